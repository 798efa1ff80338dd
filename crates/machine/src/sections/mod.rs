//! One file per group of tables of a machine file. Each turns checked text into its part of the model.

mod chain;
mod closure;
mod control;
mod cylinder;
mod errata;
mod fluid;
mod friction;
mod ground;
mod joint;
mod keep_out;
mod link;
mod reference;
mod sensor;
mod signal_chain;
mod valve;

pub use control::{CONTROLLERS, PLAUSIBILITY};
pub use joint::coordinate;

use crate::document::Node;
use crate::errors::MachineError;
use crate::model::{Equilibrium, Machine};
use crate::quantities;
use crate::reader::{Log, Reader, Sign};

type Result<T> = std::result::Result<T, MachineError>;

const ROOT_KEYS: [&str; 18] = [
    "extends",
    "include",
    "machine",
    "environment",
    "link",
    "joint",
    "cylinder",
    "valve",
    "friction",
    "fluid",
    "supply",
    "payload",
    "equilibrium",
    "sensor",
    "keep-out",
    "ground",
    "control",
    "errata",
];

/// Gauge pressure of the chamber that carries less at rest, where the file states none, Pa.
const DEFAULT_BACK_PRESSURE: f64 = 10e5;

/// Builds the machine that a merged tree describes.
pub fn machine(tree: &Node) -> Result<Machine> {
    let log = Log::new(true);
    let root = Reader::open(tree, String::new(), Some(&ROOT_KEYS), &log)?;
    let head = required_table(&root, "machine", &["name", "title", "description", "tip"])?;

    // Chain order first: every index of the model follows it.
    let chain = chain::read(&root)?;
    let links = link::read(&chain)?;
    let joints = joint::read(&chain, &links)?;
    let cylinders = cylinder::read(&root, &chain, &links, &joints)?;

    let mut machine = Machine {
        name: head.text("name")?.into(),
        title: head.text_or("title", "")?.into(),
        description: head.text_or("description", "")?.into(),
        gravity: gravity(&root)?,
        tip: reference::point(&head.required("tip", "a point as \"link.point\"")?, &links)?,
        fluid: fluid::read(&root)?,
        supply: fluid::supply(&root)?,
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
        provenance: Vec::new(),
        warnings: Vec::new(),
    };
    errata::check_printed_viscosity(&root, &machine)?;
    machine.provenance = log.in_order_of(tree);
    machine.warnings = log.unusual();
    Ok(machine)
}

/// A table that every machine has.
fn required_table<'a>(root: &Reader<'a>, key: &'static str, known: &[&str]) -> Result<Reader<'a>> {
    root.table(key, known)?.ok_or_else(|| root.missing(key, format!("add the table [{key}]")))
}

fn gravity(root: &Reader) -> Result<f64> {
    required_table(root, "environment", &["gravity"])?.quantity(
        "gravity",
        &quantities::acceleration(),
        Sign::NonNegative,
    )
}

fn equilibrium(root: &Reader) -> Result<Equilibrium> {
    let table = root.table("equilibrium", &["back-pressure"])?;
    let pressure =
        table.map(|table| table.quantity("back-pressure", &quantities::pressure(), Sign::NonNegative)).transpose()?;
    Ok(Equilibrium { back_pressure: pressure.unwrap_or(DEFAULT_BACK_PRESSURE) })
}
