//! Derivatives of the inputs of a run by keys of the machine file.

use hydrocrane_machine::by_keys::Keys;
use hydrocrane_machine::model::Form;
use hydrocrane_machine::{OverrideValue, Template};
use hydrocrane_plant::cylinders::hydraulic_axis::FrictionLaw;
use hydrocrane_sim::sensitivity::inputs::{check_effect, machines_by, Differentiated, Inputs, WIDTH};
use std::f64::consts::PI;

/// The rig with one key: its inputs with derivatives, and the value of the key.
fn rig(key: &str) -> (Inputs<Differentiated, 1>, f64) {
    let template = Template::open("single-cylinder", &[]).expect("bundled");
    let keys = Keys::new(template, &[key.to_string()]).expect("a number");
    (inputs::<1>(&keys), keys.values()[0])
}

/// The inputs with derivatives by the first keys, at the values of the machine.
fn inputs<const N: usize>(keys: &Keys) -> Inputs<Differentiated, N> {
    let machines = machines_by(keys, &keys.values()).expect("a machine");
    Inputs::of(&machines[0]).expect("inputs")
}

/// Whether two numbers differ in their last digits at most.
fn equal(a: f64, b: f64) -> bool {
    (a - b).abs() <= 4.0 * f64::EPSILON * b.abs()
}

#[test]
fn keys_that_enter_linearly_have_a_slope_of_one() {
    let (inputs, _) = rig("supply.pressure");
    assert_eq!(inputs.plant.supply_pressures.supply.derivative, [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(inputs.plant.supply_pressures.tank.derivative, [0.0; WIDTH]);
    // At the edge of its range: the tank's pressure is zero and cannot be lower.
    let (inputs, value) = rig("supply.tank-pressure");
    assert_eq!(value, 0.0);
    assert_eq!(inputs.plant.supply_pressures.tank.derivative[0], 1.0);
}

#[test]
fn diameters_and_gaps_have_the_slopes_of_their_formulas() {
    let (inputs, bore) = rig("cylinder.test.bore");
    let area = inputs.plant.cylinders[0].chambers.area_1;
    assert!(equal(area.derivative[0], PI / 2.0 * bore));
    let (inputs, gap) = rig("cylinder.test.leakage-gap");
    let internal = inputs.plant.cylinders[0].leakage.internal;
    // pi (r + s) s^3 / (6 eta l)
    let radius = 0.025;
    let relative = gap * internal.derivative[0] / internal.value;
    assert!(equal(relative, 3.0 + gap / (radius + gap)), "{relative}");
}

#[test]
fn short_cuts_for_exponents_are_left_where_these_vary() {
    let short_cuts = |key: &str| match rig(key).0.plant.cylinders[0].friction {
        FrictionLaw::LuGre { map, .. } => (map.gaussian, map.three_halves),
        _ => panic!("the rig has bristles"),
    };
    assert_eq!(short_cuts("friction.test.coulomb[0]"), (true, true));
    assert_eq!(short_cuts("friction.test.stribeck-exponent[1]"), (false, true));
    assert_eq!(short_cuts("friction.test.viscous-exponent"), (true, false));
}

#[test]
fn what_the_laws_do_not_see_is_refused_by_its_name() {
    let rating = ("cylinder.test.pressure-rating".to_string(), OverrideValue::Number(2e7));
    let keys = ["supply.pressure".to_string(), rating.0.clone()];
    let keys = Keys::new(Template::open("single-cylinder", &[rating]).expect("bundled"), &keys).expect("numbers");
    let error = check_effect(&keys, &[inputs::<1>(&keys)]).expect_err("held");
    assert!(error.to_string().starts_with("`cylinder.test.pressure-rating` does not enter"), "{error}");
}

/// Points of a difference quotient beside the one in the middle, or at the edge of what a value may be.
const POINTS: i32 = 8;

/// What rounding leaves of zero: of the inertia of a body about its own centre of gravity, for example.
const RESIDUE: f64 = 1e-30;

/// Weights of the values at multiples of the step, of order eight.
const CENTRAL: [(i32, f64); 8] = [
    (-4, 1.0 / 280.0),
    (-3, -4.0 / 105.0),
    (-2, 0.2),
    (-1, -0.8),
    (1, 0.8),
    (2, -0.2),
    (3, 4.0 / 105.0),
    (4, -1.0 / 280.0),
];

/// The same to one side: sum of (-1)^(k+1)/k Delta^k, without the weight of the point itself.
fn one_sided(direction: i32) -> Vec<(i32, f64)> {
    let mut binomial = 1.0;
    let weight = |k: i32| {
        binomial *= f64::from(POINTS + 1 - k) / f64::from(k);
        (direction * k, f64::from(direction) * if k % 2 == 0 { -binomial } else { binomial } / f64::from(k))
    };
    (1..=POINTS).map(weight).collect()
}

/// Derivatives of the plain numbers by the only key, with the size of their rounding errors; `None`: the file allows no
/// other value.
fn quotients<const N: usize>(keys: &Keys) -> Option<Vec<(f64, f64)>> {
    let value = keys.values()[0];
    let numbers = |value: f64| Some(Inputs::<f64, N>::of(&keys.machine(&[value]).ok()?).ok()?.numbers());
    let here = numbers(value).expect("as it is");
    let quotient = |step: f64, weights: &[(i32, f64)]| -> Option<Vec<(f64, f64)>> {
        let mut sums = vec![(0.0, 0.0); here.len()];
        for (times, weight) in weights {
            for ((sum, there), here) in sums.iter_mut().zip(numbers(value + f64::from(*times) * step)?).zip(&here) {
                // Limits that are infinite stay so.
                let change = if there == *here { 0.0 } else { there - here };
                *sum = (sum.0 + weight * change / step, sum.1 + f64::EPSILON * (weight * here / step).abs());
            }
        }
        Some(sums)
    };
    let steps: &[f64] = if value == 0.0 { &[1e-3, 1e-6, 1e-9, 1e-12, 1e-15] } else { &[4e-3, 4e-4, 4e-5] };
    let size = if value == 0.0 { 1.0 } else { value.abs() };
    let kinds = [CENTRAL.to_vec(), one_sided(1), one_sided(-1)];
    let mut all = steps.iter().flat_map(|step| kinds.iter().map(move |weights| (step * size, weights)));
    all.find_map(|(step, weights)| quotient(step, weights))
}

/// Every value of the file, values of pairs one by one and where they are shared both at once too.
fn all_keys(template: &Template) -> Vec<String> {
    let machine = template.build(&[]).expect("a machine");
    let mut all = Vec::new();
    for entry in machine.provenance.iter().filter(|entry| entry.value.form != Form::List) {
        if entry.value.form != Form::Two {
            all.push(entry.key.clone());
        }
        if entry.value.form != Form::One {
            all.extend([0, 1].map(|element| format!("{}[{element}]", entry.key)));
        }
    }
    all
}

/// Compares the derivatives of a machine with difference quotients of plain ones, by every key that begins with `prefix`; how
/// many of them enter.
fn compare<const N: usize>(name: &str, overrides: &[(&str, f64)], prefix: &str) -> usize {
    let overrides: Vec<_> =
        overrides.iter().map(|(key, value)| (key.to_string(), OverrideValue::Number(*value))).collect();
    let open = || Template::open(name, &overrides).expect("bundled");
    let mut entering = 0;
    for key in all_keys(&open()).into_iter().filter(|key| key.starts_with(prefix)) {
        let keys = Keys::new(open(), std::slice::from_ref(&key)).expect("a number");
        let machine = keys.machine_with::<Differentiated>(&keys.values(), 0..1).expect("as it is");
        let found = Inputs::<_, N>::of(&machine).expect("a plant").numbers();
        let plain = Inputs::<f64, N>::of(&keys.machine(&keys.values()).expect("as it is")).expect("a plant").numbers();
        assert!(found.iter().zip(&plain).all(|(found, plain)| found.value.to_bits() == plain.to_bits()), "{key}");
        let wanted = quotients::<N>(&keys);
        let largest = found.iter().fold(0.0, |most: f64, number| most.max(number.derivative[0].abs()));
        entering += usize::from(largest != 0.0);
        let Some(wanted) = wanted else {
            assert_eq!(largest, 0.0, "{name}: {key} cannot be moved");
            continue;
        };
        for (i, (number, (wanted, rounding))) in found.iter().zip(wanted).enumerate() {
            let slope = number.derivative[0];
            let allowed = 1e-12 * slope.abs() + 8.0 * rounding + RESIDUE;
            assert!(
                (slope - wanted).abs() <= allowed,
                "{name}: number {i} = {:e} by {key}: {slope:e}, not {wanted:e}",
                number.value
            );
        }
    }
    entering
}

const GROUND: [(&str, f64); 9] = [
    ("ground.height", -2.0),
    ("payload.hang", 0.32),
    ("payload.hang-growth", 0.044),
    ("ground.support.bunk.height", -1.5),
    ("ground.support.bunk.from", 1.4),
    ("ground.support.bunk.to", 2.0),
    ("ground.support.shelf.height", -1.9),
    ("ground.support.shelf.from", 2.5),
    ("ground.support.shelf.to", 2.7),
];

/// The whole way from a file to the laws, against differences of order eight that are taken of plain machines.
#[test]
fn derivatives_by_every_value_are_those_of_differences() {
    assert!(compare::<1>("single-cylinder", &[], "") >= 60);
    assert!(compare::<1>("rig-rottne", &[], "") >= 60);
    assert!(compare::<1>("rig-kalmar", &[], "") >= 60);
}

#[test]
fn derivatives_by_every_value_of_the_laboratory_crane() {
    assert!(compare::<3>("rottne-f9-lab", &[], "") >= 160);
    assert!(compare::<3>("rottne-f9-lab", &GROUND, "ground") == 7);
}

#[test]
fn derivatives_by_every_value_of_the_loader_crane() {
    assert!(compare::<3>("hiab-xs031", &[], "") >= 160);
}

#[test]
fn derivatives_by_every_value_of_the_printed_program() {
    assert!(compare::<3>("heinze-2007", &[], "") >= 160);
}
