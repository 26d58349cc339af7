//! Light from all around: direction to radiance.

use std::sync::Arc;

use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::latlong;
use iridesce_numerics::simd;
use iridesce_numerics::turns::atan2_turns;
use iridesce_optics::color::REC709_LUMINANCE;
use iridesce_scene::EnvironmentMap;

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
    pub fn rgb<S: Simd>(&self, [dx, dy, dz]: [f32x16<S>; 3]) -> [[f32; LANES]; 3] {
        let (width, height) = (self.map.width, self.map.height);
        // Azimuth from -z (middle column) towards +x. A rotation by 90 degrees brings to +x (u = 0.75) what stood at
        // +z (u = 1), so it adds to u.
        let u = atan2_turns(dx, -dz) + self.offset;
        let colatitude = atan2_turns(dx.mul_add(dx, dz * dz).sqrt(), dy) * 2.0;
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

    /// Radiance that is there in every direction: the least of each channel.
    pub fn least_rgb(&self) -> [f32; 3] {
        let texels = self.map.rgb.chunks_exact(3);
        let least = texels.fold([f32::INFINITY; 3], |least, rgb| std::array::from_fn(|c| least[c].min(rgb[c])));
        least.map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 })
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
    /// One over the solid angle of a cell, by row.
    per_angle: Vec<f64>,
}

impl MapSampler {
    pub fn new(maps: &[(MapLookup, f32)]) -> MapSampler {
        let [columns, rows] = GRID;
        let mut power = vec![0.0_f64; columns * rows];
        dispatch!(simd::level_or_best(), simd => measure(simd, maps, &mut power));
        // A tenth goes to every direction alike, so that what falls between the samples is not missed.
        let solid: Vec<f64> = (0..rows).map(|row| latlong::solid_angle(row, GRID)).collect();
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
        MapSampler { rows: row_sums, cells, per_angle: solid.iter().map(|angle| 1.0 / angle).collect() }
    }

    /// A direction and its probability per solid angle, from two random numbers in [0, 1).
    #[inline(always)]
    pub fn draw(&self, (a, b): (f64, f64)) -> (Vec3, f64) {
        let columns = GRID[0];
        let (row, down, row_chance) = pick(&self.rows, b);
        let (column, across, chance) = pick(&self.cells[row * columns..(row + 1) * columns], a);
        let [top, bottom] = latlong::band(row, GRID[1]);
        let y = top + (bottom - top) * down;
        let azimuth = std::f64::consts::TAU * ((column as f64 + across) / columns as f64 - 0.5);
        let (sin, cos) = azimuth.sin_cos();
        let level = (1.0 - y * y).max(0.0).sqrt();
        (Vec3::new(level * sin, y, -level * cos), row_chance * chance * self.per_angle[row])
    }

    /// The probability per solid angle with which a direction is drawn.
    #[inline(always)]
    pub fn density(&self, direction: Vec3) -> f64 {
        let [columns, rows] = GRID;
        let [across, down] = latlong::place(direction.to_array(), GRID);
        let (column, row) = ((across as usize).min(columns - 1), (down as usize).min(rows - 1));
        let step = |sums: &[f64], i: usize| sums[i] - if i > 0 { sums[i - 1] } else { 0.0 };
        step(&self.rows, row) * step(&self.cells[row * columns..(row + 1) * columns], column) * self.per_angle[row]
    }
}

/// Mean luminance of the maps over every cell of the grid, from sixteen places of it.
#[inline(always)]
fn measure<S: Simd>(simd: S, maps: &[(MapLookup, f32)], power: &mut [f64]) {
    let columns = GRID[0];
    for (i, cell) in power.iter_mut().enumerate() {
        let mut directions = [[0.0_f32; LANES]; 3];
        let [x, y, z] = &mut directions;
        for (lane, ((x, y), z)) in x.iter_mut().zip(y).zip(z).enumerate() {
            let across = (i % columns) as f64 + ((lane % 4) as f64 + 0.5) / 4.0;
            let down = (i / columns) as f64 + ((lane / 4) as f64 + 0.5) / 4.0;
            [*x, *y, *z] = latlong::direction([across, down], GRID).map(|v| v as f32);
        }
        let directions = [directions[0].simd_into(simd), directions[1].simd_into(simd), directions[2].simd_into(simd)];
        for (lookup, factor) in maps {
            let rgb = lookup.rgb(directions);
            for c in 0..3 {
                let sum: f64 = rgb[c].iter().map(|&v| f64::from(v)).sum();
                *cell += f64::from(*factor) * REC709_LUMINANCE[c] * sum / LANES as f64;
            }
        }
    }
}

/// Where a random number falls among summed chances: the place, how far into it, and its own chance.
#[inline(always)]
fn pick(sums: &[f64], random: f64) -> (usize, f64, f64) {
    let at = sums.partition_point(|&sum| sum <= random).min(sums.len() - 1);
    let before = if at > 0 { sums[at - 1] } else { 0.0 };
    let chance = sums[at] - before;
    (at, ((random - before) / chance).clamp(0.0, 1.0), chance)
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
        let look = |turn: f64, x: f32, y: f32, z: f32| {
            let lookup = MapLookup::new(ramp(width, height), turn);
            let rgb = dispatch!(simd::level_or_best(), simd => {
                lookup.rgb([f32x16::splat(simd, x), f32x16::splat(simd, y), f32x16::splat(simd, z)])
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
