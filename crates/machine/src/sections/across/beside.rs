//! Valves and lines between a cylinder and its valve or tank against the valve that feeds it.

use super::digits;
use crate::model::Machine;
use crate::number::Number;
use crate::reader::Reader;
use crate::sections::{on_a_side, Result};

/// Tables of valves and lines with a nominal flow at one side of a cylinder.
const TABLES: [&str; 7] =
    ["counterbalance", "pilot-check", "hose-burst", "port-relief", "crossover-relief", "anti-cavitation", "line"];
/// Times that two nominal flows of one section differ, each at a drop of its own; real ones differ by some three. A relief valve may be as
/// large as it likes: some are stated by their opening.
const APART: f64 = 20.0;

pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    for name in TABLES {
        for (_, table) in root.named_tables(name)? {
            let (index, _) = on_a_side::find(&table, &machine.cylinders)?;
            let valve = &machine.cylinders[index].valve;
            let (own, fed) = (table.optional_quantity::<f64>("nominal-flow")?, valve.nominal_flow.plain());
            let own = own.unwrap_or(fed);
            if own < fed / APART || (own > APART * fed && !name.ends_with("relief")) {
                table.required("nominal-flow", "a volume flow")?.warn(
                    format!(
                        "{} beside the {} l/min of valve.{}",
                        if own < fed { "small" } else { "large" },
                        digits(60e3 * fed),
                        valve.name
                    ),
                    "check the unit of both nominal flows: ml or l, per minute or second?".into(),
                );
            }
        }
    }
    Ok(())
}
