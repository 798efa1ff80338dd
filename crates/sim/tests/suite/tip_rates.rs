//! Redundancy of the tip over slices.

use hydrocrane_control::reference::redundancy::{resolve, Preference, Task};
use hydrocrane_sim::{resolve_rates, RateRequest};

#[test]
fn slices_give_what_arrays_give() {
    let jacobian = [[0.929, 1.4097, 0.342], [2.8251, 0.5652, -0.9397]];
    let prefer = Preference { weights: [1.0, 2.0, 3.0], rates: [0.1, 0.0, -0.1], bounds: [[-0.1, 0.1]; 3] };
    let task = Task { velocity: [0.4, 0.1], correction: [0.01, 0.0] };
    let typed = resolve(&jacobian, &task, &prefer);
    let request = RateRequest {
        jacobian: jacobian.as_flattened(),
        velocity: task.velocity,
        correction: task.correction,
        weights: &prefer.weights,
        preferred: &prefer.rates,
        bounds: prefer.bounds.as_flattened(),
    };
    assert!(typed.scale > 0.0 && typed.scale < 1.0);
    assert_eq!(resolve_rates(&request), Some((typed.rates.to_vec(), typed.scale)));
    assert_eq!(resolve_rates(&RateRequest { weights: &[], ..request }), None);
}
