//! The built-in studio: light made by code, after how bubbles are photographed. A dark room, a bright overcast bay
//! of windows behind the camera, a soft box on either side, a strip overhead: the front of a bubble mirrors it upright,
//! its back upside down, and what is seen through the bubble stays dark, so the film's own colours carry the picture.

use std::f32::consts::PI;
use std::sync::Arc;

use crate::model::EnvironmentMap;

const WIDTH: usize = 1024;
const HEIGHT: usize = 512;

/// 0 below `from`, 1 above `to`, smooth between.
fn smooth(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 1 between `from` and `to`, falling to 0 over `soft` degrees on either side.
fn band(from: f32, to: f32, soft: f32, x: f32) -> f32 {
    smooth(from - soft, from + soft, x) * (1.0 - smooth(to - soft, to + soft, x))
}

/// The map, 1024 x 512.
pub fn studio() -> Arc<EnvironmentMap> {
    let mut rgb = Vec::with_capacity(3 * WIDTH * HEIGHT);
    for row in 0..HEIGHT {
        let elevation = 90.0 - 180.0 * (row as f32 + 0.5) / HEIGHT as f32;
        for column in 0..WIDTH {
            // Azimuth from behind the camera (+z), positive to its right (+x).
            let turn = (column as f32 + 0.5) / WIDTH as f32 - 0.5;
            let azimuth = if turn >= 0.0 { 180.0 - 360.0 * turn } else { -180.0 - 360.0 * turn };
            rgb.extend([radiance(azimuth, elevation); 3]);
        }
    }
    Arc::new(EnvironmentMap { width: WIDTH, height: HEIGHT, rgb })
}

fn radiance(azimuth: f32, elevation: f32) -> f32 {
    let behind = (0.5 + 0.5 * (azimuth * PI / 180.0).cos()) * (elevation * PI / 180.0).cos().max(0.0);
    // The room: nearly black ahead, a little floor light, more behind the camera.
    let mut light = 0.012 + 0.02 * smooth(-60.0, 80.0, elevation) + 0.16 * behind * behind;
    // A wide bay of windows behind the camera, three panes by two, its bars seen as a cross on every bubble.
    let pane = |a0: f32, a1: f32| {
        band(a0, a1, 0.9, azimuth) * (band(-4.0, 20.0, 0.9, elevation) + band(23.0, 46.0, 0.9, elevation))
    };
    light += 5.0 * (pane(-76.0, -52.0) + pane(-49.0, -25.0) + pane(25.0, 49.0) + pane(52.0, 76.0));
    // Soft boxes beside the bubble, brighter towards their middle.
    let side = |sign: f32| {
        let a = sign * azimuth;
        let e = (elevation - 12.0) / 46.0;
        band(98.0, 122.0, 3.0, a) * band(-34.0, 58.0, 5.0, elevation) * (1.0 - 0.55 * e * e)
    };
    light += 7.0 * side(1.0) + 4.5 * side(-1.0);
    // A strip overhead and a low one in front of the camera's feet.
    light += 9.0 * band(-38.0, 38.0, 4.0, azimuth) * band(62.0, 74.0, 2.0, elevation);
    light += 1.6 * band(-60.0, 60.0, 8.0, azimuth) * band(-52.0, -36.0, 3.0, elevation);
    light
}
