//! Forms of values, as common definitions of the schema.
//!
//! A text with a unit must match a pattern: a number of the right sign, then a unit. Units of one symbol are those of
//! the quantity; of products and quotients only the beginning is checked.

use serde_json::{json, Map, Value as Json};

use super::FileKind;
use crate::keys::{Key, Sign, Value};
use crate::reading::log::CLASSES;
use crate::units::quantities::{Kind, LENGTH, NUMBER};
use crate::units::symbols_of;

const UNSIGNED: &str = r"([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?";
/// Zero may have a minus.
const MINUS_ZERO: &str = r"-(0+(\.0*)?|\.0+)([eE][+-]?[0-9]+)?";
/// Beginning of the unit of a product, a quotient or a power.
const COMPOUND: &str = r"[A-Za-zµ%]+\s*[*/·^²³(]|[A-Za-zµ%]+[2-9]|[A-Za-zµ%]+\s+[A-Za-zµ%]|\(";

/// The forms of values of a kind of file.
pub struct Forms {
    pub file: FileKind,
    pub definitions: Map<String, Json>,
}

impl Forms {
    pub fn new(file: FileKind) -> Self {
        let mut forms = Self { file, definitions: Map::new() };
        let classes = CLASSES.map(|(name, _)| name);
        // The reader checks only the classes of quantities in machine files.
        if file == FileKind::Machine {
            forms.define("class", json!({ "enum": classes }));
        }
        forms.define("any-class", json!({ "anyOf": [{ "enum": classes }, { "type": "string" }] }));
        forms
    }

    pub fn reference(name: &str) -> Json {
        json!({ "$ref": format!("#/definitions/{name}") })
    }

    /// # Panics If another schema has the name.
    pub fn define(&mut self, name: &str, schema: Json) -> Json {
        let known = self.definitions.entry(name).or_insert_with(|| schema.clone());
        assert_eq!(known, &schema, "two schemas have the name `{name}`");
        Self::reference(name)
    }

    /// Adds the keys for the provenance of the values of a table.
    pub fn origin(&self, properties: &mut Map<String, Json>) {
        let hints = |what: &str, class: Json| match self.file {
            FileKind::Machine => json!({ "description": what, "anyOf": [class] }),
            // Read and ignored.
            FileKind::Scenario => json!({ "type": "string", "x-taplo": { "hidden": true } }),
        };
        let class = "Provenance of the values of this table and below it: where they come from.";
        properties.insert("class".into(), hints(class, Self::reference("any-class")));
        let source = "Source of the values of this table and below it.";
        properties.insert("source".into(), hints(source, json!({ "type": "string" })));
    }

    /// A value alone, or with its provenance.
    pub fn alternatives(&mut self, key: &Key) -> Vec<Json> {
        let (name, mut value) = self.value(key);
        if let Some(name) = &name {
            value = self.define(name, value);
        }
        let class = match (self.file, key.value.is_of_quantities()) {
            (FileKind::Machine, true) => "class",
            _ => "any-class",
        };
        let mut with_origin = json!({
            "type": "object",
            "properties": { "value": value, "class": Self::reference(class), "source": { "type": "string" } },
            "required": ["value"],
            "additionalProperties": false,
        });
        if let Some(name) = name {
            with_origin = self.define(&format!("{name}-with-origin"), with_origin);
        }
        vec![value, with_origin]
    }

    /// The schema of a value, with a name if several keys have it.
    fn value(&mut self, key: &Key) -> (Option<String>, Json) {
        match key.value {
            Value::Quantity(kinds, sign) => (Some(named("quantity", kinds, sign)), quantity(kinds, sign)),
            Value::Pair(kinds, sign) => {
                let one = self.define(&named("quantity", kinds, sign), quantity(kinds, sign));
                let two = json!({ "type": "array", "items": one, "minItems": 2, "maxItems": 2 });
                (Some(named("pair", kinds, sign)), json!({ "anyOf": [one, two] }))
            }
            Value::Series(kinds) => {
                let one = self.define(&named("quantity", kinds, Sign::Any), quantity(kinds, Sign::Any));
                (Some(named("series", kinds, Sign::Any)), json!({ "type": "array", "items": one, "minItems": 1 }))
            }
            Value::Point => (Some("point".into()), point()),
            Value::Points => {
                let one = self.define("point", point());
                (Some("points".into()), json!({ "type": "array", "items": one }))
            }
            Value::Text => (Some("text".into()), json!({ "type": "string" })),
            Value::Texts(&[]) => (Some("texts".into()), json!({ "type": "array", "items": { "type": "string" } })),
            Value::Texts(choices) => (None, json!({ "type": "array", "items": { "enum": choices } })),
            Value::Choice(choices) => (None, json!({ "enum": choices })),
            Value::Table(_) | Value::Tables(_) | Value::Overrides => (None, json!({ "type": "object" })),
        }
    }
}

/// A name of letters, digits and hyphens.
fn named(form: &str, kinds: &[Kind], sign: Sign) -> String {
    let sign = match sign {
        Sign::Any => "",
        Sign::NonNegative => "not negative",
        Sign::Positive => "positive",
    };
    let kinds = kinds.iter().flat_map(|kind| [kind.name, kind.unit]);
    let words: Vec<String> =
        [form].into_iter().chain(kinds).chain([sign]).map(|word| word.replace('/', " per ")).collect();
    let parts = words.iter().flat_map(|word| word.split(|c: char| !c.is_ascii_alphanumeric()));
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

fn quantity(kinds: &[Kind], sign: Sign) -> Json {
    let number = match sign {
        Sign::Any => format!("[+-]?{UNSIGNED}"),
        Sign::NonNegative => format!(r"(\+?{UNSIGNED}|{MINUS_ZERO})"),
        Sign::Positive => format!(r"\+?{UNSIGNED}"),
    };
    // Between a number and a unit that begins with a digit there is a space.
    let text = json!({ "type": "string", "pattern": format!(r"^\s*{number}(\s*({})|\s+1)", unit(kinds)) });
    if !kinds.contains(&NUMBER) {
        return text;
    }
    let number = match sign {
        Sign::Any => json!({ "type": "number" }),
        Sign::NonNegative => json!({ "type": "number", "minimum": 0 }),
        Sign::Positive => json!({ "type": "number", "exclusiveMinimum": 0 }),
    };
    json!({ "anyOf": [number, text] })
}

fn point() -> Json {
    let pattern = format!(r"^\s*\(\s*[+-]?{UNSIGNED}(\s*,\s*[+-]?{UNSIGNED}){{1,2}}\s*\)\s*({}|1)", unit(&[LENGTH]));
    json!({ "type": "string", "pattern": pattern })
}

/// A pattern of the units of these kinds.
fn unit(kinds: &[Kind]) -> String {
    let symbols = kinds.iter().flat_map(|kind| symbols_of(kind.quantity().dimension));
    let mut single: Vec<&str> = symbols.collect();
    if kinds.contains(&NUMBER) {
        single.push("");
    }
    match single.is_empty() {
        true => COMPOUND.into(),
        false => format!(r"({})\s*$|{COMPOUND}", single.join("|")),
    }
}

/// The default of a key that has one.
pub fn default(key: &Key) -> Option<Json> {
    let [text] = key.defaults else { return None };
    let number = text.parse::<f64>().ok().filter(|_| key.kinds().contains(&NUMBER));
    Some(match number {
        Some(number) if number.fract() == 0.0 => json!(number as i64),
        Some(number) => json!(number),
        None => json!(text),
    })
}
