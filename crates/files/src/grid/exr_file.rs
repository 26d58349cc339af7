//! OpenEXR: floats in nm, in the channel that the caller names, or the only one that can be meant.

use std::io::Cursor;

use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};
use iridesce_numerics::Watch;
use iridesce_thickness::ThicknessMap;

use super::plane::{MapOf, Plane, Samples, Sought, no_page};
use crate::exr::{OpenExr, open_exr};
use crate::report::ReadReport;
use crate::words::quoted;

/// The channel that thickness maps and rendered pictures call so.
const CHANNEL: &str = "thickness_nm";
/// Names of a channel, the surest first; `Z` only as it stands, without a layer: `depth.Z` is no thickness.
fn names(of: MapOf) -> &'static [&'static str] {
    match of {
        MapOf::Thickness => &[CHANNEL, "thickness", "Z"],
        MapOf::Roughness => &["roughness"],
        MapOf::Height => &["height", "displacement", "Z"],
    }
}

pub fn read(bytes: &[u8], sought: &Sought<'_>, watch: &Watch, report: &mut ReadReport) -> Result<Plane, String> {
    no_page(sought, "OpenEXR")?;
    let mut open = open_exr(bytes, watch)?;
    let (place, why) = match sought.channel {
        Some(asked) => (open.named(asked)?, "channel ="),
        None => only(&open, sought.of)?,
    };
    let others: Vec<String> =
        open.channels.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, c)| c.name.clone()).collect();
    let channel = open.channels.swap_remove(place);
    if channel.is_whole {
        return Err(format!(
            "its channel {} holds whole numbers; floats{} are read",
            quoted(&channel.name),
            sought.of.in_unit()
        ));
    }
    report.take(sought.of.name(), &channel.name, sought.of.unit(), why);
    if !others.is_empty() {
        report.drop(format!("the channels {}", crate::words::listed(others.iter().map(String::as_str))));
    }
    let mut values = Vec::with_capacity(channel.values.len());
    for piece in channel.values.chunks(1 << 20) {
        watch.check().map_err(|stopped| stopped.to_string())?;
        values.extend(piece.iter().map(|&value| f64::from(value)));
    }
    Ok(Plane { width: channel.width, height: channel.height, samples: Samples::Values(values) })
}

/// The channel that is meant where none was named: the only one (transparency apart), or the only one that is called what
/// the map is of. The order of a file or of the alphabet is no reason.
fn only(open: &OpenExr, of: MapOf) -> Result<(usize, &'static str), String> {
    let solid: Vec<usize> = (0..open.channels.len()).filter(|&place| open.channels[place].short != "A").collect();
    if let &[place] = solid.as_slice() {
        return Ok((place, "the only one"));
    }
    for &name in names(of) {
        let found: Vec<usize> = (0..open.channels.len())
            .filter(|&place| match name {
                "Z" => open.channels[place].short == "Z",
                _ => open.channels[place].last().eq_ignore_ascii_case(name),
            })
            .collect();
        match found.as_slice() {
            [] => {}
            &[place] => return Ok((place, "its name")),
            _ => break,
        }
    }
    let parts = match open.parts() {
        1 => String::new(),
        parts => format!(" in {parts} parts"),
    };
    let (count, list) = (open.channels.len(), open.list());
    Err(match of {
        MapOf::Thickness => format!("it holds {count} channels{parts}; say which is the thickness: channel = {list}"),
        // (Its table has no key for one.)
        MapOf::Roughness | MapOf::Height => {
            format!("it holds {count} channels{parts}, {list}; save {} alone, or call its channel {0:?}", of.name())
        }
    })
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
