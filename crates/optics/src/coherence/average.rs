//! Averages over lines and over uneven thicknesses: Gauss-Legendre rules, doubled until they agree.

use std::f64::consts::TAU;

use iridesce_numerics::Watch;
use rayon::prelude::*;

use super::damped::damped;
use super::rules::{LineShape, Rule, TAIL, plain};
use crate::incidence::Incidence;
use crate::medium::Beyond;
use crate::stack::sweep::{Operand, Power, Quantity, Sweep, SweepRequest};
use crate::stack::{Polarization, check, layer_airy};
use crate::{Complex64, Medium, OpticsError};

/// Nodes a variable to begin with.
const FEWEST_NODES: usize = 16;
/// Nodes a variable at most.
pub const MOST_NODES: usize = 4096;
/// Evaluations of the finest rule at most, over all points.
const MOST_EVALUATIONS: usize = 1 << 28;
/// Evaluations that are worked through together: their indices stay in the second cache.
const PASS: usize = 1 << 14;
/// A Gaussian of thicknesses is cut at 0; from this many standard deviations on nothing is cut, and the series is exact.
const CLEAR_OF_ZERO: f64 = 6.0;
/// The least error that is stated.
const LEAST_ERROR: f64 = 1e-13;

/// What is averaged.
#[derive(Debug, Clone, Copy)]
pub struct AverageRequest<'a> {
    /// Reflectance or transmittance.
    pub power: Power,
    /// Of which light.
    pub polarization: Polarization,
    /// First medium, that of each layer, last medium.
    pub media: &'a [Medium],
    /// Of each layer whether it is coherent.
    pub coherent: &'a [bool],
    /// Shape and full width at half maximum, nm, of each line: an instrument's, a source's.
    pub lines: &'a [(LineShape, f64)],
    /// Standard deviation of each layer's thickness, nm: Gaussians independent of one another, cut at 0.
    pub thickness_sd_nm: &'a [f64],
    /// Wanted error.
    pub tolerance: f64,
    /// Middle of the lines, one a point, nm.
    pub wavelength_nm: &'a [f64],
    /// One a point.
    pub angle_deg: &'a [f64],
    /// A row of layers a point, nm.
    pub thickness_nm: &'a [f64],
}

/// Averages of all points, and of each the last change of the rule, of which the error is a small part.
#[derive(Debug, Clone, PartialEq)]
pub struct Averaged {
    /// One a point.
    pub value: Vec<f64>,
    /// One a point.
    pub error: Vec<f64>,
}

/// Averages a power over lines and thicknesses. The spread of the one uneven layer of a coherent stack is averaged in closed
/// form ([`damped`]) where that layer is clear; all else by the tensor product of rules, doubled until no point changes by
/// more than the tolerance. Media are read at every wavelength of a line, and must be known there.
pub fn averaged(request: &AverageRequest<'_>, watch: &Watch) -> Result<Averaged, OpticsError> {
    let problem = Problem::new(request)?;
    let (points, dimensions) = (request.wavelength_nm.len(), problem.dimensions());
    if dimensions == 0 || points == 0 {
        let value = problem.sums(0, watch)?;
        return Ok(Averaged { error: vec![LEAST_ERROR; points], value });
    }
    let mut nodes = FEWEST_NODES;
    let mut last = problem.sums(nodes, watch)?;
    loop {
        nodes *= 2;
        let evaluations = nodes.checked_pow(dimensions as u32).and_then(|all| all.checked_mul(points));
        if nodes > MOST_NODES || evaluations.is_none_or(|all| all > MOST_EVALUATIONS) {
            return Err(OpticsError::Resource(format!(
                "the average needs more than {} nodes a variable to reach tolerance={:e}; give a larger tolerance or \
                 fewer points",
                nodes / 2,
                request.tolerance
            )));
        }
        let value = problem.sums(nodes, watch)?;
        let error: Vec<f64> = value.iter().zip(&last).map(|(new, old)| (new - old).abs()).collect();
        if error.iter().all(|error| *error <= request.tolerance) {
            let error = error.into_iter().map(|error| error.max(LEAST_ERROR)).collect();
            return Ok(Averaged { value, error });
        }
        last = value;
    }
}

struct Problem<'a> {
    request: &'a AverageRequest<'a>,
    layers: usize,
    /// Layers of uneven thickness.
    uneven: Vec<usize>,
    /// The one uneven layer, where it is averaged in closed form.
    in_series: Option<usize>,
}

/// One place of the tensor product: shift of the wavelength, places in (0, 1) of the uneven thicknesses, weight.
struct Place {
    shift_nm: f64,
    shares: Vec<f64>,
    weight: f64,
}

/// Points at places: wavelength, weight, and thickness of each layer.
struct Samples {
    wavelengths: Vec<f64>,
    weights: Vec<f64>,
    thicknesses: Vec<Vec<f64>>,
}

impl<'a> Problem<'a> {
    fn new(request: &'a AverageRequest<'a>) -> Result<Problem<'a>, OpticsError> {
        let layers = request.coherent.len();
        let points = request.wavelength_nm.len();
        let fits = request.media.len() == layers + 2
            && request.thickness_sd_nm.len() == layers
            && request.angle_deg.len() == points
            && request.thickness_nm.len() == points * layers;
        if !fits {
            return Err(OpticsError::Argument("media, thicknesses, spreads and points do not belong together".into()));
        }
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !positive(request.tolerance) || !request.lines.iter().all(|line| positive(line.1)) {
            return Err(OpticsError::Argument("tolerance and the widths of lines must be > 0 and finite".into()));
        }
        if let Some(sd) = request.thickness_sd_nm.iter().find(|sd| !(**sd >= 0.0 && sd.is_finite())) {
            return Err(OpticsError::Argument(format!("thickness_sd_nm must be >= 0 and finite, got {sd}")));
        }
        let uneven: Vec<usize> = (0..layers).filter(|&layer| request.thickness_sd_nm[layer] > 0.0).collect();
        if let Some(slab) = uneven.iter().find(|&&layer| !request.coherent[layer]) {
            return Err(OpticsError::Argument(format!(
                "thickness_sd_nm of an incoherent slab must be 0 (layer {}); it has no phase",
                slab + 1
            )));
        }
        let mut problem = Problem { request, layers, uneven, in_series: None };
        problem.in_series = problem.series()?;
        Ok(problem)
    }

    /// The one uneven layer if it is clear, lets light in, and is thick enough everywhere that no Gaussian is cut at 0.
    fn series(&self) -> Result<Option<usize>, OpticsError> {
        let (&[layer], true) = (self.uneven.as_slice(), self.request.coherent.iter().all(|&coherent| coherent)) else {
            return Ok(None);
        };
        let AverageRequest { media, wavelength_nm, angle_deg, thickness_nm, thickness_sd_nm, .. } = self.request;
        for (point, (&nm, &angle)) in wavelength_nm.iter().zip(*angle_deg).enumerate() {
            let n = media[layer + 1].index(nm, Beyond::Hold)?;
            let along = media[0].index(nm, Beyond::Hold)?.re * Incidence::from_degrees(angle)?.sin_theta();
            let thick = thickness_nm[point * self.layers + layer] >= CLEAR_OF_ZERO * thickness_sd_nm[layer];
            if !(n.im == 0.0 && n.re > along && thick) {
                return Ok(None);
            }
        }
        Ok(Some(layer))
    }

    fn dimensions(&self) -> usize {
        self.request.lines.len() + if self.in_series.is_some() { 0 } else { self.uneven.len() }
    }

    /// The tensor product of the rules.
    fn places(&self, nodes: usize) -> Vec<Place> {
        let mut places = vec![Place { shift_nm: 0.0, shares: Vec::new(), weight: 1.0 }];
        for &(shape, fwhm) in self.request.lines {
            places = spread(places, shape.rule(fwhm, nodes), |place, x| (place.shift_nm + x, place.shares.clone()));
        }
        if self.in_series.is_none() {
            for _ in &self.uneven {
                places = spread(places, plain(nodes), |place, x| {
                    (place.shift_nm, place.shares.iter().copied().chain([x]).collect())
                });
            }
        }
        places
    }

    /// The averages of all points by rules of so many nodes.
    fn sums(&self, nodes: usize, watch: &Watch) -> Result<Vec<f64>, OpticsError> {
        let points = self.request.wavelength_nm.len();
        if points == 0 {
            return Ok(Vec::new());
        }
        let places = self.places(nodes);
        // Passes of some places by all points; for many points, of one place by some.
        let at_once = (PASS / points).max(1);
        let passes: Vec<Result<Vec<[f64; 2]>, OpticsError>> =
            places.par_chunks(at_once).map(|places| self.pass(places, watch)).collect();
        let (mut total, mut norm) = (vec![0.0; points], vec![0.0; points]);
        for pass in passes {
            for ((total, norm), [value, weight]) in total.iter_mut().zip(&mut norm).zip(pass?) {
                *total += value;
                *norm += weight;
            }
        }
        Ok(total.into_iter().zip(norm).map(|(total, norm)| total / norm).collect())
    }

    /// Of each point the weighted sum over some places, and the sum of the weights.
    fn pass(&self, places: &[Place], watch: &Watch) -> Result<Vec<[f64; 2]>, OpticsError> {
        let points = self.request.wavelength_nm.len();
        let samples = self.samples(places)?;
        let tables = self.tables(&samples.wavelengths)?;
        let values = match self.in_series {
            Some(layer) => self.in_closed_form(layer, &samples.wavelengths, &tables, &samples.thicknesses, watch)?,
            None => self.swept(&samples, &tables, places.len(), watch)?,
        };
        let mut sums = vec![[0.0; 2]; points];
        for (at, (value, weight)) in values.iter().zip(&samples.weights).enumerate() {
            let sum = &mut sums[at % points];
            sum[0] += weight * value;
            sum[1] += weight;
        }
        Ok(sums)
    }

    /// Every point at every place, place after place.
    fn samples(&self, places: &[Place]) -> Result<Samples, OpticsError> {
        let AverageRequest { wavelength_nm, thickness_nm, thickness_sd_nm, .. } = self.request;
        let (points, layers) = (wavelength_nm.len(), self.layers);
        let count = places.len() * points;
        let mut wavelengths = Vec::with_capacity(count);
        let mut weights = Vec::with_capacity(count);
        let mut thicknesses = vec![Vec::with_capacity(count); layers];
        for place in places {
            for point in 0..points {
                let nm = wavelength_nm[point] + place.shift_nm;
                if nm <= 0.0 {
                    return Err(OpticsError::Argument(
                        "the line is wider than its wavelength: it reaches below 0 nm".into(),
                    ));
                }
                wavelengths.push(nm);
                let row = &thickness_nm[point * layers..][..layers];
                thicknesses.iter_mut().zip(row).for_each(|(column, &nm)| column.push(nm));
                let mut weight = place.weight;
                for (&layer, share) in self.uneven.iter().zip(&place.shares) {
                    // From 0 or the lower tail to the upper one: a rule over both sides of the cut would not converge.
                    let (sd, middle) = (thickness_sd_nm[layer], row[layer]);
                    let low = (-TAIL * sd).max(-middle);
                    let offset = low + (TAIL * sd - low) * share;
                    weight *= (-0.5 * (offset / sd).powi(2)).exp();
                    if let Some(last) = thicknesses[layer].last_mut() {
                        *last = (middle + offset).max(0.0);
                    }
                }
                weights.push(weight);
            }
        }
        Ok(Samples { wavelengths, weights, thicknesses })
    }

    fn swept(
        &self,
        samples: &Samples,
        tables: &[Vec<Complex64>],
        places: usize,
        watch: &Watch,
    ) -> Result<Vec<f64>, OpticsError> {
        let angle_deg = self.request.angle_deg;
        let angles: Vec<f64> = (0..places).flat_map(|_| angle_deg.iter().copied()).collect();
        let each = |values| Operand { values, strides: vec![1] };
        let request = SweepRequest {
            quantity: Quantity::Power(self.request.power),
            polarization: self.request.polarization,
            indices: tables.iter().map(Vec::as_slice).collect(),
            coherent: self.request.coherent.to_vec(),
            shape: vec![samples.weights.len()],
            wavelength_nm: each(samples.wavelengths.as_slice()),
            angle_deg: each(angles.as_slice()),
            thickness_nm: samples.thicknesses.iter().map(|column| each(column.as_slice())).collect(),
        };
        let mut values = vec![0.0; samples.weights.len()];
        Sweep::new(request)?.watched(watch).evaluate(&mut values)?;
        Ok(values)
    }

    /// Of each medium its index at each wavelength, or the one that holds at all.
    fn tables(&self, wavelength_nm: &[f64]) -> Result<Vec<Vec<Complex64>>, OpticsError> {
        let table = |medium: &Medium| match medium.constant_index() {
            Some(index) => Ok(vec![index]),
            None => wavelength_nm.iter().map(|&nm| medium.index(nm, Beyond::Refuse)).collect(),
        };
        self.request.media.iter().map(table).collect()
    }

    fn in_closed_form(
        &self,
        layer: usize,
        wavelength_nm: &[f64],
        tables: &[Vec<Complex64>],
        thicknesses: &[Vec<f64>],
        watch: &Watch,
    ) -> Result<Vec<f64>, OpticsError> {
        let AverageRequest { angle_deg, coherent, power, polarization, thickness_sd_nm, .. } = self.request;
        let parts = polarization.parts();
        let mut indices = vec![Complex64::default(); tables.len()];
        let mut thickness_nm = vec![0.0; thicknesses.len()];
        let mut values = Vec::with_capacity(wavelength_nm.len());
        for (at, &nm) in wavelength_nm.iter().enumerate() {
            if watch.is_stopped() {
                return Err(OpticsError::Stopped);
            }
            indices
                .iter_mut()
                .zip(tables)
                .for_each(|(n, table)| *n = if table.len() == 1 { table[0] } else { table[at] });
            thickness_nm.iter_mut().zip(thicknesses).for_each(|(nm, column)| *nm = column[at]);
            check(&indices, &thickness_nm, coherent, nm)?;
            let incidence = Incidence::from_degrees(angle_deg[at % angle_deg.len()])?;
            let mut sum = 0.0;
            for &part in parts {
                let airy = layer_airy(&indices, &thickness_nm, nm, incidence, part, layer)?;
                let per_nm = 2.0 * TAU * airy.kz.re / nm;
                let turn = Complex64::from_polar(1.0, per_nm * thickness_nm[layer]);
                sum += damped(&airy, turn, 0.5 * (per_nm * thickness_sd_nm[layer]).powi(2), *power);
            }
            values.push(sum / parts.len() as f64);
        }
        Ok(values)
    }
}

/// Every place with every node of a further rule; `of` gives the shift and the shares that a node makes of a place.
fn spread(places: Vec<Place>, rule: Rule, of: impl Fn(&Place, f64) -> (f64, Vec<f64>)) -> Vec<Place> {
    let mut all = Vec::with_capacity(places.len() * rule.len());
    for place in &places {
        for &(x, weight) in &rule {
            let (shift_nm, shares) = of(place, x);
            all.push(Place { shift_nm, shares, weight: place.weight * weight });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request<'a>(media: &'a [Medium], lines: &'a [(LineShape, f64)], sd: &'a [f64]) -> AverageRequest<'a> {
        AverageRequest {
            power: Power::Reflectance,
            polarization: Polarization::Unpolarized,
            media,
            coherent: &[true],
            lines,
            thickness_sd_nm: sd,
            tolerance: 1e-10,
            wavelength_nm: &[550.0, 560.0],
            angle_deg: &[30.0, 0.0],
            thickness_nm: &[3000.0, 2500.0],
        }
    }

    fn media(n: [Complex64; 3]) -> Vec<Medium> {
        n.into_iter().map(|n| Medium::constant(n).unwrap()).collect()
    }

    /// A trace of absorption takes the road of the rules, none the closed form: both must meet.
    #[test]
    fn the_series_is_the_rule() {
        let (clear, hazy) =
            ([1.0, 1.33, 1.5].map(Complex64::from), [1.0.into(), Complex64::new(1.33, 1e-13), 1.5.into()]);
        let watch = Watch::new();
        let found = [clear, hazy].map(|n| {
            let media = media(n);
            averaged(&request(&media, &[(LineShape::Gaussian, 2.0)], &[40.0]), &watch).unwrap()
        });
        for point in 0..2 {
            let [series, rule] = [&found[0], &found[1]].map(|found| found.value[point]);
            assert!((series - rule).abs() < 1e-9, "{series} {rule}");
        }
        assert!(found.iter().flat_map(|found| &found.error).all(|error| *error <= 1e-10));
    }

    #[test]
    fn nothing_uneven_is_the_stack_itself() {
        let media = media([1.0, 1.33, 1.0].map(Complex64::from));
        let found = averaged(&request(&media, &[], &[0.0]), &Watch::new()).unwrap();
        let exact = crate::film::airy([1.0, 1.33, 1.0].map(Complex64::from), 2500.0, 560.0, 1.0, Polarization::S);
        assert!((found.value[1] - exact.unwrap().reflectance).abs() < 1e-13);
    }

    #[test]
    fn refusals_and_stops() {
        let media = media([1.0, 1.33, 1.0].map(Complex64::from));
        let watch = Watch::new();
        let message = |request: AverageRequest<'_>| averaged(&request, &watch).unwrap_err();
        let wide = [(LineShape::Rectangle, 2000.0)];
        assert!(message(request(&media, &wide, &[0.0])).to_string().contains("below 0 nm"));
        let fine = AverageRequest { tolerance: 1e-300, ..request(&media, &[(LineShape::Gaussian, 100.0)], &[0.0]) };
        assert!(matches!(message(fine), OpticsError::Resource(_)));
        let slab = AverageRequest { coherent: &[false], ..request(&media, &[], &[1.0]) };
        assert!(message(slab).to_string().contains("incoherent slab must be 0"));
        watch.stop();
        let stopped = averaged(&request(&media, &[(LineShape::Gaussian, 1.0)], &[0.0]), &watch);
        assert_eq!(stopped, Err(OpticsError::Stopped));
    }
}
