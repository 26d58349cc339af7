//! Light from all around: direction to radiance.

use std::sync::Arc;

use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::latlong;
use iridesce_numerics::simd;
use iridesce_numerics::turns::{atan2_turns, sin_cos_turns};
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

/// Columns and rows of the grid by which surfaces that scatter look for light: 1.4 degrees.
const GRID: [usize; 2] = [256, 128];

/// So many places across and down each of its cells are looked at.
const FINE: usize = 4;

/// So many bands of as much light the sphere is parted into, and each of these into so many fields.
const BANDS: usize = 256;
const FIELDS: usize = 256;

/// Draws directions in proportion to the luminance of the maps, all added up: evenly within fields of as much light, which fill the sphere.
/// Where a random number falls among fields alike is told without a search.
pub struct MapSampler {
    /// Heights of the edges of the bands, from the upper one of the first on.
    heights: Vec<f64>,
    /// Of each band the edges of its fields, in turns from the left edge of the maps.
    turns: Vec<f32>,
    /// Of each band the probability per solid angle in a field of one turn.
    shares: Vec<f32>,
    /// About the probability per solid angle with which a direction is drawn, by cell.
    densities: Vec<f32>,
    /// Red, green and blue of the maps together, at [`FINE`] times [`FINE`] places of every cell, row after row; nowhere 0.
    lights: Vec<f32>,
}

/// What the maps are like in sixteen directions.
#[derive(Clone, Copy)]
pub struct Around<V> {
    /// About the probability per solid angle with which each is drawn.
    pub densities: V,
    /// About the light from there, red, green and blue together; nowhere 0.
    pub lights: V,
}

impl MapSampler {
    pub fn new(maps: &[(MapLookup, f32)]) -> MapSampler {
        let [columns, rows] = GRID;
        let mut power = vec![0.0_f64; columns * rows];
        let mut lights = vec![0.0_f32; FINE * FINE * columns * rows];
        dispatch!(simd::level_or_best(), simd => measure(simd, maps, &mut power, &mut lights));
        // Where places are black there may be light between them.
        let mean = lights.iter().map(|light| f64::from(*light)).sum::<f64>() / lights.len() as f64;
        lights.iter_mut().for_each(|light| *light += (0.01 * mean).max(f64::from(f32::MIN_POSITIVE)) as f32);
        // A tenth goes to every direction alike, so that what falls between the places is not missed.
        let solid: Vec<f64> = (0..rows).map(|row| latlong::solid_angle(row, GRID)).collect();
        let all: f64 = power.iter().enumerate().map(|(i, p)| p * solid[i / columns]).sum();
        let floor = (0.1 * all / (4.0 * std::f64::consts::PI)).max(f64::MIN_POSITIVE);
        power.iter_mut().for_each(|cell| *cell = cell.max(0.0) + floor);
        let of_rows: Vec<f64> =
            power.chunks(columns).zip(&solid).map(|(row, angle)| row.iter().sum::<f64>() * angle).collect();
        let whole: f64 = of_rows.iter().sum();
        let densities = power.iter().map(|cell| (cell / whole) as f32).collect();

        let edges = alike(&of_rows, BANDS);
        let heights: Vec<f64> = edges.iter().map(|&edge| (std::f64::consts::PI * edge / rows as f64).cos()).collect();
        let (mut turns, mut shares) = (Vec::new(), Vec::new());
        for band in 0..BANDS {
            let [upper, lower] = [edges[band], edges[band + 1]];
            let mut own = vec![0.0; columns];
            for row in upper as usize..(lower.ceil() as usize).min(rows) {
                let [from, to] = [upper.max(row as f64), lower.min((row + 1) as f64)];
                let tall = [from, to].map(|edge| (std::f64::consts::PI * edge / rows as f64).cos());
                for (own, cell) in own.iter_mut().zip(&power[row * columns..(row + 1) * columns]) {
                    *own += cell * (tall[0] - tall[1]);
                }
            }
            turns.extend(alike(&own, FIELDS).iter().map(|edge| (edge / columns as f64) as f32));
            let angle = std::f64::consts::TAU * (heights[band] - heights[band + 1]);
            shares.push((1.0 / ((BANDS * FIELDS) as f64 * angle)) as f32);
        }
        MapSampler { heights, turns, shares, densities, lights }
    }

    /// Sixteen directions of sixteen points of the unit square, and the probability per solid angle with which each is drawn.
    #[inline(always)]
    pub fn draw_lanes<S: Simd>(&self, simd: S, points: &[(f64, f64); LANES]) -> ([f32x16<S>; 3], f32x16<S>) {
        let [mut turns, mut wide, mut height, mut level, mut shares] = [[0.0_f32; LANES]; 5];
        for (lane, &(a, b)) in points.iter().enumerate() {
            let (across, down) = (a * FIELDS as f64, b * BANDS as f64);
            let (field, band) = ((across as usize).min(FIELDS - 1), (down as usize).min(BANDS - 1));
            let (across, down) = (across - field as f64, down - band as f64);
            let y = self.heights[band] + (self.heights[band + 1] - self.heights[band]) * down;
            let left = self.turns[band * (FIELDS + 1) + field];
            wide[lane] = self.turns[band * (FIELDS + 1) + field + 1] - left;
            turns[lane] = left + wide[lane] * across as f32 - 0.5;
            (height[lane], level[lane]) = (y as f32, ((1.0 - y) * (1.0 + y)).max(0.0).sqrt() as f32);
            shares[lane] = self.shares[band];
        }
        let (sin, cos) = sin_cos_turns(f32x16::from_slice(simd, &turns));
        let level = f32x16::from_slice(simd, &level);
        let densities = f32x16::from_slice(simd, &shares) / f32x16::from_slice(simd, &wide);
        ([level * sin, f32x16::from_slice(simd, &height), -(level * cos)], densities)
    }

    /// What the maps are like in sixteen directions of length 1.
    #[inline(always)]
    pub fn around<S: Simd>(&self, simd: S, [x, y, z]: &[f32x16<S>; 3]) -> Around<f32x16<S>> {
        let [columns, rows] = GRID.map(|count| count * FINE);
        let (across, down) = (atan2_turns(*x, -*z) + 0.5, atan2_turns(x.mul_add(*x, *z * *z).sqrt(), *y));
        let (across, down) = ((across * columns as f32).to_array(), (down * (2 * rows) as f32).to_array());
        let [mut densities, mut lights] = [[0.0_f32; LANES]; 2];
        for lane in 0..LANES {
            let (column, row) = ((across[lane] as usize).min(columns - 1), (down[lane] as usize).min(rows - 1));
            densities[lane] = self.densities[row / FINE * GRID[0] + column / FINE];
            lights[lane] = self.lights[row * columns + column];
        }
        Around { densities: f32x16::from_slice(simd, &densities), lights: f32x16::from_slice(simd, &lights) }
    }
}

/// The edges of so many parts of a list that are alike in sum, the numbers evenly within each of its entries; the first is 0, the last
/// the length of the list.
fn alike(list: &[f64], parts: usize) -> Vec<f64> {
    let all: f64 = list.iter().sum();
    let (mut at, mut before) = (0, 0.0);
    let edge = |part: usize| {
        let wanted = all * part as f64 / parts as f64;
        while at + 1 < list.len() && before + list[at] < wanted {
            before += list[at];
            at += 1;
        }
        at as f64 + ((wanted - before) / list[at]).clamp(0.0, 1.0)
    };
    let mut edges: Vec<f64> = (0..=parts).map(edge).collect();
    (edges[0], edges[parts]) = (0.0, list.len() as f64);
    edges
}

/// Mean luminance of the maps over every cell of the grid, from sixteen places of it.
#[inline(always)]
fn measure<S: Simd>(simd: S, maps: &[(MapLookup, f32)], power: &mut [f64], lights: &mut [f32]) {
    let columns = GRID[0];
    for (i, cell) in power.iter_mut().enumerate() {
        let mut directions = [[0.0_f32; LANES]; 3];
        let [x, y, z] = &mut directions;
        for (lane, ((x, y), z)) in x.iter_mut().zip(y).zip(z).enumerate() {
            let across = (i % columns) as f64 + ((lane % FINE) as f64 + 0.5) / FINE as f64;
            let down = (i / columns) as f64 + ((lane / FINE) as f64 + 0.5) / FINE as f64;
            [*x, *y, *z] = latlong::direction([across, down], GRID).map(|v| v as f32);
        }
        let directions = [directions[0].simd_into(simd), directions[1].simd_into(simd), directions[2].simd_into(simd)];
        for (lookup, factor) in maps {
            let rgb = lookup.rgb(directions);
            for c in 0..3 {
                let sum: f64 = rgb[c].iter().map(|&v| f64::from(v)).sum();
                *cell += f64::from(*factor) * REC709_LUMINANCE[c] * sum / LANES as f64;
                for (lane, value) in rgb[c].iter().enumerate() {
                    let (row, column) = (i / columns * FINE + lane / FINE, i % columns * FINE + lane % FINE);
                    lights[row * FINE * columns + column] += factor * value.max(0.0);
                }
            }
        }
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

    /// Directions come as often as is told: over draws one over the density is the whole sphere on average, and half of it on either side
    /// of planes through its middle.
    #[test]
    fn maps_are_drawn_by_their_density() {
        let (width, height) = (64, 32);
        let rgb =
            (0..width * height).flat_map(|i| [if i % 97 == 3 { 40.0 } else { (i % 7) as f32 * 0.1 }; 3]).collect();
        let lookup = MapLookup::new(Arc::new(EnvironmentMap { width, height, rgb }), 30.0);
        let sampler = MapSampler::new(&[(lookup, 2.0)]);
        let planes = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [0.36, 0.8, 0.48]];
        let (mut noise, mut sphere, mut halves) = (iridesce_numerics::noise::SplitMix64::new(3), 0.0, [0.0; 5]);
        let (mut far, rounds) = (0, 20_000);
        for _ in 0..rounds {
            let points = std::array::from_fn(|_| (noise.unit(), noise.unit()));
            let (ways, told, about) = dispatch!(simd::level_or_best(), simd => {
                let (ways, told) = sampler.draw_lanes(simd, &points);
                let about = sampler.around(simd, &ways).densities;
                (ways.map(|along| along.to_array()), told.to_array(), about.to_array())
            });
            for lane in 0..LANES {
                let way = ways.map(|along| f64::from(along[lane]));
                assert!((way.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-6);
                let angle = 1.0 / f64::from(told[lane]);
                sphere += angle;
                for (half, plane) in halves.iter_mut().zip(planes) {
                    *half += if way.iter().zip(plane).map(|(a, b)| a * b).sum::<f64>() > 0.0 { angle } else { 0.0 };
                }
                far += usize::from(!(0.5..2.0).contains(&(about[lane] / told[lane])));
            }
        }
        let count = (rounds * LANES) as f64;
        // The spread of 1 / density is below that of a density of a tenth of the mean: 40 pi.
        let error = 5.0 * 10.0 / count.sqrt();
        for (what, sum, wanted) in [("sphere", sphere, 4.0)].into_iter().chain(halves.map(|half| ("half", half, 2.0))) {
            let part = sum / count / std::f64::consts::PI;
            assert!((part - wanted).abs() < 4.0 * error, "{what}: {part} pi");
        }
        // Fields that reach over the edge of a bright cell are few.
        assert!((far as f64) < 0.05 * count, "{far}");
    }

    #[test]
    fn parts_alike_end_where_sums_say() {
        let edges = alike(&[1.0, 0.0, 3.0], 4);
        assert_eq!(edges, [0.0, 1.0, 2.0 + 1.0 / 3.0, 2.0 + 2.0 / 3.0, 3.0]);
        assert_eq!(alike(&[0.5], 2), [0.0, 0.5, 1.0]);
    }
}
