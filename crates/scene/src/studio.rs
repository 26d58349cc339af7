//! The built-in studio: light made by code, after how bubbles are photographed. A window with bars to the left behind
//! the camera, a soft box to the right, a strip on either side behind the bubble for its rim, one overhead, and a grey
//! room that lights the rest of the film. The front of a bubble mirrors all that upright, its back upside down. What is
//! seen through the bubble stays dark. All of it is grey: every colour in the picture is the film's.

use std::sync::{Arc, LazyLock};

use iridesce_numerics::vector::dot;

use crate::model::EnvironmentMap;

const WIDTH: usize = 1024;
const HEIGHT: usize = 512;

/// The map, 1024 x 512, made once.
pub fn studio() -> Arc<EnvironmentMap> {
    static STUDIO: LazyLock<Arc<EnvironmentMap>> = LazyLock::new(|| Arc::new(make()));
    STUDIO.clone()
}

fn make() -> EnvironmentMap {
    let lights = Lights::new();
    let mut rgb = Vec::with_capacity(3 * WIDTH * HEIGHT);
    for row in 0..HEIGHT {
        let polar = std::f32::consts::PI * (row as f32 + 0.5) / HEIGHT as f32;
        for column in 0..WIDTH {
            // The middle column looks to -z, columns grow towards +x.
            let turn = std::f32::consts::TAU * ((column as f32 + 0.5) / WIDTH as f32 - 0.5);
            let direction = [polar.sin() * turn.sin(), polar.cos(), -polar.sin() * turn.cos()];
            rgb.extend([lights.radiance(direction); 3]);
        }
    }
    EnvironmentMap { width: WIDTH, height: HEIGHT, rgb }
}

/// 0 below `from`, 1 above `to`, smooth between.
fn smooth(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A flat rectangle of light at distance 1 that faces the bubble.
struct Panel {
    normal: [f32; 3],
    right: [f32; 3],
    up: [f32; 3],
    half_width: f32,
    half_height: f32,
    /// Width of its blurred edge, to either side.
    soft: f32,
}

impl Panel {
    /// Azimuth from behind the camera (+z), positive to its right (+x); elevation from the horizon.
    fn new(azimuth_deg: f32, elevation_deg: f32, half_width: f32, half_height: f32, soft: f32) -> Panel {
        let ((sin_a, cos_a), (sin_e, cos_e)) =
            (azimuth_deg.to_radians().sin_cos(), elevation_deg.to_radians().sin_cos());
        Panel {
            normal: [cos_e * sin_a, sin_e, cos_e * cos_a],
            right: [cos_a, 0.0, -sin_a],
            up: [-sin_e * sin_a, cos_e, -sin_e * cos_a],
            half_width,
            half_height,
            soft,
        }
    }

    /// How much of it a direction meets, 0 to 1, and where: -1 to 1 across and up.
    fn meet(&self, direction: [f32; 3]) -> Option<(f32, f32, f32)> {
        let ahead = dot(direction, self.normal);
        if ahead < 0.05 {
            return None;
        }
        let (across, up) = (dot(direction, self.right) / ahead, dot(direction, self.up) / ahead);
        let share = smooth(-self.soft, self.soft, self.half_width - across.abs())
            * smooth(-self.soft, self.soft, self.half_height - up.abs());
        (share > 0.0).then(|| (share, across / self.half_width, up / self.half_height))
    }
}

/// 1 on the glass and 0 on the bars between `panes` panes along a side of half the length `half`; `x` from -1 to 1.
fn glass(x: f32, panes: f32, half: f32) -> f32 {
    const BAR: f32 = 0.028;
    const BLUR: f32 = 0.005;
    let place = (x + 1.0) / 2.0 * panes;
    let nearest = place.round();
    if nearest < 0.5 || nearest > panes - 0.5 {
        return 1.0;
    }
    smooth(BAR - BLUR, BAR + BLUR, (place - nearest).abs() * 2.0 * half / panes)
}

/// The lamps. Numbers by eye, for the look of the bubble.
struct Lights {
    window: Panel,
    soft_box: Panel,
    rim_left: Panel,
    rim_right: Panel,
    overhead: Panel,
    floor: Panel,
}

impl Lights {
    fn new() -> Lights {
        Lights {
            window: Panel::new(-44.0, 26.0, 0.66, 0.80, 0.010),
            soft_box: Panel::new(60.0, 12.0, 0.60, 1.0, 0.12),
            rim_left: Panel::new(-120.0, 6.0, 0.24, 1.2, 0.12),
            rim_right: Panel::new(118.0, 6.0, 0.28, 1.2, 0.12),
            overhead: Panel::new(10.0, 78.0, 0.75, 0.26, 0.08),
            floor: Panel::new(0.0, -60.0, 1.1, 0.40, 0.25),
        }
    }

    fn radiance(&self, direction: [f32; 3]) -> f32 {
        let [_, y, z] = direction;
        // The backdrop glows a little where the camera looks; the room behind the camera is lighter towards its ceiling.
        let backdrop = 0.008 + 0.03 * smooth(0.5, 1.0, -z - 0.25 * y);
        let room = 0.75 * smooth(0.3, 1.0, 0.5 + 0.5 * z) * (0.65 + 0.35 * y);
        let mut light = backdrop + room;
        if let Some((share, x, y)) = self.window.meet(direction) {
            let panes = glass(x, 2.0, self.window.half_width) * glass(y, 3.0, self.window.half_height);
            light += share * panes * (7.0 + 2.5 * y);
        }
        if let Some((share, x, _)) = self.soft_box.meet(direction) {
            light += share * (3.4 - 0.8 * x);
        }
        for (panel, radiance) in
            [(&self.rim_left, 2.6), (&self.rim_right, 3.4), (&self.overhead, 5.0), (&self.floor, 0.9)]
        {
            light += panel.meet(direction).map_or(0.0, |(share, ..)| share * radiance);
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radiance towards an azimuth from behind the camera, positive to its right, and an elevation.
    fn at(azimuth_deg: f32, elevation_deg: f32) -> f32 {
        let map = studio();
        let row = (90.0 - elevation_deg) / 180.0 * HEIGHT as f32;
        let column = (0.5 - (azimuth_deg - 180.0) / 360.0).rem_euclid(1.0) * WIDTH as f32;
        map.rgb[3 * (row as usize * WIDTH + column as usize)]
    }

    #[test]
    fn the_lamps_hang_where_they_should() {
        let map = studio();
        assert_eq!((map.width, map.height, map.rgb.len()), (1024, 512, 3 * 1024 * 512));
        assert!(map.rgb.iter().all(|&v| v > 0.0 && v < 16.0), "light everywhere, nowhere too much");
        assert!(map.rgb.chunks_exact(3).all(|rgb| rgb[0] == rgb[1] && rgb[1] == rgb[2]), "grey");
        assert!(at(180.0, 0.0) < 0.05, "dark straight ahead");
        assert!(at(-52.0, 30.0) > 5.0 && at(-36.0, 30.0) > 5.0, "two panes");
        assert!(at(-44.0, 30.0) < 1.0, "and the bar between them");
        assert!((2.0..5.0).contains(&at(60.0, 12.0)), "the soft box on the other side");
        assert!(at(-60.0, -40.0) < 2.0 && at(0.0, 85.0) > 4.0, "dim floor, bright ceiling");
    }

    #[test]
    fn the_studio_is_made_once() {
        assert!(Arc::ptr_eq(&studio(), &studio()));
    }
}
