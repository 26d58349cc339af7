//! A film as it is seen from outside: in a few numbers, row by row, as a map and as a field.

use iridesce_thickness::{FlowField, ThicknessError, ThicknessMap};

use super::{Film, State, Summary};
use crate::grid::Shape;
use crate::share::rest;

impl Film {
    /// Volume of the film, m3.
    pub fn volume(&self) -> f64 {
        self.grid.integral(&self.state.h)
    }

    /// How thick it is and where its liquid went.
    pub fn summary(&self) -> Summary {
        let (grid, h) = (&self.grid, &self.state.h);
        let area = grid.total_area();
        let below = self.parameters.black_below_m;
        let black: Vec<f64> = match self.share_and_rest() {
            None => h.iter().map(|&h| f64::from(u8::from(h < below))).collect(),
            Some((share, rest)) => {
                let black = |(phi, rest): (&f64, f64)| if rest < below { 1.0 } else { *phi };
                share.iter().zip(rest).map(black).collect()
            }
        };
        let books = self.state.books;
        // A rounding below zero is none: what a spot frees may come back.
        let share = |volume: f64| (volume / books.start).max(0.0);
        Summary {
            time_s: self.state.time_s,
            mean_nm: self.volume() / area * 1e9,
            min_nm: h.iter().copied().fold(f64::INFINITY, f64::min) * 1e9,
            max_nm: h.iter().copied().fold(0.0, f64::max) * 1e9,
            black_share: grid.integral(&black) / area,
            evaporated: share(books.evaporated),
            swallowed: share(books.swallowed),
            blackened: share(books.blackened),
            drained: share(books.drained),
        }
    }

    /// Row by row from the top: height of its middle above the lowest place of the film, m; mean, least and greatest
    /// thickness, nm.
    pub fn profile(&self) -> Vec<[f64; 4]> {
        let grid = &self.grid;
        let lowest = match self.parameters.shape {
            Shape::Sphere { radius_m, rim_deg } => radius_m * rim_deg.to_radians().cos(),
            Shape::Plane { .. } => 0.0,
        };
        let rows = self.state.h.chunks_exact(grid.columns).zip(&grid.height);
        rows.map(|(row, height)| {
            let mean = row.iter().sum::<f64>() / grid.columns as f64;
            let least = row.iter().copied().fold(f64::INFINITY, f64::min);
            let most = row.iter().copied().fold(0.0, f64::max);
            [height - lowest, mean * 1e9, least * 1e9, most * 1e9]
        })
        .collect()
    }

    /// Share of each cell that is black film and thickness of the rest, m, if any is; the rest of a cell that is all black is as
    /// thick as the cell.
    fn share_and_rest(&self) -> Option<(&[f64], Vec<f64>)> {
        let State { h, black, .. } = &self.state;
        let black_m = self.parameters.black_film_m();
        let rest = || black.iter().zip(h).map(|(&phi, &h)| rest(h, phi, black_m)).collect();
        (!black.is_empty()).then(|| (&black[..], rest()))
    }

    /// Thickness now, nm, row 0 on top; the mean of cells that are partly black film.
    pub fn thickness_nm(&self) -> Vec<f64> {
        self.state.h.iter().map(|h| h * 1e9).collect()
    }

    /// Thickness now as a map for a whole sphere: a dome is mirrored below its rim, as in the bath it stands on.
    pub fn map(&self) -> Result<ThicknessMap, ThicknessError> {
        let values = self.whole(self.thickness_nm());
        ThicknessMap::new(self.grid.columns, values.len() / self.grid.columns, values)
    }

    /// The share of black film over the same cells, if there is any.
    pub fn black_share(&self) -> Option<Vec<f64>> {
        (!self.state.black.is_empty()).then(|| self.whole(self.state.black.clone()))
    }

    /// Values of cells for a whole sphere, or for a plane.
    fn whole(&self, own: Vec<f64>) -> Vec<f64> {
        let (n, rows) = (self.grid.columns, self.grid.rows);
        let rim_deg = match self.parameters.shape {
            Shape::Sphere { rim_deg, .. } if rim_deg != 180.0 => rim_deg,
            _ => return own,
        };
        let total = (rows as f64 * 180.0 / rim_deg).round() as usize;
        let row = |i: usize| if i < rows { i } else { (2 * rows - 1).saturating_sub(i) };
        (0..total).flat_map(|i| own[row(i) * n..(row(i) + 1) * n].iter().copied()).collect()
    }

    /// Thickness now as a field over a whole sphere or a plane, with the edges of its black film.
    pub fn field(&self) -> Result<FlowField, ThicknessError> {
        Ok(self.parameters.field(self.map()?, self.black_share()))
    }
}
