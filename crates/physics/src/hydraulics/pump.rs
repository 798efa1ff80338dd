//! Pump with its losses and its control.                       theory: docs/theory/hydraulics/pump.md
//!
//! Q = e D w - k dp                 flow into the mains                                     Wilson (1946)
//! M = D dp (e + c)                 torque of the shaft
//! w = max(0, w_0 - s M)            speed of the shaft under its load
//! P = w M = dp Q + k dp^2 + c w D dp     power of the shaft: delivered, leaked, rubbed away
//!
//! | symbol | meaning | unit |
//! | e      | displacement in use, 0 to 1; a fixed pump has 1           | -          |
//! | D      | displacement per angle, that per revolution over 2 pi     | m^3/rad    |
//! | w, w_0 | speed of the shaft, and without a load                    | rad/s      |
//! | s      | droop of the engine: fall of speed per torque, 0 where the speed is constant | rad/(s N m) |
//! | dp     | pressure rise from the tank to the mains                  | Pa         |
//! | k      | conductance of the leakage, from the volumetric efficiency at the set pressure and the rated speed: (1 - eta_v) D w_r / dp_set |
//! | c      | torque of mechanical loss, from the hydromechanical efficiency at full displacement: 1/eta_hm - 1                   |
//!
//! A controlled pump turns its swivel towards what its control asks for, with one time constant:
//!     e' = (e_wanted - e)/T,    e_wanted = min(1, (p_set - p)/p_range, M_max/(D dp) - c), not below 0.
//! p_set is constant, or follows the load ([`super::load_sensing`]).
//!
//! Limits of validity: losses are linear in pressure (no cavitation of the suction, no compressibility within the pump), the
//! engine follows its load at once, and the leakage does not depend on the displacement.

use hydrocrane_num::Real;

parameters! {
    pub struct Pump {
        /// m^3/rad
        displacement,
        /// w_0, rad/s
        speed,
        /// s, rad/(s N m)
        droop,
        /// m^3/(s Pa)
        leakage,
        /// Torque of mechanical loss as a share of D dp.
        mechanical_loss,
    }
}

parameters! {
    /// Control of the displacement by the pressure of the mains.
    pub struct PressureControl {
        /// Fall of pressure below the set one that brings full displacement, Pa.
        range,
        /// s
        time_constant,
        /// Largest torque of the shaft, N m; infinite: no limit.
        torque_limit,
    }
}

/// Pressure rise below which a limit of torque is that at this pressure, Pa: there it limits nothing.
const LEAST_RISE: f64 = 1e3;

impl<T: Real> Pump<T> {
    /// Flow without losses at full displacement, m^3/s, at a share `e` of the displacement and the pressure rise `dp` (Pa).
    #[inline(always)]
    pub fn full_flow(&self, e: T, dp: T) -> T {
        self.displacement * self.shaft_speed(e, dp)
    }

    /// rad/s
    #[inline(always)]
    pub fn shaft_speed(&self, e: T, dp: T) -> T {
        (self.speed - self.droop * (self.displacement * dp * (e + self.mechanical_loss))).max(T::c(0.0))
    }

    /// Flow into the mains, m^3/s, at a share `e` of the displacement and the pressure rise `dp` (Pa).
    #[inline(always)]
    pub fn flow(&self, e: T, dp: T) -> T {
        e * self.full_flow(e, dp) - self.leakage * dp
    }

    /// Power of the shaft, W.
    #[inline(always)]
    pub fn shaft_power(&self, e: T, dp: T) -> T {
        self.full_flow(e, dp) * dp * (e + self.mechanical_loss)
    }

    /// Powers lost by leakage and by mechanical loss, W.
    #[inline(always)]
    pub fn losses(&self, e: T, dp: T) -> (T, T) {
        (self.leakage * dp.square(), self.full_flow(e, dp) * dp * self.mechanical_loss)
    }
}

impl<T: Real> PressureControl<T> {
    /// Rate of the share of the displacement, 1/s, at the pressure `p` of the mains, which is `set` at zero displacement, and
    /// `tank` (Pa).
    #[inline(always)]
    pub fn swivel_rate(&self, pump: &Pump<T>, e: T, p: T, set: T, tank: T) -> T {
        (self.wanted(pump, p, set, tank) - e) / self.time_constant
    }

    /// The share of the displacement that is asked for, likewise.
    #[inline(always)]
    pub fn wanted(&self, pump: &Pump<T>, p: T, set: T, tank: T) -> T {
        let by_pressure = (set - p) / self.range;
        by_pressure.min(self.by_torque(pump, p, tank)).clamp(T::c(0.0), T::c(1.0))
    }

    /// The share of the displacement that takes the largest torque; it may be above 1 or below 0.
    #[inline(always)]
    pub fn by_torque(&self, pump: &Pump<T>, p: T, tank: T) -> T {
        self.torque_limit / (pump.displacement * (p - tank).max(T::c(LEAST_RISE))) - pump.mechanical_loss
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: f64 = 45e-6 / core::f64::consts::TAU * 157.0;

    fn pump() -> Pump<f64> {
        Pump {
            displacement: 45e-6 / core::f64::consts::TAU,
            speed: 157.0,
            droop: 0.0,
            leakage: 0.05 * FULL / 210e5,
            mechanical_loss: 0.08,
        }
    }

    /// 8 % of the speed at 150 N m.
    fn on_an_engine() -> Pump<f64> {
        Pump { droop: 0.08 * 157.0 / 150.0, ..pump() }
    }

    #[test]
    fn an_engine_slows_down_under_its_load_and_stalls_at_last() {
        let pump = on_an_engine();
        assert_eq!(pump.shaft_speed(0.7, 0.0), 157.0);
        // The pressure at which the pump takes 150 N m at full displacement.
        let dp = 150.0 / (pump.displacement * 1.08);
        assert!((pump.shaft_speed(1.0, dp) / 157.0 - 0.92).abs() < 1e-12);
        assert!((pump.shaft_power(1.0, dp) - 150.0 * 0.92 * 157.0).abs() < 1e-6);
        assert_eq!(pump.shaft_speed(1.0, 100.0 * dp), 0.0);
    }

    #[test]
    fn at_the_set_pressure_the_efficiencies_are_those_of_the_data_sheet() {
        let (pump, dp) = (pump(), 210e5);
        assert!((pump.flow(1.0, dp) / FULL - 0.95).abs() < 1e-12);
        let hydromechanical = FULL * dp / pump.shaft_power(1.0, dp);
        assert!((hydromechanical - 1.0 / 1.08).abs() < 1e-12);
    }

    #[test]
    fn what_the_shaft_gives_is_delivered_or_lost() {
        for pump in [pump(), on_an_engine()] {
            for (e, dp) in [(1.0, 150e5), (0.3, 200e5), (0.0, 210e5), (0.5, 0.0)] {
                let (leaked, rubbed) = pump.losses(e, dp);
                let gap = pump.shaft_power(e, dp) - dp * pump.flow(e, dp) - leaked - rubbed;
                assert!(gap.abs() < 1e-9 * FULL * 210e5, "{e} {dp}: {gap}");
            }
        }
    }

    #[test]
    fn the_swivel_rests_where_control_and_torque_want_it() {
        let control = PressureControl { range: 10e5, time_constant: 0.05, torque_limit: 100.0 };
        let rate = |e: f64, p: f64| control.swivel_rate(&pump(), e, p, 210e5, 0.0);
        assert_eq!(rate(0.0, 212e5), 0.0);
        assert_eq!(rate(1.0, 50e5), 0.0);
        assert!((rate(0.4, 206e5)).abs() < 1e-9);
        // 100 N m at 180 bar: M/(D dp) - c.
        let share = 100.0 / (pump().displacement * 180e5) - 0.08;
        assert!(share < 1.0 && rate(share, 180e5).abs() < 1e-9);
        let torque = pump().shaft_power(share, 180e5) / pump().speed;
        assert!((torque - 100.0).abs() < 1e-9);
    }
}
