//! Colours of a stack with one varying layer as a table: exact at its nodes, interpolated between, the error measured.
//!
//! One axis is the angle of incidence, uniform in degrees. The other is the reduced thickness `v = t s(theta)` with
//! `s = sqrt(1 - sin^2(theta)/m^2)`, m the layer's index over the first medium's at 550 nm: along a column of the table
//! the phase stands still and colours change slowly. Layers that absorb strongly or that light enters at a glancing
//! angle have `s = 1`. Between nodes: cubic Hermite in v, whose slopes are measured at the nodes, and the cubic through
//! four rows in angle.

use iridesce_numerics::Argument;

use fearless_simd::{Level, Simd, dispatch, f32x4, prelude::*};
use iridesce_numerics::interpolation::{hermite, lagrange};
use iridesce_numerics::turns::sin_pi;
use iridesce_numerics::{F64s, Lanes, Number, simd};
use rayon::prelude::*;

use crate::OpticsError;
use crate::stack::sweep::lanes::{LANES, Lane};

mod build;
#[cfg(test)]
mod tests;

pub use build::ColorTableRequest;

/// No table has more nodes (of 32 bytes) than this.
pub const MOST_NODES: usize = 1 << 22;
/// Queries a task.
const CHUNK: usize = 4096;

/// Colour and its slope at one node: X, Y, Z and their change per step of v, padded to vectors of four.
type Node = [f32; 8];

/// Where a table's nodes are, and how good it was when it was built: all that a file must hold besides the nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorTableShape {
    /// Angles (1, or 4 and more).
    pub rows: usize,
    /// Nodes a row (2 and more).
    pub columns: usize,
    /// Thicknesses that may be asked for, nm.
    pub range_nm: [f64; 2],
    /// Angles that may be asked for, degrees.
    pub range_deg: [f64; 2],
    /// 1/m^2 of the reduced thickness; 0 where it is the thickness itself.
    pub inverse_square: f64,
    /// XYZ of the light, Y = 1.
    pub white: [f64; 3],
    /// CIEDE2000 against exact sums: 1.25 times the largest that was found when the table was built.
    pub max_delta_e: f64,
    /// The mean over the probes.
    pub mean_delta_e: f64,
    /// At how many points it was looked for, before a climb from the worst of them.
    pub probes: usize,
}

/// A table of colours.
#[derive(Debug, Clone)]
pub struct ColorTable {
    shape: ColorTableShape,
    nodes: Vec<Node>,
    extended: Vec<String>,
}

impl ColorTableShape {
    /// s(theta): what turns a thickness into a reduced one.
    fn reduction(&self, angle_deg: f64) -> f64 {
        reduction(self.inverse_square, angle_deg)
    }

    /// First reduced thickness and step.
    fn axis(&self) -> (f64, f64) {
        let first = self.range_nm[0] * self.reduction(self.range_deg[1]);
        let last = self.range_nm[1] * self.reduction(self.range_deg[0]);
        // A range of no length still has two nodes.
        (first, ((last - first) / (self.columns - 1) as f64).max(1e-9 * last.max(1.0)))
    }

    /// Degrees between rows.
    fn angle_step(&self) -> f64 {
        if self.rows == 1 { 1.0 } else { (self.range_deg[1] - self.range_deg[0]) / (self.rows - 1) as f64 }
    }

    fn angle(&self, row: usize) -> f64 {
        if row + 1 == self.rows { self.range_deg[1] } else { self.range_deg[0] + row as f64 * self.angle_step() }
    }

    fn check(&self) -> Result<(), OpticsError> {
        let bad = |message: String| Err(OpticsError::Argument(message));
        let [low, high] = self.range_nm;
        if !(low >= 0.0 && low <= high && high.is_finite() && high > 0.0) {
            return bad(format!("thickness_nm must be a range from >= 0 up to > 0, finite, got ({low}, {high})"));
        }
        let [from, to] = self.range_deg;
        if !(from >= 0.0 && from <= to && to < 90.0) {
            return bad(format!("angle_deg must be a range within [0, 90), got ({from}, {to})"));
        }
        let steep = to.to_radians().sin().powi(2) * self.inverse_square;
        let sound = (self.rows == 1 && from == to || self.rows >= 4 && from < to)
            && self.columns >= 2
            && self.rows.checked_mul(self.columns).is_some_and(|nodes| nodes <= MOST_NODES)
            && (0.0..1.0).contains(&steep)
            && self.inverse_square >= 0.0
            && self.white.iter().all(|w| *w > 0.0 && w.is_finite())
            && (0.0..f64::INFINITY).contains(&self.max_delta_e)
            && (0.0..f64::INFINITY).contains(&self.mean_delta_e);
        if sound { Ok(()) } else { bad(format!("this is no shape of a colour table: {self:?}")) }
    }
}

fn reduction(inverse_square: f64, angle_deg: f64) -> f64 {
    let sine = angle_deg.to_radians().sin();
    (1.0 - sine * sine * inverse_square).sqrt()
}

impl ColorTable {
    /// A table from what [`ColorTable::shape`] and [`ColorTable::nodes`] gave.
    pub fn from_nodes(shape: ColorTableShape, nodes: Vec<[f32; 8]>) -> Result<ColorTable, OpticsError> {
        shape.check()?;
        let expected = shape.rows * shape.columns;
        if nodes.len() != expected || nodes.as_flattened().iter().any(|v| !v.is_finite()) {
            let message = format!("the table must have {expected} finite nodes, got {}", nodes.len());
            return Err(OpticsError::Argument(message));
        }
        Ok(ColorTable { shape, nodes, extended: Vec::new() })
    }

    /// Where the nodes are, and how good the table is.
    pub fn shape(&self) -> &ColorTableShape {
        &self.shape
    }

    /// Row by row: X, Y, Z, 0 and their slopes per step, 0.
    pub fn nodes(&self) -> &[[f32; 8]] {
        &self.nodes
    }

    /// Names of the media whose stated extension beyond their data was used in building it.
    pub fn extended(&self) -> &[String] {
        &self.extended
    }

    /// The reduced thickness of a column, in nm.
    pub fn reduced_nm(&self, column: usize) -> f64 {
        let (first, step) = self.shape.axis();
        first + column as f64 * step
    }

    /// XYZ of many points, one thickness and one angle each (or one angle for all), into `out`.
    ///
    /// Points outside the table's ranges are an error that tells the first. Runs on all threads of the pool it is called in.
    pub fn evaluate(&self, thickness_nm: &[f64], angle_deg: &[f64], out: &mut [[f64; 3]]) -> Result<(), OpticsError> {
        let points = out.len();
        if thickness_nm.len() != points || (angle_deg.len() != points && angle_deg.len() != 1) {
            return Err(OpticsError::Argument(format!(
                "{points} colours take as many thicknesses and as many angles or one, got {} and {}",
                thickness_nm.len(),
                angle_deg.len()
            )));
        }
        self.check_range("thickness_nm", thickness_nm, self.shape.range_nm)?;
        self.check_range("angle_deg", angle_deg, self.shape.range_deg)?;
        self.evaluate_at(simd::level_or_best(), thickness_nm, angle_deg, out);
        Ok(())
    }

    fn evaluate_at(&self, level: Level, thickness_nm: &[f64], angle_deg: &[f64], out: &mut [[f64; 3]]) {
        out.par_chunks_mut(CHUNK).zip(thickness_nm.par_chunks(CHUNK)).enumerate().for_each(|(chunk, (out, t))| {
            let angles =
                if angle_deg.len() == 1 { angle_deg } else { &angle_deg[chunk * CHUNK..chunk * CHUNK + t.len()] };
            dispatch!(level, simd => self.look_up(simd, t, angles, out));
        });
    }

    fn check_range(&self, name: &'static str, values: &[f64], [low, high]: [f64; 2]) -> Result<(), OpticsError> {
        // (Without a branch a value, so that vectors do it; the place is looked for only where there is one.)
        let outside = values.iter().fold(false, |outside, v| outside | !(*v >= low && *v <= high));
        if !outside {
            return Ok(());
        }
        let place = values.iter().position(|v| !(low..=high).contains(v)).unwrap_or(0);
        let allowed = format!("within the table's {low} to {high}");
        Err(Argument::new(name, allowed, values[place]).at(format!("at point {place}")).into())
    }

    #[inline(always)]
    fn look_up<S: Simd>(&self, simd: S, thickness_nm: &[f64], angle_deg: &[f64], out: &mut [[f64; 3]]) {
        let (mut t, mut angle) = (Lane::ZERO, Lanes([angle_deg[0]; LANES]));
        let mut place = Places::new();
        for (first, out) in (0..).step_by(LANES).zip(out.chunks_mut(LANES)) {
            let some = out.len();
            t.0[..some].copy_from_slice(&thickness_nm[first..first + some]);
            if angle_deg.len() > 1 {
                angle.0[..some].copy_from_slice(&angle_deg[first..first + some]);
            }
            place.find(simd, &self.shape, &t, &angle);
            for (lane, out) in out.iter_mut().enumerate() {
                *out = self.blend(simd, &place, lane);
            }
        }
    }

    /// The colour of one lane: two nodes with their slopes of each row, rows weighted.
    #[inline(always)]
    fn blend<S: Simd>(&self, simd: S, place: &Places, lane: usize) -> [f64; 3] {
        let (column, row) = (place.column.0[lane] as usize, place.row.0[lane] as usize);
        let along = [
            f32x4::splat(simd, place.along[0].0[lane] as f32),
            f32x4::splat(simd, place.along[1].0[lane] as f32),
            f32x4::splat(simd, place.along[2].0[lane] as f32),
            f32x4::splat(simd, place.along[3].0[lane] as f32),
        ];
        let mut sum = f32x4::splat(simd, 0.0);
        let rows = if self.shape.rows == 1 { 1 } else { 4 };
        for across in 0..rows {
            let start = (row + across) * self.shape.columns + column;
            let values = self.nodes[start..start + 2].as_flattened();
            let mut of_row = f32x4::from_slice(simd, &values[0..4]) * along[0];
            of_row = along[1].mul_add(f32x4::from_slice(simd, &values[4..8]), of_row);
            of_row = along[2].mul_add(f32x4::from_slice(simd, &values[8..12]), of_row);
            of_row = along[3].mul_add(f32x4::from_slice(simd, &values[12..16]), of_row);
            sum = of_row.mul_add(f32x4::splat(simd, place.across[across].0[lane] as f32), sum);
        }
        let [x, y, z, _] = sum.to_array();
        [f64::from(x), f64::from(y), f64::from(z)]
    }
}

/// Where in the table some points lie.
struct Places {
    column: Lane,
    row: Lane,
    /// Weights of value and slope at either end of the cell.
    along: [Lane; 4],
    /// Weights of the four rows.
    across: [Lane; 4],
}

impl Places {
    fn new() -> Places {
        Places { column: Lane::ZERO, row: Lane::ZERO, along: [Lane::ZERO; 4], across: [Lane::ZERO; 4] }
    }

    #[inline(always)]
    fn find<S: Simd>(&mut self, simd: S, shape: &ColorTableShape, thickness_nm: &Lane, angle_deg: &Lane) {
        let (first, step) = shape.axis();
        let per_degree = 1.0 / shape.angle_step();
        for at in (0..LANES).step_by(F64s::<S>::LEN) {
            let (zero, one) = (F64s::splat(simd, 0.0), F64s::splat(simd, 1.0));
            let angle = angle_deg.load(simd, at);
            let mut v = thickness_nm.load(simd, at);
            if shape.inverse_square > 0.0 {
                let sine = sin_pi(angle * (1.0 / 180.0));
                v = v * (one - sine * sine * shape.inverse_square).sqrt();
            }
            let p = ((v - first) * (1.0 / step)).max(zero);
            let column = p.floor().min(F64s::splat(simd, (shape.columns - 2) as f64));
            let f = p - column;
            self.column.store::<S>(at, column);
            for (kept, weight) in self.along.iter_mut().zip(hermite(f)) {
                kept.store::<S>(at, weight);
            }
            if shape.rows == 1 {
                self.row.store::<S>(at, zero);
                self.across[0].store::<S>(at, one);
                continue;
            }
            // The cubic through four rows; at either end the outermost four serve the first two cells.
            let y = (angle - shape.range_deg[0]) * per_degree;
            let row = (y.floor() - 1.0).max(zero).min(F64s::splat(simd, (shape.rows - 4) as f64));
            self.row.store::<S>(at, row);
            for (kept, weight) in self.across.iter_mut().zip(lagrange(y - row - 1.0)) {
                kept.store::<S>(at, weight);
            }
        }
    }
}
