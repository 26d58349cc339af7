//! Paths that escape to the lights that depend on direction, sixteen at a time.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;

use super::Tracer;
use super::escaped::Share;
use super::path::Sums;
use crate::lights::chooser::LightId;
use crate::lights::{Source, SunDisc};
use crate::prepare::Prepared;

impl Tracer<'_> {
    /// Makes room for a few more paths.
    #[inline(always)]
    pub(super) fn make_room<S: Simd>(&mut self, simd: S, paths: usize) {
        if self.escaped.count + paths > LANES {
            // Once in sixteen paths: not worth being compiled in place, of which there are many.
            simd.vectorize(
                #[inline(always)]
                || self.add_environment(simd),
            );
        }
    }

    /// Adds the environment for the paths that have escaped.
    #[inline(always)]
    pub(super) fn add_environment<S: Simd>(&mut self, simd: S) {
        if self.escaped.count == 0 {
            return;
        }
        let lights = &self.spectra.lights;
        let [red, green, blue] = lights.map_rgb(simd, &self.escaped.directions);
        let mut xyz = [f32x16::splat(simd, 0.0); 3];
        let mut batch = self.escaped.batches[0];
        for path in 0..self.escaped.count {
            if self.escaped.batches[path] != batch {
                self.add(batch, &Sums(xyz));
                (xyz, batch) = ([f32x16::splat(simd, 0.0); 3], self.escaped.batches[path]);
            }
            let Share { maps, sun } = self.escaped.shares[path];
            let rgb = [red[path] * maps, green[path] * maps, blue[path] * maps];
            for block in 0..self.blocks {
                let carried = self.escaped.carried[path * self.blocks + block].load(simd);
                xyz = lights.add_map(simd, block, carried, rgb, xyz);
                self.tell(Source::Map(rgb), block, carried);
            }
            if let Some((sun, share)) = sun {
                for block in 0..self.blocks {
                    let carried = self.escaped.carried[path * self.blocks + block].load(simd) * share;
                    xyz = lights.add_light(simd, LightId::Sun(sun), block, carried, xyz);
                    self.tell(Source::Light(LightId::Sun(sun)), block, carried);
                }
            }
        }
        self.escaped.count = 0;
        self.add(batch, &Sums(xyz));
    }

    /// Adds what a camera ray finds that meets nothing, through a polariser or none.
    #[inline(always)]
    pub(super) fn add_unscattered<S: Simd>(&mut self, simd: S, direction: Vec3, polarizer: Option<Vec3>) {
        if self.extras.is_some() {
            self.tell_unscattered(simd, direction, polarizer);
        }
        let lights = &self.spectra.lights;
        let share: f32 = if polarizer.is_some() { 0.5 } else { 1.0 };
        if self.scene.has_alpha {
            self.batches[self.batch][3] += 1.0;
        } else {
            for c in 0..3 {
                self.batches[self.batch][c] += f64::from(share) * lights.uniform_xyz[c];
            }
        }
        if !lights.depend_on_direction() {
            return;
        }
        let sun = match lights.sun_at(direction) {
            Some((_, false)) => {
                let scene = self.scene;
                let seen = lights.suns.iter().filter(|sun| sun.is_at(direction) && !is_left_out(scene, sun));
                for sun in seen {
                    let part = match (polarizer, sun.linear) {
                        (Some(axis), Some(linear)) => 0.5 * (1.0 + linear.stokes(-direction, axis)[0]),
                        _ => f64::from(share),
                    };
                    for (total, xyz) in self.batches[self.batch].iter_mut().zip(sun.xyz) {
                        *total += part * xyz;
                    }
                }
                None
            }
            found => found
                .map(|(sun, _)| sun)
                .filter(|sun| !is_left_out(self.scene, &lights.suns[*sun]))
                .map(|sun| (sun, share)),
        };
        let maps = if self.scene.has_alpha { 0.0 } else { share };
        self.bare.push(direction, Share { maps, sun });
        if self.bare.count == LANES {
            self.add_environment_unscattered(simd);
        }
    }

    /// Tells the sums beside those of the picture of the light that a camera ray finds that meets nothing.
    fn tell_unscattered<S: Simd>(&self, simd: S, direction: Vec3, polarizer: Option<Vec3>) {
        let Some(extras) = &self.extras else { return };
        let lights = &self.spectra.lights;
        let has_stokes = extras.has_stokes();
        let axis = if has_stokes { None } else { polarizer };
        let natural = if axis.is_some() { 1.0 } else { 2.0 };
        if !self.scene.has_alpha {
            extras.receive_evenly(lights, Source::Uniform, [natural, 0.0, 0.0, 0.0]);
        }
        if lights.has_maps() && !self.scene.has_alpha {
            let towards = [direction.x, direction.y, direction.z];
            let towards = towards.map(|along| iridesce_numerics::lanes::Lanes([along as f32; LANES]));
            let rgb = lights.map_rgb(simd, &towards).map(|lanes| lanes[0]);
            extras.receive_evenly(lights, Source::Map(rgb), [natural, 0.0, 0.0, 0.0]);
        }
        let suns = lights.suns.iter().enumerate();
        for (number, sun) in suns.filter(|(_, sun)| sun.is_at(direction) && !is_left_out(self.scene, sun)) {
            let along = axis.unwrap_or_else(|| self.scene.camera.upright(direction));
            let [q, u] = sun.linear.map_or([0.0; 2], |linear| linear.stokes(-direction, along).map(|v| v as f32));
            let carried = if axis.is_some() {
                [1.0 + q, 0.0, 0.0, 0.0]
            } else {
                // S2 of pictures is -U of this frame (`Extras::start`).
                [2.0, 2.0 * q, -2.0 * u, 0.0]
            };
            extras.receive_evenly(lights, Source::Light(LightId::Sun(number)), carried);
        }
    }

    /// The same for camera rays that met nothing.
    #[inline(always)]
    pub(super) fn add_environment_unscattered<S: Simd>(&mut self, simd: S) {
        if self.bare.count == 0 {
            return;
        }
        let lights = &self.spectra.lights;
        let rgb = lights.map_rgb(simd, &self.bare.directions);
        let count = self.bare.count;
        let mut start = 0;
        while start < count {
            let batch = self.bare.batches[start];
            let own = self.bare.batches[start..count].iter().take_while(|&&other| other == batch).count();
            let mut sum = [0.0_f64; 3];
            for (sum, lanes) in sum.iter_mut().zip(&rgb) {
                let own = lanes[start..start + own].iter().zip(&self.bare.shares[start..start + own]);
                *sum = own.map(|(&v, share)| f64::from(v * share.maps)).sum();
            }
            let total = &mut self.batches[batch];
            for (total, part) in total.iter_mut().zip(lights.xyz(sum)) {
                *total += part;
            }
            for share in &self.bare.shares[start..start + own] {
                if let Some((sun, share)) = share.sun {
                    for (total, part) in total.iter_mut().zip(lights.suns[sun].xyz) {
                        *total += f64::from(share) * part;
                    }
                }
            }
            start += own;
        }
        self.bare.count = 0;
    }
}

/// Whether a sun belongs to the backdrop, and the picture is without it.
fn is_left_out(scene: &Prepared, sun: &SunDisc) -> bool {
    scene.has_alpha && sun.is_of_sky
}
