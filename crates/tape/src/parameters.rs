//! Numbers of the machine file as inputs of a tape.
//!
//! Choices between formulas, and whether a part is there, are made once, for the values of the file. So each parameter is checked: a
//! machine with other values is read anew, and its laws must have the same structure and the numbers that the tape gives.

use crate::error::TapeError;
use crate::laws::{by_joints, recorded, Recorded};
use hydrocrane_machine::by_keys::{name_of, numbers_at, Keys, Parameter};
use hydrocrane_machine::{Machine, Number, Template};
use hydrocrane_plant::equations::from_machine::plant;
use hydrocrane_plant::errors::BuildError;
use hydrocrane_plant::Layout;
use std::collections::BTreeMap;

type Result<T> = std::result::Result<T, TapeError>;

/// The mass at the tip, which every machine has.
const PAYLOAD: &str = "payload.mass";
/// Table of that key.
const LOAD: &str = "payload";
/// Relative change of a value in the check, and the change of a value that is zero, SI.
const CHANGE: f64 = 1e-3;
const FROM_ZERO: f64 = 1e-6;
/// Largest relative difference that is rounding.
const ROUNDING: f64 = 1e-9;

/// A machine file with the numbers that are parameters. The payload, if it is one, is the last of them.
pub(crate) struct Chosen {
    template: Template,
    /// `None`: no number but the payload.
    keys: Option<Keys>,
    /// kg; `None` if it is no parameter.
    payload: Option<f64>,
}

impl Chosen {
    fn new(template: &Template, names: &[String], payload: Option<f64>) -> Result<Self> {
        let keys = if names.is_empty() { None } else { Some(Keys::new(template.clone(), names)?) };
        Ok(Chosen { template: template.clone(), keys, payload })
    }

    pub fn parameters(&self) -> Vec<Parameter> {
        let of_keys = self.keys.iter().flat_map(|keys| keys.parameters.clone());
        let payload = self.payload.map(|value| Parameter { key: PAYLOAD.into(), value, unit: "kg".into() });
        of_keys.chain(payload).collect()
    }

    pub fn values(&self) -> Vec<f64> {
        self.parameters().iter().map(|parameter| parameter.value).collect()
    }

    pub fn count(&self) -> usize {
        self.keys.as_ref().map_or(0, |keys| keys.parameters.len()) + usize::from(self.payload.is_some())
    }

    /// The machine with these values of the parameters, but for the payload.
    pub fn machine<T: Number>(&self, values: &[f64]) -> Result<Machine<T>> {
        let Some(keys) = &self.keys else { return Ok(self.template.build_with(&[], &[])?) };
        let count = keys.parameters.len();
        Ok(keys.machine_with(&values[..count], 0..count)?)
    }

    /// The laws with these parameters as inputs, and so many outputs and powers.
    pub fn record(&self, layout: &Layout, counts: [usize; 2], derivatives: bool) -> Result<Recorded> {
        let payload = self.payload.map(|mass| (self.count() - 1, mass));
        recorded(|| self.machine(&self.values()), payload, layout, counts, derivatives)
    }
}

/// The parameters of a request. Numbers of tables that cannot be any are left out.
///
/// # Errors
/// A key that is no number, one without effect, and one that decides what the laws are.
pub(crate) fn chosen(template: &Template, layout: &Layout, counts: [usize; 2], request: &[String]) -> Result<Chosen> {
    let machine = template.build(&[])?;
    let payload = request.iter().any(|key| key == PAYLOAD || key == LOAD).then_some(machine.payload.mass);
    // The mass is a parameter of its own, which a file need not state.
    let stated = |key: &str| machine.provenance.iter().any(|entry| entry.key != PAYLOAD && entry.key.starts_with(key));
    let keys = request.iter().filter(|key| *key != PAYLOAD && (*key != LOAD || stated("payload.")));
    let is_number = |key: &&String| machine.provenance.iter().any(|entry| key.split('[').next() == Some(&entry.key));
    let (numbers, tables): (Vec<String>, Vec<String>) = keys.cloned().partition(|key| is_number(&key));
    let taken = |key: &str| key == PAYLOAD || numbers.iter().any(|number| number.split('[').next() == Some(key));
    let below = numbers_at(&machine, &tables).map_err(TapeError::Request)?.into_iter();
    let below = below.filter(|(entry, _)| !taken(&entry.key)).map(|(entry, element)| name_of(&entry.key, element));
    let names: Vec<String> = numbers.iter().cloned().chain(below).collect();

    let all = Chosen::new(template, &names, payload)?;
    let recorded = all.record(layout, counts, false)?;
    let faults = faults(&all, &recorded)?;
    if let Some(fault) = (0..numbers.len()).find_map(|i| faults.get(&i)) {
        return Err(TapeError::Request(fault.clone()));
    }
    // Named itself, a number that decides on a formula only costs the shorter one.
    let stays =
        |i: &usize| *i < numbers.len() || !(faults.contains_key(i) || recorded.tape.decisive.contains(&(*i as u32)));
    let kept: Vec<String> = (0..names.len()).filter(stays).map(|i| names[i].clone()).collect();
    Chosen::new(template, &kept, payload)
}

/// What forbids to take parameters as inputs, by their index in order.
fn faults(chosen: &Chosen, recorded: &Recorded) -> Result<BTreeMap<usize, String>> {
    let parameters = chosen.parameters();
    let count = parameters.len() - usize::from(chosen.payload.is_some());
    let results = recorded.rates.iter().chain(&recorded.outputs).map(|result| result.operand());
    let needed = recorded.tape.needed(results);
    let mut found = BTreeMap::new();
    for (i, parameter) in parameters.iter().take(count).enumerate() {
        if !recorded.tape.uses_parameter(&needed, i) {
            found.insert(
                i,
                format!("`{}` does not enter the equations of this machine, so it is no parameter", parameter.key),
            );
        }
    }
    let all: Vec<usize> = (0..count).collect();
    if agrees(chosen, recorded, &all) {
        return Ok(found);
    }
    // At their own values these have a shorter formula, which is not the recorded one.
    let decisive = |i: &usize| recorded.tape.decisive.contains(&(*i as u32));
    for i in 0..count {
        let moved: Vec<usize> = all.iter().copied().filter(|other| *other == i || decisive(other)).collect();
        if !agrees(chosen, recorded, &moved) {
            found.insert(i, format!(
                "`{}` decides which laws act, or cannot change alone, so it is no parameter; export the machine once for each value",
                parameters[i].key
            ));
        }
    }
    Ok(found)
}

/// Whether the tape follows a change of these parameters, upwards or else downwards.
fn agrees(chosen: &Chosen, recorded: &Recorded, which: &[usize]) -> bool {
    let on_tape: Vec<_> = recorded.numbers.iter().map(|number| number.operand()).collect();
    [CHANGE, -CHANGE].into_iter().any(|change| {
        let mut values = chosen.values();
        for i in which {
            values[*i] = if values[*i] == 0.0 { FROM_ZERO * change.signum() } else { values[*i] * (1.0 + change) };
        }
        let Ok((numbers, structure)) = chosen.machine::<f64>(&values).and_then(|machine| laws(&machine)) else {
            return false;
        };
        let followed = recorded.tape.evaluate(&on_tape, [&[], &[], &values]);
        let same = |(a, b): (&f64, &f64)| a == b || (a - b).abs() <= ROUNDING * b.abs();
        structure == recorded.structure && numbers.len() == followed.len() && followed.iter().zip(&numbers).all(same)
    })
}

/// All numbers of the laws of a machine, and what they have besides.
fn laws(machine: &Machine) -> Result<(Vec<f64>, String)> {
    by_joints!(machine.joints.len(), numbers_of(machine))
}

fn numbers_of<const N: usize>(machine: &Machine) -> Result<(Vec<f64>, String)> {
    let plant = plant::<f64, N>(machine)?;
    Ok((plant.numbers(), plant.structure()))
}
