//! Makes an input that fails smaller: takes out blocks of lines, ever smaller ones, while it fails alike.

use super::child::{signature, worker, Failure};
use super::Kind;
use std::path::Path;
use std::time::{Duration, Instant};

/// Time spent on one input.
const PATIENCE: Duration = Duration::from_secs(20);
/// Longest line that is kept whole, bytes.
const LINE: usize = 2000;

/// The smallest form found of `text`, which fails as `failure` says.
pub fn smaller(program: &Path, kind: Kind, text: &str, failure: &Failure) -> String {
    let wanted = signature(failure);
    let began = Instant::now();
    let fails =
        |candidate: &str| began.elapsed() < PATIENCE && tried(program, kind, candidate).as_ref() == Some(&wanted);
    // A link is one line of JSON.
    if kind == Kind::Link {
        return members(text, &fails);
    }
    let mut lines: Vec<&str> = text.lines().collect();
    let mut block = lines.len().div_ceil(2);
    while block > 0 {
        let mut at = 0;
        while at < lines.len() {
            let rest: Vec<&str> = lines[..at].iter().chain(&lines[(at + block).min(lines.len())..]).copied().collect();
            if fails(&(rest.join("\n") + "\n")) {
                lines = rest;
            } else {
                at += block;
            }
        }
        block /= 2;
    }
    shortened(lines, &fails)
}

/// Long lines cut in half as often as they fail alike.
fn shortened(lines: Vec<&str>, fails: &dyn Fn(&str) -> bool) -> String {
    let mut lines: Vec<String> = lines.into_iter().map(str::to_string).collect();
    for i in 0..lines.len() {
        while lines[i].len() > LINE {
            let half = lines[i].len() / 4..3 * lines[i].len() / 4;
            if !lines[i].is_char_boundary(half.start) || !lines[i].is_char_boundary(half.end) {
                break;
            }
            let mut candidate = lines.clone();
            candidate[i].replace_range(half, "");
            if !fails(&(candidate.join("\n") + "\n")) {
                break;
            }
            lines = candidate;
        }
    }
    lines.join("\n") + "\n"
}

/// A request without the members that it fails without.
fn members(text: &str, fails: &dyn Fn(&str) -> bool) -> String {
    let Ok(serde_json::Value::Object(mut request)) = serde_json::from_str(text) else { return text.to_string() };
    for key in request.keys().cloned().collect::<Vec<_>>() {
        let mut without = request.clone();
        without.shift_remove(&key);
        if fails(&serde_json::Value::Object(without.clone()).to_string()) {
            request = without;
        }
    }
    serde_json::Value::Object(request).to_string()
}

/// The signature of what a text does in a worker, if it fails.
fn tried(program: &Path, kind: Kind, text: &str) -> Option<String> {
    let path =
        std::env::temp_dir().join(format!("hydrocrane-fuzz-{}-{:?}", std::process::id(), std::thread::current().id()));
    std::fs::write(&path, text).ok()?;
    let said = worker(program, &["--worker", kind.name(), "--file", path.to_str()?]);
    let _ = std::fs::remove_file(&path);
    said.killed(0).or_else(|| said.failures.first().cloned()).map(|failure| signature(&failure))
}
