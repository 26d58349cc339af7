//! Radiance HDR in: pixels with a shared exponent, run-length coded in two ways, and a header whose lines are part of the values.
//!
//! Source: G. Ward, "Real Pixels", Graphics Gems II, 80 (1991), and Radiance's "Picture File Format" (filefmts). EXPOSURE and
//! COLORCORR may stand several times and multiply; the numbers of the file are the radiance times them.

use iridesce_numerics::Watch;

use crate::limits::{check_size, room};
use crate::report::ReadReport;
use crate::words::quoted;

/// Longest header.
const MAX_HEADER: usize = 65_536;
/// Scan lines of these lengths may be coded plane by plane.
const NEW_LENGTHS: std::ops::RangeInclusive<usize> = 8..=32_767;
/// Primaries and white of Rec.709 as Radiance writes them, and how far apart still means the same.
const REC709: [f64; 8] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
const SLACK: f64 = 2e-3;

/// A decoded picture, row 0 on top, three floats a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct HdrPicture {
    pub width: usize,
    pub height: usize,
    pub rgb: Vec<f32>,
}

/// Which way the scan lines run.
struct Layout {
    /// Number and length of the scan lines.
    lines: usize,
    length: usize,
    /// Scan lines are columns.
    is_transposed: bool,
    flips_x: bool,
    flips_y: bool,
}

/// The picture in the bytes of a file; what its header does to the values goes into the report.
pub fn read(bytes: &[u8], watch: &Watch, report: &mut ReadReport) -> Result<HdrPicture, String> {
    let (layout, scale, body) = header(bytes, report)?;
    let Layout { lines, length, .. } = layout;
    let (width, height) = if layout.is_transposed { (lines, length) } else { (length, lines) };
    check_size(width, height, 3)?;
    // The shortest scan line: a pixel, and a run whose length takes a code for each 8 bits.
    let codes = (1..8).find(|&digits| length >> (8 * digits) == 0).unwrap_or(8);
    let least = lines.saturating_mul(if length < 2 { 4 } else { 4 + 4 * codes });
    if body.len() < least {
        return Err(format!(
            "damaged Radiance HDR: {width} x {height} pixels need {least} bytes at least, {} follow the header",
            body.len()
        ));
    }
    room(16 * (width as u64) * (height as u64))?;
    let mut rgb = vec![0.0_f32; 3 * width * height];
    let mut rest = body;
    let mut line: Vec<[u8; 4]> = vec![[0; 4]; length];
    for number in 0..lines {
        watch.check().map_err(|stopped| stopped.to_string())?;
        rest = scan_line(rest, &mut line)
            .ok_or_else(|| format!("damaged Radiance HDR: scan line {number} of {lines} is not whole"))?;
        for (place, texel) in line.iter().enumerate() {
            let (x, y) = if layout.is_transposed { (number, place) } else { (place, number) };
            let x = if layout.flips_x { width - 1 - x } else { x };
            let y = if layout.flips_y { height - 1 - y } else { y };
            let at = 3 * (y * width + x);
            rgb[at..at + 3].copy_from_slice(&float(*texel, scale));
        }
    }
    Ok(HdrPicture { width, height, rgb })
}

/// `mantissa * 2^(exponent - 136)`, divided by what the header says the radiance was multiplied by.
fn float([r, g, b, exponent]: [u8; 4], scale: Option<[f64; 3]>) -> [f32; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    let unit = f32::exp2(f32::from(exponent) - 136.0);
    let rgb = [r, g, b].map(|mantissa| f32::from(mantissa) * unit);
    match scale {
        None => rgb,
        Some(scale) => std::array::from_fn(|i| (f64::from(rgb[i]) / scale[i]) as f32),
    }
}

/// The layout, what the values are divided by, and what follows the header.
type Header<'a> = (Layout, Option<[f64; 3]>, &'a [u8]);

fn header<'a>(bytes: &'a [u8], report: &mut ReadReport) -> Result<Header<'a>, String> {
    let mut scale = [1.0_f64; 3];
    let mut at = 0;
    let next = |at: &mut usize| -> Result<&'a [u8], String> {
        let rest = &bytes[*at..bytes.len().min(MAX_HEADER)];
        let end = rest
            .iter()
            .position(|&byte| byte == b'\n')
            .ok_or_else(|| "damaged Radiance HDR: its header does not end".to_owned())?;
        *at += end + 1;
        Ok(&rest[..end])
    };
    loop {
        let line = next(&mut at)?;
        if line.is_empty() || line == b"\r" {
            break;
        }
        if let Some((name, value)) = String::from_utf8_lossy(line).split_once('=') {
            variable(&name.trim().to_uppercase(), value.trim(), &mut scale, report)?;
        }
    }
    if scale.iter().any(|value| *value <= 0.0 || !value.is_finite()) {
        return Err(format!("damaged Radiance HDR: its exposures multiply to {scale:?}"));
    }
    let layout = layout(&String::from_utf8_lossy(next(&mut at)?), report)?;
    let is_scaled = scale != [1.0; 3];
    Ok((layout, is_scaled.then_some(scale), &bytes[at..]))
}

/// One line `NAME=value` of a header: what it divides the values by, or why they cannot be read.
fn variable(name: &str, value: &str, scale: &mut [f64; 3], report: &mut ReadReport) -> Result<(), String> {
    let number = |word: &str| -> Result<f64, String> {
        let number = word.parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
        number.ok_or_else(|| format!("damaged Radiance HDR: {name} must be a number > 0, got {}", quoted(word)))
    };
    match name {
        "FORMAT" => match value {
            "32-bit_rle_rgbe" => {}
            "32-bit_rle_xyze" => {
                return Err("its pixels are XYZ (FORMAT=32-bit_rle_xyze); convert it to 32-bit_rle_rgbe".into());
            }
            other => return Err(format!("Radiance HDR of FORMAT={}; 32-bit_rle_rgbe is read", quoted(other))),
        },
        "EXPOSURE" => {
            let exposure = number(value)?;
            *scale = scale.map(|value| value * exposure);
            report.note(format!("EXPOSURE={exposure}: the values are divided by it"));
        }
        "COLORCORR" => {
            let words: Vec<&str> = value.split_whitespace().collect();
            let [r, g, b] = words[..] else {
                return Err(format!("damaged Radiance HDR: COLORCORR needs three numbers, got {}", quoted(value)));
            };
            for (scale, word) in scale.iter_mut().zip([r, g, b]) {
                *scale *= number(word)?;
            }
            report.note(format!("COLORCORR={value}: the values are divided by it"));
        }
        "PIXASPECT" if (number(value)? - 1.0).abs() > SLACK => {
            return Err(format!("its pixels are not square (PIXASPECT={})", quoted(value)));
        }
        "GAMMA" if (number(value)? - 1.0).abs() > SLACK => {
            return Err(format!("its values are not linear (GAMMA={})", quoted(value)));
        }
        "PRIMARIES" => {
            let numbers: Vec<f64> = value.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            if numbers.len() != 8 || numbers.iter().zip(REC709).any(|(a, b)| (a - b).abs() > SLACK) {
                return Err(format!(
                    "its colours have other primaries and white (PRIMARIES={}) than Rec.709; convert it to linear Rec.709",
                    quoted(value)
                ));
            }
        }
        _ => {}
    }
    Ok(())
}

/// The line of the size, `-Y 512 +X 1024`: how many scan lines of what length, and which way they run.
fn layout(line: &str, report: &mut ReadReport) -> Result<Layout, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let wrong =
        || format!("damaged Radiance HDR: its size must be like \"-Y 512 +X 1024\", it is {}", quoted(line.trim()));
    let [first, count, second, length] = words[..] else { return Err(wrong()) };
    let (lines, length) = (count.parse().map_err(|_| wrong())?, length.parse().map_err(|_| wrong())?);
    let layout = match (first, second) {
        ("-Y" | "+Y", "-X" | "+X") => {
            Layout { lines, length, is_transposed: false, flips_x: second == "-X", flips_y: first == "+Y" }
        }
        ("-X" | "+X", "-Y" | "+Y") => {
            Layout { lines, length, is_transposed: true, flips_x: first == "-X", flips_y: second == "+Y" }
        }
        _ => return Err(wrong()),
    };
    if (first, second) != ("-Y", "+X") {
        report.note(format!("its scan lines run {first} {second}; the picture is turned upright"));
    }
    Ok(layout)
}

/// Decodes one scan line; what follows it, or nothing where the bytes do not make one.
fn scan_line<'a>(bytes: &'a [u8], line: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let length = line.len();
    match *bytes {
        [2, 2, high, low, ..] if high < 128 && NEW_LENGTHS.contains(&length) => {
            if usize::from(u16::from_be_bytes([high, low])) != length {
                return None;
            }
            planes(&bytes[4..], line)
        }
        _ => flat(bytes, line),
    }
}

/// Four planes of runs: a count above 128 repeats the next byte, one below copies what follows.
fn planes<'a>(mut bytes: &'a [u8], line: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    for plane in 0..4 {
        let mut place = 0;
        while place < line.len() {
            let (&code, rest) = bytes.split_first()?;
            let count = usize::from(if code > 128 { code - 128 } else { code });
            let run = line.get_mut(place..place.checked_add(count)?).filter(|run| !run.is_empty())?;
            if code > 128 {
                let (&value, rest) = rest.split_first()?;
                run.iter_mut().for_each(|texel| texel[plane] = value);
                bytes = rest;
            } else {
                let (values, rest) = rest.split_at_checked(count)?;
                run.iter_mut().zip(values).for_each(|(texel, value)| texel[plane] = *value);
                bytes = rest;
            }
            place += count;
        }
    }
    Some(bytes)
}

/// Plain pixels; (1, 1, 1, n) repeats the one before n times, and further such codes count in higher bytes.
fn flat<'a>(mut bytes: &'a [u8], line: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let (mut place, mut shift) = (0, 0);
    while place < line.len() {
        let (texel, rest) = bytes.split_first_chunk::<4>()?;
        bytes = rest;
        if texel[..3] == [1, 1, 1] {
            let count = usize::from(texel[3]).checked_shl(shift).filter(|count| *count <= line.len())?;
            let value = *line[..place].last()?;
            line.get_mut(place..place + count)?.fill(value);
            place += count;
            shift += 8;
            if shift > 24 {
                return None;
            }
        } else {
            line[place] = *texel;
            place += 1;
            shift = 0;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 x 2 pixels, flat: red 1, 2 / 3, 4.
    fn file(header: &str, size: &str) -> Vec<u8> {
        let texels: Vec<u8> = [128, 64, 0, 129, 128, 0, 0, 130, 192, 0, 0, 130, 128, 0, 0, 131].into();
        [format!("#?RADIANCE\n{header}\n{size}\n").as_bytes(), &texels].concat()
    }

    fn reds(header: &str, size: &str) -> Vec<f32> {
        let picture = read(&file(header, size), &Watch::new(), &mut ReadReport::default()).unwrap();
        picture.rgb.chunks_exact(3).map(|rgb| rgb[0]).collect()
    }

    fn refused(header: &str, size: &str, words: &str) {
        let error = read(&file(header, size), &Watch::new(), &mut ReadReport::default()).unwrap_err();
        assert!(error.contains(words), "{error}");
    }

    #[test]
    fn header_lines_are_part_of_the_values() {
        assert_eq!(reds("FORMAT=32-bit_rle_rgbe\n", "-Y 2 +X 2"), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(reds("EXPOSURE=2\nEXPOSURE= 0.25\n", "-Y 2 +X 2"), [2.0, 4.0, 6.0, 8.0]);
        assert_eq!(reds("COLORCORR=4 1 1\nEXPOSURE=0.5\n", "-Y 2 +X 2"), [0.5, 1.0, 1.5, 2.0]);
        assert_eq!(reds("PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\nPIXASPECT=1\n", "-Y 2 +X 2")[0], 1.0);
        for (header, words) in [
            ("FORMAT=32-bit_rle_xyze\n", "its pixels are XYZ"),
            ("FORMAT=\x1b[31mred\n", "FORMAT=\"\\u{1b}[31mred\""),
            ("PRIMARIES=0.64 0.33 0.29 0.6 0.15 0.06 0.333 0.333\n", "other primaries and white"),
            ("PIXASPECT=2\n", "not square"),
            ("GAMMA=2.2\n", "not linear"),
            ("EXPOSURE=0\n", "EXPOSURE must be a number > 0"),
            ("EXPOSURE=1e300\nEXPOSURE=1e300\n", "multiply to"),
            ("COLORCORR=1 2\n", "three numbers"),
        ] {
            refused(header, "-Y 2 +X 2", words);
        }
    }

    #[test]
    fn scan_lines_may_run_any_way() {
        for (size, expected) in [
            ("-Y 2 +X 2", [1.0, 2.0, 3.0, 4.0]),
            ("-Y 2 -X 2", [2.0, 1.0, 4.0, 3.0]),
            ("+Y 2 +X 2", [3.0, 4.0, 1.0, 2.0]),
            ("+Y 2 -X 2", [4.0, 3.0, 2.0, 1.0]),
            ("+X 2 -Y 2", [1.0, 3.0, 2.0, 4.0]),
            ("-X 2 +Y 2", [4.0, 2.0, 3.0, 1.0]),
        ] {
            assert_eq!(reds("", size), expected, "{size}");
        }
        refused("", "-Y 2 +Y 2", "its size must be like");
        refused("", "-Y two +X 2", "its size must be like");
    }

    #[test]
    fn a_size_without_bytes_is_refused_before_memory_is_taken() {
        refused("", "-Y 8192 +X 16384", "8192 pixels need 98304 bytes at least, 16 follow");
        refused("", "-Y 1000000 +X 1000000", "1000000 x 1000000 pixels");
        refused("", "-Y 0 +X 2", "no pixels");
        assert!(read(b"#?RADIANCE\nno end", &Watch::new(), &mut ReadReport::default()).is_err());
    }

    #[test]
    fn runs_of_both_kinds() {
        // Ten equal pixels: plane by plane, and as one pixel and a run of nine.
        let new = [&[2, 2, 0, 10][..], &[138, 128], &[138, 64], &[10], &[7; 10], &[138, 129]].concat();
        let old = [&[128, 64, 7, 129][..], &[1, 1, 1, 9]].concat();
        for body in [new, old] {
            let file = [&b"#?RADIANCE\n\n-Y 1 +X 10\n"[..], &body].concat();
            let picture = read(&file, &Watch::new(), &mut ReadReport::default()).unwrap();
            assert_eq!(picture.rgb, [1.0, 0.5, 0.0546875].repeat(10));
            assert!(read(&file[..file.len() - 1], &Watch::new(), &mut ReadReport::default()).is_err());
        }
        let watch = Watch::new();
        watch.stop();
        assert_eq!(read(&file("", "-Y 2 +X 2"), &watch, &mut ReadReport::default()).unwrap_err(), "stopped");
    }
}
