//! Control of the crane tip: one stick, all cylinders, a straight path.  theory: docs/theory/control/tip.md
//!
//! Per sample: pressures and positions -> [`Drive`] (observer, speeds the valves can give now) -> [`Reference`]
//! (set-point, redundancy, scaling that keeps the direction) -> nominal load forces -> spool commands.

use crate::controller::{Controller, Fault, Measurement, Stick};
use crate::drive::{Demand, Drive, DriveGains};
use crate::feed_forward::{Mains, Moment};
use crate::nominal::{Nominal, Posture};
use crate::set_point::{Reference, Shape};
use crate::slow_down::{checked, checked_stick};
use crate::standstill::{Cause, Standstill};
use hydrocrane_num::Vec2;

#[derive(Debug, Clone, PartialEq)]
pub struct Settings<const N: usize> {
    /// s
    pub period: f64,
    /// Tip speed at full stick, m/s.
    pub full_speed: f64,
    pub shape: Shape<N>,
    pub drive: DriveGains,
    /// Distance of the tip from its set-point at which the set-point waits, m.
    pub lag_limit: f64,
    /// Time after the set-point has stopped during which every error is still corrected, s.
    pub settling: f64,
}

pub struct Tip<const N: usize> {
    nominal: Nominal<N>,
    settings: Settings<N>,
    state: Option<State<N>>,
}

struct State<const N: usize> {
    reference: Reference<N>,
    drives: [Drive; N],
    /// Since the set-point stopped, s.
    still: f64,
    standstill: Standstill,
    /// Why the tip stands, if that is news.
    news: Option<Cause>,
}

/// Share of the speed asked for that counts as nothing left of it.
const BLOCKED: f64 = 0.1;

impl<const N: usize> Tip<N> {
    pub fn new(nominal: Nominal<N>, settings: Settings<N>) -> Self {
        Tip { nominal, settings, state: None }
    }
}

impl<const N: usize> State<N> {
    /// At rest, as first measured.
    fn at(n: &Nominal<N>, s: &Settings<N>, q: [f64; N], p: &[[f64; 2]; N]) -> Self {
        let reference = Reference::at(n, &s.shape, s.period, q);
        let load = n.cylinder_force(&q, &[0.0; N]);
        let mains = Mains { supply: n.supply, tank: n.tank };
        let drives = std::array::from_fn(|c| {
            let moment = Moment { stroke: reference.posture.stroke[c], p: p[c] };
            Drive::at(n.cylinders[c], n.fluid, mains, s.drive, s.period, moment, load[c])
        });
        State { reference, drives, still: s.settling, standstill: Standstill::default(), news: None }
    }

    /// Joint coordinates as observed.
    fn observed(&self, q: &[f64; N], measured: &Posture<N>) -> [f64; N] {
        std::array::from_fn(|i| {
            let turned = (self.drives[i].position() - measured.stroke[i]) / measured.gain[i];
            if turned.is_finite() {
                q[i] + turned
            } else {
                q[i]
            }
        })
    }

    /// 1 with the tip at its set-point, 0 with the tip too far behind.
    fn governor(&self, q: &[f64; N], measured: &Posture<N>, observed: &[f64; N], lag_limit: f64) -> f64 {
        // Observed and measured lie within a count of the sensor: the Jacobian takes one to the other.
        let tip: [f64; 2] = std::array::from_fn(|r| {
            measured.tip[r] + (0..N).map(|i| measured.jacobian[r][i] * (observed[i] - q[i])).sum::<f64>()
        });
        let lag = (Vec2::<f64>::c(self.reference.set_point) - Vec2::c(tip)).norm();
        (2.0 - 2.0 * lag / lag_limit).clamp(0.0, 1.0)
    }

    /// Finds out why the tip stands though it is told to move at `wish`, m/s.
    fn look_for_standstill(&mut self, s: &Settings<N>, wish: [f64; 2], waiting: f64) {
        let asked = Vec2::<f64>::c(wish).norm();
        if !self.standstill.watch(asked, self.reference.pace, s.period) {
            return;
        }
        let open = Vec2::<f64>::c(s.shape.keep_out.slowed(self.reference.set_point, wish)).norm();
        self.news = Some(if waiting < BLOCKED {
            Cause::Lag
        } else if open < BLOCKED * asked {
            Cause::Region
        } else {
            Cause::Range
        });
    }

    fn step(
        &mut self,
        nominal: &Nominal<N>,
        s: &Settings<N>,
        q: &[f64; N],
        p: &[[f64; 2]; N],
        wish: [f64; 2],
    ) -> [f64; N] {
        let measured = nominal.posture(q);
        for c in 0..N {
            self.drives[c].measure(&Moment { stroke: measured.stroke[c], p: p[c] });
        }
        self.still = if self.reference.moving(wish) { 0.0 } else { self.still + s.period };
        let rest = self.still >= s.settling;
        let target: [f64; N];
        if rest {
            target = nominal.strokes(&self.reference.q).map(|(stroke, _)| stroke);
            self.reference.stand();
        } else {
            let observed = self.observed(q, &measured);
            let waiting = self.governor(q, &measured, &observed, s.lag_limit);
            let ranges = std::array::from_fn(|c| self.drives[c].range());
            self.reference.advance(nominal, &s.shape, wish.map(|w| w * waiting), &observed, &ranges);
            self.look_for_standstill(s, wish, waiting);
            target = self.reference.posture.stroke;
        }
        let rates = self.reference.rates;
        let load = nominal.cylinder_force(&self.reference.q, &rates);
        std::array::from_fn(|c| {
            let speed = self.reference.posture.gain[c] * rates[c];
            self.drives[c].command(&Demand { stroke: target[c], speed, load: load[c], rest })
        })
    }
}

impl<const N: usize> Controller for Tip<N> {
    fn period(&self) -> f64 {
        self.settings.period
    }

    fn reset(&mut self, first: &Measurement) {
        self.state = checked::<N>(first).ok().map(|(q, p)| State::at(&self.nominal, &self.settings, q, &p));
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        let (q, p) = checked::<N>(measured)?;
        let wish = checked_stick(stick)?.map(|s| s * self.settings.full_speed);
        let state = self.state.get_or_insert_with(|| State::at(&self.nominal, &self.settings, q, &p));
        let command = state.step(&self.nominal, &self.settings, &q, &p, wish);
        if command.iter().any(|u| !u.is_finite()) {
            self.state = None;
            return Err(Fault::Failed("the spool command is not a finite number; tip control starts anew".to_string()));
        }
        for (out, u) in spool.iter_mut().zip(command) {
            *out = u;
        }
        Ok(())
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        self.state.as_ref().map(|s| s.reference.set_point)
    }

    fn notices(&mut self) -> Vec<String> {
        let news = self.state.as_mut().and_then(|state| state.news.take());
        news.into_iter().map(|cause| cause.text().to_string()).collect()
    }
}
