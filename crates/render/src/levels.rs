//! Everything that depends on wavelength, at the nodes of a render: the same spectra ever finer, until the fringes of the thickest
//! layer are resolved.

use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_optics::color::{Illuminant, rgb_basis};
use iridesce_optics::{Medium, OpticsError};
use iridesce_scene::{Light, ResolvedScene, ResolvedSource, Unit};

use crate::coating::IndexTable;
use crate::coherence::{LEAST_SEEN_NM, longest_seen_nm};
use crate::film::FilmTable;
use crate::framebuffer::RenderError;
use crate::lights::{EmittingObject, EnvironmentLight, Lights};
use crate::materials::{Material, Materials};
use crate::medium_stack::{Media, indices};
use crate::spectral::{Bands, FROM_NM, LEAST_NODES, MAX_NODES, Nodes, TO_NM, node_count, resolved_nm};

/// Everything that depends on wavelength, at one choice of nodes.
pub struct Spectra {
    pub nodes: Nodes,
    /// Longest optical path difference whose fringes the nodes resolve, nm.
    pub resolved_nm: f64,
    /// 2 / lambda, per nm.
    pub rate: Vec<Lanes>,
    pub films: Vec<FilmTable>,
    /// Layers of the coatings, in order.
    pub coatings: Vec<Vec<IndexTable>>,
    pub media: Vec<IndexTable>,
    /// By what the media attenuate: powers of 1/2 per scene unit. `None` for clear ones.
    pub attenuation: Vec<Option<Vec<Lanes>>>,
    /// Reflectances of the diffuse surfaces.
    pub diffuse: Vec<Vec<Lanes>>,
    /// Reflectance of red, green and blue.
    pub rgb_basis: [Vec<Lanes>; 3],
    pub lights: Lights,
    /// Luminance of a path's s and p weights; sums to 1/2.
    pub importance: Vec<Lanes>,
    pub bands: Bands,
    /// Where nothing but a few lines shines, some of it evenly from all around: light that is met by branches alone.
    pub lines: Option<Lines>,
}

/// More lines than these are as good as a continuous spectrum, whose fringes are summed over it.
const MOST_LINES: usize = LANES;

/// Layers and media at lines, a block for each: in the lanes stands what else differs.
pub struct Lines {
    pub rate: Vec<Lanes>,
    pub coatings: Vec<Vec<IndexTable>>,
    pub media: Vec<IndexTable>,
    /// Luminance of the s and p weights of each.
    pub importance: Vec<f32>,
}

impl Lines {
    fn new(
        nodes: &Nodes,
        media: &Media,
        materials: &Materials<'_>,
        importance: &[Lanes],
    ) -> Result<Lines, OpticsError> {
        let lines = nodes.lines();
        let each = || lines.iter().flat_map(|nm| [*nm; LANES]);
        let table = |medium: &Medium| indices(medium, each()).map(|n| IndexTable::new(&n));
        let tables = |layers: &Vec<&Medium>| layers.iter().map(|medium| table(medium)).collect::<Result<_, _>>();
        Ok(Lines {
            rate: blocks(each().map(|nm| 2.0 / nm)),
            coatings: materials.coatings.iter().map(tables).collect::<Result<_, _>>()?,
            media: media.list().iter().map(table).collect::<Result<_, _>>()?,
            importance: (0..lines.len()).map(|line| importance[line / LANES].0[line % LANES]).collect(),
        })
    }
}

impl Spectra {
    /// Whether no medium, layer or film absorbs anything.
    pub fn is_clear(&self) -> bool {
        self.attenuation.iter().all(Option::is_none)
            && self.films.iter().all(FilmTable::is_clear)
            && self.coatings.iter().flatten().all(IndexTable::is_clear)
    }
}

/// What of the light is the same whatever the nodes are.
pub struct Lit<'a> {
    pub around: EnvironmentLight,
    /// In the order of their numbers.
    pub emitters: Vec<EmittingObject<'a>>,
    /// Places of the scene that the picture shows, where lights are compared.
    pub places: Vec<Vec3>,
}

/// Up to which path difference fringes of films are seen, nm, and the choices of nodes, ever finer, until those of the
/// thickest layer are resolved.
pub fn levels_for(scene: &ResolvedScene, materials: &Materials<'_>) -> Result<(f64, Vec<Nodes>), RenderError> {
    let mut lines = Vec::new();
    let mut continuous = Vec::new();
    // What shines through is told of white light.
    let is_continuous = !scene.recipe.render.has_backdrop;
    let mut see = |illuminant: &Illuminant, radiance: f64| {
        if radiance > 0.0 {
            lines.extend(illuminant.lines().iter().map(|line| line.0));
            if (FROM_NM as u32..=TO_NM as u32).any(|nm| illuminant.power(f64::from(nm)) > 0.0) {
                continuous.push(illuminant.clone());
            }
        }
    };
    let mut has_map = false;
    for environment in &scene.environments {
        match &environment.source {
            ResolvedSource::Uniform(illuminant) => see(illuminant, environment.radiance),
            ResolvedSource::Map(_) | ResolvedSource::Sky(..) => has_map = true,
        }
    }
    for light in &scene.recipe.lights {
        match light {
            Light::Environment(_) => {}
            Light::Sun(sun) => see(&sun.illuminant, sun.radiance),
            Light::Delta(delta) => see(&delta.illuminant, delta.power),
        }
    }
    for (_, emitter) in &materials.emitters {
        see(&emitter.illuminant, emitter.radiance);
    }
    // Under lines alone nothing between them is seen, however fine the fringes are.
    if continuous.is_empty() && !(is_continuous || has_map || lines.is_empty()) {
        return Ok((f64::INFINITY, vec![Nodes::new(0, &lines)]));
    }
    let is_film = |material: &&Material| matches!(material, Material::Film(_));
    let thickest = materials.list.iter().filter(is_film).map(Material::longest_path_nm).fold(0.0, f64::max);
    let mut seen_nm = f64::INFINITY;
    if thickest > LEAST_SEEN_NM {
        continuous.push(Illuminant::named("D65")?);
        seen_nm = longest_seen_nm(&continuous);
    }
    let mut longest_nm = 0.0_f64;
    for (object, material) in scene.recipe.objects.iter().zip(&materials.list) {
        let own_nm = material.longest_path_nm();
        let path_nm = if is_film(&material) { own_nm.min(seen_nm) } else { own_nm };
        let wanted = node_count(path_nm);
        if wanted > MAX_NODES {
            return Err(RenderError::Resource(format!(
                "the layers of object \"{}\" make optical path differences up to {path_nm:.0} nm; under a continuous spectrum a render resolves the \
                 fringes of at most {:.0} nm",
                object.name,
                resolved_nm(MAX_NODES)
            )));
        }
        longest_nm = longest_nm.max(path_nm);
    }
    let finest = node_count(longest_nm);
    let mut counts = vec![LEAST_NODES];
    while counts[counts.len() - 1] < finest {
        // 32, 48, 64, 96, 128, ..
        let last = counts[counts.len() - 1];
        counts.push(if last.is_power_of_two() { last / 2 * 3 } else { last / 3 * 4 });
    }
    Ok((seen_nm, counts.into_iter().map(|count| Nodes::new(count, &lines)).collect()))
}

/// All spectra at a choice of nodes.
pub fn spectra(
    scene: &ResolvedScene,
    nodes: &Nodes,
    media: &Media,
    materials: &Materials<'_>,
    lit: &Lit<'_>,
) -> Result<Spectra, OpticsError> {
    let at_nodes = |medium: &Medium| indices(medium, nodes.wavelength_nm.iter().copied());
    let mut films = Vec::new();
    for (medium, outside) in &materials.films {
        let outer: Vec<f64> = at_nodes(&media.list()[usize::from(*outside)])?.iter().map(|n| n.re).collect();
        films.push(FilmTable::new(nodes, &at_nodes(medium)?, &outer));
    }
    let table = |medium: &Medium| at_nodes(medium).map(|n| IndexTable::new(&n));
    let mut coatings = Vec::new();
    for layers in &materials.coatings {
        coatings.push(layers.iter().map(|medium| table(medium)).collect::<Result<Vec<_>, _>>()?);
    }
    let nm_per_unit = match scene.recipe.unit {
        Unit::M => 1e9,
        Unit::Cm => 1e7,
        Unit::Mm => 1e6,
    };
    let mut attenuation = Vec::new();
    for medium in media.list() {
        let n = at_nodes(medium)?;
        // exp(-4 pi k x / lambda) as a power of 1/2.
        let per_unit = n
            .iter()
            .zip(&nodes.wavelength_nm)
            .map(|(n, nm)| 4.0 * std::f64::consts::PI * n.im / nm * nm_per_unit * std::f64::consts::LOG2_E);
        attenuation.push(n.iter().any(|n| n.im > 0.0).then(|| blocks(per_unit)));
    }
    let diffuse = materials.diffuse.iter().map(|color| blocks(nodes.wavelength_nm.iter().map(|&nm| color.at(nm))));
    let basis = |channel: usize| blocks(nodes.wavelength_nm.iter().map(|&nm| rgb_basis(nm)[channel]));
    let lights = Lights::new(scene, nodes, &lit.around, &lit.emitters)?;
    let importance = lights.importance(&lit.places);
    Ok(Spectra {
        nodes: nodes.clone(),
        resolved_nm: resolved_nm(nodes.uniform()),
        rate: blocks(nodes.wavelength_nm.iter().map(|nm| 2.0 / nm)),
        films,
        coatings,
        media: media.list().iter().map(table).collect::<Result<_, _>>()?,
        attenuation,
        diffuse: diffuse.collect(),
        rgb_basis: [basis(0), basis(1), basis(2)],
        bands: Bands::new(nodes, &lights.color_importance(&lit.places)),
        lines: match nodes.uniform() {
            0 if nodes.lines().len() <= MOST_LINES && !lights.are_all_sampled() => {
                Some(Lines::new(nodes, media, materials, &importance)?)
            }
            _ => None,
        },
        importance,
        lights,
    })
}
