//! Which vector instructions are used: the best that the machine has, or what `IRIDESCE_SIMD` caps them at.

use std::sync::OnceLock;

pub use fearless_simd::Level;
use fearless_simd::Simd;

use crate::argument::Argument;

/// The environment variable that caps the level.
pub const VARIABLE: &str = "IRIDESCE_SIMD";

/// The names a level can be asked for by, on any machine.
pub const NAMES: [&str; 5] = ["sse2", "sse4.2", "avx2", "avx512", "neon"];

/// A level was asked for that does not exist, or that this machine lacks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.argument())]
pub struct SimdError {
    /// What was asked for.
    pub asked: String,
    /// What could have been.
    pub has: Vec<&'static str>,
}

impl SimdError {
    /// The same in parts.
    pub fn argument(&self) -> Argument {
        let has = if self.has.is_empty() { "none".into() } else { self.has.join(", ") };
        let allowed = format!("one of {} (of these this machine has {has})", NAMES.join(", "));
        Argument::new(VARIABLE, allowed, format!("{:?}", self.asked))
    }
}

/// The level for all vector work of this process: what `IRIDESCE_SIMD` names (the variable is read once), else the best
/// that the machine has.
pub fn level() -> Result<Level, SimdError> {
    static LEVEL: OnceLock<Result<Level, SimdError>> = OnceLock::new();
    LEVEL.get_or_init(|| chosen(std::env::var(VARIABLE).ok().as_deref())).clone()
}

/// The same for what cannot fail: the best level where the variable is wrong. The call that began the work asks [`level`].
#[inline]
pub fn level_or_best() -> Level {
    level().unwrap_or_else(|_| Level::new())
}

/// The level of a name (nothing: the best).
fn chosen(asked: Option<&str>) -> Result<Level, SimdError> {
    let Some(asked) = asked.map(str::trim).filter(|name| !name.is_empty()) else { return Ok(Level::new()) };
    let found = levels().into_iter().find(|&level| name(level).eq_ignore_ascii_case(asked));
    found.ok_or_else(|| SimdError {
        asked: asked.chars().take(40).collect(),
        has: levels().into_iter().map(name).filter(|name| NAMES.contains(name)).collect(),
    })
}

/// What a level is called.
pub fn name(level: Level) -> &'static str {
    match level {
        #[cfg(target_arch = "aarch64")]
        Level::Neon(_) => "neon",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse2(_) => "sse2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse4_2(_) => "sse4.2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx2(_) => "avx2",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Avx512(_) => "avx512",
        _ => "scalar",
    }
}

/// Every level of SIMD that this machine has, from the plainest on: for tests and measurements.
pub fn levels() -> Vec<Level> {
    let best = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        let levels = [
            best.as_sse2().map(Simd::level),
            best.as_sse4_2().map(Simd::level),
            best.as_avx2().map(Simd::level),
            best.as_avx512().map(Simd::level),
        ];
        levels.into_iter().flatten().collect()
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        vec![best]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_chosen_by_name() {
        assert_eq!(name(chosen(None).unwrap()), name(Level::new()));
        assert_eq!(name(chosen(Some(" ")).unwrap()), name(Level::new()));
        for level in levels() {
            assert_eq!(name(chosen(Some(name(level))).unwrap()), name(level));
            assert_eq!(name(chosen(Some(&name(level).to_uppercase())).unwrap()), name(level));
        }
    }

    #[test]
    fn what_the_machine_lacks_is_refused() {
        let lacking = NAMES.into_iter().find(|name| levels().into_iter().all(|level| super::name(level) != *name));
        for wrong in ["mmx", "avx1024"].into_iter().chain(lacking) {
            let error = chosen(Some(wrong)).unwrap_err();
            let message = error.to_string();
            assert_eq!(error.asked, wrong);
            assert!(message.contains(VARIABLE) && message.contains(wrong) && message.contains("sse2"), "{message}");
        }
    }
}
