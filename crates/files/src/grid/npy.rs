//! NumPy's NPY files, versions 1 to 3 (numpy.lib.format): a header that is a Python dict, then the plain numbers.

use exr::prelude::f16;

use super::plane::{MapChoice, Plane, Samples, no_page};
use crate::limits::check_size;
use crate::report::ReadReport;
use crate::words::{harmless, quoted};

/// Longest header: a plain two-dimensional array needs a hundred bytes.
const MAX_HEADER: usize = 65_536;

pub fn read(bytes: &[u8], choice: &MapChoice<'_>, report: &mut ReadReport) -> Result<Plane, String> {
    no_page(choice, "NPY")?;
    if let Some(channel) = choice.channel {
        return Err(format!("channel must be left out: an NPY file has one, got {}", quoted(channel)));
    }
    let damaged = || "damaged NPY: it ends inside its header".to_owned();
    let major = *bytes.get(6).ok_or_else(damaged)?;
    let (start, length) = match (major, bytes) {
        (1, [_, _, _, _, _, _, _, _, a, b, ..]) => (10, usize::from(u16::from_le_bytes([*a, *b]))),
        (2 | 3, [_, _, _, _, _, _, _, _, a, b, c, d, ..]) => (12, u32::from_le_bytes([*a, *b, *c, *d]) as usize),
        (1..=3, _) => return Err(damaged()),
        _ => return Err(format!("NPY of version {major}; 1, 2 and 3 are read")),
    };
    if length > MAX_HEADER {
        return Err(format!("damaged NPY: a header of {length} bytes"));
    }
    let header = bytes.get(start..start + length).ok_or_else(damaged)?;
    let header = std::str::from_utf8(header).map_err(|_| "damaged NPY: its header is no text".to_owned())?;
    let [height, width] = shape(header)?;
    check_size(width, height, 1)?;
    let kind = text_of(header, "descr").ok_or("damaged NPY: no descr in its header")?;
    let (order, number) = kind.split_at_checked(1).unwrap_or(("", kind));
    let size = match number {
        "u1" => 1,
        "f2" | "u2" => 2,
        "f4" => 4,
        "f8" => 8,
        _ => 0,
    };
    if size == 0 || !matches!(order, "<" | ">" | "|") {
        return Err(format!(
            "its numbers are of type {}; float16, float32, float64 (nm), uint8 and uint16 (a range) are read",
            quoted(kind)
        ));
    }
    report.take("thickness", kind, "", "the only one");
    let data = &bytes[start + length..];
    let cells = width * height;
    if data.len() != cells * size {
        return Err(format!(
            "damaged NPY: {height} x {width} numbers of {size} bytes need {} bytes, {} follow the header",
            cells * size,
            data.len()
        ));
    }
    let mut values: Vec<f64> = data
        .chunks_exact(size)
        .map(|chunk| {
            let mut little = [0_u8; 8];
            little[..size].copy_from_slice(chunk);
            if order == ">" {
                little[..size].reverse();
            }
            let [a, b, c, d, ..] = little;
            match number {
                "u1" => f64::from(a) / f64::from(u8::MAX),
                "u2" => f64::from(u16::from_le_bytes([a, b])) / f64::from(u16::MAX),
                "f2" => f16::from_bits(u16::from_le_bytes([a, b])).to_f64(),
                "f4" => f64::from(f32::from_le_bytes([a, b, c, d])),
                _ => f64::from_le_bytes(little),
            }
        })
        .collect();
    if value_of(header, "fortran_order") == Some("True") {
        // Column after column.
        values = (0..cells).map(|i| values[(i % width) * height + i / width]).collect();
    }
    let samples = if number.starts_with('u') { Samples::Shares(values) } else { Samples::Nanometres(values) };
    Ok(Plane { width, height, samples })
}

/// What stands behind a key of the header's dict: `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }`.
fn after<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = header.split_once(&format!("'{key}'"))?;
    Some(rest.trim_start().strip_prefix(':')?.trim_start())
}

/// A word.
fn value_of<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    after(header, key)?.split([',', '}']).next().map(str::trim)
}

/// A text.
fn text_of<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let rest = after(header, key)?;
    // A structured array has a list here.
    Some(rest.strip_prefix('\'').and_then(|text| text.split('\'').next()).unwrap_or(rest))
}

/// Two lengths.
fn shape(header: &str) -> Result<[usize; 2], String> {
    let text = after(header, "shape").and_then(|rest| rest.strip_prefix('(')).and_then(|rest| rest.split_once(')'));
    let (inside, _) = text.ok_or("damaged NPY: no shape in its header")?;
    let lengths: Option<Vec<usize>> =
        inside.split(',').map(str::trim).filter(|part| !part.is_empty()).map(|part| part.parse().ok()).collect();
    match lengths.as_deref() {
        Some(&[height, width]) => Ok([height, width]),
        _ => Err(format!("its shape is ({}); a map has two sides, (height, width)", harmless(inside.trim()))),
    }
}
