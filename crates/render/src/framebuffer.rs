//! What goes into a render and what comes out of it: plain values between the integrator and the image.

use iridesce_optics::OpticsError;

/// What a caller may say about a render; `None` takes the scene's own value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RenderOptions {
    /// Camera rays per pixel, 1 to [`RenderOptions::MAX_SAMPLES`].
    pub samples: Option<u32>,
    /// Seed of the sample pattern.
    pub seed: Option<u64>,
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
    /// Worker threads, at least 1; `None` uses rayon's own pool (all cores, or `RAYON_NUM_THREADS`).
    pub threads: Option<usize>,
}

impl RenderOptions {
    /// The most camera rays per pixel: a thousand times what a clean picture needs, so more is a slip of the keyboard.
    pub const MAX_SAMPLES: u32 = 1 << 20;
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
    /// Unit normal of the first surface, world axes, three floats a pixel; zero where there is none.
    pub normal: Vec<f32>,
    /// How it was made.
    pub info: RenderInfo,
}

impl Framebuffer {
    /// Bytes of all planes of one pixel.
    pub const BYTES_PER_PIXEL: u64 = 8 * size_of::<f32>() as u64;

    /// An empty picture: black, no surface anywhere. [`RenderError::Resource`] where it cannot fit.
    pub fn empty(width: u32, height: u32, info: RenderInfo) -> Result<Framebuffer, RenderError> {
        Framebuffer::check_size(width, height)?;
        let pixels = width as usize * height as usize;
        Ok(Framebuffer {
            width,
            height,
            xyz: plane(3 * pixels, 0.0, width, height)?,
            depth: plane(pixels, f32::INFINITY, width, height)?,
            thickness_nm: plane(pixels, f32::NAN, width, height)?,
            normal: plane(3 * pixels, 0.0, width, height)?,
            info,
        })
    }

    /// Refuses empty pictures, and those that the machine cannot hold, before anything is allocated.
    ///
    /// A render holds the planes themselves; developing and saving add at most as much again, hence the factor 2.
    /// The memory to be had is read from `/proc/meminfo` and the control group where they exist, else taken as 8 GiB.
    pub fn check_size(width: u32, height: u32) -> Result<(), RenderError> {
        if width == 0 || height == 0 {
            return Err(RenderError::Argument(format!(
                "size must be at least 1 pixel each way, got {width} x {height}"
            )));
        }
        let need = u128::from(width) * u128::from(height) * u128::from(2 * Framebuffer::BYTES_PER_PIXEL);
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
fn plane(len: usize, value: f32, width: u32, height: u32) -> Result<Vec<f32>, RenderError> {
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
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info() -> RenderInfo {
        RenderInfo { samples: 1, seed: 1, seconds: 0.0, simd: String::new(), threads: 1 }
    }

    #[test]
    fn an_empty_picture_has_its_planes() {
        let frame = Framebuffer::empty(3, 2, info()).unwrap();
        assert_eq!((frame.xyz.len(), frame.normal.len()), (18, 18));
        assert!(frame.depth.len() == 6 && frame.depth.iter().all(|d| *d == f32::INFINITY));
        assert!(frame.thickness_nm.len() == 6 && frame.thickness_nm.iter().all(|t| t.is_nan()));
    }

    #[test]
    fn pictures_that_cannot_be_are_refused_at_once() {
        assert!(matches!(Framebuffer::empty(0, 4, info()), Err(RenderError::Argument(m)) if m.contains("0 x 4")));
        let refused = Framebuffer::empty(u32::MAX, u32::MAX, info()).unwrap_err();
        let RenderError::Resource(message) = refused else { panic!("{refused:?}") };
        assert!(message.contains("4294967295 x 4294967295") && message.contains("EiB"), "{message}");
        // 10^6 x 10^6 pixels: 64 TB, more than any machine this runs on.
        assert!(matches!(Framebuffer::check_size(1_000_000, 1_000_000), Err(RenderError::Resource(_))));
    }
}
