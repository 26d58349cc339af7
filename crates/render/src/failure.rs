//! What only rays can tell is wrong with a scene.

use crate::framebuffer::RenderError;
use crate::materials::Material;
use crate::medium_stack::{DEEPEST, SURROUNDING};
use crate::prepare::{MOST_FILMS, Prepared};

/// Why a pixel could not be finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathFailure {
    /// A ray came to an object in another medium than the one that the object lies in.
    WrongMedium { object: usize, is_in: u8, expected: u8 },
    /// Media nested too deeply.
    TooDeep { object: usize },
    /// A straight way through films does not come past this one: another lies where it lies.
    SamePlace { object: usize },
}

/// The level of spectra that a pixel asks for; an error where it was not prepared, which takes thicknesses beyond those that
/// the scene has told.
pub fn prepared_level(scene: &Prepared, level: usize) -> Result<usize, RenderError> {
    if level < scene.levels.len() {
        return Ok(level);
    }
    Err(RenderError::Resource(format!("spectra of level {level} are needed, which were not prepared")))
}

/// What a scene is told whose rays fail.
pub fn describe(scene: &Prepared, failure: PathFailure) -> RenderError {
    let medium = |number: u8| match number {
        SURROUNDING => "air".to_owned(),
        _ => format!("\"{}\"", scene.media.name(number)),
    };
    match failure {
        PathFailure::WrongMedium { object, is_in, expected } => {
            let name = &scene.names[object];
            let (key, why) = match &scene.materials[object] {
                Material::Film(_) => ("film.outside", "lies in"),
                _ => ("", "is left from"),
            };
            let key = format!("object.{name}.surface{}{key}", if key.is_empty() { "" } else { "." });
            // Where a body fills the place, two of them overlap, or a film pokes into one.
            let ranks = if is_in == SURROUNDING { "" } else { "; of bodies that overlap give one the higher priority" };
            RenderError::Scene {
                message: format!(
                    "{key}: a ray comes to object \"{name}\", which {why} {}, in {}; close the body that the medium fills, \
                         or let the object lie in the medium around it{ranks}",
                    medium(expected),
                    medium(is_in)
                ),
                key,
            }
        }
        PathFailure::TooDeep { object } => RenderError::Scene {
            message: format!(
                "object \"{}\": more than {DEEPEST} media lie within one another where a ray enters it",
                scene.names[object]
            ),
            key: format!("object.{}", scene.names[object]),
        },
        PathFailure::SamePlace { object } => RenderError::Scene {
            message: format!(
                "object \"{}\": a straight way to a light crosses more than {MOST_FILMS} films here; another film lies in the same \
                 place: leave one of them out, or part them",
                scene.names[object]
            ),
            key: format!("object.{}", scene.names[object]),
        },
    }
}
