//! Heads, encodings, quotes, and what is lost.

use crate::values;
use hydrocrane_logs::{decoded, read, Content, Form, Loss, Table};

fn of(text: &str) -> Table {
    read(text, &Form::default()).unwrap_or_else(|fault| panic!("{text}: {fault}"))
}

fn numbers<'a>(table: &'a Table, name: &str) -> &'a [f64] {
    let found = table.columns.iter().find(|column| column.name == name);
    values(found.unwrap_or_else(|| panic!("{name} in {:?}", table.columns)))
}

#[test]
fn usual_ways_to_write_a_log_say_the_same() {
    for (text, units) in [
        ("time,lift\n0,1\n1,-2\n", ["", ""]),
        ("# made by hand\ntime,lift\r\n0,1\r\n1,-2\r\n", ["", ""]),
        ("time,lift\r0,1\r1,-2\r", ["", ""]),
        ("sep=;\ntime;lift\ns;mm\n0;1,0\n\n1;-2,0\n", ["s", "mm"]),
        ("Rig 7;\n;\nRate;1000\ntime;lift\n[s];[mm]\n0;1,0\n1;-2,0\n", ["[s]", "[mm]"]),
        ("time  lift\n 0.0  1\n 1.0 -2\n", ["", ""]),
        ("% time lift\n0 1\n1 -2\n", ["", ""]),
        ("\"time\",\"lift\",\n0,1,\n1,-2,\n", ["", ""]),
        ("time\tlift\t\n0\t1\t\n1\t-2\t\n", ["", ""]),
        ("lift,time\n1,2024-05-01T12:00:00Z\n-2,2024-05-01T12:00:01Z\n", ["", ""]),
    ] {
        let table = of(text);
        assert_eq!([numbers(&table, "time"), numbers(&table, "lift")], [[0.0, 1.0], [1.0, -2.0]], "{text}");
        assert_eq!(
            table.columns.iter().map(|c| c.unit.as_str()).collect::<Vec<_>>(),
            units[..table.columns.len()],
            "{text}"
        );
        assert!(table.notes.is_empty() && table.rows == 2, "{table:?}");
    }
    let bare = of("0 1\n1 -2\n");
    assert_eq!([numbers(&bare, "column 1"), numbers(&bare, "column 2")], [[0.0, 1.0], [1.0, -2.0]]);
    assert!(numbers(&of("a\tb\n\t2\n"), "a")[0].is_nan());
    // An empty cell at the start of a line is a cell.
    assert!(numbers(&of("a\tb\tc\n1\t2\t3\n\t2\t3\n"), "a")[1].is_nan());
}

#[test]
fn a_blank_cell_between_blanks_shifts_no_other() {
    let blank = "time p1 p3\n 0.0   50.0   20.0\n 0.1          20.1\n 0.2   50.2\n 10.0  50.3   20.3\n";
    let table = of(blank);
    assert!(numbers(&table, "p1")[1].is_nan() && numbers(&table, "p3")[2].is_nan() && table.notes.is_empty());
    assert_eq!([numbers(&table, "p3")[1], numbers(&table, "p1")[2]], [20.1, 50.2]);
    // The first row is the short one; and one that stands below no column.
    assert_eq!(numbers(&of("time p1 p3\n 0.0          20.0\n 0.1   50.1   20.1\n"), "p3"), [20.0, 20.1]);
    let table = of("time p1 p3\n0.0 50.0 20.0\n0.1    20.1\n0.2 50.2 20.2\n");
    assert!(numbers(&table, "time")[1].is_nan() && numbers(&table, "p3")[1].is_nan());
    assert_eq!(table.notes[0].0, "ragged-rows");
}

#[test]
fn a_column_without_a_name_counts() {
    let table = of("time;;x;\n0;;1;\n1;;2;\n");
    assert_eq!(table.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>(), ["time", "", "x"]);
}

#[test]
fn whole_numbers_above_points_of_thousands_are_asked_for() {
    let table = of("time,p\n0,900\n1,1.100\n");
    assert_eq!(table.columns[1].content, Content::Lost(Loss::Undecided("1.100".into())));
    assert_eq!(numbers(&of("time,p\n0,0.900\n1,1.100\n"), "p"), [0.9, 1.1]);
}

#[test]
fn times_of_day_are_those_of_the_dates_beside_them() {
    let table = of("Date;Time\n1.5.2024;10:00:00\n1.5.2024;11:00:00\n3.5.2024;12:00:00\n");
    assert_eq!(numbers(&table, "Time"), [0.0, 3600.0, 2.0 * 86_400.0 + 7200.0]);
    assert_eq!(table.columns[0].content, Content::Lost(Loss::DateOf("Time".into())));
}

#[test]
fn what_is_lost_is_told() {
    let lost = |text: &str| match &of(text).columns.last().unwrap().content {
        Content::Lost(loss) => loss.clone(),
        other => panic!("{text}: {other:?}"),
    };
    assert_eq!(lost("t;x\n0;on\n1;off\n"), Loss::Words("on".into()));
    assert_eq!(lost("t;x\n0;1.500\n1;2.500\n"), Loss::Undecided("1.500".into()));
    assert_eq!(lost("t;x\n0;1.5\n1;2,5\n"), Loss::Mixed("1.5".into(), "2,5".into()));
    assert_eq!(lost("t;x;y\n0;1\n1;2\n"), Loss::NoCells);
    assert_eq!(lost("t;x\n0;1/3/2024 1:00:00\n1;4/6/2024 1:00:00\n"), Loss::Dates);
    assert_eq!(lost("Date;Time\n1/3/2024;1:00:00\n4/6/2024;1:00:00\n"), Loss::OfNoDay(vec!["Date".into()]));
    let days = vec!["d".into(), "e".into()];
    assert_eq!(lost("d;e;t\n2024-05-01;2024-05-01;1:00:00\n2024-05-01;2024-05-01;1:00:01\n"), Loss::OfNoDay(days));
    let kinds = |text: &str| of(text).notes.into_iter().map(|(kind, _)| kind).collect::<Vec<_>>();
    assert_eq!(kinds("t,x\n0,0\n1,5\n2\n"), ["truncated"]);
    assert_eq!(kinds("t,x\n0,0\n1,0,5\n"), ["ragged-rows"]);
    let Content::Numbers { values, notes, .. } = &of("t,x\n0,0\n1,off\n2,1\n").columns[1].content else { panic!() };
    assert!(values[1].is_nan() && notes[0].1.contains("1 cells that are not numbers, the first is `off`"), "{notes:?}");
}

#[test]
fn what_is_no_table_is_told() {
    let long = format!("t,x\n0,{}\n1,2\n", "7".repeat(1 << 20));
    let wide = format!("t,x\n0,1\n0{}\n1,2\n", ",1".repeat(2000));
    for (text, told) in [
        ("", "is empty"),
        ("# nothing\n", "is empty"),
        ("time,x\n", "holds 1 line(s) of text and no row of numbers"),
        (&long, "a line of 1048578 letters"),
        (&wide, "2001 columns, more than 2000"),
    ] {
        let fault = read(text, &Form::default()).expect_err(told);
        assert!(fault.what.contains(told), "{fault}");
    }
}

#[test]
fn stated_names_leave_only_rows() {
    let form = Form { delimiter: Some(0x1f), names: vec!["t".into(), "x".into()], ..Form::default() };
    let table = read("0\u{1f}# 1\n\u{1f}\n2\u{1f}3", &form).unwrap();
    assert_eq!((table.rows, numbers(&table, "x")[2]), (3, 3.0));
}

#[test]
fn the_same_text_in_every_encoding() {
    let text = "time;x [µm];φ\n";
    let wide = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
    for bytes in [
        text.as_bytes().to_vec(),
        [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        [&b"\xff\xfe"[..], &wide(u16::to_le_bytes)].concat(),
        [&b"\xfe\xff"[..], &wide(u16::to_be_bytes)].concat(),
    ] {
        assert_eq!(decoded(&bytes).unwrap(), text);
    }
    assert_eq!(decoded(b"x [\xb5m];T [\xb0C] \x80").unwrap(), "x [µm];T [°C] €");
    assert!(decoded(b"\xff\xfe\x00\xd8").unwrap_err().contains("damaged"));
    assert!(decoded(b"MATLAB\0").unwrap_err().contains("binary"));
}

#[test]
fn names_between_blanks_and_in_quotes() {
    for (line, row, wanted) in [
        ("time x p", "0 1 2", &["time", "x", "p"][..]),
        ("time [s]   x [m]", "0 1", &["time [s]", "x [m]"]),
        ("time [s] x [m]", "0 1", &["time [s]", "x [m]"]),
        ("time(s), x, p", "0 1 2", &["time(s)", "x", "p"]),
        ("piston way  load", "0 1", &["piston way", "load"]),
        ("a, \"b, \"\"c\"\"\",\"d", "0,1,2", &["a", "b, \"c\"", "d"]),
        ("a,x [\"],b", "0,1,2", &["a", "x [\"]", "b"]),
    ] {
        let table = of(&format!("{line}\n{row}\n{row}\n"));
        assert_eq!(table.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>(), wanted);
    }
}

#[test]
fn parts_of_a_long_text_are_one_table() {
    const ROWS: usize = 200_000;
    let row = |i: usize| match i {
        150_000 => "# payload = 20\n150000;1.500;2024-01-01T00:00:00;x".to_string(),
        // Only this row says that a comma is the decimal mark.
        199_000 => "199000;2,5;2024-01-01T00:00:00;".into(),
        i => format!("{i};1.{:03};2024-01-01T{:02}:00:00;", i % 1000, i % 24),
    };
    let text: String = (0..ROWS).map(|i| row(i) + "\n").collect();
    let table = of(&format!("n;x;when\n{text}7;1"));
    assert_eq!((table.rows, table.comments.as_slice()), (ROWS, &["# payload = 20".to_string()][..]));
    let kinds: Vec<&str> = table.notes.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(kinds, ["truncated", "ragged-rows"]);
    assert!(table.notes[1]
        .1
        .contains("1 rows have more cells than the 3 of the header, the first begins with `150000`"));
    assert!(numbers(&table, "n").iter().enumerate().all(|(i, n)| *n == i as f64));
    let x = numbers(&table, "x");
    assert_eq!([x[1], x[100_999], x[150_000], x[199_000], x[199_999]], [1001.0, 1999.0, 1500.0, 2.5, 1999.0]);
    let when = numbers(&table, "when");
    assert_eq!([when[23], when[100_007], when[199_999]], [23.0 * 3600.0, 23.0 * 3600.0, 7.0 * 3600.0]);
    assert!(
        matches!(table.columns[3].content, Content::Lost(Loss::Words(_))) || numbers(&table, "column 4")[0].is_nan()
    );
}
