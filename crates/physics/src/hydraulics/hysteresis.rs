//! Hysteresis of a pilot stage: play between command and spool. theory: docs/theory/hydraulics/hysteresis.md
//!
//! w = min(max(w_before, u - h), u + h)
//!
//! | symbol | meaning | unit |
//! | u      | command at the pilot stage                  | m |
//! | w      | command that the spool follows              | m |
//! | h      | half width of the loop: hysteresis times stroke over 2 | m |
//!
//! Exact for commands that jump, and for those that rise or fall from `before` on. Source: Krasnosel'skii and Pokrovskii (1989), the
//! play operator. Limits of validity: the loop has parallel sides and one width; no creep of the magnet, no dither.

use hydrocrane_num::Real;

/// Command w that the spool follows, m, after the one `before`, with the command `u` at a pilot stage whose loop is twice `half_width` (m)
/// wide.
#[inline(always)]
pub fn follow<T: Real>(half_width: T, before: T, u: T) -> T {
    before.max(u - half_width).min(u + half_width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::Dual;

    #[test]
    fn a_spool_stands_until_the_command_has_crossed_the_loop() {
        let mut spool: f64 = 0.0;
        // Up, small cycles within the loop of 2 mm, up again, down and back.
        for (u, wanted) in [
            (0.0005, 0.0),
            (0.01, 0.009),
            (0.0085, 0.009),
            (0.0095, 0.009),
            (0.0081, 0.009),
            (0.011, 0.01),
            (0.0, 0.001),
            (-0.02, -0.019),
            (0.0, -0.001),
        ] {
            spool = follow(0.001, spool, u);
            assert!((spool - wanted).abs() < 1e-15, "{u}: {spool} {wanted}");
        }
    }

    #[test]
    fn a_full_cycle_encloses_the_width_of_the_loop_times_its_travel() {
        let (half_width, steps) = (0.001, 10_000);
        let (mut spool, mut area, mut last) = (0.0f64, 0.0, 0.0f64);
        for i in 0..2 * steps {
            let angle = core::f64::consts::TAU * f64::from(i) / f64::from(steps);
            let u = 0.01 * hydrocrane_num::portable::sin_cos(angle).0;
            let before = spool;
            spool = follow(half_width, before, u);
            // The first cycle leaves the middle.
            area += if i >= steps { 0.5 * (before + spool) * (u - last) } else { 0.0 };
            last = u;
        }
        // 2 h wide and 2 (0.01 - h) high.
        assert!((area.abs() / (2.0 * half_width * 2.0 * (0.01 - half_width)) - 1.0).abs() < 1e-6, "{area}");
    }

    #[test]
    fn derivatives_are_those_of_what_it_follows() {
        let by = |before: f64, u: f64| {
            follow(Dual::<f64, 2>::constant(0.001), Dual::variable(before, 0), Dual::variable(u, 1)).derivative
        };
        assert_eq!([by(0.0, 0.0005), by(0.0, 0.003), by(0.0, -0.003)], [[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]]);
    }
}
