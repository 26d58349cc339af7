//! Built-ins against published values, the readers on sound and on hostile text.

use std::fmt::Write as _;

use super::{Beyond, Formula, Kind, MAX_TEXT_BYTES, Medium, VISIBLE_NM, names};
use crate::{Complex64, OpticsError};

fn named(name: &str) -> Medium {
    Medium::named(name).unwrap()
}

fn n(name: &str, wavelength_nm: f64) -> f64 {
    named(name).index(wavelength_nm, Beyond::Refuse).unwrap().re
}

fn message<T: std::fmt::Debug>(result: Result<T, OpticsError>) -> String {
    result.unwrap_err().to_string()
}

fn rows(rows: &[[f64; 2]]) -> Result<Medium, OpticsError> {
    let numbered: Vec<_> = rows.iter().enumerate().map(|(line, &[nm, n])| (line + 1, nm, n, 0.0)).collect();
    Medium::from_rows(&numbered, false, "m.csv", "")
}

fn yaml(text: &str) -> Result<Medium, OpticsError> {
    Medium::from_yaml(text, "m.yml")
}

const VISIBLE_LINES: [f64; 8] = [400.0, 435.8, 486.1, 546.1, 589.3, 656.3, 700.0, 780.0];

/// n printed to five decimals in the project's fact sheet, computed there from the published coefficients.
#[test]
fn published_values_of_formulas() {
    let rows: [(&str, [f64; 8]); 13] = [
        ("water", [1.34356, 1.34059, 1.33749, 1.33483, 1.33335, 1.33151, 1.33052, 1.32896]),
        ("SiO2", [1.47012, 1.46670, 1.46313, 1.46008, 1.45840, 1.45637, 1.45529, 1.45367]),
        ("N-BK7", [1.53085, 1.52669, 1.52238, 1.51872, 1.51673, 1.51432, 1.51306, 1.51118]),
        ("MgF2", [1.38387, 1.38207, 1.38020, 1.37859, 1.37771, 1.37664, 1.37608, 1.37524]),
        ("rutile-o", [2.99595, 2.85302, 2.73456, 2.65200, 2.61291, 2.57091, 2.55124, 2.52492]),
        ("rutile-e", [3.40373, 3.21593, 3.06311, 2.95802, 2.90865, 2.85586, 2.83122, 2.79837]),
        ("ZnS", [2.55406, 2.48996, 2.43185, 2.38842, 2.36694, 2.34317, 2.33178, 2.31627]),
        ("sapphire-o", [1.78652, 1.78113, 1.77551, 1.77071, 1.76808, 1.76488, 1.76321, 1.76068]),
        ("Si3N4", [2.07261, 2.05552, 2.03821, 2.02397, 2.01647, 2.00778, 2.00347, 1.99744]),
        ("PDMS", [1.44912, 1.44381, 1.43838, 1.43387, 1.43148, 1.42870, 1.42731, 1.42536]),
        ("acetone", [1.37126, 1.36757, 1.36381, 1.36073, 1.35910, 1.35722, 1.35628, 1.35498]),
        ("ethanol", [1.37256, 1.36932, 1.36596, 1.36314, 1.36163, 1.35986, 1.35898, 1.35773]),
        ("glycerol", [1.48128, 1.47948, 1.47683, 1.47397, 1.47220, 1.46991, 1.46867, 1.46683]),
    ];
    for (name, wanted) in rows {
        for (wavelength_nm, wanted) in VISIBLE_LINES.into_iter().zip(wanted) {
            let (index, _) = named(name).index_extended(wavelength_nm).unwrap();
            assert!((index.re - wanted).abs() <= 5.1e-6, "{name} {wavelength_nm}: {} {wanted}", index.re);
            assert_eq!(index.im, 0.0, "{name} is clear");
        }
    }
    assert!((n("air-ciddor", 589.3) - 1.0 - 2.7715e-4).abs() < 5e-9);
    assert_eq!(n("soap", 589.3), n("water", 589.3));
    // Zero of the definition of the air of every day.
    for name in ["air", "vacuum"] {
        assert_eq!(named(name).constant_index(), Some(Complex64::new(1.0, 0.0)));
    }
    assert_eq!(named("soap").constant_index(), None);
}

/// The published tables: rows as printed, and the check values of the colour reference.
#[test]
fn published_values_of_tables() {
    // Name, wavelength, n, k, half a unit of the last digit printed.
    let rows = [
        ("Si", 380.0, 6.616, 0.946, 1e-15),
        ("Si", 450.0, 4.691, 0.086302, 1e-15),
        ("Si", 550.0, 4.077, 0.027968, 1e-15),
        ("Si", 780.0, 3.691, 0.0063933, 1e-15),
        ("Ti", 380.0, 1.983076923076923, 2.927692307692308, 1e-15),
        ("Ti", 650.0, 2.7407142857142857, 3.814285714285714, 1e-15),
        ("TiO2-siefke", 450.0, 2.5513399560941976, 1.3960429569362229e-05, 1e-15),
        ("TiO2-siefke", 650.0, 2.3823589870439568, 1.1177576672284613e-09, 1e-15),
        ("TiO2", 387.45, 2.701, 0.0, 5e-4),
        ("TiO2", 553.5, 2.447, 0.0, 5e-4),
        ("Ag", 187.9, 1.07, 1.212, 1e-15),
        ("Ag", 548.6, 0.06, 3.586, 1e-15),
        ("Au", 616.8, 0.21, 3.272, 1e-15),
        ("Fe", 704.0, 2.86, 3.19, 1e-15),
        ("Fe3O4", 500.0, 2.359, 0.071, 1e-15),
        ("Al", 413.28, 0.5213, 5.001, 5e-4),
        ("Si-aspnes", 539.1, 4.123, 0.048, 1e-15),
        ("Cu", 548.6, 1.02, 2.577, 1e-15),
        ("Cr", 549.0, 3.18, 3.33, 1e-15),
        ("Fe2O3", 560.0, 3.348, 0.437, 1e-15),
        ("Ta2O5", 480.0, 2.187, 0.0001, 5e-4),
        ("Nb2O5", 400.0, 2.544, 0.001046, 5e-4),
        ("water-hale", 550.0, 1.333, 1.96e-9, 1e-15),
        ("ZnS-film", 550.0, 2.3883, 7.0e-4, 5e-3),
    ];
    for (name, wavelength_nm, n, k, half_digit) in rows {
        let index = named(name).index(wavelength_nm, Beyond::Refuse).unwrap();
        assert!((index.re - n).abs() <= half_digit * n, "{name} {wavelength_nm}: {index}");
        // Rounding of the interpolation is relative to the neighbouring rows, up to three times larger.
        assert!((index.im - k).abs() <= 3.0 * half_digit * k, "{name} {wavelength_nm}: {index}");
    }
}

/// Every built-in answers everywhere a colour sum asks, and tells its source, range and kind.
#[test]
fn built_ins_cover_the_visible() {
    assert_eq!(names().len(), names().iter().collect::<std::collections::HashSet<_>>().len());
    for name in names() {
        let medium = named(name);
        assert_eq!(medium.name(), *name);
        assert!(medium.source().len() > 5 && !medium.source().contains('<'), "{name}: {}", medium.source());
        let mut extended = false;
        for wavelength_nm in 360..=830 {
            let (index, beyond) = medium.index_extended(f64::from(wavelength_nm)).unwrap();
            assert!(index.re > 0.0 && index.im >= 0.0 && index.norm() < 10.0, "{name} {wavelength_nm}: {index}");
            extended |= beyond;
        }
        assert_eq!(extended, medium.extension().is_some(), "{name}: the extension is stated where it is used");
        match medium.range_nm() {
            Some((from, to)) => {
                assert!(from < to);
                medium.index(from, Beyond::Refuse).unwrap();
                medium.index(to, Beyond::Refuse).unwrap();
                assert!(medium.index(from * (1.0 - 1e-12), Beyond::Refuse).is_err());
                assert!(medium.index(to * (1.0 + 1e-12), Beyond::Refuse).is_err());
            }
            None => assert_eq!(medium.kind(), Kind::Constant),
        }
    }
    let kinds = ["air", "SiO2", "Ag", "N-BK7"].map(|name| named(name).kind().word());
    assert_eq!(kinds, ["constant", "formula", "table", "formula"]);
    assert!(named("Ag").source().contains("Johnson") && named("Ag").source().contains("4370"));
}

/// n of the sodium D line at 20 C, four digits, for 20, 40 and 60 % glycerol by mass (CRC Handbook), times the 1.00027
/// of air, to which the handbook refers it.
#[test]
fn glycerol_solutions() {
    for (name, wanted) in [("soap-glycerol-20", 1.3572), ("soap-glycerol-40", 1.3841), ("soap-glycerol-60", 1.4129)] {
        let n = n(name, 589.3);
        assert!((n - wanted * 1.00027).abs() < 4e-4, "{name}: {n}");
    }
    let mixture = named("soap-glycerol-40");
    assert_eq!((mixture.kind(), mixture.range_nm()), (Kind::Mixture, Some((589.3, 1050.0))));
    let (blue, extended) = mixture.index_extended(450.0).unwrap();
    assert!(extended && blue.re > mixture.index(450.0, Beyond::Hold).unwrap().re);
    assert!(message(mixture.index(450.0, Beyond::Refuse)).contains("\"soap-glycerol-40\" has data for 589-1050 nm"));
}

#[test]
fn outside_the_data() {
    let silver = named("Ag");
    assert_eq!(
        message(silver.index(2000.0, Beyond::Refuse)),
        "medium \"Ag\" has data for 188-1937 nm; 2000.0 nm was asked. Pass extrapolate=\"hold\" to accept the end value"
    );
    assert!(matches!(silver.index(2000.0, Beyond::Refuse), Err(OpticsError::OutsideData(_))));
    assert_eq!(silver.index(2000.0, Beyond::Hold).unwrap(), silver.index(1937.0, Beyond::Refuse).unwrap());
    assert_eq!(silver.index(1.0, Beyond::Hold).unwrap(), silver.index(187.9, Beyond::Refuse).unwrap());
    // 187.95 is rounded into the short form of the range, so the exact ends are shown.
    let narrow = rows(&[[400.4, 1.5], [500.0, 1.4]]).unwrap();
    let text = message(narrow.index(400.2, Beyond::Refuse));
    assert!(text.contains("400.4-500 nm; 400.2 nm was asked"), "{text}");
    assert!(
        message(silver.index_at(2000.0, Beyond::Refuse, "at index (3,)")).contains("nm was asked at index (3,). Pass")
    );
    for bad in [f64::NAN, f64::INFINITY, 0.0, -500.0, f64::NEG_INFINITY] {
        for name in ["air", "Ag", "SiO2"] {
            assert!(message(named(name).index(bad, Beyond::Hold)).starts_with("wavelength_nm must be > 0 and finite"));
            assert!(named(name).index_extended(bad).is_err());
        }
    }
}

#[test]
fn stated_extensions() {
    let rutile = named("rutile-o");
    assert!(rutile.index(400.0, Beyond::Refuse).is_err());
    // Holding repeats the value at 430 nm; the extension continues the formula: n^2 = 5.913 + 0.2441/(L^2 - 0.0803).
    assert_eq!(rutile.index(400.0, Beyond::Hold).unwrap().re, n("rutile-o", 430.0));
    let (index, extended) = rutile.index_extended(400.0).unwrap();
    assert!(extended && (index.re - (5.913 + 0.2441 / (0.16 - 0.0803_f64)).sqrt()).abs() < 1e-14);
    assert_eq!(rutile.extension().unwrap(), "360-430 nm: the dispersion formula is continued");
    assert!(!rutile.index_extended(500.0).unwrap().1);
    assert!(message(rutile.index_extended(359.0)).contains("extension ends at 360 and 830"));
    let film = named("TiO2");
    assert_eq!(film.extension().unwrap(), "827-830 nm: the end value of the table is held");
    assert_eq!(film.index_extended(830.0).unwrap(), (film.index(826.56, Beyond::Refuse).unwrap(), true));
    assert_eq!(named("Ag").extension(), None);
    assert_eq!(VISIBLE_NM, (360.0, 830.0));

    // Media of the user are never continued.
    let user = rows(&[[400.0, 1.5], [700.0, 1.4]]).unwrap();
    assert_eq!(user.extension(), None);
    assert_eq!(user.index_extended(550.0).unwrap(), (Complex64::new(1.45, 0.0), false));
    assert!(message(user.index_extended(399.0)).contains("continue only built-in media"));
    let constant = Medium::constant(Complex64::new(1.5, 0.0)).unwrap();
    assert_eq!(constant.index_extended(5.0).unwrap(), (Complex64::new(1.5, 0.0), false));
}

#[test]
fn constants() {
    let constant = |re: f64, im: f64| Medium::constant(Complex64::new(re, im));
    assert_eq!(constant(1.33, 0.0).unwrap().name(), "1.33");
    assert_eq!(constant(2.0, 3.0).unwrap().name(), "2+3j");
    assert_eq!(constant(1.5, -0.0).unwrap().name(), "1.5");
    assert_eq!(constant(2.0, -0.1).unwrap().constant_index(), Some(Complex64::new(2.0, -0.1)), "gain is allowed");
    constant(0.0, 3.0).unwrap();
    for (re, im) in [
        (f64::NAN, 0.0),
        (1.0, f64::NAN),
        (f64::INFINITY, 0.0),
        (1.0, f64::NEG_INFINITY),
        (0.0, 0.0),
        (-1.5, 0.0),
        (-1.5, 2.0),
        (1e300, 0.0),
        (1e-300, 0.0),
    ] {
        let text = message(constant(re, im));
        assert!(text.contains("n >= 0") && text.contains(&format!("n = {re:?}, k = {im:?}")), "{text}");
    }
}

#[test]
fn unknown_names_suggest() {
    assert!(message(Medium::named("sopa")).contains("unknown medium \"sopa\"; did you mean \"soap\"?"));
    assert!(message(Medium::named("n-bk7")).contains("did you mean \"N-BK7\"?"));
    assert!(message(Medium::named("tio2-siefk")).contains("did you mean \"TiO2-siefke\"?"));
    let text = message(Medium::named("unobtainium"));
    assert!(!text.contains("did you mean") && text.contains("Known: vacuum, air,"), "{text}");
    assert!(message(Medium::named("")).contains("unknown medium \"\""));
    assert!(message(Medium::named(&"x".repeat(1 << 20))).len() < 2000);
}

const HEAD: &str = "REFERENCES: |\n    A. Author. <i>J. Opt.</i> <b>1</b>, 2 (2000)\nCOMMENTS: |\n    a film\nDATA:\n";

#[test]
fn yaml_forms() {
    let formula = "  - type: formula 5\n    wavelength_range: 0.3 2.5\n    coefficients: 1.5 0.01 -2\n";
    let with = |data: &str| yaml(&format!("{HEAD}{data}CONDITIONS:\n    temperature: 293\n"));
    let cauchy = with(formula).unwrap();
    assert_eq!(cauchy.source(), "A. Author. J. Opt. 1, 2 (2000)");
    assert_eq!(cauchy.note(), "a film");
    assert_eq!((cauchy.range_nm(), cauchy.kind()), (Some((300.0, 2500.0)), Kind::Formula));
    assert_eq!(cauchy.index(500.0, Beyond::Refuse).unwrap(), Complex64::new(1.54, 0.0));
    let older = with(&formula.replace("wavelength_range", "range")).unwrap();
    assert_eq!(older.index(500.0, Beyond::Refuse).unwrap().re, 1.54);

    // Formula and table of k with another range: known where both are; held each at its own end.
    let k = "  - type: tabulated k\n    data: |\n        0.4 0.2\n        0.6 0.4\n        3.0 0.4\n";
    let both = with(&format!("{formula}{k}")).unwrap();
    assert_eq!((both.range_nm(), both.kind()), (Some((400.0, 2500.0)), Kind::FormulaAndTable));
    let close = |index: Complex64, n: f64, k: f64| assert!((index - Complex64::new(n, k)).norm() < 1e-15, "{index}");
    close(both.index(500.0, Beyond::Refuse).unwrap(), 1.54, 0.3);
    assert!(both.index(350.0, Beyond::Refuse).is_err());
    close(both.index(350.0, Beyond::Hold).unwrap(), cauchy.index(350.0, Beyond::Refuse).unwrap().re, 0.2);
    close(both.index(5000.0, Beyond::Hold).unwrap(), cauchy.index(2500.0, Beyond::Refuse).unwrap().re, 0.4);

    let n = "  - type: tabulated n\n    data: |\n        0.8 1.8\n        0.5 1.5\n";
    let tables = with(&format!("{n}{k}")).unwrap();
    assert_eq!((tables.range_nm(), tables.kind()), (Some((500.0, 800.0)), Kind::Table));
    close(tables.index(550.0, Beyond::Refuse).unwrap(), 1.55, 0.35);
    let joint = with("  - type: tabulated nk\n    data: |\n        4.0e-1 1.5 0.2\n        0.6 1.7 0.4\n").unwrap();
    close(joint.index(500.0, Beyond::Refuse).unwrap(), 1.6, 0.3);
    assert_eq!(joint.range_nm(), Some((400.0, 600.0)));

    // Published pages hold rounding pairs.
    let pair = with("  - type: tabulated n\n    data: |\n        0.4 1.5\n        0.4 1.7\n        0.5 1.8\n").unwrap();
    close(pair.index(400.0, Beyond::Refuse).unwrap(), 1.6, 0.0);
    assert!(pair.note().contains("mean taken: 1"), "{}", pair.note());

    // Reading is the same whatever the ends of lines.
    let dos = yaml(&format!("{HEAD}{n}{k}").replace('\n', "\r\n")).unwrap();
    assert_eq!(dos.index(550.0, Beyond::Refuse).unwrap(), tables.index(550.0, Beyond::Refuse).unwrap());
    assert!(message(Medium::from_yaml("400 1.5", "A.YML")).contains("key DATA"));
}

#[test]
fn yaml_hostile() {
    let table = |rows: &str| format!("{HEAD}  - type: tabulated nk\n    data: |\n        0.4 1.5 0\n        {rows}\n");
    let formula = |rest: &str| format!("{HEAD}  - type: formula {rest}\n");
    let deep = "[".repeat(200_000);
    let deep_block = (0..40).map(|i| format!("{}a:\n", " ".repeat(i))).collect::<String>();
    let bomb = "a: &a [1, 1]\nb: &b [*a, *a]\nc: &c [*b, *b]\n";
    let many_keys = (0..100_000).fold(String::new(), |mut text, i| {
        writeln!(text, "k{i}: 1").unwrap();
        text
    });
    let open_tags = format!("REFERENCES: '{}'\nDATA: []", "<a".repeat(200_000));
    for (text, wanted) in [
        (String::new(), "m.yml:"),
        ("just words".into(), "holds no list under the key DATA"),
        ("- 1\n- 2\n".into(), "holds no list under the key DATA"),
        ("DATA: 5".into(), "holds no list under the key DATA"),
        ("DATA: []".into(), "m.yml: holds no refractive index n"),
        ("DATA:\n  - 5\n".into(), "m.yml:2: an entry of DATA needs the key \"type\""),
        ("DATA:\n  - type: [1]\n".into(), "m.yml:2: \"type\" must be text"),
        ("DATA:\n  - type: tabulated q\n".into(), "m.yml:2: the type must be"),
        ("DATA:\n  - type: formula x\n".into(), "m.yml:2: the type must be"),
        (
            formula("10\n    wavelength_range: 0.3 2\n    coefficients: 1"),
            "m.yml:8: dispersion formulas are numbered 1 to 9",
        ),
        (formula("1\n    wavelength_range: 0.3 2"), "needs the key \"coefficients\""),
        (formula("1\n    coefficients: 0"), "needs the key \"wavelength_range\""),
        (formula("1\n    wavelength_range: 0.3 2\n    coefficients: 0 1"), "m.yml:8: formula 1 takes an odd number"),
        (
            formula("1\n    wavelength_range: 0.3 2\n    coefficients: 0 nan 1"),
            "m.yml:8: \"nan\" is not a finite number",
        ),
        (formula("1\n    wavelength_range: 2 0.3\n    coefficients: 0"), "m.yml:7: a wavelength range"),
        (formula("1\n    wavelength_range: 0.3\n    coefficients: 0"), "m.yml:7: a wavelength range"),
        (formula("1\n    wavelength_range: 0 2\n    coefficients: 0"), "m.yml:7: a wavelength range"),
        (table("0.5 1.5"), "m.yml:9: a row holds wavelength, n and k, got 2 numbers"),
        (table("0.5 1.5 0 0"), "m.yml:9: a row holds"),
        (table("0.5 nan 0"), "m.yml:9: \"nan\" is not a finite number"),
        (table("0.5 1.5 inf"), "m.yml:9: \"inf\""),
        (table("0.5 -1.5 0"), "m.yml:9: n must be >= 0"),
        (table("0.5 0 0"), "m.yml:9: n must be >= 0"),
        (table("-0.5 1 0"), "m.yml:9: a wavelength must be > 0"),
        (table("\n        0.5 1 x"), "m.yml:10: \"x\" is not"),
        (format!("{HEAD}  - type: tabulated n\n    data: |\n\n\n        0.4 x\n"), "m.yml:10: \"x\" is not"),
        (format!("{HEAD}  - type: tabulated n\n    data: |\n"), "holds no rows"),
        (format!("{HEAD}  - type: tabulated k\n    data: 0.5 1\n"), "m.yml: holds no refractive index n"),
        (
            format!("{HEAD}  - type: tabulated n\n    data: 0.5 1\n  - type: tabulated k\n    data: 0.6 1\n"),
            "n is given for 500-500 nm and k for 600-600 nm; they have no wavelength in common",
        ),
        ("DATA: [}".into(), "not YAML"),
        ("DATA:\n  - type: 'tabulated".into(), "not YAML"),
        ("DATA: []\nDATA: []".into(), "m.yml:2: the key \"DATA\" stands twice"),
        ("\u{0}\u{1}\u{2}".into(), "m.yml"),
        ("{[1]: 2}".into(), "m.yml:1: a key must be a word"),
        (deep, "m.yml:1:"),
        (deep_block, "m.yml:33: nested deeper than 32 levels"),
        (bomb.into(), "aliases"),
        (many_keys, "more than 256 keys"),
        ("DATA:\n".to_owned() + &"  - 1\n".repeat(300), "m.yml:258: more than 256 entries in one list"),
        (open_tags, "m.yml: holds no refractive index n"),
    ] {
        let got = message(yaml(&text));
        let shown: String = text.chars().take(200).collect();
        assert!(got.contains(wanted), "{shown:?}: {got}");
        assert!(got.len() < 500, "{got}");
    }
    assert!(message(yaml(&"#".repeat(MAX_TEXT_BYTES + 1))).contains("longer than 16 MiB"));
}

/// A page cut anywhere is read or refused, never a panic; what is read gives an index or an error.
#[test]
fn yaml_truncated_and_broken() {
    let page = include_str!("../../data/media/N-BK7.yml");
    for end in (0..page.len()).filter(|&end| page.is_char_boundary(end)) {
        if let Ok(medium) = yaml(&page[..end]) {
            medium.index(550.0, Beyond::Hold).unwrap();
        }
    }
    // Every byte of a short page replaced by every sign that means something to YAML.
    let page = format!("{HEAD}  - type: tabulated nk\n    data: |\n        0.4 1.5 0\n        0.5 1.4 0\n");
    for place in 0..page.len() {
        for sign in b"\n\t :-?[]{}&*!|>'\"%@#,0\0" {
            let mut bytes = page.clone().into_bytes();
            bytes[place] = *sign;
            if let Ok(medium) = yaml(std::str::from_utf8(&bytes).unwrap()) {
                let _ = medium.index(450.0, Beyond::Hold);
            }
        }
    }
}

/// A formula that leaves the real numbers inside its own range is an error with the wavelength.
#[test]
fn formula_without_an_index() {
    let text = format!("{HEAD}  - type: formula 1\n    wavelength_range: 0.3 0.9\n    coefficients: 0 1 0.6\n");
    let medium = yaml(&text).unwrap();
    let message = message(medium.index_at(500.0, Beyond::Refuse, "at index (2,)"));
    assert!(
        message.starts_with("medium \"m.yml\" gives no refractive index at 500.0 nm at index (2,): its"),
        "{message}"
    );
    assert!(medium.index(600.0, Beyond::Refuse).is_err(), "the pole itself");
    medium.index(700.0, Beyond::Refuse).unwrap();
    assert!(Formula::new(1, vec![0.0]).is_ok());
}

#[test]
fn rows_are_checked_with_their_lines() {
    let medium = rows(&[[500.0, 1.7], [400.0, 1.5], [400.0, 1.5]]).unwrap();
    assert_eq!((medium.range_nm(), medium.kind()), (Some((400.0, 500.0)), Kind::Table));
    assert!((medium.index(425.0, Beyond::Refuse).unwrap().re - 1.55).abs() < 1e-15);
    for (table, wanted) in [
        (&[][..], "m.csv: holds no rows"),
        (&[[400.0, -1.5]], "m.csv:1: n must be >= 0"),
        (&[[400.0, 1.5], [-400.0, 1.5]], "m.csv:2: a wavelength must be > 0, got -400"),
        (&[[400.0, 1.5], [400.0, 1.6]], "m.csv:2: the wavelength 400 nm stands on line 1 too"),
    ] {
        assert!(message(rows(table)).contains(wanted), "{table:?}");
    }
}
