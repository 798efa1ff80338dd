//! The highest load pressure of a chamber, and whether the setting of its counterbalance valve is well above it.

use crate::crane::limits::in_words;
use crate::crane::workspace::forbidden;
use crate::crane::Crane;
use hydrocrane_machine::model::{HoldingKind, Unusual};

/// Least ratio of the setting of a counterbalance valve to the highest load pressure, as manufacturers recommend.
const MARGIN: f64 = 1.3;
/// Most poses that are checked, and most of them along one joint.
const POSES: usize = 2500;
const MOST: usize = 13;

/// A pressure (Pa) with its pose of rest.
#[derive(Clone, Copy)]
struct Loaded<const N: usize> {
    pressure: f64,
    q: [f64; N],
}

impl<const N: usize> Crane<N> {
    /// Settings of counterbalance valves below [`MARGIN`] times the highest pressure of a load at rest. Poses in which
    /// the supply cannot lift the load, or whose tip is where it must not be, are left out. Builds for the smallest chains only have no such valves.
    pub(crate) fn low_settings(&self) -> Vec<Unusual> {
        if !cfg!(feature = "chains") {
            return Vec::new();
        }
        let cylinders = self.machine.cylinders.iter().enumerate();
        let held = cylinders.flat_map(|(c, cylinder)| {
            let sides = cylinder.ports.holding.iter().enumerate();
            sides.filter_map(move |(side, valve)| match &valve.as_ref()?.kind {
                HoldingKind::Counterbalance(valve) => Some((c, side, valve)),
                _ => None,
            })
        });
        let held: Vec<_> = held.collect();
        if held.is_empty() {
            return Vec::new();
        }
        let highest = self.highest_pressures();
        let low = held.into_iter().filter_map(|(c, side, valve)| {
            let Loaded { pressure, q } = highest[c][side]?;
            let wanted = MARGIN * pressure;
            let pose = self.machine.joints.iter().zip(q).map(|(joint, q)| format!("{} {}", joint.name, in_words(joint, q)));
            (valve.setting < wanted).then(|| Unusual {
                key: valve.key.clone(),
                place: valve.place.to_string(),
                text: format!(
                    "low: {:.0} bar are below {MARGIN} times the highest load pressure, {:.0} bar with {} kg at the tip and {}",
                    valve.setting / 1e5,
                    pressure / 1e5,
                    self.machine.payload.mass,
                    pose.collect::<Vec<_>>().join(", ")
                ),
                cure: format!("set it to {:.0} bar, or carry less", (wanted / 1e5).ceil()),
            })
        });
        low.collect()
    }

    /// Highest pressure of a load at rest at the piston side and the rod side of each cylinder, with its pose, while the other side is
    /// at the pressure of the tank; `None` if no pose loads the side.
    fn highest_pressures(&self) -> [[Option<Loaded<N>>; 2]; N] {
        let limits = self.limit_pairs();
        let along = (2..=MOST).rev().find(|along| along.pow(N as u32) <= POSES).unwrap_or(2);
        let (supply, tank) = (self.plant().supply_pressures.supply, self.plant().supply_pressures.tank);
        let mut highest: [[Option<Loaded<N>>; 2]; N] = [[None; 2]; N];
        for number in 0..along.pow(N as u32) {
            let mut rest = number;
            let q = limits.map(|[lower, upper]| {
                let i = rest % along;
                rest /= along;
                lower + (upper - lower) * i as f64 / (along - 1) as f64
            });
            let tip = self.plant().tip_position(&self.plant().mechanics.pose(&q));
            if forbidden(&self.machine, [tip.x, tip.z]) {
                continue;
            }
            let forces = self.plant().static_force(&q, self.machine.payload.mass);
            for (c, (found, force)) in highest.iter_mut().zip(forces).enumerate() {
                let chambers = &self.plant().cylinders[c].chambers;
                let [a1, a2] = [chambers.area_1, chambers.area_2];
                let pressures = [(force + tank * a2) / a1, (tank * a1 - force) / a2];
                for (found, pressure) in found.iter_mut().zip(pressures) {
                    let higher = found.is_none_or(|most| pressure > most.pressure);
                    if higher && pressure > tank && pressure <= supply {
                        *found = Some(Loaded { pressure, q });
                    }
                }
            }
        }
        highest
    }
}
