//! What one cylinder's part of tip control keeps: its model, the shares of its low-passes, what it has seen and what it plans with.
//!                                                               theory: docs/theory/control/regulate.md

use crate::model::controller_model::CylinderModel;
use crate::model::feed_forward::{Capacity, Moment, Steady, SupplyPressures};
use crate::regulate::tip_settings::DriveGains;
use crate::valve::opening::Edges;
use hydrocrane_num::portable;
use hydrocrane_physics::hydraulics::fluid::Fluid;

/// The cylinder with its valve and its supply, and what follows from them once.
#[derive(Debug, Clone, Copy)]
pub struct DriveModel {
    pub cylinder: CylinderModel,
    pub fluid: Fluid<f64>,
    pub supply_pressures: SupplyPressures,
    pub steady: Steady,
    pub edges: Edges,
    /// Openings that commands reach, retracting and extending, as shares of the whole.
    pub reach: [f64; 2],
    /// Friction at the start of a motion, retracting and extending, N.
    pub starting_friction: [f64; 2],
    /// Force that the reference leaves for corrections, N.
    pub spare: f64,
}

/// Share of the forces between full pressure on the one side and on the other that the reference leaves for corrections.
const SPARE: f64 = 0.04;
/// Speed at which friction is taken when asking how fast a piston could be, m/s.
const FRICTION_SPEED: f64 = 0.01;

impl DriveModel {
    pub fn new(cylinder: CylinderModel, fluid: Fluid<f64>, supply_pressures: SupplyPressures, steady: Steady) -> Self {
        DriveModel {
            cylinder,
            fluid,
            supply_pressures,
            steady,
            edges: Edges::of(&cylinder),
            reach: [-1.0, 1.0].map(|sense| cylinder.reach(sense)),
            starting_friction: [-FRICTION_SPEED, FRICTION_SPEED].map(|v| cylinder.steady_friction(v)),
            spare: SPARE * steady.span(),
        }
    }
}

/// Corner of the low-pass on the difference between the load and the planned one, rad/s.
const LOAD_BANDWIDTH: f64 = 5.0;
/// Rate at which the speed to plan with falls, rad/s.
pub const RANGE_RATE: f64 = 5.0;
/// Corner of the low-pass on the growth of a load, rad/s.
const GROWTH_RATE: f64 = 10.0;
/// Rate at which the speed to plan with comes back, rad/s.
const RETURN_RATE: f64 = 2.0;
/// Corner of the low-pass on the speeds at the measured pressures, rad/s.
const MOMENTARY_RATE: f64 = 20.0;

/// Shares by which low-passes go on in a period.
#[derive(Debug, Clone, Copy)]
pub struct Shares {
    pub pressure: f64,
    pub load: f64,
    /// Share by which the speed to plan with may fall, and by which it comes back.
    pub range: f64,
    pub back: f64,
    pub growth: f64,
    pub momentary: f64,
}

impl Shares {
    pub fn new(gains: &DriveGains, period: f64) -> Self {
        let share = |corner: f64| 1.0 - portable::exp(-corner * period);
        Shares {
            pressure: share(gains.pressure),
            load: share(LOAD_BANDWIDTH),
            range: share(RANGE_RATE),
            back: share(RETURN_RATE),
            growth: share(GROWTH_RATE),
            momentary: share(MOMENTARY_RATE),
        }
    }
}

/// What the samples have shown.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Low-passed pressures with the measured position, and what they allow.
    pub moment: Moment,
    pub capacity: Capacity,
    /// Speed with closed edges that is made up for, m/s: behind a low-pass, since what leaks also damps the modes on the oil.
    pub leaks: f64,
    /// Cylinder force, N.
    pub force: f64,
    /// Displacement that the oil has given since the start, m.
    pub given: f64,
    /// Resolution of the measured position, m.
    pub count: f64,
    /// Lowest natural frequency of the crane on its oil, rad/s.
    pub slowest: f64,
    /// Observed piston speed, m/s.
    pub speed: f64,
    /// Friction without its viscous part of the piston as observed, N.
    pub seal: f64,
}

impl Seen {
    pub fn at(moment: Moment, capacity: Capacity, force: f64) -> Self {
        Seen {
            moment,
            leaks: capacity.closed,
            capacity,
            force,
            given: 0.0,
            count: 0.0,
            slowest: f64::INFINITY,
            speed: 0.0,
            seal: 0.0,
        }
    }
}

/// What the reference asked for last, and what it may plan with.
#[derive(Debug, Clone, Copy, Default)]
pub struct Plan {
    /// Planned load of the last sample, N, and behind a low-pass how fast it grows, N/s.
    pub load: f64,
    pub growth: f64,
    /// Planned friction without its viscous part, N.
    pub dry_friction: f64,
    /// Speed that the reference asked for, and speeds that it may plan with, m/s.
    pub asked: f64,
    pub range: [f64; 2],
    /// Speeds at full stroke and the pressures of the last samples, m/s: one wrong pressure is no shortage.
    pub momentary: [f64; 2],
}
