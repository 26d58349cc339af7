//! The built-in sky: a clear day at a sun elevation of 35 degrees, made by code.
//!
//! Luminance is that of the CIE standard clear sky of low turbidity: ISO 15469:2004 / CIE S 011:2003, type 12,
//!
//! ```text
//! L ~ phi(Z) f(chi),   phi(Z) = 1 + a exp(b / cos Z),   f(chi) = 1 + c (exp(d chi) - exp(d pi / 2)) + e cos^2 chi
//! ```
//!
//! with Z the angle from the zenith and chi that from the sun. The standard says nothing of colour: every direction has
//! that of CIE daylight of a temperature chosen by eye, blue above, paler at the horizon, warm around the sun. Below the
//! horizon lies even, grey ground that mirrors nothing.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::{Arc, LazyLock};

use iridesce_numerics::latlong;
use iridesce_numerics::vector::dot;
use iridesce_optics::OpticsError;
use iridesce_optics::color::{Adaptation, Illuminant, Observer, Space};

use crate::model::{EnvironmentMap, Sun};

const WIDTH: usize = 1024;
const HEIGHT: usize = 512;

/// Coefficients of sky type 12, the clear sky of low turbidity (ISO 15469:2004 / CIE S 011:2003).
const A: f64 = -1.0;
const B: f64 = -0.32;
const C: f64 = 10.0;
const D: f64 = -3.0;
const E: f64 = 0.45;

/// The sun stands before a camera at +z, to its left.
const SUN_ELEVATION_DEG: f64 = 35.0;
const SUN_AZIMUTH_DEG: f64 = -40.0;
/// Mean angular radius of the sun seen from the earth, degrees.
const SUN_RADIUS_DEG: f64 = 0.266;
/// Temperature of the sun's light on a clear day, kelvin: CIE daylight, as D55.
const SUN_KELVIN: f64 = 5500.0;
/// Illuminance of level ground by the sun over that by the sky.
const SUN_OVER_SKY: f64 = 4.0;

/// Luminous reflectance of the ground: between grass and bare soil, near enough.
const ALBEDO: f64 = 0.12;

/// Reciprocal temperatures of the sky's colours, by eye, 10^6 / kelvin: at the zenith, at the horizon, around the sun.
const ZENITH_MIRED: f64 = 44.0;
const HORIZON_MIRED: f64 = 122.0;
const GLOW_MIRED: f64 = 185.0;
/// How fast the paleness of the horizon fades upwards, and the warmth of the sun around it, degrees.
const HAZE_DEG: f64 = 16.0;
const GLOW_DEG: f64 = 14.0;

/// The sky's map, 1024 x 512, and its sun, made once. The map's mean radiance over all directions has Y = 1.
pub fn sky() -> Result<(Arc<EnvironmentMap>, Sun), OpticsError> {
    static SKY: LazyLock<Result<(Arc<EnvironmentMap>, Sun), OpticsError>> = LazyLock::new(make);
    SKY.clone()
}

fn make() -> Result<(Arc<EnvironmentMap>, Sun), OpticsError> {
    let sun = sun_direction();
    let tints = Tints::new()?;
    let mut rgb = vec![0.0_f64; 3 * WIDTH * HEIGHT];
    // What falls on level ground from the sky, and the sky's part of the mean over all directions.
    let (mut ground, mut mean) = ([0.0; 3], 0.0);
    for row in 0..HEIGHT / 2 {
        for column in 0..WIDTH {
            let direction = towards(row, column);
            let (luminance, tint) = (luminance(direction, sun), tints.at(temperature(direction, sun)));
            let weight = latlong::solid_angle(row, [WIDTH, HEIGHT]);
            mean += weight / (4.0 * PI) * luminance;
            for channel in 0..3 {
                let radiance = luminance * tint[channel];
                rgb[3 * (row * WIDTH + column) + channel] = radiance;
                ground[channel] += weight * direction[1] * radiance;
            }
        }
    }
    let diffuse = tints.luminance(ground);
    let direct = SUN_OVER_SKY * diffuse;
    let sun_tint = tints.at(1e6 / SUN_KELVIN);
    let ground: [f64; 3] = std::array::from_fn(|i| ALBEDO / PI * (ground[i] + direct * sun_tint[i]));
    mean += 0.5 * tints.luminance(ground);
    for texel in rgb[3 * WIDTH * (HEIGHT / 2)..].chunks_exact_mut(3) {
        texel.copy_from_slice(&ground);
    }
    let rgb = rgb.into_iter().map(|value| (value / mean) as f32).collect();
    // The integral of the cosine over a disc of light, exact for any that is wholly above the horizon.
    let angular_radius = SUN_RADIUS_DEG.to_radians();
    let projected = PI * angular_radius.sin().powi(2) * SUN_ELEVATION_DEG.to_radians().sin();
    let sun = Sun {
        direction: sun,
        angular_radius_deg: SUN_RADIUS_DEG,
        illuminant: Illuminant::daylight(SUN_KELVIN)?,
        radiance: direct / mean / projected,
        polarized_deg: None,
    };
    Ok((Arc::new(EnvironmentMap { width: WIDTH, height: HEIGHT, rgb }), sun))
}

fn sun_direction() -> [f64; 3] {
    let (elevation, azimuth) = (SUN_ELEVATION_DEG.to_radians(), SUN_AZIMUTH_DEG.to_radians());
    // Azimuth from straight ahead (-z), positive to the right (+x).
    [elevation.cos() * azimuth.sin(), elevation.sin(), -elevation.cos() * azimuth.cos()]
}

/// The direction of a texel's middle.
fn towards(row: usize, column: usize) -> [f64; 3] {
    latlong::direction([column as f64 + 0.5, row as f64 + 0.5], [WIDTH, HEIGHT])
}

/// Luminance of the sky in a direction above the horizon, to a common factor.
fn luminance(direction: [f64; 3], sun: [f64; 3]) -> f64 {
    let gradation = 1.0 + A * (B / direction[1]).exp();
    let cosine = dot(direction, sun).clamp(-1.0, 1.0);
    let indicatrix = 1.0 + C * ((D * cosine.acos()).exp() - (D * FRAC_PI_2).exp()) + E * cosine * cosine;
    gradation * indicatrix
}

/// Reciprocal temperature of the sky's colour in a direction above the horizon, 10^6 / kelvin.
fn temperature(direction: [f64; 3], sun: [f64; 3]) -> f64 {
    let haze = (-direction[1].asin().to_degrees() / HAZE_DEG).exp();
    let from_sun = dot(direction, sun).clamp(-1.0, 1.0).acos().to_degrees();
    let glow = (-from_sun / GLOW_DEG).exp();
    let sky = ZENITH_MIRED + (HORIZON_MIRED - ZENITH_MIRED) * haze;
    sky + (GLOW_MIRED - sky) * glow
}

/// Colours of daylight, linear Rec.709 of luminance 1, by reciprocal temperature.
struct Tints {
    /// From 40 to 250 mired, the range of the CIE daylight formula.
    table: Vec<[f64; 3]>,
    luminance: [f64; 3],
}

impl Tints {
    const FROM_MIRED: f64 = 40.0;
    const TO_MIRED: f64 = 250.0;
    const STEPS: usize = 42;

    fn new() -> Result<Tints, OpticsError> {
        let space = Space::LinearSrgb;
        let mut table = Vec::with_capacity(Self::STEPS + 1);
        for i in 0..=Self::STEPS {
            let mired = Self::FROM_MIRED + (Self::TO_MIRED - Self::FROM_MIRED) * i as f64 / Self::STEPS as f64;
            let white = Illuminant::daylight(1e6 / mired)?.white(Observer::Cie1931);
            let white = white.map(|value| value / white[1]);
            table.push(space.from_xyz(white, white, Adaptation::None));
        }
        let luminance = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|rgb| space.to_xyz(rgb, [1.0; 3], Adaptation::None)[1]);
        Ok(Tints { table, luminance })
    }

    fn at(&self, mired: f64) -> [f64; 3] {
        let place = (mired - Self::FROM_MIRED) / (Self::TO_MIRED - Self::FROM_MIRED) * Self::STEPS as f64;
        let first = (place.max(0.0) as usize).min(Self::STEPS - 1);
        let share = place - first as f64;
        std::array::from_fn(|i| self.table[first][i] * (1.0 - share) + self.table[first + 1][i] * share)
    }

    fn luminance(&self, rgb: [f64; 3]) -> f64 {
        dot(rgb, self.luminance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made() -> (Arc<EnvironmentMap>, Sun) {
        sky().unwrap()
    }

    /// Linear Rec.709 in the texel nearest to an azimuth from straight ahead, positive to the right, and an elevation.
    fn at(azimuth_deg: f64, elevation_deg: f64) -> [f64; 3] {
        let map = made().0;
        let row = ((90.0 - elevation_deg) / 180.0 * HEIGHT as f64) as usize;
        let column = ((0.5 + azimuth_deg / 360.0).rem_euclid(1.0) * WIDTH as f64) as usize;
        std::array::from_fn(|i| f64::from(map.rgb[3 * (row.min(HEIGHT - 1) * WIDTH + column) + i]))
    }

    /// Luminance of Rec.709, ITU-R BT.709-6, item 3.2.
    fn y(rgb: [f64; 3]) -> f64 {
        dot(rgb, iridesce_optics::color::REC709_LUMINANCE)
    }

    #[test]
    fn luminance_is_that_of_the_standard() {
        // L / L_z = f(chi) phi(Z) / (f(Z_s) phi(0)) with Z_s = 55 degrees, worked out by hand from the coefficients.
        let zenith = luminance([0.0, 1.0, 0.0], sun_direction());
        let relative = |azimuth: f64, elevation: f64| {
            let ((sin_a, cos_a), (sin_e, cos_e)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
            luminance([cos_e * sin_a, sin_e, -cos_e * cos_a], sun_direction()) / zenith
        };
        // Opposite the sun at an elevation of 55: chi = 90, f = 1; phi(Z = 35) = 1 - exp(-0.32 / 0.819152) = 0.323382.
        // f(55) = 1 + 10 (0.056146 - 0.008983) + 0.45 * 0.328990 = 1.619676; phi(0) = 1 - exp(-0.32) = 0.273851.
        assert!((relative(140.0, 55.0) - 0.323382 / (1.619676 * 0.273851)).abs() < 2e-6, "{}", relative(140.0, 55.0));
        // In the sun's place: f(0) = 1 + 10 (1 - 0.008983) + 0.45 = 11.360167; phi(55) = 1 - exp(-0.32 / 0.573576).
        let expected = 11.360167 * (1.0 - f64::exp(-0.32 / 0.573576)) / (1.619676 * 0.273851);
        assert!((relative(-40.0, 35.0) - expected).abs() < 1e-5);
        // The map has it, too: texels are half a degree or less off.
        for (azimuth, elevation) in [(0.0, 10.0), (100.0, 45.0), (-100.0, 70.0), (180.0, 30.0)] {
            let found = y(at(azimuth, elevation)) / y(at(0.0, 89.9));
            assert!((found / relative(azimuth, elevation) - 1.0).abs() < 0.03, "{azimuth} {elevation}");
        }
    }

    #[test]
    fn light_is_shared_as_promised() {
        let (map, sun) = made();
        let (mut mean, mut diffuse) = (0.0, 0.0);
        for row in 0..HEIGHT {
            for column in 0..WIDTH {
                let texel = std::array::from_fn(|i| f64::from(map.rgb[3 * (row * WIDTH + column) + i]));
                let weight = latlong::solid_angle(row, [WIDTH, HEIGHT]) * y(texel);
                mean += weight / (4.0 * PI);
                diffuse += weight * towards(row, column)[1].max(0.0);
            }
        }
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
        let omega = 2.0 * PI * (1.0 - f64::cos(sun.angular_radius_deg.to_radians()));
        let direct = sun.radiance * omega * sun.direction[1];
        assert!((direct / diffuse - 4.0).abs() < 0.01, "{}", direct / diffuse);
        // The ground: albedo times all that falls on it, over pi.
        let ground = y(at(50.0, -30.0));
        assert!((ground - 0.12 * (direct + diffuse) / PI).abs() < 1e-3 * ground, "{ground} {direct} {diffuse}");
        assert_eq!(at(50.0, -30.0), at(-120.0, -89.9), "even everywhere");
        assert!((dot(sun.direction, sun.direction) - 1.0).abs() < 1e-12);
        assert!((sun.direction[1].asin().to_degrees() - 35.0).abs() < 1e-9);
        assert!(sun.direction[0] < 0.0 && sun.direction[2] < 0.0, "before the camera, to the left");
    }

    #[test]
    fn the_zenith_is_blue_and_the_horizon_pale() {
        let blueness = |rgb: [f64; 3]| rgb[2] / rgb[0];
        assert!((2.0..6.0).contains(&blueness(at(0.0, 89.0))), "{:?}", at(0.0, 89.0));
        assert!((1.0..2.0).contains(&blueness(at(140.0, 1.0))));
        assert!(blueness(at(-40.0, 35.0)) < 1.0, "warm around the sun");
        assert!(blueness(at(0.0, -30.0)) < 1.2, "the ground is grey");
        assert!(made().0.rgb.iter().all(|&v| v > 0.0 && v < 100.0));
        assert!(y(at(-40.0, 35.0)) > 4.0 * y(at(140.0, 35.0)));
    }

    #[test]
    fn the_sky_is_made_once() {
        assert!(Arc::ptr_eq(&made().0, &made().0));
    }
}
