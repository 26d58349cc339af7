//! NumPy's NPY files, versions 1 to 3 (numpy.lib.format): a header that is a Python dict, then the plain numbers.

use exr::prelude::f16;
use iridesce_numerics::Watch;

use super::plane::{Plane, Samples, Sought, no_page};
use crate::input::gathered;
use crate::limits::check_size;
use crate::report::ReadReport;
use crate::words::{harmless, quoted};

/// Longest header: a plain two-dimensional array needs a hundred bytes.
const MAX_HEADER: usize = 65_536;
/// Most transforms of a file: their boxes then take some gigabytes.
const MAX_TRANSFORMS: usize = 1 << 24;

pub fn read(bytes: &[u8], sought: &Sought<'_>, watch: &Watch, report: &mut ReadReport) -> Result<Plane, String> {
    no_page(sought, "NPY")?;
    if let Some(channel) = sought.channel {
        return Err(format!("channel must be left out: an NPY file has one, got {}", quoted(channel)));
    }
    let (header, data) = parts(bytes)?;
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
            "its numbers are of type {}; float16, float32, float64{}, uint8 and uint16 (a range) are read",
            quoted(kind),
            sought.of.in_unit()
        ));
    }
    report.take(sought.of.name(), kind, "", "the only one");
    let cells = width * height;
    if data.len() != cells * size {
        return Err(format!(
            "damaged NPY: {height} x {width} numbers of {size} bytes need {} bytes, {} follow the header",
            cells * size,
            data.len()
        ));
    }
    let value = |chunk: &[u8]| {
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
    };
    let mut values = gathered(data.chunks_exact(size).map(value), watch)?;
    if value_of(header, "fortran_order") == Some("True") {
        // Column after column.
        values = gathered((0..cells).map(|i| values[(i % width) * height + i / width]), watch)?;
    }
    let samples = if number.starts_with('u') { Samples::Shares(values) } else { Samples::Values(values) };
    Ok(Plane { width, height, samples })
}

/// The header's text, and what follows it.
fn parts(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
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
    Ok((header, &bytes[start + length..]))
}

/// Transforms from a file: an array n x 3 x 4 of floats, three rows of four for each.
pub fn decode_transforms(bytes: &[u8]) -> Result<Vec<[[f64; 4]; 3]>, String> {
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err("it is no NPY file".to_owned());
    }
    let (header, data) = parts(bytes)?;
    let lengths = lengths(header)?;
    let [count, 3, 4] = lengths[..] else {
        return Err(format!("its shape is {lengths:?}; transforms have the shape (n, 3, 4)"));
    };
    let kind = text_of(header, "descr").ok_or("damaged NPY: no descr in its header")?;
    let size = match kind {
        "<f4" | ">f4" => 4,
        "<f8" | ">f8" => 8,
        _ => return Err(format!("its numbers are of type {}; float32 and float64 are read", quoted(kind))),
    };
    if count == 0 {
        return Err("it holds no transform".to_owned());
    }
    if count > MAX_TRANSFORMS {
        return Err(format!("it holds {count} transforms; at most {MAX_TRANSFORMS} are read"));
    }
    if data.len() != count * 12 * size {
        return Err(format!(
            "damaged NPY: {count} transforms of 12 numbers need {} bytes, {} follow the header",
            count * 12 * size,
            data.len()
        ));
    }
    let is_by_columns = value_of(header, "fortran_order") == Some("True");
    let value = |at: usize| {
        let mut chunk = [0_u8; 8];
        chunk[..size].copy_from_slice(&data[at * size..(at + 1) * size]);
        if kind.starts_with('>') {
            chunk[..size].reverse();
        }
        let [a, b, c, d, ..] = chunk;
        if size == 4 { f64::from(f32::from_le_bytes([a, b, c, d])) } else { f64::from_le_bytes(chunk) }
    };
    let mut all = Vec::with_capacity(count);
    for i in 0..count {
        let at = |row: usize, column: usize| match is_by_columns {
            true => i + count * (row + 3 * column),
            false => 12 * i + 4 * row + column,
        };
        let rows: [[f64; 4]; 3] = std::array::from_fn(|row| std::array::from_fn(|column| value(at(row, column))));
        if let Some(bad) = rows.iter().flatten().find(|v| !(v.is_finite() && v.abs() <= 1e9)) {
            return Err(format!("transform {i} holds {bad}; numbers are finite, at most 1e9 either way"));
        }
        all.push(rows);
    }
    Ok(all)
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
    match lengths(header)?[..] {
        [height, width] => Ok([height, width]),
        _ => Err(format!(
            "its shape is ({}); a map has two sides, (height, width)",
            harmless(shape_text(header)?.trim())
        )),
    }
}

/// What stands between the brackets of its shape.
fn shape_text(header: &str) -> Result<&str, String> {
    let text = after(header, "shape").and_then(|rest| rest.strip_prefix('(')).and_then(|rest| rest.split_once(')'));
    text.map(|(inside, _)| inside).ok_or_else(|| "damaged NPY: no shape in its header".to_owned())
}

/// Its lengths; none where one is no number.
fn lengths(header: &str) -> Result<Vec<usize>, String> {
    let inside = shape_text(header)?;
    let parts = inside.split(',').map(str::trim).filter(|part| !part.is_empty());
    Ok(parts.map(|part| part.parse().ok()).collect::<Option<_>>().unwrap_or_default())
}
