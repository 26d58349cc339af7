//! What the samples of a tile have added up to: all that a journal keeps of it, and all that its planes are made of.

use std::ops::Range;

use fearless_simd::{Level, Simd};
use iridesce_numerics::Watch;

use crate::camera::{MOST_TOGETHER, Ray};
use crate::failure::{describe, prepared_level};
use crate::framebuffer::{RenderError, TilePlanes};
use crate::geometry::{Best, PartTree};
use crate::integrator::{Finished, GROUP, Tracer};
use crate::prepare::Prepared;
use crate::refraction::shown;
use crate::sampler::{Choices, PixelSampler};
use crate::tiles::Rect;
use crate::variance::Estimator;

/// Numbers that are added up for every pixel: X, Y, Z, and the share of its rays that nothing bent or stopped.
const SUMS: usize = 4;

/// Share of a tile's mean Y below which a pixel's error counts as that of a pixel of this Y: beside bright ones eyes do not see it.
const DIM_SHARE: f64 = 0.1;

/// Sums over the samples so far.
#[derive(Debug, Clone, PartialEq)]
pub struct TileSums {
    /// Samples of each pixel.
    pub samples: u32,
    /// [`SUMS`] numbers a pixel, and those that were asked for beside them.
    sums: Vec<f64>,
    /// How many numbers that are.
    a_pixel: usize,
    spread: Spread,
    /// Some ray from the camera has met a surface.
    pub has_surface: bool,
}

/// What is known of the spread of Y.
#[derive(Debug, Clone, PartialEq)]
enum Spread {
    /// Mean Y of each pixel in each batch of so many samples, batch after batch.
    Batches(u32, Vec<Vec<f32>>),
    /// The variance of each pixel's mean.
    Variance(Vec<f32>),
}

impl TileSums {
    /// No samples yet.
    pub fn new(tile: Rect, extras: usize) -> TileSums {
        let a_pixel = SUMS + extras;
        let sums = vec![0.0; a_pixel * tile.pixels()];
        TileSums { samples: 0, sums, a_pixel, spread: Spread::Batches(0, Vec::new()), has_surface: false }
    }

    /// Bytes of a pixel whose spread is known by so many batches.
    pub const fn bytes_per_pixel(batches: usize, extras: usize) -> u64 {
        ((SUMS + extras) * size_of::<f64>() + batches * size_of::<f32>()) as u64
    }

    /// Adds `samples` more to every pixel, in batches of `size`. [`RenderError::Cancelled`] within 1024 samples of the watch
    /// saying so; the sums are then of no use.
    pub fn add(
        &mut self,
        level: Level,
        scene: &Prepared,
        tile: Rect,
        batches: [u32; 2],
        watch: &Watch,
    ) -> Result<(), RenderError> {
        // The one place where the paths of light are compiled for each level: a second one doubles the time of a build.
        at_level!(level, simd => self.add_with(simd, scene, tile, batches, watch))
    }

    #[inline(always)]
    fn add_with<S: Simd>(
        &mut self,
        simd: S,
        scene: &Prepared,
        tile: Rect,
        [samples, size]: [u32; 2],
        watch: &Watch,
    ) -> Result<(), RenderError> {
        let (first, whole) = (self.samples, (samples / size) as usize);
        let mut batches = vec![vec![0.0_f32; tile.pixels()]; whole];
        // One tracer a level of spectra; most tiles need the first only.
        let mut tracers: Vec<Option<Tracer<'_>>> = scene.levels.iter().map(|_| None).collect();
        let tree = scene.geometry.tree();
        let mut ahead = tree.map(|tree| CameraRays::new(scene, tree, tile, first..first + samples));
        for (pixel, sums) in self.sums.chunks_exact_mut(self.a_pixel).enumerate() {
            let rays = PixelRays::new(scene, tile, pixel);
            // A pixel that shows finer fringes than its spectra resolve starts again with finer ones.
            let mut level = 0;
            let tracer = loop {
                let tracer = tracers[level].get_or_insert_with(|| Tracer::new(scene, level));
                for sample in 0..samples {
                    // Not once a pixel: a pixel of a million samples takes seconds.
                    if sample % 1024 == 0 && watch.is_stopped() {
                        return Err(RenderError::Cancelled);
                    }
                    tracer.begin_batch((sample / size) as usize);
                    let is_shared = scene.is_sparse && sample - sample % GROUP + GROUP <= samples;
                    tracer.begin_sample(is_shared.then_some(sample % GROUP == 0));
                    let (ray, hit, mut choices);
                    if let Some(ahead) = &mut ahead {
                        let at = ahead.place_of(simd, pixel, first + sample);
                        let found = ahead.found[at].as_ref();
                        ray = ahead.rays[at];
                        if found.is_some_and(|best| tracer.sees_emitter(simd, &ray, ahead.tree.object(best))) {
                            continue;
                        }
                        hit = found.map(|best| ahead.tree.hit(&ray, best));
                        choices = ahead.choices[at].clone();
                    } else {
                        (ray, choices) = rays.of(scene, first + sample);
                        hit = scene.geometry.nearest(&ray, None);
                        if hit.as_ref().is_some_and(|hit| tracer.sees_emitter(simd, &ray, hit.object)) {
                            continue;
                        }
                    }
                    if !tracer.trace(simd, ray, hit, &mut choices) {
                        break;
                    }
                }
                self.has_surface |= tracer.has_met_surface();
                match tracer.finish(simd).map_err(|failure| describe(scene, failure))? {
                    Finished::Whole => break tracers[level].as_mut(),
                    Finished::NeedsLevel(finer) => level = prepared_level(scene, finer)?,
                }
            };
            let Some(tracer) = tracer else { unreachable!("it has just traced") };
            tracer.take_extras(&mut sums[SUMS..]);
            // Samples beyond the last whole batch have one of their own, which says nothing of the spread.
            for batch in 0..=whole {
                let own = tracer.take_batch(batch);
                for (sum, part) in sums.iter_mut().zip(own) {
                    *sum += part;
                }
                if let Some(means) = batches.get_mut(batch) {
                    means[pixel] = (own[1] / f64::from(size)) as f32;
                }
            }
        }
        self.samples += samples;
        if let Spread::Batches(own_size, own) = &mut self.spread {
            *own_size = size;
            own.extend(batches);
        }
        Ok(())
    }

    /// Joins neighbouring batches into ones of twice the size.
    pub fn join_batches(&mut self) {
        let Spread::Batches(size, batches) = &mut self.spread else { return };
        *size *= 2;
        let joined = batches.chunks_exact(2).map(|pair| {
            pair[0].iter().zip(&pair[1]).map(|(a, b)| (0.5 * (f64::from(*a) + f64::from(*b))) as f32).collect()
        });
        *batches = joined.collect();
    }

    /// How many batches there are.
    pub fn batches(&self) -> usize {
        match &self.spread {
            Spread::Batches(_, batches) => batches.len(),
            Spread::Variance(_) => 0,
        }
    }

    /// Samples of a batch, once there is one.
    pub fn batch_size(&self) -> Option<u32> {
        match &self.spread {
            Spread::Batches(size, _) if *size > 0 => Some(*size),
            _ => None,
        }
    }

    /// No more samples will come: of the batches only what they say is kept.
    pub fn close(&mut self) {
        self.spread = Spread::Variance(self.variance());
    }

    /// Variance of each pixel's mean Y.
    pub fn variance(&self) -> Vec<f32> {
        match &self.spread {
            Spread::Variance(variance) => variance.clone(),
            Spread::Batches(size, batches) => self.variance_of_batches(*size, batches).collect(),
        }
    }

    fn variance_of_batches(&self, size: u32, batches: &[Vec<f32>]) -> impl Iterator<Item = f32> {
        // Samples that are in no batch count as if they had the same spread.
        let counted = f64::from(size) * batches.len() as f64;
        let share = (counted / f64::from(self.samples.max(1))) as f32;
        let estimator = Estimator::new(batches.len());
        let mut means = vec![0.0; batches.len()];
        (0..self.sums.len() / self.a_pixel).map(move |pixel| {
            means.iter_mut().zip(batches).for_each(|(mean, batch)| *mean = f64::from(batch[pixel]));
            share * estimator.variance_of_mean(&mut means)
        })
    }

    /// Whether nine tenths of the pixels are known to this relative error of Y; of those darker than [`DIM_SHARE`] of the
    /// tile's mean it is relative to that. If so, no more samples may come.
    pub fn settle(&mut self, error: f64) -> bool {
        let Spread::Batches(size, batches) = &self.spread else { return false };
        if batches.len() < 2 {
            return false;
        }
        let pixels = self.sums.len() / self.a_pixel;
        let dim = DIM_SHARE * self.mean_y().sum::<f64>() / pixels as f64;
        let (mut variance, mut noisy) = (Vec::with_capacity(pixels), 0);
        for (own, y) in self.variance_of_batches(*size, batches).zip(self.mean_y()) {
            noisy += usize::from(f64::from(own).sqrt() > error * y.max(dim));
            if 10 * noisy > pixels {
                return false;
            }
            variance.push(own);
        }
        self.spread = Spread::Variance(variance);
        true
    }

    /// Mean Y of each pixel.
    pub fn mean_y(&self) -> impl Iterator<Item = f64> {
        let samples = f64::from(self.samples.max(1));
        self.sums.chunks_exact(self.a_pixel).map(move |sums| sums[1] / samples)
    }

    /// The planes of the tile. Those beside the colours hold what the ray through the pixel's centre meets first: a mean of
    /// depths is no depth.
    pub fn planes(&self, scene: &Prepared, tile: Rect) -> TilePlanes {
        let samples = f64::from(self.samples.max(1));
        let mut planes = TilePlanes {
            samples: self.samples,
            variance: self.variance(),
            has_surface: self.has_surface,
            ..TilePlanes::default()
        };
        let mean = |sum: &f64| (sum / samples) as f32;
        let [natural, q, u, _] = scene.camera.passes();
        for (pixel, sums) in self.sums.chunks_exact(self.a_pixel).enumerate() {
            let mut extras = &sums[SUMS..];
            if scene.stokes {
                for c in 0..3 {
                    let [s1, s2, s3] = [0, 3, 6].map(|row| extras[row + c]);
                    // The picture's own sums are of what passes the polariser; the light before it is wanted.
                    let s0 = (sums[c] - q * s1 - u * s2) / natural;
                    planes.stokes.extend([s0, s1, s2, s3].iter().map(mean));
                }
                extras = &extras[9..];
            }
            planes.spectra.extend(extras.iter().map(mean));
            planes.xyz.extend(sums[..3].iter().map(|sum| (sum / samples) as f32));
            planes.alpha.push((1.0 - sums[3] / samples) as f32);
            let (x, y) = place(tile, pixel);
            let centre = scene.camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let hit = scene.geometry.nearest(&centre, None);
            let film = hit.and_then(|hit| shown(scene, centre, hit));
            planes.has_surface |= hit.is_some();
            planes.depth.push(hit.map_or(f32::INFINITY, |hit| hit.distance as f32));
            planes.object.push(hit.map_or(-1, |hit| hit.object as i32));
            planes.thickness_nm.push(film.map_or(f32::NAN, |film| film.thickness_nm as f32));
            planes.path_difference_nm.push(film.map_or(f32::NAN, |film| film.path_difference_nm as f32));
            planes
                .normal
                .extend(hit.map_or([0.0; 3], |hit| [hit.normal.x, hit.normal.y, hit.normal.z].map(|v| v as f32)));
        }
        planes
    }

    /// As a journal keeps it: little-endian, samples, batch size, number of batches, sums, then batches or variance.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let (size, count) = match &self.spread {
            Spread::Batches(size, batches) => (*size, batches.len() as u32),
            Spread::Variance(_) => (0, 0),
        };
        [self.samples, size, count].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        self.sums.iter().for_each(|sum| bytes.extend(sum.to_le_bytes()));
        let mut add = |values: &[f32]| values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
        match &self.spread {
            Spread::Batches(_, batches) => batches.iter().for_each(|batch| add(batch)),
            Spread::Variance(variance) => add(variance),
        }
        bytes
    }

    /// What [`TileSums::to_bytes`] wrote; `None` where it is not of this tile.
    pub fn from_bytes(bytes: &[u8], tile: Rect, extras: usize) -> Option<TileSums> {
        let a_pixel = SUMS + extras;
        let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
        let (samples, size, count) = (number(0)?, number(4)?, number(8)? as usize);
        let pixels = tile.pixels();
        let sums_end = 12 + 8 * a_pixel * pixels;
        let sums = bytes.get(12..sums_end)?.chunks_exact(8).map(|v| v.try_into().map(f64::from_le_bytes));
        let rest = bytes.get(sums_end..)?.chunks_exact(4).map(|v| v.try_into().map(f32::from_le_bytes));
        let rest: Vec<f32> = rest.collect::<Result<_, _>>().ok()?;
        let is_closed = size == 0;
        if rest.len() != pixels * if is_closed { 1 } else { count } || samples == 0 {
            return None;
        }
        let spread = if is_closed {
            Spread::Variance(rest)
        } else {
            Spread::Batches(size, rest.chunks_exact(pixels).map(<[f32]>::to_vec).collect())
        };
        // What a journal does not tell counts as seen.
        Some(TileSums { samples, sums: sums.collect::<Result<_, _>>().ok()?, a_pixel, spread, has_surface: true })
    }
}

/// The rays of a pixel from the camera.
struct PixelRays {
    sampler: PixelSampler,
    x: f64,
    y: f64,
}

impl PixelRays {
    #[inline(always)]
    fn new(scene: &Prepared, tile: Rect, pixel: usize) -> PixelRays {
        let (x, y) = place(tile, pixel);
        let sampler = PixelSampler::new(scene.seed, u64::from(y) << 32 | u64::from(x));
        PixelRays { sampler, x: f64::from(x), y: f64::from(y) }
    }

    /// That of a sample, with the random numbers of the path that begins there.
    #[inline(always)]
    fn of(&self, scene: &Prepared, sample: u32) -> (Ray, Choices) {
        let (dx, dy) = self.sampler.point(sample);
        let mut choices = self.sampler.choices(sample);
        (scene.camera.ray_through_lens(self.x + dx, self.y + dy, &mut choices), choices)
    }
}

/// Camera rays whose hits are found together, ahead of the paths that begin with them: those of the samples of a tile, pixel after pixel.
struct CameraRays<'a> {
    scene: &'a Prepared,
    tree: &'a PartTree,
    tile: Rect,
    samples: Range<u32>,
    /// The first of those that are known, counted over the tile.
    first: usize,
    rays: Vec<Ray>,
    choices: Vec<Choices>,
    found: [Option<Best>; MOST_TOGETHER],
    /// So many pixels are not tried as bundles.
    loose: u32,
}

impl<'a> CameraRays<'a> {
    /// Pixels after one that shows too much for a bundle which most probably do, too.
    const LOOSE: u32 = 7;

    fn new(scene: &'a Prepared, tree: &'a PartTree, tile: Rect, samples: Range<u32>) -> CameraRays<'a> {
        let found = [None; MOST_TOGETHER];
        CameraRays { scene, tree, tile, samples, first: 0, rays: Vec::new(), choices: Vec::new(), found, loose: 0 }
    }

    /// Where the ray of a sample of a pixel stands in the lists, together with what it meets.
    #[inline(always)]
    fn place_of<S: Simd>(&mut self, simd: S, pixel: usize, sample: u32) -> usize {
        let number = pixel * self.samples.len() + (sample - self.samples.start) as usize;
        if number < self.first || number >= self.first + self.rays.len() {
            self.find(simd, number);
        }
        number - self.first
    }

    /// Finds what the rays from one on meet.
    #[inline(never)]
    fn find<S: Simd>(&mut self, simd: S, number: usize) {
        let a_pixel = self.samples.len();
        let last = (number + MOST_TOGETHER).min(self.tile.pixels() * a_pixel);
        self.first = number;
        self.rays.clear();
        self.choices.clear();
        let has_lens = self.scene.camera.has_lens();
        let mut at = number;
        while at < last {
            let end = last.min(at - at % a_pixel + a_pixel);
            simd.vectorize(
                #[inline(always)]
                || self.draw(at..end),
            );
            if !has_lens {
                let own = at - number..end - number;
                let is_bundle = self.loose == 0;
                let (rays, found) = (&self.rays[own.clone()], &mut self.found[own]);
                let was_quick = self.tree.nearest_each_alike(rays, None, is_bundle, found);
                self.loose = if was_quick { self.loose.saturating_sub(1) } else { Self::LOOSE };
            }
            at = end;
        }
        if has_lens {
            self.tree.nearest_each(&self.rays, None, &mut self.found);
        }
    }

    /// Adds the rays of some samples of a pixel.
    #[inline(always)]
    fn draw(&mut self, numbers: Range<usize>) {
        let a_pixel = self.samples.len();
        let pixel = PixelRays::new(self.scene, self.tile, numbers.start / a_pixel);
        let first = self.samples.start + (numbers.start % a_pixel) as u32;
        let (mut x, mut y) = ([0.0; MOST_TOGETHER], [0.0; MOST_TOGETHER]);
        let (x, y) = (&mut x[..numbers.len()], &mut y[..numbers.len()]);
        pixel.sampler.points(first, x, y);
        for (x, y) in x.iter_mut().zip(&mut *y) {
            (*x, *y) = (pixel.x + *x, pixel.y + *y);
        }
        let known = self.choices.len();
        self.choices.extend((first..).take(numbers.len()).map(|sample| pixel.sampler.choices(sample)));
        self.scene.camera.rays_through_lens(x, y, &mut self.choices[known..], &mut self.rays);
    }
}

/// Column and row of a tile's pixel in the whole picture.
#[inline(always)]
fn place(tile: Rect, pixel: usize) -> (u32, u32) {
    let pixel = pixel as u32;
    (tile.x + pixel % tile.width, tile.y + pixel / tile.width)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: Rect = Rect { x: 3, y: 4, width: 2, height: 3 };

    fn sums() -> TileSums {
        let batches = (0..4).map(|batch| (0..6).map(|pixel| ((batch * 7 + pixel) % 5) as f32).collect()).collect();
        let sums = (0..24).map(|i| f64::from(i) / 7.0).collect();
        TileSums { samples: 9, sums, a_pixel: 4, spread: Spread::Batches(2, batches), has_surface: true }
    }

    #[test]
    fn bytes_bring_a_tile_back() {
        let mut sums = sums();
        for _ in 0..2 {
            let bytes = sums.to_bytes();
            assert_eq!(TileSums::from_bytes(&bytes, TILE, 0), Some(sums.clone()));
            assert_eq!(TileSums::from_bytes(&bytes, TILE, 1), None);
            assert_eq!(TileSums::from_bytes(&bytes, Rect { width: 3, ..TILE }, 0), None);
            for cut in 0..bytes.len() {
                assert_eq!(TileSums::from_bytes(&bytes[..cut], TILE, 0), None);
            }
            sums.close();
        }
    }

    #[test]
    fn joined_batches_have_the_same_mean() {
        let mut joined = sums();
        joined.join_batches();
        let Spread::Batches(size, batches) = &joined.spread else { panic!("closed") };
        assert_eq!((*size, batches.len()), (4, 2));
        assert_eq!(batches[0], [1.0, 2.0, 3.0, 1.5, 2.5, 1.0]);
        // Eight of nine samples are in batches.
        let variance = sums().variance();
        assert!((variance[0] / Estimator::new(4).variance_of_mean(&mut [0.0, 2.0, 4.0, 1.0]) - 8.0 / 9.0).abs() < 1e-6);
    }
}
