//! Which branches go on: all that matter, the others by chance, none without being made up for.
//!
//! Every choice is made against the scene's mean light: what the branch would find if its surroundings had their mean
//! radiance is added for certain, and only the difference from that is left to chance.

use fearless_simd::Simd;

use super::{FAINT, Path, Sums, Tracer};
use crate::sampler::Choices;

impl Tracer<'_> {
    /// Goes on with what came of a hit: `path` becomes the branch to follow next (false: there is none), another waits.
    /// `slot` is the one that the path had; the mirrored branch has another where both go on.
    #[inline(always)]
    pub(super) fn follow<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        [mirrored, passed]: [Option<(Path, f32)>; 2],
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        let (one, luminance) = match (mirrored, passed) {
            (Some((mirrored, mirrored_y)), Some((passed, passed_y))) => {
                return self.follow_both(simd, path, [mirrored, passed], [mirrored_y, passed_y], sums, choices);
            }
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => return false,
        };
        *path = one;
        self.survives(simd, path, luminance, sums, choices)
    }

    #[inline(always)]
    fn follow_both<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        [mut mirrored, passed]: [Path; 2],
        [mirrored_y, passed_y]: [f32; 2],
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        *path = passed;
        if path.hits >= self.scene.max_depth {
            return self.choose(simd, path, mirrored, [mirrored_y, passed_y], sums, choices);
        }
        let mirrored_survives = self.survives(simd, &mut mirrored, mirrored_y, sums, choices);
        let passed_survives = self.survives(simd, path, passed_y, sums, choices);
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
        self.add_mean_light(simd, &mirrored, 1.0, sums);
        self.add_mean_light(simd, path, 1.0, sums);
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
        self.add_mean_light(simd, path, -1.0, sums);
        self.survives(simd, path, sum, sums, choices)
    }

    /// Whether a branch of this luminance goes on; if it does so by luck, its weight makes up for it.
    #[inline(always)]
    pub(super) fn survives<S: Simd>(
        &mut self,
        simd: S,
        path: &mut Path,
        luminance: f32,
        sums: &mut Sums<S>,
        choices: &mut Choices,
    ) -> bool {
        if path.hits == self.scene.max_depth {
            // From here on the walk is a game of chance at the luminance it has now. A fixed chance would not do: at
            // grazing angles hardly anything is lost at a hit, and weights would grow without bound.
            path.floor = luminance.max(FAINT);
        }
        if luminance >= path.floor {
            return true;
        }
        // A branch without luminance (or, by rounding, below zero) may still carry colour: the odds have a least value.
        let odds = (luminance / path.floor).max(1e-3);
        self.add_mean_light(simd, path, 1.0, sums);
        let survives = choices.next() < odds;
        if survives {
            self.scale(simd, path, 1.0 / odds);
            self.add_mean_light(simd, path, -1.0, sums);
        }
        survives
    }

    /// Adds what a path would find if the lights had their mean radiance everywhere.
    #[inline(always)]
    fn add_mean_light<S: Simd>(&self, simd: S, path: &Path, factor: f32, sums: &mut Sums<S>) {
        let mut xyz = sums.0;
        for block in 0..self.blocks {
            let s = self.arena[self.at(path.slot, 0, block)].load(simd);
            let p = self.arena[self.at(path.slot, 1, block)].load(simd);
            xyz = self.add_mean(simd, block, (s + p) * factor, xyz);
        }
        sums.0 = xyz;
    }

    #[inline(always)]
    fn scale<S: Simd>(&mut self, simd: S, path: &Path, factor: f32) {
        let start = self.at(path.slot, 0, 0);
        let count = if path.in_plane { 2 } else { 4 } * self.blocks;
        for lanes in &mut self.arena[start..start + count] {
            lanes.store(lanes.load(simd) * factor);
        }
    }
}
