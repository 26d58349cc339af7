//! Bytes to text: the encodings that instruments and spreadsheets write, and what is no text refused by name.

/// Signatures of files that people hand to a reader of text, and what they are.
const BINARY: [(&[u8], &str); 10] = [
    (b"PK\x03\x04", "a zip archive or a spreadsheet"),
    (&[0xD0, 0xCF, 0x11, 0xE0], "an old spreadsheet (OLE)"),
    (b"\x89PNG", "a PNG picture"),
    (b"\x89HDF", "an HDF5 file"),
    (b"%PDF", "a PDF"),
    (&[0x1F, 0x8B], "a gzip archive"),
    (&[0xFF, 0xD8, 0xFF], "a JPEG picture"),
    (&[0x76, 0x2F, 0x31, 0x01], "an OpenEXR picture"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"II*\0", "a TIFF picture"),
];

/// Windows-1252 above 0x7F and below 0xA0 (RFC 1345, "CP1252"); the five holes are kept as the control codes they are.
const CP1252: [char; 32] = [
    '\u{20AC}', '\u{81}', '\u{201A}', '\u{192}', '\u{201E}', '\u{2026}', '\u{2020}', '\u{2021}', '\u{2C6}', '\u{2030}',
    '\u{160}', '\u{2039}', '\u{152}', '\u{8D}', '\u{17D}', '\u{8F}', '\u{90}', '\u{2018}', '\u{2019}', '\u{201C}',
    '\u{201D}', '\u{2022}', '\u{2013}', '\u{2014}', '\u{2DC}', '\u{2122}', '\u{161}', '\u{203A}', '\u{153}', '\u{9D}',
    '\u{17E}', '\u{178}',
];

/// The text in `bytes` and the name of its encoding: UTF-8, UTF-16 (with a mark or, by its zeros, without), or else
/// Windows-1252, which takes every byte. Line ends are `\n`, marks and no-break blanks are gone, and the minus of
/// typographers (U+2212) is that of numbers.
pub fn decode_text(bytes: &[u8]) -> Result<(String, &'static str), String> {
    if let Some((_, what)) = BINARY.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Err(binary(what));
    }
    let (text, encoding) = match bytes {
        [0xFF, 0xFE, rest @ ..] => (utf16(rest, u16::from_le_bytes), "UTF-16"),
        [0xFE, 0xFF, rest @ ..] => (utf16(rest, u16::from_be_bytes), "UTF-16"),
        _ => match zeros(bytes) {
            Zeros::None => match std::str::from_utf8(bytes) {
                Ok(text) => (text.to_owned(), "UTF-8"),
                Err(_) => (bytes.iter().map(|&byte| from_cp1252(byte)).collect(), "Windows-1252"),
            },
            Zeros::Odd => (utf16(bytes, u16::from_le_bytes), "UTF-16 without a mark"),
            Zeros::Even => (utf16(bytes, u16::from_be_bytes), "UTF-16 without a mark"),
            Zeros::Anywhere => return Err(binary("a binary file")),
        },
    };
    let mut clean = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '\r' => {
                letters.next_if_eq(&'\n');
                clean.push('\n');
            }
            '\u{FEFF}' => {}
            '\u{A0}' | '\u{2007}' | '\u{2009}' | '\u{202F}' => clean.push(' '),
            '\u{2212}' => clean.push('-'),
            other => clean.push(other),
        }
    }
    Ok((clean, encoding))
}

fn binary(what: &str) -> String {
    format!("holds no table of numbers: it is {what}; export it from the program that wrote it as text (CSV or ASCII)")
}

fn from_cp1252(byte: u8) -> char {
    match byte {
        0x80..=0x9F => CP1252[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let (pairs, _) = bytes.as_chunks::<2>();
    char::decode_utf16(pairs.iter().map(|&pair| unit(pair))).map(|letter| letter.unwrap_or('\u{FFFD}')).collect()
}

/// Where zero bytes stand in the first 4 KiB.
enum Zeros {
    None,
    /// In (nearly) every second byte, the low ones first.
    Odd,
    Even,
    Anywhere,
}

fn zeros(bytes: &[u8]) -> Zeros {
    let head = &bytes[..bytes.len().min(4096)];
    let (pairs, _) = head.as_chunks::<2>();
    let [even, odd] = [0, 1].map(|place| pairs.iter().filter(|pair| pair[place] == 0).count());
    let most = pairs.len() * 7 / 10;
    match (even, odd) {
        // An even number of bytes: half a letter at the end is no UTF-16.
        (0, odd) if odd > most && bytes.len().is_multiple_of(2) => Zeros::Odd,
        (even, 0) if even > most && bytes.len().is_multiple_of(2) => Zeros::Even,
        _ if bytes.contains(&0) => Zeros::Anywhere,
        _ => Zeros::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "Wellenlänge [µm];R\n0,5;−1,2\n";
        let clean = text.replace('−', "-");
        let utf16: Vec<u16> = text.encode_utf16().collect();
        let little: Vec<u8> = utf16.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let big: Vec<u8> = utf16.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        for (bytes, encoding) in [
            (text.as_bytes().to_vec(), "UTF-8"),
            ([b"\xEF\xBB\xBF", text.as_bytes()].concat(), "UTF-8"),
            ([&[0xFF, 0xFE][..], &little].concat(), "UTF-16"),
            ([&[0xFE, 0xFF][..], &big].concat(), "UTF-16"),
            (text.replace('\n', "\r\n").into_bytes(), "UTF-8"),
            (text.replace('\n', "\r").into_bytes(), "UTF-8"),
        ] {
            assert_eq!(decode_text(&bytes).unwrap(), (clean.clone(), encoding));
        }
        let plain = "nm;R\n500,1;4,2\n";
        let little: Vec<u8> = plain.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = plain.encode_utf16().flat_map(u16::to_be_bytes).collect();
        for bytes in [little, big] {
            assert_eq!(decode_text(&bytes).unwrap(), (plain.into(), "UTF-16 without a mark"));
        }
        assert_eq!(decode_text(b"L\xE4nge \x96 \xB5m").unwrap(), ("Länge \u{2013} µm".into(), "Windows-1252"));
    }

    #[test]
    fn what_is_no_text_is_refused_by_name() {
        assert!(decode_text(b"PK\x03\x04rest").unwrap_err().contains("spreadsheet"));
        assert!(decode_text(&[0, 1, 2, 255, 0, 0, 7]).unwrap_err().contains("a binary file"));
        assert!(decode_text(b"500,1\n5\x0001,2\n").unwrap_err().contains("a binary file"));
    }
}
