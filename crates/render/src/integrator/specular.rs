//! Films, coatings and bare surfaces: light is mirrored and passes, at every wavelength in its own share.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::Singles as Lanes;

use super::parted::{Apart, Refracted};
use super::path::{Continuation, Path, Scattered, Since, Sums, Target};
use super::roulette::Onward;
use super::{SAME_PLANE, Tracer};
use crate::coating::{LayersAt, Sequence};
use crate::failure::PathFailure;
use crate::film::{Beam, Mueller, Phase, Response};
use crate::geometry::Hit;
use crate::materials::{CoatedSurface, FilmSurface};
use crate::medium_stack::MediumStack;
use crate::refraction::refracted_direction;
use crate::sampler::Choices;

/// The media of a coated or bare surface as a path comes to it.
pub(super) struct Sides {
    /// The stack of media beyond.
    pub beyond: MediumStack,
    /// The medium that light is refracted into, or ends in.
    pub exit: u8,
    /// The layers come in the other order.
    pub is_reversed: bool,
}

/// What is expected of the wavelengths that do not go on where a prism parts them.
#[derive(Clone, Copy)]
pub(super) enum Expected {
    /// The mean light.
    Mean,
    /// What they find at least.
    Least,
    /// Nothing: where something absorbs, all of it may be lost.
    Nothing,
}

impl<'a> Tracer<'a> {
    /// Splits a path at a film.
    #[inline(always)]
    pub(super) fn scatter_film<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        film: &FilmSurface,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let Path { hit, direction, medium, .. } = *path;
        if medium.innermost() != film.outside && !self.scene.media.are_one(medium.innermost(), film.outside) {
            self.failure = Some(PathFailure::WrongMedium {
                object: hit.object,
                is_in: medium.innermost(),
                expected: film.outside,
            });
            return false;
        }
        let thickness = film.layer.thickness_nm(&self.scene.geometry, &hit);
        let Some(phase) = self.phase(film.layer.path_nm(thickness)) else { return false };
        let thickness_nm = thickness as f32;
        let along = direction.dot(hit.normal);
        let cos_theta = along.abs().min(1.0) as f32;

        self.rotate_stokes_frame(simd, path);
        path.hits += 1;
        path.is_unpolarized = false;

        let mirror = direction - hit.normal * (2.0 * along);
        let scattered = self.scattered(path);
        let mut passed = self.straight_on(path);
        if path.since == Since::Bend {
            passed = self.shared(passed, path, false);
        }
        let mirrored = self.shared(self.continuation(&hit, mirror, medium, None), path, true);
        self.make_room(simd, 2);
        let to = self.targets(path, (mirrored, mirror), (passed, direction, scattered));
        if path.since == Since::Bend {
            self.share_sun(to[1], path, false);
        }
        self.share_sun(to[0], path, true);
        let (mirrored_y, passed_y) = if phase != Phase::Single {
            let at = (along.abs().min(1.0), thickness, phase);
            simd.vectorize(
                #[inline(always)]
                || self.split_long_film(simd, path, film.number, at, to, sums),
            )
        } else if path.in_plane && self.spectra.films[film.number].is_plain() {
            self.split_plain(simd, path, film.number, cos_theta, thickness_nm, to, sums)
        } else {
            self.split_film(simd, path, film.number, cos_theta, thickness_nm, to, sums)
        };
        let onward = Onward { direction, medium, band: path.band, since: path.since };
        self.follow(simd, path, [mirrored, passed], to, mirror, &onward, [mirrored_y, passed_y], sums, choices)
    }

    /// Splits a path at a coated or bare surface.
    #[inline(always)]
    pub(super) fn scatter_coating<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        coating: &CoatedSurface,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let spectra = self.spectra;
        let Path { hit, direction, medium, .. } = *path;
        let along = direction.dot(hit.normal);
        let is_from_front = along < 0.0;
        let outer = medium.innermost();
        let Some(Sides { beyond, exit, is_reversed }) = self.sides(path, coating) else { return false };
        if self.take_thicknesses(coating, &hit).is_none() {
            return false;
        }
        let cos_theta = along.abs().min(1.0);

        self.rotate_stokes_frame(simd, path);
        path.hits += 1;
        path.is_unpolarized = false;

        let mirror = direction - hit.normal * (2.0 * along);
        let mut refracted = Refracted { direction: None, band: path.band, is_thinned: false, chosen: None };
        let (mut passed, mut apart) = (Continuation::Absorbed, None::<Apart<'_>>);
        if !coating.is_opaque {
            let facing = if is_from_front { hit.normal } else { -hit.normal };
            let media = [&spectra.media[usize::from(outer)], &spectra.media[usize::from(exit)]];
            refracted = self.refract(path, facing, cos_theta, media, choices);
            if let Some(direction) = refracted.direction {
                passed = self.shared(self.continuation(&hit, direction, beyond, None), path, false);
            }
            // By where the middle of the spectrum goes, not the chosen place: how light is estimated must not hang on the choice.
            if let Some(chosen) = refracted.chosen
                && let Some(along) = refracted_direction(direction, facing, cos_theta, media, spectra.bands.middle)
                && !matches!(self.continuation(&hit, along, beyond, None), Continuation::Surface(_))
            {
                apart = Some(Apart { facing, cos_theta, media, beyond, chosen });
                // Whichever it will be that goes on.
                passed = Continuation::Surface(hit);
            }
        }
        let mirrored = self.shared(self.continuation(&hit, mirror, medium, None), path, true);
        self.make_room(simd, 2);
        let expected = match refracted.chosen {
            // What is not followed at all is to be estimated.
            None => Expected::Mean,
            // What is left to chance must not make the rest less than nothing. The same whether the chosen part gets through or not:
            // on average over all choices it cancels.
            Some(_) if self.scene.is_clear => Expected::Least,
            Some(_) => Expected::Nothing,
        };
        let mut passed_direction = refracted.direction.unwrap_or(direction);
        let to = self.targets(path, (mirrored, mirror), (passed, passed_direction, None));
        self.share_sun(to[0], path, true);
        self.share_sun(to[1], path, false);
        let (thicknesses, weights) = (std::mem::take(&mut self.thicknesses), std::mem::take(&mut self.thinned));
        let thinned = (refracted.is_thinned && apart.is_none()).then_some((&weights[..], expected));

        let tables = &spectra.coatings[coating.number];
        let sequence = Sequence {
            outer: &spectra.media[usize::from(outer)],
            layers: LayersAt { tables, thickness_nm: &thicknesses },
            is_reversed,
            exit: &spectra.media[usize::from(exit)],
            rate: &spectra.rate,
        };
        let (mirrored_y, mut passed_y) = self.split_coating(simd, path, &sequence, cos_theta as f32, to, thinned, sums);
        (self.thicknesses, self.thinned) = (thicknesses, weights);
        if let Some(apart) = apart {
            let found = simd.vectorize(
                #[inline(always)]
                || self.pass_apart(simd, path, &apart, sums),
            );
            passed = Continuation::Absorbed;
            if let Some((next, onward, luminance)) = found {
                passed = Continuation::Surface(next);
                (passed_direction, passed_y) = (onward, luminance);
            } else if let (Continuation::Surface(_), Target::Slot(slot)) = (mirrored, to[0]) {
                self.free.push(path.slot);
                path.slot = slot;
            }
        }

        let onward = Onward { direction: passed_direction, medium: beyond, band: refracted.band, since: Since::Bend };
        self.follow(simd, path, [mirrored, passed], to, mirror, &onward, [mirrored_y, passed_y], sums, choices)
    }

    /// The media of a coated or bare surface as a path comes to it; `None` if the pixel cannot be finished.
    #[inline(always)]
    pub(super) fn sides(&mut self, path: &Path, coating: &CoatedSurface) -> Option<Sides> {
        let Path { hit, direction, medium, .. } = *path;
        let is_from_front = direction.dot(hit.normal) < 0.0;
        let outer = medium.innermost();
        let beyond = if is_from_front {
            let Some(deeper) = medium.entered(coating.substrate) else {
                self.failure = Some(PathFailure::TooDeep { object: hit.object });
                return None;
            };
            deeper
        } else if outer == coating.substrate {
            medium.left()
        } else if coating.is_opaque {
            // The back of a thin piece of metal: it looks like its front.
            medium
        } else {
            self.failure =
                Some(PathFailure::WrongMedium { object: hit.object, is_in: outer, expected: coating.substrate });
            return None;
        };
        let is_metal_back = coating.is_opaque && !is_from_front;
        let exit = if is_metal_back { coating.substrate } else { beyond.innermost() };
        // The back of a metal is coated like its front.
        Some(Sides { beyond, exit, is_reversed: !is_from_front && !is_metal_back })
    }

    /// Takes the thicknesses of a coating's layers at a hit: the path difference that they make at most, nm; `None` if their fringes are
    /// finer than the spectra resolve.
    #[inline(always)]
    pub(super) fn take_thicknesses(&mut self, coating: &CoatedSurface, hit: &Hit) -> Option<f64> {
        let mut path_nm = 0.0;
        self.thicknesses.clear();
        for layer in &coating.layers {
            let thickness = layer.thickness_nm(&self.scene.geometry, hit);
            path_nm += layer.path_nm(thickness);
            self.thicknesses.push(thickness as f32);
        }
        (!self.is_too_coarse(path_nm)).then_some(path_nm)
    }

    /// Where both branches of a hit write their spectra; a second slot is taken where both go on.
    #[inline(always)]
    fn targets(
        &mut self,
        path: &Path,
        (mirrored, mirror): (Continuation, Vec3),
        (passed, direction, scattered): (Continuation, Vec3, Option<Scattered>),
    ) -> [Target; 2] {
        let both_go_on = matches!((mirrored, passed), (Continuation::Surface(_), Continuation::Surface(_)));
        let other = if both_go_on {
            let Some(slot) = self.free.pop() else { unreachable!("one slot a level") };
            self.copy_told(path.slot, slot);
            slot
        } else {
            path.slot
        };
        [self.target(mirrored, other, mirror, None), self.target(passed, path.slot, direction, scattered)]
    }

    /// Rotates the frame of the path's Stokes vector into the plane of incidence of the film it meets.
    #[inline(always)]
    pub(super) fn rotate_stokes_frame<S: Simd>(&mut self, simd: S, path: &mut Path) {
        self.rotate_stokes_frame_to(simd, path, path.hit.normal);
    }

    /// The same for a surface, or a facet, of any normal.
    #[inline(always)]
    pub(super) fn rotate_stokes_frame_to<S: Simd>(&mut self, simd: S, path: &mut Path, normal: Vec3) {
        let across = normal.cross(path.direction);
        let sine2 = across.length_squared();
        if sine2 < 1e-12 {
            // Near the normal s and p are alike and every plane is as good: keep the one at hand.
            return;
        }
        // Light travels against the path.
        let p_axis = (-path.direction).cross(path.axis);
        let along_p = across.dot(p_axis);
        if path.in_plane && along_p * along_p < SAME_PLANE * SAME_PLANE * sine2 {
            return;
        }
        let scale = 1.0 / sine2.sqrt();
        let (cos, sin) = (across.dot(path.axis) * scale, along_p * scale);
        path.axis = across * scale;
        if path.is_unpolarized {
            // Unpolarised light looks the same in every frame.
            return;
        }
        let (cos2, sin2) = ((cos * cos - sin * sin) as f32, (2.0 * cos * sin) as f32);
        let blocks = self.blocks;
        let [s, p, u, v] = components(&mut self.arena, path.slot, blocks);
        if path.in_plane {
            u.fill(Lanes::ZERO);
            v.fill(Lanes::ZERO);
            path.in_plane = false;
        }
        for block in 0..blocks {
            let (w_s, w_p, w_u) = (s[block].load(simd), p[block].load(simd), u[block].load(simd));
            let (w_i, w_q) = ((w_s + w_p) * 0.5, (w_s - w_p) * 0.5);
            let turned_q = w_q * cos2 + w_u * sin2;
            s[block].store(w_i + turned_q);
            p[block].store(w_i - turned_q);
            u[block].store(w_u * cos2 - w_q * sin2);
        }
    }

    /// A lossless film while all planes of incidence coincide. `to` tells where the mirrored and the passed branch go;
    /// the luminance of both is given back.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    fn split_plain<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        film: usize,
        cos_theta: f32,
        thickness_nm: f32,
        to: [Target; 2],
        sums: &mut Sums<S>,
    ) -> (f32, f32) {
        let spectra = self.spectra;
        let table = &spectra.films[film];
        let zero = f32x16::splat(simd, 0.0);
        let (mut mirrored_y, mut all_y) = (zero, zero);
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let [r_s, r_p] = table.reflectance(simd, block, cos_theta, thickness_nm);
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            let (back_s, back_p) = (s * r_s, p * r_p);
            xyz = self.splat(simd, to[0], block, back_s, back_p, xyz);
            xyz = self.splat(simd, to[1], block, s - back_s, p - back_p, xyz);
            let weight = spectra.importance[block].load(simd);
            mirrored_y = weight.mul_add(back_s + back_p, mirrored_y);
            all_y = weight.mul_add(s + p, all_y);
        }
        sums.0 = xyz;
        let mirrored_y = mirrored_y.reduce_sum();
        (mirrored_y, all_y.reduce_sum() - mirrored_y)
    }

    /// [`Tracer::split_plain`] for any film and any planes.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    pub(super) fn split_film<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        film: usize,
        cos_theta: f32,
        thickness_nm: f32,
        to: [Target; 2],
        sums: &mut Sums<S>,
    ) -> (f32, f32) {
        let table = &self.spectra.films[film];
        let zero = f32x16::splat(simd, 0.0);
        let mut luminance = [zero; 2];
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let response = table.response(simd, block, cos_theta, thickness_nm);
            (xyz, luminance) = self.split_block(simd, path, block, &response, to, None, xyz, luminance);
        }
        sums.0 = xyz;
        (luminance[0].reduce_sum(), luminance[1].reduce_sum())
    }

    /// [`Tracer::split_film`] for a film whose phase single precision does not hold.
    #[inline(always)]
    pub(super) fn split_long_film<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        film: usize,
        (cos_theta, thickness_nm, phase): (f64, f64, Phase),
        to: [Target; 2],
        sums: &mut Sums<S>,
    ) -> (f32, f32) {
        let table = &self.spectra.films[film];
        let zero = f32x16::splat(simd, 0.0);
        let mut luminance = [zero; 2];
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let response = table.long_response(simd, block, cos_theta, thickness_nm, phase);
            (xyz, luminance) = self.split_block(simd, path, block, &response, to, None, xyz, luminance);
        }
        sums.0 = xyz;
        (luminance[0].reduce_sum(), luminance[1].reduce_sum())
    }

    /// The same for a coated or bare surface.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    pub(super) fn split_coating<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        sequence: &Sequence<'_>,
        cos_theta: f32,
        to: [Target; 2],
        thinned: Option<(&[Lanes], Expected)>,
        sums: &mut Sums<S>,
    ) -> (f32, f32) {
        let zero = f32x16::splat(simd, 0.0);
        let mut luminance = [zero; 2];
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let response = sequence.response(simd, block, cos_theta);
            (xyz, luminance) = self.split_block(simd, path, block, &response, to, thinned, xyz, luminance);
        }
        sums.0 = xyz;
        (luminance[0].reduce_sum(), luminance[1].reduce_sum())
    }

    /// One block of nodes: sums and luminances go in and out by value.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    fn split_block<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        block: usize,
        response: &Response<S>,
        to: [Target; 2],
        thinned: Option<(&[Lanes], Expected)>,
        mut xyz: [f32x16<S>; 3],
        mut luminance: [f32x16<S>; 2],
    ) -> ([f32x16<S>; 3], [f32x16<S>; 2]) {
        let zero = f32x16::splat(simd, 0.0);
        let mut w = Beam {
            s: self.arena[self.at(path.slot, 0, block)].load(simd),
            p: self.arena[self.at(path.slot, 1, block)].load(simd),
            u: zero,
            v: zero,
        };
        if !path.in_plane {
            w.u = self.arena[self.at(path.slot, 2, block)].load(simd);
            w.v = self.arena[self.at(path.slot, 3, block)].load(simd);
        }
        let matrices: [&Mueller<S>; 2] = [&response.reflect, &response.transmit];
        for branch in 0..2 {
            let mut out = matrices[branch].carry(&w);
            if let (1, Some((weights, expected))) = (branch, thinned) {
                // What the other bands are expected to find is added for certain, whatever this one finds.
                let weight = weights[block].load(simd);
                let before = out.s + out.p;
                out = Beam { s: out.s * weight, p: out.p * weight, u: out.u * weight, v: out.v * weight };
                let rest = before - (out.s + out.p);
                xyz = match expected {
                    Expected::Nothing => xyz,
                    Expected::Mean => self.add_mean(simd, block, rest, xyz),
                    Expected::Least => self.add_around(simd, block, rest, self.spectra.lights.least_rgb, xyz),
                };
            }
            xyz = self.splat(simd, to[branch], block, out.s, out.p, xyz);
            if let (Target::Slot(slot), false) = (to[branch], path.in_plane) {
                let (u_at, v_at) = (self.at(slot, 2, block), self.at(slot, 3, block));
                self.arena[u_at].store(out.u);
                self.arena[v_at].store(out.v);
            }
            let weight = self.spectra.importance[block].load(simd);
            luminance[branch] = weight.mul_add(out.s + out.p, luminance[branch]);
        }
        (xyz, luminance)
    }
}

/// The four components of a slot.
#[inline(always)]
fn components(arena: &mut [Lanes], slot: usize, blocks: usize) -> [&mut [Lanes]; 4] {
    let own = &mut arena[slot * 4 * blocks..(slot + 1) * 4 * blocks];
    let (s, rest) = own.split_at_mut(blocks);
    let (p, rest) = rest.split_at_mut(blocks);
    let (u, v) = rest.split_at_mut(blocks);
    [s, p, u, v]
}
