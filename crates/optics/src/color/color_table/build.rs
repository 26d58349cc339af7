//! Building a colour table: nodes from exact sums, probes between them, refinement until the error is small enough.

use iridesce_numerics::Bounds;
use iridesce_numerics::noise::SplitMix64;
use std::ops::Range;

use iridesce_numerics::Watch;

use super::{ColorTable, ColorTableShape, MOST_NODES, Node};
use crate::OpticsError;
use crate::color::difference::ciede2000;
use crate::color::request::ColorRequest;
use crate::color::space::{Adaptation, Space};
use crate::color::stack_color::StackColor;

/// Where the index that reduces thicknesses is read: the middle of what the eye sees.
const REDUCED_NM: f64 = 550.0;
/// No table runs through more fringes: a millimetre of glass.
const MOST_TURNS: f64 = 8000.0;
/// Rounds of refinement before a table is given up.
const MOST_ROUNDS: usize = 16;
/// The error that a table states is this often the worst that was found: a climb ends a little below its summit, and
/// not every summit is climbed.
const CAUTION: f64 = 1.25;
/// From how many probes the search climbs, and how often it steps.
const CLIMBERS: usize = 32;
const CLIMB_STEPS: usize = 6;
/// Colours between two looks at the watch.
const PIECE: usize = 4096;

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

/// The coarsest table worth a try: nodes for each fringe, and an axis of angles on which fringes stay where they are.
fn first_shape(
    asked: &ColorRequest,
    layer: usize,
    range_nm: [f64; 2],
    range_deg: [f64; 2],
) -> Result<ColorTableShape, OpticsError> {
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
    Ok(shape)
}

impl ColorTableShape {
    /// More nodes along the axis that `worst` comes from; `on_rows` is the largest error at the angles of the nodes.
    fn refine(&mut self, worst: f64, on_rows: f64, tolerance: f64) {
        let finer_columns = CAUTION * on_rows > 0.5 * tolerance;
        let finer_rows = self.rows > 1 && worst > 2.0 * on_rows;
        // An error of the fourth order falls by 16 where steps are halved.
        let finer = |count: usize, wanted: f64| {
            let factor = (1.1 * (CAUTION * wanted / tolerance).powf(0.25)).clamp(1.4, 2.5);
            (count as f64 * factor) as usize
        };
        if finer_columns || !finer_rows {
            self.columns = finer(self.columns, 2.0 * on_rows);
        }
        if finer_rows || (!finer_columns && self.rows > 1) {
            self.rows = finer(self.rows, 2.0 * worst);
        }
    }
}

impl ColorTable {
    /// Builds a table whose stated error keeps to the tolerance.
    ///
    /// The exact colours it is held against are those of [`StackColor`]. A table that cannot keep to the tolerance within
    /// [`MOST_NODES`] is an error that tells what was reached. `watch` hears of colours in the stage `building`, whose total
    /// grows where the table must be refined.
    pub fn build(request: ColorTableRequest, watch: &Watch) -> Result<ColorTable, OpticsError> {
        let ColorTableRequest { color, thickness_nm, layer, range_nm, range_deg, tolerance } = request;
        let layers = color.coherent.len();
        if layer >= layers || thickness_nm.len() != layers {
            return Err(OpticsError::Argument(format!(
                "a stack of {layers} layers takes as many thicknesses and a varying layer below {layers}, got {} and {layer}",
                thickness_nm.len()
            )));
        }
        Bounds::above("max_delta_e", 0.0).check(tolerance)?;
        let asked = ColorRequest { space: Space::Xyz, adaptation: Adaptation::None, gamut: None, ..color };
        let mut shape = first_shape(&asked, layer, range_nm, range_deg)?;
        let colors = StackColor::new(asked)?;
        shape.white = colors.white()?;
        let exact = Exact { colors, thickness_nm, layer, watch };
        watch.begin("building", 0);
        let (mut reached, mut vain) = (f64::INFINITY, 0);
        for _ in 0..MOST_ROUNDS {
            exact.expect((3 * shape.rows * shape.columns) as u64);
            let table = ColorTable { nodes: exact.nodes(&shape)?, shape, extended: exact.colors.extended() };
            let probes = table.probe(&exact, Where::Anywhere)?;
            let mut worst = probes.worst();
            if CAUTION * worst <= tolerance {
                worst = worst.max(table.climb(&exact, &probes)?);
            }
            // Where rounding of the nodes is all that is left, finer tables are no better.
            vain = if CAUTION * worst < 0.7 * reached { 0 } else { vain + 1 };
            reached = reached.min(CAUTION * worst);
            if CAUTION * worst <= tolerance {
                let count = probes.errors.len();
                let mean_delta_e = probes.errors.iter().sum::<f64>() / count as f64;
                let shape = ColorTableShape { max_delta_e: CAUTION * worst, mean_delta_e, probes: count, ..shape };
                return Ok(ColorTable { shape, extended: exact.colors.extended(), ..table });
            }
            let on_rows = if shape.rows == 1 { worst } else { table.probe(&exact, Where::OnRows)?.worst() };
            shape.refine(worst, on_rows, tolerance);
            if shape.rows.saturating_mul(shape.columns) > MOST_NODES || vain == 4 {
                break;
            }
        }
        Err(OpticsError::Argument(format!(
            "no table of {MOST_NODES} nodes or less keeps to max_delta_e={tolerance}: {reached:.3} was reached; narrow \
             thickness_nm or angle_deg, or allow more"
        )))
    }

    /// The error near the middle of every cell (or of every cell of some rows, on the rows themselves).
    fn probe(&self, exact: &Exact<'_>, place: Where) -> Result<Probes, OpticsError> {
        let shape = &self.shape;
        let (_, step) = shape.axis();
        // The same probes every time.
        let mut random = SplitMix64::new(0).skip();
        // Interpolation errs most in the middle of a cell: the middle half of each.
        let mut within = || 0.25 + 0.5 * random.unit();
        let angles: Vec<f64> = match place {
            Where::Anywhere if shape.rows == 1 => vec![shape.range_deg[0]],
            Where::Anywhere => (0..shape.rows - 1)
                .map(|row| shape.range_deg[0] + (row as f64 + within()) * shape.angle_step())
                .collect(),
            Where::OnRows => (0..shape.rows).step_by(shape.rows.div_ceil(32)).map(|row| shape.angle(row)).collect(),
        };
        let [thinnest, thickest] = shape.range_nm;
        let (mut points, mut groups) = (Vec::new(), Vec::new());
        for angle in angles {
            let first = points.len();
            let cells = ((thickest - thinnest) * shape.reduction(angle) / step).ceil().max(1.0) as usize;
            points.extend((0..cells).map(|cell| {
                let share = (cell as f64 + within()) / cells as f64;
                [thinnest + (thickest - thinnest) * share, angle]
            }));
            groups.push(first..points.len());
        }
        exact.expect(points.len() as u64);
        let errors = self.errors(exact, &points)?;
        Ok(Probes { points, errors, groups })
    }

    /// The greatest error near the worst probes: steps of a quarter of a cell, halved where none leads up.
    fn climb(&self, exact: &Exact<'_>, probes: &Probes) -> Result<f64, OpticsError> {
        let shape = &self.shape;
        let (_, step) = shape.axis();
        // The worst of each angle; of a single angle, the worst of all.
        let mut starts: Vec<usize> = match probes.groups.as_slice() {
            [one] => one.clone().collect(),
            groups => {
                let worst =
                    |of: &Range<usize>| of.clone().max_by(|a, b| probes.errors[*a].total_cmp(&probes.errors[*b]));
                groups.iter().filter_map(worst).collect()
            }
        };
        starts.sort_by(|a, b| probes.errors[*b].total_cmp(&probes.errors[*a]));
        starts.truncate(CLIMBERS);
        let mut climbers: Vec<(f64, [f64; 2], f64)> =
            starts.into_iter().map(|at| (probes.errors[at], probes.points[at], 0.25)).collect();
        exact.expect((climbers.len() * CLIMB_STEPS * if shape.rows == 1 { 2 } else { 8 }) as u64);
        for _ in 0..CLIMB_STEPS {
            let mut points = Vec::new();
            for (_, [t, angle], length) in &climbers {
                for across in if shape.rows == 1 { 0..=0 } else { -1..=1 } {
                    for along in [-1.0, 0.0, 1.0] {
                        let moved = angle + f64::from(across) * length * shape.angle_step();
                        let moved = moved.clamp(shape.range_deg[0], shape.range_deg[1]);
                        // (In v, so that a step sideways keeps its phase.)
                        let v = t * shape.reduction(*angle) + along * length * step;
                        if along != 0.0 || across != 0 {
                            let t = (v / shape.reduction(moved)).clamp(shape.range_nm[0], shape.range_nm[1]);
                            points.push([t, moved]);
                        }
                    }
                }
            }
            let errors = self.errors(exact, &points)?;
            let each = points.len() / climbers.len();
            for (place, climber) in climbers.iter_mut().enumerate() {
                let mine = place * each..(place + 1) * each;
                match mine.max_by(|a, b| errors[*a].total_cmp(&errors[*b])) {
                    Some(best) if errors[best] > climber.0 => (climber.0, climber.1) = (errors[best], points[best]),
                    _ => climber.2 *= 0.5,
                }
            }
        }
        Ok(climbers.iter().fold(0.0, |max, climber| climber.0.max(max)))
    }

    fn errors(&self, exact: &Exact<'_>, points: &[[f64; 2]]) -> Result<Vec<f64>, OpticsError> {
        let (t, angle): (Vec<f64>, Vec<f64>) = points.iter().map(|[t, angle]| (*t, *angle)).unzip();
        let wanted = exact.xyz(&t, &angle)?;
        let mut found = vec![[0.0; 3]; t.len()];
        self.evaluate(&t, &angle, &mut found)?;
        let lab = |xyz: [f64; 3]| Space::Lab.from_xyz(xyz, self.shape.white, Adaptation::None);
        // A NaN must count as a failure, not vanish in a comparison.
        let error = |(a, b): (&[f64; 3], &[f64; 3])| match ciede2000(lab(*a), lab(*b)) {
            e if e.is_nan() => f64::INFINITY,
            e => e,
        };
        Ok(found.iter().zip(&wanted).map(error).collect())
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Where {
    Anywhere,
    OnRows,
}

/// Points (nm, degrees), the error at each, and which belong to one angle.
struct Probes {
    points: Vec<[f64; 2]>,
    errors: Vec<f64>,
    groups: Vec<Range<usize>>,
}

impl Probes {
    fn worst(&self) -> f64 {
        self.errors.iter().fold(0.0, |max, error| error.max(max))
    }
}

/// The colours themselves.
struct Exact<'a> {
    colors: StackColor,
    thickness_nm: Vec<f64>,
    layer: usize,
    watch: &'a Watch,
}

impl Exact<'_> {
    /// So many colours more will be asked for.
    fn expect(&self, colors: u64) {
        self.watch.expect(self.watch.progress().done + colors);
    }

    fn xyz(&self, varying_nm: &[f64], angle_deg: &[f64]) -> Result<Vec<[f64; 3]>, OpticsError> {
        let mut found = Vec::with_capacity(varying_nm.len());
        let mut thickness = Vec::new();
        for (varying_nm, angle_deg) in varying_nm.chunks(PIECE).zip(angle_deg.chunks(PIECE)) {
            thickness.clear();
            for &t in varying_nm {
                let start = thickness.len();
                thickness.extend_from_slice(&self.thickness_nm);
                thickness[start + self.layer] = t;
            }
            found.extend(self.colors.colors(&thickness, angle_deg)?.values);
            self.watch.add(varying_nm.len() as u64);
            let progress = self.watch.progress();
            self.watch.expect(progress.total.max(progress.done));
            self.watch.check().map_err(|_| OpticsError::Argument("the table was stopped".into()))?;
        }
        Ok(found)
    }

    /// Values and slopes at all nodes that a query can reach.
    fn nodes(&self, shape: &ColorTableShape) -> Result<Vec<Node>, OpticsError> {
        let (first, step) = shape.axis();
        // Slopes by central differences: narrow enough that their own error (step^3/2400 of the third derivative) is below
        // that of the cubic, wide enough that neighbours summed in other steps (thick films) do not tilt them.
        let near = 0.05 * step;
        let mut nodes = vec![[0.0; 8]; shape.rows * shape.columns];
        for (row, nodes) in nodes.chunks_exact_mut(shape.columns).enumerate() {
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
