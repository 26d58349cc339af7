//! u and v, tangents and shading normals of places that rays have met.

use std::sync::Arc;

use iridesce_numerics::Vec3;
use iridesce_scene::{Affine, Chart, Heights, Mesh, ResolvedScene, Shape as SceneShape, UvMap};

use super::mesh::TriangleMesh;
use super::parts::{Kind, Tree};
use super::{Hit, Interaction, frame};

/// Of the objects of a scene, in their order.
#[derive(Default)]
pub struct Charts {
    objects: Vec<ObjectChart>,
    /// One of them has shading normals of its own.
    any_shaded: bool,
}

struct ObjectChart {
    chart: Option<Chart>,
    mesh: Option<Arc<Mesh>>,
    uv: UvMap,
    bump: Option<Heights>,
    /// From the world to the space of the object, of each instance of a simple shape: of others the tree knows it.
    to_object: Vec<Affine>,
    is_shaded: bool,
}

impl Charts {
    pub fn new(scene: &ResolvedScene) -> Charts {
        let objects: Vec<ObjectChart> = scene
            .recipe
            .objects
            .iter()
            .enumerate()
            .map(|(number, object)| {
                let mesh = scene.mesh(number).cloned();
                let bump = scene.bump(number).cloned();
                let placements = scene.placements(number);
                let stays = matches!(placements, [only] if *only == Affine::IDENTITY) || !is_simple(&object.shape);
                ObjectChart {
                    chart: (!matches!(object.shape, SceneShape::Mesh(_))).then(|| Chart::new(&object.shape)),
                    is_shaded: bump.is_some() || mesh.as_ref().is_some_and(|mesh| mesh.normals.is_some()),
                    mesh,
                    uv: object.uv,
                    bump,
                    to_object: if stays {
                        Vec::new()
                    } else {
                        placements.iter().map(|by| by.inverse().unwrap_or_default()).collect()
                    },
                }
            })
            .collect();
        let any_shaded = objects.iter().any(|object| object.is_shaded);
        Charts { objects, any_shaded }
    }

    #[inline(always)]
    pub fn is_shaded(&self, object: usize) -> bool {
        self.any_shaded && self.objects.get(object).is_some_and(|own| own.is_shaded)
    }

    pub fn interaction(&self, tree: Option<&Tree>, hit: &Hit) -> Interaction {
        let mut all = Interaction {
            instance: 0,
            local: hit.point,
            shading_normal: hit.normal,
            frame: frame(hit.normal).into(),
            u: 0.0,
            v: 0.0,
            thickness_nm: f64::NAN,
        };
        let Some(own) = self.objects.get(hit.object) else { return all };
        let part = tree.map(|tree| &tree.parts[hit.part as usize]);
        all.instance = part.map_or(0, |part| part.instance);
        let to_object =
            own.to_object.get(all.instance as usize).or_else(|| tree?.to_object.get(part?.placement as usize));
        all.local = to_object.map_or(hit.point, |by| by.moved(hit.point));
        let kind = part.and_then(|part| tree.map(|tree| &tree.kinds[part.kind as usize]));
        let tangents = match (&own.mesh, kind, &own.chart) {
            (Some(mesh), Some(Kind::Mesh(triangles)), _) => on_mesh(&mut all, mesh, triangles, to_object, hit),
            (_, _, Some(chart)) => {
                let place = all.local.to_array();
                [all.u, all.v] = chart.uv(place);
                let out = to_world(to_object);
                Some(chart.tangents(place).map(|v| out(v.into())))
            }
            _ => None,
        };
        [all.u, all.v] = own.uv.of([all.u, all.v]);
        if let (Some(tangents), Some(heights)) = (tangents, &own.bump) {
            bend(&mut all, tangents, heights, own.uv.scale, hit);
        }
        all.frame = frame_along(tangents, all.shading_normal);
        all
    }
}

/// Takes vectors of an object's space into the world. The inverse is made where it is asked for: most hits have no use for it, and a
/// million instances would keep another hundred megabytes.
#[inline(always)]
fn to_world(to_object: Option<&Affine>) -> impl Fn(Vec3) -> Vec3 {
    let by = to_object.map(|by| by.inverse().unwrap_or_default());
    move |v| by.as_ref().map_or(v, |by| by.turned(v))
}

/// What the corners of a triangle tell of a place on it; gives the tangents along u and v, if it has any.
fn on_mesh(
    all: &mut Interaction,
    mesh: &Mesh,
    triangles: &TriangleMesh,
    to_object: Option<&Affine>,
    hit: &Hit,
) -> Option<[Vec3; 2]> {
    let corners = mesh.triangles[hit.primitive as usize].map(|corner| corner as usize);
    let [b, c] = triangles.shares(hit.primitive, all.local);
    let shares = [1.0 - b - c, b, c];
    let mixed = |value: &dyn Fn(usize) -> f64| (0..3).map(|k| shares[k] * value(corners[k])).sum::<f64>();
    if let Some(normals) = &mesh.normals {
        let n = Vec3::new(
            mixed(&|corner| f64::from(normals[corner][0])),
            mixed(&|corner| f64::from(normals[corner][1])),
            mixed(&|corner| f64::from(normals[corner][2])),
        );
        let n = to_object.map_or(n, |by| by.transposed(n.to_array()).into());
        let n = n.normalized();
        // A file's normals may run against its winding, and may cancel out.
        let along = n.dot(hit.normal);
        if along.is_finite() && along != 0.0 {
            all.shading_normal = n * along.signum();
        }
    }
    if let Some(thickness_nm) = &mesh.thickness_nm {
        all.thickness_nm = mixed(&|corner| f64::from(thickness_nm[corner]));
    }
    let uv = mesh.uv.as_ref()?;
    (all.u, all.v) = (mixed(&|corner| f64::from(uv[corner][0])), mixed(&|corner| f64::from(uv[corner][1])));
    let [p, q, r] = triangles.corners(hit.primitive);
    let [p_uv, q_uv, r_uv] = corners.map(|corner| uv[corner].map(f64::from));
    let (q_u, q_v) = (q_uv[0] - p_uv[0], q_uv[1] - p_uv[1]);
    let (r_u, r_v) = (r_uv[0] - p_uv[0], r_uv[1] - p_uv[1]);
    let area = q_u * r_v - q_v * r_u;
    if area == 0.0 {
        return None;
    }
    let out = to_world(to_object);
    let (q, r) = (out(q - p), out(r - p));
    Some([(q * r_v - r * q_v) * (1.0 / area), (r * q_u - q * r_u) * (1.0 / area)])
}

/// Bends the shading normal by the slopes of a map of heights.
fn bend(all: &mut Interaction, [along_u, along_v]: [Vec3; 2], heights: &Heights, scale: [f64; 2], hit: &Hit) {
    let [slope_u, slope_v] = heights.slopes([all.u, all.v]);
    let (slope_u, slope_v) = (slope_u * scale[0], slope_v * scale[1]);
    let n = all.shading_normal;
    let area = n.dot(along_u.cross(along_v));
    if area != 0.0 {
        let gradient = (along_v.cross(n) * slope_u + n.cross(along_u) * slope_v) * (1.0 / area);
        let bent = (n - gradient).normalized();
        if bent.dot(hit.normal) > 0.0 {
            all.shading_normal = bent;
        }
    }
}

/// Along u, at right angles to the shading normal, and across both; anyhow at right angles to it where there is no u.
fn frame_along(tangents: Option<[Vec3; 2]>, n: Vec3) -> [Vec3; 2] {
    if let Some([along_u, _]) = tangents {
        let along = along_u - n * n.dot(along_u);
        let length2 = along.length_squared();
        if length2 > 0.0 && length2.is_finite() {
            let along = along * (1.0 / length2.sqrt());
            return [along, n.cross(along)];
        }
    }
    frame(n).into()
}

/// Whether a shape may be put into the world as another of its kind, without a placement.
fn is_simple(shape: &SceneShape) -> bool {
    !matches!(shape, SceneShape::Mesh(_) | SceneShape::Bubbles(_) | SceneShape::Cylinder { .. })
}
