//! The staggered grid that a film lives on: a sphere, a dome of one, or a vertical plane. All three are rows of cells
//! whose lengths are told row by row, so that one solver serves them all.
//!
//! Cells count from the top, row after row. `down` is the velocity through the lower and upper sides of cells
//! (`rows + 1` rows), `across` the one through their right sides (`rows` rows). Columns close on themselves; those of a
//! frame with borders do not, but the velocity through its last right sides, which is none, stands for that through its
//! first left ones, too.

use std::f64::consts::{PI, TAU};

/// What the film spans, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A sphere, or what of it lies within `rim_deg` of the top: 180 is all of it, 90 a dome on a bath.
    Sphere {
        /// Radius, m.
        radius_m: f64,
        /// Angle from the top down to the rim, degrees.
        rim_deg: f64,
    },
    /// A vertical plane.
    Plane {
        /// Width between its sides, or after which it repeats, m.
        width_m: f64,
        /// Height between its upper and lower side, m.
        height_m: f64,
        /// What lies beyond its sides.
        sides: Sides,
    },
}

/// What lies beyond the left and the right side of a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// The borders of a frame: menisci along which the film slips, and regenerates.
    Menisci,
    /// The same film again: the middle of a frame whose sides are out of sight.
    Periodic,
}

impl Sides {
    /// Both, by name.
    pub const NAMES: [(&'static str, Sides); 2] = [("menisci", Sides::Menisci), ("periodic", Sides::Periodic)];

    /// Its name.
    pub fn name(self) -> &'static str {
        Sides::NAMES[usize::from(self == Sides::Periodic)].0
    }
}

/// What lies beyond the first or the last row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// The same rows, half a turn further.
    Pole,
    /// A wall along which the film slips freely.
    Wall,
}

/// Lengths, areas and directions of a grid, m.
#[derive(Debug, Clone)]
pub struct Grid {
    pub shape: Shape,
    pub rows: usize,
    pub columns: usize,
    pub top: Edge,
    pub bottom: Edge,
    /// Between rows.
    pub dy: f64,
    /// Between columns at the middles of cells, by row.
    pub width: Vec<f64>,
    /// Lengths of the upper sides of cells, and of the last lower one.
    pub side: Vec<f64>,
    /// Of a cell, by row.
    pub area: Vec<f64>,
    /// Around corners: between the middles of the rows above and below; nothing at the ends.
    pub corner_area: Vec<f64>,
    /// Heights of the middles of cells above any level.
    pub height: Vec<f64>,
    /// Polar angle of the middles of cells and of their upper sides: sine, cosine.
    pub polar: Vec<[f64; 2]>,
    pub polar_side: Vec<[f64; 2]>,
    /// Azimuth of the middles of cells and of their right sides: sine, cosine.
    pub azimuth: Vec<[f64; 2]>,
    pub azimuth_side: Vec<[f64; 2]>,
    /// Radius of a sphere, 1 for a plane.
    pub radius: f64,
    /// 1 / radius^2 of a sphere, 0 for a plane.
    pub curvature: f64,
}

impl Grid {
    pub fn new(shape: Shape, columns: usize, rows: usize) -> Grid {
        let pair = |angle: f64| [angle.sin(), angle.cos()];
        let turn = TAU / columns as f64;
        let azimuth = (0..columns).map(|j| pair((j as f64 + 0.5) * turn)).collect();
        let azimuth_side = (0..columns).map(|j| pair((j as f64 + 1.0) * turn)).collect();
        match shape {
            Shape::Sphere { radius_m: r, rim_deg } => {
                let whole = rim_deg == 180.0;
                let step = if whole { PI } else { rim_deg.to_radians() } / rows as f64;
                let middle = |i: usize| (i as f64 + 0.5) * step;
                // sin of pi would be 1e-16, not zero.
                let ends = |i: usize| i == 0 || (whole && i == rows);
                let sine = |i: usize| if ends(i) { 0.0 } else { (i as f64 * step).sin() };
                let ring = |from: f64, to: f64| 2.0 * ((from + to) / 2.0).sin() * ((to - from) / 2.0).sin();
                Grid {
                    shape,
                    rows,
                    columns,
                    top: Edge::Pole,
                    bottom: if whole { Edge::Pole } else { Edge::Wall },
                    dy: r * step,
                    width: (0..rows).map(|i| r * middle(i).sin() * turn).collect(),
                    side: (0..=rows).map(|i| r * sine(i) * turn).collect(),
                    area: (0..rows).map(|i| r * r * turn * ring(i as f64 * step, (i as f64 + 1.0) * step)).collect(),
                    corner_area: (0..=rows)
                        .map(|i| if i == 0 || i == rows { 0.0 } else { r * r * turn * ring(middle(i - 1), middle(i)) })
                        .collect(),
                    height: (0..rows).map(|i| r * middle(i).cos()).collect(),
                    polar: (0..rows).map(|i| pair(middle(i))).collect(),
                    polar_side: (0..=rows).map(|i| [sine(i), (i as f64 * step).cos()]).collect(),
                    azimuth,
                    azimuth_side,
                    radius: r,
                    curvature: 1.0 / (r * r),
                }
            }
            Shape::Plane { width_m, height_m, .. } => {
                let (dx, dy) = (width_m / columns as f64, height_m / rows as f64);
                Grid {
                    shape,
                    rows,
                    columns,
                    top: Edge::Wall,
                    bottom: Edge::Wall,
                    dy,
                    width: vec![dx; rows],
                    side: vec![dx; rows + 1],
                    area: vec![dx * dy; rows],
                    corner_area: vec![dx * dy; rows + 1],
                    height: (0..rows).map(|i| height_m - (i as f64 + 0.5) * dy).collect(),
                    polar: vec![[1.0, 0.0]; rows],
                    polar_side: vec![[1.0, 0.0]; rows + 1],
                    azimuth,
                    azimuth_side,
                    radius: 1.0,
                    curvature: 0.0,
                }
            }
        }
    }

    pub fn cells(&self) -> usize {
        self.rows * self.columns
    }

    pub fn is_plane(&self) -> bool {
        matches!(self.shape, Shape::Plane { .. })
    }

    /// Whether the last column's neighbour is the first.
    pub fn closes(&self) -> bool {
        !matches!(self.shape, Shape::Plane { sides: Sides::Menisci, .. })
    }

    /// Columns of values to either side that a field of a frame with borders is mirrored from: the k-th beyond the left
    /// one and beyond the right one, with its sign.
    pub fn beyond(&self, kind: Kind, k: usize) -> [(usize, f64); 2] {
        let n = self.columns;
        match (self.closes(), kind) {
            (true, _) => [(n - 1 - k, 1.0), (k, 1.0)],
            (false, Kind::Scalar | Kind::Down) => [(k, 1.0), (n - 1 - k, 1.0)],
            // Sides: the last is the border itself, and no flow passes either.
            (false, Kind::Across) => [if k == 0 { (n - 1, 1.0) } else { (k - 1, -1.0) }, (n - 2 - k, -1.0)],
        }
    }

    /// Columns after which rows repeat: those of a frame with borders do so with their mirror image.
    pub fn period(&self) -> usize {
        if self.closes() { self.columns } else { 2 * self.columns }
    }

    /// The middle of a cell: on the unit sphere (z up), or x and height on the plane, m.
    pub fn place(&self, row: usize, column: usize) -> [f64; 3] {
        self.place_of(self.polar[row], self.azimuth[column], (column as f64 + 0.5) * self.width[row], self.height[row])
    }

    /// The middle of a cell's upper side.
    pub fn place_above(&self, row: usize, column: usize) -> [f64; 3] {
        let height = if row == 0 { self.height[0] + self.dy / 2.0 } else { self.height[row - 1] - self.dy / 2.0 };
        let width = self.width[row.min(self.rows - 1)];
        self.place_of(self.polar_side[row], self.azimuth[column], (column as f64 + 0.5) * width, height)
    }

    /// The middle of a cell's right side.
    pub fn place_right(&self, row: usize, column: usize) -> [f64; 3] {
        let x = (column as f64 + 1.0) * self.width[row];
        self.place_of(self.polar[row], self.azimuth_side[column], x, self.height[row])
    }

    fn place_of(&self, polar: [f64; 2], azimuth: [f64; 2], x: f64, height: f64) -> [f64; 3] {
        if self.is_plane() {
            return [x, 0.0, height];
        }
        [polar[0] * azimuth[1], polar[0] * azimuth[0], polar[1]]
    }

    /// Area of all cells, m2.
    pub fn total_area(&self) -> f64 {
        self.area.iter().sum::<f64>() * self.columns as f64
    }

    /// Sum over cells of a value times the cell's area; the order does not depend on threads.
    pub fn integral(&self, values: &[f64]) -> f64 {
        values.chunks_exact(self.columns).zip(&self.area).map(|(row, area)| row.iter().sum::<f64>() * area).sum()
    }
}

/// Rows and columns of ghosts around a field.
pub const PAD: usize = 3;

/// How a field continues beyond an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number at the middles of cells.
    Scalar,
    /// The velocity down, on the upper sides of cells.
    Down,
    /// The velocity across, on the right sides of cells.
    Across,
}

/// A field with its ghosts, so that no interpolation needs a case for an edge.
#[derive(Debug, Clone)]
pub struct Padded {
    pub stride: usize,
    pub data: Vec<f64>,
}

impl Padded {
    pub fn new(grid: &Grid, kind: Kind) -> Padded {
        let rows = grid.rows + usize::from(kind == Kind::Down) + 2 * PAD;
        let stride = grid.columns + 2 * PAD;
        Padded { stride, data: vec![0.0; rows * stride] }
    }

    pub fn fill(&mut self, grid: &Grid, kind: Kind, values: &[f64]) {
        use rayon::prelude::*;
        let n = grid.columns;
        let rows = (values.len() / n) as isize;
        self.data.par_chunks_exact_mut(self.stride).enumerate().with_min_len(16).for_each(|(padded_row, out)| {
            let (row, shift, sign) = source(grid, kind, padded_row as isize - PAD as isize, rows);
            let row = &values[row * n..(row + 1) * n];
            for (k, value) in out[PAD..PAD + n].iter_mut().enumerate() {
                *value = row[k];
            }
            if shift > 0 {
                out[PAD..PAD + n].rotate_left(shift);
            }
            if sign < 0.0 {
                out[PAD..PAD + n].iter_mut().for_each(|value| *value = -*value);
            }
            for k in 0..PAD {
                let [(left, left_sign), (right, right_sign)] = grid.beyond(kind, k);
                out[PAD - 1 - k] = out[PAD + left] * left_sign;
                out[PAD + n + k] = out[PAD + right] * right_sign;
            }
        });
    }
}

/// Rows of ghosts above and below.
pub const GHOSTS: usize = PAD;

/// The rows beyond the edges of a field that is itself left where it is.
pub struct Ghosts {
    columns: usize,
    /// Those above, the furthest first, then those below.
    rows: Vec<f64>,
}

impl Ghosts {
    pub fn new(grid: &Grid) -> Ghosts {
        Ghosts { columns: grid.columns, rows: vec![0.0; 2 * GHOSTS * grid.columns] }
    }

    pub fn fill(&mut self, grid: &Grid, kind: Kind, values: &[f64]) {
        let n = self.columns;
        let rows = (values.len() / n) as isize;
        for (k, out) in self.rows.chunks_exact_mut(n).enumerate() {
            let row = if k < GHOSTS { k as isize - GHOSTS as isize } else { rows + (k - GHOSTS) as isize };
            let (from, shift, sign) = source(grid, kind, row, rows);
            out.copy_from_slice(&values[from * n..(from + 1) * n]);
            out.rotate_left(shift);
            out.iter_mut().for_each(|value| *value *= sign);
        }
    }

    /// A row of the field that the ghosts were made of.
    #[inline(always)]
    pub fn line<'a>(&'a self, values: &'a [f64], row: isize) -> &'a [f64] {
        let n = self.columns;
        let rows = (values.len() / n) as isize;
        if row < 0 {
            let k = (row + GHOSTS as isize) as usize;
            &self.rows[k * n..(k + 1) * n]
        } else if row >= rows {
            let k = (row - rows) as usize + GHOSTS;
            &self.rows[k * n..(k + 1) * n]
        } else {
            &values[row as usize * n..(row as usize + 1) * n]
        }
    }
}

/// Where a row, perhaps a ghost, comes from: its source, the columns by which it is turned, its sign.
fn source(grid: &Grid, kind: Kind, row: isize, rows: isize) -> (usize, usize, f64) {
    let (edge, mirrored) = if row < 0 {
        (grid.top, if kind == Kind::Down { -row } else { -1 - row })
    } else if row >= rows {
        let last = rows - 1;
        (grid.bottom, if kind == Kind::Down { 2 * last - row } else { 2 * last + 1 - row })
    } else {
        return (row as usize, 0, 1.0);
    };
    let shift = if edge == Edge::Pole { grid.columns / 2 } else { 0 };
    let sign = match (kind, edge) {
        (Kind::Scalar, _) | (Kind::Across, Edge::Wall) => 1.0,
        _ => -1.0,
    };
    (mirrored as usize, shift, sign)
}

/// The same as the library's, which most processors of today do in one instruction and all builds for older ones call.
#[inline]
pub fn floor(x: f64) -> f64 {
    let whole = x as i64 as f64;
    if whole > x { whole - 1.0 } else { whole }
}
