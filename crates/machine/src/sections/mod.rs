//! One file per group of tables of a machine file. Each turns checked text into its part of the model.

mod accumulator;
mod across;
mod chain;
mod closure;
mod control;
mod cylinder;
mod errata;
mod fluid;
mod friction;
mod ground;
mod hose_leak;
mod joint;
mod keep_out;
mod line;
mod link;
mod load_holding;
mod metering;
pub mod on_a_side;
mod port_valves;
mod priority;
mod reference;
mod resistance;
mod return_pressure;
mod sensor;
mod signal_chain;
mod space;
mod supply;
mod tank_line;
mod valve;

pub use joint::coordinate;

use crate::errors::{ErrorKind, MachineError};
use crate::keys;
use crate::model::{Environment, Equilibrium, Machine};
use crate::number::{Number, Variable};
use crate::reading::reader::{Log, Reader};
use crate::text::document::Node;
use std::sync::Arc;

type Result<T> = std::result::Result<T, MachineError>;

/// Builds the machine that a merged tree describes, with derivatives by `variables` where numbers have them.
pub fn machine<T: Number>(tree: &Node, variables: &[Variable]) -> Result<Machine<T>> {
    let log = Log::new(true).with_variables(variables);
    let root = Reader::root(tree, keys::MACHINE, &log)?;
    let head = required_table(&root, "machine")?;

    // Chain order first: every index of the model follows it.
    let chain = chain::read(&root)?;
    let links = link::read(&chain)?;
    let joints = joint::read(&chain, &links)?;
    let fluid = fluid::read(&root)?;
    let cylinders = cylinder::read(&root, &chain, &links, &joints, &fluid)?;

    let mut supply = supply::read(&root)?;
    tank_line::read(&root, &fluid, &mut supply)?;
    priority::read(&root, &cylinders, &mut supply)?;

    let mut machine = Machine {
        name: head.name("name")?.into(),
        title: head.line("title")?.into(),
        description: head.text_or("description", "")?.into(),
        environment: Environment {
            gravity: required_table(&root, "environment")?.quantity("gravity")?,
            slope: slope(&root)?,
        },
        tip: reference::point(&head.required("tip", "a point as \"link.point\"")?, &links)?,
        fluid,
        supply,
        payload: ground::payload(&root)?,
        equilibrium: equilibrium(&root)?,
        errata: errata::read(&root, &cylinders)?,
        sensors: sensor::read(&root, &joints, &cylinders)?,
        keep_out: keep_out::read(&root)?,
        ground: ground::read(&root)?,
        control: control::read(&root, &joints)?,
        links,
        joints,
        cylinders,
        provenance: Arc::default(),
        words: Arc::default(),
        warnings: Vec::new(),
    };
    errata::check_printed_viscosity(&root, &machine)?;
    supply::check(&root, &machine)?;
    return_pressure::check(&root, &machine)?;
    priority::check(&root, &machine)?;
    space::check(&root, &machine)?;
    across::check(&root, &machine)?;
    machine.warnings = log.unusual();
    machine.words = log.words().into();
    machine.provenance = log.in_order_of(tree).into();
    Ok(machine)
}

/// A table that every machine has.
fn required_table<'a>(root: &Reader<'a>, key: &str) -> Result<Reader<'a>> {
    root.table(key)?.ok_or_else(|| root.missing(key, format!("add the table [{key}]")))
}

/// Steeper ground carries no machine, rad: 60 deg less what rounding in other units may take.
const STEEPEST: f64 = std::f64::consts::FRAC_PI_3 * (1.0 - 1e-9);

fn slope<T: Number>(root: &Reader) -> Result<T> {
    let table = required_table(root, "environment")?;
    let slope: T = table.quantity_or_default("slope")?;
    if slope.plain().abs() < STEEPEST {
        return Ok(slope);
    }
    let message = "60 deg or more: no machine stands on such ground";
    Err(table
        .error(ErrorKind::OutOfRange, "slope", message)
        .help("give the angle of the ground, for example \"10 deg\""))
}

fn equilibrium<T: Number>(root: &Reader) -> Result<Equilibrium<T>> {
    let table = root.table_or_empty("equilibrium")?;
    let stated = root.has("equilibrium");
    let key = "back-pressure";
    Ok(Equilibrium { back_pressure: if stated { table.quantity(key)? } else { table.quantity_or_default(key)? } })
}
