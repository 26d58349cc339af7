//! OpenEXR: floats in nm, in the channel `thickness_nm`, or else `Y`, `R` or the first.

use std::io::Cursor;

use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};
use iridesce_thickness::ThicknessMap;

use super::{Plane, Samples};
use crate::exr::open_exr;

/// The channel that thickness maps and rendered pictures call so.
const CHANNEL: &str = "thickness_nm";

pub fn read(bytes: &[u8]) -> Result<Plane, String> {
    let layer = open_exr(bytes)?.layer_data;
    let (width, height) = (layer.size.x(), layer.size.y());
    let channels = &layer.channel_data.list;
    // Also in a named layer: `film.thickness_nm`.
    let find = |wanted: &str| {
        channels.iter().find(|channel| {
            let name = channel.name.to_string();
            name.rsplit('.').next().is_some_and(|last| last.eq_ignore_ascii_case(wanted))
        })
    };
    let channel = [CHANNEL, "Y", "R"].into_iter().find_map(find).or(channels.first()).ok_or("it has no channels")?;
    if matches!(channel.sample_data, FlatSamples::U32(_)) {
        return Err(format!("its channel {} holds whole numbers; floats (nm) are read", channel.name));
    }
    let values: Vec<f64> = channel.sample_data.values_as_f32().map(f64::from).collect();
    if values.len() != width * height {
        return Err(format!("its channel {} has fewer values than the picture has pixels", channel.name));
    }
    Ok(Plane { width, height, samples: Samples::Nanometres(values) })
}

/// A map as an OpenEXR file: one channel `thickness_nm` of single-precision floats.
pub fn thickness_exr(map: &ThicknessMap) -> Result<Vec<u8>, String> {
    let values: Vec<f32> = map.thickness_nm().iter().map(|&v| v as f32).collect();
    let channels = AnyChannels::sort([AnyChannel::new(CHANNEL, FlatSamples::F32(values))].into_iter().collect());
    let encoding = Encoding::SMALL_LOSSLESS;
    let layer = Layer::new((map.width(), map.height()), LayerAttributes::default(), encoding, channels);
    let mut bytes = Vec::new();
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|e| format!("the map cannot be written as OpenEXR: {e}"))?;
    Ok(bytes)
}
