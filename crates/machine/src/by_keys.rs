//! Keys of a machine file as parameters: `supply.pressure`, or `friction.test.coulomb[0]` for one value of a pair.

use crate::errors::{ErrorKind, MachineError};
use crate::load::Template;
use crate::model::{Form, Machine, Provenance, Recorded};
use crate::nearest::suggestion;
use crate::number::{Number, Variable};
use crate::text::merge::OverrideValue;
use std::ops::Range;

type Result<T> = std::result::Result<T, KeyError>;

/// Why keys or their values do not serve.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyError {
    /// An error of the machine, or an unknown key.
    Machine(MachineError),
    /// A key that is no numeric parameter, or a wrong value of one.
    Key(String),
}

impl From<MachineError> for KeyError {
    fn from(error: MachineError) -> Self {
        KeyError::Machine(error)
    }
}

impl std::fmt::Display for KeyError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            KeyError::Machine(error) => error.fmt(f),
            KeyError::Key(text) => f.write_str(text),
        }
    }
}

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
            return Err(KeyError::Key("name at least one key of the machine file".into()));
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
                return Err(KeyError::Key(format!("`{key}` is named twice; name each value once")));
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
            Some(element) if element >= number.si.len() => Some(format!(
                "`{path}` holds {} values, `{path}[0]` to `{path}[{}]`",
                number.si.len(),
                number.si.len() - 1
            )),
            None if number.form == Form::Two => {
                Some(format!("`{path}` holds two values: name one of them, `{path}[0]` or `{path}[1]`"))
            }
            _ => None,
        };
        if let Some(text) = trouble {
            return Err(KeyError::Key(text));
        }
        let i = element.filter(|_| number.form == Form::Two).unwrap_or(0);
        self.parameters.push(Parameter { key: key.into(), value: number.si[i], unit: number.units[i].to_string() });
        self.slots.push(Slot { number: index, element });
        Ok(())
    }

    /// The loader's reason why `path` names no number.
    fn no_number(&self, path: &str, machine: &Machine) -> KeyError {
        if let Some((pair, element @ ("0" | "1"))) = path.rsplit_once('.') {
            if machine.provenance.iter().any(|entry| entry.key == pair && entry.value.form != Form::List) {
                return KeyError::Key(format!("one value of a pair is written `{pair}[{element}]`, not `{path}`"));
            }
        }
        let probe = self.template.build(&[(path.into(), OverrideValue::Number(1.0))]);
        match probe.map_err(|error| (error.kind(), error)) {
            Err((ErrorKind::UnknownKey | ErrorKind::UnknownReference, error)) => error.into(),
            Err((ErrorKind::WrongType, error)) => KeyError::Key(format!(
                "`{path}` is not one number, so a derivative by it does not exist: {}",
                error.message()
            )),
            _ => KeyError::Key(format!("this machine gives `{path}` no value; give it one by an override")),
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
            return Err(KeyError::Key(format!("{got} values for {wanted} keys; give one for each")));
        }
        let mut numbers = self.pinned.clone();
        for ((slot, value), parameter) in self.slots.iter().zip(values).zip(&self.parameters) {
            if !value.is_finite() {
                let text = format!("the value of `{}` must be a finite number, got {value}", parameter.key);
                return Err(KeyError::Key(text));
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
        Some((path, "2]")) => Ok((path, Some(2))),
        Some((path, _)) => {
            Err(KeyError::Key(format!("`{key}` is not a key: the values of a pair are `{path}[0]` and `{path}[1]`")))
        }
    }
}

/// The numbers of `machine` at these keys, and at all keys of tables among them, each with the element of a pair that it is.
///
/// # Errors
/// A key at which there is no number.
pub fn numbers_at<'a>(
    machine: &'a Machine,
    keys: &[String],
) -> std::result::Result<Vec<(&'a Provenance, Option<usize>)>, String> {
    let below = |entry: &Provenance, key: &str| {
        entry.key.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    if let Some(none) = keys.iter().find(|key| !machine.provenance.iter().any(|entry| below(entry, key))) {
        let near = suggestion(none, beside(machine, none));
        return Err(format!("the machine has no number at `{none}`, so it is no parameter; {near}"));
    }
    let wanted = machine.provenance.iter().filter(|entry| keys.iter().any(|key| below(entry, key)));
    Ok(wanted.flat_map(elements).collect())
}

/// What the machine has in the innermost of the tables of `key` that it has.
fn beside<'a>(machine: &'a Machine, key: &str) -> Vec<&'a str> {
    let mut table = key;
    loop {
        table = table.rsplit_once('.').map_or("", |(above, _)| above);
        let below = machine.provenance.iter().filter_map(|entry| {
            let start = if table.is_empty() { 0 } else { table.len() + 1 };
            let inside = entry.key.starts_with(table) && (start == 0 || entry.key[table.len()..].starts_with('.'));
            inside.then(|| &entry.key[..entry.key[start..].find('.').map_or(entry.key.len(), |end| start + end)])
        });
        let mut found: Vec<&str> = below.collect();
        found.sort_unstable();
        found.dedup();
        if !found.is_empty() || table.is_empty() {
            return found;
        }
    }
}

fn elements(entry: &Provenance) -> Vec<(&Provenance, Option<usize>)> {
    match entry.value.form {
        Form::List => Vec::new(),
        Form::Two => (0..entry.value.si.len()).map(|element| (entry, Some(element))).collect(),
        _ => entry.value.si.first().map(|_| (entry, None)).into_iter().collect(),
    }
}

/// The name of a number, `a.b` or `a.b[1]`.
pub fn name_of(key: &str, element: Option<usize>) -> String {
    element.map_or_else(|| key.to_string(), |element| format!("{key}[{element}]"))
}
