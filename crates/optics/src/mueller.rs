//! Light and surfaces in the plane of incidence: four numbers each, over a [`Number`].

use iridesce_numerics::Number;

/// Weights of s and p light, and of the two Stokes components between them: a row vector that is carried along a path.
#[derive(Debug, Clone, Copy)]
pub struct Beam<V> {
    /// Of s light.
    pub s: V,
    /// Of p light.
    pub p: V,
    /// Of U.
    pub u: V,
    /// Of V.
    pub v: V,
}

/// The four numbers of the Mueller matrix of a flat stack in its own plane of incidence: powers of s and p, and
/// `cross = amplitude_s conj(amplitude_p)`.
#[derive(Debug, Clone, Copy)]
pub struct Mueller<V> {
    /// Power of s light.
    pub s: V,
    /// Power of p light.
    pub p: V,
    /// Real and imaginary part of the product of amplitudes.
    pub cross: [V; 2],
}

/// What a flat stack reflects and passes.
#[derive(Debug, Clone, Copy)]
pub struct Response<V> {
    /// What comes back.
    pub reflect: Mueller<V>,
    /// What passes.
    pub transmit: Mueller<V>,
}

impl<V: Number> Mueller<V> {
    /// The row times the matrix.
    #[inline(always)]
    pub fn carry(&self, row: &Beam<V>) -> Beam<V> {
        let [re, im] = self.cross;
        Beam { s: row.s * self.s, p: row.p * self.p, u: row.u * re + row.v * im, v: row.v * re - row.u * im }
    }
}
