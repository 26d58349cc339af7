//! A validated scene, as a recipe: every default filled in, every medium and illuminant found; maps and films that flow
//! are named and checked, and come with [`crate::resolve`].

use std::path::PathBuf;

use std::sync::Arc;

use crate::affine::Affine;
use iridesce_flow::FilmRun;
use iridesce_optics::Medium;
use iridesce_optics::color::Illuminant;
pub use iridesce_thickness::ThicknessModel;

pub use crate::field::{Place, ThicknessField};
pub use crate::heights::Heights;
pub use crate::origin::Origin;
pub use crate::shape::Chart;
pub use iridesce_files::{EnvironmentMap, Mesh};

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

impl Unit {
    /// The unit that a scene calls `name`.
    pub fn named(name: &str) -> Option<Unit> {
        [Unit::M, Unit::Cm, Unit::Mm].into_iter().find(|unit| unit.name() == name)
    }

    /// What a scene calls it.
    pub fn name(self) -> &'static str {
        match self {
            Unit::M => "m",
            Unit::Cm => "cm",
            Unit::Mm => "mm",
        }
    }

    /// Millimetres in one of it.
    pub fn millimetres(self) -> f64 {
        match self {
            Unit::M => 1000.0,
            Unit::Cm => 10.0,
            Unit::Mm => 1.0,
        }
    }
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
    /// What they pass on their way; `None` is a pinhole.
    pub lens: Option<Lens>,
    /// Angle of the linear polariser before it, degrees from its upright, clockwise in the picture.
    pub polarizer_deg: Option<f64>,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
}

/// A thin lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Radius of its aperture, scene units, > 0.
    pub aperture_radius: f64,
    /// Distance from the camera, along the view, of the plane that is sharp; scene units, > 0.
    pub focus_distance: f64,
}

/// How rays leave the camera.
///
/// A parallel view with a `numerical_aperture` is a microscope: rays through one place of the picture meet at the distance
/// of the camera's target, spread evenly over its pupil.
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
        /// Sine of the largest angle between a ray and the view; 0 for parallel rays.
        numerical_aperture: f64,
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
    /// Whether the environment is seen straight; else a plane tells what of it would be.
    pub has_backdrop: bool,
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
    /// How rough that is.
    pub roughness: Roughness,
    /// Where its shape is put, and how often.
    pub placement: Placement,
    /// How maps lie on it.
    pub uv: UvMap,
    /// Heights that turn its shading normals.
    pub bump: Option<Bump>,
    /// Of the medium behind it: inside several, the highest rules.
    pub priority: i32,
}

/// How rough a surface is: GGX with alpha = roughness^2.
#[derive(Debug, Clone, PartialEq)]
pub enum Roughness {
    /// The same all over it, 0 to 1: along u and along v. Smooth where both are 0.
    Uniform([f64; 2]),
    /// A grey map, laid over the shape by u and v.
    Map {
        /// The file.
        file: MapFile,
        /// What black means.
        min: f64,
        /// What white means.
        max: f64,
    },
}

impl Roughness {
    /// A mirror.
    pub const SMOOTH: Roughness = Roughness::Uniform([0.0; 2]);
}

/// What a matt surface reflects.
#[derive(Debug, Clone, PartialEq)]
pub enum Reflectance {
    /// Linear Rec.709, 0 to 1.
    Rgb([f64; 3]),
    /// A picture, laid over the shape by u and v.
    Map(MapFile),
    /// A table of wavelengths in nm and reflectances.
    Spectrum(MapFile),
}

/// Where a shape is put.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placement {
    /// The object's own transform.
    pub transform: Affine,
    /// What comes after it, once for each.
    pub instances: Instances,
}

/// How often an object is there.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Instances {
    /// Once.
    #[default]
    Once,
    /// Once for each of these.
    List(Arc<[Affine]>),
    /// Once for each in a file.
    File(MapFile),
}

impl Placement {
    /// Whether the shape stays where it is, once.
    pub fn is_plain(&self) -> bool {
        self.transform == Affine::IDENTITY && self.instances == Instances::Once
    }
}

/// How maps lie on an object: u and v scaled, then shifted; maps then repeat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UvMap {
    /// Factors of u and v.
    pub scale: [f64; 2],
    /// Added to them.
    pub offset: [f64; 2],
}

impl Default for UvMap {
    fn default() -> UvMap {
        UvMap { scale: [1.0; 2], offset: [0.0; 2] }
    }
}

impl UvMap {
    /// u and v as maps are asked with them.
    #[inline(always)]
    pub fn of(&self, uv: [f64; 2]) -> [f64; 2] {
        [uv[0] * self.scale[0] + self.offset[0], uv[1] * self.scale[1] + self.offset[1]]
    }
}

/// A map of heights.
#[derive(Debug, Clone, PartialEq)]
pub struct Bump {
    /// The file.
    pub file: MapFile,
    /// The height of white, scene units.
    pub height: f64,
}

/// A sphere of a cluster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Centre, scene units.
    pub center: [f64; 3],
    /// Radius, scene units, > 0.
    pub radius: f64,
}

/// Geometry. The front of a surface is the side that its normal points to.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A sphere; its normal points outwards.
    Sphere {
        /// Centre, scene units.
        center: [f64; 3],
        /// Radius, scene units, > 0.
        radius: f64,
    },
    /// A parallelogram, a rectangle where the half edges are at right angles; its normal is u x v.
    Rectangle {
        /// Centre, scene units.
        center: [f64; 3],
        /// From the centre to the middle of one edge.
        u: [f64; 3],
        /// From the centre to the middle of the next edge.
        v: [f64; 3],
    },
    /// A flat disk.
    Disk {
        /// Centre, scene units.
        center: [f64; 3],
        /// Its normal, length 1.
        normal: [f64; 3],
        /// Radius, scene units, > 0.
        radius: f64,
    },
    /// An unbounded plane.
    Plane {
        /// A point of it, scene units.
        point: [f64; 3],
        /// Its normal, length 1.
        normal: [f64; 3],
    },
    /// Part of a sphere around a vertex, as one face of a lens.
    Cap {
        /// The vertex (the middle of the cap), scene units.
        center: [f64; 3],
        /// Its normal at the vertex, length 1.
        axis: [f64; 3],
        /// Radius of the sphere, scene units, not zero: > 0 bulges towards the axis (the sphere's centre lies at
        /// `center - radius_of_curvature * axis`), < 0 is hollow.
        radius_of_curvature: f64,
        /// Radius of the rim, scene units, > 0, at most |radius_of_curvature|.
        aperture_radius: f64,
    },
    /// The side of a cylinder, with its ends or without; its normal points outwards.
    Cylinder {
        /// The middle of its axis, scene units.
        center: [f64; 3],
        /// Along the axis, length 1.
        axis: [f64; 3],
        /// Radius, scene units, > 0.
        radius: f64,
        /// From end to end, scene units, > 0.
        height: f64,
        /// Whether its ends are open.
        is_open: bool,
    },
    /// The triangles of a file; the front by winding.
    Mesh(MapFile),
    /// A cluster of bubbles that share walls.
    Bubbles(Arc<[Ball]>),
}

/// What a surface is made of.
#[expect(clippy::large_enum_variant, reason = "one a kind of object, not one a hit: a box would only be in the way")]
#[derive(Debug, Clone)]
pub enum Surface {
    /// A free film, the same medium on both sides.
    Film(Film),
    /// Layers on a substrate, which fills the space behind the surface.
    Coating(Coating),
    /// The bare surface of a transparent medium, which fills the space behind it.
    Dielectric(Medium),
    /// The bare surface of an opaque medium.
    Metal(Medium),
    /// A matt surface (Lambert's law).
    Diffuse(Reflectance),
    /// A surface that glows on both sides and reflects nothing.
    Emitter(Emitter),
}

impl Surface {
    /// The key that a scene writes it under.
    pub fn kind(&self) -> &'static str {
        match self {
            Surface::Film(_) => "film",
            Surface::Coating(_) => "coating",
            Surface::Dielectric(_) => "dielectric",
            Surface::Metal(_) => "metal",
            Surface::Diffuse(_) => "diffuse",
            Surface::Emitter(_) => "emitter",
        }
    }

    /// Every medium of the surface, from outside inwards.
    pub fn media(&self) -> Vec<&Medium> {
        match self {
            Surface::Film(film) => vec![&film.outside, &film.medium],
            Surface::Coating(coating) => {
                coating.layers.iter().map(|layer| &layer.medium).chain([&coating.substrate]).collect()
            }
            Surface::Dielectric(medium) | Surface::Metal(medium) => vec![medium],
            Surface::Diffuse(_) | Surface::Emitter(_) => Vec::new(),
        }
    }
}

/// A free film.
#[derive(Debug, Clone)]
pub struct Film {
    /// What the film is made of.
    pub medium: Medium,
    /// How thick it is.
    pub thickness: Thickness,
    /// The medium on both of its sides.
    pub outside: Medium,
    /// How thick the walls between bubbles are; `None`: as the film.
    pub inner_thickness: Option<Thickness>,
}

/// Layers on a substrate.
#[derive(Debug, Clone)]
pub struct Coating {
    /// From outside (the front) inwards.
    pub layers: Vec<CoatingLayer>,
    /// What is behind them.
    pub substrate: Medium,
}

/// A layer of a coating.
#[derive(Debug, Clone)]
pub struct CoatingLayer {
    /// What it is made of.
    pub medium: Medium,
    /// How thick it is.
    pub thickness: Thickness,
}

/// How thick a layer is: what a scene says of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Thickness {
    /// A law of place, laid over the object's shape.
    Law(ThicknessField),
    /// A law of place that waits for where the object is: for its mesh, its transform, its instances.
    Model(ThicknessModel),
    /// What the vertices of the object's mesh say.
    Vertex,
    /// The grid in a file.
    Map {
        /// The file.
        file: MapFile,
        /// What a whole number of 0 means, nm.
        min_nm: Option<f64>,
        /// What the largest whole number means, nm.
        max_nm: Option<f64>,
    },
    /// Swirls between two thicknesses.
    Swirls {
        /// Least thickness, nm.
        min_nm: f64,
        /// Largest thickness, nm.
        max_nm: f64,
        /// Another seed, other swirls.
        seed: u64,
    },
    /// A film that has flowed for some time.
    Flow {
        /// Which film.
        film: FilmRun,
        /// For how long, s.
        time_s: f64,
    },
}

/// A file that a scene names, found but not read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapFile {
    /// As the scene writes it.
    pub name: String,
    /// Where it is, links followed.
    pub path: PathBuf,
    /// Which channel, layer or part of it is meant; `None`: the only one, of a mesh the whole.
    pub channel: Option<String>,
    /// Which page of it is meant, the first being 1; `None`: the only one.
    pub page: Option<usize>,
}

/// A glowing surface.
#[derive(Debug, Clone)]
pub struct Emitter {
    /// Its spectrum.
    pub illuminant: Illuminant,
    /// The Y of its radiance, the same in every direction.
    pub radiance: f64,
    /// Angle of its linear polarisation, degrees from the upright of each ray; `None` for natural light.
    pub polarized_deg: Option<f64>,
}

/// A light.
#[derive(Debug, Clone)]
pub enum Light {
    /// Light from all around, infinitely far away.
    Environment(Environment),
    /// A disc, infinitely far away.
    Sun(Sun),
    /// A light without size, which nothing sees.
    Delta(DeltaLight),
}

/// A light without size: surfaces that scatter it show it, mirrors and the camera do not.
#[derive(Debug, Clone)]
pub struct DeltaLight {
    /// Where it comes from.
    pub kind: DeltaKind,
    /// Its spectrum.
    pub illuminant: Illuminant,
    /// The Y of its irradiance on a surface that faces it (directional), or of that times the squared distance in scene units
    /// (the others), where radiance 1 has Y = 1.
    pub power: f64,
    /// Angle of its linear polarisation, degrees from the upright of each ray; `None` for natural light.
    pub polarized_deg: Option<f64>,
}

/// Where a light without size comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DeltaKind {
    /// Infinitely far away.
    Directional {
        /// Towards it, length 1.
        direction: [f64; 3],
    },
    /// From a point, the same to every side.
    Point {
        /// Where it is, scene units.
        position: [f64; 3],
    },
    /// From a point, into a cone.
    Spot {
        /// Where it is, scene units.
        position: [f64; 3],
        /// The middle of the cone, length 1.
        axis: [f64; 3],
        /// Full angle of the cone of full intensity, degrees.
        cone_deg: f64,
        /// Over how much more, on each side, the intensity falls to 0, degrees.
        soft_deg: f64,
    },
}

impl DeltaKind {
    /// Where it is, if it is anywhere.
    pub fn position(&self) -> Option<[f64; 3]> {
        match *self {
            DeltaKind::Directional { .. } => None,
            DeltaKind::Point { position } | DeltaKind::Spot { position, .. } => Some(position),
        }
    }
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
    /// A latitude-longitude map in a file.
    Map(MapFile),
    /// The same in every direction.
    Uniform(Illuminant),
    /// The built-in studio.
    Studio,
    /// The built-in sky with its sun.
    Sky,
}

/// A disc of light, infinitely far away; that of a sky is turned about +y together with it.
#[derive(Debug, Clone)]
pub struct Sun {
    /// Towards its middle, length 1, before any rotation.
    pub direction: [f64; 3],
    /// Angle between its middle and its rim, degrees.
    pub angular_radius_deg: f64,
    /// Its spectrum.
    pub illuminant: Illuminant,
    /// The Y of its radiance, the same all over it.
    pub radiance: f64,
    /// Angle of its linear polarisation, degrees from the upright of each ray; `None` for natural light.
    pub polarized_deg: Option<f64>,
}

/// A validated scene: a recipe, which [`crate::resolve`] makes ready to be looked at.
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
    /// The tree as it was given, with its lines.
    pub(crate) source: Node,
    /// Where it came from.
    pub(crate) origin: Origin,
}
