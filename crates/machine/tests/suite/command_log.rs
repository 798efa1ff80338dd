//! `[command] log`: commands from a text file beside the scenario.

use hydrocrane_machine::scenario::Interpolation;
use hydrocrane_machine::{parse_scenario_with, MachineError, Scenario};

const HEAD: &str =
    "[scenario]\nname = \"t\"\nmachine = \"rottne-f9-lab\"\nduration = \"9 s\"\n[command]\nlog = \"drive.csv\"\n";
const LOG: &str = "time [ms],lift,u_jib [mm],cylinder.extension.command\n0,0.01,2,0\n500,0.02,-3,0.001\n";

fn read(rest: &str, log: &str) -> Result<Scenario, MachineError> {
    parse_scenario_with(&format!("{HEAD}{rest}"), "t.toml", &[("drive.csv".to_string(), log.to_string())])
}

#[test]
fn columns_are_found_by_the_names_of_cylinders() {
    let scenario = read("", LOG).unwrap();
    let [lift, extension] = &scenario.commands[..] else { panic!("{:?}", scenario.commands) };
    assert_eq!((lift.cylinder.as_str(), &lift.time[..], &lift.spool[..]), ("lift", &[0.0, 0.5][..], &[0.01, 0.02][..]));
    assert_eq!((extension.cylinder.as_str(), &extension.spool[..]), ("extension", &[0.0, 0.001][..]));
    assert_eq!(lift.interpolation, Interpolation::Linear);
}

#[test]
fn a_table_says_which_column_in_which_unit() {
    let scenario = read("interpolation = \"hold\"\n[command.jib]\ncolumn = \"u_jib\"\n", LOG).unwrap();
    let [jib] = &scenario.commands[..] else { panic!("{:?}", scenario.commands) };
    assert_eq!((&jib.spool[..], jib.interpolation), (&[0.002, -0.003][..], Interpolation::Hold));
    let scenario = read("[command.lift]\nunit = \"cm\"\n", LOG).unwrap();
    assert_eq!(scenario.commands[0].spool, [1e-4, 2e-4]);
}

#[test]
fn what_is_wrong_is_told_at_its_place() {
    for (rest, log, slug, line) in [
        ("", "time,x\n0,1\n", "unknown-reference", 6),
        ("", "time,lift\n0,1\n", "out-of-range", 6),
        ("", "time,lift\n1,0\n0,0\n", "bad-series", 6),
        ("", "time,lift\n1,0\n2\n", "bad-series", 6),
        ("", "clock,lift\n1,0\n", "unknown-reference", 6),
        ("time = \"clock\"\n[command.jib]\ncolumn = \"jib\"\n", "clock,lift\n1,0\n", "unknown-reference", 6),
        ("[command.lift]\nunit = \"bar\"\n", LOG, "wrong-dimension", 6),
        ("[command.lift]\nspool = [\"1 mm\"]\n", LOG, "conflicting-keys", 8),
        ("[command.lifft]\nunit = \"mm\"\n", LOG, "unknown-reference", 7),
        ("[command.lift]\nunits = \"mm\"\n", LOG, "unknown-key", 8),
        ("[joystick]\ntime = [\"0 s\"]\nz = [1]\n", LOG, "conflicting-keys", 7),
    ] {
        let found = read(rest, log).expect_err(rest);
        assert_eq!((found.slug(), found.line()), (slug, Some(line)), "{found}");
    }
    let none = parse_scenario_with(HEAD, "t.toml", &[]).unwrap_err();
    assert_eq!(none.slug(), "unreadable-file", "{none}");
    let other = HEAD.replace(".csv", ".mat");
    assert!(parse_scenario_with(&other, "t.toml", &[]).unwrap_err().to_string().contains("CSV"));
    let alone = HEAD.replace("log = \"drive.csv\"", "time = \"t\"");
    assert_eq!(parse_scenario_with(&alone, "t.toml", &[]).unwrap_err().slug(), "missing-key");
}

fn lift(log: &str) -> Result<Vec<f64>, MachineError> {
    read("[command.lift]\n", log).map(|scenario| scenario.commands[0].spool.clone())
}

#[test]
fn units_are_those_of_a_row_or_of_the_names() {
    for text in [
        "time [s],lift [mm]\n0,1\n1,-2\n",
        "\u{feff}t\tLift (mm)\r\n0\t1\r\n1\t-2\r\n",
        "time;lift\n[s];[mm]\n0;1,0\n\n1;-2,0\n",
        "timestamp,lift\n2024-05-01T12:00:00Z,0.001\n2024-05-01T12:00:01Z,-0.002\n",
        "time;lift [um]\n0.0;1,000\n1.0;-2,000\n",
        "time in ms,lift [0.1 mm]\n0,10\n1000,-20\n",
        "t [degC],time [ms],lift in mm\n20,0,1\n20,1000,-2\n",
        "time [ms],lift [mm]\n2024-05-01T12:00:00Z,1\n2024-05-01T12:00:01Z,-2\n",
        "Date;Time;lift [mm]\n1.5.2024;10:00:00;1\n2.5.2024;11:00:00;-2\n",
    ] {
        assert_eq!(lift(text).unwrap_or_else(|error| panic!("{text}: {error}")), [0.001, -0.002], "{text}");
    }
}

#[test]
fn what_is_no_log_is_told() {
    for (text, told) in [
        ("", "empty"),
        ("0,1\n1,2\n", "no column `time` for the times"),
        ("time,tilt\n0,1\n", "no column `lift`"),
        ("time,lift\n0,1\n1\n", "the last line of the log is cut off"),
        ("time,lift\n0,0,1\n1,0,2\n", "rows of the log have more or fewer cells than its header"),
        ("time,lift [bar]\n0,1\n", "`bar` is not a unit of `lift`; give one of m"),
        ("time,lift [furlong]\n0,1\n", "the unit `furlong` of column `lift` is not known; it must be one of m"),
        ("time,lift [counts]\n0,1\n", "`counts` is not a unit of `lift`"),
        ("TIME,Time,lift\n0,1,1\n", "the log has `TIME` and `Time`; say by its full name which is `time`"),
        ("time,lift [m],lift [mm]\n0,1,1\n", "the log has `lift [m]` and `lift [mm]`; say by its full name"),
        ("time,lift\n1.7e12,0\n1.7000001e12,0\n", "it seems to count ms; call it `time [ms]`, or `time [s]`"),
        ("time,lift\n45000,0\n45000.00001,0\n", "it seems to count d; call it `time [d]`"),
        ("Date;Time;lift\n1/3/2024;1:00:00;0\n4/6/2024;1:00:00;0\n", "a time of day beside the dates in `Date`"),
        ("time,lift\n0,0.01\n1,\n", "row 2"),
        ("time,lift\n0,1\n1,on\n2,3\n", "row 2"),
        ("time;lift\n0;1,500\n1;2,500\n", "`1,500` may mean decimals or thousands"),
        ("time;lift\n0;1.500\n1;2,5\n2;2.5\n", "different decimal marks"),
        ("time,lift\n0,1\n0,2\n", "do not increase"),
    ] {
        let error = lift(text).expect_err(text);
        assert!(error.to_string().contains(told) && error.cure().is_some(), "{text}: {error}");
    }
}

#[test]
fn what_other_columns_decide_is_told() {
    let scenario = read("", "time;lift [um]\n0.0;1,000\n1.0;-2,000\n").unwrap();
    assert!(scenario.warnings[0].text.contains("column `lift` has `1,000`"), "{:?}", scenario.warnings);
}

#[test]
fn what_no_cell_decides_is_said() {
    let log = "time;lift [um]\n0;1,500\n1;2,500\n";
    for (format, spool) in [("1,234.5", [1.5e-3, 2.5e-3]), ("1.234,5", [1.5e-6, 2.5e-6])] {
        let scenario = read(&format!("number-format = \"{format}\"\n"), log).unwrap();
        assert_eq!(scenario.commands[0].spool, spool, "{format}");
    }
    assert!(lift(log).unwrap_err().cure().unwrap().contains("number-format"));
    let wrong = read("number-format = \"1.5\"\n", log).unwrap_err();
    assert!(wrong.to_string().contains("number-format"), "{wrong}");
    for table in
        ["[command]", "[supply]\ntime = [\"0 s\"]\npressure = [\"100 bar\"]", "[joystick]\ntime = [\"0 s\"]\nz = [1]"]
    {
        let text = HEAD.replace("[command]\nlog = \"drive.csv\"", &format!("{table}\nnumber-format = \"1,234.5\""));
        assert_eq!(parse_scenario_with(&text, "t.toml", &[]).unwrap_err().slug(), "missing-key", "{table}");
    }
}
