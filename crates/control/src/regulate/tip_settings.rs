//! What tip control is set to.

use crate::estimate::chamber_estimate::Pressures;
use crate::reference::set_point::Shape;
use crate::regulate::damping::DampingGains;

#[derive(Debug, Clone, PartialEq)]
pub struct Settings<const N: usize> {
    /// s
    pub period: f64,
    /// Tip speed at full stick, m/s.
    pub full_speed: f64,
    /// Speeds of each piston at full lever, retracting and extending, m/s.
    pub lever_speeds: [[f64; 2]; N],
    pub shape: Shape<N>,
    pub drive: DriveGains,
    pub damping: DampingGains,
    /// Distance of the tip from its set-point at which the set-point waits, m.
    pub lag_limit: f64,
    /// Time after the set-point has stopped during which every error is still corrected, s.
    pub settling: f64,
}

hydrocrane_num::stored!([const N: usize] Settings<N> {
    period: f64,
    full_speed: f64,
    lever_speeds: [[f64; 2]; N],
    shape: Shape<N>,
    drive: DriveGains,
    damping: DampingGains,
    lag_limit: f64,
    settling: f64,
});

/// Gains of the drive; the same for every cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveGains {
    /// k_p, 1/s
    pub position: f64,
    /// Bandwidth of the position observer, rad/s.
    pub observer: f64,
    /// Corner of the low-pass on the pressures in the valve law, rad/s.
    pub pressure: f64,
    /// Share of the stroke that the reference may plan with.
    pub reserve: f64,
    /// Piston error that is corrected only slowly at rest, m.
    pub rest_band: f64,
    /// Time of motion over which is remembered what was learnt of the valve, s; zero: nothing is learnt.
    pub learning: f64,
    pub pressures: Pressures,
}

hydrocrane_num::stored!([] DriveGains {
    position: f64,
    observer: f64,
    pressure: f64,
    reserve: f64,
    rest_band: f64,
    learning: f64,
    pressures: Pressures,
});
