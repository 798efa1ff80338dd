//! `[control]` and `[errata]`.

use super::Sign::{NonNegative, Positive};
use super::{Key, Kind, Usual};
use crate::units::quantities::{ANGULAR_FREQUENCY, LENGTH, NUMBER, TIME, VELOCITY};

/// The controllers that a scenario can name and a machine file can give gains to, with the keys of their tables.
pub const CONTROLLERS: [(&str, &[Key]); 2] = [("tip", TIP), ("heinze-pid", HEINZE_PID)];

/// Thresholds of the sensor monitor.
pub const PLAUSIBILITY: (&str, &[Key]) = ("plausibility", THRESHOLDS);

pub static CONTROL: &[Key] = &[
    Key::quantity("period", &[TIME], Positive)
        .otherwise("the controller's own")
        .usual(&[("0.2 ms", "0.2 s", 10.0)])
        .means("Time between samples."),
    Key::table(CONTROLLERS[0].0, CONTROLLERS[0].1).means("Gains of tip control.").source("theory/control/tip.md"),
    Key::table(CONTROLLERS[1].0, CONTROLLERS[1].1)
        .means("Settings of the thesis' controller.")
        .source("theory/control/heinze_pid.md"),
    Key::table(PLAUSIBILITY.0, PLAUSIBILITY.1)
        .means("Thresholds of the sensor monitor.")
        .source("theory/control/plausibility.md"),
];

const PER_METRE: Kind = gain_in("1/m");
const PER_SECOND: Kind = gain_in("1/s");
const FULL_SPEED: &[Usual] = &[("1 mm/s", "10 m/s", 100.0)];

const fn gain_in(unit: &'static str) -> Kind {
    Kind { name: "gain", unit }
}

const fn gain(name: &'static str, kind: &'static [Kind]) -> Key {
    Key::quantity(name, kind, NonNegative)
}

const TIP: &[Key] = &[
    gain("full-speed", &[VELOCITY])
        .otherwise("speed with the fastest joint alone, in the middle of all ranges, or less where the oil would not follow")
        .usual(FULL_SPEED)
        .means("Speed of the tip at full stick."),
    gain("stick-bandwidth", &[ANGULAR_FREQUENCY])
        .defaults(&["15 rad/s"])
        .means("Bandwidth with which the commanded velocity follows the stick."),
    gain("path-rate", &[PER_SECOND]).defaults(&["30 1/s"]).means("Rate at which the set-point returns to its line."),
    gain("limit-rate", &[PER_SECOND])
        .defaults(&["2 1/s"])
        .means("Largest speed towards a limit (joints) or a region (tip), per distance from it."),
    gain("keep-out-margin", &[LENGTH])
        .defaults(&["50 mm"])
        .means("Distance of the set-point from keep-out regions."),
    gain("telescope-centring", &[PER_METRE])
        .defaults(&["0.5 1/m"])
        .means("Gain that moves the telescope towards the middle of its range."),
    gain("position-gain", &[PER_SECOND]).defaults(&["4 1/s"]).means("Piston velocity per position error."),
    gain("damping-ratio", &[NUMBER])
        .defaults(&["0.4"])
        .means("Damping ratio that the valves add to the modes of the crane on its oil.")
        .source("theory/control/regulate.md#damping-of-the-crane-on-its-oil"),
    gain("quiet-speed", &[VELOCITY])
        .defaults(&["0.7 mm/s"])
        .means("Tip speed in an oscillation below which the valves do not damp it."),
    gain("observer-bandwidth", &[ANGULAR_FREQUENCY])
        .defaults(&["5 rad/s"])
        .means("Bandwidth with which the observed position follows the measured one."),
    gain("pressure-bandwidth", &[ANGULAR_FREQUENCY])
        .defaults(&["85 rad/s"])
        .means("Bandwidth of the low-pass on the pressures of the feed-forward."),
    gain("reserve", &[NUMBER]).defaults(&["0.95"]).means("Share of the spool stroke that the commanded speed may use."),
    Key::choice("pressures", &["measured", "estimated"])
        .defaults(&["measured"])
        .means("Where chamber pressures come from: a sensor for each chamber, or an estimate from joint sensors and commands.")
        .source("theory/control/estimate.md#without-pressure-sensors"),
    Key::text("height-joint")
        .otherwise("the telescope, else the last joint")
        .means("Joint that holds the tip's height in the stick mode `height`.")
        .source("theory/control/reference.md#height-held-by-one-joint"),
    gain("rest-band", &[LENGTH])
        .defaults(&["0.2 mm"])
        .means("Position error of a piston up to which only creep is held at rest."),
    gain("learning-time", &[TIME])
        .defaults(&["10 s"])
        .means(
            "Time constant, in time of motion, of what tip control learns about each valve; zero switches learning off.",
        )
        .source("theory/control/estimate.md#learning-of-valve-errors"),
    gain("lag-limit", &[LENGTH])
        .otherwise("0.75 % of the reach")
        .usual(&[("1 mm", "1 m", 100.0)])
        .means("Lag of the tip at which the set-point waits."),
    gain("settling-time", &[TIME])
        .defaults(&["0.5 s"])
        .means("Time after a stop during which every error is corrected."),
];

const HEINZE_PID: &[Key] = &[
    gain("full-speed", &[VELOCITY]).defaults(&["1 m/s"]).usual(FULL_SPEED).means("Speed of the tip at full stick."),
    gain("set-point-interval", &[TIME]).otherwise("the period").means("Time between set-points."),
    gain("limit-rate", &[PER_SECOND]).defaults(&["2 1/s"]).means("As for `tip`."),
    gain("keep-out-margin", &[LENGTH]).defaults(&["50 mm"]).means("As for `tip`."),
    Key::choice("working-area", &["limited", "none"])
        .defaults(&["limited"])
        .means("Whether the set-point is limited to the working area.")
        .source("theory/control/heinze_pid.md#working-area-of-the-thesiss-controller"),
    Key::choice("extension", &["penalty", "zero"])
        .defaults(&["zero"])
        .means("Telescope: `zero` keeps it retracted, `penalty` chooses its position by a penalty function, (131).")
        .source("theory/control/heinze_pid.md#penalty-search"),
    Key::table("motion-weight", MOTION_WEIGHT).means("Weights $w_1$ to $w_3$, with the joint's range as the unit."),
    Key::table("middle-weight", MIDDLE_WEIGHT).means("Weights $w_4$ to $w_6$, with the joint's range as the unit."),
];

static MOTION_WEIGHT: &[Key] =
    &[gain("<joint>", &[NUMBER]).defaults(&["1"]).means("Weight of the joint's motion, in its range.")];
static MIDDLE_WEIGHT: &[Key] = &[gain("<joint>", &[NUMBER])
    .defaults(&["0.1"])
    .means("Weight of the joint's distance from the middle of its range.")];

const THRESHOLDS: &[Key] = &[
    gain("jump", &[LENGTH])
        .otherwise("`flow-tolerance` of the travel of each piston at its fastest in one sample")
        .means("Displacement of a piston in one sample, shown by only one of three residuals, that counts as a fault."),
    gain("frozen", &[LENGTH])
        .otherwise("twice the displacement that counts as a jump")
        .means("Travel of a piston during which its position reading may stay the same."),
    gain("flow-tolerance", &[NUMBER]).defaults(&["0.25"]).means("Error of the valve law, share of the flow."),
    gain("pressure-tolerance", &[NUMBER])
        .defaults(&["0.03"])
        .means("Smallest assumed error of pressures, share of the supply pressure of the file."),
    gain("stroke-margin", &[NUMBER])
        .defaults(&["0.05"])
        .means("Plausible piston reading beyond the end of the stroke, share of the stroke."),
    gain("pressure-limit", &[NUMBER])
        .defaults(&["2"])
        .means("Highest pressure that is plausible without a rise that piston and oil confirm, relative to the supply pressure of the file, or the present one if higher, times the ratio of the areas."),
    gain("recovery-time", &[TIME])
        .defaults(&["0.5 s"])
        .means("Time for which a sensor must read plausibly before it is used again."),
    gain("ride-through", &[TIME])
        .defaults(&["50 ms"])
        .means("Time for which control continues without a sensor.")
        .source("theory/control/plausibility.md"),
];

const fn erratum(name: &'static str) -> Key {
    Key::choice(name, &["corrected", "as-printed"]).defaults(&["corrected"])
}

pub static ERRATA: &[Key] = &[
    erratum("gravity-sign").means("Sign of gravity in the equations of motion."),
    erratum("inertia-about").means("Point that moments of inertia refer to."),
    erratum("orifice-law")
        .means("Flow through the metering edges; as printed with the blend of `valve.<name>.printed`."),
    erratum("extension-leakage").means("Chamber that the telescope's external leakage leaves."),
    erratum("extension-dead-volume").means("Dead volume of the telescope's cylinder."),
    erratum("leakage-viscosity").means("Viscosity in the leakage law."),
    erratum("end-stop").means("Force of the end stops."),
    erratum("friction-map").means("Static friction map near standstill."),
    erratum("ik-quadrant").means("Quadrant of the inverse kinematics."),
    erratum("ik-unreachable").means("Inverse kinematics of points out of reach."),
    erratum("ik-extension").means("Extension of the telescope in the inverse kinematics."),
];
