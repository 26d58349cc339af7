//! Where a surface parts the wavelengths of a path: one place of the spectrum goes on, or, where nothing more is met, all of them.

use fearless_simd::Simd;
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::Singles as Lanes;

use super::Tracer;
use super::path::{Continuation, Path, Sums};
use crate::coating::IndexTable;
use crate::geometry::Hit;
use crate::medium_stack::MediumStack;
use crate::refraction::{is_parted, refracted_direction};
use crate::sampler::Choices;

/// The refracted branch of a hit.
pub(super) struct Refracted {
    /// `None` beyond the critical angle.
    pub direction: Option<Vec3>,
    pub band: Option<f64>,
    /// Only a part of the spectrum goes on: [`Tracer::thinned`].
    pub is_thinned: bool,
    /// The part that was chosen here, and by how much its place lies beside its node.
    pub chosen: Option<(usize, f64)>,
}

/// Where the wavelengths part for good: those that meet nothing more are all followed.
pub(super) struct Apart<'b> {
    pub facing: Vec3,
    pub cos_theta: f64,
    pub media: [&'b IndexTable; 2],
    pub beyond: MediumStack,
    /// The part that goes on where it meets something, and by how much places lie beside their nodes.
    pub chosen: (usize, f64),
}

impl Tracer<'_> {
    /// The direction beyond a surface. `facing` is its normal on the side of the path.
    #[inline(always)]
    pub(super) fn refract(
        &mut self,
        path: &Path,
        facing: Vec3,
        cos_theta: f64,
        media: [&IndexTable; 2],
        choices: &mut Choices,
    ) -> Refracted {
        let bands = &self.spectra.bands;
        let mut band = path.band;
        let is_parted = band.is_none() && is_parted(bands, cos_theta, media);
        let chosen = is_parted.then(|| bands.choose_group(choices.pair()));
        if let Some((group, moved)) = chosen {
            let place = bands.place(group, moved);
            bands.weigh(place, &mut self.thinned);
            band = Some(place);
        }
        let direction = refracted_direction(path.direction, facing, cos_theta, media, band.unwrap_or(bands.middle));
        if direction.is_none() {
            // A little may pass at other nodes than the one that tells the direction: it finds the mean light.
            self.thinned.clear();
            self.thinned.resize(self.blocks, Lanes::ZERO);
        }
        Refracted { direction, band, is_thinned: is_parted || direction.is_none(), chosen }
    }

    /// Takes what a surface passes, which stands in the path's slot, on by every wavelength's own way: those that meet nothing more are
    /// added up, and of the others the chosen part stays in the slot. What it meets, its direction and its luminance.
    #[inline(always)]
    pub(super) fn pass_apart<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        apart: &Apart<'_>,
        sums: &mut Sums<S>,
    ) -> Option<(Hit, Vec3, f32)> {
        let &Apart { facing, cos_theta, media, beyond, chosen: (chosen, moved) } = apart;
        let bands = &self.spectra.bands;
        let along = |place: f64| refracted_direction(path.direction, facing, cos_theta, media, place);
        let mut weights = std::mem::take(&mut self.thinned);
        let mut goes_on = None;
        for group in 0..bands.count() {
            // What passes at a node passes, though a place beside it may lie beyond the critical angle.
            let found = along(bands.place(group, moved)).or_else(|| along(bands.place(group, 0.0)));
            let Some(direction) = found else { continue };
            let found = self.shared(self.continuation(&path.hit, direction, beyond, None), path, false);
            if let Continuation::Surface(next) = found {
                if group == chosen {
                    goes_on = Some((next, direction));
                }
                continue;
            }
            self.make_room(simd, 1);
            let to = self.target(found, path.slot, direction, None);
            self.share_sun(to, path, false);
            bands.weigh_group(group, 1.0, &mut weights);
            let mut xyz = sums.0;
            for (block, weight) in weights.iter().enumerate() {
                let weight = weight.load(simd);
                let s = self.arena[self.at(path.slot, 0, block)].load(simd) * weight;
                let p = self.arena[self.at(path.slot, 1, block)].load(simd) * weight;
                xyz = self.splat(simd, to, block, s, p, xyz);
            }
            sums.0 = xyz;
        }
        let found = goes_on.map(|(next, direction)| {
            bands.weigh_group(chosen, (1.0 / bands.chance(chosen)) as f32, &mut weights);
            for component in 0..if path.in_plane { 2 } else { 4 } {
                for (block, weight) in weights.iter().enumerate() {
                    let at = self.at(path.slot, component, block);
                    let left = self.arena[at].load(simd) * weight.load(simd);
                    self.arena[at].store(left);
                }
            }
            (next, direction, self.luminance(simd, path))
        });
        self.thinned = weights;
        found
    }
}
