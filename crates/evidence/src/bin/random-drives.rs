//! Drives every bundled machine with random sticks and judges the drives; one line of JSON per case.

use hydrocrane_evidence::arguments::Arguments;
use hydrocrane_evidence::case::{machines, modes, Case};
use hydrocrane_evidence::drives::{campaign, Figures, Options};
use hydrocrane_evidence::lowering::lowering;
use serde_json::json;
use std::fs::File;
use std::io::Write;
use std::process::ExitCode;
use std::sync::Mutex;

const OPTIONS: [&str; 15] = [
    "machines", "modes", "payloads", "drives", "seconds", "followed", "seed", "threads", "script", "core", "against",
    "output", "lowering", "keep", "ground",
];

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("random-drives: {message}");
            ExitCode::from(2)
        }
    }
}

/// Whether all drives are as they must be.
fn run() -> Result<bool, String> {
    let given = Arguments::read(std::env::args().skip(1), &OPTIONS)?;
    let cases = cases(&given)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let options = Options {
        drives: given.number("drives", 100)?,
        seconds: given.number("seconds", 60.0)?,
        followed: given.number("followed", 5.0)?,
        seed: given.number("seed", 0)?,
        threads: given.number("threads", cores)?,
        keep: given.text("keep").map(str::to_string),
        page: match (given.text("script"), given.text("core")) {
            (Some(script), Some(core)) => Some([script.to_string(), core.to_string()]),
            (None, None) => None,
            _ => return Err("--script and --core go together".into()),
        },
    };
    let others = given.text("against").map_or(Ok(Vec::new()), read)?;
    // Case by case as they end, so that a campaign that is broken off leaves what it has; in order at the end.
    let so_far = given.text("output").map(|path| File::create(path).map_err(|error| format!("{path}: {error}")));
    let so_far = so_far.transpose()?.map(Mutex::new);
    let tell = |figures: &Figures| {
        eprintln!("{}", line(figures));
        if let Some(Ok(mut file)) = so_far.as_ref().map(Mutex::lock) {
            let _ = writeln!(file, "{}", json!(figures));
        }
    };
    let mut all = campaign(&cases, &options, &tell)?;
    all.iter_mut().for_each(|figures| figures.compare(&others));
    write(&given, &all)?;
    let faults: Vec<String> =
        all.iter().flat_map(|f| f.faults().into_iter().map(|fault| format!("{}: {fault}", name(f)))).collect();
    faults.iter().for_each(|fault| println!("{fault}"));
    println!("{} cases, {} faults", all.len(), faults.len());
    Ok(faults.is_empty())
}

fn cases(given: &Arguments) -> Result<Vec<Case>, String> {
    let payloads: Result<Vec<f64>, String> = given
        .list("payloads", &["0", "80", "300"])
        .iter()
        .map(|text| text.parse().map_err(|_| format!("--payloads: `{text}` is no number of kg")))
        .collect();
    let payloads = payloads?;
    let ground = match given.text("ground") {
        Some("yes") => true,
        Some("no") | None => false,
        Some(other) => return Err(format!("--ground {other}: give yes or no")),
    };
    let mut cases = Vec::new();
    for machine in given.list("machines", &machines()) {
        for mode in given.list("modes", &modes()) {
            for payload in &payloads {
                cases.push(Case { machine: machine.clone(), mode: mode.clone(), payload: *payload, ground });
            }
        }
    }
    Ok(cases)
}

fn read(path: &str) -> Result<Vec<Figures>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    let lines = text.lines().filter(|line| line.contains("\"machine\""));
    lines.map(|line| serde_json::from_str(line).map_err(|error| format!("{path}: {error}"))).collect()
}

fn write(given: &Arguments, all: &[Figures]) -> Result<(), String> {
    let Some(path) = given.text("output") else { return Ok(()) };
    let mut lines: Vec<String> = all.iter().map(|f| json!(f).to_string()).collect();
    if given.text("lowering").is_some() {
        let done = lowering()?;
        lines.push(
            json!({ "lowering": {
                "tip": 1e3 * done.difference, "outcome": done.outcome, "residual": done.gap.residual,
                "share": done.gap.share, "peaks": done.peaks.map(|p| p / 1e5),
            } })
            .to_string(),
        );
    }
    std::fs::write(path, lines.join("\n") + "\n").map_err(|error| format!("{path}: {error}"))
}

fn name(f: &Figures) -> String {
    format!("{} {} {} kg", f.machine, f.mode, f.payload)
}

fn line(f: &Figures) -> String {
    if let Some(why) = &f.refused {
        return format!("{:40} refused: {why}", name(f));
    }
    let mean = 1e6 * f.steps.total / f.steps.count.max(1) as f64;
    format!(
        "{:40} {} drives, ended {:?}, {:.0} bar ({:.2} of the bound, {:.2} at rest), ledger {:.3} %, tip {:.3} mm, \
         step {mean:.1} us, worst {:.0} us",
        name(f),
        f.drives,
        f.ended,
        f.pressures.peak,
        f.pressures.bound_share,
        f.pressures.rest_share,
        100.0 * f.ledger_share,
        f.agreement.tip,
        1e6 * f.steps.worst,
    )
}
