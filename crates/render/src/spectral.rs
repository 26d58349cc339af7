//! At which wavelengths a path carries its light, and with which weights they become XYZ.
//!
//! Nodes are uniform in 1/lambda (fringes of a film are uniform there). A weight is not a sample of
//! illuminant x observer at its node: it is the integral (1 nm sum, 360..830 nm) of illuminant x observer x the
//! cubic cardinal spline of the node, so the structure of lamp and observer is summed exactly and only the
//! transport itself (smooth: Airy functions of a film) is interpolated. Against point samples the same colour
//! error needs half the nodes: docs/evidence/performance.md. Line spectra become nodes of their own, never bins.

use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::lanes::Singles as Lanes;
use iridesce_optics::color::{Illuminant, Observer};
use iridesce_optics::medium::VISIBLE_NM;

/// Vacuum wavelengths outside which the observers are zero, nm.
pub const FROM_NM: f64 = VISIBLE_NM.0;
/// The other end, nm.
pub const TO_NM: f64 = VISIBLE_NM.1;

/// Largest number of nodes: films beyond about 0.5 mm have fringes that no eye and no lamp resolves.
pub const MAX_NODES: usize = 1 << 14;

/// Fewest nodes: what a smooth spectrum needs.
pub const LEAST_NODES: usize = 32;

/// Nodes to the finest fringe (error of a soap film's colour: docs/evidence/performance.md).
const NODES_A_FRINGE: f64 = 8.0;

/// Uniform nodes up to twice which sums go in steps of 1 nm: nodes are 0.8 nm apart then at the violet end, and fringes 6.4.
const NODES_PER_NM_STEP: usize = 128;

/// Least chance of a place in the spectrum to be chosen, of an equal share.
const LEAST_CHANCE: f64 = 0.1;

/// Lines closer than this are one band, nm: no prism of a scene tells them apart.
const SAME_BAND_NM: f64 = 2.0;

/// The nodes of a render.
#[derive(Debug, Clone)]
pub struct Nodes {
    /// Vacuum wavelength of every node, nm: the uniform ones, then lines, then those that are asked for, then padding; as
    /// often as there are rows.
    pub wavelength_nm: Vec<f64>,
    uniform: usize,
    lines: Vec<f64>,
    probes: Probes,
    rows: usize,
}

/// Wavelengths at which radiance is asked for, in ascending order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Probes(Vec<f64>);

impl Probes {
    /// Half the band of a single wavelength, nm.
    const HALF_BAND_NM: f64 = 0.5;

    pub fn new(wavelength_nm: &[f64]) -> Probes {
        Probes(wavelength_nm.to_vec())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The ends of the band halfway to the neighbours; the first and the last are as wide on both sides.
    fn band(&self, output: usize) -> (f64, f64) {
        let nm = self.0[output];
        let below = output.checked_sub(1).map(|before| 0.5 * (nm - self.0[before]));
        let above = self.0.get(output + 1).map(|after| 0.5 * (after - nm));
        let least = Probes::HALF_BAND_NM;
        (nm - below.or(above).unwrap_or(least), nm + above.or(below).unwrap_or(least))
    }

    /// The wavelength in whose band a line lies.
    fn output_of(&self, line_nm: f64) -> Option<usize> {
        (0..self.len()).find(|&output| {
            let (from, to) = self.band(output);
            from <= line_nm && line_nm < to
        })
    }
}

/// How many uniform nodes resolve the fringes of an optical path difference 2 n t (nm).
pub fn node_count(path_difference_nm: f64) -> usize {
    let wavenumbers = 1.0 / FROM_NM - 1.0 / TO_NM;
    let wanted = (NODES_A_FRINGE * path_difference_nm * wavenumbers).ceil().clamp(LEAST_NODES as f64, 1e9) as usize;
    wanted.div_ceil(LANES) * LANES
}

/// The longest optical path difference (nm) whose fringes this many uniform nodes resolve.
pub fn resolved_nm(uniform: usize) -> f64 {
    uniform as f64 / (NODES_A_FRINGE * (1.0 / FROM_NM - 1.0 / TO_NM))
}

impl Nodes {
    /// `uniform` nodes (a multiple of [`LANES`]; none where there are only lines) and a node for every line inside the visible range.
    pub fn new(uniform: usize, lines_nm: &[f64]) -> Nodes {
        let mut lines: Vec<f64> = lines_nm.iter().copied().filter(|l| (FROM_NM..=TO_NM).contains(l)).collect();
        lines.sort_by(f64::total_cmp);
        lines.dedup();
        let (low, high) = (1.0 / TO_NM, 1.0 / FROM_NM);
        let mut wavelength_nm: Vec<f64> =
            (0..uniform).map(|i| 1.0 / (low + (high - low) * (i as f64 + 0.5) / uniform as f64)).collect();
        wavelength_nm.extend(&lines);
        // Padding repeats a harmless wavelength and has weight zero.
        wavelength_nm.resize(wavelength_nm.len().div_ceil(LANES) * LANES, 550.0);
        Nodes { wavelength_nm, uniform, lines, probes: Probes::default(), rows: 1 }
    }

    /// The same with a node for each wavelength that is asked for (where light is continuous: between lines there is none),
    /// all as often as there are rows of the adjoint. What is added weighs nothing for X, Y, Z.
    pub fn with_extras(mut self, probes: &Probes, rows: usize) -> Nodes {
        self.wavelength_nm.truncate(self.uniform + self.lines.len());
        if self.uniform > 0 {
            self.wavelength_nm.extend(&probes.0);
        }
        self.wavelength_nm.resize(self.wavelength_nm.len().div_ceil(LANES) * LANES, 550.0);
        self.wavelength_nm = self.wavelength_nm.repeat(rows);
        Nodes { probes: probes.clone(), rows, ..self }
    }

    /// Rows of the adjoint.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Nodes of one row.
    pub fn row_len(&self) -> usize {
        self.len() / self.rows
    }

    /// The wavelengths that are asked for.
    pub fn probes(&self) -> &Probes {
        &self.probes
    }

    /// Which of the wavelengths that are asked for each node of a row tells of.
    pub fn outputs(&self) -> Vec<Option<usize>> {
        let lines = self.lines.iter().map(|&line| self.probes.output_of(line));
        let probes = (0..if self.uniform > 0 { self.probes.len() } else { 0 }).map(Some);
        let mut outputs: Vec<Option<usize>> =
            std::iter::repeat_n(None, self.uniform).chain(lines).chain(probes).collect();
        outputs.resize(self.row_len(), None);
        outputs
    }

    /// Spectral radiance at the nodes of a row, of a light with this illuminant's spectrum and Y = 1, on the scale where D65
    /// of Y = 1 has 1 at 560 nm; of a line the mean over the band that it lies in.
    pub fn radiance(&self, illuminant: &Illuminant) -> Vec<f64> {
        let mut radiance = vec![0.0; self.row_len()];
        let Ok(d65) = Illuminant::named("D65") else { return radiance };
        let y = |illuminant: &Illuminant| -> f64 {
            let continuum = (FROM_NM as u32..=TO_NM as u32).map(|nm| {
                let nm = f64::from(nm);
                illuminant.power(nm) * Observer::Cie1931.at(nm)[1]
            });
            let lines = illuminant.lines().iter().filter(|(nm, _)| (FROM_NM..=TO_NM).contains(nm));
            continuum.sum::<f64>() + lines.map(|(nm, power)| power * Observer::Cie1931.at(*nm)[1]).sum::<f64>()
        };
        let own = y(illuminant);
        if own <= 0.0 {
            return radiance;
        }
        let scale = y(&d65) / d65.power(560.0) / own;
        for &(nm, power) in illuminant.lines() {
            if let (Some(line), Some(output)) =
                (self.lines.iter().position(|&line| line == nm), self.probes.output_of(nm))
            {
                let (from, to) = self.probes.band(output);
                radiance[self.uniform + line] += scale * power / (to - from);
            }
        }
        if self.uniform > 0 {
            for (output, nm) in self.probes.0.iter().enumerate() {
                radiance[self.uniform + self.lines.len() + output] = scale * illuminant.power(*nm);
            }
        }
        radiance
    }

    /// Where among the uniform nodes each node lies that was asked for.
    fn probe_places(&self) -> Vec<f64> {
        let (low, high) = (1.0 / TO_NM, 1.0 / FROM_NM);
        let place = |nm: &f64| (1.0 / nm - low) / (high - low) * self.uniform as f64 - 0.5;
        let count = if self.uniform > 0 { self.probes.len() } else { 0 };
        self.probes.0[..count].iter().map(|nm| place(nm).clamp(0.0, (self.uniform - 1) as f64)).collect()
    }

    /// Whether a node stands for a part of a continuous spectrum: it is neither a line nor a wavelength that is asked for.
    pub fn is_continuous(&self, node: usize) -> bool {
        node % self.row_len() < self.uniform
    }

    /// The lines; their nodes follow the uniform ones.
    pub fn lines(&self) -> &[f64] {
        &self.lines
    }

    /// Number of nodes, padding included.
    pub fn len(&self) -> usize {
        self.wavelength_nm.len()
    }

    /// Number of uniform nodes; they come first.
    pub fn uniform(&self) -> usize {
        self.uniform
    }

    /// Weights of X, Y, Z at every node for a light with this illuminant's spectrum, scaled to Y = 1.
    pub fn weights(&self, illuminant: &Illuminant, observer: Observer) -> [Vec<f64>; 3] {
        let mut weights = [vec![0.0_f64; self.len()], vec![0.0; self.len()], vec![0.0; self.len()]];
        if self.uniform > 0 {
            self.add_continuum(illuminant, observer, &mut weights);
        }
        for &(nm, power) in illuminant.lines() {
            if let Some(line) = self.lines.iter().position(|&l| l == nm) {
                let xyz = observer.at(nm);
                for channel in 0..3 {
                    weights[channel][self.uniform + line] += power * xyz[channel];
                }
            }
        }
        let total: f64 = weights[1].iter().sum();
        let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
        weights.map(|w| w.into_iter().map(|v| v * scale).collect())
    }

    fn add_continuum(&self, illuminant: &Illuminant, observer: Observer, weights: &mut [Vec<f64>; 3]) {
        // Steps of 1 nm, or as fine as the nodes: fringes of thick films that come closer together would beat with the steps.
        let finer = (self.uniform / NODES_PER_NM_STEP).max(1) as u32;
        let step = 1.0 / f64::from(finer);
        let samples: Vec<(f64, [f64; 3])> = (FROM_NM as u32 * finer..=TO_NM as u32 * finer)
            .map(|at| {
                let nm = f64::from(at) * step;
                (nm, observer.at(nm).map(|v| v * illuminant.power(nm) * step))
            })
            .collect();
        // The spline through unit vectors, integrated: solve the transposed problem once for X, Y, Z
        // instead of building every cardinal spline.
        let (low, high) = (1.0 / TO_NM, 1.0 / FROM_NM);
        let step = (high - low) / self.uniform as f64;
        let places: Vec<f64> = samples
            .iter()
            .map(|(nm, _)| ((1.0 / nm - low) / step - 0.5).clamp(0.0, (self.uniform - 1) as f64))
            .collect();
        for (channel, out) in weights.iter_mut().enumerate() {
            let values: Vec<f64> = samples.iter().map(|(_, xyz)| xyz[channel]).collect();
            out[..self.uniform].copy_from_slice(&spline_weights(self.uniform, &places, &values));
        }
    }
}

/// Where in the spectrum a path goes on that a prism has parted.
///
/// It is a place between nodes, not a node: directions are then spread without a gap, and what is carried there is shared
/// between the two nodes beside it, as linear interpolation would. Lines are places of their own.
#[derive(Debug, Clone)]
pub struct Bands {
    /// The place by which paths that carry the whole spectrum are refracted.
    pub middle: f64,
    /// The places at the ends of the spectrum.
    pub ends: [f64; 2],
    /// The nodes that go together: every uniform one by itself, lines that no prism tells apart.
    groups: Vec<Group>,
    /// The same by node: of a group at its first.
    pub chances: Vec<Lanes>,
    uniform: usize,
    blocks: usize,
    /// Of nodes that were asked for: where they lie among the uniform ones. They come from `first_probe` on.
    probe_places: Vec<f64>,
    first_probe: usize,
    rows: usize,
}

/// Nodes that are chosen together.
#[derive(Debug, Clone)]
struct Group {
    nodes: std::ops::Range<usize>,
    /// Chance to be chosen.
    chance: f64,
    /// The same summed over all groups up to and with this one.
    until: f64,
}

impl Bands {
    /// Chances are in proportion to `importance`, that of colours, but never less than a tenth of an equal share: light may be
    /// of another colour than is expected.
    pub fn new(nodes: &Nodes, importance: &[Lanes]) -> Bands {
        let weights: Vec<f64> = importance.iter().flat_map(|l| l.0).map(f64::from).collect();
        let mut ranges: Vec<std::ops::Range<usize>> = (0..nodes.uniform).map(|node| node..node + 1).collect();
        for (i, nm) in nodes.lines.iter().enumerate() {
            let at = nodes.uniform + i;
            match ranges.last_mut() {
                Some(last) if i > 0 && nm - nodes.wavelength_nm[last.start] < SAME_BAND_NM => last.end = at + 1,
                _ => ranges.push(at..at + 1),
            }
        }
        let equal = LEAST_CHANCE / ranges.len() as f64;
        let shares: Vec<f64> = ranges
            .iter()
            .map(|range| equal + (1.0 - LEAST_CHANCE) * weights[range.clone()].iter().map(|w| w.max(0.0)).sum::<f64>())
            .collect();
        let total: f64 = shares.iter().sum();
        let mut until = 0.0;
        let groups: Vec<Group> = ranges
            .into_iter()
            .zip(shares)
            .map(|(nodes, share)| {
                until += share / total;
                Group { nodes, chance: share / total, until }
            })
            .collect();
        let mut chances = vec![Lanes::ZERO; importance.len()];
        for Group { nodes, chance, .. } in &groups {
            chances[nodes.start / LANES].0[nodes.start % LANES] = *chance as f32;
        }
        let distance = |i: &usize| (nodes.wavelength_nm[*i] - 560.0).abs();
        let used = 0..nodes.uniform + nodes.lines.len();
        let middle = used.clone().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let by_wavelength = |a: &usize, b: &usize| nodes.wavelength_nm[*a].total_cmp(&nodes.wavelength_nm[*b]);
        let ends = [used.clone().min_by(by_wavelength), used.max_by(by_wavelength)].map(|end| end.unwrap_or(0) as f64);
        Bands {
            middle: middle.unwrap_or(0) as f64,
            ends,
            groups,
            chances,
            uniform: nodes.uniform,
            blocks: importance.len(),
            probe_places: nodes.probe_places(),
            first_probe: nodes.uniform + nodes.lines.len(),
            rows: nodes.rows,
        }
    }

    /// The place that a point of the unit square chooses.
    #[inline(always)]
    pub fn choose(&self, point: (f64, f64)) -> f64 {
        let (group, moved) = self.choose_group(point);
        self.place(group, moved)
    }

    /// The group that a point of the unit square chooses, and by how much its place lies beside its node.
    #[inline(always)]
    pub fn choose_group(&self, (a, b): (f64, f64)) -> (usize, f64) {
        let at = self.groups.partition_point(|group| group.until <= a).min(self.groups.len() - 1);
        let group = &self.groups[at];
        // What is left of the first number is as good as another: the sum of two spreads like a tent over the neighbours.
        let left = ((a - group.until) / group.chance + 1.0).clamp(0.0, 1.0);
        (at, left + b - 1.0)
    }

    /// A place beside the node of a group; lines are places of their own.
    #[inline(always)]
    pub fn place(&self, group: usize, moved: f64) -> f64 {
        let node = self.groups[group].nodes.start;
        if node >= self.uniform {
            return node as f64;
        }
        // At the ends of the spectrum the tent is folded.
        let last = (self.uniform - 1) as f64;
        let place = (node as f64 + moved).abs();
        if place > last { (2.0 * last - place).max(0.0) } else { place }
    }

    /// How many groups there are.
    pub fn count(&self) -> usize {
        self.groups.len()
    }

    /// The chance of a group.
    pub fn chance(&self, group: usize) -> f64 {
        self.groups[group].chance
    }

    /// The node that a number in [0, 1) chooses, by [`Bands::chances`].
    #[inline(always)]
    pub fn choose_node(&self, random: f64) -> f64 {
        let at = self.groups.partition_point(|group| group.until <= random).min(self.groups.len() - 1);
        self.groups[at].nodes.start as f64
    }

    /// The weights of the nodes at a place: on average over all places every node weighs one.
    #[inline(always)]
    pub fn weigh(&self, place: f64, weights: &mut Vec<Lanes>) {
        weights.clear();
        weights.resize(self.blocks, Lanes::ZERO);
        let first = place as usize;
        if first >= self.uniform {
            let at = self.groups.partition_point(|group| group.nodes.end <= first).min(self.groups.len() - 1);
            self.weigh_group(at, (1.0 / self.groups[at].chance) as f32, weights);
            return;
        }
        let share = place - first as f64;
        // Half of the tent of an outermost node is folded onto the other.
        let folded = |node: usize| if node == 0 || node + 1 == self.uniform { 2.0 } else { 1.0 };
        let beside = (first + 1).min(self.uniform - 1);
        let (low, high) = ((1.0 - share) * folded(first), share * folded(beside));
        let density = low * self.groups[first].chance + high * self.groups[beside].chance;
        weights[first / LANES].0[first % LANES] += (low / density) as f32;
        weights[beside / LANES].0[beside % LANES] += (high / density) as f32;
        self.weigh_probes(weights);
        self.weigh_rows(weights);
    }

    /// The same weight for the nodes of one group, and none for all others.
    pub fn weigh_group(&self, group: usize, weight: f32, weights: &mut Vec<Lanes>) {
        weights.clear();
        weights.resize(self.blocks, Lanes::ZERO);
        for node in self.groups[group].nodes.clone() {
            weights[node / LANES].0[node % LANES] = weight;
        }
        self.weigh_probes(weights);
        self.weigh_rows(weights);
    }

    #[inline(always)]
    fn weigh_probes(&self, weights: &mut [Lanes]) {
        for (i, place) in self.probe_places.iter().enumerate() {
            // What is interpolated between nodes weighs one on average as they do.
            let (before, share) = (*place as usize, (place - place.floor()) as f32);
            let after = (before + 1).min(self.uniform - 1);
            let of = |node: usize| weights[node / LANES].0[node % LANES];
            let weight = of(before) * (1.0 - share) + of(after) * share;
            let node = self.first_probe + i;
            weights[node / LANES].0[node % LANES] = weight;
        }
    }

    /// Further rows of the adjoint weigh as the first does.
    #[inline(always)]
    fn weigh_rows(&self, weights: &mut [Lanes]) {
        let base = self.blocks / self.rows;
        for row in 1..self.rows {
            weights.copy_within(..base, row * base);
        }
    }
}

/// Weights `w` with `sum_i w[i] f[i] = sum_k values[k] s(places[k])`, where s is the natural cubic spline
/// through `f` at 0, 1, .., n - 1.
///
/// With second derivatives m = B f (a tridiagonal solve), s(x) = a f_j + b f_j+1 + c m_j + d m_j+1, so
/// w = sum of the (a, b) parts + B^T (sum of the (c, d) parts), and B^T is the same tridiagonal solve.
fn spline_weights(n: usize, places: &[f64], values: &[f64]) -> Vec<f64> {
    let mut direct = vec![0.0; n];
    let mut curved = vec![0.0; n];
    for (&x, &value) in places.iter().zip(values) {
        let j = (x.floor() as usize).min(n - 2);
        let b = x - j as f64;
        let a = 1.0 - b;
        direct[j] += a * value;
        direct[j + 1] += b * value;
        curved[j] += (a * a * a - a) / 6.0 * value;
        curved[j + 1] += (b * b * b - b) / 6.0 * value;
    }
    // m_{i-1} + 4 m_i + m_{i+1} = 6 (f_{i-1} - 2 f_i + f_{i+1}), m_0 = m_{n-1} = 0; symmetric, so B^T = D^T A^-1.
    let mut rhs: Vec<f64> = curved[1..n - 1].to_vec();
    solve_1_4_1(&mut rhs);
    for (i, &y) in rhs.iter().enumerate() {
        direct[i] += 6.0 * y;
        direct[i + 1] -= 12.0 * y;
        direct[i + 2] += 6.0 * y;
    }
    direct
}

/// Solves the tridiagonal system (1, 4, 1) in place.
fn solve_1_4_1(rhs: &mut [f64]) {
    let mut ratio = Vec::with_capacity(rhs.len());
    let mut pivot = 4.0;
    for i in 0..rhs.len() {
        if i > 0 {
            pivot = 4.0 - ratio[i - 1];
            rhs[i] -= rhs[i - 1];
        }
        rhs[i] /= pivot;
        ratio.push(1.0 / pivot);
    }
    for i in (0..rhs.len().saturating_sub(1)).rev() {
        rhs[i] -= ratio[i] * rhs[i + 1];
    }
}

#[cfg(test)]
mod tests {
    use iridesce_numerics::lanes::blocks;

    use super::*;

    #[test]
    fn spline_weights_are_exact_for_straight_lines_and_good_for_cosines() {
        let n = 24;
        let places: Vec<f64> = (0..200).map(|k| f64::from(k) * 23.0 / 199.0).collect();
        // A bell, as the observers are: nothing at the ends, where a natural spline is poor.
        let values: Vec<f64> = places.iter().map(|x| (-0.5 * ((x - 11.0) / 3.0).powi(2)).exp()).collect();
        let weights = spline_weights(n, &places, &values);
        let error = |f: &dyn Fn(f64) -> f64| {
            let exact: f64 = places.iter().zip(&values).map(|(&x, v)| v * f(x)).sum();
            let found: f64 = weights.iter().enumerate().map(|(i, w)| w * f(i as f64)).sum();
            (found - exact).abs() / values.iter().sum::<f64>()
        };
        assert!(error(&|_| 1.0) < 1e-14);
        assert!(error(&|x| 3.0 * x - 1.0) < 1e-12);
        // Eight nodes to a period: cubic splines err by (2 pi / 8)^4 / 720 ~ 5e-4 at most.
        assert!(error(&|x| (std::f64::consts::FRAC_PI_4 * x).cos()) < 5e-4);
    }

    #[test]
    fn white_is_the_white_of_the_one_nanometre_sum() {
        let d65 = Illuminant::named("D65").unwrap();
        let weights = Nodes::new(32, &[]).weights(&d65, Observer::Cie1931);
        let xyz = weights.map(|w| w.iter().sum::<f64>());
        let mut sums = [0.0; 3];
        for nm in 360..=830 {
            let at = Observer::Cie1931.at(f64::from(nm));
            for c in 0..3 {
                sums[c] += at[c] * d65.power(f64::from(nm));
            }
        }
        for c in 0..3 {
            assert!((xyz[c] - sums[c] / sums[1]).abs() < 1e-12, "{xyz:?} {sums:?}");
        }
    }

    #[test]
    fn lines_are_nodes() {
        let sodium = Illuminant::named("lines:589.158*2,589.756").unwrap();
        let lines: Vec<f64> = sodium.lines().iter().map(|l| l.0).collect();
        let nodes = Nodes::new(32, &lines);
        assert_eq!(nodes.len(), 48);
        assert_eq!(nodes.wavelength_nm[32..34], [589.158, 589.756]);
        let y = &nodes.weights(&sodium, Observer::Cie1931)[1];
        assert!((y.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let y_bar = |nm| Observer::Cie1931.at(nm)[1];
        assert!((y[32] / y[33] - 2.0 * y_bar(589.158) / y_bar(589.756)).abs() < 1e-12, "powers 2 : 1");
        assert!(y[34..].iter().all(|&w| w == 0.0), "padding weighs nothing");
    }

    #[test]
    fn lines_alone_need_no_other_nodes() {
        let sodium = Illuminant::named("lines:589.158*2,589.756").unwrap();
        let nodes = Nodes::new(0, &[589.158, 589.756]);
        assert_eq!((nodes.len(), nodes.uniform()), (16, 0));
        let y = &nodes.weights(&sodium, Observer::Cie1931)[1];
        assert!((y[0] + y[1] - 1.0).abs() < 1e-12 && y[2..].iter().all(|&w| w == 0.0));
        assert!(nodes.weights(&Illuminant::named("D65").unwrap(), Observer::Cie1931)[1].iter().all(|&w| w == 0.0));
    }

    /// Whatever the places weigh, on average every node weighs one: that is all that makes the choice fair.
    #[test]
    fn places_are_chosen_fairly() {
        for (uniform, lines) in [(32, &[][..]), (96, &[435.8, 546.07, 577.0, 579.07][..]), (0, &[589.158, 589.756][..])]
        {
            let nodes = Nodes::new(uniform, lines);
            let d65 = nodes.weights(&Illuminant::named("D65").unwrap(), Observer::Cie1931);
            let importance = blocks(d65[1].iter().map(|w| 0.5 * w));
            let bands = Bands::new(&nodes, &importance);
            let mut mean = vec![0.0; nodes.len()];
            let mut weights = Vec::new();
            let (columns, rows) = (20_000, 16);
            for i in 0..columns * rows {
                let a = (f64::from(i / rows) + 0.5) / f64::from(columns);
                let b = (f64::from(i % rows) + 0.5) / f64::from(rows);
                let place = bands.choose((a, b));
                bands.weigh(place, &mut weights);
                assert!(weights[place as usize / LANES].0[place as usize % LANES] >= 0.0);
                for (sum, weight) in mean.iter_mut().zip(weights.iter().flat_map(|l| l.0)) {
                    *sum += f64::from(weight) / f64::from(columns * rows);
                }
            }
            for (i, value) in mean.iter().enumerate().take(uniform + lines.len()) {
                // The least chance, 0.25 / 98, holds 50 columns.
                assert!((value - 1.0).abs() < 0.06, "{uniform}, node {i}: {value}");
            }
            let all: f64 = mean.iter().take(uniform + lines.len()).sum();
            assert!((all / (uniform + lines.len()) as f64 - 1.0).abs() < 5e-3, "{all}");
        }
    }
}
