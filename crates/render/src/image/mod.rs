//! From linear XYZ to what eyes and other programs take: develop, PNG, EXR. Knows nothing of scenes or light.
//!
//! `develop` turns relative XYZ into encoded RGB; `png_file` and `exr_file` write whole files or none
//! (`whole_file`). The XYZ planes themselves are never changed: nothing is denoised, nothing clamped.

mod develop;
mod exr_file;
mod icc;
mod png_file;
mod table_file;
mod whole_file;

pub use develop::{Developed, Development, OutputSpace, auto_exposure, develop};
pub use exr_file::{Planes, write_exr};
pub use png_file::{BitDepth, png_bytes, write_png};
pub use table_file::{Table, read_tables, write_tables};
pub use whole_file::{check_output, write_bytes};

use std::path::{Path, PathBuf};

/// Asked now and then during long work: `true` stops it with [`ImageError::Cancelled`] and leaves no file behind.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// Why there is no picture file; `Display` is the whole message a user sees.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// A number, a name or a shape outside what is allowed.
    #[error("{0}")]
    Argument(String),
    /// The file could not be written; what was there before is still there.
    #[error("cannot write {}: {source}", .path.display())]
    Write {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system said, or what is wrong with the place.
        source: std::io::Error,
    },
    /// The caller asked to stop.
    #[error("saving was cancelled")]
    Cancelled,
}

impl ImageError {
    fn write(path: &Path, source: std::io::Error) -> ImageError {
        ImageError::Write { path: path.to_owned(), source }
    }
}

/// One fact about a picture that travels in its file.
#[derive(Debug, Clone, PartialEq)]
pub enum Fact {
    /// Words, a 64-bit seed, or a whole scene as JSON.
    Text(String),
    /// A count.
    Integer(i32),
    /// A measured number.
    Number(f64),
}

impl std::fmt::Display for Fact {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fact::Text(text) => f.write_str(text),
            Fact::Integer(value) => write!(f, "{value}"),
            Fact::Number(value) => write!(f, "{value}"),
        }
    }
}

/// Named facts in the order they are written. What varies from run to run (wall time, threads, dates) stays out of
/// files, so that the same render gives the same bytes.
pub type Facts = [(String, Fact)];

/// Holds the lengths of planes against the size of the picture.
fn check_planes(width: u32, height: u32, planes: &[(&str, usize, usize)]) -> Result<(), ImageError> {
    if width == 0 || height == 0 {
        return Err(ImageError::Argument(format!("size must be at least 1 pixel each way, got {width} x {height}")));
    }
    let pixels = u128::from(width) * u128::from(height);
    for &(name, len, per_pixel) in planes {
        let wanted = pixels * per_pixel as u128;
        if len as u128 != wanted {
            return Err(ImageError::Argument(format!(
                "{name} must hold {wanted} values for {width} x {height} pixels, got {len}"
            )));
        }
    }
    Ok(())
}
