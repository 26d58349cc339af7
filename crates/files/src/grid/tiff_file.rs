//! TIFF: floats (a thickness in nm), or whole numbers of 8 or 16 bits; orientation and ImageJ's calibration applied, pages by number.

use iridesce_numerics::Watch;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{PhotometricInterpretation, Tag};

use super::plane::{MapOf, Plane, Samples, Sought, one_of};
use crate::input::{Input, gathered};
use crate::limits::{check_ratio, check_size, room};
use crate::orient::upright;
use crate::report::ReadReport;
use crate::words::{harmless, quoted};

/// Most memory for the pixels.
const MAX_BYTES: usize = 4 << 30;
/// Most bytes out of one: LZW, whose codes of 9 to 12 bits stand for up to 3837 bytes, is the strongest that is read.
const RATIO: u64 = 4096;
/// Most pages that are looked at.
const MOST_PAGES: usize = 4096;

type Pages<'a> = Decoder<Input<'a>>;

/// A page as it is stored, turned upright.
pub struct Page {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub values: DecodingResult,
    pub description: String,
    pub icc: Option<Vec<u8>>,
}

pub fn read(bytes: &[u8], sought: &Sought<'_>, watch: &Watch, report: &mut ReadReport) -> Result<Plane, String> {
    let Page { width, height, channels, values, description, .. } = page(bytes, sought.page, watch, report)?;
    let names: &[&str] = match channels {
        1 => &["grey"],
        2 => &["grey", "A"],
        3 => &["R", "G", "B"],
        4 => &["R", "G", "B", "A"],
        _ => return Err(format!("its pixels hold {channels} numbers; save it in grey, one number a pixel")),
    };
    let floats = |values: Vec<f64>, report: &mut ReadReport| -> Result<Samples, String> {
        Ok(Samples::Values(one_of(values, names, sought, watch, report)?))
    };
    let whole = |values: Vec<f64>, most: f64, report: &mut ReadReport| -> Result<Samples, String> {
        let calibration = Calibration::of(&description, sought.of)?;
        let values = one_of(values, names, sought, watch, report)?;
        Ok(match calibration {
            Some(Calibration { c0, c1, unit }) => {
                let told = match sought.of {
                    MapOf::Thickness => format!("nm = {unit} ({c0} + {c1} v)"),
                    other => format!("{} = {c0} + {c1} v", other.name()),
                };
                report.note(format!("ImageJ's calibration is applied: {told}"));
                Samples::Values(gathered(values.into_iter().map(|v| unit * (c0 + c1 * v)), watch)?)
            }
            None => Samples::Shares(gathered(values.into_iter().map(|v| v / most), watch)?),
        })
    };
    let scale = value_unit(&description, sought.of)?.unwrap_or(1.0);
    let scaled = |values: Vec<f64>| -> Result<Vec<f64>, String> {
        if scale == 1.0 { Ok(values) } else { gathered(values.into_iter().map(|v| scale * v), watch) }
    };
    if scale != 1.0 {
        report.note(format!("the file gives its values in another unit: nm = {scale} v"));
    }
    let samples = match values {
        DecodingResult::F16(values) => {
            floats(scaled(gathered(values.into_iter().map(|v| f64::from(v.to_f32())), watch)?)?, report)?
        }
        DecodingResult::F32(values) => floats(scaled(gathered(values.into_iter().map(f64::from), watch)?)?, report)?,
        DecodingResult::F64(values) => floats(scaled(values)?, report)?,
        DecodingResult::U8(values) => {
            whole(gathered(values.into_iter().map(f64::from), watch)?, f64::from(u8::MAX), report)?
        }
        DecodingResult::U16(values) => {
            whole(gathered(values.into_iter().map(f64::from), watch)?, f64::from(u16::MAX), report)?
        }
        _ => {
            return Err(format!(
                "its numbers must be floats of 16, 32 or 64 bits{} or whole numbers, >= 0, of 8 or 16 bits (a range)",
                sought.of.in_unit()
            ));
        }
    };
    watch.check().map_err(|stopped| stopped.to_string())?;
    let (Samples::Values(numbers) | Samples::Shares(numbers)) = &samples;
    if numbers.len() != width * height {
        return Err(format!("damaged TIFF: {} numbers for {width} x {height} pixels", numbers.len()));
    }
    Ok(Plane { width, height, samples })
}

/// One page, the first being 1: the one that was asked for, or the only one.
pub fn page(bytes: &[u8], asked: Option<usize>, watch: &Watch, report: &mut ReadReport) -> Result<Page, String> {
    let damaged = |e: tiff::TiffError| format!("damaged or unsupported TIFF ({})", harmless(&e.to_string()));
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_BYTES;
    limits.intermediate_buffer_size = MAX_BYTES;
    let mut decoder: Pages<'_> = Decoder::new(Input::new(bytes, watch)).map_err(damaged)?.with_limits(limits);
    let pages = full_pages(&mut decoder)?;
    let place = match (asked, pages.as_slice()) {
        (None, &[only]) => only,
        (None, several) => {
            return Err(format!("it holds {0} pages; say which: page = 1 to {0}", several.len()));
        }
        (Some(asked), pages) => *asked
            .checked_sub(1)
            .and_then(|place| pages.get(place))
            .ok_or_else(|| format!("page must be 1 to {}, got {asked}", pages.len()))?,
    };
    if pages.len() > 1 {
        report.take("page", &asked.unwrap_or(1).to_string(), "", "page =");
        report.drop(format!("{} other pages", pages.len() - 1));
    }
    decoder.seek_to_image(place).map_err(damaged)?;
    let (width, height) = decoder.dimensions().map_err(damaged)?;
    let (width, height) = (width as usize, height as usize);
    check_size(width, height, 1)?;
    let color = decoder.colortype().map_err(damaged)?;
    let (channels, bits) = match color {
        tiff::ColorType::Gray(bits) => (1, bits),
        tiff::ColorType::GrayA(bits) => (2, bits),
        tiff::ColorType::RGB(bits) => (3, bits),
        tiff::ColorType::RGBA(bits) => (4, bits),
        other => return Err(format!("its pixels are {other:?}; save it in grey, one number a pixel")),
    };
    check_size(width, height, channels)?;
    let raw = (width as u64 * height as u64) * channels as u64 * u64::from(bits) / 8;
    check_ratio(raw, bytes.len() as u64, RATIO, "TIFF")?;
    // The numbers, and the doubles that they become.
    room(raw + 16 * (width * height * channels) as u64)?;
    let photometric = decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(damaged)?;
    if photometric == Some(PhotometricInterpretation::WhiteIsZero.to_u16()) {
        return Err("its numbers grow from white to black (WhiteIsZero); save it without inversion".into());
    }
    let description = decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default();
    // ImageJ keeps stacks beyond 4 GiB, and some writers all stacks, behind one directory.
    let hidden = fact(&description, "images").and_then(|count| count.parse::<usize>().ok()).unwrap_or(1);
    if pages.len() == 1 && hidden > 1 {
        return Err(format!(
            "it is an ImageJ stack of {hidden} pictures behind one directory; save the one that is meant by itself"
        ));
    }
    let icc = decoder.get_tag_u8_vec(Tag::Unknown(34675)).ok().filter(|profile| !profile.is_empty());
    let orientation = decoder.find_tag_unsigned::<u16>(Tag::Orientation).map_err(damaged)?.unwrap_or(1);
    let values = decoder.read_image().map_err(damaged)?;
    if !matches!(orientation, 1..=8) {
        return Err(format!("its orientation must be 1 to 8, got {orientation}"));
    }
    if orientation != 1 {
        report.note(format!("orientation {orientation}: the picture is turned upright"));
    }
    macro_rules! turned {
        ($($kind:ident),*) => {
            match values {
                $(DecodingResult::$kind(values) => {
                    if values.len() != width * height * channels {
                        return Err(format!("damaged TIFF: {} numbers for {width} x {height} pixels", values.len()));
                    }
                    let (w, h, values) = upright(orientation, width, height, channels, values, watch)?;
                    (w, h, DecodingResult::$kind(values))
                })*
            }
        };
    }
    let (width, height, values) = turned!(U8, U16, U32, U64, F16, F32, F64, I8, I16, I32, I64);
    Ok(Page { width, height, channels, values, description, icc })
}

/// The places of the pages that are pictures by themselves: smaller copies and masks are none.
fn full_pages(decoder: &mut Pages<'_>) -> Result<Vec<usize>, String> {
    let damaged = |e: tiff::TiffError| format!("damaged or unsupported TIFF ({})", harmless(&e.to_string()));
    let mut pages = Vec::new();
    for place in 0.. {
        if place >= MOST_PAGES {
            return Err(format!("it has more than {MOST_PAGES} pages"));
        }
        // Bit 0: a reduced copy of another page; bit 2: a mask (TIFF 6.0, NewSubfileType).
        let kind = decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType).map_err(damaged)?.unwrap_or(0);
        if kind & 0b101 == 0 {
            pages.push(place);
        }
        if !decoder.more_images() {
            break;
        }
        decoder.next_image().map_err(damaged)?;
    }
    if pages.is_empty() {
        pages.push(0);
    }
    Ok(pages)
}

/// What the whole numbers of a map mean that ImageJ calibrated: unit (c0 + c1 v).
struct Calibration {
    c0: f64,
    c1: f64,
    /// nm in the unit of a thickness; 1 for numbers as they stand.
    unit: f64,
}

/// A line `name=value` of ImageJ's description.
fn fact<'a>(description: &'a str, name: &str) -> Option<&'a str> {
    if !description.starts_with("ImageJ=") {
        return None;
    }
    description.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('=')).map(str::trim)
}

/// What ImageJ's unit of the values is worth: nm where a thickness is sought, else 1; `None` where the file states none.
fn value_unit(description: &str, of: MapOf) -> Result<Option<f64>, String> {
    let nm = match fact(description, "vunit").map(|unit| unit.to_lowercase()).as_deref() {
        None | Some("" | "gray value" | "grey value" | "pixel") => return Ok(None),
        Some("nm") => Some(1.0),
        Some("um" | "\u{b5}m" | "\u{3bc}m" | "micron" | "\\u00b5m") => Some(1e3),
        Some(_) => None,
    };
    match (of, nm) {
        (MapOf::Thickness, Some(nm)) => Ok(Some(nm)),
        // The shape counts: what a height of 1 is worth in the scene is said there.
        (MapOf::Height, Some(_)) => Ok(Some(1.0)),
        _ => {
            let other = fact(description, "vunit").unwrap_or_default();
            let allowed = if of == MapOf::Roughness { "a roughness has none" } else { "nm and um are read" };
            Err(format!("its values are in {} (ImageJ's vunit); {allowed}", quoted(other)))
        }
    }
}

impl Calibration {
    fn of(description: &str, map: MapOf) -> Result<Option<Calibration>, String> {
        let number = |name: &str| -> Result<Option<f64>, String> {
            fact(description, name)
                .map(|word| {
                    word.parse::<f64>()
                        .ok()
                        .filter(|value| value.is_finite())
                        .ok_or_else(|| format!("damaged TIFF: ImageJ's {name} must be a number, got {}", quoted(word)))
                })
                .transpose()
        };
        let (Some(c0), Some(c1)) = (number("c0")?, number("c1")?) else { return Ok(None) };
        // Function 0 is the straight line; others are curves of optical density and the like.
        if fact(description, "cf").is_some_and(|function| function != "0") {
            return Err(format!(
                "ImageJ's calibration of its values is no straight line; save it as floats{}",
                map.in_unit()
            ));
        }
        match (value_unit(description, map)?, map) {
            (Some(unit), _) => Ok(Some(Calibration { c0, c1, unit })),
            (None, MapOf::Roughness | MapOf::Height) => Ok(Some(Calibration { c0, c1, unit: 1.0 })),
            (None, MapOf::Thickness) => Err(format!(
                "ImageJ calibrated its values (c0 = {c0}, c1 = {c1}) without a unit of length; set the unit nm or um"
            )),
        }
    }
}
