//! The whole picture: rows on all cores, one SIMD dispatch a row, the same bytes for any number of threads.

use std::time::Instant;

use fearless_simd::{Level, Simd, dispatch};
use iridesce_numerics::{Watch, simd};
use iridesce_scene::{ResolvedScene, Scene};
use rayon::prelude::*;

use crate::failure::{PathFailure, describe};
use crate::framebuffer::{Framebuffer, RenderError, RenderInfo, RenderOptions};
use crate::integrator::Tracer;
use crate::prepare::Prepared;
use crate::refraction::shown_thickness_nm;
use crate::sampler::PixelSampler;

/// Renders a scene. Deterministic: the same scene, options and SIMD level give the same bytes for any `threads`.
///
/// Errors: [`RenderError::Argument`] for options outside their range, [`RenderError::Resource`] for pictures or
/// films that cannot fit, [`RenderError::Optics`] for media without data in 360..830 nm, and
/// [`RenderError::Cancelled`] within 1024 samples of the watch saying so, which hears of pixels in the stage `rendering`.
pub fn render(scene: &ResolvedScene, options: &RenderOptions, watch: &Watch) -> Result<Framebuffer, RenderError> {
    let level = simd::level().map_err(|error| RenderError::Argument(error.to_string()))?;
    render_at(level, scene, options, watch)
}

/// Refuses options outside their range and pictures that cannot fit, before a scene is resolved.
pub fn check(scene: &Scene, options: &RenderOptions) -> Result<(), RenderError> {
    let samples = options.samples.unwrap_or(scene.render.samples);
    if samples == 0 || samples > RenderOptions::MAX_SAMPLES {
        return Err(RenderError::Argument(format!(
            "samples must be 1 to {}, got {samples}",
            RenderOptions::MAX_SAMPLES
        )));
    }
    let [width, height] = options.size.unwrap_or(scene.camera.resolution);
    Framebuffer::check_size(width, height)
}

/// [`render`] at a SIMD level of the caller's choice, which the machine must have (tests compare levels).
pub fn render_at(
    level: Level,
    scene: &ResolvedScene,
    options: &RenderOptions,
    watch: &Watch,
) -> Result<Framebuffer, RenderError> {
    check(&scene.recipe, options)?;
    match options.threads {
        None => draw(level, scene, options, watch),
        Some(0) => Err(RenderError::Argument("threads must be at least 1, got 0".into())),
        Some(threads) => {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|e| RenderError::Resource(format!("cannot start {threads} threads: {e}")))?;
            pool.install(|| draw(level, scene, options, watch))
        }
    }
}

/// One row of every plane.
struct Row<'a> {
    xyz: &'a mut [f32],
    depth: &'a mut [f32],
    thickness_nm: &'a mut [f32],
    normal: &'a mut [f32],
}

fn draw(
    level: Level,
    scene: &ResolvedScene,
    options: &RenderOptions,
    watch: &Watch,
) -> Result<Framebuffer, RenderError> {
    let start = Instant::now();
    let prepared = Prepared::new(scene, options)?;
    let (width, height) = (prepared.width, prepared.height);
    let info = RenderInfo {
        samples: prepared.samples,
        seed: prepared.seed,
        seconds: 0.0,
        simd: simd::name(level).to_owned(),
        threads: rayon::current_num_threads(),
    };
    let mut frame = Framebuffer::empty(width, height, info)?;
    let columns = width as usize;
    watch.begin("rendering", u64::from(width) * u64::from(height));
    (frame.xyz.par_chunks_mut(3 * columns))
        .zip(frame.depth.par_chunks_mut(columns))
        .zip(frame.thickness_nm.par_chunks_mut(columns))
        .zip(frame.normal.par_chunks_mut(3 * columns))
        .enumerate()
        .try_for_each(|(y, (((xyz, depth), thickness_nm), normal))| {
            let row = Row { xyz, depth, thickness_nm, normal };
            dispatch!(level, simd => draw_row(simd, &prepared, y as u32, row, watch))?;
            watch.add(u64::from(width));
            Ok::<(), RenderError>(())
        })?;
    frame.info.seconds = start.elapsed().as_secs_f64();
    Ok(frame)
}

#[inline(always)]
fn draw_row<S: Simd>(simd: S, scene: &Prepared, y: u32, row: Row<'_>, watch: &Watch) -> Result<(), RenderError> {
    // One tracer a level of spectra; most rows need the first only.
    let mut tracers: Vec<Option<Tracer<'_>>> = scene.levels.iter().map(|_| None).collect();
    for x in 0..scene.width {
        let sampler = PixelSampler::new(scene.seed, u64::from(y) << 32 | u64::from(x));
        // A pixel that shows finer fringes than its spectra resolve starts again with finer ones.
        let mut level = 0;
        let sum = loop {
            let tracer = tracers[level].get_or_insert_with(|| Tracer::new(scene, level));
            for sample in 0..scene.samples {
                // Not once a pixel: a pixel of a million samples takes seconds.
                if sample % 1024 == 0 && watch.is_stopped() {
                    return Err(RenderError::Cancelled);
                }
                let (dx, dy) = sampler.point(sample);
                let mut choices = sampler.choices(sample);
                let ray = scene.camera.ray_through_lens(f64::from(x) + dx, f64::from(y) + dy, &mut choices);
                if !tracer.trace(simd, ray, &mut choices) {
                    break;
                }
            }
            match tracer.take_xyz(simd) {
                Ok(sum) => break sum,
                Err(PathFailure::NeedsLevel(finer)) => level = finer,
                Err(failure) => return Err(describe(scene, failure)),
            }
        };
        let column = x as usize;
        for (out, sum) in row.xyz[3 * column..3 * column + 3].iter_mut().zip(sum) {
            *out = (sum / f64::from(scene.samples)) as f32;
        }
        // The other planes hold what the ray through the pixel's centre meets first: a mean of depths is no depth.
        let centre = scene.camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        if let Some(hit) = scene.geometry.nearest(&centre, None) {
            row.depth[column] = hit.distance as f32;
            if let Some(thickness_nm) = shown_thickness_nm(scene, centre, hit) {
                row.thickness_nm[column] = thickness_nm as f32;
            }
            for (out, value) in row.normal[3 * column..].iter_mut().zip([hit.normal.x, hit.normal.y, hit.normal.z]) {
                *out = value as f32;
            }
        }
    }
    Ok(())
}

/// The name of the SIMD level that renders use and record: the widest of this machine, or what `IRIDESCE_SIMD` caps it at.
pub fn simd_level() -> &'static str {
    simd::name(simd::level_or_best())
}
