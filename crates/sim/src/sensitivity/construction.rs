//! From keys to the parameters of the laws: the construction's derivative, by differences.
//!
//! Most keys enter the parameters linearly, where differences are exact to rounding. Elsewhere (diameters, gaps, angles)
//! Richardson's extrapolation of central differences leaves a relative error of the order of the fourth power of the step.

use super::key::Keys;
use super::SensitivityError;
use hydrocrane_machine::Machine;
use hydrocrane_num::Dual;
use hydrocrane_plant::from_machine::plant;
use hydrocrane_plant::hydraulic_axis::FrictionLaw;
use hydrocrane_plant::plant::Plant;

type Result<T> = std::result::Result<T, SensitivityError>;

/// Parameters differentiated by in one pass.
pub const WIDTH: usize = 4;
/// Step relative to the value, and in SI where the value is zero.
const STEP: f64 = 1e-3;

/// Every number that a run with given commands depends on.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<T, const N: usize> {
    pub plant: Plant<T, N>,
    /// kg
    pub payload: T,
    /// Pressure of the chamber that carries less at the start, Pa.
    pub back_pressure: T,
}

impl<const N: usize> Inputs<f64, N> {
    pub fn of(machine: &Machine) -> Result<Self> {
        let (payload, back_pressure) = (machine.payload.mass, machine.equilibrium.back_pressure);
        Ok(Inputs { plant: plant(machine)?, payload, back_pressure })
    }

    fn numbers(&self) -> Vec<f64> {
        let mut all = Vec::new();
        self.map(&mut |number| all.push(number));
        all
    }

    /// The same inputs as duals: `tangents[i]` holds the derivatives of all numbers by parameter `i`.
    pub fn with_tangents(&self, tangents: &[Vec<f64>]) -> Inputs<Dual<f64, WIDTH>, N> {
        let mut index = 0;
        let mut inputs = self.map(&mut |value| {
            let derivative = std::array::from_fn(|i| tangents.get(i).map_or(0.0, |tangent| tangent[index]));
            index += 1;
            Dual { value, derivative }
        });
        inputs.plant.cylinders.iter_mut().for_each(|unit| allow_other_exponents(&mut unit.friction));
        inputs
    }
}

impl<T: Copy, const N: usize> Inputs<T, N> {
    fn map<U>(&self, f: &mut impl FnMut(T) -> U) -> Inputs<U, N> {
        Inputs { plant: self.plant.map(f), payload: f(self.payload), back_pressure: f(self.back_pressure) }
    }
}

/// The short cuts for usual exponents do not see them, so they are no way to differentiate by them.
fn allow_other_exponents(friction: &mut FrictionLaw<Dual<f64, WIDTH>>) {
    let (FrictionLaw::Static { map, .. } | FrictionLaw::Printed { map, .. } | FrictionLaw::LuGre { map, .. }) =
        friction;
    let fixed = |exponents: [Dual<f64, WIDTH>; 2]| exponents.iter().all(|e| e.derivative == [0.0; WIDTH]);
    map.gaussian &= fixed([map.stribeck_exponent_extending, map.stribeck_exponent_retracting]);
    map.three_halves &= fixed([map.viscous_exponent_extending, map.viscous_exponent_retracting]);
}

/// Derivatives of all numbers of the inputs by each key, at the `values` of the keys.
pub fn tangents<const N: usize>(keys: &Keys, values: &[f64], base: &Inputs<f64, N>) -> Result<Vec<Vec<f64>>> {
    let here = base.numbers();
    let tangent = |i: usize| {
        let along = |delta: f64| -> Result<Vec<f64>> {
            let mut moved = values.to_vec();
            moved[i] += delta;
            Ok(Inputs::<f64, N>::of(&keys.machine(&moved)?)?.numbers())
        };
        let step = if values[i] == 0.0 { STEP } else { STEP * values[i].abs() };
        let tangent = derivative(&along, &here, step)?;
        match tangent.iter().any(|derivative| *derivative != 0.0) {
            true => Ok(tangent),
            false => Err(SensitivityError::Key(without_effect(&keys.parameters[i].key))),
        }
    };
    (0..values.len()).map(tangent).collect()
}

fn without_effect(key: &str) -> String {
    format!(
        "`{key}` does not enter the equations of motion of this machine, so a run with given commands does not depend on \
         it, unless by the commands that arrive at the spools, which are held"
    )
}

/// Central where both sides are machines; at the edge of what a value may be, from the side that is one.
fn derivative(along: &dyn Fn(f64) -> Result<Vec<f64>>, here: &[f64], step: f64) -> Result<Vec<f64>> {
    match (along(step), along(-step)) {
        (Ok(ahead), Ok(behind)) => {
            let wide = difference_quotient(&ahead, &behind, 2.0 * step);
            let narrow = difference_quotient(&along(0.5 * step)?, &along(-0.5 * step)?, step);
            Ok(wide.iter().zip(&narrow).map(|(wide, narrow)| (4.0 * narrow - wide) / 3.0).collect())
        }
        (Ok(ahead), Err(_)) => one_sided(along, here, ahead, step),
        (Err(_), Ok(behind)) => one_sided(along, here, behind, -step),
        (Err(error), Err(_)) => Err(error),
    }
}

/// Three differences to one side, extrapolated to the third order.
fn one_sided(along: &dyn Fn(f64) -> Result<Vec<f64>>, here: &[f64], far: Vec<f64>, step: f64) -> Result<Vec<f64>> {
    let wide = difference_quotient(&far, here, step);
    let half = difference_quotient(&along(0.5 * step)?, here, 0.5 * step);
    let quarter = difference_quotient(&along(0.25 * step)?, here, 0.25 * step);
    Ok((0..here.len()).map(|i| (8.0 * quarter[i] - 6.0 * half[i] + wide[i]) / 3.0).collect())
}

/// (b - a) / step, zero where nothing changes, as with limits that are infinite.
fn difference_quotient(b: &[f64], a: &[f64], step: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| if a == b { 0.0 } else { (b - a) / step }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_machine::Template;
    use std::f64::consts::PI;

    /// The rig with one key: its inputs as duals, and the value of the key.
    fn rig(key: &str) -> (Inputs<Dual<f64, WIDTH>, 1>, f64) {
        let template = Template::open("single-cylinder", &[]).expect("bundled");
        let keys = Keys::new(template, &[key.to_string()]).expect("a number");
        let base = Inputs::of(&keys.machine(&keys.values()).expect("as it is")).expect("one joint");
        let derivatives = tangents(&keys, &keys.values(), &base).expect("it enters");
        (base.with_tangents(&derivatives), keys.values()[0])
    }

    #[test]
    fn keys_that_enter_linearly_have_their_slope_to_rounding() {
        let (inputs, _) = rig("supply.pressure");
        assert!((inputs.plant.supply_pressures.supply.derivative[0] - 1.0).abs() < 1e-12);
        assert_eq!(inputs.plant.supply_pressures.tank.derivative[0], 0.0);
        // At the edge of its range: the tank's pressure is zero and cannot be lower.
        let (inputs, value) = rig("supply.tank-pressure");
        assert_eq!(value, 0.0);
        assert!((inputs.plant.supply_pressures.tank.derivative[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn diameters_and_gaps_have_the_slopes_of_their_formulas() {
        let (inputs, bore) = rig("cylinder.test.bore");
        let area = inputs.plant.cylinders[0].chambers.area_1;
        assert!((area.derivative[0] / (PI / 2.0 * bore) - 1.0).abs() < 1e-11);
        let (inputs, gap) = rig("cylinder.test.leakage-gap");
        let internal = inputs.plant.cylinders[0].leakage.internal;
        // pi (r + s) s^3 / (6 eta l)
        let radius = 0.025;
        let relative = gap * internal.derivative[0] / internal.value;
        assert!((relative - 3.0 - gap / (radius + gap)).abs() < 1e-10, "{relative}");
    }

    #[test]
    fn the_short_cut_for_exponents_of_two_is_left_where_they_vary() {
        let gaussian = |key: &str| match rig(key).0.plant.cylinders[0].friction {
            FrictionLaw::LuGre { map, .. } => map.gaussian,
            _ => panic!("the rig has bristles"),
        };
        assert!(gaussian("friction.test.coulomb[0]"));
        assert!(!gaussian("friction.test.stribeck-exponent[1]"));
    }

    #[test]
    fn numbers_keep_their_places() {
        let machine = hydrocrane_machine::load("rottne-f9-lab", &[]).expect("bundled");
        let inputs = Inputs::<f64, 3>::of(&machine).expect("three joints");
        let count = inputs.numbers().len();
        let indices: Vec<f64> = (0..count).map(|i| i as f64).collect();
        let numbered = inputs.with_tangents(&[indices]);
        let mut order = Vec::new();
        numbered.map(&mut |number| order.push(number.derivative[0] as usize));
        assert_eq!(order, (0..count).collect::<Vec<_>>());
    }
}
