//! Oil: bulk modulus, density, stored energy.                    theory: docs/theory/hydraulics/fluid.md
//!
//! p >= 0:  E = 1/2 E_max log10(C_1 p / p_max + C_2)                                     thesis (96)
//! p <  0:  E = E_0 y (y + a (1 - y)),  y = (p - p_v)/|p_v|,  a = |p_v|/E_0,  E_0 = E(0)
//!
//! | symbol | meaning | unit |
//! | p, p_v | gauge pressure, vacuum (about -1 bar) | Pa |
//! | E      | bulk modulus, d rho / rho = dp / E     | Pa |
//!
//! Departs from the source: (96) knows no negative pressure, and the printed program takes |p|, so that oil pulls
//! like a rod. Below zero we let free gas expand by Boyle's law: v/v_0 = 1 + a (1/y - 1). The gas volume `a`
//! is the one whose compressibility at p = 0 equals that of (96), so E is continuous. As the chamber is torn open
//! E falls to the absolute pressure and p nears p_v without reaching it; closing it, the same oil is found again.
//! Not modelled: vapour heat, air going into and out of solution.

use hydrocrane_num::{functions::smooth, Real};
#[cfg(feature = "std")]
use hydrocrane_num::{functions::table::QuinticTable, portable, Dual};

parameters! {
    pub struct Fluid {
        /// At p = 0, kg/m^3.
        density,
        /// Pa
        bulk_max,
        /// C_1/p_max of (96), 1/Pa.
        rise,
        /// C_2 of (96).
        c2,
        /// Gauge pressure of vacuum p_v, Pa, negative.
        vacuum,
        ;
        /// Take the modulus of |p| below zero, as the printed program does.
        ignore_cavitation: bool,
    }
}

/// Lowest relative absolute pressure y: keeps E positive in trial states beyond vacuum.
const LEAST_Y: f64 = 1e-9;
const LN_10: f64 = core::f64::consts::LN_10;

impl<T: Real> Fluid<T> {
    /// Pa, from gauge pressure (Pa).
    #[inline(always)]
    pub fn bulk_modulus(&self, p: T) -> T {
        if self.ignore_cavitation {
            return self.logarithmic(p.abs());
        }
        let oil = self.logarithmic(smooth::positive_part(p));
        let y = self.relative_absolute_pressure(p);
        let gas = y * (oil * y - self.vacuum * (T::c(1.0) - y));
        T::select(p.lt(T::c(0.0)), gas, oil)
    }

    #[inline(always)]
    fn logarithmic(&self, p: T) -> T {
        self.bulk_max * (self.rise * p + self.c2).ln() * (0.5 / LN_10)
    }

    #[inline(always)]
    fn relative_absolute_pressure(&self, p: T) -> T {
        ((self.vacuum - p) / self.vacuum).max(T::c(LEAST_Y))
    }
}

/// Density and elastic energy of the oil as functions of pressure, both integrals of 1/E:
///     d ln(rho) = dp/E,      dw = (p + w)/E dp,
/// where w = rho u is the elastic energy per volume: a chamber stores U = V w, and dU = (p + w) q dt - p dV.
/// Quintic tables over pressure, exact below zero where the gas law integrates in closed form.
#[cfg(feature = "std")]
#[derive(Debug, Clone)]
pub struct OilTables {
    fluid: Fluid<f64>,
    /// a, volume of the free gas at p = 0.
    gas: f64,
    above: Branch,
    /// Only where the modulus is that of |p|.
    below: Option<Branch>,
}

/// Where the elastic energy of oil comes from.
pub trait ElasticEnergy {
    /// Per volume, w = rho u, Pa (J/m^3), zero at p = 0.
    fn energy_density<T: Real>(&self, p: T) -> T;
}

#[cfg(feature = "std")]
#[derive(Debug, Clone)]
struct Branch {
    ln_density_ratio: QuinticTable,
    energy: QuinticTable,
}

#[cfg(feature = "std")]
const TABLE_END: f64 = 800e5;
#[cfg(feature = "std")]
const TABLE_SPACING: f64 = 0.25e5;

#[cfg(feature = "std")]
impl OilTables {
    pub fn new(fluid: Fluid<f64>) -> Self {
        let below = fluid.ignore_cavitation.then(|| Branch::new(&fluid, -TABLE_SPACING));
        OilTables {
            fluid,
            gas: -fluid.vacuum / fluid.bulk_modulus(0.0),
            above: Branch::new(&fluid, TABLE_SPACING),
            below,
        }
    }

    /// kg/m^3
    pub fn density<T: Real>(&self, p: T) -> T {
        let above = self.above.ln_density_ratio.eval(p).exp();
        let below = match &self.below {
            Some(branch) => branch.ln_density_ratio.eval(p).exp(),
            None => self.gas(p).0,
        };
        T::select(p.lt(T::c(0.0)), below, above) * self.fluid.density
    }

    /// Density ratio and energy density below p = 0: w = -p + rho h with h the integral of dp/rho.
    #[inline(always)]
    fn gas<T: Real>(&self, p: T) -> (T, T) {
        let (absolute_zero, share) = (-self.fluid.vacuum, self.gas);
        let y = ((p + absolute_zero) / absolute_zero).clamp(T::c(LEAST_Y), T::c(1.0));
        let ratio = y / (y + (T::c(1.0) - y) * share);
        let h = (y - 1.0) * (absolute_zero * (1.0 - share)) + y.ln() * (absolute_zero * share);
        (ratio, ratio * h - p)
    }
}

#[cfg(feature = "std")]
impl ElasticEnergy for OilTables {
    #[inline(always)]
    fn energy_density<T: Real>(&self, p: T) -> T {
        let below = match &self.below {
            Some(branch) => branch.energy.eval(p),
            None => self.gas(p).1,
        };
        T::select(p.lt(T::c(0.0)), below, self.above.energy.eval(p))
    }
}

#[cfg(feature = "std")]
impl Branch {
    /// From p = 0 to the table's end, upwards or downwards by the sign of `spacing`.
    fn new(fluid: &Fluid<f64>, spacing: f64) -> Self {
        let mut knots = integrate(fluid, spacing, (TABLE_END / TABLE_SPACING) as usize);
        let start = spacing.min(0.0) / TABLE_SPACING * TABLE_END;
        if spacing < 0.0 {
            knots.reverse();
        }
        let table = |i: usize| QuinticTable::new(start, TABLE_SPACING, &knots.iter().map(|k| k[i]).collect::<Vec<_>>());
        Branch { ln_density_ratio: table(0), energy: table(1) }
    }
}

#[cfg(feature = "std")]
/// Knots (value, slope, curvature) of ln(rho/rho_0) and of w from p = 0 on, by Gauss-Legendre steps.
fn integrate(fluid: &Fluid<f64>, spacing: f64, knots: usize) -> Vec<[[f64; 3]; 2]> {
    // Five-point rule: exact to rounding over one spacing.
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let lifted = fluid.lift::<Dual<f64, 1>>();
    let ln_rise = |from: f64, to: f64| {
        let half = 0.5 * (to - from);
        NODES.iter().map(|(t, w)| half * w / fluid.bulk_modulus(from + half * (1.0 + t))).sum::<f64>()
    };
    let mut out = Vec::with_capacity(knots + 1);
    let (mut ln_ratio, mut w) = (0.0, 0.0);
    for i in 0..=knots {
        let p = spacing * i as f64;
        // At p = 0 the slope is the one of this side of the kink.
        let e = lifted.bulk_modulus(Dual::variable(p + 1e-6 * spacing.signum(), 0));
        let (e, slope) = (e.value, e.derivative[0]);
        let w1 = (p + w) / e;
        out.push([[ln_ratio, 1.0 / e, -slope / (e * e)], [w, w1, (1.0 + w1 - w1 * slope) / e]]);
        // w = -p + rho h: advance h over the interval with the density inside it.
        let next = p + spacing;
        let half = 0.5 * spacing;
        let h_rise: f64 =
            NODES.iter().map(|(t, weight)| half * weight * portable::exp(-ln_rise(p, p + half * (1.0 + t)))).sum();
        let rise = ln_rise(p, next);
        w = -next + portable::exp(rise) * (w + p + h_rise);
        ln_ratio += rise;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn oil(ignore_cavitation: bool) -> Fluid<f64> {
        Fluid { density: 1000.0, bulk_max: 1e9, rise: 90.0 / 200e5, c2: 3.0, vacuum: -1e5, ignore_cavitation }
    }

    #[test]
    fn bulk_modulus_matches_96_and_is_continuous_at_zero() {
        let f = oil(false);
        assert!((f.bulk_modulus(200e5) - 0.5e9 * 93f64.log10()).abs() < 1.0);
        assert!((f.bulk_modulus(-1e-6) / f.bulk_modulus(0.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn oil_cannot_pull_modulus_falls_to_the_absolute_pressure() {
        let f = oil(false);
        let absolute = 0.1;
        assert!((f.bulk_modulus(-1e5 + absolute) / absolute - 1.0).abs() < 0.01);
        assert!(f.bulk_modulus(-5e5) > 0.0);
        assert!(f.lift::<Dual<f64, 1>>().bulk_modulus(Dual::variable(-1e5, 0)).derivative[0].is_finite());
    }

    #[test]
    fn density_and_energy_satisfy_their_differential_equations() {
        for ignore_cavitation in [false, true] {
            let t = OilTables::new(oil(ignore_cavitation));
            for p in [-0.9e5, -0.3e5, 1e3, 4.2e5, 33.3e5, 140e5, 612e5] {
                let x = Dual::<f64, 1>::variable(p, 0);
                let e = t.fluid.bulk_modulus(p);
                let rho = t.density(x);
                assert!((rho.derivative[0] * e / rho.value - 1.0).abs() < 1e-8, "{ignore_cavitation} {p} {rho:?} {e}");
                let w = t.energy_density(x);
                let exact = (p + w.value) / e;
                assert!((w.derivative[0] - exact).abs() < 1e-8 * exact.abs().max(1e-3), "{p} {w:?} {exact}");
            }
        }
    }
}
