use iridesce_optics::{Beyond, Complex64};

use super::*;

fn csv(text: &str) -> Result<Medium, String> {
    read_medium(text.as_bytes(), "m.csv").map(|(medium, _, _)| medium)
}

fn message(result: Result<Medium, String>) -> String {
    result.unwrap_err()
}

#[test]
fn other_quantities_are_converted_or_refused_by_name() {
    // 2.10 is the permittivity of n = 1.45.
    let (medium, _, report) = read_medium(b"nm,e1,e2\n400,2.1025,0\n700,-9.0,1.2\n", "m.csv").unwrap();
    assert!((medium.index(400.0, Beyond::Refuse).unwrap() - Complex64::new(1.45, 0.0)).norm() < 1e-12);
    assert!((medium.index(700.0, Beyond::Refuse).unwrap() - Complex64::new(-9.0, 1.2).sqrt()).norm() < 1e-12);
    assert!(report.to_string().contains("computed from the permittivity"), "{report}");
    for name in ["eps", "R", "conductivity", "n_g"] {
        let error = message(csv(&format!("nm,{name}\n400,1.5\n500,1.4\n")));
        assert!(error.contains(&format!("{name:?} is neither n nor k")), "{error}");
    }
    // Swapped columns are told by their names.
    let swapped = csv("nm,k,n\n400,0.1,1.5\n500,0.3,1.7\n").unwrap();
    assert_eq!(swapped.index(400.0, Beyond::Refuse).unwrap(), Complex64::new(1.5, 0.1));
}

#[test]
fn units_of_the_axis_and_the_blocks_of_web_sites() {
    for text in [
        "wavelength (um),n,k\n0.4,1.5,0.1\n0.5,1.7,0.3\n",
        "wl,n,k\n0.4,1.5,0.1\n0.5,1.7,0.3\n",
        "wl,n\n0.4,1.5\n0.5,1.7\n\nwl,k\n0.4,0.1\n0.5,0.3\n",
        "nm;n;k\n400;1,5;0,1\n500;1,7;0,3\n",
    ] {
        let medium = csv(text).unwrap();
        assert_eq!(medium.range_nm(), Some((400.0, 500.0)), "{text:?}");
        assert_eq!(medium.index(500.0, Beyond::Refuse).unwrap(), Complex64::new(1.7, 0.3), "{text:?}");
    }
    let energies = csv("eV,n\n2.0,1.5\n3.0,1.6\n").unwrap();
    assert!((energies.range_nm().unwrap().1 - 619.920992).abs() < 1e-6);
}

#[test]
fn csv_forms() {
    let plain = csv("400,1.5,0.1\n500,1.7,0.3\n").unwrap();
    for text in [
        "nm,n,k\n400,1.5,0.1\n500,1.7,0.3",
        "wavelength [nm]; n; k\r\n400; 1.5; 0.1\r\n500; 1.7; 0.3\r\n",
        "\u{feff}400\t1.5\t0.1\n500\t1.7\t0.3",
        "# a comment\n\n  400   1.5 0.1 # another\n500 1.7 0.3",
        "500,1.7,0.3\n400,1.5,0.1\n400,1.5,0.1\n",
        "\"nm\",\"n\",\"k\"\n\"400\",\"1.5\",\"0.1\"\n4e2,1.5,0.1\n5E+2,1.7,0.3,\n",
    ] {
        let medium = csv(text).unwrap();
        assert_eq!(medium.range_nm(), Some((400.0, 500.0)), "{text:?}");
        for wavelength_nm in [400.0, 425.0, 500.0] {
            let wanted = plain.index(wavelength_nm, Beyond::Refuse).unwrap();
            assert_eq!(medium.index(wavelength_nm, Beyond::Refuse).unwrap(), wanted, "{text:?}");
        }
    }
    let quarter = plain.index(425.0, Beyond::Refuse).unwrap();
    assert!((quarter - Complex64::new(1.55, 0.15)).norm() < 1e-15);
    assert_eq!(csv("# Smith 2020\n400 1.5").unwrap().note(), "Smith 2020");
    assert_eq!(csv("400,1.5").unwrap().index(400.0, Beyond::Refuse).unwrap().im, 0.0);
    assert_eq!(csv("400,1.5,-0.1").unwrap().index(400.0, Beyond::Refuse).unwrap().im, -0.1, "gain is allowed");
}

#[test]
fn csv_hostile() {
    let long_row = format!("400,1.5\n{}", "9,".repeat(5000));
    for (text, wanted) in [
        ("", "m.csv: holds no rows"),
        ("# only\n\n# comments", "m.csv: holds no rows"),
        ("nm,n\n", "m.csv: holds no rows"),
        ("nm,n\n400,1.5\n500,x", "m.csv:3: \"x\" is not a finite number"),
        ("400,1.5\n500,", "m.csv:2: a row holds nm, n and perhaps k"),
        ("400,1.5\n500", "m.csv:2: a row holds"),
        ("400,1.5,0,0", "m.csv:1: a row holds"),
        ("400,1.5\n500,1.5,0.1", "m.csv:2: 3 numbers in this row, but 2 in line 1"),
        ("400,nan", "m.csv:1: \"nan\" is not a finite number"),
        ("400,inf", "m.csv:1: \"inf\" is not a finite number"),
        ("400,1.5\nnan,1.5", "m.csv:2: \"nan\""),
        ("400,-1.5", "m.csv:1: n must be >= 0"),
        ("400,0", "m.csv:1: n must be >= 0"),
        ("400,0,0", "m.csv:1: n must be >= 0"),
        ("400,1e300", "m.csv:1: n must be >= 0"),
        ("-400,1.5", "m.csv:1: a wavelength must be > 0, got -400"),
        ("0,1.5", "m.csv:1: a wavelength must be > 0"),
        ("0.4,1.5,0\n0.8,1.4,0\n", "the wavelengths end at 0.8 without a unit"),
        ("wavelength,n\n0.4,1.5\n14,1.4\n", "the wavelengths end at 14 without a unit"),
        ("400,1.5\n500,1.4\n400,1.6", "m.csv:3: the wavelength 400 nm stands on line 1 too"),
        ("nm,n\nnm,n\n400,1.5", "m.csv:2: the column \"n n\" is neither n nor k"),
        ("f [THz],n\n0.4,1.5", "m.csv:1: the axis"),
        ("\u{0}\u{1}\u{fffd}PNG", "m.csv: holds no table of numbers: it is a binary file"),
        ("400 1.5 \u{0}", "a binary file"),
        (&long_row, "m.csv:2: 5000 numbers in this row, but 2 in line 1"),
    ] {
        let got = message(csv(text));
        assert!(got.contains(wanted), "{text:?}: {got}");
    }
    let huge = "400,1.5\n".repeat(MAX_TEXT_BYTES / 8 + 1);
    assert!(message(csv(&huge)).contains("longer than 16 MiB"));
}
