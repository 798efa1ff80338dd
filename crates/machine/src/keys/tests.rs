//! Declarations are whole, and the reader asks for every one of them. (For a key without a declaration it cannot ask:
//! that panics.)

use super::{asked, Key, Value, MACHINE, SCENARIO};
use crate::units::parse_scalar;
use crate::{bundled_machines, bundled_scenarios, load, load_scenario, parse, parse_scenario, parse_scenario_with};

/// Every declaration with its dotted path.
fn all(keys: &'static [Key], path: &str, found: &mut Vec<(String, &'static Key)>) {
    for key in keys {
        let path = format!("{path}.{}", key.name);
        found.push((path.clone(), key));
        if let Value::Table(below) | Value::Tables(below) = key.value {
            all(below, &path, found);
        }
    }
}

fn declarations() -> Vec<(String, &'static Key)> {
    let mut found = Vec::new();
    all(MACHINE, "machine file", &mut found);
    all(SCENARIO, "scenario file", &mut found);
    found
}

/// What no bundled file has.
const MACHINE_WITH_MORE: &str = r#"
    extends = "rottne-f9-lab"
    [machine]
    class = "assumed"
    [pump.main]
    type = "load-sensing"
    ls-margin = "20 bar"
    displacement = "45 ml"
    speed = "1500 rpm"
    rated-speed = "1500 rpm"
    droop = "5 %"
    rated-torque = "150 N m"
    volumetric-efficiency = 0.95
    hydromechanical-efficiency = 0.92
    [mains]
    volume = "2 l"
    [valve.jib]
    return-pressure = ["20 bar", "3 bar"]
    return-pressure-range = "4 bar"
    [valve.lift.metering.supply-to-a]
    travel = [0, 0.1, 1]
    area = [0, 0, 1]
    [valve.lift.metering.a-to-tank]
    travel = [0, 1]
    flow = ["0 l/min", "3 l/min"]
    [ground]
    height = "-2 m"
    support.bunk = { height = "-1 m", from = "1 m", to = "2 m" }
    [control.heinze-pid]
    motion-weight.boom = 1
    middle-weight.boom = 1
    [control.plausibility]
    jump = "1 mm"
    [control.tip]
    position-gain = "4 1/s"
    [sensor.a]
    measures = "cylinder.lift.force"
    kind = "load-cell"
    full-scale = "10 kN"
    [sensor.b]
    measures = "cylinder.jib.x"
    kind = "wire-potentiometer"
    span = "1 m"
    offset = "10 mm"
    [port-relief.lift]
    cylinder = "lift"
    side = "piston-side"
    setting = "250 bar"
    nominal-flow = "40 l/min"
    [crossover-relief.jib]
    cylinder = "jib"
    side = "piston-side"
    setting = "120 bar"
    nominal-flow = "40 l/min"
    [anti-cavitation.lift]
    cylinder = "lift"
    side = "rod-side"
    nominal-flow = "40 l/min"
    nominal-pressure-drop = "2 bar"
    [tank-line]
    volume = "5 l"
    nominal-flow = "60 l/min"
    nominal-pressure-drop = "2 bar"
    [tank-line.filter]
    nominal-flow = "60 l/min"
    nominal-pressure-drop = "0.5 bar"
    bypass-pressure = "1.5 bar"
    [priority]
    cylinder = "jib"
    margin = "5 bar"
    [accumulator.main]
    volume = "1 l"
    precharge = "90 bar"
    [line.jib]
    cylinder = "jib"
    side = "piston-side"
    length = "3 m"
    inner-diameter = "10 mm"
    [line.extension-rod]
    cylinder = "extension"
    side = "rod-side"
    volume = "0.2 l"
    nominal-flow = "30 l/min"
    nominal-pressure-drop = "4 bar"
    laminar-share = 0.4
    [hose-leak.extension]
    cylinder = "extension"
    side = "rod-side"
    opening = "2 mm^2"
    [pilot-check.lift]
    cylinder = "lift"
    side = "rod-side"
    pilot-ratio = 3
    nominal-flow = "40 l/min"
    nominal-pressure-drop = "10 bar"
    [hose-burst.extension]
    cylinder = "extension"
    side = "piston-side"
    closing-flow = "60 l/min"
    nominal-flow = "40 l/min"
    nominal-pressure-drop = "2 bar"
    [link.boom.body.hose]
    mass = "1 kg"
    centre-of-gravity = "(1, 0.1, 0) m"
    inertia = "0.1 kg m^2"
    inertia-x = "0.01 kg m^2"
    inertia-z = "0.1 kg m^2"
    inertia-xy = "0 kg m^2"
    inertia-xz = "0 kg m^2"
    inertia-yz = "0 kg m^2"
    [counterbalance.lift]
    cylinder = "lift"
    side = "piston-side"
    setting = "120 bar"
    pilot-ratio = 4
    nominal-flow = "40 l/min"
    nominal-pressure-drop = "10 bar"
"#;
const SCENARIO_WITH_MORE: &str = r#"
    [scenario]
    name = "all"
    machine = "rottne-f9-lab"
    duration = "1 s"
    [initial]
    joint.boom = "60 deg"
    pressure = { lift = "10 bar", jib = "10 bar", extension = "10 bar" }
    [payload]
    time = ["0.2 s"]
    mass = ["10 kg"]
    [joystick]
    mode = "lever"
    time = ["0 s"]
    lift = [0]
    [goal]
    time = ["0.5 s"]
    x = ["2 m"]
    z = ["0 m"]
    speed = ["0.1 m/s"]
    [controller]
    [supply]
    time = ["0 s", "1 s"]
    pressure = ["140 bar", "120 bar"]
    [phase.late]
    time = "0.5 s"
    controller = { name = "tip", period = "10 ms" }
    joystick = { time = ["0 s"], x = [0], precision = [0.5] }
    [phase.later]
    time = "0.6 s"
    joystick = { mode = "lever", time = ["0 s"], lift = [0] }
    [burst.lift]
    cylinder = "lift"
    side = "piston-side"
    time = "0.4 s"
    opening = "20 mm^2"
    [sensor-fault.a]
    signal = "joint.boom.q"
    kind = "jump"
    size = "1 deg"
    from = "0.1 s"
"#;

const SCENARIO_WITH_A_LOG: &str = r#"
    [scenario]
    name = "log"
    machine = "single-cylinder"
    duration = "1 s"
    [command]
    log = "drive.csv"
    time = "clock"
    number-format = "1,234.5"
    interpolation = "hold"
    [command.test]
    column = "up"
    unit = "mm"
    [supply]
    log = "drive.csv"
    column = "feed"
    unit = "bar"
    time-column = "clock"
    number-format = "1,234.5"
    interpolation = "linear"
"#;

#[test]
fn every_declared_key_is_read() {
    for (name, _) in bundled_machines() {
        load(name, &[]).unwrap();
    }
    for (name, _) in bundled_scenarios() {
        load_scenario(name, &[]).unwrap();
    }
    parse(MACHINE_WITH_MORE, "more.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    parse_scenario(SCENARIO_WITH_MORE, "more.toml", &[]).unwrap_or_else(|error| panic!("{error}"));
    let log = [("drive.csv".to_string(), "clock,up,feed\n0,0,100\n".to_string())];
    parse_scenario_with(SCENARIO_WITH_A_LOG, "log.toml", &log).unwrap_or_else(|error| panic!("{error}"));
    // These are read before files are merged.
    let of_the_loader = ["machine file.extends", "machine file.include", "machine file.without"];
    let unread =
        declarations().into_iter().filter(|(path, key)| !asked::has(key) && !of_the_loader.contains(&path.as_str()));
    assert_eq!(unread.map(|(path, _)| path).collect::<Vec<_>>(), [] as [&str; 0]);
}

#[test]
fn each_range_is_ordered_and_in_one_unit() {
    for (path, key) in declarations() {
        for (low, high, margin) in key.usual {
            let [from, to] = [low, high].map(|text| parse_scalar(text).unwrap_or_else(|_| panic!("{path}: {text}")));
            assert!(from.1.dimension == to.1.dimension, "{path}");
            assert!(from.1.to_si(from.0) < to.1.to_si(to.0) && *margin >= 1.0, "{path}");
        }
    }
}

#[test]
fn each_default_is_a_value_that_its_key_may_have() {
    for (path, key) in declarations() {
        for text in key.defaults {
            if let Value::Choice(choices) = key.value {
                assert!(choices.contains(text), "{path}: {text}");
                continue;
            }
            let (_, unit) = parse_scalar(text).unwrap_or_else(|_| panic!("{path}: {text}"));
            let fits = key.kinds().iter().any(|kind| kind.quantity().dimension == unit.dimension);
            assert!(fits, "{path}: {text}");
        }
    }
}
