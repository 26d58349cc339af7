//! PNG out: 8 or 16 bits a channel, tagged with its colour space, carrying the facts of the render as text.

use std::borrow::Cow;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use png::{ColorType, DeflateCompression, Encoder, Info, chunk};
use rayon::prelude::*;

use crate::error::{FileError, Stop};
use crate::facts::{Fact, Facts};
use crate::icc;
use crate::limits::check_planes;
use crate::space::OutputSpace;
use crate::whole::write_whole;

/// Bits of one channel of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BitDepth {
    /// 256 steps: what everything reads.
    Eight,
    /// 65536 steps: what survives further editing.
    Sixteen,
}

/// What is spent on making a file small; its pixels are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// Small files.
    Small,
    /// A ninth of the time, files larger by a fifth: frames of footage, which are read once.
    Quick,
}

/// Longest side a PNG can state.
const MAX_SIDE: u32 = (1 << 31) - 1;

/// Writes encoded RGB in [0, 1], three floats a pixel, as a whole PNG file or none; or four, the last of them how opaque
/// the pixel is, by which the colours are not multiplied.
///
/// 16 bits are rounded to the nearest step, `round(65535 v)`. 8 bits are dithered, `round(255 v + t)` with a threshold
/// |t| < 1/2 that depends on the pixel's place alone: slow gradients show no bands, values that are steps already stay what
/// they are, grey stays grey, and the same picture gives the same bytes. sRGB is tagged by the `sRGB` chunk (with `gAMA` and `cHRM` for old
/// readers), Display P3 and Rec.2020 by `cICP` and, for readers that do not know it, an ICC profile.
/// Facts become text chunks (`tEXt` where Latin-1 will do, else `iTXt`).
#[allow(clippy::too_many_arguments)]
pub fn write_png(
    path: &Path,
    width: u32,
    height: u32,
    rgb: &[f32],
    bits: BitDepth,
    packing: Packing,
    space: OutputSpace,
    facts: &Facts,
    stop: Stop<'_>,
) -> Result<(), FileError> {
    let components = components(width, height, rgb)?;
    if width.max(height) > MAX_SIDE {
        return Err(FileError::Argument(format!("a PNG has at most {MAX_SIDE} pixels a side, got {width} x {height}")));
    }
    let bytes = quantize(rgb, width, components, bits);
    write_whole(path, stop, |out| {
        let mut buffered = BufWriter::new(out);
        let color = if components == 4 { ColorType::Rgba } else { ColorType::Rgb };
        encode(&mut buffered, [width, height], color, &bytes, (bits, packing), space, facts)?;
        buffered.flush()
    })
}

/// The same file in memory, 8 bits.
pub fn png_bytes(width: u32, height: u32, rgb: &[f32], space: OutputSpace) -> Result<Vec<u8>, FileError> {
    let components = components(width, height, rgb)?;
    let mut file = Vec::new();
    let bytes = quantize(rgb, width, components, BitDepth::Eight);
    let color = if components == 4 { ColorType::Rgba } else { ColorType::Rgb };
    encode(&mut file, [width, height], color, &bytes, (BitDepth::Eight, Packing::Small), space, &[])
        .map_err(|error| FileError::Argument(format!("no PNG of {width} x {height} pixels: {error}")))?;
    Ok(file)
}

/// Numbers a pixel has: three, or four.
fn components(width: u32, height: u32, rgb: &[f32]) -> Result<usize, FileError> {
    let is_four = rgb.len() as u128 == 4 * u128::from(width) * u128::from(height);
    let components = if is_four { 4 } else { 3 };
    check_planes(width, height, &[("rgb", rgb.len(), components)])?;
    Ok(components)
}

/// 2^32 / g and 2^32 / g^2, g^3 = g + 1: steps of the sequence R2, whose points spread most evenly over the plane (Roberts,
/// "The unreasonable effectiveness of quasirandom sequences", 2018).
const ACROSS: u32 = 3_242_174_889;
const DOWN: u32 = 2_447_445_414;
/// The widest threshold. Below half a step, so that the rounding of 255 v in f32 moves no value that is a step.
const WIDEST: f64 = 0.499;

/// What is added before rounding at a pixel, within a step: even over any patch of pixels, without a pattern.
fn threshold(x: u32, y: u32) -> f32 {
    let turn = f64::from(ACROSS.wrapping_mul(x).wrapping_add(DOWN.wrapping_mul(y))) / 4_294_967_296.0;
    ((2.0 * turn - 1.0) * WIDEST) as f32
}

/// Steps, big-endian. NaN becomes 0 (`as` saturates), so no input can make a wrong byte count.
fn quantize(rgb: &[f32], width: u32, components: usize, bits: BitDepth) -> Vec<u8> {
    match bits {
        BitDepth::Eight => {
            let mut bytes = vec![0; rgb.len()];
            let row = components * width as usize;
            bytes.par_chunks_mut(row).zip(rgb.par_chunks(row)).enumerate().for_each(|(y, (bytes, values))| {
                for (x, (pixel, values)) in bytes.chunks_mut(components).zip(values.chunks(components)).enumerate() {
                    let threshold = threshold(x as u32, y as u32);
                    for (component, (byte, v)) in pixel.iter_mut().zip(values).enumerate() {
                        // How opaque a pixel is, is no gradient to look at.
                        *byte = (v * 255.0 + if component < 3 { threshold } else { 0.0 }).round() as u8;
                    }
                }
            });
            bytes
        }
        BitDepth::Sixteen => {
            let mut bytes = vec![0; 2 * rgb.len()];
            bytes.par_chunks_exact_mut(2).zip(rgb).for_each(|(pair, v)| {
                // In f64: 65535 v in f32 would be rounded before it is rounded to the step.
                pair.copy_from_slice(&((f64::from(*v) * 65535.0).round() as u16).to_be_bytes());
            });
            bytes
        }
    }
}

fn encode(
    out: impl Write,
    [width, height]: [u32; 2],
    color: ColorType,
    bytes: &[u8],
    (bits, packing): (BitDepth, Packing),
    space: OutputSpace,
    facts: &Facts,
) -> io::Result<()> {
    let mut info = Info::with_size(width, height);
    info.color_type = color;
    info.bit_depth = match bits {
        BitDepth::Eight => png::BitDepth::Eight,
        BitDepth::Sixteen => png::BitDepth::Sixteen,
    };
    if space != OutputSpace::Srgb {
        info.icc_profile = Some(Cow::Owned(icc::profile(space)));
    }
    let mut encoder = Encoder::with_info(out, info)?;
    if packing == Packing::Quick {
        encoder.set_deflate_compression(DeflateCompression::Level(1));
    }
    if space == OutputSpace::Srgb {
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        encoder.set_source_gamma(png::ScaledFloat::from_scaled(45455));
        encoder.set_source_chromaticities(srgb_chromaticities());
    }
    for (keyword, fact) in facts {
        let text = fact.to_string();
        if matches!(fact, Fact::Text(_)) && !text.chars().all(|c| matches!(c, '\n' | ' '..='~' | '\u{a1}'..='\u{ff}')) {
            encoder.add_itxt_chunk(keyword.clone(), text)?;
        } else {
            encoder.add_text_chunk(keyword.clone(), text)?;
        }
    }
    let mut writer = encoder.write_header()?;
    if let Some(code_points) = space.code_points() {
        writer.write_chunk(chunk::cICP, &code_points)?;
    }
    // In pieces, so that a large picture can be stopped while it is compressed.
    let mut stream = writer.stream_writer_with_size(1 << 16)?;
    stream.write_all(bytes)?;
    stream.finish()?;
    writer.finish()?;
    Ok(())
}

/// The values the PNG specification prescribes beside an `sRGB` chunk (section 11.3.2.5), in units of 1/100000.
fn srgb_chromaticities() -> png::SourceChromaticities {
    let pair = |x, y| (png::ScaledFloat::from_scaled(x), png::ScaledFloat::from_scaled(y));
    png::SourceChromaticities {
        white: pair(31270, 32900),
        red: pair(64000, 33000),
        green: pair(30000, 60000),
        blue: pair(15000, 6000),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn save(space: OutputSpace, bits: BitDepth, rgb: &[f32], width: u32, facts: &Facts) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        write_png(&path, width, rgb.len() as u32 / 3 / width, rgb, bits, Packing::Small, space, facts, &|| false)
            .unwrap();
        fs::read(path).unwrap()
    }

    /// Chunk names and data, read by hand: an independent look at what is in the file.
    fn chunks(file: &[u8]) -> Vec<(String, Vec<u8>)> {
        let mut rest = file.strip_prefix(b"\x89PNG\r\n\x1a\n").unwrap();
        let mut found = Vec::new();
        while !rest.is_empty() {
            let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
            found.push((String::from_utf8(rest[4..8].to_vec()).unwrap(), rest[8..8 + length].to_vec()));
            rest = &rest[12 + length..];
        }
        found
    }

    fn chunk_of(file: &[u8], name: &str) -> Option<Vec<u8>> {
        chunks(file).into_iter().find(|c| c.0 == name).map(|c| c.1)
    }

    #[test]
    fn pixels_come_back_as_the_nearest_steps() {
        let rgb: Vec<f32> = (0..3 * 7 * 5).map(|i| (i as f32 / 104.0 * 255.0).round() / 255.0).collect();
        for (bits, steps) in [(BitDepth::Eight, 255.0), (BitDepth::Sixteen, 65535.0)] {
            let file = save(OutputSpace::Srgb, bits, &rgb, 7, &[]);
            let mut reader = png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            let frame = reader.next_frame(&mut bytes).unwrap();
            assert_eq!((frame.width, frame.height), (7, 5));
            let read: Vec<f64> = match bits {
                BitDepth::Eight => bytes.iter().map(|b| f64::from(*b)).collect(),
                BitDepth::Sixteen => bytes.chunks(2).map(|b| f64::from(u16::from_be_bytes([b[0], b[1]]))).collect(),
            };
            let wanted: Vec<f64> = rgb.iter().map(|v| (f64::from(*v) * steps).round()).collect();
            assert_eq!(read, wanted);
        }
    }

    #[test]
    fn every_space_is_tagged() {
        let srgb = save(OutputSpace::Srgb, BitDepth::Eight, &[0.5; 3], 1, &[]);
        assert_eq!(chunk_of(&srgb, "sRGB"), Some(vec![1]));
        assert_eq!(chunk_of(&srgb, "gAMA"), Some(45455_u32.to_be_bytes().to_vec()));
        assert_eq!(chunk_of(&srgb, "cHRM").unwrap()[..4], 31270_u32.to_be_bytes());
        assert!(chunk_of(&srgb, "iCCP").is_none() && chunk_of(&srgb, "cICP").is_none());
        // H.273: primaries 12 (P3-D65) with transfer 13 (sRGB); primaries 9 (BT.2020) with transfer 14 (BT.2020).
        for (space, code_points) in [(OutputSpace::DisplayP3, [12, 13, 0, 1]), (OutputSpace::Rec2020, [9, 14, 0, 1])] {
            let file = save(space, BitDepth::Sixteen, &[0.5; 3], 1, &[]);
            assert_eq!(chunk_of(&file, "cICP"), Some(code_points.to_vec()));
            let reader = png::Decoder::new(io::Cursor::new(&file)).read_info().unwrap();
            assert_eq!(reader.info().icc_profile.as_deref(), Some(&icc::profile(space)[..]));
            assert!(chunk_of(&file, "sRGB").is_none());
        }
    }

    #[test]
    fn facts_travel_as_text() {
        let facts = [
            ("Software".to_owned(), Fact::Text("iridesce 0".into())),
            ("samples".to_owned(), Fact::Integer(64)),
            ("exposure".to_owned(), Fact::Number(-0.25)),
            ("scene".to_owned(), Fact::Text("{\"name\": \"泡\"}".into())),
        ];
        let file = save(OutputSpace::Srgb, BitDepth::Eight, &[0.5; 3], 1, &facts);
        let reader = png::Decoder::new(io::Cursor::new(&file)).read_info().unwrap();
        let latin: Vec<_> =
            reader.info().uncompressed_latin1_text.iter().map(|t| (&t.keyword[..], &t.text[..])).collect();
        assert_eq!(latin, [("Software", "iridesce 0"), ("samples", "64"), ("exposure", "-0.25")]);
        let utf8 = &reader.info().utf8_text[0];
        assert_eq!((&utf8.keyword[..], utf8.get_text().unwrap()), ("scene", "{\"name\": \"泡\"}".into()));
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let rgb: Vec<f32> = (0..3 * 64 * 64).map(|i| (i as f32 * 0.37).sin().abs()).collect();
        let files: Vec<_> = (0..2).map(|_| save(OutputSpace::DisplayP3, BitDepth::Sixteen, &rgb, 64, &[])).collect();
        assert_eq!(files[0], files[1]);
    }

    #[test]
    fn eight_bits_are_dithered() {
        // Steps stay what they are, everywhere.
        let side = 64;
        for step in 0..=255_u8 {
            let flat = vec![f32::from(step) / 255.0; 3 * side * side];
            assert!(quantize(&flat, side as u32, 3, BitDepth::Eight).iter().all(|byte| *byte == step), "{step}");
        }
        // Between two steps every patch of 8 x 8 pixels has the right mean, in grey.
        for share in [0.1, 0.25, 0.5, 0.8] {
            let flat = vec![(100.0 + share) / 255.0; 3 * side * side];
            let bytes = quantize(&flat, side as u32, 3, BitDepth::Eight);
            assert!(bytes.chunks(3).all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2]));
            for (top, left) in [(0, 0), (8, 40), (33, 17), (56, 56)] {
                let patch = (0..64).map(|i| f64::from(bytes[3 * ((top + i / 8) * side + left + i % 8)]));
                let mean = patch.sum::<f64>() / 64.0 - 100.0;
                assert!((mean - f64::from(share)).abs() < 0.05, "{share}: {mean} at {top}, {left}");
            }
        }
    }

    #[test]
    fn a_fourth_number_is_how_opaque_a_pixel_is() {
        let rgba: Vec<f32> = (0..7 * 5).flat_map(|i| [0.2, 0.4, 0.6, i as f32 / 34.0]).collect();
        for bits in [BitDepth::Eight, BitDepth::Sixteen] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("x.png");
            write_png(&path, 7, 5, &rgba, bits, Packing::Small, OutputSpace::Srgb, &[], &|| false).unwrap();
            let mut reader = png::Decoder::new(io::Cursor::new(fs::read(path).unwrap())).read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            assert_eq!(reader.next_frame(&mut bytes).unwrap().color_type, ColorType::Rgba);
            let step = if bits == BitDepth::Eight { 1 } else { 2 };
            for (i, pixel) in bytes.chunks(4 * step).enumerate() {
                let high = [0, 1, 2, 3].map(|c| i32::from(pixel[c * step]));
                assert_eq!(high[..3], [51, 102, 153]);
                // (The upper byte of 65535 v is that of 255 v or the one below.)
                assert!((high[3] - (i as f64 / 34.0 * 255.0).round() as i32).abs() < step as i32, "{i}: {high:?}");
            }
        }
    }

    #[test]
    fn wrong_shapes_and_values_are_no_panic() {
        let path = Path::new("/nonexistent/x.png");
        let try_it = |width, height, len| {
            let rgb = vec![0.0; len];
            write_png(path, width, height, &rgb, BitDepth::Eight, Packing::Small, OutputSpace::Srgb, &[], &|| false)
                .unwrap_err()
        };
        assert!(try_it(2, 2, 11).to_string().contains("rgb must hold 12 values for 2 x 2 pixels, got 11"));
        assert!(try_it(0, 2, 0).to_string().contains("got 0 x 2"));
        assert!(try_it(u32::MAX, u32::MAX, 3).to_string().contains("got 3"));
        assert!(matches!(try_it(1, 1, 3), FileError::Write { .. }));
        assert_eq!(quantize(&[f32::NAN, f32::INFINITY, -2.0], 1, 3, BitDepth::Eight), [0, 255, 0]);
        assert_eq!(quantize(&[f32::NAN, 9.0, -2.0], 1, 3, BitDepth::Sixteen), [0, 0, 255, 255, 0, 0]);
    }
}
