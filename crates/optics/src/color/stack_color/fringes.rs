//! How fine the steps of a colour sum must be: every fringe needs its steps, sharp ones and lamps with spikes more.

use std::collections::HashMap;

use crate::color::observer::{FIRST_NM, LAST_NM};
use crate::color::request::ColorRequest;
use crate::incidence::{Incidence, sqrt_upper};
use crate::{Complex64, Medium, OpticsError};

/// A fringe needs 4 steps of the sum or more: 2 n t cos(theta) step / lambda^2 <= 1/4.
pub const FRINGE_STEPS: f64 = 0.25;
/// Films with more than this share of a fringe a step are summed in half steps too, to see whether that changes the colour:
/// where layers reflect strongly (metals, grazing light) fringes have overtones, which need finer steps than fringes do.
pub const CHECKED_ABOVE: f64 = 1.0 / 16.0;
/// The same under a lamp whose spectrum has spikes, where 1 nm steps lose something on every fringe that is not broad, and
/// where light grazes the first face (beyond 75 degrees), so that fringes are sharp.
pub const CHECKED_ABOVE_SHARP: f64 = 1.0 / 64.0;
pub const GRAZING_DEG: f64 = 75.0;
/// Bends of a lamp's 1 nm table, sum |S'' cmf| / sum S cmf, above which it has spikes: 0.0004 to 0.006 for daylights, lamps
/// that glow and LEDs, 0.012 to 0.07 for discharge lamps.
const SPIKES: f64 = 0.01;
/// Sums that differ by less than this (CIEDE2000) are fine enough; the error of the coarser is about the difference, since
/// that of the finer falls with a power of it.
pub const AGREE: f64 = 0.01;
/// The grid is halved this often at most, to 1/4096 nm: enough for 5 cm of glass.
pub const HALVINGS: usize = 12;

/// Media that differ from all before them, by their places, and which of these each one is: a mirror of thousands of
/// layers has two.
pub fn distinct(media: &[Medium]) -> (Vec<usize>, Vec<usize>) {
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
pub fn has_spikes(request: &ColorRequest) -> bool {
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

/// Of each distinct medium max over the wavelengths of 2 Re(n cos theta) step / lambda^2; `index` tells that of the first medium
/// (`None`) or of a distinct one.
pub fn fringes(
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
/// fringe has its steps: the rule of [`crate::color::StackColor`], for sums of other things over the same spectra. `thickness_nm` holds
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
pub fn halvings_for(fringe: f64, thickness_nm: &[f64]) -> Result<usize, OpticsError> {
    (0..=HALVINGS).find(|&h| fringe <= FRINGE_STEPS * (1usize << h) as f64).ok_or_else(|| {
        OpticsError::Argument(format!(
            "layers of {thickness_nm:?} nm are too thick for a coherent colour sum (finest step 1/{} nm); \
             mark thick layers coherent=False or give wavelength_nm=",
            1 << HALVINGS
        ))
    })
}
