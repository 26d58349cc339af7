//! Every number that a film follows, with its unit; presets.

use crate::grid::Shape;
use iridesce_thickness::ThicknessError;

/// What a flowing film is made of and exposed to. SI units throughout; `docs/guide/living-films.md` has the sources.
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
    /// How far the frame of a plane leans from the vertical, degrees; a sphere has none.
    pub tilt_deg: f64,
    /// Greatest acceleration of a frame, or of a bubble's ring, that is shaken up and down along the film, m/s2.
    pub shake: f64,
    /// How often it is, Hz.
    pub shake_hz: f64,
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

/// Most cells of a grid: 4096 x 2048.
const MOST_CELLS: usize = 1 << 23;

/// Presets by name.
pub const PRESETS: [&str; 16] = [
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
];

/// Parameters that may change while a film flows, by the names of [`Parameters::listed`]. The others say what the
/// film is, or are counted from its start.
pub const CHANGEABLE: [&str; 10] = [
    "gravity_m_s2",
    "tilt_deg",
    "shake_m_s2",
    "shake_hz",
    "viscosity_pa_s",
    "wind_m_s",
    "eddies_m_s",
    "evaporation_nm_s",
    "humidity",
    "rupture_nm",
];

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
        let dome = Parameters {
            shape: Shape::Sphere { radius_m: 0.025, rim_deg: 90.0 },
            columns: 384,
            rows: 96,
            step_s: 5e-3,
            thickness_m: 450e-9,
            noise: 0.25,
            noise_length_m: [0.025 / 4.0, 0.025 / 40.0],
            density: 1000.0,
            gravity: 9.81,
            tilt_deg: 0.0,
            shake: 0.0,
            shake_hz: 5.0,
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
            rows: 192,
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
            thickness_m: 900e-9,
            noise_length_m: [0.15 / 4.0, 0.15 / 40.0],
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
        // The middle of a wide frame, 10 cm across before it repeats: its sides are out of sight.
        let vertical = Parameters {
            shape: Shape::Plane { width_m: 0.1, height_m: 0.06 },
            columns: 320,
            rows: 192,
            thickness_m: 700e-9,
            noise_length_m: [0.01, 0.001],
            evaporation: 10e-9,
            ..dome.clone()
        };
        // Previews: as fine as one core can show in real time at 30 pictures/s, steps of a picture or half of one. Patches
        // have 4 cells a radius; what regenerates does not depend on their size.
        let dome_preview = |columns: usize| Parameters {
            patch_m: 0.64 / columns as f64,
            noise_length_m: [0.025 / 4.0, 0.16 / columns as f64],
            step_s: if columns < 256 { 1.0 / 30.0 } else { 1.0 / 60.0 },
            tolerance: 1e-3,
            ..dome.clone().with_columns(columns)
        };
        let free_preview = |columns: usize| Parameters {
            patch_m: 0.77 / columns as f64,
            noise_length_m: [0.03 / 4.0, 0.19 / columns as f64],
            step_s: 1.0 / 30.0,
            tolerance: 1e-3,
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
                Ok(Parameters { patch_m: 2.2e-3, step_s: 1.0 / 30.0, tolerance: 1e-3, ..vertical.with_columns(192) })
            }
            "vertical-film" => Ok(vertical),
            "vertical-film-time-lapse" => Ok(Parameters { regeneration: 0.4, ..vertical }),
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
        match self.shape {
            Shape::Plane { .. } if self.tilt_deg > 90.0 => {
                return wrong("tilt_deg", format!("must be from 0 (vertical) to 90 (level), got {:?}", self.tilt_deg));
            }
            Shape::Sphere { .. } if self.tilt_deg != 0.0 => {
                return wrong(
                    "tilt_deg",
                    format!("must be 0 for a bubble, which has no frame, got {:?}", self.tilt_deg),
                );
            }
            _ => {}
        }
        for (key, value, least) in [("columns", self.columns, 16), ("rows", self.rows, 8)] {
            if !(least..=16384).contains(&value) {
                return wrong(key, format!("must be from {least} to 16384 cells, got {value}"));
            }
        }
        // Each cell takes about 250 bytes.
        if self.columns * self.rows > MOST_CELLS {
            let message =
                format!("times rows must be at most {MOST_CELLS} cells, got {} x {}", self.columns, self.rows);
            return wrong("columns", message);
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
                "noise_shortest_m",
                format!(
                    "must not exceed noise_longest_m, {:?}, got {:?}",
                    self.noise_length_m[0], self.noise_length_m[1]
                ),
            );
        }
        if self.black_m > self.black_below_m {
            return wrong(
                "black_nm",
                format!("must not exceed black_below_nm, {:?}, got {:?}", self.black_below_m * 1e9, self.black_m * 1e9),
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

    /// Gravity along the vertical of the film: less where the frame leans, m/s2.
    pub fn weight(&self) -> f64 {
        self.gravity * self.tilt_deg.to_radians().cos()
    }

    /// What a frame that is shaken up and down adds to gravity, m/s2, and the speed at which the air then comes down
    /// upon it, m/s; means from `time` to `time + dt`, s.
    pub fn shaken(&self, time: f64, dt: f64) -> [f64; 2] {
        let rate = std::f64::consts::TAU * self.shake_hz;
        // The acceleration is a cos(wt) upwards, the speed a sin(wt) / w.
        let mean = |integral: &dyn Fn(f64) -> f64| (integral(time + dt) - integral(time)) / dt;
        let speed = mean(&|t| -(rate * t).cos() / rate) / rate;
        [self.shake * mean(&|t| (rate * t).sin() / rate), self.shake * speed]
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

    /// Every number by the name it has outside, in the unit that the name says and in a fixed order: what a checkpoint
    /// remembers. A plane's width and height stand where a sphere has its radius and rim; the seed by its bits.
    pub fn listed(&self) -> Vec<(&'static str, f64)> {
        let shape = match self.shape {
            Shape::Sphere { radius_m, rim_deg } => [("radius_m", radius_m), ("rim_deg", rim_deg)],
            Shape::Plane { width_m, height_m } => [("width_m", width_m), ("height_m", height_m)],
        };
        let mut all = shape.to_vec();
        all.extend([("columns", self.columns as f64), ("rows", self.rows as f64)]);
        all.extend(self.numbers());
        all.push(("drains_inside", f64::from(u8::from(self.drains_inside))));
        // Exact for every seed: its bits, not its value.
        all.push(("seed", f64::from_bits(self.seed)));
        all
    }

    /// Changes one number by the name it has in [`Parameters::listed`]; `humidity` (0 to 1) stands for the evaporation of
    /// a bubble of this size into still air. Columns, rows and the seed are set by themselves.
    ///
    /// ```
    /// use iridesce_flow::Parameters;
    /// let mut film = Parameters::preset("late")?;
    /// film.set("humidity", 0.5)?;
    /// assert!((film.evaporation * 1e9 - 8.65).abs() < 0.01); // nm/s at a radius of 2.5 cm
    /// assert!(film.set("viscosty", 1e-3).unwrap_err().message.contains("viscosity_pa_s"));
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), ThicknessError> {
        match (name, &mut self.shape) {
            ("radius_m", Shape::Sphere { radius_m: place, .. })
            | ("rim_deg", Shape::Sphere { rim_deg: place, .. })
            | ("width_m", Shape::Plane { width_m: place, .. })
            | ("height_m", Shape::Plane { height_m: place, .. }) => *place = value,
            ("drains_inside", _) => self.drains_inside = value != 0.0,
            ("humidity", shape) => {
                if !(0.0..=1.0).contains(&value) {
                    let message = format!("must be a relative humidity from 0 to 1, got {value:?}");
                    return Err(ThicknessError { key: "humidity", message });
                }
                let size = match *shape {
                    Shape::Sphere { radius_m, .. } => radius_m,
                    Shape::Plane { width_m, height_m } => width_m.min(height_m) / 2.0,
                };
                // Diffusion from the outer face; the air within is damp. Vapour: 2.5e-5 m2/s, 17.3 g/m3 at 20 C.
                self.evaporation = 2.5e-5 * 17.3e-3 * (1.0 - value) / (self.density * size);
            }
            _ => {
                if !self.set_number(name, value) {
                    let known = self.listed().into_iter().map(|(name, _)| name);
                    let known: Vec<&str> = known.filter(|k| !["columns", "rows", "seed"].contains(k)).collect();
                    let message = format!("must be one of {}, humidity, got {name:?}", known.join(", "));
                    return Err(ThicknessError { key: "parameter", message });
                }
            }
        }
        Ok(())
    }
}

/// Names with units for fields in SI.
macro_rules! numbers {
    ($($name:literal = $($field:ident)? $([$list:ident $index:literal])? * $scale:literal,)*) => {
        impl Parameters {
            fn numbers(&self) -> Vec<(&'static str, f64)> {
                vec![$(($name, self$(.$field)?$(.$list[$index])? * $scale),)*]
            }

            fn set_number(&mut self, name: &str, value: f64) -> bool {
                match name {
                    $($name => self$(.$field)?$(.$list[$index])? = value / $scale,)*
                    _ => return false,
                }
                true
            }
        }
    };
}

numbers! {
    "step_s" = step_s * 1.0,
    "thickness_nm" = thickness_m * 1e9,
    "noise" = noise * 1.0,
    "noise_longest_m" = [noise_length_m 0] * 1.0,
    "noise_shortest_m" = [noise_length_m 1] * 1.0,
    "density_kg_m3" = density * 1.0,
    "gravity_m_s2" = gravity * 1.0,
    "tilt_deg" = tilt_deg * 1.0,
    "shake_m_s2" = shake * 1.0,
    "shake_hz" = shake_hz * 1.0,
    "viscosity_pa_s" = viscosity * 1.0,
    "surface_viscosity_pa_s_m" = surface_viscosity * 1.0,
    "elasticity_n_m" = elasticity * 1.0,
    "tension_n_m" = tension * 1.0,
    "surfactant_diffusivity_m2_s" = surfactant_diffusivity * 1.0,
    "surfactant_exchange_s" = surfactant_exchange_s * 1.0,
    "air_density_kg_m3" = air_density * 1.0,
    "air_viscosity_m2_s" = air_viscosity * 1.0,
    "air_length_m" = air_length_m * 1.0,
    "air_speed_m_s" = air_speed * 1.0,
    "air_mass_kg_m2" = air_mass * 1.0,
    "wind_m_s" = wind * 1.0,
    "eddies_m_s" = eddies * 1.0,
    "evaporation_nm_s" = evaporation * 1e9,
    "regeneration" = regeneration * 1.0,
    "meniscus_m" = meniscus_m * 1.0,
    "patch_m" = patch_m * 1.0,
    "patch_ratio" = patch_ratio * 1.0,
    "patch_s" = patch_s * 1.0,
    "drop_m" = drop_m * 1.0,
    "black_below_nm" = black_below_m * 1e9,
    "black_nm" = black_m * 1e9,
    "black_s" = black_s * 1.0,
    "spots_per_m2_s" = spots * 1.0,
    "spot_below_nm" = spot_below_m * 1e9,
    "spot_m" = spot_m * 1.0,
    "spot_speed_m_s" = spot_speed * 1.0,
    "rupture_nm" = rupture_m * 1e9,
    "tolerance" = tolerance * 1.0,
}

#[derive(PartialEq)]
enum Least {
    Above,
    Zero,
}

/// Numbers that must not be zero.
const POSITIVE: [&str; 23] = [
    "shake_hz",
    "radius_m",
    "rim_deg",
    "width_m",
    "height_m",
    "step_s",
    "thickness_nm",
    "noise_longest_m",
    "noise_shortest_m",
    "density_kg_m3",
    "viscosity_pa_s",
    "elasticity_n_m",
    "tension_n_m",
    "surfactant_exchange_s",
    "air_length_m",
    "meniscus_m",
    "patch_m",
    "patch_ratio",
    "patch_s",
    "black_s",
    "spot_m",
    "spot_speed_m_s",
    "tolerance",
];

/// Numbers that may be infinite.
const INFINITE: [&str; 2] = ["elasticity_n_m", "surfactant_exchange_s"];
