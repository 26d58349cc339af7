//! glTF 2.0 and GLB, by `gltf`: the meshes of the default scene where its nodes put them.

use gltf::buffer::Source;
use gltf::mesh::{Mode, Semantic};
use gltf::{Document, Gltf, Node, Primitive};

use iridesce_numerics::vector::cross;

use crate::words::quoted;

use super::gltf_numbers::Numbers;
use super::triangles::{MAX_TRIANGLES, Mesh};

/// Deepest tree of nodes.
const DEEPEST: usize = 256;

type Matrix = [[f64; 4]; 4];

pub fn read(
    bytes: &[u8],
    part: Option<&str>,
    beside: &dyn Fn(&str) -> Result<Vec<u8>, String>,
) -> Result<Mesh, String> {
    let wrong = |error: gltf::Error| format!("it is no glTF file that can be read: {error}");
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(wrong)?;
    let root = without_needless_extensions(with_accessors(document.into_json())?)?;
    let document = Document::from_json(root).map_err(wrong)?;
    let buffers = buffers(&document, blob, beside)?;
    let mut reader = Reader {
        numbers: Numbers::of(&buffers),
        mesh: Mesh { is_in_metres: true, ..Mesh::default() },
        carried: [None; 2],
        met: vec![false; document.nodes().count()],
    };
    if let Some(pointer) = part {
        reader.part(&document, pointer)?;
        return Ok(reader.mesh);
    }
    let scene = document.default_scene().or_else(|| document.scenes().next());
    match scene {
        Some(scene) => {
            for node in scene.nodes() {
                reader.node(&node, &IDENTITY, 0)?;
            }
        }
        // A file without a scene is a shelf of meshes.
        None => {
            for mesh in document.meshes() {
                reader.mesh(&mesh, &IDENTITY)?;
            }
        }
    }
    let mut mesh = reader.mesh;
    if document.materials().next().is_some() {
        mesh.notes.push("its own materials are left out: the scene says what the surface is".into());
    }
    for (what, is_there) in [
        ("animations", document.animations().next().is_some()),
        ("skins", document.skins().next().is_some()),
        ("cameras", document.cameras().next().is_some()),
    ] {
        if is_there {
            mesh.notes.push(format!("its {what} are left out"));
        }
    }
    Ok(mesh)
}

/// The same file, if every accessor of a primitive is there: the library's validation looks positions up before it has asked.
fn with_accessors(root: gltf::json::Root) -> Result<gltf::json::Root, String> {
    let count = root.accessors.len();
    for (number, mesh) in root.meshes.iter().enumerate() {
        let wanted = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if let Some(missing) = wanted.map(|accessor| accessor.value()).find(|accessor| *accessor >= count) {
            return Err(format!("mesh {number} asks for accessor {missing}, and there are {count}"));
        }
    }
    Ok(root)
}

/// The same file, if all that it says a reader must know is known here, or changes no triangle: materials, textures and lights
/// are left out anyway.
fn without_needless_extensions(mut root: gltf::json::Root) -> Result<gltf::json::Root, String> {
    let is_compressed = |name: &str| name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression";
    // (Draco without being required has a plain copy beside it; the copy of meshopt is no part of the file.)
    if let Some(name) = root.extensions_required.iter().chain(&root.extensions_used).find(|name| is_compressed(name)) {
        return Err(format!("its meshes are compressed ({name}); save it without compression"));
    }
    let changes_nothing = |name: &String| {
        name == "KHR_mesh_quantization"
            || [
                "KHR_materials_",
                "KHR_texture_",
                "EXT_texture_",
                "MSFT_texture_",
                "KHR_lights_",
                "EXT_lights_",
                "KHR_xmp",
            ]
            .iter()
            .any(|kind| name.starts_with(kind))
    };
    root.extensions_required.retain(|name| !changes_nothing(name));
    match root.extensions_required.first() {
        Some(name) => Err(format!("it needs the extension {}, which is not read; save it without", quoted(name))),
        None => Ok(root),
    }
}

/// A relative name as a file has it: `%20` is a blank. Where that is no text, the name as it stands.
fn decoded(uri: &str) -> String {
    percent_encoding::percent_decode_str(uri).decode_utf8().map_or_else(|_| uri.to_owned(), String::from)
}

fn buffers(
    document: &Document,
    blob: Option<Vec<u8>>,
    beside: &dyn Fn(&str) -> Result<Vec<u8>, String>,
) -> Result<Vec<Vec<u8>>, String> {
    let mut blob = blob;
    let mut all = Vec::new();
    for buffer in document.buffers() {
        let at = buffer.index();
        let data = match buffer.source() {
            Source::Bin => blob.take().ok_or_else(|| format!("buffer {at} is missing: the file has no binary part"))?,
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(inside) => decode_inside(inside).map_err(|why| format!("buffer {at} {why}"))?,
                // Names are percent-encoded by the format's rule; some writers leave them as they are.
                None => beside(&decoded(uri))
                    .or_else(|why| if decoded(uri) == uri { Err(why) } else { beside(uri).map_err(|_| why) })
                    .map_err(|why| format!("buffer {at} ({}): {why}", quoted(uri)))?,
            },
        };
        if data.len() < buffer.length() {
            return Err(format!("buffer {at} declares {} bytes and has {}", buffer.length(), data.len()));
        }
        all.push(data);
    }
    Ok(all)
}

fn decode_inside(uri: &str) -> Result<Vec<u8>, String> {
    use base64::Engine;
    let Some((_, text)) = uri.split_once(";base64,") else { return Err("is a data URI without base64".into()) };
    base64::engine::general_purpose::STANDARD.decode(text).map_err(|error| format!("is no base64: {error}"))
}

const IDENTITY: Matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The product of two matrices that are stored by columns, as glTF stores them.
fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|column| std::array::from_fn(|row| (0..4).map(|k| a[k][row] * b[column][k]).sum()))
}

struct Reader<'a> {
    numbers: Numbers<'a>,
    mesh: Mesh,
    /// Whether every primitive so far has normals, and texture coordinates; `None` before the first.
    carried: [Option<bool>; 2],
    /// Nodes met so far.
    met: Vec<bool>,
}

/// The vertices of a primitive, as its file has them.
struct Vertices {
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    uv: Option<Vec<[f32; 2]>>,
}

impl Reader<'_> {
    fn node(&mut self, node: &Node<'_>, parent: &Matrix, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("its nodes are nested more than {DEEPEST} deep"));
        }
        // Nodes are a tree by the format's rule. Where one hangs below two others, a small file could hold 2^256 meshes.
        if std::mem::replace(&mut self.met[node.index()], true) {
            return Err(format!("its node {} hangs below more than one other", node.index()));
        }
        let own = node.transform().matrix().map(|column| column.map(f64::from));
        let world = product(parent, &own);
        if let Some(mesh) = node.mesh() {
            self.mesh(&mesh, &world)?;
        }
        for child in node.children() {
            self.node(&child, &world, depth + 1)?;
        }
        Ok(())
    }

    /// One mesh, or one primitive of it, as it is stored.
    fn part(&mut self, document: &Document, pointer: &str) -> Result<(), String> {
        let unknown = || {
            format!(
                "its part is /meshes/M or /meshes/M/primitives/P, M below {}, got {}",
                document.meshes().count(),
                crate::quoted(pointer)
            )
        };
        let words: Vec<&str> = pointer.split('/').collect();
        let number = |word: &str| word.parse::<usize>().map_err(|_| unknown());
        let (mesh, primitive) = match words.as_slice() {
            ["", "meshes", mesh] => (number(mesh)?, None),
            ["", "meshes", mesh, "primitives", primitive] => (number(mesh)?, Some(number(primitive)?)),
            _ => return Err(unknown()),
        };
        let mesh = document.meshes().nth(mesh).ok_or_else(unknown)?;
        match primitive {
            None => self.mesh(&mesh, &IDENTITY),
            Some(at) => self.primitive(&mesh.primitives().nth(at).ok_or_else(unknown)?, &IDENTITY),
        }
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>, world: &Matrix) -> Result<(), String> {
        for primitive in mesh.primitives() {
            self.primitive(&primitive, world)
                .map_err(|why| format!("mesh {}, primitive {}: {why}", mesh.index(), primitive.index()))?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, world: &Matrix) -> Result<(), String> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.mesh.notes.push("its points and lines are left out".into());
            return Ok(());
        }
        let numbers = self.numbers;
        let positions = primitive.get(&Semantic::Positions).ok_or("it has no positions")?;
        let positions: Vec<[f32; 3]> = numbers.floats(&positions, "positions")?;
        let count = positions.len();
        let corners: Vec<u32> = match primitive.indices() {
            Some(indices) => numbers.indices(&indices)?,
            None => (0..count as u32).collect(),
        };
        let first = self.mesh.positions.len();
        if first + count > MAX_TRIANGLES || self.mesh.triangles.len() + corners.len() > 3 * MAX_TRIANGLES {
            return Err(format!("there are more than {MAX_TRIANGLES} triangles"));
        }
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(format!("an index is {corner}, and there are {count} vertices"));
        }
        let of_each = |what: &str, held: usize| match held == count {
            true => Ok(()),
            false => Err(format!("it has {held} {what} for {count} vertices")),
        };
        let normals: Option<Vec<[f32; 3]>> = match primitive.get(&Semantic::Normals) {
            Some(accessor) => Some(numbers.floats(&accessor, "normals")?),
            None => None,
        };
        let uv: Option<Vec<[f32; 2]>> = match primitive.get(&Semantic::TexCoords(0)) {
            Some(accessor) => Some(numbers.floats(&accessor, "texture coordinates")?),
            None => None,
        };
        of_each("normals", normals.as_ref().map_or(count, Vec::len))?;
        of_each("texture coordinates", uv.as_ref().map_or(count, Vec::len))?;
        self.carry(0, normals.is_some(), "normals");
        self.carry(1, uv.is_some(), "texture coordinates");

        self.place(Vertices { positions, normals, uv }, (mode, &corners), world);
        Ok(())
    }

    /// Adds the vertices of a primitive, turned into the world, and its triangles.
    fn place(
        &mut self,
        Vertices { positions, normals, uv }: Vertices,
        (mode, corners): (Mode, &[u32]),
        world: &Matrix,
    ) {
        let first = self.mesh.positions.len() as u32;
        let mesh = &mut self.mesh;
        let axes = [world[0], world[1], world[2]].map(|c| [c[0], c[1], c[2]]);
        let apply = |v: [f64; 3]| -> [f64; 3] { std::array::from_fn(|row| (0..3).map(|k| axes[k][row] * v[k]).sum()) };
        mesh.positions.extend(positions.iter().map(|p| {
            let turned = apply(p.map(f64::from));
            std::array::from_fn(|row| turned[row] + world[3][row])
        }));
        let cofactors = [cross(axes[1], axes[2]), cross(axes[2], axes[0]), cross(axes[0], axes[1])];
        let is_mirrored = (0..3).map(|k| axes[0][k] * cofactors[0][k]).sum::<f64>() < 0.0;
        // Normals go with the inverse transpose; where the nodes mirror, the winding turns and the normals with it.
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        if let (Some(all), Some(own)) = (&mut mesh.normals, normals) {
            all.extend(own.into_iter().map(|n| -> [f32; 3] {
                std::array::from_fn(|row| {
                    (sign * (0..3).map(|k| cofactors[k][row] * f64::from(n[k])).sum::<f64>()) as f32
                })
            }));
        }
        if let (Some(all), Some(own)) = (&mut mesh.uv, uv) {
            // glTF counts v from the top of a picture.
            all.extend(own.into_iter().map(|[u, v]| [u, 1.0 - v]));
        }
        let mut add = |a: u32, b: u32, c: u32| {
            let [a, b, c] = [a, b, c].map(|corner| corner + first);
            mesh.triangles.push(if is_mirrored { [a, c, b] } else { [a, b, c] });
        };
        match mode {
            Mode::Triangles => corners.chunks_exact(3).for_each(|c| add(c[0], c[1], c[2])),
            Mode::TriangleStrip => (2..corners.len()).for_each(|k| {
                let [a, b] = if k % 2 == 0 { [k - 2, k - 1] } else { [k - 1, k - 2] };
                add(corners[a], corners[b], corners[k]);
            }),
            _ => (2..corners.len()).for_each(|k| add(corners[0], corners[k - 1], corners[k])),
        }
    }

    /// Keeps a list of what all primitives carry; one that some lack is given up, and the mesh says so.
    fn carry(&mut self, which: usize, has: bool, what: &str) {
        match self.carried[which] {
            None => {
                self.carried[which] = Some(has);
                match which {
                    0 => self.mesh.normals = has.then(Vec::new),
                    _ => self.mesh.uv = has.then(Vec::new),
                }
            }
            Some(before) if before != has => {
                match which {
                    0 => self.mesh.normals = None,
                    _ => self.mesh.uv = None,
                }
                let note = format!("some of its parts have {what} and some have none: all are left out");
                if !self.mesh.notes.contains(&note) {
                    self.mesh.notes.push(note);
                }
            }
            Some(_) => {}
        }
    }
}
