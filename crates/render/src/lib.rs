//! The CPU renderer: camera, intersection, film optics in f32, integrator, image.

pub mod framebuffer;

pub use framebuffer::{Framebuffer, Progress, RenderError, RenderInfo, RenderOptions};
