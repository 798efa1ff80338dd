//! Cranes in a batch: each as if it were alone, and as one crane is stepped.

use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_num::RandomStream;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::batch::{Batch, BatchOptions};
use hydrocrane_sim::{build, EquilibriumMode, Model, OutcomeKind, RunOptions, Simulator};
use std::sync::Arc;

const SAMPLES: usize = 30;
const TOLERANCE: f64 = 0.02;

pub fn machine(overrides: &[(String, OverrideValue)]) -> Arc<dyn Model> {
    build(&load("rottne-f9-lab", overrides).expect("a bundled machine")).expect("it can be built")
}

pub fn options(threads: usize) -> BatchOptions {
    BatchOptions { sample_time: 0.01, step: 0.01, tolerance: TOLERANCE, threads, instruction_set: None }
}

/// One crane's task: where it starts, what it carries and its commands, sample by sample.
#[derive(Clone)]
pub struct Task {
    pub start: Vec<f64>,
    pub payload: f64,
    pub commands: Vec<[f64; 3]>,
}

pub fn tasks(model: &dyn Model, count: usize, samples: usize) -> Vec<Task> {
    let mut random = RandomStream::new(5, "tasks");
    let task = |_| {
        let pose = |l: &hydrocrane_sim::JointLimits| {
            0.5 * (l.lower + l.upper) + 0.3 * random.symmetric() * (l.upper - l.lower)
        };
        let q: Vec<f64> = model.joint_limits().iter().map(pose).collect();
        let payload = 20.0 * random.uniform();
        let start = model.equilibrium(&q, EquilibriumMode::Hold, payload).expect("a pose inside the limits");
        let held: Vec<[f64; 3]> =
            (0..=samples / 10).map(|_| std::array::from_fn(|_| 0.02 * random.symmetric())).collect();
        Task { start, payload, commands: (0..samples).map(|i| held[i / 10]).collect() }
    };
    (0..count).map(task).collect()
}

pub fn begun(model: &Arc<dyn Model>, tasks: &[Task], options: &BatchOptions) -> Batch {
    let mut batch = Batch::new(model.clone(), tasks.len(), options).expect("threads");
    for (crane, task) in tasks.iter().enumerate() {
        batch.reset(crane, model.as_ref(), &task.start, task.payload).expect("a state to start from");
    }
    batch
}

fn run(batch: &mut Batch, tasks: &[Task]) -> Vec<Vec<u64>> {
    for sample in 0..tasks[0].commands.len() {
        let commands: Vec<f64> = tasks.iter().flat_map(|task| task.commands[sample]).collect();
        batch.step(&commands);
    }
    (0..tasks.len()).map(|crane| bits(&batch.state(crane))).collect()
}

pub fn bits(x: &[f64]) -> Vec<u64> {
    x.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn a_crane_depends_neither_on_threads_nor_on_the_others_nor_on_its_place() {
    let model = machine(&[]);
    let tasks = tasks(model.as_ref(), 200, SAMPLES);
    let all = run(&mut begun(&model, &tasks, &options(1)), &tasks);
    assert_eq!(run(&mut begun(&model, &tasks, &options(2)), &tasks), all);
    for part in [0..1, 3..10, 9..17, 42..43] {
        assert_eq!(run(&mut begun(&model, &tasks[part.clone()], &options(2)), &tasks[part.clone()]), all[part]);
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let model = machine(&[]);
    let tasks = tasks(model.as_ref(), 8, SAMPLES);
    let in_set = |set: &str| {
        let mut batch = begun(&model, &tasks, &BatchOptions { instruction_set: Some(set.to_string()), ..options(1) });
        (batch.instruction_set(), run(&mut batch, &tasks))
    };
    let widest = run(&mut begun(&model, &tasks, &options(1)), &tasks);
    for set in ["sse2", "avx2", "avx512"] {
        let (found, bits) = in_set(set);
        assert_eq!(bits, widest, "{found}");
    }
}

#[test]
fn a_crane_that_is_lost_stays_where_it_was_and_its_neighbours_do_not_notice() {
    let model = machine(&[]);
    let mut tasks = tasks(model.as_ref(), 16, SAMPLES);
    let undisturbed = run(&mut begun(&model, &tasks, &options(1)), &tasks);
    // The jib is thrown against its end stop, far faster than oil could hold it.
    tasks[3].start[model.layout().qd(1)] = 4e4;
    let mut batch = begun(&model, &tasks, &options(1));
    let disturbed = run(&mut batch, &tasks);
    let status = batch.status(3);
    assert!(status.kind != OutcomeKind::Completed && status.time < 0.3, "{status:?}");
    assert!(batch.state(3).iter().all(|x| x.is_finite()) && model.admissible(&batch.state(3)));
    for crane in (0..16).filter(|crane| *crane != 3) {
        assert_eq!(disturbed[crane], undisturbed[crane], "{crane}");
        assert_eq!(batch.status(crane).kind, OutcomeKind::Completed);
        assert!((batch.status(crane).time - 0.3).abs() < 1e-12);
    }
    // Reset, it works again.
    tasks[3].start[model.layout().qd(1)] = 0.0;
    assert_eq!(run(&mut begun(&model, &tasks, &options(1)), &tasks), undisturbed);
}

/// Largest distance of any tip of the batch from that of a crane stepped alone with tight tolerances, m.
fn worst_tip(model: &Arc<dyn Model>, tasks: &[Task], tolerance: f64) -> f64 {
    let mut batch = begun(model, tasks, &BatchOptions { tolerance, ..options(1) });
    let tight = RunOptions {
        method: "rodas5p".to_string(),
        tolerances: Tolerances { relative: 1e-8, absolute: 1e-8, max_step: 0.01 },
        control: StepControl::Adaptive,
        payload: 0.0,
        payload_changes: Vec::new(),
        supply: None,
        ledger: false,
        max_steps: u64::MAX,
    };
    let mut alone: Vec<Simulator> = tasks
        .iter()
        .map(|task| {
            let mut one = Simulator::new(model.clone(), 0.01, RunOptions { payload: task.payload, ..tight.clone() });
            one.reset(&task.start).expect("a state to start from");
            one
        })
        .collect();
    let mut worst = 0.0f64;
    for sample in 0..tasks[0].commands.len() {
        let commands: Vec<f64> = tasks.iter().flat_map(|task| task.commands[sample]).collect();
        batch.step(&commands);
        let (rows, width) = (batch.observe(), batch.observed());
        for (crane, one) in alone.iter_mut().enumerate() {
            one.step(&tasks[crane].commands[sample]);
            let tip = model.tip_in_plane(&one.state().expect("a state")[..3]);
            let row = &rows[crane * width..][..width];
            worst = worst.max((row[12] - tip[0]).hypot(row[13] - tip[1]));
        }
    }
    worst
}

#[test]
fn tips_follow_those_of_cranes_stepped_one_by_one() {
    let model = machine(&[]);
    let tasks = tasks(model.as_ref(), 12, 60);
    let (coarse, fine) = (worst_tip(&model, &tasks, TOLERANCE), worst_tip(&model, &tasks, 0.05 * TOLERANCE));
    assert!(coarse < 6e-4 && fine < coarse / 5.0, "{coarse} {fine}");
}

/// One crane whose boom is thrown up from its oil, as fast as only short steps can follow, with another that rests.
fn thrown_and_resting(model: &dyn Model) -> [Task; 2] {
    let tasks = tasks(model, 2, SAMPLES);
    let [mut thrown, mut resting]: [Task; 2] = tasks.try_into().unwrap_or_else(|_| unreachable!("two of them"));
    thrown.start[model.layout().qd(0)] = 1.0;
    resting.commands.fill([0.0; 3]);
    [thrown, resting]
}

#[test]
fn torn_oil_is_followed_where_equal_steps_go_wrong() {
    let model = machine(&[]);
    let [thrown, _] = thrown_and_resting(model.as_ref());
    let task = std::slice::from_ref(&thrown);
    let mut batch = begun(&model, task, &options(1));
    batch.step(&thrown.commands[0]);
    let lowest = (0..3).flat_map(|c| [model.layout().p1(c), model.layout().p2(c)]).map(|i| batch.state(0)[i]);
    assert!(lowest.fold(0.0, f64::min) < -0.8e5, "no oil is torn");
    let [fine, usual, equal] = [0.1 * TOLERANCE, TOLERANCE, 1e9].map(|tolerance| worst_tip(&model, task, tolerance));
    assert!(fine < 1e-3 && usual < 3e-3 && equal > 5.0 * usual, "{fine} {usual} {equal}");
}

#[test]
fn a_crane_that_needs_many_steps_takes_them_alone_and_in_company_alike() {
    let model = machine(&[]);
    let [thrown, resting] = thrown_and_resting(model.as_ref());
    let alone = run(&mut begun(&model, std::slice::from_ref(&thrown), &options(1)), std::slice::from_ref(&thrown));
    let rest = run(&mut begun(&model, std::slice::from_ref(&resting), &options(1)), std::slice::from_ref(&resting));
    // Enough for two blocks; the thrown ones are in the midst of resting ones, at other places of their groups.
    let crowd: Vec<Task> = (0..600).map(|i| if i % 11 == 4 { thrown.clone() } else { resting.clone() }).collect();
    for threads in [1, 2] {
        for (i, bits) in run(&mut begun(&model, &crowd, &options(threads)), &crowd).iter().enumerate() {
            assert_eq!(*bits, if i % 11 == 4 { alone[0].clone() } else { rest[0].clone() }, "{i}");
        }
    }
}

#[test]
fn delayed_commands_arrive_when_they_arrive_at_one_crane() {
    let model = machine(&[("valve.lift.delay".to_string(), OverrideValue::Number(0.013))]);
    let tasks = tasks(model.as_ref(), 3, 60);
    assert!(worst_tip(&model, &tasks, 1e-3) < 1e-4);
}

#[test]
fn a_load_taken_up_brakes_the_tip_as_it_does_for_one_crane() {
    let model = machine(&[]);
    let tasks = tasks(model.as_ref(), 2, SAMPLES);
    let mut batch = begun(&model, &tasks, &options(1));
    run(&mut batch, &tasks);
    let before = batch.state(1);
    batch.set_payload(1, tasks[1].payload + 50.0);
    let after = batch.state(1);
    let mut rates = vec![0.0; 3];
    model.attach(&before[..3], &before[3..6], tasks[1].payload, 50.0, &mut rates);
    assert_eq!(after[3..6], rates[..]);
    assert_eq!(before[6..], after[6..]);
    assert_eq!((batch.payload(0), batch.payload(1)), (tasks[0].payload, tasks[1].payload + 50.0));
}

#[test]
fn the_ground_carries_in_lanes_as_it_does_for_one_crane() {
    let free = machine(&[]);
    let tasks = tasks(free.as_ref(), 12, 60);
    let height = |task: &Task| free.tip_in_plane(&task.start[..3])[1];
    // The lowest tip begins in the ground, and some of the others come to it.
    let lowest = tasks.iter().map(height).fold(f64::INFINITY, f64::min);
    let model = machine(&[("ground.height".to_string(), OverrideValue::Number(lowest + 0.02))]);
    let moved = |model: &Arc<dyn Model>| run(&mut begun(model, &tasks, &options(1)), &tasks);
    let (on_the_ground, without) = (moved(&model), moved(&free));
    let touched = (0..tasks.len()).filter(|&crane| on_the_ground[crane] != without[crane]).count();
    assert!((1..tasks.len()).contains(&touched), "{touched} of {}", tasks.len());
    for set in ["sse2", "avx2", "avx512"] {
        let options = BatchOptions { instruction_set: Some(set.to_string()), ..options(1) };
        assert_eq!(run(&mut begun(&model, &tasks, &options), &tasks), on_the_ground, "{set}");
    }
    let (coarse, fine) = (worst_tip(&model, &tasks, TOLERANCE), worst_tip(&model, &tasks, 0.05 * TOLERANCE));
    assert!(coarse < 1e-3 && fine < coarse / 3.0, "{coarse} {fine}");
}
