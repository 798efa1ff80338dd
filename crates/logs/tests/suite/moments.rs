//! Dates and times of day.

use crate::{rows, values};
use hydrocrane_logs::{Content, DateOrder, Form, Loss};

fn seconds(cells: &[&str]) -> Vec<f64> {
    values(&rows(';', cells, Form::default())[0]).to_vec()
}

#[test]
fn every_country_writes_the_same_instant() {
    for cells in [
        ["2024-12-31T23:59:59.5Z", "2025-01-01 00:00:00.500"],
        ["2024-12-31T23:59:59,5+01:00", "2025-01-01T02:00:00.5+0300"],
        ["2024-12-31T18:59:59.5-05", "2025-01-01T00:00:00.5"],
        ["31.12.2024 23:59:59,5", "1.1.2025 00:00:00,5"],
        ["12/31/2024 11:59:59.5 PM", "1/1/2025 12:00:00.5 am"],
        ["31-12-2024 23:59:59.5", "01-01-2025 00:00:00.5"],
        ["2024/12/31 23:59:59.5", "2025/1/1 0:00:00.5"],
        ["23:59:59.5", "00:00:00.5"],
        ["11:59:59.5pm", "12:00:00.5 AM"],
        ["12:30:59.000000000", "12:30:60.0"],
    ] {
        assert_eq!(seconds(&cells), [0.0, 1.0], "{cells:?}");
    }
    assert_eq!(seconds(&["2024-02-28 12:00", "2024-03-01 12:00"]), [0.0, 2.0 * 86_400.0]);
    assert_eq!(seconds(&["31.12.2024", "1.1.2025", "1.1.2025"]), [0.0, 86_400.0, 86_400.0]);
    assert_eq!(seconds(&["2023-02-28 12:00", "2023-03-01 12:00"]), [0.0, 86_400.0]);
    assert_eq!(seconds(&["0001-01-01 00:00", "1970-01-01 00:00"])[1], 719_162.0 * 86_400.0);
}

#[test]
fn the_first_moment_is_told() {
    for (cell, since) in [
        ("2024-12-31T23:59:59.5Z", 1_735_689_599.5),
        ("2025-01-01T00:59:59.5+01:00", 1_735_689_599.5),
        ("23:59:59.5", 86_399.5),
    ] {
        let found = rows(';', &[cell, cell], Form::default()).remove(0);
        let Content::Numbers { start, .. } = found.content else { panic!("{cell}") };
        assert_eq!(start, Some(since), "{cell}");
    }
}

#[test]
fn what_is_no_moment() {
    for cell in [
        "12:30",
        "1.5",
        "12:75:00",
        "123:00:00",
        "2024-02-30T12:00:00",
        "13/13/2024 12:00:00",
        "32.1.2024 12:00:00",
        "time: x",
        "12:00:00.",
        "12:00:00.5x",
        "2024-05-01T12:00:00+1",
        "0000-01-01T00:00:00",
        "é:00:00",
        "12:00:é",
    ] {
        let found = rows(';', &[cell, cell], Form::default()).remove(0);
        assert!(!matches!(found.content, Content::Numbers { start: Some(_), .. }), "{cell}: {found:?}");
    }
}

#[test]
fn the_order_of_day_and_month() {
    let of = |cells: &[&str], dates| rows(';', cells, Form { dates, ..Form::default() }).remove(0);
    assert_eq!(values(&of(&["02/03/2024 0:00:00", "03/03/2024 0:00:00"], None))[1], 86_400.0);
    assert_eq!(values(&of(&["02/28/2024 0:00:00", "02/29/2024 0:00:00"], None))[1], 86_400.0);
    let apart = ["01/03/2024 12:00:00", "04/06/2024 12:00:00"];
    assert_eq!(of(&apart, None).content, Content::Lost(Loss::Dates));
    assert_eq!(values(&of(&apart, Some(DateOrder::DayMonth)))[1], 95.0 * 86_400.0);
    assert_eq!(values(&of(&apart, Some(DateOrder::MonthDay)))[1], 94.0 * 86_400.0);
}

#[test]
fn words_and_gaps_among_moments() {
    let found = rows(';', &["12:00:00", "", "late", "12:00:02"], Form::default()).remove(0);
    assert!(values(&found)[1].is_nan() && values(&found)[3] == 2.0);
    let Content::Numbers { notes, start: Some(_), .. } = &found.content else { panic!() };
    assert!(notes[0].1.contains("1 cells that are not numbers, the first is `late`"), "{notes:?}");
}
