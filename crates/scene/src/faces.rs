//! Films that lie on the very face of a body, as an object of their own: same shape, same place. What such a film is in the world is
//! a layer of the body's face, and so it is drawn.

use std::collections::HashMap;

use crate::model::{Object, Roughness, Scene, Shape, Surface};

/// Which film lies on the face of which body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilmOnFace {
    /// The object that is the film.
    pub film: usize,
    /// The object that is the body.
    pub body: usize,
}

impl Scene {
    /// The films that are layers of the faces of bodies, in the order of the films; at most one on each body.
    ///
    /// ```
    /// use iridesce_scene::{Node, Scene};
    /// let scene = Scene::builtin("coated-lens")?;
    /// assert!(scene.films_on_faces().is_empty());
    /// # Ok::<(), iridesce_scene::SceneError>(())
    /// ```
    pub fn films_on_faces(&self) -> Vec<FilmOnFace> {
        films_on_faces(&self.objects)
    }
}

/// All films on faces, in the order of the films. What a body has a second of is among them.
pub fn films_on_faces(objects: &[Object]) -> Vec<FilmOnFace> {
    let mut bodies: HashMap<Vec<u64>, Vec<usize>> = HashMap::new();
    if objects.iter().any(|object| matches!(object.surface, Surface::Film(_))) {
        for (number, object) in objects.iter().enumerate().filter(|(_, object)| is_body(object)) {
            bodies.entry(place(object)).or_default().push(number);
        }
    }
    if bodies.is_empty() {
        return Vec::new();
    }
    let films = objects.iter().enumerate().filter(|(_, object)| matches!(object.surface, Surface::Film(_)));
    films
        .filter_map(|(film, object)| {
            let near = bodies.get(&place(object))?;
            let is_it =
                |body: &&usize| objects[**body].shape == object.shape && objects[**body].placement == object.placement;
            near.iter().find(is_it).map(|&body| FilmOnFace { film, body })
        })
        .collect()
}

/// What is wrong with films on faces: such a film follows the face, and there is one on each. Each is told with the number of the film
/// and the keys below it.
pub fn check_faces(objects: &[Object], mut complain: impl FnMut(usize, &[&str], String)) {
    let mut first: HashMap<usize, usize> = HashMap::new();
    for FilmOnFace { film, body } in films_on_faces(objects) {
        let (skin, face) = (&objects[film], &objects[body]);
        let path = format!("object.{}", skin.name);
        let (name, lies) = (&face.name, "on whose face the film lies");
        if let Some(before) = first.insert(body, film) {
            let message = format!(
                "{path} lies on the face of object \"{name}\", where the film of object \"{}\" lies already; write them as the layers of a \
                 coating of \"{name}\", from outside inwards",
                objects[before].name
            );
            complain(film, &[], message);
            continue;
        }
        let is_own = [
            (
                ["surface", "film", "roughness"].as_slice(),
                skin.roughness != Roughness::SMOOTH && skin.roughness != face.roughness,
            ),
            (&["bump"], skin.bump.is_some() && skin.bump != face.bump),
            (&["uv"], skin.uv != face.uv),
        ];
        for (keys, _) in is_own.into_iter().filter(|(_, is_own)| *is_own) {
            let key = format!("{path}.{}", keys.join("."));
            let what = if keys == ["uv"] { "be" } else { "be left out or be" };
            let message = format!("{key} must {what} that of object \"{name}\", {lies} and which it follows");
            complain(film, keys, message);
        }
    }
}

/// Whether a medium fills what lies behind an object's surface, so that a layer can lie on its face.
pub fn is_body(object: &Object) -> bool {
    matches!(object.surface, Surface::Coating(_) | Surface::Dielectric(_) | Surface::Metal(_))
}

/// Equal for objects of equal shape and place, and seldom for others: what 100 000 objects are first told apart by.
fn place(object: &Object) -> Vec<u64> {
    let numbers: Vec<f64> = match &object.shape {
        Shape::Sphere { center, radius } => center.iter().chain([radius]).copied().collect(),
        Shape::Rectangle { center, u, v } => [center, u, v].into_iter().flatten().copied().collect(),
        Shape::Disk { center, normal, radius } => center.iter().chain(normal).chain([radius]).copied().collect(),
        Shape::Plane { point, normal } => point.iter().chain(normal).copied().collect(),
        Shape::Cap { center, axis, radius_of_curvature, aperture_radius } => {
            center.iter().chain(axis).chain([radius_of_curvature, aperture_radius]).copied().collect()
        }
        Shape::Cylinder { center, axis, radius, height, .. } => {
            center.iter().chain(axis).chain([radius, height]).copied().collect()
        }
        Shape::Mesh(_) | Shape::Bubbles(_) => Vec::new(),
    };
    let transform = object.placement.transform.rows.as_flattened();
    // (-0 is 0.)
    numbers.iter().chain(transform).map(|number| (number + 0.0).to_bits()).collect()
}
