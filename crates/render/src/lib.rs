//! The CPU renderer: camera, intersection, film optics in f32, integrator, image.

/// Does `$work` with the vector instructions of a level, for what is compiled once a level and takes long: the paths of light.
/// Builds with debug assertions, which are those of tests, hold SSE2 and AVX2 alone, and this crate's own tests SSE2: four levels
/// are most of the 83 s of processor time that a release of this crate takes. The tests of the package as users install it run
/// at every level that the machine has.
#[cfg(not(all(debug_assertions, target_arch = "x86_64")))]
macro_rules! at_level {
    ($level:expr, $simd:ident => $work:expr) => {
        fearless_simd::dispatch!($level, $simd => $work)
    };
}
#[cfg(all(debug_assertions, not(test), target_arch = "x86_64"))]
macro_rules! at_level {
    ($level:expr, $simd:ident => $work:expr) => {{
        use fearless_simd::Simd as _;
        if let Some($simd) = $level.as_avx2() {
            $simd.vectorize(
                #[inline(always)]
                || $work,
            )
        } else if let Some($simd) = $level.as_sse2() {
            $simd.vectorize(
                #[inline(always)]
                || $work,
            )
        } else {
            unreachable!("each x86-64 has SSE2")
        }
    }};
}
#[cfg(all(debug_assertions, test, target_arch = "x86_64"))]
macro_rules! at_level {
    ($level:expr, $simd:ident => $work:expr) => {{
        use fearless_simd::Simd as _;
        let Some($simd) = $level.as_sse2() else { unreachable!("each x86-64 has SSE2") };
        $simd.vectorize(
            #[inline(always)]
            || $work,
        )
    }};
}

pub mod framebuffer;
pub mod image;

mod camera;
mod caustics;
mod chain;
mod coating;
mod coherence;
mod enclosing;
mod environment;
mod facet_lanes;
mod failure;
mod film;
mod floors;
mod geometry;
mod integrator;
mod keep;
mod levels;
mod lights;
mod materials;
mod medium_stack;
mod microfacet;
mod passes;
mod prepare;
mod refraction;
mod render;
mod rough;
mod sampler;
mod spectral;
mod specular_ray;
mod tile_sums;
mod tiles;
mod variance;

pub use framebuffer::{Framebuffer, KeepOptions, RenderError, RenderInfo, RenderOptions};
pub use render::{check, render, render_at, simd_level};
pub use tiles::{Rect, SIDE as TILE_SIDE, Shard, tiles};
