//! The two cores that can be driven: the native one, and the compiled one of the page in Node.js.

use crate::clock::thread_time;
use crate::course::{Course, Ended, Plan};
use hydrocrane_web::Cockpit;
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Whoever drives plans. An error is one of the tool, not of the drive.
pub trait Core {
    fn drive(&mut self, plan: &Plan) -> Result<Course, String>;
}

/// The cockpit's own code, compiled for this machine.
pub struct Native;

impl Core for Native {
    fn drive(&mut self, plan: &Plan) -> Result<Course, String> {
        let mut cockpit = Cockpit::default();
        let description = match cockpit.open(&plan.request.to_string()) {
            Ok(description) => description,
            Err(problem) => return Ok(Course { refused: Some(problem.message().into()), ..Course::default() }),
        };
        let mut course = Course { signals: signals(&description), ..Course::default() };
        course.see(0, cockpit.frame(), false, plan.followed);
        let last: u32 = plan.moves.iter().map(|m| m.ticks).sum();
        let mut tick = 0;
        for m in &plan.moves {
            cockpit.set_sticks(&m.deflections);
            for _ in 0..m.ticks {
                let began = thread_time();
                let goes_on = cockpit.advance(1);
                course.steps.take((thread_time() - began).as_secs_f64());
                tick += 1;
                course.see(tick, cockpit.frame(), tick == last || !goes_on, plan.followed);
                // A drive is written down until its last sample.
                if tick == plan.followed + 1 || (!goes_on && tick <= plan.followed) {
                    course.saved = cockpit.save().ok();
                }
                if !goes_on {
                    course.ended = ended(&cockpit.events());
                    return Ok(course);
                }
            }
        }
        Ok(course)
    }
}

fn signals(description: &Value) -> Vec<String> {
    let all = description["signals"].as_array().map(Vec::as_slice).unwrap_or_default();
    all.iter().map(|signal| signal["name"].as_str().unwrap_or_default().to_string()).collect()
}

fn ended(events: &Value) -> Option<Ended> {
    serde_json::from_value(events["ended"].clone()).ok()
}

/// The compiled core in a process of its own: a plan per line in, a course per line out.
pub struct Page {
    child: Child,
    plans: ChildStdin,
    courses: BufReader<ChildStdout>,
}

impl Page {
    /// `script` is `cockpit/tests/random_drives.mjs`, `core` the compiled core.
    pub fn start(script: &str, core: &str) -> Result<Self, String> {
        let spawned = Command::new("node")
            .args(["--max-old-space-size=1024", script, core])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let mut child = spawned.map_err(|error| format!("Node.js cannot be started: {error}"))?;
        let (Some(plans), Some(courses)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("Node.js has no input and output".into());
        };
        Ok(Page { child, plans, courses: BufReader::new(courses) })
    }
}

impl Core for Page {
    fn drive(&mut self, plan: &Plan) -> Result<Course, String> {
        let line = serde_json::to_string(plan).map_err(|error| error.to_string())?;
        writeln!(self.plans, "{line}").map_err(|error| format!("Node.js has ended: {error}"))?;
        let mut answer = String::new();
        self.courses.read_line(&mut answer).map_err(|error| error.to_string())?;
        serde_json::from_str(&answer).map_err(|error| format!("Node.js answers `{:.200}`: {error}", answer))
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
