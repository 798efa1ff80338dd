//! What is done with an input: read it, build, find equilibria, run and drive it for an instant.

use super::Kind;
use hydrocrane_machine::{parse, parse_scenario, parse_scenario_with, Machine};
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{build, simulate, Commands, EquilibriumMode, Model, OutcomeKind, RunOptions};
use hydrocrane_web::Cockpit;
use serde_json::{json, Value};

/// How an input that is no fault ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reply {
    /// Refused with a message.
    Refused,
    Ran,
}

/// A message longer than this is none for people.
const LONGEST_MESSAGE: usize = 4000;
const RUN: f64 = 0.05;
const MOST_STEPS: u64 = 2000;
const TICKS: u32 = 40;

/// Words for the tool's own guards.
pub const TRIALS: [&str; 5] = ["good", "panic", "hang", "memory", "not finite"];

/// Tries an input; an error is a fault of the program.
pub fn exercise(kind: Kind, text: &str) -> Result<Reply, String> {
    match kind {
        Kind::Machine => machine(text),
        Kind::Scenario => scenario(text),
        Kind::Link => link(text),
        Kind::Trial => trial(text.trim()),
    }
}

fn refused(message: &str) -> Result<Reply, String> {
    match message.trim().len() {
        0 => Err("an error without a message".into()),
        1..=LONGEST_MESSAGE => Ok(Reply::Refused),
        length => {
            let kind = message.split(['[', ']']).nth(1).filter(|kind| kind.len() < 30).unwrap_or_default();
            let begin = message.chars().take(80).collect::<String>().replace('`', "'");
            Err(format!("a message of {length} bytes [{kind}] `{begin}`"))
        }
    }
}

fn machine(text: &str) -> Result<Reply, String> {
    let machine = match parse(text, "fuzz.toml", &[]) {
        Ok(machine) => machine,
        Err(error) => return refused(&error.to_string()),
    };
    let model = match build(&machine) {
        Ok(model) => model,
        Err(error) => return refused(&error.to_string()),
    };
    run(&machine, model.as_ref())?;
    for controller in ["lever", "tip"] {
        drive(&json!({ "machine": "fuzz.toml", "text": text, "controller": controller }))?;
    }
    Ok(Reply::Ran)
}

/// A short run with full spools, from rest in the middle of the joints' ranges.
fn run(machine: &Machine, model: &dyn Model) -> Result<(), String> {
    let pose: Vec<f64> = model.joint_limits().iter().map(|l| 0.5 * (l.lower + l.upper)).collect();
    let payload = machine.payload.mass;
    for mode in [EquilibriumMode::Hold, EquilibriumMode::Steady] {
        let Ok(x0) = model.equilibrium(&pose, mode, payload) else { continue };
        finite("an equilibrium", &x0)?;
        let commands = Commands { times: vec![0.01], values: model.spool_strokes(), linear: false };
        open_loop(model, &x0, RUN, &commands, payload)?;
    }
    Ok(())
}

fn open_loop(model: &dyn Model, x0: &[f64], end: f64, commands: &Commands, payload: f64) -> Result<(), String> {
    let options = RunOptions {
        method: "rodas5p".into(),
        tolerances: Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 0.05 },
        control: StepControl::Adaptive,
        payload,
        payload_changes: Vec::new(),
        supply: None,
        ledger: true,
        max_steps: MOST_STEPS,
    };
    let run = simulate(model, x0, end, commands, &[0.0, 0.5 * end, end], &options, &mut |_| true);
    if run.outcome.kind != OutcomeKind::Completed {
        return refused(&run.outcome.message).map(drop);
    }
    finite("states of a completed run", &run.states)?;
    finite("energies of a completed run", &run.ledger)?;
    let mut outputs = vec![0.0; model.output_info().len()];
    for x in run.states.chunks_exact(model.layout().len()) {
        model.outputs(x, payload, &mut outputs);
        if let Some(i) = outputs.iter().position(|value| !value.is_finite()) {
            return Err(format!("output {} of a completed run is {}", model.output_info()[i].name, outputs[i]));
        }
    }
    Ok(())
}

fn finite(what: &str, values: &[f64]) -> Result<(), String> {
    values.iter().find(|value| !value.is_finite()).map_or(Ok(()), |value| Err(format!("{what}: {value}")))
}

fn scenario(text: &str) -> Result<Reply, String> {
    if let Err(error) = parse_scenario(text, "fuzz.toml", &[]) {
        return refused(&error.to_string());
    }
    drive(&json!({ "scenario": text }))
}

fn link(text: &str) -> Result<Reply, String> {
    let mut cockpit = Cockpit::default();
    // A drive is under way when a link is opened.
    let good = json!({ "machine": "rottne-f9-lab", "controller": "lever" }).to_string();
    cockpit.open(&good).map_err(|problem| format!("a good request is refused: {}", problem.message()))?;
    cockpit.advance(5);
    opened(&mut cockpit, text)
}

fn drive(request: &Value) -> Result<Reply, String> {
    opened(&mut Cockpit::default(), &request.to_string())
}

/// Opens a request and drives it for an instant with full sticks.
fn opened(cockpit: &mut Cockpit, request: &str) -> Result<Reply, String> {
    let description = match cockpit.open(request) {
        Ok(description) => description,
        Err(problem) => return refused(problem.message()),
    };
    for (level, ticks) in [(1.0, TICKS / 2), (-1.0, TICKS / 2)] {
        cockpit.set_sticks(&[level; 8]);
        if !cockpit.advance(ticks) {
            let message = cockpit.events()["ended"]["message"].as_str().unwrap_or_default().to_string();
            return refused(&message).map(|_| Reply::Ran);
        }
    }
    let names = description["signals"].as_array().map(Vec::as_slice).unwrap_or_default();
    for (name, value) in names.iter().zip(cockpit.frame()) {
        let name = name["name"].as_str().unwrap_or_default();
        // Without a set-point there is no place for it, and the page does not know the oil's energy.
        let may = name.starts_with("set_point.") || name.starts_with("wanted.") || name == "energy.oil";
        if !value.is_finite() && !may {
            return Err(format!("{name} is {value} in a drive that goes on"));
        }
    }
    if let Ok(saved) = cockpit.save() {
        let request = &description["request"];
        let own = request["machine"].as_str().zip(request["text"].as_str());
        let files: Vec<_> = own.iter().map(|(name, text)| (name.to_string(), text.to_string())).collect();
        parse_scenario_with(&saved, "drive.toml", &files)
            .map_err(|error| format!("a saved drive cannot be read: {error:.300}"))?;
    }
    Ok(Reply::Ran)
}

/// Does what the tool must find.
fn trial(word: &str) -> Result<Reply, String> {
    match word {
        "panic" => panic!("asked for"),
        "hang" => loop {
            std::hint::spin_loop();
        },
        "memory" => {
            let much = vec![0u8; 3 << 30];
            Ok(if much.is_empty() { Reply::Refused } else { Reply::Ran })
        }
        "not finite" => finite("a trial", &[f64::NAN]).map(|()| Reply::Ran),
        _ => Ok(Reply::Ran),
    }
}
