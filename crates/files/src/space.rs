//! The display spaces that picture files are written in, and what other programs call them.

use iridesce_optics::color::{Matrix, Space};

use crate::error::FileError;

/// The display spaces a picture can be written in; all have the white D65.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputSpace {
    /// IEC 61966-2-1.
    Srgb,
    /// The primaries of DCI-P3 with white and curve of sRGB.
    DisplayP3,
    /// ITU-R BT.2020 with its own curve.
    Rec2020,
}

impl OutputSpace {
    /// All of them.
    pub const ALL: [OutputSpace; 3] = [OutputSpace::Srgb, OutputSpace::DisplayP3, OutputSpace::Rec2020];

    /// The space of that name.
    pub fn named(name: &str) -> Result<OutputSpace, FileError> {
        OutputSpace::ALL.into_iter().find(|space| space.name() == name).ok_or_else(|| {
            let allowed = OutputSpace::ALL.map(|space| format!("\"{}\"", space.name())).join(", ");
            FileError::Argument(format!("space must be one of {allowed}, got {name:?}"))
        })
    }

    /// The name it is asked for by.
    pub fn name(self) -> &'static str {
        match self {
            OutputSpace::Srgb => "srgb",
            OutputSpace::DisplayP3 => "display-p3",
            OutputSpace::Rec2020 => "rec2020",
        }
    }

    /// The name other programs know it by.
    pub(crate) fn title(self) -> &'static str {
        match self {
            OutputSpace::Srgb => "sRGB",
            OutputSpace::DisplayP3 => "Display P3",
            OutputSpace::Rec2020 => "Rec.2020",
        }
    }

    /// ITU-T H.273 code points: primaries, transfer, matrix (0, RGB), full range. `None` for sRGB, which has a chunk
    /// of its own.
    pub(crate) fn code_points(self) -> Option<[u8; 4]> {
        match self {
            OutputSpace::Srgb => None,
            OutputSpace::DisplayP3 => Some([12, 13, 0, 1]),
            OutputSpace::Rec2020 => Some([9, 14, 0, 1]),
        }
    }

    /// The same in the words of colour.
    pub fn space(self) -> Space {
        match self {
            OutputSpace::Srgb => Space::Srgb,
            OutputSpace::DisplayP3 => Space::DisplayP3,
            OutputSpace::Rec2020 => Space::Rec2020,
        }
    }

    /// Linear RGB to relative XYZ.
    pub fn xyz_from_rgb(self) -> Matrix {
        self.space().xyz_from_rgb().expect("a display space has primaries")
    }

    /// Relative XYZ to linear RGB.
    pub fn rgb_from_xyz(self) -> Matrix {
        self.space().rgb_from_xyz().expect("a display space has primaries")
    }
}
