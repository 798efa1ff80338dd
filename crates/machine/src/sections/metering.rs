//! `[valve.<name>.metering.<edge>]`: areas of the metering edges over the displacement of the spool.

use crate::errors::ErrorKind;
use crate::model::{EdgeCurve, MeterOut, ValveKind};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;

const EDGES: [&str; 4] = ["supply-to-a", "a-to-tank", "supply-to-b", "b-to-tank"];
/// For the edges to the tank, the port with their `return-area-ratio`.
const RETURNS: [(usize, usize); 2] = [(1, 0), (3, 1)];
/// Most points of a curve, and their least distance.
const MOST_POINTS: usize = 16;
const LEAST_STEP: f64 = 1e-3;

/// Values of a valve's table on which its curves depend.
pub struct Around<T> {
    pub kind: ValveKind,
    pub nominal_flow: T,
    pub overlap: T,
    pub return_ratio: [T; 2],
}

/// The curves of the valve in `valve`.
pub fn read<T: Number>(valve: &Reader, around: &Around<T>) -> Result<[Option<EdgeCurve<T>>; 4]> {
    let mut curves = [None, None, None, None];
    let Some(table) = valve.table("metering")? else { return Ok(curves) };
    for (curve, edge) in curves.iter_mut().zip(EDGES) {
        *curve = table.table(edge)?.map(|table| one(&table, around.nominal_flow)).transpose()?;
    }
    if around.kind == ValveKind::Regenerative && curves[3].is_some() {
        let message = "a regenerative valve does not join port B to the tank";
        return Err(table
            .key_error(ErrorKind::ConflictingKeys, EDGES[3], message)
            .help("leave it out: `supply-to-b` counts for both ways"));
    }
    for (edge, port) in RETURNS {
        if curves[edge].is_some() && around.return_ratio[port].plain() != 1.0 {
            let message = format!("`return-area-ratio` of the valve says something else of the edge `{}`", EDGES[edge]);
            return Err(table
                .key_error(ErrorKind::ConflictingKeys, EDGES[edge], message)
                .help("state the narrow edge by the curve alone, and 1 for the ratio of its port"));
        }
    }
    if around.overlap.plain() > 0.0 && curves.iter().all(Option::is_some) {
        valve.required("overlap", "a length")?.warn(
            "counts for nothing: curves say how all edges open".into(),
            "leave it out; the flat beginning of a curve is its overlap".into(),
        );
    }
    Ok(curves)
}

/// Separate spools that hold the pressures of ports A and B while these drain.
pub fn meter_out<T: Number>(
    valve: &Reader,
    kind: ValveKind,
    curves: &[Option<EdgeCurve<T>>; 4],
) -> Result<[Option<MeterOut<T>>; 2]> {
    let [key, range] = ["return-pressure", "return-pressure-range"];
    let Some(field) = valve.optional(key)? else {
        return match valve.has(range) {
            true => Err(valve
                .error(ErrorKind::ConflictingKeys, range, "counts for nothing without `return-pressure`")
                .help("give `return-pressure`, or leave it out")),
            false => Ok([None, None]),
        };
    };
    if kind == ValveKind::Regenerative {
        let message = "a regenerative valve returns the oil of the rod side to the mains";
        return Err(field.error(ErrorKind::ConflictingKeys, message).help(format!("leave `{key}` out")));
    }
    if let Some((edge, _)) = RETURNS.iter().find(|(edge, _)| curves[*edge].is_some()) {
        let message = format!("the edge `{}` has a curve over the spool of the feed", EDGES[*edge]);
        return Err(field
            .error(ErrorKind::ConflictingKeys, message)
            .help("leave the curve out: a spool of its own opens the edge as the pressure asks"));
    }
    let range: T = valve.quantity_or_default(range)?;
    Ok(field.pair::<T>()?.map(|pressure| Some(MeterOut { pressure, range })))
}

fn one<T: Number>(table: &Reader, nominal_flow: T) -> Result<EdgeCurve<T>> {
    let travel = table.required("travel", "a list of shares of the stroke, for example [0, 0.1, 1]")?;
    let shares = travel.series()?;
    if !(2..=MOST_POINTS).contains(&shares.len()) {
        let message = format!("{} points; a curve has 2 to {MOST_POINTS}", shares.len());
        return Err(travel.error(ErrorKind::TooLarge, message).help("the curve between points is smooth: few will do"));
    }
    let steps = shares.windows(2).all(|pair| pair[1] - pair[0] >= LEAST_STEP);
    if !(steps && shares[0] == 0.0 && shares[shares.len() - 1] == 1.0) {
        let message = format!("does not rise from 0 to 1 by {LEAST_STEP} at least from point to point");
        return Err(travel
            .error(ErrorKind::OutOfRange, message)
            .help("give shares of the stroke, for example [0, 0.1, 1]"));
    }
    let (name, full): (_, fn(f64, T) -> T) = match table.either([&["area"], &["flow"]])? {
        Some(0) => ("area", |most, _| T::c(most)),
        Some(_) => ("flow", |most, nominal| T::c(most) / nominal),
        None => return Err(table.missing("area", "give shares of the full area, or flows as `flow`")),
    };
    let values = table.required(name, "a list")?;
    let series = values.series()?;
    let wrong = |message: String, help: &str| Err(values.error(ErrorKind::OutOfRange, message).help(help));
    if series.len() != shares.len() {
        let message = format!("{} values for {} points of `travel`", series.len(), shares.len());
        return wrong(message, "give one for each point");
    }
    let most = series[series.len() - 1];
    if series[0] != 0.0 {
        return wrong(
            "the edge is open in the middle of the spool".into(),
            "begin with 0: edges open in one sense alone",
        );
    }
    if let Some(pair) = series.windows(2).find(|pair| pair[1] < pair[0]) {
        return wrong(format!("falls from {} to {}", pair[0], pair[1]), "an edge opens further as the spool moves on");
    }
    if most <= 0.0 {
        return wrong("the edge never opens".into(), "end with the area or flow at full stroke");
    }
    let points = shares.iter().zip(&series).map(|(share, value)| [*share, value / most]).collect();
    Ok(EdgeCurve { points, full: full(most, nominal_flow) })
}
