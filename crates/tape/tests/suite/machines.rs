//! Every machine as a tape against the plant itself.

use hydrocrane_machine::by_keys::Keys;
use hydrocrane_machine::{bundled_machines, OverrideValue, Template};
use hydrocrane_num::RandomStream;
use hydrocrane_plant::cylinders::ledger::terms;
use hydrocrane_plant::equations::from_machine::plant;
use hydrocrane_plant::equations::rhs::Evaluator;
use hydrocrane_sim::{build, Model};
use hydrocrane_tape::{export, Program, Request, Step};
use std::collections::HashMap;
use std::sync::Arc;

const STATES: usize = 200;

fn overrides(name: &str) -> Vec<(String, OverrideValue)> {
    // The program of the thesis has a friction that jumps.
    let jumps = name == "heinze-2007";
    let corrected = ("errata.friction-map".to_string(), OverrideValue::Text("corrected".into()));
    jumps.then_some(corrected).into_iter().collect()
}

fn template(name: &str) -> Template {
    Template::open(name, &overrides(name)).expect("bundled")
}

fn model(name: &str) -> Arc<dyn Model> {
    build(&template(name).build(&[]).expect("a machine")).expect("a model")
}

/// A state at random: joints within their limits, pressures from a little below zero to above the supply's, spools over their stroke.
fn random_state(model: &dyn Model, random: &mut RandomStream) -> (Vec<f64>, Vec<f64>) {
    let (layout, machine) = (model.layout(), model.machine());
    let mut within = |lower: f64, upper: f64| lower + (upper - lower) * random.uniform();
    let mut x = vec![0.0; layout.len()];
    for (j, limits) in model.joint_limits().iter().enumerate() {
        x[layout.q(j)] = within(limits.lower, limits.upper);
        x[layout.qd(j)] = within(-0.5, 0.5);
    }
    for (c, cylinder) in machine.cylinders.iter().enumerate() {
        let stroke = cylinder.valve.stroke;
        x[layout.xs(c)] = within(-stroke, stroke);
        x[layout.vs(c)] = within(-0.1, 0.1);
        layout.z(c).into_iter().for_each(|z| x[z] = within(-1e-4, 1e-4));
        layout.opening(c).into_iter().for_each(|at| x[at] = within(0.0, 1.0));
    }
    for p in layout.pressures().collect::<Vec<_>>() {
        x[p] = within(-0.8e5, 1.2 * machine.supply.pressure);
    }
    layout.swivels().for_each(|at| x[at] = within(0.0, 1.0));
    let u = machine.cylinders.iter().map(|c| within(-c.valve.stroke, c.valve.stroke)).collect();
    (x, u)
}

/// The state derivative with cylinders one after the other.
fn one_by_one(model: &dyn Model, x: &[f64], u: &[f64]) -> Vec<f64> {
    fn of<const N: usize>(model: &dyn Model, x: &[f64], u: &[f64]) -> Vec<f64> {
        let (machine, layout, mut dx) = (model.machine(), model.layout(), vec![0.0; x.len()]);
        let plant = plant::<f64, N>(machine).expect("a plant");
        Evaluator::<f64, f64, N>::new(&plant, layout).derivative(layout, x, u, machine.payload.mass, &mut dx);
        dx
    }
    match model.layout().joints() {
        1 => of::<1>(model, x, u),
        4 => of::<4>(model, x, u),
        _ => of::<3>(model, x, u),
    }
}

/// What the steps of a program give, run name by name as a writer would write them.
fn run(program: &Program, function: usize, [x, u, p]: [&[f64]; 3]) -> Vec<f64> {
    let mut names = HashMap::new();
    let input = |names: &mut HashMap<String, f64>, letter: char, values: &[f64]| {
        values.iter().enumerate().for_each(|(i, value)| _ = names.insert(format!("{letter}{i}"), *value));
    };
    [('x', x), ('u', u), ('p', p)].into_iter().for_each(|(letter, values)| input(&mut names, letter, values));
    let value = |names: &HashMap<String, f64>, text: &String| {
        names.get(text).copied().unwrap_or_else(|| text.parse().expect("a constant or a name"))
    };
    let go = |names: &mut HashMap<String, f64>, steps: &[Step]| {
        for Step { result, operation, operands } in steps {
            let numbers: Vec<f64> = operands.iter().map(|operand| value(names, operand)).collect();
            let found = match (*operation, numbers.as_slice()) {
                ("place", [table, x]) => {
                    program.tables[*table as usize].starts.iter().filter(|start| *start <= x).count() as f64
                }
                ("entry", [table, column, place]) => {
                    program.tables[*table as usize].columns[*column as usize][*place as usize]
                }
                (operation, numbers) => of(operation, numbers),
            };
            names.insert(result.clone(), found);
        }
    };
    go(&mut names, &program.prologue.steps);
    let kept: Vec<f64> = program.prologue.results.iter().map(|text| value(&names, text)).collect();
    input(&mut names, 'c', &kept);
    go(&mut names, &program.functions[function].steps);
    program.functions[function].results.iter().map(|text| value(&names, text)).collect()
}

fn of(operation: &str, numbers: &[f64]) -> f64 {
    use hydrocrane_tape::Kind;
    let kinds = [
        Kind::Add,
        Kind::Subtract,
        Kind::Multiply,
        Kind::Divide,
        Kind::Negate,
        Kind::Root,
        Kind::Exp,
        Kind::Ln,
        Kind::Sin,
        Kind::Cos,
        Kind::Tanh,
        Kind::Magnitude,
        Kind::Positive,
        Kind::Less,
        Kind::LessOrEqual,
        Kind::And,
        Kind::Or,
        Kind::Not,
        Kind::Select,
    ];
    let kind = kinds.into_iter().find(|kind| kind.name() == operation).expect("an operation");
    kind.of(std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0)))
}

#[test]
fn a_tape_has_the_bits_of_the_plant_and_its_derivatives() {
    for (name, _) in bundled_machines() {
        let model = model(name);
        let request = Request { derivatives: true, ..Request::default() };
        let found = export(&template(name), model.layout(), model.output_info(), &request).expect(name);
        assert!(found.program.kept.is_empty() && found.parameters.is_empty(), "{name}");
        let (n, mut random) = (model.layout().len(), RandomStream::new(7, name));
        let mass = model.machine().payload.mass;
        for k in 0..STATES {
            let (mut x, u) = random_state(model.as_ref(), &mut random);
            if k % 10 == 0 {
                // At rest without pressure, where laws have their kinks.
                let layout = model.layout();
                x[layout.joints()..].iter_mut().for_each(|number| *number = 0.0);
            }
            let (mut in_lanes, mut jacobian) = (vec![0.0; n], vec![0.0; n * n]);
            let dx = one_by_one(model.as_ref(), &x, &u);
            assert_eq!(run(&found.program, 0, [&x, &u, &[]]), dx, "{name}");
            // Sums over the cylinders are in another order there.
            model.derivative(&x, &u, mass, &mut in_lanes);
            for (own, other) in dx.iter().zip(&in_lanes) {
                assert!((own - other).abs() <= 1e-13 * other.abs(), "{name}: {own} {other}");
            }
            model.jacobian(&x, &u, mass, &mut jacobian);
            let linearised = run(&found.program, 1, [&x, &u, &[]]);
            assert_eq!(linearised[..n], dx, "{name}");
            let mut own = vec![0.0; n * n];
            for ([row, column], value) in found.places.iter().zip(&linearised[n..]) {
                own[row * n + column] = *value;
            }
            for (row, (own, other)) in own.chunks(n).zip(jacobian.chunks(n)).enumerate() {
                let scale = |column: usize| model.layout().scales[column];
                let size = (0..n).map(|c| other[c].abs() * scale(c)).fold(0.0, f64::max);
                for c in 0..n {
                    let off = (own[c] - other[c]).abs() * scale(c) / size;
                    assert!(own[c] == other[c] || off < 1e-12, "{name} {row} {c}: {} {} {off:e}", own[c], other[c]);
                }
            }
        }
    }
}

/// The tables whose numbers an FMU offers as parameters.
const TUNABLE: [&str; 6] = ["supply", "pump", "mains", "tank-line", "friction", "payload"];

#[test]
fn parameters_are_followed_as_a_machine_with_other_values_has_them() {
    for (name, _) in bundled_machines() {
        let (model, template) = (model(name), template(name));
        let keys = TUNABLE
            .into_iter()
            .filter(|table| model.machine().provenance.iter().any(|entry| entry.key.starts_with(&format!("{table}."))));
        let request = Request { parameters: keys.map(String::from).collect(), ..Request::default() };
        let found = export(&template, model.layout(), model.output_info(), &request).expect(name);
        assert!(found.parameters.len() > 5, "{name}: {:?}", found.parameters);
        let parameters = found.parameters.iter().filter(|parameter| parameter.key != "payload.mass");
        let names: Vec<String> = parameters.map(|parameter| parameter.key.clone()).collect();
        let keys = Keys::new(template, &names).expect(name);
        let p: Vec<f64> = found.parameters.iter().map(|parameter| 1.01 * parameter.value).collect();
        let other = build(&keys.machine(&p[..names.len()]).expect(name)).expect(name);
        let (mut random, mut dx) = (RandomStream::new(11, name), vec![0.0; model.layout().len()]);
        let mass = if p.len() > names.len() { p[names.len()] } else { model.machine().payload.mass };
        for _ in 0..20 {
            let (x, u) = random_state(other.as_ref(), &mut random);
            other.derivative(&x, &u, mass, &mut dx);
            for (i, (own, other)) in run(&found.program, 0, [&x, &u, &p]).iter().zip(&dx).enumerate() {
                assert!((own - other).abs() <= 1e-11 * other.abs() + 1e-9, "{name} {i}: {own} {other}");
            }
        }
        assert_eq!(found.program.kept.len(), found.program.prologue.results.len());
    }
}

#[test]
fn powers_of_the_ledger_are_those_of_the_plant() {
    for (name, _) in bundled_machines() {
        let model = model(name);
        let (terms, mut random) = (terms(model.machine()), RandomStream::new(13, name));
        let elastic = |term: &str| ["elastic", "carried"].contains(&term);
        let kept = (0..terms.len()).filter(|i| !elastic(terms[*i].1 .0));
        let outputs = kept.clone().map(|i| format!("ledger.{}.{}", terms[i].0, terms[i].1 .0)).collect();
        let request = Request { outputs, ..Request::default() };
        let found = export(&template(name), model.layout(), model.output_info(), &request).expect(name);
        let mut powers = vec![0.0; terms.len()];
        for _ in 0..STATES {
            let (x, u) = random_state(model.as_ref(), &mut random);
            model.powers(&x, model.machine().payload.mass, &mut powers);
            let size = powers.iter().map(|power| power.abs()).fold(1.0, f64::max);
            for (i, own) in kept.clone().zip(run(&found.program, 2, [&x, &u, &[]])) {
                assert!((own - powers[i]).abs() <= 1e-12 * size, "{name} {:?}: {own} {}", terms[i], powers[i]);
            }
        }
    }
}

fn refusal(keys: &[&str], outputs: &[&str]) -> String {
    let own = |names: &[&str]| names.iter().map(ToString::to_string).collect();
    let request = Request { parameters: own(keys), outputs: own(outputs), derivatives: false };
    let model = model("rottne-f9-lab");
    export(&template("rottne-f9-lab"), model.layout(), model.output_info(), &request).expect_err("refused").to_string()
}

#[test]
fn what_cannot_be_exported_is_refused_by_name() {
    assert!(refusal(&["friction.lift.colomb"], &[]).contains("friction.lift.colomb"));
    assert!(refusal(&["valve.lift.delay"], &[]).contains("valve.lift.delay"));
    assert!(refusal(&[], &["tip.y"]).contains("did you mean `tip.x`?"));
    assert!(refusal(&[], &["energy.oil"]).contains("table"));
    assert!(refusal(&[], &["ledger.lift.elastic"]).contains("table"));
    assert!(refusal(&[], &["ledger.lift.fricton"]).contains("did you mean `ledger.lift.friction`?"));
    let jumping = Template::open("heinze-2007", &[]).expect("bundled");
    let model = build(&jumping.build(&[]).expect("a machine")).expect("a model");
    let error = export(&jumping, model.layout(), model.output_info(), &Request::default()).expect_err("it jumps");
    assert!(error.to_string().contains("errata.friction-map"));
}

#[test]
fn an_exponent_is_a_parameter_where_it_is_named_and_keeps_the_shorter_formula_elsewhere() {
    let (model, template) = (model("rottne-f9-lab"), template("rottne-f9-lab"));
    let exported = |key: &str| {
        let request = Request { parameters: vec![key.into()], ..Request::default() };
        export(&template, model.layout(), model.output_info(), &request).expect(key)
    };
    let key = "friction.lift.viscous-exponent";
    assert!(exported("friction").parameters.iter().all(|parameter| parameter.key != key));
    assert_eq!(exported(key).parameters[0].key, key);
}

/// Leakage from nothing decides that there is a leak, and friction has formulas of its own for two exponents.
#[test]
fn tables_have_the_parameters_together_that_each_has_by_itself() {
    let (model, template) = (model("hiab-xs031"), template("hiab-xs031"));
    let keys = |names: &[&str]| -> Vec<String> {
        let parameters = names.iter().map(ToString::to_string).collect();
        let request = Request { parameters, ..Request::default() };
        let found = export(&template, model.layout(), model.output_info(), &request).expect("tables");
        found.parameters.into_iter().map(|parameter| parameter.key).collect()
    };
    let each = [keys(&["cylinder"]), keys(&["friction"])];
    assert!(each.iter().all(|keys| keys.len() > 10));
    assert_eq!(keys(&["cylinder", "friction"]), each.concat());
    let exponent = "friction.lift.viscous-exponent";
    assert_eq!(keys(&[exponent, "cylinder"]), [vec![exponent.to_string()], each[0].clone()].concat());
}
