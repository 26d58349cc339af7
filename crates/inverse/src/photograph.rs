//! A whole picture: candidates of its pixels, what their neighbours say, an answer for each, and what fixes its order.

use iridesce_numerics::Watch;
use rayon::prelude::*;

use crate::InverseError;
use crate::blocks::all_candidates;
use crate::exposure::FilmChannels;
use crate::lines::{Slope, beliefs};
use crate::neighbours::Neighbourhood;
use crate::pixels::{Candidate, Exposure, MOST, Photograph, filled};
use crate::regions::{Answers, Tie, anchor, tie};

/// Candidates told of each pixel.
pub const TOLD: usize = 4;

/// The answer for every pixel; NaN where there is none.
#[derive(Debug, Clone, Default)]
pub struct Map {
    /// Thickness, nm.
    pub best_nm: Vec<f32>,
    /// Standard deviation within the order, nm.
    pub sd_nm: Vec<f32>,
    /// Probability of the order.
    pub confidence: Vec<f32>,
    /// The likeliest candidates, `TOLD` a pixel.
    pub candidates_nm: Vec<f32>,
    /// Their probabilities.
    pub weights: Vec<f32>,
    /// What fixes the order of each pixel's region: 0 nothing, 1 colour, 2 no film at all, 3 a tie point.
    pub anchor: Vec<u8>,
    /// Which of the ties found a candidate near their thickness.
    pub taken: Vec<bool>,
}

/// What is asked of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Question<'a> {
    /// Channels of every film.
    pub films: FilmChannels<'a>,
    /// How the picture was exposed.
    pub exposure: Exposure,
    /// How neighbours hang together.
    pub neighbourhood: Neighbourhood,
    /// Half width of an order, nm: a quarter of a wave in the film.
    pub quarter_nm: f32,
    /// Pixels whose thickness is known.
    pub ties: &'a [Tie],
    /// What the frame before said.
    pub prior: Option<Prior<'a>>,
}

/// What the frame before says of this one: a line through time, heard in one direction.
#[derive(Debug, Clone, Copy)]
pub struct Prior<'a> {
    /// Thickness of each pixel.
    pub thickness_nm: &'a [f32],
    /// Probability of its order.
    pub confidence: &'a [f32],
    /// Mean size of a step from frame to frame, nm.
    pub tau_nm: f32,
}

/// A frame is trusted by the next one no more than this: films burst, and orders that were wrong are to be found out.
const TRUSTED: f32 = 0.98;

impl Prior<'_> {
    /// Candidates far from where a pixel was are less likely by what that pixel knew.
    fn apply(&self, candidates: &mut [Candidate]) -> Result<(), InverseError> {
        let count = candidates.len() / MOST;
        if self.thickness_nm.len() != count
            || self.confidence.len() != count
            || self.tau_nm.is_nan()
            || self.tau_nm <= 0.0
        {
            return Err(InverseError::Argument(format!("the frame before must have {count} pixels, and steps > 0")));
        }
        candidates.par_chunks_exact_mut(MOST).enumerate().with_min_len(4096).for_each(|(i, own)| {
            let (before, trust) = (self.thickness_nm[i], self.confidence[i].clamp(0.0, TRUSTED));
            let mut most = 0.0_f32;
            for one in own.iter_mut().filter(|one| one.likelihood > 0.0) {
                let step = ((one.thickness_nm - before).abs() - one.sd_nm).max(0.0) / self.tau_nm;
                one.likelihood *= trust * (-step.min(40.0)).exp() + (1.0 - trust);
                most = most.max(one.likelihood);
            }
            if most > 0.0 {
                own.iter_mut().for_each(|one| one.likelihood /= most);
            }
        });
        Ok(())
    }
}

/// The thickness of every pixel.
pub fn map_thickness(ask: &Question<'_>, of: &Photograph<'_>, watch: &Watch) -> Result<Map, InverseError> {
    let Question { films, exposure, neighbourhood, quarter_nm, ties, prior } = *ask;
    let tables = films.tables(&Exposure { temper: neighbourhood.temper, ..exposure })?;
    of.check(tables.len())?;
    let count = of.count();
    if let Some(wrong) = ties.iter().find(|tie| tie.pixel >= count) {
        return Err(InverseError::Argument(format!("tie point {} lies outside the picture", wrong.pixel)));
    }
    watch.begin("mapping", 3 * count as u64);
    let mut found = all_candidates(&tables, of, watch)?;
    let candidates = &mut found.as_flattened_mut().as_flattened_mut()[..count * MOST];
    if let Some(prior) = prior {
        prior.apply(candidates)?;
    }
    let candidates = &*candidates;
    let range_nm = films.step_nm * films.count as f32;
    let beliefs = beliefs(candidates, of.width, neighbourhood.tau_nm.map(|tau_nm| Slope { tau_nm, range_nm }), watch)?;
    let mut map = Map {
        best_nm: filled(count, f32::NAN)?,
        sd_nm: filled(count, f32::NAN)?,
        confidence: filled(count, 0.0)?,
        candidates_nm: filled(count * TOLD, f32::NAN)?,
        weights: filled(count * TOLD, 0.0)?,
        anchor: filled(count, 0)?,
        taken: Vec::new(),
    };
    let mut own = filled(count, 0.0_f32)?;
    let answers = map
        .best_nm
        .par_iter_mut()
        .zip(&mut map.sd_nm)
        .zip(&mut map.confidence)
        .zip(&mut own)
        .zip(map.candidates_nm.par_chunks_exact_mut(TOLD))
        .zip(map.weights.par_chunks_exact_mut(TOLD));
    answers.with_min_len(4096).enumerate().for_each(|(i, (((((best, sd), confidence), own), told), weights))| {
        let candidates = &candidates[i * MOST..(i + 1) * MOST];
        if let Some(one) = answer(candidates, &beliefs[i * MOST..(i + 1) * MOST], quarter_nm, told, weights) {
            [*best, *sd, *confidence, *own] = one;
        }
    });
    drop(beliefs);
    let mut answers =
        Answers { best_nm: &mut map.best_nm, confidence: &mut map.confidence, anchor: &mut map.anchor, own: &own };
    map.taken = tie(ties, candidates, of.width, quarter_nm, &mut answers, watch)?;
    anchor(of.width, (quarter_nm, films.first_nm), neighbourhood.temper, &mut answers, watch)?;
    Ok(map)
}

/// Best, standard deviation, probability of its order, and that by the pixel alone; `None` without candidates.
fn answer(
    candidates: &[Candidate],
    beliefs: &[f32],
    quarter_nm: f32,
    told: &mut [f32],
    weights: &mut [f32],
) -> Option<[f32; 4]> {
    let near = |a: usize, b: usize| (candidates[a].thickness_nm - candidates[b].thickness_nm).abs() <= quarter_nm;
    // The order of most mass, and in it the likeliest candidate.
    let mass = |a: usize| -> f32 { (0..MOST).filter(|&b| near(a, b)).map(|b| beliefs[b]).sum() };
    let mut top: Option<(f32, f32, usize)> = None;
    for a in (0..MOST).filter(|&a| beliefs[a] > 0.0) {
        let this = (mass(a), beliefs[a], a);
        if top.is_none_or(|top| (this.0, this.1) > (top.0, top.1)) {
            top = Some(this);
        }
    }
    let (share, _, top) = top?;
    let middle = candidates[top].thickness_nm;
    let mut spread = 0.0;
    let (mut own, mut all) = (0.0, 0.0);
    for (b, one) in candidates.iter().enumerate() {
        all += one.likelihood;
        if near(top, b) {
            own += one.likelihood;
            spread += beliefs[b] / share * ((one.thickness_nm - middle).powi(2) + one.sd_nm.powi(2));
        }
    }
    let mut order = [0; MOST];
    (0..MOST).for_each(|a| order[a] = a);
    order.sort_by(|&a, &b| (b == top).cmp(&(a == top)).then(beliefs[b].total_cmp(&beliefs[a])));
    for (slot, &a) in order.iter().take(TOLD).enumerate().filter(|(_, a)| beliefs[**a] > 0.0) {
        (told[slot], weights[slot]) = (candidates[a].thickness_nm, beliefs[a]);
    }
    Some([middle, spread.sqrt(), share.min(1.0), own / all])
}
