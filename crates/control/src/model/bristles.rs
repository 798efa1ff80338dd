//! Friction that a seal with bristles keeps.                          theory: docs/theory/control/regulate.md
//!
//! z' = v - sigma_0 |v| z / g  (116), F = sigma_0 z:   F' = sigma_0 (v - |v| F/g),
//! whose solution over a time t at constant v is F = g sign(v) + (F_0 - g sign(v)) exp(-sigma_0 |v| t/g).

use hydrocrane_num::portable;

/// Friction (N) after the time `period` (s) at the velocity `v` (m/s), where it was `before`; `sliding`: g(v), N, above zero,
/// `stiffness`: sigma_0, N/m.
pub fn after(before: f64, v: f64, sliding: f64, stiffness: f64, period: f64) -> f64 {
    let end = sliding * v.signum();
    end + (before - end) * portable::exp(-stiffness * v.abs() * period / sliding)
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 4000.0;
    const SIGMA: f64 = 8e6;

    #[test]
    fn follows_the_bristles_in_small_steps() {
        for (v, before) in [(0.02f64, 0.0), (-0.01, 3000.0), (1e-3, -4000.0)] {
            let (mut f, steps, period) = (before, 100_000, 0.05);
            for _ in 0..steps {
                f += period / f64::from(steps) * SIGMA * (v - v.abs() * f / G);
            }
            assert!((after(before, v, G, SIGMA, period) - f).abs() < 0.5, "{v}");
        }
    }

    #[test]
    fn stays_where_the_piston_stands_and_ends_at_sliding_friction() {
        assert_eq!(after(2500.0, 0.0, G, SIGMA, 10.0), 2500.0);
        assert!((after(-4000.0, 0.1, G, SIGMA, 1.0) - G).abs() < 1e-9);
    }
}
