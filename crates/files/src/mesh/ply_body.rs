//! The bodies of binary PLY files, read in one go: a million faces as things of their own, each with a list of its own, take many times
//! as long. What is unusual here (other types, faces that are none, bytes that are missing) is left to the library, which then says
//! what is wrong.

use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyType, ScalarType};

use super::triangles::{MAX_TRIANGLES, Mesh};

/// What a property of a vertex is to a mesh.
#[derive(Clone, Copy, PartialEq)]
pub enum Role {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Thickness,
}

impl Role {
    /// By the name of the property; `None` for what is left out.
    pub fn of(name: &str) -> Option<Role> {
        Some(match name {
            "x" => Role::Position(0),
            "y" => Role::Position(1),
            "z" => Role::Position(2),
            "nx" => Role::Normal(0),
            "ny" => Role::Normal(1),
            "nz" => Role::Normal(2),
            "u" | "s" | "texture_u" => Role::Uv(0),
            "v" | "t" | "texture_v" => Role::Uv(1),
            "thickness_nm" => Role::Thickness,
            _ => return None,
        })
    }
}

/// Whether a property holds the corners of a face.
pub fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

/// Numbers one after the other.
struct Bytes<'a> {
    left: &'a [u8],
    is_little: bool,
}

impl Bytes<'_> {
    #[inline(always)]
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, left) = self.left.split_first_chunk::<N>()?;
        self.left = left;
        let mut first = *first;
        if !self.is_little {
            first.reverse();
        }
        Some(first)
    }

    #[inline(always)]
    fn number(&mut self, kind: &ScalarType) -> Option<f64> {
        Some(match kind {
            ScalarType::Float => f64::from(f32::from_le_bytes(self.take()?)),
            ScalarType::Double => f64::from_le_bytes(self.take()?),
            whole => self.whole(whole)? as f64,
        })
    }

    #[inline(always)]
    fn whole(&mut self, kind: &ScalarType) -> Option<i64> {
        Some(match kind {
            ScalarType::Char => i64::from(i8::from_le_bytes(self.take()?)),
            ScalarType::UChar => i64::from(u8::from_le_bytes(self.take()?)),
            ScalarType::Short => i64::from(i16::from_le_bytes(self.take()?)),
            ScalarType::UShort => i64::from(u16::from_le_bytes(self.take()?)),
            ScalarType::Int => i64::from(i32::from_le_bytes(self.take()?)),
            ScalarType::UInt => i64::from(u32::from_le_bytes(self.take()?)),
            ScalarType::Float | ScalarType::Double => return None,
        })
    }
}

impl Bytes<'_> {
    fn skip(&mut self, property: &PropertyType) -> Option<()> {
        let (kind, count) = match property {
            PropertyType::Scalar(kind) => (kind, 1),
            PropertyType::List(count_kind, kind) => (kind, usize::try_from(self.whole(count_kind)?).ok()?),
        };
        let size = match kind {
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        };
        self.left = self.left.get(count.checked_mul(size)?..)?;
        Some(())
    }
}

/// Vertices and faces of a binary file; `None` where the library is to read it.
pub fn read(bytes: &[u8], header: &Header) -> Option<Mesh> {
    let is_little = match header.encoding {
        Encoding::BinaryLittleEndian => true,
        Encoding::BinaryBigEndian => false,
        Encoding::Ascii => return None,
    };
    let mut bytes = Bytes { left: body(bytes)?, is_little };
    let mut mesh = Mesh::default();
    for (name, definition) in &header.elements {
        if definition.count > bytes.left.len() || definition.count > MAX_TRIANGLES {
            return None;
        }
        match name.as_str() {
            "vertex" => vertices(&mut bytes, definition, &mut mesh)?,
            "face" => faces(&mut bytes, definition, &mut mesh)?,
            _ => {
                for _ in 0..definition.count {
                    definition.properties.values().try_for_each(|property| bytes.skip(&property.data_type))?;
                }
                mesh.notes.push(format!("its elements \"{name}\" are left out"));
            }
        }
    }
    Some(mesh)
}

/// What comes after the head.
fn body(bytes: &[u8]) -> Option<&[u8]> {
    const END: &[u8] = b"\nend_header";
    let at = bytes.windows(END.len()).position(|window| window == END)?;
    let rest = &bytes[at + END.len()..];
    rest.strip_prefix(b"\n").or_else(|| rest.strip_prefix(b"\r\n"))
}

fn vertices(bytes: &mut Bytes<'_>, definition: &ElementDef, mesh: &mut Mesh) -> Option<()> {
    let mut kinds = Vec::new();
    for (name, property) in &definition.properties {
        let PropertyType::Scalar(kind) = &property.data_type else { return None };
        if is_corners(name) {
            return None;
        }
        kinds.push((Role::of(name), kind.clone()));
    }
    let has = |role: Role| kinds.iter().any(|kind| kind.0 == Some(role));
    let [has_normals, has_uv, has_thickness] =
        [(0..3).all(|axis| has(Role::Normal(axis))), (0..2).all(|axis| has(Role::Uv(axis))), has(Role::Thickness)];
    if !(0..3).all(|axis| has(Role::Position(axis))) {
        return None;
    }
    let count = definition.count;
    let (mut normals, mut uvs, mut thicknesses) = (Vec::new(), Vec::new(), Vec::new());
    mesh.positions.reserve(count);
    for _ in 0..count {
        let (mut position, mut normal, mut uv, mut thickness_nm) = ([0.0; 3], [0.0; 3], [0.0; 2], 0.0);
        for (role, kind) in &kinds {
            let value = bytes.number(kind)?;
            match role {
                Some(Role::Position(axis)) => position[*axis] = value,
                Some(Role::Normal(axis)) => normal[*axis] = value as f32,
                Some(Role::Uv(axis)) => uv[*axis] = value as f32,
                Some(Role::Thickness) => thickness_nm = value as f32,
                None => {}
            }
        }
        mesh.positions.push(position);
        if has_normals {
            normals.push(normal);
        }
        if has_uv {
            uvs.push(uv);
        }
        if has_thickness {
            thicknesses.push(thickness_nm);
        }
    }
    mesh.normals = has_normals.then_some(normals);
    mesh.uv = has_uv.then_some(uvs);
    mesh.thickness_nm = has_thickness.then_some(thicknesses);
    Some(())
}

/// What nearly all files hold: a count of three and three whole numbers, thirteen bytes after thirteen. Stops before the first face that
/// is anything else; gives how many there were.
fn plain_triangles(bytes: &mut Bytes<'_>, most: usize, mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    for row in bytes.left.as_chunks::<13>().0.iter().take(most) {
        let corner = |at: usize| u32::from_le_bytes([row[at], row[at + 1], row[at + 2], row[at + 3]]);
        let corners = [corner(1), corner(5), corner(9)];
        // Less than nothing, in files of numbers with a sign.
        if row[0] != 3 || corners.iter().any(|corner| *corner > i32::MAX as u32) {
            break;
        }
        mesh.triangles.push(corners);
    }
    let count = mesh.triangles.len() - before;
    bytes.left = &bytes.left[13 * count..];
    count
}

/// Polygons as fans around their first corner.
fn faces(bytes: &mut Bytes<'_>, definition: &ElementDef, mesh: &mut Mesh) -> Option<()> {
    if definition.properties.keys().filter(|name| is_corners(name)).count() != 1 {
        return None;
    }
    mesh.triangles.reserve(definition.count);
    let plain = match definition.properties.values().next().map(|property| &property.data_type) {
        Some(PropertyType::List(ScalarType::UChar, ScalarType::Int | ScalarType::UInt))
            if definition.properties.len() == 1 && bytes.is_little =>
        {
            plain_triangles(bytes, definition.count, mesh)
        }
        _ => 0,
    };
    for _ in plain..definition.count {
        for (name, property) in &definition.properties {
            if !is_corners(name) {
                bytes.skip(&property.data_type)?;
                continue;
            }
            let PropertyType::List(count_kind, kind) = &property.data_type else { return None };
            let count = bytes.whole(count_kind)?;
            if count < 3 {
                return None;
            }
            let mut corner = || u32::try_from(bytes.whole(kind)?).ok();
            let (first, mut last) = (corner()?, corner()?);
            for _ in 2..count {
                let next = corner()?;
                mesh.triangles.push([first, last, next]);
                last = next;
            }
        }
        if mesh.triangles.len() > MAX_TRIANGLES {
            return None;
        }
    }
    Some(())
}
