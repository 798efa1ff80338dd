//! The declared keys for editors, as a JSON Schema, and for the reference page, as a list.
//!
//! The reader refuses everything that the schema refuses. It refuses more, because it has the other values of the file,
//! and units.

mod listing;
mod values;
mod words;

use serde_json::{json, Map, Value as Json};

use crate::keys::{Key, Value, MACHINE, SCENARIO};
use values::Forms;

/// A kind of file with its keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    Machine,
    Scenario,
}

impl FileKind {
    pub const ALL: [(&'static str, Self); 2] = [("machine", Self::Machine), ("scenario", Self::Scenario)];

    fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }

    fn keys(self) -> &'static [Key] {
        match self {
            Self::Machine => MACHINE,
            Self::Scenario => SCENARIO,
        }
    }

    /// The schema of these files, a text of JSON Schema draft-07.
    pub fn json_schema(self) -> String {
        let mut forms = Forms::new(self);
        let mut schema = Map::new();
        schema.insert("$schema".into(), "http://json-schema.org/draft-07/schema#".into());
        schema.insert("title".into(), format!("hydrocrane {} file", self.name()).into());
        schema.insert("$comment".into(), format!("Written by `hydrocrane schema {}`.", self.name()).into());
        schema.extend(table(self.keys(), &mut forms));
        // Machine files that extend others may be incomplete.
        if let (Self::Machine, Some(whole)) = (self, whole(self.keys())) {
            forms.define("whole", whole);
            schema.insert("if".into(), json!({ "anyOf": [{ "required": ["extends"] }, { "required": ["include"] }] }));
            schema.insert("else".into(), Forms::reference("whole"));
        }
        schema.insert("definitions".into(), Json::Object(forms.definitions));
        written(&Json::Object(schema))
    }

    /// Every key of these files with its declaration, as JSON text.
    pub fn key_list(self) -> String {
        written(&Json::Array(listing::rows(self.keys())))
    }
}

fn written(value: &Json) -> String {
    serde_json::to_string_pretty(value).expect("a value of JSON") + "\n"
}

/// The schema of a table with these keys.
fn table(keys: &'static [Key], forms: &mut Forms) -> Map<String, Json> {
    let mut properties = Map::new();
    let mut further = Json::Bool(false);
    let required = required(keys);
    for key in keys {
        let schema = Json::Object(one(key, forms));
        if key.is_for_any_name() {
            further = schema;
        } else {
            properties.insert(key.name.into(), schema);
        }
    }
    forms.origin(&mut properties);
    let mut schema = Map::new();
    schema.insert("type".into(), "object".into());
    schema.insert("properties".into(), properties.into());
    if forms.file == FileKind::Scenario && !required.is_empty() {
        schema.insert("required".into(), required.into());
    }
    schema.insert("additionalProperties".into(), further);
    schema
}

/// The schema of the value of a key.
fn one(key: &'static Key, forms: &mut Forms) -> Map<String, Json> {
    let mut schema = Map::new();
    schema.insert("description".into(), words::description(key).into());
    match key.value {
        Value::Table(keys) => schema.extend(table(keys, forms)),
        Value::Tables(keys) => {
            let mut properties = Map::new();
            forms.origin(&mut properties);
            schema.insert("type".into(), "object".into());
            schema.insert("properties".into(), properties.into());
            schema.insert("additionalProperties".into(), table(keys, forms).into());
        }
        Value::Overrides => {
            schema.insert("type".into(), "object".into());
        }
        _ => {
            if let Some(default) = values::default(key) {
                schema.insert("default".into(), default);
            }
            schema.insert("anyOf".into(), forms.alternatives(key).into());
        }
    }
    schema
}

fn required(keys: &'static [Key]) -> Vec<&'static str> {
    keys.iter().filter(|key| key.is_required()).map(|key| key.name).collect()
}

/// The required keys of a complete machine file, as a schema.
fn whole(keys: &'static [Key]) -> Option<Json> {
    let required = required(keys);
    let below = |key: &Key| match key.value {
        Value::Table(keys) => Some((key.name.to_string(), whole(keys)?)),
        Value::Tables(keys) => Some((key.name.to_string(), json!({ "additionalProperties": whole(keys)? }))),
        _ => None,
    };
    let properties: Map<String, Json> = keys.iter().filter_map(below).collect();
    let mut schema = Map::new();
    if !required.is_empty() {
        schema.insert("required".into(), required.into());
    }
    if !properties.is_empty() {
        schema.insert("properties".into(), properties.into());
    }
    (!schema.is_empty()).then(|| schema.into())
}
