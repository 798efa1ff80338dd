//! Hands inputs to worker processes, notes what they say, and goes on behind an input that killed one.

use super::{input, minimise, Kind};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::Mutex;

/// Address space of a worker, KiB.
pub const MEMORY: u64 = 1 << 20;
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

/// An input that failed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    pub number: u64,
    /// panic, hang, memory, crash, or wrong.
    pub class: String,
    pub text: String,
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

/// What a worker said.
#[derive(Default)]
pub(super) struct Said {
    ended: Vec<(String, u64, f64)>,
    pub(super) failures: Vec<Failure>,
    begun: Option<u64>,
    errors: String,
    well: bool,
}

impl Said {
    /// The input that killed the worker, where one did and nothing was said of it. A worker that never began one died of
    /// the one it was `at`.
    pub(super) fn killed(&self, at: u64) -> Option<Failure> {
        if self.well || self.failures.iter().any(|failure| failure.class == "hang") {
            return None;
        }
        let number = self.begun.unwrap_or(at);
        let memory = self.errors.contains("memory allocation") || self.errors.contains("failed to allocate");
        let class = if memory { "memory" } else { "crash" };
        let text: String = self.errors.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(300).collect();
        Some(Failure { number, class: class.into(), text })
    }
}

/// Runs a worker with bounded memory; every worker ends, for it watches its own time.
pub(super) fn worker(program: &Path, arguments: &[&str]) -> Said {
    let mut command = bounded(program);
    let spawned = command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let Ok(mut child) = spawned else {
        return Said { errors: "the worker cannot be started".into(), ..Said::default() };
    };
    let errors = child.stderr.take();
    let listening = std::thread::spawn(move || {
        let mut text = String::new();
        // A panic that cannot be caught can say much.
        errors.map(|errors| errors.take(100_000).read_to_string(&mut text));
        text
    });
    let mut said = Said::default();
    for line in child.stdout.take().into_iter().flat_map(|out| BufReader::new(out).lines()).map_while(Result::ok) {
        said.hear(&line);
    }
    said.well = child.wait().is_ok_and(|status| status.success());
    said.errors = listening.join().unwrap_or_default();
    said
}

/// The program under a limit of memory, where the system can set one.
fn bounded(program: &Path) -> Command {
    if cfg!(unix) {
        let mut command = Command::new("sh");
        command.args(["-c", &format!("ulimit -v {MEMORY}; ulimit -c 0; exec \"$0\" \"$@\"")]).arg(program);
        command
    } else {
        Command::new(program)
    }
}

impl Said {
    fn hear(&mut self, line: &str) {
        let mut words = line.splitn(4, ' ');
        let (Some(what), Some(number)) = (words.next(), words.next().and_then(|n| n.parse().ok())) else { return };
        match what {
            "begin" => self.begun = Some(number),
            "fault" => {
                let (class, text) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
                self.failures.push(Failure { number, class: class.into(), text: text.into() });
            }
            _ => {
                let spent = words.next().and_then(|ms| ms.parse().ok()).unwrap_or(0.0);
                self.ended.push((what.to_string(), number, spent));
            }
        }
    }
}

/// What two failures share that read alike but for their numbers and names.
pub(super) fn signature(failure: &Failure) -> String {
    let quoted = failure.text.split('`').step_by(2).collect::<Vec<_>>().join("`");
    let plain: String = quoted.chars().filter(|c| !c.is_ascii_digit() && *c != '-').take(120).collect();
    format!("{} {plain}", failure.class)
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
