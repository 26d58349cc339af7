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
    /// Floats: nm.
    Nanometres(Vec<f64>),
    /// Whole numbers over the largest one of their format.
    Shares(Vec<f64>),
}

/// Which part of a file is the map, where it holds several.
#[derive(Debug, Clone, Copy, Default)]
pub struct MapChoice<'a> {
    /// `part:layer.channel` of an OpenEXR file, `R`, `G`, `B` or `A` of a picture in colour.
    pub channel: Option<&'a str>,
    /// The page of a TIFF, the first being 1.
    pub page: Option<usize>,
}

/// One number a pixel: the channel that was named; or else the only one, transparency apart; or colours that are equal.
pub fn one_of(
    samples: Vec<f64>,
    names: &[&str],
    choice: &MapChoice<'_>,
    watch: &Watch,
    report: &mut ReadReport,
) -> Result<Vec<f64>, String> {
    let channels = names.len();
    let pixels = samples.chunks_exact(channels);
    let (place, why) = match choice.channel {
        Some(asked) => (
            names.iter().position(|name| name.eq_ignore_ascii_case(asked.trim())).ok_or_else(|| {
                format!("it has no channel {}; there are {}", quoted(asked), listed(names.iter().copied()))
            })?,
            "channel =",
        ),
        None if channels < 3 => (0, "the only one"),
        None if pixels.clone().all(|p| p[0] == p[1] && p[1] == p[2]) => (0, "its colours are equal"),
        None => {
            return Err(
                "it is a picture in colour; name the channel (glTF keeps thickness in green: channel = \"G\"), or \
                        save it in grey, one number a pixel"
                    .into(),
            );
        }
    };
    report.take("thickness", names[place], "", why);
    if channels == 1 { Ok(samples) } else { gathered(pixels.map(|p| p[place]), watch) }
}

/// Only a TIFF has pages.
pub fn no_page(choice: &MapChoice<'_>, format: &str) -> Result<(), String> {
    match choice.page {
        None | Some(1) => Ok(()),
        Some(page) => Err(format!("page must be 1: a file of {format} has no other, got {page}")),
    }
}
