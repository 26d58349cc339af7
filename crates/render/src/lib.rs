//! The CPU renderer: camera, intersection, film optics in f32, integrator, image.

pub mod framebuffer;
pub mod image;

mod camera;
mod coating;
mod enclosing;
mod environment;
mod failure;
mod film;
mod geometry;
mod integrator;
mod keep;
mod lights;
mod medium_stack;
mod microfacet;
mod passes;
mod prepare;
mod refraction;
mod render;
mod rough;
mod sampler;
mod spectral;
mod tile_sums;
mod tiles;
mod variance;

pub use framebuffer::{Framebuffer, KeepOptions, RenderError, RenderInfo, RenderOptions};
pub use render::{check, render, render_at, simd_level};
pub use tiles::{Rect, SIDE as TILE_SIDE, Shard, tiles};
