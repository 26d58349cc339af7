use super::*;

fn read(text: &str) -> Rows {
    Rows::read(text, 2).unwrap_or_else(|why| panic!("{text:?}: {why}"))
}

#[test]
fn the_same_numbers_in_every_dialect() {
    let expected = vec![vec![400.5, 401.0, 401.5], vec![0.25, f64::NAN, -1.5]];
    for (separator, decimal) in [("\t", '.'), ("\t", ','), (";", '.'), (";", ','), (",", '.'), (" ", '.'), ("  ", ',')]
    {
        for (header, names) in [(String::new(), ["", ""]), (format!("Wave{separator}R\n"), ["Wave", "R"])] {
            for trailer in ["", "\nMethod: 7\nend of file\n"] {
                let rows = [["400.5", "2.5E-1"], ["401.0", "---"], ["401.5", "-1.5"]]
                    .map(|row| row.map(|cell| cell.replace('.', &decimal.to_string())).join(separator));
                let text = format!("Probe 7 am 3.4.2019\n{header}{}\n{trailer}", rows.join("\n"));
                let table = read(&text);
                assert_eq!(format!("{:?}", table.columns), format!("{expected:?}"), "{text:?}");
                assert_eq!(table.names, names, "{text:?}");
                assert_eq!(table.missing, 1);
            }
        }
    }
}

#[test]
fn commas_that_do_both_are_read_in_pairs_under_names_or_refused() {
    let rows = "400,1,4,2\n400,6,4,4\n401,1,4,1\n";
    let table = read(&format!("nm,R\n{rows}"));
    assert_eq!(table.columns, [vec![400.1, 400.6, 401.1], vec![4.2, 4.4, 4.1]]);
    let error = Rows::read(rows, 2).unwrap_err();
    assert_eq!(error, "commas both separate and mark decimals (4 fields in line 1); save it with \";\" or with points");
    // Four names over four fields leave one reading.
    assert_eq!(read("nm,a,b,c\n400,1,4,2\n401,6,4,4\n").columns.len(), 4);
}

#[test]
fn thousands_marks_are_refused() {
    for text in
        ["1,000.5;4.2\n1,001.5;4.3\n", "1.000,5\t4,2\n1.001,5\t4,3\n", "\"1,000.5\",\"4.2\"\n\"1,001.5\",\"4.3\"\n"]
    {
        assert!(Rows::read(text, 2).unwrap_err().contains("groups its thousands"), "{text:?}");
    }
    assert!(!is_grouped("400,0.1") && !is_grouped("1234.5") && is_grouped("12,345,678.9"));
    assert!(!is_grouped("0.365,1"), "nothing is grouped behind a nought: two numbers");
    // Fifteen of 401 rows were read, those of three digits, and the others passed over.
    for text in ["nm;counts\n400.0;41\n400.5;61,233\n401.0;812\n", "nm\tcounts\n400.0\t1,233\n400.5\t61,233\n"] {
        assert!(Rows::read(text, 2).unwrap_err().contains("groups its thousands"), "{text:?}");
    }
    // A spectrometer's whole wavelengths before counts of three digits, all of them or some.
    for text in ["446,987.25\n447,912.5\n448,870.0\n", "nm,counts\n446,987.25\n447,1012.5\n448,99.5\n"] {
        assert_eq!(
            (read(text).columns[0].as_slice(), read(text).columns[1][0]),
            ([446.0, 447.0, 448.0].as_slice(), 987.25)
        );
    }
    for text in ["1,000.5\n1,001.5\n1,002.5\n", "1,000.5\n1,001.5\n"] {
        assert!(Rows::read(text, 2).unwrap_err().contains("groups its thousands"), "{text:?}");
    }
    assert_eq!(read("nm;R\n400;1,233\n401;1,234\n").columns[1], [1.233, 1.234], "decimal commas");
    assert_eq!(read("400.5, 123,456\n401.5, 124,457\n").columns.len(), 3);
}

#[test]
fn header_lines_are_no_names_and_second_tables_are_told() {
    let table = read("Fiber (micron): 400\nIntegration time: 20\n400 0.1\n401 0.2\n402 0.3\n");
    assert_eq!((table.names, table.columns[0].len()), (vec![String::new(), String::new()], 3));
    let table = read("a;R\n1;2\n2;3\n3;4\n\nb;T\n1;2\n2;3\n3;4\n4;5\n");
    assert_eq!((table.names, table.others), (vec!["b".to_owned(), "T".to_owned()], vec![(2, 3)]));
    let table = read("WL;Dark;Ref\n[nm];[cts];[%]\n\n400;1;2\n401;1;3\n");
    assert_eq!(table.names, ["WL [nm]", "Dark [cts]", "Ref [%]"]);
    let table = read("# made up\nwavelength n\n400 1.5\n401 1.6\n");
    assert_eq!(table.names, ["wavelength", "n"]);
    // A separator at the end of each row, and short rows.
    let table = read("nm,R,\n400,1,\n401,,\n402,3,\n");
    assert_eq!((table.names.len(), table.missing, table.ragged), (2, 1, None));
    assert_eq!(read("400 1 2\n401 1\n402 1 3\n").ragged, Some((2, 2)));
}

#[test]
fn no_table_is_said_so() {
    for (text, words) in [
        ("", "no table"),
        ("hello\n", "no table"),
        ("500\n501\n502\n", "3 lines of one number each"),
        ("nan,0.1\nnan,0.2\n", "no table"),
    ] {
        let error = Rows::read(text, 2).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    let wide: Vec<String> = (0..2048).map(|i| (400 + i).to_string()).collect();
    assert!(Rows::read(&wide.join(","), 2).unwrap_err().contains("transposed?"));
}
