//! What a file says besides its numbers.

/// One fact about a picture that travels in its file.
#[derive(Debug, Clone, PartialEq)]
pub enum Fact {
    /// Words, a 64-bit seed, or a whole scene as JSON.
    Text(String),
    /// A count.
    Integer(i32),
    /// A measured number.
    Number(f64),
}

impl std::fmt::Display for Fact {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fact::Text(text) => f.write_str(text),
            Fact::Integer(value) => write!(f, "{value}"),
            Fact::Number(value) => write!(f, "{value}"),
        }
    }
}

/// Named facts in the order they are written. What varies from run to run (wall time, threads, dates) stays out of
/// files, so that the same render gives the same bytes.
pub type Facts = [(String, Fact)];
