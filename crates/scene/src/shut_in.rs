//! Lights that closed matt shapes shut in, or the camera out of: pictures that are black for no reason that they show.

use iridesce_numerics::vector::{cross, difference, dot, length};

use crate::affine::Affine;
use crate::model::{DeltaKind, Instances, Light, Object, Scene, Shape, Surface};

/// Most pairs of light and shape that are asked about: more take longer than a check should.
const MOST_PAIRS: usize = 1_000_000;

/// A ball that a light, or the camera, lies within.
type Ball = ([f64; 3], f64);

/// One sentence each.
pub fn shut_in_lights(scene: &Scene) -> Vec<String> {
    let shells: Vec<&Object> = scene.objects.iter().filter(|object| is_shell(object)).collect();
    let lights: Vec<(String, Ball)> = delta_lights(scene).chain(emitters(scene)).collect();
    if shells.is_empty() || shells.len().saturating_mul(lights.len() + 1) > MOST_PAIRS {
        return Vec::new();
    }
    // Where the others are, only files tell.
    let is_all = emitters(scene).count()
        == scene.objects.iter().filter(|object| matches!(object.surface, Surface::Emitter(_))).count();
    let camera = (scene.camera.position, 0.0);
    let mut notes = Vec::new();
    for shell in shells {
        if holds(shell, camera) {
            if is_all && lights.iter().all(|(_, ball)| is_apart(shell, *ball)) {
                notes.push(format!(
                    "camera.position lies inside object \"{}\", which is closed and matt, and every light is outside: the picture is \
                     black; put a light or an emitter inside, or move the camera out",
                    shell.name
                ));
            }
            continue;
        }
        for (what, _) in lights.iter().filter(|(_, ball)| holds(shell, *ball)) {
            notes.push(format!(
                "{what} inside object \"{}\", which is closed and matt: nothing of its light is seen outside; move it out, put the camera \
                 inside, or make the object one that light leaves (a film, glass, a cap, a cylinder with open = true)",
                shell.name
            ));
        }
    }
    notes
}

fn delta_lights(scene: &Scene) -> impl Iterator<Item = (String, Ball)> {
    scene.lights.iter().enumerate().filter_map(|(number, light)| {
        let Light::Delta(delta) = light else { return None };
        let kind = if matches!(delta.kind, DeltaKind::Spot { .. }) { "spot" } else { "point" };
        Some((format!("light.{number}.{kind}.position lies"), (delta.kind.position()?, 0.0)))
    })
}

fn emitters(scene: &Scene) -> impl Iterator<Item = (String, Ball)> {
    scene.objects.iter().filter_map(|object| {
        let glows = matches!(object.surface, Surface::Emitter(_)) && object.placement.is_plain();
        let ball = if glows { around(&object.shape)? } else { return None };
        Some((format!("object \"{}\" glows", object.name), ball))
    })
}

/// A ball around a shape, if it has an end and its file need not be read.
fn around(shape: &Shape) -> Option<Ball> {
    Some(match shape {
        Shape::Sphere { center, radius } | Shape::Disk { center, radius, .. } => (*center, *radius),
        Shape::Rectangle { center, u, v } => (*center, length(*u) + length(*v)),
        Shape::Cap { center, radius_of_curvature, .. } => (*center, 2.0 * radius_of_curvature.abs()),
        Shape::Cylinder { center, radius, height, .. } => (*center, radius.hypot(0.5 * height)),
        Shape::Plane { .. } | Shape::Mesh(_) | Shape::Bubbles(_) => return None,
    })
}

/// Whether no light gets through an object from inside, where it has an inside that is known without its file.
fn is_shell(object: &Object) -> bool {
    let is_closed = matches!(object.shape, Shape::Sphere { .. } | Shape::Cylinder { is_open: false, .. });
    is_closed && matches!(object.surface, Surface::Diffuse(_))
}

/// Whether a ball lies within a shell, or within one of its instances; false where that is not known.
fn holds(shell: &Object, ball: Ball) -> bool {
    depths(shell, ball).is_some_and(|depths| depths.iter().any(|depth| *depth > ball.1))
}

/// Whether a ball lies outside a shell and all its instances; false where that is not known.
fn is_apart(shell: &Object, ball: Ball) -> bool {
    depths(shell, ball).is_some_and(|depths| depths.iter().all(|depth| *depth < -ball.1))
}

/// How deep the middle of a ball lies within each instance of a shell, in the space of its shape; `None` where a file tells where they
/// are, or where the ball would be none in that space.
fn depths(shell: &Object, (middle, radius): Ball) -> Option<Vec<f64>> {
    let own = shell.placement.transform;
    let all = match &shell.placement.instances {
        Instances::Once => vec![own],
        Instances::List(list) => list.iter().map(|by| by.after(&own)).collect(),
        Instances::File(_) => return None,
    };
    let within = |by: &Affine| match radius > 0.0 && *by != Affine::IDENTITY {
        true => None,
        false => Some(depth(&shell.shape, by.inverse()?.point(middle))),
    };
    all.iter().map(within).collect()
}

/// How deep a point lies below the surface of a closed shape, at least; negative outside.
fn depth(shape: &Shape, point: [f64; 3]) -> f64 {
    match shape {
        Shape::Sphere { center, radius } => radius - length(difference(point, *center)),
        Shape::Cylinder { center, axis, radius, height, .. } => {
            let off = difference(point, *center);
            (radius - length(cross(off, *axis))).min(0.5 * height - dot(off, *axis).abs())
        }
        _ => f64::NEG_INFINITY,
    }
}
