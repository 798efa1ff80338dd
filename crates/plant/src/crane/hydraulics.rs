//! Properties of oil, valves and seals.
//!
//! Slices of joints, cylinders and states have the lengths of the layout; SI units throughout.

use crate::crane::Crane;
use crate::cylinders::hydraulic_axis::FrictionLaw;

/// Speed up to which passivity of friction is checked, m/s: above that of any hydraulic cylinder.
const FASTEST_PISTON: f64 = 1.0;

/// The passivity condition of one LuGre cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct Passivity {
    pub cylinder: String,
    /// Lowest speed where it fails, m/s; `None`: it holds up to `checked_to`.
    pub fails_at: Option<f64>,
    pub checked_to: f64,
}

pub trait Hydraulics {
    fn orifice_flow(&self, cylinder: usize, spool: f64, pressure_drop: f64) -> f64;
    /// Areas of the edges supply to A, A to tank, supply to B and B to tank over the one that has the nominal flow.
    fn edge_areas(&self, cylinder: usize, spool: f64) -> [f64; 4];
    fn bulk_modulus(&self, p: f64) -> f64;
    fn density(&self, p: f64) -> f64;
    /// Friction at constant velocity.
    fn steady_friction(&self, cylinder: usize, v: f64) -> f64;
    /// Per cylinder with LuGre friction.
    fn passivity(&self) -> Vec<Passivity>;
    /// Largest spool displacement per cylinder, m.
    fn spool_strokes(&self) -> Vec<f64>;
}

impl<const N: usize> Hydraulics for Crane<N> {
    fn orifice_flow(&self, cylinder: usize, spool: f64, pressure_drop: f64) -> f64 {
        self.plant().cylinders[cylinder].valve.edge_a.flow(spool, pressure_drop)
    }

    fn edge_areas(&self, cylinder: usize, spool: f64) -> [f64; 4] {
        let (stroke, valve) = (self.machine.cylinders[cylinder].valve.stroke, &self.plant().cylinders[cylinder].valve);
        valve.edge_openings(spool).map(|opening| opening / (stroke - valve.overlap))
    }

    fn bulk_modulus(&self, p: f64) -> f64 {
        self.plant().fluid.bulk_modulus(p)
    }

    fn density(&self, p: f64) -> f64 {
        self.oil().density(p)
    }

    fn steady_friction(&self, cylinder: usize, v: f64) -> f64 {
        self.plant().cylinders[cylinder].friction.steady(v)
    }

    fn passivity(&self) -> Vec<Passivity> {
        let laws = self.plant().cylinders.iter().zip(&self.machine.cylinders);
        laws.filter_map(|(unit, c)| match &unit.friction {
            FrictionLaw::LuGre { map, bristle } => Some(Passivity {
                cylinder: c.name.clone(),
                fails_at: bristle.passivity_limit(map, FASTEST_PISTON),
                checked_to: FASTEST_PISTON,
            }),
            _ => None,
        })
        .collect()
    }

    fn spool_strokes(&self) -> Vec<f64> {
        self.machine.cylinders.iter().map(|c| c.valve.stroke).collect()
    }
}
