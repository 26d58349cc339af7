//! The facets of a rough surface at a hit: which way they send light, how likely, and what each does to it.

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;

use super::Tracer;
use super::direct::{Draws, Scatters, Sends};
use super::path::Path;
use crate::coating::{IndexTable, LayersAt, Sequence};
use crate::facet_lanes::{dot, escapes, single_points, world_lanes};
use crate::film::{Beam, FilmTable, Phase, Response};
use crate::medium_stack::MediumStack;
use crate::microfacet::{Microfacets, Wanderer};
use crate::refraction::{bare_reflectance, ratio};
use crate::rough::Frame;
use crate::sampler::Choices;

/// What light meets at a facet.
#[derive(Clone, Copy)]
pub(super) enum Stack<'b> {
    Film { table: &'b FilmTable, thickness_nm: f64, phase: Phase },
    Layers { media: [&'b IndexTable; 2], layers: LayersAt<'b>, is_reversed: bool, rate: &'b [Lanes] },
}

impl<'b> Stack<'b> {
    /// The layers as they are met from the side of the path or from beyond; `None` for a free film.
    #[inline(always)]
    pub(super) fn sequence(&self, is_below: bool) -> Option<Sequence<'b>> {
        let Stack::Layers { media: [outer, exit], layers, is_reversed, rate } = *self else { return None };
        let (outer, exit) = if is_below { (exit, outer) } else { (outer, exit) };
        Some(Sequence { outer, layers, is_reversed: is_reversed != is_below, exit, rate })
    }

    /// What a facet does to a block of nodes, met from the side of the path or from beyond.
    #[inline(always)]
    pub(super) fn response<S: Simd>(&self, simd: S, is_below: bool, block: usize, cos_theta: f32) -> Response<S> {
        match (self, self.sequence(is_below)) {
            (_, Some(sequence)) => sequence.response(simd, block, cos_theta),
            (Stack::Film { table, thickness_nm, phase: Phase::Single }, _) => {
                table.response(simd, block, cos_theta, *thickness_nm as f32)
            }
            (Stack::Film { table, thickness_nm, phase }, _) => simd.vectorize(
                #[inline(always)]
                || table.long_response(simd, block, f64::from(cos_theta), *thickness_nm, *phase),
            ),
            (Stack::Layers { .. }, None) => unreachable!("layers have a sequence"),
        }
    }
}

/// A place of a rough surface that a ray has come to, among its facets.
#[derive(Clone, Copy)]
pub(super) struct Facets<'b> {
    pub ray: Wanderer,
    pub spread: Microfacets,
    pub frame: Frame,
    /// The normal of the surface itself, on the side of the path.
    pub facing: Vec3,
    pub stack: Stack<'b>,
    /// The index on the path's side over that beyond; `None` where nothing gets through.
    pub ratio: Option<f64>,
    /// The media on the two sides, and whether light that arrives there from a lamp would be absorbed on its way.
    pub media: [MediumStack; 2],
    pub is_dark: [bool; 2],
    /// Where the wavelengths part: the indices before a facet and beyond it, met from the side of the path, and the chances of the
    /// nodes to tell the direction.
    pub parted: Option<([&'b IndexTable; 2], &'b [Lanes])>,
    /// Its layers at lines, one a block, where nothing gets through, nothing else shines, and they show fringes.
    pub lines: Option<(Stack<'b>, &'b [f32])>,
}

impl Facets<'_> {
    /// The index before a facet over that beyond it.
    #[inline(always)]
    pub(super) fn ratio(&self) -> Option<f64> {
        self.ratio.map(|ratio| if self.ray.is_below { 1.0 / ratio } else { ratio })
    }

    /// The same where the wavelengths part, at a node.
    #[inline(always)]
    pub(super) fn ratio_at(&self, node: f64) -> f64 {
        let ratio = self.parted.map_or(1.0, |(media, _)| ratio(media, node));
        if self.ray.is_below { 1.0 / ratio } else { ratio }
    }

    /// The facet, in the world, that sends the ray into a direction: its probability density given that it mirrors or
    /// refracts, and whether it mirrors.
    #[inline(always)]
    fn towards(&self, direction: Vec3) -> Option<(Vec3, f64, bool)> {
        let (h, mut density, is_mirrored) = self.towards_by_middle(direction)?;
        if !is_mirrored && self.parted.is_some() {
            let local = self.frame.local(direction);
            density = self.mixed_density(local) * self.ray.escape_beyond(&self.spread, local);
        }
        (density > 0.0).then_some((h, density, is_mirrored))
    }

    /// The same where the middle of the spectrum tells the direction.
    #[inline(always)]
    fn towards_by_middle(&self, direction: Vec3) -> Option<(Vec3, f64, bool)> {
        let local = self.frame.local(direction);
        let side = usize::from(local.z < 0.0);
        // A direction that only the shading normal takes for one of this side does not leave the surface.
        let is_through = (direction.dot(self.facing) < 0.0) != (side == 1);
        if is_through || self.is_dark[side] {
            return None;
        }
        let is_mirrored = (side == 1) == self.ray.is_below;
        let (h, density) = if is_mirrored {
            self.ray.mirror_density(&self.spread, local)?
        } else {
            self.ray.refract_density(&self.spread, local, self.ratio()?)?
        };
        Some((self.frame.world(h), density, is_mirrored))
    }

    /// How likely a facet that sends light into a direction mirrors it, or refracts it, where either is drawn.
    #[inline(always)]
    fn share(&self, h: Vec3, is_mirrored: bool) -> f64 {
        let Some(ratio) = self.ratio() else { return 1.0 };
        let cos = -self.frame.world(self.ray.direction).dot(h);
        let share = bare_reflectance(cos, ratio).clamp(0.02, 0.98);
        if is_mirrored { share } else { 1.0 - share }
    }

    /// How densely a direction of the surface's frame is refracted into, whichever wavelength tells it.
    #[inline(always)]
    pub(super) fn mixed_density(&self, local: Vec3) -> f64 {
        let Some((_, chances)) = self.parted else { return 0.0 };
        let mut sums = [0.0_f32; LANES];
        for (block, chances) in chances.iter().enumerate() {
            let [densities, _] = self.densities(block, local);
            for lane in 0..LANES {
                sums[lane] += chances.0[lane] * densities[lane];
            }
        }
        f64::from(sums.iter().sum::<f32>())
    }

    /// By node of a block how densely light is refracted into a direction of the surface's frame, and at which cosine to the facet.
    #[inline(always)]
    fn densities(&self, block: usize, local: Vec3) -> [[f32; LANES]; 2] {
        let Some(([outer, exit], _)) = self.parted else { return [[0.0; LANES], [1.0; LANES]] };
        let (before, beyond) = if self.ray.is_below { (exit, outer) } else { (outer, exit) };
        let (before, beyond) = (before.real(block), beyond.real(block));
        self.ray.refract_densities(&self.spread, local, &std::array::from_fn(|lane| before[lane] / beyond[lane]))
    }
}

impl Scatters for Facets<'_> {
    #[inline(always)]
    fn facing(&self) -> Vec3 {
        self.facing
    }

    #[inline(always)]
    fn density(&self, direction: Vec3) -> f64 {
        let Some((h, density, is_mirrored)) = self.towards(direction) else { return 0.0 };
        density * self.share(h, is_mirrored)
    }
}

impl Draws for Facets<'_> {
    #[inline(always)]
    fn draw_lanes<S: Simd>(&self, simd: S, points: &[(f64, f64); LANES], choices: &mut Choices) -> [f32x16<S>; 3] {
        if self.only_mirrors() {
            let points = single_points(simd, points);
            let ray = self.ray.lanes(points[0], &self.spread);
            let local = ray.mirrored(&ray.facets(&self.spread, points));
            return world_lanes(&local, self.frame.axes());
        }
        let mut ways = [[0.0; LANES]; 3];
        for (lane, point) in points.iter().enumerate() {
            let Some(way) = self.draw(*point, choices.next().into()) else { continue };
            for (ways, along) in ways.iter_mut().zip(way.to_array()) {
                ways[lane] = along as f32;
            }
        }
        ways.map(|along| f32x16::from_slice(simd, &along))
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, ways: &[f32x16<S>; 3]) -> [f32x16<S>; 2] {
        let zero = f32x16::splat(simd, 0.0);
        if self.only_mirrors() {
            if self.is_dark[0] {
                return [zero; 2];
            }
            let local = self.frame.local_lanes(ways);
            let density = self.ray.lanes(zero, &self.spread).densities(&self.spread, &local);
            let escape = escapes(&self.spread, self.ray.log2_height(), &local);
            // A direction that only the shading normal takes for one of this side does not leave the surface.
            let target = (density * escape).copysign(dot(ways, self.facing)).max(zero);
            return [density, target];
        }
        let ways = ways.map(|along| along.to_array());
        let [mut densities, mut targets] = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let way = Vec3::new(ways[0][lane].into(), ways[1][lane].into(), ways[2][lane].into());
            if way.length_squared() > 0.0 {
                let [density, target] = self.drawn(way.normalized());
                (densities[lane], targets[lane]) = (density as f32, target as f32);
            }
        }
        [densities, targets].map(|lanes| f32x16::from_slice(simd, &lanes))
    }
}

impl Sends for Facets<'_> {
    #[inline(always)]
    fn evaluate<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer<'_>,
        onward: &mut Path,
        direction: Vec3,
        slot: usize,
    ) -> Option<f64> {
        // One copy of it in the program, however many lamps ask.
        simd.vectorize(
            #[inline(always)]
            || self.send(simd, tracer, onward, direction, slot),
        )
    }
}

impl Facets<'_> {
    /// Whether nothing gets through, and the ray is above.
    #[inline(always)]
    fn only_mirrors(&self) -> bool {
        self.ratio.is_none() && !self.ray.is_below
    }

    /// A direction that is as likely as [`Facets::drawn`] tells, from a point of the unit square and a number in [0, 1); `None` where it
    /// fails.
    #[inline(always)]
    fn draw(&self, point: (f64, f64), random: f64) -> Option<Vec3> {
        let h = self.ray.facet(&self.spread, point);
        let (direction, is_mirrored) = match self.ratio() {
            Some(ratio) if random >= self.share(self.frame.world(h), true) => {
                let cos = -self.ray.direction.dot(h);
                let cosine2 = 1.0 - ratio * ratio * (1.0 - cos * cos);
                if cosine2 <= 0.0 {
                    return None;
                }
                (self.ray.direction * ratio + h * (ratio * cos - cosine2.sqrt()), false)
            }
            _ => (self.ray.mirrored(h).direction, true),
        };
        // What does not get out at once, on its own side, is not told by the density.
        if (direction.z > 0.0) != (is_mirrored != self.ray.is_below) {
            return None;
        }
        Some(self.frame.world(direction).normalized())
    }

    /// [`Scatters::lanes`] of one direction.
    #[inline(always)]
    fn drawn(&self, direction: Vec3) -> [f64; 2] {
        let Some((h, density, is_mirrored)) = self.towards_by_middle(direction) else { return [0.0; 2] };
        let target = density * self.share(h, is_mirrored);
        // What is mirrored or refracted there gets out by chance.
        let escape = self.ray.escape(&self.spread, self.frame.local(direction), is_mirrored);
        if escape > 0.0 { [target / escape, target] } else { [0.0; 2] }
    }

    /// [`Scatters::evaluate`].
    #[inline(always)]
    fn send<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer<'_>,
        onward: &mut Path,
        direction: Vec3,
        slot: usize,
    ) -> Option<f64> {
        let (h, density, is_mirrored) = self.towards(direction)?;
        tracer.copy_slot(onward, slot);
        tracer.rotate_stokes_frame_to(simd, onward, h);
        if !is_mirrored && self.parted.is_some() {
            let local = self.frame.local(direction);
            let factor = self.ray.escape_beyond(&self.spread, local) / density;
            self.refract_by_node(simd, tracer, onward, local, factor as f32);
        } else {
            self.respond(simd, tracer, onward, h, is_mirrored);
        }
        onward.direction = direction;
        onward.is_unpolarized = false;
        onward.medium = self.media[usize::from(direction.dot(self.facing) < 0.0)];
        Some(density)
    }

    /// Makes of what a path carries, told in the plane of incidence of a facet, what that mirrors of it, or passes.
    #[inline(always)]
    pub(super) fn respond<S: Simd>(&self, simd: S, tracer: &mut Tracer<'_>, path: &Path, h: Vec3, mirrors: bool) {
        let cos_theta = (-path.direction.dot(h)).clamp(0.0, 1.0) as f32;
        for block in 0..tracer.blocks {
            let response = self.stack.response(simd, self.ray.is_below, block, cos_theta);
            let matrix = if mirrors { &response.reflect } else { &response.transmit };
            let out = matrix.carry(&tracer.beam(simd, path, block));
            tracer.store_beam(path, block, &out);
        }
    }

    /// Makes of what a path carries what goes through the facets into a direction of the surface's frame, each node by its own facet
    /// and density, times a factor; gives the luminance.
    #[inline(always)]
    pub(super) fn refract_by_node<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer<'_>,
        path: &Path,
        local: Vec3,
        factor: f32,
    ) -> f32 {
        let mut luminance = f32x16::splat(simd, 0.0);
        let Some(sequence) = self.stack.sequence(self.ray.is_below) else { return 0.0 };
        for block in 0..tracer.blocks {
            let [densities, cosines] =
                self.densities(block, local).map(|lanes| iridesce_numerics::lanes::Lanes(lanes).load(simd));
            let response = sequence.response_by_node(simd, block, cosines);
            let out = scaled(&response.transmit.carry(&tracer.beam(simd, path, block)), densities * factor);
            tracer.store_beam(path, block, &out);
            luminance = tracer.spectra.importance[block].load(simd).mul_add(out.s + out.p, luminance);
        }
        luminance.reduce_sum()
    }
}

#[inline(always)]
pub(super) fn scaled<S: Simd>(beam: &Beam<S>, factor: f32x16<S>) -> Beam<S> {
    Beam { s: beam.s * factor, p: beam.p * factor, u: beam.u * factor, v: beam.v * factor }
}
