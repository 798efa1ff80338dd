//! Pumps, mains, load-sensing line and tank line.

use super::laws::{bulk_modulus, rounded};
use hydrocrane_machine::model::{Machine, Mains, Pump, TankLine};
use std::f64::consts::PI;

/// Flow through the tank line at the drop `whole` from the line to the tank, by halving.
fn through_tank_line(line: &TankLine, whole: f64) -> f64 {
    let drop = |q: f64| {
        let own = line.resistance.as_ref().map_or(0.0, |of| of.laminar * q + of.turbulent * q * q.abs());
        let filter = line.filter.as_ref().map_or(0.0, |of| {
            let alone = q * of.nominal_pressure_drop / of.nominal_flow;
            match &of.bypass {
                Some(by) if alone > by.pressure => {
                    let (a, b) = (of.nominal_flow / of.nominal_pressure_drop, of.nominal_flow / by.overpressure);
                    (q + b * by.pressure) / (a + b)
                }
                _ => alone,
            }
        });
        own + filter
    };
    let (mut least, mut most) = (-1.0, 1.0);
    for _ in 0..200 {
        let middle = 0.5 * (least + most);
        if drop(middle) > whole {
            most = middle;
        } else {
            least = middle;
        }
    }
    0.5 * (least + most)
}

/// Rates of the states of the supply, `x`: pressure of the mains, with load sensing that of its line, with a tank line its pressure, and
/// where the pumps swivel the shares of their displacements. The valves draw `drawn`, give `signal` to the load-sensing line and give back
/// `returned`.
pub fn supply_rates(m: &Machine, mains: &Mains, x: &[f64], drawn: f64, signal: f64, returned: f64) -> Vec<f64> {
    let (pumps, tank, p) = (mains.pumps().collect::<Vec<_>>(), m.supply.tank_pressure, x[0]);
    let controlled = mains.pump.control.is_some();
    let share = |k: usize| if controlled { x[x.len() - pumps.len() + k] } else { 1.0 };
    let follows = |highest: f64, pump: &Pump| pump.margin.map_or(highest, |margin| highest.min(x[1] + margin));
    let opens = if controlled { mains.relief_pressure } else { follows(mains.relief_pressure, &mains.pump) };
    let per_angle = |pump: &Pump| pump.displacement / (2.0 * PI);
    let given = |(k, pump): (usize, &&Pump)| {
        // The engine slows down under the torque of the pump.
        let torque = per_angle(pump) * (p - tank) * (share(k) - 1.0 + 1.0 / pump.hydromechanical_efficiency);
        let speed = pump
            .engine
            .as_ref()
            .map_or(pump.speed, |engine| (pump.speed * (1.0 - engine.droop * torque / engine.rated_torque)).max(0.0));
        let leaking =
            (1.0 - pump.volumetric_efficiency) * per_angle(pump) * pump.rated_speed / (m.supply.pressure - tank);
        share(k) * per_angle(pump) * speed - leaking * (p - tank)
    };
    let given: f64 = pumps.iter().enumerate().map(given).sum();
    let relieved = mains.relief_gradient * rounded(p - opens, 0.5e5);
    // Gas that the oil compresses above its precharge.
    let (held, growth) = mains.accumulator.as_ref().map_or((0.0, 0.0), |a| {
        let (atmosphere, within) = (1.013_25e5, 1e5);
        let slope = ((p - a.precharge + within) / (2.0 * within)).clamp(0.0, 1.0);
        let absolute = a.precharge + atmosphere;
        let gas =
            a.volume * (absolute / (absolute + rounded(p - a.precharge, within))).powf(1.0 / a.polytropic_exponent);
        let growth = gas / (a.polytropic_exponent * (absolute + rounded(p - a.precharge, within))) * slope;
        (a.volume - gas, growth)
    });
    let volume = mains.volume + mains.compliance * p + held;
    let inflow = given - relieved - drawn;
    let mut rates = vec![inflow / (volume / bulk_modulus(&m.fluid, p) + mains.compliance + growth)];
    rates.extend(mains.load_sensing.iter().map(|sensing| (signal - x[1]) / sensing.time_constant));
    rates.extend(mains.tank_line.iter().map(|line| {
        let p = x[1 + usize::from(mains.load_sensing.is_some())];
        let capacity = (line.volume + line.compliance * p) / bulk_modulus(&m.fluid, p) + line.compliance;
        (returned + relieved - through_tank_line(line, p - tank)) / capacity
    }));
    rates.extend(pumps.iter().enumerate().filter_map(|(k, pump)| {
        let control = pump.control.as_ref()?;
        let mut wanted = (follows(m.supply.pressure, pump) - p) / control.range;
        if let Some(limit) = control.torque_limit {
            wanted = wanted
                .min(limit / (per_angle(pump) * (p - tank).max(1e3)) - (1.0 / pump.hydromechanical_efficiency - 1.0));
        }
        Some((wanted.clamp(0.0, 1.0) - share(k)) / control.time_constant)
    }));
    rates
}
