//! From a validated scene to flat arrays that the integrator walks: nothing here depends on a ray.

use iridesce_optics::{Complex64, Medium, OpticsError};
use iridesce_scene::{EnvironmentSource, Light, Scene, Shape, Surface, ThicknessField};

use crate::camera::RayCamera;
use crate::film::FilmTable;
use crate::framebuffer::{RenderError, RenderOptions};
use crate::geometry::Sphere;
use crate::lanes::Lanes;
use crate::lights::Lights;
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
    pub lights: Lights,
    /// Luminance of a path's s and p weights; sums to 1/2.
    pub importance: Vec<Lanes>,
}

/// A free film on an object.
pub struct FilmSurface {
    pub table: FilmTable,
    thickness: ThicknessField,
    /// The medium on both sides, by its number in the render.
    pub outside: u16,
}

impl FilmSurface {
    /// Thickness in nm at a point of the object.
    #[inline(always)]
    pub fn thickness_nm(&self, point: Vec3) -> f64 {
        self.thickness.thickness_nm([point.x, point.y, point.z])
    }
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
            let (Shape::Sphere { center, radius }, Surface::Film(film)) = (object.shape, &object.surface) else {
                return Err(not_yet(&object.name));
            };
            spheres.push(Sphere::new(center.into(), radius));
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
                outside: number as u16,
            });
        }
        let lights = Lights::new(&scene.lights, &nodes)?;
        Ok(Prepared {
            camera: RayCamera::new(&scene.camera, width, height),
            width,
            height,
            samples: options.samples.unwrap_or(scene.render.samples),
            seed: options.seed.unwrap_or(scene.render.seed),
            max_depth: scene.render.max_depth,
            spheres,
            films,
            importance: lights.importance(),
            lights,
        })
    }
}

/// As many nodes as the thickest film needs, and the lines of all lamps.
fn nodes_for(scene: &Scene) -> Result<Nodes, RenderError> {
    let mut count = node_count(0.0);
    for object in &scene.objects {
        let Surface::Film(film) = &object.surface else { return Err(not_yet(&object.name)) };
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

fn not_yet(name: &str) -> RenderError {
    RenderError::Argument(format!("object \"{name}\" cannot be drawn by this version"))
}

fn indices(medium: &Medium, nodes: &Nodes) -> Result<Vec<Complex64>, OpticsError> {
    nodes.wavelength_nm.iter().map(|&nm| medium.index_extended(nm).map(|(n, _)| n)).collect()
}
