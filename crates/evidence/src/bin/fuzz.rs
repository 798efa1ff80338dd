//! Feeds damaged files and links to the core; one line of JSON per kind of input.

use hydrocrane_evidence::arguments::Arguments;
use hydrocrane_evidence::fuzz::parent::{fuzz, Options, Report};
use hydrocrane_evidence::fuzz::{input, worker, Kind};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

const OPTIONS: [&str; 11] =
    ["kinds", "inputs", "seed", "threads", "failures", "output", "worker", "from", "to", "file", "show"];

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("fuzz: {message}");
            ExitCode::from(2)
        }
    }
}

/// Whether no input failed.
fn run() -> Result<bool, String> {
    let given = Arguments::read(std::env::args().skip(1), &OPTIONS)?;
    let seed = given.number("seed", 0)?;
    if let Some(name) = given.text("worker") {
        work(&given, kind(name)?, seed)?;
        return Ok(true);
    }
    let kinds = given.list("kinds", &Kind::ALL.map(Kind::name));
    let kinds = kinds.iter().map(|name| kind(name)).collect::<Result<Vec<Kind>, String>>()?;
    if let Some(number) = given.text("show") {
        let number = number.parse().map_err(|_| format!("--show {number}: give a number"))?;
        kinds.iter().for_each(|kind| println!("{}", input(*kind, seed, number)));
        return Ok(true);
    }
    let inputs: u64 = given.number("inputs", 100_000)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut reports = Vec::new();
    for (i, kind) in kinds.iter().enumerate() {
        // What the division leaves goes to the first.
        let share = inputs / kinds.len() as u64 + u64::from(i == 0) * (inputs % kinds.len() as u64);
        let options = Options {
            program: std::env::current_exe().map_err(|error| error.to_string())?,
            kind: *kind,
            seed,
            inputs: share,
            threads: given.number("threads", cores)?,
            failures: given.text("failures").map(PathBuf::from),
        };
        let report = fuzz(&options);
        show(&report);
        reports.push(report);
    }
    if let Some(path) = given.text("output") {
        let lines: Vec<String> = reports.iter().map(|report| json!(report).to_string()).collect();
        std::fs::write(path, lines.join("\n") + "\n").map_err(|error| format!("{path}: {error}"))?;
    }
    Ok(reports.iter().all(|report| report.failures.is_empty()))
}

fn kind(name: &str) -> Result<Kind, String> {
    Kind::named(name).ok_or_else(|| format!("no kind `{name}`; there are {}", Kind::ALL.map(Kind::name).join(", ")))
}

fn work(given: &Arguments, kind: Kind, seed: u64) -> Result<(), String> {
    if let Some(path) = given.text("file") {
        let bytes = std::fs::read(path).map_err(|error| format!("{path}: {error}"))?;
        worker::text(kind, &String::from_utf8_lossy(&bytes));
        return Ok(());
    }
    worker::numbers(kind, seed, given.number("from", 0)?, given.number("to", 0)?);
    Ok(())
}

fn show(report: &Report) {
    let Report { kind, inputs, refused, ran, slowest, slowest_number, .. } = report;
    println!(
        "{kind}: {inputs} inputs, {refused} refused, {ran} ran, slowest {slowest:.0} ms (number {slowest_number})"
    );
    for group in &report.failures {
        let file = group.file.as_deref().unwrap_or("not kept");
        println!("  {} x {}: {} (number {}, {file})", group.count, group.class, group.text, group.number);
    }
}
