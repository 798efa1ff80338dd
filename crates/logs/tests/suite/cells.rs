//! Cells as numbers, and what their marks mean.

use crate::{rows, values};
use hydrocrane_logs::{Content, Form, Format, Loss};

#[test]
fn every_cell_of_a_column_is_evidence() {
    for (delimiter, lines, wanted) in [
        (';', &["998,5", "1.001"][..], &[998.5, 1001.0][..]),
        (',', &["\"998.5\"", "\"1,001\""], &[998.5, 1001.0]),
        ('\t', &["1.001", "998,5", "-12"], &[1001.0, 998.5, -12.0]),
        (';', &["0.500", "1.250"], &[0.5, 1.25]),
        (';', &["1.250", "0.500", "1.250"], &[1.25, 0.5, 1.25]),
        (';', &["1 234,5", "1'234,5", "1\u{202f}234\u{a0}567"], &[1234.5, 1234.5, f64::NAN]),
        (';', &["1.234.567,5", "1.500"], &[1234567.5, 1500.0]),
        (';', &["1.234e3", "2.000", "5.", ".5"], &[1234.0, 2.0, 5.0, 0.5]),
        (';', &["1,234e3", "2,5E-1", "1.000"], &[1234.0, 0.25, 1000.0]),
        (' ', &["1234.567", "1.001"], &[1234.567, 1.001]),
    ] {
        let found = rows(delimiter, lines, Form::default());
        let same = values(&found[0]).iter().zip(wanted).all(|(a, b)| a == b || a.is_nan() && b.is_nan());
        assert!(same, "{lines:?}: {found:?}");
    }
}

#[test]
fn other_columns_decide_where_a_column_cannot() {
    let of = |delimiter, lines: &[&str]| rows(delimiter, lines, Form::default()).pop().unwrap();
    let thousands = of(';', &["0.5;2,500", "1.0;-1,250"]);
    assert_eq!(values(&thousands), [2500.0, -1250.0]);
    let Content::Numbers { notes, .. } = &thousands.content else { panic!() };
    assert!(notes[0].0 == "number-format" && notes[0].1.contains("`2,500`"), "{notes:?}");
    assert_eq!(values(&of(';', &["0,5;2,500", "1,0;-1,250"])), [2.5, -1.25]);
    assert_eq!(values(&of(';', &["0,5;2.500", "1,0;-1.250"])), [2500.0, -1250.0]);
    assert_eq!(values(&of(',', &["0,1.500", "1,1.250"])), [1.5, 1.25]);
    assert_eq!(of(';', &["0;1.500", "1;1.250"]).content, Content::Lost(Loss::Undecided("1.500".into())));
    assert_eq!(of(',', &["0,\"1,500\"", "1,\"1,250\""]).content, Content::Lost(Loss::Undecided("1,500".into())));
    assert_eq!(of(';', &["0;1,5", "1;2.5"]).content, Content::Lost(Loss::Mixed("2.5".into(), "1,5".into())));
}

#[test]
fn a_stated_format_decides_and_refuses_what_it_does_not_explain() {
    let form = Form { numbers: Some(Format::Comma), ..Form::default() };
    let found = rows(';', &["1.234", "0,5", "0.5", "x", "", "1 000"], form).remove(0);
    assert_eq!(values(&found)[..2], [1234.0, 0.5]);
    let Content::Numbers { notes, .. } = &found.content else { panic!() };
    assert!(notes[0].1.contains("2 cells that are not numbers, the first is `0.5`"), "{notes:?}");
}

#[test]
fn short_rows_are_filled() {
    let columns = rows(',', &["1,", "2,3", "4", "5, 6 "], Form::default());
    assert_eq!(
        (columns.len(), values(&columns[1])[1], values(&columns[1])[3], values(&columns[1]).len()),
        (2, 3.0, 6.0, 4)
    );
}

#[test]
fn numbers_have_the_same_bits_as_those_of_the_standard_library() {
    let (mut seed, mut texts) = (1_u64, vec!["-0.5".to_string()]);
    for digits in 1..25 {
        for _ in 0..200 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let text = format!("{seed:020}{seed:020}");
            let at = (seed >> 32) as usize % (digits + 1);
            let text = format!("-{}.{}", &text[..at], &text[at..digits]);
            texts.extend([format!("{text}e-07"), format!("{text}E12"), text]);
        }
    }
    let lines: Vec<&str> = texts.iter().map(String::as_str).collect();
    let found = rows(';', &lines, Form::default()).remove(0);
    for (value, text) in values(&found).iter().zip(&texts) {
        assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{text}");
    }
    for text in ["-", ".", "e5", "1e", "1e+", "+.e1", "x1", "1_0", "1 23", "1.23.456", "0,123,456"] {
        assert_eq!(rows(';', &[text], Form::default())[0].content, Content::Lost(Loss::Words(text.into())));
    }
}
