//! `[errata]`: each correction of the thesis as a switch.

use crate::errors::ErrorKind;
use crate::model::{Cylinder, Errata, Leakage, Machine};
use crate::reading::reader::Reader;
use crate::sections::Result;

pub fn read<T>(root: &Reader, cylinders: &[Cylinder<T>]) -> Result<Errata> {
    let table = root.table("errata")?;
    let corrected = |key: &str| match &table {
        Some(table) => table.choice_or_default(key, &[true, false]),
        None => Ok(true),
    };
    let errata = Errata {
        gravity_sign: corrected("gravity-sign")?,
        inertia_about: corrected("inertia-about")?,
        orifice_law: corrected("orifice-law")?,
        extension_leakage: corrected("extension-leakage")?,
        extension_dead_volume: corrected("extension-dead-volume")?,
        leakage_viscosity: corrected("leakage-viscosity")?,
        end_stop: corrected("end-stop")?,
        friction_map: corrected("friction-map")?,
        ik_quadrant: corrected("ik-quadrant")?,
        ik_unreachable: corrected("ik-unreachable")?,
        ik_extension: corrected("ik-extension")?,
    };
    if let Some(table) = &table {
        check_printed_values(table, &errata, cylinders)?;
    }
    Ok(errata)
}

/// A switch to the printed program needs its printed values.
fn check_printed_values<T>(table: &Reader, errata: &Errata, cylinders: &[Cylinder<T>]) -> Result<()> {
    let leaks_from_piston_side = |cylinder: &Cylinder<T>| {
        matches!(cylinder.leakage, Leakage::Gap { printed_external_from_piston_side: true, .. })
    };
    let needs = [
        (
            errata.extension_leakage,
            "extension-leakage",
            "cylinder.<name>.printed.external-leakage-from",
            cylinders.iter().any(leaks_from_piston_side),
        ),
        (
            errata.extension_dead_volume,
            "extension-dead-volume",
            "cylinder.<name>.printed.dead-volume",
            cylinders.iter().any(|cylinder| cylinder.printed_dead_volume.is_some()),
        ),
        (
            errata.orifice_law,
            "orifice-law",
            "valve.<name>.printed",
            cylinders.iter().all(|cylinder| cylinder.valve.printed_blend.is_some()),
        ),
    ];
    if !errata.orifice_law && cylinders.iter().any(Cylinder::has_line_resistance) {
        let message = "the law of the edges as printed does not go with the resistance of a line";
        return Err(table
            .error(ErrorKind::ConflictingKeys, "orifice-law", message)
            .help("choose \"corrected\", or leave `nominal-flow` of the lines out"));
    }
    match needs.iter().find(|(corrected, _, _, given)| !corrected && !given) {
        Some((_, key, value, _)) => Err(no_printed_value(table, key, value)),
        None => Ok(()),
    }
}

/// As [`check_printed_values`], for the value of the fluid.
pub fn check_printed_viscosity<T>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let table = root.table("errata")?;
    match table {
        Some(table) if !machine.errata.leakage_viscosity && machine.fluid.printed_leakage_viscosity.is_none() => {
            Err(no_printed_value(&table, "leakage-viscosity", "fluid.printed.leakage-viscosity"))
        }
        _ => Ok(()),
    }
}

fn no_printed_value(table: &Reader, key: &str, value: &str) -> crate::errors::MachineError {
    table
        .error(
            ErrorKind::ConflictingKeys,
            key,
            format!("`as-printed` needs `{value}`, which this machine does not give"),
        )
        .help("give the printed value, or keep `corrected`")
}
