//! What [`crate::microfacet`] tells of one direction of a ray that facets mirror, of many at once, in single precision: by these, light
//! is looked for.

use fearless_simd::{Simd, SimdBase, f32x16};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::number::Number;
use iridesce_numerics::turns::{exp2, sin_cos_turns};

use crate::microfacet::{Microfacets, Wanderer};
use crate::rough::Frame;

/// a . b
#[inline(always)]
pub fn dot<V: Number<Precision = f32>>(a: &[V; 3], b: Vec3) -> V {
    a[2].mul_add(a[2].like(b.z), a[1].mul_add(a[1].like(b.y), a[0].times(b.x)))
}

/// Points in single precision.
#[inline(always)]
pub fn single_points<S: Simd>(simd: S, points: &[(f64, f64); LANES]) -> [f32x16<S>; 2] {
    let [mut a, mut b] = [[0.0; LANES]; 2];
    for (lane, point) in points.iter().enumerate() {
        (a[lane], b[lane]) = (point.0 as f32, point.1 as f32);
    }
    [f32x16::from_slice(simd, &a), f32x16::from_slice(simd, &b)]
}

/// Vectors of a frame of three axes in the world.
#[inline(always)]
pub fn world_lanes<V: Number<Precision = f32>>(v: &[V; 3], axes: [Vec3; 3]) -> [V; 3] {
    let [x, y, z] = axes.map(|axis| axis.to_array());
    std::array::from_fn(|k| sum(v, [x[k], y[k], z[k]]))
}

/// a x + b y + c z
#[inline(always)]
fn sum<V: Number<Precision = f32>>([a, b, c]: &[V; 3], [x, y, z]: [f64; 3]) -> V {
    c.mul_add(c.like(z), b.mul_add(b.like(y), a.times(x)))
}

impl Frame {
    /// Vectors of the world in it.
    #[inline(always)]
    pub fn local_lanes<V: Number<Precision = f32>>(&self, v: &[V; 3]) -> [V; 3] {
        self.axes().map(|axis| dot(v, axis))
    }
}

/// Directions about a normal in proportion to their cosine, from points of the unit square, in a frame of which that is the third axis.
#[inline(always)]
pub fn cosine_lanes<V: Number<Precision = f32>>([a, b]: [V; 2]) -> [V; 3] {
    let (sin, cos) = sin_cos_turns(b);
    let radius = a.sqrt();
    [radius * cos, radius * sin, (a.like(1.0) - a).sqrt()]
}

/// Rays among facets, seen from where they come from, in the frame of the surface; or one, in every lane.
pub struct RayLanes<V> {
    towards: [V; 3],
    /// Where they come from if facets were stretched until they are round, less its third number.
    round: [V; 2],
    /// That, added to one and taken from it, without cancellation.
    one_and_less: [V; 2],
    /// The projected area of the facets that they see.
    area: V,
}

/// alpha_x^2 x^2 + alpha_y^2 y^2
#[inline(always)]
fn wide2<V: Number<Precision = f32>>([alpha_x, alpha_y]: [f64; 2], [x, y, _]: &[V; 3]) -> V {
    let (x, y) = (x.times(alpha_x), y.times(alpha_y));
    x.mul_add(x, y * y)
}

impl<V: Number<Precision = f32>> RayLanes<V> {
    /// Rays that come from there; directions of length 1.
    #[inline(always)]
    pub fn new(facets: &Microfacets, towards: [V; 3]) -> RayLanes<V> {
        let (across, z) = (wide2(facets.alpha(), &towards), towards[2]);
        let slant = z.mul_add(z, across).sqrt().max(z.like(f64::from(f32::MIN_POSITIVE)));
        let sum = slant + z.abs();
        let (more, less) = (sum / slant, across / (slant * sum));
        let is_above = z.gt(z.like(0.0));
        let one_and_less = [V::select(is_above, more, less), V::select(is_above, less, more)];
        let [x, y] = facets.alpha();
        RayLanes {
            towards,
            round: [towards[0].times(x) / slant, towards[1].times(y) / slant],
            one_and_less,
            area: (slant * one_and_less[0]).times(0.5),
        }
    }

    /// Facets that are met from above, from points of the unit square; in the frame of the surface, of any length.
    #[inline(always)]
    pub fn facets(&self, facets: &Microfacets, [a, b]: [V; 2]) -> [V; 3] {
        let [x, y] = facets.alpha();
        let (sin, cos) = sin_cos_turns(b);
        // As `Microfacets::sample_visible`; 1 - z^2 without cancellation.
        let [one, less] = self.one_and_less;
        let up = (a.like(1.0) - a) * one;
        let radius = (a * one * (up + less)).max(a.like(0.0)).sqrt();
        [radius.mul_add(cos, self.round[0]).times(x), radius.mul_add(sin, self.round[1]).times(y), up.max(a.like(0.0))]
    }

    /// The cosines at which they meet facets of any length.
    #[inline(always)]
    pub fn cosines(&self, h: &[V; 3]) -> V {
        let [t_x, t_y, t_z] = self.towards;
        let length2 = h[0].mul_add(h[0], h[1].mul_add(h[1], h[2] * h[2]));
        let along = h[2].mul_add(t_z, h[1].mul_add(t_y, h[0] * t_x));
        (along / length2.max(along.like(f64::from(f32::MIN_POSITIVE))).sqrt()).max(along.like(0.0)).min(along.like(1.0))
    }

    /// Directions into which facets of any length mirror them.
    #[inline(always)]
    pub fn mirrored(&self, h: &[V; 3]) -> [V; 3] {
        let length2 = h[0].mul_add(h[0], h[1].mul_add(h[1], h[2] * h[2]));
        let [t_x, t_y, t_z] = self.towards;
        let along = h[2].mul_add(t_z, h[1].mul_add(t_y, h[0] * t_x)).times(2.0);
        let along = along / length2.max(h[0].like(f64::from(f32::MIN_POSITIVE)));
        [along.mul_sub(h[0], t_x), along.mul_sub(h[1], t_y), along.mul_sub(h[2], t_z)]
    }

    /// How densely facets that are met from above mirror them into directions of length 1; 0 where none does.
    #[inline(always)]
    pub fn densities(&self, facets: &Microfacets, [d_x, d_y, d_z]: &[V; 3]) -> V {
        let [t_x, t_y, t_z] = self.towards;
        let (s_x, s_y, s_z) = (*d_x + t_x, *d_y + t_y, *d_z + t_z);
        let zero = s_z.like(0.0);
        let [x, y] = facets.alpha();
        let area = self.area.max(zero.like(f64::from(f32::MIN_POSITIVE)));
        let length2 = s_x.mul_add(s_x, s_y.mul_add(s_y, s_z * s_z));
        let (slope_x, slope_y) = (s_x.times(1.0 / x), s_y.times(1.0 / y));
        // D of the half vector, whose length goes out of it to the fourth power.
        let stretched = slope_x.mul_add(slope_x, slope_y.mul_add(slope_y, s_z * s_z));
        let share = length2 / stretched;
        let density = (share * share).times(0.25 / (std::f64::consts::PI * x * y)) / area;
        let is_there = d_z.gt(zero) & s_z.gt(zero) & density.gt(zero) & density.lt(zero.like(f64::from(f32::MAX)));
        V::select(is_there, density, zero)
    }
}

/// Lambda of directions of length 1 that climb or sink: how fast rays meet facets, by the logarithm of their height.
#[inline(always)]
fn rates<V: Number<Precision = f32>>(facets: &Microfacets, ways: &[V; 3]) -> V {
    let (across, up) = (wide2(facets.alpha(), ways), ways[2].abs());
    let slant = up.mul_add(up, across).sqrt();
    let climbing = across.times(0.5) / ((slant + up) * up);
    V::select(ways[2].gt(up.like(0.0)), climbing, (slant + up).times(0.5) / up)
}

impl Wanderer {
    /// Seen from where it comes from, in as many lanes as a number has.
    #[inline(always)]
    pub fn lanes<V: Number<Precision = f32>>(&self, like: V, facets: &Microfacets) -> RayLanes<V> {
        RayLanes::new(facets, (-self.direction).to_array().map(|along| like.like(along)))
    }

    /// The logarithm of its height to base 2.
    #[inline(always)]
    pub fn log2_height(&self) -> f64 {
        self.height().max(f64::MIN_POSITIVE).log2()
    }
}

/// The probability that rays get out from a height, told by its logarithm, into directions of length 1; 0 where they do not climb.
#[inline(always)]
pub fn escapes<V: Number<Precision = f32>>(facets: &Microfacets, log2_height: f64, ways: &[V; 3]) -> V {
    let zero = ways[2].like(0.0);
    V::select(ways[2].gt(zero), exp2(rates(facets, ways).times(log2_height)), zero)
}

/// The probability that rays of these directions meet a facet from a height C, told by its logarithm, and from there get out into those others.
///
/// With rates a of the first direction and b of the second, C^a is the probability that a climbing ray meets none, and over all heights it
/// may meet one at `(C^b - C^a) / (1 - b / a)`; a sinking one always does, `C^b / (1 + b / a)`.
#[inline(always)]
pub fn escapes_after<V: Number<Precision = f32>>(
    facets: &Microfacets,
    log2_height: f64,
    first: &[V; 3],
    second: &[V; 3],
) -> V {
    let (a, b) = (rates(facets, first), rates(facets, second));
    let zero = a.like(0.0);
    let less = (a - b).times(log2_height).abs();
    // (1 - 2^-x) / x, by its series where x is small.
    let small = less.times(-0.5 * std::f64::consts::LN_2 * std::f64::consts::LN_2).plus(std::f64::consts::LN_2);
    let share = V::select(less.lt(zero.like(1e-2)), small, (zero.like(1.0) - exp2(-less)) / less);
    let larger = exp2(a.min(b).times(log2_height));
    let climbing = larger * share * a.times(-log2_height);
    let sinking = exp2(b.times(log2_height)) * a / (a + b);
    let met = V::select(first[2].gt(zero), climbing, sinking);
    V::select(second[2].gt(zero), met, zero)
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use iridesce_numerics::noise::SplitMix64;

    use super::*;

    /// Directions of facets and their densities against those of one direction at a time, from above and from below the horizon, at
    /// several heights. In single precision the half vector is good to 1e-7 of a unit vector, which narrow facets see 1 / alpha times as
    /// large; grazing directions more so.
    #[test]
    fn many_directions_are_as_one() {
        #[inline(always)]
        fn run<S: Simd>(simd: S, ray: &Wanderer, facets: &Microfacets, a: &[f32; 16], b: &[f32; 16]) -> [[f32; 16]; 5] {
            let (a, b) = (f32x16::from_slice(simd, a), f32x16::from_slice(simd, b));
            let lanes = ray.lanes(a, facets);
            let ways = lanes.mirrored(&lanes.facets(facets, [a, b]));
            let (density, escape) = (lanes.densities(facets, &ways), escapes(facets, ray.log2_height(), &ways));
            [ways[0], ways[1], ways[2], density, escape].map(|lanes| lanes.into())
        }
        let mut noise = SplitMix64::new(5);
        let mut compared = 0;
        for roughness in [[0.1, 0.1], [0.3, 0.3], [1.0, 1.0], [0.2, 0.8]] {
            let facets = Microfacets::new(roughness);
            let tolerance = 2e-5 / facets.alpha()[0].min(facets.alpha()[1]);
            for _ in 0..200 {
                let mut draw = || noise.unit();
                let way = Vec3::new(draw() - 0.5, draw() - 0.5, -draw()).normalized();
                let mut ray = Wanderer::new(way);
                ray.meets_facet(&facets, draw());
                if draw() < 0.5 {
                    ray = ray.mirrored(ray.facet(&facets, (draw(), draw())));
                    if !ray.meets_facet(&facets, draw()) {
                        continue;
                    }
                }
                let (a, b) = (std::array::from_fn(|_| draw() as f32), std::array::from_fn(|_| draw() as f32));
                let [x, y, z, density, escape] = dispatch!(Level::new(), simd => run(simd, &ray, &facets, &a, &b));
                for lane in 0..16 {
                    let found = Vec3::new(x[lane].into(), y[lane].into(), z[lane].into());
                    let h = ray.facet(&facets, (a[lane].into(), b[lane].into()));
                    let exact = ray.mirrored(h).direction;
                    assert!((found - exact).length_squared().sqrt() < 1e-5, "{roughness:?}: {found:?}, {exact:?}");
                    let [density, escape] = [density[lane], escape[lane]].map(f64::from);
                    let wanted = ray.mirror_density(&facets, found.normalized()).map_or(0.0, |(_, density)| density);
                    // At the horizon either may take it for the other side.
                    if found.z.abs() > 1e-3 {
                        let error = (density * escape - wanted).abs();
                        assert!(
                            error <= tolerance * wanted + 1e-12,
                            "{roughness:?} {ray:?}: {density} x {escape}, {wanted}"
                        );
                        compared += usize::from(wanted > 0.0);
                    }
                }
            }
        }
        assert!(compared > 5000, "{compared}");
    }

    /// What is told of two facets one after the other against walks from random heights, evenly drawn, and against walks that are made to meet
    /// a second facet.
    #[test]
    fn second_facets_are_met_as_by_walks() {
        #[inline(always)]
        fn run<S: Simd>(simd: S, ray: &Wanderer, facets: &Microfacets, ways: [Vec3; 2]) -> f32 {
            let [first, second] = ways.map(|way| way.to_array().map(|along| f32x16::splat(simd, along as f32)));
            escapes_after(facets, ray.log2_height(), &first, &second).to_array()[3]
        }
        let mut noise = SplitMix64::new(7);
        let mut draw = || noise.unit();
        for roughness in [[0.1, 0.1], [0.3, 0.3], [1.0, 1.0], [0.2, 0.8]] {
            let facets = Microfacets::new(roughness);
            for case in 0..60 {
                let mut start = Wanderer::new(Vec3::new(draw() - 0.5, draw() - 0.5, -draw()).normalized());
                start.meets_facet(&facets, draw());
                let climbs = if case % 3 == 0 { -1.0 } else { 1.0 };
                let first = Vec3::new(draw() - 0.5, draw() - 0.5, climbs * (0.02 + 0.3 * draw())).normalized();
                // The same rate for both directions is a limit of the formula.
                let second =
                    if case % 5 == 1 { first } else { Vec3::new(draw() - 0.5, draw() - 0.5, draw()).normalized() };
                let mut ray = start;
                ray.direction = first;
                let (mut walked, mut made, count) = (0.0, 0.0, 20_000);
                for k in 0..count {
                    let random = (f64::from(k) + 0.5) / f64::from(count);
                    let mut own = ray;
                    if own.meets_facet(&facets, random) {
                        walked += own.escape(&facets, second, true);
                    }
                    let mut own = ray;
                    assert!(own.meets_facet(&facets, ray.blocking(&facets, random)));
                    made += own.escape(&facets, second, true);
                }
                let met = 1.0 - ray.escape(&facets, first, true);
                let [walked, made] = [walked, met * made].map(|sum| sum / f64::from(count));
                let told: f64 = dispatch!(Level::new(), simd => run(simd, &ray, &facets, [first, second])).into();
                // By steps of 1 / 20 000 either sum is good to a few of them.
                for sum in [walked, made] {
                    assert!((told - sum).abs() < 3e-4, "{roughness:?} {ray:?} {second:?}: {told}, by walks {sum}");
                }
            }
        }
    }
}
