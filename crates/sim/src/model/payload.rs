//! Changes of the payload: the payload against time, and the effect of each change on the state and on the energy
//! account.
//!
//! Picking up a load at rest is an impact (`hydrocrane_physics::dynamics::attachment`); releasing one does not change
//! the state. theory: docs/theory/simulation.md

use crate::model::Model;

/// The payload is `mass` (kg) from `time` (s) on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PayloadChange {
    pub time: f64,
    pub mass: f64,
}

/// Effect of a change of the payload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PayloadEvent {
    /// s
    pub time: f64,
    /// Payload before and after, kg.
    pub mass: [f64; 2],
    /// Velocity (x, y, z) of the tip before and after, m/s, and along which of these it moves.
    pub tip_velocity: [[f64; 3]; 2],
    pub tip_axes: &'static [usize],
    /// Kinetic energy that became heat, J.
    pub loss: f64,
    /// Mechanical energy of the load, J; negative for a release.
    pub brought: f64,
}

/// Name, meaning and sign in the balance of the account's terms.
pub const PAYLOAD_TERMS: [(&str, &str, f64); 2] = [
    ("load", "energy of loads picked up minus energy of loads released", 1.0),
    ("impact", "heat of picking up loads at rest", -1.0),
];

/// The loads of one run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Loads {
    /// Ascending; entries before `next` are done.
    changes: Vec<PayloadChange>,
    next: usize,
    pub events: Vec<PayloadEvent>,
    /// Energies since the start, J, in the order of [`PAYLOAD_TERMS`].
    pub account: [f64; 2],
}

/// Rounding tolerance between the time of a change and the present time, s.
const ROUNDING: f64 = 1e-12;

impl Loads {
    pub fn new(changes: &[PayloadChange]) -> Self {
        Loads { changes: changes.to_vec(), ..Loads::default() }
    }

    /// Adds a change after all others.
    pub fn add(&mut self, change: PayloadChange) {
        self.changes.push(change);
    }

    /// Removes all future changes.
    pub fn forget(&mut self) {
        self.changes.truncate(self.next);
    }

    /// Number of changes that have happened.
    pub fn done(&self) -> usize {
        self.next
    }

    /// Time of the next change.
    pub fn next_time(&self) -> Option<f64> {
        self.changes.get(self.next).map(|change| change.time)
    }

    /// Whether a change is due at `now`.
    pub fn are_due(&self, now: f64) -> bool {
        self.next_time().is_some_and(|time| time <= now + ROUNDING)
    }

    /// Executes the changes that are due at `now` on state `x` and the present `payload`; returns whether there were
    /// any.
    pub fn come_and_go(&mut self, model: &dyn Model, now: f64, x: &mut [f64], payload: &mut f64) -> bool {
        let first = self.next;
        while self.are_due(now) {
            let change = self.changes[self.next];
            let event = change_payload(model, now, x, [*payload, change.mass]);
            *payload = change.mass;
            self.account[0] += event.brought;
            self.account[1] += event.loss;
            self.events.push(event);
            self.next += 1;
        }
        self.next > first
    }
}

/// Whether a load is picked up where the payload changes from the first to the second mass: joint rates jump. Otherwise
/// the state stays as it is.
pub(crate) fn picks_up(mass: [f64; 2]) -> bool {
    mass[1] > mass[0]
}

/// Changes the payload of state `x` from the first to the second mass.
pub fn change_payload(model: &dyn Model, time: f64, x: &mut [f64], mass: [f64; 2]) -> PayloadEvent {
    let n = model.layout().joints();
    let (q, rest) = x.split_at_mut(model.layout().qd(0));
    let qd = &mut rest[..n];
    let load = mass[1] - mass[0];
    let before = model.tip_velocity(q, qd);
    let mut loss = 0.0;
    if picks_up(mass) {
        let mut rates = vec![0.0; n];
        loss = model.attach(q, qd, mass[0], load, &mut rates);
        qd.copy_from_slice(&rates);
    }
    // The depth in the ground depends on the load at the tip.
    let potential = |payload: f64| model.energies(q, &vec![0.0; n], payload).1 + model.ground_energy(q, payload);
    // A load that is picked up is at rest; a released one has the tip's velocity.
    let carried_off = 0.5 * (-load).max(0.0) * before.iter().fold(0.0, |sum, v| sum + v * v);
    let brought = potential(mass[1]) - potential(mass[0]) - carried_off;
    let tip_velocity = [before, model.tip_velocity(q, qd)];
    PayloadEvent { time, mass, tip_velocity, tip_axes: model.tip_axes(), loss, brought }
}

/// The reason if a payload cannot change like this.
pub(crate) fn fault(changes: &[PayloadChange]) -> Option<String> {
    if let Some(change) = changes.iter().find(|c| !(c.mass.is_finite() && c.mass >= 0.0)) {
        return Some(format!("a payload of {} kg at {} s; it must be zero or greater", change.mass, change.time));
    }
    let times: Vec<f64> = std::iter::once(0.0).chain(changes.iter().map(|c| c.time)).collect();
    let back = times.windows(2).find(|pair| !(pair[1].is_finite() && pair[1] > pair[0]))?;
    Some(format!("the payload changes at {} s after {} s; its times must be positive and increasing", back[1], back[0]))
}
