//! The built-in media: pages of the refractiveindex.info database, kept whole under `data/media`
//! (`data/SOURCES.md` lists them), and what this crate adds to them.

use std::sync::{Arc, LazyLock, OnceLock};

use super::rule::Rule;
use super::value::{Index, Inner, Medium};
use super::{mixture, yaml};
use crate::{Complex64, OpticsError};

/// Where the index of a built-in medium comes from.
enum Origin {
    /// Exactly one at every wavelength.
    One,
    /// A page of the database.
    Page(&'static str),
    /// A page of the database without its table of k, for a medium that light may come from.
    Clear(&'static str),
    /// Glycerol in water, and the density of the solution at 20 C, g/cm^3: checked against two sources in
    /// `data/media/SOURCES.md`.
    Glycerol { mass_fraction: f64, density: f64 },
}

struct Entry {
    name: &'static str,
    origin: Origin,
    /// What a user should know beyond the page's own comments.
    note: &'static str,
}

macro_rules! page {
    ($file:literal) => {
        include_str!(concat!("../../data/media/", $file))
    };
}

const fn entry(name: &'static str, origin: Origin, note: &'static str) -> Entry {
    Entry { name, origin, note }
}

use Origin::{Clear, Glycerol, One, Page};

const GLYCEROL_NOTE: &str =
    "Bubble solution with glycerol, per cent by mass in the name: Lorentz-Lorenz with the measured density at 20 C.";

/// Densities, g/cm^3, at the temperatures of the pages: water 20 C, glycerol 25 C (`data/media/SOURCES.md`).
const WATER_DENSITY: f64 = 0.9982;
const GLYCEROL_DENSITY: f64 = 1.2580;

static ENTRIES: &[Entry] = &[
    entry("vacuum", One, "Exactly 1."),
    entry("air", One, "Exactly 1; air-ciddor is the air that disperses."),
    entry("air-ciddor", Page(page!("air-ciddor.yml")), ""),
    entry("water", Page(page!("water.yml")), ""),
    entry("soap", Page(page!("water.yml")), "Taken as water, from which a bubble solution differs by less than 0.004."),
    entry(
        "N-BK7",
        Clear(page!("N-BK7.yml")),
        "Taken as clear: the absorption of the catalogue, k < 4e-8 from 365 to 830 nm, is left out.",
    ),
    entry("SiO2", Page(page!("SiO2.yml")), ""),
    entry("MgF2", Page(page!("MgF2.yml")), "Crystal."),
    entry("TiO2", Page(page!("TiO2.yml")), "Amorphous film; film density decides, rutile lies 0.2 higher."),
    // A second film of TiO2, from 120 nm to 125 um: 14 kB of the 450 that the page may load.
    #[cfg(not(target_family = "wasm"))]
    entry("TiO2-siefke", Page(page!("TiO2-siefke.yml")), ""),
    entry("rutile-o", Page(page!("rutile-o.yml")), "Rutile (TiO2) crystal."),
    entry("rutile-e", Page(page!("rutile-e.yml")), "Rutile (TiO2) crystal."),
    entry("Si", Page(page!("Si.yml")), "Crystalline silicon."),
    entry("Ti", Page(page!("Ti.yml")), ""),
    entry("Al", Page(page!("Al.yml")), ""),
    entry("Ag", Page(page!("Ag.yml")), ""),
    entry("Au", Page(page!("Au.yml")), ""),
    entry("Fe", Page(page!("Fe.yml")), ""),
    entry("Fe3O4", Page(page!("Fe3O4.yml")), "Magnetite; k of about 0.1 is low against other reports (0.2 to 0.6)."),
    // Glasses.
    entry(
        "soda-lime",
        Clear(page!("soda-lime.yml")),
        "Taken as clear: the absorption of the page, k < 3e-6 up to 830 nm, is left out.",
    ),
    entry("F2", Clear(page!("F2.yml")), "Taken as clear: the absorption of the catalogue is left out."),
    entry(
        "N-SF11",
        Clear(page!("N-SF11.yml")),
        "Dense flint glass; taken as clear: the absorption of the catalogue is left out.",
    ),
    // Crystals and films that let light through.
    entry("MgF2-e", Page(page!("MgF2-e.yml")), "Crystal."),
    entry("CaF2", Page(page!("CaF2.yml")), "Fluorite."),
    entry("sapphire-o", Page(page!("sapphire-o.yml")), ""),
    entry("sapphire-e", Page(page!("sapphire-e.yml")), ""),
    entry("Al2O3", Page(page!("Al2O3.yml")), "Amorphous film; its absorption is not given."),
    entry("anatase", Page(page!("anatase.yml")), ""),
    entry("Ta2O5", Page(page!("Ta2O5.yml")), ""),
    entry("Nb2O5", Page(page!("Nb2O5.yml")), ""),
    entry("HfO2", Page(page!("HfO2.yml")), ""),
    entry("ZrO2", Page(page!("ZrO2.yml")), ""),
    entry("Y2O3", Page(page!("Y2O3.yml")), "Crystal."),
    entry("ZnO", Page(page!("ZnO.yml")), "Crystal."),
    entry("ZnS", Page(page!("ZnS.yml")), ""),
    entry("ZnS-film", Page(page!("ZnS-film.yml")), ""),
    entry("Si3N4", Page(page!("Si3N4.yml")), "Film."),
    entry("SiO", Page(page!("SiO.yml")), "Film, evaporated."),
    entry("ITO", Page(page!("ITO.yml")), "Indium tin oxide."),
    entry("diamond", Page(page!("diamond.yml")), ""),
    // Semiconductors.
    entry("Si-aspnes", Page(page!("Si-aspnes.yml")), "Crystalline silicon; Si is the newer table."),
    entry("Ge", Page(page!("Ge.yml")), ""),
    entry("GaAs", Page(page!("GaAs.yml")), ""),
    // Metals, their oxides and nitrides.
    entry("Cu", Page(page!("Cu.yml")), ""),
    entry("Cr", Page(page!("Cr.yml")), ""),
    entry("Ni", Page(page!("Ni.yml")), ""),
    entry("V", Page(page!("V.yml")), ""),
    entry("Pt", Page(page!("Pt.yml")), ""),
    entry("W", Page(page!("W.yml")), ""),
    entry("Nb", Page(page!("Nb.yml")), ""),
    entry("Zr", Page(page!("Zr.yml")), ""),
    entry("brass", Page(page!("brass.yml")), ""),
    entry("steel", Page(page!("steel.yml")), ""),
    entry("TiN", Page(page!("TiN.yml")), ""),
    entry("Fe2O3", Page(page!("Fe2O3.yml")), "k falls below 0 in the far infrared, as published."),
    // Liquids and polymers.
    entry("water-hale", Page(page!("water-hale.yml")), "Has absorption; water has none."),
    entry("acetone", Page(page!("acetone.yml")), ""),
    entry("ethanol", Page(page!("ethanol.yml")), ""),
    entry("glycerol", Page(page!("glycerol.yml")), ""),
    entry("cyclohexane", Page(page!("cyclohexane.yml")), ""),
    entry("toluene", Page(page!("toluene.yml")), ""),
    entry("oleic-acid", Page(page!("oleic-acid.yml")), "The chief acid of olive oil, whose n_D is 1.467."),
    entry("PDMS", Page(page!("PDMS.yml")), ""),
    entry("PMMA", Page(page!("PMMA.yml")), "Acrylic glass."),
    entry("polystyrene", Page(page!("polystyrene.yml")), ""),
    entry("polycarbonate", Page(page!("polycarbonate.yml")), ""),
    entry("soap-glycerol-10", Glycerol { mass_fraction: 0.1, density: 1.0221 }, GLYCEROL_NOTE),
    entry("soap-glycerol-20", Glycerol { mass_fraction: 0.2, density: 1.0469 }, GLYCEROL_NOTE),
    entry("soap-glycerol-30", Glycerol { mass_fraction: 0.3, density: 1.0727 }, GLYCEROL_NOTE),
    entry("soap-glycerol-40", Glycerol { mass_fraction: 0.4, density: 1.0993 }, GLYCEROL_NOTE),
    entry("soap-glycerol-50", Glycerol { mass_fraction: 0.5, density: 1.1263 }, GLYCEROL_NOTE),
    entry("soap-glycerol-60", Glycerol { mass_fraction: 0.6, density: 1.1538 }, GLYCEROL_NOTE),
];

/// Window glass, where nobody says which.
const ALSO_CALLED: (&str, &str) = ("glass", "soda-lime");

/// The names of the built-in media.
pub fn names() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&'static str>> = LazyLock::new(|| ENTRIES.iter().map(|entry| entry.name).collect());
    &NAMES
}

pub(super) fn named(name: &str) -> Result<Medium, OpticsError> {
    static MEDIA: LazyLock<Vec<OnceLock<Medium>>> = LazyLock::new(|| ENTRIES.iter().map(|_| OnceLock::new()).collect());
    let name = if name == ALSO_CALLED.0 { ALSO_CALLED.1 } else { name };
    let Some(place) = ENTRIES.iter().position(|entry| entry.name == name) else { return Err(unknown(name)) };
    if let Some(medium) = MEDIA[place].get() {
        return Ok(medium.clone());
    }
    let medium = build(&ENTRIES[place])?;
    Ok(MEDIA[place].get_or_init(|| medium).clone())
}

fn build(entry: &Entry) -> Result<Medium, OpticsError> {
    let medium = match entry.origin {
        One => Medium::constant(Complex64::new(1.0, 0.0))?,
        Page(text) | Clear(text) => yaml::read_own(text, entry.name)?,
        Glycerol { mass_fraction, density } => mixture::mix(
            (named("water")?, (1.0 - mass_fraction) * density / WATER_DENSITY),
            (named("glycerol")?, mass_fraction * density / GLYCEROL_DENSITY),
            Rule::LorentzLorenz,
        ),
    };
    let mut inner = Arc::into_inner(medium.0).expect("just built, held once");
    inner.name = entry.name.to_owned();
    inner.builtin = true;
    if matches!(entry.origin, One) {
        inner.source = "by definition".to_owned();
    }
    if let (Clear(_), Index::Data { n, k }) = (&entry.origin, &mut inner.index) {
        *k = None;
        inner.range_nm = Some(n.range_nm());
    }
    inner.note = [entry.note, &inner.note].join(" ").trim().to_owned();
    Ok(Medium(Arc::new(Inner { ..inner })))
}

fn unknown(name: &str) -> OpticsError {
    let lower = name.to_lowercase();
    let distance = |known: &&str| strsim::damerau_levenshtein(&known.to_lowercase(), &lower);
    // Long texts are no slips of the finger, and the distance of two texts costs the product of their lengths.
    let nearest = if name.len() > 64 { None } else { names().iter().min_by_key(|known| distance(known)) };
    let shown: String = name.chars().take(64).collect();
    let hint = match nearest {
        Some(known) if distance(known) <= 1.max(known.len() / 3) => format!("; did you mean \"{known}\"?"),
        _ => format!(". Known: {}", names().join(", ")),
    };
    OpticsError::Unknown(format!("unknown medium {shown:?}{hint}"))
}

#[cfg(test)]
mod tests {
    use super::{Clear, ENTRIES, Page, named, names, yaml};

    #[test]
    fn glass_is_window_glass() {
        assert_eq!(named("glass").unwrap().name(), "soda-lime");
        assert!(!names().contains(&"glass"), "a name of its own needs no other");
        assert!(named("Glass").is_err());
    }

    #[test]
    fn own_pages_are_read_as_a_reader_of_yaml_does() {
        let mut pages = 0;
        for entry in ENTRIES {
            let (Page(text) | Clear(text)) = entry.origin else { continue };
            assert_eq!(yaml::read_own(text, entry.name), yaml::read(text, entry.name), "{}", entry.name);
            pages += 1;
        }
        assert!(pages > 60, "{pages}");
    }
}
