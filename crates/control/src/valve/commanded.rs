//! What one valve was asked for, and what has reached the piston and its oil of it.  theory: docs/theory/control/valve.md

use crate::model::controller_model::CylinderModel;
use crate::model::valve_answer::{UnderWay, ValveAnswer};

#[derive(Debug, Clone, Copy)]
pub struct Commanded {
    pub answer: ValveAnswer,
    period: f64,
    /// Speed that the valve should give over this period, m/s.
    pub expected: f64,
    speeds: UnderWay,
    /// Forces that the reference needed, N, with all friction, and of load and inertia alone: those of the last command, and those that have
    /// reached the oil.
    asked: [f64; 2],
    pub needed: [f64; 2],
    forces: [UnderWay; 2],
    /// Spool position that was asked for last, m.
    pub spool: f64,
}

impl Commanded {
    /// Nothing but what holds `load` (N); `period` in s.
    pub fn at(cylinder: &CylinderModel, period: f64, load: f64) -> Self {
        let answer = ValveAnswer::new(&cylinder.dynamics, period);
        Commanded {
            answer,
            period,
            expected: 0.0,
            speeds: UnderWay::at(0.0, &answer),
            asked: [load; 2],
            needed: [load; 2],
            forces: [UnderWay::at(load, &answer); 2],
            spool: 0.0,
        }
    }

    /// Sends a command for the spool position `spool` (m), which gives `speed` (m/s), for a reference that needs the `forces` (N).
    pub fn send(&mut self, spool: f64, speed: f64, forces: [f64; 2]) {
        (self.spool, self.asked) = (spool, forces);
        self.expected = self.speeds.send(speed, &self.answer);
        self.needed = hydrocrane_num::array::from_fn(|i| self.forces[i].send(forces[i], &self.answer));
    }

    /// Travel that is left to the piston by the commands that are under way, m.
    pub fn under_way(&self) -> f64 {
        self.period * self.speeds.sum(&self.answer)
    }

    /// By how much the force with all friction that was asked for last exceeds the one that has reached the oil, N.
    pub fn force_to_come(&self) -> f64 {
        self.asked[0] - self.needed[0]
    }
}
