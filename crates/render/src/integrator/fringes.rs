//! Fringes finer than the lobe of an opaque rough surface, under lines.
//!
//! A facet drawn by itself shows one place of a fringe, and under lines alone nothing else takes the mean over them. So sixteen facets
//! that lie evenly over the lobe are looked at together: one goes on, in proportion to what each mirrors, and carries the mean of all
//! (resampling: J. F. Talbot, D. Cline, P. Egbert, "Importance resampling for global illumination", EGSR 2005). Each keeps its own
//! direction and its own phase, so that rings are where they are whatever the light. (Under lamps alone, whose directions are sampled,
//! directions that lie evenly over the lobe are worth more: there it makes twice the variance.)

use fearless_simd::{Simd, f32x16, prelude::*};
use iridesce_numerics::Vec3;
use iridesce_numerics::lanes::SINGLES as LANES;

use super::Tracer;
use super::direct::lane_of;
use super::facets::{Facets, Stack};
use super::path::Path;
use crate::facet_lanes::{escapes, single_points};
use crate::sampler::Choices;

/// Each facet goes on at least as if it mirrored so much of the mean: what of its light has little luminance has colour.
const LEAST: f32 = 0.1;

impl Tracer<'_> {
    /// Draws the facet from which a path goes on, in the frame of the surface; where it stands for others the path carries what they all mirror.
    #[inline(always)]
    pub(super) fn draw_facet<S: Simd>(
        &mut self,
        simd: S,
        path: &Path,
        facets: &Facets<'_>,
        choices: &mut Choices,
    ) -> Vec3 {
        let Some(lines) = &facets.lines else { return facets.ray.facet(&facets.spread, choices.pair()) };
        // One copy of it in the program.
        let (facet, share) = simd.vectorize(
            #[inline(always)]
            || facets.one_of_fringes(simd, lines, choices),
        );
        self.scale(simd, path, share);
        facet
    }
}

impl Facets<'_> {
    /// One of sixteen facets, and how many times its own light it carries.
    #[inline(always)]
    fn one_of_fringes<S: Simd>(
        &self,
        simd: S,
        (stack, importance): &(Stack<'_>, &[f32]),
        choices: &mut Choices,
    ) -> (Vec3, f32) {
        let points = choices.pairs(LANES as u32).points();
        let singles = single_points(simd, &points);
        let ray = self.ray.lanes(singles[0], &self.spread);
        let h = ray.facets(&self.spread, singles);
        let cosines = ray.cosines(&h);
        let mut mirrored = f32x16::splat(simd, 0.0);
        if let Some(sequence) = stack.sequence(false) {
            for (block, importance) in importance.iter().enumerate() {
                let matrix = sequence.response_by_node(simd, block, cosines).reflect;
                mirrored = (matrix.s + matrix.p).mul_add(*importance, mirrored);
            }
        }
        let mean = mirrored.reduce_sum() / LANES as f32;
        // What does not get out at once meets another facet, steeper than most, where surfaces mirror more.
        let again = (2.0 * mean).min(1.0);
        let escape = escapes(&self.spread, self.ray.log2_height(), &ray.mirrored(&h));
        let worth = (mirrored + LEAST * mean) * ((f32x16::splat(simd, 1.0) - escape) * again + escape);
        let (worth, sum) = (worth.to_array(), worth.reduce_sum());
        let lane = lane_of(&worth, sum * choices.pair().0 as f32).unwrap_or_default();
        // (What mirrors nothing at all carries nothing.)
        let share = if sum > 0.0 { sum / (LANES as f32 * worth[lane]) } else { 1.0 };
        (self.ray.facet(&self.spread, points[lane]), share)
    }
}
