//! Models as maps.

use crate::error::ThicknessError;
use crate::map::{ThicknessMap, check_size, mix};
use crate::model::ThicknessModel;

/// Samples at the middles of the cells of a grid over an extent `[left, right, bottom, top]`, row 0 on top.
fn sampled(
    width: usize,
    height: usize,
    extent: [f64; 4],
    at: impl Fn(f64, f64) -> f64,
) -> Result<ThicknessMap, ThicknessError> {
    check_size(width, height)?;
    let [left, right, bottom, top] = extent;
    if !extent.iter().all(|x| x.is_finite()) || left == right || bottom == top {
        let allowed = "four finite numbers, left, right, bottom and top, with an area";
        return Err(ThicknessError::new("extent", allowed, format!("{extent:?}")));
    }
    let mut thickness_nm = Vec::with_capacity(width * height);
    for row in 0..height {
        let y = mix(top, bottom, (row as f64 + 0.5) / height as f64);
        thickness_nm.extend((0..width).map(|column| at(mix(left, right, (column as f64 + 0.5) / width as f64), y)));
    }
    ThicknessMap::new(width, height, thickness_nm)
}

impl ThicknessModel {
    /// The model on a grid, sampled at the middles of its cells.
    ///
    /// A gradient's grid spans its relative height, a map's its own; both take no extent. A wedge and a lens's gap need
    /// one, `[left, right, bottom, top]`: for a wedge in x and y of the scene, at z = 0; for a gap in mm from the point
    /// where it is narrowest.
    pub fn map(&self, width: usize, height: usize, extent: Option<[f64; 4]>) -> Result<ThicknessMap, ThicknessError> {
        let wrong = |allowed: &'static str| Err(ThicknessError::new("extent", allowed, format!("{extent:?}")));
        let extent = match (self, extent) {
            (ThicknessModel::Wedge(_) | ThicknessModel::LensGap(_), Some(extent)) => extent,
            (ThicknessModel::Wedge(_), None) => {
                return wrong("the part of the scene to show, left, right, bottom and top in x and y");
            }
            (ThicknessModel::LensGap(_), None) => {
                return wrong("the part of the gap to show, left, right, bottom and top in mm from its middle");
            }
            (_, None) => [0.0, 1.0, 0.0, 1.0],
            (_, Some(_)) => {
                return wrong("left out: it is for a wedge or a lens's gap; this model spans the whole object");
            }
        };
        sampled(width, height, extent, |x, y| match self {
            ThicknessModel::Uniform { thickness_nm } => *thickness_nm,
            ThicknessModel::Gradient(gradient) => gradient.at_height(y),
            ThicknessModel::Wedge(wedge) => wedge.at_point([x, y, 0.0]),
            ThicknessModel::LensGap(gap) => gap.at_square(x * x + y * y),
            ThicknessModel::Map(map) => map.sample(x, y),
            ThicknessModel::Flow(field) => field.sample(x, y),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{Gradient, LensGap, Wedge};

    #[test]
    fn models_give_maps_that_agree_with_them() {
        let gradient = Gradient::new(20.0, 900.0, 0.7).unwrap();
        let map = ThicknessModel::Gradient(gradient).map(3, 50, None).unwrap();
        assert_eq!((map.width(), map.height(), map.thickness_nm().len()), (3, 50, 150));
        assert_eq!(map.thickness_nm()[0], gradient.at_height(0.99));
        assert_eq!(map.thickness_nm()[149], gradient.at_height(0.01));
        // Linear interpolation of t = 900 - 880 s^0.7 errs by at most h^2 / 8 |t''|, largest towards s = 0.
        for i in 10..=98 {
            let s = f64::from(i) / 100.0;
            let bound = 0.02 * 0.02 / 8.0 * 880.0 * 0.21 * (s - 0.02).powf(-1.3) + 1e-9;
            assert!((map.sample(0.3, s) - gradient.at_height(s)).abs() <= bound, "{s}");
        }
        let uniform = ThicknessModel::uniform(320.0).unwrap().map(2, 1, None).unwrap();
        assert_eq!(uniform.into_thickness_nm(), [320.0, 320.0]);
    }

    #[test]
    fn wedges_and_gaps_need_an_extent_and_others_take_none() {
        let wedge = ThicknessModel::Wedge(Wedge::new([0.0; 3], [4.0, 0.0, 0.0], 0.0, 400.0).unwrap());
        let map = wedge.map(4, 1, Some([0.0, 4.0, -1.0, 1.0])).unwrap();
        assert_eq!(map.thickness_nm(), [50.0, 150.0, 250.0, 350.0]);
        let up = ThicknessModel::Wedge(Wedge::new([0.0; 3], [0.0, 1.0, 0.0], 0.0, 400.0).unwrap());
        assert_eq!(up.map(1, 2, Some([0.0, 1.0, 0.0, 1.0])).unwrap().thickness_nm(), [300.0, 100.0], "row 0 on top");
        let gap = LensGap::new(1000.0, 10.0).unwrap();
        let map = ThicknessModel::LensGap(gap).map(3, 3, Some([-3.0, 3.0, -3.0, 3.0])).unwrap();
        let (side, corner) = (gap.at_radius(2.0), gap.at_square(8.0));
        assert_eq!(map.thickness_nm(), [corner, side, corner, side, 10.0, side, corner, side, corner]);
        let grid = ThicknessModel::Map(Arc::new(ThicknessMap::new(2, 1, vec![0.0, 100.0]).unwrap()));
        assert_eq!(grid.map(4, 1, None).unwrap().thickness_nm(), [0.0, 25.0, 75.0, 100.0]);
        for model in [&wedge, &ThicknessModel::LensGap(gap)] {
            assert_eq!(model.map(2, 2, None).unwrap_err().argument, "extent");
            for bad in [[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 2.0, 2.0], [0.0, f64::NAN, 0.0, 1.0]] {
                assert_eq!(model.map(2, 2, Some(bad)).unwrap_err().argument, "extent");
            }
        }
        for model in [&grid, &ThicknessModel::uniform(1.0).unwrap()] {
            assert_eq!(model.map(2, 2, Some([0.0, 1.0, 0.0, 1.0])).unwrap_err().argument, "extent");
        }
    }
}
