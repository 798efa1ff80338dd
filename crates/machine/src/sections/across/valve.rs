//! A valve against the cylinder that it feeds.

use super::cylinder::LEAKS;
use super::{digits, Sizes};
use crate::model::Cylinder;
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;
use std::f64::consts::TAU;

/// Speed of a piston beyond which no seal of hydraulic cylinders is made, m/s; usual ones bear 0.5 to 1.
const FASTEST: f64 = 5.0;
/// Time of a stroke at full opening beyond which nobody waits, s.
const SLOWEST: f64 = 300.0;
/// Share of its stroke over which no spool stays closed, and of the supply pressure that no draining port keeps.
const HALF: f64 = 0.5;
/// Time of the spool's own stroke, s.
const SPOOL: f64 = 5.0;
/// Periods of a spool that are no dead time of its own pilot stage, and time that no bus needs beside, s: five times the 60 ms measured
/// on a forwarder crane.
const PERIODS: f64 = 4.0;
const LATE: f64 = 0.3;

pub fn check<T: Number>(table: &Reader, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    speed(table, of, sizes)?;
    let valve = &of.valve;
    let (transition, edge) = (valve.transition_pressure.plain(), valve.edge_pressure_drop.plain());
    if transition > edge {
        table.required("transition-pressure", "a pressure")?.warn(
            format!(
                "above the nominal drop over an edge, {} bar: the nominal flow would be laminar",
                digits(1e-5 * edge)
            ),
            "check the units of both; the transition lies at some 1 to 5 bar".into(),
        );
    }
    closed(table, of)?;
    let kept = valve.meter_out.iter().flatten().map(|of| of.pressure.plain()).fold(0.0, f64::max);
    if kept > HALF * sizes.pressure {
        table.required("return-pressure", "pressures")?.warn(
            format!(
                "large: a port that drains keeps {} bar, more than half of the supply pressure",
                digits(1e-5 * kept)
            ),
            "check its unit; some 5 to 30 bar keep a load from running away".into(),
        );
    }
    if let Some(limit) = valve.spool.velocity_limit.map(T::plain) {
        let time = valve.stroke.plain() / limit;
        if time > SPOOL {
            table.required("velocity-limit", "a velocity")?.warn(
                format!("slow: the spool takes {} s for its stroke", digits(time)),
                "check the units of `velocity-limit` and `stroke`".into(),
            );
        }
    }
    let period = TAU / valve.spool.natural_frequency.plain();
    if valve.delay > LATE && valve.delay > PERIODS * period {
        table.required("delay", "a time")?.warn(
            format!("large: {} s, and the spool swings in {} s", digits(valve.delay), digits(period)),
            "check the units of `delay` and `natural-frequency`: ms or s, Hz or rad/s?".into(),
        );
    }
    let lost = valve.leakage.plain() * sizes.pressure;
    if lost > LEAKS * valve.nominal_flow.plain() {
        table.required("leakage", "a leakage conductance")?.warn(
            format!(
                "large: {} l/min pass a closed edge at the supply pressure, and the nominal flow is {} l/min",
                digits(60e3 * lost),
                digits(60e3 * valve.nominal_flow.plain())
            ),
            "check its unit, m^3/(s Pa)".into(),
        );
    }
    Ok(())
}

/// A spool that is closed over more than half of its stroke; curves of its edges state as much in shares.
fn closed<T: Number>(table: &Reader, of: &Cylinder<T>) -> Result<()> {
    let (stroke, overlap) = (of.valve.stroke.plain(), of.valve.overlap.plain());
    let chain = table.table("command")?.filter(|_| of.valve.command.dead_band > HALF * stroke);
    let overlapped = (overlap > HALF * stroke).then_some(("overlap", overlap));
    let of_chain = chain.as_ref().map(|chain| (chain, ("dead-band", of.valve.command.dead_band)));
    for (table, (key, zone)) in overlapped.map(|found| (table, found)).into_iter().chain(of_chain) {
        table.required(key, "a length")?.warn(
            format!("large: {} of the {} mm of spool stroke move no piston", digits(1e3 * zone), digits(1e3 * stroke)),
            "check the units of both; spools overlap by some 5 to 25 % of their stroke".into(),
        );
    }
    Ok(())
}

fn speed<T: Number>(table: &Reader, of: &Cylinder<T>, sizes: &Sizes) -> Result<()> {
    // A small pump makes no valve slow.
    let asked = sizes.asked / sizes.areas[0];
    let (text, speed) = if sizes.speed() > FASTEST {
        ("large: without a load the piston would move at", sizes.speed())
    } else if asked > 0.0 && sizes.stroke / asked > SLOWEST {
        ("small: without a load the piston would move at", asked)
    } else {
        return Ok(());
    };
    table.required("nominal-flow", "a volume flow")?.warn(
        format!("{text} {} m/s, {} s for its stroke", digits(speed), digits(sizes.stroke / speed)),
        format!("check the unit, the nominal drop, and the bore of cylinder `{}`", of.name),
    );
    Ok(())
}
