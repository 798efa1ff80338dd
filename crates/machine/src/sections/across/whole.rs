//! Values against the whole machine: the oil, the supply with its relief valve, and the payload.

use super::digits;
use crate::model::Machine;
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;

/// Bulk moduli of oils at the supply pressure, Pa: with a tenth of air and more than that of water under 2000 bar.
const MODULI: [f64; 2] = [1e8, 3.5e9];
/// A relief valve that opens above so many supply pressures limits nothing.
const OPEN: f64 = 3.0;
/// Share of the mass of the moving links that no payload is worth: kg were meant as t, or g as kg.
const THOUSANDTH: f64 = 1.001e-3;

pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    oil(root, machine)?;
    relief(root, machine)?;
    payload(root, machine)
}

/// The modulus that several values make together.
fn oil<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let Some(table) = root.table("fluid")?.filter(|table| table.has("bulk-modulus-max") && !table.is_doubted()) else {
        return Ok(());
    };
    let modulus = machine.fluid.modulus_at(machine.supply.pressure.plain());
    let [low, high] = MODULI;
    if !(low..=high).contains(&modulus) {
        table.required("bulk-modulus-max", "a pressure")?.warn(
            format!(
                "{}: with the other values of the oil it makes {} MPa at the supply pressure",
                if modulus > high { "large" } else { "small" },
                digits(1e-6 * modulus)
            ),
            "check `bulk-modulus-max`, `bulk-c1`, `bulk-c2` and `bulk-reference-pressure` with their units; oils have some 1000 to 2000 MPa".into(),
        );
    }
    Ok(())
}

fn relief<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let Some(mains) = &machine.supply.mains else { return Ok(()) };
    let Some(table) = root.table("mains")?.filter(|table| !table.is_doubted()) else { return Ok(()) };
    let (opens, set) = (mains.relief_pressure.plain(), machine.supply.rated);
    if opens > OPEN * set && table.has("relief-pressure") {
        table.required("relief-pressure", "a pressure")?.warn(
            format!("large: {} bar, and the supply is set to {} bar", digits(1e-5 * opens), digits(1e-5 * set)),
            "check both units; a relief valve is set some 10 to 20 % above the pump".into(),
        );
    }
    Ok(())
}

fn payload<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let Some(table) = root.table("payload")?.filter(|table| !table.is_doubted()) else { return Ok(()) };
    let (mass, moving) = (machine.payload.mass.plain(), machine.moving_mass());
    if 0.0 < mass && mass <= THOUSANDTH * moving {
        table.required("mass", "a mass")?.warn(
            format!("small: {} kg at the tip of links of {} kg", digits(mass), digits(moving)),
            "check its unit: g, kg or t? Write 0 kg for none".into(),
        );
    }
    Ok(())
}
