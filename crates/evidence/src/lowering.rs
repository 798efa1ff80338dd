//! One concrete case: the loader crane lowers 300 kg at full spool and stops at once, by fixed steps and by an adaptive
//! method. A chamber cavitates.

use crate::energy::{worst_gap, Gap};
use hydrocrane_machine::load;
use hydrocrane_machine::scenario::FIXED_STEPS;
use hydrocrane_ode::{StepControl, Tolerances};
use hydrocrane_sim::{build, ledger_totals, simulate, total_terms, Commands, EquilibriumMode, Model, RunOptions};

const MACHINE: &str = "hiab-xs031";
const PAYLOAD: f64 = 300.0;
/// rad, rad, m
const POSE: [f64; 3] = [0.939, -1.279, 0.55];
/// The spool is fully open until here, and shut until there, s.
const LOWERED: f64 = 1.0;
const DURATION: f64 = 2.0;

/// What the two runs end with.
pub struct Lowering {
    /// Distance of the tips, m.
    pub difference: f64,
    /// Of the fixed steps.
    pub gap: Gap,
    pub outcome: &'static str,
    /// Highest pressures of the fixed steps and of the adaptive method, Pa.
    pub peaks: [f64; 2],
}

struct End {
    tip: [f64; 2],
    gap: Gap,
    outcome: &'static str,
    peak: f64,
}

pub fn lowering() -> Result<Lowering, String> {
    let machine = load(MACHINE, &[]).map_err(|error| error.to_string())?;
    let model = build(&machine).map_err(|error| error.to_string())?;
    let even = Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 1e-3 };
    let fixed = lowered(model.as_ref(), FIXED_STEPS, even, StepControl::Even)?;
    let tight = Tolerances { relative: 1e-6, absolute: 1e-6, max_step: 0.05 };
    let adaptive = lowered(model.as_ref(), "rodas5p", tight, StepControl::Adaptive)?;
    let difference = (fixed.tip[0] - adaptive.tip[0]).hypot(fixed.tip[1] - adaptive.tip[1]);
    Ok(Lowering { difference, gap: fixed.gap, outcome: fixed.outcome, peaks: [fixed.peak, adaptive.peak] })
}

fn lowered(model: &dyn Model, method: &str, tolerances: Tolerances, control: StepControl) -> Result<End, String> {
    let x0 = model.equilibrium(&POSE, EquilibriumMode::Hold, PAYLOAD).map_err(|error| error.to_string())?;
    let n = model.layout().joints();
    let mut spools = vec![0.0; 2 * n];
    spools[0] = -model.spool_strokes()[0];
    let commands = Commands { times: vec![0.0, LOWERED], values: spools, linear: false };
    let record: Vec<f64> = (0..=2000).map(|i| DURATION * f64::from(i) / 2000.0).collect();
    let options = RunOptions {
        method: method.into(),
        tolerances,
        control,
        payload: PAYLOAD,
        payload_changes: Vec::new(),
        supply: None,
        ledger: true,
        max_steps: 1_000_000,
    };
    let run = simulate(model, &x0, DURATION, &commands, &record, &options, &mut |_| true);
    let (states, energies) = (model.layout().len(), run.ledger.len() / run.times.len());
    let rows: Vec<(&[f64], &[f64])> = run.states.chunks_exact(states).zip(run.ledger.chunks_exact(energies)).collect();
    let chambers: Vec<usize> = (0..states).filter(|&i| crate::course::is_chamber(&model.layout().names[i])).collect();
    let peak = rows.iter().flat_map(|(x, _)| chambers.iter().map(|&i| x[i])).fold(f64::NEG_INFINITY, f64::max);
    let Some((last, _)) = rows.last() else { return Err(run.outcome.message) };
    Ok(End { tip: model.tip_in_plane(&last[..n]), gap: gap(model, &rows), outcome: run.outcome.kind.name(), peak })
}

/// The run's states and energies as rows of a drive.
fn gap(model: &dyn Model, rows: &[(&[f64], &[f64])]) -> Gap {
    let names = total_terms(model.machine()).map(|(name, _, _)| format!("ledger.{name}"));
    let signals: Vec<String> =
        std::iter::once("payload".to_string()).chain(model.layout().names.iter().cloned()).chain(names).collect();
    let row = |(x, energies): &(&[f64], &[f64])| {
        let mut all = vec![PAYLOAD];
        all.extend_from_slice(x);
        all.extend(ledger_totals(energies, model.layout().joints()));
        all
    };
    worst_gap(model, &signals, &rows.iter().map(row).collect::<Vec<_>>())
}
