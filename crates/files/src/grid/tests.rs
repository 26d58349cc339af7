use tiff::encoder::{TiffEncoder, colortype};

use super::*;

fn decode(bytes: &[u8]) -> Result<Grid, String> {
    super::decode(bytes, &MapChoice::default(), &Watch::new())
}

/// The map of the part of a file that is named.
fn chosen(bytes: &[u8], channel: Option<&str>, page: Option<usize>) -> Result<Grid, String> {
    super::decode(bytes, &MapChoice { channel, page }, &Watch::new())
}

/// 3 columns, 2 rows.
const VALUES: [f64; 6] = [0.0, 100.0, 250.5, 300.0, 512.25, 999.0];

fn npy(kind: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let fortran = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn png(color: png::ColorType, depth: png::BitDepth, width: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, width, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette([0, 0, 0, 255, 0, 0].to_vec());
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

fn tiff<C: colortype::ColorType>(data: &[C::Inner]) -> Vec<u8>
where
    [C::Inner]: ::tiff::encoder::TiffValue,
{
    let mut bytes = std::io::Cursor::new(Vec::new());
    TiffEncoder::new(&mut bytes).unwrap().write_image::<C>(3, 2, data).unwrap();
    bytes.into_inner()
}

fn floats() -> Vec<f32> {
    VALUES.iter().map(|&v| v as f32).collect()
}

fn exr() -> Vec<u8> {
    thickness_exr(&ThicknessMap::new(3, 2, VALUES.to_vec()).unwrap()).unwrap()
}

/// One small file of every kind of floats, and of every kind of whole numbers.
fn files() -> (Vec<Vec<u8>>, Vec<Vec<u8>>) {
    let f64s: Vec<u8> = VALUES.iter().flat_map(|v| v.to_le_bytes()).collect();
    let big: Vec<u8> = VALUES.iter().flat_map(|v| v.to_be_bytes()).collect();
    let f32s: Vec<u8> = floats().iter().flat_map(|v| v.to_le_bytes()).collect();
    // The same values column after column.
    let columns: Vec<u8> = [0, 3, 1, 4, 2, 5].iter().flat_map(|&i: &usize| VALUES[i].to_le_bytes()).collect();
    let u8s = [0_u8, 51, 102, 153, 204, 255];
    let u16s = u8s.map(|v| u16::from(v) * 257);
    let (u16_big, u16_little) = (u16s.map(u16::to_be_bytes), u16s.map(u16::to_le_bytes));
    let grey_alpha: Vec<u8> = u8s.iter().flat_map(|&v| [v, 7]).collect();
    let rgb: Vec<u8> = u8s.iter().flat_map(|&v| [v; 3]).collect();
    let nanometres = vec![
        exr(),
        tiff::<colortype::Gray32Float>(&floats()),
        tiff::<colortype::Gray64Float>(&VALUES),
        npy("<f8", false, "(2, 3)", &f64s),
        npy(">f8", false, "(2, 3)", &big),
        npy("<f8", true, "(2, 3)", &columns),
        npy("<f4", false, "(2, 3)", &f32s),
    ];
    let shares = vec![
        png(png::ColorType::Grayscale, png::BitDepth::Eight, 3, &u8s),
        png(png::ColorType::Grayscale, png::BitDepth::Sixteen, 3, u16_big.as_flattened()),
        png(png::ColorType::GrayscaleAlpha, png::BitDepth::Eight, 3, &grey_alpha),
        png(png::ColorType::Rgb, png::BitDepth::Eight, 3, &rgb),
        tiff::<colortype::Gray8>(&u8s),
        tiff::<colortype::Gray16>(&u16s),
        npy("|u1", false, "(2, 3)", &u8s),
        npy("<u2", false, "(2, 3)", u16_little.as_flattened()),
        npy(">u2", false, "(2, 3)", u16_big.as_flattened()),
    ];
    (nanometres, shares)
}

#[test]
fn floats_are_nanometres_and_take_no_range() {
    for file in files().0 {
        let grid = decode(&file).unwrap();
        let map = grid.in_range(None, None).unwrap();
        assert_eq!((map.width(), map.height(), map.thickness_nm()), (3, 2, &VALUES[..]));
        assert_eq!(grid.in_range(Some(0.0), None).unwrap_err().argument, "min_nm");
        assert_eq!(grid.in_range(None, Some(0.0)).unwrap_err().argument, "max_nm");
        assert!(grid.in_range(Some(0.0), Some(9.0)).unwrap_err().allowed.contains("floats, which are nm already"));
    }
    // Half floats: 1.5 and 1024.
    let half = npy("<f2", false, "(1, 2)", &[0x00, 0x3E, 0x00, 0x64]);
    assert_eq!(decode(&half).unwrap().in_range(None, None).unwrap().thickness_nm(), [1.5, 1024.0]);
}

#[test]
fn whole_numbers_are_shares_of_the_range() {
    for file in files().1 {
        let grid = decode(&file).unwrap();
        let map = grid.in_range(Some(100.0), Some(600.0)).unwrap();
        assert_eq!((map.width(), map.height()), (3, 2));
        for (found, expected) in map.thickness_nm().iter().zip([100.0, 200.0, 300.0, 400.0, 500.0, 600.0]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        assert_eq!((map.thickness_nm()[0], map.thickness_nm()[5]), (100.0, 600.0), "exact at both ends");
        for (min, max, key) in [
            (None, None, "min_nm"),
            (None, Some(1.0), "min_nm"),
            (Some(1.0), None, "max_nm"),
            (Some(-1.0), Some(1.0), "min_nm"),
            (Some(0.0), Some(f64::NAN), "max_nm"),
            (Some(2.0), Some(1.0), "max_nm"),
        ] {
            assert_eq!(grid.in_range(min, max).unwrap_err().argument, key);
        }
    }
    let bits = png(png::ColorType::Grayscale, png::BitDepth::One, 3, &[0b0100_0000, 0b1010_0000]);
    let map = decode(&bits).unwrap().in_range(Some(0.0), Some(8.0)).unwrap();
    assert_eq!(map.thickness_nm(), [0.0, 8.0, 0.0, 8.0, 0.0, 8.0]);
}

#[test]
fn what_is_no_map_is_refused_with_its_reason() {
    let refused = |file: Vec<u8>, said: &str| {
        let error = decode(&file).unwrap_err();
        assert!(error.contains(said), "{error}");
    };
    refused(vec![], "it is empty");
    refused(b"thickness\n320\n".to_vec(), "no OpenEXR, TIFF, PNG or NPY");
    refused(png(png::ColorType::Rgb, png::BitDepth::Eight, 1, &[1, 2, 3, 4, 4, 4]), "picture in colour");
    refused(png(png::ColorType::Indexed, png::BitDepth::Eight, 3, &[0, 1, 0, 1, 0, 1]), "picture in colour");
    refused(tiff::<colortype::RGB8>(&[1, 2, 3].repeat(6)), "picture in colour");
    refused(tiff::<colortype::Gray32>(&[1; 6]), "of 8 or 16 bits");
    refused(tiff::<colortype::GrayI16>(&[1; 6]), "of 8 or 16 bits");
    refused(npy("<f8", false, "(6,)", &[0; 48]), "its shape is (6,)");
    refused(npy("<f8", false, "()", &[0; 8]), "its shape is ()");
    refused(npy("<f8", false, "(2, 3, 1)", &[0; 48]), "two sides");
    refused(npy("<f8", false, "(-2, 3)", &[0; 48]), "two sides");
    refused(npy("<f8", false, "(0, 3)", &[]), "no pixels");
    refused(npy("<f8", false, "(99999999, 99999999)", &[]), "at most 134217728");
    refused(npy("<f8", false, "(99999999999999999999, 2)", &[]), "two sides");
    refused(npy("<f8", false, "(2, 3)", &[0; 40]), "need 48 bytes, 40 follow");
    refused(npy("<f8", false, "(2, 3)", &[0; 56]), "need 48 bytes, 56 follow");
    for kind in ["<i4", "<i8", "<c8", "<U3", "|O", "|b1", "<f16", "", "é"] {
        refused(npy(kind, false, "(2, 3)", &[0; 48]), "its numbers are of type");
    }
    refused(b"\x93NUMPY\x01\x00".to_vec(), "ends inside its header");
    refused(b"\x93NUMPY\x09\x00\x00\x00".to_vec(), "version 9");
    let mut huge = png(png::ColorType::Grayscale, png::BitDepth::Eight, 3, &[0; 6]);
    huge[16..24].copy_from_slice(&[0x7F, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF]);
    assert!(decode(&huge).is_err());
}

#[test]
fn values_that_are_no_thickness_are_refused_with_their_place() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
        let mut values = VALUES;
        values[4] = bad;
        let f64s: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        for file in [npy("<f8", false, "(2, 3)", &f64s), tiff::<colortype::Gray64Float>(&values)] {
            let error = decode(&file).unwrap_err();
            assert!(error.contains(&format!("it holds {bad} at row 1, column 1;")), "{error}");
        }
    }
}

/// An OpenEXR file of 2 x 2 pixels, each channel of a part of one value.
fn exr_of(parts: &[(&str, &[(&str, f32)])]) -> Vec<u8> {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes,
        Layers, Vec2, WritableImage,
    };
    let layers: Layers<AnyChannels<FlatSamples>> = parts
        .iter()
        .map(|(part, channels)| {
            let list = channels.iter().map(|&(name, value)| AnyChannel::new(name, FlatSamples::F32(vec![value; 4])));
            let attributes = LayerAttributes { layer_name: Some((*part).into()), ..LayerAttributes::default() };
            Layer::new((2, 2), attributes, Encoding::UNCOMPRESSED, AnyChannels::sort(list.collect()))
        })
        .collect();
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(Vec2(2, 2)));
    let mut bytes = Vec::new();
    Image { attributes, layer_data: layers }
        .write()
        .non_parallel()
        .to_buffered(std::io::Cursor::new(&mut bytes))
        .unwrap();
    bytes
}

#[test]
fn the_channel_of_an_exr_is_the_only_one_or_the_one_that_is_named() {
    let first = |grid: Result<Grid, String>| grid.map(|grid| grid.in_range(None, None).unwrap().thickness_nm()[0]);
    let plain = |channels: &[(&str, f32)]| first(decode(&exr_of(&[("a", channels)])));
    assert_eq!(plain(&[("A", 1.0), ("B", 2.0), ("G", 3.0), ("R", 4.0), ("thickness_nm", 5.0)]), Ok(5.0));
    assert_eq!(plain(&[("A", 1.0), ("film.thickness_nm", 5.0), ("Y", 2.0)]), Ok(5.0));
    assert_eq!(plain(&[("A", 1.0), ("Y", 2.0)]), Ok(2.0));
    assert_eq!(plain(&[("B", 1.0), ("Z", 3.0)]), Ok(3.0));
    assert_eq!(plain(&[("depth.Z", 1.0), ("thickness", 3.0)]), Ok(3.0));
    // Neither the alphabet nor the order of the file is a reason.
    for channels in
        [&[("height", 7.0), ("weight", 8.0)][..], &[("R", 1.0), ("Y", 2.0)], &[("depth.Z", 1.0), ("R", 2.0)]]
    {
        let error = plain(channels).unwrap_err();
        assert!(error.contains("it holds 2 channels; say which is the thickness: channel = "), "{error}");
    }
    let rgba = [("R", 1.0), ("G", 2.0), ("B", 3.0), ("A", 4.0)];
    let file = exr_of(&[("rgba", &rgba), ("aux", &[("film.t_nm", 5.0), ("film.order", 6.0)])]);
    let error = first(chosen(&file, None, None)).unwrap_err();
    assert!(error.contains("6 channels in 2 parts") && error.contains("\"aux:film.t_nm\""), "{error}");
    for (name, value) in [("aux:film.t_nm", 5.0), ("film.order", 6.0), ("T_NM", 5.0), ("rgba:G", 2.0)] {
        assert_eq!(first(chosen(&file, Some(name), None)), Ok(value), "{name}");
    }
    assert!(first(chosen(&file, Some("t"), None)).unwrap_err().contains("it has no channel \"t\""));
    let twice = exr_of(&[("a", &[("t", 1.0)]), ("b", &[("t", 2.0)])]);
    assert!(first(chosen(&twice, Some("t"), None)).unwrap_err().contains("\"a:t\", \"b:t\""));
    assert!(chosen(&file, Some("R"), Some(2)).unwrap_err().contains("page must be 1"));
}

#[test]
fn faults_are_told_in_the_words_of_what_the_map_is_of() {
    let told = |of: MapOf, file: &[u8]| {
        super::decode_of(of, file, &MapChoice::default(), &Watch::new()).map(|grid| grid.report.notes)
    };
    let colour = png(png::ColorType::Rgb, png::BitDepth::Eight, 1, &[1, 2, 3, 4, 4, 4]);
    let number = |value: f64| npy("<f8", false, "(1, 1)", &value.to_le_bytes());
    let words = npy("<U3", false, "(2, 3)", &[0; 48]);
    let two = exr_of(&[("a", &[("G", 0.25), ("R", 0.5)])]);
    for (of, name) in [(MapOf::Roughness, "roughness"), (MapOf::Height, "height")] {
        for (file, said) in [(&colour, "in grey"), (&number(-1.0), name), (&words, "float64,"), (&two, "2 channels, ")]
        {
            let error = told(of, file).unwrap_err();
            assert!(error.contains(said), "{error}");
            for foreign in ["thickness", "nm", "channel ="] {
                assert!(!error.contains(foreign), "{error}");
            }
        }
        assert_eq!(told(of, &number(1e-9)), Ok(vec![]), "no guess at a unit");
        assert_eq!(told(of, &exr_of(&[("a", &[("thickness", 0.25), (name, 0.5)])])), Ok(vec![]));
    }
    assert!(told(MapOf::Thickness, &colour).unwrap_err().contains("name the channel"));
}

/// A TIFF of pages of 3 x 2 numbers 0, 1, ... each page a hundred more, with tags.
fn tiff_of(pages: u16, orientation: u16, description: &str) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    for page in 0..pages {
        let values: Vec<u16> = (0..6).map(|i| 100 * page + i).collect();
        let mut image = encoder.new_image::<colortype::Gray16>(3, 2).unwrap();
        image.encoder().write_tag(tiff::tags::Tag::Orientation, orientation).unwrap();
        image.encoder().write_tag(tiff::tags::Tag::ImageDescription, description).unwrap();
        image.write_data(&values).unwrap();
    }
    bytes.into_inner()
}

#[test]
fn orientation_pages_and_calibration_of_a_tiff_count() {
    let nm = |grid: Grid| {
        let map = grid.in_range(Some(0.0), Some(65535.0)).unwrap();
        (map.width(), map.thickness_nm().iter().map(|nm| nm.round()).collect::<Vec<f64>>())
    };
    assert_eq!(nm(decode(&tiff_of(1, 1, "")).unwrap()), (3, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
    assert_eq!(nm(decode(&tiff_of(1, 4, "")).unwrap()), (3, vec![3.0, 4.0, 5.0, 0.0, 1.0, 2.0]));
    assert_eq!(nm(decode(&tiff_of(1, 6, "")).unwrap()), (2, vec![3.0, 0.0, 4.0, 1.0, 5.0, 2.0]));
    assert!(decode(&tiff_of(1, 9, "")).unwrap_err().contains("orientation must be 1 to 8, got 9"));
    // Pages.
    let stack = tiff_of(3, 1, "");
    assert!(decode(&stack).unwrap_err().contains("it holds 3 pages; say which: page = 1 to 3"));
    assert_eq!(nm(chosen(&stack, None, Some(2)).unwrap()).1[0], 100.0);
    for page in [0, 4] {
        assert!(chosen(&stack, None, Some(page)).unwrap_err().contains(&format!("page must be 1 to 3, got {page}")));
    }
    // ImageJ: nm = c0 + c1 v.
    for (unit, factor) in [("nm", 1.0), ("um", 1000.0), ("micron", 1000.0)] {
        let grid = decode(&tiff_of(1, 1, &format!("ImageJ=1.53\ncf=0\nc0=10.5\nc1=0.5\nvunit={unit}\n"))).unwrap();
        assert!(grid.report.to_string().contains("calibration is applied"));
        assert_eq!(grid.in_range(None, None).unwrap().thickness_nm()[3], factor * 12.0);
    }
    for (description, words) in [
        ("ImageJ=1.53\nc0=1\nc1=2\nvunit=kg\n", "\"kg\" (ImageJ's vunit)"),
        ("ImageJ=1.53\nc0=1\nc1=2\n", "without a unit of length"),
        ("ImageJ=1.53\ncf=20\nc0=1\nc1=2\nvunit=nm\n", "no straight line"),
        ("ImageJ=1.53\nimages=3\nslices=3\n", "stack of 3 pictures"),
        ("ImageJ=1.53\nc0=x\nc1=2\nvunit=nm\n", "c0 must be a number, got \"x\""),
    ] {
        let error = decode(&tiff_of(1, 1, description)).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    // A roughness and a height are numbers without a unit; only a height may be told as a length, whose shape counts.
    let of = |map: MapOf, description: &str| {
        super::decode_of(map, &tiff_of(1, 1, description), &MapChoice::default(), &Watch::new())
    };
    for (map, told) in [(MapOf::Roughness, "roughness = 0.25 + 0.125 v"), (MapOf::Height, "height = 0.25 + 0.125 v")] {
        for unit in ["", "vunit=Gray Value\n"] {
            let grid = of(map, &format!("ImageJ=1.53\ncf=0\nc0=0.25\nc1=0.125\n{unit}")).unwrap();
            assert!(grid.report.to_string().contains(told), "{}", grid.report);
            assert_eq!(grid.shares().thickness_nm()[..4], [0.25, 0.375, 0.5, 0.625]);
        }
    }
    assert_eq!(of(MapOf::Height, "ImageJ=1.53\nc0=1\nc1=2\nvunit=um\n").unwrap().shares().thickness_nm()[1], 3.0);
    let error = of(MapOf::Roughness, "ImageJ=1.53\nc0=1\nc1=2\nvunit=nm\n").unwrap_err();
    assert!(error.contains("\"nm\" (ImageJ's vunit); a roughness has none"), "{error}");
    // The description of any other program is none of a calibration.
    assert_eq!(nm(decode(&tiff_of(1, 1, "c0=1\nc1=2\nvunit=nm")).unwrap()).1[3], 3.0);
}

#[test]
fn a_picture_in_colour_needs_a_channel() {
    let colour = png(::png::ColorType::Rgb, ::png::BitDepth::Eight, 1, &[1, 51, 3, 4, 102, 6]);
    assert!(decode(&colour).unwrap_err().contains("channel = \"G\""));
    let grid = chosen(&colour, Some("G"), None).unwrap();
    assert_eq!(grid.in_range(Some(0.0), Some(5.0)).unwrap().thickness_nm(), [1.0, 2.0]);
    assert!(chosen(&colour, Some("A"), None).unwrap_err().contains("it has no channel \"A\""));
}

#[test]
fn declared_sizes_and_packed_texts_take_no_memory() {
    // A PNG whose header declares 16384 x 8192 colours over a few bytes.
    let mut huge = png(::png::ColorType::Rgb, ::png::BitDepth::Eight, 1, &[0; 6]);
    huge[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x20, 0]);
    let sum = crc(&huge[12..29]);
    huge[29..33].copy_from_slice(&sum.to_be_bytes());
    assert!(decode(&huge).unwrap_err().contains("declares 402653184 bytes of pixels"), "{:?}", decode(&huge));
    // A watch ends the work.
    let watch = Watch::new();
    watch.stop();
    for file in files().0.iter().chain(&files().1).filter(|file| file[0] != 0x93) {
        assert!(super::decode(file, &MapChoice::default(), &watch).is_err());
    }
}

/// The check sum of a PNG chunk (ISO 3309), bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xEDB8_8320 & 0_u32.wrapping_sub(sum & 1)))
    })
}

#[test]
fn damaged_files_are_refused_not_followed() {
    let (nanometres, shares) = files();
    for whole in nanometres.iter().chain(&shares) {
        // A PNG is whole before its last chunk and a TIFF may keep its directory's end for last: cut the half away.
        for length in 0..whole.len() / 2 {
            assert!(decode(&whole[..length]).is_err(), "cut at {length} of {}", whole.len());
        }
        // Every byte wrong in turn: refused, or a map of thicknesses; never a panic or a reservation of gigabytes.
        for at in 0..whole.len() {
            for value in [0x00, 0x7F, 0xFF] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                if let Ok(grid) = decode(&bytes) {
                    assert!(grid.values.thickness_nm().iter().all(|v| v.is_finite() && *v >= 0.0));
                }
            }
        }
    }
}
