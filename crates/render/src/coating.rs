//! Layers on a substrate at one hit: what they reflect and pass at every spectral node. No layers at all is the bare
//! surface of a medium.
//!
//! Fields are marched up from the medium beyond by [`iridesce_optics::stack::layer`], as everywhere, here in single
//! precision: q = kz / k0 in a medium is its `kz`, n^2 the weight of p light. Each layer is scaled by exp(-Im delta), so
//! that nothing grows in opaque ones; t collects the factors. q^2 = (n - n_0)(n + n_0) + (n_0 cos)^2 has no cancellation
//! near grazing incidence.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::complex::{Complex, conjugate_product, inverse, mul, power, square_root};
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_numerics::lanes::blocks;
use iridesce_numerics::turns::{exp2, sin_cos_pi};
use iridesce_optics::stack::layer::{Field, Turn};
use num_complex::Complex64;

use crate::film::{EXP2_PER_HALF_TURN, Mueller, Response, SMALLEST_COS};

/// Complex indices of a medium at the nodes of a render.
#[derive(Debug, Clone)]
pub struct IndexTable {
    n: Vec<Lanes>,
    k: Vec<Lanes>,
}

impl IndexTable {
    pub fn new(indices: &[Complex64]) -> IndexTable {
        IndexTable { n: blocks(indices.iter().map(|n| n.re)), k: blocks(indices.iter().map(|n| n.im)) }
    }

    /// The real index at a place among the nodes, linear between two.
    #[inline(always)]
    pub fn n_at(&self, place: f64) -> f64 {
        let node = place as usize;
        let n = f64::from(self.n[node / LANES].0[node % LANES]);
        let share = place - node as f64;
        if share == 0.0 {
            return n;
        }
        let beside = node + 1;
        (f64::from(self.n[beside / LANES].0[beside % LANES]) - n).mul_add(share, n)
    }

    /// The real indices of a block.
    #[inline(always)]
    pub fn real(&self, block: usize) -> &[f32; LANES] {
        &self.n[block].0
    }

    pub fn is_clear(&self) -> bool {
        self.k.iter().all(|lanes| lanes.0.iter().all(|k| *k == 0.0))
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, block: usize) -> [f32x16<S>; 2] {
        [self.n[block].load(simd), self.k[block].load(simd)]
    }
}

/// The layers at a hit: their indices and thicknesses, from outside inwards.
#[derive(Debug, Clone, Copy)]
pub struct LayersAt<'a> {
    pub tables: &'a [IndexTable],
    pub thickness_nm: &'a [f32],
}

/// What light meets at a hit, in the order in which a ray of the camera comes to it.
pub struct Sequence<'a> {
    /// The medium the ray is in; of its index the real part counts.
    pub outer: &'a IndexTable,
    pub layers: LayersAt<'a>,
    /// The layers stand in the other order: the ray comes from the substrate.
    pub is_reversed: bool,
    pub exit: &'a IndexTable,
    /// Half turns of phase per nm and unit of q: 2 / lambda.
    pub rate: &'a [Lanes],
}

impl Sequence<'_> {
    /// Everything about a block of nodes.
    #[inline(always)]
    pub fn response<S: Simd>(&self, simd: S, block: usize, cos_theta: f32) -> Response<S> {
        self.response_by_node(simd, block, f32x16::splat(simd, cos_theta))
    }

    /// The same with an angle of its own for each node.
    #[inline(always)]
    pub fn response_by_node<S: Simd>(&self, simd: S, block: usize, cos_theta: f32x16<S>) -> Response<S> {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let n_0 = self.outer.n[block].load(simd);
        let q_0 = n_0 * cos_theta.max(f32x16::splat(simd, SMALLEST_COS));
        let q_0_squared = q_0 * q_0;
        let per_n_0_squared = one / (n_0 * n_0);
        let rate = self.rate[block].load(simd);
        let n_exit = self.exit.load(simd, block);
        let (q_exit, per_exit_squared) = normal_to(n_exit, n_0, q_0_squared);
        // For p light the first of the two fields is the magnetic one.
        let y_p_exit = mul(q_exit, per_exit_squared);
        let (mut of_s, mut of_p) = (Field::leaving(q_exit), Field::leaving(y_p_exit));
        // Exponent (base 2) of the factors left out.
        let mut left_out = zero;
        let LayersAt { tables, thickness_nm } = self.layers;
        let count = tables.len();
        for i in 0..count {
            // From the exit side: the last of the order in which the ray comes.
            let layer = if self.is_reversed { i } else { count - 1 - i };
            let (q, per_n_squared) = normal_to(tables[layer].load(simd, block), n_0, q_0_squared);
            let turns = rate * thickness_nm[layer];
            let half_turns = q[0] * turns;
            let x = half_turns - half_turns.round_ties_even();
            let (sine, cosine) = sin_cos_pi(x);
            let exponent = q[1] * turns * -EXP2_PER_HALF_TURN;
            left_out += exponent;
            // exp(-2 Im delta); sums with it, halved, are cosh and sinh times exp(-Im delta).
            let decay = exp2(exponent * 2.0);
            let (cosh, sinh) = ((decay + 1.0) * 0.5, (one - decay) * 0.5);
            let Turn { cos, sin } = Turn::new(sine, cosine, cosh, sinh);
            let per_q = inverse(q);
            let n_squared = inverse(per_n_squared);
            of_s.up(cos, mul(sin, per_q), mul(sin, q));
            of_p.up(cos, mul(sin, mul(n_squared, per_q)), mul(sin, mul(q, per_n_squared)));
        }
        let y_p_0 = q_0 * per_n_0_squared;
        let (r_s, t_s) = of_s.amplitudes(q_0);
        let (r_p, t_p) = of_p.amplitudes(y_p_0);
        // Power that leaves against power that arrives; beyond the critical angle the real parts vanish.
        let decay = exp2(left_out * 2.0);
        let (t_s_power, t_p_power) = (q_exit[0] / q_0 * decay, y_p_exit[0].max(zero) / y_p_0 * decay);
        let between = (t_s_power * t_p_power).sqrt();
        let [re, im] = conjugate_product(t_s, t_p);
        Response {
            reflect: Mueller { s: power(r_s), p: power(r_p), cross: conjugate_product(r_s, r_p) },
            transmit: Mueller {
                s: power(t_s) * t_s_power,
                p: power(t_p) * t_p_power,
                cross: [re * between, im * between],
            },
        }
    }
}

// Functions, not closures: those are not always compiled for the wider instructions.

/// q = kz / k0 in a medium, and its 1 / n^2.
#[inline(always)]
fn normal_to<S: Simd>(
    n: Complex<f32x16<S>>,
    n_0: f32x16<S>,
    q_0_squared: f32x16<S>,
) -> (Complex<f32x16<S>>, Complex<f32x16<S>>) {
    let re = (n[0] - n_0).mul_add(n[0] + n_0, q_0_squared - n[1] * n[1]);
    (square_root([re, n[0] * n[1] * 2.0]), inverse(mul(n, n)))
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use iridesce_optics::Polarization;
    use iridesce_optics::stack::{Response as Solved, solve};

    use super::*;
    use crate::spectral::Nodes;

    const OUTER: usize = 0;

    /// Reflected and transmitted s, p and cross terms at every node.
    fn kernel(
        nodes: &Nodes,
        indices: &[Complex64],
        thickness_nm: &[f32],
        is_reversed: bool,
        cos_theta: f32,
    ) -> [Vec<[f32; 4]>; 2] {
        #[inline(always)]
        fn run<S: Simd>(simd: S, sequence: &Sequence<'_>, cos_theta: f32) -> [Vec<[f32; 4]>; 2] {
            let mut out = [Vec::new(), Vec::new()];
            for block in 0..sequence.rate.len() {
                let response = sequence.response(simd, block, cos_theta);
                for (m, out) in [response.reflect, response.transmit].into_iter().zip(&mut out) {
                    let lanes = [m.s, m.p, m.cross[0], m.cross[1]].map(|v| v.to_array());
                    out.extend((0..LANES).map(|i| [lanes[0][i], lanes[1][i], lanes[2][i], lanes[3][i]]));
                }
            }
            out
        }
        let table = |n: Complex64| IndexTable::new(&vec![n; nodes.len()]);
        let mut layers: Vec<IndexTable> = indices[1..indices.len() - 1].iter().map(|&n| table(n)).collect();
        let mut thickness_nm = thickness_nm.to_vec();
        if is_reversed {
            layers.reverse();
            thickness_nm.reverse();
        }
        let rate = blocks(nodes.wavelength_nm.iter().map(|nm| 2.0 / nm));
        let (outer, exit) = (table(indices[OUTER]), table(indices[indices.len() - 1]));
        let layers = LayersAt { tables: &layers, thickness_nm: &thickness_nm };
        let sequence = Sequence { outer: &outer, layers, is_reversed, exit: &exit, rate: &rate };
        dispatch!(Level::new(), simd => run(simd, &sequence, cos_theta))
    }

    /// The f32 march against the f64 multilayer. Tolerance: roundings of 2^-24 make the phase of a layer of m half turns
    /// wrong by about pi m 2^-22, of which r takes at most a few times as much near sharp fringes. Near a critical angle
    /// q^2 is a difference: an error of n_0^2 2^-23 makes q wrong by half of that over q.
    #[test]
    fn coatings_are_the_multilayer() {
        let c = Complex64::new;
        let (air, glass, silicon, metal) = (c(1.0, 0.0), c(1.52, 0.0), c(3.9, 0.02), c(0.9, 6.0));
        let cases: &[(&[Complex64], &[f32])] = &[
            (&[air, glass], &[]),
            (&[glass, air], &[]),
            (&[air, metal], &[]),
            (&[air, c(1.46, 0.0), silicon], &[320.0]),
            (&[air, c(2.4, 0.05), metal], &[75.0]),
            (&[c(1.33, 0.0), c(1.47, 0.0), air], &[610.0]),
            // A gap that light tunnels through beyond the critical angle.
            (&[glass, air, glass], &[150.0]),
            (&[air, c(2.3, 0.0), c(1.38, 0.0), c(2.3, 0.0), c(1.38, 0.0), glass], &[60.0, 100.0, 55.0, 90.0]),
            // Opaque: whatever is below must not come through, and nothing may overflow.
            (&[air, metal, glass], &[4000.0]),
            (&[air, c(1.5, 0.0), glass], &[0.0]),
        ];
        let nodes = Nodes::new(32, &[]);
        for (indices, thickness_nm) in cases {
            // Rounding of the inputs is not the kernel's.
            let rounded = |n: &Complex64| c(f64::from(n.re as f32), f64::from(n.im as f32));
            let indices: &[Complex64] = &indices.iter().map(rounded).collect::<Vec<_>>();
            for angle in [0.0_f64, 30.0, 41.0, 56.3, 80.0, 88.0] {
                for is_reversed in [false, true] {
                    let cos_theta = angle.to_radians().cos() as f32;
                    let found = kernel(&nodes, indices, thickness_nm, is_reversed, cos_theta);
                    let thickness: Vec<f64> = thickness_nm.iter().map(|&t| f64::from(t)).collect();
                    let half_turns: f64 = indices[1..].iter().zip(&thickness).map(|(n, t)| n.re * t / 180.0).sum();
                    let sine2 = indices[OUTER].re.powi(2) * (1.0 - f64::from(cos_theta).powi(2));
                    let smallest_q = indices[1..].iter().map(|n| (n * n - sine2).norm().sqrt()).fold(1.0, f64::min);
                    let near_critical = 4.0 * f64::from(f32::EPSILON) * indices[OUTER].re.powi(2) / smallest_q;
                    for (i, &nm) in nodes.wavelength_nm.iter().enumerate() {
                        let exact = [Polarization::S, Polarization::P].map(|polarization| -> Solved {
                            solve(
                                indices,
                                &thickness,
                                &vec![true; thickness.len()],
                                nm,
                                f64::from(cos_theta),
                                polarization,
                            )
                            .unwrap()
                        });
                        let tolerance = 3e-6 + 3e-6 * half_turns + near_critical;
                        let close = |found: f32, exact: f64, what: &str| {
                            assert!(
                                (f64::from(found) - exact).abs() <= tolerance,
                                "{what} of {indices:?} {thickness_nm:?} at {angle} deg, {nm} nm: {found}, exactly {exact}"
                            );
                        };
                        let [s, p] = &exact;
                        close(found[0][i][0], s.reflectance, "R_s");
                        close(found[0][i][1], p.reflectance, "R_p");
                        close(found[1][i][0], s.transmittance, "T_s");
                        close(found[1][i][1], p.transmittance, "T_p");
                        let (a_s, a_p) = (s.amplitudes.unwrap(), p.amplitudes.unwrap());
                        let cross = a_s.r * a_p.r.conj();
                        close(found[0][i][2], cross.re, "Re r_s r_p*");
                        close(found[0][i][3], cross.im, "Im r_s r_p*");
                        if indices[indices.len() - 1].im == 0.0 && s.transmittance > 1e-30 {
                            let phase = a_s.t * a_p.t.conj();
                            let cross = phase / phase.norm() * (s.transmittance * p.transmittance).sqrt();
                            close(found[1][i][2], cross.re, "Re t_s t_p*");
                            close(found[1][i][3], cross.im, "Im t_s t_p*");
                        }
                    }
                }
            }
        }
    }
}
