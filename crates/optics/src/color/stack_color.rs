//! The colour of a stack: the full spectral sum at every point of an array of thicknesses and angles.

use iridesce_numerics::{ANGLE_DEG, THICKNESS_NM};
use std::collections::{BTreeSet, HashMap};
use std::sync::OnceLock;

use iridesce_numerics::Watch;
use iridesce_numerics::sums::dot;
use rayon::prelude::*;

use super::difference::ciede2000;
use super::observer::{FIRST_NM, LAST_NM};
use super::request::{ColorRequest, Model};
use super::space::{Adaptation, Space};
use super::sums::{Grid, Weights};
use super::two_beam::TwoBeamSpectrum;
use crate::incidence::{Incidence, sqrt_upper};
use crate::stack;
use crate::stack::sweep::{Operand, Sweep, SweepRequest};
use crate::{Complex64, Medium, OpticsError};

/// A fringe needs 4 steps of the sum or more: 2 n t cos(theta) step / lambda^2 <= 1/4.
pub const FRINGE_STEPS: f64 = 0.25;
/// Films with more than this share of a fringe a step are summed in half steps too, to see whether that changes the colour:
/// where layers reflect strongly (metals, grazing light) fringes have overtones, which need finer steps than fringes do.
const CHECKED_ABOVE: f64 = 1.0 / 16.0;
/// The same under a lamp whose spectrum has spikes, where 1 nm steps lose something on every fringe that is not broad, and
/// where light grazes the first face (beyond 75 degrees), so that fringes are sharp.
const CHECKED_ABOVE_SHARP: f64 = 1.0 / 64.0;
const GRAZING_DEG: f64 = 75.0;
/// Bends of a lamp's 1 nm table, sum |S'' cmf| / sum S cmf, above which it has spikes: 0.0004 to 0.006 for daylights, lamps
/// that glow and LEDs, 0.012 to 0.07 for discharge lamps.
const SPIKES: f64 = 0.01;
/// Sums that differ by less than this (CIEDE2000) are fine enough; the error of the coarser is about the difference, since
/// that of the finer falls with a power of it.
const AGREE: f64 = 0.01;
/// The grid is halved this often at most, to 1/4096 nm: enough for 5 cm of glass.
const HALVINGS: usize = 12;
/// Points a task: enough to share what an angle needs, few enough for their sums to stay in the second cache.
const CHUNK: usize = 512;
/// Indices of a refinement that are kept: 1 GiB of them.
const MOST_INDICES: usize = 1 << 26;

/// A request made ready: weights, and the indices of all media at every wavelength.
#[derive(Debug)]
pub struct StackColor {
    request: ColorRequest,
    has_spikes: bool,
    /// Places in the stack of media that differ from all before, and which of these each medium is.
    distinct: Vec<usize>,
    of: Vec<usize>,
    levels: [OnceLock<Result<Level, OpticsError>>; HALVINGS + 1],
}

/// One refinement of the sum.
#[derive(Debug)]
struct Level {
    weights: Weights,
    /// X, Y, Z weights one after the other, for long plain loops.
    columns: [Vec<f64>; 3],
    /// Of each distinct medium its index at every wavelength, or the one that holds at all of them.
    tables: Vec<Vec<Complex64>>,
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
    /// The point whose fringes need the finest steps, on a grid the user forced.
    pub forced: Forced,
}

/// How well a grid that the user forced resolves a point's fringes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Forced {
    /// Largest 2 n t cos(theta) step / lambda^2, layers added up; above [`FRINGE_STEPS`] fringes are lost.
    pub steps: f64,
    /// Coherent layers of that point together.
    pub thickness_nm: f64,
}

impl StackColor {
    /// Checks the request and reads all indices at the wavelengths of the sum.
    pub fn new(request: ColorRequest) -> Result<StackColor, OpticsError> {
        request.check()?;
        let has_spikes = has_spikes(&request);
        let (distinct, of) = distinct(&request.media);
        let levels = [const { OnceLock::new() }; HALVINGS + 1];
        let made = StackColor { request, has_spikes, distinct, of, levels };
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
        self.colors_watched(thickness_nm, angle_deg, &Watch::new())
    }

    /// The same, until the watch is stopped ([`OpticsError::Stopped`]).
    pub fn colors_watched(
        &self,
        thickness_nm: &[f64],
        angle_deg: &[f64],
        watch: &Watch,
    ) -> Result<Colors, OpticsError> {
        let (points, layers) = (angle_deg.len(), self.request.coherent.len());
        if thickness_nm.len() != points * layers {
            let message = format!("{points} points of {layers} layers need {} thicknesses", points * layers);
            return Err(OpticsError::Argument(format!("{message}, got {}", thickness_nm.len())));
        }
        if let Some(i) = ANGLE_DEG.first_outside(angle_deg) {
            return Err(ANGLE_DEG.refuse(angle_deg[i]).at(format!("at point {i}")).into());
        }
        if let Some(i) = THICKNESS_NM.first_outside(thickness_nm) {
            return Err(THICKNESS_NM.refuse(thickness_nm[i]).at(format!("at point {}", i / layers)).into());
        }
        // Points of one angle share all that does not depend on thickness: visit them together.
        let mut order: Vec<usize> = (0..points).collect();
        if angle_deg.windows(2).any(|pair| pair[0] != pair[1]) {
            order.par_sort_unstable_by(|&a, &b| angle_deg[a].total_cmp(&angle_deg[b]).then(a.cmp(&b)));
        }
        let visited = order
            .par_chunks((32 * CHUNK / (layers + 31)).max(1))
            .map(|chunk| {
                let runs = chunk.chunk_by(|&a, &b| angle_deg[a].to_bits() == angle_deg[b].to_bits());
                let mut found = Vec::with_capacity(chunk.len());
                for run in runs {
                    AtAngle::new(self, angle_deg[run[0]], watch)?.colors(run, thickness_nm, &mut found)?;
                }
                Ok(found)
            })
            .collect::<Result<Vec<Vec<Found>>, OpticsError>>()?;
        let mut colors = Colors { values: vec![[0.0; 3]; points], ..Colors::default() };
        for found in visited.into_iter().flatten() {
            colors.values[found.point] = found.value;
            colors.out_of_gamut += u64::from(found.outside);
            if found.forced.steps > colors.forced.steps {
                colors.forced = found.forced;
            }
        }
        Ok(colors)
    }

    /// XYZ of the light on the grid of the sum, Y = 1.
    pub fn white(&self) -> Result<[f64; 3], OpticsError> {
        Ok(self.level(0)?.weights.white)
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
        let mut extended = BTreeSet::new();
        let tables = self.tables(&weights.wavelength_nm, &mut extended)?;
        let columns = std::array::from_fn(|i| weights.xyz.iter().map(|w| w[i]).collect());
        Ok(Level { weights, columns, tables, extended })
    }

    /// A table a distinct medium; refused where all of them cannot fit, however many layers share them.
    fn tables(
        &self,
        wavelength_nm: &[f64],
        extended: &mut BTreeSet<String>,
    ) -> Result<Vec<Vec<Complex64>>, OpticsError> {
        let request = &self.request;
        let (media, last) = (&request.media, request.media.len() - 1);
        let disperse = self.distinct.iter().filter(|&&place| media[place].constant_index().is_none()).count();
        if disperse.saturating_mul(wavelength_nm.len()) > MOST_INDICES {
            return Err(OpticsError::Resource(format!(
                "the colour sum of {disperse} different dispersive media over {} wavelengths cannot fit: their indices \
                 would take {:.1} GiB of the {:.1} GiB allowed (mark thick layers coherent=False, or give \
                 wavelength_nm=)",
                wavelength_nm.len(),
                gib(disperse * wavelength_nm.len()),
                gib(MOST_INDICES)
            )));
        }
        let mut tables = Vec::with_capacity(self.distinct.len());
        for (number, &place) in self.distinct.iter().enumerate() {
            let medium = &media[place];
            let ends = [0, last].into_iter().filter(|&end| self.of[end] == number);
            let places: Vec<usize> = ends.chain([place]).collect();
            let needed = if medium.constant_index().is_some() { 1 } else { wavelength_nm.len() };
            let mut table = Vec::with_capacity(needed);
            for &nm in &wavelength_nm[..needed] {
                let (index, beyond) = medium.index_extended(nm).map_err(within_data)?;
                if beyond {
                    extended.insert(medium.name().to_string());
                }
                places.iter().try_for_each(|&place| request.check_index(index, place, nm))?;
                table.push(index);
            }
            if table.iter().all(|n| *n == table[0]) {
                table.truncate(1);
                table.shrink_to_fit();
            }
            tables.push(table);
        }
        Ok(tables)
    }

    /// The index of a medium of the stack at a wavelength of a level.
    fn index(&self, level: &Level, medium: usize, wavelength: usize) -> Complex64 {
        let table = &level.tables[self.of[medium]];
        if table.len() == 1 { table[0] } else { table[wavelength] }
    }
}

/// Indices of 16 bytes as GiB.
fn gib(indices: usize) -> f64 {
    indices as f64 * 16.0 / f64::from(1 << 30)
}

/// Media that differ from all before them, by their places, and which of these each one is: a mirror of thousands of
/// layers has two.
fn distinct(media: &[Medium]) -> (Vec<usize>, Vec<usize>) {
    let mut places: Vec<usize> = Vec::new();
    let mut of = Vec::with_capacity(media.len());
    let mut named: HashMap<&str, Vec<usize>> = HashMap::new();
    for (place, medium) in media.iter().enumerate() {
        let alike = named.entry(medium.name()).or_default();
        match alike.iter().find(|&&number| media[places[number]] == *medium) {
            Some(&number) => of.push(number),
            None => {
                alike.push(places.len());
                of.push(places.len());
                places.push(place);
            }
        }
    }
    (places, of)
}

/// Whether the lamp's continuum bends so sharply that steps of 1 nm may be too wide for it.
fn has_spikes(request: &ColorRequest) -> bool {
    let power = |nm: f64| request.illuminant.power(nm);
    let (mut bends, mut sums) = ([0.0; 3], [0.0; 3]);
    let steps = (LAST_NM - FIRST_NM) as u32;
    for nm in (1..steps).map(|step| FIRST_NM + f64::from(step)) {
        let bend = (power(nm - 1.0) - 2.0 * power(nm) + power(nm + 1.0)).abs();
        for (i, cmf) in request.observer.at(nm).into_iter().enumerate() {
            bends[i] += bend * cmf;
            sums[i] += power(nm) * cmf;
        }
    }
    bends.iter().zip(sums).any(|(bend, sum)| *bend > SPIKES * sum)
}

/// A medium of the user's that stops inside the visible has no extension: say what can be done.
fn within_data(error: OpticsError) -> OpticsError {
    match error {
        OpticsError::OutsideData(message) => OpticsError::OutsideData(format!(
            "{message} (a colour sum runs over 360..830 nm unless wavelength_nm= gives a grid within the data)"
        )),
        other => other,
    }
}

/// The stack at one angle, with what its points share.
struct AtAngle<'a> {
    of: &'a StackColor,
    angle_deg: f64,
    incidence: Incidence,
    watch: &'a Watch,
    /// max over the wavelengths of 2 Re(n cos theta) step / lambda^2, a layer; before any halving.
    fringe_per_nm: Vec<f64>,
}

/// The colour of one point.
struct Found {
    point: usize,
    value: [f64; 3],
    outside: bool,
    forced: Forced,
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
    fn new(of: &'a StackColor, angle_deg: f64, watch: &'a Watch) -> Result<AtAngle<'a>, OpticsError> {
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
    fn colors(&self, points: &[usize], thickness_nm: &[f64], found: &mut Vec<Found>) -> Result<(), OpticsError> {
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
    fn xyz(&self, level: &Level, thickness_nm: &[f64], out: &mut [[f64; 3]]) -> Result<(), OpticsError> {
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
    fn sweep<'b>(&'b self, level: &'b Level, thickness_nm: &'b [f64], points: usize) -> Result<Sweep<'b>, OpticsError> {
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

/// Of each distinct medium max over the wavelengths of 2 Re(n cos theta) step / lambda^2; `index` tells that of the first medium
/// (`None`) or of a distinct one.
fn fringes(
    wavelength_nm: impl Iterator<Item = (usize, f64)>,
    media: usize,
    incidence: &Incidence,
    step_nm: f64,
    index: impl Fn(Option<usize>, usize) -> Complex64,
) -> Vec<f64> {
    let mut fringe_of = vec![0.0_f64; media];
    for (i, nm) in wavelength_nm {
        let n_first = index(None, i).re;
        for (medium, fringe) in fringe_of.iter_mut().enumerate() {
            let path = sqrt_upper(incidence.kz_squared(n_first, index(Some(medium), i))).re.abs();
            *fringe = fringe.max(2.0 * path * step_nm / (nm * nm));
        }
    }
    fringe_of
}

/// Into how many parts (a power of two) the sum of a stack's colour divides its 1 nm steps at some points, so that every
/// fringe has its steps: the rule of [`StackColor`], for sums of other things over the same spectra. `thickness_nm` holds
/// one row of layers a point.
pub fn fringe_parts(
    media: &[Medium],
    coherent: &[bool],
    thickness_nm: &[f64],
    angle_deg: &[f64],
) -> Result<Vec<usize>, OpticsError> {
    let layers = coherent.len();
    if media.len() != layers + 2 || thickness_nm.len() != layers * angle_deg.len() {
        return Err(OpticsError::Argument("media, thicknesses and angles do not belong together".into()));
    }
    let (distinct, of) = distinct(media);
    let grid: Vec<f64> = (FIRST_NM as u32..=LAST_NM as u32).map(f64::from).collect();
    let table = |&place: &usize| grid.iter().map(|&nm| media[place].index_extended(nm).map(|(n, _)| n)).collect();
    let tables: Vec<Vec<Complex64>> = distinct.iter().map(table).collect::<Result<_, _>>()?;
    let mut known: Option<(f64, Vec<f64>)> = None;
    let mut parts = Vec::with_capacity(angle_deg.len());
    for (point, &angle) in angle_deg.iter().enumerate() {
        let fringe_of = match known.take() {
            Some((at, fringe_of)) if at == angle => fringe_of,
            _ => {
                let incidence = Incidence::from_degrees(angle)?;
                let index = |medium: Option<usize>, i: usize| tables[medium.unwrap_or(of[0])][i];
                fringes(grid.iter().copied().enumerate(), distinct.len(), &incidence, 1.0, index)
            }
        };
        let row = thickness_nm[point * layers..][..layers].iter().zip(coherent).zip(&of[1..]);
        let fringe: f64 = row.map(|((t, &coherent), &medium)| if coherent { fringe_of[medium] * t } else { 0.0 }).sum();
        let halvings = (0..HALVINGS).find(|&h| fringe <= FRINGE_STEPS * (1_usize << h) as f64);
        parts.push(1 << halvings.unwrap_or(HALVINGS));
        known = Some((angle, fringe_of));
    }
    Ok(parts)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::gamut::Mapping;
    use crate::color::{Illuminant, Observer, Quantity};
    use crate::stack::Solver;
    use crate::{Medium, Polarization};

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

    /// The sum of a film's spectrum, wavelength by wavelength through the solver.
    fn by_solver(made: &StackColor, level: &Level, deg: f64, t: f64) -> [f64; 3] {
        let (mut solver, mut scratch) = (Solver::new(), Vec::new());
        let request = &made.request;
        let one = |(i, &nm): (usize, &f64)| {
            let n = [0, 1, 2].map(|medium| made.index(level, medium, i));
            solver.prepare(&n, &[t], &request.coherent, nm, Incidence::from_degrees(deg).unwrap());
            match request.quantity {
                Quantity::Reflectance => solver.powers(request.polarization).unwrap().reflectance,
                Quantity::Transmittance => solver.powers(request.polarization).unwrap().transmittance,
                Quantity::Absorptance => solver.absorptance(request.polarization, &mut scratch).unwrap(),
            }
        };
        let values: Vec<f64> = level.weights.wavelength_nm.iter().enumerate().map(one).collect();
        level.columns.each_ref().map(|w| dot(w, &values))
    }

    #[test]
    fn vectors_are_the_general_solver() {
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
                        let watch = Watch::new();
                        let at = AtAngle::new(&made, deg, &watch).unwrap();
                        let level = made.level(0).unwrap();
                        assert!(at.sweep(level, &[t], 1).unwrap().is_vectorised());
                        let mut fast = [[0.0; 3]];
                        at.xyz(level, &[t], &mut fast).unwrap();
                        let [fast] = fast;
                        close(fast, by_solver(&made, level, deg, t), 2e-14);
                    }
                }
            }
        }
    }

    /// By the general solver, through a layer of no thickness in front.
    fn with_general_solver(n: [Complex64; 3], t: f64, deg: f64) -> [f64; 3] {
        let made = StackColor::new(request(&[n[0], n[0], n[1], n[2]], &[true, true])).unwrap();
        made.colors(&[0.0, t], &[deg]).unwrap().values[0]
    }

    #[test]
    fn gain_and_light_along_the_film_take_the_general_solver() {
        for (n, t, deg) in [
            ([1.0.into(), Complex64::new(1.5, -0.004), 1.3.into()], 600.0, 20.0),
            // n sin(theta) = 0.75: within rounding of the critical angle of the film, where kz is 1e-8 or 0
            ([1.5.into(), 0.75.into(), 1.5.into()], 300.0, 30.0),
            ([1.5.into(), 0.75.into(), 1.5.into()], 300.0, 29.999),
        ] {
            let made = StackColor::new(request(&n, &[true])).unwrap();
            let value = made.colors(&[t], &[deg]).unwrap().values[0];
            assert!(value.iter().all(|v| v.is_finite()), "{value:?}");
            close(value, with_general_solver(n, t, deg), 1e-13);
        }
    }

    #[test]
    fn incoherent_slabs_need_no_refinement() {
        let made = StackColor::new(request(&real(&[1.0, 1.5, 1.0]), &[false])).unwrap();
        let colors = made.colors(&[1e9], &[0.0]).unwrap();
        close(colors.values[0], made.level(0).unwrap().weights.white.map(|w| 0.08 / 1.04 * w), 1e-14);
        assert!(made.levels[1..].iter().all(|level| level.get().is_none()));
    }

    #[test]
    fn thick_films_are_refined_to_their_mean() {
        // Fringes far finer than 1 nm average out: R of the incoherent slab, 2 r0 / (1 + r0).
        let made = StackColor::new(request(&real(&[1.0, 1.5, 1.0]), &[true])).unwrap();
        let colors = made.colors(&[0.5e6], &[0.0]).unwrap();
        close(colors.values[0], made.level(0).unwrap().weights.white.map(|w| 0.08 / 1.04 * w), 2e-5);
        assert_eq!(colors.forced, Forced::default());
        // The steps of the rule, and half of them to see that they are enough.
        let used: Vec<usize> = (0..=HALVINGS).filter(|h| made.levels[*h].get().is_some()).collect();
        assert_eq!(used, [0, 6, 7]);
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
        assert!(given.forced.steps > 0.0 && given.forced.steps < FRINGE_STEPS);
        let coarse =
            ColorRequest { grid: Some(Grid { first_nm: 380.0, step_nm: 10.0, count: 41 }), ..request(&n, &[true]) };
        let coarse = StackColor::new(coarse).unwrap().colors(&[30_000.0], &[10.0]).unwrap();
        assert!(coarse.forced.steps > 4.0);
    }

    #[test]
    fn overtones_are_seen() {
        // At 80 degrees glass reflects so much that a fringe of 4 steps is not resolved by them.
        let n = real(&[1.0, 1.77, 1.0]);
        let asked =
            ColorRequest { illuminant: Illuminant::named("FL12").unwrap(), space: Space::Lab, ..request(&n, &[true]) };
        let fine = ColorRequest { grid: Some(Grid::default().divided(64)), ..asked.clone() };
        let by_rule = ColorRequest { grid: Some(Grid::default().divided(2)), ..asked.clone() };
        let [own, fine, by_rule] =
            [asked, fine, by_rule].map(|asked| StackColor::new(asked).unwrap().colors(&[20_694.3], &[79.9]).unwrap());
        assert!(by_rule.forced.steps <= FRINGE_STEPS, "{:?}", by_rule.forced);
        assert!(ciede2000(by_rule.values[0], fine.values[0]) > 0.1, "{by_rule:?} {fine:?}");
        assert!(ciede2000(own.values[0], fine.values[0]) < AGREE, "{own:?} {fine:?}");
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
        assert!(made.colors(&[1e12], &[0.0]).is_ok());
        assert!(made.levels[1..].iter().all(|level| level.get().is_none()));
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

    /// Media that are alike are held once, however many layers are of them, and what cannot fit is refused.
    #[test]
    fn memory_goes_with_the_layers() {
        let mut n = vec![Complex64::from(1.0)];
        n.extend((0..10_000).map(|j| Complex64::from(if j % 2 == 0 { 1.3 } else { 1.4 })));
        n.push(Complex64::from(1.0));
        let made = StackColor::new(request(&n, &vec![true; 10_000])).unwrap();
        let level = made.level(HALVINGS).unwrap();
        assert_eq!(level.tables.iter().map(Vec::len).collect::<Vec<_>>(), [1, 1, 1]);
        // A grid of one wavelength: the sum itself, without its refinements.
        let grid = Some(Grid { first_nm: 550.0, step_nm: 1.0, count: 2 });
        let coarse = StackColor::new(ColorRequest { grid, ..request(&n, &vec![true; 10_000]) }).unwrap();
        let y = coarse.colors(&vec![10.0; 10_000], &[0.0]).unwrap().values[0][1];
        assert!((0.0..=1.0).contains(&y), "{y}");

        let media = (0..400_u32).map(|j| {
            let row = |i: u32| (i as usize + 1, 300.0 + 300.0 * f64::from(i), 1.3 + 0.001 * f64::from(i + j), 0.0);
            Medium::from_rows(&[row(0), row(1), row(2)], false, "own", "").unwrap()
        });
        let mut asked = request(&n[..402], &[true; 400]);
        asked.media.splice(1..401, media);
        let made = StackColor::new(asked).unwrap();
        assert!(made.level(0).is_ok());
        let error = made.level(HALVINGS).unwrap_err();
        assert!(matches!(error, OpticsError::Resource(_)) && error.to_string().contains("400"), "{error}");
    }

    #[test]
    fn a_stopped_sum_ends() {
        let made = StackColor::new(request(&real(&[1.0, 1.33, 1.0]), &[true])).unwrap();
        let watch = Watch::new();
        watch.stop();
        assert_eq!(made.colors_watched(&[300.0], &[0.0], &watch), Err(OpticsError::Stopped));
    }
}
