//! Hands inputs to worker processes, notes what they say, and goes on behind an input that killed one.

use super::child::{signature, worker, Failure};
use super::{input, minimise, Kind};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::Mutex;

/// Inputs that a worker gets at most.
const BATCH: u64 = 1000;
/// Failures of one kind whose inputs are made small.
const MINIMISED: usize = 40;

/// Which inputs, and how.
#[derive(Debug, Clone)]
pub struct Options {
    pub program: PathBuf,
    pub kind: Kind,
    pub seed: u64,
    pub inputs: u64,
    pub threads: usize,
    /// Where inputs that failed are kept.
    pub failures: Option<PathBuf>,
}

/// Failures that read alike but for their numbers.
#[derive(Debug, Clone, Serialize)]
pub struct Group {
    pub class: String,
    pub text: String,
    pub count: u64,
    /// The first input of the group, and its small form.
    pub number: u64,
    pub file: Option<String>,
    pub bytes: usize,
}

/// What came of the inputs of one kind.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    pub kind: &'static str,
    pub seed: u64,
    pub inputs: u64,
    pub refused: u64,
    pub ran: u64,
    /// Longest processor time of an input, ms, and its number.
    pub slowest: f64,
    pub slowest_number: u64,
    pub failures: Vec<Group>,
}

#[derive(Default)]
struct Tally {
    refused: u64,
    ran: u64,
    slowest: (f64, u64),
    failures: Vec<Failure>,
}

/// Tries all inputs of a kind.
pub fn fuzz(options: &Options) -> Report {
    let (next, tally) = (AtomicU64::new(0), Mutex::new(Tally::default()));
    std::thread::scope(|scope| {
        for _ in 0..options.threads.max(1) {
            scope.spawn(|| loop {
                let from = next.fetch_add(BATCH, Ordering::Relaxed);
                if from >= options.inputs {
                    return;
                }
                batch(options, from, (from + BATCH).min(options.inputs), &tally);
            });
        }
    });
    let tally = tally.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    Report {
        kind: options.kind.name(),
        seed: options.seed,
        inputs: options.inputs,
        refused: tally.refused,
        ran: tally.ran,
        slowest: tally.slowest.0,
        slowest_number: tally.slowest.1,
        failures: grouped(options, tally.failures),
    }
}

/// The inputs `from..to`, with a new worker behind each input that kills one.
fn batch(options: &Options, from: u64, to: u64, tally: &Mutex<Tally>) {
    let mut at = from;
    while at < to {
        let range = [at.to_string(), to.to_string()];
        let (seed, kind) = (options.seed.to_string(), options.kind.name());
        let said =
            worker(&options.program, &["--worker", kind, "--seed", &seed, "--from", &range[0], "--to", &range[1]]);
        let mut tally = tally.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        said.ended.iter().for_each(|(class, number, spent)| {
            *(if class == "ran" { &mut tally.ran } else { &mut tally.refused }) += 1;
            if *spent > tally.slowest.0 {
                tally.slowest = (*spent, *number);
            }
        });
        let killed = said.killed(at);
        let killer = killed.as_ref().map(|failure| failure.number);
        tally.failures.extend(said.failures.iter().cloned().chain(killed));
        at = match (said.begun, killer) {
            (_, Some(number)) => number + 1,
            (Some(last), None) => last + 1,
            (None, None) => to,
        };
    }
}

fn grouped(options: &Options, mut failures: Vec<Failure>) -> Vec<Group> {
    failures.sort_by_key(|failure| failure.number);
    let mut groups: BTreeMap<String, Vec<Failure>> = BTreeMap::new();
    failures.into_iter().for_each(|failure| groups.entry(signature(&failure)).or_default().push(failure));
    let mut all: Vec<Group> = Vec::new();
    for (which, group) in groups.into_values().enumerate() {
        let first = &group[0];
        let whole = input(options.kind, options.seed, first.number);
        let small = match &options.failures {
            Some(_) if which < MINIMISED => minimise::smaller(&options.program, options.kind, &whole, first),
            _ => whole,
        };
        let file = options.failures.as_deref().and_then(|folder| keep(folder, options.kind, first.number, &small));
        let (class, text) = (first.class.clone(), first.text.clone());
        all.push(Group { class, text, count: group.len() as u64, number: first.number, file, bytes: small.len() });
    }
    all
}

fn keep(folder: &Path, kind: Kind, number: u64, text: &str) -> Option<String> {
    let path = folder.join(format!("{}-{number}.{}", kind.name(), kind.suffix()));
    std::fs::create_dir_all(folder).ok()?;
    std::fs::write(&path, text).ok()?;
    Some(path.display().to_string())
}
