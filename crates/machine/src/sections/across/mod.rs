//! Judgement across values: each may be usual alone and impossible beside the others. Every bound is one of matter or of a
//! stated promise, far enough from real machines that factors of 1000, or of 10 where a bound is sharp, are what it finds.

mod beside;
mod cylinder;
mod friction;
mod mass;
mod twins;
mod valve;
mod whole;

use crate::model::{Cylinder, JointKind, Machine};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::Result;
use std::f64::consts::PI;

/// A value that was found alone, in a table or in what it is compared with, would be blamed on others: these are left out until
/// it is right.
pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    hanging(root, machine)?;
    mass::check(root, machine)?;
    let common = ["fluid", "supply"].map(|key| root.table_or_empty(key));
    if common.into_iter().collect::<Result<Vec<_>>>()?.iter().any(Reader::is_doubted) {
        return Ok(());
    }
    beside::sections(root, machine)?;
    whole::check(root, machine)?;
    let [cylinders, valves, frictions] = ["cylinder", "valve", "friction"].map(|key| root.named_tables(key));
    let [cylinders, valves, frictions] = [cylinders?, valves?, frictions?];
    let mut axes = Vec::new();
    for of in &machine.cylinders {
        // Exactly one friction table names the cylinder.
        let rubs = |table: &Reader| table.text("cylinder").is_ok_and(|name| name == of.name);
        let cylinder = cylinders.iter().find(|(name, _)| *name == of.name);
        let valve = valves.iter().find(|(name, _)| *name == of.valve.name);
        let friction = frictions.iter().find(|(_, table)| rubs(table));
        let (Some((_, cylinder)), Some((_, valve)), Some((_, friction))) = (cylinder, valve, friction) else {
            continue;
        };
        axes.push(Axis { of, sizes: Sizes::new(machine, of), cylinder, valve, friction });
    }
    for axis in axes.iter().filter(|axis| !axis.is_doubted()) {
        cylinder::shape(axis.cylinder, machine, axis.of, &axis.sizes)?;
    }
    beside::strokes(&axes)?;
    for axis in axes.iter().filter(|axis| !axis.is_doubted()) {
        cylinder::check(axis.cylinder, machine, axis.of, &axis.sizes)?;
        valve::check(axis.valve, axis.of, &axis.sizes)?;
        friction::check(axis.friction, axis.of, &axis.sizes)?;
    }
    twins::check(root)
}

/// A cylinder with its tables.
struct Axis<'a, T> {
    of: &'a Cylinder<T>,
    sizes: Sizes,
    cylinder: &'a Reader<'a>,
    valve: &'a Reader<'a>,
    friction: &'a Reader<'a>,
}

impl<T> Axis<'_, T> {
    fn is_doubted(&self) -> bool {
        [self.cylinder, self.valve, self.friction].into_iter().any(Reader::is_doubted)
    }
}

/// What the checks of a cylinder have in common, plain and in SI: of one of those in parallel.
struct Sizes {
    bore: f64,
    rod: f64,
    stroke: f64,
    /// Of the piston side and the rod side, m^2.
    areas: [f64; 2],
    /// Supply pressure above that of the tank, Pa.
    pressure: f64,
    /// Its share of what the valve takes at full stroke without a load, m^3/s.
    asked: f64,
    /// The same, but no more than the pumps give.
    flow: f64,
    /// Its share of the nominal flow of the valve, m^3/s.
    nominal_flow: f64,
}

impl Sizes {
    fn new<T: Number>(machine: &Machine<T>, of: &Cylinder<T>) -> Self {
        let [bore, rod, stroke] = [of.bore, of.rod_diameter, of.stroke].map(T::plain);
        let pressure = machine.supply.pressure.plain() - machine.supply.tank_pressure.plain();
        let count = of.count.plain();
        let asked = super::supply::asked(machine, &of.valve);
        let given =
            machine.supply.mains.as_ref().map_or(asked, |mains| super::supply::given(&machine.supply, mains, true));
        let areas = [bore * bore, bore * bore - rod * rod].map(|square| 0.25 * PI * square);
        let [asked, flow, nominal_flow] =
            [asked, asked.min(given), of.valve.nominal_flow.plain()].map(|of_all| of_all / count);
        Self { bore, rod, stroke, areas, pressure, asked, flow, nominal_flow }
    }

    /// Of the piston at full stroke of the valve, m/s.
    fn speed(&self) -> f64 {
        self.flow / self.areas[0]
    }

    /// Of the supply on the piston, N.
    fn force(&self) -> f64 {
        self.pressure * self.areas[0]
    }
}

/// A load that hangs below the tip touches only a ground.
fn hanging<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let hangs = machine.payload.hang.plain() > 0.0 || machine.payload.hang_growth.plain() > 0.0;
    let Some(table) = root.table("payload")?.filter(|_| hangs && machine.ground.is_none()) else { return Ok(()) };
    let key = if machine.payload.hang.plain() > 0.0 { "hang" } else { "hang-growth" };
    table.required(key, "a length")?.warn(
        "without effect: the machine has no ground that the load could touch".into(),
        "add `[ground]` with its `height`, or leave the key out".into(),
    );
    Ok(())
}

/// Length that the child of a joint slides, m.
fn slides<T: Number>(machine: &Machine<T>, link: usize) -> f64 {
    let joint = link.checked_sub(1).map(|joint| (&machine.joints[joint].kind, &machine.cylinders[joint]));
    joint.map_or(0.0, |(kind, cylinder)| match kind {
        JointKind::Prismatic { .. } => cylinder.stroke.plain(),
        JointKind::Revolute(_) => 0.0,
    })
}

/// Three digits, for people.
fn digits(number: f64) -> String {
    let magnitude = if number == 0.0 { 0.0 } else { libm::floor(libm::log10(number.abs())) };
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{number:.2e}");
    }
    let places = (2.0 - magnitude).max(0.0) as usize;
    format!("{number:.places$}")
}
