//! OpenEXR out: the colours, any planes beside them, and the facts to repeat the render.

use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Chromaticities};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, Text, Vec2, WritableImage, f16,
};
use rayon::prelude::*;

use crate::error::{FileError, Stop};
use crate::facts::{Fact, Facts};
use crate::limits::check_planes;
use crate::space::OutputSpace;
use crate::whole::write_whole;

/// One plane of a picture, in as many channels of the file as it has components.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane<'a> {
    /// What the channel of each component is called: `depth.Z`, or `normal.X`, `normal.Y`, `normal.Z`.
    pub channels: Vec<String>,
    /// Its numbers, those of a pixel beside one another.
    pub values: Values<'a>,
}

/// The numbers of a plane, borrowed, and how they are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values<'a> {
    /// 32-bit floats.
    Single(&'a [f32]),
    /// 16-bit floats: three digits, and nothing beyond 65504, where they end.
    Half(&'a [f32]),
    /// Counts.
    Whole(&'a [u32]),
}

/// What an EXR holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Relative XYZ, three floats a pixel.
    pub xyz: &'a [f32],
    /// Whether the colours are stored in half floats.
    pub is_half: bool,
    /// All other planes; no two channels of a file are called the same.
    pub planes: Vec<Plane<'a>>,
}

/// Single-line ZIP: half the time of 16-line ZIP or PIZ for 7 and 23 % more bytes (a 512 x 512 bubble), and compositors read
/// lines of it by themselves.
pub(super) const ENCODING: Encoding =
    Encoding { compression: Compression::ZIP1, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };

/// Writes a picture as a whole EXR file or none: scan lines, each ZIP-compressed by itself.
///
/// Beside the channels of the planes there are
///
/// | channels | what |
/// |---|---|
/// | `R` `G` `B` | linear Rec.709, D65, of the XYZ: what every viewer shows; negative and large values kept |
/// | `XYZ.X` `XYZ.Y` `XYZ.Z` | relative XYZ as computed. A layer of its own: plain `Y` would mean luminance, plain `Z` depth |
///
/// No exposure is applied. The standard attributes `chromaticities` and `software` are set; facts become attributes of
/// their own name (`string`, `int`, `double`), `Software` the standard one.
pub fn write_exr(path: &Path, picture: &Picture<'_>, facts: &Facts, stop: Stop<'_>) -> Result<(), FileError> {
    check(picture)?;
    let attributes = attributes(facts)?;
    let channels = channels(picture, stop)?;
    let size = Vec2(picture.width as usize, picture.height as usize);
    let layer = Layer::new(size, attributes, ENCODING, AnyChannels::sort(channels));
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(rec709());
    write_whole(path, stop, |out| {
        let mut buffered = BufWriter::new(&mut *out);
        let written = image.write().to_buffered(&mut buffered);
        written.map_err(|error| match error {
            exr::error::Error::Io(source) => source,
            other => io::Error::other(other.to_string()),
        })?;
        buffered.flush()?;
        drop(buffered);
        sort_attributes(out)
    })
}

/// Refuses planes of other sizes than the picture's, and pictures that no EXR holds.
fn check(picture: &Picture<'_>) -> Result<(), FileError> {
    let Picture { width, height, xyz, ref planes, .. } = *picture;
    let mut sizes = vec![("xyz", xyz.len(), 3)];
    for plane in planes {
        let length = match plane.values {
            Values::Single(values) | Values::Half(values) => values.len(),
            Values::Whole(values) => values.len(),
        };
        let first = plane.channels.first();
        let first = first.ok_or_else(|| FileError::Argument("a plane has one channel at least".into()))?;
        sizes.push((first, length, plane.channels.len()));
    }
    check_planes(width, height, &sizes)?;
    if width.max(height) > i32::MAX as u32 {
        return Err(FileError::Argument(format!(
            "an EXR has at most {} pixels a side, got {width} x {height}",
            i32::MAX
        )));
    }
    Ok(())
}

/// Refuses a channel's name that another has, or that the format cannot hold.
fn check_name(name: &str, channels: &[AnyChannel<FlatSamples>]) -> Result<(), FileError> {
    if channels.iter().any(|channel| channel.name == *name) {
        return Err(FileError::Argument(format!("two channels of an EXR are called {name:?}")));
    }
    if name.is_empty() || name.len() > 255 || Text::new_or_none(name).is_none() {
        return Err(FileError::Argument(format!("a channel's name has 1 to 255 Latin-1 letters, got {name:?}")));
    }
    Ok(())
}

/// Every channel: linear Rec.709, XYZ, then the planes.
fn channels(picture: &Picture<'_>, stop: Stop<'_>) -> Result<SmallVec<[AnyChannel<FlatSamples>; 4]>, FileError> {
    let Picture { xyz, is_half, ref planes, .. } = *picture;
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    let mut add = |name: &str, values: &dyn Fn() -> FlatSamples| {
        if stop() {
            return Err(FileError::Cancelled);
        }
        check_name(name, &channels)?;
        channels.push(AnyChannel::new(name, values()));
        Ok(())
    };
    let floats = |values: Vec<f32>, is_half: bool| {
        if is_half { FlatSamples::F16(halves(&values)) } else { FlatSamples::F32(values) }
    };
    let third = |i: usize| -> Vec<f32> { xyz.par_chunks_exact(3).map(|v| v[i]).collect() };
    let linear = |row: [f64; 3]| -> Vec<f32> {
        let dot = |v: &[f32]| (0..3).map(|c| row[c] * f64::from(v[c])).sum::<f64>() as f32;
        xyz.par_chunks_exact(3).map(dot).collect()
    };
    let rows = OutputSpace::Srgb.rgb_from_xyz();
    for (i, (colour, axis)) in ["R", "G", "B"].into_iter().zip(["X", "Y", "Z"]).enumerate() {
        add(colour, &|| floats(linear(rows[i]), is_half))?;
        add(&format!("XYZ.{axis}"), &|| floats(third(i), is_half))?;
    }
    for plane in planes {
        let components = plane.channels.len();
        for (i, name) in plane.channels.iter().enumerate() {
            add(name, &|| match plane.values {
                Values::Single(values) => floats(component(values, components, i), false),
                Values::Half(values) => floats(component(values, components, i), true),
                Values::Whole(values) => FlatSamples::U32(component(values, components, i)),
            })?;
        }
    }
    Ok(channels)
}

/// One component of every pixel.
fn component<T: Copy + Send + Sync>(values: &[T], of: usize, i: usize) -> Vec<T> {
    if of == 1 { values.to_vec() } else { values.par_chunks_exact(of).map(|v| v[i]).collect() }
}

/// The nearest half floats. What lies beyond the largest becomes the largest: a sun is very bright, not infinite. (An
/// infinity that was one stays one.)
fn halves(values: &[f32]) -> Vec<f16> {
    let half = |value: &f32| {
        f16::from_f32(if value.is_finite() { value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()) } else { *value })
    };
    values.par_iter().map(half).collect()
}

fn rec709() -> Chromaticities {
    Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    }
}

pub(super) fn attributes(facts: &Facts) -> Result<LayerAttributes, FileError> {
    let mut attributes = LayerAttributes::default();
    for (name, fact) in facts {
        let text = |text: &str| {
            Text::new_or_none(text).ok_or_else(|| {
                FileError::Argument(format!("{name} must be Latin-1 text for an EXR attribute, got {text:?}"))
            })
        };
        if name.is_empty() || name.len() > 255 || name.contains('\0') {
            return Err(FileError::Argument(format!("an EXR attribute's name has 1 to 255 characters, got {name:?}")));
        }
        let value = match fact {
            Fact::Text(words) if name == "Software" => {
                attributes.software_name = Some(text(words)?);
                continue;
            }
            Fact::Text(words) => AttributeValue::Text(text(words)?),
            Fact::Integer(value) => AttributeValue::I32(*value),
            Fact::Number(value) => AttributeValue::F64(*value),
        };
        attributes.other.insert(text(name)?, value);
    }
    Ok(attributes)
}

/// Puts the attributes of each written header into the order of their names.
///
/// The `exr` crate keeps them in a hash map with random keys, so that two writes of the same image differ; the same
/// render shall give the same bytes. Nothing after the headers moves: their length stays the same.
pub(super) fn sort_attributes(file: &mut (impl Read + Write + Seek)) -> io::Result<()> {
    const START: u64 = 8; // magic number and version
    const MULTI_PART: u32 = 0x1000; // the flag, beside the version, of a list of headers that an empty one ends
    file.seek(SeekFrom::Start(START - 4))?;
    let mut reader = io::BufReader::new(&mut *file);
    let mut version = [0; 4];
    reader.read_exact(&mut version)?;
    let has_parts = u32::from_le_bytes(version) & MULTI_PART != 0;
    let mut sorted: Vec<u8> = Vec::new();
    loop {
        let attributes = header(&mut reader)?;
        let is_end = attributes.is_empty();
        sorted.extend(attributes.concat());
        if is_end || !has_parts {
            break;
        }
        sorted.push(0);
    }
    file.seek(SeekFrom::Start(START))?;
    file.write_all(&sorted)
}

/// The attributes of one header in the order of their names, each with its name, type, size and value.
fn header(reader: &mut impl io::BufRead) -> io::Result<Vec<Vec<u8>>> {
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    loop {
        // name, 0, type, 0, size (u32, little-endian), value; an empty name ends the header.
        let mut bytes = Vec::new();
        reader.read_until(0, &mut bytes)?;
        if bytes.len() <= 1 {
            break;
        }
        reader.read_until(0, &mut bytes)?;
        let mut size = [0; 4];
        reader.read_exact(&mut size)?;
        bytes.extend(size);
        reader.by_ref().take(u64::from(u32::from_le_bytes(size))).read_to_end(&mut bytes)?;
        attributes.push(bytes);
    }
    attributes.sort();
    Ok(attributes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    struct Made {
        samples: Vec<u32>,
        xyz: Vec<f32>,
        depth: Vec<f32>,
        thickness_nm: Vec<f32>,
        normal: Vec<f32>,
    }

    const WIDTH: u32 = 20;
    const HEIGHT: u32 = 37;

    fn picture() -> Made {
        let pixels = (WIDTH * HEIGHT) as usize;
        let ramp = |n: usize, k: f32| (0..n).map(|i| (i as f32 * k).sin() * 2.0).collect::<Vec<_>>();
        let mut picture = Made {
            samples: (0..pixels as u32).map(|i| i << 20).collect(),
            xyz: ramp(3 * pixels, 0.11),
            depth: ramp(pixels, 0.3),
            thickness_nm: ramp(pixels, 0.7),
            normal: ramp(3 * pixels, 0.05),
        };
        picture.depth[3] = f32::INFINITY;
        picture.thickness_nm[3] = f32::NAN;
        picture
    }

    fn planes(made: &Made) -> Picture<'_> {
        let plane =
            |names: &[&str], values| Plane { channels: names.iter().map(ToString::to_string).collect(), values };
        Picture {
            width: WIDTH,
            height: HEIGHT,
            xyz: &made.xyz,
            is_half: false,
            planes: vec![
                plane(&["depth.Z"], Values::Single(&made.depth)),
                plane(&["thickness_nm"], Values::Single(&made.thickness_nm)),
                plane(&["normal.X", "normal.Y", "normal.Z"], Values::Single(&made.normal)),
                plane(&["samples"], Values::Whole(&made.samples)),
            ],
        }
    }

    fn facts() -> Vec<(String, Fact)> {
        vec![
            ("Software".to_owned(), Fact::Text("iridesce 0".into())),
            ("scene".to_owned(), Fact::Text("{\"version\": 1}".into())),
            ("samples".to_owned(), Fact::Integer(64)),
            ("seed".to_owned(), Fact::Text(u64::MAX.to_string())),
            ("exposure".to_owned(), Fact::Number(0.5)),
            ("simd".to_owned(), Fact::Text("avx2".into())),
        ]
    }

    #[test]
    fn planes_and_facts_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.exr");
        let picture = picture();
        write_exr(&path, &planes(&picture), &facts(), &|| false).unwrap();
        let read = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
        let layer = &read.layer_data[0];
        assert_eq!(layer.size, Vec2(WIDTH as usize, HEIGHT as usize));
        let channel = |name: &str| -> Vec<f32> {
            let found = layer.channel_data.list.iter().find(|c| c.name == *name).unwrap_or_else(|| panic!("no {name}"));
            let FlatSamples::F32(values) = &found.sample_data else { panic!("{name} is not float32") };
            values.clone()
        };
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        for (i, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
            let every_third = |values: &[f32]| values.iter().copied().skip(i).step_by(3).collect::<Vec<_>>();
            assert_eq!(channel(&format!("XYZ.{axis}")), every_third(&picture.xyz));
            assert_eq!(channel(&format!("normal.{axis}")), every_third(&picture.normal));
        }
        let counts = layer.channel_data.list.iter().find(|c| c.name == *"samples").unwrap();
        assert_eq!(counts.sample_data, FlatSamples::U32(picture.samples.clone()));
        assert_eq!(bits(&channel("depth.Z")), bits(&picture.depth));
        assert_eq!(bits(&channel("thickness_nm")), bits(&picture.thickness_nm));
        // Luminance of linear Rec.709 is the Y it came from (coefficients of IEC 61966-2-1, four digits).
        let (r, g, b) = (channel("R"), channel("G"), channel("B"));
        for (i, y) in picture.xyz.iter().skip(1).step_by(3).enumerate() {
            assert!((0.2126 * r[i] + 0.7152 * g[i] + 0.0722 * b[i] - y).abs() < 1e-3);
        }
        assert_eq!(read.attributes.chromaticities, Some(rec709()));
        assert_eq!(layer.attributes.software_name, Some(Text::from("iridesce 0")));
        let other = |name: &str| layer.attributes.other[&Text::from(name)].clone();
        assert_eq!(other("samples"), AttributeValue::I32(64));
        assert_eq!(other("seed"), AttributeValue::Text(Text::from("18446744073709551615")));
        assert_eq!(other("exposure"), AttributeValue::F64(0.5));
        assert_eq!(other("scene"), AttributeValue::Text(Text::from("{\"version\": 1}")));
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let picture = picture();
        let files: Vec<_> = (0..4)
            .map(|i| {
                let path = folder.path().join(format!("{i}.exr"));
                write_exr(&path, &planes(&picture), &facts(), &|| false).unwrap();
                fs::read(path).unwrap()
            })
            .collect();
        assert!(files.iter().all(|f| *f == files[0]));
    }

    #[test]
    fn wrong_shapes_and_facts_are_refused() {
        let picture = picture();
        let path = Path::new("/nonexistent/x.exr");
        let mut short = planes(&picture);
        short.planes[0].values = Values::Single(&picture.depth[1..]);
        let message = write_exr(path, &short, &[], &|| false).unwrap_err().to_string();
        assert!(message.contains("depth.Z must hold 740 values for 20 x 37 pixels, got 739"), "{message}");
        let facts = [("scene".to_owned(), Fact::Text("泡".into()))];
        assert!(write_exr(path, &planes(&picture), &facts, &|| false).unwrap_err().to_string().contains("Latin-1"));
        let nameless = [(String::new(), Fact::Integer(1))];
        assert!(write_exr(path, &planes(&picture), &nameless, &|| false).unwrap_err().to_string().contains("name"));
        for wrong in ["XYZ.Y", "depth.Z", "", "泡"] {
            let mut named = planes(&picture);
            named.planes[1].channels[0] = wrong.into();
            let message = write_exr(path, &named, &[], &|| false).unwrap_err().to_string();
            assert!(message.contains("called") || message.contains("letters"), "{wrong}: {message}");
        }
    }

    #[test]
    fn halves_are_the_nearest_and_stay_finite() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.exr");
        let mut picture = picture();
        picture.xyz[0] = 1e6;
        picture.depth[5] = 1e9;
        let mut planes = planes(&picture);
        planes.is_half = true;
        planes.planes[0].values = Values::Half(&picture.depth);
        write_exr(&path, &planes, &facts(), &|| false).unwrap();
        let read = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
        let channel = |name: &str| {
            let list = &read.layer_data[0].channel_data.list;
            list.iter().find(|c| c.name == *name).unwrap().sample_data.clone()
        };
        let (FlatSamples::F16(x), FlatSamples::F16(depth)) = (channel("XYZ.X"), channel("depth.Z")) else {
            panic!("not half floats")
        };
        assert!(matches!(channel("R"), FlatSamples::F16(_)) && matches!(channel("thickness_nm"), FlatSamples::F32(_)));
        assert_eq!((x[0].to_f32(), depth[5].to_f32(), depth[3].to_f32()), (65504.0, 65504.0, f32::INFINITY));
        for (half, single) in x.iter().zip(picture.xyz.iter().step_by(3)).skip(1) {
            // Half the last of 11 binary digits.
            assert!((half.to_f32() - single).abs() <= single.abs() / 2048.0, "{half} {single}");
        }
    }

    #[test]
    fn a_stop_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let picture = picture();
        let result = write_exr(&folder.path().join("x.exr"), &planes(&picture), &[], &|| true);
        assert!(matches!(result, Err(FileError::Cancelled)));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
