//! Machines and scenarios compiled into the program.

macro_rules! bundle {
    ($folder:literal: $($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../../", $folder, "/", $name, ".toml")))),*]
    };
}

/// Name and text of every bundled machine.
pub fn bundled_machines() -> &'static [(&'static str, &'static str)] {
    bundle!("machines": "rottne-f9-lab", "rottne-f9-pump", "rottne-f9-mobile", "rottne-f9-ls", "rottne-f9-forwarder", "heinze-2007", "hiab-xs031", "sany-sy19e", "single-cylinder", "rig-rottne", "rig-kalmar")
}

/// Name and text of every bundled scenario.
pub fn bundled_scenarios() -> &'static [(&'static str, &'static str)] {
    bundle!(
        "scenarios": "vertical-lift-open-loop",
        "tip-vertical-line",
        "tip-log-pick-and-place",
        "flow-valve-lift",
        "heinze-2007-open-loop",
        "hiab-lift",
        "forwarder-swing",
        "forwarder-tip",
        "excavator-swing",
        "excavator-tip",
        "single-cylinder-step",
        "rig-small-sine",
        "rig-constant-velocity",
        "rig-ramp",
        "rig-step",
        "rig-break-away",
        "rig-frictional-lag",
        "rig-load-variation",
        "rig-pressure-variation",
        "rig-kalmar-ramp",
    )
}
