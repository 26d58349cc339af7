//! From a validated scene to flat arrays that the integrator walks: nothing here depends on a ray.

use iridesce_optics::color::{Illuminant, Observer, rgb_basis};
use iridesce_optics::{Complex64, Medium, OpticsError};
use iridesce_scene::{EnvironmentSource, Light, Scene, Shape, Surface};
use iridesce_thickness::ThicknessModel;

use crate::camera::RayCamera;
use crate::environment::MapLookup;
use crate::film::FilmTable;
use crate::framebuffer::{RenderError, RenderOptions};
use crate::geometry::Sphere;
use crate::lanes::{Lanes, blocks};
use crate::spectral::{MAX_NODES, Nodes, node_count};
use crate::vector::Vec3;

/// A scene ready to render.
pub struct Prepared {
    pub camera: RayCamera,
    pub width: u32,
    pub height: u32,
    pub samples: u32,
    pub seed: u64,
    pub max_depth: u32,
    /// Shape and surface of object i stand at index i of both.
    pub spheres: Vec<Sphere>,
    pub films: Vec<FilmSurface>,
    pub lights: Vec<PreparedLight>,
    /// Spectra of linear Rec.709 red, green and blue relative to D65, at the nodes.
    pub basis: [Vec<Lanes>; 3],
    /// Y of an unpolarised path's s and p weights under all lights together; sums to 1/2 for each.
    pub importance: Vec<Lanes>,
}

/// A free film on an object.
pub struct FilmSurface {
    pub table: FilmTable,
    thickness: ThicknessModel,
    y_min: f64,
    per_height: f64,
    /// The medium on both sides, by its number in the render.
    pub outside: u16,
}

impl FilmSurface {
    /// Thickness in nm at a point of the object.
    #[inline(always)]
    pub fn thickness_nm(&self, point: Vec3) -> f64 {
        match self.thickness {
            ThicknessModel::Uniform { thickness_nm } => thickness_nm,
            _ => self.thickness.at_height((point.y - self.y_min) * self.per_height),
        }
    }
}

/// A light with the weights that turn a path's spectrum into XYZ (halved: they meet s + p).
pub struct PreparedLight {
    pub weights: [Vec<Lanes>; 3],
    pub radiance: Radiance,
}

/// How the radiance of a light depends on direction.
pub enum Radiance {
    /// Not at all; XYZ of the bare light.
    Uniform { xyz: [f32; 3] },
    /// By a map; XYZ of the bare map's red, green and blue.
    Map { lookup: MapLookup, factor: f32, rgb_to_xyz: [[f32; 3]; 3] },
}

/// The number of the medium that cameras stand in and scenes are surrounded by: n = 1.
pub const SURROUNDING: u16 = 0;

impl Prepared {
    pub fn new(scene: &Scene, options: &RenderOptions) -> Result<Prepared, RenderError> {
        let [width, height] = options.size.unwrap_or(scene.camera.resolution);
        let nodes = nodes_for(scene)?;
        let mut media: Vec<Vec<Complex64>> = vec![vec![Complex64::new(1.0, 0.0); nodes.len()]];
        let mut spheres = Vec::new();
        let mut films = Vec::new();
        for object in &scene.objects {
            let Shape::Sphere { center, radius } = object.shape;
            let Surface::Film(film) = &object.surface;
            spheres.push(Sphere { center: center.into(), radius });
            let inside = indices(&film.medium, &nodes)?;
            let outside = indices(&film.outside, &nodes)?;
            let number = media.iter().position(|known| *known == outside).unwrap_or_else(|| {
                media.push(outside.clone());
                media.len() - 1
            });
            let outer: Vec<f64> = outside.iter().map(|n| n.re).collect();
            films.push(FilmSurface {
                table: FilmTable::new(&nodes.wavelength_nm, &inside, &outer),
                thickness: film.thickness.clone(),
                y_min: center[1] - radius,
                per_height: 0.5 / radius,
                outside: number as u16,
            });
        }
        let basis: [Vec<Lanes>; 3] =
            std::array::from_fn(|channel| blocks(nodes.wavelength_nm.iter().map(|&nm| rgb_basis(nm)[channel])));
        let lights: Vec<PreparedLight> =
            scene.lights.iter().map(|light| prepare_light(light, &nodes, &basis)).collect::<Result<_, _>>()?;
        Ok(Prepared {
            camera: RayCamera::new(&scene.camera, width, height),
            width,
            height,
            samples: options.samples.unwrap_or(scene.render.samples),
            seed: options.seed.unwrap_or(scene.render.seed),
            max_depth: scene.render.max_depth,
            spheres,
            films,
            importance: importance(&lights, nodes.len()),
            lights,
            basis,
        })
    }
}

/// As many nodes as the thickest film needs, and the lines of all lamps.
fn nodes_for(scene: &Scene) -> Result<Nodes, RenderError> {
    let mut count = node_count(0.0);
    for object in &scene.objects {
        let Surface::Film(film) = &object.surface;
        // The largest index over the visible range: fringes are finest there.
        let index = (360..=830)
            .step_by(10)
            .map(|nm| film.medium.index_extended(f64::from(nm)).map(|(n, _)| n.re))
            .try_fold(0.0_f64, |most, n| n.map(|n| most.max(n)))?;
        let thickest_nm = film.thickness.max_nm();
        let wanted = node_count(2.0 * index * thickest_nm);
        if wanted > MAX_NODES {
            return Err(RenderError::Resource(format!(
                "film of object \"{}\" is up to {thickest_nm} nm thick; a render resolves the fringes of at most {:.0} nm of this medium",
                object.name,
                thickest_nm * MAX_NODES as f64 / wanted as f64
            )));
        }
        count = count.max(wanted);
    }
    let mut lines = Vec::new();
    for Light::Environment(environment) in &scene.lights {
        if let EnvironmentSource::Uniform(illuminant) = &environment.source {
            lines.extend(illuminant.lines().iter().map(|l| l.0));
        }
    }
    Ok(Nodes::new(count, &lines))
}

fn indices(medium: &Medium, nodes: &Nodes) -> Result<Vec<Complex64>, OpticsError> {
    nodes.wavelength_nm.iter().map(|&nm| medium.index_extended(nm).map(|(n, _)| n)).collect()
}

fn prepare_light(light: &Light, nodes: &Nodes, basis: &[Vec<Lanes>; 3]) -> Result<PreparedLight, RenderError> {
    let Light::Environment(environment) = light;
    let factor = environment.radiance;
    match &environment.source {
        EnvironmentSource::Uniform(illuminant) => {
            let weights = halved(illuminant, nodes, factor);
            let xyz = std::array::from_fn(|c| 2.0 * total(&weights[c]));
            Ok(PreparedLight { weights, radiance: Radiance::Uniform { xyz } })
        }
        EnvironmentSource::Map(map) => {
            let weights = halved(&Illuminant::named("D65")?, nodes, 1.0);
            let rgb_to_xyz = std::array::from_fn(|rgb| {
                std::array::from_fn(|c| {
                    let products = weights[c]
                        .iter()
                        .zip(&basis[rgb])
                        .flat_map(|(w, f)| w.0.iter().zip(&f.0).map(|(w, f)| 2.0 * f64::from(*w) * f64::from(*f)));
                    products.sum::<f64>() as f32
                })
            });
            let lookup = MapLookup::new(map.clone(), environment.rotation_deg);
            Ok(PreparedLight { weights, radiance: Radiance::Map { lookup, factor: factor as f32, rgb_to_xyz } })
        }
    }
}

/// Weights that meet s + p: half of those that meet the mean.
fn halved(illuminant: &Illuminant, nodes: &Nodes, factor: f64) -> [Vec<Lanes>; 3] {
    nodes
        .weights(illuminant, Observer::Cie1931)
        .map(|w| blocks(w.iter().map(|&v| 0.5 * factor * f64::from(v)).collect::<Vec<_>>().into_iter()))
}

fn total(weights: &[Lanes]) -> f32 {
    weights.iter().flat_map(|l| l.0).map(f64::from).sum::<f64>() as f32
}

/// The Y weights of all lights together, scaled to a sum of 1/2; equal weights where every light is dark.
fn importance(lights: &[PreparedLight], nodes: usize) -> Vec<Lanes> {
    let mut sum = vec![0.0_f64; nodes];
    for light in lights {
        // Weights are of either sign at the ends of the range, where a cardinal spline may dip below zero;
        // a choice by luminance must follow them exactly, or a white furnace would not stay white.
        let own: f64 = light.weights[1].iter().flat_map(|l| l.0).map(f64::from).sum();
        if own > 0.0 {
            for (to, from) in sum.iter_mut().zip(light.weights[1].iter().flat_map(|l| l.0)) {
                *to += f64::from(from) / own;
            }
        }
    }
    let all: f64 = sum.iter().sum();
    if all > 0.0 { blocks(sum.iter().map(|v| 0.5 * v / all)) } else { blocks(sum.iter().map(|_| 0.5 / nodes as f64)) }
}
