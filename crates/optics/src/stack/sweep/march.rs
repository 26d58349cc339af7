//! The march of [`crate::stack`] with an evaluation a lane: both polarisations from one sine, cosine and exponential a layer.
//!
//! A layer that is lossless and lets light in at every row has real matrix elements; any other is taken as complex, its
//! matrix times `exp(-|Im delta|)`, the logarithms added up. The sign that is lost with whole half turns of phase turns
//! both fields over, which no power can tell.

use fearless_simd::Simd;
use iridesce_numerics::complex::{Complex, mul};
use iridesce_numerics::turns::{exp_m1, sin_cos_pi, within_half_turn};
use iridesce_numerics::{F64s, Number};

use super::lanes::{LANES, Lane};
use crate::OpticsError;
use crate::stack::layer::{Field, Turn};

/// A complex number a lane.
pub(super) type Pair = [Lane; 2];
/// A layer of one medium, for a block of rows. For s the fields are `(E_y, H_x)`, for p `(H_y, E_x)`; `w` is 1 or n^2:
/// what the sine is multiplied by, `w/kz` above and `kz/w` below the diagonal.
#[derive(Debug, Clone)]
pub(super) struct MediumRows {
    /// Half turns of phase per nm, and nepers of decay per nm.
    pub(super) rate: Lane,
    pub(super) loss: Lane,
    pub(super) over: [Pair; 2],
    pub(super) under: [Pair; 2],
}

/// A block of rows: one wavelength and direction a lane.
#[derive(Debug, Clone)]
pub(super) struct StackRows {
    /// `q` of the first medium (real) and of the last, of s and of p.
    pub(super) first: [Lane; 2],
    pub(super) last: [Pair; 2],
    /// One entry a medium; those that no layer is of stay empty.
    pub(super) media: Vec<MediumRows>,
    /// 1 where some layer absorbs, 0 where none does.
    pub(super) absorbs: Lane,
}

impl StackRows {
    pub(super) fn new(media: usize) -> StackRows {
        let pair = [Lane::ZERO; 2];
        let medium = MediumRows { rate: Lane::ZERO, loss: Lane::ZERO, over: [pair; 2], under: [pair; 2] };
        StackRows { first: [Lane::ZERO; 2], last: [pair; 2], media: vec![medium; media], absorbs: Lane::ZERO }
    }

    /// Every lane of `self` becomes the given row of `other`.
    pub(super) fn repeat(&mut self, other: &StackRows, row: usize) {
        let splat = |to: &mut Lane, from: &Lane| to.0 = [from.0[row]; LANES];
        let splat_pair = |to: &mut Pair, from: &Pair| to.iter_mut().zip(from).for_each(|(to, from)| splat(to, from));
        for polarization in 0..2 {
            splat(&mut self.first[polarization], &other.first[polarization]);
            splat_pair(&mut self.last[polarization], &other.last[polarization]);
        }
        splat(&mut self.absorbs, &other.absorbs);
        for (to, from) in self.media.iter_mut().zip(&other.media) {
            splat(&mut to.rate, &from.rate);
            splat(&mut to.loss, &from.loss);
            for polarization in 0..2 {
                splat_pair(&mut to.over[polarization], &from.over[polarization]);
                splat_pair(&mut to.under[polarization], &from.under[polarization]);
            }
        }
    }
}

/// Which power ratio is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Power {
    /// What comes back.
    #[default]
    Reflectance,
    /// What passes.
    Transmittance,
    /// What stays in the layers.
    Absorptance,
}

impl Power {
    /// By name: `reflectance`, `transmittance` or `absorptance`.
    pub fn named(name: &str) -> Result<Power, OpticsError> {
        match name {
            "reflectance" => Ok(Power::Reflectance),
            "transmittance" => Ok(Power::Transmittance),
            "absorptance" => Ok(Power::Absorptance),
            _ => Err(OpticsError::Unknown(format!(
                "quantity must be \"reflectance\", \"transmittance\" or \"absorptance\", got {name:?}"
            ))),
        }
    }
}

#[inline(always)]
fn load_pair<S: Simd>(simd: S, pair: &Pair, at: usize) -> Complex<F64s<S>> {
    [pair[0].load(simd, at), pair[1].load(simd, at)]
}

/// One answer a lane; NaN where fields left the range of a double (a long mirror), for the careful path to do.
///
/// `layers` tells the medium of each layer, `real` of each medium whether its matrix elements are real; `FROM..UNTIL` picks the polarisations, s is 0 and p is 1.
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "the index also names the polarisation's elements")]
pub(super) fn march<S: Simd, const FROM: usize, const UNTIL: usize>(
    simd: S,
    rows: &StackRows,
    layers: &[usize],
    real: &[bool],
    thickness_nm: &[Lane],
    power: Power,
    out: &mut Lane,
) {
    for at in (0..LANES).step_by(F64s::<S>::LEN) {
        let one = F64s::splat(simd, 1.0);
        let zero = F64s::splat(simd, 0.0);
        let mut fields = [Field { e: [one, zero], h: [zero, zero] }; 2];
        for polarization in FROM..UNTIL {
            fields[polarization].h = load_pair(simd, &rows.last[polarization], at);
        }
        let mut log = zero;
        for (&medium, length) in layers.iter().zip(thickness_nm).rev() {
            let layer = &rows.media[medium];
            let length = length.load(simd, at);
            let (sin, cos) = sin_cos_pi(within_half_turn(layer.rate.load(simd, at), length));
            if real[medium] {
                for polarization in FROM..UNTIL {
                    let over = layer.over[polarization][0].load(simd, at) * sin;
                    let under = layer.under[polarization][0].load(simd, at) * sin;
                    fields[polarization].up_real(cos, over, under);
                }
            } else {
                let decay = layer.loss.load(simd, at) * length;
                log = log + decay;
                // cosh and sinh times exp(-decay); exp - 1 keeps the digits of sinh for thin layers.
                let sinh = exp_m1(decay * -2.0).0 * -0.5;
                let cosh = one - sinh;
                let turn = Turn::new(sin, cos, cosh, sinh);
                for polarization in FROM..UNTIL {
                    let over = mul(load_pair(simd, &layer.over[polarization], at), turn.sin);
                    let under = mul(load_pair(simd, &layer.under[polarization], at), turn.sin);
                    fields[polarization].up(turn.cos, over, under);
                }
            }
        }
        let passed = if power == Power::Reflectance { one } else { exp_m1(-log).1 };
        let mut parts = [(one, one); 2];
        for polarization in FROM..UNTIL {
            let Field { e, h } = fields[polarization];
            let q = rows.first[polarization].load(simd, at);
            let (a, b) = (q.mul_add(e[0], h[0]), q.mul_add(e[1], h[1]));
            let all = a.mul_add(a, b * b);
            let share = match power {
                Power::Reflectance => {
                    let (a, b) = (q.mul_sub(e[0], h[0]), q.mul_sub(e[1], h[1]));
                    a.mul_add(a, b * b)
                }
                Power::Transmittance => rows.last[polarization][0].load(simd, at) * q * 4.0,
                Power::Absorptance => {
                    let entering = fields[polarization].flux();
                    let leaving = rows.last[polarization][0].load(simd, at) * passed * passed;
                    (entering - leaving) * q * 4.0 * rows.absorbs.load(simd, at)
                }
            };
            parts[polarization] = (share, all);
        }
        let mut all = parts[FROM].1;
        let mut share = parts[FROM].0;
        if UNTIL - FROM == 2 {
            // One division for two ratios; their product stays within range where both do.
            let (other, other_all) = parts[UNTIL - 1];
            share = share.mul_add(other_all, other * all) * 0.5;
            all = all * other_all;
        }
        let value = match power {
            Power::Reflectance => (share / all).min(one),
            // Factor by factor: the square of exp(-log) alone could underflow where T does not.
            Power::Transmittance => share / all * passed * passed,
            Power::Absorptance => share / all,
        };
        let in_range = all.gt(F64s::splat(simd, 1e-250)) & all.lt(F64s::splat(simd, 1e250));
        out.store::<S>(at, Number::select(in_range, value, F64s::splat(simd, f64::NAN)));
    }
}
