//! Relative XYZ to encoded RGB: exposure, roll-off of what is too bright, hue-keeping gamut mapping, encoding.

use iridesce_files::{FileError, OutputSpace, Stop};
use iridesce_optics::color::gamut::{Gamut, HIGHEST, Mapping};
use iridesce_optics::color::{Adaptation, Matrix, Space};
use rayon::prelude::*;

/// How to develop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Development {
    /// The space of the answer.
    pub space: OutputSpace,
    /// XYZ are multiplied by 2 to this power, -64 to 64.
    pub exposure: f64,
    /// What is done with colours outside it.
    pub gamut: Mapping,
}

/// A developed picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Developed {
    /// Encoded RGB in [0, 1], three floats a pixel; never NaN.
    pub rgb: Vec<f32>,
    /// Share of pixels that lay outside the space and had to be moved, 0 to 1 (see `optics::color::Gamut`).
    pub out_of_gamut: f64,
    /// Share of pixels too bright for the space: some linear component was above 1.
    pub overexposed: f64,
}

/// Relative XYZ, three floats a pixel, to encoded RGB.
///
/// Colours inside the space at the chosen exposure come out exactly. With [`Mapping::Hue`] the others keep their Oklab
/// hue:
/// - a colour with negative components loses chroma, at the same lightness, until it fits;
/// - a colour whose largest component is m > 1 is scaled by 1/m (which moves no hue: Oklab is homogeneous in light) and
///   then goes the share 1 - 1/m of the straight line to white. Highlights whiten as on film, instead of turning into
///   the nearest corner of the cube or all into the same white; just above 1 nothing jumps.
///
/// With [`Mapping::Clip`] each component is clipped to [0, 1]: what other programs do, hues shift.
///
/// NaN counts as 0, so that one bad pixel is a black one and not a broken file.
pub fn develop(xyz: &[f32], how: &Development, stop: Stop<'_>) -> Result<Developed, FileError> {
    if !xyz.len().is_multiple_of(3) {
        return Err(FileError::Argument(format!("xyz must hold three values a pixel, got {}", xyz.len())));
    }
    if !(-MAX_EXPOSURE..=MAX_EXPOSURE).contains(&how.exposure) {
        return Err(FileError::Argument(format!(
            "exposure must be -{MAX_EXPOSURE} to {MAX_EXPOSURE} stops, got {}",
            how.exposure
        )));
    }
    let gain = how.exposure.exp2();
    let rgb_from_xyz = how.space.rgb_from_xyz();
    let (space, hue, clip) = (how.space.space(), Mapper::new(how.space), Gamut::new(how.space.space(), how.gamut));
    let clip = clip.expect("a display space has primaries");
    let mut rgb = vec![0.0; xyz.len()];
    // Counts are integers: the same whatever the order the threads add them in.
    let (outside, over) = rgb
        .par_chunks_mut(3 * BLOCK)
        .zip(xyz.par_chunks(3 * BLOCK))
        .map(|(out, xyz)| {
            if stop() {
                return Err(FileError::Cancelled);
            }
            let mut counts = (0_u64, 0_u64);
            for (out, xyz) in out.chunks_exact_mut(3).zip(xyz.chunks_exact(3)) {
                let linear = apply(&rgb_from_xyz, [0, 1, 2].map(|i| sound(xyz[i]) * gain));
                let (mapped, outside) = clip.map(linear);
                let over = linear.iter().any(|v| *v > HIGHEST);
                let inside = if over && how.gamut == Mapping::Hue { hue.map(linear) } else { mapped };
                for (to, value) in out.iter_mut().zip(space.encode(inside)) {
                    *to = value.clamp(0.0, 1.0) as f32;
                }
                counts = (counts.0 + u64::from(outside), counts.1 + u64::from(over));
            }
            Ok(counts)
        })
        .try_reduce(|| (0, 0), |a, b| Ok((a.0 + b.0, a.1 + b.1)))?;
    let pixels = (xyz.len() / 3).max(1) as f64;
    Ok(Developed { rgb, out_of_gamut: outside as f64 / pixels, overexposed: over as f64 / pixels })
}

/// Pixels of one piece of work: a millisecond or two, after which `stop` is asked again.
const BLOCK: usize = 4096;

/// No picture needs more; f32 has 128 stops above 1.
const MAX_EXPOSURE: f64 = 64.0;

/// Where the 95th percentile lands: 0.95 once encoded in sRGB. The twentieth part above it may roll off to white.
const AUTO_TARGET: f64 = 0.9;

/// The exposure in stops that shows a picture whole: `log2(0.9 / p)`, rounded to a hundredth of a stop.
///
/// p is the 95th percentile of the largest linear Rec.709 component (of a grey, its Y) over the pixels that show a surface
/// (finite `depth`), or over all pixels where surfaces fill less than a hundredth of the picture: the meter looks at the
/// films and not at the lamps around them. 0 for a black picture. `depth` is empty or has one value a pixel.
pub fn auto_exposure(xyz: &[f32], depth: &[f32], stop: Stop<'_>) -> Result<f64, FileError> {
    let pixels = xyz.len() / 3;
    if !xyz.len().is_multiple_of(3) || !(depth.is_empty() || depth.len() == pixels) {
        return Err(FileError::Argument(format!(
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
    let is_surface = |i: usize| depth.get(i).is_some_and(|depth| depth.is_finite());
    let mut counts = histogram(pixels, &|i| is_surface(i).then(|| brightest(i)), stop)?;
    let surfaces = counts.iter().sum::<u64>() >= pixels.div_ceil(100) as u64;
    let metered = |i: usize| (!surfaces || is_surface(i)).then(|| brightest(i));
    if !surfaces {
        counts = histogram(pixels, &metered, stop)?;
    }
    let Some(last) = counts.iter().sum::<u64>().checked_sub(1) else { return Ok(0.0) };
    let (mut rank, mut place) = (last * 95 / 100, 0);
    while counts[place] <= rank {
        rank -= counts[place];
        place += 1;
    }
    let mut there = Vec::with_capacity(counts[place] as usize);
    for i in 0..pixels {
        if i % BLOCK == 0 && stop() {
            return Err(FileError::Cancelled);
        }
        there.extend(metered(i).filter(|value| bucket(*value) == place));
    }
    let p = *there.select_nth_unstable_by(rank as usize, f64::total_cmp).1;
    if p <= 0.0 {
        return Ok(0.0);
    }
    let stops = (AUTO_TARGET / p).log2().clamp(-MAX_EXPOSURE, MAX_EXPOSURE);
    Ok((stops * 100.0).round() / 100.0)
}

/// Buckets of a number's sign, exponent and four bits behind it: they stand in the order of the numbers, from 0 on.
const BUCKETS: usize = 1 << 16;

fn bucket(value: f64) -> usize {
    (value.to_bits() >> 48) as usize
}

/// How many of the pixels that have a value, 0 or more, have it in each bucket.
fn histogram(
    pixels: usize,
    value: &(dyn Fn(usize) -> Option<f64> + Sync),
    stop: Stop<'_>,
) -> Result<Vec<u64>, FileError> {
    (0..pixels.div_ceil(BLOCK))
        .into_par_iter()
        .with_min_len(64)
        .try_fold(
            || vec![0; BUCKETS],
            |mut counts, block| {
                if stop() {
                    return Err(FileError::Cancelled);
                }
                for value in (block * BLOCK..pixels.min((block + 1) * BLOCK)).filter_map(value) {
                    counts[bucket(value)] += 1;
                }
                Ok(counts)
            },
        )
        .try_reduce(|| vec![0; BUCKETS], |a, b| Ok(a.into_iter().zip(b).map(|(a, b)| a + b).collect()))
}

/// NaN counts as 0, infinities as the largest number, so that what follows stays a number.
fn sound(value: f32) -> f64 {
    if value.is_nan() { 0.0 } else { f64::from(value.clamp(f32::MIN, f32::MAX)) }
}

/// Hue-keeping mapping into one space.
struct Mapper {
    cube: Gamut,
    xyz_from_rgb: Matrix,
    rgb_from_xyz: Matrix,
    white: [f64; 3],
}

impl Mapper {
    fn new(space: OutputSpace) -> Mapper {
        let cube = Gamut::new(space.space(), Mapping::Hue).expect("a display space has primaries");
        let (xyz_from_rgb, rgb_from_xyz) = (space.xyz_from_rgb(), space.rgb_from_xyz());
        // White as the Oklab matrices see it, so that greys stay exactly grey on their way to it.
        Mapper { cube, xyz_from_rgb, rgb_from_xyz, white: oklab(apply(&xyz_from_rgb, [1.0; 3])) }
    }

    fn map(&self, rgb: [f64; 3]) -> [f64; 3] {
        let largest = rgb.into_iter().fold(0.0, f64::max);
        if largest <= 1.0 {
            return self.cube.map(rgb).0;
        }
        let (scaled, _) = self.cube.map(rgb.map(|v| v / largest));
        let colour = oklab(apply(&self.xyz_from_rgb, scaled));
        let share = 1.0 / largest;
        let faded = [0, 1, 2].map(|i| self.white[i] + share * (colour[i] - self.white[i]));
        // The boundary between the colour and white may bulge inwards: the straight line may leave the cube again.
        self.cube.map(apply(&self.rgb_from_xyz, Space::Oklab.to_xyz(faded, [1.0; 3], Adaptation::None))).0
    }
}

fn oklab(xyz: [f64; 3]) -> [f64; 3] {
    Space::Oklab.from_xyz(xyz, [1.0; 3], Adaptation::None)
}

pub(super) fn apply(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn how(space: OutputSpace, exposure: f64, gamut: Mapping) -> Development {
        Development { space, exposure, gamut }
    }

    /// XYZ of linear RGB in f32, as a picture holds it.
    fn xyz(space: OutputSpace, rgb: [f64; 3]) -> [f32; 3] {
        apply(&space.xyz_from_rgb(), rgb).map(|v| v as f32)
    }

    /// Lightness, chroma, hue (radians) in Oklab.
    fn lch(space: OutputSpace, encoded: [f64; 3]) -> [f64; 3] {
        let [l, a, b] = oklab(apply(&space.xyz_from_rgb(), space.space().decode(encoded)));
        [l, a.hypot(b), b.atan2(a)]
    }

    fn one(space: OutputSpace, linear: [f64; 3], exposure: f64, gamut: Mapping) -> [f64; 3] {
        let developed = develop(&xyz(space, linear), &how(space, exposure, gamut), &|| false).unwrap();
        [0, 1, 2].map(|i| f64::from(developed.rgb[i]))
    }

    #[test]
    fn colours_inside_are_exact_at_their_exposure() {
        for space in OutputSpace::ALL {
            for gamut in [Mapping::Hue, Mapping::Clip] {
                for linear in [[0.0; 3], [1.0; 3], [0.2, 0.7, 0.05], [0.999, 0.0, 0.5], [1e-3, 2e-3, 0.0]] {
                    for exposure in [-3.0_f64, 0.0, 2.5] {
                        let wanted = space.space().encode(linear);
                        let got = one(space, linear.map(|v| v / exposure.exp2()), exposure, gamut);
                        for i in 0..3 {
                            // f32 XYZ: 1e-7 relative, times the gain of the matrix and of the curve near black (12.92).
                            assert!((got[i] - wanted[i]).abs() < 4e-6, "{space:?} {linear:?}: {got:?} for {wanted:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn hue_is_kept_out_of_gamut_and_too_bright() {
        for space in OutputSpace::ALL {
            for linear in [[0.5, -0.05, 0.1], [2.0, 0.4, 0.1], [0.1, 0.2, 5.0], [3.0, -0.2, 1.0], [0.6, 1.4, 0.3]] {
                let mapped = one(space, linear, 0.0, Mapping::Hue);
                assert!(mapped.iter().all(|v| (0.0..=1.0).contains(v)));
                let [_, _, wanted] = {
                    let [l, a, b] = oklab(apply(&space.xyz_from_rgb(), linear));
                    [l, a.hypot(b), b.atan2(a)]
                };
                let [_, chroma, hue] = lch(space, mapped);
                let turn = ((hue - wanted) / std::f64::consts::TAU).fract();
                let turn = turn - turn.round();
                assert!(chroma > 0.01 && turn.abs() < 2e-3, "{space:?} {linear:?}: {mapped:?} turned by {turn}");
            }
            // Clipping does turn it: the test above can fail.
            let clipped = lch(space, one(space, [2.0, 0.4, 0.1], 0.0, Mapping::Clip))[2];
            let kept = lch(space, one(space, [2.0, 0.4, 0.1], 0.0, Mapping::Hue))[2];
            assert!((clipped - kept).abs() > 0.05, "{clipped} {kept}");
        }
    }

    #[test]
    fn highlights_go_to_white_without_a_jump() {
        let colour = [1.0, 0.45, 0.05];
        let mut last = lch(OutputSpace::Srgb, OutputSpace::Srgb.space().encode(colour.map(|v| 0.98 * v)));
        for step in -40..400 {
            let factor = (0.01 * f64::from(step)).exp2();
            let now = lch(OutputSpace::Srgb, one(OutputSpace::Srgb, colour.map(|v| v * factor), 0.0, Mapping::Hue));
            assert!(step == -40 || now[0] >= last[0] - 1e-5, "{factor}: lightness fell from {} to {}", last[0], now[0]);
            assert!(step == -40 || (now[0] - last[0]).abs() + (now[1] - last[1]).abs() < 0.01, "a jump at {factor}");
            last = now;
        }
        let white = one(OutputSpace::Srgb, colour.map(|v| v * 1e6), 0.0, Mapping::Hue);
        assert!(white.iter().all(|v| *v > 0.999), "{white:?}");
        assert!(last[1] < 0.02 && last[1] > 0.0, "four stops over there is a breath of colour left: {last:?}");
        assert_eq!(one(OutputSpace::Srgb, [3.0; 3], 0.0, Mapping::Hue), [1.0; 3]);
    }

    #[test]
    fn shares_count_pixels() {
        let pixels = [[0.5, 0.5, 0.5], [-0.1, 0.5, 0.2], [2.0, 0.5, 0.5], [1.0, 1.0, 1.0]];
        let xyz: Vec<f32> = pixels.into_iter().flat_map(|rgb| xyz(OutputSpace::Srgb, rgb)).collect();
        for gamut in [Mapping::Hue, Mapping::Clip] {
            let developed = develop(&xyz, &how(OutputSpace::Srgb, 0.0, gamut), &|| false).unwrap();
            assert_eq!((developed.out_of_gamut, developed.overexposed), (0.5, 0.25));
        }
        // The same green is inside Rec.2020.
        let developed = develop(&xyz[3..6], &how(OutputSpace::Rec2020, 0.0, Mapping::Hue), &|| false).unwrap();
        assert_eq!(developed.out_of_gamut, 0.0);
    }

    #[test]
    fn nothing_makes_a_nan() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, f32::MIN_POSITIVE] {
            for xyz in [[bad, 0.5, 0.5], [0.5, bad, 0.5], [bad; 3]] {
                for (space, exposure) in [(OutputSpace::Srgb, 64.0), (OutputSpace::Rec2020, -64.0)] {
                    for gamut in [Mapping::Hue, Mapping::Clip] {
                        let rgb = develop(&xyz, &how(space, exposure, gamut), &|| false).unwrap().rgb;
                        assert!(rgb.iter().all(|v| (0.0..=1.0).contains(v)), "{xyz:?}: {rgb:?}");
                    }
                }
                assert!(auto_exposure(&xyz, &[], &|| false).unwrap().is_finite());
            }
        }
        assert!(develop(&[], &how(OutputSpace::Srgb, 0.0, Mapping::Hue), &|| false).unwrap().rgb.is_empty());
        assert_eq!(auto_exposure(&[], &[], &|| false).unwrap(), 0.0);
    }

    #[test]
    fn wrong_arguments_are_named() {
        for exposure in [f64::NAN, f64::INFINITY, 64.5, -1e9] {
            let error =
                develop(&[0.0; 3], &how(OutputSpace::Srgb, exposure, Mapping::Hue), &|| false).unwrap_err().to_string();
            assert!(error.contains("-64 to 64 stops") && error.contains(&exposure.to_string()), "{error}");
        }
        let error = develop(&[0.0; 4], &how(OutputSpace::Srgb, 0.0, Mapping::Hue), &|| false).unwrap_err();
        assert!(error.to_string().contains("got 4"));
        assert!(OutputSpace::named("SRGB").unwrap_err().to_string().contains("\"rec2020\", got \"SRGB\""));
        assert!(auto_exposure(&[0.0; 6], &[1.0], &|| false).is_err());
    }

    #[test]
    fn the_meter_reads_surfaces_not_lamps() {
        // 900 grey surface pixels of 0.25 to 0.5, 90 of a lamp at 1000 in the background, 10 bright ones on the surface.
        let mut grey: Vec<f32> = (0..900).map(|i| 0.25 + 0.25 * i as f32 / 899.0).collect();
        grey.extend(vec![1000.0; 90]);
        grey.extend(vec![7.0; 10]);
        let mut depth = vec![4.0; 1000];
        depth[900..990].fill(f32::INFINITY);
        let xyz: Vec<f32> = grey.iter().flat_map(|g| xyz(OutputSpace::Srgb, [f64::from(*g); 3])).collect();
        // 910 metered: rank 863 (of 0 to 909) is 0.25 + 0.25 * 863 / 899 = 0.48999; log2(0.9 / 0.48999) = 0.877.
        assert_eq!(auto_exposure(&xyz, &depth, &|| false).unwrap(), 0.88);
        // Without a surface all pixels count: the lamp.
        assert_eq!(auto_exposure(&xyz, &[], &|| false).unwrap(), -10.12);
        depth.fill(f32::INFINITY);
        depth[..9].fill(1.0);
        assert_eq!(
            auto_exposure(&xyz, &depth, &|| false).unwrap(),
            -10.12,
            "surfaces of less than a hundredth do not count"
        );
        assert_eq!(auto_exposure(&[0.0; 30], &[], &|| false).unwrap(), 0.0);
        assert!(matches!(auto_exposure(&xyz, &[], &|| true), Err(FileError::Cancelled)));
    }

    #[test]
    fn the_meter_takes_the_number_of_its_rank() {
        // Y of greys all over the range of numbers, in no order: the rank by a plain sort.
        let grey: Vec<f64> =
            (0..20_000_u32).map(|i| (f64::from(i.wrapping_mul(2_654_435_761) >> 8) / 1e6).exp2()).collect();
        let xyz: Vec<f32> = grey.iter().flat_map(|g| xyz(OutputSpace::Srgb, [*g; 3])).collect();
        let mut sorted = grey;
        sorted.sort_by(f64::total_cmp);
        let wanted = (AUTO_TARGET / sorted[19_999 * 95 / 100]).log2();
        assert!((auto_exposure(&xyz, &[], &|| false).unwrap() - wanted).abs() < 0.006);
    }
}
