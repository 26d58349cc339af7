//! Light sources: a continuous part over wavelength, and true lines.

use std::sync::{Arc, OnceLock};

use iridesce_numerics::shown;

use super::observer::{FIRST_NM, LAST_NM, Observer};
use super::table::parse_csv;
use crate::OpticsError;
use crate::spectrum::Tabulated;

/// Second radiation constant h c / k in nm K (exact SI constants of 2019).
const SECOND_RADIATION_NM_K: f64 = 1.438_776_877e7;
/// Temperatures taken by `"blackbody:T"`, K: outside them a lamp gives no visible light to speak of, or the sum overflows.
const BLACKBODY_K: (f64, f64) = (500.0, 1e7);
/// Correlated colour temperatures of the CIE daylight formula, K (CIE 15:2004).
const DAYLIGHT_K: (f64, f64) = (4000.0, 25000.0);

/// A light source: a continuous part (a table or a formula over wavelength) and true lines. Cheap to clone.
///
/// The scale is free: colour sums divide by the light's own Y.
#[derive(Debug, Clone, PartialEq)]
pub struct Illuminant {
    name: String,
    continuous: Continuous,
    lines: Arc<[(f64, f64)]>,
}

#[derive(Debug, Clone, PartialEq)]
enum Continuous {
    Dark,
    Table(Arc<Tabulated>),
    Blackbody { kelvin: f64 },
}

impl Illuminant {
    /// A light source by name.
    ///
    /// CIE tables at 5 nm, linear between, zero outside: `A B C D50 D55 D60 D65 D75 E FL1..FL12 FL3.1..FL3.15 HP1..HP5
    /// LED-B1..LED-B5 LED-BH1 LED-RGB1 LED-V1 LED-V2` (also `F2` for `FL2`; letter case does not matter).
    /// `blackbody:T` Planck's radiator of T kelvin; `daylight:CCT` the CIE daylight formula, 4000..25000 K;
    /// `lines:589.158*2,589.756` lines at vacuum wavelengths in nm with relative powers (1 unless given);
    /// `laser:632.99` one line. Lines lie within 360..830 nm, where the observers see.
    pub fn named(name: &str) -> Result<Illuminant, OpticsError> {
        let asked = name.trim();
        if let Some((kind, rest)) = asked.split_once(':') {
            let kind = kind.trim().to_ascii_lowercase();
            return match kind.as_str() {
                "blackbody" => Illuminant::blackbody(number(asked, rest)?),
                "daylight" => Illuminant::daylight(number(asked, rest)?),
                "lines" => Illuminant::from_lines(asked, &lines(asked, rest)?),
                "laser" => Illuminant::from_lines(asked, &[(number(asked, rest)?, 1.0)]),
                _ => Err(unknown(name)),
            };
        }
        let key = asked.to_ascii_uppercase();
        let key = match key.strip_prefix('F') {
            Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => format!("FL{rest}"),
            _ => key,
        };
        let (found, table) = cie_tables().iter().find(|(n, _)| *n == key).ok_or_else(|| unknown(name))?;
        Ok(Illuminant { name: found.clone(), continuous: Continuous::Table(table.clone()), lines: Arc::new([]) })
    }

    /// Relative spectral power as a table: vacuum nm ascending, power >= 0; linear between the rows, zero outside. `label` names
    /// it, also in errors.
    ///
    /// ```
    /// use iridesce_optics::color::Illuminant;
    /// let lamp = Illuminant::from_table(vec![400.0, 700.0], vec![1.0, 4.0], "lamp")?;
    /// assert_eq!(lamp.power(500.0), 2.0);
    /// # Ok::<(), iridesce_optics::OpticsError>(())
    /// ```
    pub fn from_table(wavelength_nm: Vec<f64>, power: Vec<f64>, label: &str) -> Result<Illuminant, OpticsError> {
        let rows = wavelength_nm.len();
        let is_ascending = wavelength_nm.windows(2).all(|pair| pair[0] < pair[1]);
        if !is_ascending || wavelength_nm.iter().any(|nm| nm.is_nan() || *nm <= 0.0) {
            return Err(OpticsError::Data(format!("{label}: wavelengths must be > 0 and ascend")));
        }
        if let Some(wrong) = power.iter().find(|power| power.is_nan() || **power < 0.0) {
            return Err(OpticsError::Data(format!("{label}: power must be >= 0, got {wrong}")));
        }
        let table = Tabulated::new(wavelength_nm, power).filter(|_| rows >= 2).ok_or_else(|| {
            OpticsError::Data(format!("{label}: an illuminant needs two rows wavelength_nm,power at least, got {rows}"))
        })?;
        let made =
            Illuminant { name: label.to_string(), continuous: Continuous::Table(Arc::new(table)), lines: Arc::new([]) };
        match made.white(Observer::Cie1931)[1] {
            y if y > 0.0 && y.is_finite() => Ok(made),
            _ => Err(OpticsError::Data(format!(
                "{label}: the illuminant gives no visible light within {FIRST_NM}..{LAST_NM} nm"
            ))),
        }
    }

    /// Planck's radiator: power proportional to lambda^-5 / (exp(c2 / (lambda T)) - 1), 100 at 560 nm.
    pub fn blackbody(kelvin: f64) -> Result<Illuminant, OpticsError> {
        let (low, high) = BLACKBODY_K;
        if !(low <= kelvin && kelvin <= high) {
            return Err(OpticsError::Argument(format!(
                "illuminant \"blackbody:T\": T must be within {low}..{high} K, got {kelvin}"
            )));
        }
        let continuous = Continuous::Blackbody { kelvin };
        Ok(Illuminant { name: format!("blackbody:{kelvin}"), continuous, lines: Arc::new([]) })
    }

    /// CIE daylight of a correlated colour temperature in kelvin (CIE 15:2004: S0 + M1 S1 + M2 S2 with M1 and
    /// M2 rounded to three decimals, as prescribed there), a 5 nm table over 300..830 nm.
    ///
    /// D65 is close to `daylight:6504`: its nominal 6500 K times 1.4388 / 1.4380.
    pub fn daylight(kelvin: f64) -> Result<Illuminant, OpticsError> {
        let (low, high) = DAYLIGHT_K;
        if !(low <= kelvin && kelvin <= high) {
            return Err(OpticsError::Argument(format!(
                "illuminant \"daylight:CCT\": the CIE daylight formula holds for {low}..{high} K, got {kelvin}"
            )));
        }
        let t = 1e3 / kelvin;
        let x = if kelvin <= 7000.0 {
            ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244063
        } else {
            ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237040
        };
        let y = (-3.0 * x + 2.870) * x - 0.275;
        let m = 0.0241 + 0.2562 * x - 0.7341 * y;
        let rounded = |v: f64| (v * 1e3).round() / 1e3;
        let m1 = rounded((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
        let m2 = rounded((0.0300 - 31.4424 * x + 30.0717 * y) / m);
        let csv = parse_csv(include_str!("../../data/illuminants/daylight_basis.csv"), "daylight_basis.csv")?;
        let (mut nm, mut power) = (Vec::new(), Vec::new());
        for (_, row) in csv.rows {
            let value = |i: usize| row[i].expect("our own table is full");
            nm.push(value(0));
            // At 4000 K the formula dips below zero in the near ultraviolet; power does not.
            power.push((value(1) + m1 * value(2) + m2 * value(3)).max(0.0));
        }
        let table = Tabulated::new(nm, power).expect("our own table is sound");
        let continuous = Continuous::Table(Arc::new(table));
        Ok(Illuminant { name: format!("daylight:{kelvin}"), continuous, lines: Arc::new([]) })
    }

    /// A lamp of lines only: (vacuum wavelength in nm within 360..830, relative power > 0).
    pub fn from_lines(name: &str, lines: &[(f64, f64)]) -> Result<Illuminant, OpticsError> {
        if lines.is_empty() {
            return Err(OpticsError::Argument(format!("illuminant \"{}\" needs one line at least", shown(name))));
        }
        for (place, &(nm, power)) in lines.iter().enumerate() {
            if !(FIRST_NM..=LAST_NM).contains(&nm) {
                return Err(OpticsError::Argument(format!(
                    "illuminant \"{}\": lines must lie within {FIRST_NM}..{LAST_NM} nm, got {nm} (line {})",
                    shown(name),
                    place + 1
                )));
            }
            if !(power > 0.0 && power.is_finite()) {
                return Err(OpticsError::Argument(format!(
                    "illuminant \"{}\": a line's power must be > 0 and finite, got {power} (line {})",
                    shown(name),
                    place + 1
                )));
            }
        }
        Ok(Illuminant { name: name.to_string(), continuous: Continuous::Dark, lines: lines.into() })
    }

    /// Its name: the CIE's own spelling, the text of a formula, or the label of a CSV text.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Relative power of the continuous part per nm of vacuum wavelength; zero outside its table.
    pub fn power(&self, wavelength_nm: f64) -> f64 {
        match &self.continuous {
            Continuous::Dark => 0.0,
            Continuous::Table(table) => table.at(wavelength_nm).unwrap_or(0.0),
            Continuous::Blackbody { kelvin } => 100.0 * planck_relative(wavelength_nm, *kelvin),
        }
    }

    /// The lines: (vacuum wavelength in nm, relative power in the unit of `power` times nm).
    pub fn lines(&self) -> &[(f64, f64)] {
        &self.lines
    }

    /// Whether there is a continuous part.
    pub fn has_continuum(&self) -> bool {
        self.continuous != Continuous::Dark
    }

    /// XYZ of the light itself, not normalised: plain sum over 360..830 nm at 1 nm, plus the lines.
    pub fn white(&self, observer: Observer) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        let mut add = |power: f64, cmf: [f64; 3]| {
            for i in 0..3 {
                xyz[i] += power * cmf[i];
            }
        };
        if self.has_continuum() {
            for (i, cmf) in observer.table().iter().enumerate() {
                add(self.power(FIRST_NM + i as f64), *cmf);
            }
        }
        for &(nm, power) in self.lines() {
            add(power, observer.at(nm));
        }
        xyz
    }
}

/// The names of the tabulated illuminants, in their table's order.
pub fn illuminant_names() -> impl Iterator<Item = &'static str> {
    cie_tables().iter().map(|(name, _)| name.as_str())
}

/// Planck's law relative to 560 nm; written with exp_m1 and differences of exponents so that neither end overflows.
fn planck_relative(wavelength_nm: f64, kelvin: f64) -> f64 {
    if !(wavelength_nm > 0.0 && wavelength_nm.is_finite()) {
        return 0.0;
    }
    let turn = |nm: f64| SECOND_RADIATION_NM_K / (nm * kelvin);
    let (here, reference) = (turn(wavelength_nm), turn(560.0));
    if here > 2000.0 {
        return 0.0; // below the smallest double, while the fifth power beside it may be infinite
    }
    // 1 / (e^a - 1) = e^-a / (1 - e^-a)
    (560.0 / wavelength_nm).powi(5) * (reference - here).exp() * (-reference).exp_m1() / (-here).exp_m1()
}

fn cie_tables() -> &'static [(String, Arc<Tabulated>)] {
    static TABLES: OnceLock<Vec<(String, Arc<Tabulated>)>> = OnceLock::new();
    TABLES.get_or_init(|| {
        let text = include_str!("../../data/illuminants/cie_illuminants.csv");
        let csv = parse_csv(text, "cie_illuminants.csv").expect("our own table reads");
        let column = |index: usize| {
            let points = csv.rows.iter().filter_map(|(_, row)| Some((row[0]?, row[index]?)));
            let (x, y) = points.unzip();
            Arc::new(Tabulated::new(x, y).expect("our own table is sound"))
        };
        csv.header.iter().enumerate().skip(1).map(|(i, name)| (name.clone(), column(i))).collect()
    })
}

fn number(whole: &str, text: &str) -> Result<f64, OpticsError> {
    text.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
        OpticsError::Argument(format!("illuminant \"{}\": \"{}\" is not a finite number", shown(whole), shown(text)))
    })
}

fn lines(whole: &str, text: &str) -> Result<Vec<(f64, f64)>, OpticsError> {
    text.split(',')
        .map(|item| match item.split_once('*') {
            Some((nm, power)) => Ok((number(whole, nm)?, number(whole, power)?)),
            None => Ok((number(whole, item)?, 1.0)),
        })
        .collect()
}

fn unknown(name: &str) -> OpticsError {
    // A name of thousands of letters would bury what is allowed.
    let named = match name.char_indices().nth(60) {
        Some((end, _)) => format!("{:?}...", &name[..end]),
        None => format!("{name:?}"),
    };
    OpticsError::Unknown(format!(
        "unknown illuminant {named}; known: {}, blackbody:T, daylight:CCT, lines:NM*POWER,..., laser:NM, or a CSV file",
        illuminant_names().collect::<Vec<_>>().join(" ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_the_published_figures() {
        let power = |name: &str, nm: f64| Illuminant::named(name).unwrap().power(nm);
        for name in ["A", "B", "C", "D50", "D55", "D65", "D75", "E"] {
            assert_eq!(
                power(name, 560.0),
                if name == "C" {
                    105.3
                } else if name == "B" {
                    102.8
                } else {
                    100.0
                },
                "{name}"
            );
        }
        assert_eq!(power("D65", 380.0), 49.9755);
        assert_eq!(power("D65", 382.5), (49.9755 + 52.3118) / 2.0);
        assert_eq!(power("A", 300.0), 0.930483);
        assert_eq!(power("FL2", 545.0), power("f2", 545.0));
        assert_eq!(Illuminant::named("f11").unwrap().name(), "FL11");
        assert_eq!(Illuminant::named("led-rgb1").unwrap().name(), "LED-RGB1");
        for (name, outside) in [("A", 780.1), ("D65", 299.0), ("E", 830.1), ("FL2", 379.9), ("D65", f64::NAN)] {
            assert_eq!(power(name, outside), 0.0);
        }
        assert_eq!(illuminant_names().count(), 50);
    }

    #[test]
    fn blackbody_is_planck() {
        let light = Illuminant::named("blackbody:2856").unwrap();
        let planck = |nm: f64| nm.powi(-5) / ((1.438776877e7 / (nm * 2856.0)).exp() - 1.0);
        for nm in [300.0, 380.0, 560.0, 780.0, 2000.0] {
            let wanted = 100.0 * planck(nm) / planck(560.0);
            assert!((light.power(nm) / wanted - 1.0).abs() < 1e-12);
        }
        assert!(Illuminant::named("blackbody:500").unwrap().white(Observer::Cie1931)[1] > 0.0);
        assert!(Illuminant::named("blackbody:1e7").unwrap().white(Observer::Cie1931)[1].is_finite());
        assert_eq!(light.power(0.0), 0.0);
        assert!(light.power(1e-3) == 0.0 && light.power(1e-80) == 0.0 && light.power(f64::NAN) == 0.0);
    }

    #[test]
    fn daylight_of_d65_is_d65() {
        let (table, formula) = (Illuminant::named("D65").unwrap(), Illuminant::named("daylight:6504").unwrap());
        for nm in (300..=780).step_by(5).map(f64::from) {
            let (a, b) = (table.power(nm), formula.power(nm));
            assert!((a - b).abs() < 0.06, "{nm}: {a} {b}");
        }
        let white = Illuminant::named("daylight:4000").unwrap().white(Observer::Cie1931);
        let x = white[0] / white.iter().sum::<f64>();
        assert!((x - 0.3823).abs() < 2e-4, "{x}");
    }

    #[test]
    fn lines_are_lines() {
        let sodium = Illuminant::named("lines:589.158*2,589.756").unwrap();
        assert_eq!(sodium.lines(), [(589.158, 2.0), (589.756, 1.0)]);
        assert_eq!(sodium.power(589.158), 0.0);
        let white = sodium.white(Observer::Cie1931);
        let wanted = 2.0 * Observer::Cie1931.at(589.158)[1] + Observer::Cie1931.at(589.756)[1];
        assert!((white[1] - wanted).abs() < 1e-15);
        assert_eq!(Illuminant::named("laser:632.99").unwrap().lines(), [(632.99, 1.0)]);
    }

    #[test]
    fn tables() {
        let made = |nm: &[f64], power: &[f64]| Illuminant::from_table(nm.to_vec(), power.to_vec(), "lamp.csv");
        let light = made(&[400.0, 500.0, 600.0], &[1.0, 3.0, 0.0]).unwrap();
        assert_eq!((light.power(450.0), light.power(399.0), light.name()), (2.0, 0.0, "lamp.csv"));
        for (nm, power, wanted) in [
            (&[][..], &[][..], "two rows"),
            (&[400.0], &[1.0], "two rows"),
            (&[400.0, 400.0], &[1.0, 2.0], "ascend"),
            (&[500.0, 400.0], &[1.0, 2.0], "ascend"),
            (&[-5.0, 400.0], &[1.0, 2.0], "> 0"),
            (&[400.0, 500.0], &[1.0, -2.0], ">= 0"),
            (&[400.0, 500.0], &[1.0, f64::NAN], ">= 0"),
            (&[100.0, 200.0], &[1.0, 2.0], "no visible light"),
            (&[400.0, 500.0], &[0.0, 0.0], "no visible light"),
            (&[400.0, 500.0], &[1e308, 1e308], "no visible light"),
        ] {
            let message = made(nm, power).unwrap_err().to_string();
            assert!(message.contains(wanted), "{nm:?}: {message}");
        }
    }

    #[test]
    fn refuses_what_is_no_light() {
        for (name, wanted) in [
            ("", "unknown illuminant"),
            ("D66", "D65"),
            ("FL13", "unknown"),
            ("torch:3", "unknown"),
            ("blackbody:0", "500"),
            ("blackbody:hot", "not a finite number"),
            ("blackbody:nan", "not a finite number"),
            ("daylight:3999", "4000..25000"),
            ("daylight:inf", "not a finite number"),
            ("lines:", "not a finite number"),
            ("lines:589*0", "> 0"),
            ("lines:589*-1", "> 0"),
            ("lines:500,1064", "line 2"),
            ("laser:", "not a finite number"),
            ("laser:100", "360..830"),
        ] {
            let message = Illuminant::named(name).unwrap_err().to_string();
            assert!(message.contains(wanted), "{name:?}: {message}");
        }
    }
}
