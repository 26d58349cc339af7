//! Stanford PLY, text or binary, by `ply-rs-bw`; the bodies of plain binary files by our own (`ply_body`).

use std::io::BufReader;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Header, Property, PropertyAccess, PropertyAccessResult};

use super::ply_body::{self, Role, is_corners};
use super::ply_words::wrong;
use super::triangles::{MAX_TRIANGLES, Mesh};

/// A vertex or a face: each element of a file becomes one of these, whatever else it carries.
#[derive(Default)]
struct Element {
    position: [f64; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    thickness_nm: f32,
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Element {
        Element::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if is_corners(name) {
            let Some(corners) = whole_list(property) else { return PropertyAccessResult::UnsupportedType };
            self.corners = corners;
            return PropertyAccessResult::Set;
        }
        let place = match Role::of(name) {
            Some(Role::Position(axis)) => Place::Wide(&mut self.position[axis]),
            Some(Role::Normal(axis)) => Place::Narrow(&mut self.normal[axis]),
            Some(Role::Uv(axis)) => Place::Narrow(&mut self.uv[axis]),
            Some(Role::Thickness) => Place::Narrow(&mut self.thickness_nm),
            None => return PropertyAccessResult::Ignored,
        };
        let Some(value) = number(property) else { return PropertyAccessResult::UnsupportedType };
        match place {
            Place::Wide(place) => *place = value,
            Place::Narrow(place) => *place = value as f32,
        }
        PropertyAccessResult::Set
    }
}

enum Place<'a> {
    Wide(&'a mut f64),
    Narrow(&'a mut f32),
}

fn number(property: Property) -> Option<f64> {
    Some(match property {
        Property::Char(v) => f64::from(v),
        Property::UChar(v) => f64::from(v),
        Property::Short(v) => f64::from(v),
        Property::UShort(v) => f64::from(v),
        Property::Int(v) => f64::from(v),
        Property::UInt(v) => f64::from(v),
        Property::Float(v) => f64::from(v),
        Property::Double(v) => v,
        _ => return None,
    })
}

fn whole_list(property: Property) -> Option<Vec<i64>> {
    fn list<T: Into<i64>>(values: Vec<T>) -> Vec<i64> {
        values.into_iter().map(Into::into).collect()
    }
    Some(match property {
        Property::ListChar(v) => list(v),
        Property::ListUChar(v) => list(v),
        Property::ListShort(v) => list(v),
        Property::ListUShort(v) => list(v),
        Property::ListInt(v) => list(v),
        Property::ListUInt(v) => list(v),
        _ => return None,
    })
}

pub fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let header = header(bytes)?;
    let Some(mut mesh) = ply_body::read(bytes, &header) else { return read_by_library(bytes) };
    if header.elements.get("vertex").is_some_and(|vertex| has_any(vertex, &COLORS)) {
        mesh.notes.push(NOTE_OF_COLORS.into());
    }
    Ok(mesh)
}

/// Names of properties that tell of colours.
const COLORS: [&str; 3] = ["red", "r", "diffuse_red"];
const NOTE_OF_COLORS: &str = "the colours of its vertices are left out: the scene says what the surface is";

fn has_any(element: &ElementDef, names: &[&str]) -> bool {
    names.iter().any(|name| element.properties.contains_key(*name))
}

pub fn header(bytes: &[u8]) -> Result<Header, String> {
    let mut reader = Reader::new(BufReader::new(bytes));
    Parser::<Element>::new().read_header(&mut reader).map_err(|error| wrong(&error, bytes))
}

pub fn read_by_library(bytes: &[u8]) -> Result<Mesh, String> {
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(BufReader::new(bytes));
    let header = parser.read_header(&mut reader).map_err(|error| wrong(&error, bytes))?;
    let mut mesh = Mesh::default();
    let mut has = [false; 4];
    for (name, definition) in &header.elements {
        // Every element takes at least a byte: more of them than bytes are a lie, and memory is not asked for.
        if definition.count > bytes.len() || definition.count > MAX_TRIANGLES {
            return Err(format!(
                "it declares {} elements \"{name}\"; it has {} bytes, and at most {MAX_TRIANGLES} elements are read",
                definition.count,
                bytes.len()
            ));
        }
        let elements =
            parser.read_payload_for_element(&mut reader, definition, &header).map_err(|error| wrong(&error, bytes))?;
        let knows = |names: &[&str]| has_any(definition, names);
        match name.as_str() {
            "vertex" => {
                for axis in ["x", "y", "z"] {
                    if !knows(&[axis]) {
                        return Err(format!("its vertices have no property {axis}"));
                    }
                }
                has = [
                    knows(&["nx"]) && knows(&["ny"]) && knows(&["nz"]),
                    knows(&["u", "s", "texture_u"]) && knows(&["v", "t", "texture_v"]),
                    knows(&["thickness_nm"]),
                    knows(&COLORS),
                ];
                mesh.positions = elements.iter().map(|vertex| vertex.position).collect();
                mesh.normals = has[0].then(|| elements.iter().map(|vertex| vertex.normal).collect());
                mesh.uv = has[1].then(|| elements.iter().map(|vertex| vertex.uv).collect());
                mesh.thickness_nm = has[2].then(|| elements.iter().map(|vertex| vertex.thickness_nm).collect());
            }
            "face" => {
                if definition.count > 0 && !definition.properties.keys().any(|name| is_corners(name)) {
                    return Err("its faces have no property vertex_indices (or vertex_index), a list of corners".into());
                }
                triangulate(&elements, &mut mesh)?;
            }
            _ => mesh.notes.push(format!("its elements \"{name}\" are left out")),
        }
    }
    if has[3] {
        mesh.notes.push(NOTE_OF_COLORS.into());
    }
    Ok(mesh)
}

/// Polygons as fans around their first corner.
fn triangulate(faces: &[Element], mesh: &mut Mesh) -> Result<(), String> {
    for (face, Element { corners, .. }) in faces.iter().enumerate() {
        let corner = |k: usize| {
            u32::try_from(corners[k]).map_err(|_| format!("face {face} has a corner at vertex {}", corners[k]))
        };
        if corners.len() < 3 {
            return Err(format!("face {face} has {} corners; a face has at least 3", corners.len()));
        }
        for k in 2..corners.len() {
            mesh.triangles.push([corner(0)?, corner(k - 1)?, corner(k)?]);
        }
        if mesh.triangles.len() > MAX_TRIANGLES {
            return Err(format!("it has more than {MAX_TRIANGLES} triangles"));
        }
    }
    Ok(())
}
