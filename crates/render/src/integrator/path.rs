//! A path on its way from the camera, what becomes of a branch of it, and where the spectra of that are written: plain data.

use fearless_simd::{Simd, f32x16};
use iridesce_numerics::Vec3;

use crate::chain::Chain;
use crate::geometry::Hit;
use crate::medium_stack::MediumStack;
use crate::sampler::Choices;

/// A path that is about to meet a surface; its spectra stand in the arena under `slot`.
#[derive(Clone, Copy)]
pub(super) struct Path {
    pub(super) direction: Vec3,
    pub(super) hit: Hit,
    /// The s direction of the plane that the Stokes vector refers to; meaningless before the first hit.
    pub(super) axis: Vec3,
    pub(super) slot: usize,
    pub(super) hits: u32,
    /// The luminance below which it survives only by chance.
    pub(super) floor: f32,
    /// No surface has sent it on by chance.
    pub(super) is_whole: bool,
    /// It stands for those of all samples of its group.
    pub(super) is_sparse: bool,
    /// What decides whether it survives.
    pub(super) lot: Lot,
    pub(super) medium: MediumStack,
    /// U and V are zero (and their storage is stale).
    pub(super) in_plane: bool,
    /// It has met nothing that polarises since the camera or a diffuse surface.
    pub(super) is_unpolarized: bool,
    /// The place in the spectrum at which it goes on, once a prism has parted the wavelengths.
    pub(super) band: Option<f64>,
    /// What it has come from straight, through films or nothing.
    pub(super) since: Since,
    /// What it has done since it was scattered, where caustics are sampled.
    pub(super) chain: Chain,
}

/// What a path has come from straight and unbent, with nothing but films in between.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Since {
    /// The camera, in a picture without its backdrop.
    Camera,
    /// A surface that scattered it; where, stands by its slot.
    Scattering,
    /// A surface that mirrored or refracted it; or it does not matter what.
    Bend,
}

impl Since {
    /// Left by a surface that sampled the lights, or did not.
    #[inline(always)]
    pub(super) fn scattering(scattered: Option<Scattered>) -> Since {
        if scattered.is_some() { Since::Scattering } else { Since::Bend }
    }
}

/// What the choices between the branches of a path are drawn from.
///
/// The same branch of all samples of a pixel draws numbers that lie evenly, so that as large a share of them survives as their odds say.
#[derive(Clone, Copy)]
pub(super) struct Lot {
    /// Names the way of the path, mirrored or passed at each hit; 0 where numbers are independent of those of other samples.
    trail: u32,
    /// Odds by which it has survived with one number, over which [`Lot::left`] was spread again.
    spent: f32,
    /// What is left of that number, in [0, 1); below 0 where the next is to be drawn.
    left: f64,
}

impl Lot {
    /// Independent numbers.
    pub(super) const SINGLE: Lot = Lot { trail: 0, spent: 1.0, left: -1.0 };

    /// Even numbers, of a path that begins.
    pub(super) const EVEN: Lot = Lot { trail: 1, spent: 1.0, left: -1.0 };

    /// Odds down to which a number is spread again: of its 53 bits this leaves 37, and of the even ones more samples than tell apart.
    const MOST_SPENT: f32 = 1.0 / 65_536.0;

    pub(super) fn is_even(self) -> bool {
        self.trail != 0
    }

    /// That of a branch which is mirrored or passes.
    #[inline(always)]
    pub(super) fn turned(self, is_mirrored: bool) -> Lot {
        // Any hash will do; its lowest bit keeps it off 0.
        let trail = (self.trail ^ u32::from(is_mirrored) << 16).wrapping_mul(0x9E37_79B1).rotate_left(13) | 1;
        if self.is_even() { Lot { trail, ..self } } else { self }
    }

    /// A number in [0, 1).
    #[inline(always)]
    pub(super) fn number(self, choices: &mut Choices) -> f64 {
        match self {
            Lot { trail: 0, .. } => f64::from(choices.next()),
            Lot { left, .. } if left >= 0.0 => left,
            Lot { trail, .. } => choices.even(trail),
        }
    }

    /// After a path has survived by a number below these odds: what is left of it is even, too.
    #[inline(always)]
    pub(super) fn spend(&mut self, number: f64, odds: f32) {
        if !self.is_even() {
            return;
        }
        self.spent *= odds;
        self.left = number / f64::from(odds);
        if self.spent < Lot::MOST_SPENT {
            self.renew();
        }
    }

    /// The next number is drawn: what is left of the last one decides elsewhere.
    #[inline(always)]
    pub(super) fn renew(&mut self) {
        (self.spent, self.left) = (1.0, -1.0);
    }
}

/// The numbers by which two branches survive with these odds, of one number for both: where both may end they do so in turn, so that of
/// what they carry together as much as can be goes on at a time.
#[inline(always)]
pub(super) fn part_number(number: f64, [first, second]: [f32; 2]) -> [f64; 2] {
    if first >= 1.0 || second >= 1.0 {
        return [number; 2];
    }
    let behind = number - f64::from(first);
    [number, if behind < 0.0 { behind + 1.0 } else { behind }]
}

/// A diffuse point that a path left in a sampled direction.
#[derive(Clone, Copy, Default)]
pub(super) struct Scattered {
    pub(super) origin: Vec3,
    /// Probability per solid angle of the direction.
    pub(super) density: f64,
}

/// What becomes of a branch.
#[derive(Clone, Copy)]
pub(super) enum Continuation {
    /// It meets another surface.
    Surface(Hit),
    /// It leaves the scene.
    Escapes,
    /// It leaves the scene straight from the camera, in a picture without its backdrop; the sun that it meets there, if any.
    Backdrop(Option<usize>),
    /// It meets an emitter; this is its weight in multiple importance sampling.
    Emitter(usize, f32),
    /// It is absorbed.
    Absorbed,
}

/// Where the spectra of a branch are written.
#[derive(Clone, Copy)]
pub(super) enum Target {
    /// Into the arena: the branch goes on.
    Slot(usize),
    /// Among the paths that leave for lights that depend on direction.
    Out(usize),
    /// Nowhere: it finds the uniform lights only.
    Uniform,
    /// Nowhere: it finds this share of an emitter.
    Emitter(usize, f32),
    /// As these, and to the sums beside those of the picture.
    Told(Found),
    /// Nowhere at all.
    Nowhere,
}

/// What a branch finds whose light is told to the sums beside those of the picture, too.
#[derive(Clone, Copy)]
pub(super) enum Found {
    /// [`Target::Out`].
    Out(usize),
    /// [`Target::Uniform`].
    Uniform,
    /// [`Target::Emitter`].
    Emitter(usize, f32),
    /// [`Continuation::Backdrop`]: the sums of the picture hear of the sun alone.
    Backdrop(Option<usize>),
}

/// Sums of X, Y, Z over a block's lanes.
pub(super) struct Sums<S: Simd>(pub(super) [f32x16<S>; 3]);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::PixelSampler;

    /// Of sixteen samples as many survive as the odds say, to one, and after each further choice to one more; of two branches whose odds come to 1
    /// exactly one does.
    #[test]
    fn branches_of_all_samples_survive_evenly() {
        for pixel in 0..200 {
            let sampler = PixelSampler::new(7, pixel);
            let odds = [0.1 + 0.003 * pixel as f32, 0.9 - 0.003 * pixel as f32];
            let (mut survivors, mut again) = ([0.0_f32; 2], 0.0);
            for sample in 0..16 {
                let mut lot = Lot::EVEN.turned(pixel % 2 == 0);
                let number = lot.number(&mut sampler.choices(sample));
                let numbers = part_number(number, odds);
                let survives = [0, 1].map(|branch| numbers[branch] < f64::from(odds[branch]));
                assert!(survives[0] != survives[1], "pixel {pixel}, sample {sample}: {odds:?} {number}");
                let branch = usize::from(survives[1]);
                survivors[branch] += 1.0;
                lot.spend(numbers[branch], odds[branch]);
                assert!((0.0..=1.0).contains(&lot.left));
                again += f32::from(u8::from(branch == 0 && lot.number(&mut sampler.choices(sample)) < 0.5));
            }
            assert!((survivors[0] - 16.0 * odds[0]).abs() < 1.0, "pixel {pixel}: {survivors:?} {odds:?}");
            assert!((again - 8.0 * odds[0]).abs() < 1.0, "pixel {pixel}: {again} {odds:?}");
        }
    }

    /// A number that has decided often is drawn anew before its bits run out.
    #[test]
    fn numbers_stay_random() {
        let mut ones = [0_u32; 200];
        for pixel in 0..4000 {
            let mut choices = PixelSampler::new(7, pixel).choices(0);
            let mut lot = Lot::EVEN;
            for one in &mut ones {
                let number = lot.number(&mut choices);
                let is_first = number < 0.5;
                *one += u32::from(is_first);
                lot.spend(part_number(number, [0.5; 2])[usize::from(!is_first)], 0.5);
                lot = lot.turned(is_first);
            }
        }
        // 4000 coins: five deviations are 158.
        assert!(ones.iter().all(|one| one.abs_diff(2000) < 158), "{ones:?}");
    }
}
