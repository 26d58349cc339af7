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
mod lights;
mod medium_stack;
mod prepare;
mod refraction;
mod render;
mod sampler;
mod spectral;

pub use framebuffer::{Framebuffer, RenderError, RenderInfo, RenderOptions};
pub use render::{check, render, render_at, simd_level};
