//! Controllers, joysticks, signal chains and keep-out regions in files.

use hydrocrane_machine::scenario::{FaultKind, Interpolation, SensorQuality, StickMode};
use hydrocrane_machine::{load, parse, parse_scenario, MachineError, OverrideValue, Scenario};

const HEAD: &str = "[scenario]\nname = \"t\"\nmachine = \"rottne-f9-lab\"\nduration = \"1 s\"\n";

fn scenario(rest: &str) -> Result<Scenario, MachineError> {
    parse_scenario(&format!("{HEAD}{rest}"), "t.toml", &[])
}

fn slug(rest: &str) -> &'static str {
    scenario(rest).expect_err(rest).slug()
}

#[test]
fn a_tip_stick_with_its_controller() {
    let s = scenario(
        "[controller]\nname = \"tip\"\nperiod = \"10 ms\"\ndelay = \"2 ms\"\nsensors = \"data-sheet\"\n\
         [joystick]\ntime = [\"0 s\", \"0.5 s\"]\nz = [1, 0]\ninterpolation = \"linear\"\ndead-zone = 0.05\n\
         full-speed = \"50 mm/s\"\nramp = \"0.2 s\"\n",
    )
    .unwrap();
    let controller = s.controller.unwrap();
    assert_eq!((controller.name.as_str(), controller.period, controller.delay), ("tip", Some(0.01), 0.002));
    assert_eq!(controller.sensors, SensorQuality::DataSheet);
    let stick = s.joystick.unwrap();
    assert_eq!(stick.axes, [vec![0.0, 0.0], vec![1.0, 0.0]]);
    assert_eq!((stick.mode, stick.interpolation), (StickMode::Tip, Interpolation::Linear));
    assert_eq!((stick.dead_zone, stick.full_speed, stick.ramp), (0.05, Some(0.05), 0.2));
}

#[test]
fn a_joystick_alone_brings_the_controller_of_its_mode() {
    let tip = scenario("[joystick]\ntime = [\"0 s\"]\nx = [1]\n").unwrap();
    assert_eq!(tip.controller.unwrap().name, "tip");
    let lever = scenario("[joystick]\nmode = \"lever\"\ntime = [\"0 s\"]\nlift = [0.5]\n").unwrap();
    assert_eq!(lever.controller.unwrap().name, "lever");
    assert_eq!(lever.joystick.unwrap().axes, [vec![0.5], vec![0.0], vec![0.0]]);
    assert_eq!(scenario("").unwrap().controller, None);
}

#[test]
fn wrong_sticks_are_errors() {
    assert_eq!(slug("[joystick]\ntime = [\"0 s\"]\nx = [1.5]\n"), "out-of-range");
    assert_eq!(slug("[joystick]\ntime = [\"0 s\"]\nx = [1, 0]\n"), "bad-series");
    assert_eq!(slug("[joystick]\ntime = [\"1 s\", \"0 s\"]\nx = [1, 0]\n"), "bad-series");
    assert_eq!(slug("[joystick]\ntime = [\"0 s\"]\n"), "missing-key");
    assert_eq!(slug("[joystick]\ntime = [\"0 s\"]\nlift = [1]\n"), "unknown-key");
    assert_eq!(slug("[joystick]\ntime = [\"0 s\"]\nx = [1]\ndead-zone = 1\n"), "out-of-range");
    assert_eq!(slug("[joystick]\ntime = [\"0 s\"]\nlog = \"a.csv\"\n"), "conflicting-keys");
    assert_eq!(slug("[joystick]\ntime = [\"0 s\"]\nx = [nan]\n"), "not-finite");
}

#[test]
fn wrong_controllers_are_errors() {
    let levers = "[joystick]\nmode = \"lever\"\ntime = [\"0 s\"]\nlift = [1]\n";
    assert_eq!(slug(&format!("[controller]\nname = \"tip\"\n{levers}")), "conflicting-keys");
    assert_eq!(slug("[controller]\n[command.lift]\ntime = [\"0 s\"]\nspool = [\"1 mm\"]\n"), "conflicting-keys");
    let shown = scenario("[controller]\nname = \"tipp\"\n").unwrap_err().to_string();
    assert!(shown.contains("did you mean `tip`"), "{shown}");
}

const STICK: &str = "[joystick]\ntime = [\"0 s\"]\nx = [1]\n";

fn faulty(entries: &str) -> Result<Scenario, MachineError> {
    scenario(&format!("{STICK}[sensor-fault.one]\n{entries}"))
}

#[test]
fn sensors_fail_as_the_file_says() {
    let read = |entries: &str| faulty(entries).unwrap().faults.sensors.remove(0);
    let jump =
        read("signal = \"joint.boom.q\"\nkind = \"jump\"\nsize = \"180 deg\"\nfrom = \"1 s\"\nuntil = \"2 s\"\n");
    assert_eq!(jump.kind, FaultKind::Jump(std::f64::consts::PI));
    assert_eq!((jump.signal.as_str(), jump.from, jump.until), ("joint.boom.q", 1.0, Some(2.0)));
    let length = read("signal = \"joint.extension.q\"\nkind = \"jump\"\nsize = \"-5 mm\"\nfrom = \"1 s\"\n");
    assert_eq!((length.kind, length.until), (FaultKind::Jump(-5e-3), None));
    let pressure = read("signal = \"cylinder.jib.p2\"\nkind = \"jump\"\nsize = \"2 bar\"\nfrom = \"0 s\"\n");
    assert_eq!(pressure.kind, FaultKind::Jump(2e5));
    assert_eq!(read("signal = \"joint.jib.q\"\nkind = \"freeze\"\nfrom = \"1 s\"\n").kind, FaultKind::Freeze);
    assert_eq!(read("signal = \"joint.jib.q\"\nkind = \"drop-out\"\nfrom = \"1 s\"\n").kind, FaultKind::DropOut);
}

#[test]
fn wrong_sensor_faults_are_errors() {
    let slug = |entries: &str| faulty(entries).expect_err(entries).slug();
    let boom = "signal = \"joint.boom.q\"\nfrom = \"1 s\"\n";
    assert_eq!(slug(&format!("{boom}kind = \"freze\"\n")), "invalid-choice");
    assert_eq!(slug(&format!("{boom}kind = \"jump\"\n")), "missing-key");
    assert_eq!(slug(&format!("{boom}kind = \"jump\"\nsize = \"3 mm\"\n")), "wrong-dimension");
    assert_eq!(slug(&format!("{boom}kind = \"jump\"\nsize = 0.1\n")), "missing-unit");
    assert_eq!(slug(&format!("{boom}kind = \"freeze\"\nsize = \"1 deg\"\n")), "conflicting-keys");
    assert_eq!(slug(&format!("{boom}kind = \"freeze\"\nuntil = \"1 s\"\n")), "out-of-range");
    assert_eq!(slug(&format!("{boom}kind = \"freeze\"\nto = \"2 s\"\n")), "unknown-key");
    assert_eq!(slug("signal = \"joint.boom.q\"\nkind = \"freeze\"\n"), "missing-key");
    let shown = faulty("signal = \"joint.bom.q\"\nkind = \"freeze\"\nfrom = \"1 s\"\n").unwrap_err();
    assert_eq!((shown.slug(), shown.line()), ("unknown-reference", Some(9)));
    assert!(shown.to_string().contains("did you mean `joint.boom.q`"), "{shown}");
}

#[test]
fn only_sensors_that_are_read_can_fail() {
    let force =
        "[sensor-fault.one]\nsignal = \"cylinder.lift.force\"\nkind = \"jump\"\nsize = \"1 kN\"\nfrom = \"1 s\"\n";
    assert_eq!(slug(&format!("{STICK}{force}")), "unknown-reference");
    let data_sheet = format!("[controller]\nsensors = \"data-sheet\"\n{STICK}{force}");
    assert_eq!(scenario(&data_sheet).unwrap().faults.sensors[0].kind, FaultKind::Jump(1e3));
    assert_eq!(slug(force), "missing-key");
}

#[test]
fn the_monitor_is_on_off_or_as_usual() {
    let monitor = |line: &str| scenario(&format!("[controller]\n{line}")).unwrap().controller.unwrap().monitor;
    assert_eq!(monitor("monitor = \"on\"\n"), Some(true));
    assert_eq!(monitor("monitor = \"off\"\n"), Some(false));
    assert_eq!(monitor(""), None);
    assert_eq!(slug("[controller]\nmonitor = true\n"), "wrong-type");
}

#[test]
fn a_signal_chain_is_the_identity_until_a_key_says_otherwise() {
    let valve = |changes: &[(&str, &str)]| {
        let changes: Vec<_> =
            changes.iter().map(|(k, v)| (k.to_string(), OverrideValue::Text(v.to_string()))).collect();
        load("rottne-f9-lab", &changes).map(|machine| machine.cylinders[0].valve.command)
    };
    let identity = valve(&[]).unwrap();
    assert_eq!((identity.offset, identity.gain, identity.dead_band, identity.delay), (0.0, 1.0, 0.0, 0.0));
    assert_eq!((identity.low, identity.high), (-0.05, 0.05));
    let chain = valve(&[("valve.lift.command.offset", "1 mm"), ("valve.lift.command.high", "40 mm")]).unwrap();
    assert_eq!((chain.offset, chain.high), (0.001, 0.04));
    let crossed = valve(&[("valve.lift.command.low", "40 mm"), ("valve.lift.command.high", "30 mm")]);
    assert_eq!(crossed.unwrap_err().slug(), "crossed-limits");
    assert_eq!(valve(&[("valve.lift.command.high", "60 mm")]).unwrap_err().slug(), "out-of-range");
    assert_eq!(valve(&[("valve.lift.command.gian", "2")]).unwrap_err().slug(), "unknown-key");
}

fn extended(rest: &str) -> Result<hydrocrane_machine::Machine, MachineError> {
    let class = "class = \"setting\"\n";
    parse(&format!("extends = \"rottne-f9-lab\"\n{}", rest.replace("CLASS\n", class)), "own.toml", &[])
}

#[test]
fn keep_out_regions_are_polygons() {
    let machine =
        extended("[keep-out.ground]\nCLASS\noutline = [\"(-5, -2) m\", \"(8, -2) m\", \"(8, -3) m\"]\n").unwrap();
    let regions = |machine: &hydrocrane_machine::Machine| -> Vec<String> {
        machine.keep_out.iter().map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(regions(&machine), ["ground", "pillar"]);
    assert_eq!(machine.keep_out[0].1, [[-5.0, -2.0], [8.0, -2.0], [8.0, -3.0]]);
    let without = extended("[keep-out.ground]\nstatus = \"inactive\"\n").unwrap();
    assert_eq!(regions(&without), ["pillar"]);
    let misspelt = extended("[keep-out.ground]\nstatus = \"inactiv\"\n").unwrap_err().to_string();
    assert!(misspelt.contains("did you mean `inactive`"), "{misspelt}");
    let line = extended("[keep-out.ground]\nCLASS\noutline = [\"(0, 0) m\", \"(1, 1) m\", \"(2, 2) m\"]\n");
    assert_eq!(line.unwrap_err().slug(), "out-of-range");
    let point = extended("[keep-out.ground]\nCLASS\noutline = []\n");
    assert_eq!(point.unwrap_err().slug(), "out-of-range");
}

#[test]
fn gains_have_units_and_known_names() {
    let machine =
        extended("[control]\nCLASS\nperiod = \"20 ms\"\n[control.tip]\nCLASS\nfull-speed = \"80 mm/s\"\n").unwrap();
    assert_eq!(machine.control.period, Some(0.02));
    assert_eq!(machine.control.gain("tip", "full-speed"), Some(0.08));
    let slug = |rest: &str| extended(rest).expect_err(rest).slug();
    assert_eq!(slug("[control.tip]\nCLASS\nfull-speed = 0.08\n"), "missing-unit");
    assert_eq!(slug("[control.tip]\nCLASS\nfull-speed = \"1 bar\"\n"), "wrong-dimension");
    assert_eq!(slug("[control.tip]\nCLASS\nspeed = \"1 m/s\"\n"), "unknown-key");
    assert_eq!(slug("[control.tpi]\nCLASS\n"), "unknown-key");
}

#[test]
fn the_thesis_controller_has_switches_and_a_weight_per_joint() {
    let steps = extended("").unwrap().control.thesis;
    assert!(steps.working_area && !steps.penalty);
    let thesis = |rest: &str| extended(&format!("[control.heinze-pid]\nCLASS\n{rest}"));
    let machine = thesis("extension = \"penalty\"\nworking-area = \"none\"\nmotion-weight.extension = 0.2\n").unwrap();
    assert!(!machine.control.thesis.working_area && machine.control.thesis.penalty);
    assert_eq!(machine.control.gain("heinze-pid", "motion-weight.extension"), Some(0.2));
    let shown = |rest: &str| thesis(rest).expect_err(rest).to_string();
    assert!(shown("extension = \"penality\"\n").contains("did you mean `penalty`"));
    assert!(shown("motion-weight.extention = 1\n").contains("did you mean `extension`"));
    assert!(shown("middle-weight.jib = -1\n").contains("zero or greater"));
}

#[test]
fn a_sensor_states_what_it_cannot_do_without() {
    let sensor =
        |signal: &str, rest: &str| extended(&format!("[sensor.own]\nCLASS\nmeasures = \"{signal}\"\nkind = {rest}"));
    let encoder = |rest: &str| sensor("joint.boom.qd", &format!("\"incremental-encoder\"\n{rest}"));
    let wire = |rest: &str| sensor("cylinder.lift.x", &format!("\"wire-potentiometer\"\n{rest}"));
    assert_eq!(encoder("").unwrap_err().slug(), "missing-key");
    assert_eq!(wire("").unwrap_err().slug(), "missing-key");
    assert_eq!(wire("range = \"1 m\"\nbits = 12.5\n").unwrap_err().slug(), "out-of-range");
    assert!(encoder("pulses = 500\n").is_ok());
    let transmitter = |live_zero: &str| {
        let rest = format!("\"pressure-transmitter\"\nrange = \"400 bar\"\nlive-zero = \"{live_zero}\"\n");
        sensor("cylinder.lift.p1", &rest)
    };
    assert!(transmitter("10 %").is_ok());
    assert_eq!(transmitter("50 %").unwrap_err().slug(), "out-of-range");
    let other = sensor("joint.boom.q", "\"load-cell\"\nrange = \"5 kN\"\n").unwrap_err();
    assert_eq!(other.slug(), "conflicting-keys");
}

#[test]
fn loads_come_and_go_at_times_above_zero() {
    let s = scenario("[payload]\ntime = [\"2 s\", \"6000 ms\"]\nmass = [\"0.1 t\", \"0 kg\"]\n").unwrap();
    assert_eq!(s.load.changes, [(2.0, 100.0), (6.0, 0.0)]);
    assert!(scenario("").unwrap().load.changes.is_empty());
    assert_eq!(slug("[payload]\ntime = [\"0 s\"]\nmass = [\"1 kg\"]\n"), "out-of-range");
    assert_eq!(slug("[payload]\ntime = [\"1 s\"]\nmass = [\"-1 kg\"]\n"), "out-of-range");
    assert_eq!(slug("[payload]\ntime = [\"1 s\", \"1 s\"]\nmass = [\"1 kg\", \"2 kg\"]\n"), "bad-series");
    assert_eq!(slug("[payload]\ntime = [\"1 s\"]\nmass = []\n"), "bad-series");
    assert_eq!(slug("[payload]\ntime = [\"1 s\"]\n"), "missing-key");
    assert_eq!(slug("[payload]\nmas = [\"1 kg\"]\n"), "unknown-key");
}

#[test]
fn the_controller_model_is_checked_as_the_overrides_are() {
    let s = scenario("[controller.model]\nsupply.pressure = \"100 bar\"\n\"payload.mass\" = \"5 kg\"\n").unwrap();
    let model = s.controller.unwrap().model;
    assert_eq!(model.iter().map(|(key, _)| key.as_str()).collect::<Vec<_>>(), ["supply.pressure", "payload.mass"]);
    let error = scenario("[controller.model]\nsupply.presure = \"100 bar\"\n").unwrap_err();
    assert_eq!((error.slug(), error.line()), ("unknown-key", Some(6)));
    assert_eq!(slug("[controller.model]\nsupply.pressure = 2024-01-01\n"), "wrong-type");
    assert_eq!(slug("[controller]\nmodel = \"heavy\"\n"), "wrong-type");
}
