//! PNG: whole numbers of 8 or 16 bits. What a file says of gamma and colour does not matter: the numbers count.

use std::io::Cursor;

use super::{Plane, Samples, grey};
use crate::limits::check_size;

/// Most memory for the decoder.
const MAX_BYTES: usize = 4 << 30;

pub fn read(bytes: &[u8]) -> Result<Plane, String> {
    let damaged = |e: png::DecodingError| format!("damaged or unsupported PNG ({e})");
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: MAX_BYTES });
    // 1, 2 and 4 bits become 8, palettes become colours.
    decoder.set_transformations(png::Transformations::EXPAND);
    // The header first: a damaged size must not reserve memory.
    let header = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = (header.width as usize, header.height as usize);
    check_size(width, height, 4)?;
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = reader.output_buffer_size().ok_or("it has too many pixels")?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(damaged)?;
    let data = &data[..frame.buffer_size()];
    let samples: Vec<f64> = match frame.bit_depth {
        png::BitDepth::Sixteen => data
            .chunks_exact(2)
            .map(|pair| f64::from(u16::from_be_bytes([pair[0], pair[1]])) / f64::from(u16::MAX))
            .collect(),
        _ => data.iter().map(|&byte| f64::from(byte) / f64::from(u8::MAX)).collect(),
    };
    Ok(Plane { width, height, samples: Samples::Shares(grey(&samples, frame.color_type.samples())?) })
}
