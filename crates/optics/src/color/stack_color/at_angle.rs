//! The colours of a stack's points at one angle, with all that they share.

use iridesce_numerics::Watch;
use iridesce_numerics::sums::dot;

use super::fringes::{AGREE, CHECKED_ABOVE, CHECKED_ABOVE_SHARP, GRAZING_DEG, HALVINGS, fringes, halvings_for};
use super::levels::{Level, Levels};
use crate::color::difference::ciede2000;
use crate::color::request::Model;
use crate::color::space::{Adaptation, Space};
use crate::color::two_beam::TwoBeamSpectrum;
use crate::incidence::Incidence;
use crate::stack;
use crate::stack::sweep::{Operand, Sweep, SweepRequest};
use crate::{Complex64, OpticsError};

/// How well a grid that the user forced resolves a point's fringes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Forced {
    /// Largest 2 n t cos(theta) step / lambda^2, layers added up; above [`FRINGE_STEPS`](crate::color::FRINGE_STEPS) fringes are lost.
    pub steps: f64,
    /// Coherent layers of that point together.
    pub thickness_nm: f64,
}

/// The stack at one angle, with what its points share.
pub struct AtAngle<'a> {
    of: &'a Levels,
    angle_deg: f64,
    incidence: Incidence,
    watch: &'a Watch,
    /// max over the wavelengths of 2 Re(n cos theta) step / lambda^2, a layer; before any halving.
    fringe_per_nm: Vec<f64>,
}

/// The colour of one point.
pub struct Found {
    /// Its place among all.
    pub point: usize,
    /// In the space that was asked for.
    pub value: [f64; 3],
    /// Whether the gamut does not hold it.
    pub outside: bool,
    /// How well a grid of the user's resolves its fringes.
    pub forced: Forced,
}

/// XYZ of a point by one sum, and the white of the same sum.
struct Sum {
    xyz: [f64; 3],
    white: [f64; 3],
}

impl Sum {
    fn lab(&self) -> [f64; 3] {
        Space::Lab.from_xyz(self.xyz, self.white, Adaptation::None)
    }
}

impl<'a> AtAngle<'a> {
    /// Reads what of the stack depends on the angle alone.
    pub fn new(of: &'a Levels, angle_deg: f64, watch: &'a Watch) -> Result<AtAngle<'a>, OpticsError> {
        let incidence = Incidence::from_degrees(angle_deg)?;
        let level = of.level(0)?;
        let (request, step) = (&of.request, of.grid().step_nm);
        // A line is exact at any thickness.
        let on_grid = (0..level.weights.wavelength_nm.len()).filter(|&i| level.weights.grid_index[i].is_some());
        let at = |i: usize| level.weights.wavelength_nm[i];
        let fringe_of = fringes(on_grid.map(|i| (i, at(i))), of.distinct.len(), &incidence, step, |medium, i| {
            of.index(level, medium.map_or(0, |number| of.distinct[number]), i)
        });
        let layers = request.coherent.iter().zip(&of.of[1..]);
        let fringe_per_nm = layers.map(|(&coherent, &medium)| if coherent { fringe_of[medium] } else { 0.0 }).collect();
        Ok(AtAngle { of, angle_deg, incidence, watch, fringe_per_nm })
    }

    /// The colours of some points, all at this angle.
    pub fn colors(&self, points: &[usize], thickness_nm: &[f64], found: &mut Vec<Found>) -> Result<(), OpticsError> {
        let request = &self.of.request;
        let layers = request.coherent.len();
        let row = |point: usize| &thickness_nm[point * layers..(point + 1) * layers];
        let fringe = |point: usize| self.fringe_per_nm.iter().zip(row(point)).map(|(f, t)| f * t).sum::<f64>();
        let halvings: Vec<usize> = points
            .iter()
            .map(|&point| match request.grid {
                Some(_) => Ok(0),
                None => halvings_for(fringe(point), row(point)),
            })
            .collect::<Result<_, _>>()?;
        let mut xyz = Vec::with_capacity(points.len());
        let mut rows = Vec::with_capacity(points.len() * layers);
        // (Neighbours with the same refinement; in a chart these are all of them, or nearly.)
        let mut start = 0;
        while start < points.len() {
            let same = halvings[start..].iter().take_while(|h| **h == halvings[start]).count();
            let run = &points[start..start + same];
            rows.clear();
            run.iter().for_each(|&point| rows.extend_from_slice(row(point)));
            let level = self.of.level(halvings[start])?;
            xyz.clear();
            xyz.resize(run.len(), [0.0; 3]);
            self.xyz(level, &rows, &mut xyz)?;
            let mut sums: Vec<Sum> = xyz.iter().map(|xyz| Sum { xyz: *xyz, white: level.weights.white }).collect();
            if request.grid.is_none() && request.model == Model::Exact {
                let is_sharp = self.of.has_spikes || self.angle_deg > GRAZING_DEG;
                let checked_above = if is_sharp { CHECKED_ABOVE_SHARP } else { CHECKED_ABOVE };
                let doubtful = (0..run.len()).filter(|&at| fringe(run[at]) > checked_above).collect();
                self.refine(halvings[start], doubtful, &rows, &mut sums)?;
            }
            for (&point, sum) in run.iter().zip(&sums) {
                let (value, outside) = request.finish(sum.xyz, sum.white);
                let forced = match request.grid {
                    Some(_) => Forced { steps: fringe(point), thickness_nm: self.coherent_nm(row(point)) },
                    None => Forced::default(),
                };
                found.push(Found { point, value, outside, forced });
            }
            start += same;
        }
        Ok(())
    }

    /// Sums of the points named in `doubtful` again in half steps, until that changes no colour any more.
    fn refine(
        &self,
        halvings: usize,
        mut doubtful: Vec<usize>,
        thickness_nm: &[f64],
        sums: &mut [Sum],
    ) -> Result<(), OpticsError> {
        let layers = self.of.request.coherent.len();
        for finer in halvings + 1..=HALVINGS {
            if doubtful.is_empty() {
                break;
            }
            let level = self.of.level(finer)?;
            let rows: Vec<f64> =
                doubtful.iter().flat_map(|at| &thickness_nm[at * layers..(at + 1) * layers]).copied().collect();
            let mut xyz = vec![[0.0; 3]; doubtful.len()];
            self.xyz(level, &rows, &mut xyz)?;
            let mut again = Vec::new();
            for (at, xyz) in doubtful.into_iter().zip(xyz) {
                let next = Sum { xyz, white: level.weights.white };
                let agree = ciede2000(sums[at].lab(), next.lab()) <= AGREE;
                if !agree {
                    sums[at] = next;
                    again.push(at);
                }
            }
            doubtful = again;
        }
        Ok(())
    }

    /// Thickness of all coherent layers together.
    fn coherent_nm(&self, thickness_nm: &[f64]) -> f64 {
        let coherent = thickness_nm.iter().zip(&self.of.request.coherent);
        coherent.filter(|(_, coherent)| **coherent).map(|(t, _)| t).sum()
    }

    /// XYZ of some points at one refinement.
    pub fn xyz(&self, level: &Level, thickness_nm: &[f64], out: &mut [[f64; 3]]) -> Result<(), OpticsError> {
        let request = &self.of.request;
        let wavelengths = &level.weights.wavelength_nm;
        let mut values = vec![0.0; wavelengths.len()];
        if request.model == Model::TwoBeam {
            let at = |i: usize| [0, 1, 2].map(|medium| self.of.index(level, medium, i));
            let indices: Vec<[Complex64; 3]> = (0..wavelengths.len()).map(at).collect();
            let film = TwoBeamSpectrum::new(wavelengths, &indices, self.incidence).map_err(|nm| {
                OpticsError::Argument(format!(
                    "model=\"two-beam\" does not hold beyond the critical angle: at angle_deg={} no light of {nm} nm \
                     enters the film",
                    self.angle_deg
                ))
            })?;
            for (out, thickness) in out.iter_mut().zip(thickness_nm) {
                film.evaluate(*thickness, &mut values);
                *out = level.columns.each_ref().map(|weights| dot(weights, &values));
            }
            return Ok(());
        }
        let columns = level.columns.each_ref().map(Vec::as_slice);
        self.sweep(level, thickness_nm, out.len())?.watched(self.watch).weigh(columns, out)
    }

    /// The spectra of some points.
    pub fn sweep<'b>(
        &'b self,
        level: &'b Level,
        thickness_nm: &'b [f64],
        points: usize,
    ) -> Result<Sweep<'b>, OpticsError> {
        let request = &self.of.request;
        let layers = request.coherent.len();
        let wavelength_nm = &level.weights.wavelength_nm;
        Sweep::new(SweepRequest {
            quantity: stack::sweep::Quantity::Power(request.quantity),
            polarization: request.polarization,
            indices: self.of.of.iter().map(|&table| level.tables[table].as_slice()).collect(),
            coherent: request.coherent.clone(),
            shape: vec![points, wavelength_nm.len()],
            wavelength_nm: Operand { values: wavelength_nm, strides: vec![0, 1] },
            angle_deg: Operand { values: std::slice::from_ref(&self.angle_deg), strides: vec![0, 0] },
            thickness_nm: (0..layers)
                .map(|layer| Operand { values: &thickness_nm[layer..], strides: vec![layers, 0] })
                .collect(),
        })
    }
}
