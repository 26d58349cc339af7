//! A mesh in memory, and what it is held against.

use iridesce_numerics::vector::{cross, difference};

/// Most triangles of a mesh, and most vertices.
pub const MAX_TRIANGLES: usize = 1 << 26;

/// Triangles; the front of each is the side from which its corners run counter-clockwise.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Vertices, in the file's own unit.
    pub positions: Vec<[f64; 3]>,
    /// Unit normals of the vertices, if the file has them.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates of the vertices, v upwards, if the file has them.
    pub uv: Option<Vec<[f32; 2]>>,
    /// Film thickness at the vertices, nm: the PLY property `thickness_nm`.
    pub thickness_nm: Option<Vec<f32>>,
    /// Corners, as places in the lists above.
    pub triangles: Vec<[u32; 3]>,
    /// The unit is the metre by the format's own rule (glTF); otherwise it is the scene's.
    pub is_in_metres: bool,
    /// What was left out, a sentence each.
    pub notes: Vec<String>,
}

impl Mesh {
    /// What it takes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.positions)
            + size_of_val(&*self.triangles)
            + self.normals.as_ref().map_or(0, |list| size_of_val(&**list))
            + self.uv.as_ref().map_or(0, |list| size_of_val(&**list))
            + self.thickness_nm.as_ref().map_or(0, |list| size_of_val(&**list))
    }

    /// Holds the mesh against its own lists: what a file may get wrong.
    pub fn checked(mut self) -> Result<Mesh, String> {
        let count = self.positions.len();
        if self.triangles.is_empty() {
            return Err("it has no faces".into());
        }
        if self.triangles.len() > MAX_TRIANGLES || count > MAX_TRIANGLES {
            return Err(format!(
                "it has {} triangles and {count} vertices; at most {MAX_TRIANGLES} of each are read",
                self.triangles.len()
            ));
        }
        for (face, corners) in self.triangles.iter().enumerate() {
            if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
                return Err(format!("triangle {face} has a corner at vertex {corner}, and there are {count} vertices"));
            }
        }
        if let Some(at) =
            self.positions.iter().position(|p| !p.iter().all(|c| c.is_finite() && c.abs() < MAX_COORDINATE))
        {
            return Err(format!(
                "vertex {at} lies at {:?}; coordinates are finite numbers below {MAX_COORDINATE:e}",
                self.positions[at]
            ));
        }
        if let Some(thickness_nm) = &self.thickness_nm
            && let Some(at) = thickness_nm.iter().position(|t| !(t.is_finite() && *t >= 0.0))
        {
            return Err(format!(
                "thickness_nm of vertex {at} must be a finite number >= 0, got {:?}",
                thickness_nm[at]
            ));
        }
        if let Some(uv) = &self.uv
            && let Some(at) = uv.iter().position(|uv| !uv.iter().all(|c| c.is_finite()))
        {
            return Err(format!("the texture coordinates of vertex {at} are {:?}, no finite numbers", uv[at]));
        }
        self.normalize();
        self.drop_degenerate()?;
        Ok(self)
    }

    /// Makes normals unit vectors; a mesh with a normal that is none is drawn flat, and says so.
    fn normalize(&mut self) {
        let Some(normals) = &mut self.normals else { return };
        for (at, normal) in normals.iter_mut().enumerate() {
            let length = normal.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
            if !(length.is_finite() && length > 0.0) {
                self.notes
                    .push(format!("the normal of vertex {at} is {normal:?}: all normals are left out, faces are flat"));
                self.normals = None;
                return;
            }
            for c in normal.iter_mut() {
                *c = (f64::from(*c) / length) as f32;
            }
        }
    }

    /// Triangles without an area are seen by nobody, and have no normal.
    fn drop_degenerate(&mut self) -> Result<(), String> {
        let before = self.triangles.len();
        let positions = &self.positions;
        self.triangles.retain(|corners| {
            let [a, b, c] = corners.map(|corner| positions[corner as usize]);
            let cross = cross(difference(b, a), difference(c, a));
            cross.iter().map(|x| x * x).sum::<f64>() > 0.0
        });
        if self.triangles.is_empty() {
            return Err(format!("none of its {before} triangles has an area"));
        }
        if self.triangles.len() < before {
            self.notes.push(format!("{} triangles without an area are left out", before - self.triangles.len()));
        }
        Ok(())
    }
}

/// Largest coordinate: its square and cube are still far from the end of double precision.
const MAX_COORDINATE: f64 = 1e15;
