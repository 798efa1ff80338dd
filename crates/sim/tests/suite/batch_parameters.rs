//! Cranes of a batch with numbers of their own: each as if all of the batch were its machine.

use crate::batch::{begun, bits, machine, options, tasks, Task};
use crate::parity::{models, models_with_pumps, random_state, Noise};
use hydrocrane_lanes::{Demand, Group, InLanes, Needed, StepKernel, Trial, WIDTH};
use hydrocrane_machine::OverrideValue;
use hydrocrane_num::RandomStream;
use hydrocrane_plant::precision::Precision;
use hydrocrane_plant::{Crane, Plant};
use hydrocrane_sim::batch::{Batch, BatchOptions};
use hydrocrane_sim::{Model, StateSpace};
use std::sync::Arc;

/// Keys of parts all over the crane and how far their values go, with two delays that divide the samples differently.
const KEYS: [(&str, [f64; 2]); 9] = [
    ("environment.gravity", [9.5, 10.0]),
    ("link.boom.mass", [66.0, 70.0]),
    ("cylinder.lift.bore", [0.098, 0.102]),
    ("valve.jib.stroke", [0.045, 0.055]),
    ("valve.lift.natural-frequency", [900.0, 1100.0]),
    ("valve.lift.delay", [0.0, 0.03]),
    ("friction.jib.bristle-stiffness", [1.7e5, 2e5]),
    ("fluid.density", [980.0, 1020.0]),
    ("supply.pressure", [130e5, 150e5]),
];

fn machines(count: usize) -> Vec<Arc<dyn Model>> {
    let mut random = RandomStream::new(8, "machines");
    let drawn = |(key, [low, high]): &(&str, [f64; 2]), share: f64| {
        ((*key).to_string(), OverrideValue::Number(low + (high - low) * share))
    };
    (0..count).map(|_| machine(&KEYS.each_ref().map(|key| drawn(key, random.uniform())))).collect()
}

/// The states after the tasks of cranes that are these machines.
fn run(machines: &[Arc<dyn Model>], tasks: &[Task], options: &BatchOptions) -> Vec<Vec<u64>> {
    let mut batch = begun(&machine(&[]), tasks, options);
    for (crane, (model, task)) in machines.iter().zip(tasks).enumerate() {
        batch.reset(crane, model.as_ref(), &task.start, task.payload).expect("a state to start from");
    }
    for sample in 0..tasks[0].commands.len() {
        let commands: Vec<f64> = tasks.iter().flat_map(|task| task.commands[sample]).collect();
        batch.step(&commands);
    }
    let (rows, width) = (batch.observe(), batch.observed());
    let seen = |crane: usize| [batch.state(crane), rows[crane * width..][..width].to_vec()].concat();
    (0..tasks.len()).map(|crane| bits(&seen(crane))).collect()
}

#[test]
fn a_crane_depends_on_its_own_numbers_alone() {
    let tasks = tasks(machine(&[]).as_ref(), 21, 20);
    let machines = machines(tasks.len());
    let all = run(&machines, &tasks, &options(1));
    assert_eq!(run(&machines, &tasks, &options(2)), all);
    for part in [3..10, 9..19] {
        assert_eq!(run(&machines[part.clone()], &tasks[part.clone()], &options(1)), all[part]);
    }
    for set in ["sse2", "avx2", "avx512"] {
        let options = BatchOptions { instruction_set: Some(set.to_string()), ..options(1) };
        assert_eq!(run(&machines, &tasks, &options), all, "{set}");
    }
    for (crane, model) in machines.iter().enumerate() {
        let task = std::slice::from_ref(&tasks[crane]);
        let mut alone: Batch = begun(model, task, &options(1));
        tasks[crane].commands.iter().for_each(|commands| alone.step(commands));
        assert_eq!(bits(&[alone.state(0), alone.observe()].concat()), all[crane], "{crane}");
    }
}

#[test]
fn a_load_meets_the_mass_of_its_own_crane() {
    let (usual, heavy) = (machine(&[]), machine(&[("link.boom.mass".to_string(), OverrideValue::Number(75.0))]));
    let tasks = tasks(usual.as_ref(), 9, 10);
    let mut batch = begun(&usual, &tasks, &options(1));
    batch.reset(8, heavy.as_ref(), &tasks[8].start, tasks[8].payload).expect("a state to start from");
    tasks[8].commands.iter().for_each(|commands| batch.step(&commands.repeat(9)));
    let before = batch.state(8);
    batch.set_payload(8, tasks[8].payload + 50.0);
    let mut rates = vec![0.0; 3];
    heavy.attach(&before[..3], &before[3..6], tasks[8].payload, 50.0, &mut rates);
    assert_eq!(batch.state(8)[3..6], rates[..]);
}

#[test]
fn a_machine_with_other_parts_is_refused() {
    let usual = machine(&[]);
    let tasks = tasks(usual.as_ref(), 2, 1);
    let mut batch = begun(&usual, &tasks, &options(1));
    let grounded = machine(&[("ground.height".to_string(), OverrideValue::Number(-3.0))]);
    let fault = batch.reset(1, grounded.as_ref(), &tasks[1].start, 0.0).expect_err("another part");
    assert!(fault.contains("more than numbers"), "{fault}");
    assert!(batch.takes(usual.as_ref()) && !batch.takes(grounded.as_ref()));
}

fn tips(kernel: &mut dyn StepKernel, x: &[Group]) -> [Group; 3] {
    let mut tips = [[0.0; WIDTH]; 3];
    kernel.tips(x, 0, &mut tips);
    tips
}

/// What a kernel makes of a state: the trial's result and end, the tips.
fn made(kernel: &mut dyn StepKernel, trial: &Trial, x: &[Group]) -> Vec<u64> {
    let (mut end, tips) = (x.to_vec(), tips(kernel, x));
    let result = kernel.attempt(trial, &mut end);
    let flags = [result.taken, result.exact, result.inside].map(|flags| flags.map(|flag| f64::from(u8::from(flag))));
    let all = [&end[..], &tips, &flags, &[result.growth]].concat();
    all.iter().flat_map(|group| bits(&group[..kernel.lanes()])).collect()
}

/// A kernel that begins without numbers is that of the machine whose numbers it is given.
fn takes_every_number<const N: usize>(name: &str, model: &dyn Model)
where
    Plant<f64, N>: InLanes,
{
    let crane = Crane::<N>::new(model.machine()).expect("it can be built");
    let (plant, layout) = (crane.plant(), crane.layout());
    let precision = Precision::new(layout, 0.01);
    let demand = Demand { precision, finest: f64::INFINITY, hopeless: f64::INFINITY };
    let numbers = [plant.numbers(), demand.precision.weights.clone()].concat();
    let (all, own): (Vec<usize>, Vec<Group>) = numbers.iter().map(|number| [*number; WIDTH]).enumerate().unzip();
    let mut without = demand.clone();
    without.precision.weights.fill(f64::NAN);
    let mut right = plant.in_lanes(layout, &demand, &[], None);
    let mut given = plant.map(&mut |_| f64::NAN).in_lanes(layout, &without, &all, None);
    let mut of_tip = plant.map(&mut |_| f64::NAN).in_lanes(layout, &without, &all, None);
    of_tip.load_all(&own, 0, Needed::Tip);
    given.load_all(&own, 0, Needed::All);
    let (mut noise, mut taken) = (Noise(3), 0);
    for place in 0..20 {
        let states: [Vec<f64>; WIDTH] = std::array::from_fn(|_| random_state(model, &mut noise));
        let x: Vec<Group> = (0..layout.len()).map(|i| std::array::from_fn(|lane| states[lane][i])).collect();
        let spools = std::array::from_fn(|_| std::array::from_fn(|_| 0.02 * noise.next()));
        let trial = Trial { h: [1e-3; WIDTH], spools, payload: [40.0; WIDTH] };
        let found = made(right.as_mut(), &trial, &x);
        taken += found.iter().all(|bits| f64::from_bits(*bits).is_finite()) as usize;
        (0..given.lanes()).for_each(|lane| given.load(lane, &own, (lane + place) % WIDTH));
        assert_eq!(made(given.as_mut(), &trial, &x), found, "{name}");
        assert_eq!(tips(of_tip.as_mut(), &x), tips(right.as_mut(), &x), "{name}");
    }
    assert!(taken > 0, "{name}: no step has an end");
}

#[test]
fn every_number_that_a_step_reads_can_be_a_cranes_own() {
    for (name, model) in models().chain(models_with_pumps()) {
        match model.layout().joints() {
            1 => takes_every_number::<1>(name, model.as_ref()),
            4 => takes_every_number::<4>(name, model.as_ref()),
            _ => takes_every_number::<3>(name, model.as_ref()),
        }
    }
}
