//! Affine maps of space: what moves, turns and scales.

use iridesce_numerics::vector::{Vec3, cross, dot};

/// p -> A p + b; three rows of A, each with its entry of b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// Rows of A, the entry of b last.
    pub rows: [[f64; 4]; 3],
}

impl Default for Affine {
    fn default() -> Affine {
        Affine::IDENTITY
    }
}

impl Affine {
    /// Leaves everything where it is.
    pub const IDENTITY: Affine = Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// Scales along the axes, turns about x, then y, then z of the world, then moves. Whole quarter turns are exact.
    ///
    /// ```
    /// use iridesce_scene::Affine;
    /// let quarter = Affine::placed([2.0; 3], [0.0, 0.0, 90.0], [1.0, 0.0, 0.0]);
    /// assert_eq!(quarter.point([1.0, 0.0, 0.0]), [1.0, 2.0, 0.0]);
    /// ```
    pub fn placed(scale: [f64; 3], rotate_deg: [f64; 3], translate: [f64; 3]) -> Affine {
        let mut all = Affine::IDENTITY;
        for (axis, &factor) in scale.iter().enumerate() {
            all.rows[axis][axis] = factor;
        }
        for (axis, &degrees) in rotate_deg.iter().enumerate() {
            let (sin, cos) = sin_cos_deg(degrees);
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut turn = Affine::IDENTITY;
            (turn.rows[a][a], turn.rows[a][b], turn.rows[b][a], turn.rows[b][b]) = (cos, -sin, sin, cos);
            all = turn.after(&all);
        }
        for (row, &by) in all.rows.iter_mut().zip(&translate) {
            row[3] += by;
        }
        all
    }

    /// First `inner`, then this one.
    pub fn after(&self, inner: &Affine) -> Affine {
        let rows = self.rows.map(|row| {
            std::array::from_fn(|column| {
                let sum: f64 = (0..3).map(|k| row[k] * inner.rows[k][column]).sum();
                sum + if column == 3 { row[3] } else { 0.0 }
            })
        });
        Affine { rows }
    }

    /// Where a point goes.
    #[inline(always)]
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        self.rows.map(|[a, b, c, d]| a * p[0] + b * p[1] + c * p[2] + d)
    }

    /// What a direction becomes.
    #[inline(always)]
    pub fn vector(&self, v: [f64; 3]) -> [f64; 3] {
        self.rows.map(|[a, b, c, _]| a * v[0] + b * v[1] + c * v[2])
    }

    /// The transpose of A times a vector: what a normal becomes, where this is the way back.
    #[inline(always)]
    pub fn transposed(&self, n: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.rows[0][i] * n[0] + self.rows[1][i] * n[1] + self.rows[2][i] * n[2])
    }

    /// The determinant of A.
    pub fn determinant(&self) -> f64 {
        let [x, y, z] = self.rows.map(|[a, b, c, _]| [a, b, c]);
        dot(x, cross(y, z))
    }

    /// The way back; `None` where there is none, as by a scale of zero.
    pub fn inverse(&self) -> Option<Affine> {
        let [x, y, z] = self.rows.map(|[a, b, c, _]| [a, b, c]);
        let determinant = dot(x, cross(y, z));
        let size = [x, y, z].iter().map(|row| dot(*row, *row).sqrt()).product::<f64>();
        // Flat but for rounding, or out of range.
        if !(determinant.abs() > 1e-12 * size && (1.0 / determinant).is_finite()) {
            return None;
        }
        let columns = [cross(y, z), cross(z, x), cross(x, y)].map(|column| column.map(|v| v / determinant));
        let mut back = Affine { rows: std::array::from_fn(|i| [columns[0][i], columns[1][i], columns[2][i], 0.0]) };
        let moved = back.vector([self.rows[0][3], self.rows[1][3], self.rows[2][3]]);
        for (row, by) in back.rows.iter_mut().zip(moved) {
            row[3] = -by;
        }
        back.rows.iter().flatten().all(|v| v.is_finite()).then_some(back)
    }

    /// By how much it scales, the same in every direction; `None` where it does not.
    pub fn similarity(&self) -> Option<f64> {
        let columns: [[f64; 3]; 3] = std::array::from_fn(|i| self.rows.map(|row| row[i]));
        let square = dot(columns[0], columns[0]);
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-14 * square;
        let even = near(dot(columns[1], columns[1]), square) && near(dot(columns[2], columns[2]), square);
        let right = [(0, 1), (1, 2), (2, 0)].iter().all(|&(a, b)| near(dot(columns[a], columns[b]), 0.0));
        (even && right).then(|| square.sqrt())
    }

    /// More than it makes any vector longer.
    pub fn stretch(&self) -> f64 {
        self.rows.iter().map(|[a, b, c, _]| a * a + b * b + c * c).sum::<f64>().sqrt()
    }

    /// [`Affine::point`] of a [`Vec3`].
    #[inline(always)]
    pub fn moved(&self, p: Vec3) -> Vec3 {
        self.point(p.to_array()).into()
    }

    /// [`Affine::vector`] of a [`Vec3`].
    #[inline(always)]
    pub fn turned(&self, v: Vec3) -> Vec3 {
        self.vector(v.to_array()).into()
    }
}

/// Exact at whole quarter turns.
fn sin_cos_deg(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => turn.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_then_turned_about_x_y_z_then_moved() {
        let all = Affine::placed([2.0, 1.0, 1.0], [90.0, 90.0, 0.0], [0.0, 0.0, 5.0]);
        // (1, 1, 0) -> (2, 1, 0) -> about x: (2, 0, 1) -> about y: (1, 0, -2) -> (1, 0, 3).
        assert_eq!(all.point([1.0, 1.0, 0.0]), [1.0, 0.0, 3.0]);
    }

    #[test]
    fn there_and_back() {
        let there = Affine::placed([2.0, -0.5, 3.0], [30.0, -70.0, 200.0], [1.0, 2.0, 3.0]);
        let back = there.inverse().unwrap();
        let p = [0.3, -4.0, 2.0];
        let again = back.point(there.point(p));
        assert!((0..3).all(|i| (again[i] - p[i]).abs() < 1e-14), "{again:?}");
        assert!((there.determinant() + 3.0).abs() < 1e-14);
        // A normal goes with the transpose of the way back: it stays at right angles.
        let (n, along) = (back.transposed([1.0, 2.0, -1.0]), there.vector([1.0, 0.0, 1.0]));
        assert!(dot(n, along).abs() < 1e-14);
        assert_eq!(there.similarity(), None);
        let even = Affine::placed([2.0; 3], [30.0, -70.0, 200.0], [1.0; 3]).similarity().unwrap();
        assert!((even - 2.0).abs() < 1e-14);
        assert_eq!(Affine::placed([1.0, 0.0, 1.0], [0.0; 3], [0.0; 3]).inverse(), None);
    }
}
