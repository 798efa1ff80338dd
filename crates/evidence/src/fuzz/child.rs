//! Runs a worker process and hears what it says of its inputs.

use serde::Serialize;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

/// Address space of a worker, KiB.
pub const MEMORY: u64 = 1 << 20;

/// An input that failed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    pub number: u64,
    /// panic, hang, memory, crash, or wrong.
    pub class: String,
    pub text: String,
}

/// What a worker said.
#[derive(Default)]
pub(super) struct Said {
    pub(super) ended: Vec<(String, u64, f64)>,
    pub(super) failures: Vec<Failure>,
    pub(super) begun: Option<u64>,
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
