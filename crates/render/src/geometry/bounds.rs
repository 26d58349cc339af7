//! Boxes along the axes.

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Bounds = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// The box around points.
    pub fn of(points: impl IntoIterator<Item = [f64; 3]>) -> Bounds {
        let mut all = Bounds::EMPTY;
        for point in points {
            for (i, value) in point.into_iter().enumerate() {
                all.min[i] = all.min[i].min(value);
                all.max[i] = all.max[i].max(value);
            }
        }
        all
    }

    pub fn union(&self, other: &Bounds) -> Bounds {
        Bounds {
            min: std::array::from_fn(|i| self.min[i].min(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].max(other.max[i])),
        }
    }

    pub fn overlap(&self, other: &Bounds) -> Bounds {
        Bounds {
            min: std::array::from_fn(|i| self.min[i].max(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].min(other.max[i])),
        }
    }

    /// Its corners.
    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|k| std::array::from_fn(|i| if k >> i & 1 == 0 { self.min[i] } else { self.max[i] }))
    }
}
