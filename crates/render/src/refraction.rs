//! Directions beyond a surface, and what stands behind clear ones.

use iridesce_numerics::Vec3;

use crate::camera::Ray;
use crate::coating::IndexTable;
use crate::geometry::{Geometry, Hit};
use crate::materials::{LayerSurface, Material};
use crate::prepare::Prepared;
use crate::spectral::Bands;

/// Directions of one refracted path that differ by less than this over the spectrum (radians) count as one: a tenth of
/// a pixel of any picture.
const SAME_DIRECTION: f64 = 1e-4;

/// Least cosine to the surface itself at which shading normals mirror.
const LEAST_RISE: f64 = 0.01;

/// Most clear surfaces through which a film is looked for.
const CLEAR_SURFACES: usize = 8;

/// The index of the medium before a surface over that of the one beyond it, at a place among the nodes.
#[inline(always)]
pub fn ratio([outer, exit]: [&IndexTable; 2], place: f64) -> f64 {
    outer.n_at(place) / exit.n_at(place)
}

/// Snell's law at a place among the nodes; `None` beyond the critical angle.
#[inline(always)]
pub fn refracted_direction(
    direction: Vec3,
    facing: Vec3,
    cos_theta: f64,
    media: [&IndexTable; 2],
    place: f64,
) -> Option<Vec3> {
    let ratio = ratio(media, place);
    let cosine2 = 1.0 - ratio * ratio * (1.0 - cos_theta * cos_theta).max(0.0);
    (cosine2 > 0.0).then(|| (direction * ratio + facing * (ratio * cos_theta - cosine2.sqrt())).normalized())
}

/// Whether a surface parts the wavelengths of a path that comes to it at an angle of this cosine.
#[inline(always)]
pub fn is_parted(bands: &Bands, cos_theta: f64, media: [&IndexTable; 2]) -> bool {
    let sine2 = (1.0 - cos_theta * cos_theta).max(0.0);
    // Indices are smooth: their ratio at the ends of the spectrum tells how far the directions spread.
    let [first, last, middle] = [bands.ends[0], bands.ends[1], bands.middle].map(|node| ratio(media, node));
    let spread = (first - last).abs() * sine2.sqrt();
    let most = first.max(last).max(middle);
    let least = 1.0 - most * most * sine2;
    spread > 0.0 && (least <= 0.0 || spread > SAME_DIRECTION * least.sqrt())
}

/// Fresnel's reflectance of unpolarised light at a bare surface. `ratio`: the index before it over that beyond.
#[inline(always)]
pub fn bare_reflectance(cos: f64, ratio: f64) -> f64 {
    let cosine2 = 1.0 - ratio * ratio * (1.0 - cos * cos);
    if cosine2 <= 0.0 {
        return 1.0;
    }
    let beyond = cosine2.sqrt();
    let s = (ratio * cos - beyond) / (ratio * cos + beyond);
    let p = (cos - ratio * beyond) / (cos + ratio * beyond);
    0.5 * (s * s + p * p)
}

/// The normal by which a surface mirrors a path: the shading normal, bent back as far as it takes for the mirrored path to
/// leave on the side from which it came (A. Keller et al., "The iray light transport simulation and rendering system",
/// arXiv:1705.01263, section A.3).
#[inline(never)]
pub fn shading_normal(geometry: &Geometry, hit: &Hit, direction: Vec3) -> Vec3 {
    let wanted = geometry.interaction(hit).shading_normal;
    let own = hit.normal;
    let side = if direction.dot(own) < 0.0 { 1.0 } else { -1.0 };
    let (facing, own_facing) = (wanted * side, own * side);
    let mirror = direction - facing * (2.0 * direction.dot(facing));
    let rise = mirror.dot(own_facing);
    let least = LEAST_RISE.min(-direction.dot(own_facing));
    if rise >= least && direction.dot(facing) < 0.0 {
        return wanted;
    }
    let lifted = (mirror + own_facing * (least - rise).max(0.0)).normalized();
    let bent = lifted - direction;
    if bent.length_squared() < 1e-12 { own } else { bent.normalized() * side }
}

/// The film, or the layer, that a camera ray shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    pub thickness_nm: f64,
    /// Optical path difference 2 n t cos(theta) in it, theta within it, at [`crate::materials::SHOWN_NM`], nm; 0 where light
    /// of that wavelength does not enter it.
    pub path_difference_nm: f64,
}

impl Shown {
    /// `outer`: index of the medium that the ray comes from, which meets the layer at `cos_theta`.
    fn new(layer: &LayerSurface, scene: &Prepared, hit: &Hit, outer: f64, cos_theta: f64) -> Shown {
        let thickness_nm = layer.thickness_nm(&scene.geometry, hit);
        let kz2 = layer.shown_index.powi(2) - outer * outer * (1.0 - cos_theta * cos_theta).max(0.0);
        Shown { thickness_nm, path_difference_nm: 2.0 * thickness_nm * kz2.max(0.0).sqrt() }
    }
}

/// What a camera ray shows: the first free film that it comes to, straight through clear surfaces; without one, the outermost
/// layer of the first coating.
pub fn shown(scene: &Prepared, ray: Ray, first: Hit) -> Option<Shown> {
    let spectra = &scene.levels[0];
    let (mut ray, mut hit, mut medium, mut outermost) = (ray, first, scene.enclosing_media(&ray), None);
    for _ in 0..CLEAR_SURFACES {
        let cos_theta = ray.direction.dot(hit.normal).abs().min(1.0);
        let outer = scene.shown_indices[usize::from(medium.innermost())];
        let seen = |layer: &LayerSurface| Shown::new(layer, scene, &hit, outer, cos_theta);
        let coating = match &scene.materials[hit.object] {
            Material::Film(film) => return Some(seen(&film.layer)),
            Material::Coating(coating) => coating,
            Material::Diffuse { .. } | Material::Emitter(_) => break,
        };
        outermost = outermost.or_else(|| coating.layers.first().map(seen));
        if coating.is_opaque {
            break;
        }
        let along = ray.direction.dot(hit.normal);
        let is_from_front = along < 0.0;
        let Some(beyond) = (if is_from_front { medium.entered(coating.substrate) } else { Some(medium.left()) }) else {
            break;
        };
        let facing = if is_from_front { hit.normal } else { -hit.normal };
        let media = [medium, beyond].map(|medium| &spectra.media[usize::from(medium.innermost())]);
        let Some(direction) =
            refracted_direction(ray.direction, facing, along.abs().min(1.0), media, spectra.bands.middle)
        else {
            break;
        };
        ray = Ray { origin: hit.point, direction };
        let Some(next) = scene.geometry.nearest(&ray, Some(&hit)) else { break };
        (hit, medium) = (next, beyond);
    }
    outermost
}
