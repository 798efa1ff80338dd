//! Cylinders side by side: the laws by lanes against the laws alone.

use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_num::{register_x86::Sse2, Field, Lanes, Pack};
use hydrocrane_plant::axis_derivatives::Piston;
use hydrocrane_plant::axis_group::{AxisGroup, Member};
use hydrocrane_plant::hydraulic_axis::LocalState;
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
        let pressures = plant.supply_pressures.map(&mut Side::c);
        for group in &groups {
            let (rates, plain) = (group.rates(&pressures, &s), group.unit.rates(&group.fluid, &pressures, &s));
            for i in 0..2 {
                let Some(Member { cylinder, .. }) = group.member(i) else { break };
                let alone = plant.cylinders[*cylinder].rates(&plant.fluid, &plant.supply_pressures, &lane(&s, i));
                let here = rates.map(|number| one(number, i));
                assert_eq!(format!("{here:?}"), format!("{alone:?}"));
                assert_eq!(format!("{here:?}"), format!("{:?}", plain.map(|number| one(number, i))));
            }
        }
    }
}

#[test]
fn rates_with_slopes_are_the_rates_and_every_instruction_set_gives_the_same_slopes() {
    let (plant, groups) = groups(false);
    let (s, pressures) = (moving(), plant.supply_pressures.map(&mut Side::c));
    let piston = Piston { lever_arm: Side::c(0.3), lever_arm_derivative: Side::c(0.1), rate: Side::c(0.2) };
    let (linearised, plain) =
        (groups[0].linearised(&pressures, &s, &piston), groups[0].lifted.derivatives(&pressures, &s, &piston));
    assert_eq!(format!("{linearised:?}"), format!("{plain:?}"));
    let (with, without) = (linearised.rates, groups[0].rates(&pressures, &s));
    for (a, b) in [(with.force, without.force), (with.p1_rate, without.p1_rate), (with.z_rate, without.z_rate)] {
        for i in 0..2 {
            assert!((one(a, i) - one(b, i)).abs() <= 1e-14 * one(b, i).abs());
        }
    }
}
