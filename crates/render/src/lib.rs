//! The CPU renderer: camera, intersection, film optics in f32, integrator, image.

pub mod framebuffer;

mod camera;
mod environment;
mod film;
mod geometry;
mod lanes;
mod sampler;
mod spectral;
mod vector;

pub use framebuffer::{Framebuffer, Progress, RenderError, RenderInfo, RenderOptions};
