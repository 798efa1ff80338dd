//! A machine as a tape.

use crate::error::TapeError;
use crate::parameters;
use crate::program::{program, Program};
use crate::traced::Traced;
use hydrocrane_machine::by_keys::Parameter;
use hydrocrane_machine::{suggestion, Template};
use hydrocrane_plant::cylinders::ledger::{terms, Term};
use hydrocrane_plant::equations::outputs::{OutputInfo, OIL_ENERGY};
use hydrocrane_plant::Layout;

type Result<T> = std::result::Result<T, TapeError>;

/// What of a machine is to be exported.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// Keys of numbers of the machine file that are inputs, and tables, all of whose numbers are that can be.
    pub parameters: Vec<String>,
    /// Names of outputs, and of terms of the energy ledger, as `ledger.lift.friction`, whose powers these are then.
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

/// Traces the machine of `template`. `layout` and `outputs` are those of its model.
///
/// # Errors
/// Keys that can be no parameters, outputs that are none, and friction that jumps.
pub fn export(template: &Template, layout: &Layout, outputs: &[OutputInfo], request: &Request) -> Result<Exported> {
    let asks_for_powers = request.outputs.iter().any(|name| name.starts_with(LEDGER));
    let powers = if asks_for_powers { powers(template)? } else { Vec::new() };
    let counts = [outputs.len(), powers.len()];
    let outputs = [outputs, &powers].concat();
    let places = chosen_outputs(&outputs, &request.outputs)?;
    let chosen = parameters::chosen(template, layout, counts, &request.parameters)?;
    let recorded = chosen.record(layout, counts, request.derivatives)?;
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

/// How the names of the powers of the ledger begin, and how those end for which the elastic energy of the oil is needed.
const LEDGER: &str = "ledger.";
const ELASTIC: [&str; 2] = [".elastic", ".carried"];

/// The powers of the ledger, in their order.
fn powers(template: &Template) -> Result<Vec<OutputInfo>> {
    let machine = template.build(&[])?;
    let of = |(owner, (name, text, _)): (&str, &Term)| OutputInfo {
        name: format!("{LEDGER}{owner}.{name}"),
        unit: "W",
        long_name: format!("{owner}: {text}, as power"),
    };
    Ok(terms(&machine).into_iter().map(of).collect())
}

/// The columns of the outputs of these names.
fn chosen_outputs(all: &[OutputInfo], names: &[String]) -> Result<Vec<usize>> {
    let place = |name: &String| {
        let found = all.iter().position(|output| output.name == *name);
        match found {
            Some(_) if name == OIL_ENERGY || ELASTIC.iter().any(|end| name.ends_with(end)) => {
                Err(TapeError::Request(format!(
                    "the output `{name}` comes from a table of thousands of rows, which no export holds; leave it out"
                )))
            }
            Some(place) => Ok(place),
            None => {
                let near = suggestion(name, all.iter().map(|output| output.name.as_str()));
                Err(TapeError::Request(format!("the machine has no output `{name}`; {near}")))
            }
        }
    };
    names.iter().map(place).collect()
}
