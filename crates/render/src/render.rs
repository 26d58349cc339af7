//! The whole picture: tiles on all cores, one SIMD dispatch a tile, the same bytes for any number of threads.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use fearless_simd::Level;
use iridesce_files::{NoAnswer, aside};
use iridesce_numerics::{Watch, simd};
use iridesce_scene::{ResolvedScene, Scene};
use rayon::prelude::*;

use crate::caustics;
use crate::framebuffer::{Framebuffer, KeepOptions, RenderError, RenderInfo, RenderOptions};
use crate::integrator::extras::Extras;
use crate::keep::Keeper;
use crate::passes::{self, draw_passes};
use crate::prepare::Prepared;
use crate::spectral::{FROM_NM, TO_NM};
use crate::tile_sums::TileSums;
use crate::tiles::{Rect, Shard, tiles};
use crate::variance::batch_size;

/// Batches of a pixel between two looks at whether its tile has settled: of fewer than four the error is too uncertain, and four
/// samples of the net are stratified both ways.
const SETTLING_BATCHES: u32 = 4;

/// Renders a scene. Deterministic: the same scene, options and SIMD level give the same bytes for any `threads`, and for
/// any number of kills and new starts with the same journal (`keep`); but where time says when it is done.
///
/// Errors: [`RenderError::Argument`] for options outside their range, [`RenderError::Resource`] for pictures or
/// films that cannot fit, [`RenderError::Optics`] for media without data in 360..830 nm, [`RenderError::File`] for a journal
/// that cannot be read or written, and [`RenderError::Cancelled`] within 1024 samples of the watch saying so, which hears of
/// pixels in the stage `rendering`.
pub fn render(
    scene: &ResolvedScene,
    options: &RenderOptions,
    keep: Option<&KeepOptions>,
    watch: &Watch,
) -> Result<Framebuffer, RenderError> {
    let level = simd::level().map_err(|error| RenderError::Argument(error.to_string()))?;
    render_at(level, scene, options, keep, watch)
}

/// Refuses options outside their range and pictures that cannot fit, before a scene is resolved.
pub fn check(scene: &Scene, options: &RenderOptions) -> Result<(), RenderError> {
    let refuse = |message: String| Err(RenderError::Argument(message));
    let samples = options.samples.unwrap_or(scene.render.samples);
    if samples == 0 || samples > RenderOptions::MAX_SAMPLES {
        return refuse(format!("samples must be 1 to {}, got {samples}", RenderOptions::MAX_SAMPLES));
    }
    let size @ [width, height] = options.size.unwrap_or(scene.camera.resolution);
    let part = options.part(size);
    let ends = [u64::from(part.x) + u64::from(part.width), u64::from(part.y) + u64::from(part.height)];
    if options.crop.is_some() && (part.pixels() == 0 || ends[0] > u64::from(width) || ends[1] > u64::from(height)) {
        return refuse(format!(
            "crop must be (x, y, width, height) of at least one pixel within the picture of {width} x {height}, got ({}, {}, {}, {})",
            part.x, part.y, part.width, part.height
        ));
    }
    for (name, value) in [("until", options.until), ("time_s", options.time_s), ("settled", options.settled)] {
        if let Some(value) = value.filter(|value| !(*value > 0.0 && value.is_finite())) {
            return refuse(format!("{name} must be a positive number, got {value}"));
        }
    }
    if let Some(Shard { number, of }) = options.shard {
        if !(1..=Shard::MOST).contains(&of) || !(1..=of).contains(&number) {
            return refuse(format!("a shard is I of N, 1 <= I <= N <= {}, got {number} of {of}", Shard::MOST));
        }
        if options.has_passes() {
            return refuse("a shard has a fixed number of samples: until and time_s judge the whole picture".into());
        }
    }
    if options.spectral_nm.len() > RenderOptions::MOST_WAVELENGTHS {
        return refuse(format!(
            "spectral_nm must be {} wavelengths at most, got {}",
            RenderOptions::MOST_WAVELENGTHS,
            options.spectral_nm.len()
        ));
    }
    let is_ascending = options.spectral_nm.windows(2).all(|pair| pair[0] < pair[1]);
    let outside = options.spectral_nm.iter().find(|nm| !(FROM_NM..=TO_NM).contains(*nm));
    if let (Some(nm), _) | (None, Some(nm)) = (outside, options.spectral_nm.first().filter(|_| !is_ascending)) {
        return refuse(format!(
            "spectral_nm must ascend from {FROM_NM} to {TO_NM} nm at most, got {nm}{}",
            if outside.is_none() { " and others out of order" } else { "" }
        ));
    }
    let extras = Extras::count(options.stokes, options.spectral_nm.len());
    let planes = 2 * size_of::<f32>() as u64 * (extras + if options.stokes { 3 } else { 0 }) as u64;
    let passes = if options.has_passes() { TileSums::bytes_per_pixel(passes::MOST, extras) } else { 0 };
    let besides = planes + passes;
    Framebuffer::check_size(part.width, part.height, besides)
}

/// [`render`] at a SIMD level of the caller's choice, which the machine must have (tests compare levels).
pub fn render_at(
    level: Level,
    scene: &ResolvedScene,
    options: &RenderOptions,
    keep: Option<&KeepOptions>,
    watch: &Watch,
) -> Result<Framebuffer, RenderError> {
    check(&scene.recipe, options)?;
    match options.threads {
        None => draw(level, scene, options, keep, watch),
        Some(0) => Err(RenderError::Argument("threads must be at least 1, got 0".into())),
        Some(threads) => {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|e| RenderError::Resource(format!("cannot start {threads} threads: {e}")))?;
            pool.install(|| draw(level, scene, options, keep, watch))
        }
    }
}

/// [`Prepared`] that can be stopped: the hierarchy of a mesh of millions of triangles takes seconds.
fn prepared(scene: &ResolvedScene, options: &RenderOptions, watch: &Watch) -> Result<Prepared, RenderError> {
    if (0..scene.recipe.objects.len()).all(|object| scene.mesh(object).is_none()) {
        return with_seeds(scene, options);
    }
    let (scene, options, threads) = (scene.clone(), options.clone(), rayon::current_num_threads());
    let no_thread =
        |why: &dyn std::fmt::Display| RenderError::Resource(format!("cannot start {threads} threads: {why}"));
    // Whoever is left behind keeps no thread of the caller's pool.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| no_thread(&error))?;
    aside(watch, move || pool.install(|| with_seeds(&scene, &options))).unwrap_or_else(|none| match none {
        NoAnswer::Stopped => Err(RenderError::Cancelled),
        NoAnswer::NoThread(why) => Err(no_thread(&why)),
        NoAnswer::Panicked => panic!("a scene could not be prepared"),
    })
}

fn with_seeds(scene: &ResolvedScene, options: &RenderOptions) -> Result<Prepared, RenderError> {
    let mut prepared = Prepared::new(scene, options)?;
    prepared.seeds = caustics::seeds(&prepared);
    Ok(prepared)
}

fn draw(
    level: Level,
    scene: &ResolvedScene,
    options: &RenderOptions,
    keep: Option<&KeepOptions>,
    watch: &Watch,
) -> Result<Framebuffer, RenderError> {
    let start = Instant::now();
    let prepared = prepared(scene, options, watch)?;
    let part = prepared.part;
    let info = RenderInfo {
        samples: prepared.samples,
        seed: prepared.seed,
        seconds: 0.0,
        simd: simd::name(level).to_owned(),
        threads: rayon::current_num_threads(),
    };
    let mut frame = Framebuffer::empty(part.width, part.height, prepared.has_alpha, info)?;
    let spectral = prepared.wavelengths * if prepared.stokes { 4 } else { 1 };
    frame.add_extras(prepared.stokes, spectral)?;
    let all = tiles(part);
    let (keeper, found) = match keep {
        None => (None, all.iter().map(|_| None).collect()),
        Some(keep) => Keeper::new(keep, start, &all, prepared.extras).map(|(keeper, found)| (Some(keeper), found))?,
    };
    let own = all.into_iter().zip(found).enumerate();
    let own = own.filter(|(number, _)| options.shard.is_none_or(|shard| shard.has(*number)));
    let own: Vec<(usize, Rect, Option<TileSums>)> = own.map(|(number, (tile, found))| (number, tile, found)).collect();
    if options.has_passes() {
        let begun = |(number, tile, found): (usize, Rect, Option<TileSums>)| {
            (number, tile, found.unwrap_or_else(|| TileSums::new(tile, prepared.extras)))
        };
        let mut own: Vec<(usize, Rect, TileSums)> = own.into_iter().map(begun).collect();
        draw_passes(level, &prepared, options, &mut own, keeper, start, watch)?;
        frame.info.samples = own.iter().map(|tile| tile.2.samples).max().unwrap_or(0);
        let frame = Mutex::new(&mut frame);
        own.into_par_iter().for_each(|(_, tile, sums)| {
            let planes = sums.planes(&prepared, tile);
            let mut frame = frame.lock().unwrap_or_else(PoisonError::into_inner);
            frame.put(tile.x - part.x, tile.y - part.y, tile, &planes);
        });
    } else {
        draw_once(level, &prepared, own, keeper, options.settled, &mut frame, watch)?;
    }
    frame.info.seconds = start.elapsed().as_secs_f64();
    Ok(frame)
}

/// Draws each tile with all its samples, or as many as it takes to settle; those that are found are whole already.
fn draw_once(
    level: Level,
    scene: &Prepared,
    tiles: Vec<(usize, Rect, Option<TileSums>)>,
    keeper: Option<Keeper<'_>>,
    settled: Option<f64>,
    frame: &mut Framebuffer,
    watch: &Watch,
) -> Result<(), RenderError> {
    watch.begin("rendering", tiles.iter().map(|tile| tile.1.pixels() as u64).sum());
    let (samples, size, part) = (scene.samples, batch_size(scene.samples), scene.part);
    let pass = if settled.is_some() { SETTLING_BATCHES * size } else { samples };
    let sink = Mutex::new((frame, keeper));
    tiles.into_par_iter().try_for_each(|(number, tile, found)| {
        let is_new = found.is_none();
        let sums = match found {
            Some(sums) => sums,
            None => {
                let mut sums = TileSums::new(tile, scene.extras);
                while sums.samples < samples && !settled.is_some_and(|error| sums.settle(error)) {
                    let more = pass.min(samples - sums.samples);
                    sums.add(level, scene, tile, [more, size], watch)?;
                }
                sums.close();
                sums
            }
        };
        let planes = sums.planes(scene, tile);
        let mut sink = sink.lock().unwrap_or_else(PoisonError::into_inner);
        let (frame, keeper) = &mut *sink;
        frame.put(tile.x - part.x, tile.y - part.y, tile, &planes);
        if let (true, Some(keeper)) = (is_new, keeper) {
            keeper.add(number, &sums)?;
        }
        watch.add(tile.pixels() as u64);
        Ok::<(), RenderError>(())
    })
}

/// The name of the SIMD level that renders use and record: the widest of this machine, or what `IRIDESCE_SIMD` caps it at.
pub fn simd_level() -> &'static str {
    simd::name(simd::level_or_best())
}
