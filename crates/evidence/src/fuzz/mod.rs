//! Damaged inputs: every one is refused with a message or runs with finite numbers, in bounded time and memory.
//!
//! Inputs are made by mutation of good files ([`mutate`], [`link`]) from a seed and a number, so that a worker process that
//! dies needs to hand nothing back. That is also why the mutation is this crate's own: cargo-fuzz needs a nightly compiler,
//! and proptest shrinks inside the process that a hang or an abort takes with it.

pub mod child;
pub mod exercise;
pub mod link;
pub mod minimise;
pub mod mutate;
pub mod parent;
pub mod worker;

use hydrocrane_machine::{bundled_machines, bundled_scenarios};
use hydrocrane_num::RandomStream;
use std::path::Path;

/// What an input is meant to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Machine,
    Scenario,
    /// A request of the page, as a link carries it.
    Link,
    /// Words that make the tool's own guards speak: see `exercise::trial`.
    Trial,
}

impl Kind {
    /// Those that are fuzzed.
    pub const ALL: [Kind; 3] = [Kind::Machine, Kind::Scenario, Kind::Link];

    pub fn name(self) -> &'static str {
        match self {
            Kind::Machine => "machine",
            Kind::Scenario => "scenario",
            Kind::Link => "link",
            Kind::Trial => "trial",
        }
    }

    pub fn named(name: &str) -> Option<Kind> {
        [Kind::Machine, Kind::Scenario, Kind::Link, Kind::Trial].into_iter().find(|kind| kind.name() == name)
    }

    pub fn suffix(self) -> &'static str {
        if self == Kind::Link {
            "json"
        } else {
            "toml"
        }
    }
}

/// The input `number` of a kind under `seed`.
pub fn input(kind: Kind, seed: u64, number: u64) -> String {
    let mut random = RandomStream::new(seed, &format!("{} {number}", kind.name()));
    match kind {
        Kind::Machine => mutate::text(&mut random, &machine_files()),
        Kind::Scenario => mutate::text(&mut random, &scenario_files()),
        Kind::Link => link::request(&mut random, &machine_files(), &scenario_files()),
        Kind::Trial => exercise::TRIALS[number as usize % exercise::TRIALS.len()].to_string(),
    }
}

/// A whole number below `below`.
pub(crate) fn pick(random: &mut RandomStream, below: usize) -> usize {
    ((random.uniform() * below as f64) as usize).min(below.saturating_sub(1))
}

pub(crate) fn one_of<'a, T>(random: &mut RandomStream, all: &'a [T]) -> &'a T {
    &all[pick(random, all.len())]
}

/// Good machine files four times, for bad ones that the tests keep are refused with or without further damage.
fn machine_files() -> Vec<String> {
    let bundled = bundled_machines().iter().map(|(_, text)| text.to_string());
    let good: Vec<String> = bundled.chain(kept_files("", "[machine]")).collect();
    [good.clone(), good.clone(), good.clone(), good, kept_files("bad", "[machine]")].concat()
}

fn scenario_files() -> Vec<String> {
    bundled_scenarios().iter().map(|(_, text)| text.to_string()).chain(kept_files("", "[scenario]")).collect()
}

/// Files of `tests/data` that hold `mark`, in order of their names.
fn kept_files(folder: &str, mark: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(folder);
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    let texts = paths.iter().filter_map(|path| std::fs::read_to_string(path).ok());
    texts.filter(|text| text.contains(mark)).collect()
}
