//! A validated scene: every default filled in, every medium, illuminant and map resolved.

use std::path::PathBuf;
use std::sync::Arc;

use iridesce_optics::Medium;
use iridesce_optics::color::Illuminant;
pub use iridesce_thickness::ThicknessModel;

use crate::tree::Node;

/// What 1.0 means in a scene's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Metre.
    M,
    /// Centimetre.
    #[default]
    Cm,
    /// Millimetre.
    Mm,
}

/// A camera; world is right-handed, y up.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub position: [f64; 3],
    /// What it looks at.
    pub target: [f64; 3],
    /// Which way is up in the picture.
    pub up: [f64; 3],
    /// How rays leave it.
    pub projection: Projection,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
}

/// How rays leave the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Central projection.
    Perspective {
        /// Full vertical angle, degrees.
        fov_deg: f64,
    },
    /// Parallel projection.
    Orthographic {
        /// Full height of the view, scene units.
        height: f64,
    },
}

/// How a scene asks to be rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderSettings {
    /// Camera rays per pixel.
    pub samples: u32,
    /// Seed of the sample pattern.
    pub seed: u64,
    /// Surface hits after which a path no longer branches.
    pub max_depth: u32,
}

/// A named thing in the scene.
#[derive(Debug, Clone)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// Its geometry.
    pub shape: Shape,
    /// What it is made of.
    pub surface: Surface,
}

/// Geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere {
        /// Centre, scene units.
        center: [f64; 3],
        /// Radius, scene units, > 0.
        radius: f64,
    },
}

/// What a surface is made of.
#[derive(Debug, Clone)]
pub enum Surface {
    /// A free film, the same medium on both sides.
    Film(Film),
}

/// A free film.
#[derive(Debug, Clone)]
pub struct Film {
    /// What the film is made of.
    pub medium: Medium,
    /// How thick it is.
    pub thickness: ThicknessModel,
    /// The medium on both of its sides.
    pub outside: Medium,
}

/// A light.
#[derive(Debug, Clone)]
pub enum Light {
    /// Light from all around, infinitely far away.
    Environment(Environment),
}

/// Light from all around.
#[derive(Debug, Clone)]
pub struct Environment {
    /// Where its radiance comes from.
    pub source: EnvironmentSource,
    /// Turns the map from +z towards +x about +y, degrees.
    pub rotation_deg: f64,
    /// Plain factor for maps; the Y of the light for an illuminant.
    pub radiance: f64,
}

/// Where an environment's radiance comes from.
#[derive(Debug, Clone)]
pub enum EnvironmentSource {
    /// A latitude-longitude map, read from a file or built in.
    Map(Arc<EnvironmentMap>),
    /// The same in every direction.
    Uniform(Illuminant),
}

/// A latitude-longitude map, linear Rec.709; first row +y, middle column -z, columns grow towards +x.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row after row, three floats a texel.
    pub rgb: Vec<f32>,
}

/// A validated, resolved scene.
#[derive(Debug, Clone)]
pub struct Scene {
    /// What 1.0 means.
    pub unit: Unit,
    /// The camera.
    pub camera: Camera,
    /// Render settings.
    pub render: RenderSettings,
    /// All objects, at least one.
    pub objects: Vec<Object>,
    /// All lights, at least one; their radiances add.
    pub lights: Vec<Light>,
    /// The tree it was read from, with every default filled in.
    pub(crate) tree: Node,
    /// Where it came from.
    pub(crate) origin: Origin,
}

/// Where a scene came from: what its paths are relative to.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// The file, for messages.
    pub file: Option<PathBuf>,
    /// The folder that paths start from and may not leave; `None` is the current folder.
    pub folder: Option<PathBuf>,
    /// The user said that paths may leave the folder.
    pub allow_outside: bool,
}
