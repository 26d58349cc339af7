//! Wavefront OBJ, by `tobj`.

use std::io::BufReader;

use tobj::{LoadError, LoadOptions};

use super::triangles::{MAX_TRIANGLES, Mesh};

const OPTIONS: LoadOptions =
    LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };

pub fn read(bytes: &[u8]) -> Result<Mesh, String> {
    // A file's own materials are left out: a scene says what a surface is made of.
    let (models, _) = tobj::load_obj_buf(&mut BufReader::new(bytes), &OPTIONS, |_| Err(LoadError::OpenFileFailed))
        .map_err(|error| format!("it is no OBJ file that can be read: {error}"))?;
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

fn names_materials(bytes: &[u8]) -> bool {
    bytes.split(|&byte| byte == b'\n').any(|line| line.starts_with(b"mtllib") || line.starts_with(b"usemtl"))
}
