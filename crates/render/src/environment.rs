//! Light from all around: direction to radiance.

use std::sync::Arc;

use iridesce_scene::EnvironmentMap;

use crate::vector::Vec3;

/// A latitude-longitude map with its rotation, looked up bilinearly between texel centres,
/// wrapped in u and clamped in v.
#[derive(Debug, Clone)]
pub struct MapLookup {
    map: Arc<EnvironmentMap>,
    /// Rotation in turns.
    turn: f64,
}

impl MapLookup {
    pub fn new(map: Arc<EnvironmentMap>, rotation_deg: f64) -> MapLookup {
        MapLookup { map, turn: (rotation_deg / 360.0).rem_euclid(1.0) }
    }

    /// Linear Rec.709 radiance from a direction (pointing away from the scene, length 1).
    #[inline(always)]
    pub fn rgb(&self, direction: Vec3) -> [f32; 3] {
        let (width, height) = (self.map.width, self.map.height);
        // Azimuth from -z (middle column) towards +x. A rotation by 90 degrees brings to +x (u = 0.75) what stood at
        // +z (u = 1), so it adds to u.
        let azimuth = direction.x.atan2(-direction.z) * std::f64::consts::FRAC_1_PI * 0.5;
        let u = azimuth + 0.5 + self.turn;
        let colatitude = direction.x.hypot(direction.z).atan2(direction.y) * std::f64::consts::FRAC_1_PI;
        let x = (u - u.floor()) * width as f64 - 0.5;
        let y = (colatitude * height as f64 - 0.5).clamp(0.0, (height - 1) as f64);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
        let column = |c: i64| {
            if c < 0 {
                width - 1
            } else if c as usize >= width {
                0
            } else {
                c as usize
            }
        };
        let (c0, c1) = (column(x0 as i64), column(x0 as i64 + 1));
        let (r0, r1) = (y0 as usize, (y0 as usize + 1).min(height - 1));
        let texel = |row: usize, column: usize| {
            let at = 3 * (row * width + column);
            [self.map.rgb[at], self.map.rgb[at + 1], self.map.rgb[at + 2]]
        };
        let (a, b, c, d) = (texel(r0, c0), texel(r0, c1), texel(r1, c0), texel(r1, c1));
        std::array::from_fn(|i| {
            let top = a[i] + (b[i] - a[i]) * fx;
            let bottom = c[i] + (d[i] - c[i]) * fx;
            top + (bottom - top) * fy
        })
    }
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
