//! The tank line: oil, hoses, resistance and return filter.     theory: docs/theory/hydraulics/tank_line.md
//!
//! p_R' = (q_in - q) / (V/E(p_R) + C)        as the mains, see [`super::mains`]  Watton (2009), chapter 3
//! p_R - p_T = R q + K q |q| + f              line and filter in series, see [`super::line`]
//! q = f/R_f + g max(f - p_o, 0)              Darcy's law for the filter; the bypass as [`super::relief_valve`], not rounded
//!
//! | symbol | meaning | unit |
//! | p_R, p_T | pressures of the line and of the tank                          | Pa          |
//! | q_in, q  | flows into the line, and from it to the tank                   | m^3/s       |
//! | R, K     | laminar and turbulent coefficient of the line                  | Pa s/m^3, Pa s^2/m^6 |
//! | f, R_f   | drop over the filter, and its coefficient                      | Pa, Pa s/m^3 |
//! | p_o, g   | drop that opens the bypass valve, its flow per drop beyond it  | Pa, m^3/(s Pa) |
//!
//! Limits of validity: one pressure everywhere in the line, a filter whose drop is proportional to its flow, in both directions, a bypass
//! valve that follows at once.

use super::line::Resistance;
use super::mains::Mains;
use hydrocrane_num::Real;

parameters! {
    /// The bypass valve of a filter.
    pub struct Bypass {
        /// p_o, Pa
        pressure,
        /// g, m^3/(s Pa)
        gradient,
    }
}

/// A tank line.
#[derive(Debug, Clone, Copy)]
pub struct TankLine<T> {
    /// Its oil and hoses.
    pub volume: Mains<T>,
    /// p_T, Pa
    pub tank: T,
    /// R and K.
    pub resistance: Resistance<T>,
    /// R_f, Pa s/m^3; zero without a filter.
    pub filter: T,
    /// Only with a filter.
    pub bypass: Option<Bypass<T>>,
}

/// Flows to the tank, m^3/s, and the drop over the filter, Pa.
#[derive(Debug, Clone, Copy)]
pub struct Return<T> {
    pub whole: T,
    pub bypassed: T,
    pub filter_drop: T,
}

impl<T: Copy> TankLine<T> {
    /// The same with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> TankLine<U> {
        TankLine {
            volume: self.volume.map(f),
            tank: f(&self.tank),
            resistance: self.resistance.map(f),
            filter: f(&self.filter),
            bypass: self.bypass.as_ref().map(|bypass| bypass.map(f)),
        }
    }
}

impl<T: Real> TankLine<T> {
    /// What flows to the tank at the pressure `p` (Pa) of the line.
    #[inline(always)]
    pub fn flow(&self, p: T) -> Return<T> {
        let dp = p - self.tank;
        let through = self.in_series(self.filter).flow(dp);
        let drop = through * self.filter;
        let Some(Bypass { pressure, gradient }) = self.bypass else {
            return Return { whole: through, bypassed: T::c(0.0), filter_drop: drop };
        };
        // With an open bypass the drop over the filter is a straight line too.
        let both = T::c(1.0) / self.filter + gradient;
        let offset = gradient * pressure / both;
        let beyond = self.in_series(T::c(1.0) / both).flow(dp - offset);
        let closed = drop.le(pressure);
        let filter_drop = T::select(closed, drop, beyond / both + offset);
        Return {
            whole: T::select(closed, through, beyond),
            bypassed: T::select(closed, T::c(0.0), gradient * (filter_drop - pressure)),
            filter_drop,
        }
    }

    /// Pressure of the line, Pa, while `flow` (m^3/s) passes steadily.
    pub fn at_rest(&self, flow: T) -> T {
        let drop = flow * self.filter;
        let filter_drop = match self.bypass {
            Some(Bypass { pressure, gradient }) => {
                let open = (flow + gradient * pressure) / (T::c(1.0) / self.filter + gradient);
                T::select(drop.le(pressure), drop, open)
            }
            None => drop,
        };
        self.tank + self.resistance.drop(flow) + filter_drop
    }

    /// The line with a filter of this coefficient.
    #[inline(always)]
    fn in_series(&self, filter: T) -> Resistance<T> {
        Resistance { laminar: self.resistance.laminar + filter, ..self.resistance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    /// 60 l/min take 2 bar of the line and 1 bar of the filter, whose bypass opens at 1.5 bar.
    const LINE: TankLine<f64> = TankLine {
        volume: Mains { volume: 5e-3, compliance: 0.0 },
        tank: 0.5e5,
        resistance: Resistance { laminar: 1e8, turbulent: 1e11 },
        filter: 1e8,
        bypass: Some(Bypass { pressure: 1.5e5, gradient: 2e-8 }),
    };

    #[test]
    fn by_hand_the_drops_of_line_and_filter_add() {
        assert!((LINE.at_rest(1e-3) - 3.5e5).abs() < 1e-6);
        let flow = LINE.flow(3.5e5);
        assert!((flow.whole / 1e-3 - 1.0).abs() < 1e-12 && (flow.filter_drop - 1e5).abs() < 1e-6);
        assert_eq!(flow.bypassed, 0.0);
        // 2 bar over the filter: 2 l/s through it and 1 l/s through the bypass; 3 bar and 9 bar over the line.
        let (p, q) = (0.5e5 + 2e5 + 3e5 + 9e5, 3e-3);
        let flow = LINE.flow(p);
        assert!((flow.whole / q - 1.0).abs() < 1e-12 && (flow.bypassed / 1e-3 - 1.0).abs() < 1e-9, "{flow:?}");
        assert!((flow.filter_drop - 2e5).abs() < 1e-6 && (LINE.at_rest(q) - p).abs() < 1e-6);
    }

    #[test]
    fn value_joins_where_the_bypass_opens_and_slopes_are_those_of_differences() {
        let opens = LINE.at_rest(1.5e-3);
        let (before, after) = (LINE.flow(opens - 1e-3), LINE.flow(opens + 1e-3));
        assert!((after.whole - before.whole).abs() < 1e-11 && after.bypassed < 1e-10);
        let lifted = LINE.map(&mut |x| Dual::<f64, 1>::constant(*x));
        for p in [-0.3e5, 0.5e5, 0.6e5, 4e5, opens - 10.0, opens + 10.0, opens + 1e5, 30e5] {
            let of = lifted.flow(Dual::variable(p, 0)).whole;
            let by_difference = LINE.flow(p).whole - LINE.flow(p - 1.0).whole;
            assert!(of.finite() && of.derivative[0].finite());
            assert!((of.derivative[0] / by_difference - 1.0).abs() < 1e-4, "{p} {of:?} {by_difference}");
        }
    }

    #[test]
    fn without_a_filter_the_line_is_left_and_oil_flows_back_as_it_came() {
        let bare = TankLine { filter: 0.0, bypass: None, ..LINE };
        let flow = bare.flow(2.5e5);
        assert!((flow.whole / 1e-3 - 1.0).abs() < 1e-12 && flow.filter_drop == 0.0);
        assert_eq!(bare.flow(-1.5e5).whole, -flow.whole);
        assert_eq!(LINE.flow(LINE.tank).whole, 0.0);
    }
}
