//! Keys of a machine file as parameters: `supply.pressure`, or `friction.test.coulomb[0]` for one value of a pair.

use super::SensitivityError;
use hydrocrane_machine::model::{Form, Provenance, Recorded};
use hydrocrane_machine::{ErrorKind, Machine, Number, OverrideValue, Template, Variable};
use std::ops::Range;

type Result<T> = std::result::Result<T, SensitivityError>;

/// A parameter with its value in the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    pub key: String,
    pub value: f64,
    /// SI; empty for a plain number.
    pub unit: String,
}

/// Index of a key's value among the pinned numbers.
struct Slot {
    number: usize,
    /// Which value of a pair; `None`: the only one.
    element: Option<usize>,
}

/// A machine file seen as a function of some of its keys.
pub struct Keys {
    template: Template,
    pub parameters: Vec<Parameter>,
    slots: Vec<Slot>,
    /// The numbers in the tables of the keys. All are given in SI when a value changes, because the unit of one can depend on
    /// the value of another (viscous friction on its exponent).
    pinned: Vec<Provenance>,
}

impl Keys {
    /// Looks the `keys` up in a machine.
    pub fn new(template: Template, keys: &[String]) -> Result<Self> {
        if keys.is_empty() {
            return Err(SensitivityError::Key("name at least one key to differentiate by".into()));
        }
        let machine = template.build(&[])?;
        let paths: Vec<(&str, Option<usize>)> = keys.iter().map(|key| split(key)).collect::<Result<_>>()?;
        let beside = |entry: &&Provenance| {
            entry.value.form != Form::List && paths.iter().any(|(path, _)| table_of(path) == table_of(&entry.key))
        };
        let pinned: Vec<Provenance> = machine.provenance.iter().filter(beside).cloned().collect();
        let mut found = Keys { template, parameters: Vec::new(), slots: Vec::new(), pinned };
        for (i, (key, (path, element))) in keys.iter().zip(&paths).enumerate() {
            let clash = |(other, e): &(&str, Option<usize>)| {
                other == path && (e == element || e.is_none() || element.is_none())
            };
            if paths[..i].iter().any(clash) {
                return Err(SensitivityError::Key(format!("`{key}` is named twice; name each value once")));
            }
            found.add(key, path, *element, &machine)?;
        }
        Ok(found)
    }

    fn add(&mut self, key: &str, path: &str, element: Option<usize>, machine: &Machine) -> Result<()> {
        let Some(index) = self.pinned.iter().position(|number| number.key == path) else {
            return Err(self.no_number(path, machine));
        };
        let number = &self.pinned[index].value;
        let pair = number.form != Form::One;
        let trouble = match element {
            Some(_) if !pair => Some(format!("`{path}` is one number: omit the brackets")),
            None if number.form == Form::Two => {
                Some(format!("`{path}` holds two values: name one of them, `{path}[0]` or `{path}[1]`"))
            }
            _ => None,
        };
        if let Some(text) = trouble {
            return Err(SensitivityError::Key(text));
        }
        let i = element.filter(|_| number.form == Form::Two).unwrap_or(0);
        self.parameters.push(Parameter { key: key.into(), value: number.si[i], unit: number.units[i].to_string() });
        self.slots.push(Slot { number: index, element });
        Ok(())
    }

    /// The loader's reason why `path` names no number.
    fn no_number(&self, path: &str, machine: &Machine) -> SensitivityError {
        if let Some((pair, element @ ("0" | "1"))) = path.rsplit_once('.') {
            if machine.provenance.iter().any(|entry| entry.key == pair && entry.value.form != Form::List) {
                return SensitivityError::Key(format!(
                    "one value of a pair is written `{pair}[{element}]`, not `{path}`"
                ));
            }
        }
        let probe = self.template.build(&[(path.into(), OverrideValue::Number(1.0))]);
        match probe.map_err(|error| (error.kind(), error)) {
            Err((ErrorKind::UnknownKey | ErrorKind::UnknownReference, error)) => error.into(),
            Err((ErrorKind::WrongType, error)) => SensitivityError::Key(format!(
                "`{path}` is not one number, so a derivative by it does not exist: {}",
                error.message()
            )),
            _ => SensitivityError::Key(format!("this machine gives `{path}` no value; give it one by an override")),
        }
    }

    /// The values in the machine.
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// The machine with these values of the keys.
    pub fn machine(&self, values: &[f64]) -> Result<Machine> {
        Ok(self.template.build(&self.changes(values)?)?)
    }

    /// As [`Self::machine`], with derivatives by the parameters of `range`, the first of them by the first of these.
    pub fn machine_with<T: Number>(&self, values: &[f64], range: Range<usize>) -> Result<Machine<T>> {
        let variable = |slot: &Slot| Variable { key: self.pinned[slot.number].key.clone(), element: slot.element };
        let variables: Vec<Variable> = self.slots[range].iter().map(variable).collect();
        Ok(self.template.build_with(&self.changes(values)?, &variables)?)
    }

    fn changes(&self, values: &[f64]) -> Result<Vec<(String, OverrideValue)>> {
        if values.len() != self.slots.len() {
            let (got, wanted) = (values.len(), self.slots.len());
            return Err(SensitivityError::Key(format!("{got} values for {wanted} keys; give one for each")));
        }
        let mut numbers = self.pinned.clone();
        for ((slot, value), parameter) in self.slots.iter().zip(values).zip(&self.parameters) {
            if !value.is_finite() {
                let text = format!("the value of `{}` must be a finite number, got {value}", parameter.key);
                return Err(SensitivityError::Key(text));
            }
            set(&mut numbers[slot.number].value, slot.element, *value);
        }
        Ok(numbers.iter().map(|n| (n.key.clone(), override_of(&n.value))).collect())
    }
}

/// A value common to both of a pair is split if one of them is set.
fn set(number: &mut Recorded, element: Option<usize>, value: f64) {
    if number.form == Form::Shared && element.is_some() {
        number.form = Form::Two;
    }
    if number.form == Form::Shared {
        number.si = vec![value; 2];
    }
    number.si[element.unwrap_or(0)] = value;
}

fn override_of(number: &Recorded) -> OverrideValue {
    match number.form {
        Form::One | Form::Shared => OverrideValue::Number(number.si[0]),
        _ => OverrideValue::List(number.si.iter().copied().map(OverrideValue::Number).collect()),
    }
}

/// The table of a key.
fn table_of(path: &str) -> &str {
    path.rsplit_once('.').map_or("", |(table, _)| table)
}

/// `a.b[1]` into its path and element.
fn split(key: &str) -> Result<(&str, Option<usize>)> {
    match key.split_once('[') {
        None => Ok((key, None)),
        Some((path, "0]")) => Ok((path, Some(0))),
        Some((path, "1]")) => Ok((path, Some(1))),
        Some((path, _)) => Err(SensitivityError::Key(format!(
            "`{key}` is not a key: the values of a pair are `{path}[0]` and `{path}[1]`"
        ))),
    }
}
