//! All numbers on which a run with given commands depends, with their derivatives by keys of the machine file.

use super::SensitivityError;
use hydrocrane_machine::by_keys::Keys;
use hydrocrane_machine::{Machine, Number};
use hydrocrane_num::Dual;
use hydrocrane_plant::equations::from_machine::plant;
use hydrocrane_plant::equations::plant::Plant;

type Result<T> = std::result::Result<T, SensitivityError>;

/// Number of parameters per pass.
pub const WIDTH: usize = 4;
/// A number with its derivatives by the parameters of one pass.
pub type Differentiated = Dual<f64, WIDTH>;

/// Every number that a run with given commands depends on.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<T, const N: usize> {
    pub plant: Plant<T, N>,
    /// kg
    pub payload: T,
    /// Pressure of the less loaded chamber at the start, Pa.
    pub back_pressure: T,
}

impl<T: Number, const N: usize> Inputs<T, N> {
    pub fn of(machine: &Machine<T>) -> Result<Self> {
        let (payload, back_pressure) = (machine.payload.mass, machine.equilibrium.back_pressure);
        Ok(Inputs { plant: plant(machine)?, payload, back_pressure })
    }

    /// All numbers, always in the same order.
    pub fn numbers(&self) -> Vec<T> {
        let mut all = self.plant.numbers();
        all.extend([self.payload, self.back_pressure]);
        all
    }
}

/// Machines at the `values` of the keys, with derivatives by [`WIDTH`] parameters each, in the order of the keys.
pub fn machines_by(keys: &Keys, values: &[f64]) -> Result<Vec<Machine<Differentiated>>> {
    let group = |first: usize| Ok(keys.machine_with(values, first..values.len().min(first + WIDTH))?);
    (0..values.len()).step_by(WIDTH).map(group).collect()
}

/// Refuses a key that does not enter the `inputs`.
pub fn check_effect<const N: usize>(keys: &Keys, inputs: &[Inputs<Differentiated, N>]) -> Result<()> {
    for (group, parameters) in inputs.iter().zip(keys.parameters.chunks(WIDTH)) {
        let numbers = group.numbers();
        let enters = |i: usize| numbers.iter().any(|number: &Differentiated| number.derivative[i] != 0.0);
        if let Some(i) = (0..parameters.len()).find(|i| !enters(*i)) {
            return Err(SensitivityError::Key(without_effect(&parameters[i].key)));
        }
    }
    Ok(())
}

fn without_effect(key: &str) -> String {
    format!(
        "`{key}` does not enter the equations of motion of this machine, so a run with given commands does not depend on \
         it, unless by the commands that arrive at the spools, which are held"
    )
}
