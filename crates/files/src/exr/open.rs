//! OpenEXR in: the header is held against the limits before anything else is read.

use std::io::Cursor;

use exr::prelude::{AnyChannels, FlatSamples, Image, Layer, ReadChannels, ReadLayers};

use crate::limits::check_size;

/// The first valid layer of an OpenEXR file, checked to be a whole picture of a size that can be read.
pub fn open_exr(bytes: &[u8]) -> Result<Image<Layer<AnyChannels<FlatSamples>>>, String> {
    let damaged = |error: exr::error::Error| format!("damaged or unsupported OpenEXR ({error})");
    // The header first: a damaged size must not reserve memory.
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    for header in &meta.headers {
        check_size(header.layer_size.x(), header.layer_size.y(), header.channels.list.len())?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(damaged)?;
    let layer = &image.layer_data;
    let (width, height) = (layer.size.x(), layer.size.y());
    let whole = image.attributes.display_window;
    if (whole.size, whole.position) != (layer.size, layer.attributes.layer_position) {
        return Err(format!(
            "only {width} x {height} of its {} x {} pixels are stored, or others beyond them; save it whole",
            whole.size.x(),
            whole.size.y()
        ));
    }
    Ok(image)
}
