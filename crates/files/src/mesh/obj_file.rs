//! Wavefront OBJ, by `tobj`.

use std::io::BufReader;

use tobj::{LoadError, LoadOptions};

use crate::words::quoted;

use super::triangles::{MAX_TRIANGLES, Mesh};

const OPTIONS: LoadOptions =
    LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };

pub fn read(bytes: &[u8]) -> Result<Mesh, String> {
    if let Some(at) = bytes.iter().position(|&byte| byte == 0) {
        let line = bytes[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
        return Err(format!(
            "it is no OBJ file that can be read: line {line} holds a zero, byte {at} of the file; an OBJ file is text (ASCII or UTF-8)"
        ));
    }
    // Names and comments may be in any encoding; none of them counts here.
    let text = String::from_utf8_lossy(bytes);
    let bytes = text.as_bytes();
    // A file's own materials are left out: a scene says what a surface is made of.
    let (models, _) = tobj::load_obj_buf(&mut BufReader::new(bytes), &OPTIONS, |_| Err(LoadError::OpenFileFailed))
        .map_err(|error| format!("it is no OBJ file that can be read: {}", told(error, bytes)))?;
    let mut mesh = Mesh::default();
    let (mut normals, mut uv) = (Vec::new(), Vec::new());
    let (mut all_normals, mut all_uv) = (true, true);
    for model in &models {
        let own = &model.mesh;
        let first = mesh.positions.len();
        if first + own.positions.len() / 3 > MAX_TRIANGLES
            || mesh.triangles.len() + own.indices.len() / 3 > MAX_TRIANGLES
        {
            return Err(format!("it has more than {MAX_TRIANGLES} triangles"));
        }
        let count = own.positions.len() / 3;
        mesh.positions
            .extend(own.positions.chunks_exact(3).map(|p| [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])]));
        all_normals &= own.normals.len() == 3 * count;
        all_uv &= own.texcoords.len() == 2 * count;
        normals.extend(own.normals.chunks_exact(3).map(|n| [n[0], n[1], n[2]]));
        uv.extend(own.texcoords.chunks_exact(2).map(|t| [t[0], t[1]]));
        mesh.triangles
            .extend(own.indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]].map(|corner| corner + first as u32)));
    }
    if all_normals && !normals.is_empty() {
        mesh.normals = Some(normals);
    } else if !normals.is_empty() {
        mesh.notes.push("some faces have normals and some have none: all are left out, faces are flat".into());
    }
    if all_uv && !uv.is_empty() {
        mesh.uv = Some(uv);
    } else if !uv.is_empty() {
        mesh.notes.push("some faces have texture coordinates and some have none: all are left out".into());
    }
    if models.iter().any(|model| model.mesh.material_id.is_some()) || names_materials(bytes) {
        mesh.notes.push("its own materials are left out: the scene says what the surface is".into());
    }
    Ok(mesh)
}

/// What is wrong, and in which line: the library tells what alone.
fn told(error: LoadError, bytes: &[u8]) -> String {
    let found = match error {
        LoadError::FaceVertexOutOfBounds => missing_corner(bytes, 0, b"v", "vertex"),
        LoadError::FaceTexCoordOutOfBounds => missing_corner(bytes, 1, b"vt", "texture coordinate"),
        LoadError::FaceNormalOutOfBounds => missing_corner(bytes, 2, b"vn", "normal"),
        LoadError::PositionParseError => no_numbers(bytes, b"v"),
        LoadError::TexcoordParseError => no_numbers(bytes, b"vt"),
        LoadError::NormalParseError => no_numbers(bytes, b"vn"),
        LoadError::FaceParseError | LoadError::InvalidPolygon => no_corner(bytes),
        _ => None,
    };
    found.unwrap_or_else(|| error.to_string())
}

/// The words of each line that begins with `kind`, and its number from 1.
fn lines_of<'a>(bytes: &'a [u8], kind: &'a [u8]) -> impl Iterator<Item = (usize, Vec<&'a [u8]>)> {
    let words = |line: &'a [u8]| line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
    let lines = bytes.split(|&byte| byte == b'\n').map(words).zip(1..);
    lines
        .filter(move |(words, _): &(Vec<&[u8]>, usize)| words.first() == Some(&kind))
        .map(|(words, line)| (line, words))
}

fn parsed<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The first corner of a face that asks for one of `kind` that is not there.
fn missing_corner(bytes: &[u8], place: usize, kind: &[u8], what: &str) -> Option<String> {
    let count = lines_of(bytes, kind).count() as i64;
    let is_missing = |number: i64| number == 0 || number > count || number < -count;
    lines_of(bytes, b"f").find_map(|(line, words)| {
        let corner = words[1..]
            .iter()
            .filter_map(|word| word.split(|&byte| byte == b'/').nth(place).and_then(parsed::<i64>))
            .find(|&number| is_missing(number))?;
        Some(format!("line {line}: a face asks for {what} {corner}, and there are {count}, counted from 1"))
    })
}

/// The first line of `kind` whose words are no numbers.
fn no_numbers(bytes: &[u8], kind: &[u8]) -> Option<String> {
    lines_of(bytes, kind).find_map(|(line, words)| {
        let least = if kind == b"vt" { 2 } else { 3 };
        let bad = words[1..].iter().find(|word| parsed::<f64>(word).is_none());
        match bad {
            Some(word) => Some(format!("line {line}: {} is no number", quoted(&String::from_utf8_lossy(word)))),
            None if words.len() <= least => {
                Some(format!("line {line}: it has {} numbers, not {least}", words.len() - 1))
            }
            None => None,
        }
    })
}

/// The first corner of a face that is none.
fn no_corner(bytes: &[u8]) -> Option<String> {
    lines_of(bytes, b"f").find_map(|(line, words)| {
        let is_corner = |word: &&&[u8]| {
            word.split(|&byte| byte == b'/').all(|part| part.is_empty() || parsed::<i64>(part).is_some())
        };
        let bad = words[1..].iter().find(|word| !is_corner(word))?;
        let word = quoted(&String::from_utf8_lossy(bad));
        Some(format!("line {line}: {word} is no corner of a face: whole numbers are, as 3, 3/1 or 3/1/2"))
    })
}

fn names_materials(bytes: &[u8]) -> bool {
    bytes.split(|&byte| byte == b'\n').any(|line| line.starts_with(b"mtllib") || line.starts_with(b"usemtl"))
}
