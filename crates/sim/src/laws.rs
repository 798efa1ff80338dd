//! A crane's laws, its cylinders in lanes where the processor has registers for them. Either way the bits are the same.

use crate::bordered::Bordered;
use crate::cylinder_group::CylinderGroup;
use crate::cylinder_unit::{LocalRates, LocalState};
use crate::layout::Layout;
use crate::ledger::{powers, LEDGER_PER_CYLINDER};
use crate::plant::Plant;
use crate::rhs::Evaluator;
#[cfg(target_arch = "x86_64")]
use hydrocrane_num::register::Register;
use hydrocrane_num::{register::Handy, Lanes, Pack, Real};
use hydrocrane_physics::hydraulics::fluid::OilTables;

/// How the cylinders are arranged.
pub enum Laws<const N: usize> {
    /// As many side by side as the register has room for.
    Wide(Evaluator<f64, Lanes<Handy>, N>),
    /// One after the other.
    #[cfg(target_arch = "x86_64")]
    Single(Evaluator<f64, f64, N>),
}

/// What drives a crane at one state.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    pub layout: &'a Layout,
    pub x: &'a [f64],
    /// Spool commands, m.
    pub u: &'a [f64],
    /// At the tip, kg.
    pub payload: f64,
}

/// Where the powers of the ledger go, and the oil they are of.
pub struct Powers<'a> {
    pub oil: &'a OilTables,
    pub out: &'a mut [f64],
}

impl<const N: usize> Laws<N> {
    pub fn new(plant: &Plant<f64, N>, layout: &Layout) -> Self {
        #[cfg(target_arch = "x86_64")]
        if !Handy::is_available() {
            return Laws::Single(Evaluator::new(plant, layout));
        }
        Laws::Wide(Evaluator::new(plant, layout))
    }

    pub fn plant(&self) -> &Plant<f64, N> {
        match self {
            Laws::Wide(evaluator) => &evaluator.plant,
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => &evaluator.plant,
        }
    }

    /// Writes the state derivative, and the powers if they are wanted.
    pub fn derivative(&self, at: Moment, dx: &mut [f64], ledger: Option<Powers>) {
        match self {
            Laws::Wide(evaluator) => derivative(evaluator, at, dx, ledger),
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => derivative(evaluator, at, dx, ledger),
        }
    }

    /// Writes the state derivative with its slopes, and the powers with theirs if they are wanted.
    pub fn linearise(&self, at: Moment, dx: &mut [f64], ledger: Option<Powers>, slopes: &mut Bordered<f64>) {
        match self {
            Laws::Wide(evaluator) => linearise(evaluator, at, dx, ledger, slopes),
            #[cfg(target_arch = "x86_64")]
            Laws::Single(evaluator) => linearise(evaluator, at, dx, ledger, slopes),
        }
    }
}

fn derivative<L: Pack<f64>, const N: usize>(
    evaluator: &Evaluator<f64, L, N>,
    at: Moment,
    dx: &mut [f64],
    mut ledger: Option<Powers>,
) {
    L::apart(
        #[inline(always)]
        || {
            evaluator.derivative(at.layout, at.x, at.u, at.payload, dx, |group, s, rates| {
                let Some(ledger) = &mut ledger else { return };
                write_powers(group, &powers_of(ledger.oil, s, rates), ledger.out);
            });
        },
    );
}

fn linearise<L: Pack<f64>, const N: usize>(
    evaluator: &Evaluator<f64, L, N>,
    at: Moment,
    dx: &mut [f64],
    mut ledger: Option<Powers>,
    slopes: &mut Bordered<f64>,
) {
    let oil = ledger.as_ref().map(|powers| powers.oil);
    L::apart(
        #[inline(always)]
        || {
            evaluator.linearise(at.layout, at.x, at.u, at.payload, oil, dx, slopes, |group, powers| {
                let Some(ledger) = &mut ledger else { return };
                write_powers(group, powers, ledger.out);
            });
        },
    );
}

#[inline(always)]
fn powers_of<L: Real>(oil: &OilTables, s: &LocalState<L>, rates: &LocalRates<L>) -> [L; LEDGER_PER_CYLINDER] {
    L::apart(
        #[inline(always)]
        || powers([oil.energy_density(s.p1), oil.energy_density(s.p2)], s, rates),
    )
}

/// Writes the powers of a group of cylinders.
#[inline(always)]
fn write_powers<L: Pack<f64>>(group: &CylinderGroup<L>, powers: &[L; LEDGER_PER_CYLINDER], out: &mut [f64]) {
    for lane in 0..L::WIDTH {
        let Some(member) = group.member(lane) else { break };
        for (i, power) in powers.iter().enumerate() {
            out[member.cylinder * LEDGER_PER_CYLINDER + i] = power.lane(lane);
        }
    }
}
