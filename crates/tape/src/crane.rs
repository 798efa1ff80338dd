//! A machine as a tape.

use crate::derivatives::{by_states, Entry};
use crate::error::TapeError;
use crate::parameters::{self, Chosen};
use crate::program::{program, Program};
use crate::recorder::{command, parameter, record, state, Tape};
use crate::traced::Traced;
use hydrocrane_machine::by_keys::Parameter;
use hydrocrane_machine::{suggestion, Machine, Template};
use hydrocrane_num::Field;
use hydrocrane_plant::errors::BuildError;
use hydrocrane_plant::from_machine::plant;
use hydrocrane_plant::hydraulic_axis::FrictionLaw;
use hydrocrane_plant::outputs::{self, OutputInfo, OIL_ENERGY};
use hydrocrane_plant::rhs::Evaluator;
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

/// What of a machine is to be exported.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// Keys of numbers of the machine file that are inputs, and tables, all of whose numbers are that can be.
    pub parameters: Vec<String>,
    /// Names of outputs.
    pub outputs: Vec<String>,
    /// Whether the derivatives by the states are wanted.
    pub derivatives: bool,
}

/// A machine as functions of states, spool commands and parameters: the state derivative, the same with its derivatives by the
/// states, and outputs.
#[derive(Debug, Clone)]
pub struct Exported {
    pub parameters: Vec<Parameter>,
    pub outputs: Vec<OutputInfo>,
    /// Row and column of each derivative that is not zero everywhere, row by row.
    pub places: Vec<[usize; 2]>,
    /// Functions: state derivative; state derivative, then the derivatives of `places`; outputs.
    pub program: Program,
}

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

/// Traces the machine of `template`. `layout` and `outputs` are those of its model.
///
/// # Errors
/// Keys that can be no parameters, outputs that are none, and friction that jumps.
pub fn export(template: &Template, layout: &Layout, outputs: &[OutputInfo], request: &Request) -> Result<Exported> {
    let places = chosen_outputs(outputs, &request.outputs)?;
    let chosen = parameters::chosen(template, layout, outputs.len(), request)?;
    let recorded = record_machine(&chosen, layout, outputs.len(), request.derivatives)?;
    let found: Vec<Traced> = places.iter().map(|place| recorded.outputs[*place]).collect();
    let entries = recorded.jacobian.iter();
    let linearised = recorded.rates.iter().copied().chain(entries.clone().map(|entry| entry.value)).collect();
    Ok(Exported {
        program: program(&recorded.tape, &[recorded.rates.clone(), linearised, found]),
        parameters: chosen.parameters(),
        outputs: places.iter().map(|place| outputs[*place].clone()).collect(),
        places: entries.map(|entry| [entry.row, entry.column]).collect(),
    })
}

/// The columns of the outputs of these names.
fn chosen_outputs(all: &[OutputInfo], names: &[String]) -> Result<Vec<usize>> {
    let place = |name: &String| {
        let found = all.iter().position(|output| output.name == *name);
        match found {
            Some(_) if name == OIL_ENERGY => Err(TapeError::Request(format!(
                "the output `{OIL_ENERGY}` comes from a table of thousands of rows, which no export holds; leave it out"
            ))),
            Some(place) => Ok(place),
            None => {
                let near = suggestion(name, all.iter().map(|output| output.name.as_str()));
                Err(TapeError::Request(format!("the machine has no output `{name}`; {near}")))
            }
        }
    };
    names.iter().map(place).collect()
}

/// Records the laws of a machine with the chosen parameters as inputs.
pub(crate) fn record_machine(chosen: &Chosen, layout: &Layout, outputs: usize, derivatives: bool) -> Result<Recorded> {
    let (found, tape) = record(|| {
        let machine = chosen.machine::<Traced>(&chosen.values())?;
        let payload = match chosen.payload {
            Some(mass) => parameter(chosen.count() - 1, mass),
            None => machine.payload.mass,
        };
        by_joints!(machine.joints.len(), chain(&machine, layout, payload, outputs, derivatives))
    });
    Ok(Recorded { tape, ..found? })
}

fn chain<const N: usize>(
    machine: &Machine<Traced>,
    layout: &Layout,
    payload: Traced,
    outputs: usize,
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
    let mut found = vec![Traced::c(0.0); outputs];
    outputs::write(&plant, None::<fn(Traced) -> Traced>, &evaluator.evaluated(layout, &x, payload), &mut found);
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
