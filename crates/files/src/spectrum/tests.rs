use super::*;

fn choice() -> SpectrumChoice<'static> {
    SpectrumChoice { quantity: "reflectance", ..SpectrumChoice::default() }
}

fn read(text: &str) -> Spectrum {
    read_spectrum(text.as_bytes(), &choice()).unwrap_or_else(|why| panic!("{text}: {why}"))
}

fn refused(text: &str, words: &str) {
    let error = read_spectrum(text.as_bytes(), &choice()).unwrap_err();
    assert!(error.contains(words), "{error}");
}

fn said(spectrum: &Spectrum, words: &str) {
    assert!(spectrum.report.to_string().contains(words), "{}", spectrum.report);
}

#[test]
fn the_processed_column_is_taken_not_the_lamp() {
    let table = "Wave;Dark;Ref;Sample;Reflectance\n[nm];[counts];[counts];[counts];[%]\n\
                 400,1;1210;48100;1310;4,2\n400,6;1208;48220;1330;4,4\n401,1;1211;48190;1290;4,1\n";
    let spectrum = read(table);
    assert_eq!(spectrum.column, "Reflectance [%]");
    assert!((spectrum.values[0] - 0.042).abs() < 1e-15);
    said(&spectrum, "left out: the columns \"Dark [counts]\", \"Ref [counts]\", \"Sample [counts]\"");
    // Without it the ratio is computed; a greatest count that repeats is a saturated detector.
    let raw = "nm;Dark;Ref;Scope\n400;10;110;30\n401;10;110;65535\n402;10;110;65535\n403;10;110;65535\n404;10;10;20\n405;10;210;60\n";
    let spectrum = read(raw);
    assert_eq!((spectrum.values[0], spectrum.values[5]), (0.2, 0.25));
    assert!(spectrum.values[1..5].iter().all(|value| value.is_nan()));
    said(&spectrum, "reference_stack=");
}

#[test]
fn a_unit_counts_in_the_name_of_its_column_only() {
    let spectrum = read("Fiber (micron): 400\nSlit 25 um\n400 0.1\n650 0.2\n900 0.3\n");
    assert_eq!(spectrum.wavelength_nm, [400.0, 650.0, 900.0]);
    said(&spectrum, "a guess by the size of the numbers");
    refused("wavelength (um) R\n400 0.1\n900 0.2\n", "wavelengths 400000.000000 to 900000.000000 nm after \"um\"");
}

#[test]
fn percent_is_decided_by_name_option_and_the_part_in_use() {
    let run = |values: &dyn Fn(usize) -> f64| -> String {
        (0..100).map(|i| format!("{}\t{}\n", 400 + 5 * i, values(i))).collect()
    };
    // Noise of 930 % at the dark end of ratios.
    let dark_end = run(&|i| if i > 97 { 9.3 } else { 0.2 });
    assert_eq!(read(&dark_end).values[0], 0.2);
    let narrow = SpectrumChoice { range_nm: Some((400.0, 500.0)), ..choice() };
    let half_dark = run(&|i| if i > 50 { 9.3 } else { 0.2 });
    assert_eq!(read_spectrum(half_dark.as_bytes(), &narrow).unwrap().values[0], 0.2);
    // A relative reflectance up to 1.6 stays one.
    let relative = run(&|i| 1.6 * i as f64 / 100.0);
    refused(&relative, "unit_y=\"percent\" or unit_y=\"ratio\"");
    for (unit_y, value) in [("ratio", 1.584), ("percent", 0.01584)] {
        let choice = SpectrumChoice { unit_y: Some(unit_y), ..choice() };
        let found = read_spectrum(relative.as_bytes(), &choice).unwrap().values[99];
        assert!((found - value).abs() < 1e-12, "{unit_y} {found}");
    }
    assert!((read(&run(&|_| 30.0)).values[0] - 0.3).abs() < 1e-15);
    assert_eq!(read(&run(&|i| 3000.0 + i as f64)).values[0], 3000.0);
    let wrong = SpectrumChoice { unit_y: Some("permille"), ..choice() };
    assert!(read_spectrum(relative.as_bytes(), &wrong).unwrap_err().contains("unit_y must be"));
}

#[test]
fn absorbance_row_numbers_and_the_axis_anywhere() {
    let absorbance = "Wavelength (nm),Abs\n400,1.0\n500,0.5\n600,2\n";
    refused(absorbance, "\"Abs\" is absorbance; a reflectance cannot be had from it");
    let transmittance = SpectrumChoice { quantity: "transmittance", ..choice() };
    let spectrum = read_spectrum(absorbance.as_bytes(), &transmittance).unwrap();
    assert_eq!((spectrum.values[0], spectrum.values[2]), (0.1, 0.01));
    said(&spectrum, "T = 10^-A");
    let pandas = ",wavelength,reflectance\n0,400.0,0.35\n1,401.0,0.36\n2,402.0,0.37\n";
    assert_eq!(read(pandas).wavelength_nm, [400.0, 401.0, 402.0]);
    assert_eq!(read("0,400.0,0.35\n1,401.0,0.36\n2,402.0,0.37\n").values, [0.35, 0.36, 0.37]);
    let late = "R;Wellenlänge [nm]\n0,35;400\n0,36;401\n0,37;402\n";
    assert_eq!(read(late).wavelength_nm, [400.0, 401.0, 402.0]);
    let chosen = SpectrumChoice { wavelength_column: Some("2"), column: Some("1"), ..choice() };
    let plain = "0.35 400\n0.36 401\n0.37 402\n";
    assert_eq!(read_spectrum(plain.as_bytes(), &chosen).unwrap().values, [0.35, 0.36, 0.37]);
    refused("nm,%T\n400,1\n500,2\n", "quantity=\"transmittance\" takes it");
}

#[test]
fn several_columns_are_asked_about() {
    refused(
        "nm,R1 refl,R2 refl\n400,0.1,0.2\n401,0.2,0.3\n",
        "which column is the reflectance? \"R1 refl\", \"R2 refl\"",
    );
    refused("400 0.1 0.2\n401 0.2 0.3\n", "\"column 2\", \"column 3\"");
}

#[test]
fn damaged_values_order_and_repeats() {
    let spectrum = read("nm,R\n402,0.3\n401,1e154\n400,0.1\n400,0.3\n");
    assert_eq!(spectrum.wavelength_nm, [400.0, 401.0, 402.0]);
    assert_eq!((spectrum.values[0], spectrum.values[1].is_nan(), spectrum.values[2]), (0.2, true, 0.3));
    for words in ["1 values beyond", "they have been turned", "1 repeated wavelengths"] {
        said(&spectrum, words);
    }
}

#[test]
fn messages_are_harmless_and_short() {
    let long = format!("nm,refl \x1b[31m{},b refl\n400,0.1,0.2\n401,0.2,0.3\n", "x".repeat(5000));
    let error = read_spectrum(long.as_bytes(), &choice()).unwrap_err();
    assert!(error.len() < 320 && !error.contains('\x1b'), "{error}");
}

/// Any spectrum in any dialect, encoding, order and unit of the axis comes back.
#[test]
fn what_is_written_in_any_dialect_is_read_back() {
    let nm: Vec<f64> = (0..40).map(|i| 380.0 + 12.5 * f64::from(i)).collect();
    let values: Vec<f64> = nm.iter().map(|nm| 0.3 + 0.2 * (nm / 37.0).sin()).collect();
    let mut count = 0;
    for (separator, decimal) in [("\t", '.'), ("\t", ','), (";", '.'), (";", ','), (",", '.'), (" ", '.'), (" ", ',')] {
        for (unit, to) in [
            ("nm", (|nm| nm) as fn(f64) -> f64),
            ("um", |nm| nm / 1e3),
            ("Angstrom", |nm| nm * 10.0),
            ("cm-1", |nm| 1e7 / nm),
            ("eV", |nm| 1_239.841_984 / nm),
        ] {
            for percent in [false, true] {
                for turned in [false, true] {
                    for utf16 in [false, true] {
                        for newline in ["\n", "\r\n", "\r"] {
                            let mut lines: Vec<String> = nm
                                .iter()
                                .zip(&values)
                                .map(|(nm, value)| {
                                    let value = if percent { 100.0 * value } else { *value };
                                    format!("{:.12}{separator}{value:.12}", to(*nm)).replace('.', &decimal.to_string())
                                })
                                .collect();
                            if turned {
                                lines.reverse();
                            }
                            let y = if percent { "R[%]" } else { "R" };
                            lines.insert(0, format!("lambda({unit}){separator}{y}"));
                            lines.insert(0, "Probe 12, Faser 200 um, 20 ms".into());
                            let text = lines.join(newline);
                            let bytes: Vec<u8> = if utf16 {
                                text.encode_utf16().flat_map(u16::to_le_bytes).collect()
                            } else {
                                text.clone().into_bytes()
                            };
                            let spectrum =
                                read_spectrum(&bytes, &choice()).unwrap_or_else(|why| panic!("{why}\n{text}"));
                            for i in 0..nm.len() {
                                assert!((spectrum.wavelength_nm[i] / nm[i] - 1.0).abs() < 1e-9, "{text}");
                                assert!((spectrum.values[i] - values[i]).abs() < 1e-9, "{text}");
                            }
                            count += 1;
                        }
                    }
                }
            }
        }
    }
    assert_eq!(count, 7 * 5 * 2 * 2 * 2 * 3);
}
