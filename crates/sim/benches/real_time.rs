//! Fixed steps of 1 ms one by one, as a real-time loop would take them: the laboratory crane with a new random command every
//! 50 ms, through the stepping interface with ideal sensors.
//!
//! `cargo bench -p hydrocrane-sim --bench real_time`. The times hold whatever the operating system does in between; the
//! reading of the clock is part of them.

use hydrocrane_machine::load;
use hydrocrane_num::RandomStream;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{build, EquilibriumMode, Model, OutcomeKind, RunOptions, Simulator};
use std::sync::Arc;
use std::time::Instant;

/// s
const STEP: f64 = 1e-3;
const STEPS: usize = 4000;
const MANOEUVRES: u64 = 50;

fn main() {
    let machine = load("rottne-f9-lab", &[]).expect("a bundled machine");
    let model = build(&machine).expect("a machine that can be built");
    let (mut times, mut worst, mut kept) = (Vec::new(), 0.0f64, 0);
    for seed in 0..MANOEUVRES {
        let mut exact = simulator(&model, "rodas5p", 1e-9, 0.05);
        let mut fixed = simulator(&model, "hc-rosenbrock-3", 1e-4, STEP);
        // A random manoeuvre may end at a stop of the stroke; what was timed until then counts.
        let (found, deviation) = compare(model.as_ref(), seed, &mut fixed, &mut exact);
        kept += usize::from(found.len() == STEPS);
        times.extend(found);
        worst = worst.max(deviation);
    }
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize] * 1e6;
    println!(
        "{} steps of {} ms, {kept} of {MANOEUVRES} manoeuvres to the end: median {:.2} us, 99 % {:.2} us, 99.9 % {:.2} us, \
         longest {:.1} us; {:.0} x real time; worst tip error {:.1} um",
        times.len(),
        STEP * 1e3,
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0),
        STEP * times.len() as f64 / times.iter().sum::<f64>(),
        worst * 1e6
    );
}

fn simulator(model: &Arc<dyn Model>, method: &str, tolerance: f64, max_step: f64) -> Simulator {
    let options = RunOptions {
        method: method.to_string(),
        tolerances: Tolerances { relative: tolerance, absolute: tolerance, max_step },
        control: if method == "hc-rosenbrock-3" { StepControl::Even } else { StepControl::Adaptive },
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: false,
        max_steps: 1_000_000,
    };
    let pose = [100f64.to_radians(), 100f64.to_radians(), 0.0];
    let start = model.equilibrium(&pose, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits");
    let mut simulator = Simulator::new(model.clone(), STEP, options);
    simulator.reset(&start).expect("a state to start from");
    simulator
}

/// Time of every step that both could take (s), and the largest distance of the tips (m).
fn compare(model: &dyn Model, seed: u64, fixed: &mut Simulator, exact: &mut Simulator) -> (Vec<f64>, f64) {
    let mut random = RandomStream::new(seed, "manoeuvre");
    let (mut times, mut worst, mut spools) = (Vec::with_capacity(STEPS), 0.0f64, [0.0; 3]);
    for k in 0..STEPS {
        if k % 50 == 0 {
            spools = hydrocrane_num::array::from_fn(|c| (spools[c] + 0.01 * random.symmetric()).clamp(-0.025, 0.025));
        }
        let began = Instant::now();
        let outcome = fixed.step(&spools);
        let time = began.elapsed().as_secs_f64();
        if outcome.kind != OutcomeKind::Completed || exact.step(&spools).kind != OutcomeKind::Completed {
            break;
        }
        times.push(time);
        let tips = [&*fixed, &*exact].map(|s| s.state().map_or([f64::NAN; 2], |x| model.tip_in_plane(x)));
        worst = worst.max((tips[0][0] - tips[1][0]).hypot(tips[0][1] - tips[1][1]));
    }
    (times, worst)
}
