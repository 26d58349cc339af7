//! JPEG: decoded by `zune-jpeg`, which does all of a picture in one call, in a way that can be stopped.
//!
//! Its reader refuses to go on once the watch says stop, which ends every pass over the file's bytes. What a progressive file
//! needs after its last byte (seconds where it has 2^27 pixels) asks nothing, so a large picture is
//! decoded aside.

use iridesce_numerics::Watch;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::{ZByteIoError, ZByteReaderTrait, ZCursor, ZSeekFrom};
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::aside::aside;
use crate::limits::{check_ratio, check_size, room};
use crate::words::harmless;

/// Most bytes of pixels out of one of a JPEG: an even picture has blocks of 6 bits for 64 pixels of three colours.
const RATIO: u64 = 512;
/// Pixels up to which a picture is decoded on the caller's own thread: some 50 ms.
const FEW_PIXELS: usize = 1 << 22;

/// A decoded picture.
pub(super) struct Jpeg {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue of each pixel, as stored.
    pub pixels: Vec<u8>,
    /// Its ICC profile.
    pub icc: Option<Vec<u8>>,
    /// Its EXIF data.
    pub exif: Option<Vec<u8>>,
}

/// The bytes of a file, until the watch says stop.
struct Watched<B> {
    bytes: ZCursor<B>,
    watch: Watch,
}

impl<B: AsRef<[u8]>> ZByteReaderTrait for Watched<B> {
    #[inline(always)]
    fn read_byte_no_error(&mut self) -> u8 {
        self.bytes.read_byte_no_error()
    }

    fn read_exact_bytes(&mut self, buffer: &mut [u8]) -> Result<(), ZByteIoError> {
        self.bytes.read_exact_bytes(buffer)
    }

    fn read_bytes(&mut self, buffer: &mut [u8]) -> Result<usize, ZByteIoError> {
        self.bytes.read_bytes(buffer)
    }

    fn peek_bytes(&mut self, buffer: &mut [u8]) -> Result<usize, ZByteIoError> {
        self.bytes.peek_bytes(buffer)
    }

    fn peek_exact_bytes(&mut self, buffer: &mut [u8]) -> Result<(), ZByteIoError> {
        self.bytes.peek_exact_bytes(buffer)
    }

    fn z_seek(&mut self, from: ZSeekFrom) -> Result<u64, ZByteIoError> {
        self.bytes.z_seek(from)
    }

    /// Asked once a byte of coded pixels, by what passes errors on.
    #[inline(always)]
    fn is_eof(&mut self) -> Result<bool, ZByteIoError> {
        if self.watch.is_stopped() {
            return Err(ZByteIoError::Generic("stopped"));
        }
        self.bytes.is_eof()
    }

    fn z_position(&mut self) -> Result<u64, ZByteIoError> {
        self.bytes.z_position()
    }

    fn read_remaining(&mut self, sink: &mut Vec<u8>) -> Result<usize, ZByteIoError> {
        self.bytes.read_remaining(sink)
    }
}

/// The picture in the bytes of a file.
pub(super) fn decoded(bytes: &[u8], watch: &Watch) -> Result<Jpeg, String> {
    let (width, height) = size(bytes, watch)?;
    let decoded = if width * height <= FEW_PIXELS {
        whole(bytes, watch.clone())
    } else {
        room(bytes.len() as u64)?;
        let (bytes, own) = (bytes.to_vec(), watch.clone());
        aside(watch, move || whole(&bytes[..], own)).map_err(|none| none.to_string())?
    };
    // Words of a decoder that was stopped are about a file that ends early.
    watch.check().map_err(|stopped| stopped.to_string())?;
    decoded
}

fn damaged(error: DecodeErrors) -> String {
    format!("damaged or unsupported JPEG ({})", harmless(&format!("{error:?}")))
}

fn decoder<B: AsRef<[u8]>>(bytes: B, watch: Watch) -> JpegDecoder<Watched<B>> {
    // (The decoder's own bound on each side is 16384.)
    let options = DecoderOptions::default()
        .set_max_width(65_535)
        .set_max_height(65_535)
        .set_strict_mode(true)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    JpegDecoder::new_with_options(Watched { bytes: ZCursor::new(bytes), watch }, options)
}

/// Columns and rows that the header declares, once they are possible and there is memory for them.
fn size(bytes: &[u8], watch: &Watch) -> Result<(usize, usize), String> {
    let mut decoder = decoder(bytes, watch.clone());
    decoder.decode_headers().map_err(damaged)?;
    let info = decoder.info().ok_or("damaged JPEG: it has no size")?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    check_size(width, height, 3)?;
    let raw = 3 * (width * height) as u64;
    check_ratio(raw, bytes.len() as u64, RATIO, "JPEG")?;
    room(8 * raw)?;
    if matches!(decoder.input_colorspace(), Some(ColorSpace::CMYK | ColorSpace::YCCK)) {
        return Err("its pixels are CMYK; save it as RGB".into());
    }
    Ok((width, height))
}

fn whole<B: AsRef<[u8]>>(bytes: B, watch: Watch) -> Result<Jpeg, String> {
    let mut decoder = decoder(bytes, watch);
    let pixels = decoder.decode().map_err(damaged)?;
    let info = decoder.info().ok_or("damaged JPEG: it has no size")?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    if pixels.len() != 3 * width * height {
        return Err(format!("damaged JPEG: {} bytes for {width} x {height} pixels", pixels.len()));
    }
    Ok(Jpeg { width, height, pixels, icc: decoder.icc_profile(), exif: decoder.exif().cloned() })
}
