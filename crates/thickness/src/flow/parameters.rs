//! Every number that a film follows, with its unit; presets.

use super::grid::Shape;
use crate::error::ThicknessError;

/// What a flowing film is made of and exposed to. SI units throughout; `docs/living-films.md` has the sources.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// What the film spans.
    pub shape: Shape,
    /// Cells across; even.
    pub columns: usize,
    /// Cells from top to bottom.
    pub rows: usize,
    /// Longest time step, s.
    pub step_s: f64,
    /// Mean thickness at the start, m.
    pub thickness_m: f64,
    /// Standard deviation of the thickness at the start, as a share of its mean.
    pub noise: f64,
    /// Longest and shortest correlation length of that noise, m.
    pub noise_length_m: [f64; 2],
    /// Density of the liquid, kg/m3.
    pub density: f64,
    /// Acceleration of gravity, m/s2.
    pub gravity: f64,
    /// Viscosity of the liquid, Pa s.
    pub viscosity: f64,
    /// Surface shear viscosity of one face, Pa s m.
    pub surface_viscosity: f64,
    /// Film elasticity E = 2 A dsigma/dA, N/m; infinity makes the film incompressible.
    pub elasticity: f64,
    /// Tension of one face, N/m.
    pub tension: f64,
    /// Diffusivity of the surfactant along the faces, m2/s.
    pub surfactant_diffusivity: f64,
    /// Time in which the surfactant of the faces comes to rest with that of the liquid, s; infinity if insoluble.
    pub surfactant_exchange_s: f64,
    /// Density of the air, kg/m3.
    pub air_density: f64,
    /// Kinematic viscosity of the air, m2/s.
    pub air_viscosity: f64,
    /// Length over which the air's boundary layer grows, m.
    pub air_length_m: f64,
    /// Least speed that the drag of the air is reckoned with, m/s.
    pub air_speed: f64,
    /// Air that is carried with the film, kg/m2.
    pub air_mass: f64,
    /// Wind at the height of the top, m/s; less below, none at the rim or the lowest point.
    pub wind: f64,
    /// Root mean square speed of eddies in the air, m/s.
    pub eddies: f64,
    /// Evaporation of both faces together, m/s.
    pub evaporation: f64,
    /// Whether liquid also runs down between the faces.
    pub drains_inside: bool,
    /// Strength K of marginal regeneration.
    pub regeneration: f64,
    /// Radius of the meniscus, m.
    pub meniscus_m: f64,
    /// Mean radius of a regenerated patch, m.
    pub patch_m: f64,
    /// Thickness of a patch as a share of the film next to it.
    pub patch_ratio: f64,
    /// Time in which a patch forms, s.
    pub patch_s: f64,
    /// Radius of the drop that hangs from a whole sphere, m; its rim regenerates.
    pub drop_m: f64,
    /// Thickness below which a film turns black, m.
    pub black_below_m: f64,
    /// Thickness of the black film, m.
    pub black_m: f64,
    /// Time in which it turns, s.
    pub black_s: f64,
    /// Black spots that open by chance, per m2 and second, where the film is thinner than `spot_below_m`.
    pub spots: f64,
    /// Thickest film that spots open in, m.
    pub spot_below_m: f64,
    /// Mean radius to which a spot grows, m.
    pub spot_m: f64,
    /// Speed of a spot's rim, m/s.
    pub spot_speed: f64,
    /// Thickness at which a film bursts, m; 0 if never.
    pub rupture_m: f64,
    /// Residual at which the tension counts as solved, as a share of what drives it.
    pub tolerance: f64,
    /// Another seed, another film.
    pub seed: u64,
}

/// Presets by name.
pub const PRESETS: [&str; 8] = [
    "bubble-on-bath",
    "bubble-on-bath-time-lapse",
    "free-bubble",
    "free-bubble-time-lapse",
    "giant-bubble",
    "giant-bubble-time-lapse",
    "late",
    "late-time-lapse",
];

impl Parameters {
    /// A film by name, one of [`PRESETS`].
    ///
    /// ```
    /// use iridesce_thickness::flow::Parameters;
    /// assert_eq!(Parameters::preset("late")?.thickness_m, 260e-9);
    /// assert!(Parameters::preset("soup").is_err());
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn preset(name: &str) -> Result<Parameters, ThicknessError> {
        let dome = Parameters {
            shape: Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 },
            columns: 512,
            rows: 128,
            step_s: 5e-3,
            thickness_m: 450e-9,
            noise: 0.25,
            noise_length_m: [0.025 / 4.0, 0.025 / 40.0],
            density: 1000.0,
            gravity: 9.81,
            viscosity: 1.5e-3,
            surface_viscosity: 1e-8,
            elasticity: 22e-3,
            tension: 30e-3,
            surfactant_diffusivity: 0.0,
            surfactant_exchange_s: f64::INFINITY,
            air_density: 1.184,
            air_viscosity: 1.562e-5,
            air_length_m: 0.01,
            air_speed: 0.02,
            air_mass: 5e-4,
            wind: 0.0,
            eddies: 0.0,
            evaporation: 20e-9,
            drains_inside: true,
            regeneration: 0.06,
            meniscus_m: 0.3e-3,
            patch_m: 2e-3,
            patch_ratio: 0.85,
            patch_s: 0.1,
            drop_m: 0.0,
            black_below_m: 55e-9,
            black_m: 12e-9,
            black_s: 0.05,
            spots: 0.0,
            spot_below_m: 0.0,
            spot_m: 0.5e-3,
            spot_speed: 5e-3,
            rupture_m: 0.0,
            tolerance: 1e-4,
            seed: 1,
        };
        let free = Parameters {
            shape: Shape::Sphere { radius_m: 0.03, rim_deg: 180.0 },
            rows: 256,
            noise: 0.3,
            noise_length_m: [0.03 / 4.0, 0.03 / 40.0],
            patch_m: 2.5e-3,
            drop_m: 5e-3,
            wind: 0.15,
            eddies: 0.1,
            ..dome.clone()
        };
        let giant = Parameters {
            shape: Shape::Sphere { radius_m: 0.15, rim_deg: 180.0 },
            thickness_m: 1.5e-6,
            noise_length_m: [0.15 / 4.0, 0.15 / 40.0],
            patch_m: 10e-3,
            drop_m: 20e-3,
            air_length_m: 0.05,
            wind: 0.3,
            eddies: 0.15,
            // Diffusion from a sphere of this radius at half humidity, from both faces.
            evaporation: 3e-9,
            ..free.clone()
        };
        // 40 spots a second over 10 cm2.
        let late =
            Parameters { thickness_m: 260e-9, evaporation: 30e-9, spots: 4e3, spot_below_m: 170e-9, ..dome.clone() };
        match name {
            "bubble-on-bath" => Ok(dome),
            "bubble-on-bath-time-lapse" => Ok(Parameters { regeneration: 0.4, wind: 0.03, ..dome }),
            "free-bubble" => Ok(free),
            "free-bubble-time-lapse" => Ok(Parameters { regeneration: 0.4, ..free }),
            "giant-bubble" => Ok(giant),
            "giant-bubble-time-lapse" => Ok(Parameters { regeneration: 0.4, evaporation: 30e-9, ..giant }),
            "late" => Ok(late),
            "late-time-lapse" => Ok(Parameters { regeneration: 0.5, ..late }),
            _ => {
                let message = format!("must be one of {}, got {name:?}", PRESETS.join(", "));
                Err(ThicknessError { key: "preset", message })
            }
        }
    }

    /// The same film on another number of columns, with rows to match: cells stay as square as they were.
    pub fn with_columns(self, columns: usize) -> Parameters {
        let rows = (self.rows as f64 * columns as f64 / self.columns as f64).round() as usize;
        Parameters { columns, rows, ..self }
    }

    /// Refuses what no film can be, and a grid that cannot hold it.
    pub fn check(&self) -> Result<(), ThicknessError> {
        let wrong = |key: &'static str, message: String| Err(ThicknessError { key, message });
        for (key, value, least) in self.bounds() {
            let allowed = value >= 0.0 && (value.is_finite() || INFINITE.contains(&key));
            if !allowed || (value == 0.0 && least == Least::Above) {
                let rule = if least == Least::Above { "> 0" } else { ">= 0" };
                return wrong(key, format!("must be a finite number {rule}, got {value:?}"));
            }
        }
        if let Shape::Sphere { rim_deg, .. } = self.shape
            && !(20.0..=160.0).contains(&rim_deg)
            && rim_deg != 180.0
        {
            return wrong("rim_deg", format!("must be 180 for a whole sphere, else from 20 to 160, got {rim_deg:?}"));
        }
        for (key, value, least) in [("columns", self.columns, 16), ("rows", self.rows, 8)] {
            if !(least..=16384).contains(&value) {
                return wrong(key, format!("must be from {least} to 16384 cells, got {value}"));
            }
        }
        if !self.columns.is_multiple_of(2) {
            return wrong("columns", format!("must be even, got {}", self.columns));
        }
        if !(0.0..1.0).contains(&self.patch_ratio) && self.regeneration > 0.0 {
            return wrong("patch_ratio", format!("must be below 1, got {:?}", self.patch_ratio));
        }
        if self.noise > 0.35 {
            return wrong("noise", format!("must be at most 0.35 of the mean, got {:?}", self.noise));
        }
        if self.noise_length_m[1] > self.noise_length_m[0] {
            return wrong(
                "noise_length_m",
                format!("must be the longest, then the shortest, got {:?}", self.noise_length_m),
            );
        }
        if self.black_m > self.black_below_m {
            return wrong(
                "black_m",
                format!("must not exceed black_below_m, {:?}, got {:?}", self.black_below_m, self.black_m),
            );
        }
        if self.tolerance > 0.1 {
            return wrong("tolerance", format!("must be at most 0.1, got {:?}", self.tolerance));
        }
        if let Shape::Sphere { radius_m, rim_deg } = self.shape
            && rim_deg == 180.0
            && self.drop_m > radius_m / 2.0
        {
            return wrong(
                "drop_m",
                format!("must be at most half the bubble's radius, {radius_m:?}, got {:?}", self.drop_m),
            );
        }
        if self.patches() {
            let cell = self.cell_m();
            if self.patch_m < 4.0 * cell {
                let enough = (self.columns as f64 * 4.0 * cell / self.patch_m / 2.0).ceil() as usize * 2;
                return wrong(
                    "columns",
                    format!(
                        "must be at least {enough}, so that a patch of {:?} m has 4 cells a radius, got {}",
                        self.patch_m, self.columns
                    ),
                );
            }
        }
        Ok(())
    }

    /// Whether anything regenerates: a rim is needed.
    pub fn patches(&self) -> bool {
        let rim = match self.shape {
            Shape::Sphere { rim_deg, .. } => rim_deg < 180.0 || self.drop_m > 0.0,
            Shape::Plane { .. } => true,
        };
        self.regeneration > 0.0 && rim
    }

    /// The longer side of a cell where patches form, m.
    fn cell_m(&self) -> f64 {
        let (columns, rows) = (self.columns as f64, self.rows as f64);
        match self.shape {
            Shape::Sphere { radius_m, rim_deg } if rim_deg < 180.0 => {
                let rim = rim_deg.to_radians();
                (radius_m * rim / rows).max(radius_m * rim.sin() * std::f64::consts::TAU / columns)
            }
            Shape::Sphere { radius_m, .. } => {
                let around = self.drop_m.min(radius_m) * std::f64::consts::TAU / columns;
                (radius_m * std::f64::consts::PI / rows).max(around)
            }
            Shape::Plane { width_m, height_m } => (width_m / columns).max(height_m / rows),
        }
    }

    fn bounds(&self) -> Vec<(&'static str, f64, Least)> {
        self.listed()
            .into_iter()
            .filter(|(key, _)| !["seed", "columns", "rows", "drains_inside"].contains(key))
            .map(|(key, value)| (key, value, if POSITIVE.contains(&key) { Least::Above } else { Least::Zero }))
            .collect()
    }

    /// Every number by its name, in a fixed order: what a checkpoint remembers. A plane's width and height stand where
    /// a sphere has its radius and rim.
    pub fn listed(&self) -> Vec<(&'static str, f64)> {
        let shape = match self.shape {
            Shape::Sphere { radius_m, rim_deg } => [("radius_m", radius_m), ("rim_deg", rim_deg)],
            Shape::Plane { width_m, height_m } => [("width_m", width_m), ("height_m", height_m)],
        };
        let mut all = shape.to_vec();
        all.extend([
            ("columns", self.columns as f64),
            ("rows", self.rows as f64),
            ("step_s", self.step_s),
            ("thickness_m", self.thickness_m),
            ("noise", self.noise),
            ("noise_length_m", self.noise_length_m[0]),
            ("noise_length_m", self.noise_length_m[1]),
            ("density", self.density),
            ("gravity", self.gravity),
            ("viscosity", self.viscosity),
            ("surface_viscosity", self.surface_viscosity),
            ("elasticity", self.elasticity),
            ("tension", self.tension),
            ("surfactant_diffusivity", self.surfactant_diffusivity),
            ("surfactant_exchange_s", self.surfactant_exchange_s),
            ("air_density", self.air_density),
            ("air_viscosity", self.air_viscosity),
            ("air_length_m", self.air_length_m),
            ("air_speed", self.air_speed),
            ("air_mass", self.air_mass),
            ("wind", self.wind),
            ("eddies", self.eddies),
            ("evaporation", self.evaporation),
            ("drains_inside", f64::from(u8::from(self.drains_inside))),
            ("regeneration", self.regeneration),
            ("meniscus_m", self.meniscus_m),
            ("patch_m", self.patch_m),
            ("patch_ratio", self.patch_ratio),
            ("patch_s", self.patch_s),
            ("drop_m", self.drop_m),
            ("black_below_m", self.black_below_m),
            ("black_m", self.black_m),
            ("black_s", self.black_s),
            ("spots", self.spots),
            ("spot_below_m", self.spot_below_m),
            ("spot_m", self.spot_m),
            ("spot_speed", self.spot_speed),
            ("rupture_m", self.rupture_m),
            ("tolerance", self.tolerance),
            // Exact for every seed: its bits, not its value.
            ("seed", f64::from_bits(self.seed)),
        ]);
        all
    }
}

#[derive(PartialEq)]
enum Least {
    Above,
    Zero,
}

/// Numbers that must not be zero.
const POSITIVE: [&str; 21] = [
    "radius_m",
    "rim_deg",
    "width_m",
    "height_m",
    "step_s",
    "thickness_m",
    "noise_length_m",
    "density",
    "viscosity",
    "elasticity",
    "tension",
    "surfactant_exchange_s",
    "air_length_m",
    "meniscus_m",
    "patch_m",
    "patch_ratio",
    "patch_s",
    "black_s",
    "spot_m",
    "spot_speed",
    "tolerance",
];

/// Numbers that may be infinite.
const INFINITE: [&str; 2] = ["elasticity", "surfactant_exchange_s"];
