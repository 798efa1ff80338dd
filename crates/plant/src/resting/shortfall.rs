//! Sections that get less oil than their spools ask for.        theory: docs/theory/hydraulics/steady_circuit.md
//!
//! A section asks for what its edges pass at the present pressures of its ports with the mains where the pumps are set to keep
//! them. Before a spool compensator that is the set pressure; without one, and behind it, the regular fall of the pumps' control comes
//! off it. Where the load leaves less than the margin below the highest pressure, the mains count as if they kept the margin: the pumps
//! cut off there. Nothing is short while a pump still swivels out: it only lags.

use crate::cylinders::hydraulic_axis::SupplyPressures;
use crate::cylinders::supply::{Shares, Supply};
use crate::equations::plant::Plant;
use crate::layout::Layout;
use hydrocrane_physics::hydraulics::compensator::{Compensator, TAKEN_AT_THE_CORNER};

/// Share of the asked flow that may be missing: what rounded corners and lags of a healthy circuit take.
const MISSING: f64 = 0.05;
/// Share of the flow of all pumps below which a section asks for nothing.
const LEAST: f64 = 0.01;
/// Share of the displacement within which a swivel has arrived.
const ARRIVED: f64 = 0.02;

/// What keeps the oil from a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Another section is served first.
    Priority,
    /// The relief valve of the mains opens below what the pumps are set to.
    Relief,
    Torque,
    /// The engine slows down under its load.
    Engine,
    Displacement,
    /// The pressure falls by more than the margin before the pumps are at full displacement.
    ControlRange,
    /// The load leaves less than the margin below the highest pressure of the pumps.
    Pressure,
}

/// A section that gets less than its spool asks for, m^3/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shortfall {
    pub cylinder: usize,
    pub asked: f64,
    pub delivered: f64,
    pub limit: Limit,
    /// Where sections share the flow: share by which the rounded corner of the compensators shifts it between them; else zero.
    pub shifted: f64,
}

impl Shortfall {
    pub fn missing(&self) -> f64 {
        self.asked - self.delivered
    }
}

impl<const N: usize> Plant<f64, N> {
    /// In the state `x`.
    pub(crate) fn shortfalls(&self, layout: &Layout, x: &[f64]) -> Vec<Shortfall> {
        let Some((supply, at, e)) = self.supply_at(layout, x) else { return Vec::new() };
        let (set, _) = supply.setting_and_shortfall(&at, &e);
        let lags =
            || supply.pumps().zip(supply.settled_shares(&at)).zip(&e).any(|((_, wanted), e)| *e < wanted - ARRIVED);
        if at.supply >= set || lags() {
            return Vec::new();
        }
        let ranges = supply.pumps().filter_map(|of| of.control.as_ref());
        let range = ranges.map(|control| control.range).fold(0.0, f64::max);
        let fall = |margin: f64| range.min(0.5 * margin);
        let margins = supply.pumps().filter_map(|of| of.margin).chain(supply.sensing.map(|sensing| sensing.margin));
        // What the pumps would keep above the load if they were not cut off.
        let margin = margins.reduce(f64::max).filter(|margin| at.load + margin > set);
        let full: f64 = supply.pumps().map(|of| of.pump.displacement * of.pump.speed).sum();
        let mut cut_off = [false; N];
        let flows: [[f64; 3]; N] = hydrocrane_num::array::from_fn(|c| {
            let (unit, spool) = (&self.cylinders[c], x[layout.xs(c)]);
            let p = [x[layout.p1(c)], x[layout.p2(c)]];
            let present = unit.ports(&at, 0.0, p, layout.opening(c).map(|at| x[at]));
            let whole = matches!(unit.valve.compensator, Compensator::Before(_));
            // All that share the flow have the drop over the highest load.
            let load = match unit.valve.compensator {
                Compensator::Behind => at.load,
                _ => unit.valve.connection.signal(spool, [present.a, present.b], at.tank).min(at.load),
            };
            let mut kept = if whole { set } else { set - fall(set - at.load) };
            let wants = margin.map_or(kept, |margin| load + margin - if whole { 0.0 } else { fall(margin) });
            if wants > kept {
                (kept, cut_off[c]) = (wants, true);
            }
            let wanted = unit.ports(&SupplyPressures { supply: kept.max(at.supply), ..at }, 0.0, p, None);
            let delivered = unit.edge_flows(spool, &present).supply();
            [unit.valve.flows(spool, &wanted).supply(), delivered, unit.valve.flows(spool, &present).supply()]
        });
        let asked: f64 = flows.iter().map(|[asked, ..]| asked.max(0.0)).sum();
        let of_pumps = pump_limit(supply, &at, &e, asked);
        // The corner takes its part of the drop of the highest load alone, and flows go with the root of the drop.
        let left = (at.supply - at.load).max(TAKEN_AT_THE_CORNER);
        let shifted = 1.0 - (1.0 - TAKEN_AT_THE_CORNER / left).sqrt();
        let shares = |c: usize| matches!(self.cylinders[c].valve.compensator, Compensator::Behind);
        let short = |asked: f64, delivered: f64| asked > LEAST * full && asked - delivered > MISSING * asked;
        flows
            .iter()
            .enumerate()
            .filter(|(_, [asked, delivered, _])| short(*asked, *delivered))
            .filter(|(c, _)| !self.on_its_stop(layout, x, *c))
            .map(|(cylinder, &[asked, delivered, without_priority])| Shortfall {
                cylinder,
                asked,
                delivered: delivered.max(0.0),
                limit: match of_pumps {
                    _ if short(without_priority, delivered) => Limit::Priority,
                    Limit::ControlRange if cut_off[cylinder] => Limit::Pressure,
                    limit => limit,
                },
                shifted: if shares(cylinder) { shifted } else { 0.0 },
            })
            .collect()
    }

    /// Whether the spool of cylinder `c` presses its piston onto an end stop.
    fn on_its_stop(&self, layout: &Layout, x: &[f64], c: usize) -> bool {
        let q = hydrocrane_num::array::from_fn(|i| x[layout.q(i)]);
        let stroke = self.strokes(&self.mechanics.pose(&q))[c].0;
        self.cylinders[c].end_stop.force(stroke, 0.0).0 * x[layout.xs(c)] < 0.0
    }
}

/// What keeps the pumps from giving the flow `asked` (m^3/s) at these pressures and shares.
fn pump_limit(supply: &Supply<f64>, at: &SupplyPressures<f64>, e: &Shares<f64>, asked: f64) -> Limit {
    let reservoir = supply.reservoir(at.tank);
    let rise = at.supply - reservoir;
    let torque = supply.pumps().zip(e).any(|(of, e)| {
        let allowed =
            of.control.as_ref().map_or(f64::INFINITY, |control| control.by_torque(&of.pump, at.supply, reservoir));
        allowed < 1.0 && *e >= allowed - ARRIVED
    });
    let unloaded: f64 = supply.pumps().map(|of| of.pump.displacement * of.pump.speed - of.pump.leakage * rise).sum();
    let slowed = supply.pumps().any(|of| of.pump.droop > 0.0);
    if supply.given(at).1 > LEAST * unloaded {
        Limit::Relief
    } else if torque {
        Limit::Torque
    } else if supply.pumps().zip(e).any(|(_, e)| *e < 1.0 - ARRIVED) {
        Limit::ControlRange
    } else if slowed && asked <= unloaded {
        Limit::Engine
    } else {
        Limit::Displacement
    }
}
