//! `[valve.<name>]`: metering edges and spool of the valve of a cylinder.

use crate::errors::ErrorKind;
use crate::model::{PrintedBlend, Valve, ValveKind};
use crate::nearest::suggestion;
use crate::quantities::{acceleration, angular_frequency, conductance, flow, length, pressure, time, velocity};
use crate::reader::{Reader, Sign};
use crate::sections::{signal_chain, Result};
use crate::units::Quantity;

pub const KEYS: [&str; 16] = [
    "cylinder",
    "type",
    "stroke",
    "nominal-flow",
    "nominal-pressure-drop",
    "nominal-edge-pressure-drop",
    "transition-pressure",
    "natural-frequency",
    "damping-ratio",
    "overlap",
    "leakage",
    "velocity-limit",
    "acceleration-limit",
    "delay",
    "command",
    "printed",
];

pub fn read(name: &str, table: &Reader) -> Result<Valve> {
    let stroke = table.quantity("stroke", &length(), Sign::Positive)?;
    let valve = Valve {
        name: name.into(),
        kind: table.choice("type", &[("4/3", ValveKind::FourThree), ("regenerative", ValveKind::Regenerative)])?,
        stroke,
        nominal_flow: table.quantity("nominal-flow", &flow(), Sign::Positive)?,
        edge_pressure_drop: edge_pressure_drop(table)?,
        transition_pressure: table.quantity("transition-pressure", &pressure(), Sign::Positive)?,
        printed_blend: table
            .table("printed", &["blend-low", "blend-high", "blend-ports"])?
            .map(printed_blend)
            .transpose()?,
        natural_frequency: table.quantity("natural-frequency", &angular_frequency(), Sign::Positive)?,
        damping_ratio: table.quantity("damping-ratio", &Quantity::number(), Sign::Positive)?,
        overlap: table.quantity_or("overlap", &length(), Sign::NonNegative, 0.0)?,
        leakage: table.quantity_or("leakage", &conductance(), Sign::NonNegative, 0.0)?,
        velocity_limit: table.optional_quantity("velocity-limit", &velocity(), Sign::Positive)?,
        acceleration_limit: table.optional_quantity("acceleration-limit", &acceleration(), Sign::Positive)?,
        delay: table.quantity_or("delay", &time(), Sign::NonNegative, 0.0)?,
        command: signal_chain::read(table, stroke)?,
    };
    if valve.overlap < valve.stroke {
        return Ok(valve);
    }
    Err(table
        .error(
            ErrorKind::OutOfRange,
            "overlap",
            "the overlap is not smaller than the spool stroke: the edges never open",
        )
        .help("give a smaller overlap"))
}

/// Data sheets state the drop over both edges in series, thesis (65), or over one.
fn edge_pressure_drop(table: &Reader) -> Result<f64> {
    let [both, one] = ["nominal-pressure-drop", "nominal-edge-pressure-drop"];
    match table.either([&["nominal-pressure-drop"], &["nominal-edge-pressure-drop"]])? {
        Some(0) => Ok(0.5 * table.quantity(both, &pressure(), Sign::Positive)?),
        Some(_) => table.quantity(one, &pressure(), Sign::Positive),
        None => Err(table.missing(both, format!("give it, the drop over both edges, or `{one}`"))),
    }
}

fn printed_blend(table: Reader) -> Result<PrintedBlend> {
    let low = table.quantity("blend-low", &pressure(), Sign::NonNegative)?;
    let high = table.quantity("blend-high", &pressure(), Sign::Positive)?;
    if low >= high {
        let message = "`blend-low` is not below `blend-high`";
        return Err(table.error(ErrorKind::CrossedLimits, "blend-low", message).help("exchange the two"));
    }
    let field = table.required("blend-ports", "a list of \"A\" and \"B\"")?;
    let mut ports = [false; 2];
    for name in field.texts()? {
        match ["A", "B"].iter().position(|port| *port == name) {
            Some(port) => ports[port] = true,
            None => {
                let message = format!("there is no port `{name}`");
                return Err(field.error(ErrorKind::InvalidChoice, message).help(suggestion(name, ["A", "B"])));
            }
        }
    }
    Ok(PrintedBlend { low, high, ports })
}
