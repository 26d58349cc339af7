//! A file's own words in a message.

/// A user's text in quotes, for a message: what would steer a terminal is escaped, what is long is cut.
pub fn quoted(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some(_) => format!("{:?}...", text.chars().take(57).collect::<String>()),
        None => format!("{text:?}"),
    }
}
