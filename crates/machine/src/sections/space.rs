//! What a machine in space must state, and what it cannot have.

use crate::errors::ErrorKind;
use crate::model::Machine;
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;

pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let Some(joint) = machine.joints.iter().find(|joint| joint.axis.is_some()) else { return Ok(()) };
    let tables = root.named_tables("link")?;
    for link in &machine.links[1..] {
        let table = tables.iter().find(|(name, _)| *name == link.name).map(|(_, table)| table);
        if let (None, Some(table)) = (&link.solid, table) {
            let message = format!(
                "joint `{}` has an axis of its own, and nothing states how hard `{}` is to turn about x and z",
                joint.name, link.name
            );
            return Err(table.place.error(ErrorKind::MissingKey, &table.path, message).help(
                "give `inertia-x` and `inertia-z` beside every `inertia`; of a slender beam along x the first is about zero and the second as large as `inertia`",
            ));
        }
    }
    if machine.ground.is_some() {
        let message = format!("joint `{}` has an axis of its own, and the ground knows places x only", joint.name);
        return Err(root
            .error(ErrorKind::ConflictingKeys, "ground", message)
            .help("leave it out, or inherit it with status = \"inactive\": it is not modelled for machines that move in space"));
    }
    Ok(())
}
