//! What whoever renders a sound scene should be told.

use crate::medium::is_clear;
use crate::model::{Light, Object, Roughness, Scene, Shape, Surface};
use crate::shut_in::shut_in_lights;

impl Scene {
    /// One sentence each. What only the scene's files can tell comes with [`crate::ResolvedScene`].
    pub fn notes(&self) -> Vec<String> {
        (self.dark_lights().into_iter().chain(self.open_bodies()).chain(self.films_that_meet()))
            .chain(shut_in_lights(self, None))
            .collect()
    }

    /// That nothing of the scene shows its lights.
    fn dark_lights(&self) -> Option<String> {
        let are_deltas = self.lights.iter().all(|light| matches!(light, Light::Delta(_)));
        let scatters = |object: &Object| {
            matches!(object.surface, Surface::Diffuse(_) | Surface::Emitter(_)) || object.roughness != Roughness::SMOOTH
        };
        let is_dark = are_deltas && !self.objects.iter().any(scatters);
        is_dark.then(|| {
            "every light of the scene has no size (directional, point, spot) and every surface is smooth: mirrors and films do \
             not show such lights, so the picture is black; a sun, an environment or an emitter is seen"
                .to_owned()
        })
    }

    /// Surfaces with an edge and a clear medium behind them that nothing else of the scene could close: a ray that comes round
    /// the edge leaves a medium that it never entered, and ends the render.
    fn open_bodies(&self) -> Vec<String> {
        let fills = |object: &Object| match &object.surface {
            Surface::Coating(coating) => Some(coating.substrate.clone()),
            Surface::Dielectric(medium) => Some(medium.clone()),
            Surface::Film(film) => Some(film.outside.clone()),
            Surface::Metal(_) | Surface::Diffuse(_) | Surface::Emitter(_) => None,
        };
        let open = self.objects.iter().enumerate().filter_map(|(number, object)| {
            let medium = fills(object).filter(|_| !matches!(object.surface, Surface::Film(_)))?;
            let edge = edge(&object.shape).filter(|_| is_clear(&medium))?;
            let others = self.objects.iter().enumerate().filter(|(other, _)| *other != number);
            let is_closed = others.filter_map(|(_, other)| fills(other)).any(|other| other.name() == medium.name());
            (!is_closed).then(|| {
                format!(
                    "object \"{}\": \"{}\" lies behind {edge}, and nothing closes the body that it fills: a ray that comes to \
                     the surface from behind, round its edge, ends the render; close the body, make the surface a plane, or \
                     make what lies behind it a closed shape (a sphere, a cylinder with its ends, a mesh)",
                    object.name,
                    medium.name(),
                )
            })
        });
        open.collect()
    }

    /// That films on spheres cross (drawn as whole spheres, as the scene says, and as no bubbles ever are), or lie in one place.
    fn films_that_meet(&self) -> Option<String> {
        let mut balls: Vec<_> = self
            .objects
            .iter()
            .filter(|object| object.placement.is_plain())
            .filter_map(|object| match (&object.shape, &object.surface) {
                (Shape::Sphere { center, radius }, Surface::Film(_)) => Some((center, *radius, &object.name)),
                _ => None,
            })
            .collect();
        // From left to right, so that far apart ones are not asked about.
        balls.sort_by(|a, b| (a.0[0] - a.1).total_cmp(&(b.0[0] - b.1)));
        let pair = balls.iter().enumerate().find_map(|(place, a)| {
            let near = balls[place + 1..].iter().take_while(|b| b.0[0] - b.1 < a.0[0] + a.1);
            near.into_iter().find(|b| a.0 == b.0 && a.1 == b.1 || crosses(a.0, a.1, b.0, b.1)).map(|b| (a, b))
        });
        pair.map(|(a, b)| {
            let is_one_place = a.1 == b.1 && a.0 == b.0;
            let (a, b) = (a.2, b.2);
            if is_one_place {
                return format!(
                    "the films of \"{a}\" and \"{b}\" lie in one place: light goes to and fro between them and does not come \
                     past; leave one of them out, or part them"
                );
            }
            format!(
                "the films of \"{a}\" and \"{b}\" cross: both are drawn whole, with four walls where they meet; bubbles that touch \
                 share a wall: make them one object of the shape bubbles = {{ spheres = [...] }}"
            )
        })
    }
}

/// Whether two spheres meet in a circle.
fn crosses(a: &[f64; 3], a_radius: f64, b: &[f64; 3], b_radius: f64) -> bool {
    let distance = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    distance < a_radius + b_radius && distance > (a_radius - b_radius).abs()
}

/// What a shape with an edge is called.
fn edge(shape: &Shape) -> Option<&'static str> {
    match shape {
        Shape::Rectangle { .. } => Some("a rectangle"),
        Shape::Disk { .. } => Some("a disk"),
        Shape::Cap { .. } => Some("a cap"),
        Shape::Cylinder { is_open: true, .. } => Some("a cylinder without its ends"),
        Shape::Cylinder { .. } | Shape::Sphere { .. } | Shape::Plane { .. } | Shape::Mesh(_) | Shape::Bubbles(_) => {
            None
        }
    }
}
