//! What goes into a render and what comes out of it: plain values between the integrator and the image.

use std::path::PathBuf;

use iridesce_files::FileError;
use iridesce_optics::OpticsError;

use crate::tiles::{Rect, Shard};

/// What a caller may say about a render; `None` takes the scene's own value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RenderOptions {
    /// Camera rays per pixel, 1 to [`RenderOptions::MAX_SAMPLES`]; with `until` or `time_s` the most there may be.
    pub samples: Option<u32>,
    /// Seed of the sample pattern.
    pub seed: Option<u64>,
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
    /// Worker threads, at least 1; `None` uses rayon's own pool (all cores, or `RAYON_NUM_THREADS`).
    pub threads: Option<usize>,
    /// The part of the picture that is drawn: with a fixed number of samples the same bytes as there in the whole.
    pub crop: Option<Rect>,
    /// Passes of samples go on until the median relative error of Y is below this (`passes.rs`).
    pub until: Option<f64>,
    /// Passes of samples go on for so many seconds.
    pub time_s: Option<f64>,
    /// A tile takes no more samples once nine tenths of its pixels have a relative error of Y below this.
    pub settled: Option<f64>,
    /// Wavelengths at which radiance is asked for, nm, ascending.
    pub spectral_nm: Vec<f64>,
    /// Whether Stokes vectors are asked for.
    pub stokes: bool,
    /// The share of the tiles that is drawn; elsewhere `samples` and colours are 0.
    pub shard: Option<Shard>,
}

impl RenderOptions {
    /// The most camera rays per pixel: a thousand times what a clean picture needs, so more is a slip of the keyboard.
    pub const MAX_SAMPLES: u32 = 1 << 20;

    /// The most wavelengths of one render.
    pub const MOST_WAVELENGTHS: usize = 4096;

    /// Whether the picture tells when it is done.
    pub fn has_passes(&self) -> bool {
        self.until.is_some() || self.time_s.is_some()
    }

    /// The part of a picture of this size that is drawn.
    pub fn part(&self, [width, height]: [u32; 2]) -> Rect {
        self.crop.unwrap_or(Rect { x: 0, y: 0, width, height })
    }
}

/// Where a render keeps its finished tiles, so that another one can go on after it was killed.
#[derive(Debug, Clone, PartialEq)]
pub struct KeepOptions {
    /// The journal's file.
    pub path: PathBuf,
    /// Which render it is, in words of the caller's.
    pub head: Vec<u8>,
    /// Nothing is written before so many seconds.
    pub after_s: f64,
    /// Whether what the file holds already is taken over; it must have the same head.
    pub resume: bool,
}

/// How a render came about: enough, with the scene, to repeat it.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderInfo {
    /// Camera rays per pixel.
    pub samples: u32,
    /// Seed of the sample pattern.
    pub seed: u64,
    /// Wall time, s.
    pub seconds: f64,
    /// SIMD level, e.g. `avx2`; the same bytes are promised for the same level only.
    pub simd: String,
    /// Worker threads.
    pub threads: usize,
}

/// A finished picture, row 0 on top, all planes of `width * height` pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Framebuffer {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear relative XYZ, three floats a pixel: a white of radiance 1 has Y = 1. May be outside any gamut.
    pub xyz: Vec<f32>,
    /// Distance along the ray to the first surface, scene units; infinite where there is none.
    pub depth: Vec<f32>,
    /// Thickness of the first free film, also behind clear surfaces, or without one of the outermost layer of the first
    /// coating, nm; NaN off them.
    pub thickness_nm: Vec<f32>,
    /// Optical path difference 2 n t cos(theta) in that film or layer at 560 nm, nm; NaN off them.
    pub path_difference_nm: Vec<f32>,
    /// Unit normal of the first surface, world axes, three floats a pixel; zero where there is none.
    pub normal: Vec<f32>,
    /// Place of the first object in the scene's list; -1 where there is none.
    pub object: Vec<i32>,
    /// Variance of the pixel's mean Y (`variance.rs`); NaN after a single sample.
    pub variance: Vec<f32>,
    /// Camera rays of the pixel.
    pub samples: Vec<i32>,
    /// One minus the pixel's mean transmittance along the unbent straight way to the environment, of pictures without
    /// their backdrop.
    pub alpha: Option<Vec<f32>>,
    /// Stokes vectors of X, of Y and of Z, twelve floats a pixel: S1 > 0 along the camera's upright, S2 > 0 at 45 degrees from
    /// it, clockwise in the picture, S3 the V of docs/reference/theory.md.
    pub stokes: Option<Vec<f32>>,
    /// Spectral radiance at each wavelength that was asked for, where Stokes vectors are too four floats each.
    pub spectra: Option<Vec<f32>>,
    /// The part of this picture, in whole tiles, outside which no ray from the camera has met a surface: what is seen there
    /// hangs on the camera and the lights alone. `None` where none has met any.
    pub surfaces: Option<Rect>,
    /// How it was made.
    pub info: RenderInfo,
}

/// The planes of one tile.
#[derive(Debug, Default)]
pub(crate) struct TilePlanes {
    pub xyz: Vec<f32>,
    pub depth: Vec<f32>,
    pub thickness_nm: Vec<f32>,
    pub path_difference_nm: Vec<f32>,
    pub normal: Vec<f32>,
    pub object: Vec<i32>,
    pub variance: Vec<f32>,
    pub samples: u32,
    pub alpha: Vec<f32>,
    pub stokes: Vec<f32>,
    pub spectra: Vec<f32>,
    pub has_surface: bool,
}

impl Framebuffer {
    /// Bytes of all planes of one pixel.
    pub const BYTES_PER_PIXEL: u64 = 13 * size_of::<f32>() as u64;

    /// An empty picture: black, no surface anywhere, no samples. [`RenderError::Resource`] where it cannot fit.
    pub fn empty(width: u32, height: u32, has_alpha: bool, info: RenderInfo) -> Result<Framebuffer, RenderError> {
        Framebuffer::check_size(width, height, 0)?;
        let pixels = width as usize * height as usize;
        let single = |len: usize, value: f32| plane(len, value, width, height);
        Ok(Framebuffer {
            width,
            height,
            xyz: single(3 * pixels, 0.0)?,
            depth: single(pixels, f32::INFINITY)?,
            thickness_nm: single(pixels, f32::NAN)?,
            path_difference_nm: single(pixels, f32::NAN)?,
            normal: single(3 * pixels, 0.0)?,
            object: plane(pixels, -1, width, height)?,
            variance: single(pixels, 0.0)?,
            samples: plane(pixels, 0, width, height)?,
            alpha: if has_alpha { Some(single(pixels, 0.0)?) } else { None },
            stokes: None,
            spectra: None,
            surfaces: None,
            info,
        })
    }

    /// Planes that were asked for: Stokes vectors, and `spectral` numbers a pixel.
    pub(crate) fn add_extras(&mut self, stokes: bool, spectral: usize) -> Result<(), RenderError> {
        let (width, height) = (self.width, self.height);
        let pixels = width as usize * height as usize;
        let of = |numbers: usize| plane(numbers * pixels, 0.0, width, height);
        self.stokes = if stokes { Some(of(12)?) } else { None };
        self.spectra = if spectral > 0 { Some(of(spectral)?) } else { None };
        Ok(())
    }

    /// Puts a tile into its place, `left` and `top` counted within this picture.
    pub(crate) fn put(&mut self, left: u32, top: u32, tile: Rect, planes: &TilePlanes) {
        fn copy<T: Copy>(to: &mut [T], from: &[T], width: usize, [left, top]: [usize; 2], tile: Rect, of: usize) {
            let columns = tile.width as usize * of;
            for (row, values) in from.chunks_exact(columns).enumerate() {
                let start = ((top + row) * width + left) * of;
                to[start..start + columns].copy_from_slice(values);
            }
        }
        if planes.has_surface {
            let own = Rect { x: left, y: top, ..tile };
            self.surfaces = Some(self.surfaces.map_or(own, |known| known.around(own)));
        }
        let (width, at) = (self.width as usize, [left as usize, top as usize]);
        copy(&mut self.xyz, &planes.xyz, width, at, tile, 3);
        copy(&mut self.depth, &planes.depth, width, at, tile, 1);
        copy(&mut self.thickness_nm, &planes.thickness_nm, width, at, tile, 1);
        copy(&mut self.path_difference_nm, &planes.path_difference_nm, width, at, tile, 1);
        copy(&mut self.normal, &planes.normal, width, at, tile, 3);
        copy(&mut self.object, &planes.object, width, at, tile, 1);
        copy(&mut self.variance, &planes.variance, width, at, tile, 1);
        copy(&mut self.samples, &vec![planes.samples as i32; tile.pixels()], width, at, tile, 1);
        if let Some(alpha) = &mut self.alpha {
            copy(alpha, &planes.alpha, width, at, tile, 1);
        }
        if let Some(stokes) = &mut self.stokes {
            copy(stokes, &planes.stokes, width, at, tile, 12);
        }
        if let Some(spectra) = &mut self.spectra {
            copy(spectra, &planes.spectra, width, at, tile, planes.spectra.len() / tile.pixels());
        }
    }

    /// Refuses empty pictures, and those that the machine cannot hold, before anything is allocated. `besides`: bytes of a
    /// pixel that the work takes for itself.
    ///
    /// A render holds the planes themselves; developing and saving add at most as much again, hence the factor 2.
    /// The memory to be had is read from `/proc/meminfo` and the control group where they exist, else taken as 8 GiB.
    pub fn check_size(width: u32, height: u32, besides: u64) -> Result<(), RenderError> {
        if width == 0 || height == 0 {
            return Err(RenderError::Argument(format!(
                "size must be at least 1 pixel each way, got {width} x {height}"
            )));
        }
        let a_pixel = 2 * Framebuffer::BYTES_PER_PIXEL + besides;
        let need = u128::from(width) * u128::from(height) * u128::from(a_pixel);
        let room = u128::from(available_memory());
        if need > room {
            return Err(RenderError::Resource(format!(
                "an image of {width} x {height} pixels needs {}, this machine has {} available; make it smaller",
                bytes(need),
                bytes(room)
            )));
        }
        Ok(())
    }
}

/// A plane of one value, refused instead of aborting where the allocator has no room.
fn plane<T: Clone>(len: usize, value: T, width: u32, height: u32) -> Result<Vec<T>, RenderError> {
    let mut values = Vec::new();
    values.try_reserve_exact(len).map_err(|_| {
        RenderError::Resource(format!("no memory for an image of {width} x {height} pixels; make it smaller"))
    })?;
    values.resize(len, value);
    Ok(values)
}

/// Memory that can be had without swapping, in bytes.
fn available_memory() -> u64 {
    const FALLBACK: u64 = 8 << 30;
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let number = |path: &str| read(path)?.trim().parse::<u64>().ok();
    let machine = read("/proc/meminfo").and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| kib << 10)
    });
    // A container is killed, not refused, beyond its limit ("max" where there is none, which is no number).
    let limit = number("/sys/fs/cgroup/memory.max").zip(number("/sys/fs/cgroup/memory.current"));
    let group = limit.map(|(limit, used)| limit.saturating_sub(used));
    machine.unwrap_or(FALLBACK).min(group.unwrap_or(u64::MAX))
}

/// `3.2 GiB` and the like.
fn bytes(count: u128) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let mut value = count as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    format!("{value:.1} {}", units[unit])
}

/// Why there is no picture; `Display` is the whole message a user sees.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// Whoever watches said so.
    #[error("the render was cancelled")]
    Cancelled,
    /// Something that cannot fit.
    #[error("{0}")]
    Resource(String),
    /// A number or name outside what is allowed.
    #[error("{0}")]
    Argument(String),
    /// A scene whose parts do not go together, as only its rays can tell.
    #[error("{message}")]
    Scene {
        /// What is wrong.
        message: String,
        /// Dotted path of the part at fault.
        key: String,
    },
    /// A medium or an illuminant that cannot be used.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// A journal that cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info() -> RenderInfo {
        RenderInfo { samples: 1, seed: 1, seconds: 0.0, simd: String::new(), threads: 1 }
    }

    #[test]
    fn an_empty_picture_has_its_planes() {
        let frame = Framebuffer::empty(3, 2, true, info()).unwrap();
        assert_eq!((frame.xyz.len(), frame.normal.len()), (18, 18));
        assert!(frame.depth.len() == 6 && frame.depth.iter().all(|d| *d == f32::INFINITY));
        assert!(frame.object == [-1; 6] && frame.samples == [0; 6] && frame.alpha == Some(vec![0.0; 6]));
        assert!(frame.thickness_nm.len() == 6 && frame.thickness_nm.iter().all(|t| t.is_nan()));
    }

    #[test]
    fn a_tile_comes_to_its_place() {
        let mut frame = Framebuffer::empty(4, 3, false, info()).unwrap();
        let tile = Rect { x: 12, y: 7, width: 2, height: 2 };
        let triple = |values: [f32; 4]| values.iter().flat_map(|v| [*v; 3]).collect::<Vec<f32>>();
        let values = [1.0, 2.0, 3.0, 4.0];
        let planes = TilePlanes {
            xyz: triple(values),
            depth: values.to_vec(),
            thickness_nm: values.to_vec(),
            path_difference_nm: values.to_vec(),
            normal: triple(values),
            object: vec![1, 2, 3, 4],
            variance: values.to_vec(),
            samples: 9,
            ..TilePlanes::default()
        };
        frame.put(2, 1, tile, &planes);
        assert_eq!(frame.object, [-1, -1, -1, -1, -1, -1, 1, 2, -1, -1, 3, 4]);
        assert_eq!(frame.samples, [0, 0, 0, 0, 0, 0, 9, 9, 0, 0, 9, 9]);
        assert_eq!(frame.xyz[18..24], [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    }

    #[test]
    fn pictures_that_cannot_be_are_refused_at_once() {
        assert!(
            matches!(Framebuffer::empty(0, 4, false, info()), Err(RenderError::Argument(m)) if m.contains("0 x 4"))
        );
        let refused = Framebuffer::empty(u32::MAX, u32::MAX, false, info()).unwrap_err();
        let RenderError::Resource(message) = refused else { panic!("{refused:?}") };
        assert!(message.contains("4294967295 x 4294967295") && message.contains("EiB"), "{message}");
        // 10^6 x 10^6 pixels: 64 TB, more than any machine this runs on.
        assert!(matches!(Framebuffer::check_size(1_000_000, 1_000_000, 0), Err(RenderError::Resource(_))));
    }
}
