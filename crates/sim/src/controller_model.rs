//! The controller model: what a controller takes a crane for.

use hydrocrane_control::nominal::{Nominal, NominalCylinder};
use hydrocrane_plant::hydraulic_axis::{FrictionLaw, HydraulicAxis};
use hydrocrane_plant::{Crane, Hydraulics, Plant, StateSpace};

/// What a controller believes of a crane: the truth but for the bristles of its friction and the ground.
pub fn nominal<const N: usize>(crane: &Crane<N>) -> Nominal<N> {
    let Plant { mechanics, actuations, cylinders, fluid, mains, .. } = *crane.plant();
    let strokes = crane.spool_strokes();
    Nominal {
        mechanics,
        actuations,
        cylinders: std::array::from_fn(|c| nominal_cylinder(&cylinders[c], strokes[c])),
        fluid,
        supply: mains.supply,
        tank: mains.tank,
        payload: crane.machine().payload.mass,
        joint_limits: crane.limit_pairs(),
    }
}

pub(crate) fn nominal_cylinder(unit: &HydraulicAxis<f64>, stroke: f64) -> NominalCylinder {
    let stop = &unit.end_stop;
    let (FrictionLaw::Static { map, .. } | FrictionLaw::Printed { map, .. } | FrictionLaw::LuGre { map, .. }) =
        unit.friction;
    NominalCylinder {
        chambers: unit.chambers,
        valve: unit.valve,
        leakage: unit.leakage,
        friction: map,
        stroke,
        free: [stop.lower + stop.zone, stop.upper - stop.zone],
    }
}
