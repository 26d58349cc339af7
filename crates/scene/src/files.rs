//! Files that a scene names: found beside it, read whole, refused with a reason.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use exr::prelude::{ReadChannels, ReadLayers};

use crate::error::SceneError;
use crate::model::{EnvironmentMap, Origin};

/// Largest map: 2^28 texels are 3 GiB of floats.
const MAX_TEXELS: u64 = 1 << 28;

impl Origin {
    /// The file that a scene means by `name`: relative to the scene's folder, inside it unless the user allowed more.
    pub fn resolve(&self, name: &str) -> Result<PathBuf, SceneError> {
        let folder = match &self.folder {
            Some(folder) => folder.clone(),
            None => PathBuf::from("."),
        };
        let path = folder.join(name);
        let found = std::fs::canonicalize(&path)
            .map_err(|e| SceneError::new(format!("cannot open \"{}\": {}", path.display(), reason(&e))))?;
        if !self.allow_outside {
            let root = std::fs::canonicalize(&folder)
                .map_err(|e| SceneError::new(format!("cannot open \"{}\": {}", folder.display(), reason(&e))))?;
            if !found.starts_with(&root) {
                return Err(SceneError::new(format!(
                    "\"{name}\" lies outside the scene's folder; a scene may name only files in its own folder or below, \
                     unless you allow it (allow_outside=True, --allow-outside)"
                )));
            }
        }
        if found.is_dir() {
            return Err(SceneError::new(format!("\"{name}\" is a folder, not a file")));
        }
        Ok(path)
    }
}

/// The system's reason without its error number.
pub fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => {
            let text = error.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_lowercase()
        }
    }
}

/// Reads an environment map: OpenEXR (R, G, B or Y; half, float or integer) or Radiance HDR, told apart by content.
pub fn read_map(path: &Path) -> Result<Arc<EnvironmentMap>, SceneError> {
    let name = path.display();
    let bytes = std::fs::read(path).map_err(|e| SceneError::new(format!("cannot read \"{name}\": {}", reason(&e))))?;
    let map = if bytes.starts_with(&[0x76, 0x2F, 0x31, 0x01]) {
        read_exr(&bytes)
    } else if bytes.starts_with(b"#?") {
        read_hdr(&bytes)
    } else {
        Err("it is neither OpenEXR nor Radiance HDR".to_owned())
    }
    .map_err(|e| SceneError::new(format!("\"{name}\" cannot be used as an environment map: {e}")))?;
    if let Some(at) = map.rgb.iter().position(|v| !v.is_finite()) {
        let (texel, channel) = (at / 3, ["red", "green", "blue"][at % 3]);
        return Err(SceneError::new(format!(
            "\"{name}\" holds {} in {channel} at column {}, row {}; every value must be finite",
            map.rgb[at],
            texel % map.width,
            texel / map.width
        )));
    }
    Ok(Arc::new(map))
}

fn check_texels(width: usize, height: usize) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err("it has no pixels".into());
    }
    if width as u64 * height as u64 > MAX_TEXELS {
        return Err(format!("it has {width} x {height} pixels, more than {MAX_TEXELS}"));
    }
    Ok(())
}

fn read_exr(bytes: &[u8]) -> Result<EnvironmentMap, String> {
    // The header first: a damaged size must not reserve memory.
    let meta = exr::meta::MetaData::read_from_buffered(std::io::Cursor::new(bytes), false).map_err(exr_reason)?;
    for header in &meta.headers {
        check_texels(header.layer_size.x(), header.layer_size.y())?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(exr_reason)?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.x(), layer.size.y());
    let channels = &layer.channel_data.list;
    let find = |wanted: &str| {
        channels.iter().find(|c| {
            let name = c.name.to_string();
            name.eq_ignore_ascii_case(wanted)
                || name.rsplit('.').next().is_some_and(|last| last.eq_ignore_ascii_case(wanted))
        })
    };
    let planes = match (find("R"), find("G"), find("B"), find("Y")) {
        (Some(r), Some(g), Some(b), _) => [r, g, b],
        (_, _, _, Some(y)) => [y, y, y],
        _ => {
            let names: Vec<String> = channels.iter().map(|c| c.name.to_string()).collect();
            return Err(format!("it has the channels {}; R, G and B or Y are needed", names.join(", ")));
        }
    };
    let planes = planes.map(|c| c.sample_data.values_as_f32().collect::<Vec<f32>>());
    let mut rgb = Vec::with_capacity(3 * width * height);
    for i in 0..width * height {
        rgb.extend(planes.iter().map(|plane| plane[i]));
    }
    Ok(EnvironmentMap { width, height, rgb })
}

fn exr_reason(error: exr::error::Error) -> String {
    format!("damaged or unsupported OpenEXR ({error})")
}

fn read_hdr(bytes: &[u8]) -> Result<EnvironmentMap, String> {
    use image::ImageDecoder as _;
    let wrong = |e: image::ImageError| format!("damaged or unsupported Radiance HDR ({e})");
    let decoder = image::codecs::hdr::HdrDecoder::new(std::io::Cursor::new(bytes)).map_err(wrong)?;
    let (width, height) = decoder.dimensions();
    check_texels(width as usize, height as usize)?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(wrong)?;
    Ok(EnvironmentMap { width: width as usize, height: height as usize, rgb: image.into_rgb32f().into_raw() })
}
