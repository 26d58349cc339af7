use tiff::encoder::{TiffEncoder, colortype};

use super::*;
use crate::{BitDepth, OutputSpace, Packing, write_png};

fn read(bytes: &[u8]) -> Result<Photograph, String> {
    read_photograph(bytes, &MapChoice::default(), &Watch::new())
}

fn close(found: &[f32], wanted: &[f32], within: f32) {
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() <= within, "{found} {wanted}");
    }
}

#[test]
fn pictures_of_every_space_and_depth_give_their_light() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.png");
    for space in [OutputSpace::Srgb, OutputSpace::DisplayP3] {
        for (bits, within) in [(BitDepth::Eight, 4e-3), (BitDepth::Sixteen, 5e-4)] {
            // Encoded 0.5 is 0.2140 of light on both curves; white clips.
            write_png(&path, 2, 1, &[0.5, 0.5, 0.5, 1.0, 1.0, 1.0], bits, Packing::Small, space, &[], &|| false)
                .unwrap();
            let photograph = read(&std::fs::read(&path).unwrap()).unwrap();
            close(&photograph.rgb, &[0.214, 0.214, 0.214, 1.0, 1.0, 1.0], within);
            assert_eq!(photograph.clipped, [false, true]);
            assert!(photograph.report.to_string().contains("1 of 2 pixels are clipped"), "{}", photograph.report);
        }
    }
}

#[test]
fn the_head_of_a_file_tells_its_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x");
    write_png(&path, 2, 1, &[0.5; 6], BitDepth::Eight, Packing::Small, OutputSpace::Srgb, &[], &|| false).unwrap();
    assert_eq!(photograph_size(&path), Some((2, 1)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    encoder.write_image::<colortype::RGB16>(8, 7, &[9; 3 * 56]).unwrap();
    std::fs::write(&path, bytes.get_ref()).unwrap();
    assert_eq!(photograph_size(&path), Some((8, 7)));
    for damaged in [&b"II*\0"[..], &[0xFF, 0xD8, 0xFF, 0xE0, 0, 0], &[0x76, 0x2F, 0x31, 1, 2, 0, 0, 0, 0, 0], b""] {
        std::fs::write(&path, damaged).unwrap();
        assert_eq!(photograph_size(&path), None);
    }
    assert_eq!(photograph_size(folder.path()), None);
}

#[test]
fn tiff_of_16_bits_is_linear_and_ends_at_its_plateau() {
    let mut values = vec![1000_u16; 3 * 64];
    values[..60].fill(4095);
    let mut bytes = std::io::Cursor::new(Vec::new());
    TiffEncoder::new(&mut bytes).unwrap().write_image::<colortype::RGB16>(8, 8, &values).unwrap();
    let photograph = read(&bytes.into_inner()).unwrap();
    close(&photograph.rgb[63 * 3..], &[1000.0 / 65_535.0; 3], 1e-6);
    assert_eq!(photograph.clipped.iter().filter(|clipped| **clipped).count(), 20);
    assert!(photograph.report.to_string().contains("4095 is a plateau"));
    assert!(photograph.report.to_string().contains("linear Rec.709"));
}

/// A JPEG of 8 x 8 grey pixels of 128 + `dc` / 8 * 16, quantised by 16, with EXIF that says an orientation: baseline, one component.
fn jpeg() -> Vec<u8> {
    let exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
    let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xE1];
    bytes.extend(((exif.len() + 2) as u16).to_be_bytes());
    bytes.extend(exif);
    bytes.extend([0xFF, 0xDB, 0, 67, 0]);
    bytes.extend([16; 64]);
    // 16 columns, 8 rows.
    bytes.extend([0xFF, 0xC0, 0, 11, 8, 0, 8, 0, 16, 1, 1, 0x11, 0]);
    // DC: categories 0 and 5 by codes 0 and 10; AC: the end of a block by 0.
    bytes.extend([0xFF, 0xC4, 0, 21, 0x00, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5]);
    bytes.extend([0xFF, 0xC4, 0, 20, 0x10, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend([0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 63, 0]);
    // Block one: no difference, end. Block two: +16 (category 5, 10000), end: 0 0 10 10000 0, filled with ones.
    bytes.extend([0b0010_1000, 0b0011_1111, 0xFF, 0xD9]);
    bytes
}

#[test]
fn jpeg_is_turned_by_its_exif() {
    let photograph = read(&jpeg()).unwrap();
    // Stored 16 x 8, dark left, light right; orientation 6 puts the left side on top.
    assert_eq!((photograph.width, photograph.height), (8, 16));
    // 128 / 255, and 128 + 16 * 16 / 8 = 160 of 255, decoded as sRGB.
    let light = |byte: f32| ((byte / 255.0 + 0.055) / 1.055).powf(2.4);
    close(&photograph.rgb[..3], &[light(128.0); 3], 5e-3);
    close(&photograph.rgb[3 * 127..], &[light(160.0); 3], 5e-3);
    assert!(photograph.report.to_string().contains("orientation 6"));
    for length in 0..jpeg().len() {
        let _ = read(&jpeg()[..length]);
    }
    let mut huge = jpeg();
    let size = huge.windows(2).position(|pair| pair == [0xFF, 0xC0]).unwrap() + 5;
    huge[size..size + 4].copy_from_slice(&[0x3F, 0xFF, 0x1F, 0xFF]);
    assert!(read(&huge).unwrap_err().contains("declares 402579459 bytes of pixels"), "{:?}", read(&huge));
}

/// An even grey JPEG of so many pixels, with as many bytes of comments as its size asks for.
fn even_jpeg(width: u16, height: u16) -> Vec<u8> {
    let mut bytes = jpeg();
    let size = bytes.windows(2).position(|pair| pair == [0xFF, 0xC0]).unwrap() + 5;
    bytes[size..size + 2].copy_from_slice(&height.to_be_bytes());
    bytes[size + 2..size + 4].copy_from_slice(&width.to_be_bytes());
    let data = bytes.len() - 4;
    let blocks = usize::from(width).div_ceil(8) * usize::from(height).div_ceil(8);
    // Two bits a block: no difference, the end; at last ones, and the end of the picture.
    bytes.splice(data.., std::iter::repeat_n(0, blocks / 4).chain([0x3F, 0xFF, 0xD9]));
    let comment = [&[0xFF, 0xFE, 0xFF, 0xFF][..], &[0; 65_533]].concat();
    bytes.splice(2..2, comment.repeat(blocks / 200_000 + 1));
    bytes
}

#[test]
fn a_large_jpeg_is_decoded_aside_to_the_same_pixels() {
    let photograph = read(&even_jpeg(2120, 2048)).unwrap();
    assert_eq!((photograph.width, photograph.height), (2048, 2120), "orientation 6");
    let light = ((128.0_f32 / 255.0 + 0.055) / 1.055).powf(2.4);
    assert!(photograph.rgb.iter().all(|value| (value - light).abs() < 5e-3));
}

#[test]
fn a_jpeg_of_any_size_stops_with_the_watch() {
    for (size, after_ms) in [([16, 8], 0), ([16_384, 8192], 200)] {
        let bytes = even_jpeg(size[0], size[1]);
        let watch = Watch::new();
        let other = watch.clone();
        let stopping = std::thread::spawn(move || {
            std::thread::sleep(std::time::Duration::from_millis(after_ms));
            other.stop();
            std::time::Instant::now()
        });
        if after_ms == 0 {
            watch.stop();
        }
        let told = read_photograph(&bytes, &MapChoice::default(), &watch).unwrap_err();
        let late = std::time::Instant::now().duration_since(stopping.join().unwrap());
        assert_eq!(told, "stopped");
        assert!(late.as_secs_f64() < 0.3, "{late:?}");
    }
}

#[test]
fn what_is_no_photograph_is_refused_with_what_to_do() {
    for (bytes, words) in [
        (&b""[..], "it is empty"),
        (b"\0\0\0\x18ftypheic", "convert it to a linear 16-bit TIFF"),
        (b"FUJIFILMCCD-RAW", "RAW"),
        (b"GIF89a", "no PNG, JPEG, TIFF"),
    ] {
        assert!(read(bytes).unwrap_err().contains(words));
    }
}
