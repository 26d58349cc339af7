//! Colours of a stack with one varying layer as a table: exact at its nodes, interpolated between, the error measured.
//!
//! One axis is the angle of incidence, uniform in degrees. The other is the reduced thickness `v = t s(theta)` with
//! `s = sqrt(1 - sin^2(theta)/m^2)`, m the layer's index over the first medium's at [`REDUCED_NM`]: along a column of the table
//! the phase stands still and colours change slowly. Layers that absorb strongly or that light enters at a glancing
//! angle have `s = 1`. Between nodes: cubic Hermite in v, whose slopes are measured at the nodes, and the cubic through
//! four rows in angle.

use fearless_simd::{Level, Simd, dispatch, f32x4, prelude::*};
use rayon::prelude::*;

use super::difference::ciede2000;
use super::request::ColorRequest;
use super::space::{Adaptation, Space};
use super::stack_color::StackColor;
use crate::OpticsError;
use crate::stack::sweep::lanes::{LANES, Lane, sin_pi};

/// Where the index that reduces thicknesses is read: the middle of what the eye sees.
const REDUCED_NM: f64 = 550.0;
/// No table has more nodes (of 32 bytes) than this.
pub const MOST_NODES: usize = 1 << 22;
/// No table runs through more fringes: a millimetre of glass.
const MOST_TURNS: f64 = 8000.0;
/// Rounds of refinement before a table is given up.
const MOST_ROUNDS: usize = 16;
/// Queries a task.
const CHUNK: usize = 4096;

/// Colour and its slope at one node: X, Y, Z and their change per step of v, padded to vectors of four.
type Node = [f32; 8];

/// What a table is made of.
#[derive(Debug, Clone)]
pub struct ColorTableRequest {
    /// The stack, its light and observer. Space, adaptation and gamut are left to the queries.
    pub color: ColorRequest,
    /// Thickness of every layer in nm; that of the varying one is not used.
    pub thickness_nm: Vec<f64>,
    /// Which layer varies.
    pub layer: usize,
    /// Its least and greatest thickness in nm.
    pub range_nm: [f64; 2],
    /// Least and greatest angle of incidence in degrees; the same number twice for a table without that axis.
    pub range_deg: [f64; 2],
    /// CIEDE2000 that the table must keep to.
    pub tolerance: f64,
}

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
    /// Largest CIEDE2000 against exact sums that was found when the table was built.
    pub max_delta_e: f64,
    /// The same on average.
    pub mean_delta_e: f64,
    /// At how many points it was looked for.
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
            && self.max_delta_e >= 0.0
            && self.mean_delta_e >= 0.0;
        if sound { Ok(()) } else { bad(format!("this is no shape of a colour table: {self:?}")) }
    }
}

fn reduction(inverse_square: f64, angle_deg: f64) -> f64 {
    let sine = angle_deg.to_radians().sin();
    (1.0 - sine * sine * inverse_square).sqrt()
}

impl ColorTable {
    /// Builds a table that keeps to the tolerance at points between its nodes; `stop` is asked now and then.
    ///
    /// The exact colours it is held against are those of [`StackColor`]. A table that cannot keep to the tolerance within
    /// [`MOST_NODES`] is an error that tells what was reached.
    pub fn build(request: ColorTableRequest, stop: &(dyn Fn() -> bool + Sync)) -> Result<ColorTable, OpticsError> {
        let ColorTableRequest { color, thickness_nm, layer, range_nm, range_deg, tolerance } = request;
        let layers = color.coherent.len();
        if layer >= layers || thickness_nm.len() != layers {
            return Err(OpticsError::Argument(format!(
                "a stack of {layers} layers takes as many thicknesses and a varying layer below {layers}, got {} and {layer}",
                thickness_nm.len()
            )));
        }
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(OpticsError::Argument(format!("the tolerance must be > 0 and finite, got {tolerance}")));
        }
        let asked = ColorRequest { space: Space::Xyz, adaptation: Adaptation::None, gamut: None, ..color };
        let at = |place: usize| asked.media[place].index_extended(REDUCED_NM).map(|(index, _)| index);
        let (first, film) = (at(0)?, at(layer + 1)?);
        let turns = 2.0 * film.re * (range_nm[1] - range_nm[0]).max(0.0) / 430.0;
        if turns > MOST_TURNS {
            return Err(OpticsError::Argument(format!(
                "thickness_nm from {} to {} runs through {turns:.0} fringes, and a table holds {MOST_TURNS} at most",
                range_nm[0], range_nm[1]
            )));
        }
        let mut shape = ColorTableShape {
            rows: if range_deg[0] == range_deg[1] { 1 } else { 8 + ((range_deg[1] - range_deg[0]) / 4.0) as usize },
            columns: (24.0 + 10.0 * turns) as usize,
            range_nm,
            range_deg,
            inverse_square: 0.0,
            white: [1.0; 3],
            max_delta_e: 0.0,
            mean_delta_e: 0.0,
            probes: 0,
        };
        shape.rows = shape.rows.min(MOST_NODES / shape.columns).max(1);
        let inverse_square = (first.re / film.re).powi(2);
        let steep = 1.0 - range_deg[1].to_radians().sin().powi(2) * inverse_square;
        if film.im < 0.1 * film.re && steep > 0.2 {
            shape.inverse_square = inverse_square;
        }
        shape.check()?;
        let exact = Exact { colors: StackColor::new(asked)?, thickness_nm, layer };
        shape.white = exact.colors.white()?;
        for _ in 0..MOST_ROUNDS {
            let table = ColorTable { nodes: exact.nodes(&shape, stop)?, shape, extended: exact.colors.extended() };
            let between = table.measure(&exact, Probes::Anywhere)?;
            if between.max <= tolerance {
                let shape = ColorTableShape {
                    max_delta_e: between.max,
                    mean_delta_e: between.mean,
                    probes: between.count,
                    ..shape
                };
                return Ok(ColorTable { shape, ..table });
            }
            shape.max_delta_e = between.max;
            let on_rows = if shape.rows == 1 { between.max } else { table.measure(&exact, Probes::OnRows)?.max };
            let (finer_columns, finer_rows) =
                (on_rows > 0.5 * tolerance, shape.rows > 1 && between.max > 2.0 * on_rows);
            // An error of the fourth order falls by 16 where steps are halved.
            if finer_columns || !finer_rows {
                shape.columns = shape.columns * 3 / 2;
            }
            if finer_rows || (!finer_columns && shape.rows > 1) {
                shape.rows = shape.rows * 3 / 2;
            }
            if shape.rows * shape.columns > MOST_NODES || shape.columns > MOST_NODES {
                break;
            }
        }
        Err(OpticsError::Argument(format!(
            "no table of {MOST_NODES} nodes or less keeps to CIEDE2000 {tolerance}: {} was reached; narrow thickness_nm or \
             angle_deg, or allow more",
            shape.max_delta_e
        )))
    }

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
        let level = Level::new();
        out.par_chunks_mut(CHUNK).zip(thickness_nm.par_chunks(CHUNK)).enumerate().for_each(|(chunk, (out, t))| {
            let angles =
                if angle_deg.len() == 1 { angle_deg } else { &angle_deg[chunk * CHUNK..chunk * CHUNK + t.len()] };
            dispatch!(level, simd => self.look_up(simd, t, angles, out));
        });
        Ok(())
    }

    fn check_range(&self, name: &str, values: &[f64], [low, high]: [f64; 2]) -> Result<(), OpticsError> {
        // (Without a branch a value, so that vectors do it; the place is looked for only where there is one.)
        let outside = values.iter().fold(false, |outside, v| outside | !(*v >= low && *v <= high));
        if !outside {
            return Ok(());
        }
        let place = values.iter().position(|v| !(low..=high).contains(v)).unwrap_or(0);
        Err(OpticsError::Argument(format!(
            "{name} must be within the table's {low} to {high}, got {} at point {place}",
            values[place]
        )))
    }

    #[inline(always)]
    fn look_up<S: Simd>(&self, simd: S, thickness_nm: &[f64], angle_deg: &[f64], out: &mut [[f64; 3]]) {
        let (mut t, mut angle) = (Lane::ZERO, Lane([angle_deg[0]; LANES]));
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

    fn measure(&self, exact: &Exact, probes: Probes) -> Result<Measured, OpticsError> {
        let shape = &self.shape;
        let (angles, each) = if shape.rows == 1 { (1, 4096) } else { (96, 64) };
        let mut random = 0x9E37_79B9_7F4A_7C15_u64;
        let mut unit = move || {
            // splitmix64 (S. Vigna, public domain): the same probes every time.
            random = random.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = random;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let ([thinnest, thickest], [from, to]) = (shape.range_nm, shape.range_deg);
        let (mut t, mut angle) = (Vec::new(), Vec::new());
        for step in 0..angles {
            let at = match probes {
                Probes::OnRows => shape.angle((step * shape.rows / angles).min(shape.rows - 1)),
                // The ends belong to it: cells there have neighbours on one side only.
                Probes::Anywhere => from + (to - from) * (step as f64 + unit()) / angles as f64,
            };
            for step in 0..each {
                t.push(thinnest + (thickest - thinnest) * (step as f64 + unit()) / each as f64);
                angle.push(at);
            }
        }
        let wanted = exact.xyz(&t, &angle)?;
        let mut found = vec![[0.0; 3]; t.len()];
        self.evaluate(&t, &angle, &mut found)?;
        let lab = |xyz: [f64; 3]| Space::Lab.from_xyz(xyz, shape.white, Adaptation::None);
        let errors: Vec<f64> = found.iter().zip(&wanted).map(|(a, b)| ciede2000(lab(*a), lab(*b))).collect();
        let count = errors.len();
        Ok(Measured {
            // A NaN must count as a failure, not vanish in a comparison.
            max: errors.iter().fold(0.0, |max, e| if *e <= max { max } else { *e }),
            mean: errors.iter().sum::<f64>() / count as f64,
            count,
        })
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Probes {
    Anywhere,
    OnRows,
}

struct Measured {
    max: f64,
    mean: f64,
    count: usize,
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
        for at in (0..LANES).step_by(S::f64s::LEN) {
            let (zero, one) = (S::f64s::splat(simd, 0.0), S::f64s::splat(simd, 1.0));
            let angle = angle_deg.load(simd, at);
            let mut v = thickness_nm.load(simd, at);
            if shape.inverse_square > 0.0 {
                let sine = sin_pi(simd, angle * (1.0 / 180.0));
                v = v * (one - sine * sine * shape.inverse_square).sqrt();
            }
            let p = ((v - first) * (1.0 / step)).max(zero);
            let column = p.floor().min(S::f64s::splat(simd, (shape.columns - 2) as f64));
            let f = p - column;
            let rest = one - f;
            self.column.store::<S>(at, column);
            self.along[0].store::<S>(at, (f * 2.0 + one) * rest * rest);
            self.along[1].store::<S>(at, f * rest * rest);
            self.along[2].store::<S>(at, f * f * (f * -2.0 + 3.0));
            self.along[3].store::<S>(at, -(f * f * rest));
            if shape.rows == 1 {
                self.row.store::<S>(at, zero);
                self.across[0].store::<S>(at, one);
                continue;
            }
            // The cubic through four rows; at either end the outermost four serve the first two cells.
            let y = (angle - shape.range_deg[0]) * per_degree;
            let row = (y.floor() - 1.0).max(zero).min(S::f64s::splat(simd, (shape.rows - 4) as f64));
            let a = y - row;
            let (b, c, d) = (a - 1.0, a - 2.0, a - 3.0);
            self.row.store::<S>(at, row);
            self.across[0].store::<S>(at, b * c * d * (-1.0 / 6.0));
            self.across[1].store::<S>(at, a * c * d * 0.5);
            self.across[2].store::<S>(at, a * b * d * -0.5);
            self.across[3].store::<S>(at, a * b * c * (1.0 / 6.0));
        }
    }
}

/// The colours themselves.
struct Exact {
    colors: StackColor,
    thickness_nm: Vec<f64>,
    layer: usize,
}

impl Exact {
    fn xyz(&self, varying_nm: &[f64], angle_deg: &[f64]) -> Result<Vec<[f64; 3]>, OpticsError> {
        let mut thickness = Vec::with_capacity(varying_nm.len() * self.thickness_nm.len());
        for &t in varying_nm {
            let start = thickness.len();
            thickness.extend_from_slice(&self.thickness_nm);
            thickness[start + self.layer] = t;
        }
        Ok(self.colors.colors(&thickness, angle_deg)?.values)
    }

    /// Values and slopes at all nodes that a query can reach.
    fn nodes(&self, shape: &ColorTableShape, stop: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Node>, OpticsError> {
        let (first, step) = shape.axis();
        // Slopes by central differences so narrow that their own error, of the second order, is nothing.
        let near = 0.01 * step;
        let mut nodes = vec![[0.0; 8]; shape.rows * shape.columns];
        for (row, nodes) in nodes.chunks_exact_mut(shape.columns).enumerate() {
            if stop() {
                return Err(OpticsError::Argument("the table was stopped".into()));
            }
            // A row serves queries between its neighbours three rows away.
            let (before, after) = (shape.angle(row.saturating_sub(3)), shape.angle((row + 3).min(shape.rows - 1)));
            let (least, most) =
                (shape.range_nm[0] * shape.reduction(after), shape.range_nm[1] * shape.reduction(before));
            let from = (((least - first) / step).floor().max(0.0) as usize).min(shape.columns - 2);
            let until = (((most - first) / step).ceil() as usize + 2).min(shape.columns);
            let per_nm = shape.reduction(shape.angle(row));
            let mut t = Vec::with_capacity(3 * (until - from));
            for column in from..until {
                let v = first + column as f64 * step;
                // At no thickness there is nothing on the other side: the slope looks ahead.
                let steps = if v >= near { [0.0, -near, near] } else { [0.0, near, 2.0 * near] };
                t.extend(steps.map(|step| (v + step) / per_nm));
            }
            let angle = vec![shape.angle(row); t.len()];
            let xyz = self.xyz(&t, &angle)?;
            for (place, three) in xyz.as_chunks::<3>().0.iter().enumerate() {
                let v = first + (from + place) as f64 * step;
                for axis in 0..3 {
                    let [here, a, b] = three.map(|xyz| xyz[axis]);
                    let slope = if v >= near { b - a } else { 4.0 * a - 3.0 * here - b } / (2.0 * near);
                    nodes[from + place][axis] = here as f32;
                    nodes[from + place][4 + axis] = (slope * step) as f32;
                }
            }
        }
        Ok(nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Illuminant, Model, Observer, Quantity};
    use crate::{Complex64, Medium, Polarization};

    fn request(n: &[Complex64], layer: usize, range_nm: [f64; 2], range_deg: [f64; 2]) -> ColorTableRequest {
        ColorTableRequest {
            color: ColorRequest {
                media: n.iter().map(|n| Medium::constant(*n).unwrap()).collect(),
                coherent: vec![true; n.len() - 2],
                illuminant: Illuminant::named("D65").unwrap(),
                observer: Observer::Cie1931,
                polarization: Polarization::Unpolarized,
                quantity: Quantity::Reflectance,
                model: Model::Exact,
                grid: None,
                space: Space::Srgb,
                adaptation: Adaptation::None,
                gamut: None,
            },
            thickness_nm: vec![60.0; n.len() - 2],
            layer,
            range_nm,
            range_deg,
            tolerance: 0.1,
        }
    }

    fn soap() -> Vec<Complex64> {
        [1.0, 1.33, 1.0].map(Complex64::from).to_vec()
    }

    /// Points of another sequence than the table's own probes, against exact sums.
    fn worst(table: &ColorTable, request: &ColorTableRequest) -> f64 {
        let exact = Exact {
            colors: StackColor::new(ColorRequest { space: Space::Xyz, ..request.color.clone() }).unwrap(),
            thickness_nm: request.thickness_nm.clone(),
            layer: request.layer,
        };
        let at = |range: [f64; 2], share: f64| range[0] + (range[1] - range[0]) * share;
        let share = |i: u32, ratio: f64| (f64::from(i) * ratio).fract();
        // Golden and plastic ratios: evenly spread in both directions, ends included below.
        let mut t: Vec<f64> = (0..3000).map(|i| at(request.range_nm, share(i, 0.754_877_666))).collect();
        let mut angle: Vec<f64> = (0..3000).map(|i| at(request.range_deg, share(i / 50, 0.569_840_29))).collect();
        for (share_t, share_a) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            t.push(at(request.range_nm, share_t));
            angle.push(at(request.range_deg, share_a));
        }
        let wanted = exact.xyz(&t, &angle).unwrap();
        let mut found = vec![[0.0; 3]; t.len()];
        table.evaluate(&t, &angle, &mut found).unwrap();
        let lab = |xyz: [f64; 3]| Space::Lab.from_xyz(xyz, table.shape.white, Adaptation::None);
        found.iter().zip(&wanted).map(|(a, b)| ciede2000(lab(*a), lab(*b))).fold(0.0, f64::max)
    }

    #[test]
    fn tables_keep_to_what_they_say() {
        let c = Complex64::new;
        let wafer = vec![c(1.0, 0.0), c(1.46, 0.0), c(4.08, 0.028)];
        let metal = vec![c(1.0, 0.0), c(0.2, 3.3), c(1.5, 0.0)];
        let mirror = [1.0, 2.35, 1.46, 2.35, 1.52].map(Complex64::from).to_vec();
        for request in [
            request(&soap(), 0, [0.0, 1500.0], [0.0, 80.0]),
            request(&soap(), 0, [300.0, 2000.0], [45.0, 45.0]),
            request(&wafer, 0, [0.0, 600.0], [0.0, 60.0]),
            request(&metal, 0, [0.0, 80.0], [0.0, 70.0]),
            request(&mirror, 1, [20.0, 400.0], [10.0, 50.0]),
        ] {
            let table = ColorTable::build(request.clone(), &|| false).unwrap();
            let found = worst(&table, &request);
            println!("{:?}: {found}", table.shape);
            assert!(table.shape.max_delta_e <= 0.1 && table.shape.mean_delta_e <= table.shape.max_delta_e);
            // A second set of points may meet a cell that the first one missed, but not one much worse.
            assert!(found <= 0.15, "{found} against {}", table.shape.max_delta_e);
        }
    }

    #[test]
    fn one_point_and_a_range_of_no_length() {
        let request = request(&soap(), 0, [320.0, 320.0], [30.0, 30.0]);
        let table = ColorTable::build(request.clone(), &|| false).unwrap();
        assert!(worst(&table, &request) < 1e-3);
    }

    #[test]
    fn nodes_make_the_same_table() {
        let table = ColorTable::build(request(&soap(), 0, [0.0, 300.0], [0.0, 40.0]), &|| false).unwrap();
        let again = ColorTable::from_nodes(*table.shape(), table.nodes().to_vec()).unwrap();
        let (mut a, mut b) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        table.evaluate(&[0.0, 150.0, 300.0], &[0.0, 39.0, 40.0], &mut a).unwrap();
        again.evaluate(&[0.0, 150.0, 300.0], &[0.0, 39.0, 40.0], &mut b).unwrap();
        assert_eq!(a, b);
        assert!(ColorTable::from_nodes(*table.shape(), table.nodes()[1..].to_vec()).is_err());
        let mut broken = table.nodes().to_vec();
        broken[5][4] = f32::NAN;
        assert!(ColorTable::from_nodes(*table.shape(), broken).is_err());
        let good = *table.shape();
        for shape in [
            ColorTableShape { rows: 3, ..good },
            ColorTableShape { columns: 1, ..good },
            ColorTableShape { columns: usize::MAX, ..good },
            ColorTableShape { range_nm: [5.0, 1.0], ..good },
            ColorTableShape { range_deg: [0.0, 90.0], ..good },
            ColorTableShape { inverse_square: 4.0, ..good },
            ColorTableShape { white: [0.0; 3], ..good },
            ColorTableShape { max_delta_e: f64::NAN, ..good },
        ] {
            assert!(ColorTable::from_nodes(shape, table.nodes().to_vec()).is_err(), "{shape:?}");
        }
    }

    #[test]
    fn refusals() {
        let message = |request| ColorTable::build(request, &|| false).unwrap_err().to_string();
        let good = request(&soap(), 0, [0.0, 300.0], [0.0, 40.0]);
        assert!(message(ColorTableRequest { layer: 1, ..good.clone() }).contains("varying layer"));
        assert!(message(ColorTableRequest { range_nm: [10.0, 5.0], ..good.clone() }).contains("thickness_nm"));
        assert!(message(ColorTableRequest { range_nm: [0.0, f64::NAN], ..good.clone() }).contains("thickness_nm"));
        assert!(message(ColorTableRequest { range_nm: [0.0, 0.0], ..good.clone() }).contains("thickness_nm"));
        assert!(message(ColorTableRequest { range_deg: [0.0, 90.0], ..good.clone() }).contains("angle_deg"));
        assert!(message(ColorTableRequest { tolerance: 0.0, ..good.clone() }).contains("tolerance"));
        assert!(message(ColorTableRequest { range_nm: [0.0, 1e7], ..good.clone() }).contains("fringes"));
        let narrow = ColorTableRequest { range_nm: [100.0, 130.0], range_deg: [30.0, 30.0], ..good.clone() };
        assert!(message(ColorTableRequest { tolerance: 1e-9, ..narrow }).contains("was reached"));
        assert!(ColorTable::build(good.clone(), &|| true).unwrap_err().to_string().contains("stopped"));
        let table = ColorTable::build(good, &|| false).unwrap();
        let mut out = [[0.0; 3]; 2];
        let wrong = table.evaluate(&[1.0, 301.0], &[0.0], &mut out).unwrap_err().to_string();
        assert!(wrong.contains("thickness_nm must be within") && wrong.contains("301 at point 1"), "{wrong}");
        let wrong = table.evaluate(&[1.0, 2.0], &[0.0, f64::NAN], &mut out).unwrap_err().to_string();
        assert!(wrong.contains("angle_deg") && wrong.contains("point 1"), "{wrong}");
        assert!(table.evaluate(&[1.0], &[0.0], &mut out).is_err());
        table.evaluate(&[], &[0.0], &mut []).unwrap();
    }
}
