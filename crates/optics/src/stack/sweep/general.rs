//! Element by element through the solver: whatever the vectors do not cover, and every error with its place.

use super::march::Power;
use super::{Quantity, Sweep};
use crate::film::two_beam_reflectance;
use crate::incidence::Incidence;
use crate::stack::{Polarization, Solver, ellipsometry};
use crate::{Complex64, OpticsError};
use iridesce_numerics::place_of;

/// Where in the result one is, and in every operand.
struct Place {
    index: Vec<usize>,
    offsets: Vec<usize>,
}

/// What one evaluation after the other needs.
pub(super) struct Bench {
    solver: Solver,
    scratch: Vec<f64>,
    indices: Vec<Complex64>,
    indices_at: usize,
    thickness_nm: Vec<f64>,
    incidence: Option<(f64, Incidence)>,
}

impl Sweep<'_> {
    pub(super) fn bench(&self) -> Bench {
        let layers = self.coherent.len();
        Bench {
            solver: Solver::new(),
            scratch: Vec::new(),
            indices: vec![Complex64::default(); layers + 2],
            indices_at: usize::MAX,
            thickness_nm: vec![0.0; layers],
            incidence: None,
        }
    }

    /// The elements from `start` on, as many as there is room for.
    pub(super) fn run_general(
        &self,
        start: usize,
        count: usize,
        first: &mut [f64],
        second: &mut [f64],
    ) -> Result<(), OpticsError> {
        let [wide, wide_second] = self.quantity.widths(self.coherent.len());
        let mut bench = self.bench();
        let mut place = self.place(start);
        for element in 0..count {
            self.look()?;
            let first = &mut first[element * wide..][..wide];
            let second = &mut second[element * wide_second..][..wide_second];
            self.evaluate_at(&mut bench, &place.offsets, first, second)
                .map_err(|error| OpticsError::Argument(format!("{error}{}", named_place(&place.index))))?;
            self.step(&mut place);
        }
        Ok(())
    }

    /// One element, by where it stands in each operand.
    pub(super) fn evaluate_at(
        &self,
        bench: &mut Bench,
        offsets: &[usize],
        first: &mut [f64],
        second: &mut [f64],
    ) -> Result<(), OpticsError> {
        let (wavelength_nm, angle_deg) = (self.values[0][offsets[0]], self.values[1][offsets[1]]);
        let incidence = match bench.incidence {
            Some((angle, incidence)) if angle == angle_deg => incidence,
            _ => {
                let new = Incidence::from_degrees(angle_deg)?;
                bench.incidence = Some((angle_deg, new));
                new
            }
        };
        for ((thickness, values), &at) in bench.thickness_nm.iter_mut().zip(&self.values[2..]).zip(&offsets[2..]) {
            *thickness = values[at];
        }
        if bench.indices_at != offsets[0] {
            bench.indices_at = offsets[0];
            for (index, table) in bench.indices.iter_mut().zip(&self.indices) {
                *index = if table.len() == 1 { table[0] } else { table[offsets[0]] };
            }
        }
        let Bench { solver, scratch, indices, thickness_nm, .. } = bench;
        if self.quantity == Quantity::TwoBeam {
            let n = [indices[0].re, indices[1].re, indices[2].re];
            first[0] = two_beam_reflectance(n, thickness_nm[0], wavelength_nm, incidence.cos_theta())?;
            return Ok(());
        }
        solver.prepare(indices, thickness_nm, &self.coherent, wavelength_nm, incidence);
        match self.quantity {
            Quantity::Power(Power::Reflectance) => first[0] = solver.powers(self.polarization)?.reflectance,
            Quantity::Power(Power::Transmittance) => first[0] = solver.powers(self.polarization)?.transmittance,
            Quantity::Power(Power::Absorptance) => first[0] = solver.absorptance(self.polarization, scratch)?,
            Quantity::LayerAbsorptance => {
                solver.powers_and_layers(self.polarization, first)?;
            }
            Quantity::Amplitudes => {
                let amplitudes = solver.amplitudes(self.polarization)?;
                first.copy_from_slice(&[amplitudes.r.re, amplitudes.r.im]);
                second.copy_from_slice(&[amplitudes.t.re, amplitudes.t.im]);
            }
            Quantity::Ellipsometry | Quantity::TwoBeam => {
                let r_s = solver.amplitudes(Polarization::S)?.r;
                let r_p = solver.amplitudes(Polarization::P)?.r;
                (first[0], second[0]) = ellipsometry(r_s, r_p).ok_or_else(|| {
                    OpticsError::Argument("psi and delta have no value where nothing is reflected".into())
                })?;
            }
        }
        Ok(())
    }

    fn place(&self, mut element: usize) -> Place {
        let mut index = vec![0; self.shape.len()];
        for (index, &length) in index.iter_mut().zip(&self.shape).rev() {
            *index = element % length;
            element /= length;
        }
        let along = |strides: &Vec<usize>| strides.iter().zip(&index).map(|(stride, index)| stride * index).sum();
        let offsets = self.strides.iter().map(along).collect();
        Place { index, offsets }
    }

    /// On to the next element in C order.
    fn step(&self, place: &mut Place) {
        for axis in (0..self.shape.len()).rev() {
            place.index[axis] += 1;
            if place.index[axis] < self.shape[axis] {
                for (offset, strides) in place.offsets.iter_mut().zip(&self.strides) {
                    *offset += strides[axis];
                }
                return;
            }
            place.index[axis] = 0;
            for (offset, strides) in place.offsets.iter_mut().zip(&self.strides) {
                *offset -= strides[axis] * (self.shape[axis] - 1);
            }
        }
    }
}

fn named_place(index: &[usize]) -> String {
    let name = place_of(index);
    if name.is_empty() { name } else { format!(" ({name})") }
}
