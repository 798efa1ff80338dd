//! `[counterbalance]`, `[pilot-check]`, `[hose-burst]`, `[line]`, `[hose-leak]`, `[port-relief]`, `[crossover-relief]`, `[anti-cavitation]`, `[accumulator]`, `[tank-line]` and
//! `[priority]`: what stands in a circuit beside cylinders, valves and pump.

use super::Key;
use super::Sign::{NonNegative, Positive};
use crate::units::quantities::{AREA, COMPLIANCE, FLOW, LENGTH, NUMBER, PRESSURE, VOLUME};

/// Where a part stands: at which cylinder, and on which side.
pub const fn cylinder(means: &'static str) -> Key {
    Key::text("cylinder").required().means(means)
}

pub const fn side(means: &'static str) -> Key {
    Key::choice("side", &["piston-side", "rod-side"]).required().means(means)
}

/// Of every part through which oil flows.
const fn nominal_flow(means: &'static str) -> Key {
    Key::quantity("nominal-flow", &[FLOW], Positive).usual(&[("0.1 l/min", "5000 l/min", 1e3)]).means(means)
}

/// Pressure at which a valve begins to open.
const fn setting(means: &'static str) -> Key {
    Key::quantity("setting", &[PRESSURE], Positive).required().usual(&[("20 bar", "500 bar", 4.0)]).means(means)
}

/// Of a relief valve with a `setting` and a `nominal-flow`.
const fn overpressure() -> Key {
    Key::quantity("overpressure", &[PRESSURE], Positive)
        .defaults(&["20 bar"])
        .usual(&[("1 bar", "100 bar", 10.0)])
        .means("Rise beyond the setting at which the nominal flow passes.")
}

pub static COUNTERBALANCE: &[Key] = &[
    cylinder("The cylinder at which the valve is mounted."),
    side("The chamber that the valve closes."),
    setting(
        "Chamber pressure at which the valve opens without pilot pressure; manufacturers advise 1.3 times the highest load pressure.",
    ),
    Key::quantity("pilot-ratio", &[NUMBER], NonNegative)
        .required()
        .usual(&[("1", "12", 3.0)])
        .means("Effect of the pressure on the other side, relative to the effect of the chamber pressure."),
    Key::quantity("opening-pressure", &[PRESSURE], Positive)
        .defaults(&["40 bar"])
        .usual(&[("2 bar", "200 bar", 5.0)])
        .means("Pressure above the setting, pilot included, at which the valve is fully open."),
    nominal_flow("Flow when fully open, at the nominal pressure drop.").required(),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .required()
        .usual(&[("0.5 bar", "400 bar", 100.0)])
        .means("Pressure drop of that flow."),
];

pub static PILOT_CHECK: &[Key] = &[
    cylinder("The cylinder at which the valve is mounted."),
    side("The chamber that the valve closes."),
    Key::quantity("pilot-ratio", &[NUMBER], Positive)
        .required()
        .usual(&[("1.5", "12", 3.0)])
        .means("Area of the pilot piston over that of the seat."),
    Key::quantity("spring-pressure", &[PRESSURE], NonNegative)
        .defaults(&["2 bar"])
        .usual(&[("0.1 bar", "20 bar", 10.0)])
        .means("Force of its spring over the area of the seat."),
    Key::quantity("opening-pressure", &[PRESSURE], Positive)
        .defaults(&["10 bar"])
        .usual(&[("1 bar", "100 bar", 5.0)])
        .means("Rise beyond load and spring, pilot ratio included, that opens it fully."),
    nominal_flow("Flow when fully open, at the nominal pressure drop.").required(),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .required()
        .usual(&[("0.5 bar", "400 bar", 100.0)])
        .means("Pressure drop of that flow."),
];

pub static HOSE_BURST: &[Key] = &[
    cylinder("The cylinder at which the valve is mounted."),
    side("The chamber that the valve closes."),
    Key::quantity("closing-flow", &[FLOW], Positive).required().usual(&[("0.1 l/min", "5000 l/min", 1e3)]).means(
        "Flow out of the chamber at which it begins to close; it has closed where 1.1 times as much would flow.",
    ),
    Key::quantity("bleed", &[NUMBER], NonNegative)
        .defaults(&["0"])
        .usual(&[("0.0001", "0.2", 5.0)])
        .means("Share of its opening that it leaves when closed, below 1: the load sinks slowly."),
    nominal_flow("Flow when open, at the nominal pressure drop.").required(),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .required()
        .usual(&[("0.2 bar", "100 bar", 100.0)])
        .means("Pressure drop of that flow."),
];

/// Of the two descriptions of a line.
const BORE: &str = "this group, or `volume`, or neither on a side whose load is held";

pub static LINE: &[Key] = &[
    cylinder("The cylinder that it leads to."),
    side("The side that it leads to."),
    Key::quantity("length", &[LENGTH], Positive)
        .otherwise(BORE)
        .usual(&[("0.1 m", "50 m", 10.0)])
        .means("Length of the line."),
    Key::quantity("inner-diameter", &[LENGTH], Positive)
        .otherwise(BORE)
        .usual(&[("3 mm", "80 mm", 10.0)])
        .means("Its inner diameter."),
    Key::quantity("volume", &[VOLUME], Positive)
        .otherwise("this, or `length` and `inner-diameter`, or neither on a side whose load is held")
        .usual(&[("1 ml", "50 l", 100.0)])
        .means("Oil in the line without pressure."),
    Key::quantity("compliance", &[COMPLIANCE], NonNegative)
        .defaults(&["0 m^3/Pa"])
        .usual(&[("0.0001 ml/bar", "10 ml/bar", 100.0)])
        .means("Growth of that volume with pressure: some 0.01 % per bar in hoses, next to none in pipes."),
    nominal_flow("Flow at which the pressure drop of the line is stated.").otherwise("the line has no resistance"),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .otherwise("that of wall friction, from `length`, `inner-diameter` and the oil")
        .usual(&[("0.05 bar", "100 bar", 100.0)])
        .means("Pressure drop over the line at that flow, with its couplings and bends."),
    Key::quantity("laminar-share", &[NUMBER], Positive)
        .defaults(&["0.5"])
        .usual(&[("0.01", "1", 100.0)])
        .means("Share of the nominal pressure drop that is proportional to the flow; the rest grows with its square."),
];

/// Area of a hole in a hose; a burst hose of 12 mm has 113 mm^2.
pub const fn hole(means: &'static str) -> Key {
    Key::quantity("opening", &[AREA], NonNegative).required().usual(&[("0.1 mm^2", "1000 mm^2", 5.0)]).means(means)
}

pub static HOSE_LEAK: &[Key] = &[
    cylinder("The cylinder to which the hose leads."),
    side("The side to which it leads."),
    hole("Area of the hole; zero: tight."),
    Key::quantity("discharge-coefficient", &[NUMBER], Positive)
        .defaults(&["0.7"])
        .usual(&[("0.5", "1", 1.2)])
        .means("Share of that area that the jet fills."),
];

pub static ACCUMULATOR: &[Key] = &[
    Key::quantity("volume", &[VOLUME], Positive)
        .required()
        .usual(&[("0.05 l", "100 l", 10.0)])
        .means("Volume of the gas without oil."),
    Key::quantity("precharge", &[PRESSURE], Positive)
        .required()
        .usual(&[("5 bar", "350 bar", 4.0)])
        .means("Gauge pressure of the gas without oil."),
    Key::quantity("polytropic-exponent", &[NUMBER], Positive)
        .defaults(&["1.4"])
        .usual(&[("1", "1.8", 1.2)])
        .means("1 where the gas keeps its temperature, 1.4 where nitrogen has no time to give off heat."),
];

pub static TANK_LINE: &[Key] = &[
    Key::quantity("volume", &[VOLUME], Positive)
        .required()
        .usual(&[("0.05 l", "100 l", 100.0)])
        .means("Oil in the line between valves and filter."),
    Key::quantity("hose-compliance", &[COMPLIANCE], NonNegative)
        .defaults(&["0 m^3/Pa"])
        .usual(&[("0.001 ml/bar", "10 ml/bar", 100.0)])
        .means("Increase of that volume with pressure."),
    nominal_flow("Flow at which the pressure drop of the line is stated.").otherwise("only the filter resists"),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .otherwise("required with `nominal-flow`")
        .usual(&[("0.05 bar", "100 bar", 100.0)])
        .means("Pressure drop over the line at that flow, without the filter."),
    Key::quantity("laminar-share", &[NUMBER], Positive)
        .defaults(&["0.5"])
        .usual(&[("0.01", "1", 100.0)])
        .means("Share of that drop that is proportional to the flow; the rest grows with its square."),
    Key::table("filter", FILTER).otherwise("none").means("The return filter at the end of the line."),
];

pub static PRIORITY: &[Key] = &[
    Key::text("cylinder").required().means("The cylinder whose section is served first."),
    Key::quantity("margin", &[PRESSURE], Positive)
        .required()
        .usual(&[("2 bar", "50 bar", 10.0)])
        .means("Pressure over the load-sensing line that is kept for that section: all other sections are shut there. At least the drop that it needs over its edge."),
    Key::quantity("range", &[PRESSURE], Positive)
        .defaults(&["2 bar"])
        .usual(&[("0.5 bar", "20 bar", 10.0)])
        .means("Rise beyond the margin at which the other sections are free."),
];

static FILTER: &[Key] = &[
    nominal_flow("Flow through the filter at its nominal pressure drop.").required(),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .required()
        .usual(&[("0.02 bar", "10 bar", 10.0)])
        .means("Pressure drop over the filter at that flow; the drop is proportional to the flow."),
    Key::quantity("bypass-pressure", &[PRESSURE], Positive)
        .otherwise("no bypass valve")
        .usual(&[("0.5 bar", "10 bar", 10.0)])
        .means("Pressure drop over the filter that opens its bypass valve."),
    Key::quantity("bypass-overpressure", &[PRESSURE], Positive)
        .defaults(&["0.5 bar"])
        .usual(&[("0.05 bar", "5 bar", 10.0)])
        .means("Rise beyond it at which the bypass valve passes the nominal flow of the filter."),
];

pub static PORT_RELIEF: &[Key] = &[
    cylinder("The cylinder that it protects."),
    side("The side that it relieves."),
    setting("Pressure over that of the tank at which it begins to open."),
    nominal_flow("Flow at the overpressure.").required(),
    overpressure(),
];

pub static CROSSOVER_RELIEF: &[Key] = &[
    cylinder("The cylinder that it protects."),
    side("The side that it relieves; the oil flows to the other side."),
    setting("Pressure of that side over the other one at which it begins to open."),
    nominal_flow("Flow at the overpressure.").required(),
    overpressure(),
];

pub static ANTI_CAVITATION: &[Key] = &[
    cylinder("The cylinder that it feeds."),
    side("The side that it feeds."),
    nominal_flow("Flow from the tank at the nominal pressure drop.").required(),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .required()
        .usual(&[("0.2 bar", "20 bar", 10.0)])
        .means("Drop from the tank to the port at that flow."),
    Key::quantity("opening-pressure", &[PRESSURE], Positive)
        .defaults(&["0.1 bar"])
        .usual(&[("0.01 bar", "5 bar", 10.0)])
        .means("Drop that opens it, below the nominal one."),
];
