//! Cranes of a batch with numbers of their own: each as if all of the batch were its machine.

use crate::batch::{begun, bits, machine, options, tasks, Task};
use hydrocrane_machine::OverrideValue;
use hydrocrane_num::RandomStream;
use hydrocrane_sim::batch::{Batch, BatchOptions};
use hydrocrane_sim::Model;
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
