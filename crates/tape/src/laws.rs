//! The laws of a machine on a tape.

use crate::derivatives::{by_states, Entry};
use crate::error::TapeError;
use crate::recorder::{record, Tape};
use crate::traced::{command, parameter, state, Traced};
use hydrocrane_machine::Machine;
use hydrocrane_num::Field;
use hydrocrane_plant::cylinders::hydraulic_axis::FrictionLaw;
use hydrocrane_plant::cylinders::ledger::NoElasticEnergy;
use hydrocrane_plant::equations::from_machine::plant;
use hydrocrane_plant::equations::outputs;
use hydrocrane_plant::equations::rhs::Evaluator;
use hydrocrane_plant::errors::BuildError;
use hydrocrane_plant::{Layout, Plant};

type Result<T> = std::result::Result<T, TapeError>;

/// Calls a function that is compiled for each number of joints.
macro_rules! by_joints {
    ($count:expr, $function:ident($($argument:expr),*)) => {
        match $count {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            3 => $function::<3>($($argument),*),
            4 => $function::<4>($($argument),*),
            5 => $function::<5>($($argument),*),
            6 => $function::<6>($($argument),*),
            n => Err(BuildError::Chain(n).into()),
        }
    };
}
pub(crate) use by_joints;

/// A traced machine.
#[derive(Debug)]
pub struct Recorded {
    pub tape: Tape,
    pub rates: Vec<Traced>,
    pub outputs: Vec<Traced>,
    pub jacobian: Vec<Entry>,
    /// All numbers of the laws, and what the laws have besides, as text.
    pub numbers: Vec<Traced>,
    pub structure: String,
}

/// Records the laws of the machine that `read` gives. The `payload` is a parameter, by its index and value (kg), or the machine's.
/// `counts`: of the outputs, and of the powers of the ledger behind them; none where these are not wanted.
pub(crate) fn recorded(
    read: impl FnOnce() -> Result<Machine<Traced>>,
    payload: Option<(usize, f64)>,
    layout: &Layout,
    counts: [usize; 2],
    derivatives: bool,
) -> Result<Recorded> {
    let (found, tape) = record(|| {
        let machine = read()?;
        let payload = payload.map_or(machine.payload.mass, |(index, mass)| parameter(index, mass));
        by_joints!(machine.joints.len(), chain(&machine, layout, payload, counts, derivatives))
    });
    Ok(Recorded { tape, ..found? })
}

fn chain<const N: usize>(
    machine: &Machine<Traced>,
    layout: &Layout,
    payload: Traced,
    counts: [usize; 2],
    derivatives: bool,
) -> Result<Recorded> {
    let plant = plant::<Traced, N>(machine)?;
    refuse_jumps(machine, &plant)?;
    let evaluator = Evaluator::<Traced, Traced, N>::new(&plant, layout);
    let x: Vec<Traced> = (0..layout.len()).map(state).collect();
    let u: Vec<Traced> = (0..N).map(command).collect();
    let mut rates = vec![Traced::c(0.0); x.len()];
    evaluator.derivative(layout, &x, &u, payload, &mut rates);
    let jacobian = if derivatives { by_states(&rates) } else { Vec::new() };
    let [outputs, powers] = counts;
    let mut found = vec![Traced::c(0.0); outputs + powers];
    outputs::write(&plant, None::<fn(Traced) -> Traced>, &evaluator.evaluated(layout, &x, payload), &mut found);
    if powers > 0 {
        evaluator.powers(layout, &NoElasticEnergy, &x, payload, &mut found[outputs..]);
    }
    Ok(Recorded {
        tape: Tape::default(),
        rates,
        outputs: found,
        jacobian,
        numbers: plant.numbers(),
        structure: plant.structure(),
    })
}

fn refuse_jumps<const N: usize>(machine: &Machine<Traced>, plant: &Plant<Traced, N>) -> Result<()> {
    for (cylinder, law) in machine.cylinders.iter().zip(&plant.cylinders) {
        if matches!(law.friction, FrictionLaw::Printed { width: None, .. }) {
            return Err(TapeError::Request(format!(
                "the friction of `{}` jumps at rest, as printed in the thesis, and has no derivative there; give it a width, \
                 `friction.{}.smoothing-velocity = \"1 mm/s\"`, or set `errata.friction-map` to \"corrected\"",
                cylinder.name, cylinder.name
            )));
        }
    }
    Ok(())
}
