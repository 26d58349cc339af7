//! How large a photograph is, from the head of its file: what is too large is refused before gibibytes are read.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use tiff::decoder::Decoder;

use crate::whole::check_ordinary;

/// Segments of a JPEG, or attributes of an OpenEXR file, that are looked at.
const MOST_PARTS: usize = 4096;

/// Columns and rows that a PNG, JPEG, TIFF or OpenEXR file declares. `None` for other formats, for a TIFF of several pages
/// and for what is damaged: the reader of the whole file has the words for it.
pub fn photograph_size(path: &Path) -> Option<(u64, u64)> {
    check_ordinary(path).ok()?;
    let mut file = BufReader::new(File::open(path).ok()?);
    let magic: [u8; 4] = bytes(&mut file)?;
    match magic {
        [0x89, b'P', b'N', b'G'] => {
            file.seek(SeekFrom::Start(16)).ok()?;
            Some((big(bytes::<4>(&mut file)?), big(bytes::<4>(&mut file)?)))
        }
        [0xFF, 0xD8, 0xFF, _] => jpeg(&mut file),
        [b'I', b'I', 42 | 43, 0] | [b'M', b'M', 0, 42 | 43] => {
            file.rewind().ok()?;
            let mut decoder = Decoder::new(file).ok()?;
            let (width, height) = decoder.dimensions().ok()?;
            (!decoder.more_images()).then_some((u64::from(width), u64::from(height)))
        }
        [0x76, 0x2F, 0x31, 0x01] => exr(&mut file),
        _ => None,
    }
}

fn bytes<const N: usize>(file: &mut impl Read) -> Option<[u8; N]> {
    let mut out = [0; N];
    file.read_exact(&mut out).ok()?;
    Some(out)
}

/// A number of two or four bytes, the greatest first.
fn big<const N: usize>(of: [u8; N]) -> u64 {
    of.iter().fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}

/// The frame's header: markers C0 to CF but for the tables C4, C8 and CC (ITU-T T.81, B.1.1.3).
fn jpeg(file: &mut BufReader<File>) -> Option<(u64, u64)> {
    file.seek(SeekFrom::Start(2)).ok()?;
    for _ in 0..MOST_PARTS {
        let [mark, kind] = bytes(file)?;
        match (mark, kind) {
            // Fill bytes stand before a marker.
            (0xFF, 0xFF) => file.seek_relative(-1).ok()?,
            (0xFF, 0xC0..=0xCF) if !matches!(kind, 0xC4 | 0xC8 | 0xCC) => {
                let [_, _, _, h, l, p, q] = bytes(file)?;
                return Some((big([p, q]), big([h, l])));
            }
            (0xFF, _) => {
                let length = i64::try_from(big(bytes::<2>(file)?)).ok()?;
                file.seek_relative(length - 2).ok()?;
            }
            _ => return None,
        }
    }
    None
}

/// The attribute dataWindow of the first part: xMin, yMin, xMax, yMax.
fn exr(file: &mut BufReader<File>) -> Option<(u64, u64)> {
    file.seek(SeekFrom::Start(8)).ok()?;
    for _ in 0..MOST_PARTS {
        let (name, _) = (text(file)?, text(file)?);
        let length = i32::from_le_bytes(bytes(file)?);
        if name == b"dataWindow" && length == 16 {
            let [left, top, right, bottom] = {
                let of: [u8; 16] = bytes(file)?;
                [0, 4, 8, 12].map(|at| i64::from(i32::from_le_bytes([of[at], of[at + 1], of[at + 2], of[at + 3]])))
            };
            return Some((u64::try_from(right - left + 1).ok()?, u64::try_from(bottom - top + 1).ok()?));
        }
        if name.is_empty() || length < 0 {
            return None;
        }
        file.seek_relative(i64::from(length)).ok()?;
    }
    None
}

/// A text that ends with a zero; names have at most 255 bytes.
fn text(file: &mut BufReader<File>) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    while out.len() < 256 {
        match bytes::<1>(file)? {
            [0] => return Some(out),
            [byte] => out.push(byte),
        }
    }
    None
}
