//! The thickness of a layer over the shape it lies on.

use std::sync::Arc;

use crate::affine::Affine;
use iridesce_files::Mesh;
use iridesce_numerics::vector::{difference, dot, length, scaled};
use iridesce_thickness::{FlowField, Gradient, LensGap, ThicknessMap, ThicknessModel, Wedge};

use crate::model::{Shape, Unit, UvMap};
use crate::shape::Chart;

/// Height, as a share of a shape's reach, below which it counts as level: what is left is rounding.
const LEVEL: f64 = 1e-9;
/// A lens's gap may end where its sphere does, and no rounding beyond.
const ROUNDING: f64 = 1e-12;

/// A thickness model laid over a shape: a thickness in nm for every point of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ThicknessField {
    model: ThicknessModel,
    laid: Laid,
    max_nm: f64,
    /// How u and v of the shape become those of maps.
    uv: UvMap,
    /// It cannot be asked with a point of the world alone.
    needs_place: bool,
    /// Of every instance, where there are several and they differ.
    instances: Vec<Foot>,
}

/// What a law must know of one instance: its lowest and its highest point, its middle and the axis through it.
#[derive(Debug, Clone, PartialEq)]
struct Foot {
    heights: [f64; 2],
    center: [f64; 3],
    axis: Option<[f64; 3]>,
}

/// What a thickness is laid over.
pub struct Ground<'a> {
    /// The shape.
    pub shape: &'a Shape,
    /// What its file holds, if it is a mesh.
    pub mesh: Option<&'a Mesh>,
    /// Where it is put, once for each.
    pub placements: &'a [Affine],
    /// How maps lie on it.
    pub uv: UvMap,
}

/// A place of an object.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// In the world.
    pub point: [f64; 3],
    /// In the space of the object's shape.
    pub local: [f64; 3],
    /// As maps are asked.
    pub uv: [f64; 2],
    /// Which instance.
    pub instance: usize,
    /// What the vertices around say, nm.
    pub vertex_nm: f64,
}

impl Ground<'_> {
    /// A foot for every instance; `None` for what has no end.
    fn feet(&self) -> Option<Vec<Foot>> {
        self.placements.iter().map(|by| self.foot(by)).collect()
    }

    fn foot(&self, by: &Affine) -> Option<Foot> {
        let row = by.rows[1];
        let along = [row[0], row[1], row[2]];
        let span = match self.mesh {
            None => self.shape.span(along)?,
            Some(mesh) => {
                let heights = mesh.positions.iter().map(|p| dot(along, *p));
                heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)])
            }
        };
        let (center, axis) = match self.mesh {
            None => self.shape.middle(),
            Some(mesh) => (box_middle(mesh), None),
        };
        let axis = axis.map(|axis| {
            let turned = by.inverse().map_or(axis, |back| back.transposed(axis));
            scaled(turned, 1.0 / length(turned))
        });
        Some(Foot { heights: [span[0] + row[3], span[1] + row[3]], center: by.point(center), axis })
    }

    /// Not less than the farthest that any instance reaches from its middle.
    fn reach(&self) -> Option<f64> {
        let own = match self.mesh {
            None => self.shape.reach()?,
            Some(mesh) => {
                let middle = box_middle(mesh);
                mesh.positions.iter().map(|p| length(difference(*p, middle))).fold(0.0, f64::max)
            }
        };
        let scale = |by: &Affine| by.similarity().unwrap_or_else(|| by.stretch());
        Some(self.placements.iter().map(scale).fold(0.0, f64::max) * own)
    }

    fn is_plain(&self) -> bool {
        self.mesh.is_none() && *self.placements == [Affine::IDENTITY] && self.uv == UvMap::default()
    }
}

/// The middle of the box around a mesh.
fn box_middle(mesh: &Mesh) -> [f64; 3] {
    let mut ends = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for position in &mesh.positions {
        for i in 0..3 {
            ends[0][i] = ends[0][i].min(position[i]);
            ends[1][i] = ends[1][i].max(position[i]);
        }
    }
    std::array::from_fn(|i| 0.5 * (ends[0][i] + ends[1][i]))
}

/// A model with what it must know of the shape.
#[derive(Debug, Clone, PartialEq)]
enum Laid {
    Uniform(f64),
    /// By height: from the lowest point of the shape, times one over its height.
    Gradient {
        gradient: Gradient,
        y_min: f64,
        per_height: f64,
    },
    Wedge(Wedge),
    /// By the square of the distance in mm from the shape's middle, or from the axis through it.
    LensGap {
        gap: LensGap,
        center: [f64; 3],
        axis: Option<[f64; 3]>,
        square_mm: f64,
    },
    Map(Arc<ThicknessMap>, Chart),
    Flow(Arc<FlowField>, Chart),
    /// By the vertices of a mesh.
    Vertex,
}

impl Laid {
    fn gradient(gradient: Gradient, ground: &Ground<'_>, feet: Option<&[Foot]>) -> Result<Laid, String> {
        let heights = match feet {
            Some(feet) => feet.first().map(|foot| foot.heights),
            None => ground.shape.heights(),
        };
        let (Some([bottom, top]), Some(reach)) = (heights, ground.reach()) else {
            return Err("cannot be a gradient on a plane, which has no lowest and no highest point; a wedge \
                        runs between two points of your choice"
                .to_owned());
        };
        let is_level = |[bottom, top]: [f64; 2]| top - bottom <= LEVEL * reach;
        if is_level([bottom, top]) || feet.into_iter().flatten().any(|foot| is_level(foot.heights)) {
            return Err("cannot be a gradient on a shape that lies level and has no height; a wedge runs \
                        between two points of your choice"
                .to_owned());
        }
        Ok(Laid::Gradient { gradient, y_min: bottom, per_height: 1.0 / (top - bottom) })
    }

    /// The gap, and how wide it is at the rim of the shape.
    fn lens_gap(gap: LensGap, ground: &Ground<'_>, feet: Option<&[Foot]>, unit: Unit) -> Result<(Laid, f64), String> {
        let (center, axis) = match feet.and_then(<[Foot]>::first) {
            Some(foot) => (foot.center, foot.axis),
            None => ground.shape.middle(),
        };
        let Some(reach) = ground.reach() else {
            return Err("cannot be a lens_gap on a plane, which is wider than any lens".to_owned());
        };
        let reach_mm = reach * unit.millimetres();
        if reach_mm > gap.radius_mm() * (1.0 + ROUNDING) {
            return Err(format!(
                "cannot be a lens_gap of radius_mm {:?} on a shape that reaches {reach_mm:?} mm from its middle, past \
                 the sphere",
                gap.radius_mm()
            ));
        }
        let laid = Laid::LensGap { gap, center, axis, square_mm: unit.millimetres().powi(2) };
        Ok((laid, gap.at_radius(reach_mm)))
    }

    fn flow(field: &Arc<FlowField>, shape: &Shape) -> Laid {
        let chart = match *shape {
            // A dome lies on its sphere, whatever else is laid over it by its rim.
            Shape::Cap { center, axis, radius_of_curvature, .. } if field.is_globe() => {
                Chart::Globe { center: difference(center, scaled(axis, radius_of_curvature)) }
            }
            _ => Chart::new(shape),
        };
        Laid::Flow(field.clone(), chart)
    }
}

impl ThicknessField {
    /// Lays a model over a shape; the message says why the two do not go together.
    pub fn new(model: ThicknessModel, shape: &Shape, unit: Unit) -> Result<ThicknessField, String> {
        let ground = Ground { shape, mesh: None, placements: &[Affine::IDENTITY], uv: UvMap::default() };
        ThicknessField::over(model, &ground, unit)
    }

    /// What the vertices of a mesh say.
    pub fn of_vertices(mesh: &Mesh) -> Result<ThicknessField, String> {
        let Some(thickness_nm) = &mesh.thickness_nm else {
            return Err("cannot be \"vertex\": the mesh has no vertex property thickness_nm, which PLY files may have"
                .to_owned());
        };
        let max_nm = thickness_nm.iter().fold(0.0, |most: f64, nm| most.max(f64::from(*nm)));
        let model = ThicknessModel::uniform(max_nm).map_err(|e| e.rule())?;
        let uv = UvMap::default();
        Ok(ThicknessField { model, laid: Laid::Vertex, max_nm, uv, needs_place: true, instances: Vec::new() })
    }

    /// Lays a model over a shape where it is put; the message says why the two do not go together.
    pub fn over(model: ThicknessModel, ground: &Ground<'_>, unit: Unit) -> Result<ThicknessField, String> {
        let shape = ground.shape;
        let is_plain = ground.is_plain();
        let by_uv = matches!(model, ThicknessModel::Map(_) | ThicknessModel::Flow(_));
        if by_uv && ground.mesh.is_some_and(|mesh| mesh.uv.is_none()) {
            return Err("cannot be a map on this mesh, whose file has no texture coordinates".to_owned());
        }
        let feet = match &model {
            ThicknessModel::Gradient(_) | ThicknessModel::LensGap(_) if !is_plain => ground.feet(),
            _ => None,
        };
        let mut max_nm = model.max_nm();
        let laid = match &model {
            ThicknessModel::Uniform { thickness_nm } => Laid::Uniform(*thickness_nm),
            ThicknessModel::Gradient(gradient) => Laid::gradient(*gradient, ground, feet.as_deref())?,
            ThicknessModel::Wedge(wedge) => Laid::Wedge(*wedge),
            ThicknessModel::LensGap(gap) => {
                let (laid, rim_nm) = Laid::lens_gap(*gap, ground, feet.as_deref(), unit)?;
                max_nm = rim_nm;
                laid
            }
            ThicknessModel::Map(map) => Laid::Map(map.clone(), Chart::new(shape)),
            ThicknessModel::Flow(field) => Laid::flow(field, shape),
        };
        let instances = feet.filter(|feet| feet.len() > 1).unwrap_or_default();
        let needs_place = by_uv && !is_plain || !instances.is_empty();
        Ok(ThicknessField { model, laid, max_nm, uv: ground.uv, needs_place, instances })
    }

    /// Thickness in nm at a point of the shape.
    #[inline]
    pub fn thickness_nm(&self, point: [f64; 3]) -> f64 {
        match &self.laid {
            Laid::Uniform(thickness_nm) => *thickness_nm,
            Laid::Gradient { gradient, y_min, per_height } => gradient.at_height((point[1] - y_min) * per_height),
            Laid::Wedge(wedge) => wedge.at_point(point),
            Laid::LensGap { gap, center, axis, square_mm } => {
                let mut way = difference(point, *center);
                if let Some(axis) = axis {
                    way = difference(way, scaled(*axis, dot(way, *axis)));
                }
                gap.at_square(dot(way, way) * square_mm)
            }
            Laid::Map(map, chart) => {
                let [u, v] = chart.uv(point);
                map.sample_with(u, v, chart.repeats())
            }
            Laid::Flow(field, chart) => {
                let [u, v] = chart.uv(point);
                field.sample(u, v)
            }
            Laid::Vertex => self.max_nm,
        }
    }

    /// Whether a point of the world alone does not tell: [`ThicknessField::thickness_at`] does.
    #[inline(always)]
    pub fn needs_place(&self) -> bool {
        self.needs_place
    }

    /// Thickness in nm at a place of an object that is moved, there several times, or a mesh (`is_mesh`).
    pub fn thickness_at(&self, place: &Place, is_mesh: bool) -> f64 {
        let uv = |chart: &Chart| if is_mesh { place.uv } else { self.uv.of(chart.uv(place.local)) };
        let foot = self.instances.get(place.instance);
        match (&self.laid, foot) {
            (Laid::Gradient { gradient, .. }, Some(Foot { heights: [low, high], .. })) => {
                gradient.at_height((place.point[1] - low) / (high - low))
            }
            (Laid::LensGap { gap, square_mm, .. }, Some(foot)) => {
                let mut way = difference(place.point, foot.center);
                if let Some(axis) = foot.axis {
                    way = difference(way, scaled(axis, dot(way, axis)));
                }
                gap.at_square(dot(way, way) * square_mm)
            }
            (Laid::Map(map, chart), _) => {
                let [u, v] = uv(chart);
                let repeats = is_mesh || self.uv != UvMap::default();
                map.sample_with(u, v, if repeats { [true, true] } else { chart.repeats() })
            }
            (Laid::Flow(field, chart), _) => {
                let [u, v] = uv(chart);
                field.sample(u, v)
            }
            (Laid::Vertex, _) => place.vertex_nm,
            _ => self.thickness_nm(place.point),
        }
    }

    /// The largest thickness in nm that it gives.
    pub fn max_nm(&self) -> f64 {
        self.max_nm
    }

    /// The model.
    pub fn model(&self) -> &ThicknessModel {
        &self.model
    }
}
