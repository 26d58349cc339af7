//! Films by name.

use crate::grid::{Shape, Sides};
use crate::parameters::Parameters;
use iridesce_thickness::ThicknessError;

/// Presets by name.
pub const PRESETS: [&str; 19] = [
    "bubble-on-bath",
    "bubble-on-bath-preview",
    "bubble-on-bath-small-preview",
    "bubble-on-bath-time-lapse",
    "free-bubble",
    "free-bubble-preview",
    "free-bubble-small-preview",
    "free-bubble-time-lapse",
    "giant-bubble",
    "giant-bubble-time-lapse",
    "late",
    "late-preview",
    "late-time-lapse",
    "vertical-film",
    "vertical-film-preview",
    "vertical-film-time-lapse",
    "vertical-film-wide",
    "vertical-film-wide-preview",
    "vertical-film-wide-time-lapse",
];

/// How many times faster a preset of that name's end loses liquid than the one without.
const TIME_LAPSE: &str = "-time-lapse";
const TIME_LAPSE_SPEED: f64 = 6.0;
/// The middle of a wide frame, 10 cm across before it repeats: its sides are out of sight.
const WIDE: &str = "-wide";

impl Parameters {
    /// A film by name, one of [`PRESETS`].
    ///
    /// ```
    /// use iridesce_flow::Parameters;
    /// assert_eq!(Parameters::preset("late")?.thickness_m, 260e-9);
    /// assert!(Parameters::preset("soup").is_err());
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn preset(name: &str) -> Result<Parameters, ThicknessError> {
        // The same film but for what it loses; one that repeats instead of ending at its sides.
        if let Some(natural) = name.strip_suffix(TIME_LAPSE)
            && PRESETS.contains(&name)
        {
            return Ok(Parameters { speed: TIME_LAPSE_SPEED, ..Parameters::preset(natural)? });
        }
        if PRESETS.contains(&name) && name.contains(WIDE) {
            let mut film = Parameters::preset(&name.replace(WIDE, ""))?;
            film.set_sides(Sides::Periodic.name())?;
            // What the borders do not take leaves at the bottom alone.
            return Ok(Parameters { bottom_meniscus_m: 0.0, ..film });
        }
        let dome = Parameters::dome();
        let free = Parameters {
            shape: Shape::Sphere { radius_m: 0.03, rim_deg: 180.0 },
            rows: 192,
            noise: 0.3,
            noise_longest_m: 0.03 / 4.0,
            noise_shortest_m: 0.03 / 40.0,
            patch_m: 2.5e-3,
            drop_m: 5e-3,
            wind: 0.15,
            eddies: 0.1,
            ..dome.clone()
        };
        let giant = Parameters {
            shape: Shape::Sphere { radius_m: 0.15, rim_deg: 180.0 },
            // Giant films that are pulled up by hand are a few um thick (Pasquet et al. 2022, arXiv:2209.03468).
            thickness_m: 3e-6,
            noise_longest_m: 0.15 / 4.0,
            noise_shortest_m: 0.15 / 40.0,
            patch_m: 10e-3,
            drop_m: 20e-3,
            air_length_m: 0.05,
            wind: 0.3,
            eddies: 0.15,
            // Diffusion from a sphere of this radius at half humidity.
            evaporation: 1.4e-9,
            ..free.clone()
        };
        // 40 spots a second over 10 cm2.
        let late =
            Parameters { thickness_m: 260e-9, evaporation: 30e-9, spots: 4e3, spot_below_m: 170e-9, ..dome.clone() };
        let vertical = Parameters {
            shape: Shape::Plane { width_m: 0.1, height_m: 0.06, sides: Sides::Menisci },
            columns: 320,
            rows: 192,
            thickness_m: 700e-9,
            noise_longest_m: 0.01,
            noise_shortest_m: 0.001,
            evaporation: 10e-9,
            // It stands on a bath: a static meniscus touches a vertical film at sqrt(2) capillary lengths above the bath
            // and is curved as rho g times that over sigma there (Landau and Lifshitz, Fluid Mechanics, section 61).
            bottom_meniscus_m: 1.24e-3,
            ..dome.clone()
        };
        // Previews: as fine as one core can show in real time at 30 pictures/s, a step a picture. Those of second order are
        // as near to their limit as with steps of first order of half a picture; where a step of first order was a picture
        // already, two pictures of second order would be further from it. Patches have 4 cells a radius; what regenerates
        // does not depend on their size. They do not burst while one looks on.
        let dome_preview = |columns: usize| Parameters {
            patch_m: 0.64 / columns as f64,
            noise_longest_m: 0.025 / 4.0,
            noise_shortest_m: 0.16 / columns as f64,
            step_s: 1.0 / 30.0,
            time_order: if columns < 256 { 1.0 } else { 2.0 },
            tolerance: 1e-3,
            rupture_m: 0.0,
            ..dome.clone().with_columns(columns)
        };
        let free_preview = |columns: usize| Parameters {
            patch_m: 0.77 / columns as f64,
            noise_longest_m: 0.03 / 4.0,
            noise_shortest_m: 0.19 / columns as f64,
            step_s: 1.0 / 30.0,
            tolerance: 1e-3,
            rupture_m: 0.0,
            ..free.clone().with_columns(columns)
        };
        match name {
            "bubble-on-bath-preview" => Ok(dome_preview(256)),
            "bubble-on-bath-small-preview" => Ok(dome_preview(128)),
            // A whole sphere has twice the rows of a dome: at 256 columns it fell behind on one core.
            "free-bubble-preview" => Ok(free_preview(192)),
            "free-bubble-small-preview" => Ok(free_preview(128)),
            "late-preview" => {
                let Parameters { thickness_m, evaporation, spots, spot_below_m, .. } = late;
                Ok(Parameters { thickness_m, evaporation, spots, spot_below_m, ..dome_preview(256) })
            }
            "vertical-film-preview" => {
                let own = vertical.with_columns(192);
                Ok(Parameters { patch_m: 2.2e-3, step_s: 1.0 / 30.0, tolerance: 1e-3, rupture_m: 0.0, ..own })
            }
            "vertical-film" => Ok(vertical),
            "bubble-on-bath" => Ok(dome),
            "free-bubble" => Ok(free),
            "giant-bubble" => Ok(giant),
            "late" => Ok(late),
            _ => {
                let allowed = format!("one of {}", PRESETS.join(", "));
                Err(ThicknessError::new("preset", allowed, format!("{name:?}")))
            }
        }
    }
}
