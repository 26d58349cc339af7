//! Renders that tell themselves when they are done: passes of samples over the whole picture.
//!
//! After each pass every pixel has one batch of samples more; of [`MOST`] batches neighbours are joined, and passes are twice
//! as large from then on. So a picture has between 4 and 32 passes' worth of batches at any time, and goes on for a 16th of
//! its samples too long at most.

use std::time::{Duration, Instant};

use fearless_simd::Level;
use iridesce_numerics::Watch;
use rayon::prelude::*;

use crate::framebuffer::{RenderError, RenderOptions};
use crate::keep::Keeper;
use crate::prepare::Prepared;
use crate::tile_sums::TileSums;
use crate::tiles::Rect;

/// Most batches that are kept of a pixel.
pub const MOST: usize = 32;
/// Fewest passes before anything is judged.
const LEAST: usize = 4;
/// Samples of the first passes: of fewer the error is too uncertain to stop at.
const FIRST: u32 = 4;
/// Time between two journals, s, and at least so many times what writing one takes.
const KEEP_EVERY_S: f64 = 10.0;
const KEEP_SHARE: f64 = 20.0;
/// Share of the mean Y below which a pixel's error counts as that of a pixel of this Y: eyes do not see noise in black.
const DARK_SHARE: f64 = 0.01;

/// Draws tiles in passes; those with samples go on from there.
pub fn draw_passes(
    level: Level,
    scene: &Prepared,
    options: &RenderOptions,
    tiles: &mut [(usize, Rect, TileSums)],
    mut keeper: Option<Keeper<'_>>,
    start: Instant,
    watch: &Watch,
) -> Result<(), RenderError> {
    let most = options.samples.unwrap_or(RenderOptions::MAX_SAMPLES);
    let pixels: u64 = tiles.iter().map(|tile| tile.1.pixels() as u64).sum();
    // With little time a scene may be too slow for more.
    let first = if options.time_s.is_some() { 1 } else { FIRST };
    let mut kept = (Instant::now(), Duration::ZERO);
    watch.begin("rendering", pixels * LEAST as u64);
    let (mut passes, mut pass_s) = (0_u64, 0.0);
    let mut error = f64::INFINITY;
    loop {
        // (A journal may be of a time in the middle of a pass: each tile knows how far it is.)
        let behind = tiles.iter().map(|tile| tile.2.samples).min().unwrap_or(most);
        let batches = tiles.iter().map(|tile| tile.2.batches()).min().unwrap_or(0);
        let elapsed = start.elapsed().as_secs_f64();
        let is_over = |time_s: f64| elapsed + pass_s > time_s;
        if behind >= most || batches >= LEAST && passes > 0 && options.time_s.is_some_and(is_over) {
            break;
        }
        if batches >= LEAST
            && let Some(until) = options.until
        {
            error = relative_error(tiles);
            if error < until {
                break;
            }
        }
        let ahead = expected_passes(options, batches, error, elapsed, pass_s);
        watch.expect(pixels * (passes + ahead.clamp(1, 1 << 32)));
        let began = Instant::now();
        tiles.par_iter_mut().try_for_each(|(_, tile, sums)| {
            if sums.batches() >= MOST {
                sums.join_batches();
            }
            let size = sums.batch_size().unwrap_or(first);
            let samples = size.min(most - sums.samples.min(most));
            if samples > 0 {
                sums.add(level, scene, *tile, [samples, size], watch)?;
            }
            watch.add(tile.pixels() as u64);
            Ok::<(), RenderError>(())
        })?;
        passes += 1;
        pass_s = began.elapsed().as_secs_f64();
        if let Some(keeper) = &mut keeper
            && kept.0.elapsed().as_secs_f64() >= KEEP_EVERY_S.max(KEEP_SHARE * kept.1.as_secs_f64())
        {
            let began = Instant::now();
            keeper.replace(tiles)?;
            kept = (Instant::now(), began.elapsed());
        }
    }
    watch.expect(pixels * passes.max(1));
    Ok(())
}

/// How many passes are still to come, for a bar.
fn expected_passes(options: &RenderOptions, batches: usize, error: f64, elapsed: f64, pass_s: f64) -> u64 {
    let by_time = options.time_s.filter(|_| pass_s > 0.0).map(|time_s| (time_s - elapsed) / pass_s);
    // As if samples were independent of one another.
    let by_error =
        options.until.filter(|_| error.is_finite()).map(|until| batches as f64 * ((error / until).powi(2) - 1.0));
    let ahead = by_time.unwrap_or(f64::INFINITY).min(by_error.unwrap_or(f64::INFINITY));
    let least = LEAST.saturating_sub(batches) as f64;
    if ahead.is_finite() { ahead.max(least).ceil() as u64 } else { least.max(1.0) as u64 }
}

/// Median of sigma(Y) / max(Y, 1 % of the mean Y) over the pixels whose sigma is not 0; 0 if there are none.
fn relative_error(tiles: &[(usize, Rect, TileSums)]) -> f64 {
    let (sum, count) = tiles.iter().flat_map(|tile| tile.2.mean_y()).fold((0.0, 0_u64), |(s, n), y| (s + y, n + 1));
    let dark = DARK_SHARE * sum / count.max(1) as f64;
    let mut errors: Vec<f64> = tiles
        .par_iter()
        .flat_map_iter(|(_, _, sums)| {
            let sigma = sums.variance().into_iter().map(|variance| f64::from(variance).sqrt());
            let pairs: Vec<(f64, f64)> = sigma.zip(sums.mean_y()).collect();
            pairs.into_iter().filter(|(sigma, _)| *sigma > 0.0).map(move |(sigma, y)| sigma / y.max(dark))
        })
        .collect();
    if errors.is_empty() {
        return 0.0;
    }
    let middle = errors.len() / 2;
    *errors.select_nth_unstable_by(middle, f64::total_cmp).1
}
