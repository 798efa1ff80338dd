//! Fields of a scenario that replace values of its machine: precedence and agreement, checked in one place.

use crate::keys::LEVER;
use crate::text::merge::OverrideValue;
use crate::units::misread::quantity;

/// A field of a scenario that replaces a key of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// Table and key of the field in a scenario file.
    pub table: &'static str,
    pub field: &'static str,
    /// SI
    pub value: f64,
    pub unit: &'static str,
    /// Key of the machine.
    pub key: String,
}

/// Machine key of the speed at full stick of a controller; `None` if it has none.
pub fn full_speed_key(controller: &str) -> Option<String> {
    (controller != LEVER).then(|| format!("control.{controller}.full-speed"))
}

/// All such values: the payload (kg), and the period (s) and the speed at full stick (m/s) of the `controller` of this
/// name. Missing fields are left out; a user-defined controller has no name.
pub fn stated(
    payload: Option<f64>,
    controller: Option<&str>,
    period: Option<f64>,
    full_speed: Option<f64>,
) -> Vec<Stated> {
    let one = |table, field, unit, key: Option<String>, value: Option<f64>| {
        Some(Stated { table, field, value: value?, unit, key: key? })
    };
    let of_loop = controller.map(|_| "control.period".to_string());
    [
        one("scenario", "payload", "kg", Some("payload.mass".to_string()), payload),
        one("controller", "period", "s", of_loop, period),
        one("joystick", "full-speed", "m/s", controller.and_then(full_speed_key), full_speed),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The contradiction between `value` and the override `other` of `key`, if there is one. Numbers are in `unit`. Invalid
/// quantities are left to the check of the machine.
pub fn contradiction(value: &OverrideValue, unit: &str, key: &str, other: &OverrideValue) -> Option<String> {
    let (one, two) = (si(value)?, si(other)?);
    let text = |value: &OverrideValue, si: f64| match value {
        OverrideValue::Text(text) => text.clone(),
        _ => format!("{si} {unit}"),
    };
    ((one - two).abs() > 1e-12 * one.abs().max(two.abs())).then(|| {
        format!("is {}, and the override `{key}` is {}: both state the same", text(value, one), text(other, two))
    })
}

fn si(value: &OverrideValue) -> Option<f64> {
    match value {
        OverrideValue::Number(number) => Some(*number),
        OverrideValue::Text(text) => quantity(text, None).ok().map(|(value, _)| value),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_controllers_and_levers_state_less() {
        let keys = |controller| {
            let found = stated(Some(1.0), controller, Some(0.01), Some(0.2));
            found.into_iter().map(|stated| stated.key).collect::<Vec<_>>()
        };
        assert_eq!(keys(Some("tip")), ["payload.mass", "control.period", "control.tip.full-speed"]);
        assert_eq!(keys(Some("lever")), ["payload.mass", "control.period"]);
        assert_eq!(keys(None), ["payload.mass"]);
    }

    #[test]
    fn the_same_in_another_unit_is_no_contradiction_and_another_value_is_reported_as_it_was_given() {
        let (number, text) = (OverrideValue::Number, |text: &str| OverrideValue::Text(text.into()));
        let found = |value, other: &OverrideValue| contradiction(&value, "kg", "payload.mass", other);
        assert_eq!(found(number(70.0), &text("0.07 t")), None);
        assert_eq!(found(number(70.0), &text("heavy")), None);
        let message = found(number(50.0), &text("0.07 t")).expect("they differ");
        assert_eq!(message, "is 50 kg, and the override `payload.mass` is 0.07 t: both state the same");
        assert!(found(text("1 t"), &number(999.0)).is_some());
    }
}
