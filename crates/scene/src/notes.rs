//! What whoever renders a sound scene should be told.

use crate::model::{Light, Object, Roughness, Scene, Surface};

impl Scene {
    /// One sentence each.
    pub fn notes(&self) -> Vec<String> {
        let are_deltas = self.lights.iter().all(|light| matches!(light, Light::Delta(_)));
        let scatters = |object: &Object| {
            matches!(object.surface, Surface::Diffuse(_) | Surface::Emitter(_)) || object.roughness != Roughness::SMOOTH
        };
        if are_deltas && !self.objects.iter().any(scatters) {
            return vec![
                "every light of the scene has no size (directional, point, spot) and every surface is smooth: mirrors and \
                 films do not show such lights, so the picture is black; a sun, an environment or an emitter is seen"
                    .to_owned(),
            ];
        }
        Vec::new()
    }
}
