//! What a closed loop costs: the laboratory crane under a controller at 100 Hz and its monitor, ideal sensors, without Python
//! around it.
//!
//! `cargo bench -p hydrocrane-sim --bench closed_loop`. The tip error is the largest distance at any sample from the same
//! loop with `rodas5p` at 1e-11. The shortest of many rounds counts: the load of the computer only ever adds.

use hydrocrane_control::interface::controller::{Controller, Measurement, Stick};
use hydrocrane_machine::load;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{build, simulate_sampled, EquilibriumMode, Model};
use hydrocrane_sim::{RunOptions, SampledPlan, SampledRun, Sensors, StickKind, Sticks};
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 100;
/// s
const END: f64 = 8.0;
const PERIOD: f64 = 0.01;
/// Method, tolerance and largest step (s).
const SOLVERS: [(&str, f64, f64); 6] = [
    ("rodas5p", 1e-3, 0.05),
    ("rodas5p", 1e-4, 0.05),
    ("hc-rosenbrock-3", 1e-4, 0.01),
    ("hc-rosenbrock-3", 1e-4, 0.005),
    ("hc-rosenbrock-3", 1e-4, 0.0025),
    ("hc-rosenbrock-3", 1e-4, 0.001),
];

/// `cargo bench ... -- alone` runs the controllers alone.
fn main() {
    let alone = std::env::args().any(|argument| argument == "alone");
    let machine = load("rottne-f9-lab", &[]).expect("a bundled machine");
    let model = build(&machine).expect("a machine that can be built");
    println!(
        "{:10}{:22}{:>10}{:>10}{:>9}{:>8}{:>8}{:>10}",
        "control", "solver", "time", "x real", "steps", "reject", "rhs", "tip"
    );
    for name in ["tip", "lever"] {
        let closed = Loop::new(model.as_ref(), name);
        let reference = closed.run(&mut *closed.controller(), "rodas5p", 1e-11, 0.05);
        for (method, rtol, step) in SOLVERS.into_iter().filter(|_| !alone) {
            closed.report(method, rtol, step, &reference);
        }
        closed.control_alone(&reference);
    }
}

struct Loop<'a> {
    model: &'a dyn Model,
    name: &'a str,
    start: Vec<f64>,
    plan: SampledPlan,
    record: Vec<f64>,
}

impl<'a> Loop<'a> {
    /// Up along a vertical line and down again, or two cylinders by lever.
    fn new(model: &'a dyn Model, name: &'a str) -> Self {
        let pose = [100f64.to_radians(), 100f64.to_radians(), 0.0];
        let (kind, row): (_, fn(f64) -> Vec<f64>) = match name {
            "tip" => (StickKind::Tip, |up| vec![0.0, 0.1 * up]),
            _ => (StickKind::Lever, |up| vec![0.5 * up, 0.3 * up, -0.2 * up]),
        };
        let axes = row(0.0).len();
        let sticks = Sticks {
            times: vec![0.5, 3.5, 4.0, 7.0],
            deflections: [1.0, 0.0, -1.0, 0.0].into_iter().flat_map(row).collect(),
            ramp: 0.2,
            ..Sticks::centred(kind, axes)
        };
        Loop {
            model,
            name,
            start: model.equilibrium(&pose, EquilibriumMode::Hold, 0.0).expect("a pose inside the limits"),
            plan: SampledPlan { sticks, sensors: Sensors::ideal(model), delay: 0.0 },
            record: (0..=(END / PERIOD).round() as usize).map(|i| PERIOD * i as f64).collect(),
        }
    }

    fn controller(&self) -> Box<dyn Controller> {
        self.model.with_sensor_monitor(self.model.controller(self.name).expect("a controller's name"), 0.0)
    }

    fn run(&self, controller: &mut dyn Controller, method: &str, rtol: f64, step: f64) -> SampledRun {
        let options = RunOptions {
            method: method.to_string(),
            tolerances: Tolerances { relative: rtol, absolute: rtol, max_step: step },
            control: if method == "hc-rosenbrock-3" { StepControl::Even } else { StepControl::Adaptive },
            payload: 0.0,
            payload_changes: Vec::new(),
            supply: None,
            ledger: false,
            max_steps: 1_000_000,
        };
        simulate_sampled(self.model, &self.start, END, controller, &self.plan, &self.record, &options, &mut |_| true)
    }

    fn report(&self, method: &str, rtol: f64, step: f64, reference: &SampledRun) {
        let controller = &mut *self.controller();
        let run = self.run(controller, method, rtol, step).run;
        let seconds = shortest(|| {
            black_box(self.run(controller, method, rtol, step));
        });
        let n = self.start.len();
        let rows = run.states.chunks_exact(n).zip(reference.run.states.chunks_exact(n));
        let deviation = |(a, b): (&[f64], &[f64])| {
            let (a, b) = (self.model.tip_in_plane(a), self.model.tip_in_plane(b));
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let worst = rows.map(deviation).fold(0.0, f64::max);
        let solver = if method == "hc-rosenbrock-3" {
            format!("{method} {} ms", step * 1e3)
        } else {
            format!("{method} {rtol:e}")
        };
        println!(
            "{:10}{solver:22}{:>7.3} ms{:>10.0}{:>9}{:>8}{:>8}{:>7.1} um",
            self.name,
            seconds * 1e3,
            END / seconds,
            run.accepted,
            run.rejected,
            run.effort.derivatives,
            worst * 1e6
        );
    }

    /// The controller fed with what the sensors read, without a crane.
    fn control_alone(&self, reference: &SampledRun) {
        let (samples, axes) = (&reference.samples, self.plan.sticks.axes);
        let width = samples.measured.len() / samples.times.len();
        let pressures: Vec<Vec<[f64; 2]>> = samples
            .measured
            .chunks_exact(width)
            .map(|row| row[3..].chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect())
            .collect();
        let (controller, mut spool) = (&mut *self.controller(), [0.0; 3]);
        let seconds = shortest(|| {
            for (k, &t) in samples.times.iter().enumerate() {
                let measured = Measurement { t, q: &samples.measured[k * width..][..3], p: &pressures[k] };
                let at = &samples.sticks[k * axes..][..axes];
                let stick = if axes == 2 { Stick::Tip(at) } else { Stick::Lever(at) };
                controller.step(&measured, stick, &mut spool).expect("readings of a good run");
                black_box(&spool);
            }
        });
        println!("{:10}alone: {:.0} ns per sample\n", self.name, seconds * 1e9 / samples.times.len() as f64);
    }
}

fn shortest(mut work: impl FnMut()) -> f64 {
    let timed = |_| {
        let began = Instant::now();
        work();
        began.elapsed().as_secs_f64()
    };
    (0..ROUNDS).map(timed).fold(f64::INFINITY, f64::min)
}
