//! Colours outside an RGB space: mapped inside with the hue kept, or clipped; and how many there were.
//!
//! A colour counts as outside when a linear channel lies below [`LOWEST`] or above [`HIGHEST`]. These margins keep
//! rounding, and the 1.6e-4 by which the white of the D65 table lies off the white of the RGB spaces, out of the count.
//! What lies within the margins is clipped to [0, 1]; everything inside [0, 1] comes back unchanged.

use iridesce_numerics::Argument;

use std::sync::OnceLock;

use rayon::prelude::*;

use super::matrix::{Matrix, inverse, mul};
use super::space::{OKLAB_FROM_ROOTS, OKLAB_LMS_FROM_XYZ, PRIMARIES, Space};
use crate::OpticsError;

/// Lowest linear value that does not count as outside.
pub const LOWEST: f64 = -1e-6;
/// Highest linear value that does not count as outside: an eighth of an 8-bit step of sRGB at white.
pub const HIGHEST: f64 = 1.0 + 5e-4;

/// How colours outside are brought inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mapping {
    /// Lightness and hue of Oklab are kept, chroma is reduced until the colour fits; what is brighter than white is white.
    #[default]
    Hue,
    /// Every channel is clipped by itself; hues shift.
    Clip,
}

impl Mapping {
    /// `"hue"` or `"clip"`.
    pub fn named(name: &str) -> Result<Mapping, OpticsError> {
        match name {
            "hue" => Ok(Mapping::Hue),
            "clip" => Ok(Mapping::Clip),
            _ => Err(Argument::one_of("gamut", &["hue", "clip"], name).into()),
        }
    }
}

/// A mapping into the linear RGB cube of one space, ready for many colours.
#[derive(Debug, Clone, Copy)]
pub struct Gamut {
    mapping: Mapping,
    oklab: &'static Polynomial,
}

/// Oklab written for one RGB space: its cone responses from RGB, and back.
///
/// The rows are scaled so that the white of the space has cone responses (1, 1, 1): then greys have no chroma also where the
/// white is not D65 (von Kries in the cones of Oklab).
#[derive(Debug)]
struct Polynomial {
    lms_from_rgb: Matrix,
    rgb_from_lms: Matrix,
    roots_from_lab: Matrix,
}

impl Gamut {
    /// `None` for spaces without primaries.
    pub fn new(space: Space, mapping: Mapping) -> Option<Gamut> {
        static CACHE: [OnceLock<Polynomial>; PRIMARIES] = [const { OnceLock::new() }; PRIMARIES];
        let place = space.primaries_number()?;
        let xyz_from_rgb = space.xyz_from_rgb()?;
        let oklab = CACHE[place].get_or_init(|| {
            let cones = mul(&OKLAB_LMS_FROM_XYZ, &xyz_from_rgb);
            let lms_from_rgb: Matrix = cones.map(|row| row.map(|v| v / row.iter().sum::<f64>()));
            let roots_from_lab = inverse(&OKLAB_FROM_ROOTS);
            Polynomial { lms_from_rgb, rgb_from_lms: inverse(&lms_from_rgb), roots_from_lab }
        });
        Some(Gamut { mapping, oklab })
    }

    /// A linear colour brought into [0, 1], and whether it was outside. Not-a-number channels count as 0.
    #[inline]
    pub fn map(&self, rgb: [f64; 3]) -> ([f64; 3], bool) {
        if rgb.iter().all(|v| (0.0..=1.0).contains(v)) {
            return (rgb, false);
        }
        let finite = rgb.map(|v| if v.is_nan() { 0.0 } else { v.clamp(-1e30, 1e30) });
        let clipped = finite.map(|v| v.clamp(0.0, 1.0));
        if rgb.iter().all(|v| (LOWEST..=HIGHEST).contains(v)) {
            return (clipped, false);
        }
        match self.mapping {
            Mapping::Clip => (clipped, true),
            Mapping::Hue => (self.oklab.reduce_chroma(finite), true),
        }
    }

    /// [`Gamut::map`] for a colour as `space` stores it (encoded where the space is).
    pub fn map_encoded(&self, space: Space, value: [f64; 3]) -> ([f64; 3], bool) {
        let (mapped, outside) = self.map(space.decode(value));
        // What was inside goes back as it came, without a trip through the curve.
        if outside { (space.encode(mapped), true) } else { (value.map(|v| v.clamp(0.0, 1.0)), false) }
    }

    /// Maps an image of linear RGB, three values a pixel, in place; returns how many pixels were outside.
    pub fn map_pixels(&self, rgb: &mut [f32]) -> u64 {
        let one = |pixel: &mut [f32; 3]| {
            if pixel.iter().all(|v| (0.0..=1.0).contains(v)) {
                return 0;
            }
            let (mapped, out) = self.map(pixel.map(f64::from));
            *pixel = mapped.map(|v| v as f32);
            u64::from(out)
        };
        rgb.as_chunks_mut::<3>().0.par_chunks_mut(4096).map(|run| run.iter_mut().map(one).sum::<u64>()).sum()
    }
}

/// A linear colour of `space` brought into [0, 1] with its hue kept; spaces without primaries return it unchanged.
pub fn map_linear(rgb: [f64; 3], space: Space) -> [f64; 3] {
    Gamut::new(space, Mapping::Hue).map_or(rgb, |gamut| gamut.map(rgb).0)
}

impl Polynomial {
    /// The largest chroma (of the same hue and lightness) inside the cube.
    ///
    /// Along a line of constant L and hue the cube roots of the cone responses are linear in chroma, so each RGB channel is
    /// a cubic in it: three Horner evaluations replace every trip through Oklab while the boundary is bracketed.
    fn reduce_chroma(&self, rgb: [f64; 3]) -> [f64; 3] {
        let roots: [f64; 3] = std::array::from_fn(|i| {
            let row = self.lms_from_rgb[i];
            (row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]).cbrt()
        });
        let lab: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| OKLAB_FROM_ROOTS[i][j] * roots[j]).sum());
        let lightness = lab[0].clamp(0.0, 1.0);
        if lightness == 0.0 || lightness == 1.0 {
            return [lightness; 3];
        }
        // Roots at chroma share s: lightness + s * slope. The grey (s = 0) is (L, L, L), as the rows of white sum to one.
        let slope: [f64; 3] =
            std::array::from_fn(|i| self.roots_from_lab[i][1] * lab[1] + self.roots_from_lab[i][2] * lab[2]);
        let mut cubic = [[0.0; 4]; 3];
        for (channel, c) in cubic.iter_mut().enumerate() {
            for (&weight, &g) in self.rgb_from_lms[channel].iter().zip(&slope) {
                c[0] += weight * lightness * lightness * lightness;
                c[1] += weight * 3.0 * lightness * lightness * g;
                c[2] += weight * 3.0 * lightness * g * g;
                c[3] += weight * g * g * g;
            }
        }
        let at = |s: f64| cubic.map(|c| ((c[3] * s + c[2]) * s + c[1]) * s + c[0]);
        // Without branches: which half it is cannot be foreseen, and a wrong guess costs more than the arithmetic.
        let inside = |[r, g, b]: [f64; 3]| r.min(g).min(b) >= 0.0 && r.max(g).max(b) <= 1.0;
        // 30 halvings: to 1e-9 of the chroma; the lower end is always inside.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            let fits = inside(at(middle));
            low = if fits { middle } else { low };
            high = if fits { high } else { middle };
        }
        at(low).map(|v| v.clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Adaptation;

    const RGB_SPACES: [Space; 6] =
        [Space::Srgb, Space::LinearSrgb, Space::DisplayP3, Space::Rec2020, Space::AcesCg, Space::Ntsc1953];

    fn hue(space: Space, rgb: [f64; 3]) -> (f64, f64, f64) {
        let xyz = super::super::matrix::times(&space.xyz_from_rgb().unwrap(), rgb);
        let [l, a, b] = Space::Oklab.from_xyz(xyz, [1.0; 3], Adaptation::None);
        (l, a.hypot(b), b.atan2(a))
    }

    #[test]
    fn inside_is_untouched() {
        for space in RGB_SPACES {
            for mapping in [Mapping::Hue, Mapping::Clip] {
                let gamut = Gamut::new(space, mapping).unwrap();
                for rgb in [[0.0; 3], [1.0; 3], [0.3, 1.0, 0.0], [0.123456789, 0.5, 0.99999]] {
                    assert_eq!(gamut.map(rgb), (rgb, false));
                }
                assert_eq!(gamut.map([1.0002, 0.5, -5e-7]), ([1.0, 0.5, 0.0], false));
            }
        }
        assert!(Gamut::new(Space::Lab, Mapping::Hue).is_none());
    }

    #[test]
    fn hue_and_lightness_are_kept() {
        for space in [Space::Srgb, Space::DisplayP3, Space::Rec2020] {
            let gamut = Gamut::new(space, Mapping::Hue).unwrap();
            for rgb in [
                [-0.2, 0.5, 0.1],
                [1.3, 0.2, 0.1],
                [0.4, -0.05, 0.9],
                [-0.01, 0.3, 0.35],
                [0.02, 0.01, -0.004],
                [1.05, 0.7, 0.9],
            ] {
                let (mapped, outside) = gamut.map(rgb);
                assert!(outside && mapped.iter().all(|v| (0.0..=1.0).contains(v)), "{mapped:?}");
                // On the boundary: no chroma given away.
                assert!(mapped.iter().any(|v| !(1e-9..=1.0 - 1e-9).contains(v)), "{rgb:?} {mapped:?}");
                let ((l0, c0, h0), (l1, c1, h1)) = (hue(space, rgb), hue(space, mapped));
                // The published Oklab matrices are off their own white by 1e-5 or so; rows are rescaled here.
                assert!((l0 - l1).abs() < 1e-4 && (h0 - h1).abs() < 2e-3 && c1 < c0, "{rgb:?}: {h0} {h1}, {l0} {l1}");
            }
        }
    }

    #[test]
    fn white_has_no_chroma_in_any_space() {
        for space in RGB_SPACES {
            let gamut = Gamut::new(space, Mapping::Hue).unwrap();
            for row in gamut.oklab.lms_from_rgb {
                assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{space:?}");
            }
        }
    }

    #[test]
    fn brighter_than_white_and_darker_than_black() {
        for space in RGB_SPACES {
            let gamut = Gamut::new(space, Mapping::Hue).unwrap();
            assert_eq!(gamut.map([3.0, 2.0, 2.5]), ([1.0; 3], true));
            assert_eq!(gamut.map([-3.0, -2.0, -2.5]), ([0.0; 3], true));
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
                let (mapped, _) = gamut.map([bad, 0.5, 0.5]);
                assert!(mapped.iter().all(|v| (0.0..=1.0).contains(v)), "{bad} {mapped:?}");
            }
        }
    }

    #[test]
    fn clip_clips_and_pixels_are_counted() {
        let gamut = Gamut::new(Space::LinearSrgb, Mapping::Clip).unwrap();
        assert_eq!(gamut.map([-0.5, 0.25, 1.5]), ([0.0, 0.25, 1.0], true));
        let mut image = [0.5, 0.5, 0.5, -0.1, 0.5, 0.5, 0.2, 1.2, 0.1];
        assert_eq!(gamut.map_pixels(&mut image), 2);
        assert_eq!(image, [0.5, 0.5, 0.5, 0.0, 0.5, 0.5, 0.2, 1.0, 0.1]);
        assert_eq!(map_linear([-0.5, 0.25, 1.5], Space::Xyz), [-0.5, 0.25, 1.5]);
    }
}
