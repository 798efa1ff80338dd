//! Scenario files.

use super::circuit;
use super::control::CONTROLLERS;
use super::Sign::{Any, NonNegative, Positive};
use super::{Key, Kind, Value};
use crate::units::quantities::{ANGLE, ANGULAR_VELOCITY, FORCE, LENGTH, MASS, NUMBER, PRESSURE, TIME, VELOCITY};

/// The axes of a stick that moves the tip; other axes are cylinders.
pub const TIP_AXES: [&str; 3] = ["x", "z", "slew"];

/// Lever control stands beside the controllers that take gains.
pub const LEVER: &str = "lever";

const PERIOD: (&str, &str, f64) = ("0.2 ms", "1 s", 2.0);
const INTERPOLATION: &[&str] = &["hold", "linear"];
const LOG_NUMBERS: Key = Key::choice("number-format", &["1,234.5", "1.234,5"])
    .otherwise("as its cells say")
    .means("How the log writes numbers, where its cells leave it open.");

/// Everything that may stand at the top of a scenario file.
pub static SCENARIO: &[Key] = &[
    Key::table("scenario", HEAD).required().means("Machine, duration and recording of the run."),
    Key::new("overrides", Value::Overrides)
        .otherwise("none")
        .means("Values that replace those of the machine, by key."),
    Key::table("initial", INITIAL).means("The state at the start."),
    Key::table("payload", PAYLOAD)
        .otherwise("`scenario.payload` stays")
        .means("Loads picked up and set down during the run."),
    Key::table("command", COMMAND).otherwise("spools centred").means("Spool commands against time."),
    Key::table("supply", SUPPLY)
        .otherwise("that of the machine")
        .means("Measured pressure of the supply against time, on a machine without a pump."),
    Key::table("controller", CONTROLLER)
        .otherwise("that of the joystick's mode")
        .means("The controller that drives the crane."),
    Key::table("joystick", JOYSTICK).otherwise("sticks centred").means("Deflections of the operator's sticks."),
    Key::table("goal", GOAL)
        .otherwise("only the stick moves the tip")
        .means("Points to which the tip moves on straight lines, with the controller `tip`.")
        .source("theory/control/reference.md#moving-to-a-point"),
    Key::tables("phase", PHASE)
        .otherwise("none")
        .means("Changes that apply from a given time on.")
        .source("theory/simulation.md"),
    Key::tables("burst", BURST).otherwise("none").means("A hose that bursts.").source("theory/hydraulics/hose_leak.md"),
    Key::tables("sensor-fault", SENSOR_FAULT).otherwise("none").means("A sensor that fails."),
    Key::table("solver", SOLVER).means("The method of integration and its tolerances."),
];

static HEAD: &[Key] = &[
    Key::text("name").required().means("Name of the scenario, used for files."),
    Key::text("title").otherwise("none").means("Title for charts and reports."),
    Key::text("machine").required().means("Bundled name of the machine, or its path relative to the scenario file."),
    Key::quantity("duration", &[TIME], Positive)
        .required()
        .usual(&[("1 ms", "100000 s", 100.0)])
        .means("Simulated time."),
    Key::quantity("record-interval", &[TIME], Positive)
        .defaults(&["10 ms"])
        .usual(&[("0.1 ms", "10000 s", 1e3)])
        .means("Time between recorded points."),
    Key::quantity("payload", &[MASS], NonNegative)
        .otherwise("the machine's")
        .usual(&[("0.01 kg", "50 t", 100.0)])
        .means("Load at the tip."),
    Key::quantity("seed", &[NUMBER], NonNegative)
        .defaults(&["0"])
        .usual(&[("1", "9007199254740992", 1.0)])
        .means("Seed of the sensors' errors and noise, a whole number up to 2^53; stored with the results."),
    Key::text("recorded-by")
        .otherwise("not a recorded drive")
        .means("Version of hydrocrane whose cockpit recorded the drive; `simulate` warns if its own version differs."),
    Key::text("recorded-on").otherwise("not compared").means(
        "Digest of the values of the machine file that the drive was recorded on; a file with other values is refused.",
    ),
];

static INITIAL: &[Key] = &[
    Key::choice("pressures", &["equilibrium"])
        .defaults(&["equilibrium"])
        .means("Pressures that hold the crane at rest; excludes `initial.pressure`."),
    Key::table("joint", INITIAL_JOINT).means("Coordinates at the start."),
    Key::table("pressure", INITIAL_PRESSURE)
        .otherwise("equilibrium")
        .means("Pressures at the start, of every cylinder."),
];

static INITIAL_JOINT: &[Key] = &[Key::quantity("<joint>", &[ANGLE, LENGTH], Any)
    .otherwise("an error: every joint has a start")
    // Sliding joints reach as far as the bounds of cylinders let them.
    .usual(&[("0 deg", "360 deg", 100.0), ("0 m", "100 m", 50.0)])
    .means("Coordinate of the joint.")];

static INITIAL_PRESSURE: &[Key] = &[Key::pair("<cylinder>", &[PRESSURE], Any)
    .usual(&[("0 bar", "1000 bar", 2.0)])
    .means("Gauge pressures (piston side, rod side).")];

static PAYLOAD: &[Key] = &[
    Key::series("time", &[TIME]).required().means("Times of the changes, above zero and increasing."),
    Key::series("mass", &[MASS])
        .required()
        .usual(&[("0.01 kg", "50 t", 1e3)])
        .means("Load from each of these times on; a load is at rest when it is picked up."),
];

static COMMAND: &[Key] = &[
    Key::text("log")
        .otherwise("a table for each cylinder")
        .means("CSV file with the commands, beside the scenario file; its columns are named as the cylinders."),
    Key::text("time").otherwise("`time` or `t`").means("Column of the log that holds the times."),
    LOG_NUMBERS,
    Key::choice("interpolation", INTERPOLATION)
        .otherwise("`linear`")
        .means("Interpolation between two rows of the log."),
    Key::table("<cylinder>", COMMAND_OF_CYLINDER).otherwise("spool centred").means("Spool command of the cylinder."),
];

static SUPPLY: &[Key] = &[
    Key::text("log").otherwise("`time` and `pressure`").means("CSV file with the pressure, beside the scenario file."),
    Key::text("column")
        .otherwise("`supply.pressure`, `mains.p` or `supply`")
        .means("Column of the log that holds the pressure."),
    Key::text("unit").otherwise("that of the log, or Pa").means("Unit of the column."),
    Key::text("time-column").otherwise("`time` or `t`").means("Column of the log that holds the times."),
    LOG_NUMBERS,
    Key::series("time", &[TIME]).otherwise("this, or `supply.log`").means("Times of the pressure, increasing."),
    Key::series("pressure", &[PRESSURE])
        .otherwise("this, or `supply.log`")
        .means("Gauge pressure at these times; constant before the first and after the last."),
    Key::choice("interpolation", INTERPOLATION).otherwise("`linear`").means("Interpolation between two times."),
];

static COMMAND_OF_CYLINDER: &[Key] = &[
    Key::series("time", &[TIME]).otherwise("this, or `command.log`").means("Times of the command, increasing."),
    Key::series("spool", &[LENGTH])
        .otherwise("this, or `command.log`")
        .means("Spool position at these times; positive extends."),
    Key::choice("interpolation", INTERPOLATION).defaults(&["hold"]).means("Interpolation between two times."),
    Key::text("column").otherwise("the cylinder's name").means("Column of the log that holds the command."),
    Key::text("unit").otherwise("that of the log, or m").means("Unit of the column."),
];

static CONTROLLER: &[Key] = &[
    Key::choice("name", &[CONTROLLERS[0].0, CONTROLLERS[1].0, LEVER])
        .otherwise("the one that supports the joystick's mode")
        .means("The controller; excludes `command`."),
    Key::quantity("period", &[TIME], Positive)
        .otherwise("the machine's")
        .usual(&[PERIOD])
        .means("Time between samples."),
    Key::quantity("delay", &[TIME], NonNegative)
        .defaults(&["0 s"])
        .usual(&[("0.1 ms", "1 s", 60.0)])
        .means("Computation delay."),
    Key::choice("sensors", &["ideal", "data-sheet"])
        .defaults(&["ideal"])
        .means("Ideal readings, or those of the machine's sensors with errors drawn by `scenario.seed`."),
    Key::new("model", Value::Overrides)
        .otherwise("the true values")
        .means("The controller model: values of the machine that the controller assumes, by key as in `overrides`."),
    Key::choice("monitor", &["on", "off"])
        .otherwise("`on` for `tip` and `heinze-pid`")
        .means("Whether implausible sensor readings close the valves.")
        .source("theory/control/plausibility.md"),
];

static JOYSTICK: &[Key] = &[
    Key::choice("mode", &["tip", "lever", "height"])
        .defaults(&["tip"])
        .means("`tip`: one stick moves the tip; `lever`: one axis per cylinder; `height`: one axis per cylinder too, while one joint holds the tip's height."),
    Key::series("time", &[TIME]).otherwise("this, or `log`").means("Times of the deflections, increasing."),
    Key::choice("interpolation", INTERPOLATION)
        .otherwise("`hold`, `linear` for a log")
        .means("Interpolation between two times."),
    Key::quantity("dead-zone", &[NUMBER], NonNegative)
        .defaults(&["0"])
        .means("Dead zone around the centre, share of the deflection."),
    Key::quantity("full-speed", &[VELOCITY], Positive)
        .otherwise("the machine's")
        .means("Speed of the tip at full deflection."),
    Key::quantity("ramp", &[TIME], NonNegative)
        .defaults(&["0 s"])
        .means("Time that the stick takes from the centre to full deflection."),
    Key::series("precision", &[NUMBER])
        .otherwise("1")
        .means("Share of the full speed at these times, from 0 to 1: a slower stick for precise work."),
    Key::text("log")
        .otherwise("this, or `time`")
        .means("CSV, MATLAB or NetCDF file with the deflections, beside the scenario file."),
    LOG_NUMBERS,
    Key::series(TIP_AXES[0], &[NUMBER]).otherwise("centred").means("Deflection along x, from -1 to 1."),
    Key::series(TIP_AXES[1], &[NUMBER]).otherwise("centred").means("Deflection along z, from -1 to 1."),
    Key::series(TIP_AXES[2], &[NUMBER])
        .otherwise("centred")
        .means("Deflection across, from -1 to 1, of a crane that slews: positive turns the slewing joint by a growing angle."),
    Key::series("<cylinder>", &[NUMBER])
        .otherwise("centred")
        .means("Deflection of the cylinder's lever, from -1 to 1, with `mode = \"lever\"` or `\"height\"`."),
];

static GOAL: &[Key] = &[
    Key::series("time", &[TIME])
        .required()
        .means("Times of the goals, increasing; a goal applies until the next one or until a stick is moved."),
    Key::series(TIP_AXES[0], &[LENGTH]).required().means("Forward coordinate of each goal."),
    Key::series(TIP_AXES[1], &[LENGTH]).required().means("Height of each goal."),
    Key::series("speed", &[VELOCITY]).otherwise("the speed of full stick").means("Speed towards each goal."),
    Key::series("drop", &[TIME])
        .otherwise("never")
        .means("Times at which the present goal is cancelled: the tip stops where it is."),
];

static PHASE: &[Key] = &[
    Key::quantity("time", &[TIME], Positive).required().means("When the phase begins."),
    Key::new("overrides", Value::Overrides)
        .otherwise("none")
        .means("Further changes of the machine; use `[payload]` to change the load."),
    Key::table("controller", CONTROLLER)
        .otherwise("unchanged; if the stick's mode changes, the one that supports it")
        .means("The controller from here on; its period is unchanged unless stated."),
    Key::table("joystick", JOYSTICK)
        .otherwise("unchanged; centred if the controller needs the other mode")
        .means("The sticks from here on; times count from the start of the run."),
];

static BURST: &[Key] = &[
    circuit::cylinder("The cylinder to which the hose leads."),
    circuit::side("The side to which it leads."),
    Key::quantity("time", &[TIME], NonNegative).required().means("When the hose bursts."),
    circuit::hole("Area of the hole from then on; that of the bore where the hose is torn off."),
];

/// What sensors measure.
const MEASURED: &[Kind] = &[ANGLE, LENGTH, PRESSURE, FORCE, VELOCITY, ANGULAR_VELOCITY];

static SENSOR_FAULT: &[Key] = &[
    Key::text("signal").required().means(
        "What fails: `joint.<joint>.q`, `cylinder.<cylinder>.p1` or `.p2`; \
         with data-sheet sensors any signal that the machine measures.",
    ),
    Key::choice("kind", &["freeze", "jump", "drop-out"])
        .required()
        .means("`freeze`: the reading stays constant; `jump`: `size` is added to it; `drop-out`: there is no reading."),
    Key::quantity("from", &[TIME], NonNegative).required().means("When the fault begins."),
    Key::quantity("until", &[TIME], Positive).otherwise("the end of the run").means("When the fault ends."),
    Key::quantity("size", MEASURED, Any)
        .otherwise("required for a jump")
        .means("Size of the jump, in the unit of the signal."),
];

/// Methods of integration: `auto` chooses among the others.
pub static METHODS: &[&str] = &["auto", "rodas5p", "hc-exponential-4", "tsit5", "hc-rosenbrock-3"];

static SOLVER: &[Key] = &[
    Key::choice("method", METHODS)
        .defaults(&["auto"])
        .means(
            "Method of integration: `auto` takes the fastest suitable one for the machine; \
             `rodas5p`, `hc-exponential-4` and `hc-rosenbrock-3` are for stiff machines, `tsit5` is explicit.",
        )
        .source("theory/integration.md"),
    Key::quantity("rtol", &[NUMBER], Positive)
        .defaults(&["3e-5"])
        .usual(&[("1e-12", "0.1", 1e3)])
        .means("Relative tolerance.")
        .source("theory/integration.md"),
    Key::quantity("atol", &[NUMBER], Positive)
        .otherwise("that of `rtol`")
        .usual(&[("1e-15", "1", 1e3)])
        .means("Absolute tolerance, relative to the scale of each state."),
    Key::quantity("max-step", &[TIME], Positive)
        .defaults(&["50 ms"])
        .usual(&[("0.01 ms", "1 s", 1e3)])
        .means("Largest step."),
    Key::quantity("step", &[TIME], Positive)
        .otherwise("step size control by the tolerances")
        .usual(&[("0.01 ms", "100 ms", 100.0)])
        .means("Largest fixed step; each interval between changes of a command is divided into equal steps."),
];
