//! Light that the branches of a path find: where the spectra of each go, and what is added up of it.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::Singles as Lanes;

use super::Tracer;
use super::escaped::Share;
use super::path::{Continuation, Found, Scattered, Sums, Target};
use crate::lights::Source;
use crate::lights::chooser::LightId;

impl Tracer<'_> {
    /// Where the spectra of a branch are written.
    #[inline(always)]
    pub(super) fn target(
        &mut self,
        continuation: Continuation,
        slot: usize,
        direction: Vec3,
        scattered: Option<Scattered>,
    ) -> Target {
        let lights = &self.spectra.lights;
        let target = match continuation {
            Continuation::Surface(_) => Target::Slot(slot),
            Continuation::Escapes if lights.depend_on_direction() => {
                let sun = lights.sun_at(direction).map(|(sun, _)| (sun, self.sun_mis_weight(sun, scattered)));
                let share =
                    Share { maps: self.environment_mis_weight(scattered), sun: sun.filter(|(_, share)| *share > 0.0) };
                if share.maps == 0.0 && share.sun.is_none() {
                    Target::Uniform
                } else {
                    Target::Out(self.escaped.push(direction, share))
                }
            }
            Continuation::Escapes => Target::Uniform,
            Continuation::Emitter(emitter, share) => Target::Emitter(emitter, share),
            Continuation::Backdrop(sun) => Target::Told(Found::Backdrop(sun)),
            Continuation::Absorbed => Target::Nowhere,
        };
        match target {
            Target::Out(path) if self.extras.is_some() => Target::Told(Found::Out(path)),
            Target::Uniform if self.extras.is_some() => Target::Told(Found::Uniform),
            Target::Emitter(emitter, share) if self.extras.is_some() => Target::Told(Found::Emitter(emitter, share)),
            target => target,
        }
    }

    /// Writes a block of a branch to where it goes; one that meets lights whose weights are known finds them at once.
    ///
    /// Sums go in and out by value: behind a reference they pass through memory at every block.
    #[inline(always)]
    pub(super) fn splat<S: Simd>(
        &mut self,
        simd: S,
        to: Target,
        block: usize,
        s: f32x16<S>,
        p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        match to {
            Target::Slot(slot) => {
                let (s_at, p_at) = (self.at(slot, 0, block), self.at(slot, 1, block));
                self.arena[s_at].store(s);
                self.arena[p_at].store(p);
                return xyz;
            }
            Target::Out(path) => self.escaped.carried[path * self.blocks + block].store(s + p),
            Target::Uniform => {}
            Target::Emitter(emitter, share) => {
                return self.spectra.lights.add_emission(simd, emitter, block, (s + p) * share, xyz);
            }
            Target::Told(found) => {
                return simd.vectorize(
                    #[inline(always)]
                    || self.splat_told(simd, found, block, s + p, xyz),
                );
            }
            Target::Nowhere => return xyz,
        }
        self.spectra.lights.add_uniform(simd, block, s + p, xyz)
    }

    /// [`Tracer::splat`] of light that the sums beside those of the picture are told of.
    #[inline(always)]
    pub(super) fn splat_told<S: Simd>(
        &mut self,
        simd: S,
        found: Found,
        block: usize,
        s_and_p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        match found {
            Found::Out(path) => self.escaped.carried[path * self.blocks + block].store(s_and_p),
            Found::Uniform => {}
            Found::Emitter(emitter, share) => {
                self.tell(Source::Light(LightId::Emitter(emitter)), block, s_and_p * share);
                return self.spectra.lights.add_emission(simd, emitter, block, s_and_p * share, xyz);
            }
            Found::Backdrop(sun) => {
                self.add_share(simd, block, s_and_p);
                let Some(sun) = sun.map(LightId::Sun) else { return xyz };
                self.tell(Source::Light(sun), block, s_and_p);
                return self.spectra.lights.add_light(simd, sun, block, s_and_p, xyz);
            }
        }
        self.tell(Source::Uniform, block, s_and_p);
        self.spectra.lights.add_uniform(simd, block, s_and_p, xyz)
    }

    /// Adds what the backdrop would shine through by, of all that a block carries straight to it.
    #[inline(always)]
    pub(super) fn add_share<S: Simd>(&mut self, simd: S, block: usize, s_and_p: f32x16<S>) {
        let share = self.spectra.lights.white(simd, block) * s_and_p;
        self.batches[self.batch][3] += f64::from(share.reduce_sum()) * self.scene.camera.bare_share();
    }

    /// Tells the sums beside those of the picture of light that is found.
    #[inline(always)]
    pub(super) fn tell<S: Simd>(&self, source: Source, block: usize, carried: f32x16<S>) {
        if let Some(extras) = &self.extras {
            let mut lanes = Lanes::ZERO;
            lanes.store(carried);
            extras.receive(&self.spectra.lights, source, block, &lanes.0);
        }
    }

    /// Adds what a block would find if the lights had their mean radiance everywhere.
    #[inline(always)]
    pub(super) fn add_mean<S: Simd>(
        &self,
        simd: S,
        block: usize,
        s_and_p: f32x16<S>,
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        self.add_around(simd, block, s_and_p, self.spectra.lights.mean_rgb, xyz)
    }

    /// Adds what a block would find if all maps had one radiance everywhere.
    #[inline(always)]
    pub(super) fn add_around<S: Simd>(
        &self,
        simd: S,
        block: usize,
        s_and_p: f32x16<S>,
        rgb: [f32; 3],
        xyz: [f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        let lights = &self.spectra.lights;
        self.tell(Source::Uniform, block, s_and_p);
        if lights.has_maps() {
            self.tell(Source::Map(rgb), block, s_and_p);
        }
        let xyz = lights.add_uniform(simd, block, s_and_p, xyz);
        if lights.has_maps() { lights.add_map(simd, block, s_and_p, rgb, xyz) } else { xyz }
    }

    /// Not `map`: closures are not compiled for the wider instructions.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, batch: usize, sums: &Sums<S>) {
        let [x, y, z] = sums.0;
        let total = &mut self.batches[batch];
        total[0] += f64::from(x.reduce_sum());
        total[1] += f64::from(y.reduce_sum());
        total[2] += f64::from(z.reduce_sum());
    }
}
