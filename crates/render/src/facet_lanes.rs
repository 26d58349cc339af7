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

impl Wanderer {
    /// Directions into which facets mirror it that are met from above, from points of the unit square; in the frame of the surface.
    #[inline(always)]
    pub fn mirrored_lanes<V: Number<Precision = f32>>(&self, facets: &Microfacets, [a, b]: [V; 2]) -> [V; 3] {
        let towards = -self.direction;
        let [x, y] = facets.alpha();
        let round = Vec3::new(x * towards.x, y * towards.y, towards.z).normalized();
        let (sin, cos) = sin_cos_turns(b);
        // As `Microfacets::sample_visible`; 1 - z^2 without cancellation.
        let up = (a.like(1.0) - a).times(1.0 + round.z);
        let radius = (a.times(1.0 + round.z) * up.plus(1.0 - round.z)).max(a.like(0.0)).sqrt();
        let h = [
            radius.mul_add(cos, a.like(round.x)).times(x),
            radius.mul_add(sin, a.like(round.y)).times(y),
            up.max(a.like(0.0)),
        ];
        let length2 = h[0].mul_add(h[0], h[1].mul_add(h[1], h[2] * h[2]));
        let along = dot(&h, towards).times(2.0) / length2.max(a.like(f64::from(f32::MIN_POSITIVE)));
        let [t_x, t_y, t_z] = towards.to_array();
        [along.mul_sub(h[0], a.like(t_x)), along.mul_sub(h[1], a.like(t_y)), along.mul_sub(h[2], a.like(t_z))]
    }

    /// How densely facets that are met from above mirror it into directions of length 1, and the probability that it then gets out;
    /// both 0 where no facet does.
    #[inline(always)]
    pub fn mirror_densities<V: Number<Precision = f32>>(&self, facets: &Microfacets, ways: &[V; 3]) -> [V; 2] {
        let [d_x, d_y, d_z] = *ways;
        let (zero, towards) = (d_x.like(0.0), -self.direction);
        let [x, y] = facets.alpha();
        let area = facets.projected_area(towards).max(f64::from(f32::MIN_POSITIVE));
        let all = 0.25 / (std::f64::consts::PI * x * y * area);
        let (s_x, s_y, s_z) = (d_x.plus(towards.x), d_y.plus(towards.y), d_z.plus(towards.z));
        let length2 = s_x.mul_add(s_x, s_y.mul_add(s_y, s_z * s_z));
        let (slope_x, slope_y) = (s_x.times(1.0 / x), s_y.times(1.0 / y));
        // D of the half vector, whose length goes out of it to the fourth power.
        let stretched = slope_x.mul_add(slope_x, slope_y.mul_add(slope_y, s_z * s_z));
        let share = length2 / stretched;
        let density = (share * share).times(all);
        let (wide_x, wide_y) = (d_x.times(x), d_y.times(y));
        let across = wide_x.mul_add(wide_x, wide_y * wide_y);
        let rate = across.times(0.5) / ((d_z.mul_add(d_z, across).sqrt() + d_z) * d_z);
        let escape = exp2(rate.times(self.height().max(f64::MIN_POSITIVE).log2()));
        let is_there = d_z.gt(zero) & s_z.gt(zero) & density.gt(zero) & density.lt(zero.like(f64::from(f32::MAX)));
        [V::select(is_there, density, zero), V::select(is_there, escape, zero)]
    }
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
            let ways = ray.mirrored_lanes(facets, [f32x16::from_slice(simd, a), f32x16::from_slice(simd, b)]);
            let [density, escape] = ray.mirror_densities(facets, &ways);
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
}
