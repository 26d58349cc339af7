//! How large a file's pictures may be, asked before memory is taken.

use crate::error::FileError;

/// Most texels: 16384 x 8192, 1.5 GiB of floats.
const MAX_TEXELS: u64 = 1 << 27;
/// Most samples in all channels of a file, those not needed included: 4 GiB of floats.
const MAX_SAMPLES: u64 = 1 << 30;

/// Whether a decoder may go on to read that many pixels.
pub fn check_size(width: usize, height: usize, channels: usize) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err("it has no pixels".into());
    }
    let texels = (width as u64).saturating_mul(height as u64);
    if texels > MAX_TEXELS {
        return Err(format!("it has {width} x {height} pixels; at most {MAX_TEXELS} (16384 x 8192) are read"));
    }
    if texels.saturating_mul(channels as u64) > MAX_SAMPLES {
        return Err(format!(
            "it has {channels} channels of {width} x {height} pixels; at most {MAX_SAMPLES} values are read"
        ));
    }
    Ok(())
}

/// Whether `declared` bytes of pixels can come out of a file of `present` bytes, at most `ratio` for one: a header of some
/// dozen bytes can declare any size.
pub fn check_ratio(declared: u64, present: u64, ratio: u64, format: &str) -> Result<(), String> {
    // A kibibyte to start with: the smallest files are all header.
    if declared > present.saturating_mul(ratio).saturating_add(1024) {
        return Err(format!(
            "damaged {format}: its header declares {declared} bytes of pixels, the file has {present} bytes"
        ));
    }
    Ok(())
}

/// Whether that many bytes can be had. Decoders reserve theirs without asking, and a refusal would end the process.
pub fn room(bytes: u64) -> Result<(), String> {
    let wanted = usize::try_from(bytes).map_err(|_| format!("it needs {bytes} bytes of memory"))?;
    Vec::<u8>::new()
        .try_reserve_exact(wanted)
        .map_err(|_| format!("it needs {} MiB of memory, which this process cannot have", bytes.div_ceil(1 << 20)))
}

/// Holds the lengths of planes against the size of the picture.
pub fn check_planes(width: u32, height: u32, planes: &[(&str, usize, usize)]) -> Result<(), FileError> {
    if width == 0 || height == 0 {
        return Err(FileError::Argument(format!("size must be at least 1 pixel each way, got {width} x {height}")));
    }
    let pixels = u128::from(width) * u128::from(height);
    for &(name, len, per_pixel) in planes {
        let wanted = pixels * per_pixel as u128;
        if len as u128 != wanted {
            return Err(FileError::Argument(format!(
                "{name} must hold {wanted} values for {width} x {height} pixels, got {len}"
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_declared_is_held_against_what_is_there() {
        assert!(check_ratio(1 << 30, 53, 1032, "PNG").unwrap_err().contains("declares 1073741824 bytes"));
        assert!(check_ratio(1000, 53, 1032, "PNG").is_ok());
        assert!(room(1 << 20).is_ok());
        assert!(room(u64::MAX).is_err() && room(1 << 62).unwrap_err().contains("cannot have"));
    }

    #[test]
    fn sizes_are_bounded_before_memory_is_asked_for() {
        assert!(check_size(16384, 8192, 4).is_ok());
        assert!(check_size(16384, 8193, 1).unwrap_err().contains("at most 134217728"));
        assert!(check_size(16384, 8192, 9).unwrap_err().contains("9 channels"));
        assert!(check_size(usize::MAX, usize::MAX, usize::MAX).is_err());
        assert!(check_size(0, 5, 3).is_err() && check_size(5, 0, 3).is_err());
    }
}
