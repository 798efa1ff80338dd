//! The declaration of a key in words.

use crate::keys::{Key, Sign, Value};
use crate::units::parse_scalar;
use crate::units::quantities::Kind;

/// Text of a key for editors: a paragraph on its meaning, one on its value.
pub fn description(key: &Key) -> String {
    let mut sentences = vec![form(key)];
    if !key.usual.is_empty() {
        let ranges: Vec<String> = key.usual.iter().map(|(low, high, _)| format!("{low} to {high}")).collect();
        let what = if key.sign() == Sign::Any { "Usual magnitude" } else { "Usual" };
        sentences.push(format!("{what}: {}.", ranges.join(", or ")));
    }
    sentences.push(without(key));
    let source = key.source.text();
    if source.ends_with(".md") {
        sentences.push(format!("See docs/{source}."));
    } else if !source.is_empty() {
        sentences.push(format!("Source: {source}."));
    }
    sentences.retain(|sentence| !sentence.is_empty());
    [key.means.text().to_string(), sentences.join(" ")].join("\n\n").trim_end().to_string()
}

/// The value of the key.
fn form(key: &Key) -> String {
    let sign = match key.sign() {
        Sign::Any => "",
        Sign::NonNegative => "; zero or greater",
        Sign::Positive => "; greater than zero",
    };
    match key.value {
        Value::Quantity(..) => format!("{}{sign}.", quantity(key)),
        Value::Pair(..) => format!("{}{sign}; one value for both, or a list of two.", quantity(key)),
        Value::Series(_) => format!("List. {}.", quantity(key)),
        Value::Point => "Point, for example \"(0.2, -0.1) m\".".into(),
        Value::Points => "List of points, for example \"(0.2, -0.1) m\".".into(),
        Value::Choice(choices) => format!("One of `{}`.", choices.join("`, `")),
        Value::Texts(choices) if !choices.is_empty() => format!("List of `{}`.", choices.join("`, `")),
        Value::Texts(_) => "List of texts.".into(),
        Value::Tables(_) => "Tables with names of their own.".into(),
        Value::Overrides => "For example `\"supply.pressure\" = \"120 bar\"`.".into(),
        Value::Text | Value::Table(_) => String::new(),
    }
}

/// The quantity, its SI unit and an example.
fn quantity(key: &Key) -> String {
    let kinds: Vec<String> = key.kinds().iter().map(|kind| named(key, *kind)).collect();
    match kinds.is_empty() {
        true => "Number with its unit".into(),
        false => upper(&kinds.join(", or ")),
    }
}

fn named(key: &Key, kind: Kind) -> String {
    let example = example(key, kind);
    let (name, quantity) = (kind.name, kind.quantity());
    match (kind.unit, quantity.written(), key.sign()) {
        ("", ..) => format!("plain number, for example {example}"),
        // Ranges are of magnitudes and have no sign.
        (unit, written, Sign::Any) if written == unit => format!("{name} (SI: {unit})"),
        (unit, written, Sign::Any) => format!("{name} (SI: {unit}), for example in {written}"),
        (unit, ..) => format!("{name} (SI: {unit}), for example \"{example}\""),
    }
}

/// The default or the lower usual value, if it is a good example; else one unit, or the upper usual value if that is
/// less.
fn example(key: &Key, kind: Kind) -> String {
    let dimension = kind.quantity().dimension;
    let in_si = |text: &str| {
        let (number, unit) = parse_scalar(text).ok().filter(|(_, unit)| unit.dimension == dimension)?;
        Some(unit.to_si(number))
    };
    let mut lower = key.defaults.iter().copied().chain(key.usual.iter().map(|(low, ..)| *low));
    let one = format!("1 {}", kind.quantity().written()).trim_end().to_string();
    let upper =
        key.usual.iter().map(|(_, high, _)| *high).find(|high| in_si(high) < in_si(&one) && in_si(high).is_some());
    let said = lower.find(|text| in_si(text).is_some_and(|value| value != 0.0));
    said.or(upper).map_or(one, str::to_string)
}

/// The effect of a missing key.
fn without(key: &Key) -> String {
    let otherwise = key.otherwise.text();
    if !key.defaults.is_empty() {
        format!("Default: {}.", key.defaults.join(", or "))
    } else if otherwise.is_empty() {
        String::new()
    } else if CONDITIONS.iter().any(|word| otherwise.starts_with(word)) {
        format!("{}.", upper(otherwise))
    } else {
        format!("Default: {otherwise}.")
    }
}

/// Beginning of the text in place of a default that states when a key is required.
const CONDITIONS: [&str; 4] = ["required", "this", "one of", "with"];

fn upper(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
