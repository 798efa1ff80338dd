//! The controller model of a crane.

use hydrocrane_control::model::controller_model::{ControllerModel, CylinderModel, PumpModel};
use hydrocrane_control::model::signal_chain::SignalChain;
use hydrocrane_control::model::valve_answer::ValveDynamics;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::pump::{PressureControl, Pump};
use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;
use hydrocrane_plant::cylinders::hydraulic_axis::FrictionLaw;
use hydrocrane_plant::cylinders::supply::Supply;
use hydrocrane_plant::{Crane, Hydraulics, Plant, StateSpace};

/// The crane in the controller model: exact, but without bristle damping and without the ground.
pub fn controller_model<const N: usize>(crane: &Crane<N>) -> ControllerModel<N> {
    let Plant { mechanics, actuations, fluid, supply_pressures, .. } = *crane.plant();
    let slewing = crane.plant().space().filter(|_| crane.machine().slews());
    ControllerModel {
        mechanics,
        space: slewing.copied(),
        actuations,
        cylinders: hydrocrane_num::array::from_fn(|c| cylinder_model(crane, c)),
        fluid,
        supply: supply_pressures.supply,
        tank: supply_pressures.tank,
        pump: crane.plant().supply().and_then(pump_model),
        payload: crane.machine().payload.mass,
        joint_limits: crane.limit_pairs(),
    }
}

/// Several pumps are one that has the sum of their flows, torques and leakages.
fn pump_model(supply: &Supply<f64>) -> Option<PumpModel> {
    let limit = |of: &PressureControl<f64>| of.torque_limit;
    let each = supply.pumps().map(|of| (of.pump, of.control.as_ref().map_or(f64::INFINITY, limit)));
    let (pump, torque_limit) = each.reduce(|(one, torque), (other, more)| (together(&one, &other), torque + more))?;
    Some(PumpModel {
        pump,
        torque_limit,
        highest: supply.highest,
        margin: supply.sensing.as_ref().map(|sensing| sensing.margin),
    })
}

fn together(one: &Pump<f64>, other: &Pump<f64>) -> Pump<f64> {
    let displacement = one.displacement + other.displacement;
    let mean = |a: f64, b: f64| (one.displacement * a + other.displacement * b) / displacement;
    Pump {
        displacement,
        speed: mean(one.speed, other.speed),
        // Both droops at a torque that the pumps share by their displacements.
        droop: mean(one.droop * one.displacement, other.droop * other.displacement) / displacement,
        leakage: one.leakage + other.leakage,
        mechanical_loss: mean(one.mechanical_loss, other.mechanical_loss),
    }
}

/// The valve in the controller model, which has no load-sensing line: with flow sharing the drop over an edge is the
/// pump's margin, as long as the pump holds it.
fn modelled_compensator<const N: usize>(crane: &Crane<N>, of: &Compensator<f64>) -> Compensator<f64> {
    let sensing = crane.plant().supply().and_then(|supply| supply.sensing.as_ref());
    match (of, sensing) {
        (Compensator::Behind, Some(sensing)) => Compensator::Before(sensing.margin),
        (other, _) => *other,
    }
}

/// Cylinder `c` of the crane.
pub(crate) fn cylinder_model<const N: usize>(crane: &Crane<N>, c: usize) -> CylinderModel {
    let (unit, valve) = (&crane.plant().cylinders[c], &crane.machine().cylinders[c].valve);
    let stop = &unit.end_stop;
    let (FrictionLaw::Static { map, .. } | FrictionLaw::Printed { map, .. } | FrictionLaw::LuGre { map, .. }) =
        unit.friction;
    let bristle_stiffness = match unit.friction {
        FrictionLaw::LuGre { bristle, .. } => Some(bristle.stiffness),
        _ => None,
    };
    let (stroke, command) = (crane.spool_strokes()[c], &valve.command);
    CylinderModel {
        chambers: unit.chambers,
        valve: SpoolValve { compensator: modelled_compensator(crane, &unit.valve.compensator), ..unit.valve },
        leakage: unit.leakage,
        friction: map,
        bristle_stiffness,
        stroke,
        chain: SignalChain {
            offset: command.offset,
            gain: command.gain,
            dead_band: command.dead_band,
            limits: [command.low.max(-stroke), command.high.min(stroke)],
        },
        dynamics: ValveDynamics {
            delay: valve.delay + valve.command.delay,
            natural_frequency: unit.spool.natural_frequency,
            damping_ratio: unit.spool.damping_ratio,
        },
        free: [stop.lower + stop.zone, stop.upper - stop.zone],
        tight_to: [0, 1].map(|side| unit.tight_to(side, crane.plant().supply_pressures.tank)),
    }
}
