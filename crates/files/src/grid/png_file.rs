//! PNG: whole numbers of 8 or 16 bits. What a file says of gamma and colour does not matter: the numbers count.

use iridesce_numerics::Watch;

use super::plane::{Plane, Samples, Sought, no_page, one_of};
use crate::input::{Input, gathered};
use crate::limits::{check_ratio, check_size, room};
use crate::report::ReadReport;
use crate::words::harmless;

/// Most memory for the decoder besides the pixels: texts and profiles are left where they are.
const MAX_BYTES: usize = 64 << 20;
/// Most bytes that deflate makes of one (RFC 1951: 258 for two bits, and the codes in front of them).
const DEFLATE_RATIO: u64 = 1032;

/// A decoded picture: shares of the largest number, channel after channel of each pixel.
pub struct PngPicture {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub bits: u8,
    pub shares: Vec<f32>,
    pub icc: Option<Vec<u8>>,
}

pub fn read(bytes: &[u8], sought: &Sought<'_>, watch: &Watch, report: &mut ReadReport) -> Result<Plane, String> {
    no_page(sought, "PNG")?;
    let (frame, data, _) = decode(bytes, false, watch)?;
    let samples: Vec<f64> = match frame.bit_depth {
        png::BitDepth::Sixteen => gathered(
            data.as_chunks::<2>().0.iter().map(|&pair| f64::from(u16::from_be_bytes(pair)) / f64::from(u16::MAX)),
            watch,
        )?,
        _ => gathered(data.iter().map(|&byte| f64::from(byte) / f64::from(u8::MAX)), watch)?,
    };
    let names: &[&str] = match frame.color_type.samples() {
        1 => &["grey"],
        2 => &["grey", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let shares = one_of(samples, names, sought, watch, report)?;
    Ok(Plane { width: frame.width as usize, height: frame.height as usize, samples: Samples::Shares(shares) })
}

/// The frame's facts, its bytes, and the ICC profile if that was asked for.
type Decoded = (png::OutputInfo, Vec<u8>, Option<Vec<u8>>);

fn decode(bytes: &[u8], with_profile: bool, watch: &Watch) -> Result<Decoded, String> {
    let damaged = |e: png::DecodingError| format!("damaged or unsupported PNG ({})", harmless(&e.to_string()));
    let limits = png::Limits { bytes: MAX_BYTES };
    let mut decoder = png::Decoder::new_with_limits(Input::new(bytes, watch), limits);
    // 1, 2 and 4 bits become 8, palettes become colours.
    decoder.set_transformations(png::Transformations::EXPAND);
    // A text or a profile of 600 kB inflates to 340 MiB.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(!with_profile);
    // The header first: a damaged size must not reserve memory.
    let header = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = (header.width as usize, header.height as usize);
    check_size(width, height, 4)?;
    let bits = u64::from(header.bit_depth as u8) * header.color_type.samples() as u64;
    check_ratio((width as u64 * height as u64 * bits) / 8, bytes.len() as u64, DEFLATE_RATIO, "PNG")?;
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = reader.output_buffer_size().ok_or("it has too many pixels")?;
    // The bytes, and the shares that they become.
    room(size as u64 * 9)?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(damaged)?;
    data.truncate(frame.buffer_size());
    let icc = reader.info().icc_profile.as_ref().map(|profile| profile.to_vec());
    Ok((frame, data, icc))
}

/// The whole picture with its profile.
pub fn picture(bytes: &[u8], watch: &Watch) -> Result<PngPicture, String> {
    let (frame, data, icc) = decode(bytes, true, watch)?;
    let is_deep = frame.bit_depth == png::BitDepth::Sixteen;
    let shares: Vec<f32> = match is_deep {
        true => gathered(
            data.as_chunks::<2>().0.iter().map(|&pair| f32::from(u16::from_be_bytes(pair)) / f32::from(u16::MAX)),
            watch,
        )?,
        false => gathered(data.iter().map(|&byte| f32::from(byte) / f32::from(u8::MAX)), watch)?,
    };
    Ok(PngPicture {
        width: frame.width as usize,
        height: frame.height as usize,
        channels: frame.color_type.samples(),
        bits: if is_deep { 16 } else { 8 },
        shares,
        icc,
    })
}
