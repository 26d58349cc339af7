//! What can be told of the media of a stack before any wavelength and angle are met together.

use std::collections::HashMap;

use crate::Complex64;
use crate::incidence::Incidence;

/// Squared moduli of indices from 1e-3 to 1e3: beyond, the kernels' squares and ratios could leave their range.
const SQUARED_RANGE: (f64, f64) = (1e-6, 1e6);

/// The media, each different one once: a mirror of a hundred layers has two, and their wavenumbers are worked out once.
#[derive(Debug, Default)]
pub(super) struct Media<'a> {
    /// Index of each different medium at every wavelength, or a single one that holds at all of them.
    pub(super) tables: Vec<&'a [Complex64]>,
    /// Which of the tables each medium of the stack has, first to last.
    pub(super) of: Vec<usize>,
    /// Of each table whether it is lossless and lets light in at every row.
    pub(super) real: Vec<bool>,
    /// Of each table the thickest layer; less than nothing where it is of no layer and not the last medium.
    pub(super) thickest_nm: Vec<f64>,
    /// Of each table whether a layer is of it.
    pub(super) of_layer: Vec<bool>,
    /// Whether some layer absorbs at some wavelength.
    pub(super) absorbs: bool,
}

impl<'a> Media<'a> {
    /// `None` for indices that are not allowed or that the kernels do not cover.
    pub(super) fn look_at(indices: &[&'a [Complex64]], wavelengths: usize, angles: &[f64]) -> Option<Media<'a>> {
        if indices.iter().any(|table| table.len() != 1 && table.len() != wavelengths) {
            return None;
        }
        let mut tables: Vec<&'a [Complex64]> = Vec::new();
        let mut of = Vec::with_capacity(indices.len());
        // By where it stands, or by value where it is one: thousands of layers of their own are told apart at once.
        let mut known: HashMap<(usize, [u64; 2]), usize> = HashMap::new();
        for &table in indices {
            let key = match table {
                [n] => (0, [n.re.to_bits(), n.im.to_bits()]),
                _ => (table.as_ptr().addr(), [0; 2]),
            };
            of.push(*known.entry(key).or_insert_with(|| {
                tables.push(table);
                tables.len() - 1
            }));
        }
        let steepest = angles.iter().copied().fold(0.0, f64::max);
        let sine_squared = 1.0 - Incidence::from_degrees(steepest).ok()?.cos_theta().powi(2);
        let last = of.len() - 1;
        let mut of_layer = vec![false; tables.len()];
        of[1..last].iter().for_each(|&medium| of_layer[medium] = true);
        let (real, thickest_nm) = (vec![true; tables.len()], vec![-1.0; tables.len()]);
        let mut media = Media { real, thickest_nm, of_layer, absorbs: false, tables, of };
        media.thickest_nm[media.of[last]] = 0.0;
        let entry = |table: &[Complex64], place: usize| if table.len() == 1 { table[0] } else { table[place] };
        let first = media.tables[media.of[0]];
        for (medium, table) in media.tables.iter().enumerate() {
            let places = if first.len() == 1 { table.len() } else { wavelengths };
            for place in 0..places {
                let (n, n_first) = (entry(table, place), entry(first, place));
                let square = n.norm_sqr();
                if !(square >= SQUARED_RANGE.0 && square <= SQUARED_RANGE.1 && n.re >= 0.0 && n.im >= 0.0) {
                    return None;
                }
                // Light enters at every angle: kz^2 > 0.
                media.real[medium] &= n.im == 0.0 && n.re * n.re > n_first.re * n_first.re * sine_squared;
                media.absorbs |= n.re * n.im != 0.0 && media.of_layer[medium];
            }
        }
        if first.iter().any(|n| n.re == 0.0 || n.im != 0.0) {
            return None;
        }
        Some(media)
    }
}
