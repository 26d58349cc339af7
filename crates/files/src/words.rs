//! A file's own words in a message: short, and harmless to a terminal.

/// A text in quotation marks, at most 60 characters of it, control characters escaped.
pub fn quoted(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some(_) => format!("{:?}...", text.chars().take(57).collect::<String>()),
        None => format!("{text:?}"),
    }
}

/// A message made harmless: control characters escaped, and no more than 200 characters of any one run of a file's words.
///
/// Decoders of other people quote what they met as it stands; a terminal would obey it.
pub fn harmless(message: &str) -> String {
    let mut clean = String::with_capacity(message.len());
    for (count, letter) in message.chars().enumerate() {
        if count == 200 {
            clean.push_str("...");
            break;
        }
        if letter.is_control() {
            clean.extend(letter.escape_default());
        } else {
            clean.push(letter);
        }
    }
    clean
}

/// Names in quotation marks, the first dozen of them.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let mut words: Vec<String> = names.iter().take(12).map(|name| quoted(name)).collect();
    if names.len() > 12 {
        words.push(format!("and {} more", names.len() - 12));
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_raw_reaches_a_terminal() {
        assert_eq!(harmless("a\x1b[31mb\u{9b}c"), "a\\u{1b}[31mb\\u{9b}c");
        assert_eq!(harmless(&"x".repeat(5000)).len(), 203);
        assert_eq!(quoted("\x1b]0;x\x07"), "\"\\u{1b}]0;x\\u{7}\"");
        assert_eq!(quoted(&"y".repeat(99)), format!("\"{}\"...", "y".repeat(57)));
        let many: Vec<String> = (0..20).map(|i| i.to_string()).collect();
        assert!(listed(many.iter().map(String::as_str)).ends_with("\"11\", and 8 more"));
    }
}
