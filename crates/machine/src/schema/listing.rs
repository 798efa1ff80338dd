//! Every declared key as a row of plain data.

use serde_json::{json, Value as Json};

use super::words;
use crate::keys::{Key, Sign, Value};

/// Rows of these keys and of all below them, each table before its keys.
pub fn rows(keys: &'static [Key]) -> Vec<Json> {
    let mut found = Vec::new();
    collect(keys, "", &mut found);
    found
}

fn collect(keys: &'static [Key], above: &str, found: &mut Vec<Json>) {
    for key in keys {
        let path = format!("{above}{}", key.name);
        found.push(row(key, &path));
        match key.value {
            Value::Table(below) => collect(below, &format!("{path}."), found),
            Value::Tables(below) => collect(below, &format!("{path}.<name>."), found),
            _ => {}
        }
    }
}

fn row(key: &'static Key, path: &str) -> Json {
    let kinds: Vec<Json> = key.kinds().iter().map(|kind| json!({ "name": kind.name, "unit": kind.unit })).collect();
    let usual: Vec<[&str; 2]> = key.usual.iter().map(|(low, high, _)| [*low, *high]).collect();
    json!({
        "path": path,
        "form": form(&key.value),
        "kinds": kinds,
        "sign": match key.sign() {
            Sign::Any => "any",
            Sign::NonNegative => "zero or greater",
            Sign::Positive => "greater than zero",
        },
        "choices": key.choices(),
        "defaults": key.defaults,
        "otherwise": key.otherwise.text(),
        "usual": usual,
        "means": key.means.text(),
        "source": key.source.text(),
        "description": words::description(key),
    })
}

fn form(value: &Value) -> &'static str {
    match value {
        Value::Quantity(..) => "quantity",
        Value::Pair(..) => "pair",
        Value::Series(_) => "series",
        Value::Point => "point",
        Value::Points => "points",
        Value::Text => "text",
        Value::Texts(_) => "texts",
        Value::Choice(_) => "choice",
        Value::Table(_) => "table",
        Value::Tables(_) => "tables",
        Value::Overrides => "overrides",
    }
}
