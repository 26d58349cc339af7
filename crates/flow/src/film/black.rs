//! Film below 100 nm by the pressure between its faces, as a law for what a cell cannot hold: the waves that tear such film
//! are some ten um long, and where they have torn it black film is left.

use std::f64::consts::PI;

use crate::parameters::Parameters;

/// Thickest film whose faces feel each other, m: at 100 nm the growth of waves takes minutes.
const FELT_M: f64 = 100e-9;
/// Steps of the table of rates, m.
const STEP_M: f64 = 0.1e-9;
/// Film thicker than black film by less than this share of it is black film.
const NEARLY: f64 = 1.0 / 3.0;
/// Boltzmann's constant, J/K; Avogadro's number, /mol; the charge of an electron, C (CODATA 2018, exact).
const BOLTZMANN: f64 = 1.380_649e-23;
const AVOGADRO: f64 = 6.022_140_76e23;
const CHARGE: f64 = 1.602_176_634e-19;
/// Permittivity of water at 25 C, F/m: 78.4 of the vacuum's (CRC Handbook).
const PERMITTIVITY: f64 = 78.4 * 8.854_187_812_8e-12;
/// 25 C, as the air has, K.
const KELVIN: f64 = 298.15;

impl Parameters {
    /// Disjoining pressure of film of a thickness, Pa, and its slope, Pa/m: double layers of salt of one charge that
    /// overlap weakly, less van der Waals attraction,
    /// `64 k T n tanh^2(e psi / 4 k T) exp(-h / lambda) - A / (6 pi h^3)` (Israelachvili, Intermolecular and Surface
    /// Forces, chapters 11 and 14).
    pub(crate) fn disjoining(&self, h: f64) -> [f64; 2] {
        let number = self.salt * AVOGADRO;
        let warmth = BOLTZMANN * KELVIN;
        let debye = (PERMITTIVITY * warmth / (2.0 * number * CHARGE * CHARGE)).sqrt();
        let layers = 64.0 * warmth * number * (CHARGE * self.surface_potential / (4.0 * warmth)).tanh().powi(2);
        let push = layers * (-h / debye).exp();
        let pull = self.hamaker / (6.0 * PI * h.powi(3));
        [push - pull, 3.0 * pull / h - push / debye]
    }

    /// Thickness of black film, m: `black_nm` under the threshold; with salt, where the disjoining pressure holds against
    /// the suction of the meniscus, tension over its radius (common black film), or `newton_nm` where it nowhere does.
    pub(crate) fn black_film_m(&self) -> f64 {
        if self.salt == 0.0 {
            return self.black_m;
        }
        let suction = self.tension / self.meniscus_m;
        let holds = |h: f64| self.disjoining(h)[0] >= suction;
        let steps = ((FELT_M - self.newton_m) / STEP_M).max(0.0) as usize;
        let Some(at) = (0..=steps).map(|k| FELT_M - k as f64 * STEP_M).find(|&h| holds(h)) else {
            return self.newton_m;
        };
        let (mut thin, mut thick) = (at, at + STEP_M);
        for _ in 0..40 {
            let middle = 0.5 * (thin + thick);
            if holds(middle) { thin = middle } else { thick = middle }
        }
        thin
    }
}

/// How film turns black within a step.
pub struct Turning {
    /// What it turns to, m.
    pub black_m: f64,
    /// What is left of the excess over that after the step, by thickness in steps of [`STEP_M`] from 0 to [`FELT_M`].
    kept: Vec<f64>,
}

impl Turning {
    /// By the fastest wave of film that its faces pull together, which grows at `h^3 Pi'^2 / (24 mu sigma)` (Vrij 1966,
    /// Discuss. Faraday Soc. 42, 23), here the rate at which what is above black film leaves. Film that has begun
    /// does not come to rest before it is black: the rate does not fall on its way.
    pub fn new(p: &Parameters, dt: f64) -> Turning {
        let count = (FELT_M / STEP_M).round() as usize;
        let mut kept = vec![1.0; count + 1];
        let mut fastest = 0.0_f64;
        for k in (1..=count).rev() {
            let h = k as f64 * STEP_M;
            let slope = p.disjoining(h)[1];
            if slope > 0.0 {
                fastest = fastest.max(h.powi(3) * slope * slope / (24.0 * p.viscosity * p.tension));
            }
            kept[k] = (-dt * p.speed * fastest).exp();
        }
        kept[0] = kept[1];
        Turning { black_m: p.black_film_m(), kept }
    }

    /// Evaporation of a row, down to black film, and what turns black; what went either way, m times a cell.
    pub fn thin_row(&self, row: &mut [f64], loss: f64) -> (f64, f64) {
        let (mut dry, mut black) = (0.0, 0.0);
        for h in row {
            let room = (*h - self.black_m).max(0.0);
            let taken = loss.min(room);
            let left = *h - taken;
            let new = self.black_m + (left - self.black_m) * self.kept(left);
            dry += taken;
            black += left - new;
            *h = new;
        }
        (dry, black)
    }

    /// The same where a share of each cell is black film.
    pub fn thin_mixed_row(&self, row: &mut [f64], share: &mut [f64], loss: f64) -> (f64, f64) {
        let (mut dry, mut black) = (0.0, 0.0);
        for (h, phi) in row.iter_mut().zip(share) {
            let rest = 1.0 - *phi;
            let excess = *h - self.black_m;
            let taken = (rest * loss).min(excess.max(0.0));
            let left = excess - taken;
            let thick = if rest > 0.0 { self.black_m + left / rest } else { self.black_m + left };
            let new = left * self.kept(thick);
            if new <= rest * NEARLY * self.black_m {
                *phi = 1.0;
            }
            dry += taken;
            black += left - new;
            *h = self.black_m + new;
        }
        (dry, black)
    }

    /// What is left after the step of what film has above black film.
    fn kept(&self, thickness_m: f64) -> f64 {
        if !(thickness_m < FELT_M && thickness_m > self.black_m) {
            return 1.0;
        }
        let place = thickness_m / STEP_M;
        let (k, share) = (place as usize, place.fract());
        let next = self.kept[(k + 1).min(self.kept.len() - 1)];
        self.kept[k] + (next - self.kept[k]) * share
    }
}
