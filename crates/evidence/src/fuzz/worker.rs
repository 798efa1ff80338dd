//! The process that tries inputs: it says which one it is at, so that whoever reads knows what killed it.
//!
//! A line per event: `begin N`, then `refused N MS`, `ran N MS` or `fault N CLASS TEXT`. N is the number of the input.

use super::exercise::{exercise, Reply};
use super::{input, Kind};
use crate::clock::process_time;
use std::io::Write;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Processor time of one input, s, and of one that hangs to try the tool.
pub const PATIENCE: f64 = 5.0;
const TRIAL: f64 = 0.5;
const WATCHED: Duration = Duration::from_millis(50);

/// What the watchman knows: the input under way and the processor time at its beginning.
type Watch = Arc<Mutex<Option<(u64, Duration)>>>;

/// Tries the inputs `from..to` of a kind.
pub fn numbers(kind: Kind, seed: u64, from: u64, to: u64) {
    let (watch, last_words) = (watched(kind), heard());
    for number in from..to {
        one(&watch, &last_words, number, || exercise(kind, &input(kind, seed, number)));
    }
}

/// Tries one text, as number zero.
pub fn text(kind: Kind, text: &str) {
    let (watch, last_words) = (watched(kind), heard());
    one(&watch, &last_words, 0, || exercise(kind, text));
}

fn one(watch: &Watch, last_words: &Mutex<String>, number: u64, act: impl FnOnce() -> Result<Reply, String>) {
    say(&format!("begin {number}"));
    let began = process_time();
    set(watch, Some((number, began)));
    let done = catch_unwind(AssertUnwindSafe(act));
    set(watch, None);
    let spent = 1e3 * (process_time() - began).as_secs_f64();
    match done {
        Ok(Ok(Reply::Refused)) => say(&format!("refused {number} {spent:.3}")),
        Ok(Ok(Reply::Ran)) => say(&format!("ran {number} {spent:.3}")),
        Ok(Err(text)) => say(&format!("fault {number} wrong {}", on_one_line(&text))),
        Err(_) => {
            let words = last_words.lock().map(|words| words.clone()).unwrap_or_default();
            say(&format!("fault {number} panic {}", on_one_line(&words)));
        }
    }
}

fn set(watch: &Watch, state: Option<(u64, Duration)>) {
    if let Ok(mut held) = watch.lock() {
        *held = state;
    }
}

/// Ends the process when an input has had its time.
fn watched(kind: Kind) -> Watch {
    let patience = if kind == Kind::Trial { TRIAL } else { PATIENCE };
    let watch: Watch = Arc::default();
    let seen = watch.clone();
    std::thread::spawn(move || loop {
        std::thread::sleep(WATCHED);
        let state = seen.lock().map_or(None, |held| *held);
        if let Some((number, began)) = state {
            if (process_time() - began).as_secs_f64() > patience {
                say(&format!("fault {number} hang not done after {patience} s of processor time"));
                std::process::exit(3);
            }
        }
    });
    watch
}

/// The last panic's message and place.
fn heard() -> Arc<Mutex<String>> {
    let words: Arc<Mutex<String>> = Arc::default();
    let kept = words.clone();
    std::panic::set_hook(Box::new(move |info| {
        if let Ok(mut text) = kept.lock() {
            *text = info.to_string();
        }
    }));
    words
}

fn on_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(600).collect()
}

fn say(line: &str) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{line}");
    let _ = out.flush();
}
