//! OpenEXR in: headers are held against the limits and the bytes that are there before anything else is read; channels are
//! found by name, wherever they are.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, Chromaticities, EnvironmentMap, SampleType};
use exr::meta::header::Header;
use exr::prelude::{AnyChannels, Compression, FlatSamples, Image, LayerAttributes, Layers, ReadChannels, ReadLayers};
use iridesce_numerics::Watch;

use crate::facts::Fact;
use crate::input::Input;
use crate::limits::{check_ratio, check_size, room};
use crate::words::{harmless, listed, quoted};

/// Most parts of a file.
const MOST_PARTS: usize = 1024;

/// One channel of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// `part:layer.channel`, without the part where there is only one.
    pub name: String,
    /// `layer.channel`.
    pub short: String,
    /// Place of its part.
    pub part: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row after row.
    pub values: Vec<f32>,
    /// Whether its numbers are whole.
    pub is_whole: bool,
}

impl Channel {
    /// The name without its layers: `Z` of `depth.Z`.
    pub fn last(&self) -> &str {
        self.short.rsplit('.').next().unwrap_or(&self.short)
    }

    /// The layer before it, with its dot, and its part.
    pub fn layer(&self) -> (usize, &str) {
        (self.part, &self.short[..self.short.len() - self.last().len()])
    }
}

/// Everything that a file holds of flat pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenExr {
    /// Every channel of every part.
    pub channels: Vec<Channel>,
    /// Primaries and white, where the file states them.
    pub chromaticities: Option<Chromaticities>,
    /// Whether a part says that it is a cube map.
    pub is_cube: bool,
    /// Whether a part says that it is a latitude-longitude map.
    pub is_latlong: bool,
    /// Attributes of the first part that are words or numbers, by their names.
    pub facts: Vec<(String, Fact)>,
}

/// All channels of an OpenEXR file, each part checked to be a whole picture of a size that can be read.
pub fn open_exr(bytes: &[u8], watch: &Watch) -> Result<OpenExr, String> {
    let damaged = |error: exr::error::Error| damaged(&error);
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    check_headers(&meta.headers, bytes.len())?;
    let image: Image<Layers<AnyChannels<FlatSamples>>> = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Input::new(bytes, watch))
        .map_err(damaged)?;
    let whole = image.attributes.display_window;
    let several = image.layer_data.len() > 1;
    let mut open = OpenExr {
        channels: Vec::new(),
        chromaticities: image.attributes.chromaticities,
        is_cube: false,
        is_latlong: false,
        facts: Vec::new(),
    };
    for (part, layer) in image.layer_data.into_iter().enumerate() {
        let (width, height) = (layer.size.x(), layer.size.y());
        if (whole.size, whole.position) != (layer.size, layer.attributes.layer_position) {
            return Err(format!(
                "only {width} x {height} of its {} x {} pixels are stored, or others beyond them; save it whole",
                whole.size.x(),
                whole.size.y()
            ));
        }
        match layer.attributes.environment_map {
            Some(EnvironmentMap::Cube) => open.is_cube = true,
            Some(EnvironmentMap::LatitudeLongitude) => open.is_latlong = true,
            None => {}
        }
        if part == 0 {
            open.facts = facts_of(&layer.attributes);
        }
        let called = layer.attributes.layer_name.as_ref().map_or_else(|| part.to_string(), ToString::to_string);
        for channel in layer.channel_data.list {
            watch.check().map_err(|stopped| stopped.to_string())?;
            let short = channel.name.to_string();
            let name = if several { format!("{called}:{short}") } else { short.clone() };
            // A subsampled channel has fewer values than the picture has pixels.
            if channel.sample_data.len() != width * height {
                return Err(format!("its channel {} has fewer values than the picture has pixels", quoted(&short)));
            }
            let (values, is_whole) = floats(channel.sample_data);
            open.channels.push(Channel { name, short, part, width, height, values, is_whole });
        }
    }
    if open.channels.is_empty() {
        return Err("it has no channels".into());
    }
    Ok(open)
}

/// The values of a channel, and whether they are whole numbers.
fn floats(samples: FlatSamples) -> (Vec<f32>, bool) {
    let is_whole = matches!(samples, FlatSamples::U32(_));
    let values = match samples {
        FlatSamples::F32(values) => values,
        other => other.values_as_f32().collect(),
    };
    (values, is_whole)
}

/// What the attributes of a part say; those of other kinds than ours are left out.
pub(super) fn facts_of(attributes: &LayerAttributes) -> Vec<(String, Fact)> {
    let other = attributes.other.iter().filter_map(|(name, value)| {
        let fact = match value {
            AttributeValue::Text(text) => Fact::Text(text.to_string()),
            AttributeValue::I32(value) => Fact::Integer(*value),
            AttributeValue::F64(value) => Fact::Number(*value),
            _ => return None,
        };
        Some((name.to_string(), fact))
    });
    let software = attributes.software_name.iter().map(|name| ("Software".to_owned(), Fact::Text(name.to_string())));
    let mut facts: Vec<(String, Fact)> = other.chain(software).collect();
    facts.sort_by(|a, b| a.0.cmp(&b.0));
    facts
}

fn damaged(error: &exr::error::Error) -> String {
    format!("damaged or unsupported OpenEXR ({})", harmless(&error.to_string()))
}

/// Sizes against the limits, and against the bytes that follow: a damaged header must not reserve memory.
fn check_headers(headers: &[Header], length: usize) -> Result<(), String> {
    if headers.len() > MOST_PARTS {
        return Err(format!("it has {} parts; at most {MOST_PARTS} are read", headers.len()));
    }
    let (mut samples, mut bytes) = (0_usize, 0_u64);
    for header in headers {
        if header.deep {
            return Err("it holds deep data (several samples a pixel); save it flat".into());
        }
        let (width, height) = (header.layer_size.x(), header.layer_size.y());
        let count = header.channels.list.len();
        check_size(width, height, count)?;
        samples = samples.saturating_add(width.saturating_mul(height).saturating_mul(count));
        // All parts together are held to what one may hold.
        check_size(samples, 1, 1)?;
        let of_type = |kind: SampleType| if kind == SampleType::F16 { 2_u64 } else { 4 };
        let a_pixel: u64 = header.channels.list.iter().map(|channel| of_type(channel.sample_type)).sum();
        let raw = (width as u64).saturating_mul(height as u64).saturating_mul(a_pixel);
        bytes = bytes.saturating_add(raw);
        // Each chunk has its place in a table (8 bytes) and a head of its own (8 bytes at least).
        if header.chunk_count.saturating_mul(16) > length {
            return Err(format!(
                "damaged OpenEXR: {} blocks of pixels need {} bytes, the file has {length}",
                header.chunk_count,
                header.chunk_count.saturating_mul(16)
            ));
        }
        if header.compression == Compression::Uncompressed {
            check_ratio(raw, length as u64, 1, "OpenEXR")?;
        }
    }
    // Deflate, the strongest of its compressions whose ratio is known, gives 1032 bytes for one; PIZ of an even picture more.
    check_ratio(bytes, length as u64, 32 * 1032, "OpenEXR")?;
    // (The decoder's own planes, and ours in single precision.)
    room(bytes.saturating_add(4 * samples as u64))
}

impl OpenExr {
    /// The channel that a user named: wholly (`part:layer.channel`), or by as much of the end as tells it from the others.
    pub fn named(&self, asked: &str) -> Result<usize, String> {
        let fits: [&dyn Fn(&Channel) -> bool; 4] = [
            &|channel| channel.name == asked,
            &|channel| channel.short == asked,
            &|channel| channel.name.eq_ignore_ascii_case(asked) || channel.short.eq_ignore_ascii_case(asked),
            &|channel| channel.last().eq_ignore_ascii_case(asked),
        ];
        for fit in fits {
            let found: Vec<usize> = (0..self.channels.len()).filter(|&place| fit(&self.channels[place])).collect();
            match found.as_slice() {
                [] => {}
                &[place] => return Ok(place),
                several => {
                    return Err(format!(
                        "{} channels are called {}; say which: channel = {}",
                        several.len(),
                        quoted(asked),
                        listed(several.iter().map(|&place| self.channels[place].name.as_str()))
                    ));
                }
            }
        }
        Err(format!("it has no channel {}; there are {}", quoted(asked), self.list()))
    }

    /// All channels in words.
    pub fn list(&self) -> String {
        listed(self.channels.iter().map(|channel| channel.name.as_str()))
    }

    /// How many parts hold channels.
    pub fn parts(&self) -> usize {
        self.channels.iter().map(|channel| channel.part).max().map_or(0, |last| last + 1)
    }
}
