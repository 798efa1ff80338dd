//! Points of a friction map and their derivatives.

use hydrocrane_sim::{map_point, MAP_PARAMETERS};

const ROTTNE: [f64; MAP_PARAMETERS] = [160.0, 280.0, 340.0, 400.0, 2e-3, 2e-3, 2.0, 2.0, 8000.0, 12000.0, 1.5, 1.5];

#[test]
fn slopes_are_those_of_differences() {
    for v in [-0.1, -2e-3, -1e-4, 1e-4, 3e-3, 0.1] {
        let here = map_point(&ROTTNE, v);
        for i in 0..MAP_PARAMETERS {
            let step = 1e-5 * ROTTNE[i];
            let [mut low, mut high] = [ROTTNE; 2];
            low[i] -= step;
            high[i] += step;
            let difference = (map_point(&high, v).force - map_point(&low, v).force) / (2.0 * step);
            assert!((difference - here.gradient[i]).abs() <= 1e-6 * (1.0 + difference.abs()), "{i} at {v}");
        }
        let step = 1e-5 * v.abs();
        let difference = (map_point(&ROTTNE, v + step).force - map_point(&ROTTNE, v - step).force) / (2.0 * step);
        assert!((difference - here.slope).abs() <= 1e-5 * (1.0 + difference.abs()), "slope at {v}");
    }
}

#[test]
fn a_direction_has_its_own_parameters() {
    let extending = map_point(&ROTTNE, 0.01);
    let retracting = map_point(&ROTTNE, -0.01);
    for i in 0..MAP_PARAMETERS {
        let other = if i % 2 == 0 { retracting } else { extending };
        assert_eq!(other.gradient[i], 0.0);
    }
    assert!(extending.force > 0.0 && retracting.force < 0.0);
}
