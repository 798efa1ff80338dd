//! Units as data sheets of pumps, valves and oils state them, and what is suggested in place of a wrong one.

use hydrocrane_machine::{load, Machine, OverrideValue};

fn with(key: &str, value: &str) -> Result<Machine, String> {
    load("rottne-f9-ls", &[(key.into(), OverrideValue::Text(value.into()))]).map_err(|error| error.to_string())
}

#[test]
fn a_displacement_may_be_stated_per_revolution() {
    let displacement =
        |text: &str| with("pump.main.displacement", text).unwrap().supply.mains.unwrap().pump.displacement;
    for text in ["28 ml", "28 cc", "28 ccm", "28 cm3", "28 cm3/rev", "28 cc/rev", "28 ml/rev"] {
        assert!((displacement(text) - 28e-6).abs() < 1e-18, "{text}: {}", displacement(text));
    }
    let inches = displacement("1.7 in^3/rev");
    assert!((inches - 1.7 * 0.0254f64.powi(3)).abs() < 1e-18, "{inches}");
}

#[test]
fn a_kinematic_viscosity_counts_times_the_density() {
    let crane = with("fluid.viscosity", "46 cSt").unwrap();
    assert!((crane.fluid.viscosity - 46e-6 * crane.fluid.density).abs() < 1e-15);
    let entry = crane.provenance.iter().find(|entry| entry.key == "fluid.viscosity").unwrap();
    assert_eq!((entry.value.si[0], &*entry.value.units[0]), (crane.fluid.viscosity, "Pa s"));
    assert!((with("fluid.viscosity", "40 mPa s").unwrap().fluid.viscosity - 0.04).abs() < 1e-15);
    assert!((with("fluid.viscosity", "40 cP").unwrap().fluid.viscosity - 0.04).abs() < 1e-15);
    assert!(!with("fluid.viscosity", "46 Pa s").unwrap().warnings.is_empty());
}

#[test]
fn suggestions_give_the_expected_quantity_of_a_usual_size() {
    for (key, value, wanted) in [
        ("supply.pressure", "20 mpa", "did you mean `MPa`?"),
        ("fluid.viscosity", "40 mpa s", "did you mean `mPa`?"),
        ("valve.lift.nominal-flow", "40 Lpm", "did you mean `lpm`?"),
        ("valve.lift.nominal-flow", "40 lt/min", "did you mean `l`?"),
        ("cylinder.lift.bore", "63 nm", "did you mean `mm`?"),
        ("pump.main.speed", "1450 1/min", "write 1450 rpm"),
        ("control.period", "1 S", "did you mean `s`?"),
        ("joint.boom.dead-centre-margin", "3 grad", "write deg: a grad is 1 deg to some"),
        ("fluid.viscosity", "46 SSU", "write cSt, from a table"),
        ("supply.pressure", "190 kg/cm2", "write kgf and tf for their weights"),
        ("supply.pressure", "190 bar g", "gauge: write \"190 bar\""),
        ("supply.pressure", "190 bara", "gauge: write what is above the atmosphere, 1.01325 bar, in bar"),
        ("payload.mass", "5 tf", "write kg or t for the mass"),
        ("valve.lift.overlap", "20 %", "a share, and nothing says of what; give a length"),
    ] {
        let found = with(key, value).unwrap_err();
        assert!(found.contains(wanted), "{key} = {value}: {found}");
    }
    assert!(with("supply.pressure", "190 kgf/cm2").is_ok());
    // What is nothing like a unit of the quantity is answered by a list of its own units, never by another quantity's.
    let found = with("valve.lift.nominal-flow", "40 xyz").unwrap_err();
    assert!(!found.contains("rpm") && !found.contains("MPa"), "{found}");
}
