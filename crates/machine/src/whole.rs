//! A machine as the text of one file, with everything that it extends and includes.

use std::fmt::Write;

use crate::model::Provenance;
use crate::text::document::{join, Entry, Node, NodeKind, Origin, Place, Scalar};
use crate::text::merge::override_value;
use crate::text::toml_text::{key, quoted, written};

/// Keys that name other files.
const OTHER_FILES: [&str; 3] = ["extends", "include", "without"];

/// The text of the `tree` of a machine; `recorded` tells the units of overrides that are plain SI numbers.
pub fn text(tree: &Node, recorded: &[Provenance]) -> String {
    let mut writer = Writer { text: String::new(), recorded };
    let entries = tree.entries().unwrap_or_default();
    for entry in entries.iter().filter(|entry| !OTHER_FILES.contains(&entry.key.as_str())) {
        writer.entry(entry, &key(&entry.key), &entry.key);
    }
    writer.text
}

struct Writer<'a> {
    text: String,
    recorded: &'a [Provenance],
}

impl Writer<'_> {
    /// A table below the heading `header`, whose keys have the dotted `path` in front of them.
    fn entry(&mut self, entry: &Entry, header: &str, path: &str) {
        let Some(entries) = entry.node.entries() else { return };
        let values: Vec<(&Entry, &Scalar, &Origin)> = entries.iter().filter_map(value_of).collect();
        let own = self.heading(header, path, &values, entries.is_empty());
        for (entry, value, origin) in values {
            let path = join(path, &entry.key);
            let value = self.value(value, &path, &entry.node.place);
            let line = match own.filter(|own| !same(own, origin)) {
                Some(_) => format!("{{ value = {value}, {} }}", provenance(origin).join(", ")),
                None => value,
            };
            let _ = writeln!(self.text, "{} = {line}", key(&entry.key));
        }
        for entry in entries {
            self.entry(entry, &format!("{header}.{}", key(&entry.key)), &join(path, &entry.key));
        }
    }

    /// Writes the heading of a table with values or with nothing in it, and the provenance that its values have unless they say
    /// otherwise. The values of the table that names the machine carry none: what stood there would count for the whole file.
    fn heading<'o>(
        &mut self,
        header: &str,
        path: &str,
        values: &[(&Entry, &Scalar, &'o Origin)],
        empty: bool,
    ) -> Option<&'o Origin> {
        if values.is_empty() && !empty {
            return None;
        }
        let _ = writeln!(self.text, "{}[{header}]", if self.text.is_empty() { "" } else { "\n" });
        let own = values.first().map(|(_, _, origin)| *origin).filter(|_| path != "machine")?;
        for line in provenance(own) {
            let _ = writeln!(self.text, "{line}");
        }
        Some(own)
    }

    fn value(&self, value: &Scalar, path: &str, place: &Place) -> String {
        let units = match place {
            Place::Override(_) => self.recorded.iter().find(|entry| entry.key == path).map(|e| &e.value.units[..]),
            Place::File { .. } => None,
        };
        override_value(value).map_or_else(|| quoted(""), |value| written(&value, units.unwrap_or_default()))
    }
}

/// A value of a table, with where it comes from.
fn value_of(entry: &Entry) -> Option<(&Entry, &Scalar, &Origin)> {
    match &entry.node.kind {
        NodeKind::Value { value, origin } => Some((entry, value, origin)),
        NodeKind::Table(_) => None,
    }
}

fn class(origin: &Origin) -> Option<&str> {
    origin.class.as_ref().map(|(class, _)| class.as_str())
}

fn same(one: &Origin, other: &Origin) -> bool {
    class(one) == class(other) && one.source == other.source
}

/// Keys and values that state a provenance. A class of which nothing is known is left out.
fn provenance(origin: &Origin) -> Vec<String> {
    let class = class(origin).map(|class| format!("class = {}", quoted(class)));
    class.into_iter().chain([format!("source = {}", quoted(&origin.source))]).collect()
}

#[cfg(test)]
mod tests {
    use crate::model::{HoldingKind, Place};
    use std::sync::Arc;

    use crate::{bundled_machines, parse, Machine, OverrideValue, Template};

    /// Values stand before tables in a file, so that the order of the values and their places are other ones.
    fn in_any_order(mut machine: Machine) -> Machine {
        Arc::make_mut(&mut machine.provenance).sort_by(|one, other| one.key.cmp(&other.key));
        let nowhere = || Place::Override("".into());
        machine.sensors.iter_mut().for_each(|sensor| sensor.place = nowhere());
        // What is written as a file is what the file states.
        machine.supply.rated = machine.supply.pressure;
        for held in machine.cylinders.iter_mut().flat_map(|cylinder| cylinder.ports.holding.iter_mut().flatten()) {
            if let HoldingKind::Counterbalance(valve) = &mut held.kind {
                valve.place = nowhere();
            }
        }
        machine
    }

    fn read_back(text: &str) -> Machine {
        in_any_order(parse(text, "machine.toml", &[]).expect("what was written can be read"))
    }

    #[test]
    fn a_bundled_machine_in_one_file_is_the_same_machine() {
        for (name, _) in bundled_machines() {
            let template = Template::open(name, &[]).expect("bundled");
            let text = template.to_toml(&[]).expect("bundled");
            assert!(!text.contains("extends"), "{name}");
            assert!(read_back(&text) == in_any_order(template.build(&[]).expect("bundled")), "{name}");
        }
    }

    #[test]
    fn overrides_are_written_with_their_units_and_all_their_digits() {
        let (number, text) = (OverrideValue::Number, |text: &str| OverrideValue::Text(text.into()));
        let changes = [
            ("supply.pressure".to_string(), number(1e8 / 7.0)),
            ("payload.mass".to_string(), text("0.07 t")),
            ("friction.lift.coulomb".to_string(), OverrideValue::List(vec![number(100.1), text("300 N")])),
        ];
        let template = Template::open("rottne-f9-pump", &[]).expect("bundled");
        let (machine, written) = (template.build(&changes), template.to_toml(&changes));
        assert!(read_back(&written.expect("it builds")) == in_any_order(machine.expect("it builds")));
    }

    #[test]
    fn what_is_wrong_with_an_override_is_an_error() {
        let template = Template::open("rottne-f9-lab", &[]).expect("bundled");
        let wrong = [("supply.pressure".to_string(), OverrideValue::Text("much".into()))];
        assert_eq!(template.to_toml(&wrong).err(), template.build(&wrong).err());
    }
}
