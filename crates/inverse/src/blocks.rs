//! Candidates of sixteen pixels at once: a lane a pixel, so that a thickness's row of the table is read once for all of them.
//!
//! The costs are passed through once, and never stored: a lane keeps its last three, and notes every minimum that may still count
//! beside the least cost so far. Those that count in the end are refined sixteen at a time, whichever pixels they belong to.

use fearless_simd::{Simd, dispatch, f32x16, mask32x16, prelude::*};
use iridesce_numerics::lanes::{SINGLES, Singles};
use iridesce_numerics::{Watch, simd};
use rayon::prelude::*;

use crate::InverseError;
use crate::pixels::{Candidates, EIGHT, MOST, NONE, Photograph, PixelTable, REACH, STEPS, reserved};

/// Candidates of sixteen pixels.
type Block = [Candidates; SINGLES];

/// A minimum of the grid: whose, where, and the costs about it.
#[derive(Debug, Clone, Copy)]
struct Minimum {
    lane: usize,
    column: usize,
    costs: [f32; 3],
}

/// What sixteen pixels need while they are looked at.
#[derive(Debug, Default)]
struct Scratch {
    minima: Vec<Minimum>,
    starts: Vec<Start>,
    /// Of pixels whose channels are cut: their costs, one after the other.
    costs: Vec<f32>,
}

/// A minimum on its way between columns: where it starts, and what it was on the grid.
#[derive(Debug, Clone, Copy)]
struct Start {
    lane: usize,
    column: usize,
    start: f32,
    cost: f32,
}

/// Candidates of every pixel, best first: by the table of its own angle; a masked pixel (`true`) has none.
pub fn all_candidates(tables: &[PixelTable], of: &Photograph<'_>, watch: &Watch) -> Result<Vec<Block>, InverseError> {
    of.check(tables.len())?;
    let count = of.count();
    let mut out = reserved(count.div_ceil(SINGLES))?;
    let level = simd::level_or_best();
    let blocks = (0..count.div_ceil(SINGLES)).into_par_iter().with_min_len(16);
    let block = |scratch: &mut Scratch, part: usize| {
        let first = part * SINGLES;
        let mut found = [[NONE; MOST]; SINGLES];
        if watch.check().is_ok() {
            let many = SINGLES.min(count - first);
            dispatch!(level, simd => some_candidates(simd, tables, of, first, many, scratch, &mut found));
            watch.add(many as u64);
        }
        found
    };
    blocks.map_init(Scratch::default, block).collect_into_vec(&mut out);
    watch.check()?;
    Ok(out)
}

/// Candidates of `many` pixels from `first` on, at most sixteen.
#[inline(always)]
fn some_candidates<S: Simd>(
    simd: S,
    tables: &[PixelTable],
    of: &Photograph<'_>,
    first: usize,
    many: usize,
    scratch: &mut Scratch,
    out: &mut Block,
) {
    let table_of = |i: usize| of.table_of.map_or(0, |table| usize::from(table[first + i]));
    let pixel = |i: usize| -> [f32; 3] { std::array::from_fn(|c| of.pixels[3 * (first + i) + c]) };
    let mut left = 0_u32; // pixels that are still to be looked at
    for i in 0..many {
        left |= u32::from(!of.mask.is_some_and(|mask| mask[first + i]) && pixel(i).iter().all(|v| v.is_finite())) << i;
    }
    while left != 0 {
        let lead = left.trailing_zeros() as usize;
        let table = &tables[table_of(lead)];
        // Whoever has the same table, and all channels.
        let mut together = 0_u32;
        let mut channels = [Singles::ZERO; 3];
        let alike = left;
        for i in (lead..many).filter(|&i| alike >> i & 1 == 1 && table_of(i) == table_of(lead)) {
            left &= !(1 << i);
            if table.is_cut(pixel(i)) {
                scratch.costs.resize(table.count(), 0.0);
                table.candidates(pixel(i), &mut scratch.costs, &mut out[i]);
                continue;
            }
            together |= 1 << i;
            for (lanes, (value, haze)) in channels.iter_mut().zip(pixel(i).iter().zip(table.haze)) {
                lanes.0[i] = value - haze;
            }
        }
        if together != 0 {
            let least = table.pass(simd, &channels, together, &mut scratch.minima);
            table.keep(simd, &channels, &least, &scratch.minima, &mut scratch.starts, out);
        }
    }
}

impl PixelTable {
    /// Costs of all thicknesses for sixteen pixels without haze, of which those in `lanes` are some. Every minimum that may count
    /// is put down; the least costs are returned.
    #[inline(always)]
    fn pass<S: Simd>(&self, simd: S, channels: &[Singles; 3], lanes: u32, minima: &mut Vec<Minimum>) -> Singles {
        minima.clear();
        let v: [f32x16<S>; 3] = std::array::from_fn(|c| channels[c].load(simd));
        let squares = v.map(|v| v * v);
        let (half, shading) = (f32x16::splat(simd, 0.5), f32x16::splat(simd, self.shading));
        let endless = f32x16::splat(simd, f32::INFINITY);
        let (mut least, mut before, mut at) = (endless, endless, endless);
        let reach = REACH * self.temper;
        for (part, (columns, coarse)) in self.columns.chunks(EIGHT).zip(&self.coarse).enumerate() {
            // A coarse table's minima lie between its columns; the first of a part belongs to the last.
            let beside = if part == 0 { *coarse } else { coarse.max(self.coarse[part - 1]) };
            let margin = f32x16::splat(simd, reach + 1.5 * beside);
            for (i, column) in columns.iter().enumerate() {
                let of = |n: usize| f32x16::splat(simd, column[n]);
                let square = of(0) * squares[0] + of(1) * squares[1] + of(2) * squares[2];
                let along = of(3) * v[0] + of(4) * v[1] + of(5) * v[2] + shading;
                let cost = half * (square - along * along * of(6)) + of(7);
                let is_least = at.simd_le(before) & at.simd_lt(cost) & at.simd_le(least + margin);
                let mut bits = is_least.to_bitmask() as u32 & lanes;
                if bits != 0 {
                    let mut stored = [Singles::ZERO; 3];
                    stored[0].store(before);
                    stored[1].store(at);
                    stored[2].store(cost);
                    while bits != 0 {
                        let lane = bits.trailing_zeros() as usize;
                        bits &= bits - 1;
                        let costs = [stored[0].0[lane], stored[1].0[lane], stored[2].0[lane]];
                        minima.push(Minimum { lane, column: part * EIGHT + i - 1, costs });
                    }
                }
                least = least.min(cost);
                (before, at) = (at, cost);
            }
        }
        let mut out = Singles::ZERO;
        out.store(least);
        out
    }

    /// Refines the minima that count and keeps the likeliest of each pixel.
    #[inline(always)]
    fn keep<S: Simd>(
        &self,
        simd: S,
        channels: &[Singles; 3],
        least: &Singles,
        minima: &[Minimum],
        starts: &mut Vec<Start>,
        out: &mut Block,
    ) {
        starts.clear();
        for &Minimum { lane, column, costs } in minima {
            if let Some(start) = PixelTable::start(costs, least.0[lane] + REACH * self.temper) {
                starts.push(Start { lane, column, start, cost: costs[1] });
            }
        }
        let mut kept = [[(f32::INFINITY, NONE); MOST]; SINGLES];
        // (One call alone: what is called from two places is not inlined, and its vectors are then passed by memory.)
        for group in starts.chunks(SINGLES) {
            let found = self.refine(simd, channels, group);
            for (one, (shift, low)) in group.iter().zip(found) {
                let (shift, low) = if low < one.cost { (shift, low) } else { (0.0, one.cost) };
                self.insert(&mut kept[one.lane], one.column, shift, low);
            }
        }
        for (kept, out) in kept.iter().zip(out).filter(|(kept, _)| kept[0].0.is_finite()) {
            self.told(kept, out);
        }
    }

    /// [`PixelTable::refined`] for at most sixteen minima of pixels whose channels are all whole.
    #[inline(always)]
    fn refine<S: Simd>(&self, simd: S, channels: &[Singles; 3], group: &[Start]) -> [(f32, f32); SINGLES] {
        let all = |value: f32| f32x16::splat(simd, value);
        // Values at three columns: of the channels, and of what is left of the cost.
        let mut at = [[Singles::ZERO; 3]; 4];
        let mut v = [Singles::ZERO; 3];
        let [mut start, mut offset, mut low, mut high] = [Singles::ZERO; 4];
        let constant = self.constant();
        let last = self.count() - 1;
        for (i, one) in group.iter().enumerate() {
            let middle = one.column.clamp(1, last - 1);
            let whose = self.model.iter().map(Vec::as_slice).chain([constant]);
            for (at, values) in at.iter_mut().zip(whose) {
                at.iter_mut().zip(&values[middle - 1..]).for_each(|(at, value)| at.0[i] = *value);
            }
            v.iter_mut().zip(channels).for_each(|(v, channel)| v.0[i] = channel.0[one.lane]);
            start.0[i] = one.start;
            offset.0[i] = one.column as f32 - middle as f32;
            (low.0[i], high.0[i]) = ((-(one.column as f32)).max(-1.0), ((last - one.column) as f32).min(1.0));
        }
        let curve: [[f32x16<S>; 3]; 4] = std::array::from_fn(|c| {
            let [a, b, d] = [0, 1, 2].map(|n| at[c][n].load(simd));
            [b, all(0.5) * (d - a), a - all(2.0) * b + d]
        });
        let v: [f32x16<S>; 3] = std::array::from_fn(|c| v[c].load(simd));
        let [mut t, offset, low, high] = [start, offset, low, high].map(|of| of.load(simd));
        let shading = all(self.shading);
        let (mut cost, mut place) = (all(f32::INFINITY), t);
        let mut going = mask32x16::from_bitmask(simd, (1 << group.len()) - 1);
        for turn in 0..=STEPS {
            let x = t + offset;
            let value = |[at, slope, bend]: [f32x16<S>; 3]| at + x * (slope + all(0.5) * x * bend);
            let (mut square, mut along, mut size) = (shading, shading, shading);
            let mut part = [(t, t, t); 3];
            for c in 0..3 {
                let m = value(curve[c]);
                let light = m + all(self.haze[c]);
                let [base, slope] = self.noise[c].map(all);
                let unknown = all(self.unknown) * light;
                let w = all(1.0) / (base + slope * light.max(all(0.0)) + unknown * unknown).max(all(1e-14));
                square += w * v[c] * v[c];
                along += w * m * v[c];
                size += w * m * m;
                part[c] = (m, curve[c][1] + x * curve[c][2], w);
            }
            let gain = along / size;
            let (mut pull, mut stiff, mut turned) = (all(0.0), all(0.0), all(0.0));
            for ((m, slope, w), v) in part.into_iter().zip(v) {
                let change = gain * slope;
                pull += w * change * (v - gain * m);
                stiff += w * change * change;
                turned += w * change * m;
            }
            let stiff = stiff - turned * turned / size;
            let step = (pull / stiff).max(all(-0.5)).min(all(0.5));
            let step = stiff.simd_gt(all(1e-9)).select(step, all(0.0));
            let here = all(0.5) * (square - along * gain - shading) + value(curve[3]);
            // A tenth of a standard deviation: nothing is gained beyond.
            let done = if turn == STEPS { going } else { going & (step * step * stiff).simd_lt(all(0.01)) };
            cost = done.select(here, cost);
            place = done.select(t, place);
            going &= !done;
            if going.all_false() {
                break;
            }
            t = (t + step).max(low).min(high);
        }
        let (mut costs, mut places) = (Singles::ZERO, Singles::ZERO);
        costs.store(cost);
        places.store(place);
        std::array::from_fn(|i| (places.0[i], costs.0[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pixels::{Candidate, Exposure};

    const FREE: f32 = f32::INFINITY;

    /// Three tables' worth of two-beam films, noise, and every kind of pixel: whole, full, cut at 0, masked, none at all.
    fn picture() -> (Vec<PixelTable>, Vec<f32>, Vec<u8>, Vec<bool>) {
        let exposure = Exposure {
            gain: 2.0,
            haze: [0.01, 0.0, 0.02],
            noise: [[4e-7, 1e-5]; 3],
            unknown: 0.01,
            shading: 0.03,
            clip: [0.15, FREE, FREE],
            cut_at_zero: true,
            temper: 1.3,
            outlier: 1e-3,
        };
        let model = |tilt: f32| {
            [610.0_f32, 540.0, 460.0].map(|nm| -> Vec<f32> {
                let turn = |k: usize| (8.0 * std::f32::consts::PI * 1.33 * tilt * k as f32 / nm).cos();
                (0..333).map(|k| 0.04 * (1.0 - 0.9 * turn(k))).collect()
            })
        };
        let tables: Vec<PixelTable> =
            [1.0, 0.97].map(|tilt| PixelTable::new(3.0, 2.0, &model(tilt), &exposure).unwrap()).into();
        let (mut pixels, mut of, mut mask) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..171_usize {
            let table = i / 5 % 2;
            let (film, _) = tables[table].film_and_slope(2.9 * i as f32);
            let wobble = |c: usize| 1.0 + 0.02 * ((7 * i + 3 * c) as f32).sin();
            pixels.extend((0..3).map(|c| 2.0 * film[c] * wobble(c) + exposure.haze[c]));
            match i {
                20 => pixels[60] = f32::NAN,
                31 => pixels[94] = -1e-3,
                44 => pixels[132] = 0.2,
                _ => {}
            }
            of.push(table as u8);
            mask.push(i % 37 == 5);
        }
        (tables, pixels, of, mask)
    }

    /// The same minima as one pixel at a time has.
    #[test]
    fn sixteen_pixels_are_as_each_of_them() {
        let (tables, pixels, of, mask) = picture();
        let photograph = Photograph { pixels: &pixels, width: 19, table_of: Some(&of), mask: Some(&mask) };
        let found = all_candidates(&tables, &photograph, &Watch::new()).unwrap();
        let found: Vec<Candidates> = found.as_flattened()[..171].to_vec();
        let (mut scratch, mut several) = (vec![0.0; 333], 0);
        for (i, found) in found.iter().enumerate() {
            let mut wanted = [NONE; MOST];
            if !mask[i] {
                let pixel = [pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2]];
                tables[usize::from(of[i])].candidates(pixel, &mut scratch, &mut wanted);
            }
            let likely = |one: &&Candidate| one.likelihood > 1e-6;
            assert_eq!(found.iter().filter(likely).count(), wanted.iter().filter(likely).count(), "{i}");
            for (a, b) in found.iter().zip(&wanted).filter(|(a, _)| likely(a)) {
                let same = (a.thickness_nm - b.thickness_nm).abs() < 1e-2 && a.sd_nm == b.sd_nm;
                assert!(same && (a.likelihood / b.likelihood - 1.0).abs() < 2e-2, "{i}: {a:?} {b:?}");
            }
            several += usize::from(wanted[1].likelihood > 1e-6);
            assert!(wanted[0].likelihood > 0.0 || mask[i] || i == 20, "{i}");
        }
        assert!(several > 20, "{several}");
    }

    #[test]
    fn threads_change_no_bit() {
        let (tables, pixels, of, mask) = picture();
        let photograph = Photograph { pixels: &pixels, width: 19, table_of: Some(&of), mask: Some(&mask) };
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let found = pool.install(|| all_candidates(&tables, &photograph, &Watch::new()).unwrap());
            let bits = |one: &Candidate| [one.thickness_nm, one.likelihood, one.sd_nm].map(f32::to_bits);
            found.as_flattened().as_flattened().iter().map(bits).collect::<Vec<_>>()
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn a_stopped_watch_ends_it() {
        let (tables, pixels, of, _) = picture();
        let watch = Watch::new();
        watch.stop();
        let photograph = Photograph { pixels: &pixels, width: 19, table_of: Some(&of), mask: None };
        assert!(matches!(all_candidates(&tables, &photograph, &watch), Err(InverseError::Stopped(_))));
    }
}
