//! Colour spaces: matrices from primaries and whites, transfer functions, CIELAB, Oklab, Bradford adaptation.

use iridesce_numerics::Argument;

use std::sync::OnceLock;

use super::matrix::{Matrix, inverse, mul, times};
use crate::OpticsError;

/// Chromaticity of D65 as colour-space standards round it (ITU-R BT.709, BT.2020; IEC 61966-2-1).
pub const D65_XY: [f64; 2] = [0.3127, 0.3290];
/// Luminance of linear Rec.709 (sRGB) red, green and blue, as rounded in ITU-R BT.709-6, item 3.2.
pub const REC709_LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Chromaticity of illuminant C (white of NTSC 1953).
pub const C_XY: [f64; 2] = [0.31006, 0.31616];
/// Chromaticity of D50.
pub const D50_XY: [f64; 2] = [0.34567, 0.35850];
/// Chromaticity of the ACES white (SMPTE ST 2065-1).
pub const ACES_XY: [f64; 2] = [0.32168, 0.33767];

/// A colour space. XYZ is relative: the perfect reflector, or the brightest white of an RGB space, has Y = 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Space {
    /// CIE XYZ.
    Xyz,
    /// CIE x, y, Y.
    Xyy,
    /// CIE 1976 L*, a*, b*.
    Lab,
    /// CIE 1976 L*, C*, h in degrees [0, 360).
    Lch,
    /// Oklab (B. Ottosson, 2020).
    Oklab,
    /// sRGB (IEC 61966-2-1), encoded.
    Srgb,
    /// Display P3, encoded with the sRGB curve.
    DisplayP3,
    /// ITU-R BT.2020, encoded with its own curve.
    Rec2020,
    /// Rec.709 primaries, linear.
    LinearSrgb,
    /// ACEScg: AP1 primaries, ACES white, linear.
    AcesCg,
    /// NTSC 1953 primaries, white C, linear.
    Ntsc1953,
}

/// How many sets of primaries [`SPACES`] have.
pub(super) const PRIMARIES: usize = 5;

/// All spaces with their names.
pub const SPACES: [(Space, &str); 11] = [
    (Space::Xyz, "xyz"),
    (Space::Xyy, "xyy"),
    (Space::Lab, "lab"),
    (Space::Lch, "lch"),
    (Space::Oklab, "oklab"),
    (Space::Srgb, "srgb"),
    (Space::DisplayP3, "display-p3"),
    (Space::Rec2020, "rec2020"),
    (Space::LinearSrgb, "linear-srgb"),
    (Space::AcesCg, "acescg"),
    (Space::Ntsc1953, "ntsc1953"),
];

impl Space {
    /// A space by name: `xyz xyy lab lch oklab srgb display-p3 rec2020 linear-srgb acescg ntsc1953`.
    pub fn named(name: &str) -> Result<Space, OpticsError> {
        let key = name.trim().to_ascii_lowercase();
        SPACES.iter().find(|(_, n)| *n == key).map(|(space, _)| *space).ok_or_else(|| {
            let known: Vec<&str> = SPACES.iter().map(|(_, n)| *n).collect();
            OpticsError::Unknown(format!("unknown colour space {name:?}; known: {}", known.join(" ")))
        })
    }

    /// The name that [`Space::named`] takes.
    pub fn name(self) -> &'static str {
        SPACES.iter().find(|(space, _)| *space == self).map_or("", |(_, name)| name)
    }

    /// Chromaticities of red, green, blue and white; `None` for spaces without primaries.
    fn primaries(self) -> Option<([[f64; 2]; 3], [f64; 2])> {
        match self {
            // ITU-R BT.709
            Space::Srgb | Space::LinearSrgb => Some(([[0.640, 0.330], [0.300, 0.600], [0.150, 0.060]], D65_XY)),
            // SMPTE EG 432-1 primaries with D65
            Space::DisplayP3 => Some(([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]], D65_XY)),
            // ITU-R BT.2020
            Space::Rec2020 => Some(([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]], D65_XY)),
            // AP1 of the Academy's S-2014-004
            Space::AcesCg => Some(([[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]], ACES_XY)),
            // FCC 1953
            Space::Ntsc1953 => Some(([[0.670, 0.330], [0.210, 0.710], [0.140, 0.080]], C_XY)),
            _ => None,
        }
    }

    /// XYZ (Y = 1) of the white this space is defined for; `None` where it is the light's own (XYZ, xyY, Lab, LCh).
    pub fn white(self) -> Option<[f64; 3]> {
        match self {
            Space::Oklab => Some(xyz_of_xy(D65_XY)),
            _ => self.primaries().map(|(_, white)| xyz_of_xy(white)),
        }
    }

    /// The matrix from XYZ to linear RGB, derived from primaries and white; `None` for spaces without primaries.
    pub fn rgb_from_xyz(self) -> Option<Matrix> {
        self.matrices().map(|(_, inverse)| inverse)
    }

    /// The matrix from linear RGB to XYZ; `None` for spaces without primaries.
    pub fn xyz_from_rgb(self) -> Option<Matrix> {
        self.matrices().map(|(forward, _)| forward)
    }

    /// Which of the [`PRIMARIES`] sets a space has; `None` for spaces without any.
    pub(super) fn primaries_number(self) -> Option<usize> {
        match self {
            Space::Srgb | Space::LinearSrgb => Some(0),
            Space::DisplayP3 => Some(1),
            Space::Rec2020 => Some(2),
            Space::AcesCg => Some(3),
            Space::Ntsc1953 => Some(4),
            _ => None,
        }
    }

    fn matrices(self) -> Option<(Matrix, Matrix)> {
        static CACHE: [OnceLock<(Matrix, Matrix)>; PRIMARIES] = [const { OnceLock::new() }; PRIMARIES];
        let place = self.primaries_number()?;
        let (primaries, white) = self.primaries()?;
        Some(*CACHE[place].get_or_init(|| {
            let columns: [[f64; 3]; 3] = primaries.map(xyz_of_xy);
            let unscaled: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
            let scale = times(&inverse(&unscaled), xyz_of_xy(white));
            let forward = std::array::from_fn(|i| std::array::from_fn(|j| unscaled[i][j] * scale[j]));
            (forward, inverse(&forward))
        }))
    }

    /// Linear RGB to what the space stores: the transfer function, or nothing for linear spaces.
    /// Negative values take the curve of their absolute value with a minus sign, so that nothing is lost.
    pub fn encode(self, linear: [f64; 3]) -> [f64; 3] {
        match self {
            Space::Srgb | Space::DisplayP3 => linear.map(|v| odd(v, srgb_encode)),
            Space::Rec2020 => linear.map(|v| odd(v, rec2020_encode)),
            _ => linear,
        }
    }

    /// The inverse of [`Space::encode`].
    pub fn decode(self, encoded: [f64; 3]) -> [f64; 3] {
        match self {
            Space::Srgb | Space::DisplayP3 => encoded.map(|v| odd(v, srgb_decode)),
            Space::Rec2020 => encoded.map(|v| odd(v, rec2020_decode)),
            _ => encoded,
        }
    }

    /// From XYZ under a light whose white is `white` (its XYZ, Y = 1).
    ///
    /// Lab and LCh are relative to `white`. RGB spaces and Oklab have whites of their own: without adaptation they take
    /// XYZ as it is. xyY of black, whose chromaticity is open, takes that of `white`.
    pub fn from_xyz(self, xyz: [f64; 3], white: [f64; 3], adaptation: Adaptation) -> [f64; 3] {
        match self {
            Space::Xyz => xyz,
            Space::Xyy => {
                let sum: f64 = xyz.iter().sum();
                let of = if sum == 0.0 { white } else { xyz };
                let sum: f64 = of.iter().sum();
                [of[0] / sum, of[1] / sum, xyz[1]]
            }
            Space::Lab => lab(xyz, white),
            Space::Lch => {
                let [l, a, b] = lab(xyz, white);
                [l, a.hypot(b), hue_deg(a, b)]
            }
            Space::Oklab => oklab(self.adapted(xyz, white, adaptation)),
            _ => {
                let matrix = self.rgb_from_xyz().unwrap_or(IDENTITY);
                self.encode(times(&matrix, self.adapted(xyz, white, adaptation)))
            }
        }
    }

    /// The inverse of [`Space::from_xyz`]. xyY with y = 0 and Y not 0 has no XYZ: the result is not finite.
    pub fn to_xyz(self, values: [f64; 3], white: [f64; 3], adaptation: Adaptation) -> [f64; 3] {
        let back = |xyz| match (adaptation, self.white()) {
            (Adaptation::Bradford, Some(own)) => times(&bradford(own, white), xyz),
            _ => xyz,
        };
        match self {
            Space::Xyz => values,
            Space::Xyy => match values {
                [_, _, 0.0] => [0.0; 3],
                [x, y, luminance] => [x * luminance / y, luminance, (1.0 - x - y) * luminance / y],
            },
            Space::Lab => xyz_of_lab(values, white),
            Space::Lch => {
                let (sin, cos) = values[2].to_radians().sin_cos();
                xyz_of_lab([values[0], values[1] * cos, values[1] * sin], white)
            }
            Space::Oklab => back(xyz_of_oklab(values)),
            _ => back(times(&self.xyz_from_rgb().unwrap_or(IDENTITY), self.decode(values))),
        }
    }

    fn adapted(self, xyz: [f64; 3], white: [f64; 3], adaptation: Adaptation) -> [f64; 3] {
        match (adaptation, self.white()) {
            (Adaptation::Bradford, Some(own)) => times(&bradford(white, own), xyz),
            _ => xyz,
        }
    }
}

/// Whether colours are adapted from the white of the light to the white of the space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Adaptation {
    /// XYZ is taken as it is.
    #[default]
    None,
    /// Linear Bradford adaptation.
    Bradford,
}

impl Adaptation {
    /// `"bradford"`, or `None`.
    pub fn named(name: Option<&str>) -> Result<Adaptation, OpticsError> {
        match name {
            None => Ok(Adaptation::None),
            Some("bradford") => Ok(Adaptation::Bradford),
            Some(other) => Err(Argument::new("adaptation", "\"bradford\" or None", format!("{other:?}")).into()),
        }
    }
}

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// XYZ with Y = 1 of a chromaticity (y > 0).
pub fn xyz_of_xy([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// The linear Bradford matrix that takes XYZ under one white to XYZ under another: M^-1 diag(M to / M from) M, with M the
/// matrix of K. Lam's thesis (Bradford, 1985) as used by the ICC (ICC.1:2022, annex E).
pub fn bradford(from: [f64; 3], to: [f64; 3]) -> Matrix {
    const CONE: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
    let (a, b) = (times(&CONE, from), times(&CONE, to));
    let scaled: Matrix = std::array::from_fn(|i| CONE[i].map(|v| v * b[i] / a[i]));
    mul(&inverse(&CONE), &scaled)
}

fn odd(value: f64, curve: impl Fn(f64) -> f64) -> f64 {
    curve(value.abs()).copysign(value)
}

/// IEC 61966-2-1:1999.
fn srgb_encode(v: f64) -> f64 {
    if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// Derivative of [`srgb_encode`].
pub(super) fn srgb_encode_slope(v: f64) -> f64 {
    if v <= 0.0031308 { 12.92 } else { 1.055 / 2.4 * v.powf(1.0 / 2.4 - 1.0) }
}

fn srgb_decode(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// ITU-R BT.2020-2, table 4: alpha and beta make the two pieces meet with one slope; the printed 1.099 and 0.018 are theirs
/// rounded to ten-bit signals.
const REC2020_ALPHA: f64 = 1.099_296_826_809_44;
const REC2020_BETA: f64 = 0.018_053_968_510_807;

fn rec2020_encode(v: f64) -> f64 {
    if v < REC2020_BETA { 4.5 * v } else { REC2020_ALPHA * v.powf(0.45) - (REC2020_ALPHA - 1.0) }
}

/// Derivative of [`rec2020_encode`].
pub(super) fn rec2020_encode_slope(v: f64) -> f64 {
    if v < REC2020_BETA { 4.5 } else { 0.45 * REC2020_ALPHA * v.powf(0.45 - 1.0) }
}

fn rec2020_decode(v: f64) -> f64 {
    if v < 4.5 * REC2020_BETA { v / 4.5 } else { ((v + (REC2020_ALPHA - 1.0)) / REC2020_ALPHA).powf(1.0 / 0.45) }
}

/// CIE 1976 L*a*b* (CIE 15:2004): the cube root continues as a straight line below (6/29)^3, and so for negative values.
fn lab(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f: [f64; 3] = std::array::from_fn(|i| {
        let t = xyz[i] / white[i];
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    });
    [116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])]
}

fn xyz_of_lab([l, a, b]: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let fy = (l + 16.0) / 116.0;
    let f = [fy + a / 500.0, fy, fy - b / 200.0];
    std::array::from_fn(|i| {
        let v = f[i];
        white[i] * if v > DELTA { v * v * v } else { 3.0 * DELTA * DELTA * (v - 4.0 / 29.0) }
    })
}

/// atan2(b, a) in degrees, [0, 360); 0 for a grey.
pub(super) fn hue_deg(a: f64, b: f64) -> f64 {
    let hue = b.atan2(a).to_degrees();
    // A tiny negative angle plus 360 rounds to 360 itself.
    if hue >= 0.0 { hue } else { (hue + 360.0) % 360.0 }
}

/// XYZ (D65) to the cone responses of Oklab. B. Ottosson, "A perceptual color space for image processing", 2020.
pub(super) const OKLAB_LMS_FROM_XYZ: Matrix = [
    [0.8189330101, 0.3618667424, -0.1288597137],
    [0.0329845436, 0.9293118715, 0.0361456387],
    [0.0482003018, 0.2643662691, 0.6338517070],
];
/// Cube roots of the cone responses to L, a, b; the same source.
pub(super) const OKLAB_FROM_ROOTS: Matrix = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
];

fn oklab(xyz: [f64; 3]) -> [f64; 3] {
    times(&OKLAB_FROM_ROOTS, times(&OKLAB_LMS_FROM_XYZ, xyz).map(f64::cbrt))
}

fn xyz_of_oklab(values: [f64; 3]) -> [f64; 3] {
    static INVERSES: OnceLock<(Matrix, Matrix)> = OnceLock::new();
    let (roots, xyz) = INVERSES.get_or_init(|| (inverse(&OKLAB_FROM_ROOTS), inverse(&OKLAB_LMS_FROM_XYZ)));
    times(xyz, times(roots, values).map(|v| v * v * v))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3], tolerance: f64) {
        for i in 0..3 {
            assert!((a[i] - b[i]).abs() <= tolerance, "{a:?} against {b:?}");
        }
    }

    #[test]
    fn white_and_black_of_every_rgb_space() {
        for (space, name) in SPACES {
            let Some(white) = space.white().filter(|_| space.rgb_from_xyz().is_some()) else { continue };
            close(space.from_xyz(white, white, Adaptation::None), [1.0; 3], 1e-14);
            close(space.from_xyz([0.0; 3], white, Adaptation::None), [0.0; 3], 0.0);
            assert_eq!(Space::named(name).unwrap(), space);
            assert_eq!(space.name(), name);
        }
    }

    #[test]
    fn srgb_matrix_and_curve() {
        // Rounded rows of IEC 61966-2-1 (four decimals).
        let matrix = Space::Srgb.rgb_from_xyz().unwrap();
        let printed = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
        for i in 0..3 {
            close(matrix[i], printed[i], 5e-4);
        }
        close(Space::Srgb.encode([0.18, 0.001, -0.18]), [0.461356, 0.01292, -0.461356], 1e-6);
        // BT.2020 12-bit value of 18 % grey: 1.0993 * 0.18^0.45 - 0.0993
        close(Space::Rec2020.encode([0.18, 0.01, 1.0]), [0.40884, 0.045, 1.0], 5e-5);
        close(Space::LinearSrgb.encode([0.18, -1.0, 2.0]), [0.18, -1.0, 2.0], 0.0);
    }

    #[test]
    fn there_and_back_for_every_space() {
        let white = xyz_of_xy([0.44757, 0.40745]);
        let colors = [[0.2, 0.3, 0.1], [0.9, 1.0, 0.4], [1e-4, 2e-4, 3e-4], [0.05, -0.01, 0.2], [-0.3, 0.2, 2.0]];
        for (space, name) in SPACES {
            for adaptation in [Adaptation::None, Adaptation::Bradford] {
                for xyz in colors {
                    let there = space.from_xyz(xyz, white, adaptation);
                    assert!(there.iter().all(|v| v.is_finite()), "{name} {xyz:?} {there:?}");
                    close(space.to_xyz(there, white, adaptation), xyz, 2e-7);
                }
            }
        }
    }

    #[test]
    fn cielab_and_oklab_of_known_colours() {
        let white = xyz_of_xy(D65_XY);
        close(Space::Lab.from_xyz(white, white, Adaptation::None), [100.0, 0.0, 0.0], 1e-12);
        close(Space::Lch.from_xyz([0.0; 3], white, Adaptation::None), [0.0, 0.0, 0.0], 1e-12);
        // Ottosson's own check values, three decimals.
        close(Space::Oklab.from_xyz([0.950, 1.000, 1.089], white, Adaptation::None), [1.0, 0.0, 0.0], 1e-3);
        close(Space::Oklab.from_xyz([1.0, 0.0, 0.0], white, Adaptation::None), [0.450, 1.236, -0.019], 5e-4);
        close(Space::Oklab.from_xyz([0.0, 1.0, 0.0], white, Adaptation::None), [0.922, -0.671, 0.263], 5e-4);
        close(Space::Oklab.from_xyz([0.0, 0.0, 1.0], white, Adaptation::None), [0.153, -1.415, -0.449], 5e-4);
    }

    #[test]
    fn bradford_takes_white_to_white() {
        let (a, d65) = (xyz_of_xy([0.44757, 0.40745]), xyz_of_xy(D65_XY));
        close(times(&bradford(a, d65), a), d65, 1e-14);
        close(Space::LinearSrgb.from_xyz(a, a, Adaptation::Bradford), [1.0; 3], 1e-14);
        assert!(Space::LinearSrgb.from_xyz(a, a, Adaptation::None)[2] < 0.3);
    }

    #[test]
    fn black_has_a_chromaticity() {
        let white = xyz_of_xy(C_XY);
        close(Space::Xyy.from_xyz([0.0; 3], white, Adaptation::None), [C_XY[0], C_XY[1], 0.0], 1e-15);
        close(Space::Xyy.to_xyz([0.3, 0.0, 0.0], white, Adaptation::None), [0.0; 3], 0.0);
    }

    #[test]
    fn hue_stays_below_a_full_turn() {
        assert_eq!(hue_deg(1.0, -1e-30), 0.0);
        assert_eq!(hue_deg(0.0, 0.0), 0.0);
        assert_eq!(hue_deg(0.0, -1.0), 270.0);
    }

    #[test]
    fn unknown_names() {
        assert!(Space::named("hsv").unwrap_err().to_string().contains("linear-srgb"));
        assert!(Adaptation::named(Some("cat02")).unwrap_err().to_string().contains("bradford"));
    }
}
