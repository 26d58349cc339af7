//! The spectra that paths carry, by slot: s, p, u and v, a block of nodes after the other.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::turns::exp2;

use super::Tracer;
use super::path::Path;
use crate::film::Beam;

impl Tracer<'_> {
    #[inline(always)]
    pub(super) fn at(&self, slot: usize, component: usize, block: usize) -> usize {
        (slot * 4 + component) * self.blocks + block
    }

    /// Takes off what the medium absorbs on the way to the hit.
    #[inline(always)]
    pub(super) fn attenuate<S: Simd>(&mut self, simd: S, path: &Path) {
        let Some(rate) = &self.spectra.attenuation[usize::from(path.medium.innermost())] else { return };
        let distance = path.hit.distance as f32;
        let components = if path.in_plane { 2 } else { 4 };
        for (block, rate) in rate.iter().enumerate() {
            let passes = exp2(rate.load(simd) * -distance);
            for component in 0..components {
                let at = self.at(path.slot, component, block);
                let left = self.arena[at].load(simd) * passes;
                self.arena[at].store(left);
            }
        }
    }

    /// What a path carries in a block of nodes.
    #[inline(always)]
    pub(super) fn beam<S: Simd>(&self, simd: S, path: &Path, block: usize) -> Beam<S> {
        let zero = f32x16::splat(simd, 0.0);
        let mut beam = Beam {
            s: self.arena[self.at(path.slot, 0, block)].load(simd),
            p: self.arena[self.at(path.slot, 1, block)].load(simd),
            u: zero,
            v: zero,
        };
        if !path.in_plane {
            beam.u = self.arena[self.at(path.slot, 2, block)].load(simd);
            beam.v = self.arena[self.at(path.slot, 3, block)].load(simd);
        }
        beam
    }

    #[inline(always)]
    pub(super) fn store_beam<S: Simd>(&mut self, path: &Path, block: usize, beam: &Beam<S>) {
        let first = self.at(path.slot, 0, block);
        self.arena[first].store(beam.s);
        self.arena[first + self.blocks].store(beam.p);
        if !path.in_plane {
            self.arena[first + 2 * self.blocks].store(beam.u);
            self.arena[first + 3 * self.blocks].store(beam.v);
        }
    }

    /// Gives a path a slot of its own, with all that it carries.
    #[inline(always)]
    pub(super) fn copy_slot(&mut self, path: &mut Path, slot: usize) {
        let count = if path.in_plane { 2 } else { 4 } * self.blocks;
        let (from, to) = (self.at(path.slot, 0, 0), self.at(slot, 0, 0));
        self.arena.copy_within(from..from + count, to);
        path.slot = slot;
    }
}
