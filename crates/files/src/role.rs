//! What the columns of a spectrometer's table are, by their names.

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    Reflectance,
    Transmittance,
    Absorbance,
    /// The spectrometer's answer without light.
    Dark,
    /// The lamp, by way of a mirror or a white tile.
    Lamp,
    /// Counts of the sample.
    Sample,
    /// A curve that a program computed.
    Computed,
    Unknown,
}

/// The roles of all columns; the one at `axis` is `Unknown`.
///
/// Beside Dark and Sample a column Ref, Reference or R is the lamp; by itself Ref or R is a reflectance.
pub fn roles(names: &[String], axis: usize) -> Vec<Role> {
    let mut roles: Vec<Role> = names.iter().map(|name| role(name)).collect();
    roles[axis] = Role::Unknown;
    let is_raw = roles.contains(&Role::Dark) && roles.contains(&Role::Sample);
    let has_full = names.iter().any(|name| first_word(name).starts_with("refl"));
    for (place, name) in names.iter().enumerate().filter(|&(place, _)| place != axis) {
        let word = first_word(name);
        let is_short = word == "ref" || word == "r";
        // A percent sign is never on counts.
        if roles[place] == Role::Reflectance && is_short && !name.contains('%') && is_raw {
            roles[place] = Role::Lamp;
        }
        // A lone "Ref" beside a full "Reflectance" is the lamp as well.
        if roles[place] == Role::Reflectance && word == "ref" && has_full {
            roles[place] = Role::Lamp;
        }
    }
    roles
}

fn first_word(name: &str) -> String {
    let lower = name.to_lowercase();
    lower.split(|c: char| !c.is_alphanumeric()).find(|word| !word.is_empty()).unwrap_or("").to_owned()
}

fn role(name: &str) -> Role {
    let lower = name.to_lowercase();
    let words: Vec<&str> = lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let starts = |starts: &[&str]| words.iter().any(|word| starts.iter().any(|start| word.starts_with(start)));
    let is = |names: &[&str]| words.first().is_some_and(|word| names.contains(word));
    if starts(&["calc", "fit", "model", "simul", "theor", "resid"]) {
        return Role::Computed;
    }
    if starts(&["dark", "dunkel", "background"]) {
        return Role::Dark;
    }
    if starts(&["reference", "referenz", "lamp", "baseline", "white"]) && !starts(&["refle"]) {
        return Role::Lamp;
    }
    if starts(&["refl"]) || is(&["r", "ref", "rs", "rp"]) {
        return Role::Reflectance;
    }
    if starts(&["trans"]) || is(&["t", "ts", "tp"]) {
        return Role::Transmittance;
    }
    if starts(&["absorb", "abs", "extinktion"]) || is(&["a", "od", "au"]) {
        return Role::Absorbance;
    }
    if starts(&["sample", "scope", "signal", "count", "intens", "raw", "probe", "irradiance"]) {
        return Role::Sample;
    }
    Role::Unknown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lamp_is_not_taken_for_the_reflectance() {
        let find = |names: &[&str]| roles(&names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>(), 0);
        use Role::{Absorbance, Computed, Dark, Lamp, Reflectance, Sample, Transmittance, Unknown};
        let units = ["Wave [nm]", "Dark [counts]", "Ref [counts]", "Sample [counts]", "Reflectance [%]"];
        assert_eq!(find(&units), [Unknown, Dark, Lamp, Sample, Reflectance]);
        assert_eq!(find(&["WL", "Dark", "R", "Scope", "Refl."]), [Unknown, Dark, Lamp, Sample, Reflectance]);
        assert_eq!(find(&["WL", "Ref"]), [Unknown, Reflectance]);
        assert_eq!(find(&["WL", "Ref", "Reflectance"]), [Unknown, Lamp, Reflectance]);
        assert_eq!(find(&["WL", "Dark", "Ref", "Refl. [%]"]), [Unknown, Dark, Lamp, Reflectance]);
        assert_eq!(find(&["nm", "%R", "%T", "Abs"]), [Unknown, Reflectance, Transmittance, Absorbance]);
        assert_eq!(find(&["nm", "Measured Reflectance", "Calculated Reflectance"]), [Unknown, Reflectance, Computed]);
    }
}
