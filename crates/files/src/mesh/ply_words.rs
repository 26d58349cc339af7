//! What is wrong with a PLY file, in words: its library says in which line at most.

use crate::words::quoted;

/// Names of number types in headers.
const TYPES: [&str; 16] = [
    "char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8", "uint8", "int16", "uint16", "int32",
    "uint32", "float32", "float64",
];

/// The library tells the line and what it missed; then, indented, the file's own bytes and its grammar.
pub fn wrong(error: &dyn std::fmt::Display, bytes: &[u8]) -> String {
    let words = error.to_string();
    let told: String = words.lines().next().unwrap_or_default().chars().filter(|c| !c.is_control()).collect();
    let told = wrong_header(bytes)
        .or_else(|| wrong_row(&told, bytes))
        .unwrap_or_else(|| told.trim_end_matches('.').to_owned());
    format!("it is no PLY file that can be read: {told}")
}

/// The first line that has no place in a header, and what has.
fn wrong_header(bytes: &[u8]) -> Option<String> {
    let mut count = 0;
    for (line, number) in bytes.split(|&byte| byte == b'\n').zip(1..) {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if line == b"end_header" {
            return None;
        }
        count = number;
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let allowed = match (number, words.as_slice()) {
            (1, ["ply"]) | (2.., ["comment" | "obj_info", ..]) => None,
            (1, _) => Some("the first line of a PLY file is ply"),
            (_, ["format", kind, version]) => {
                let kinds = ["ascii", "binary_little_endian", "binary_big_endian"];
                let is_known = kinds.contains(kind) && version.split('.').all(|part| part.parse::<u16>().is_ok());
                (!is_known)
                    .then_some("a format is ascii, binary_little_endian or binary_big_endian, then its version, 1.0")
            }
            (_, ["element", _, count]) if count.parse::<u64>().is_ok() => None,
            (_, ["element", ..]) => {
                Some("an element is a name and how many there are, a whole number: element vertex 8")
            }
            (_, ["property", "list", a, b, _]) if TYPES.contains(a) && TYPES.contains(b) => None,
            (_, ["property", kind, _]) if TYPES.contains(kind) => None,
            (_, ["property", ..]) => Some(
                "a property is a type and a name (property float x), or list, two types and a name; types are char, uchar, short, ushort, \
                 int, uint, float and double",
            ),
            _ => Some(
                "a header has the lines format, element, property, comment and obj_info, and ends with the line end_header",
            ),
        };
        if let Some(allowed) = allowed {
            return Some(format!("line {number} is {}; {allowed}", quoted(&text)));
        }
    }
    Some(format!("its header has no end within {count} lines; it ends with the line end_header"))
}

/// A row of numbers that the library could not read, by the line that it names: "Line 11: ...".
fn wrong_row(told: &str, bytes: &[u8]) -> Option<String> {
    let number: usize = told.strip_prefix("Line ")?.split(':').next()?.parse().ok()?;
    let line = bytes.split(|&byte| byte == b'\n').nth(number.checked_sub(1)?)?;
    let text = String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line));
    is_text(bytes).then(|| format!("line {number}, {}, does not hold the numbers that the header says", quoted(&text)))
}

fn is_text(bytes: &[u8]) -> bool {
    bytes
        .split(|&byte| byte == b'\n')
        .take_while(|line| *line != b"end_header")
        .any(|line| line.starts_with(b"format ascii"))
}
