//! What a decoder hands over: numbers row after row, and which of a file's channels and pages they are.

use iridesce_numerics::Watch;

use crate::input::gathered;
use crate::report::ReadReport;
use crate::words::{listed, quoted};

/// Numbers as a decoder found them, row after row, row 0 on top.
pub struct Plane {
    pub width: usize,
    pub height: usize,
    pub samples: Samples,
}

pub enum Samples {
    /// What the map is of: thicknesses in nm, roughness and heights as they stand.
    Values(Vec<f64>),
    /// Whole numbers over the largest one of their format.
    Shares(Vec<f64>),
}

/// What a map is of: its channels are sought by that name, and its faults told in those words.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum MapOf {
    /// Floats are nm, whole numbers shares of a range.
    #[default]
    Thickness,
    /// A surface's roughness: numbers as they stand, 0 to 1.
    Roughness,
    /// Heights of bumps: numbers as they stand, 0 being flat.
    Height,
}

impl MapOf {
    /// Its name, in words and of channels.
    pub fn name(self) -> &'static str {
        match self {
            MapOf::Thickness => "thickness",
            MapOf::Roughness => "roughness",
            MapOf::Height => "height",
        }
    }

    /// A map of it, as messages call it.
    pub fn map(self) -> &'static str {
        match self {
            MapOf::Thickness => "a thickness map",
            MapOf::Roughness => "a roughness map",
            MapOf::Height => "a bump map",
        }
    }

    /// What its floats are, where they have a unit.
    pub(super) fn unit(self) -> &'static str {
        match self {
            MapOf::Thickness => "nm",
            MapOf::Roughness | MapOf::Height => "",
        }
    }

    /// The unit in brackets, after a word.
    pub(super) fn in_unit(self) -> &'static str {
        match self {
            MapOf::Thickness => " (nm)",
            MapOf::Roughness | MapOf::Height => "",
        }
    }

    /// What is allowed of each number of it, besides being finite and >= 0.
    pub(super) fn rule(self) -> &'static str {
        match self {
            MapOf::Thickness => "a finite thickness in nm, >= 0",
            MapOf::Roughness => "a roughness from 0 to 1",
            MapOf::Height => "a finite height, >= 0",
        }
    }

    /// What to do with a picture in colour. Only where a thickness is asked for can a channel be named.
    fn instead_of_colour(self) -> &'static str {
        match self {
            MapOf::Thickness => {
                "name the channel (glTF keeps thickness in green: channel = \"G\"), or save it in grey, one number a pixel"
            }
            MapOf::Roughness => "save its roughness in grey, one number a pixel (glTF keeps it in green)",
            MapOf::Height => {
                "save heights in grey, one number a pixel (a normal map, whose colours are directions, is none)"
            }
        }
    }
}

/// Which part of a file is the map, where it holds several.
#[derive(Debug, Clone, Copy, Default)]
pub struct MapChoice<'a> {
    /// `part:layer.channel` of an OpenEXR file, `R`, `G`, `B` or `A` of a picture in colour.
    pub channel: Option<&'a str>,
    /// The page of a TIFF, the first being 1.
    pub page: Option<usize>,
}

/// What a reader is to find: a map of something, in one part of a file.
pub struct Sought<'a> {
    pub of: MapOf,
    pub channel: Option<&'a str>,
    pub page: Option<usize>,
}

/// One number a pixel: the channel that was named; or else the only one, transparency apart; or colours that are equal.
pub fn one_of(
    samples: Vec<f64>,
    names: &[&str],
    sought: &Sought<'_>,
    watch: &Watch,
    report: &mut ReadReport,
) -> Result<Vec<f64>, String> {
    let channels = names.len();
    let pixels = samples.chunks_exact(channels);
    let (place, why) = match sought.channel {
        Some(asked) => (
            names.iter().position(|name| name.eq_ignore_ascii_case(asked.trim())).ok_or_else(|| {
                format!("it has no channel {}; there are {}", quoted(asked), listed(names.iter().copied()))
            })?,
            "channel =",
        ),
        None if channels < 3 => (0, "the only one"),
        None if pixels.clone().all(|p| p[0] == p[1] && p[1] == p[2]) => (0, "its colours are equal"),
        None => {
            return Err(format!("it is a picture in colour; {}", sought.of.instead_of_colour()));
        }
    };
    report.take(sought.of.name(), names[place], "", why);
    if channels == 1 { Ok(samples) } else { gathered(pixels.map(|p| p[place]), watch) }
}

/// Only a TIFF has pages.
pub fn no_page(sought: &Sought<'_>, format: &str) -> Result<(), String> {
    match sought.page {
        None | Some(1) => Ok(()),
        Some(page) => Err(format!("page must be 1: a file of {format} has no other, got {page}")),
    }
}
