//! The smallest ICC profile that says which RGB a file holds: version 4, three primaries, one curve.
//!
//! Source: ICC.1:2022, "Image technology colour management": header (7.2), tag types (10), chromatic adaptation (annex E).

use iridesce_optics::color::{D65_XY, Matrix, bradford, xyz_of_xy};

use crate::space::OutputSpace;

/// White of the profile connection space, D50, as the specification states it (7.2.16).
const PCS_WHITE: [f64; 3] = [0.9642, 1.0, 0.8249];

/// The profile of a space, always the same bytes.
pub fn profile(space: OutputSpace) -> Vec<u8> {
    let to_pcs = bradford(xyz_of_xy(D65_XY), PCS_WHITE);
    let primaries = multiply(&to_pcs, &space.xyz_from_rgb());
    let column = |i: usize| xyz_tag([primaries[0][i], primaries[1][i], primaries[2][i]]);
    let curve = curve_tag(curve(space));
    let tags: [(&[u8; 4], Vec<u8>); 10] = [
        (b"desc", text_tag(space.title())),
        (b"cprt", text_tag("No copyright, use freely")),
        (b"wtpt", xyz_tag(PCS_WHITE)),
        (b"chad", matrix_tag(&to_pcs)),
        (b"rXYZ", column(0)),
        (b"gXYZ", column(1)),
        (b"bXYZ", column(2)),
        (b"rTRC", curve.clone()),
        (b"gTRC", curve.clone()),
        (b"bTRC", curve),
    ];

    let mut table = (tags.len() as u32).to_be_bytes().to_vec();
    let mut data: Vec<u8> = Vec::new();
    let first = 128 + 4 + 12 * tags.len();
    let mut placed: Vec<(Vec<u8>, usize)> = Vec::new();
    for (name, tag) in tags {
        // The three curves are one: tags may share their data.
        let offset = placed.iter().find(|p| p.0 == tag).map(|p| p.1).unwrap_or_else(|| {
            let offset = first + data.len();
            data.extend(&tag);
            data.resize(data.len().next_multiple_of(4), 0);
            placed.push((tag.clone(), offset));
            offset
        });
        table.extend(name);
        table.extend((offset as u32).to_be_bytes());
        table.extend((tag.len() as u32).to_be_bytes());
    }

    let mut bytes = header((first + data.len()) as u32);
    bytes.extend(table);
    bytes.extend(data);
    bytes
}

fn header(size: u32) -> Vec<u8> {
    let mut bytes = vec![0; 128];
    let mut put = |at: usize, what: &[u8]| bytes[at..at + what.len()].copy_from_slice(what);
    put(0, &size.to_be_bytes());
    put(8, &[4, 0x40]); // version 4.4
    put(12, b"mntrRGB XYZ ");
    put(24, &[7, 232, 0, 1, 0, 1]); // a fixed date, 2024-01-01: the same bytes every time
    put(36, b"acsp");
    put(64, &1_u32.to_be_bytes()); // media-relative colorimetric
    for (i, value) in PCS_WHITE.into_iter().enumerate() {
        put(68 + 4 * i, &fixed(value));
    }
    bytes
}

/// s15Fixed16Number.
fn fixed(value: f64) -> [u8; 4] {
    ((value * 65536.0).round() as i32).to_be_bytes()
}

fn tag(kind: &[u8; 4], numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    let mut bytes = kind.to_vec();
    bytes.extend([0; 4]);
    bytes.extend(numbers.into_iter().flat_map(fixed));
    bytes
}

fn xyz_tag(xyz: [f64; 3]) -> Vec<u8> {
    tag(b"XYZ ", xyz)
}

fn matrix_tag(matrix: &[[f64; 3]; 3]) -> Vec<u8> {
    tag(b"sf32", matrix.iter().flatten().copied())
}

/// Parametric curve, function type 3: `(a v + b)^g` from d on, `c v` below; parameters g, a, b, c, d.
fn curve_tag(parameters: [f64; 5]) -> Vec<u8> {
    let mut bytes = b"para\0\0\0\0".to_vec();
    bytes.extend([0, 3, 0, 0]);
    bytes.extend(parameters.into_iter().flat_map(fixed));
    bytes
}

/// multiLocalizedUnicode with one record, American English as the specification's own examples use.
fn text_tag(text: &str) -> Vec<u8> {
    let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let mut bytes = b"mluc\0\0\0\0".to_vec();
    bytes.extend(1_u32.to_be_bytes());
    bytes.extend(12_u32.to_be_bytes());
    bytes.extend(b"enUS");
    bytes.extend((utf16.len() as u32).to_be_bytes());
    bytes.extend(28_u32.to_be_bytes());
    bytes.extend(utf16);
    bytes
}

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// The way from encoded to linear values, as the parameters g, a, b, c, d of [`curve_tag`]: the decoding of
/// IEC 61966-2-1, and that of ITU-R BT.2020-2 with the constants of its table 4 to more digits.
fn curve(space: OutputSpace) -> [f64; 5] {
    match space {
        OutputSpace::Srgb | OutputSpace::DisplayP3 => [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045],
        OutputSpace::Rec2020 => {
            let (alpha, beta) = (1.099_296_826_809_44, 0.018_053_968_510_807);
            [1.0 / 0.45, 1.0 / alpha, (alpha - 1.0) / alpha, 1.0 / 4.5, 4.5 * beta]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tag_of<'a>(profile: &'a [u8], name: &[u8; 4]) -> &'a [u8] {
        let number = |at: usize| u32::from_be_bytes(profile[at..at + 4].try_into().unwrap()) as usize;
        let entry = (0..number(128)).map(|i| 132 + 12 * i).find(|at| &profile[*at..at + 4] == name).unwrap();
        &profile[number(entry + 4)..number(entry + 4) + number(entry + 8)]
    }

    fn numbers(tag: &[u8], from: usize) -> Vec<f64> {
        tag[from..].chunks(4).map(|b| f64::from(i32::from_be_bytes(b.try_into().unwrap())) / 65536.0).collect()
    }

    #[test]
    fn the_profile_is_whole_and_its_primaries_add_to_white() {
        for space in [OutputSpace::DisplayP3, OutputSpace::Rec2020] {
            let profile = profile(space);
            assert_eq!(u32::from_be_bytes(profile[..4].try_into().unwrap()) as usize, profile.len());
            assert_eq!(&profile[36..40], b"acsp");
            let columns = [b"rXYZ", b"gXYZ", b"bXYZ"].map(|name| numbers(tag_of(&profile, name), 8));
            for (axis, white) in PCS_WHITE.into_iter().enumerate() {
                let sum: f64 = columns.iter().map(|c| c[axis]).sum();
                assert!((sum - white).abs() < 5e-5, "{space:?}: {sum} for {white}");
            }
            assert_eq!(tag_of(&profile, b"rTRC"), tag_of(&profile, b"bTRC"));
        }
        // The primaries of Display P3 adapted to D50, as in the profile that Apple published with it.
        let red = numbers(tag_of(&profile(OutputSpace::DisplayP3), b"rXYZ"), 8);
        for (got, wanted) in red.into_iter().zip([0.5151, 0.2412, -0.0011]) {
            assert!((got - wanted).abs() < 1e-4, "{got} for {wanted}");
        }
    }
    #[test]
    fn the_curve_undoes_the_encoding() {
        for space in OutputSpace::ALL {
            let profile = profile(space);
            let [g, a, b, c, d] = numbers(tag_of(&profile, b"gTRC"), 12).try_into().unwrap();
            for i in 0..=1000 {
                let encoded = f64::from(i) / 1000.0;
                let linear = if encoded >= d { (a * encoded + b).powf(g) } else { c * encoded };
                let wanted = space.space().decode([encoded; 3])[0];
                // Parameters are kept to 1/65536.
                assert!((linear - wanted).abs() < 5e-5, "{space:?} {encoded}: {linear} for {wanted}");
            }
        }
    }
}
