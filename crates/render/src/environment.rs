//! Light from all around: direction to radiance.

use std::sync::Arc;

use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use iridesce_scene::EnvironmentMap;

use crate::lanes::{LANES, polynomial};
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

    /// Linear Rec.709 radiance from sixteen directions at once (length 1, pointing away from the scene).
    ///
    /// Sixteen, because one alone is a chain of some 200 cycles that nothing else can hide.
    #[inline(always)]
    pub fn rgb<S: Simd>(&self, simd: S, [dx, dy, dz]: [f32x16<S>; 3]) -> [[f32; LANES]; 3] {
        let (width, height) = (self.map.width, self.map.height);
        // Azimuth from -z (middle column) towards +x. A rotation by 90 degrees brings to +x (u = 0.75) what stood at
        // +z (u = 1), so it adds to u.
        let u = atan2_turns(simd, dx, -dz) + self.offset;
        let colatitude = atan2_turns(simd, dx.mul_add(dx, dz * dz).sqrt(), dy) * 2.0;
        let x = (u - u.floor()) * width as f32 - 0.5;
        let y = (colatitude * height as f32 - 0.5).max(0.0).min((height - 1) as f32);
        let (left, top) = (x.floor(), y.floor());
        let (across, down) = ((x - left).to_array(), (y - top).to_array());
        let (left, top) = (left.to_array(), top.to_array());
        let mut rgb = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let column = left[lane] as isize;
            let west = if column < 0 { width - 1 } else { (column as usize).min(width - 1) };
            let east = if column + 1 >= width as isize { 0 } else { (column + 1) as usize };
            let (north, south) = (top[lane] as usize, (top[lane] as usize + 1).min(height - 1));
            let (a, b) = (self.texel(north, west), self.texel(north, east));
            let (c, d) = (self.texel(south, west), self.texel(south, east));
            for i in 0..3 {
                let upper = a[i] + (b[i] - a[i]) * across[lane];
                let lower = c[i] + (d[i] - c[i]) * across[lane];
                rgb[i][lane] = upper + (lower - upper) * down[lane];
            }
        }
        rgb
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

/// Columns and rows of the grid by which diffuse surfaces look for light: 1.4 degrees.
const GRID: [usize; 2] = [256, 128];

/// Draws directions in proportion to the luminance of the maps, all added up.
pub struct MapSampler {
    /// Chance of a row, summed over all rows up to and with it.
    rows: Vec<f64>,
    /// Chance of a cell within its row, summed likewise.
    cells: Vec<f64>,
}

impl MapSampler {
    pub fn new(maps: &[(MapLookup, f32)]) -> MapSampler {
        let [columns, rows] = GRID;
        let mut power = vec![0.0_f64; columns * rows];
        dispatch!(Level::new(), simd => measure(simd, maps, &mut power));
        // A tenth goes to every direction alike, so that what falls between the samples is not missed.
        let solid: Vec<f64> = (0..rows).map(solid_angle).collect();
        let all: f64 = power.iter().enumerate().map(|(i, p)| p * solid[i / columns]).sum();
        let floor = 0.1 * all / (4.0 * std::f64::consts::PI);
        let (mut row_sums, mut cells) = (Vec::with_capacity(rows), Vec::with_capacity(columns * rows));
        let mut total = 0.0;
        for row in 0..rows {
            let mut sum = 0.0;
            for cell in &power[row * columns..(row + 1) * columns] {
                sum += cell.max(0.0) + floor.max(f64::MIN_POSITIVE);
                cells.push(sum);
            }
            for cell in &mut cells[row * columns..] {
                *cell /= sum;
            }
            total += sum * solid[row];
            row_sums.push(total);
        }
        for row in &mut row_sums {
            *row /= total;
        }
        MapSampler { rows: row_sums, cells }
    }

    /// A direction and its probability per solid angle, from two random numbers in [0, 1).
    #[inline(always)]
    pub fn draw(&self, (a, b): (f64, f64)) -> (Vec3, f64) {
        let columns = GRID[0];
        let (row, down, row_chance) = pick(&self.rows, b);
        let (column, across, chance) = pick(&self.cells[row * columns..(row + 1) * columns], a);
        let (top, bottom) = band(row);
        let y = top + (bottom - top) * down;
        let azimuth = std::f64::consts::TAU * ((column as f64 + across) / columns as f64 - 0.5);
        let (sin, cos) = azimuth.sin_cos();
        let level = (1.0 - y * y).max(0.0).sqrt();
        (Vec3::new(level * sin, y, -level * cos), row_chance * chance / solid_angle(row))
    }

    /// The probability per solid angle with which a direction is drawn.
    #[inline(always)]
    pub fn density(&self, direction: Vec3) -> f64 {
        let [columns, rows] = GRID;
        let turns = direction.x.atan2(-direction.z) / std::f64::consts::TAU + 0.5;
        let column = ((turns * columns as f64) as usize).min(columns - 1);
        let colatitude = direction.y.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
        let row = ((colatitude * rows as f64) as usize).min(rows - 1);
        let step = |sums: &[f64], i: usize| sums[i] - if i > 0 { sums[i - 1] } else { 0.0 };
        step(&self.rows, row) * step(&self.cells[row * columns..(row + 1) * columns], column) / solid_angle(row)
    }
}

/// Mean luminance of the maps over every cell of the grid, from sixteen places of it.
#[inline(always)]
fn measure<S: Simd>(simd: S, maps: &[(MapLookup, f32)], power: &mut [f64]) {
    /// Luminance of linear Rec.709 (ITU-R BT.709-6, item 3.2).
    const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
    let [columns, rows] = GRID;
    for (i, cell) in power.iter_mut().enumerate() {
        let mut directions = [[0.0_f32; LANES]; 3];
        let [x, y, z] = &mut directions;
        for (lane, ((x, y), z)) in x.iter_mut().zip(y).zip(z).enumerate() {
            let across = (i % columns) as f64 + ((lane % 4) as f64 + 0.5) / 4.0;
            let down = (i / columns) as f64 + ((lane / 4) as f64 + 0.5) / 4.0;
            let azimuth = std::f64::consts::TAU * (across / columns as f64 - 0.5);
            let colatitude = std::f64::consts::PI * down / rows as f64;
            let level = colatitude.sin();
            *x = (level * azimuth.sin()) as f32;
            *y = colatitude.cos() as f32;
            *z = (-level * azimuth.cos()) as f32;
        }
        let directions = [directions[0].simd_into(simd), directions[1].simd_into(simd), directions[2].simd_into(simd)];
        for (lookup, factor) in maps {
            let rgb = lookup.rgb(simd, directions);
            for c in 0..3 {
                let sum: f64 = rgb[c].iter().map(|&v| f64::from(v)).sum();
                *cell += f64::from(*factor) * LUMINANCE[c] * sum / LANES as f64;
            }
        }
    }
}

/// Cosines of the colatitudes between which a row of the grid lies.
#[inline(always)]
fn band(row: usize) -> (f64, f64) {
    let colatitude = |row: usize| std::f64::consts::PI * row as f64 / GRID[1] as f64;
    (colatitude(row).cos(), colatitude(row + 1).cos())
}

/// Solid angle of a cell of the grid.
#[inline(always)]
fn solid_angle(row: usize) -> f64 {
    let (top, bottom) = band(row);
    std::f64::consts::TAU / GRID[0] as f64 * (top - bottom)
}

/// Where a random number falls among summed chances: the place, how far into it, and its own chance.
#[inline(always)]
fn pick(sums: &[f64], random: f64) -> (usize, f64, f64) {
    let at = sums.partition_point(|&sum| sum <= random).min(sums.len() - 1);
    let before = if at > 0 { sums[at - 1] } else { 0.0 };
    let chance = sums[at] - before;
    (at, ((random - before) / chance).clamp(0.0, 1.0), chance)
}

/// atan(t) / (2 pi t) as a polynomial of t^2 on [0, 1]; weighted minimax fit.
const ATAN: [f32; 8] = [
    0.159_154_83,
    -0.053_046_122,
    0.031_745_944,
    -0.022_136_265,
    0.015_346_02,
    -0.008_898_706,
    0.003_479_586_2,
    -0.000_645_301_3,
];

/// atan2(y, x) in turns, in [-1/2, 1/2]; error below 1e-8 of a turn before rounding, so that a map of 8192 columns is
/// looked up to 5e-4 of a texel in f32. NaN-free: atan2(0, 0) is 0.
#[inline(always)]
fn atan2_turns<S: Simd>(simd: S, y: f32x16<S>, x: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(simd, 0.0);
    let (ax, ay) = (x.abs(), y.abs());
    // The smallest normal number keeps 0 / 0 from happening and changes no other quotient.
    let t = ax.min(ay) / ax.max(ay).max(f32::MIN_POSITIVE);
    let octant = t * polynomial(simd, t * t, &ATAN);
    let quadrant = ay.simd_gt(ax).select(f32x16::splat(simd, 0.25) - octant, octant);
    let half = x.simd_lt(zero).select(f32x16::splat(simd, 0.5) - quadrant, quadrant);
    half.copysign(y)
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
        fn check<S: Simd>(simd: S) {
            for i in 0..10_000 {
                let angles: [f64; LANES] = std::array::from_fn(|lane| {
                    (f64::from(i * LANES as u32 + lane as u32) / 80_000.0 - 1.0) * std::f64::consts::PI
                });
                let (y, x) = (angles.map(|a| a.sin() as f32), angles.map(|a| a.cos() as f32));
                let found = atan2_turns(simd, y.simd_into(simd), x.simd_into(simd)).to_array();
                for lane in 0..LANES {
                    let exact = f64::from(y[lane]).atan2(f64::from(x[lane])) / std::f64::consts::TAU;
                    // Half an ulp of a result up to 1/2 is 3e-8; the polynomial's own rounding adds as much.
                    assert!((f64::from(found[lane]) - exact).abs() < 9e-8, "{}", angles[lane]);
                }
            }
            assert_eq!(atan2_turns(simd, f32x16::splat(simd, 0.0), f32x16::splat(simd, 0.0)).to_array(), [0.0; LANES]);
        }
        dispatch!(Level::new(), simd => check(simd));
    }

    #[test]
    fn directions_meet_their_texels() {
        let (width, height) = (64, 32);
        let look = |turn: f64, x: f32, y: f32, z: f32| {
            let lookup = MapLookup::new(ramp(width, height), turn);
            let rgb = dispatch!(Level::new(), simd => {
                lookup.rgb(simd, [f32x16::splat(simd, x), f32x16::splat(simd, y), f32x16::splat(simd, z)])
            });
            [rgb[0][7], rgb[1][7]]
        };
        assert!((look(0.0, 0.0, 0.0, -1.0)[0] - 31.5).abs() < 1e-4, "-z: middle column");
        assert!((look(0.0, 1.0, 0.0, 0.0)[0] - 47.5).abs() < 1e-4, "+x: three quarters");
        assert!((look(0.0, 0.0, 0.0, -1.0)[1] - 15.5).abs() < 1e-4, "the horizon: middle row");
        assert!(look(0.0, 0.0, 1.0, 0.0)[1].abs() < 1e-4, "+y: first row");
        assert!((look(0.0, 0.0, -1.0, 0.0)[1] - 31.0).abs() < 1e-4, "-y: last row");
        assert!((look(90.0, 1.0, 0.0, 1e-7)[0] - look(0.0, 1e-7, 0.0, 1.0)[0]).abs() < 1e-3, "+z turns to +x");
        assert!((look(0.0, 0.0, 0.0, 1.0)[0] - 31.5).abs() < 1e-3, "+z: half way between last and first column");
    }
}
