//! Seal friction of a cylinder (thesis 5.1). Forces are positive against positive piston velocity.

pub mod lugre;
pub mod static_map;

use hydrocrane_num::{functions::smooth, Real};

parameters! {
    /// Static friction parameters; a pair holds (extending, retracting).
    pub struct StaticParameters {
        /// alpha_0 = F_C, N
        coulomb_extending,
        coulomb_retracting,
        /// alpha_0 + alpha_1 = F_S, the break-away force, N
        breakaway_extending,
        breakaway_retracting,
        /// v_sigma, m/s
        stribeck_velocity_extending,
        stribeck_velocity_retracting,
        /// delta_sigma
        stribeck_exponent_extending,
        stribeck_exponent_retracting,
        /// alpha_2 = k_v, N (s/m)^delta_v
        viscous_extending,
        viscous_retracting,
        /// delta_v
        viscous_exponent_extending,
        viscous_exponent_retracting,
        ;
        /// Both Stribeck exponents are 2: spares a logarithm and an exponential.
        gaussian: bool,
        /// Both viscous exponents are 3/2: spares a logarithm and an exponential for two roots.
        three_halves: bool,
    }
}

/// Velocity below which powers of |v| are rounded off, m/s.
const LEAST_VELOCITY: f64 = 1e-9;

impl<T: Real> StaticParameters<T> {
    /// g(v) = alpha_0 + alpha_1 exp(-|v/v_sigma|^delta_sigma), N                     thesis (110), (117)
    #[inline(always)]
    pub fn stribeck(&self, v: T) -> T {
        let pick = self.picker(v);
        let coulomb = pick(self.coulomb_extending, self.coulomb_retracting);
        let breakaway = pick(self.breakaway_extending, self.breakaway_retracting);
        let v_s = pick(self.stribeck_velocity_extending, self.stribeck_velocity_retracting);
        let ratio = v / v_s;
        let argument = if self.gaussian {
            ratio.square()
        } else {
            let exponent = pick(self.stribeck_exponent_extending, self.stribeck_exponent_retracting);
            smooth::power_of_magnitude(ratio, exponent, LEAST_VELOCITY)
        };
        coulomb + (breakaway - coulomb) * smooth::exp_neg(argument)
    }

    /// k_v |v|^delta_v sign(v), N                                                             thesis (108)
    #[inline(always)]
    pub fn viscous(&self, v: T) -> T {
        let pick = self.picker(v);
        let power = if self.three_halves {
            smooth::signed_three_halves(v, LEAST_VELOCITY)
        } else {
            let exponent = pick(self.viscous_exponent_extending, self.viscous_exponent_retracting);
            smooth::signed_power(v, exponent, LEAST_VELOCITY)
        };
        pick(self.viscous_extending, self.viscous_retracting) * power
    }

    #[inline(always)]
    fn picker(&self, v: T) -> impl Fn(T, T) -> T {
        let retracting = v.lt(T::c(0.0));
        move |extending, other| T::select(retracting, other, extending)
    }
}

/// The Rottne cylinder without load, thesis Table 3.
#[cfg(test)]
pub(crate) fn rottne() -> StaticParameters<f64> {
    StaticParameters {
        coulomb_extending: 160.0,
        coulomb_retracting: 280.0,
        breakaway_extending: 340.0,
        breakaway_retracting: 400.0,
        stribeck_velocity_extending: 0.002,
        stribeck_velocity_retracting: 0.002,
        stribeck_exponent_extending: 2.0,
        stribeck_exponent_retracting: 2.0,
        viscous_extending: 8000.0,
        viscous_retracting: 12000.0,
        viscous_exponent_extending: 1.5,
        viscous_exponent_retracting: 1.5,
        gaussian: true,
        three_halves: true,
    }
}
