//! ICC profiles in: spaces of three primaries with curves, as cameras and editors attach them to RGB pictures.
//!
//! Source: ICC.1:2022, header (7.2), tag types `curv` (10.6), `para` (10.18), `XYZ ` (10.31).

use iridesce_optics::color::{D65_XY, Matrix, Space, bradford, xyz_of_xy};

use crate::words::quoted;

/// White of the profile connection space, D50 (7.2.16).
const PCS_WHITE: [f64; 3] = [0.9642, 1.0, 0.8249];
/// Longest profile of primaries and curves; three curves of 4096 entries have 24 KiB.
const MAX_BYTES: usize = 4 << 20;

/// From stored numbers in [0, 1] to linear Rec.709.
#[derive(Debug, Clone)]
pub struct Transfer {
    curves: [Curve; 3],
    matrix: Matrix,
}

/// From a stored number to linear light.
#[derive(Debug, Clone)]
enum Curve {
    Linear,
    Gamma(f64),
    /// Function types of `para`: g, a, b, c, d, e, f with y = (a x + b)^g + e for x >= d, else c x + f.
    Parametric([f64; 7]),
    Table(Vec<u16>),
}

/// A profile.
#[derive(Debug, Clone)]
pub struct Profile {
    /// What it calls itself.
    pub name: String,
    pub transfer: Transfer,
}

const UNIT: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// IEC 61966-2-1: the curve of sRGB.
const SRGB: [f64; 7] = [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045, 0.0, 0.0];

impl Transfer {
    /// Linear Rec.709 as it stands.
    pub fn linear() -> Transfer {
        Transfer { curves: [Curve::Linear, Curve::Linear, Curve::Linear], matrix: UNIT }
    }

    /// IEC 61966-2-1.
    pub fn srgb() -> Transfer {
        Transfer { curves: std::array::from_fn(|_| Curve::Parametric(SRGB)), matrix: UNIT }
    }

    /// One pixel.
    pub fn rec709(&self, stored: [f32; 3]) -> [f32; 3] {
        let own: [f64; 3] = std::array::from_fn(|i| self.curves[i].linear(f64::from(stored[i])));
        std::array::from_fn(|i| (0..3).map(|j| self.matrix[i][j] * own[j]).sum::<f64>() as f32)
    }
}

impl Curve {
    fn linear(&self, x: f64) -> f64 {
        match self {
            Curve::Linear => x,
            Curve::Gamma(gamma) => x.max(0.0).powf(*gamma),
            Curve::Parametric([g, a, b, c, d, e, f]) => {
                if x >= *d {
                    (a * x + b).max(0.0).powf(*g) + e
                } else {
                    c * x + f
                }
            }
            Curve::Table(table) => {
                let place = x.clamp(0.0, 1.0) * (table.len() - 1) as f64;
                let below = (place as usize).min(table.len() - 2);
                let (low, high) = (f64::from(table[below]), f64::from(table[below + 1]));
                (low + (high - low) * (place - below as f64)) / 65_535.0
            }
        }
    }

    /// A curve's tag and what follows it.
    fn read(tag: &[u8]) -> Option<Curve> {
        match tag.get(..4)? {
            b"curv" => {
                let count = long(tag, 8)?;
                match count {
                    0 => Some(Curve::Linear),
                    1 => Some(Curve::Gamma(f64::from(short(tag, 12)?) / 256.0)),
                    _ => {
                        let entries = tag.get(12..12_usize.checked_add(count.checked_mul(2)?)?)?;
                        Some(Curve::Table(
                            entries.as_chunks::<2>().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect(),
                        ))
                    }
                }
            }
            b"para" => {
                let kind = short(tag, 8)?;
                let count = *[1, 3, 4, 5, 7].get(usize::from(kind))?;
                let mut given = [0.0; 7];
                for (place, value) in given.iter_mut().take(count).enumerate() {
                    *value = fixed(tag, 12 + 4 * place)?;
                }
                let [g, a, b, c, d, e, f] = given;
                Some(match kind {
                    0 => Curve::Gamma(g),
                    1 if a != 0.0 => Curve::Parametric([g, a, b, 0.0, -b / a, 0.0, 0.0]),
                    2 if a != 0.0 => Curve::Parametric([g, a, b, 0.0, -b / a, c, c]),
                    3 => Curve::Parametric([g, a, b, c, d, 0.0, 0.0]),
                    4 => Curve::Parametric([g, a, b, c, d, e, f]),
                    _ => return None,
                })
            }
            _ => None,
        }
    }
}

fn short(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes(bytes.get(at..at.checked_add(2)?)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<usize> {
    usize::try_from(u32::from_be_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?)).ok()
}

/// s15Fixed16.
fn fixed(bytes: &[u8], at: usize) -> Option<f64> {
    let raw = i32::from_be_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?);
    Some(f64::from(raw) / 65_536.0)
}

impl Profile {
    /// The profile in its bytes. Those that are tables, or of other than RGB, are refused by name.
    pub fn read(bytes: &[u8]) -> Result<Profile, String> {
        let damaged = || "its colour profile is damaged".to_owned();
        if bytes.len() > MAX_BYTES {
            return Err(format!("its colour profile has {} bytes; at most {MAX_BYTES} are read", bytes.len()));
        }
        let name = tag(bytes, b"desc").map(words).unwrap_or_default();
        let space = bytes.get(16..20).ok_or_else(damaged)?;
        if !matches!(space, b"RGB " | b"GRAY") {
            let space = String::from_utf8_lossy(space);
            return Err(format!(
                "its colour profile {} is of {}; save it as sRGB",
                quoted(&name),
                quoted(space.trim())
            ));
        }
        let cannot = || {
            format!(
                "its colour profile {} is no set of primaries and curves; save it as sRGB or Display P3",
                quoted(&name)
            )
        };
        if space == b"GRAY" {
            let curve = tag(bytes, b"kTRC").and_then(Curve::read).ok_or_else(cannot)?;
            let transfer = Transfer { curves: [curve.clone(), curve.clone(), curve], matrix: UNIT };
            return Ok(Profile { name, transfer });
        }
        let mut columns = [[0.0; 3]; 3];
        let mut curves = Vec::new();
        for (column, [primary, curve]) in
            columns.iter_mut().zip([[b"rXYZ", b"rTRC"], [b"gXYZ", b"gTRC"], [b"bXYZ", b"bTRC"]])
        {
            let place = tag(bytes, primary).ok_or_else(cannot)?;
            for (i, value) in column.iter_mut().enumerate() {
                *value = fixed(place, 8 + 4 * i).ok_or_else(damaged)?;
            }
            curves.push(tag(bytes, curve).and_then(Curve::read).ok_or_else(cannot)?);
        }
        // From the profile's RGB to D50, to D65, to Rec.709.
        let from_pcs = bradford(PCS_WHITE, xyz_of_xy(D65_XY));
        let to_rgb = Space::LinearSrgb.rgb_from_xyz().ok_or_else(damaged)?;
        let to_pcs: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        let matrix = multiply(&to_rgb, &multiply(&from_pcs, &to_pcs));
        let curves = curves.try_into().map_err(|_| damaged())?;
        Ok(Profile { name, transfer: Transfer { curves, matrix } })
    }
}

/// The bytes of a tag from its beginning on.
fn tag<'a>(bytes: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    let count = long(bytes, 128)?.min(1000);
    let entry = (0..count).map(|i| 132 + 12 * i).find(|&at| bytes.get(at..at + 4) == Some(name))?;
    let (offset, size) = (long(bytes, entry + 4)?, long(bytes, entry + 8)?);
    bytes.get(offset..offset.checked_add(size)?)
}

/// The text of a `mluc` or an old `desc` tag.
fn words(tag: &[u8]) -> String {
    match tag.get(..4) {
        Some(b"mluc") => {
            let (Some(size), Some(offset)) = (long(tag, 20), long(tag, 24)) else { return String::new() };
            let text = offset.checked_add(size).and_then(|end| tag.get(offset..end)).unwrap_or_default();
            let units = text.as_chunks::<2>().0.iter().map(|&pair| u16::from_be_bytes(pair));
            char::decode_utf16(units).map(|letter| letter.unwrap_or('?')).take(100).collect()
        }
        Some(b"desc") => {
            let size = long(tag, 8).unwrap_or(0).min(100);
            let text = tag.get(12..12 + size).unwrap_or_default();
            String::from_utf8_lossy(text).trim_end_matches('\0').to_owned()
        }
        _ => String::new(),
    }
}

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::icc;
    use crate::space::OutputSpace;

    #[test]
    fn our_own_profiles_lead_back_to_rec709() {
        for space in OutputSpace::ALL {
            let profile = Profile::read(&icc::profile(space)).unwrap();
            assert_eq!(profile.name, space.title());
            // White is white, and green of Rec.709 is what the space's own matrices say.
            let white = profile.transfer.rec709([1.0; 3]);
            assert!(white.iter().all(|value| (value - 1.0).abs() < 2e-3), "{white:?}");
            let half = profile.transfer.rec709([0.5; 3])[0];
            let wanted = if space == OutputSpace::Rec2020 { 0.2596 } else { 0.2140 };
            assert!((half - wanted).abs() < 2e-3, "{space:?} {half}");
        }
        let p3 = Profile::read(&icc::profile(OutputSpace::DisplayP3)).unwrap().transfer.rec709([0.0, 1.0, 0.0]);
        // Green of Display P3 lies outside Rec.709: (-0.2249, 1.0421, -0.0786).
        for (found, wanted) in p3.iter().zip([-0.2249, 1.0421, -0.0786]) {
            assert!((found - wanted).abs() < 2e-3, "{p3:?}");
        }
    }

    #[test]
    fn others_and_damaged_ones_are_refused() {
        let good = icc::profile(OutputSpace::DisplayP3);
        let mut cmyk = good.clone();
        cmyk[16..20].copy_from_slice(b"CMYK");
        assert!(Profile::read(&cmyk).unwrap_err().contains("\"CMYK\"; save it as sRGB"));
        for length in 0..good.len() {
            let _ = Profile::read(&good[..length]);
        }
        for at in 0..good.len() {
            let mut wrong = good.clone();
            wrong[at] = 0xFF;
            let _ = Profile::read(&wrong);
        }
        assert!(Profile::read(&good[..140]).is_err());
    }
}
