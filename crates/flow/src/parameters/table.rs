//! The table of all numbers that a film follows: a field, its name outside, its unit there, what is allowed, and its
//! value for a dome on a bath. `docs/guide/living-films.md` has their sources.

use crate::grid::Shape;

/// What a number may be.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Allowed {
    /// Finite, above zero.
    Positive,
    /// Finite, zero or above.
    NotNegative,
    /// Above zero, perhaps infinite.
    PositiveOrInfinite,
}

impl Allowed {
    /// The rule that a value breaks, in words.
    pub fn broken_by(self, value: f64) -> Option<&'static str> {
        let is_kept = match self {
            Allowed::Positive => value > 0.0 && value.is_finite(),
            Allowed::NotNegative => value >= 0.0 && value.is_finite(),
            Allowed::PositiveOrInfinite => value > 0.0,
        };
        let rule = if self == Allowed::NotNegative { "a finite number >= 0" } else { "a finite number > 0" };
        (!is_kept).then_some(rule)
    }
}

/// A line: what it is; the field, in SI: its name outside and what a unit of the field is there, what is allowed, its
/// value for a dome on a bath.
macro_rules! numbers {
    ($($(#[doc = $what:literal])+ $field:ident: $name:literal * $scale:literal, $allowed:ident, $dome:expr;)+) => {
        /// What a flowing film is made of and exposed to. SI units throughout; `docs/guide/living-films.md` has the sources.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Parameters {
            /// What the film spans.
            pub shape: Shape,
            /// Cells across; even.
            pub columns: usize,
            /// Cells from top to bottom.
            pub rows: usize,
            $($(#[doc = $what])+ pub $field: f64,)+
            /// Whether liquid also runs down between the faces.
            pub drains_inside: bool,
            /// Another seed, another film.
            pub seed: u64,
        }

        impl Parameters {
            /// A dome of 2.5 cm on a bath, in a draughty room.
            pub(super) fn dome() -> Parameters {
                Parameters {
                    shape: Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 },
                    columns: 384,
                    rows: 96,
                    $($field: $dome,)+
                    drains_inside: true,
                    seed: 1,
                }
            }

            /// Name outside and value in the unit of that name, in the order of the table.
            pub(super) fn numbers(&self) -> Vec<(&'static str, f64)> {
                vec![$(($name, self.$field * $scale),)+]
            }

            /// Changes a number by its name outside; false if there is none of that name.
            pub(super) fn set_number(&mut self, name: &str, value: f64) -> bool {
                match name {
                    $($name => self.$field = value / $scale,)+
                    _ => return false,
                }
                true
            }
        }

        /// What a number may be, by its name outside.
        pub fn allowed(name: &str) -> Allowed {
            match name {
                $($name => Allowed::$allowed,)+
                // The sides of a shape.
                _ => Allowed::Positive,
            }
        }
    };
}

numbers! {
    /// Longest time step, s.
    step_s: "step_s" * 1.0, Positive, 5e-3;
    /// Order of a step in time: 1 or 2.
    time_order: "time_order" * 1.0, Positive, 1.0;
    /// Mean thickness at the start, m.
    thickness_m: "thickness_nm" * 1e9, Positive, 450e-9;
    /// Standard deviation of the thickness at the start, as a share of its mean.
    noise: "noise" * 1.0, NotNegative, 0.25;
    /// Longest correlation length of that noise, m.
    noise_longest_m: "noise_longest_m" * 1.0, Positive, 0.025 / 4.0;
    /// The shortest, m.
    noise_shortest_m: "noise_shortest_m" * 1.0, Positive, 0.025 / 40.0;
    /// Density of the liquid, kg/m3.
    density: "density_kg_m3" * 1.0, Positive, 1000.0;
    /// Acceleration of gravity, m/s2.
    gravity: "gravity_m_s2" * 1.0, NotNegative, 9.81;
    /// How far the frame of a plane leans from the vertical, degrees; a sphere has none.
    tilt_deg: "tilt_deg" * 1.0, NotNegative, 0.0;
    /// Greatest acceleration of a frame, or of a bubble's ring, that is shaken up and down along the film, m/s2.
    shake: "shake_m_s2" * 1.0, NotNegative, 0.0;
    /// How often it is, Hz.
    shake_hz: "shake_hz" * 1.0, Positive, 5.0;
    /// Viscosity of the liquid, Pa s.
    viscosity: "viscosity_pa_s" * 1.0, Positive, 1.5e-3;
    /// Surface shear viscosity of one face, Pa s m.
    surface_viscosity: "surface_viscosity_pa_s_m" * 1.0, NotNegative, 1e-8;
    /// Film elasticity E = 2 A dsigma/dA, N/m; infinity makes the film incompressible.
    elasticity: "elasticity_n_m" * 1.0, PositiveOrInfinite, 22e-3;
    /// Tension of one face, N/m.
    tension: "tension_n_m" * 1.0, Positive, 30e-3;
    /// Diffusivity of the surfactant along the faces, m2/s.
    surfactant_diffusivity: "surfactant_diffusivity_m2_s" * 1.0, NotNegative, 0.0;
    /// Time in which the surfactant of the faces comes to rest with that of the liquid, s; infinity if insoluble.
    surfactant_exchange_s: "surfactant_exchange_s" * 1.0, PositiveOrInfinite, f64::INFINITY;
    /// Density of the air, kg/m3.
    air_density: "air_density_kg_m3" * 1.0, NotNegative, 1.184;
    /// Kinematic viscosity of the air, m2/s.
    air_viscosity: "air_viscosity_m2_s" * 1.0, NotNegative, 1.562e-5;
    /// Length over which the air's boundary layer grows, m.
    air_length_m: "air_length_m" * 1.0, Positive, 0.01;
    /// Least speed that the drag of the air is reckoned with, m/s.
    air_speed: "air_speed_m_s" * 1.0, NotNegative, 0.02;
    /// Air that is carried with the film, kg/m2.
    air_mass: "air_mass_kg_m2" * 1.0, NotNegative, 5e-4;
    /// Wind at the height of the top, m/s; less below, none at the rim or the lowest point.
    wind: "wind_m_s" * 1.0, NotNegative, 0.0;
    /// Root mean square speed of eddies in the air, m/s.
    eddies: "eddies_m_s" * 1.0, NotNegative, 0.0;
    /// How many times faster than in nature the film loses liquid, on all ways together; what moves keeps its pace.
    speed: "speed" * 1.0, Positive, 1.0;
    /// Evaporation of both faces together, m/s.
    evaporation: "evaporation_nm_s" * 1e9, NotNegative, 20e-9;
    /// Strength K of marginal regeneration.
    regeneration: "regeneration" * 1.0, NotNegative, 0.06;
    /// Radius of the meniscus, m.
    meniscus_m: "meniscus_m" * 1.0, Positive, 0.3e-3;
    /// Radius of the meniscus along the lower border of a plane, m; 0 if it is that of the others. A bubble has no other.
    bottom_meniscus_m: "bottom_meniscus_m" * 1.0, NotNegative, 0.0;
    /// Mean radius of a regenerated patch, m.
    patch_m: "patch_m" * 1.0, Positive, 2e-3;
    /// Thickness of a patch as a share of the film next to it.
    patch_ratio: "patch_ratio" * 1.0, Positive, 0.85;
    /// Time in which a patch forms, s.
    patch_s: "patch_s" * 1.0, Positive, 0.1;
    /// Radius of the drop that hangs from a whole sphere, m; its rim regenerates.
    drop_m: "drop_m" * 1.0, NotNegative, 0.0;
    /// Thickness below which a film turns black, m.
    black_below_m: "black_below_nm" * 1e9, NotNegative, 55e-9;
    /// Thickness of the black film, m.
    black_m: "black_nm" * 1e9, NotNegative, 12e-9;
    /// Time in which it turns, s.
    black_s: "black_s" * 1.0, Positive, 0.05;
    /// Salt of the liquid, mol/m3: thin film turns black by the pressure between its faces; 0: below `black_below_nm`.
    salt: "salt_mol_m3" * 1.0, NotNegative, 0.0;
    /// Hamaker constant of the liquid between air, J.
    hamaker: "hamaker_j" * 1.0, NotNegative, 4e-20;
    /// Potential of a face, V.
    surface_potential: "surface_potential_v" * 1.0, NotNegative, 0.1;
    /// Thickness of a Newton black film, m.
    newton_m: "newton_nm" * 1e9, Positive, 4.5e-9;
    /// Black spots that open by chance, per m2 and second, where the film is thinner than `spot_below_m`.
    spots: "spots_per_m2_s" * 1.0, NotNegative, 0.0;
    /// Thickest film that spots open in, m.
    spot_below_m: "spot_below_nm" * 1e9, NotNegative, 0.0;
    /// Mean radius to which a spot grows, m.
    spot_m: "spot_m" * 1.0, Positive, 0.5e-3;
    /// Speed of a spot's rim, m/s.
    spot_speed: "spot_speed_m_s" * 1.0, Positive, 5e-3;
    /// Thickness below which a film may burst, m; 0 if never.
    rupture_m: "rupture_nm" * 1e9, NotNegative, 30e-9;
    /// How often it does, per m2 of film thinner than that and second; infinity if at once.
    rupture_rate: "rupture_per_m2_s" * 1.0, PositiveOrInfinite, 500.0;
    /// Residual at which the tension counts as solved, as a share of what drives it.
    tolerance: "tolerance" * 1.0, Positive, 1e-4;
}
