//! `[supply]` of a scenario: a measured pressure from a text file beside it, or by numbers.

use hydrocrane_machine::scenario::{Interpolation, SupplyPressure};
use hydrocrane_machine::{parse_scenario_with, MachineError, OverrideValue, Scenario};

const HEAD: &str = "[scenario]\nname = \"t\"\nmachine = \"rottne-f9-lab\"\nduration = \"9 s\"\n[supply]\n";
const NAMED: &str = "log = \"drive.csv\"\n";
const LOG: &str = "time [ms],supply.pressure [bar],p_s [psi]\n0,140,2000\n500,110,1500\n";

fn read(rest: &str, log: &str) -> Result<Scenario, MachineError> {
    parse_scenario_with(&format!("{HEAD}{rest}"), "t.toml", &[("drive.csv".to_string(), log.to_string())])
}

fn pressure(rest: &str) -> SupplyPressure {
    read(rest, LOG).unwrap_or_else(|error| panic!("{error}")).supply.expect("a pressure")
}

#[test]
fn a_log_and_numbers_say_the_same() {
    let logged = pressure(NAMED);
    assert_eq!((&logged.time[..], logged.interpolation), (&[0.0, 0.5][..], Interpolation::Linear));
    assert_eq!(logged.pressure, [140e5, 110e5]);
    assert_eq!(pressure("time = [\"0 s\", \"0.5 s\"]\npressure = [\"140 bar\", \"110 bar\"]\n"), logged);
    let column = pressure(&format!("{NAMED}column = \"p_s\"\nunit = \"psi\"\ninterpolation = \"hold\"\n"));
    assert!((column.pressure[0] - 2000.0 * 6894.757).abs() < 100.0, "{:?}", column.pressure);
    assert_eq!(column.interpolation, Interpolation::Hold);
}

#[test]
fn an_absolute_pressure_loses_the_air_and_says_so() {
    let scenario = read(NAMED, "time,supply [bara]\n0,101.01325\n1,91.01325\n").unwrap();
    let pressure = scenario.supply.expect("a pressure").pressure;
    assert!((pressure[0] - 100e5).abs() < 1e-6 && (pressure[1] - 90e5).abs() < 1e-6, "{pressure:?}");
    assert!(scenario.warnings[0].text.contains("1.01325 bar of standard atmosphere"), "{:?}", scenario.warnings);
}

#[test]
fn between_its_times_the_pressure_is_joined_or_held() {
    let mut supply = pressure(NAMED);
    assert_eq!((supply.at(-1.0), supply.at(9.0)), ((140e5, 0.0), (110e5, 0.0)));
    assert_eq!(supply.at(0.25), (125e5, -60e5));
    assert_eq!((supply.next_time(0.0), supply.next_time(0.5)), (Some(0.5), None));
    supply.interpolation = Interpolation::Hold;
    assert_eq!((supply.at(0.25), supply.at(0.5)), ((140e5, 0.0), (110e5, 0.0)));
}

#[test]
fn every_stage_has_a_machine_that_takes_it() {
    let scenario = read(&format!("{NAMED}[controller]\nname = \"tip\"\n[phase.late]\ntime = \"1 s\"\n"), LOG).unwrap();
    let yes = ("supply.measured".to_string(), OverrideValue::Text("yes".into()));
    assert!(scenario.stages().iter().all(|stage| stage.overrides.contains(&yes)));
    assert_eq!(scenario.stages().len(), 2);
}

#[test]
fn what_is_wrong_is_told_at_its_place() {
    for (rest, log, slug, line) in [
        ("log = \"drive.csv\"\n", "time,x\n0,1\n", "unknown-reference", 6),
        ("log = \"drive.csv\"\n", "time,supply [mm]\n0,1\n", "wrong-dimension", 6),
        ("log = \"drive.csv\"\n", "time,supply [bar]\n0,-3\n", "out-of-range", 6),
        ("log = \"drive.csv\"\n", "time,supply\n1,0\n0,0\n", "bad-series", 6),
        ("log = \"drive.csv\"\ncolumn = \"ps\"\n", LOG, "unknown-reference", 6),
        ("log = \"drive.csv\"\npressure = [\"1 bar\"]\n", LOG, "conflicting-keys", 7),
        ("column = \"p_s\"\n", LOG, "missing-key", 6),
        ("time = [\"0 s\"]\npressure = [\"1 bar\", \"2 bar\"]\n", LOG, "bad-series", 7),
        ("time = [\"1 s\", \"0 s\"]\npressure = [\"1 bar\", \"2 bar\"]\n", LOG, "bad-series", 6),
        ("logs = \"drive.csv\"\n", LOG, "unknown-key", 6),
    ] {
        let found = read(rest, log).expect_err(rest);
        assert_eq!((found.slug(), found.line()), (slug, Some(line)), "{found}");
    }
    let pumped = format!("{HEAD}{NAMED}").replace("rottne-f9-lab", "rottne-f9-pump");
    let files = [("drive.csv".to_string(), LOG.to_string())];
    let refused = parse_scenario_with(&pumped, "t.toml", &files).unwrap_err();
    assert_eq!((refused.slug(), refused.line()), ("conflicting-keys", Some(5)), "{refused}");
    let by_key = [("supply.measured".to_string(), OverrideValue::Text("yes".into()))];
    assert_eq!(hydrocrane_machine::load("rottne-f9-pump", &by_key).unwrap_err().slug(), "conflicting-keys");
}
