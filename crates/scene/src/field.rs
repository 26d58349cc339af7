//! The thickness of a layer over the shape it lies on.

use iridesce_thickness::ThicknessModel;

use crate::model::{Shape, Unit};

/// A thickness model laid over a shape: a thickness in nm for every point of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ThicknessField {
    model: ThicknessModel,
    /// Lowest point of the shape and one over its height, scene units.
    y_min: f64,
    per_height: f64,
}

impl ThicknessField {
    /// Lays a model over a shape; the message says why the two do not go together.
    pub fn new(model: ThicknessModel, shape: &Shape, _unit: Unit) -> Result<ThicknessField, String> {
        let Shape::Sphere { center, radius } = *shape else {
            return Err("only spheres carry films so far".to_owned());
        };
        Ok(ThicknessField { model, y_min: center[1] - radius, per_height: 0.5 / radius })
    }

    /// Thickness in nm at a point of the shape.
    #[inline(always)]
    pub fn thickness_nm(&self, point: [f64; 3]) -> f64 {
        match self.model {
            ThicknessModel::Uniform { thickness_nm } => thickness_nm,
            _ => self.model.at_height((point[1] - self.y_min) * self.per_height),
        }
    }

    /// The largest thickness in nm that it gives.
    pub fn max_nm(&self) -> f64 {
        self.model.max_nm()
    }

    /// The model.
    pub fn model(&self) -> &ThicknessModel {
        &self.model
    }
}
