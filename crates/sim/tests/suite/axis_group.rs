//! Cylinders side by side: the laws by lanes against the laws alone.

use hydrocrane_machine::{load, parse, OverrideValue};
use hydrocrane_num::{lanes::register_x86::Sse2, Field, Lanes, Pack};
use hydrocrane_physics::hydraulics::parts::{AnyParts, NoParts};
use hydrocrane_plant::cylinders::axis_derivatives::Piston;
use hydrocrane_plant::cylinders::axis_group::{AxisGroup, Member};
use hydrocrane_plant::cylinders::local::LocalState;
use hydrocrane_plant::{Crane, Plant, StateSpace};

type Side = Lanes<Sse2>;

/// The laboratory crane, with a static map on one cylinder if `mixed`.
fn groups(mixed: bool) -> (Plant<f64, 3>, Vec<AxisGroup<Side>>) {
    let other = [("friction.jib.model".to_string(), OverrideValue::Text("static".to_string()))];
    let machine = load("rottne-f9-lab", if mixed { &other } else { &[] }).expect("a bundled machine");
    let crane = Crane::<3>::new(&machine).expect("three joints");
    let layout = crane.layout().clone();
    let plant = *crane.plant();
    (plant, AxisGroup::all(&plant.cylinders, &plant.fluid, &layout))
}

fn moving() -> LocalState<Side> {
    LocalState {
        x: Lanes::load(&[0.02, -0.1]),
        v: Lanes::load(&[0.1, -0.03]),
        p1: Lanes::load(&[60e5, -0.4e5]),
        p2: Lanes::load(&[20e5, 90e5]),
        spool: Lanes::load(&[0.004, -0.01]),
        z: Lanes::load(&[1e-4, -2e-4]),
        opening: None,
    }
}

fn one(lanes: Side, i: usize) -> f64 {
    lanes.lane(i)
}

fn lane(s: &LocalState<Side>, i: usize) -> LocalState<f64> {
    s.map(|number| number.lane(i))
}

#[test]
fn side_by_side_the_laws_say_bit_for_bit_what_they_say_alone() {
    for mixed in [false, true] {
        let (plant, groups) = groups(mixed);
        assert_eq!(groups.len(), 2);
        let s = moving();
        let pressures = plant.supply_pressures.map(&mut |number| Side::c(*number));
        for group in &groups {
            let (rates, plain) =
                (group.rates(&pressures, &s), group.unit.rates::<AnyParts>(&group.fluid, &pressures, &s));
            for i in 0..2 {
                let Some(Member { cylinder, .. }) = group.member(i) else { break };
                let alone =
                    plant.cylinders[*cylinder].rates::<AnyParts>(&plant.fluid, &plant.supply_pressures, &lane(&s, i));
                let here = rates.map(|number| one(number, i));
                assert_eq!(format!("{here:?}"), format!("{alone:?}"));
                assert_eq!(format!("{here:?}"), format!("{:?}", plain.map(|number| one(number, i))));
                let of_states = group.state_rates(&pressures, &s).map(|number| one(number, i));
                assert_eq!(format!("{of_states:?}"), format!("{:?}", alone.of_states()));
            }
        }
    }
}

#[test]
fn rates_with_slopes_are_the_rates_and_every_instruction_set_gives_the_same_slopes() {
    let (plant, groups) = groups(false);
    let (s, pressures) = (moving(), plant.supply_pressures.map(&mut |number| Side::c(*number)));
    let piston = Piston { lever_arm: Side::c(0.3), lever_arm_derivative: Side::c(0.1), rate: Side::c(0.2) };
    let (linearised, plain) = (
        groups[0].linearised(&pressures, &s, &piston),
        groups[0].lifted.derivatives::<AnyParts>(&pressures, &s, &piston),
    );
    assert_eq!(format!("{linearised:?}"), format!("{plain:?}"));
    let (with, without) = (linearised.rates, groups[0].state_rates(&pressures, &s));
    for (a, b) in [(with.force, without.force), (with.p1_rate, without.p1_rate), (with.z_rate, without.z_rate)] {
        for i in 0..2 {
            assert!((one(a, i) - one(b, i)).abs() <= 1e-14 * one(b, i).abs());
        }
    }
}

#[test]
fn laws_without_parts_say_what_laws_with_them_say_of_a_section_that_has_none() {
    let (plant, groups) = groups(false);
    let (s, pressures) = (moving(), plant.supply_pressures.map(&mut |number| Side::c(*number)));
    for group in &groups {
        assert!(!group.unit.has_parts());
        let with = group.unit.rates::<AnyParts>(&group.fluid, &pressures, &s);
        let without = group.unit.rates::<NoParts>(&group.fluid, &pressures, &s);
        assert_eq!(format!("{with:?}"), format!("{without:?}"));
    }
}

#[test]
fn a_section_with_a_single_part_has_parts() {
    let section = |more: &str| {
        let text = format!("extends = \"rottne-f9-lab\"\n[machine]\nclass = \"assumed\"\n{more}\n");
        let machine = parse(&text, "part.toml", &[]).unwrap_or_else(|error| panic!("{more}: {error}"));
        let crane = Crane::<3>::new(&machine).expect("three joints");
        crane.plant().cylinders[0]
    };
    assert!(!section("").has_parts());
    let at = "cylinder = \"lift\"\nside = \"piston-side\"\n";
    for part in [
        "[valve.lift]\nload-check = \"yes\"".to_string(),
        "[valve.lift]\ncompensator = \"before-spool\"\ncompensator-setting = \"8 bar\"".to_string(),
        "[valve.lift]\nreturn-pressure = [\"5 bar\", \"5 bar\"]".to_string(),
        "[valve.lift.metering.supply-to-a]\ntravel = [0, 1]\narea = [0, 1]".to_string(),
        format!("[counterbalance.c]\n{at}setting = \"200 bar\"\npilot-ratio = 3\nnominal-flow = \"40 l/min\"\nnominal-pressure-drop = \"10 bar\""),
        format!("[port-relief.r]\n{at}setting = \"200 bar\"\nnominal-flow = \"40 l/min\""),
        format!("[anti-cavitation.a]\n{at}nominal-flow = \"40 l/min\"\nnominal-pressure-drop = \"2 bar\""),
        format!("[crossover-relief.x]\n{at}setting = \"100 bar\"\nnominal-flow = \"40 l/min\""),
        format!("[line.l]\n{at}length = \"3 m\"\ninner-diameter = \"12 mm\"\ncompliance = \"0.08 ml/bar\""),
        format!("[line.l]\n{at}length = \"3 m\"\ninner-diameter = \"12 mm\"\nnominal-flow = \"40 l/min\"\nnominal-pressure-drop = \"2 bar\""),
        format!("[hose-leak.h]\n{at}opening = \"1 mm^2\""),
    ] {
        assert!(section(&part).has_parts(), "{part}");
    }
}
