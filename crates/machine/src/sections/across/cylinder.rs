//! A cylinder's diameters, volumes, stop and leakage against each other, and its pins against its joint.

use super::{digits, Sizes};
use crate::model::{Cylinder, JointKind, Leakage, Machine, RodPin};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::closure::{from_joint, split};
use crate::sections::Result;
use std::f64::consts::PI;

/// Area ratios of ISO 7181, piston side over rod side, from the thinnest rod to the thickest, with room for rounded diameters.
const AREA_RATIOS: [f64; 2] = [1.05, 5.5];
/// A retracted cylinder is no longer than so many strokes, or than its stroke and ends of so many bores. Those of real cranes have 1.1 to
/// 2.3 strokes, and ends of 1.4 to 7.2 bores.
const LONGEST: f64 = 4.0;
const ENDS: f64 = 7.0;
/// The share of a stroke that the supply may take up by compressing the dead volume alone.
const COMPRESSED: f64 = 0.1;
/// The least passage between valve and piston: so long, m, at this speed of the oil, m/s.
const PASSAGE: [f64; 2] = [0.02, 20.0];
/// The fastest oil in a port, m/s; usual are 2 to 10. Ports of ISO 6020 and 6022 have a quarter to 0.45 of the bore.
const FASTEST: f64 = 50.0;
const WIDEST: f64 = 0.5;
/// Into a stop the supply presses the piston by its zone; so many zones are too many.
const ZONES: f64 = 5.0;
/// Share of the stroke that no stops take.
const HALF: f64 = 0.5;
/// Time in which a stop lets go of a piston, its damping over its stiffness, s: no crane waits for longer.
const SLOWEST: f64 = 1.0;
/// Of steel, Pa.
const STEEL: f64 = 2.1e11;
/// Of the nominal flow, through seals or closed edges at the supply pressure.
pub const LEAKS: f64 = 0.25;

/// The cylinder by itself.
pub fn shape<T: Number>(table: &Reader, machine: &Machine<T>, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    diameters(table, sizes)?;
    length(table, machine, of, sizes)?;
    levers(table, machine, of, sizes)
}

/// The cylinder beside its valve and its supply.
pub fn check<T: Number>(table: &Reader, machine: &Machine<T>, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    dead_volume(table, machine, of, sizes)?;
    port(table, of, sizes)?;
    stop(table, of, sizes)?;
    leakage(table, machine, of, sizes)
}

fn diameters(table: &Reader, sizes: &Sizes) -> Result<()> {
    if sizes.rod == 0.0 {
        return Ok(());
    }
    let ratio = sizes.areas[0] / sizes.areas[1];
    let [low, high] = AREA_RATIOS;
    let word = if ratio < low { "thin" } else { "thick" };
    if !(low..=high).contains(&ratio) {
        table.required("rod-diameter", "a length")?.warn(
            format!(
                "{word} in a bore of {} mm: the sides would have an area ratio of {}, and cylinders have 1.06 to 5 (ISO 7181)",
                digits(1e3 * sizes.bore),
                digits(ratio)
            ),
            "check both diameters and their units".into(),
        );
    }
    Ok(())
}

/// Limits of the joint that the file states say themselves whether a stroke is long enough.
fn length<T: Number>(table: &Reader, machine: &Machine<T>, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    if !table.has("closed-length") {
        return Ok(());
    }
    let (closed, stroke) = (of.mid_length.plain() - 0.5 * sizes.stroke, digits(1e3 * sizes.stroke));
    let most = (LONGEST * sizes.stroke).max(sizes.stroke + ENDS * sizes.bore);
    let text = if closed < sizes.stroke {
        format!("shorter than the stroke of {stroke} mm, which the retracted cylinder must hold")
    } else if closed > most && machine.joints[of.joint].limits.is_none() {
        format!(
            "long for a stroke of {stroke} mm and a bore of {} mm: usual are 1.1 to 2.3 strokes",
            digits(1e3 * sizes.bore)
        )
    } else {
        return Ok(());
    };
    let cure = "give the distance of the pins with the rod fully retracted, and check the stroke and the units";
    table.required("closed-length", "a length")?.warn(text, cure.into());
    Ok(())
}

fn dead_volume<T: Number>(table: &Reader, machine: &Machine<T>, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    let modulus = machine.fluid.modulus_at(sizes.pressure);
    let dead = of.dead_volume.map(T::plain);
    let key = if table.has("dead-volume") { "dead-volume" } else { "dead-length" };
    for (side, (dead, area)) in dead.into_iter().zip(sizes.areas).enumerate() {
        let chamber = area * sizes.stroke;
        let share = dead * sizes.pressure / modulus / chamber;
        let name = ["piston side", "rod side"][side];
        if share > COMPRESSED {
            table.required(key, "a volume")?.warn(
                format!(
                    "large: {} l beside the {} l of the chamber ({name}); the supply pressure alone compresses it by {} % of the stroke",
                    digits(1e3 * dead),
                    digits(1e3 * chamber),
                    digits(100.0 * share)
                ),
                "check the unit: ml or l?".into(),
            );
            return Ok(());
        }
    }
    let [long, fast] = PASSAGE;
    let (least, passage) = (dead[0].min(dead[1]), sizes.nominal_flow / fast * long);
    if least < passage {
        table.required(key, "a volume")?.warn(
            format!(
                "small: {} ml; 2 cm of passage for the {} l/min of the valve hold {} ml at 20 m/s",
                digits(1e6 * least),
                digits(60e3 * sizes.nominal_flow),
                digits(1e6 * passage)
            ),
            "check the unit: ml or l? Oil between valve and cylinder counts too".into(),
        );
    }
    Ok(())
}

fn port<T: Number>(table: &Reader, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    let Some(port) = of.port_diameter.map(T::plain) else { return Ok(()) };
    let speed = sizes.flow / (0.25 * PI * port * port);
    let text = if port > WIDEST * sizes.bore && !of.motor {
        format!("large: wider than half the bore of {} mm", digits(1e3 * sizes.bore))
    } else if speed > FASTEST {
        format!("small: at full stroke of the valve the oil would pass it at {} m/s", digits(speed))
    } else {
        return Ok(());
    };
    table.required("port-diameter", "a length")?.warn(text, "check its unit, and the flow of the valve".into());
    Ok(())
}

fn stop<T: Number>(table: &Reader, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    let (zone, stiffness) = (of.end_stop.zone.plain(), of.end_stop.stiffness.plain());
    let (depth, rod) = (sizes.force() / stiffness, STEEL * 0.25 * PI * sizes.rod * sizes.rod / sizes.stroke);
    let stop = table.table("end-stop")?.expect("a cylinder with its stop");
    if 2.0 * zone > HALF * sizes.stroke {
        stop.required("zone", "a length")?.warn(
            format!(
                "large: both stops together take {} of the {} mm stroke",
                digits(2e3 * zone),
                digits(1e3 * sizes.stroke)
            ),
            "check its unit; cushions have some 20 to 50 mm".into(),
        );
        return Ok(());
    }
    let text = if depth > ZONES * zone {
        format!(
            "soft: the supply presses the piston {} mm into a zone of {} mm",
            digits(1e3 * depth),
            digits(1e3 * zone)
        )
    } else if stiffness > rod && sizes.rod > 0.0 {
        format!("stiff: the rod itself, of steel and as long as the stroke, has {} kN/mm", digits(1e-6 * rod))
    } else {
        let slow = of.end_stop.damping.plain() / stiffness;
        if slow > SLOWEST && stop.has("damping") {
            stop.required("damping", "a damping")?.warn(
                format!("large: damping over stiffness is {} s, in which the stop lets go of the piston", digits(slow)),
                "check its unit: N s/m or N s/mm?".into(),
            );
        }
        return Ok(());
    };
    stop.required("stiffness", "a stiffness")?.warn(text, "check its unit: N/m or N/mm?".into());
    Ok(())
}

fn leakage<T: Number>(table: &Reader, machine: &Machine<T>, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    let printed = machine.fluid.printed_leakage_viscosity.filter(|_| !machine.errata.leakage_viscosity);
    let viscosity = printed.unwrap_or(machine.fluid.viscosity).plain();
    let annulus = |gap: f64, length: f64| PI * sizes.bore * gap * gap * gap / (12.0 * viscosity * length);
    let (key, conductance) = match &of.leakage {
        Leakage::Gap { gap, piston_length, .. } => ("leakage-gap", annulus(gap.plain(), piston_length.plain())),
        Leakage::Conductance { internal, external } if internal.plain() >= external.plain() => {
            ("internal-leakage", internal.plain())
        }
        Leakage::Conductance { external, .. } => ("external-leakage", external.plain()),
    };
    if let Leakage::Gap { piston_length, gland_length, .. } = &of.leakage {
        for (key, length) in [("piston-length", piston_length.plain()), ("gland-length", gland_length.plain())] {
            if length > sizes.stroke && !of.motor && table.has(key) {
                table.required(key, "a length")?.warn(
                    format!("large: longer than the stroke of {} mm", digits(1e3 * sizes.stroke)),
                    "check its unit: mm, cm or m?".into(),
                );
            }
        }
    }
    let (lost, nominal) = (conductance * sizes.pressure, sizes.nominal_flow);
    if lost > LEAKS * nominal {
        table.required(key, "a quantity")?.warn(
            format!(
                "large: {} l/min leak at the supply pressure, and the valve's nominal flow is {} l/min",
                digits(60e3 * lost),
                digits(60e3 * nominal)
            ),
            "check its unit: a piston's gap has some 10 um, a conductance some 1e-14 m^3/(s Pa)".into(),
        );
    }
    Ok(())
}

/// The eye of a rod is no thinner than the rod: a pin cannot lie nearer to its joint than half of that.
fn levers<T: Number>(table: &Reader, machine: &Machine<T>, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    let joint = &machine.joints[of.joint];
    let (RodPin::Point(rod), JointKind::Revolute(_)) = (&of.rod_pin, &joint.kind) else { return Ok(()) };
    for (key, pin) in [("barrel", &of.barrel_pin), ("rod", rod)] {
        let (arm, _) = split(from_joint(joint, pin, pin.link == of.joint), joint.turning_axis());
        if arm < 0.5 * sizes.rod {
            table.required(key, "a point")?.warn(
                format!(
                    "{} mm from joint `{}`, inside the half thickness of the rod, {} mm: it has no lever",
                    digits(1e3 * arm),
                    joint.name,
                    digits(500.0 * sizes.rod)
                ),
                "check the pin, its unit, and in which link's frame it is".into(),
            );
        }
    }
    Ok(())
}
