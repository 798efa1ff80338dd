//! What one trajectory costs: laws, Jacobian and whole runs of the bundled open-loop lift, without Python around them.
//!
//! `cargo bench -p hydrocrane-sim`. The shortest of many rounds counts: the load of the computer only ever adds.

use hydrocrane_machine::{load, load_scenario, Scenario};
use hydrocrane_ode::{BlockArrow, StepControl, Tolerances};
use hydrocrane_sim::{build, EquilibriumMode, Model};
use hydrocrane_sim::{simulate, Commands, Run, RunOptions};
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 300;

fn main() {
    let scenario = load_scenario("vertical-lift-open-loop", &[]).expect("a bundled scenario");
    let model = build(&load(&scenario.machine, &[]).expect("its machine")).expect("a machine that can be built");
    let lift = Lift::new(&scenario, model.as_ref());
    let reference = lift.run("rodas5p", 1e-11, false);
    laws(model.as_ref(), &reference);
    println!(
        "\n{:28}{:>10}{:>10}{:>8}{:>8}{:>8}{:>8}{:>10}",
        "run", "time", "x real", "steps", "reject", "rhs", "LU", "tip"
    );
    for (method, rtol, ledger) in [
        ("rodas5p", 1e-3, false),
        ("rodas5p", 2e-4, false),
        ("rodas5p", 1e-4, false),
        ("rodas5p", 1e-4, true),
        ("hc-exponential-4", 1e-3, false),
        ("hc-exponential-4", 3e-4, false),
        ("hc-exponential-4", 2e-4, false),
        ("hc-exponential-4", 1e-4, false),
        ("hc-exponential-4", 1e-4, true),
        ("tsit5", 1e-4, false),
    ] {
        lift.report(method, rtol, ledger, &reference);
    }
}

struct Lift<'a> {
    model: &'a dyn Model,
    start: Vec<f64>,
    commands: Commands,
    record: Vec<f64>,
    end: f64,
}

impl<'a> Lift<'a> {
    fn new(scenario: &Scenario, model: &'a dyn Model) -> Self {
        let machine = model.machine();
        let named = |name: &str| scenario.initial.joints.iter().find(|(joint, _)| joint == name).map_or(0.0, |j| j.1);
        let q: Vec<f64> = machine.joints.iter().map(|joint| named(&joint.name)).collect();
        let start = model.equilibrium(&q, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits");
        let mut times: Vec<f64> = scenario.commands.iter().flat_map(|command| command.time.clone()).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let held = |name: &str, t: f64| {
            let command = scenario.commands.iter().find(|command| command.cylinder == name);
            command.map_or(0.0, |c| c.spool[c.time.partition_point(|&at| at <= t).max(1) - 1])
        };
        let row = |t: f64| machine.cylinders.iter().map(move |c| held(&c.name, t)).collect::<Vec<f64>>();
        let values = times.iter().flat_map(|&t| row(t)).collect();
        let rows = (scenario.duration / scenario.record_interval).round() as usize;
        Lift {
            model,
            start,
            commands: Commands { times, values, linear: false },
            record: (0..=rows).map(|i| scenario.duration * i as f64 / rows as f64).collect(),
            end: scenario.duration,
        }
    }

    fn run(&self, method: &str, rtol: f64, ledger: bool) -> Run {
        let options = RunOptions {
            method: method.to_string(),
            tolerances: Tolerances { relative: rtol, absolute: rtol, max_step: 0.05 },
            control: StepControl::Adaptive,
            payload: 0.0,
            payload_changes: Vec::new(),
            supply: None,
            ledger,
            max_steps: 1_000_000,
        };
        simulate(self.model, &self.start, self.end, &self.commands, &self.record, &options, &mut |_| true)
    }

    fn report(&self, method: &str, rtol: f64, ledger: bool, reference: &Run) {
        let run = self.run(method, rtol, ledger);
        let seconds = shortest(ROUNDS, || {
            black_box(self.run(method, rtol, ledger));
        });
        let n = self.start.len();
        let rows = run.states.chunks_exact(n).zip(reference.states.chunks_exact(n));
        let deviation = |(a, b): (&[f64], &[f64])| {
            let (a, b) = (self.model.tip_in_plane(a), self.model.tip_in_plane(b));
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let worst = rows.map(deviation).fold(0.0, f64::max);
        let name = format!("{method} {rtol:e}{}", if ledger { " ledger" } else { "" });
        println!(
            "{name:28}{:>7.3} ms{:>10.0}{:>8}{:>8}{:>8}{:>8}{:>7.1} um",
            seconds * 1e3,
            self.end / seconds,
            run.accepted,
            run.rejected,
            run.effort.derivatives,
            run.effort.factorisations,
            worst * 1e6
        );
    }
}

/// Right-hand side and Jacobian at the states of a run.
fn laws(model: &dyn Model, run: &Run) {
    let n = model.layout().len();
    let states: Vec<&[f64]> = run.states.chunks_exact(n).collect();
    let u = vec![0.01; model.layout().joints()];
    let (mut dx, mut dense) = (vec![0.0; n], vec![0.0; n * n]);
    let per_state = 1e9 / states.len() as f64;
    let rhs = shortest(ROUNDS, || {
        for x in &states {
            model.derivative(x, &u, 0.0, &mut dx);
            black_box(&dx);
        }
    });
    let mut jacobian = BlockArrow::new(model.layout().blocks());
    let structured = shortest(ROUNDS, || {
        for x in &states {
            model.linearise(x, &u, 0.0, &mut dx, &mut jacobian);
            black_box(&jacobian);
        }
    });
    let whole = shortest(ROUNDS, || {
        for x in &states {
            model.jacobian(x, &u, 0.0, &mut dense);
            black_box(&dense);
        }
    });
    let [rhs, structured, whole] = [rhs, structured, whole].map(|seconds| seconds * per_state);
    println!("right-hand side {rhs:.0} ns, with structured Jacobian {structured:.0} ns, dense Jacobian {whole:.0} ns");
}

fn shortest(rounds: usize, mut work: impl FnMut()) -> f64 {
    let timed = |_| {
        let began = Instant::now();
        work();
        began.elapsed().as_secs_f64()
    };
    (0..rounds).map(timed).fold(f64::INFINITY, f64::min)
}
