//! Thickness models: a thickness in nm as a function of place.

use std::sync::Arc;

use crate::error::{ThicknessError, check_nm};
use crate::flow_field::FlowField;
use crate::gradient::Gradient;
use crate::lens_gap::LensGap;
use crate::map::ThicknessMap;
use crate::wedge::Wedge;

/// A film's thickness over an object.
#[derive(Debug, Clone, PartialEq)]
pub enum ThicknessModel {
    /// The same everywhere.
    Uniform {
        /// Thickness in nm, >= 0.
        thickness_nm: f64,
    },
    /// A power law in height.
    Gradient(Gradient),
    /// Linear between two points of the scene.
    Wedge(Wedge),
    /// The gap under a lens, around the object's centre.
    LensGap(LensGap),
    /// A grid laid over the object by its u and v.
    Map(Arc<ThicknessMap>),
    /// A film that has flowed, laid over the object by its u and v.
    Flow(Arc<FlowField>),
}

impl ThicknessModel {
    /// The same thickness everywhere, nm, >= 0 and finite.
    pub fn uniform(thickness_nm: f64) -> Result<ThicknessModel, ThicknessError> {
        check_nm("thickness_nm", thickness_nm)?;
        Ok(ThicknessModel::Uniform { thickness_nm })
    }

    /// A [`Gradient`] as a model.
    pub fn gradient(top_nm: f64, bottom_nm: f64, exponent: f64) -> Result<ThicknessModel, ThicknessError> {
        Gradient::new(top_nm, bottom_nm, exponent).map(ThicknessModel::Gradient)
    }

    /// A [`Wedge`] as a model.
    pub fn wedge(from: [f64; 3], to: [f64; 3], start_nm: f64, end_nm: f64) -> Result<ThicknessModel, ThicknessError> {
        Wedge::new(from, to, start_nm, end_nm).map(ThicknessModel::Wedge)
    }

    /// A [`LensGap`] as a model.
    pub fn lens_gap(radius_mm: f64, contact_gap_nm: f64) -> Result<ThicknessModel, ThicknessError> {
        LensGap::new(radius_mm, contact_gap_nm).map(ThicknessModel::LensGap)
    }

    /// The largest thickness in nm that the model can give; a lens's gap is counted to the full radius of its sphere.
    pub fn max_nm(&self) -> f64 {
        match self {
            ThicknessModel::Uniform { thickness_nm } => *thickness_nm,
            ThicknessModel::Gradient(gradient) => gradient.max_nm(),
            ThicknessModel::Wedge(wedge) => wedge.max_nm(),
            ThicknessModel::LensGap(gap) => gap.max_nm(),
            ThicknessModel::Map(map) => map.max_nm(),
            ThicknessModel::Flow(field) => field.max_nm(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_films_are_refused_by_name() {
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(ThicknessModel::uniform(bad).unwrap_err().argument, "thickness_nm");
        }
    }
}
