//! Tables of numbers as OpenEXR: any planes of float32 with facts beside them, written and read back bit for bit.

use std::io::{self, BufWriter, Cursor, Write};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::Text;
use exr::prelude::{
    AnyChannel, AnyChannels, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer, Layers, ReadChannels,
    ReadLayers, Vec2, WritableImage,
};

use super::open::facts_of;
use super::picture::{ENCODING, attributes, sort_attributes};
use crate::error::{FileError, Stop};
use crate::facts::Fact;
use crate::limits::check_size;
use crate::whole::write_whole;

/// A file has no more tables than this.
const MOST_TABLES: usize = 1024;

/// Named planes of one size, and facts about them.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What the part of the file is called; no two of a file are called the same.
    pub name: String,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Name and `width * height` values of each plane, rows first.
    pub planes: Vec<(String, Vec<f32>)>,
    /// What the file says besides.
    pub facts: Vec<(String, Fact)>,
}

/// Writes tables, a part of the file each, as a whole EXR file or none.
pub fn write_tables(path: &Path, tables: &[Table], stop: Stop<'_>) -> Result<(), FileError> {
    let image = image_of(tables, stop)?;
    write_whole(path, stop, |out| {
        let mut buffered = BufWriter::new(&mut *out);
        image.write().to_buffered(&mut buffered).map_err(io_error)?;
        buffered.flush()?;
        drop(buffered);
        sort_attributes(out)
    })
}

/// The same file in memory.
pub fn tables_bytes(tables: &[Table]) -> Result<Vec<u8>, FileError> {
    let image = image_of(tables, &|| false)?;
    let mut out = Cursor::new(Vec::new());
    let written = image.write().to_buffered(&mut out).map_err(io_error).and_then(|()| sort_attributes(&mut out));
    written.map_err(|error| FileError::Argument(format!("the tables cannot be written as OpenEXR: {error}")))?;
    Ok(out.into_inner())
}

fn io_error(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(source) => source,
        other => io::Error::other(other.to_string()),
    }
}

/// Tables as parts of an image.
fn image_of(tables: &[Table], stop: Stop<'_>) -> Result<Image<Layers<AnyChannels<FlatSamples>>>, FileError> {
    let most = i32::MAX as usize;
    if !(1..=MOST_TABLES).contains(&tables.len()) {
        return Err(FileError::Argument(format!("a file takes 1 to {MOST_TABLES} tables, got {}", tables.len())));
    }
    let mut layers = Layers::new();
    let mut whole = Vec2(0, 0);
    for table in tables {
        let Table { name, width, height, planes, facts } = table;
        if !(1..=most).contains(width) || !(1..=most).contains(height) || planes.is_empty() {
            return Err(FileError::Argument(format!(
                "a table has planes of 1 to {most} columns and rows, got {} of {width} x {height}",
                planes.len()
            )));
        }
        if let Some((name, values)) = planes.iter().find(|(_, values)| Some(values.len()) != width.checked_mul(*height))
        {
            return Err(FileError::Argument(format!(
                "{name} must hold {width} x {height} values, got {}",
                values.len()
            )));
        }
        if stop() {
            return Err(FileError::Cancelled);
        }
        let channels = planes
            .iter()
            .map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values.clone())))
            .collect();
        let mut attributes = attributes(facts)?;
        let words = Text::new_or_none(name);
        let words = words.ok_or_else(|| FileError::Argument(format!("a part's name is Latin-1, got {name:?}")))?;
        attributes.layer_name = Some(words);
        whole = Vec2(whole.0.max(*width), whole.1.max(*height));
        layers.push(Layer::new(Vec2(*width, *height), attributes, ENCODING, AnyChannels::sort(channels)));
    }
    Ok(Image { attributes: ImageAttributes::new(IntegerBounds::from_dimensions(whole)), layer_data: layers })
}

/// Reads tables from the bytes of an EXR file; facts of other kinds than ours are left out.
pub fn read_tables(bytes: &[u8]) -> Result<Vec<Table>, FileError> {
    let damaged = |error: exr::error::Error| FileError::Argument(format!("damaged or unsupported OpenEXR ({error})"));
    // The headers first: a damaged size must not reserve memory.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    if meta.headers.len() > MOST_TABLES {
        let message = format!("it has {} parts; at most {MOST_TABLES} are read", meta.headers.len());
        return Err(FileError::Argument(message));
    }
    let mut samples = 0_usize;
    for header in &meta.headers {
        let (width, height, channels) = (header.layer_size.x(), header.layer_size.y(), header.channels.list.len());
        // (All parts together are held to what one may hold.)
        samples = samples.saturating_add(width.saturating_mul(height).saturating_mul(channels));
        check_size(width, height, channels).map_err(FileError::Argument)?;
        check_size(samples, 1, 1).map_err(FileError::Argument)?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(damaged)?;
    image.layer_data.iter().map(table_of).collect()
}

fn table_of(layer: &Layer<AnyChannels<FlatSamples>>) -> Result<Table, FileError> {
    let (width, height) = (layer.size.x(), layer.size.y());
    let mut planes = Vec::new();
    for channel in &layer.channel_data.list {
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        if values.len() != width * height {
            let message = format!("its channel {} has fewer values than the table has places", channel.name);
            return Err(FileError::Argument(message));
        }
        planes.push((channel.name.to_string(), values));
    }
    let name = layer.attributes.layer_name.as_ref().map(Text::to_string).unwrap_or_default();
    Ok(Table { name, width, height, planes, facts: facts_of(&layer.attributes) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(name: &str, width: usize) -> Table {
        let values = |k: f32| (0..3 * width).map(|i| (i as f32 * k).sin()).collect();
        Table {
            name: name.into(),
            width,
            height: 3,
            planes: vec![("X".into(), values(0.3)), ("slope.X".into(), values(1.7))],
            facts: vec![
                ("kind".into(), Fact::Text("a table".into())),
                ("least".into(), Fact::Number(0.1)),
                ("rows".into(), Fact::Integer(3)),
            ],
        }
    }

    #[test]
    fn come_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.exr");
        for tables in [vec![table("D65", 4)], vec![table("D65", 4), table("A", 7), table("laser", 2)]] {
            write_tables(&path, &tables, &|| false).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            assert_eq!(read_tables(&bytes).unwrap(), tables);
            // The crate's order of attributes is another one each time.
            for _ in 0..8 {
                write_tables(&path, &tables, &|| false).unwrap();
                assert_eq!(std::fs::read(&path).unwrap(), bytes);
            }
            for cut in [0, 7, 100, bytes.len() / 2, bytes.len() - 1] {
                assert!(read_tables(&bytes[..cut]).is_err(), "{cut}");
            }
        }
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let path = Path::new("/nonexistent/x.exr");
        let good = table("D65", 4);
        let message = |tables: &[Table]| write_tables(path, tables, &|| false).unwrap_err().to_string();
        assert!(message(&[Table { width: 5, ..good.clone() }]).contains("X must hold 5 x 3 values, got 12"));
        assert!(message(&[Table { planes: Vec::new(), ..good.clone() }]).contains("planes"));
        assert!(message(&[Table { height: 0, ..good.clone() }]).contains("rows"));
        assert!(message(&[Table { name: "\u{4e00}".into(), ..good.clone() }]).contains("Latin-1"));
        assert!(message(&[]).contains("1 to 1024 tables"));
        assert!(write_tables(path, std::slice::from_ref(&good), &|| true).is_err());
    }
}
