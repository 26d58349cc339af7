//! OpenEXR out: every plane in float32, and the facts to repeat the render.

use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Chromaticities};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, Text, Vec2, WritableImage,
};
use rayon::prelude::*;

use crate::error::{FileError, Stop};
use crate::facts::{Fact, Facts};
use crate::limits::check_planes;
use crate::space::OutputSpace;
use crate::whole::write_whole;

/// What an EXR holds: borrowed planes of `width * height` pixels, as in `Framebuffer`.
#[derive(Debug, Clone, Copy)]
pub struct Planes<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Relative XYZ, three floats a pixel.
    pub xyz: &'a [f32],
    /// Distance along the ray, scene units; infinite where there is none.
    pub depth: &'a [f32],
    /// Film thickness, nm; NaN off films.
    pub thickness_nm: &'a [f32],
    /// Unit normal, three floats a pixel; zero where there is none.
    pub normal: &'a [f32],
}

/// Single-line ZIP: half the time of 16-line ZIP or PIZ for 7 and 23 % more bytes (a 512 x 512 bubble), and compositors read
/// lines of it by themselves.
pub(super) const ENCODING: Encoding =
    Encoding { compression: Compression::ZIP1, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };

/// Writes the planes as a whole EXR file or none: scan lines, each ZIP-compressed by itself, 32-bit floats.
///
/// | channels | what |
/// |---|---|
/// | `R` `G` `B` | linear Rec.709, D65, of the XYZ: what every viewer shows; negative and large values kept |
/// | `XYZ.X` `XYZ.Y` `XYZ.Z` | relative XYZ as computed. A layer of its own: plain `Y` would mean luminance, plain `Z` depth |
/// | `depth.Z` | distance along the ray |
/// | `thickness_nm` | film thickness |
/// | `normal.X` `normal.Y` `normal.Z` | normal in world axes |
///
/// No exposure is applied. The standard attributes `chromaticities` and `software` are set; facts become attributes of
/// their own name (`string`, `int`, `double`), `Software` the standard one.
pub fn write_exr(path: &Path, planes: &Planes<'_>, facts: &Facts, stop: Stop<'_>) -> Result<(), FileError> {
    let Planes { width, height, xyz, depth, thickness_nm, normal } = *planes;
    check_planes(
        width,
        height,
        &[
            ("xyz", xyz.len(), 3),
            ("depth", depth.len(), 1),
            ("thickness_nm", thickness_nm.len(), 1),
            ("normal", normal.len(), 3),
        ],
    )?;
    if width.max(height) > i32::MAX as u32 {
        return Err(FileError::Argument(format!(
            "an EXR has at most {} pixels a side, got {width} x {height}",
            i32::MAX
        )));
    }
    let attributes = attributes(facts)?;

    let third = |values: &[f32], i: usize| -> Vec<f32> { values.par_chunks_exact(3).map(|v| v[i]).collect() };
    let linear = |row: [f64; 3]| -> Vec<f32> {
        let dot = |v: &[f32]| (0..3).map(|c| row[c] * f64::from(v[c])).sum::<f64>() as f32;
        xyz.par_chunks_exact(3).map(dot).collect()
    };
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    let mut add = |name: &str, values: &dyn Fn() -> Vec<f32>| {
        if stop() {
            return Err(FileError::Cancelled);
        }
        channels.push(AnyChannel::new(name, FlatSamples::F32(values())));
        Ok(())
    };
    let rows = OutputSpace::Srgb.rgb_from_xyz();
    for (i, (colour, axis)) in ["R", "G", "B"].into_iter().zip(["X", "Y", "Z"]).enumerate() {
        add(colour, &|| linear(rows[i]))?;
        add(&format!("XYZ.{axis}"), &|| third(xyz, i))?;
        add(&format!("normal.{axis}"), &|| third(normal, i))?;
    }
    add("depth.Z", &|| depth.to_vec())?;
    add("thickness_nm", &|| thickness_nm.to_vec())?;

    let size = Vec2(width as usize, height as usize);
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

    struct Picture {
        xyz: Vec<f32>,
        depth: Vec<f32>,
        thickness_nm: Vec<f32>,
        normal: Vec<f32>,
    }

    const WIDTH: u32 = 20;
    const HEIGHT: u32 = 37;

    fn picture() -> Picture {
        let pixels = (WIDTH * HEIGHT) as usize;
        let ramp = |n: usize, k: f32| (0..n).map(|i| (i as f32 * k).sin() * 2.0).collect::<Vec<_>>();
        let mut picture = Picture {
            xyz: ramp(3 * pixels, 0.11),
            depth: ramp(pixels, 0.3),
            thickness_nm: ramp(pixels, 0.7),
            normal: ramp(3 * pixels, 0.05),
        };
        picture.depth[3] = f32::INFINITY;
        picture.thickness_nm[3] = f32::NAN;
        picture
    }

    fn planes(picture: &Picture) -> Planes<'_> {
        Planes {
            width: WIDTH,
            height: HEIGHT,
            xyz: &picture.xyz,
            depth: &picture.depth,
            thickness_nm: &picture.thickness_nm,
            normal: &picture.normal,
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
        let short = Planes { depth: &picture.depth[1..], ..planes(&picture) };
        let message = write_exr(path, &short, &[], &|| false).unwrap_err().to_string();
        assert!(message.contains("depth must hold 740 values for 20 x 37 pixels, got 739"), "{message}");
        let facts = [("scene".to_owned(), Fact::Text("泡".into()))];
        assert!(write_exr(path, &planes(&picture), &facts, &|| false).unwrap_err().to_string().contains("Latin-1"));
        let nameless = [(String::new(), Fact::Integer(1))];
        assert!(write_exr(path, &planes(&picture), &nameless, &|| false).unwrap_err().to_string().contains("name"));
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
