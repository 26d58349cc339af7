//! Photographs: what a camera wrote, as linear light in Rec.709, with the pixels that were clipped.
//!
//! PNG and JPEG are decoded by their ICC profile where it is one of primaries and curves, else as sRGB; TIFF of 16 bits,
//! OpenEXR, Radiance HDR and NPY are linear as they stand. Orientation is obeyed everywhere.

mod jpeg;
mod size;

use std::panic::{AssertUnwindSafe, catch_unwind};

use iridesce_numerics::Watch;
use tiff::decoder::DecodingResult;

use crate::environment;
use crate::grid::{MapChoice, png_file, tiff_file};
use crate::icc_in::{Profile, Transfer};
use crate::input::gathered;
use crate::limits::room;
use crate::orient::upright;
use crate::report::ReadReport;

pub use size::photograph_size;

/// Largest file of a photograph, bytes.
pub const MAX_PHOTOGRAPH_BYTES: u64 = 4 << 30;
/// Pixels at the greatest number of a file, as a share, from which on that number is where the sensor ends.
const PLATEAU: f64 = 1e-4;
/// Pixels between two looks at the watch.
const PIECE: usize = 1 << 18;

/// A photograph as linear light.
#[derive(Debug, Clone, PartialEq)]
pub struct Photograph {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear Rec.709, three floats a pixel, row 0 on top; negative where the file's space is wider.
    pub rgb: Vec<f32>,
    /// Pixels of which a number stood at the end of its range: their light is at least what `rgb` says.
    pub clipped: Vec<bool>,
    /// How the file was understood.
    pub report: ReadReport,
}

/// Numbers as they were stored, before any curve.
struct Stored {
    width: usize,
    height: usize,
    /// 1 to 4: grey, grey and alpha, colours, colours and alpha.
    channels: usize,
    values: Vec<f32>,
    transfer: Transfer,
    /// Numbers from here on are clipped.
    most: f32,
}

/// The photograph in the bytes of a file. `choice` names a page of a TIFF, or a layer of an OpenEXR file as its channel.
pub fn read_photograph(bytes: &[u8], choice: &MapChoice<'_>, watch: &Watch) -> Result<Photograph, String> {
    let mut report = ReadReport::default();
    let read = || match bytes {
        [0x89, b'P', b'N', b'G', ..] => from_png(bytes, watch, &mut report),
        [0xFF, 0xD8, 0xFF, ..] => from_jpeg(bytes, watch, &mut report),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => from_tiff(bytes, choice, watch, &mut report),
        [0x76, 0x2F, 0x31, 0x01, ..] | [b'#', b'?', ..] => {
            let map = environment::picture(bytes, choice.channel, watch, &mut report)?;
            report.note("the numbers are taken as linear light");
            let most = f32::INFINITY;
            let transfer = Transfer::linear();
            Ok(Stored { width: map.width, height: map.height, channels: 3, values: map.rgb, transfer, most })
        }
        [_, _, _, _, b'f', b't', b'y', b'p', b'h' | b'm' | b'a', ..] => {
            Err("it is HEIC or AVIF; convert it to a linear 16-bit TIFF, or to PNG".into())
        }
        [b'F', b'U', b'J', b'I', ..] | [b'I', b'I', b'R', ..] | [b'I', b'I', b'U', ..] => {
            Err("it is a camera's RAW file; convert it to a linear 16-bit TIFF (dcraw -4 -T, or a raw developer)"
                .into())
        }
        [] => Err("it is empty".to_owned()),
        _ => Err("it is no PNG, JPEG, TIFF, OpenEXR or Radiance HDR file".to_owned()),
    };
    // A file made to trip a decoder must not take the program with it.
    let stored = catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("it is damaged".to_owned()))?;
    develop(&stored, watch, report)
}

/// Curve and primaries undone, clipped pixels remembered.
fn develop(stored: &Stored, watch: &Watch, mut report: ReadReport) -> Result<Photograph, String> {
    let Stored { width, height, channels, ref values, ref transfer, most } = *stored;
    if values.len() != width * height * channels {
        return Err(format!("damaged picture: {} numbers for {width} x {height} pixels", values.len()));
    }
    room(20 * (width * height) as u64)?;
    let mut rgb = Vec::with_capacity(3 * width * height);
    let mut clipped = Vec::with_capacity(width * height);
    let colours = if channels >= 3 { 3 } else { 1 };
    for piece in values.chunks(PIECE * channels) {
        watch.check().map_err(|stopped| stopped.to_string())?;
        for pixel in piece.chunks_exact(channels) {
            if let Some(bad) = pixel.iter().find(|value| !value.is_finite()) {
                let at = clipped.len();
                return Err(format!(
                    "it holds {bad} at row {}, column {}; light must be finite",
                    at / width,
                    at % width
                ));
            }
            clipped.push(pixel[..colours].iter().any(|&value| value >= most));
            let own = if colours == 3 { [pixel[0], pixel[1], pixel[2]] } else { [pixel[0]; 3] };
            rgb.extend(transfer.rec709(own));
        }
    }
    let count = clipped.iter().filter(|clipped| **clipped).count();
    if count > 0 {
        report.note(format!("{count} of {} pixels are clipped", width * height));
    }
    if matches!(channels, 2 | 4) {
        report.drop("the channel A");
    }
    Ok(Photograph { width, height, rgb, clipped, report })
}

fn transfer_of(icc: Option<&[u8]>, report: &mut ReadReport) -> Result<Transfer, String> {
    match icc {
        None => {
            report.note("no colour profile: taken as sRGB");
            Ok(Transfer::srgb())
        }
        Some(bytes) => {
            let profile = Profile::read(bytes)?;
            report.note(format!("converted by its colour profile, {}", crate::words::quoted(&profile.name)));
            Ok(profile.transfer)
        }
    }
}

fn from_png(bytes: &[u8], watch: &Watch, report: &mut ReadReport) -> Result<Stored, String> {
    let picture = png_file::picture(bytes, watch)?;
    report.format = format!("PNG of {} bits", picture.bits);
    let names = if picture.channels >= 3 { "R, G, B" } else { "grey" };
    report.take("light", names, "", "the only ones");
    let transfer = transfer_of(picture.icc.as_deref(), report)?;
    let png_file::PngPicture { width, height, channels, shares: values, .. } = picture;
    Ok(Stored { width, height, channels, values, transfer, most: 1.0 })
}

fn from_jpeg(bytes: &[u8], watch: &Watch, report: &mut ReadReport) -> Result<Stored, String> {
    let jpeg::Jpeg { width, height, pixels, icc, exif } = jpeg::decoded(bytes, watch)?;
    report.format = "JPEG".into();
    report.take("light", "R, G, B", "", "the only ones");
    let transfer = transfer_of(icc.as_deref(), report)?;
    let orientation = exif.as_deref().and_then(exif_orientation).unwrap_or(1);
    if orientation != 1 {
        report.note(format!("orientation {orientation}: the picture is turned upright"));
    }
    let (width, height, pixels) = upright(orientation, width, height, 3, pixels, watch)?;
    let mut values = Vec::with_capacity(pixels.len());
    for piece in pixels.chunks(PIECE) {
        watch.check().map_err(|stopped| stopped.to_string())?;
        values.extend(piece.iter().map(|&byte| f32::from(byte) / 255.0));
    }
    Ok(Stored { width, height, channels: 3, values, transfer, most: 1.0 })
}

fn from_tiff(bytes: &[u8], choice: &MapChoice<'_>, watch: &Watch, report: &mut ReadReport) -> Result<Stored, String> {
    report.format = "TIFF".into();
    let page = tiff_file::page(bytes, choice.page, watch, report)?;
    let tiff_file::Page { width, height, channels, values, icc, .. } = page;
    let (values, most, is_coded): (Vec<f32>, f32, bool) = match values {
        DecodingResult::U8(values) => (gathered(values.into_iter().map(|v| f32::from(v) / 255.0), watch)?, 1.0, true),
        DecodingResult::U16(values) => {
            let most = plateau(&values);
            if let Some(level) = most.filter(|level| *level < u16::MAX) {
                report.note(format!("its greatest number {level} is a plateau: the sensor ends there, not at 65535"));
            }
            let most = f32::from(most.unwrap_or(u16::MAX)) / 65_535.0;
            (gathered(values.into_iter().map(|v| f32::from(v) / 65_535.0), watch)?, most, false)
        }
        DecodingResult::F16(values) => (gathered(values.into_iter().map(|v| v.to_f32()), watch)?, f32::INFINITY, false),
        DecodingResult::F32(values) => (values, f32::INFINITY, false),
        DecodingResult::F64(values) => (gathered(values.into_iter().map(|v| v as f32), watch)?, f32::INFINITY, false),
        _ => return Err("its numbers must be floats, or whole numbers >= 0 of 8 or 16 bits".into()),
    };
    let names = if channels >= 3 { "R, G, B" } else { "grey" };
    report.take("light", names, "", "the only ones");
    let transfer = match icc {
        None if !is_coded => {
            report.note("no colour profile: 16 bits and floats are taken as linear Rec.709");
            Transfer::linear()
        }
        icc => transfer_of(icc.as_deref(), report)?,
    };
    Ok(Stored { width, height, channels, values, transfer, most })
}

/// The greatest number, where so many pixels stand at it that it is the end of the sensor's range: data of 12 bits in words of 16.
fn plateau(values: &[u16]) -> Option<u16> {
    let top = values.iter().copied().max()?;
    let count = values.iter().filter(|value| **value == top).count();
    let enough = (PLATEAU * values.len() as f64).max(16.0);
    (top == u16::MAX || (count as f64 >= enough && count < values.len())).then_some(top)
}

/// The orientation in EXIF data, which is a TIFF without pixels.
fn exif_orientation(exif: &[u8]) -> Option<u16> {
    let is_big = match exif.get(..4)? {
        [b'M', b'M', 0, 42] => true,
        [b'I', b'I', 42, 0] => false,
        _ => return None,
    };
    let short = |at: usize| -> Option<u16> {
        let bytes = exif.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if is_big { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    };
    let long = |at: usize| -> Option<usize> {
        let bytes = exif.get(at..at.checked_add(4)?)?.try_into().ok()?;
        usize::try_from(if is_big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }).ok()
    };
    let directory = long(4)?;
    let count = usize::from(short(directory)?);
    (0..count)
        .map(|entry| directory + 2 + 12 * entry)
        .find(|&at| short(at) == Some(274))
        .and_then(|at| short(at + 8))
        .filter(|orientation| (1..=8).contains(orientation))
}

#[cfg(test)]
mod tests;
