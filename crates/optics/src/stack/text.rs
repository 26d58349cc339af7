//! Stacks as one line of text: `air / MgF2 100 / N-BK7 1e6 incoherent / air`.

use crate::{Complex64, Medium, OpticsError};

const EXAMPLE: &str = "\"air / soap 320 / air\"";

/// A stack as it was written; a layer may leave its thickness open.
#[derive(Debug, Clone)]
pub struct StackText {
    /// First medium, layers, last medium.
    pub media: Vec<Medium>,
    /// One thickness a layer, nm; 0 where it is open.
    pub thickness_nm: Vec<f64>,
    /// One entry a layer; `false` for an incoherent slab.
    pub coherent: Vec<bool>,
    /// One entry a layer: its thickness was left out, or written `?`.
    pub open: Vec<bool>,
}

impl StackText {
    /// Reads items separated by ` / `: a name, a number or `n+kj`; layers add their nm, or `?`, and may add `incoherent`.
    ///
    /// ```
    /// use iridesce_optics::stack::StackText;
    /// let text = StackText::parse("air / soap 320 / 1.5+0.1j")?;
    /// assert_eq!((text.media.len(), text.thickness_nm[0]), (3, 320.0));
    /// assert!(StackText::parse("air / soap ? / air")?.open[0]);
    /// assert!(StackText::parse("air / soap thick / air").is_err());
    /// # Ok::<(), iridesce_optics::OpticsError>(())
    /// ```
    pub fn parse(text: &str) -> Result<StackText, OpticsError> {
        let bad = |message: String| Err(OpticsError::Argument(message));
        // A slash separates only where it stands alone.
        let mut items: Vec<Vec<&str>> = vec![Vec::new()];
        for word in text.split_whitespace() {
            match (word, items.last_mut()) {
                ("/", _) => items.push(Vec::new()),
                (word, Some(item)) => item.push(word),
                (_, None) => {}
            }
        }
        if items.len() < 2 {
            return bad(format!("a stack needs two or more items separated by \" / \", as in {EXAMPLE}, got {text:?}"));
        }
        let last = items.len() - 1;
        let mut read = StackText { media: vec![], thickness_nm: vec![], coherent: vec![], open: vec![] };
        for (place, words) in items.iter().enumerate() {
            let [name, rest @ ..] = words.as_slice() else {
                return bad(format!("item {} of the stack is empty; it should look like {EXAMPLE}", place + 1));
            };
            let wherever = format!("item {} of the stack, {:?}", place + 1, words.join(" "));
            read.media.push(medium(name, &wherever)?);
            if place == 0 || place == last {
                if !rest.is_empty() {
                    return bad(format!("{wherever}: the first and the last item are a medium without thickness"));
                }
                continue;
            }
            let (thickness, tail) = match rest {
                [] => (None, rest),
                ["incoherent", ..] => (None, rest),
                ["?", tail @ ..] => (None, tail),
                [number, tail @ ..] => match number.parse::<f64>() {
                    Ok(nm) if nm.is_finite() && nm >= 0.0 => (Some(nm), tail),
                    Ok(nm) => return bad(format!("{wherever}: the thickness in nm must be >= 0 and finite, got {nm}")),
                    Err(_) => {
                        return bad(format!("{wherever}: the thickness in nm must be a number, got {number:?}"));
                    }
                },
            };
            if !matches!(tail, [] | ["incoherent"]) {
                return bad(format!(
                    "{wherever}: after the thickness only \"incoherent\" may follow, got {}",
                    tail.join(" ")
                ));
            }
            read.thickness_nm.push(thickness.unwrap_or(0.0));
            read.coherent.push(tail.is_empty());
            read.open.push(thickness.is_none());
        }
        Ok(read)
    }
}

/// A name, or an index where the word begins like a number.
fn medium(word: &str, wherever: &str) -> Result<Medium, OpticsError> {
    if !word.starts_with(|first: char| first.is_ascii_digit() || "+-.".contains(first)) {
        return Medium::named(word);
    }
    let index = complex(word)
        .ok_or_else(|| OpticsError::Argument(format!("{wherever}: an index is written n or n+kj, got {word:?}")))?;
    Medium::constant(index)
}

/// `n`, `kj`, `n+kj` or `n-kj`.
fn complex(word: &str) -> Option<Complex64> {
    let Some(body) = word.strip_suffix(['j', 'J']) else {
        return word.parse().ok().map(|n| Complex64::new(n, 0.0));
    };
    // The sign between the parts is the last one that belongs to no exponent.
    let bytes = body.as_bytes();
    let sign = (1..bytes.len()).rev().find(|&i| b"+-".contains(&bytes[i]) && !b"eE".contains(&bytes[i - 1]));
    let (n, k) = body.split_at(sign.unwrap_or(0));
    let n = if n.is_empty() { 0.0 } else { n.parse().ok()? };
    let k = match k {
        "+" | "" => 1.0,
        "-" => -1.0,
        k => k.parse().ok()?,
    };
    Some(Complex64::new(n, k))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_read_as_python_writes_them() {
        let c = |re, im| Some(Complex64::new(re, im));
        for (word, expected) in [
            ("1.33", c(1.33, 0.0)),
            ("1.5+0.1j", c(1.5, 0.1)),
            ("2-3j", c(2.0, -3.0)),
            ("3j", c(0.0, 3.0)),
            ("1e1+2e-3j", c(10.0, 0.002)),
            ("2+j", c(2.0, 1.0)),
            ("1.5+", None),
            ("1+2i", None),
            ("-", None),
        ] {
            assert_eq!(complex(word), expected, "{word}");
        }
    }

    #[test]
    fn what_is_no_stack_is_told_with_its_place() {
        for (text, expected) in [
            ("air", "two or more items"),
            ("air / / air", "item 2 of the stack is empty"),
            ("air 3 / air", "without thickness"),
            ("air / soap 3 thick / air", "only \"incoherent\" may follow"),
            ("air / soap -3 / air", ">= 0"),
            ("air / soap inf / air", "finite"),
            ("air / sope 3 / air", "soap"),
            ("air / 1.5k 3 / air", "n+kj"),
        ] {
            let message = StackText::parse(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn layers_may_be_open_and_slabs_incoherent() {
        let read = StackText::parse("air / soap / glass? / air").map(|read| read.media.len());
        assert!(read.is_err(), "a question mark belongs to the thickness, not to the name");
        let read = StackText::parse(" air / soap / N-BK7 1e6 incoherent / TiO2 ? incoherent / air ").unwrap();
        assert_eq!(read.open, [true, false, true]);
        assert_eq!(read.coherent, [true, false, false]);
        assert_eq!(read.thickness_nm, [0.0, 1e6, 0.0]);
    }
}
