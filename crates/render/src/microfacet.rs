//! Rough surfaces as microscopic facets: how their normals are spread (GGX), which of them are seen from where, how far
//! light gets among them, and the walk of a ray that may hit several.
//!
//! Everything is in the surface's own frame: z along the normal, x along u. Slopes are spread like an ellipsoid's with
//! half axes alpha_x, alpha_y, 1 (B. Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007):
//!
//! ```text
//! D(h)     = 1 / (pi alpha_x alpha_y (h_x^2 / alpha_x^2 + h_y^2 / alpha_y^2 + h_z^2)^2)      per solid angle of normals
//! sigma(w) = (w_z + sqrt(alpha_x^2 w_x^2 + alpha_y^2 w_y^2 + w_z^2)) / 2                      projected area seen from w
//! D_w(h)   = max(w . h, 0) D(h) / sigma(w)                                                   normals seen from w
//! ```
//!
//! Heights and slopes are independent (Smith). A height is told by the share C of the surface that lies below it, which
//! makes it uniform; a ray that climbs from C gets through with probability C^Lambda, Lambda = sigma(-direction) / |z|.
//! Averaged over the heights of first hits that is the height-correlated G_2 / G_1 = (1 + Lambda_i) / (1 + Lambda_i +
//! Lambda_o). A ray that does not get through hits another facet, and so on (E. Heitz, J. Hanika, E. d'Eon, C.
//! Dachsbacher, "Multiple-scattering microfacet BSDFs with the Smith model", ACM TOG 35(4), 2016), so no energy is lost.
//! Facets that are seen are drawn as spherical caps (J. Dupuy, A. Benyoub, "Sampling visible GGX normals with spherical
//! caps", CGF 42(8), 2023), which holds for rays that come from below the horizon, too.

use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;

/// Least alpha: beneath it a lobe is narrower than 0.01 degrees, and no picture tells it from a mirror.
pub const LEAST_ALPHA: f64 = 1e-4;

/// How facets are spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microfacets {
    alpha: [f64; 2],
}

impl Microfacets {
    /// From roughness along u and v, 0 to 1: alpha is its square.
    pub fn new(roughness: [f64; 2]) -> Microfacets {
        Microfacets { alpha: roughness.map(|r| (r * r).clamp(LEAST_ALPHA, 1.0)) }
    }

    /// Half axes along x and y.
    #[inline(always)]
    pub fn alpha(&self) -> [f64; 2] {
        self.alpha
    }

    /// D of a normal, per solid angle; zero for those that face down.
    #[inline(always)]
    pub fn normal_density(&self, h: Vec3) -> f64 {
        let [x, y] = self.alpha;
        if h.z <= 0.0 {
            return 0.0;
        }
        let stretched = (h.x / x).powi(2) + (h.y / y).powi(2) + h.z * h.z;
        std::f64::consts::FRAC_1_PI / (x * y * stretched * stretched)
    }

    /// sigma: the area of the facets that are seen from a direction, per area of the surface.
    #[inline(always)]
    pub fn projected_area(&self, towards: Vec3) -> f64 {
        let [x, y] = self.alpha;
        let across = (x * towards.x).powi(2) + (y * towards.y).powi(2);
        let slant = across.mul_add(1.0, towards.z * towards.z).sqrt();
        if towards.z >= 0.0 {
            0.5 * (slant + towards.z)
        } else {
            // The difference, without cancellation.
            0.5 * across / (slant - towards.z)
        }
    }

    /// D_w: probability density of the normals that are seen from a direction, per solid angle.
    #[inline(always)]
    pub fn visible_density(&self, towards: Vec3, h: Vec3) -> f64 {
        towards.dot(h).max(0.0) * self.normal_density(h) / self.projected_area(towards).max(f64::MIN_POSITIVE)
    }

    /// A normal among those that are seen from a direction, from a point of the unit square.
    #[inline(always)]
    pub fn sample_visible(&self, towards: Vec3, (a, b): (f64, f64)) -> Vec3 {
        let [x, y] = self.alpha;
        let round = Vec3::new(x * towards.x, y * towards.y, towards.z).normalized();
        // A sphere's mirrored rays fill the cap that ends opposite to where they come from.
        let z = (1.0 - a).mul_add(1.0 + round.z, -round.z);
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
        let half = Vec3::new(radius.mul_add(cos, round.x), radius.mul_add(sin, round.y), z + round.z);
        let h = Vec3::new(x * half.x, y * half.y, half.z.max(0.0));
        if h.length_squared() > 0.0 { h.normalized() } else { Vec3::new(0.0, 0.0, 1.0) }
    }

    /// Lambda of a ray: mean number of surfaces in the way per unit of -ln C.
    #[inline(always)]
    fn rate(&self, direction: Vec3) -> f64 {
        self.projected_area(-direction) / direction.z.abs().max(f64::MIN_POSITIVE)
    }

    /// Probability that a ray gets out from where it starts.
    #[inline(always)]
    pub fn escape(&self, direction: Vec3, height: f64) -> f64 {
        if direction.z > 0.0 { height.powf(self.rate(direction)) } else { 0.0 }
    }

    /// G_2 / G_1: the probability that what was mirrored at the first facet gets out, over all heights of that facet.
    #[cfg(test)]
    fn mean_escape(&self, towards: Vec3, direction: Vec3) -> f64 {
        let (arrives, leaves) = (self.rate(-towards), self.rate(direction));
        arrives / (arrives + leaves)
    }
}

/// A ray among facets, in the frame of the surface.
#[derive(Debug, Clone, Copy)]
pub struct Wanderer {
    /// Where it goes.
    pub direction: Vec3,
    /// It is beneath the surface.
    pub is_below: bool,
    /// The share of the surface that is further from its side than it.
    height: f64,
}

impl Wanderer {
    /// A ray that comes from far above.
    #[inline(always)]
    pub fn new(direction: Vec3) -> Wanderer {
        Wanderer { direction, is_below: false, height: 1.0 }
    }

    /// The share of the surface that is further from its side than it.
    #[inline(always)]
    pub fn height(&self) -> f64 {
        self.height
    }

    /// A vector as the side that the ray is on sees it, and back.
    #[inline(always)]
    fn own(&self, v: Vec3) -> Vec3 {
        if self.is_below { Vec3::new(v.x, v.y, -v.z) } else { v }
    }

    /// Goes on to the next facet; false where it gets out instead. `random` is uniform in [0, 1).
    #[inline(always)]
    pub fn meets_facet(&mut self, facets: &Microfacets, random: f64) -> bool {
        let own = self.own(self.direction);
        let rate = facets.rate(own);
        if own.z > 0.0 {
            if random < self.height.powf(rate) {
                return false;
            }
            self.height = (self.height / random.powf(1.0 / rate)).min(1.0);
        } else {
            // 1 - random is never zero.
            self.height *= (1.0 - random).powf(1.0 / rate);
        }
        true
    }

    /// A random number for [`Wanderer::meets_facet`] by which it does meet one, from a random number in [0, 1).
    #[inline(always)]
    pub fn blocking(&self, facets: &Microfacets, random: f64) -> f64 {
        let escape = facets.escape(self.own(self.direction), self.height);
        escape + (1.0 - escape) * random
    }

    /// The normal of the facet it meets, on its own side.
    #[inline(always)]
    pub fn facet(&self, facets: &Microfacets, random: (f64, f64)) -> Vec3 {
        self.own(facets.sample_visible(self.own(-self.direction), random))
    }

    /// Mirrored at a facet.
    #[inline(always)]
    pub fn mirrored(&self, facet: Vec3) -> Wanderer {
        let along = self.direction.dot(facet);
        Wanderer { direction: self.direction - facet * (2.0 * along), ..*self }
    }

    /// Probability that it gets out in another direction from the facet it is at, mirrored or refracted.
    #[inline(always)]
    pub fn escape(&self, facets: &Microfacets, direction: Vec3, is_mirrored: bool) -> f64 {
        if is_mirrored {
            facets.escape(self.own(direction), self.height)
        } else {
            self.escape_beyond(facets, direction)
        }
    }

    /// Through a facet, on in another direction.
    #[inline(always)]
    pub fn passed(&self, direction: Vec3) -> Wanderer {
        Wanderer { direction, is_below: !self.is_below, height: 1.0 - self.height }
    }

    /// The facet that mirrors it into a direction, and how likely that direction is where the facet mirrors: probability
    /// per solid angle, getting out included. `None` where no facet does.
    #[inline(always)]
    pub fn mirror_density(&self, facets: &Microfacets, direction: Vec3) -> Option<(Vec3, f64)> {
        let (towards, own) = (self.own(-self.direction), self.own(direction));
        let sum = towards + own;
        if own.z <= 0.0 || sum.z <= 0.0 {
            return None;
        }
        let h = sum.normalized();
        let density = 0.25 * facets.normal_density(h) / facets.projected_area(towards).max(f64::MIN_POSITIVE);
        let density = density * facets.escape(own, self.height);
        (density > 0.0 && density.is_finite()).then(|| (self.own(h), density))
    }

    /// How densely it is refracted into a direction at sixteen ratios of the indices at once, whether it then gets out or not, and the
    /// cosines of the facets that do it; in single precision, 0 and 1 where no facet does.
    #[inline(always)]
    pub fn refract_densities(&self, facets: &Microfacets, direction: Vec3, ratios: &[f32; LANES]) -> [[f32; LANES]; 2] {
        let (towards, own) = (self.own(-self.direction), self.own(direction));
        let [x, y] = facets.alpha;
        let area = std::f64::consts::PI * x * y * facets.projected_area(towards);
        let all = 1.0 / area.max(f64::from(f32::MIN_POSITIVE)) as f32;
        let single = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
        let ([t_x, t_y, t_z], [o_x, o_y, o_z]) = (single(towards), single(own));
        let per_alpha = [1.0 / x as f32, 1.0 / y as f32];
        let (mut densities, mut cosines) = ([0.0; LANES], [1.0; LANES]);
        for lane in 0..LANES {
            let ratio = ratios[lane];
            let (s_x, s_y, s_z) = (t_x * ratio + o_x, t_y * ratio + o_y, t_z * ratio + o_z);
            let length2 = s_x * s_x + s_y * s_y + s_z * s_z;
            let scale = 1.0_f32.copysign(s_z) / length2.sqrt();
            let (h_x, h_y, h_z) = (s_x * scale, s_y * scale, s_z * scale);
            let cos_in = t_x * h_x + t_y * h_y + t_z * h_z;
            let cos_out = -(o_x * h_x + o_y * h_y + o_z * h_z);
            let (slope_x, slope_y) = (h_x * per_alpha[0], h_y * per_alpha[1]);
            let stretched = slope_x * slope_x + slope_y * slope_y + h_z * h_z;
            let density = all * cos_in * cos_out / (length2 * stretched * stretched);
            let is_there = cos_in > 0.0 && cos_out > 0.0 && length2 > 1e-10 && density < f32::INFINITY;
            densities[lane] = if is_there { density } else { 0.0 };
            cosines[lane] = if is_there { cos_in } else { 1.0 };
        }
        [densities, cosines]
    }

    /// Probability that it gets out on the other side of the facet it is at.
    #[inline(always)]
    pub fn escape_beyond(&self, facets: &Microfacets, direction: Vec3) -> f64 {
        let own = self.own(direction);
        facets.escape(Vec3::new(own.x, own.y, -own.z), 1.0 - self.height)
    }

    /// The same for refraction; `ratio` is the index on its own side over that beyond.
    #[inline(always)]
    pub fn refract_density(&self, facets: &Microfacets, direction: Vec3, ratio: f64) -> Option<(Vec3, f64)> {
        let (towards, own) = (self.own(-self.direction), self.own(direction));
        // Along the normal, either way.
        let sum = towards * ratio + own;
        let length2 = sum.length_squared();
        if own.z >= 0.0 || length2 < 1e-16 {
            return None;
        }
        let h = sum * (1.0_f64.copysign(sum.z) / length2.sqrt());
        let (cos_in, cos_out) = (towards.dot(h), -own.dot(h));
        if cos_in <= 0.0 || cos_out <= 0.0 {
            return None;
        }
        let jacobian = cos_out / length2;
        let density = facets.visible_density(towards, h) * jacobian * self.escape_beyond(facets, direction);
        (density > 0.0 && density.is_finite()).then(|| (self.own(h), density))
    }
}

#[cfg(test)]
mod tests {
    use iridesce_numerics::noise::SplitMix64;

    use super::*;

    const ROUGHNESSES: [[f64; 2]; 5] = [[0.1, 0.1], [0.3, 0.3], [0.55, 0.55], [1.0, 1.0], [0.2, 0.8]];

    struct Random(SplitMix64);

    impl Random {
        fn new(seed: u64) -> Random {
            Random(SplitMix64::new(seed))
        }
        fn next(&mut self) -> f64 {
            self.0.unit()
        }
        fn pair(&mut self) -> (f64, f64) {
            (self.next(), self.next())
        }
    }

    fn direction(angle_deg: f64, azimuth_deg: f64) -> Vec3 {
        let ((sin, cos), (s, c)) = (angle_deg.to_radians().sin_cos(), azimuth_deg.to_radians().sin_cos());
        Vec3::new(sin * c, sin * s, cos)
    }

    /// Normals of the upper half space with their weights in an integral over solid angle. In slopes stretched by alpha GGX
    /// is 1 / (pi (1 + r^2)^2); r^2 = 1 / t^2 - 1 makes 2 t dt of it, which holds the steep ones together.
    fn normals(facets: &Microfacets) -> impl Iterator<Item = (Vec3, f64)> {
        let (n, m) = (800, 320);
        let facets = *facets;
        (0..n * m).map(move |at| {
            let t = (f64::from(at / m) + 0.5) / f64::from(n);
            let r = (1.0 / (t * t) - 1.0).sqrt();
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(at % m) + 0.5) / f64::from(m)).sin_cos();
            let h = Vec3::new(facets.alpha[0] * r * cos, facets.alpha[1] * r * sin, 1.0).normalized();
            (h, 2.0 * t / (facets.normal_density(h) * h.z) / f64::from(n * m))
        })
    }

    /// The integral over normals of the upper half space.
    fn over_normals(facets: &Microfacets, f: impl Fn(Vec3) -> f64) -> f64 {
        normals(facets).map(|(h, weight)| f(h) * weight).sum()
    }

    /// Midpoints over 800 x 320 cells of bounded integrands, whose only kinks lie where facets are seen from the side: h^2.
    #[test]
    fn densities_are_normalised() {
        for roughness in ROUGHNESSES {
            let facets = Microfacets::new(roughness);
            let cosines = over_normals(&facets, |h| facets.normal_density(h) * h.z);
            assert!((cosines - 1.0).abs() < 1e-6, "{roughness:?}: {cosines}");
            for (angle, azimuth) in [(0.0, 0.0), (40.0, 20.0), (75.0, 100.0), (89.0, 10.0), (95.0, 45.0)] {
                let w = direction(angle, azimuth);
                let area = over_normals(&facets, |h| w.dot(h).max(0.0) * facets.normal_density(h));
                let told = facets.projected_area(w);
                assert!((area - told).abs() < 1e-4 * told, "{roughness:?} at {angle}: {area}, told {told}");
                let all = over_normals(&facets, |h| facets.visible_density(w, h));
                assert!((all - area / told).abs() < 1e-9, "{roughness:?} at {angle}: {all}");
            }
        }
    }

    /// Chi-square of drawn normals against their density, in 16 x 8 cells; those that expect fewer than 10 are joined. 99.99 %
    /// of right samplers stay below the limit.
    #[test]
    fn seen_normals_are_drawn_by_their_density() {
        let draws = 200_000;
        for (which, roughness) in ROUGHNESSES.into_iter().enumerate() {
            let facets = Microfacets::new(roughness);
            for (angle, azimuth) in [(0.0, 0.0), (35.0, 70.0), (80.0, 20.0), (105.0, 30.0)] {
                let w = direction(angle, azimuth);
                let cell = |h: Vec3| {
                    let (x, y) = (h.x / h.z / facets.alpha[0], h.y / h.z / facets.alpha[1]);
                    let (t, turn) = (1.0 / (1.0 + x * x + y * y).sqrt(), y.atan2(x) / std::f64::consts::TAU + 0.5);
                    ((t * 16.0) as usize).min(15) * 8 + ((turn * 8.0) as usize).min(7)
                };
                let mut expected = [0.0; 128];
                for (h, weight) in normals(&facets) {
                    expected[cell(h)] += facets.visible_density(w, h) * weight;
                }
                let total: f64 = expected.iter().sum();
                let mut found = [0.0; 128];
                let mut random = Random::new(which as u64 * 10 + angle as u64);
                for _ in 0..draws {
                    found[cell(facets.sample_visible(w, random.pair()))] += 1.0;
                }
                let (mut chi, mut cells, mut few) = (0.0, 0, [0.0; 2]);
                for (expected, found) in expected.iter().zip(&found) {
                    let expected = expected / total * f64::from(draws);
                    if expected < 10.0 {
                        few = [few[0] + expected, few[1] + found];
                    } else {
                        chi += (found - expected).powi(2) / expected;
                        cells += 1;
                    }
                }
                if few[0] > 5.0 {
                    chi += (few[1] - few[0]).powi(2) / few[0];
                    cells += 1;
                }
                // Wilson and Hilferty; 3.72 deviations.
                let k = f64::from(cells - 1).max(1.0);
                let limit = k * (1.0 - 2.0 / (9.0 * k) + 3.72 * (2.0 / (9.0 * k)).sqrt()).powi(3);
                assert!(chi < limit, "{roughness:?} at {angle}: chi-square {chi}, limit {limit} ({k})");
            }
        }
    }

    /// The walk's first hits lie at heights over which the chance to get out is the height-correlated G_2 / G_1.
    #[test]
    fn shadowing_is_height_correlated() {
        let mut random = Random::new(5);
        for roughness in ROUGHNESSES {
            let facets = Microfacets::new(roughness);
            for (arrives, leaves) in [(10.0, 50.0), (70.0, 70.0), (85.0, 40.0)] {
                let (towards, out) = (direction(arrives, 15.0), direction(leaves, 130.0));
                let walks = 40_000;
                let (mut sum, mut squares) = (0.0, 0.0);
                for _ in 0..walks {
                    let mut ray = Wanderer::new(-towards);
                    assert!(ray.meets_facet(&facets, random.next()));
                    let chance = facets.escape(out, ray.height);
                    sum += chance;
                    squares += chance * chance;
                }
                let mean = sum / f64::from(walks);
                let error = ((squares / f64::from(walks) - mean * mean) / f64::from(walks)).sqrt();
                let exact = facets.mean_escape(towards, out);
                assert!((mean - exact).abs() < 4.5 * error + 1e-9, "{roughness:?}: {mean} +- {error}, exactly {exact}");
            }
        }
    }

    /// Mirrored once, light goes as much from a to b as from b to a: f cos = D G_2 / (4 cos cos) cos.
    #[test]
    fn one_bounce_is_reciprocal() {
        for roughness in ROUGHNESSES {
            let facets = Microfacets::new(roughness);
            for (a, b) in [((20.0, 0.0), (60.0, 150.0)), ((5.0, 30.0), (80.0, 200.0)), ((45.0, 10.0), (45.0, 100.0))] {
                let (a, b) = (direction(a.0, a.1), direction(b.0, b.1));
                let way = |from: Vec3, to: Vec3| {
                    // At height 1 nothing is in the way: the shadowing comes by the mean over heights.
                    let (_, density) = Wanderer::new(-from).mirror_density(&facets, to).unwrap();
                    density * facets.mean_escape(from, to) * from.z
                };
                let (there, back) = (way(a, b), way(b, a));
                assert!((there / back - 1.0).abs() < 1e-12, "{roughness:?}: {there} {back}");
            }
        }
    }

    /// Where a mirrored or refracted ray goes, drawn and by density: the probability of a cap of directions either way.
    #[test]
    fn scattered_directions_have_their_density() {
        let walks = 60_000;
        for (which, roughness) in [[0.3, 0.3], [0.55, 0.55], [1.0, 1.0], [0.2, 0.8]].into_iter().enumerate() {
            let facets = Microfacets::new(roughness);
            for ratio in [1.0 / 1.5, 1.5] {
                let mut random = Random::new(17 + which as u64);
                let towards = direction(40.0, 30.0);
                // Around the directions of the mean facet.
                let mirror = direction(40.0, 210.0);
                let sine = ratio * 40.0_f64.to_radians().sin();
                let refracted = -direction(sine.min(0.9).asin().to_degrees(), 30.0);
                let cos_rim = 0.95;
                let mut drawn = [0.0; 2];
                let mut told = [0.0; 2];
                let cap = std::f64::consts::TAU * (1.0 - cos_rim);
                for _ in 0..walks {
                    let mut ray = Wanderer::new(-towards);
                    assert!(ray.meets_facet(&facets, random.next()));
                    let h = ray.facet(&facets, random.pair());
                    let mut up = ray.mirrored(h);
                    if up.direction.dot(mirror) > cos_rim && !up.meets_facet(&facets, random.next()) {
                        drawn[0] += 1.0;
                    }
                    let cos = towards.dot(h);
                    let cosine2 = 1.0 - ratio * ratio * (1.0 - cos * cos);
                    if cosine2 > 0.0 {
                        let mut down = ray.passed((-towards * ratio + h * (ratio * cos - cosine2.sqrt())).normalized());
                        if down.direction.dot(refracted) > cos_rim && !down.meets_facet(&facets, random.next()) {
                            drawn[1] += 1.0;
                        }
                    }
                    // One direction in each cap, uniformly.
                    for (axis, told) in [mirror, refracted].into_iter().zip(&mut told) {
                        let (a, b) = random.pair();
                        let z = 1.0 - a * (1.0 - cos_rim);
                        let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
                        let side = axis.cross(Vec3::new(0.3, -0.9, 0.1)).normalized();
                        let up = axis.cross(side);
                        let radius = (1.0 - z * z).sqrt();
                        let out = axis * z + side * (radius * cos) + up * (radius * sin);
                        let found = if axis.z > 0.0 {
                            ray.mirror_density(&facets, out)
                        } else {
                            ray.refract_density(&facets, out, ratio)
                        };
                        *told += cap * found.map_or(0.0, |(_, density)| density);
                    }
                }
                for (drawn, told) in drawn.into_iter().zip(told) {
                    // Both are noisy; the counted one is binomial, the other's weights are at most as wide here.
                    let error = 4.5 * (2.0 * drawn + 25.0_f64).sqrt();
                    assert!((drawn - told).abs() < error, "{roughness:?}, {ratio}: {drawn} drawn, {told} by density");
                }
            }
        }
    }

    /// White facets, mirrors or clear glass: the whole walk is reciprocal. Rays that arrive evenly over a cap (by cosine)
    /// and leave within another are as many as the other way round.
    #[test]
    fn walks_are_reciprocal() {
        let facets = Microfacets::new([1.0, 0.7]);
        let caps = [direction(75.0, 10.0), direction(35.0, 160.0)];
        let cos_rim = 0.94;
        let mut random = Random::new(23);
        let mut counts = [0.0_f64; 2];
        let mut bounces = [0_u32; 2];
        for way in 0..2 {
            let (from, to) = (caps[way], caps[1 - way]);
            let side = from.cross(Vec3::new(0.3, -0.9, 0.1)).normalized();
            let up = from.cross(side);
            for _ in 0..400_000 {
                let (a, b) = random.pair();
                let z = 1.0 - a * (1.0 - cos_rim);
                let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
                let radius = (1.0 - z * z).sqrt();
                let towards = from * z + side * (radius * cos) + up * (radius * sin);
                if towards.z <= 0.0 || random.next() > towards.z {
                    continue;
                }
                let mut ray = Wanderer::new(-towards);
                let mut hits = 0;
                while ray.meets_facet(&facets, random.next()) {
                    ray = ray.mirrored(ray.facet(&facets, random.pair()));
                    hits += 1;
                    assert!(hits < 200, "a walk that does not end");
                }
                if ray.direction.dot(to) > cos_rim {
                    counts[way] += 1.0;
                    bounces[usize::from(hits > 1)] += 1;
                }
            }
        }
        let error = (counts[0] + counts[1]).sqrt();
        assert!((counts[0] - counts[1]).abs() < 4.0 * error, "{counts:?}");
        assert!(counts[0] > 5000.0 && bounces[1] > 1000, "{counts:?} {bounces:?}: enough of both kinds");
    }
}
