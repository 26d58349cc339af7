//! What surfaces are made of, as the integrator asks them: numbers into tables, and thicknesses that are known at every point.

use iridesce_optics::color::rgb_basis;
use iridesce_optics::{Medium, OpticsError};
use iridesce_scene::{
    Place, Reflectance, ResolvedReflectance, ResolvedScene, Shape, Surface, Texture, ThicknessField, held,
};

use crate::framebuffer::RenderError;
use crate::geometry::{Geometry, Hit};
use crate::medium_stack::{Media, indices, visible};
use crate::rough::RoughSurface;

/// Where the path difference of the film that a pixel shows is told, nm: the middle of what eyes see.
pub const SHOWN_NM: f64 = 560.0;

/// What a surface does to light.
#[expect(clippy::large_enum_variant, reason = "one an object, not one a hit: a box would only be in the way")]
pub enum Material {
    Film(FilmSurface),
    Coating(CoatedSurface),
    /// Number among the reflectances.
    Diffuse {
        number: usize,
        is_black: bool,
    },
    /// Number among the emitters.
    Emitter(usize),
}

/// A layer whose thickness is known at every point.
pub struct LayerSurface {
    thickness: ThicknessField,
    /// Of walls between bubbles, if that is another.
    inner: Option<ThicknessField>,
    is_on_mesh: bool,
    /// A point of the world alone does not tell it.
    needs_place: bool,
    /// Largest 2 n over the visible range: optical path difference per thickness.
    path_per_nm: f64,
    /// n at [`SHOWN_NM`].
    pub shown_index: f64,
}

impl LayerSurface {
    /// Thickness in nm where a ray has met the object.
    #[inline(always)]
    pub fn thickness_nm(&self, geometry: &Geometry, hit: &Hit) -> f64 {
        if self.needs_place {
            return self.thickness_by_place(geometry, hit);
        }
        self.thickness.thickness_nm([hit.point.x, hit.point.y, hit.point.z])
    }

    #[inline(never)]
    fn thickness_by_place(&self, geometry: &Geometry, hit: &Hit) -> f64 {
        let field = self.inner.as_ref().filter(|_| geometry.is_inner(hit)).unwrap_or(&self.thickness);
        if !field.needs_place() {
            return field.thickness_nm(hit.point.to_array());
        }
        let met = geometry.interaction(hit);
        let place = Place {
            point: hit.point.to_array(),
            local: met.local.to_array(),
            uv: [met.u, met.v],
            instance: met.instance as usize,
            vertex_nm: met.thickness_nm,
        };
        field.thickness_at(&place, self.is_on_mesh)
    }

    /// Optical path difference in nm that a thickness makes, at most.
    #[inline(always)]
    pub fn path_nm(&self, thickness_nm: f64) -> f64 {
        self.path_per_nm * thickness_nm
    }

    fn new(thickness: &ThicknessField, medium: &Medium, shape: &Shape) -> Result<LayerSurface, OpticsError> {
        let most = indices(medium, visible())?.iter().fold(0.0_f64, |most, n| most.max(n.re));
        Ok(LayerSurface {
            thickness: thickness.clone(),
            inner: None,
            is_on_mesh: matches!(shape, Shape::Mesh(_)),
            needs_place: thickness.needs_place(),
            path_per_nm: 2.0 * most,
            shown_index: shown_index(medium)?,
        })
    }

    fn longest_path_nm(&self) -> f64 {
        let inner = self.inner.as_ref().map_or(0.0, ThicknessField::max_nm);
        self.path_nm(self.thickness.max_nm().max(inner))
    }
}

/// A free film on an object.
pub struct FilmSurface {
    /// Number among the film tables.
    pub number: usize,
    pub layer: LayerSurface,
    /// The medium on both sides.
    pub outside: u8,
    /// `None`: a mirror.
    pub rough: Option<RoughSurface>,
}

/// A coated, or bare, surface of a medium.
pub struct CoatedSurface {
    /// Number among the coatings.
    pub number: usize,
    pub layers: Vec<LayerSurface>,
    pub substrate: u8,
    /// What enters the substrate is absorbed.
    pub is_opaque: bool,
    /// `None`: a mirror.
    pub rough: Option<RoughSurface>,
}

impl CoatedSurface {
    /// Light passes it without being scattered.
    pub fn is_glass(&self) -> bool {
        !self.is_opaque && self.rough.is_none()
    }
}

impl Material {
    /// The medium that fills the space behind.
    pub fn body(&self) -> Option<u8> {
        match self {
            Material::Coating(coating) => Some(coating.substrate),
            Material::Film(_) | Material::Diffuse { .. } | Material::Emitter(_) => None,
        }
    }

    /// Whether it sends light on in more than single directions, and so samples the lights.
    pub fn scatters(&self) -> bool {
        match self {
            Material::Film(film) => film.rough.is_some(),
            Material::Coating(coating) => coating.rough.is_some(),
            Material::Diffuse { is_black, .. } => !is_black,
            Material::Emitter(_) => false,
        }
    }

    /// Whether all light that comes to it goes on, if its media are clear.
    pub fn is_clear(&self, reflectances: &[DiffuseColor<'_>]) -> bool {
        match self {
            Material::Film(_) => true,
            Material::Coating(coating) => !coating.is_opaque,
            Material::Diffuse { number, .. } => matches!(reflectances[*number], DiffuseColor::Rgb([1.0, 1.0, 1.0])),
            Material::Emitter(_) => false,
        }
    }

    /// What share of the scene's mean light is expected from a surface: the estimate against which choices are made.
    /// Any would do, the better it is the less noise they make.
    pub fn expected_share(&self, reflectances: &[DiffuseColor<'_>]) -> f32 {
        match self {
            Material::Diffuse { number, .. } => reflectances[*number].mean() as f32,
            Material::Coating(coating) if coating.is_opaque => 0.5,
            Material::Emitter(_) => 0.0,
            Material::Film(_) | Material::Coating(_) => 1.0,
        }
    }

    pub fn longest_path_nm(&self) -> f64 {
        match self {
            Material::Film(film) => film.layer.longest_path_nm(),
            Material::Coating(coating) => coating.layers.iter().map(LayerSurface::longest_path_nm).sum(),
            Material::Diffuse { .. } | Material::Emitter(_) => 0.0,
        }
    }
}

/// What the objects are made of, in the order of their numbers.
#[derive(Default)]
pub struct Materials<'a> {
    pub list: Vec<Material>,
    pub films: Vec<(&'a Medium, u8)>,
    pub coatings: Vec<Vec<&'a Medium>>,
    pub diffuse: Vec<DiffuseColor<'a>>,
    pub emitters: Vec<(usize, &'a iridesce_scene::Emitter)>,
}

/// What a diffuse surface reflects.
pub enum DiffuseColor<'a> {
    Rgb([f64; 3]),
    Map(&'a Texture),
    Spectrum(&'a [(f64, f64)]),
}

impl DiffuseColor<'_> {
    /// At a wavelength in nm; of a picture, in the mean.
    pub fn at(&self, nm: f64) -> f64 {
        let of = |rgb: [f64; 3]| rgb_basis(nm).iter().zip(rgb).map(|(f, v)| f * v).sum();
        match self {
            DiffuseColor::Rgb(rgb) => of(*rgb),
            DiffuseColor::Map(texture) => of(texture.mean()),
            DiffuseColor::Spectrum(table) => held(table, nm),
        }
    }

    pub fn map(&self) -> Option<Texture> {
        match self {
            DiffuseColor::Map(texture) => Some((*texture).clone()),
            _ => None,
        }
    }

    pub fn mean(&self) -> f64 {
        match self {
            DiffuseColor::Rgb(rgb) => rgb.iter().sum::<f64>() / 3.0,
            DiffuseColor::Map(texture) => texture.mean().iter().sum::<f64>() / 3.0,
            DiffuseColor::Spectrum(table) => held(table, 560.0),
        }
    }
}

/// Of every object of a scene.
pub fn materials<'a>(scene: &'a ResolvedScene, media: &mut Media) -> Result<Materials<'a>, RenderError> {
    let mut all = Materials::default();
    for (object, described) in scene.recipe.objects.iter().enumerate() {
        let thicknesses = scene.layers(object);
        let rough = RoughSurface::new(scene.roughness(object), described);
        let mut coated =
            |mut layers: Vec<LayerSurface>, mut of: Vec<&'a Medium>, substrate: &Medium, is_metal, rough| {
                if let Some((film, thickness)) = scene.film_on_face(object) {
                    layers.insert(0, LayerSurface::new(thickness, &film.medium, &described.shape)?);
                    of.insert(0, &film.medium);
                }
                let substrate = number_of(media, substrate, described.priority)?;
                all.coatings.push(of);
                Ok::<_, RenderError>(Material::Coating(CoatedSurface {
                    number: all.coatings.len() - 1,
                    layers,
                    substrate,
                    is_opaque: is_metal || media.is_opaque(substrate),
                    rough,
                }))
            };
        let material = match &described.surface {
            Surface::Film(film) => {
                let outside = number_of(media, &film.outside, 0)?;
                all.films.push((&film.medium, outside));
                Material::Film(FilmSurface {
                    number: all.films.len() - 1,
                    layer: film_layer(thicknesses, &film.medium, &described.shape)?,
                    outside,
                    rough,
                })
            }
            Surface::Coating(coating) => {
                let layers = coating
                    .layers
                    .iter()
                    .zip(thicknesses)
                    .map(|(layer, thickness)| LayerSurface::new(thickness, &layer.medium, &described.shape))
                    .collect::<Result<_, _>>()?;
                let of = coating.layers.iter().map(|layer| &layer.medium).collect();
                coated(layers, of, &coating.substrate, false, rough)?
            }
            Surface::Dielectric(medium) => coated(Vec::new(), Vec::new(), medium, false, rough)?,
            Surface::Metal(medium) => coated(Vec::new(), Vec::new(), medium, true, rough)?,
            Surface::Diffuse(reflectance) => {
                let color = match (reflectance, scene.reflectance(object)) {
                    (_, Some(ResolvedReflectance::Map(texture))) => DiffuseColor::Map(texture),
                    (_, Some(ResolvedReflectance::Spectrum(table))) => DiffuseColor::Spectrum(table),
                    (Reflectance::Rgb(rgb), None) => DiffuseColor::Rgb(*rgb),
                    _ => unreachable!("a scene is resolved with its files"),
                };
                all.diffuse.push(color);
                Material::Diffuse {
                    number: all.diffuse.len() - 1,
                    is_black: matches!(reflectance, Reflectance::Rgb([0.0, 0.0, 0.0])),
                }
            }
            Surface::Emitter(emitter) => {
                all.emitters.push((object, emitter));
                Material::Emitter(all.emitters.len() - 1)
            }
        };
        all.list.push(material);
    }
    Ok(all)
}

/// The index of a medium where the path difference is told.
pub fn shown_index(medium: &Medium) -> Result<f64, OpticsError> {
    Ok(indices(medium, std::iter::once(SHOWN_NM))?[0].re)
}

/// The layer of a free film; of bubbles with walls of their own.
fn film_layer(thicknesses: &[ThicknessField], medium: &Medium, shape: &Shape) -> Result<LayerSurface, OpticsError> {
    let mut layer = LayerSurface::new(&thicknesses[0], medium, shape)?;
    layer.inner = thicknesses.get(1).cloned();
    layer.needs_place |= layer.inner.is_some();
    Ok(layer)
}

fn number_of(media: &mut Media, medium: &Medium, priority: i32) -> Result<u8, RenderError> {
    media.number(medium, priority)?.ok_or_else(|| {
        RenderError::Resource(format!(
            "the scene fills space with more than 255 different media, one of them \"{}\"",
            medium.name()
        ))
    })
}
