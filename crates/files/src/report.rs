//! What a reader did with a file: one value for spectra, lamps, index files, maps, environments and photographs.

/// One thing that was taken from a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Taken {
    /// What it is used as: `wavelength`, `reflectance`, `n`, `thickness`, `red`.
    pub role: String,
    /// The column, channel or page, as the file calls it; `column 2` where it has no name.
    pub name: String,
    /// The unit its numbers were read in: `nm`, `cm-1`, `percent`, `ratio`, `counts`.
    pub unit: String,
    /// Why it was taken so: `its own name`, `unit=`, `a guess by the size of the numbers`.
    pub why: String,
}

/// How a file was understood. Nothing is decided in silence: what was chosen, why, and what was left out.
///
/// ```
/// use iridesce_files::ReadReport;
/// let mut report = ReadReport::new("CSV");
/// report.take("wavelength", "Wave [nm]", "nm", "its own name");
/// report.drop("2 values are missing");
/// assert_eq!(report.to_string(), "CSV; wavelength: \"Wave [nm]\" in nm (its own name); left out: 2 values are missing");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ReadReport {
    /// The format, with encoding and dialect where it is a text.
    pub format: String,
    /// Columns, channels or pages that were taken.
    pub taken: Vec<Taken>,
    /// What was left out, in words.
    pub dropped: Vec<String>,
    /// What else a user should know: guesses, conversions.
    pub notes: Vec<String>,
}

impl ReadReport {
    /// A report of a file of that format.
    pub fn new(format: impl Into<String>) -> ReadReport {
        ReadReport { format: format.into(), ..ReadReport::default() }
    }

    /// Adds something that was taken.
    pub fn take(&mut self, role: &str, name: &str, unit: &str, why: &str) {
        let [role, name, unit, why] = [role, name, unit, why].map(str::to_owned);
        self.taken.push(Taken { role, name, unit, why });
    }

    /// Adds something that was left out.
    pub fn drop(&mut self, what: impl Into<String>) {
        self.dropped.push(what.into());
    }

    /// Adds something to know.
    pub fn note(&mut self, what: impl Into<String>) {
        self.notes.push(what.into());
    }

    /// Everything a reader should be told about guesses and losses, one sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let mut all = self.notes.clone();
        all.extend(self.dropped.iter().map(|what| format!("left out: {what}")));
        all
    }
}

impl std::fmt::Display for ReadReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.format)?;
        for Taken { role, name, unit, why } in &self.taken {
            write!(f, "; {role}: {}", crate::words::quoted(name))?;
            if !unit.is_empty() {
                write!(f, " in {unit}")?;
            }
            if !why.is_empty() {
                write!(f, " ({why})")?;
            }
        }
        for sentence in self.sentences() {
            write!(f, "; {sentence}")?;
        }
        Ok(())
    }
}
