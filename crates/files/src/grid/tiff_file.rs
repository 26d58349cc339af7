//! TIFF: floats of 32 or 64 bits in nm, or whole numbers of 8 or 16 bits; the first page of a file counts.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{PhotometricInterpretation, Tag};

use super::{Plane, Samples};
use crate::limits::check_size;

/// Most memory for the pixels.
const MAX_BYTES: usize = 4 << 30;

pub fn read(bytes: &[u8]) -> Result<Plane, String> {
    let damaged = |e: tiff::TiffError| format!("damaged or unsupported TIFF ({e})");
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_BYTES;
    limits.intermediate_buffer_size = MAX_BYTES;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(damaged)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(damaged)?;
    let (width, height) = (width as usize, height as usize);
    check_size(width, height, 1)?;
    let color = decoder.colortype().map_err(damaged)?;
    if !matches!(color, tiff::ColorType::Gray(_)) {
        return Err(format!("its pixels are {color:?}; save it in grey, one number a pixel"));
    }
    let photometric = decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(damaged)?;
    if photometric == Some(PhotometricInterpretation::WhiteIsZero.to_u16()) {
        return Err("its numbers grow from white to black (WhiteIsZero); save it without inversion".into());
    }
    let samples = match decoder.read_image().map_err(damaged)? {
        DecodingResult::F32(values) => Samples::Nanometres(values.into_iter().map(f64::from).collect()),
        DecodingResult::F64(values) => Samples::Nanometres(values),
        DecodingResult::U8(values) if color == tiff::ColorType::Gray(8) => {
            Samples::Shares(values.into_iter().map(|v| f64::from(v) / f64::from(u8::MAX)).collect())
        }
        DecodingResult::U16(values) if color == tiff::ColorType::Gray(16) => {
            Samples::Shares(values.into_iter().map(|v| f64::from(v) / f64::from(u16::MAX)).collect())
        }
        _ => {
            return Err("its numbers must be floats of 32 or 64 bits (nm) or whole numbers, >= 0, of 8 or 16 bits \
                        (a range)"
                .into());
        }
    };
    let (Samples::Nanometres(values) | Samples::Shares(values)) = &samples;
    if values.len() != width * height {
        return Err(format!("damaged TIFF: {} numbers for {width} x {height} pixels", values.len()));
    }
    Ok(Plane { width, height, samples })
}
