//! The CPU renderer: camera, intersection, film optics in f32, integrator, image.

pub mod framebuffer;
pub mod image;

pub use framebuffer::{Framebuffer, Progress, RenderError, RenderInfo, RenderOptions};
