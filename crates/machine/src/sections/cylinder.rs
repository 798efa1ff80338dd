//! `[cylinder.<name>]`: a double-acting cylinder between two links, with its valve and its friction.

use std::f64::consts::PI;

use crate::errors::ErrorKind;
use crate::model::{
    Cylinder, CylinderPorts, EndStop, Fluid, FourBar, Friction, Joint, JointKind, Leakage, Link, Point, RodPin, Valve,
};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::chain::Chain;
use crate::sections::{
    closure, friction, hose_leak, line, load_holding, port_valves, reference, supply, valve, Result,
};

/// Cylinders that move one joint.
const MOST_IN_PARALLEL: f64 = 8.0;

pub fn read<T: Number>(
    root: &Reader,
    chain: &Chain,
    links: &[Link<T>],
    joints: &[Joint<T>],
    fluid: &Fluid<T>,
) -> Result<Vec<Cylinder<T>>> {
    let tables = root.named_tables("cylinder")?;
    let tables = reference::one_to_one("cylinder", tables, "joint", &chain.joints)?;
    let valves = reference::one_to_one("valve", root.named_tables("valve")?, "cylinder", &tables)?;
    let frictions = root.named_tables("friction")?;
    let frictions = reference::one_to_one("friction", frictions, "cylinder", &tables)?;
    let mut cylinders = Vec::new();
    for (index, (name, table)) in tables.iter().enumerate() {
        let valve = valve::read(valves[index].0, &valves[index].1)?;
        let friction = friction::read(&frictions[index].1)?;
        let cylinder = read_cylinder(index, name, table, links, &joints[index], valve, friction)?;
        if matches!((&joints[index].kind, &cylinder.rod_pin), (JointKind::Prismatic { .. }, RodPin::FourBar(_))) {
            return Err(table
                .error(ErrorKind::ConflictingKeys, "linkage", "a prismatic joint cannot have a linkage")
                .help("give the rod pin as `rod`"));
        }
        if joints[index].axis.is_some() && matches!(cylinder.rod_pin, RodPin::FourBar(_)) {
            let message = format!(
                "joint `{}` has an axis of its own, and linkages lie in the plane of x and z",
                joints[index].name
            );
            return Err(table
                .error(ErrorKind::ConflictingKeys, "linkage", message)
                .help("give the rod pin as `rod`, or `rack-radius`"));
        }
        closure::check(table, &cylinder, &joints[index], links)?;
        cylinders.push(cylinder);
    }
    load_holding::read(root, &mut cylinders)?;
    port_valves::read(root, &mut cylinders)?;
    line::read(root, &mut cylinders, fluid)?;
    hose_leak::read(root, &mut cylinders)?;
    Ok(cylinders)
}

fn read_cylinder<T: Number>(
    index: usize,
    name: &str,
    table: &Reader,
    links: &[Link<T>],
    joint: &Joint<T>,
    valve: Valve<T>,
    friction: Friction<T>,
) -> Result<Cylinder<T>> {
    let rack = rack(table, joint)?;
    let motor = motor(table, rack)?;
    let travel = if rack.is_some() { rack_travel(table)? } else { travel(table)? };
    let [bore, rod_diameter]: [T; 2] = match motor {
        Some(bore) => [bore, T::c(0.0)],
        None => [table.quantity("bore")?, table.quantity("rod-diameter")?],
    };
    if rod_diameter.plain() >= bore.plain() {
        let message = "the rod is not thinner than the bore";
        return Err(table.error(ErrorKind::OutOfRange, "rod-diameter", message).help("exchange the two diameters?"));
    }
    let port_diameter = table.optional_quantity("port-diameter")?;
    let printed = table.table("printed")?;
    Ok(Cylinder {
        name: name.into(),
        joint: index,
        count: count(table)?,
        motor: motor.is_some(),
        barrel_pin: match rack {
            // Where pictures show it.
            Some(_) => Point { link: index, name: joint.name.clone(), position: joint.at, aside: joint.aside },
            None => reference::point(&table.required("barrel", "a point as \"link.point\"")?, links)?,
        },
        rod_pin: rack.map_or_else(|| rod_pin(table, links), |radius| Ok(RodPin::Rack(radius)))?,
        bore,
        rod_diameter,
        stroke: travel.stroke,
        mid_length: travel.mid_length,
        rod_contact: travel.rod_contact,
        dead_volume: dead_volume(table, port_diameter)?,
        printed_dead_volume: printed.as_ref().map(printed_dead_volume).transpose()?.flatten(),
        port_diameter,
        leakage: leakage(table, printed.as_ref(), bore.plain())?,
        end_stop: end_stop(table, travel.stroke.plain())?,
        pressure_rating: table.optional_quantity("pressure-rating")?,
        valve,
        ports: CylinderPorts::plain(),
        friction,
    })
}

fn count<T: Number>(table: &Reader) -> Result<T> {
    let count: T = table.quantity_or_default("count")?;
    let plain = count.plain();
    if plain.fract() == 0.0 && plain <= MOST_IN_PARALLEL {
        return Ok(count);
    }
    let message = format!("must be a whole number of cylinders up to {MOST_IN_PARALLEL}, found {plain}");
    Err(table.error(ErrorKind::OutOfRange, "count", message).help("give for example 2"))
}

struct Travel<T> {
    stroke: T,
    mid_length: T,
    rod_contact: Option<T>,
}

/// Stroke and pin distance, from the lengths of the parts, thesis (1)-(2), or from stroke and retracted length.
fn travel<T: Number>(table: &Reader) -> Result<Travel<T>> {
    let groups: [&[&str]; 2] =
        [&["barrel-length", "rod-length", "barrel-offset", "rod-offset"], &["stroke", "closed-length"]];
    let length = |key: &str| table.quantity::<T>(key);
    let group = table.either(groups)?.ok_or_else(|| {
        table.missing("stroke", "give it with `closed-length`, or the lengths of barrel, piston and rod")
    })?;
    if group == 1 {
        // Leakage may need it; it is checked in any case.
        table.optional_quantity::<T>("piston-length")?;
        let stroke = length("stroke")?;
        return Ok(Travel { stroke, mid_length: length("closed-length")? + stroke * 0.5, rod_contact: None });
    }
    let [barrel, piston, rod] = [length("barrel-length")?, length("piston-length")?, length("rod-length")?];
    if piston.plain() >= barrel.plain() {
        let message = "the piston is not shorter than the barrel";
        return Err(table.error(ErrorKind::OutOfRange, "piston-length", message).help("exchange the two lengths?"));
    }
    let stroke = barrel - piston;
    Ok(Travel {
        stroke,
        mid_length: length("barrel-offset")? + (barrel + piston) * 0.5 + rod + length("rod-offset")?,
        // The rod's eye touches the barrel's end when the rod is fully retracted.
        rod_contact: Some(stroke * 0.5 - rod),
    })
}

/// Pitch radius of the pinion, m, where the rod is a rack.
fn rack<T: Number>(table: &Reader, joint: &Joint<T>) -> Result<Option<T>> {
    let Some(radius) = table.optional_quantity("rack-radius")? else { return Ok(None) };
    if matches!(joint.kind, JointKind::Prismatic { .. }) {
        let message = format!("joint `{}` slides, and a pinion turns", joint.name);
        return Err(table
            .error(ErrorKind::ConflictingKeys, "rack-radius", message)
            .help("give the pins `barrel` and `rod`"));
    }
    let pins =
        ["barrel", "rod", "linkage", "closed-length", "barrel-length", "rod-length", "barrel-offset", "rod-offset"];
    match pins.into_iter().find(|key| table.has(key)) {
        Some(key) => Err(table
            .error(ErrorKind::ConflictingKeys, key, "excludes `rack-radius`, which is given too")
            .help("keep one of the two")),
        None => Ok(Some(radius)),
    }
}

/// The bore of a piston that takes as much oil as a motor and its gear for the same travel of the rack, m.
fn motor<T: Number>(table: &Reader, rack: Option<T>) -> Result<Option<T>> {
    let Some(motor) = table.table("motor")? else { return Ok(None) };
    if let Some(key) =
        ["bore", "rod-diameter", "leakage-gap", "gland-length", "piston-length"].iter().find(|key| table.has(key))
    {
        let message = format!("a `motor` has no {key}");
        return Err(table.error(ErrorKind::ConflictingKeys, key, message).help("leave the key out, or `motor`"));
    }
    let Some(radius) = rack else {
        return Err(table.missing("rack-radius", "give the pitch radius of the ring that the motor turns"));
    };
    let per_turn = supply::displacement::<T>(&motor)? * motor.quantity::<T>("gear-ratio")?;
    Ok(Some((per_turn / radius * (2.0 / (PI * PI))).sqrt()))
}

/// The piston of a rack is at mid-stroke where its joint is at zero.
fn rack_travel<T: Number>(table: &Reader) -> Result<Travel<T>> {
    table.optional_quantity::<T>("piston-length")?;
    Ok(Travel { stroke: table.quantity("stroke")?, mid_length: T::c(0.0), rod_contact: None })
}

fn rod_pin<T: Number>(table: &Reader, links: &[Link<T>]) -> Result<RodPin<T>> {
    match table.either([&["rod"], &["linkage"]])? {
        Some(0) => Ok(RodPin::Point(reference::point(&table.required("rod", "a point as \"link.point\"")?, links)?)),
        Some(_) => {
            let linkage = table.table("linkage")?.expect("`either` found the table");
            let pivot = |key: &str| reference::point(&linkage.required(key, "a point as \"link.point\"")?, links);
            Ok(RodPin::FourBar(FourBar {
                rocker_pivot: pivot("rocker-pivot")?,
                coupler_pivot: pivot("coupler-pivot")?,
                rocker_length: linkage.quantity("rocker-length")?,
                coupler_length: linkage.quantity("coupler-length")?,
                side: linkage.choice("side", &[1.0, -1.0])?,
            }))
        }
        None => Err(table.missing("rod", "give the rod's pin as \"link.point\", or a table `linkage`")),
    }
}

fn dead_volume<T: Number>(table: &Reader, port_diameter: Option<T>) -> Result<[T; 2]> {
    match table.either([&["dead-length"], &["dead-volume"]])? {
        Some(0) => {
            let dead_length: T = table.quantity("dead-length")?;
            let diameter = port_diameter.ok_or_else(|| table.missing("port-diameter", "`dead-length` needs it"))?;
            Ok([diameter.square() * (0.25 * PI) * dead_length; 2])
        }
        Some(_) => table.required("dead-volume", "a volume")?.pair(),
        None => Err(table.missing("dead-volume", "give it, or `dead-length` with `port-diameter`")),
    }
}

fn printed_dead_volume<T: Number>(printed: &Reader) -> Result<Option<[T; 2]>> {
    let field = printed.optional("dead-volume")?;
    field.map(|field| field.pair()).transpose()
}

fn leakage<T: Number>(table: &Reader, printed: Option<&Reader>, bore: f64) -> Result<Leakage<T>> {
    let from_piston_side = match printed {
        Some(printed) => printed.choice_or_default("external-leakage-from", &[true, false])?,
        None => false,
    };
    match table.either([&["leakage-gap", "gland-length"], &["internal-leakage", "external-leakage"]])? {
        Some(0) => Ok(Leakage::Gap {
            gap: gap(table, bore)?,
            piston_length: table.quantity("piston-length")?,
            gland_length: table.quantity("gland-length")?,
            printed_external_from_piston_side: from_piston_side,
        }),
        Some(_) => Ok(Leakage::Conductance {
            internal: table.quantity("internal-leakage")?,
            external: table.quantity("external-leakage")?,
        }),
        None => {
            Err(table
                .missing("internal-leakage", "give it with `external-leakage`, or `leakage-gap` with `gland-length`"))
        }
    }
}

/// The gap around the piston, which must be smaller than its radius.
fn gap<T: Number>(table: &Reader, bore: f64) -> Result<T> {
    let gap: T = table.quantity("leakage-gap")?;
    if gap.plain() < 0.5 * bore {
        return Ok(gap);
    }
    let message = "the gap is not smaller than half the bore";
    Err(table
        .error(ErrorKind::OutOfRange, "leakage-gap", message)
        .help("a piston's gap has some 10 um; check the unit"))
}

fn end_stop<T: Number>(table: &Reader, stroke: f64) -> Result<EndStop<T>> {
    let Some(stop) = table.table("end-stop")? else {
        return Err(table.missing("end-stop", "add it with zone, stiffness and damping"));
    };
    let end_stop: EndStop<T> = EndStop {
        zone: stop.quantity("zone")?,
        stiffness: stop.quantity("stiffness")?,
        damping: stop.quantity("damping")?,
    };
    if end_stop.zone.plain() <= 0.5 * stroke {
        return Ok(end_stop);
    }
    Err(stop
        .error(ErrorKind::OutOfRange, "zone", format!("longer than half the stroke, {} m", 0.5 * stroke))
        .help("the two stops would overlap: give a shorter zone"))
}
