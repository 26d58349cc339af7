//! The colour of a stack: the full spectral sum at every point of an array of thicknesses and angles.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::gamut::{Gamut, Mapping};
use super::illuminant::Illuminant;
use super::observer::Observer;
use super::single_film::{FilmSpectrum, normal_wavenumber};
use super::space::{Adaptation, Space};
use super::sums::{Grid, Weights};
use crate::incidence::Incidence;
use crate::stack::{self, Solver};
use crate::{Complex64, Medium, OpticsError, Polarization};

/// Which power ratio is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quantity {
    /// What comes back.
    #[default]
    Reflectance,
    /// What passes.
    Transmittance,
    /// What stays.
    Absorptance,
}

impl Quantity {
    /// `"reflectance"`, `"transmittance"` or `"absorptance"`.
    pub fn named(name: &str) -> Result<Quantity, OpticsError> {
        match name {
            "reflectance" => Ok(Quantity::Reflectance),
            "transmittance" => Ok(Quantity::Transmittance),
            "absorptance" => Ok(Quantity::Absorptance),
            _ => Err(OpticsError::Unknown(format!(
                "quantity must be \"reflectance\", \"transmittance\" or \"absorptance\", got {name:?}"
            ))),
        }
    }
}

/// Which optics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// Every reflection, both polarisations.
    #[default]
    Exact,
    /// The two-beam form of 1991: one layer, real indices, amplitudes of normal incidence at every angle.
    TwoBeam,
}

impl Model {
    /// `"exact"` or `"two-beam"`.
    pub fn named(name: &str) -> Result<Model, OpticsError> {
        match name {
            "exact" => Ok(Model::Exact),
            "two-beam" => Ok(Model::TwoBeam),
            _ => Err(OpticsError::Unknown(format!("model must be \"exact\" or \"two-beam\", got {name:?}"))),
        }
    }
}

/// What is asked of a stack.
#[derive(Debug, Clone)]
pub struct ColorRequest {
    /// First medium, layers in the order light meets them, last medium.
    pub media: Vec<Medium>,
    /// One entry a layer; `false` for an incoherent slab.
    pub coherent: Vec<bool>,
    /// The light.
    pub illuminant: Illuminant,
    /// The observer.
    pub observer: Observer,
    /// The polarisation of the light.
    pub polarization: Polarization,
    /// The power ratio.
    pub quantity: Quantity,
    /// The optics.
    pub model: Model,
    /// Wavelengths of the sum, taken as they are; `None`: 360..830 nm at 1 nm, refined where fringes need it.
    pub grid: Option<Grid>,
    /// The space of the answer.
    pub space: Space,
    /// Adaptation to the space's white.
    pub adaptation: Adaptation,
    /// What to do with RGB out of range; `None` keeps it.
    pub gamut: Option<Mapping>,
}

/// A fringe needs 4 steps of the sum or more: 2 n t cos(theta) step / lambda^2 <= 1/4.
pub const FRINGE_STEPS: f64 = 0.25;
/// The grid is halved this often at most, to 1/4096 nm: enough for 5 cm of glass.
const HALVINGS: usize = 12;

/// A request made ready: weights, and the indices of all media at every wavelength.
#[derive(Debug)]
pub struct StackColor {
    request: ColorRequest,
    levels: [OnceLock<Result<Level, OpticsError>>; HALVINGS + 1],
}

/// One refinement of the sum.
#[derive(Debug)]
struct Level {
    weights: Weights,
    /// X, Y, Z weights one after the other, for long plain loops.
    columns: [Vec<f64>; 3],
    /// `media` indices at each wavelength.
    indices: Vec<Complex64>,
    /// Media whose stated extension was used.
    extended: BTreeSet<String>,
}

/// Colours, and what the user should hear about them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Colors {
    /// One colour a point.
    pub values: Vec<[f64; 3]>,
    /// Points outside the gamut (where a gamut mapping was asked for).
    pub out_of_gamut: u64,
    /// Largest 2 n t cos(theta) step / lambda^2 on a grid the user forced; above [`FRINGE_STEPS`] fringes are lost.
    pub fringe_steps: f64,
}

impl StackColor {
    /// Checks the request and reads all indices at the wavelengths of the sum.
    pub fn new(request: ColorRequest) -> Result<StackColor, OpticsError> {
        let bad = |message: &str| Err(OpticsError::Argument(message.to_string()));
        if request.media.len() < 2 || request.coherent.len() + 2 != request.media.len() {
            return bad("a stack needs a first medium, one entry of coherent for each layer, and a last medium");
        }
        if request.gamut.is_some() && request.space.rgb_from_xyz().is_none() {
            return Err(OpticsError::Argument(format!(
                "gamut= needs an RGB space (srgb, display-p3, rec2020, linear-srgb, acescg, ntsc1953), got space={:?}",
                request.space.name()
            )));
        }
        if request.model == Model::TwoBeam {
            if request.coherent.len() != 1 || !request.coherent[0] {
                return bad("model=\"two-beam\" needs exactly one layer, a coherent one");
            }
            if request.polarization != Polarization::Unpolarized {
                return bad("model=\"two-beam\" knows no polarisation: polarization must be \"unpolarized\"");
            }
            if request.quantity != Quantity::Reflectance {
                return bad("model=\"two-beam\" gives the reflectance only: quantity must be \"reflectance\"");
            }
        }
        let made = StackColor { request, levels: [const { OnceLock::new() }; HALVINGS + 1] };
        made.level(0)?;
        Ok(made)
    }

    /// Names of the media whose stated extension beyond their data was used.
    pub fn extended(&self) -> Vec<String> {
        let levels = self.levels.iter().filter_map(|level| level.get()?.as_ref().ok());
        let names: BTreeSet<&String> = levels.flat_map(|level| &level.extended).collect();
        names.into_iter().cloned().collect()
    }

    /// Colours of many points: `thickness_nm` holds one row of layers a point, `angle_deg` one angle a point.
    /// All cores work at it; the answer does not depend on how many there are.
    pub fn colors(&self, thickness_nm: &[f64], angle_deg: &[f64]) -> Result<Colors, OpticsError> {
        let (points, layers) = (angle_deg.len(), self.request.coherent.len());
        if thickness_nm.len() != points * layers {
            let message = format!("{points} points of {layers} layers need {} thicknesses", points * layers);
            return Err(OpticsError::Argument(format!("{message}, got {}", thickness_nm.len())));
        }
        if let Some(i) = angle_deg.iter().position(|a| !(0.0..90.0).contains(a)) {
            let message = format!("angle_deg must be >= 0 and < 90, got {} at point {i}", angle_deg[i]);
            return Err(OpticsError::Argument(message));
        }
        if let Some(i) = thickness_nm.iter().position(|t| !(*t >= 0.0 && t.is_finite())) {
            let message =
                format!("thickness_nm must be >= 0 and finite, got {} at point {}", thickness_nm[i], i / layers);
            return Err(OpticsError::Argument(message));
        }
        // Points of one angle share their Fresnel amplitudes: visit them together.
        let mut order: Vec<usize> = (0..points).collect();
        order.sort_by(|&a, &b| angle_deg[a].total_cmp(&angle_deg[b]));
        let visited: Vec<(usize, [f64; 3], bool, f64)> = order
            .par_chunks(256)
            .map(|chunk| {
                let mut at: Option<AtAngle> = None;
                chunk
                    .iter()
                    .map(|&i| {
                        let here = match &mut at {
                            Some(here) if here.angle_deg == angle_deg[i] => here,
                            other => other.insert(AtAngle::new(self, angle_deg[i])?),
                        };
                        let (value, outside, fringe) = here.color(&thickness_nm[i * layers..(i + 1) * layers])?;
                        Ok((i, value, outside, fringe))
                    })
                    .collect::<Result<Vec<_>, OpticsError>>()
            })
            .collect::<Result<Vec<_>, _>>()?
            .concat();
        let mut colors = Colors { values: vec![[0.0; 3]; points], ..Colors::default() };
        for (i, value, outside, fringe) in visited {
            colors.values[i] = value;
            colors.out_of_gamut += u64::from(outside);
            colors.fringe_steps = colors.fringe_steps.max(fringe);
        }
        Ok(colors)
    }

    fn grid(&self) -> Grid {
        self.request.grid.unwrap_or_default()
    }

    fn level(&self, halvings: usize) -> Result<&Level, OpticsError> {
        self.levels[halvings].get_or_init(|| self.make_level(halvings)).as_ref().map_err(Clone::clone)
    }

    fn make_level(&self, halvings: usize) -> Result<Level, OpticsError> {
        let request = &self.request;
        let grid = self.grid().divided(1 << halvings);
        let weights = Weights::new(&grid, &request.illuminant, request.observer)?;
        let mut indices = Vec::with_capacity(weights.wavelength_nm.len() * request.media.len());
        let mut extended = BTreeSet::new();
        for &nm in &weights.wavelength_nm {
            for (place, medium) in request.media.iter().enumerate() {
                let (index, beyond) = medium.index_extended(nm)?;
                if beyond {
                    extended.insert(medium.name().to_string());
                }
                check_index(index, place, medium, nm, request)?;
                indices.push(index);
            }
        }
        let columns = std::array::from_fn(|i| weights.xyz.iter().map(|w| w[i]).collect());
        Ok(Level { weights, columns, indices, extended })
    }
}

fn check_index(
    index: Complex64,
    place: usize,
    medium: &Medium,
    nm: f64,
    request: &ColorRequest,
) -> Result<(), OpticsError> {
    let last = place + 1 == request.media.len();
    let what = match place {
        0 if !(index.re > 0.0 && index.im == 0.0) => "the first medium must have a real index > 0",
        _ if last && index.im < 0.0 => "the last medium must not amplify (k >= 0)",
        _ if request.model == Model::TwoBeam && index.im != 0.0 => "model=\"two-beam\" needs real indices",
        _ if !(index.re.is_finite() && index.im.is_finite()) => "indices must be finite",
        _ => return Ok(()),
    };
    Err(OpticsError::Argument(format!("{what}, got {index} for medium {:?} at {nm} nm", medium.name())))
}

/// The stack at one angle, with what its points share.
struct AtAngle<'a> {
    of: &'a StackColor,
    angle_deg: f64,
    incidence: Incidence,
    /// max over the wavelengths of 2 Re(n cos theta) step / lambda^2, a layer; before any halving.
    fringe_per_nm: Vec<f64>,
    films: Vec<Option<Film>>,
    values: Vec<f64>,
}

/// How the spectrum is worked out at one refinement.
enum Film {
    Single(FilmSpectrum),
    General,
}

impl<'a> AtAngle<'a> {
    fn new(of: &'a StackColor, angle_deg: f64) -> Result<AtAngle<'a>, OpticsError> {
        let incidence = Incidence::from_degrees(angle_deg)?;
        let level = of.level(0)?;
        let (request, step) = (&of.request, of.grid().step_nm);
        let mut fringe_per_nm = vec![0.0f64; request.coherent.len()];
        for (i, &nm) in level.weights.wavelength_nm.iter().enumerate() {
            if level.weights.grid_index[i].is_none() {
                continue; // a line is exact at any thickness
            }
            let n = &level.indices[i * request.media.len()..][..request.media.len()];
            for (layer, fringe) in fringe_per_nm.iter_mut().enumerate() {
                if request.coherent[layer] {
                    let path = normal_wavenumber(incidence, n[0].re, n[layer + 1]).re.abs();
                    *fringe = fringe.max(2.0 * path * step / (nm * nm));
                }
            }
        }
        let films = (0..=HALVINGS).map(|_| None).collect();
        Ok(AtAngle { of, angle_deg, incidence, fringe_per_nm, films, values: Vec::new() })
    }

    /// The colour at this angle, whether it was out of gamut, and the fringe measure on a forced grid.
    fn color(&mut self, thickness_nm: &[f64]) -> Result<([f64; 3], bool, f64), OpticsError> {
        let request = &self.of.request;
        let fringe: f64 = self.fringe_per_nm.iter().zip(thickness_nm).map(|(f, t)| f * t).sum();
        let halvings = if request.grid.is_some() { 0 } else { halvings_for(fringe, thickness_nm)? };
        let level = self.of.level(halvings)?;
        let xyz = self.xyz(level, halvings, thickness_nm)?;
        let white = level.weights.white;
        let (value, outside) = match request.gamut.and_then(|mapping| Gamut::new(request.space, mapping)) {
            None => (request.space.from_xyz(xyz, white, request.adaptation), false),
            Some(gamut) => gamut.map_encoded(request.space, request.space.from_xyz(xyz, white, request.adaptation)),
        };
        Ok((value, outside, if request.grid.is_some() { fringe } else { 0.0 }))
    }

    fn xyz(&mut self, level: &Level, halvings: usize, thickness_nm: &[f64]) -> Result<[f64; 3], OpticsError> {
        if self.films[halvings].is_none() {
            self.films[halvings] = Some(self.film(level)?);
        }
        self.values.resize(level.weights.wavelength_nm.len(), 0.0);
        match &self.films[halvings] {
            Some(Film::Single(film)) => film.evaluate(thickness_nm[0], &mut self.values),
            _ => general(&self.of.request, level, self.incidence, thickness_nm, &mut self.values)?,
        }
        Ok(level.columns.each_ref().map(|weights| dot(weights, &self.values)))
    }

    fn film(&self, level: &Level) -> Result<Film, OpticsError> {
        let request = &self.of.request;
        if request.coherent != [true] {
            return Ok(Film::General);
        }
        let indices: Vec<[Complex64; 3]> = level.indices.as_chunks::<3>().0.to_vec();
        let wavelengths = &level.weights.wavelength_nm;
        match request.model {
            Model::TwoBeam => FilmSpectrum::two_beam(wavelengths, &indices, self.incidence).map(Film::Single).map_err(|nm| {
                OpticsError::Argument(format!(
                    "model=\"two-beam\" does not hold beyond the critical angle: at angle_deg={} no light of {nm} nm enters the film",
                    self.angle_deg
                ))
            }),
            Model::Exact => Ok(
                match FilmSpectrum::exact(wavelengths, &indices, self.incidence, request.polarization, request.quantity) {
                    Some(film) => Film::Single(film),
                    None => Film::General,
                },
            ),
        }
    }
}

/// How often the 1 nm steps are halved so that every fringe has its steps.
fn halvings_for(fringe: f64, thickness_nm: &[f64]) -> Result<usize, OpticsError> {
    (0..=HALVINGS).find(|&h| fringe <= FRINGE_STEPS * (1usize << h) as f64).ok_or_else(|| {
        OpticsError::Argument(format!(
            "layers of {thickness_nm:?} nm are too thick for a coherent colour sum (finest step 1/{} nm); \
             mark thick layers coherent=False or give wavelength_nm=",
            1 << HALVINGS
        ))
    })
}

/// The spectrum of any stack by the general solver.
fn general(
    request: &ColorRequest,
    level: &Level,
    incidence: Incidence,
    thickness_nm: &[f64],
    out: &mut [f64],
) -> Result<(), OpticsError> {
    let media = request.media.len();
    let (mut solver, mut scratch) = (Solver::new(), Vec::new());
    for (i, (&nm, value)) in level.weights.wavelength_nm.iter().zip(out).enumerate() {
        let n = &level.indices[i * media..][..media];
        stack::check(n, thickness_nm, &request.coherent, nm)?;
        solver.prepare(n, thickness_nm, &request.coherent, nm, incidence);
        *value = match request.quantity {
            Quantity::Reflectance => solver.powers(request.polarization)?.reflectance,
            Quantity::Transmittance => solver.powers(request.polarization)?.transmittance,
            Quantity::Absorptance => solver.absorptance(request.polarization, &mut scratch)?,
        };
    }
    Ok(())
}

/// Sum of products, in four interleaved sums: the order is fixed, and the compiler may use vectors.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, a_rest) = a.as_chunks::<4>();
    let (b4, b_rest) = b.as_chunks::<4>();
    for (a, b) in a4.iter().zip(b4) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(n: &[Complex64], coherent: &[bool]) -> ColorRequest {
        ColorRequest {
            media: n.iter().map(|n| Medium::constant(*n).unwrap()).collect(),
            coherent: coherent.to_vec(),
            illuminant: Illuminant::named("D65").unwrap(),
            observer: Observer::Cie1931,
            polarization: Polarization::Unpolarized,
            quantity: Quantity::Reflectance,
            model: Model::Exact,
            grid: None,
            space: Space::Xyz,
            adaptation: Adaptation::None,
            gamut: None,
        }
    }

    fn real(n: &[f64]) -> Vec<Complex64> {
        n.iter().map(|n| Complex64::new(*n, 0.0)).collect()
    }

    fn close(a: [f64; 3], b: [f64; 3], tolerance: f64) {
        for i in 0..3 {
            assert!((a[i] - b[i]).abs() <= tolerance, "{a:?} against {b:?}");
        }
    }

    #[test]
    fn zero_thickness_is_the_bare_interface() {
        let made = StackColor::new(request(&real(&[1.0, 2.0, 1.5]), &[true])).unwrap();
        let colors = made.colors(&[0.0], &[0.0]).unwrap();
        close(colors.values[0], made.level(0).unwrap().weights.white.map(|w| 0.04 * w), 1e-15);
    }

    #[test]
    fn closed_form_is_the_general_solver() {
        let gold = Complex64::new(0.3, 2.9);
        for n in [
            [1.0.into(), 1.33.into(), 1.0.into()],
            [1.0.into(), 1.46.into(), gold],
            [1.0.into(), Complex64::new(2.4, 0.3), gold],
            [1.5.into(), 1.0.into(), 1.5.into()],
            [1.5.into(), gold, 1.0.into()],
        ] as [[Complex64; 3]; 5]
        {
            for quantity in [Quantity::Reflectance, Quantity::Transmittance, Quantity::Absorptance] {
                for polarization in [Polarization::S, Polarization::P, Polarization::Unpolarized] {
                    let made =
                        StackColor::new(ColorRequest { quantity, polarization, ..request(&n, &[true]) }).unwrap();
                    for (deg, t) in [(0.0, 5.0), (30.0, 310.0), (60.0, 1500.0), (80.0, 40.0)] {
                        let mut at = AtAngle::new(&made, deg).unwrap();
                        let (fast, ..) = at.color(&[t]).unwrap();
                        let (level, mut values) = (made.level(0).unwrap(), vec![0.0; at.values.len()]);
                        general(&made.request, level, at.incidence, &[t], &mut values).unwrap();
                        let slow = level.columns.each_ref().map(|w| dot(w, &values));
                        close(fast, slow, 2e-14);
                    }
                }
            }
        }
    }

    #[test]
    fn thick_films_are_refined_to_their_mean() {
        // Fringes far finer than 1 nm average out: R of the incoherent slab, 2 r0 / (1 + r0).
        let made = StackColor::new(request(&real(&[1.0, 1.5, 1.0]), &[true])).unwrap();
        let colors = made.colors(&[0.5e6], &[0.0]).unwrap();
        close(colors.values[0], made.level(0).unwrap().weights.white.map(|w| 0.08 / 1.04 * w), 2e-5);
        assert_eq!(colors.fringe_steps, 0.0);
        assert!(made.levels[5].get().is_none() && made.levels[6].get().is_some());
        let message = made.colors(&[1e9], &[0.0]).unwrap_err().to_string();
        assert!(message.contains("coherent=False"), "{message}");
    }

    #[test]
    fn refining_agrees_with_a_grid_given_as_fine() {
        let n = real(&[1.0, 1.33, 1.0]);
        let own = StackColor::new(request(&n, &[true])).unwrap().colors(&[30_000.0], &[10.0]).unwrap();
        let grid = Some(Grid::default().divided(4));
        let given = StackColor::new(ColorRequest { grid, ..request(&n, &[true]) }).unwrap();
        let given = given.colors(&[30_000.0], &[10.0]).unwrap();
        close(own.values[0], given.values[0], 1e-15);
        assert!(given.fringe_steps > 0.0 && given.fringe_steps < FRINGE_STEPS);
        let coarse =
            ColorRequest { grid: Some(Grid { first_nm: 380.0, step_nm: 10.0, count: 41 }), ..request(&n, &[true]) };
        let coarse = StackColor::new(coarse).unwrap().colors(&[30_000.0], &[10.0]).unwrap();
        assert!(coarse.fringe_steps > 4.0);
    }

    #[test]
    fn order_of_points_does_not_matter() {
        let made = StackColor::new(request(&real(&[1.0, 1.33, 1.5]), &[true])).unwrap();
        let angles: Vec<f64> = (0..700).map(|i| f64::from(i * 37 % 80)).collect();
        let thickness: Vec<f64> = (0..700).map(|i| f64::from(i) * 3.0).collect();
        let all = made.colors(&thickness, &angles).unwrap();
        for i in [0, 13, 333, 699] {
            assert_eq!(made.colors(&thickness[i..=i], &angles[i..=i]).unwrap().values[0], all.values[i]);
        }
    }

    #[test]
    fn gamut_and_spaces() {
        let n = real(&[1.0, 1.33, 1.0]);
        let asked = ColorRequest { space: Space::Srgb, gamut: Some(Mapping::Hue), ..request(&n, &[true]) };
        let thickness: Vec<f64> = (0..400).map(|i| f64::from(i) * 2.0).collect();
        let angles = vec![0.0; 400];
        let mapped = StackColor::new(asked.clone()).unwrap().colors(&thickness, &angles).unwrap();
        assert!(mapped.values.iter().flatten().all(|v| (0.0..=1.0).contains(v)));
        assert!(mapped.out_of_gamut > 20, "{}", mapped.out_of_gamut);
        let kept = StackColor::new(ColorRequest { gamut: None, ..asked.clone() })
            .unwrap()
            .colors(&thickness, &angles)
            .unwrap();
        let negative = kept.values.iter().filter(|v| v.iter().any(|v| *v < -2e-5)).count() as u64;
        assert_eq!((negative, kept.out_of_gamut), (mapped.out_of_gamut, 0));
        let message = StackColor::new(ColorRequest { space: Space::Lab, ..asked }).unwrap_err().to_string();
        assert!(message.contains("RGB space"), "{message}");
    }

    #[test]
    fn lines_need_no_refinement() {
        let mut asked = request(&real(&[1.0, 1.33, 1.0]), &[true]);
        asked.illuminant = Illuminant::named("laser:632.99").unwrap();
        let made = StackColor::new(asked).unwrap();
        let t = 1e6;
        let value = made.colors(&[t], &[0.0]).unwrap().values[0][1];
        let r0: f64 = (0.33f64 / 2.33).powi(2);
        let f = 4.0 * r0 / (1.0 - r0).powi(2) * (2.0 * std::f64::consts::PI * 1.33 * t / 632.99).sin().powi(2);
        assert!((value - f / (1.0 + f)).abs() < 1e-11);
    }

    #[test]
    fn refuses_what_it_cannot_do() {
        let good = request(&real(&[1.0, 1.33, 1.0]), &[true]);
        let two_beam = ColorRequest { model: Model::TwoBeam, ..good.clone() };
        let absorbing = request(&[1.0.into(), Complex64::new(1.33, 0.1), 1.0.into()], &[true]);
        for (bad, wanted) in [
            (ColorRequest { polarization: Polarization::S, ..two_beam.clone() }, "unpolarized"),
            (ColorRequest { quantity: Quantity::Transmittance, ..two_beam.clone() }, "reflectance only"),
            (ColorRequest { model: Model::TwoBeam, ..absorbing }, "real indices"),
            (ColorRequest { model: Model::TwoBeam, ..request(&real(&[1.0, 1.3, 1.4, 1.5]), &[true; 2]) }, "one layer"),
            (ColorRequest { coherent: vec![false], ..two_beam }, "coherent"),
            (request(&[Complex64::new(1.0, 0.1), 1.5.into()], &[]), "first medium"),
            (request(&[1.0.into(), Complex64::new(1.5, -0.1)], &[]), "last medium"),
            (request(&[1.0.into()], &[]), "a stack needs"),
        ] {
            let message = StackColor::new(bad).map(|_| ()).unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
        let made = StackColor::new(good).unwrap();
        assert!(made.colors(&[1.0], &[90.0]).unwrap_err().to_string().contains("angle_deg"));
        assert!(made.colors(&[-1.0], &[0.0]).unwrap_err().to_string().contains("thickness_nm"));
        assert!(made.colors(&[f64::NAN], &[0.0]).is_err());
        assert!(made.colors(&[1.0, 2.0], &[0.0]).is_err());
        assert_eq!(made.colors(&[], &[]).unwrap().values.len(), 0);
    }
}
