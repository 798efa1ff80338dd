//! Lever control: one stick axis per cylinder, straight to its spool (thesis Figure 76).
//!
//! What an operator without crane-tip control has. Nothing is measured, nothing is corrected.

use crate::interface::controller::{copied_by_clone, Controller, Fault, Measurement, Stick};
use crate::reference::slow_down::checked_levers;

/// Spool command = deflection times the full spool stroke.
#[derive(Debug, Clone, PartialEq)]
pub struct Lever<const N: usize> {
    period: f64,
    /// Spool command at full deflection per cylinder, m.
    full: [f64; N],
}

hydrocrane_num::stored!([const N: usize] Lever<N> { period: f64, full: [f64; N] });

impl<const N: usize> Lever<N> {
    pub fn new(period: f64, full: [f64; N]) -> Self {
        Lever { period, full }
    }
}

impl<const N: usize> Controller for Lever<N> {
    copied_by_clone!();

    fn period(&self) -> f64 {
        self.period
    }

    fn reset(&mut self, _first: &Measurement) {}

    fn step(&mut self, _measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        let Stick::Lever(axes) = stick else { return Err(Fault::WrongStick("lever")) };
        let axes = checked_levers::<N>(axes)?;
        for ((command, deflection), full) in spool.iter_mut().zip(axes).zip(self.full) {
            *command = deflection * full;
        }
        Ok(())
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOTHING: Measurement = Measurement { t: 0.0, q: &[], p: &[] };

    #[test]
    fn an_axis_is_a_share_of_the_stroke() {
        let mut lever = Lever::new(0.01, [0.05, 0.02]);
        let mut spool = [0.0; 2];
        assert_eq!(lever.step(&NOTHING, Stick::Lever(&[-1.0, 0.5]), &mut spool), Ok(()));
        assert_eq!(spool, [-0.05, 0.01]);
    }

    #[test]
    fn bad_sticks_are_faults() {
        let mut lever = Lever::new(0.01, [0.05]);
        let mut spool = [0.0];
        assert_eq!(lever.step(&NOTHING, Stick::Lever(&[1.5]), &mut spool), Err(Fault::BadStick));
        assert_eq!(lever.step(&NOTHING, Stick::Lever(&[f64::NAN]), &mut spool), Err(Fault::BadStick));
        assert_eq!(lever.step(&NOTHING, Stick::Tip(&[0.0; 2]), &mut spool), Err(Fault::WrongStick("lever")));
    }
}
