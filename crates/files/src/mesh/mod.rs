//! Meshes: triangles with what their corners carry, from OBJ, PLY, glTF and GLB files.
//!
//! The formats themselves are read by `tobj`, `ply-rs-bw` and `gltf`; here their answers become one thing, checked:
//! every coordinate is finite, every corner exists, nothing is larger than the file that declares it.

mod gltf_file;
mod gltf_numbers;
mod obj_file;
mod ply_body;
mod ply_file;
mod ply_words;
mod topology;
mod triangles;

#[cfg(test)]
mod tests;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

pub use topology::OpenEdge;
pub use triangles::{MAX_TRIANGLES, Mesh};

/// Most bytes of a mesh file, and of each file of buffers that it names: 2 GiB.
pub const MAX_MESH_BYTES: u64 = 1 << 31;
/// The formats, by the ending of a file's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY, text or binary.
    Ply,
    /// glTF 2.0, as text with buffers beside it or inside, or as GLB.
    Gltf,
}

impl MeshFormat {
    /// The format of a file of this name; the message names those that are read.
    pub fn of(path: &Path) -> Result<MeshFormat, String> {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        match ending.as_deref() {
            Some("obj") => Ok(MeshFormat::Obj),
            Some("ply") => Ok(MeshFormat::Ply),
            Some("gltf" | "glb") => Ok(MeshFormat::Gltf),
            _ => Err("a mesh is a file .obj, .ply, .gltf or .glb".into()),
        }
    }
}

/// A mesh from the bytes of a file. `beside` reads a file that this one names (buffers of glTF), by its relative name.
///
/// `part` is a JSON pointer to a mesh of glTF or to one of its primitives, `/meshes/3` or `/meshes/3/primitives/0`: that one
/// alone, as it is stored, wherever nodes put it.
///
/// Errors say what is wrong and where in the file: no triangles, indices out of range, coordinates that are no numbers,
/// more elements declared than the file has bytes for.
pub fn decode_mesh(
    bytes: &[u8],
    format: MeshFormat,
    part: Option<&str>,
    beside: &dyn Fn(&str) -> Result<Vec<u8>, String>,
) -> Result<Mesh, String> {
    let read = || match format {
        MeshFormat::Obj => obj_file::read(bytes),
        MeshFormat::Ply => ply_file::read(bytes),
        MeshFormat::Gltf => gltf_file::read(bytes, part, beside),
    };
    if part.is_some() && format != MeshFormat::Gltf {
        return Err("only files of glTF have parts; this one is read whole".into());
    }
    // A file made to trip a decoder must not take the program with it.
    let mesh = catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("it is damaged".to_owned()))?;
    mesh.checked()
}
