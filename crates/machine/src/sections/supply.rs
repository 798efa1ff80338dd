//! `[supply]`, `[pump.<name>]` and `[mains]`: where the oil comes from.

use crate::errors::ErrorKind;
use crate::model::{Machine, Mains, PressureControl, Pump, Supply, Valve};
use crate::number::Number;
use crate::reader::Reader;
use crate::sections::{required_table, Result};
use std::f64::consts::TAU;

/// Relief pressure over supply pressure where the file does not say.
const RELIEF: f64 = 1.15;
/// What an ideal pump has none of; from the fifth on, what a fixed one has none of.
const KEYS_OF_A_REAL_PUMP: [&str; 7] = [
    "displacement",
    "speed",
    "volumetric-efficiency",
    "hydromechanical-efficiency",
    "control-range",
    "time-constant",
    "torque-limit",
];

#[derive(Debug, Clone, Copy, PartialEq)]
enum PumpKind {
    ConstantPressure,
    Fixed,
    PressureCompensated,
}

pub fn read<T: Number>(root: &Reader) -> Result<Supply<T>> {
    let table = required_table(root, "supply")?;
    let mut supply: Supply<T> = Supply {
        pressure: table.quantity("pressure")?,
        tank_pressure: table.quantity("tank-pressure")?,
        measured: table.choice_or_default("measured", &[true, false])?,
        mains: None,
    };
    if supply.pressure.plain() < supply.tank_pressure.plain() {
        return Err(table
            .error(ErrorKind::OutOfRange, "pressure", "the supply pressure lies below the tank pressure")
            .help("raise `pressure` or lower `tank-pressure`"));
    }
    supply.mains = mains(root, &supply)?;
    if supply.measured && supply.mains.is_some() {
        let message = "the pressure follows from the pump, so no measured one can be prescribed";
        return Err(table.error(ErrorKind::ConflictingKeys, "measured", message).help(
            "leave the measured pressure of the supply out of the scenario, or take the machine without its pump",
        ));
    }
    Ok(supply)
}

/// Warns of a pump that a single valve exceeds: at full stroke, without load, the supply pressure falls over its two edges.
pub fn check_size<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let Some(mains) = &machine.supply.mains else { return Ok(()) };
    let plain = |numbers: [T; 3]| numbers.map(T::plain);
    let [displacement, speed, efficiency] =
        plain([mains.pump.displacement, mains.pump.speed, mains.pump.volumetric_efficiency]);
    let given = displacement / TAU * speed * efficiency;
    let drop = machine.supply.pressure.plain() - machine.supply.tank_pressure.plain();
    let asked = |valve: &Valve<T>| {
        let [flow, edge, _] = plain([valve.nominal_flow, valve.edge_pressure_drop, valve.stroke]);
        flow * libm::sqrt(0.5 * drop / edge)
    };
    let valves = machine.cylinders.iter().map(|cylinder| &cylinder.valve);
    let Some(largest) = valves.max_by(|a, b| asked(a).total_cmp(&asked(b))) else { return Ok(()) };
    if asked(largest) <= given {
        return Ok(());
    }
    for (_, table) in root.named_tables("pump")? {
        let litres = |flow: f64| 60e3 * flow;
        let (given, asked) = (litres(given), litres(asked(largest)));
        table.required("displacement", "a volume")?.warn(
            format!(
                "small: it gives {given:.1} l/min at most, and valve `{}` alone takes {asked:.1} l/min at full stroke",
                largest.name
            ),
            "take a larger one, or expect the pressure of the mains to fall".into(),
        );
    }
    Ok(())
}

fn mains<T: Number>(root: &Reader, supply: &Supply<T>) -> Result<Option<Mains<T>>> {
    let pumps = root.named_tables("pump")?;
    let table = root.table("mains")?;
    let pump = match &pumps[..] {
        [] => None,
        [(name, table)] => pump(name, table, supply)?,
        [_, (second, _), ..] => {
            let message = format!("a second pump, `{second}`: all valves hang on one");
            return Err(root.error(ErrorKind::TooLarge, "pump", message).help("keep one [pump.<name>]"));
        }
    };
    match (pump, table) {
        (None, None) => Ok(None),
        (Some(_), None) => Err(root.missing("mains", "add the table [mains] with the `volume` of the lines")),
        (None, Some(_)) => Err(root
            .error(ErrorKind::ConflictingKeys, "mains", "its pressure would follow from a pump, and there is none")
            .help("add a [pump.<name>] of type \"fixed\" or \"pressure-compensated\", or leave [mains] out")),
        (Some(_), Some(_)) if supply.pressure.plain() == supply.tank_pressure.plain() => {
            let message = "the supply pressure is that of the tank: its pump has nothing to do";
            Err(root.error(ErrorKind::OutOfRange, "supply", message).help("raise `supply.pressure`"))
        }
        (Some(pump), Some(table)) => Ok(Some(lines(&table, supply, pump)?)),
    }
}

fn lines<T: Number>(table: &Reader, supply: &Supply<T>, pump: Pump<T>) -> Result<Mains<T>> {
    let default = supply.pressure * if pump.control.is_some() { RELIEF } else { 1.0 };
    let mains = Mains {
        volume: table.quantity("volume")?,
        compliance: table.quantity_or_default("hose-compliance")?,
        relief_pressure: table.optional_quantity("relief-pressure")?.unwrap_or(default),
        relief_gradient: table.quantity_or_default("relief-gradient")?,
        pump,
    };
    if mains.pump.control.is_none() || mains.relief_pressure.plain() > supply.pressure.plain() {
        return Ok(mains);
    }
    Err(table
        .error(ErrorKind::OutOfRange, "relief-pressure", "the relief valve opens before the pump swivels back")
        .help("set it some 10 to 20 % above `supply.pressure`"))
}

/// `None`: an ideal one.
fn pump<T: Number>(name: &str, table: &Reader, supply: &Supply<T>) -> Result<Option<Pump<T>>> {
    let kinds = [PumpKind::ConstantPressure, PumpKind::Fixed, PumpKind::PressureCompensated];
    let kind = table.choice("type", &kinds)?;
    let superfluous = match kind {
        PumpKind::ConstantPressure => &KEYS_OF_A_REAL_PUMP[..],
        PumpKind::Fixed => &KEYS_OF_A_REAL_PUMP[4..],
        PumpKind::PressureCompensated => &[],
    };
    if let Some(key) = superfluous.iter().find(|key| table.has(key)) {
        let kind = table.text("type")?;
        return Err(table
            .error(ErrorKind::ConflictingKeys, key, format!("a pump of type `{kind}` has none"))
            .help("leave it out, or choose type \"pressure-compensated\""));
    }
    if kind == PumpKind::ConstantPressure {
        return Ok(None);
    }
    let control = (kind == PumpKind::PressureCompensated).then(|| control(table, supply)).transpose()?;
    Ok(Some(Pump {
        name: name.into(),
        displacement: table.quantity("displacement")?,
        speed: table.quantity("speed")?,
        volumetric_efficiency: efficiency(table, "volumetric-efficiency")?,
        hydromechanical_efficiency: efficiency(table, "hydromechanical-efficiency")?,
        control,
    }))
}

fn control<T: Number>(table: &Reader, supply: &Supply<T>) -> Result<PressureControl<T>> {
    let control: PressureControl<T> = PressureControl {
        range: table.quantity_or_default("control-range")?,
        time_constant: table.quantity_or_default("time-constant")?,
        torque_limit: table.optional_quantity("torque-limit")?,
    };
    if control.range.plain() < supply.pressure.plain() {
        return Ok(control);
    }
    Err(table
        .error(ErrorKind::OutOfRange, "control-range", "not below the supply pressure")
        .help("data sheets state some 2 to 15 bar"))
}

fn efficiency<T: Number>(table: &Reader, key: &str) -> Result<T> {
    let efficiency: T = table.quantity(key)?;
    if efficiency.plain() <= 1.0 {
        return Ok(efficiency);
    }
    Err(table.error(ErrorKind::OutOfRange, key, "exceeds 1").help("give a share: 0.95, or \"95 %\""))
}
