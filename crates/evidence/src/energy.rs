//! How well the energy ledger of a drive closes.

use hydrocrane_sim::{total_terms, Model};

/// Energies below this are no basis for a share, J.
const LEAST_FLOW: f64 = 100.0;

/// What the ledger lacks.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gap {
    /// J
    pub residual: f64,
    /// Share of the energy that flowed.
    pub share: f64,
}

/// The largest gap in a drive's `rows` of `signals`. What flowed is half the sum of all terms and of the change of what
/// is stored, each by its magnitude: what came in where everything closes.
pub fn worst_gap(model: &dyn Model, signals: &[String], rows: &[Vec<f64>]) -> Gap {
    let at = |name: &str| signals.iter().position(|signal| signal == name);
    let states = model.layout().len();
    let (Some(first), Some(payload)) = (at(&model.layout().names[0]), at("payload")) else { return Gap::default() };
    let stored_in: Vec<usize> =
        model.output_info().iter().enumerate().filter(|(_, o)| o.name.starts_with("energy.")).map(|(i, _)| i).collect();
    let terms: Vec<(usize, f64)> = total_terms(model.machine())
        .filter(|(_, _, sign)| *sign != 0.0)
        .filter_map(|(name, _, sign)| Some((at(&format!("ledger.{name}"))?, *sign)))
        .collect();
    let mut outputs = vec![0.0; model.output_info().len()];
    let mut stored = |row: &[f64]| {
        model.outputs(&row[first..first + states], row[payload], &mut outputs);
        stored_in.iter().map(|&i| outputs[i]).sum::<f64>()
    };
    let Some(start) = rows.first().map(|row| stored(row)) else { return Gap::default() };
    let mut worst = Gap::default();
    for row in rows {
        let gain = stored(row) - start;
        let came: f64 = terms.iter().map(|&(i, sign)| sign * row[i]).sum();
        let flowed = 0.5 * (gain.abs() + terms.iter().map(|&(i, _)| row[i].abs()).sum::<f64>());
        let gap = Gap { residual: gain - came, share: (gain - came).abs() / flowed.max(LEAST_FLOW) };
        // A gap that is no number is the worst.
        if gap.share.is_nan() || gap.share > worst.share {
            worst = gap;
        }
        if worst.share.is_nan() {
            break;
        }
    }
    worst
}
