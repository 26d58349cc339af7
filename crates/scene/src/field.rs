//! The thickness of a layer over the shape it lies on.

use std::sync::Arc;

use iridesce_numerics::vector::{difference, dot, scaled};
use iridesce_thickness::{FlowField, Gradient, LensGap, ThicknessMap, ThicknessModel, Wedge};

use crate::model::{Shape, Unit};
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
}

impl ThicknessField {
    /// Lays a model over a shape; the message says why the two do not go together.
    pub fn new(model: ThicknessModel, shape: &Shape, unit: Unit) -> Result<ThicknessField, String> {
        let mut max_nm = model.max_nm();
        let laid = match &model {
            ThicknessModel::Uniform { thickness_nm } => Laid::Uniform(*thickness_nm),
            ThicknessModel::Gradient(gradient) => {
                let (Some([bottom, top]), Some(reach)) = (shape.heights(), shape.reach()) else {
                    return Err("cannot be a gradient on a plane, which has no lowest and no highest point; a wedge \
                                runs between two points of your choice"
                        .to_owned());
                };
                if top - bottom <= LEVEL * reach {
                    return Err("cannot be a gradient on a shape that lies level and has no height; a wedge runs \
                                between two points of your choice"
                        .to_owned());
                }
                Laid::Gradient { gradient: *gradient, y_min: bottom, per_height: 1.0 / (top - bottom) }
            }
            ThicknessModel::Wedge(wedge) => Laid::Wedge(*wedge),
            ThicknessModel::LensGap(gap) => {
                let (center, axis) = match *shape {
                    Shape::Sphere { center, .. } | Shape::Rectangle { center, .. } | Shape::Disk { center, .. } => {
                        (center, None)
                    }
                    Shape::Cap { center, axis, .. } => (center, Some(axis)),
                    Shape::Plane { point, .. } => (point, None),
                };
                let Some(reach) = shape.reach() else {
                    return Err("cannot be a lens_gap on a plane, which is wider than any lens".to_owned());
                };
                let reach_mm = reach * unit.millimetres();
                if reach_mm > gap.radius_mm() * (1.0 + ROUNDING) {
                    return Err(format!(
                        "cannot be a lens_gap of radius_mm {:?} on a shape that reaches {reach_mm:?} mm from its middle, \
                         past the sphere",
                        gap.radius_mm()
                    ));
                }
                max_nm = gap.at_radius(reach_mm);
                Laid::LensGap { gap: *gap, center, axis, square_mm: unit.millimetres().powi(2) }
            }
            ThicknessModel::Map(map) => Laid::Map(map.clone(), Chart::new(shape)),
            ThicknessModel::Flow(field) => {
                let chart = match *shape {
                    // A dome lies on its sphere, whatever else is laid over it by its rim.
                    Shape::Cap { center, axis, radius_of_curvature, .. } if field.is_globe() => {
                        Chart::Globe { center: difference(center, scaled(axis, radius_of_curvature)) }
                    }
                    _ => Chart::new(shape),
                };
                Laid::Flow(field.clone(), chart)
            }
        };
        Ok(ThicknessField { model, laid, max_nm })
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
