//! Light from all around: direction to radiance.

use std::sync::Arc;

use fearless_simd::{Simd, dispatch, f32x16, prelude::*};
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::latlong;
use iridesce_numerics::simd;
use iridesce_numerics::turns::{atan2_turns, sin_cos_turns};
use iridesce_scene::EnvironmentMap;
use rayon::prelude::*;

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

    /// How many places by a side of a field, the sphere parted into so many, tell of every texel: a lookup in the middle of four is their mean.
    fn places_by(&self, columns: usize, rows: usize) -> usize {
        self.map.width.div_ceil(2 * columns).max(self.map.height.div_ceil(2 * rows)).clamp(1, MOST_CLOSER)
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

/// So many fields across and down each of its cells are told apart.
const FINE: usize = 4;

/// Most places by a side of a field that are looked at: every texel of maps of 16 384 columns.
const MOST_CLOSER: usize = 8;

/// Draws directions in proportion to the light of the maps, red, green and blue added up, to the parts that [`Parts`] tell apart.
pub struct MapSampler {
    rows: Parts<{ GRID[1] }>,
    /// Of the cells within each row.
    cells: Vec<Parts<{ GRID[0] }>>,
    /// Heights of the edges of the rows, from the first's upper one on.
    heights: Vec<f64>,
    /// Probability per solid angle with which a direction is drawn, by cell.
    densities: Vec<f32>,
    /// Red, green and blue of the maps together, about [`FINE`] times [`FINE`] places of every cell, row after row; nowhere 0.
    lights: Vec<f32>,
}

/// What the maps are like in sixteen directions.
#[derive(Clone, Copy)]
pub struct Around<V> {
    /// The probability per solid angle with which each is drawn.
    pub densities: V,
    /// About the light from there, red, green and blue together; nowhere 0.
    pub lights: V,
}

impl MapSampler {
    pub fn new(maps: &[(MapLookup, f32)]) -> MapSampler {
        let [columns, rows] = GRID;
        let mut lights = vec![0.0_f32; FINE * FINE * columns * rows];
        let closer = maps.iter().map(|(lookup, _)| lookup.places_by(FINE * columns, FINE * rows)).max().unwrap_or(1);
        lights.par_chunks_exact_mut(FINE * columns).enumerate().for_each(|(row, lights)| {
            dispatch!(simd::level_or_best(), simd => measure(simd, maps, closer, row, lights));
        });
        let mut lights = softened(&lights, FINE * columns);
        let mut power = vec![0.0_f64; columns * rows];
        for (i, light) in lights.iter().enumerate() {
            let (row, column) = (i / (FINE * columns), i % (FINE * columns));
            power[row / FINE * columns + column / FINE] += f64::from(*light);
        }
        // Where places are black there may be light between them.
        let mean = lights.iter().map(|light| f64::from(*light)).sum::<f64>() / lights.len() as f64;
        lights.iter_mut().for_each(|light| *light += (0.01 * mean).max(f64::from(f32::MIN_POSITIVE)) as f32);
        // A tenth goes to every direction alike, so that what falls between the places is not missed.
        let solid: Vec<f64> = (0..rows).map(|row| latlong::solid_angle(row, GRID)).collect();
        let all: f64 = power.iter().enumerate().map(|(i, p)| p * solid[i / columns]).sum();
        let floor = (0.1 * all / (4.0 * std::f64::consts::PI)).max(f64::MIN_POSITIVE);
        power.iter_mut().for_each(|cell| *cell = cell.max(0.0) + floor);
        let cells: Vec<_> = power.chunks(columns).map(Parts::new).collect();
        let shares: Vec<f64> =
            power.chunks(columns).zip(&solid).map(|(row, angle)| row.iter().sum::<f64>() * angle).collect();
        let own_rows = Parts::new(&shares);
        let density = |i: usize| {
            let (row, column) = (i / columns, i % columns);
            (own_rows.of(row) * cells[row].of(column) / solid[row]) as f32
        };
        let densities = (0..columns * rows).map(density).collect();
        let mut heights: Vec<f64> = (0..rows).map(|row| latlong::band(row, rows)[0]).collect();
        heights.push(-1.0);
        MapSampler { rows: own_rows, cells, heights, densities, lights }
    }

    /// Sixteen directions of sixteen points of the unit square.
    #[inline(always)]
    pub fn draw_lanes<S: Simd>(&self, simd: S, points: &[(f64, f64); LANES]) -> [f32x16<S>; 3] {
        let columns = GRID[0] as f64;
        let [mut turns, mut height, mut level] = [[0.0_f32; LANES]; 3];
        for (lane, &(a, b)) in points.iter().enumerate() {
            let (row, down) = self.rows.pick(b);
            let (column, across) = self.cells[row].pick(a);
            let y = self.heights[row] + (self.heights[row + 1] - self.heights[row]) * down;
            turns[lane] = ((column as f64 + across) / columns - 0.5) as f32;
            (height[lane], level[lane]) = (y as f32, ((1.0 - y) * (1.0 + y)).max(0.0).sqrt() as f32);
        }
        let (sin, cos) = sin_cos_turns(f32x16::from_slice(simd, &turns));
        let level = f32x16::from_slice(simd, &level);
        [level * sin, f32x16::from_slice(simd, &height), -(level * cos)]
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

/// So many parts alike the random numbers are divided into.
const PARTS: usize = 2048;

/// Entries of a list, at most 256, each of which has as many of [`PARTS`] parts as it is worth, to a whole number, but one at least: where a
/// random number falls is looked up, and what the chance of that is stands for certain.
struct Parts<const COUNT: usize> {
    /// The entry that a part belongs to.
    entries: Box<[u8; PARTS]>,
    /// The first part of each entry.
    first: [u16; COUNT],
    /// How many it has.
    count: [u16; COUNT],
}

impl<const COUNT: usize> Parts<COUNT> {
    /// In proportion to positive numbers.
    fn new(worth: &[f64]) -> Parts<COUNT> {
        let all: f64 = worth.iter().sum();
        let (mut entries, mut first, mut count) = (Box::new([0; PARTS]), [0; COUNT], [0; COUNT]);
        let (mut sum, mut at) = (0.0, 0);
        for (entry, own) in worth.iter().enumerate().take(COUNT) {
            sum += own;
            // One for each entry so far; of the others its share.
            let rest = ((PARTS - COUNT) as f64 * (sum / all).clamp(0.0, 1.0)).round() as usize;
            let end = if entry + 1 == COUNT { PARTS } else { entry + 1 + rest };
            entries[at..end].fill(entry as u8);
            (first[entry], count[entry]) = (at as u16, (end - at) as u16);
            at = end;
        }
        Parts { entries, first, count }
    }

    /// The chance of an entry.
    fn of(&self, entry: usize) -> f64 {
        f64::from(self.count[entry]) / PARTS as f64
    }

    /// The entry that a random number in [0, 1) falls into, and how far.
    #[inline(always)]
    fn pick(&self, random: f64) -> (usize, f64) {
        let place = random * PARTS as f64;
        let entry = usize::from(self.entries[(place as usize).min(PARTS - 1)]);
        (entry, (place - f64::from(self.first[entry])) / f64::from(self.count[entry]))
    }
}

/// Adds red, green and blue of the maps together, of a row of the fine grid: the mean over so many places by a side of each
/// field.
#[inline(always)]
fn measure<S: Simd>(simd: S, maps: &[(MapLookup, f32)], closer: usize, row: usize, lights: &mut [f32]) {
    let size = GRID.map(|count| count * FINE * closer);
    let share = 1.0 / (closer * closer) as f32;
    for place in (0..size[0] * closer).step_by(LANES) {
        let (row, column) = (row * closer + place / size[0], place % size[0]);
        let mut directions = [[0.0_f32; LANES]; 3];
        let [x, y, z] = &mut directions;
        for (lane, ((x, y), z)) in x.iter_mut().zip(y).zip(z).enumerate() {
            let place = [(column + lane) as f64 + 0.5, row as f64 + 0.5];
            [*x, *y, *z] = latlong::direction(place, size).map(|v| v as f32);
        }
        let directions = [directions[0].simd_into(simd), directions[1].simd_into(simd), directions[2].simd_into(simd)];
        for (lookup, factor) in maps {
            for channel in lookup.rgb(directions) {
                for (lane, value) in channel.into_iter().enumerate() {
                    lights[(column + lane) / closer] += factor * share * value.max(0.0);
                }
            }
        }
    }
}

/// Every place a quarter of itself and of its neighbours in proportion: between places maps are looked up, and what is told of one should not
/// be far below what is found beside it, or a path that looks there brings far too much.
fn softened(lights: &[f32], columns: usize) -> Vec<f32> {
    let rows = lights.len() / columns;
    let along: Vec<f32> = lights
        .chunks_exact(columns)
        .flat_map(|row| {
            let at = |i: usize| row[i % columns];
            (0..columns).map(move |i| 0.5 * at(i) + 0.25 * (at(i + columns - 1) + at(i + 1)))
        })
        .collect();
    let at = |row: usize, column: usize| along[row * columns + column];
    (0..lights.len())
        .map(|i| {
            let (row, column) = (i / columns, i % columns);
            let [above, below] = [row.saturating_sub(1), (row + 1).min(rows - 1)];
            0.5 * at(row, column) + 0.25 * (at(above, column) + at(below, column))
        })
        .collect()
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
    /// of planes through its middle. Where one texel is much brighter than all others, too: then hardly any are drawn but there.
    #[test]
    fn maps_are_drawn_by_their_density() {
        let (width, height) = (64, 32);
        let planes = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [0.36, 0.8, 0.48]];
        for bright in [40.0, 1e6] {
            let dim = |i: usize| if i % 97 == 3 { 40.0 } else { (i % 7) as f32 * 0.1 };
            let rgb = (0..width * height).flat_map(|i| [if i == 700 { bright } else { dim(i) }; 3]).collect();
            let lookup = MapLookup::new(Arc::new(EnvironmentMap { width, height, rgb }), 30.0);
            let sampler = MapSampler::new(&[(lookup, 2.0)]);
            let mut noise = iridesce_numerics::noise::SplitMix64::new(3);
            let (mut sphere, mut squares, mut halves, mut others) = (0.0, 0.0, [0.0; 5], 0);
            let (mut drawn, rounds) = (0, 20_000);
            for _ in 0..rounds {
                let points = std::array::from_fn(|_| (noise.unit(), noise.unit()));
                let (ways, told) = dispatch!(simd::level_or_best(), simd => {
                    let ways = sampler.draw_lanes(simd, &points);
                    let told = sampler.around(simd, &ways);
                    (ways.map(|along| along.to_array()), told.densities.to_array())
                });
                for lane in 0..LANES {
                    let way = ways.map(|along| f64::from(along[lane]));
                    assert!((way.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-6);
                    let (a, b) = points[lane];
                    let (row, _) = sampler.rows.pick(b);
                    let own = sampler.densities[row * GRID[0] + sampler.cells[row].pick(a).0];
                    // (At the edge of a cell rounding may take it for the next.)
                    others += usize::from(own != told[lane]);
                    let angle = 1.0 / f64::from(own);
                    (sphere, squares, drawn) = (sphere + angle, squares + angle * angle, drawn + 1);
                    for (half, plane) in halves.iter_mut().zip(planes) {
                        *half += if way.iter().zip(plane).map(|(a, b)| a * b).sum::<f64>() > 0.0 { angle } else { 0.0 };
                    }
                }
            }
            let count = f64::from(drawn);
            let error = 5.0 * (squares / count).sqrt() / count.sqrt() / std::f64::consts::PI;
            assert!(error < 0.3, "{error}");
            for (what, sum, wanted) in
                [("sphere", sphere, 4.0)].into_iter().chain(halves.map(|half| ("half", half, 2.0)))
            {
                let part = sum / count / std::f64::consts::PI;
                assert!((part - wanted).abs() < error, "{what}: {part} pi, within {error}");
            }
            assert!((others as f64) < 1e-3 * count, "{others}");
        }
    }

    /// Every entry has a part at least, together they have all, and what is worth much has what it is worth.
    #[test]
    fn parts_are_shared_out() {
        for worth in [[1.0, 0.0, 3.0, 0.0], [1e-300, 1.0, 1e300, 2.0], [5e-324; 4], [1.0; 4]] {
            let parts = Parts::<4>::new(&worth);
            let all: f64 = worth.iter().sum();
            assert_eq!(parts.count.iter().map(|own| usize::from(*own)).sum::<usize>(), PARTS);
            for (entry, own) in worth.iter().enumerate() {
                assert!(parts.count[entry] >= 1);
                assert!((parts.of(entry) - own / all).abs() <= 4.0 / PARTS as f64, "{worth:?}");
            }
            for part in 0..4 * PARTS {
                let random = (part as f64 + 0.5) / (4 * PARTS) as f64;
                let (entry, within) = parts.pick(random);
                let from: f64 = (0..entry).map(|before| parts.of(before)).sum();
                assert!((from + within * parts.of(entry) - random).abs() < 1e-12 && (0.0..1.0).contains(&within));
            }
        }
    }
}
