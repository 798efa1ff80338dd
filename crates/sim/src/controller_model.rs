//! The controller model of a crane.

use hydrocrane_control::controller_model::{ControllerModel, CylinderModel, PumpModel};
use hydrocrane_control::signal_chain::SignalChain;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::pump::{PressureControl, Pump};
use hydrocrane_physics::hydraulics::spool_valve::SpoolValve;
use hydrocrane_plant::hydraulic_axis::FrictionLaw;
use hydrocrane_plant::supply::Supply;
use hydrocrane_plant::{Crane, Hydraulics, Plant, StateSpace};

/// The crane in the controller model: exact, but without bristle damping and without the ground.
pub fn controller_model<const N: usize>(crane: &Crane<N>) -> ControllerModel<N> {
    let Plant { mechanics, actuations, fluid, supply_pressures, .. } = *crane.plant();
    ControllerModel {
        mechanics,
        actuations,
        cylinders: hydrocrane_num::array::from_fn(|c| cylinder_model(crane, c)),
        fluid,
        supply: supply_pressures.supply,
        tank: supply_pressures.tank,
        pump: crane.plant().supply.as_ref().map(pump_model),
        payload: crane.machine().payload.mass,
        joint_limits: crane.limit_pairs(),
    }
}

/// Several pumps are one that has the sum of their flows, torques and leakages.
fn pump_model(supply: &Supply<f64>) -> PumpModel {
    let (mut pump, limit) =
        (supply.pump, |of: &Option<PressureControl<f64>>| of.as_ref().map_or(f64::INFINITY, |of| of.torque_limit));
    let mut torque_limit = limit(&supply.control);
    for of in supply.further.iter().flatten() {
        let displacement = pump.displacement + of.pump.displacement;
        let mean = |a: f64, b: f64| (pump.displacement * a + of.pump.displacement * b) / displacement;
        // Both droops at a torque that the pumps share by their displacements.
        let droop = mean(pump.droop * pump.displacement, of.pump.droop * of.pump.displacement) / displacement;
        pump = Pump {
            displacement,
            speed: mean(pump.speed, of.pump.speed),
            droop,
            leakage: pump.leakage + of.pump.leakage,
            rubbing: mean(pump.rubbing, of.pump.rubbing),
        };
        torque_limit += limit(&of.control);
    }
    PumpModel {
        pump,
        torque_limit,
        highest: supply.highest,
        margin: supply.sensing.as_ref().map(|sensing| sensing.margin),
    }
}

/// The valve in the controller model, which has no load-sensing line: with flow sharing the drop over an edge is the
/// pump's margin, as long as the pump holds it.
fn modelled_compensator<const N: usize>(crane: &Crane<N>, of: &Compensator<f64>) -> Compensator<f64> {
    let sensing = crane.plant().supply.as_ref().and_then(|supply| supply.sensing.as_ref());
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
        delay: valve.delay + valve.command.delay + 2.0 * unit.spool.damping_ratio / unit.spool.natural_frequency,
        free: [stop.lower + stop.zone, stop.upper - stop.zone],
    }
}
