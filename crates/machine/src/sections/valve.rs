//! `[valve.<name>]`: metering edges and spool of the valve of a cylinder.

use crate::errors::ErrorKind;
use crate::model::{Compensator, PrintedBlend, SpoolDynamics, Valve, ValveKind};
use crate::nearest::suggestion;
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{metering, signal_chain, Result};

pub fn read<T: Number>(name: &str, table: &Reader) -> Result<Valve<T>> {
    let stroke: T = table.quantity("stroke")?;
    let kind = table.choice("type", &[ValveKind::FourThree, ValveKind::Regenerative])?;
    let compensator = compensator(table)?;
    let load_check = table.choice_or_default("load-check", &[true, false])?;
    if kind == ValveKind::Regenerative {
        let returning = [("load-check", load_check), ("compensator", !compensator.is_none())];
        let narrowed = ("return-area-ratio", table.has("return-area-ratio"));
        if let Some((key, _)) = returning.into_iter().chain([narrowed]).find(|(_, there)| *there) {
            let message = "a regenerative valve returns the oil of the rod side to the mains";
            return Err(table.error(ErrorKind::ConflictingKeys, key, message).help(format!("leave `{key}` out")));
        }
    }
    let around = metering::Around {
        kind,
        nominal_flow: table.quantity("nominal-flow")?,
        overlap: table.quantity_or_default("overlap")?,
        return_ratio: match table.optional("return-area-ratio")? {
            Some(field) => field.pair()?,
            None => [T::c(1.0); 2],
        },
    };
    let metering = metering::read(table, &around)?;
    let meter_out = metering::meter_out(table, kind, &metering)?;
    let metering::Around { nominal_flow, overlap, return_ratio, .. } = around;
    let valve = Valve {
        name: name.into(),
        kind,
        stroke,
        nominal_flow,
        edge_pressure_drop: edge_pressure_drop(table, &compensator)?,
        transition_pressure: table.quantity("transition-pressure")?,
        printed_blend: table.table("printed")?.map(printed_blend).transpose()?,
        spool: SpoolDynamics {
            natural_frequency: table.quantity("natural-frequency")?,
            damping_ratio: table.quantity("damping-ratio")?,
            velocity_limit: table.optional_quantity("velocity-limit")?,
            acceleration_limit: table.optional_quantity("acceleration-limit")?,
        },
        overlap,
        metering,
        meter_out,
        leakage: table.quantity_or_default("leakage")?,
        return_ratio,
        load_check: load_check || !compensator.is_none(),
        compensator_time_constant: compensator_time_constant(table, &compensator)?,
        compensator,
        delay: table.quantity_or_default("delay")?,
        command: signal_chain::read(table, stroke.plain())?,
    };
    if valve.overlap.plain() < valve.stroke.plain() {
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

fn compensator<T: Number>(table: &Reader) -> Result<Compensator<T>> {
    let kinds = [Compensator::None, Compensator::Before(T::c(0.0)), Compensator::Behind];
    let kind = table.choice_or_default("compensator", &kinds)?;
    let setting: Option<T> = table.optional_quantity("compensator-setting")?;
    match (kind, setting) {
        (Compensator::Before(_), Some(setting)) => Ok(Compensator::Before(setting)),
        (Compensator::Before(_), None) => Err(table
            .missing("compensator-setting", "give the pressure drop that it keeps, some 4 to 14 bar in data sheets")),
        (_, None) => Ok(kind),
        (_, Some(_)) => Err(table
            .error(
                ErrorKind::ConflictingKeys,
                "compensator-setting",
                "only a compensator before the spool has a setting",
            )
            .help("omit it, or choose `compensator = \"before-spool\"`")),
    }
}

fn compensator_time_constant<T: Number>(table: &Reader, compensator: &Compensator<T>) -> Result<Option<T>> {
    let key = "compensator-time-constant";
    if compensator.is_none() && table.has(key) {
        return Err(table
            .error(ErrorKind::ConflictingKeys, key, "the section has no compensator")
            .help("omit it, or choose `compensator = \"before-spool\"` or `\"behind-spool\"`"));
    }
    table.optional_quantity(key)
}

/// Data sheets state the drop over both edges in series, thesis (65), or over one; that over a compensated one is its setting.
fn edge_pressure_drop<T: Number>(table: &Reader, compensator: &Compensator<T>) -> Result<T> {
    let [both, one] = ["nominal-pressure-drop", "nominal-edge-pressure-drop"];
    match table.either([&["nominal-pressure-drop"], &["nominal-edge-pressure-drop"]])? {
        Some(0) => Ok(table.quantity::<T>(both)? * 0.5),
        Some(_) => table.quantity(one),
        None if matches!(compensator, Compensator::Before(_)) => table.quantity("compensator-setting"),
        None => Err(table.missing(both, format!("give it, the drop over both edges, or `{one}`"))),
    }
}

fn printed_blend<T: Number>(table: Reader) -> Result<PrintedBlend<T>> {
    let [low, high]: [T; 2] = [table.quantity("blend-low")?, table.quantity("blend-high")?];
    if low.plain() >= high.plain() {
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
