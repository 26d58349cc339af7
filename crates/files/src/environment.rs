//! Environment maps from the bytes of a file: OpenEXR (R, G, B or Y; half, float or integer) or Radiance HDR.

use std::panic::{AssertUnwindSafe, catch_unwind};

use iridesce_numerics::Watch;
use iridesce_optics::color::REC709_LUMINANCE;

use crate::exr::{OpenExr, open_exr};
use crate::hdr;
use crate::report::ReadReport;
use crate::words::{listed, quoted};

/// Texels between two looks at the watch.
const PIECE: usize = 1 << 20;

/// Largest file of a map: the largest map in single precision, and then some.
pub const MAX_ENVIRONMENT_BYTES: u64 = 4 << 30;

/// Largest radiance, as a factor and in a map: their product, summed over any number of samples and wavelengths, stays
/// within the range of the renderer's single precision (1e38).
pub const MAX_RADIANCE: f64 = 1e12;

/// A latitude-longitude map, linear Rec.709; first row +y, middle column -z, columns grow towards +x.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row after row, three floats a texel.
    pub rgb: Vec<f32>,
}

/// Rec.709 primaries and white, CIE 1931 x, y (ITU-R BT.709-6, table 1).
const REC709: [[f32; 2]; 4] = [[0.640, 0.330], [0.300, 0.600], [0.150, 0.060], [0.3127, 0.3290]];
/// Largest difference from them that is rounding in a file.
const CHROMATICITY_SLACK: f32 = 2e-3;

/// Luminance of linear Rec.709 (ITU-R BT.709-6, item 3.2).
const LUMINANCE: [f32; 3] = [REC709_LUMINANCE[0] as f32, REC709_LUMINANCE[1] as f32, REC709_LUMINANCE[2] as f32];

/// The map in a file's bytes, told apart by content; every value is finite and every texel's luminance >= 0. `layer` names the
/// layer of an OpenEXR file (`part:layer`) where it holds several pictures.
pub fn decode(bytes: &[u8], layer: Option<&str>, watch: &Watch) -> Result<(EnvironmentMap, ReadReport), String> {
    let mut report = ReadReport::default();
    let read = || picture(bytes, layer, watch, &mut report);
    // A file made to trip the decoder must not take the program with it.
    let map = catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("it is damaged".to_owned()))?;
    check_shape(&map, &mut report)?;
    watch.check().map_err(|stopped| stopped.to_string())?;
    check_values(&map)?;
    Ok((map, report))
}

/// The colours of an OpenEXR or Radiance HDR file, whatever they show.
pub fn picture(
    bytes: &[u8],
    layer: Option<&str>,
    watch: &Watch,
    report: &mut ReadReport,
) -> Result<EnvironmentMap, String> {
    match bytes {
        [0x76, 0x2F, 0x31, 0x01, ..] => read_exr(bytes, layer, watch, report),
        [b'#', b'?', ..] => {
            if let Some(layer) = layer {
                return Err(format!("layer must be left out: a Radiance HDR has none, got {}", quoted(layer)));
            }
            report.format = "Radiance HDR".into();
            report.take("radiance", "R, G, B", "", "the only ones");
            let hdr::HdrPicture { width, height, rgb } = hdr::read(bytes, watch, report)?;
            Ok(EnvironmentMap { width, height, rgb })
        }
        [] => Err("it is empty".to_owned()),
        _ => Err("it is neither OpenEXR nor Radiance HDR".to_owned()),
    }
}

/// The map in a file that holds one picture, without a watch.
pub fn decode_environment(bytes: &[u8]) -> Result<EnvironmentMap, String> {
    decode(bytes, None, &Watch::new()).map(|(map, _)| map)
}

/// Six faces side by side, above one another or in a cross are a cube map, whatever the file says.
fn check_shape(map: &EnvironmentMap, report: &mut ReadReport) -> Result<(), String> {
    let (width, height) = (map.width, map.height);
    let is = |a: usize, b: usize| width * b == height * a;
    // One pixel each way is a colour for all directions.
    if width > 1 && (is(6, 1) || is(1, 6) || is(3, 4) || is(4, 3)) {
        return Err(format!(
            "it has {width} x {height} pixels, the shape of a cube map; convert it to a latitude-longitude map, twice as \
             wide as high"
        ));
    }
    let is_one_texel = width == 1 && height == 1;
    if !is(2, 1) && !is_one_texel {
        report.note(format!("{width} x {height} pixels are not 2:1; taken as latitude and longitude all the same"));
    }
    Ok(())
}

fn check_values(map: &EnvironmentMap) -> Result<(), String> {
    let place = |texel: usize| format!("at column {}, row {}", texel % map.width, texel / map.width);
    // Also refuses NaN, which no range contains.
    if let Some(at) = map.rgb.iter().position(|&v| !(-MAX_RADIANCE..=MAX_RADIANCE).contains(&f64::from(v))) {
        return Err(format!(
            "it holds {} in {} {}; every value must be finite and at most 1e12",
            map.rgb[at],
            ["red", "green", "blue"][at % 3],
            place(at / 3)
        ));
    }
    // A single value below 0 is a colour outside Rec.709; light below 0 does not exist.
    let luminance = |rgb: &[f32]| rgb.iter().zip(LUMINANCE).map(|(value, weight)| value * weight).sum::<f32>();
    if let Some(texel) = map.rgb.chunks_exact(3).position(|rgb| luminance(rgb) < 0.0) {
        return Err(format!(
            "its luminance is {} {}; no light is below 0",
            luminance(&map.rgb[3 * texel..][..3]),
            place(texel)
        ));
    }
    Ok(())
}

fn read_exr(
    bytes: &[u8],
    layer: Option<&str>,
    watch: &Watch,
    report: &mut ReadReport,
) -> Result<EnvironmentMap, String> {
    let open = open_exr(bytes, watch)?;
    report.format = "OpenEXR".into();
    if open.is_cube {
        return Err("it says that it is a cube map (envmap); convert it to a latitude-longitude map".into());
    }
    if let Some(given) = open.chromaticities {
        let given = [given.red, given.green, given.blue, given.white].map(|v| [v.x(), v.y()]);
        let differs = |(a, b): (&f32, &f32)| (a - b).is_nan() || (a - b).abs() > CHROMATICITY_SLACK;
        if given.as_flattened().iter().zip(REC709.as_flattened()).any(differs) {
            return Err(format!(
                "its colours have other primaries and white ({given:?}) than Rec.709; convert it to linear Rec.709"
            ));
        }
    }
    let [red, green, blue] = rgb_planes(&open, layer, report)?;
    let [r, g, b] = [red, green, blue].map(|place| &open.channels[place]);
    if (r.width, r.height) != (g.width, g.height) || (r.width, r.height) != (b.width, b.height) {
        return Err("its channels differ in size".into());
    }
    let mut rgb = Vec::with_capacity(3 * r.values.len());
    for start in (0..r.values.len()).step_by(PIECE) {
        watch.check().map_err(|stopped| stopped.to_string())?;
        let end = (start + PIECE).min(r.values.len());
        for i in start..end {
            rgb.extend([r.values[i], g.values[i], b.values[i]]);
        }
    }
    Ok(EnvironmentMap { width: r.width, height: r.height, rgb })
}

/// A layer that holds colours: its part and name, and its channels R, G, B or thrice Y.
type Coloured<'a> = ((usize, &'a str), [usize; 3]);

/// The channels R, G, B or thrice Y of the layer that was named; or else of the plain one, or of the only one.
fn rgb_planes(open: &OpenExr, asked: Option<&str>, report: &mut ReadReport) -> Result<[usize; 3], String> {
    let pictures = pictures(open);
    if pictures.is_empty() {
        return Err(format!("it has the channels {}; R, G and B, or Y alone are needed", open.list()));
    }
    // `part:layer` as a user names it: the channel's name without its last part.
    let called = |planes: &[usize; 3]| {
        let channel = &open.channels[planes[0]];
        channel.name[..channel.name.len() - channel.last().len()].trim_end_matches('.').trim_end_matches(':').to_owned()
    };
    let names: Vec<String> = pictures.iter().map(|(_, planes)| called(planes)).collect();
    let (place, why) = match asked {
        Some(asked) => (named(&names, asked)?, "layer ="),
        None => plain(&pictures, &names)?,
    };
    let planes = pictures[place].1;
    let taken: Vec<&str> = planes.iter().map(|&plane| open.channels[plane].name.as_str()).collect();
    report.take("radiance", &taken.join(", "), "", why);
    let others = open.channels.iter().enumerate().filter(|(other, _)| !planes.contains(other));
    let others: Vec<&str> = others.map(|(_, channel)| channel.name.as_str()).collect();
    if !others.is_empty() {
        report.drop(format!("the channels {}", listed(others)));
    }
    Ok(planes)
}

fn pictures(open: &OpenExr) -> Vec<Coloured<'_>> {
    let mut layers: Vec<(usize, &str)> = Vec::new();
    for channel in &open.channels {
        if !layers.contains(&channel.layer()) {
            layers.push(channel.layer());
        }
    }
    let find = |layer: (usize, &str), last: &str| {
        open.channels.iter().position(|channel| channel.layer() == layer && channel.last().eq_ignore_ascii_case(last))
    };
    // Y beside X and Z, or beside the colour differences RY and BY, is not grey.
    let colours = |layer: (usize, &str)| match [find(layer, "R"), find(layer, "G"), find(layer, "B")] {
        [Some(r), Some(g), Some(b)] => Some([r, g, b]),
        _ if ["X", "Z", "RY", "BY"].iter().any(|other| find(layer, other).is_some()) => None,
        _ => find(layer, "Y").map(|y| [y, y, y]),
    };
    layers.into_iter().filter_map(|layer| Some((layer, colours(layer)?))).collect()
}

/// The picture that a user asked for, by its whole name or by the last part of it.
fn named(names: &[String], asked: &str) -> Result<usize, String> {
    let wanted = asked.trim_end_matches('.');
    let exact = names.iter().position(|name| name == wanted);
    let short: Vec<usize> =
        (0..names.len()).filter(|&place| names[place].rsplit([':', '.']).next() == Some(wanted)).collect();
    match (exact, short.as_slice()) {
        (Some(place), _) | (None, &[place]) => Ok(place),
        _ => {
            let there = listed(names.iter().map(String::as_str));
            Err(format!("it has no layer {} with colours; there are {there}", quoted(asked)))
        }
    }
}

/// The picture that is meant where nobody says which, and why.
fn plain(pictures: &[Coloured<'_>], names: &[String]) -> Result<(usize, &'static str), String> {
    let plain: Vec<usize> = (0..pictures.len()).filter(|&place| pictures[place].0.1.is_empty()).collect();
    match (plain.as_slice(), pictures.len()) {
        (&[place], _) => Ok((place, "the layer without a name")),
        ([], 1) => Ok((0, "the only layer with colours")),
        (_, count) => {
            let there = listed(names.iter().map(String::as_str));
            Err(format!("it holds {count} pictures in layers or parts; say which: layer = {there}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use exr::prelude::*;

    use super::{EnvironmentMap, Watch};

    fn decode(bytes: &[u8]) -> std::result::Result<EnvironmentMap, String> {
        super::decode(bytes, None, &Watch::new()).map(|(map, _)| map)
    }

    /// An OpenEXR file of 4 x 2 single-precision pixels, every value of a channel `value` but the last texel's.
    fn file(channels: &[(&str, f32, f32)], change: impl Fn(&mut Image<Layer<AnyChannels<FlatSamples>>>)) -> Vec<u8> {
        let list = channels.iter().map(|&(name, value, last)| {
            let mut samples = vec![value; 8];
            samples[7] = last;
            AnyChannel::new(name, FlatSamples::F32(samples))
        });
        let channels = AnyChannels::sort(list.collect());
        let layer = Layer::new((4, 2), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
        let mut image = Image::from_layer(layer);
        change(&mut image);
        let mut bytes = Vec::new();
        image.write().non_parallel().to_buffered(Cursor::new(&mut bytes)).unwrap();
        bytes
    }

    fn plain(channels: &[(&str, f32, f32)]) -> std::result::Result<EnvironmentMap, String> {
        decode(&file(channels, |_| ()))
    }

    #[test]
    fn channels_are_found_by_name_in_any_layout() {
        let rgb = |r, g, b| -> Vec<f32> { [r, g, b].repeat(8) };
        let extra = [("A", 9.0, 9.0), ("B", 3.0, 3.0), ("G", 2.0, 2.0), ("R", 1.0, 1.0), ("depth.Z", 8.0, 8.0)];
        assert_eq!(plain(&extra).unwrap().rgb, rgb(1.0, 2.0, 3.0));
        let map = plain(&[("b", 3.0, 3.0), ("g", 2.0, 2.0), ("r", 1.0, 4.0)]).unwrap();
        assert_eq!((map.width, map.height, &map.rgb[21..]), (4, 2, &[4.0, 2.0, 3.0][..]));
        let layers = [("a.B", 3.0, 3.0), ("a.G", 2.0, 2.0), ("a.R", 1.0, 1.0), ("b.B", 7.0, 7.0), ("b.R", 7.0, 7.0)];
        assert_eq!(plain(&layers).unwrap().rgb, rgb(1.0, 2.0, 3.0));
        assert_eq!(plain(&[("Y", 0.5, 0.5)]).unwrap().rgb, rgb(0.5, 0.5, 0.5));
    }

    #[test]
    fn what_is_no_linear_rgb_is_refused() {
        for channels in [
            &[("X", 1.0, 1.0), ("Y", 1.0, 1.0), ("Z", 1.0, 1.0)][..],
            &[("BY", 1.0, 1.0), ("RY", 1.0, 1.0), ("Y", 1.0, 1.0)],
            &[("G", 1.0, 1.0), ("R", 1.0, 1.0)],
        ] {
            let error = plain(channels).unwrap_err();
            assert!(error.contains("R, G and B, or Y alone are needed") && error.contains(channels[0].0), "{error}");
        }
        let grey = [("Y", 1.0, 1.0)];
        let aces = |image: &mut Image<Layer<AnyChannels<FlatSamples>>>| {
            image.attributes.chromaticities = Some(attribute::Chromaticities {
                red: Vec2(0.713, 0.293),
                green: Vec2(0.165, 0.830),
                blue: Vec2(0.128, 0.044),
                white: Vec2(0.32168, 0.33767),
            });
        };
        assert!(decode(&file(&grey, aces)).unwrap_err().contains("convert it to linear Rec.709"));
        let rec709 = |image: &mut Image<Layer<AnyChannels<FlatSamples>>>| {
            image.attributes.chromaticities = Some(attribute::Chromaticities {
                red: Vec2(0.64, 0.33),
                green: Vec2(0.3, 0.6),
                blue: Vec2(0.15, 0.06),
                white: Vec2(0.3127, 0.329),
            });
        };
        assert!(decode(&file(&grey, rec709)).is_ok());
        let crop =
            |image: &mut Image<Layer<AnyChannels<FlatSamples>>>| image.attributes.display_window.size = Vec2(8, 4);
        assert!(decode(&file(&grey, crop)).unwrap_err().contains("only 4 x 2 of its 8 x 4 pixels"));
    }

    #[test]
    fn values_that_are_no_light_are_refused_with_their_place() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e12] {
            let error = plain(&[("B", 1.0, 1.0), ("G", 1.0, bad), ("R", 1.0, 1.0)]).unwrap_err();
            assert!(error.contains(&format!("it holds {bad} in green at column 3, row 1")), "{error}");
        }
        let error = plain(&[("B", 1.0, 1.0), ("G", 1.0, -1.0), ("R", 1.0, 1.0)]).unwrap_err();
        assert!(error.contains("its luminance is -0.43") && error.contains("at column 3, row 1"), "{error}");
        // A green no screen has: red below 0, and still light.
        assert!(plain(&[("B", 0.1, 0.1), ("G", 1.0, 1.0), ("R", -0.5, -0.5)]).is_ok());
    }

    #[test]
    fn damaged_files_are_refused_not_followed() {
        let whole = file(&[("B", 1.0, 1.0), ("G", 1.0, 1.0), ("R", 1.0, 1.0)], |_| ());
        for length in 0..whole.len() {
            assert!(decode(&whole[..length]).is_err(), "cut at {length} of {}", whole.len());
        }
        // Every byte wrong in turn: refused, or a map of finite values; never a panic or a reservation of gigabytes.
        for at in 0..whole.len() {
            for value in [0x00, 0x7F, 0xFF] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                if let Ok(map) = decode(&bytes) {
                    assert!(map.rgb.iter().all(|v| v.is_finite()) && map.rgb.len() == 3 * map.width * map.height);
                }
            }
        }
    }

    /// A Radiance HDR file: a shared exponent, `mantissa / 256 * 2^(exponent - 128)`.
    fn hdr(header: &str, texels: &[[u8; 4]]) -> Vec<u8> {
        [header.as_bytes(), texels.as_flattened()].concat()
    }

    #[test]
    fn radiance_hdr_is_read() {
        let header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
        let map = decode(&hdr(header, &[[128, 64, 0, 129], [255, 128, 32, 132]])).unwrap();
        assert_eq!((map.width, map.height), (2, 1));
        assert_eq!(map.rgb, [1.0, 0.5, 0.0, 15.9375, 8.0, 2.0]);
        assert!(decode(&hdr(header, &[[128, 64, 0, 129]])).is_err(), "cut short");
        assert!(decode(&hdr("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 2\n", &[])).is_err(), "no rows");
        let huge = hdr("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n", &[]);
        assert!(decode(&huge).unwrap_err().contains("1000000 x 1000000 pixels"));
        assert!(decode(b"\x89PNG\r\n").unwrap_err().contains("neither OpenEXR nor Radiance HDR"));
        assert_eq!(decode(b"").unwrap_err(), "it is empty");
    }
}
