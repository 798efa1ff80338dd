//! A warning of a return pressure that is high at the full flow of the pump.

use crate::model::{Cylinder, Machine, TankLine};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{supply, Result};

/// Housings of return filters on a tank are rated for 10 bar upwards, Pa.
const HIGH: f64 = 10e5;

/// Warns if the pump's flow, and what a retracting piston returns beyond its feed, raise the pressure of the tank line above [`HIGH`].
pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let Some(mains) = &machine.supply.mains else { return Ok(()) };
    let (Some(line), Some(table)) = (&mains.tank_line, root.table("tank-line")?) else { return Ok(()) };
    let asked = |cylinder: &Cylinder<T>| supply::asked(machine, &cylinder.valve);
    let given = supply::given(&machine.supply, mains, true);
    // A pump with a control gives what is taken; the rest of a fixed one returns through its relief valve.
    let fed = match mains.pump.control {
        Some(_) => given.min(machine.cylinders.iter().map(asked).sum()),
        None => given,
    };
    let returned = |cylinder: &Cylinder<T>| fed + fed.min(asked(cylinder)) * (area_ratio(cylinder) - 1.0);
    let of_cylinders = machine.cylinders.iter().map(|cylinder| (returned(cylinder), &cylinder.name));
    let Some((flow, name)) = of_cylinders.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    let [along, filter] = drops(line, flow);
    let pressure = machine.supply.tank_pressure.plain() + along + filter;
    if pressure <= HIGH {
        return Ok(());
    }
    let (place, cure) = if along > filter {
        (table.required("nominal-pressure-drop", "a pressure")?, "use a wider line")
    } else {
        let own = table.table("filter")?.expect("the filter that has this drop");
        (own.required("nominal-pressure-drop", "a pressure")?, "use a larger filter, or one with a bypass valve")
    };
    place.warn(
        format!(
            "high: the tank line has {:.1} bar while {:.0} l/min return, which happens when `{name}` retracts at the full flow of the pump",
            pressure / 1e5,
            60e3 * flow
        ),
        format!("{cure}; above 10 bar, check the rating of the filter housing, and expect each section to lose this pressure"),
    );
    Ok(())
}

/// Area of the piston side over that of the rod side.
fn area_ratio<T: Number>(cylinder: &Cylinder<T>) -> f64 {
    let [bore, rod] = [&cylinder.bore, &cylinder.rod_diameter].map(|diameter| diameter.plain() * diameter.plain());
    bore / (bore - rod)
}

/// Steady drops over line and filter, Pa, with a flow, m^3/s.
fn drops<T: Number>(of: &TankLine<T>, flow: f64) -> [f64; 2] {
    let along = of.resistance.as_ref().map_or(0.0, |of| flow * (of.laminar.plain() + of.turbulent.plain() * flow));
    let filter = of.filter.as_ref().map_or(0.0, |filter| {
        let nominal = filter.nominal_flow.plain();
        let alone = flow / nominal * filter.nominal_pressure_drop.plain();
        match &filter.bypass {
            Some(bypass) if alone > bypass.pressure.plain() => {
                let [own, beyond] =
                    [&filter.nominal_pressure_drop, &bypass.overpressure].map(|of| nominal / of.plain());
                (flow + beyond * bypass.pressure.plain()) / (own + beyond)
            }
            _ => alone,
        }
    });
    [along, filter]
}
