//! The CPU renderer: camera, intersection, film optics in f32, integrator, image.
