//! Chamber pressures that nothing measures, on a cylinder of the laboratory crane.

use hydrocrane_control::estimate::chamber_estimate::{ChamberEstimate, Sent, Surroundings};
use hydrocrane_control::estimate::observer::Gains;
use hydrocrane_control::model::controller_model::{ControllerModel, CylinderModel};
use hydrocrane_control::model::feed_forward::steady_speed;
use hydrocrane_machine::load;
use hydrocrane_sim::{controller_model, Crane};

const PERIOD: f64 = 0.01;
const FORCE: f64 = 20e3;
const STROKE: f64 = 0.25;
const STIFFNESS: f64 = 1e7;
const BAND: f64 = 2e-4;

fn boom() -> (CylinderModel, Surroundings) {
    let machine = load("rottne-f9-lab", &[]).expect("a valid machine");
    let model: ControllerModel<3> = controller_model(&Crane::new(&machine).expect("a machine that can be built"));
    let supply_pressures = model.supply_pressures();
    (model.cylinders[0], Surroundings { fluid: model.fluid, supply_pressures, period: PERIOD })
}

/// The estimate after `seconds` at rest in its place with the spool at `spool`, m.
fn after(cylinder: &CylinderModel, around: &Surroundings, spool: f64, seconds: f64) -> ChamberEstimate {
    let mut estimate = ChamberEstimate::at(cylinder, STROKE, FORCE, 20e5);
    estimate.sent = Sent { spool, speed: 0.0, planned: FORCE };
    for _ in 0..(seconds / PERIOD).round() as usize {
        estimate.advance(cylinder, around, &Gains::new(2.0, PERIOD), (STROKE, 0.0), STIFFNESS);
    }
    estimate
}

#[test]
fn an_open_valve_brings_the_pressures_to_those_of_steady_motion() {
    let (cylinder, around) = boom();
    let supply = around.supply_pressures;
    for sense in [-1.0, 1.0] {
        for opening in [0.1, 1.0] {
            let estimate = after(&cylinder, &around, cylinder.spool(sense * opening), 20.0);
            // What either edge lets through at this speed, v^2 A^2 / (C x)^2, at full opening.
            let v = steady_speed(&cylinder, &supply, FORCE, sense);
            let x = cylinder.stroke - cylinder.valve.overlap;
            let drop = |area: f64, coefficient: f64| sense * (v * area / (coefficient * x)).powi(2);
            let behind = if sense > 0.0 { [supply.supply, supply.tank] } else { [supply.tank, supply.supply] };
            let expected = [
                behind[0] - drop(cylinder.chambers.area_1, cylinder.valve.edge_a.coefficient),
                behind[1] + drop(cylinder.chambers.area_2, cylinder.valve.edge_b.coefficient),
            ];
            for (p, expected) in estimate.p.iter().zip(expected) {
                // Leakage is the rest.
                assert!((p - expected).abs() < 0.02 * supply.supply, "{sense} {opening}: {p} {expected}");
            }
        }
    }
}

#[test]
fn the_pressures_carry_the_planned_force_at_every_sample() {
    let (cylinder, around) = boom();
    for steps in 1..50 {
        let estimate = after(&cylinder, &around, 0.3 * cylinder.stroke, PERIOD * f64::from(steps));
        let force = cylinder.chambers.force(estimate.p[0], estimate.p[1]);
        assert!((force - FORCE).abs() < 1.0, "{steps}: {force}");
    }
}

#[test]
fn a_piston_off_its_place_is_oil_that_gives_way_as_far_as_its_sensor_tells() {
    let (cylinder, around) = boom();
    let pushed = |count: f64| {
        let mut estimate = after(&cylinder, &around, 0.0, 0.1);
        estimate.advance(&cylinder, &around, &Gains::new(2.0, PERIOD), (STROKE + 1e-4, count), STIFFNESS);
        estimate.force - FORCE
    };
    let share = pushed(0.0) / (-STIFFNESS * 1e-4);
    assert!((0.9..1.0).contains(&share), "{share}");
    assert_eq!(pushed(4e-4), 0.0);
}

#[test]
fn a_piston_that_goes_farther_off_at_rest_is_given_up_until_it_moves() {
    let (cylinder, _) = boom();
    let mut estimate = ChamberEstimate::at(&cylinder, STROKE, FORCE, 20e5);
    for k in 0..100 {
        estimate.hold(true, 1e-3 - 5e-6 * f64::from(k), BAND);
    }
    assert!(!estimate.yields);
    for k in 0..100 {
        estimate.hold(true, 5e-4 + 3e-5 * f64::from(k), BAND);
    }
    assert!(estimate.yields);
    estimate.hold(true, 0.0, BAND);
    assert!(estimate.yields);
    estimate.hold(false, 3e-3, BAND);
    assert!(!estimate.yields);
}
