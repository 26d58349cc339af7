//! A request made ready: weights, and the indices of all media at every wavelength of each refinement.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use super::fringes::{HALVINGS, distinct, has_spikes};
use crate::color::observer::{FIRST_NM, LAST_NM};
use crate::color::request::ColorRequest;
use crate::color::sums::{Grid, Weights};
use crate::{Complex64, OpticsError};

/// Indices of a refinement that are kept: 1 GiB of them.
const MOST_INDICES: usize = 1 << 26;

/// A request with its sums; those that are not needed are never made.
#[derive(Debug)]
pub struct Levels {
    /// What is asked for.
    pub request: ColorRequest,
    /// Whether the lamp has spikes.
    pub has_spikes: bool,
    /// Places in the stack of media that differ from all before, and which of these each medium is.
    pub distinct: Vec<usize>,
    pub of: Vec<usize>,
    /// One for each halving of the steps.
    pub levels: [OnceLock<Result<Level, OpticsError>>; HALVINGS + 1],
}

/// One refinement of the sum.
#[derive(Debug)]
pub struct Level {
    /// Of each wavelength.
    pub weights: Weights,
    /// X, Y, Z weights one after the other, for long plain loops.
    pub columns: [Vec<f64>; 3],
    /// Of each distinct medium its index at every wavelength, or the one that holds at all of them.
    pub tables: Vec<Vec<Complex64>>,
    /// Media whose stated extension was used.
    pub extended: BTreeSet<String>,
}

impl Levels {
    /// Checks the request and reads all indices at the wavelengths of the sum.
    pub fn new(request: ColorRequest) -> Result<Levels, OpticsError> {
        request.check()?;
        let has_spikes = has_spikes(&request);
        let (distinct, of) = distinct(&request.media);
        let levels = [const { OnceLock::new() }; HALVINGS + 1];
        let made = Levels { request, has_spikes, distinct, of, levels };
        made.level(0)?;
        Ok(made)
    }

    /// Names of the media whose stated extension beyond their data was used.
    pub fn extended(&self) -> Vec<String> {
        let levels = self.levels.iter().filter_map(|level| level.get()?.as_ref().ok());
        let names: BTreeSet<&String> = levels.flat_map(|level| &level.extended).collect();
        names.into_iter().cloned().collect()
    }

    /// The grid of the coarsest sum.
    pub fn grid(&self) -> Grid {
        self.request.grid.unwrap_or_default()
    }

    /// One refinement, made when it is first asked for.
    pub fn level(&self, halvings: usize) -> Result<&Level, OpticsError> {
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
    pub fn index(&self, level: &Level, medium: usize, wavelength: usize) -> Complex64 {
        let table = &level.tables[self.of[medium]];
        if table.len() == 1 { table[0] } else { table[wavelength] }
    }
}

/// Indices of 16 bytes as GiB.
fn gib(indices: usize) -> f64 {
    indices as f64 * 16.0 / f64::from(1 << 30)
}

/// A medium of the user's that stops inside the visible has no extension: say what can be done.
fn within_data(error: OpticsError) -> OpticsError {
    match error {
        OpticsError::OutsideData(message) => OpticsError::OutsideData(format!(
            "{message} (a colour sum runs over {FIRST_NM}..{LAST_NM} nm unless wavelength_nm= gives a grid within the data)"
        )),
        other => other,
    }
}
