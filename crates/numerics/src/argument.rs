//! What is wrong with an argument: in parts for programs, in words for people.

use std::borrow::Cow;
use std::fmt;

/// An argument outside what is allowed. Every message about a single value is made here, from these parts, in one order.
///
/// ```
/// use iridesce_numerics::Argument;
/// let wrong = Argument::new("samples", "a whole number >= 1", 0);
/// assert_eq!(wrong.to_string(), "samples must be a whole number >= 1, got 0");
/// assert_eq!(wrong.at("in layer 2").to_string(), "samples must be a whole number >= 1, got 0 in layer 2");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Argument {
    /// Its name, as the caller wrote it: `thickness_nm`, `camera.fov_deg`.
    pub argument: Cow<'static, str>,
    /// What is allowed, to be read after "must be".
    pub allowed: Cow<'static, str>,
    /// What was given.
    pub given: String,
    /// Where in it: `at index (3, 7)`, `in layer 2`; empty where there is only one place.
    pub place: String,
}

/// Longer values are cut: a message is to be read.
const MOST_GIVEN: usize = 200;

impl Argument {
    /// `argument` must be `allowed`, but is `given`.
    pub fn new(
        argument: impl Into<Cow<'static, str>>,
        allowed: impl Into<Cow<'static, str>>,
        given: impl fmt::Display,
    ) -> Argument {
        Argument {
            argument: argument.into(),
            allowed: allowed.into(),
            given: shown(&given.to_string()),
            place: String::new(),
        }
    }

    /// The message without the argument's name: `must be >= 0 and finite, got -1.0`.
    pub fn rule(&self) -> String {
        let Argument { allowed, given, place, .. } = self;
        format!("must be {allowed}, got {given}{}{place}", if place.is_empty() { "" } else { " " })
    }

    /// `argument` must be one of `names`, each in quotes.
    ///
    /// ```
    /// use iridesce_numerics::Argument;
    /// let wrong = Argument::one_of("gamut", &["hue", "clip"], "huge");
    /// assert_eq!(wrong.to_string(), r#"gamut must be "hue" or "clip", got "huge""#);
    /// ```
    pub fn one_of(argument: impl Into<Cow<'static, str>>, names: &[&str], given: &str) -> Argument {
        let quoted: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
        let allowed = match quoted.split_last() {
            Some((last, [])) => last.clone(),
            Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
            None => "left out".to_owned(),
        };
        Argument::new(argument, allowed, format!("{given:?}"))
    }

    /// The same, at a place, or at a place within the one it has.
    #[must_use]
    pub fn at(mut self, place: impl AsRef<str>) -> Argument {
        if !self.place.is_empty() && !place.as_ref().is_empty() {
            self.place.push(' ');
        }
        self.place.push_str(place.as_ref());
        self
    }
}

impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.argument, self.rule())
    }
}

impl std::error::Error for Argument {}

/// Whether a letter is not seen itself, but turns the writing of others round or makes words look alike.
fn is_unseen(letter: char) -> bool {
    matches!(letter, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// A text of unknown origin as part of a message: control characters escaped (a terminal would obey them), and no more
/// than 200 characters.
///
/// ```
/// assert_eq!(iridesce_numerics::shown("a\u{1b}[2Jb\u{202e}"), "a\\u{1b}[2Jb\\u{202e}");
/// assert_eq!(iridesce_numerics::shown(&"x".repeat(300)).len(), 200);
/// ```
pub fn shown(text: &str) -> String {
    let mut shown = String::with_capacity(text.len().min(MOST_GIVEN));
    let mut count = 0;
    for letter in text.chars() {
        let escaped = if letter.is_control() || is_unseen(letter) {
            letter.escape_default().to_string()
        } else {
            letter.to_string()
        };
        count += escaped.chars().count();
        if count > MOST_GIVEN {
            let keep = shown.char_indices().nth(MOST_GIVEN - 3).map_or(shown.len(), |(place, _)| place);
            shown.truncate(keep);
            shown.push_str("...");
            break;
        }
        shown.push_str(&escaped);
    }
    shown
}

/// The index of an element of an array as Python writes it, `at index (3, 7)`; empty for a scalar.
///
/// ```
/// assert_eq!(iridesce_numerics::index_place(5, &[2, 4]), "at index (1, 1)");
/// assert_eq!(iridesce_numerics::index_place(5, &[9]), "at index (5,)");
/// assert_eq!(iridesce_numerics::index_place(0, &[]), "");
/// ```
pub fn index_place(flat: usize, shape: &[usize]) -> String {
    let mut rest = flat;
    let mut index = vec![0; shape.len()];
    for (index, &length) in index.iter_mut().zip(shape).rev() {
        *index = rest % length.max(1);
        rest /= length.max(1);
    }
    place_of(&index)
}

/// `at index (3, 7)`, as Python writes an index; empty for that of a scalar.
pub fn place_of(index: &[usize]) -> String {
    match index {
        [] => String::new(),
        [index] => format!("at index ({index},)"),
        index => {
            let words: Vec<String> = index.iter().map(usize::to_string).collect();
            format!("at index ({})", words.join(", "))
        }
    }
}

/// The numbers that an argument may be: finite, and within bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The argument.
    pub argument: &'static str,
    /// Its unit; told where the argument's name does not end in it. Empty for a plain number.
    pub unit: &'static str,
    /// Its lower bound; minus infinity where there is none.
    pub low: f64,
    /// Whether the lower bound itself is allowed.
    pub includes_low: bool,
    /// Its upper bound; infinity where there is none.
    pub high: f64,
    /// Whether the upper bound itself is allowed.
    pub includes_high: bool,
}

/// The thickness of a film or layer.
pub const THICKNESS_NM: Bounds = Bounds::at_least("thickness_nm", 0.0).in_unit("nm");
/// A vacuum wavelength.
pub const WAVELENGTH_NM: Bounds = Bounds::above("wavelength_nm", 0.0).in_unit("nm");
/// An angle of incidence, from the normal in the first medium.
pub const ANGLE_DEG: Bounds = Bounds::at_least("angle_deg", 0.0).below(90.0).in_unit("deg");

impl Bounds {
    /// Every finite number.
    pub const fn finite(argument: &'static str) -> Bounds {
        let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        Bounds { argument, unit: "", low, includes_low: false, high, includes_high: false }
    }

    /// From `low` on, `low` included.
    pub const fn at_least(argument: &'static str, low: f64) -> Bounds {
        Bounds { low, includes_low: true, ..Bounds::finite(argument) }
    }

    /// From `low` on, `low` excluded.
    pub const fn above(argument: &'static str, low: f64) -> Bounds {
        Bounds { low, ..Bounds::finite(argument) }
    }

    /// Below `high`.
    pub const fn below(self, high: f64) -> Bounds {
        Bounds { high, includes_high: false, ..self }
    }

    /// Up to `high`, `high` included.
    pub const fn at_most(self, high: f64) -> Bounds {
        Bounds { high, includes_high: true, ..self }
    }

    /// In a unit.
    pub const fn in_unit(self, unit: &'static str) -> Bounds {
        Bounds { unit, ..self }
    }

    /// The same range for an argument of another name.
    pub const fn named(self, argument: &'static str) -> Bounds {
        Bounds { argument, ..self }
    }

    /// Whether a value lies within.
    #[inline]
    pub fn holds(&self, value: f64) -> bool {
        value.is_finite()
            && (value > self.low || self.includes_low && value == self.low)
            && (value < self.high || self.includes_high && value == self.high)
    }

    /// What is allowed, in words: `>= 0 and finite`, `> 0 and <= 1`, `>= 0 and finite, in nm`.
    pub fn words(&self) -> String {
        let low = (self.low > f64::NEG_INFINITY)
            .then(|| format!("{} {}", if self.includes_low { ">=" } else { ">" }, self.low));
        let high = match self.high {
            f64::INFINITY => "finite".to_owned(),
            high => format!("{} {high}", if self.includes_high { "<=" } else { "<" }),
        };
        let mut words = low.map_or(high.clone(), |low| format!("{low} and {high}"));
        let named = self.argument.strip_suffix(self.unit).is_some_and(|rest| rest.ends_with('_'));
        if !self.unit.is_empty() && !named {
            words += ", in ";
            words += self.unit;
        }
        words
    }

    /// The value, where it lies within.
    #[inline]
    pub fn check(&self, value: f64) -> Result<f64, Argument> {
        if self.holds(value) { Ok(value) } else { Err(self.refuse(value)) }
    }

    /// The place of the first value that lies outside.
    pub fn first_outside(&self, values: &[f64]) -> Option<usize> {
        values.iter().position(|value| !self.holds(*value))
    }

    /// What is wrong with a value that lies outside.
    #[cold]
    pub fn refuse(&self, value: f64) -> Argument {
        Argument::new(self.argument, self.words(), format!("{value:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_has_argument_value_allowed_and_place() {
        let wrong = THICKNESS_NM.check(-1.5).unwrap_err().at(index_place(7, &[2, 4]));
        assert_eq!(
            (wrong.argument.as_ref(), wrong.given.as_str(), wrong.allowed.as_ref(), wrong.place.as_str()),
            ("thickness_nm", "-1.5", ">= 0 and finite", "at index (1, 3)")
        );
        assert_eq!(wrong.to_string(), "thickness_nm must be >= 0 and finite, got -1.5 at index (1, 3)");
        assert_eq!(ANGLE_DEG.check(90.0).unwrap_err().to_string(), "angle_deg must be >= 0 and < 90, got 90.0");
        assert_eq!(WAVELENGTH_NM.check(0.0).unwrap_err().to_string(), "wavelength_nm must be > 0 and finite, got 0.0");
        let top = THICKNESS_NM.named("top").check(f64::NAN).unwrap_err();
        assert_eq!(top.to_string(), "top must be >= 0 and finite, in nm, got NaN");
    }

    #[test]
    fn bounds_are_inside_where_they_are_said_to_be() {
        let share = Bounds::at_least("share", 0.0).at_most(1.0);
        for (value, inside) in [(0.0, true), (1.0, true), (-0.0, true), (1.0 + f64::EPSILON, false), (f64::NAN, false)]
        {
            assert_eq!(share.holds(value), inside, "{value}");
        }
        let open = Bounds::above("x", 0.0).below(1.0);
        assert!(!open.holds(0.0) && open.holds(5e-324) && !open.holds(1.0));
        assert!(!Bounds::finite("x").holds(f64::INFINITY) && Bounds::finite("x").holds(-1e308));
        assert_eq!(Bounds::finite("x").words(), "finite");
        assert_eq!(share.words(), ">= 0 and <= 1");
        assert_eq!(share.first_outside(&[0.5, 0.0, 2.0, -1.0]), Some(2));
    }

    #[test]
    fn values_of_any_length_and_any_character_fit_into_a_message() {
        let wrong = Argument::new("name", "a word", format!("{}\n\u{7}{}", "é".repeat(150), "b".repeat(10_000)));
        assert!(wrong.given.chars().count() <= 200 && wrong.given.ends_with("..."), "{}", wrong.given);
        assert!(wrong.given.contains("\\n\\u{7}") && !wrong.given.chars().any(char::is_control));
    }
}
