//! One argument of a sweep.

/// One argument: its own values, and how far to step in them along each axis of the result (0: broadcast).
#[derive(Debug, Clone)]
pub struct Operand<'a> {
    /// The values.
    pub values: &'a [f64],
    /// One stride an axis.
    pub strides: Vec<usize>,
}

impl Operand<'_> {
    /// Whether every element of `shape` finds its value.
    pub fn reaches(&self, shape: &[usize]) -> bool {
        let furthest = shape.iter().zip(&self.strides).try_fold(0_usize, |sum, (&length, &stride)| {
            sum.checked_add(stride.checked_mul(length.saturating_sub(1))?)
        });
        furthest.is_some_and(|furthest| furthest < self.values.len())
    }
}
