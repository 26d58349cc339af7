//! Reading this crate's own tables: comma-separated lines, `#` comments, a header. Tables of users are read by `iridesce-files`.

use crate::OpticsError;

/// A numeric table: the header's names (empty when there is none) and the rows with their line numbers.
pub(super) struct Csv {
    pub header: Vec<String>,
    pub rows: Vec<(usize, Vec<Option<f64>>)>,
}

/// Reads `text`; an empty field is `None`. `label` names the text in errors.
pub(super) fn parse_csv(text: &str, label: &str) -> Result<Csv, OpticsError> {
    let mut csv = Csv { header: Vec::new(), rows: Vec::new() };
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() {
            continue;
        }
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if csv.rows.is_empty() && csv.header.is_empty() && fields[0].parse::<f64>().is_err() {
            csv.header = fields.iter().map(|f| f.to_string()).collect();
            continue;
        }
        let mut row = Vec::with_capacity(fields.len());
        for field in fields {
            row.push(match field {
                "" => None,
                _ => match field.parse::<f64>() {
                    Ok(value) if value.is_finite() => Some(value),
                    _ => {
                        let message = format!("{label}:{}: expected finite numbers, got {field:?}", index + 1);
                        return Err(OpticsError::Data(message));
                    }
                },
            });
        }
        csv.rows.push((index + 1, row));
    }
    Ok(csv)
}

/// The rows of one of our own three-column tables on the 1 nm grid, one entry a wavelength.
pub(super) fn own_triples(text: &str, label: &str) -> Vec<[f64; 3]> {
    let csv = parse_csv(text, label).expect("our own table reads");
    let value = |row: &[Option<f64>], column: usize| row[column].expect("our own table is full");
    csv.rows.iter().map(|(_, row)| [value(row, 1), value(row, 2), value(row, 3)]).collect()
}

/// Entry of a 1 nm table that starts at `first_nm`, linear between entries, `None` outside.
pub(super) fn at_one_nm(table: &[[f64; 3]], first_nm: f64, wavelength_nm: f64) -> Option<[f64; 3]> {
    let place = wavelength_nm - first_nm;
    let last = table.len() - 1;
    if !(0.0 <= place && place <= last as f64) {
        return None;
    }
    let below = (place as usize).min(last - 1);
    let share = place - below as f64;
    let (a, b) = (table[below], table[below + 1]);
    Some(std::array::from_fn(|i| if share == 0.0 { a[i] } else { a[i] + (b[i] - a[i]) * share }))
}
