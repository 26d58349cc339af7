//! A path on its way from the camera, what becomes of a branch of it, and where the spectra of that are written: plain data.

use fearless_simd::{Simd, f32x16};
use iridesce_numerics::Vec3;

use crate::chain::Chain;
use crate::geometry::Hit;
use crate::medium_stack::MediumStack;

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
    /// It stands for those of all samples of its group.
    pub(super) is_sparse: bool,
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
