//! The controller model of a crane.

use hydrocrane_control::controller_model::{ControllerModel, CylinderModel};
use hydrocrane_plant::hydraulic_axis::{FrictionLaw, HydraulicAxis};
use hydrocrane_plant::{Crane, Hydraulics, Plant, StateSpace};

/// The crane as a controller models it: exact, but without the bristles of friction and without the ground.
pub fn controller_model<const N: usize>(crane: &Crane<N>) -> ControllerModel<N> {
    let Plant { mechanics, actuations, cylinders, fluid, supply_pressures, .. } = *crane.plant();
    let strokes = crane.spool_strokes();
    ControllerModel {
        mechanics,
        actuations,
        cylinders: std::array::from_fn(|c| cylinder_model(&cylinders[c], strokes[c])),
        fluid,
        supply: supply_pressures.supply,
        tank: supply_pressures.tank,
        payload: crane.machine().payload.mass,
        joint_limits: crane.limit_pairs(),
    }
}

pub(crate) fn cylinder_model(unit: &HydraulicAxis<f64>, stroke: f64) -> CylinderModel {
    let stop = &unit.end_stop;
    let (FrictionLaw::Static { map, .. } | FrictionLaw::Printed { map, .. } | FrictionLaw::LuGre { map, .. }) =
        unit.friction;
    CylinderModel {
        chambers: unit.chambers,
        valve: unit.valve,
        leakage: unit.leakage,
        friction: map,
        stroke,
        free: [stop.lower + stop.zone, stop.upper - stop.zone],
    }
}
