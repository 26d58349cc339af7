//! Lights that closed opaque shapes shut in, or the camera out of: pictures that are black for no reason that they show.

use std::borrow::Cow;

use iridesce_files::Mesh;
use iridesce_numerics::vector::{cross, difference, dot, length};
use iridesce_optics::medium::VISIBLE_NM;

use crate::affine::Affine;
use crate::bodies::Bodies;
use crate::faces::is_body;
use crate::inside::{Box3, Side, side_of_mesh};
use crate::medium::{is_clear, is_clear_at};
use crate::model::{DeltaKind, Instances, Light, Object, Scene, Shape, Surface};

/// Most pairs of an instance and a light that are asked about, and most triangles that are gone through for all of them: more take
/// longer than a note is worth (a second).
const MOST_PAIRS: usize = 1_000_000;
const MOST_TRIANGLES: usize = 20_000_000;

/// What files say of where objects are.
#[derive(Clone, Copy)]
pub struct Read<'a> {
    /// Meshes and placements.
    pub bodies: &'a Bodies,
    /// Whether the mesh of an object is closed.
    pub is_closed: &'a dyn Fn(usize) -> bool,
}

/// One sentence each. Without `read` nothing is known of meshes and of instances in files, and nothing is told of them.
pub fn shut_in_lights(scene: &Scene, read: Option<Read<'_>>) -> Vec<String> {
    let bodies = scene.objects.iter().filter(|object| is_body(object));
    let asking = Asking { scene, read, strongest: bodies.map(|body| body.priority).max().unwrap_or(0) };
    let shells: Vec<Shell<'_>> = (0..scene.objects.len()).filter_map(|object| asking.shell(object)).collect();
    let lamps: Vec<Lamp> = asking.deltas().chain(asking.emitters()).collect();
    let (instances, balls) =
        (shells.iter().map(|s| s.placements.len()).sum::<usize>(), lamps.iter().map(|l| l.balls.len()).sum::<usize>());
    if instances.saturating_mul(balls + 1) > MOST_PAIRS {
        return Vec::new();
    }
    // Where the others are, only files tell.
    let is_all = lamps.iter().all(|lamp| !lamp.balls.is_empty());
    let camera = Ball { middle: scene.camera.position, radius: 0.0 };
    let mut left = MOST_TRIANGLES;
    let mut notes = Vec::new();
    for shell in &shells {
        let told = told(shell, camera, &lamps, is_all, &mut left);
        if !told.is_empty() && asking.is_opaque(shell.object) {
            notes.extend(told);
        }
    }
    notes
}

/// What is to be told of one shell.
fn told(shell: &Shell<'_>, camera: Ball, lamps: &[Lamp], is_all: bool, left: &mut usize) -> Vec<String> {
    let name = &shell.object.name;
    if shell.side(camera, left) == Side::Inside {
        let is_dark = is_all && lamps.iter().all(|lamp| lamp.is_all(shell, Side::Outside, left));
        let note = || {
            format!(
                "camera.position lies inside object \"{name}\", which is closed and opaque, and every light is outside: the picture is \
                 black; put a light or an emitter inside, or move the camera out"
            )
        };
        return is_dark.then(note).into_iter().collect();
    }
    let note = |lamp: &Lamp| {
        format!(
            "{} inside object \"{name}\", which is closed and opaque: nothing of its light is seen outside; move it out, put the camera \
             inside, or make the object one that light leaves (a film, glass, a cap, a cylinder with open = true)",
            lamp.what
        )
    };
    lamps.iter().filter(|lamp| lamp.is_all(shell, Side::Inside, left)).map(note).collect()
}

/// A ball that a light, or an instance of one, or the camera, lies within; in scene units.
#[derive(Clone, Copy)]
struct Ball {
    middle: [f64; 3],
    radius: f64,
}

/// A light that is somewhere.
struct Lamp {
    /// The beginning of the sentence.
    what: String,
    /// One for each instance; none where that is not known.
    balls: Vec<Ball>,
}

impl Lamp {
    /// Whether all of it is known to lie on one side of a shell.
    fn is_all(&self, shell: &Shell<'_>, side: Side, left: &mut usize) -> bool {
        !self.balls.is_empty() && self.balls.iter().all(|ball| shell.side(*ball, left) == side)
    }
}

/// A closed shape that no light gets through from inside.
struct Shell<'a> {
    object: &'a Object,
    placements: Cow<'a, [Affine]>,
    mesh: Option<ReadMesh<'a>>,
}

/// A mesh with the box around it, and whether it is closed.
struct ReadMesh<'a> {
    mesh: &'a Mesh,
    around: Box3,
    is_closed: Box<dyn Fn() -> bool + 'a>,
}

impl Shell<'_> {
    /// Whether a ball lies within one instance, or outside all of them.
    fn side(&self, ball: Ball, left: &mut usize) -> Side {
        let mut all = Side::Outside;
        for placement in self.placements.iter() {
            match self.side_of_one(placement, ball, left) {
                Side::Inside => return Side::Inside,
                Side::Outside => {}
                Side::Unknown => all = Side::Unknown,
            }
        }
        all
    }

    fn side_of_one(&self, placement: &Affine, ball: Ball, left: &mut usize) -> Side {
        let Some(back) = placement.inverse() else { return Side::Unknown };
        let middle = back.point(ball.middle);
        let radius = ball.radius * back.similarity().unwrap_or_else(|| back.stretch());
        let Some(ReadMesh { mesh, around, is_closed }) = &self.mesh else {
            let depth = depth(&self.object.shape, middle);
            return Side::of(depth > radius, depth < -radius);
        };
        if around.distance(middle) > radius {
            return Side::Outside;
        }
        if *left < mesh.triangles.len() {
            return Side::Unknown;
        }
        *left -= mesh.triangles.len();
        match side_of_mesh(mesh, middle, radius) {
            Side::Inside if !is_closed() => Side::Unknown,
            side => side,
        }
    }
}

/// A scene, and what is known of it.
struct Asking<'a> {
    scene: &'a Scene,
    read: Option<Read<'a>>,
    /// The highest priority of a body.
    strongest: i32,
}

impl<'a> Asking<'a> {
    /// Where an object is, once for each instance; `None` where only its file tells.
    fn placements(&self, object: usize) -> Option<Cow<'a, [Affine]>> {
        if let Some(read) = self.read {
            return Some(Cow::Borrowed(&read.bodies.placements[object]));
        }
        let placement = &self.scene.objects[object].placement;
        match &placement.instances {
            Instances::Once => Some(Cow::Borrowed(std::slice::from_ref(&placement.transform))),
            Instances::List(list) => Some(list.iter().map(|by| by.after(&placement.transform)).collect()),
            Instances::File(_) => None,
        }
    }

    fn mesh(&self, object: usize) -> Option<&'a Mesh> {
        self.read?.bodies.meshes[object].as_deref()
    }

    /// An object that may be one: what takes long to tell of its medium, only a mesh is asked already.
    fn shell(&self, number: usize) -> Option<Shell<'a>> {
        let object = &self.scene.objects[number];
        let mesh = match object.shape {
            Shape::Sphere { .. } | Shape::Cylinder { is_open: false, .. } if self.may_be_opaque(object) => None,
            Shape::Mesh(_) if self.is_opaque(object) => {
                let (mesh, read) = (self.mesh(number)?, self.read?);
                let is_closed = Box::new(move || (read.is_closed)(number));
                Some(ReadMesh { mesh, around: Box3::around(&mesh.positions), is_closed })
            }
            _ => return None,
        };
        Some(Shell { object, placements: self.placements(number)?, mesh })
    }

    fn may_be_opaque(&self, object: &Object) -> bool {
        match &object.surface {
            Surface::Diffuse(_) => true,
            Surface::Film(_) | Surface::Emitter(_) => false,
            // Inside a stronger body its surface is not there.
            _ if object.priority < self.strongest => false,
            Surface::Metal(_) => true,
            Surface::Dielectric(medium) => !is_clear_at(medium, VISIBLE_NM.0),
            Surface::Coating(coating) => !is_clear_at(&coating.substrate, VISIBLE_NM.0),
        }
    }

    /// Whether no light gets through an object's surface, anywhere on it.
    fn is_opaque(&self, object: &Object) -> bool {
        let medium = match &object.surface {
            Surface::Dielectric(medium) => Some(medium),
            Surface::Coating(coating) => Some(&coating.substrate),
            _ => None,
        };
        self.may_be_opaque(object) && !medium.is_some_and(is_clear)
    }

    fn deltas(&self) -> impl Iterator<Item = Lamp> {
        self.scene.lights.iter().enumerate().filter_map(|(number, light)| {
            let Light::Delta(delta) = light else { return None };
            let kind = if matches!(delta.kind, DeltaKind::Spot { .. }) { "spot" } else { "point" };
            let ball = Ball { middle: delta.kind.position()?, radius: 0.0 };
            Some(Lamp { what: format!("light.{number}.{kind}.position lies"), balls: vec![ball] })
        })
    }

    fn emitters(&self) -> impl Iterator<Item = Lamp> {
        let glowing = self.scene.objects.iter().enumerate().filter(|(_, o)| matches!(o.surface, Surface::Emitter(_)));
        glowing.map(|(number, object)| {
            let placed = |ball: Ball, by: &Affine| Ball {
                middle: by.point(ball.middle),
                radius: ball.radius * by.similarity().unwrap_or_else(|| by.stretch()),
            };
            let own = around(&object.shape, self.mesh(number));
            let balls =
                own.zip(self.placements(number)).map(|(ball, all)| all.iter().map(|by| placed(ball, by)).collect());
            Lamp { what: format!("object \"{}\" glows", object.name), balls: balls.unwrap_or_default() }
        })
    }
}

/// A ball around a shape, if it has an end and is known.
fn around(shape: &Shape, mesh: Option<&Mesh>) -> Option<Ball> {
    let (middle, radius) = match shape {
        Shape::Sphere { center, radius } | Shape::Disk { center, radius, .. } => (*center, *radius),
        Shape::Rectangle { center, u, v } => (*center, length(*u) + length(*v)),
        Shape::Cap { center, radius_of_curvature, .. } => (*center, 2.0 * radius_of_curvature.abs()),
        Shape::Cylinder { center, radius, height, .. } => (*center, radius.hypot(0.5 * height)),
        Shape::Mesh(_) => Box3::around(&mesh?.positions).ball(),
        Shape::Plane { .. } | Shape::Bubbles(_) => return None,
    };
    Some(Ball { middle, radius })
}

/// How deep a point lies below the surface of a closed shape, at least; negative outside.
fn depth(shape: &Shape, point: [f64; 3]) -> f64 {
    match shape {
        Shape::Sphere { center, radius } => radius - length(difference(point, *center)),
        Shape::Cylinder { center, axis, radius, height, .. } => {
            let off = difference(point, *center);
            (radius - length(cross(off, *axis))).min(0.5 * height - dot(off, *axis).abs())
        }
        _ => f64::NAN,
    }
}
