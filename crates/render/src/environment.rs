//! Light from all around: direction to radiance.

use std::sync::Arc;

use iridesce_scene::EnvironmentMap;

use crate::vector::Vec3;

/// A latitude-longitude map with its rotation, looked up bilinearly between texel centres,
/// wrapped in u and clamped in v.
#[derive(Debug, Clone)]
pub struct MapLookup {
    map: Arc<EnvironmentMap>,
    /// Half a turn (the middle column looks to -z) and the rotation.
    offset: f32,
}

impl MapLookup {
    pub fn new(map: Arc<EnvironmentMap>, rotation_deg: f64) -> MapLookup {
        MapLookup { map, offset: (0.5 + (rotation_deg / 360.0).rem_euclid(1.0)) as f32 }
    }

    /// Linear Rec.709 radiance from a direction (pointing away from the scene, length 1).
    #[inline(always)]
    pub fn rgb(&self, direction: Vec3) -> [f32; 3] {
        let (width, height) = (self.map.width, self.map.height);
        let (dx, dy, dz) = (direction.x as f32, direction.y as f32, direction.z as f32);
        // Azimuth from -z (middle column) towards +x. A rotation by 90 degrees brings to +x (u = 0.75) what stood at
        // +z (u = 1), so it adds to u.
        let u = atan2_turns(dx, -dz) + self.offset;
        let colatitude = 2.0 * atan2_turns((dx * dx + dz * dz).sqrt(), dy);
        let x = (u - u.floor()) * width as f32 - 0.5;
        let y = (colatitude * height as f32 - 0.5).clamp(0.0, (height - 1) as f32);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let column = x0 as isize;
        let left = if column < 0 { width - 1 } else { (column as usize).min(width - 1) };
        let right = if column + 1 >= width as isize { 0 } else { (column + 1) as usize };
        let (above, below) = (y0 as usize, (y0 as usize + 1).min(height - 1));
        let (a, b) = (self.texel(above, left), self.texel(above, right));
        let (c, d) = (self.texel(below, left), self.texel(below, right));
        let mix = |i: usize| {
            let top = a[i] + (b[i] - a[i]) * fx;
            let bottom = c[i] + (d[i] - c[i]) * fx;
            top + (bottom - top) * fy
        };
        [mix(0), mix(1), mix(2)]
    }

    /// Mean radiance over the sphere (texels weighted by the sine of their colatitude).
    pub fn mean_rgb(&self) -> [f32; 3] {
        let (mut sum, mut total) = ([0.0_f64; 3], 0.0);
        for (row, texels) in self.map.rgb.chunks_exact(3 * self.map.width).enumerate() {
            let sine = (std::f64::consts::PI * (row as f64 + 0.5) / self.map.height as f64).sin();
            for texel in texels.chunks_exact(3) {
                for c in 0..3 {
                    sum[c] += sine * f64::from(texel[c]);
                }
            }
            total += sine * self.map.width as f64;
        }
        sum.map(|v| (v / total) as f32)
    }

    #[inline(always)]
    fn texel(&self, row: usize, column: usize) -> [f32; 3] {
        let at = 3 * (row * self.map.width + column);
        let texel = &self.map.rgb[at..at + 3];
        [texel[0], texel[1], texel[2]]
    }
}

/// atan2(y, x) in turns, in [-1/2, 1/2]; error below 1e-8 of a turn before rounding, so that a map of 8192 columns is
/// looked up to 5e-4 of a texel in f32. The library's own takes as long as a film.
#[inline(always)]
fn atan2_turns(y: f32, x: f32) -> f32 {
    /// atan(t) / (2 pi t) as a polynomial of t^2 on [0, 1]; weighted minimax fit.
    const ATAN: [f32; 8] = [
        0.159154837,
        -0.0530461209,
        0.0317459442,
        -0.0221362663,
        0.0153460208,
        -0.00889870614,
        0.00347958631,
        -0.000645301316,
    ];
    let (ax, ay) = (x.abs(), y.abs());
    let (small, large) = (ax.min(ay), ax.max(ay));
    let t = if large > 0.0 { small / large } else { 0.0 };
    let t2 = t * t;
    // Estrin's order: the lookup waits for this chain, and Horner's is twice as long.
    let t4 = t2 * t2;
    let low = (ATAN[0] + ATAN[1] * t2) + (ATAN[2] + ATAN[3] * t2) * t4;
    let high = (ATAN[4] + ATAN[5] * t2) + (ATAN[6] + ATAN[7] * t2) * t4;
    let sum = low + high * (t4 * t4);
    let mut turns = sum * t;
    if ay > ax {
        turns = 0.25 - turns;
    }
    if x < 0.0 {
        turns = 0.5 - turns;
    }
    if y < 0.0 { -turns } else { turns }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Texel value = its own column and row, so that a lookup tells where it looked.
    fn ramp(width: usize, height: usize) -> Arc<EnvironmentMap> {
        let rgb = (0..width * height).flat_map(|i| [(i % width) as f32, (i / width) as f32, 1.0]).collect();
        Arc::new(EnvironmentMap { width, height, rgb })
    }

    #[test]
    fn fast_arc_tangent_is_the_arc_tangent() {
        for i in 0..100_000 {
            let angle = (f64::from(i) / 50_000.0 - 1.0) * std::f64::consts::PI;
            let (y, x) = (angle.sin() as f32, angle.cos() as f32);
            let exact = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
            // Half an ulp of a result up to 1/2 is 3e-8; the polynomial's own rounding adds as much.
            assert!((f64::from(atan2_turns(y, x)) - exact).abs() < 9e-8, "{angle}");
        }
        assert_eq!(atan2_turns(0.0, 0.0), 0.0);
    }

    #[test]
    fn directions_meet_their_texels() {
        let (width, height) = (64, 32);
        let look = |turn, x, y, z| MapLookup::new(ramp(width, height), turn).rgb(Vec3::new(x, y, z).normalized());
        assert!((look(0.0, 0.0, 0.0, -1.0)[0] - 31.5).abs() < 1e-4, "-z: middle column");
        assert!((look(0.0, 1.0, 0.0, 0.0)[0] - 47.5).abs() < 1e-4, "+x: three quarters");
        assert!((look(0.0, 0.0, 0.0, -1.0)[1] - 15.5).abs() < 1e-4, "the horizon: middle row");
        assert!(look(0.0, 0.0, 1.0, 0.0)[1].abs() < 1e-4, "+y: first row");
        assert!((look(0.0, 0.0, -1.0, 0.0)[1] - 31.0).abs() < 1e-4, "-y: last row");
        assert!((look(90.0, 1.0, 0.0, 1e-9)[0] - look(0.0, 1e-9, 0.0, 1.0)[0]).abs() < 1e-3, "+z turns to +x");
        assert!((look(0.0, 0.0, 0.0, 1.0)[0] - 31.5).abs() < 1e-3, "+z: half way between last and first column");
    }
}
