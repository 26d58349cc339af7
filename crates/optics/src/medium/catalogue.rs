//! The built-in media: pages of the refractiveindex.info database, kept whole under `data/media`
//! (`data/SOURCES.md` lists them), and what this crate adds to them.

use std::sync::{Arc, LazyLock, OnceLock};

use super::{Index, Inner, Medium, yaml};
use crate::{Complex64, OpticsError};

/// Where the index of a built-in medium comes from.
enum Origin {
    /// Exactly one at every wavelength.
    One,
    /// A page of the database.
    Page(&'static str),
    /// A page of the database without its table of k, for a medium that light may come from.
    Clear(&'static str),
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

use Origin::{Clear, One, Page};

static ENTRIES: &[Entry] = &[
    entry("vacuum", One, "Exactly 1."),
    entry("air", One, "Exactly 1; air-ciddor is the air that disperses."),
    entry("air-ciddor", Page(page!("air-ciddor.yml")), "Dry air at 15 C, 101.325 kPa, 450 ppm CO2."),
    entry("water", Page(page!("water.yml")), "Water at 20 C."),
    entry(
        "soap",
        Page(page!("water.yml")),
        "Taken as water at 20 C, from which a bubble solution differs by less than 0.004.",
    ),
    entry(
        "N-BK7",
        Clear(page!("N-BK7.yml")),
        "Taken as clear: the absorption of the catalogue, k < 4e-8 from 365 to 830 nm, is left out.",
    ),
    entry("SiO2", Page(page!("SiO2.yml")), "Fused silica at 20 C."),
    entry("MgF2", Page(page!("MgF2.yml")), "Crystal, ordinary ray."),
    entry("TiO2", Page(page!("TiO2.yml")), "Amorphous film; film density decides, rutile lies 0.2 higher."),
    entry("TiO2-siefke", Page(page!("TiO2-siefke.yml")), "Film of 350 nm by atomic layer deposition."),
    entry("rutile-o", Page(page!("rutile-o.yml")), "Rutile crystal (TiO2), ordinary ray."),
    entry("rutile-e", Page(page!("rutile-e.yml")), "Rutile crystal (TiO2), extraordinary ray."),
    entry("Si", Page(page!("Si.yml")), "Crystalline silicon at 300 K."),
    entry("Ti", Page(page!("Ti.yml")), ""),
    entry("Al", Page(page!("Al.yml")), ""),
    entry("Ag", Page(page!("Ag.yml")), ""),
    entry("Au", Page(page!("Au.yml")), ""),
    entry("Fe", Page(page!("Fe.yml")), ""),
    entry("Fe3O4", Page(page!("Fe3O4.yml")), "Magnetite; k of about 0.1 is low against other reports (0.2 to 0.6)."),
];

/// The names of the built-in media.
pub fn names() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&'static str>> = LazyLock::new(|| ENTRIES.iter().map(|entry| entry.name).collect());
    &NAMES
}

pub(super) fn named(name: &str) -> Result<Medium, OpticsError> {
    static MEDIA: LazyLock<Vec<OnceLock<Medium>>> = LazyLock::new(|| ENTRIES.iter().map(|_| OnceLock::new()).collect());
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
        Page(text) | Clear(text) => yaml::read(text, entry.name)?,
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
        _ => String::new(),
    };
    OpticsError::Unknown(format!("unknown medium {shown:?}{hint}. Known: {}", names().join(", ")))
}
