//! What one layer does to the tangential fields, over a [`Number`]: the careful solver, its derivatives and the fields
//! inside are instances of it, the sweeps' vectors and the renderer's.
//!
//! For s light the pair `(e, h)` is `(E_y, H_x)`, for p light `(H_y, E_x)`. With the phase `delta = kz k0 d` of a layer,
//! `over = w sin(delta)/kz` and `under = kz/w sin(delta)`, `w = 1` (s) or `n^2` (p), from its bottom to its top
//!
//! ```text
//! e_top = cos(delta) e - i over h,   h_top = cos(delta) h - i under e
//! ```
//!
//! Source: F. Abeles, Ann. Phys. (Paris) 5, 596 (1950).

use iridesce_numerics::Number;
use iridesce_numerics::complex::{Complex, add, inverse, mul, sub};

/// cos(delta) and sin(delta) of a layer, both times `exp(-Im delta)`: nothing grows in opaque layers.
#[derive(Debug, Clone, Copy)]
pub struct Turn<V> {
    /// cos(delta) exp(-Im delta)
    pub cos: Complex<V>,
    /// sin(delta) exp(-Im delta)
    pub sin: Complex<V>,
}

impl<V: Number> Turn<V> {
    /// From sine and cosine of the real part, and cosh and sinh of the imaginary one times its exponential.
    #[inline(always)]
    pub fn new(sin: V, cos: V, cosh: V, sinh: V) -> Turn<V> {
        Turn { cos: [cos * cosh, -(sin * sinh)], sin: [sin * cosh, cos * sinh] }
    }
}

/// Tangential fields at one interface.
#[derive(Debug, Clone, Copy)]
pub struct Field<V> {
    /// `E_y` (s) or `H_y` (p).
    pub e: Complex<V>,
    /// `H_x` (s) or `E_x` (p).
    pub h: Complex<V>,
}

impl<V: Number> Field<V> {
    /// The wave that leaves into the last medium, of unit amplitude there; `q = kz / w`.
    #[inline(always)]
    pub fn leaving(q: Complex<V>) -> Field<V> {
        Field { e: [q[0].like(1.0), q[0].like(0.0)], h: q }
    }

    /// Through any layer, from its bottom to its top.
    #[inline(always)]
    pub fn up(&mut self, cos: Complex<V>, over: Complex<V>, under: Complex<V>) {
        let (c_e, c_h) = (mul(cos, self.e), mul(cos, self.h));
        let (b, d) = (mul(over, self.h), mul(under, self.e));
        // -i (x + i y) = y - i x
        self.e = [c_e[0] + b[1], c_e[1] - b[0]];
        self.h = [c_h[0] + d[1], c_h[1] - d[0]];
    }

    /// Through a layer whose matrix elements are real: lossless, and light enters. Half the work.
    #[inline(always)]
    pub fn up_real(&mut self, cos: V, over: V, under: V) {
        let (e, h) = (self.e, self.h);
        self.e = [cos.mul_add(e[0], over * h[1]), cos.mul_sub(e[1], over * h[0])];
        self.h = [cos.mul_add(h[0], under * e[1]), cos.mul_sub(h[1], under * e[0])];
    }

    /// Net power flux downwards.
    #[inline(always)]
    pub fn flux(&self) -> V {
        self.e[0].mul_add(self.h[0], self.e[1] * self.h[1])
    }

    /// Reflected and transmitted field (E for s, H for p) over the incident one, from a first medium of real `q`.
    #[inline(always)]
    pub fn amplitudes(&self, q: V) -> (Complex<V>, Complex<V>) {
        let incoming = [self.e[0] * q, self.e[1] * q];
        let per_sum = inverse(add(incoming, self.h));
        let scale = q.times(2.0);
        (mul(sub(incoming, self.h), per_sum), [per_sum[0] * scale, per_sum[1] * scale])
    }
}
