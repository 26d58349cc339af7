//! Every number that a film follows: reading, changing and checking them.

use std::fmt::Debug;

use crate::grid::{Shape, Sides};
use iridesce_thickness::{FlowField, ThicknessError, ThicknessMap};

mod presets;
mod table;

pub use presets::PRESETS;
pub use table::Parameters;

/// Most cells of a grid: 4096 x 2048.
const MOST_CELLS: usize = 1 << 23;

/// Parameters that may change while a film flows, by the names of [`Parameters::listed`]. The others say what the
/// film is, or are counted from its start.
pub const CHANGEABLE: [&str; 11] = [
    "gravity_m_s2",
    "tilt_deg",
    "shake_m_s2",
    "shake_hz",
    "viscosity_pa_s",
    "wind_m_s",
    "eddies_m_s",
    "speed",
    "evaporation_nm_s",
    "humidity",
    "rupture_nm",
];

impl Parameters {
    /// The same film on another number of columns, with rows to match: cells stay as square as they were.
    pub fn with_columns(self, columns: usize) -> Parameters {
        let rows = (self.rows as f64 * columns as f64 / self.columns as f64).round() as usize;
        Parameters { columns, rows, ..self }
    }

    /// A map of such a film as a field that is smooth between its cells, but for the edges of black film, which is what is
    /// thinner than `black_below_m` or, where it is told, what `black_share` says of each cell.
    ///
    /// ```
    /// use iridesce_flow::Parameters;
    /// use iridesce_thickness::ThicknessMap;
    /// let map = ThicknessMap::new(16, 1, [[12.0; 8], [200.0; 8]].concat())?;
    /// let field = Parameters::preset("late")?.field(map, None);
    /// assert_eq!((field.sample(0.49, 0.5).round(), field.sample(0.51, 0.5).round()), (12.0, 200.0));
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn field(&self, map: ThicknessMap, black_share: Option<Vec<f64>>) -> FlowField {
        let is_globe = matches!(self.shape, Shape::Sphere { .. });
        match black_share {
            Some(share) => FlowField::with_black_share(map, is_globe, &share, self.black_film_m() * 1e9),
            None => FlowField::with_black_film(map, is_globe, self.black_below_m * 1e9),
        }
    }

    /// Refuses what no film can be, and a grid that cannot hold it.
    pub fn check(&self) -> Result<(), ThicknessError> {
        for (key, value) in self.shape_numbers().into_iter().chain(self.numbers()) {
            if let Some(rule) = table::allowed(key).broken_by(value) {
                return wrong(key, rule.into(), &value);
            }
        }
        if self.time_order != 1.0 && self.time_order != 2.0 {
            return wrong("time_order", "1 or 2".into(), &self.time_order);
        }
        if self.tolerance > 0.1 {
            return wrong("tolerance", "at most 0.1".into(), &self.tolerance);
        }
        self.check_shape()?;
        self.check_grid()?;
        self.check_film()?;
        self.check_patches()
    }

    fn check_shape(&self) -> Result<(), ThicknessError> {
        match self.shape {
            Shape::Sphere { rim_deg, .. } if !(20.0..=160.0).contains(&rim_deg) && rim_deg != 180.0 => {
                wrong("rim_deg", "180 for a whole sphere, else from 20 to 160".into(), &rim_deg)
            }
            Shape::Plane { .. } if self.tilt_deg > 90.0 => {
                wrong("tilt_deg", "from 0 (vertical) to 90 (level)".into(), &self.tilt_deg)
            }
            Shape::Sphere { .. } if self.tilt_deg != 0.0 => {
                wrong("tilt_deg", "0 for a bubble, which has no frame".into(), &self.tilt_deg)
            }
            Shape::Sphere { .. } if self.bottom_meniscus_m != 0.0 => {
                let allowed = "0 for a bubble, whose rim has meniscus_m";
                wrong("bottom_meniscus_m", allowed.into(), &self.bottom_meniscus_m)
            }
            Shape::Sphere { radius_m, rim_deg } if rim_deg == 180.0 && self.drop_m > radius_m / 2.0 => {
                wrong("drop_m", format!("at most half the bubble's radius, {radius_m:?}"), &self.drop_m)
            }
            _ => Ok(()),
        }
    }

    fn check_grid(&self) -> Result<(), ThicknessError> {
        for (key, value, least) in [("columns", self.columns, 16), ("rows", self.rows, 8)] {
            if !(least..=16384).contains(&value) {
                return wrong(key, format!("from {least} to 16384 cells"), &value);
            }
        }
        // Each cell takes about 280 bytes.
        if self.columns * self.rows > MOST_CELLS {
            let allowed = format!("such that columns x rows is at most {MOST_CELLS} cells");
            return wrong("columns", allowed, &format_args!("{} x {}", self.columns, self.rows));
        }
        if !self.columns.is_multiple_of(2) {
            return wrong("columns", "even".into(), &self.columns);
        }
        Ok(())
    }

    /// How thick it is at first, and where it turns black.
    fn check_film(&self) -> Result<(), ThicknessError> {
        if self.noise > 0.35 {
            return wrong("noise", "at most 0.35 of the mean".into(), &self.noise);
        }
        if self.noise_shortest_m > self.noise_longest_m {
            let allowed = format!("at most noise_longest_m, {:?}", self.noise_longest_m);
            return wrong("noise_shortest_m", allowed, &self.noise_shortest_m);
        }
        if self.black_m > self.black_below_m {
            let allowed = format!("at most black_below_nm, {:?}", self.black_below_m * 1e9);
            return wrong("black_nm", allowed, &(self.black_m * 1e9));
        }
        if self.salt > 0.0 && self.black_film_m() > self.black_below_m {
            let [below_nm, black_nm] = [self.black_below_m, self.black_film_m()].map(|m| m * 1e9);
            let allowed = format!("0 or enough for black film below black_below_nm, {below_nm:?}");
            return wrong("salt_mol_m3", allowed, &format_args!("{:?}, which has {black_nm:.1} nm", self.salt));
        }
        Ok(())
    }

    fn check_patches(&self) -> Result<(), ThicknessError> {
        if !(0.0..1.0).contains(&self.patch_ratio) && self.regeneration > 0.0 {
            return wrong("patch_ratio", "below 1".into(), &self.patch_ratio);
        }
        let cell = self.cell_m();
        if self.patches() && self.patch_m < 4.0 * cell {
            let enough = (self.columns as f64 * 4.0 * cell / self.patch_m / 2.0).ceil() as usize * 2;
            let allowed = format!("at least {enough}, so that a patch of {:?} m has 4 cells a radius", self.patch_m);
            return wrong("columns", allowed, &self.columns);
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
            Shape::Plane { width_m, height_m, .. } => (width_m / columns).max(height_m / rows),
        }
    }

    fn shape_numbers(&self) -> [(&'static str, f64); 2] {
        match self.shape {
            Shape::Sphere { radius_m, rim_deg } => [("radius_m", radius_m), ("rim_deg", rim_deg)],
            Shape::Plane { width_m, height_m, .. } => [("width_m", width_m), ("height_m", height_m)],
        }
    }

    /// Every number by the name it has outside, in the unit that the name says and in a fixed order: what a checkpoint
    /// remembers. A plane's width and height stand where a sphere has its radius and rim; the seed by its bits.
    pub fn listed(&self) -> Vec<(&'static str, f64)> {
        let mut all = self.shape_numbers().to_vec();
        if let Shape::Plane { sides, .. } = self.shape {
            all.push(("sides", f64::from(u8::from(sides == Sides::Periodic))));
        }
        all.extend([("columns", self.columns as f64), ("rows", self.rows as f64)]);
        all.extend(self.numbers());
        all.push(("drains_inside", f64::from(u8::from(self.drains_inside))));
        // Exact for every seed: its bits, not its value.
        all.push(("seed", f64::from_bits(self.seed)));
        all
    }

    /// What lies beyond the sides of a plane, by name; none of a bubble.
    pub fn sides(&self) -> Option<&'static str> {
        match self.shape {
            Shape::Plane { sides, .. } => Some(sides.name()),
            Shape::Sphere { .. } => None,
        }
    }

    /// Puts something else beyond the sides of a plane: `menisci` or `periodic`.
    ///
    /// ```
    /// use iridesce_flow::Parameters;
    /// let mut film = Parameters::preset("vertical-film")?;
    /// film.set_sides("periodic")?;
    /// assert_eq!(film.sides(), Some("periodic"));
    /// assert!(film.set_sides("glass").is_err() && Parameters::preset("late")?.set_sides("menisci").is_err());
    /// # Ok::<(), iridesce_thickness::ThicknessError>(())
    /// ```
    pub fn set_sides(&mut self, name: &str) -> Result<(), ThicknessError> {
        let wrong = |allowed: &'static str| Err(ThicknessError::new("sides", allowed, format!("{name:?}")));
        let Shape::Plane { sides, .. } = &mut self.shape else {
            return wrong("left out for a bubble, which has none");
        };
        match Sides::NAMES.iter().find(|(known, _)| *known == name) {
            Some((_, found)) => *sides = *found,
            None => return wrong("\"menisci\" or \"periodic\""),
        }
        Ok(())
    }

    /// Changes one number by the name it has in [`Parameters::listed`]; `humidity` (0 to 1) stands for the evaporation of
    /// a bubble of this size into still air. Columns, rows and the seed are set by themselves.
    ///
    /// ```
    /// use iridesce_flow::Parameters;
    /// let mut film = Parameters::preset("late")?;
    /// film.set("humidity", 0.5)?;
    /// assert!((film.evaporation * 1e9 - 8.65).abs() < 0.01); // nm/s at a radius of 2.5 cm
    /// assert!(film.set("viscosty", 1e-3).unwrap_err().allowed.contains("viscosity_pa_s"));
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
                    let allowed = "a relative humidity from 0 to 1";
                    return Err(ThicknessError::new("humidity", allowed, format!("{value:?}")));
                }
                let size = match *shape {
                    Shape::Sphere { radius_m, .. } => radius_m,
                    Shape::Plane { width_m, height_m, .. } => width_m.min(height_m) / 2.0,
                };
                // Diffusion from the outer face; the air within is damp. Vapour: 2.5e-5 m2/s, 17.3 g/m3 at 20 C.
                self.evaporation = 2.5e-5 * 17.3e-3 * (1.0 - value) / (self.density * size);
            }
            _ => {
                if !self.set_number(name, value) {
                    let known = self.listed().into_iter().map(|(name, _)| name);
                    let known: Vec<&str> =
                        known.filter(|k| !["columns", "rows", "seed", "sides"].contains(k)).collect();
                    let nearest = known.iter().chain(&["humidity"]).map(|k| (strsim::jaro_winkler(k, name), *k));
                    let nearest = nearest.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(alike, _)| *alike > 0.8);
                    let meant = nearest.map_or(String::new(), |(_, k)| format!(" (perhaps {k} is meant)"));
                    let allowed = format!("one of {}, humidity{meant}", known.join(", "));
                    return Err(ThicknessError::new("parameter", allowed, format!("{name:?}")));
                }
            }
        }
        Ok(())
    }
}

/// The parameter `key` is not what is allowed.
fn wrong(key: &'static str, allowed: String, given: &dyn Debug) -> Result<(), ThicknessError> {
    Err(ThicknessError::new(key, allowed, format!("{given:?}")))
}
