//! Every default of the scene language, here and nowhere else.

use crate::model::{RenderSettings, Unit};

pub const UNIT: Unit = Unit::Cm;

pub const POSITION: [f64; 3] = [0.0, 0.0, 16.0];
pub const TARGET: [f64; 3] = [0.0, 0.0, 0.0];
pub const UP: [f64; 3] = [0.0, 1.0, 0.0];
pub const FOV_DEG: f64 = 35.0;
pub const RESOLUTION: [u32; 2] = [512, 512];

pub const RENDER: RenderSettings = RenderSettings { samples: 64, seed: 1, max_depth: 16 };

pub const CENTER: [f64; 3] = [0.0, 0.0, 0.0];
pub const RADIUS: f64 = 4.0;
pub const HALF_EDGE_U: [f64; 3] = [4.0, 0.0, 0.0];
pub const HALF_EDGE_V: [f64; 3] = [0.0, 4.0, 0.0];
/// Disks and caps face the default camera.
pub const NORMAL: [f64; 3] = [0.0, 0.0, 1.0];
/// Planes are ground.
pub const PLANE_NORMAL: [f64; 3] = [0.0, 1.0, 0.0];
pub const RADIUS_OF_CURVATURE: f64 = 8.0;

pub const MEDIUM: &str = "soap";
/// Thickness of a film that states none: a linear gradient, nm.
pub const TOP_NM: f64 = 0.0;
pub const BOTTOM_NM: f64 = 800.0;
pub const EXPONENT: f64 = 1.0;
pub const OUTSIDE: &str = "air";

/// Narrowest gap under a lens that states none, nm.
pub const CONTACT_GAP_NM: f64 = 0.0;

pub const DIELECTRIC: &str = "N-BK7";
pub const METAL: &str = "Al";
pub const REFLECTANCE: f64 = 0.5;
pub const ILLUMINANT: &str = "D65";

/// A pinhole.
pub const APERTURE_RADIUS: f64 = 0.0;

pub const SWIRLS_SEED: u64 = 1;
/// Seed of a film that flows.
pub const FLOW_SEED: u64 = 1;

pub const ROTATION_DEG: f64 = 0.0;
pub const RADIANCE: f64 = 1.0;

/// What the object at `number` (from 0) is called where it has no name.
pub fn name(number: usize) -> String {
    if number == 0 { "bubble".to_owned() } else { format!("bubble-{}", number + 1) }
}
