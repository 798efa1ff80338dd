//! Values of the machine file that a simulation tool can change.

use crate::variable::{Kind, Use, Variable};
use hydrocrane_machine::by_keys::{name_of, numbers_at};
use hydrocrane_machine::model::Provenance;
use hydrocrane_machine::{Machine, OverrideValue};

/// Key of the mass at the tip, which every plant has.
pub const PAYLOAD: &str = "payload.mass";

/// A value of the file, or one element of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    pub key: String,
    pub element: Option<usize>,
    pub unit: String,
    /// SI
    pub value: f64,
    /// As in the file.
    pub start: f64,
}

impl Parameter {
    pub fn name(&self) -> String {
        name_of(&self.key, self.element)
    }

    pub fn variable(&self, index: usize) -> Variable {
        let text = format!("value `{}` of the machine file", self.name());
        Variable::new(&self.name(), Kind::Parameter(index), Use::Tunable, &self.unit, text).starting(self.start)
    }
}

/// The numbers of `machine` at these keys, and at all keys of tables among them.
///
/// # Errors
/// A key at which there is no number.
pub fn parameters(machine: &Machine, keys: &[String]) -> Result<Vec<Parameter>, String> {
    let found = numbers_at(machine, keys)?;
    Ok(found.into_iter().filter(|(entry, _)| entry.key != PAYLOAD).map(parameter).collect())
}

fn parameter((entry, element): (&Provenance, Option<usize>)) -> Parameter {
    let (value, index) = (&entry.value, element.unwrap_or(0));
    let unit = value.units.get(index).or(value.units.first()).map_or(String::new(), |unit| unit.to_string());
    let si = value.si[index];
    Parameter { key: entry.key.clone(), element, unit, value: si, start: si }
}

/// The overrides for the present values.
pub fn overrides(parameters: &[Parameter]) -> Vec<(String, OverrideValue)> {
    let changed = |key: &str| parameters.iter().any(|p| p.key == key && p.value != p.start);
    let mut found: Vec<(String, OverrideValue)> = Vec::new();
    for parameter in parameters.iter().filter(|p| changed(&p.key)) {
        let number = OverrideValue::Number(parameter.value);
        match (parameter.element, found.last_mut()) {
            (Some(_), Some((key, OverrideValue::List(list)))) if *key == parameter.key => list.push(number),
            (Some(_), _) => found.push((parameter.key.clone(), OverrideValue::List(vec![number]))),
            (None, _) => found.push((parameter.key.clone(), number)),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_stands_for_all_numbers_below_and_one_changed_element_brings_the_other() {
        let machine = hydrocrane_machine::load("rottne-f9-lab", &[]).expect("bundled");
        let keys = ["supply".to_string(), "friction.lift".to_string()];
        let mut found = parameters(&machine, &keys).expect("the machine has both");
        assert!(found.iter().any(|p| p.name() == "supply.pressure" && p.unit == "Pa"));
        assert!(overrides(&found).is_empty());
        let second = found.iter_mut().find(|p| p.name() == "friction.lift.coulomb[1]").expect("a pair");
        second.value = 500.0;
        let list = OverrideValue::List(vec![OverrideValue::Number(280.0), OverrideValue::Number(500.0)]);
        assert_eq!(overrides(&found), [("friction.lift.coulomb".to_string(), list)]);
        assert!(parameters(&machine, &["supply.colour".to_string()]).is_err());
    }
}
