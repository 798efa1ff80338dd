//! Speed of a piston that compresses its oil for the force to come.           theory: docs/theory/control/valve.md
//!
//! v_w = (F_ref - F_w)/(T k),   |v_w| <= v_most,     F_w += T k v_w
//!
//! Beyond the bounds low and high F_w comes back with F_ref, and never goes on.
//!
//! | symbol    | meaning                                                   | unit  |
//! | F_ref     | force that the reference needs                            | N     |
//! | F_w       | force that the valve has compressed the oil for           | N     |
//! | k         | stiffness of the oil between closed edges                 | N/m   |
//! | low, high | forces up to which the oil is compressed                  | N     |

/// Largest speed that compresses the oil, as a share of the full one without load.
pub const MOST_COMPRESSION: f64 = 0.1;

/// F_w; `None` until the first sample of a reference, whose force the oil carries already.
#[derive(Debug, Clone, Copy, Default)]
pub struct Compression(Option<f64>);

/// What bounds the compression at a sample.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Forces up to which the oil is compressed, lowest and highest, N.
    pub forces: [f64; 2],
    /// Largest speed, m/s.
    pub speed: f64,
    /// T k, N s/m.
    pub force_per_speed: f64,
}

impl Compression {
    /// Speed (m/s) for the planned `force` (N), of which the oil has been found to carry `found` (N) already since the last sample.
    pub fn speed(&mut self, force: f64, found: f64, within: &Bounds) -> f64 {
        // At a dead centre a force can be no number.
        if !(force.is_finite() && found.is_finite()) {
            return 0.0;
        }
        let [low, high] = within.forces;
        let compressed = self.0.map_or(force, |compressed| compressed + found);
        let target = force.max(low.min(compressed)).min(high.max(compressed));
        let speed = ((target - compressed) / within.force_per_speed).max(-within.speed).min(within.speed);
        self.0 = Some(compressed + within.force_per_speed * speed);
        speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.01;
    const BOUNDS: Bounds = Bounds { forces: [-50e3, 90e3], speed: 0.04, force_per_speed: PERIOD * 5e6 };

    /// Force that the oil is compressed for (N) after each sample of planned forces, from where the first one leaves it.
    fn compressed(planned: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let (mut compression, mut force) = (Compression::default(), None);
        let step = |planned: f64| {
            let speed = compression.speed(planned, 0.0, &BOUNDS);
            assert!(speed.abs() <= BOUNDS.speed);
            let now = force.unwrap_or(planned) + BOUNDS.force_per_speed * speed;
            force = Some(now);
            now
        };
        planned.into_iter().map(step).collect()
    }

    #[test]
    fn a_force_that_jumps_and_comes_back_leaves_the_oil_as_it_was() {
        // A reference that stops at once: the force of its inertia jumps, and fades behind a low-pass.
        let fading = |k: u32| 70e3 - 45e3 * (-f64::from(k) / 8.0).exp();
        let found = compressed([70e3; 3].into_iter().chain((0..100).map(fading)));
        let (least, most) = found.iter().fold((f64::INFINITY, 0.0f64), |(l, m), f| (l.min(*f), m.max(*f)));
        assert!((found[102] - 70e3).abs() < 1.0 && least < 62e3 && most < 70e3 + 1e-6, "{least} {most} {found:?}");
    }

    #[test]
    fn what_is_beyond_the_bounds_is_not_compressed_and_not_taken_back() {
        let found = compressed([80e3, 85e3, 95e3, 120e3, 95e3, 85e3].into_iter().flat_map(|force| [force; 20]));
        assert!((found[99] - 90e3).abs() < 1e-6 && (found[119] - 85e3).abs() < 1e-6, "{found:?}");
        assert!(found.iter().all(|force| *force <= 90e3 + 1e-6));
    }

    #[test]
    fn an_oil_that_begins_beyond_the_bounds_is_released_from_there() {
        let found = compressed([120e3, 115e3, 118e3, 80e3].into_iter().flat_map(|force| [force; 40]));
        assert!(
            (found[79] - 115e3).abs() < 1e-6 && (found[119] - 115e3).abs() < 1e-6 && (found[159] - 80e3).abs() < 1e-6
        );
    }

    #[test]
    fn what_the_oil_is_found_to_carry_is_not_compressed() {
        let mut compression = Compression::default();
        for k in 0..10 {
            assert!(
                compression.speed(10e3 + 500.0 * f64::from(k), if k == 0 { 0.0 } else { 500.0 }, &BOUNDS).abs() < 1e-12
            );
        }
    }

    #[test]
    fn a_force_that_is_no_number_is_not_compressed_for() {
        let mut compression = Compression::default();
        for (force, found) in [(10e3, 0.0), (f64::INFINITY, 0.0), (f64::NAN, f64::NAN), (10e3, 0.0)] {
            assert_eq!(compression.speed(force, found, &BOUNDS), 0.0);
        }
    }
}
