//! Relative XYZ to encoded RGB: exposure, roll-off of what is too bright, hue-keeping gamut mapping, encoding.

use rayon::prelude::*;

use super::ImageError;

type Matrix = [[f64; 3]; 3];

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
    pub fn named(name: &str) -> Result<OutputSpace, ImageError> {
        OutputSpace::ALL.into_iter().find(|space| space.name() == name).ok_or_else(|| {
            let allowed = OutputSpace::ALL.map(|space| format!("\"{}\"", space.name())).join(", ");
            ImageError::Argument(format!("space must be one of {allowed}, got {name:?}"))
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
    pub(super) fn title(self) -> &'static str {
        match self {
            OutputSpace::Srgb => "sRGB",
            OutputSpace::DisplayP3 => "Display P3",
            OutputSpace::Rec2020 => "Rec.2020",
        }
    }

    /// ITU-T H.273 code points: primaries, transfer, matrix (0, RGB), full range. `None` for sRGB, which has a chunk
    /// of its own.
    pub(super) fn code_points(self) -> Option<[u8; 4]> {
        match self {
            OutputSpace::Srgb => None,
            OutputSpace::DisplayP3 => Some([12, 13, 0, 1]),
            OutputSpace::Rec2020 => Some([9, 14, 0, 1]),
        }
    }

    /// Chromaticities of red, green and blue.
    fn primaries(self) -> [[f64; 2]; 3] {
        match self {
            OutputSpace::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]],
            OutputSpace::DisplayP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]],
            OutputSpace::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
        }
    }

    /// XYZ of the white, Y = 1.
    pub(super) fn white(self) -> [f64; 3] {
        let (x, y) = (0.3127, 0.3290);
        [x / y, 1.0, (1.0 - x - y) / y]
    }

    /// Linear RGB to relative XYZ, from primaries and white.
    pub(super) fn xyz_from_rgb(self) -> Matrix {
        let columns = self.primaries().map(|[x, y]| [x / y, 1.0, (1.0 - x - y) / y]);
        let matrix = [0, 1, 2].map(|row| [columns[0][row], columns[1][row], columns[2][row]]);
        let scale = apply(&inverse(&matrix), self.white());
        matrix.map(|row| [row[0] * scale[0], row[1] * scale[1], row[2] * scale[2]])
    }

    /// Relative XYZ to linear RGB.
    pub(super) fn rgb_from_xyz(self) -> Matrix {
        inverse(&self.xyz_from_rgb())
    }

    /// Linear to encoded value.
    fn encode(self, linear: f64) -> f64 {
        match self {
            OutputSpace::Srgb | OutputSpace::DisplayP3 => {
                if linear <= 0.003_130_8 {
                    12.92 * linear
                } else {
                    1.055 * linear.powf(1.0 / 2.4) - 0.055
                }
            }
            OutputSpace::Rec2020 => {
                if linear < REC2020_BETA {
                    4.5 * linear
                } else {
                    REC2020_ALPHA * linear.powf(0.45) - (REC2020_ALPHA - 1.0)
                }
            }
        }
    }

    /// Parameters g, a, b, c, d of the way back: `(a v + b)^g` from d on, `c v` below.
    pub(super) fn icc_curve(self) -> [f64; 5] {
        match self {
            OutputSpace::Srgb | OutputSpace::DisplayP3 => {
                [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 12.92 * 0.003_130_8]
            }
            OutputSpace::Rec2020 => {
                let a = 1.0 / REC2020_ALPHA;
                [1.0 / 0.45, a, (REC2020_ALPHA - 1.0) * a, 1.0 / 4.5, 4.5 * REC2020_BETA]
            }
        }
    }
}

/// The two constants of ITU-R BT.2020-2, table 4, from its condition that both pieces meet smoothly.
const REC2020_ALPHA: f64 = 1.099_296_826_809_44;
const REC2020_BETA: f64 = 0.018_053_968_510_807;

/// What is done with colours that the space cannot hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gamut {
    /// Keep the hue, give up saturation, then brightness: see [`develop`].
    Hue,
    /// Clip each of R, G and B to [0, 1]: hues shift.
    Clip,
}

impl Gamut {
    /// `"hue"` or `"clip"`.
    pub fn named(name: &str) -> Result<Gamut, ImageError> {
        match name {
            "hue" => Ok(Gamut::Hue),
            "clip" => Ok(Gamut::Clip),
            _ => Err(ImageError::Argument(format!("gamut must be \"hue\" or \"clip\", got {name:?}"))),
        }
    }
}

/// How to develop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Development {
    /// The space of the answer.
    pub space: OutputSpace,
    /// XYZ are multiplied by 2 to this power, -64 to 64.
    pub exposure: f64,
    /// What is done with colours outside it.
    pub gamut: Gamut,
}

/// A developed picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Developed {
    /// Encoded RGB in [0, 1], three floats a pixel; never NaN.
    pub rgb: Vec<f32>,
    /// Share of pixels that had to be moved, 0 to 1: some linear component is below 0 or above 1 by more than 1e-5.
    pub out_of_gamut: f64,
    /// Share of pixels too bright for the space: some linear component is above 1 by more than 1e-5.
    pub overexposed: f64,
}

/// Rounding of f32 sums puts a white of exactly 1 this far outside at most; such pixels are not counted.
const TOLERANCE: f64 = 1e-5;

/// Relative XYZ, three floats a pixel, to encoded RGB.
///
/// Colours inside the space at the chosen exposure come out exactly. With [`Gamut::Hue`] the others keep their Oklab
/// hue, in two steps:
/// 1. a colour with negative components loses chroma, at the same lightness, until none is negative;
/// 2. a colour whose largest component is m > 1 is scaled to 1 (which moves no hue: Oklab is homogeneous in light) and
///    then goes the share 1 - 1/m of the straight line to white: highlights whiten as on film instead of turning into
///    the nearest corner of the cube. The lightness so found is continuous in m and close to the colour's own just above 1.
///
/// NaN counts as 0, so that one bad pixel is a black one and not a broken file.
pub fn develop(xyz: &[f32], how: &Development) -> Result<Developed, ImageError> {
    if !xyz.len().is_multiple_of(3) {
        return Err(ImageError::Argument(format!("xyz must hold three values a pixel, got {}", xyz.len())));
    }
    if !(-MAX_EXPOSURE..=MAX_EXPOSURE).contains(&how.exposure) {
        return Err(ImageError::Argument(format!(
            "exposure must be -{MAX_EXPOSURE} to {MAX_EXPOSURE} stops, got {}",
            how.exposure
        )));
    }
    let gain = how.exposure.exp2();
    let mapper = Mapper::new(how.space);
    let mut rgb = vec![0.0; xyz.len()];
    // Counts are integers: the same whatever the order the threads add them in.
    let (outside, over) = rgb
        .par_chunks_exact_mut(3)
        .zip(xyz.par_chunks_exact(3))
        .map(|(out, xyz)| {
            let linear = apply(&mapper.rgb_from_xyz, [0, 1, 2].map(|i| sound(xyz[i]) * gain));
            let over = linear.iter().any(|v| *v > 1.0 + TOLERANCE);
            let outside = over || linear.iter().any(|v| *v < -TOLERANCE);
            let inside = match how.gamut {
                Gamut::Hue if outside => mapper.keep_hue(linear),
                _ => linear,
            };
            for (to, value) in out.iter_mut().zip(inside) {
                *to = how.space.encode(value.clamp(0.0, 1.0)).clamp(0.0, 1.0) as f32;
            }
            (u64::from(outside), u64::from(over))
        })
        .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let pixels = (xyz.len() / 3).max(1) as f64;
    Ok(Developed { rgb, out_of_gamut: outside as f64 / pixels, overexposed: over as f64 / pixels })
}

/// No picture needs more; f32 has 128 stops above 1.
const MAX_EXPOSURE: f64 = 64.0;

/// Largest linear component where the 99th percentile lands: 0.95 once encoded.
const AUTO_TARGET: f64 = 0.9;

/// The exposure in stops that shows a picture whole: `log2(0.9 / p)`, rounded to a hundredth of a stop.
///
/// p is the 99th percentile of the largest linear Rec.709 component (of a grey, its Y) over the pixels that show a surface
/// (finite `depth`), or over all pixels where surfaces fill less than a hundredth of the picture: the meter looks at the
/// films and not at the lamps around them. 0 for a black picture. `depth` is empty or has one value a pixel.
pub fn auto_exposure(xyz: &[f32], depth: &[f32]) -> Result<f64, ImageError> {
    let pixels = xyz.len() / 3;
    if !xyz.len().is_multiple_of(3) || !(depth.is_empty() || depth.len() == pixels) {
        return Err(ImageError::Argument(format!(
            "xyz must hold three values a pixel and depth one, got {} and {}",
            xyz.len(),
            depth.len()
        )));
    }
    let matrix = OutputSpace::Srgb.rgb_from_xyz();
    let brightest = |i: usize| {
        let rgb = apply(&matrix, [0, 1, 2].map(|c| sound(xyz[3 * i + c])));
        rgb.into_iter().fold(0.0, f64::max)
    };
    let mut metered: Vec<f64> = (0..depth.len()).filter(|i| depth[*i].is_finite()).map(brightest).collect();
    if metered.len() < pixels.div_ceil(100) {
        metered = (0..pixels).map(brightest).collect();
    }
    if metered.is_empty() {
        return Ok(0.0);
    }
    let rank = (metered.len() - 1) * 99 / 100;
    let p = *metered.select_nth_unstable_by(rank, f64::total_cmp).1;
    if p <= 0.0 {
        return Ok(0.0);
    }
    let stops = (AUTO_TARGET / p).log2().clamp(-MAX_EXPOSURE, MAX_EXPOSURE);
    Ok((stops * 100.0).round() / 100.0)
}

/// NaN counts as 0, infinities as the largest number, so that what follows stays a number.
fn sound(value: f32) -> f64 {
    if value.is_nan() { 0.0 } else { f64::from(value.clamp(f32::MIN, f32::MAX)) }
}

/// The matrices of one space.
struct Mapper {
    rgb_from_xyz: Matrix,
    lms_from_rgb: Matrix,
    rgb_from_lms: Matrix,
}

impl Mapper {
    fn new(space: OutputSpace) -> Mapper {
        let lms_from_rgb = multiply(&LMS_FROM_XYZ, &space.xyz_from_rgb());
        Mapper { rgb_from_xyz: space.rgb_from_xyz(), lms_from_rgb, rgb_from_lms: inverse(&lms_from_rgb) }
    }

    fn oklab(&self, rgb: [f64; 3]) -> [f64; 3] {
        apply(&OKLAB_FROM_LMS, apply(&self.lms_from_rgb, rgb).map(f64::cbrt))
    }

    fn rgb(&self, oklab: [f64; 3]) -> [f64; 3] {
        apply(&self.rgb_from_lms, apply(&inverse(&OKLAB_FROM_LMS), oklab).map(|v| v * v * v))
    }

    /// The nearest colour of the same Oklab lightness and hue without components below 0 (and, if `cube`, above 1).
    fn reduce_chroma(&self, rgb: [f64; 3], cube: bool) -> [f64; 3] {
        let holds = |c: [f64; 3]| c.iter().all(|v| *v >= 0.0 && (!cube || *v <= 1.0));
        if holds(rgb) {
            return rgb;
        }
        let [lightness, a, b] = self.oklab(rgb);
        let with = |share: f64| self.rgb([lightness, share * a, share * b]);
        let (mut inside, mut outside) = (0.0, 1.0);
        // 30 halvings: 1e-9 of the chroma, far below a 16-bit step.
        for _ in 0..30 {
            let middle = 0.5 * (inside + outside);
            if holds(with(middle)) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        with(inside)
    }

    fn keep_hue(&self, rgb: [f64; 3]) -> [f64; 3] {
        if self.oklab(rgb)[0] <= 0.0 {
            return [0.0; 3]; // darker than black: no colour of that lightness
        }
        let positive = self.reduce_chroma(rgb, false);
        let largest = positive.into_iter().fold(0.0, f64::max);
        if largest <= 1.0 {
            return positive;
        }
        let [lightness, a, b] = self.oklab(positive.map(|v| v / largest));
        let colour = 1.0 / largest;
        let faded = self.rgb([1.0 + colour * (lightness - 1.0), colour * a, colour * b]);
        self.reduce_chroma(faded, true)
    }
}

/// Oklab (B. Ottosson, "A perceptual color space for image processing", 2020), from XYZ under D65.
const LMS_FROM_XYZ: Matrix = [
    [0.818_933_010_1, 0.361_866_742_4, -0.128_859_713_7],
    [0.032_984_543_6, 0.929_311_871_5, 0.036_145_638_7],
    [0.048_200_301_8, 0.264_366_269_1, 0.633_851_707_0],
];
const OKLAB_FROM_LMS: Matrix = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];

pub(super) fn apply(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub(super) fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// By cofactors; the matrices here are well conditioned.
pub(super) fn inverse(m: &Matrix) -> Matrix {
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant = (0..3).map(|c| m[0][c] * cofactor(0, c)).sum::<f64>();
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| cofactor(column, row) / determinant))
}
