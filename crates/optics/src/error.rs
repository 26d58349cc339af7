//! The one error type of this crate. Every message says what was wrong, what was given and what is allowed.

/// What can go wrong in optics; `Display` is the whole message a user sees.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A number or name outside what the function allows.
    #[error("{0}")]
    Argument(String),
    /// No medium, illuminant or observer of that name.
    #[error("{0}")]
    Unknown(String),
    /// A wavelength outside the data of a medium.
    #[error("{0}")]
    OutsideData(String),
    /// Something that cannot fit into memory.
    #[error("{0}")]
    Resource(String),
    /// Long work was asked to stop, and did.
    #[error("stopped")]
    Stopped,
    /// A text (CSV, YAML) that does not hold what it should.
    #[error("{0}")]
    Data(String),
}

impl From<iridesce_numerics::simd::SimdError> for OpticsError {
    fn from(error: iridesce_numerics::simd::SimdError) -> OpticsError {
        OpticsError::Argument(error.to_string())
    }
}

/// `at index (2, 0)`, as arrays are indexed; nothing for a scalar.
pub(crate) fn name_of(index: &[usize]) -> String {
    match index {
        [] => String::new(),
        [index] => format!("at index ({index},)"),
        place => {
            let indices: Vec<String> = place.iter().map(usize::to_string).collect();
            format!("at index ({})", indices.join(", "))
        }
    }
}

/// `at index (2, 0)`: where an element of an array stands that is counted in C order; nothing for a scalar.
pub fn place_name(shape: &[usize], mut element: usize) -> String {
    let mut index = vec![0; shape.len()];
    for (index, &length) in index.iter_mut().zip(shape).rev() {
        *index = element % length.max(1);
        element /= length.max(1);
    }
    name_of(&index)
}
