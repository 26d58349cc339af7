//! Thickness maps from files: OpenEXR, TIFF, PNG and NumPy's NPY, told apart by content.
//!
//! Files of floats hold nm. Files of whole numbers hold shares of a range that the scene states: 0 is `min_nm`, the largest
//! number of the format `max_nm`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use iridesce_numerics::{Stopped, THICKNESS_NM, Watch};
use iridesce_thickness::{ThicknessError, ThicknessMap};

use crate::error::FileError;
use crate::input::gathered;
use crate::limits::check_size;
use crate::report::ReadReport;
use crate::whole::read_whole_watched;

mod exr_file;
mod npy;
mod plane;
pub mod png_file;
pub mod tiff_file;

pub use exr_file::thickness_exr;
pub use npy::decode_transforms;
pub use plane::{MapChoice, MapOf};
use plane::{Samples, Sought};

/// Largest file of a map: the largest map in double precision, and then some.
pub const MAX_GRID_BYTES: u64 = 4 << 30;

/// Medians of maps in nm: from a monolayer's tenth to a millimetre.
const PLAUSIBLE_NM: std::ops::Range<f64> = 0.1..1e6;

/// What a file holds: nm, or shares of a range.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    values: Arc<ThicknessMap>,
    is_share: bool,
    /// How the file was understood.
    pub report: ReadReport,
}

/// The map in a file; `min_nm` and `max_nm` are needed where it holds whole numbers, and refused where it holds floats.
/// A file that holds no map is a [`FileError::Argument`] that says why, to be read after the name of the file.
pub fn read_thickness_map(
    path: &Path,
    min_nm: Option<f64>,
    max_nm: Option<f64>,
    choice: &MapChoice<'_>,
    watch: &Watch,
) -> Result<(Arc<ThicknessMap>, ReadReport), FileError> {
    let grid = read_whole_watched(path, MAX_GRID_BYTES, watch)
        .and_then(|bytes| decode(&bytes, choice, watch))
        .map_err(|why| FileError::Argument(format!("cannot be used as a thickness map: {why}")))?;
    Ok((grid.in_range_watched(min_nm, max_nm, watch)?, grid.report))
}

/// The thickness map in a file's bytes. A watch that stops the work ends it with an error whose words do not matter.
pub fn decode(bytes: &[u8], choice: &MapChoice<'_>, watch: &Watch) -> Result<Grid, String> {
    decode_of(MapOf::Thickness, bytes, choice, watch)
}

/// The same for a map of something else: channels are sought by its name, and faults told in its words.
pub fn decode_of(of: MapOf, bytes: &[u8], choice: &MapChoice<'_>, watch: &Watch) -> Result<Grid, String> {
    let sought = Sought { of, channel: choice.channel, page: choice.page };
    let mut report = ReadReport::default();
    let format = match bytes {
        [0x76, 0x2F, 0x31, 0x01, ..] => "OpenEXR",
        [0x89, b'P', b'N', b'G', ..] => "PNG",
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => "TIFF",
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => "NPY",
        [] => return Err("it is empty".to_owned()),
        _ => return Err("it is no OpenEXR, TIFF, PNG or NPY file".to_owned()),
    };
    format.clone_into(&mut report.format);
    let read = || match format {
        "OpenEXR" => exr_file::read(bytes, &sought, watch, &mut report),
        "PNG" => png_file::read(bytes, &sought, watch, &mut report),
        "TIFF" => tiff_file::read(bytes, &sought, watch, &mut report),
        _ => npy::read(bytes, &sought, watch, &mut report),
    };
    // A file made to trip a decoder must not take the program with it.
    let plane = catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("it is damaged".to_owned()))?;
    let (values, is_share) = match plane.samples {
        Samples::Values(values) => (values, false),
        Samples::Shares(values) => (values, true),
    };
    check_size(plane.width, plane.height, 1)?;
    let stopped = |stopped: Stopped| stopped.to_string();
    watch.check().map_err(stopped)?;
    if let Some(at) = values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        let (row, column) = (at / plane.width, at % plane.width);
        return Err(format!(
            "it holds {} at row {row}, column {column}; every value must be {}",
            values[at],
            of.rule()
        ));
    }
    if of != MapOf::Thickness {
        // Numbers as they stand: nothing was guessed.
    } else if is_share {
        report.note("whole numbers: 0 means min_nm, the largest of the format max_nm");
    } else {
        let mut some: Vec<f64> = values.iter().copied().step_by((values.len() / 4096).max(1)).collect();
        some.sort_by(f64::total_cmp);
        let middle = some[some.len() / 2];
        if middle > 0.0 && !PLAUSIBLE_NM.contains(&middle) {
            report.note(format!("half of the values lie around {middle:.3e} nm: is the map in m or um?"));
        }
    }
    watch.check().map_err(stopped)?;
    let values = ThicknessMap::new(plane.width, plane.height, values).map_err(|e| e.to_string())?;
    Ok(Grid { values: Arc::new(values), is_share, report })
}

/// The grid in the bytes of a file that holds one map, without a watch.
pub fn decode_thickness(bytes: &[u8]) -> Result<Grid, String> {
    decode(bytes, &MapChoice::default(), &Watch::new())
}

impl Grid {
    /// What it takes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.thickness_nm())
    }

    /// Its values as they are: shares of 1 of whole numbers, and floats.
    pub fn shares(&self) -> Arc<ThicknessMap> {
        self.values.clone()
    }

    /// Its thicknesses; the error names the key at fault.
    pub fn in_range(&self, min_nm: Option<f64>, max_nm: Option<f64>) -> Result<Arc<ThicknessMap>, ThicknessError> {
        self.in_range_watched(min_nm, max_nm, &Watch::new())
    }

    /// The same under a watch; the words of the error that ends work which was stopped do not matter.
    pub fn in_range_watched(
        &self,
        min_nm: Option<f64>,
        max_nm: Option<f64>,
        watch: &Watch,
    ) -> Result<Arc<ThicknessMap>, ThicknessError> {
        if !self.is_share {
            let given = [("min_nm", min_nm), ("max_nm", max_nm)].into_iter().find_map(|(key, nm)| Some((key, nm?)));
            let Some((key, nm)) = given else { return Ok(self.values.clone()) };
            let allowed = "left out: the map holds floats, which are nm already";
            return Err(ThicknessError::new(key, allowed, format!("{nm:?}")));
        }
        let (Some(min_nm), Some(max_nm)) = (min_nm, max_nm) else {
            let key = if min_nm.is_none() { "min_nm" } else { "max_nm" };
            let allowed = "given: the map holds whole numbers, of which 0 means min_nm and the largest max_nm";
            return Err(ThicknessError::new(key, allowed, "none"));
        };
        for (key, value) in [("min_nm", min_nm), ("max_nm", max_nm)] {
            THICKNESS_NM.named(key).check(value)?;
        }
        if max_nm < min_nm {
            let allowed = format!("at least min_nm = {min_nm:?}");
            return Err(ThicknessError::new("max_nm", allowed, format!("{max_nm:?}")));
        }
        let shares = self.values.thickness_nm().iter();
        let nm = gathered(shares.map(|share| min_nm * (1.0 - share) + max_nm * share), watch);
        let nm = nm.map_err(|stopped| ThicknessError::new("map", "left to be read whole", stopped))?;
        ThicknessMap::new(self.values.width(), self.values.height(), nm).map(Arc::new)
    }
}

#[cfg(test)]
mod tests;
