//! Tables of numbers as OpenEXR: any planes of float32 with facts beside them, written and read back bit for bit.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use exr::meta::attribute::AttributeValue;
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, Layer, Vec2, WritableImage};
use iridesce_scene::open_exr;

use super::exr_file::{ENCODING, attributes, sort_attributes};
use super::whole_file::write_whole;
use super::{Fact, ImageError, Stop};

/// Named planes of one size, and facts about them.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Name and `width * height` values of each plane, rows first.
    pub planes: Vec<(String, Vec<f32>)>,
    /// What the file says besides.
    pub facts: Vec<(String, Fact)>,
}

/// Writes a table as a whole EXR file or none.
pub fn write_table(path: &Path, table: &Table, stop: Stop<'_>) -> Result<(), ImageError> {
    let Table { width, height, planes, facts } = table;
    let most = i32::MAX as usize;
    if !(1..=most).contains(width) || !(1..=most).contains(height) || planes.is_empty() {
        return Err(ImageError::Argument(format!(
            "a table has planes of 1 to {most} columns and rows, got {} of {width} x {height}",
            planes.len()
        )));
    }
    if let Some((name, values)) = planes.iter().find(|(_, values)| Some(values.len()) != width.checked_mul(*height)) {
        return Err(ImageError::Argument(format!("{name} must hold {width} x {height} values, got {}", values.len())));
    }
    let channels =
        planes.iter().map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values.clone()))).collect();
    let layer = Layer::new(Vec2(*width, *height), attributes(facts)?, ENCODING, AnyChannels::sort(channels));
    let image = Image::from_layer(layer);
    write_whole(path, stop, |out| {
        let mut buffered = BufWriter::new(&mut *out);
        image.write().to_buffered(&mut buffered).map_err(|error| match error {
            exr::error::Error::Io(source) => source,
            other => io::Error::other(other.to_string()),
        })?;
        buffered.flush()?;
        drop(buffered);
        sort_attributes(out)
    })
}

/// Reads a table from the bytes of an EXR file; facts of other kinds than ours are left out.
pub fn read_table(bytes: &[u8]) -> Result<Table, ImageError> {
    let layer = open_exr(bytes).map_err(ImageError::Argument)?.layer_data;
    let (width, height) = (layer.size.x(), layer.size.y());
    let mut planes = Vec::new();
    for channel in &layer.channel_data.list {
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        if values.len() != width * height {
            let message = format!("its channel {} has fewer values than the table has places", channel.name);
            return Err(ImageError::Argument(message));
        }
        planes.push((channel.name.to_string(), values));
    }
    let mut facts: Vec<(String, Fact)> = Vec::new();
    for (name, value) in &layer.attributes.other {
        let fact = match value {
            AttributeValue::Text(text) => Fact::Text(text.to_string()),
            AttributeValue::I32(value) => Fact::Integer(*value),
            AttributeValue::F64(value) => Fact::Number(*value),
            _ => continue,
        };
        facts.push((name.to_string(), fact));
    }
    facts.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(Table { width, height, planes, facts })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let values = |k: f32| (0..12).map(|i| (i as f32 * k).sin()).collect();
        Table {
            width: 4,
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
    fn comes_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.exr");
        write_table(&path, &table(), &|| false).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(read_table(&bytes).unwrap(), table());
        write_table(&path, &table(), &|| false).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
        for cut in [0, 7, 100, bytes.len() - 1] {
            assert!(read_table(&bytes[..cut]).is_err(), "{cut}");
        }
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let path = Path::new("/nonexistent/x.exr");
        let message = |table| write_table(path, &table, &|| false).unwrap_err().to_string();
        assert!(message(Table { width: 5, ..table() }).contains("X must hold 5 x 3 values, got 12"));
        assert!(message(Table { planes: Vec::new(), ..table() }).contains("planes"));
        assert!(message(Table { height: 0, ..table() }).contains("rows"));
    }
}
