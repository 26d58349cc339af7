//! Which branches go on: Russian roulette with a control variate.
//!
//! All branches that matter go on, the others survive with a probability and are weighted by its inverse. Where there are bodies that
//! part light into many branches, each survives in as large a share of the samples of a pixel ([`Lot`]), and where both of two may end,
//! one number decides which. The control
//! variate: what the branch finds at least, the light that comes from every direction alike where nothing of the scene absorbs, is
//! added for certain, and only the rest is left to chance, so that no pixel is ever darker than black. (The mean light in its place makes
//! less noise in a bright surrounding, and pixels of -7 times the mean where a branch of much light is left to chance.) Pictures that end where tiles have settled share the branches below [`SPARSE`]
//! among the samples of a pixel before that, in turn and not by chance.

use fearless_simd::Simd;
use iridesce_numerics::Vec3;

use super::path::{Continuation, Lot, Path, Since, Sums, Target, part_number};
use super::{GROUP, LATE_SURVIVAL, SPARSE, Tracer};
use crate::geometry::Hit;
use crate::materials::Material;
use crate::medium_stack::MediumStack;
use crate::sampler::Choices;

/// Luminance below which a branch survives only by chance where it comes to a surface that scatters: what it finds there is a matter of
/// chance in any case, and to look at it takes as long as for a branch of all the light.
const SCATTERED: f32 = 0.02;

/// So many hits beyond `max_depth` a walk is taken to be caught for good, as by total reflection in clear glass.
const LONG_WALK: u32 = 100;

/// How the branch that passes a surface goes on.
pub(super) struct Onward {
    pub direction: Vec3,
    pub medium: MediumStack,
    pub band: Option<f64>,
    pub since: Since,
}

impl Onward {
    #[inline(always)]
    fn take(&self, path: &mut Path, hit: Hit) {
        (path.direction, path.hit, path.medium) = (self.direction, hit, self.medium);
        (path.band, path.since) = (self.band, self.since);
        path.chain = path.chain.then(false);
        path.lot = path.lot.turned(false);
    }
}

impl Tracer<'_> {
    /// Goes on with what came of a hit: `path` becomes the branch to follow next (false: there is none), another waits.
    ///
    /// The path is changed in place: copies of it would wait for the stores before them.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "plain values of one hit; a struct of them passes through memory")]
    pub(super) fn follow<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        continuations: [Continuation; 2],
        to: [Target; 2],
        mirror: Vec3,
        onward: &Onward,
        [mirrored_y, passed_y]: [f32; 2],
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        match continuations {
            [Continuation::Surface(mirrored_hit), Continuation::Surface(passed_hit)] => {
                let Target::Slot(slot) = to[0] else { unreachable!("what goes on has a slot") };
                let mirrored = Path {
                    direction: mirror,
                    hit: mirrored_hit,
                    slot,
                    since: Since::Bend,
                    chain: path.chain.then(true),
                    lot: path.lot.turned(true),
                    ..*path
                };
                onward.take(path, passed_hit);
                self.follow_both(simd, path, mirrored, [mirrored_y, passed_y], sums, choices)
            }
            [Continuation::Surface(hit), _] => {
                (path.direction, path.hit, path.since) = (mirror, hit, Since::Bend);
                path.chain = path.chain.then(true);
                path.lot = path.lot.turned(true);
                self.survives(simd, path, mirrored_y, sums, choices)
            }
            [_, Continuation::Surface(hit)] => {
                onward.take(path, hit);
                self.survives(simd, path, passed_y, sums, choices)
            }
            _ => false,
        }
    }

    #[inline(always)]
    pub(super) fn follow_both<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        mut mirrored: Path,
        [mirrored_y, passed_y]: [f32; 2],
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        if path.hits >= self.scene.max_depth {
            return self.choose(simd, path, mirrored, [mirrored_y, passed_y], sums, choices);
        }
        let (mirrored_survives, passed_survives);
        if path.lot.is_even() {
            let odds = [self.odds(simd, &mut mirrored, mirrored_y, sums), self.odds(simd, path, passed_y, sums)];
            // Certain of both, nothing is drawn: each has numbers of its own from here on.
            let numbers = match odds {
                [first, second] if first >= 1.0 && second >= 1.0 => [0.0; 2],
                _ => part_number(mirrored.lot.number(choices), odds),
            };
            mirrored_survives = self.wins(simd, &mut mirrored, odds[0], numbers[0], sums);
            passed_survives = self.wins(simd, path, odds[1], numbers[1], sums);
        } else {
            mirrored_survives = self.survives(simd, &mut mirrored, mirrored_y, sums, choices);
            passed_survives = self.survives(simd, path, passed_y, sums, choices);
        }
        match (mirrored_survives, passed_survives) {
            (true, true) => self.waiting.push(mirrored),
            (true, false) => {
                self.free.push(path.slot);
                *path = mirrored;
            }
            (false, _) => self.free.push(mirrored.slot),
        }
        mirrored_survives || passed_survives
    }

    /// Of two branches that both go on, keeps one with probability in proportion to luminance.
    #[inline(always)]
    fn choose<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        mirrored: Path,
        [mirrored_y, passed_y]: [f32; 2],
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        self.add_least_light(simd, &mirrored, 1.0, sums);
        self.add_least_light(simd, path, 1.0, sums);
        let sum = mirrored_y + passed_y;
        let share = if sum > 0.0 { (mirrored_y / sum).clamp(0.0, 1.0) } else { 0.5 };
        let probability = if choices.next() < share {
            self.free.push(path.slot);
            *path = mirrored;
            share
        } else {
            self.free.push(mirrored.slot);
            1.0 - share
        };
        self.scale(simd, path, 1.0 / probability);
        self.add_least_light(simd, path, -1.0, sums);
        self.survives(simd, path, sum, sums, choices)
    }

    /// Whether a branch goes on that has come to a surface that scatters: it had one luminance before and has another now.
    #[inline(always)]
    pub(super) fn survives_scattering<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        [before, now]: [f32; 2],
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let (floor, was_sparse) = (path.floor, path.is_sparse);
        // What the surface itself takes away counts for nothing: all that is seen may be dark.
        let kept = if before > 0.0 { (now / before).clamp(0.0, 1.0) } else { 1.0 };
        path.floor = floor.max(SCATTERED * kept);
        let survives = self.survives(simd, path, now, sums, choices);
        // The ways of scattered branches have nothing in common.
        path.lot = Lot::SINGLE;
        if path.hits != self.scene.max_depth {
            path.floor = if path.is_sparse == was_sparse { floor } else { floor * GROUP as f32 };
        }
        survives
    }

    /// Raises the floor of a branch that a surface has sent on by chance, with this luminance. It never falls again: each further such
    /// surface matters less.
    #[inline(always)]
    pub(super) fn raise_floor(&self, path: &mut Path, luminance: f32) {
        path.is_whole = false;
        path.floor = path.floor.max(self.scene.floors.share * luminance);
    }

    /// Whether a branch of this luminance survives Russian roulette; its weight is divided by the probability.
    #[inline(always)]
    pub(super) fn survives<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        luminance: f32,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let odds = self.odds(simd, path, luminance, sums);
        // (What is left of its number serves the next choice.)
        if odds >= 1.0 || odds <= 0.0 {
            return odds > 0.0;
        }
        let number = path.lot.number(choices);
        self.wins(simd, path, odds, number, sums)
    }

    /// Whether a branch goes on that does so with these odds, by a number that is uniform in [0, 1).
    #[inline(always)]
    fn wins<S: Simd>(&mut self, simd: S, path: &mut Path, odds: f32, number: f64, sums: &mut Sums<S>) -> bool {
        if odds >= 1.0 || odds <= 0.0 {
            path.lot.renew();
            return odds > 0.0;
        }
        let survives = number < f64::from(odds);
        // For certain what it finds at least; less what it goes on with, should it do so.
        self.add_least_light(simd, path, if survives { 1.0 - 1.0 / odds } else { 1.0 }, sums);
        if survives {
            path.lot.spend(number, odds);
            self.scale(simd, path, 1.0 / odds);
        }
        survives
    }

    /// The odds of a branch of this luminance to survive: 1 where it does for certain, 0 where it is dropped.
    #[inline(always)]
    fn odds<S: Simd>(&mut self, simd: S, path: &mut Path, mut luminance: f32, sums: &mut Sums<S>) -> f32 {
        if !luminance.is_finite() {
            return 0.0;
        }
        if path.hits == self.scene.max_depth {
            // From here on the walk is a game of roulette at the luminance it has now. A fixed probability would not do: at
            // grazing angles hardly anything is lost at a hit, and weights would grow without bound.
            path.floor = luminance.max(self.scene.floors.faint);
        }
        if path.hits > self.scene.max_depth.saturating_add(LONG_WALK) {
            // Nearly all of the light stays on a walk that is still going: where total reflection keeps it in, for ever.
            path.floor = path.floor.max(luminance / LATE_SURVIVAL);
        }
        if luminance < SPARSE
            && !path.is_sparse
            && let Some(carries) = self.carries_sparse
        {
            self.add_mean_light(simd, path, 1.0, sums);
            if !carries {
                return 0.0;
            }
            path.is_sparse = true;
            path.floor *= GROUP as f32;
            luminance *= GROUP as f32;
            self.scale(simd, path, GROUP as f32);
            self.add_mean_light(simd, path, -1.0, sums);
        }
        let group = if path.is_sparse { GROUP } else { 1 };
        let floor = path.floor.max(self.scene.floors.after(self.hits) * group as f32);
        // (What carries nothing at all could otherwise wander among surfaces that take nothing away for ever: its floor is nothing, too.)
        if luminance >= floor && luminance > 0.0 {
            return 1.0;
        }
        // A branch without luminance (or, by rounding, below zero) may still carry colour: the odds have a least value.
        (luminance / floor).max(1e-3)
    }

    /// Adds what a path finds at least.
    #[inline(always)]
    fn add_least_light<S: Simd>(&mut self, simd: S, path: &Path, factor: f32, sums: &mut Sums<S>) {
        if self.scene.is_clear {
            // Of the maps a scattered branch has a share alone.
            let is_shared = path.since == Since::Scattering && self.spectra.lights.sampler.is_some();
            let rgb = if is_shared { [0.0; 3] } else { self.spectra.lights.least_rgb };
            self.add_light_around(simd, path, factor, rgb, sums);
        }
    }

    /// Adds what a path is expected to find: the lights' mean radiance, or what a diffuse surface makes of it.
    #[inline(always)]
    fn add_mean_light<S: Simd>(&mut self, simd: S, path: &Path, factor: f32, sums: &mut Sums<S>) {
        let factor = factor * self.scene.expected_shares[path.hit.object];
        self.add_light_around(simd, path, factor, self.spectra.lights.mean_rgb, sums);
    }

    /// Adds what a path would find if all maps had one radiance everywhere.
    #[inline(always)]
    fn add_light_around<S: Simd>(&mut self, simd: S, path: &Path, factor: f32, rgb: [f32; 3], sums: &mut Sums<S>) {
        if path.since == Since::Camera && matches!(self.scene.materials.get(path.hit.object), Some(Material::Film(_))) {
            // What it is expected to find is the backdrop, which is left out.
            for block in 0..self.blocks {
                let s = self.arena[self.at(path.slot, 0, block)].load(simd);
                let p = self.arena[self.at(path.slot, 1, block)].load(simd);
                self.add_share(simd, block, (s + p) * factor);
            }
            return;
        }
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            xyz = self.add_around(simd, block, (s + p) * factor, rgb, xyz);
        }
        sums.0 = xyz;
    }

    #[inline(always)]
    pub(super) fn scale<S: Simd>(&mut self, simd: S, path: &Path, factor: f32) {
        let start = self.at(path.slot, 0, 0);
        let count = if path.in_plane { 2 } else { 4 } * self.blocks;
        for lanes in &mut self.arena[start..start + count] {
            lanes.store(lanes.load(simd) * factor);
        }
    }
}
