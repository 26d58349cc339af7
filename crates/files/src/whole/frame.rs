//! Whether a picture file is whole: right size, and there to its last byte. Asked of frames that an interrupted run left.

use std::io::Cursor;

/// Why the bytes of a PNG or an OpenEXR file are no whole picture of that size, if they are none. No pixel is decoded.
pub fn check_picture(bytes: &[u8], width: u32, height: u32) -> Result<(), String> {
    let found = match bytes {
        [0x89, b'P', b'N', b'G', ..] => png(bytes),
        [0x76, 0x2F, 0x31, 0x01, ..] => exr(bytes),
        [] => return Err("it is empty".into()),
        _ => return Err("it is neither PNG nor OpenEXR".into()),
    };
    match found {
        None => Err("it is not whole".into()),
        Some(size) if size == (width, height) => Ok(()),
        Some((w, h)) => Err(format!("it has {w} x {h} pixels, not {width} x {height}")),
    }
}

/// The size of a PNG whose chunks lead to its end mark, and nothing beyond it (PNG, section 5.3).
fn png(bytes: &[u8]) -> Option<(u32, u32)> {
    let long = |at: usize| Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let (mut at, mut has_data) = (8, false);
    let size = (long(16)?, long(20)?);
    loop {
        let length = usize::try_from(long(at)?).ok()?;
        let kind = bytes.get(at + 4..at + 8)?;
        at = at.checked_add(length)?.checked_add(12)?;
        has_data |= kind == b"IDAT";
        if kind == b"IEND" {
            return (at == bytes.len() && has_data).then_some(size);
        }
    }
}

/// The size of an OpenEXR file of one part, each of whose blocks stands where its table says, to its last byte.
fn exr(bytes: &[u8]) -> Option<(u32, u32)> {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).ok()?;
    let [header] = meta.headers.as_slice() else { return None };
    let table = header_end(bytes)?;
    let table = bytes.get(table..table.checked_add(header.chunk_count.checked_mul(8)?)?)?;
    for &offset in table.as_chunks::<8>().0 {
        let at = usize::try_from(u64::from_le_bytes(offset)).ok().filter(|at| *at > 0)?;
        // The row that it begins at, its length, and so many bytes: what our files of scan lines are made of.
        let length = u32::from_le_bytes(bytes.get(at.checked_add(4)?..at.checked_add(8)?)?.try_into().ok()?);
        let end = at.checked_add(8)?.checked_add(usize::try_from(length).ok()?)?;
        bytes.get(at + 8..end).filter(|block| !block.is_empty())?;
    }
    Some((u32::try_from(header.layer_size.x()).ok()?, u32::try_from(header.layer_size.y()).ok()?))
}

/// Where the attributes of the only header end: each has a name, a type, both ended by a zero, and a length.
fn header_end(bytes: &[u8]) -> Option<usize> {
    let text_end = |at: usize| Some(at + bytes.get(at..)?.iter().position(|&byte| byte == 0)? + 1);
    let mut at = 8;
    loop {
        let after = text_end(at)?;
        if after == at + 1 {
            return Some(after);
        }
        let kind = text_end(after)?;
        let size = u32::from_le_bytes(bytes.get(kind..kind.checked_add(4)?)?.try_into().ok()?);
        at = kind.checked_add(4)?.checked_add(usize::try_from(size).ok()?)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BitDepth, OutputSpace, Packing, Picture, Plane, Values, write_exr, write_png};

    #[test]
    fn only_whole_pictures_of_the_size_pass() {
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("x.png"), folder.path().join("x.exr"));
        let values = vec![0.25_f32; 20 * 10 * 3];
        let stop = || false;
        write_png(&png, 20, 10, &values, BitDepth::Eight, Packing::Small, OutputSpace::Srgb, &[], &stop).unwrap();
        let depth = Plane { channels: vec!["depth.Z".into()], values: Values::Single(&values[..200]) };
        let picture = Picture { width: 20, height: 10, xyz: &values, is_half: false, planes: vec![depth] };
        write_exr(&exr, &picture, &[], &stop).unwrap();
        for path in [png, exr] {
            let bytes = std::fs::read(path).unwrap();
            assert_eq!(check_picture(&bytes, 20, 10), Ok(()));
            assert!(check_picture(&bytes, 10, 20).unwrap_err().contains("20 x 10 pixels, not 10 x 20"));
            for length in 0..bytes.len() {
                assert!(check_picture(&bytes[..length], 20, 10).is_err(), "{length} of {}", bytes.len());
            }
            // As a file system may leave it after a power cut: the right length, nothing in it.
            assert!(check_picture(&vec![0; bytes.len()], 20, 10).is_err());
        }
    }
}
