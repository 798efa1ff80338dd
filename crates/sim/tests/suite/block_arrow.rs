//! The block arrow of real cranes against the dense matrix, and its solution by the Schur complement.

use hydrocrane_machine::{load, OverrideValue};
use hydrocrane_num::Dual;
use hydrocrane_ode::{BlockArrow, SchurFactors};
use hydrocrane_sim::{build, EquilibriumMode, Model};
use std::sync::Arc;

/// Chains of one and three joints, with and without bristles, regenerative valves, cylinders on four-bars, compensators that follow late.
fn models() -> Vec<Arc<dyn Model>> {
    let without_bristles = [("friction.lift.model".to_string(), OverrideValue::Text("static".to_string()))];
    let mut machines: Vec<_> = ["rottne-f9-lab", "rottne-f9-pump", "rottne-f9-mobile", "hiab-xs031", "single-cylinder"]
        .map(|name| load(name, &[]))
        .into_iter()
        .collect();
    machines.push(load("rottne-f9-lab", &without_bristles));
    let late = ["lift", "jib"]
        .map(|valve| (format!("valve.{valve}.compensator-time-constant"), OverrideValue::Text("20 ms".to_string())));
    machines.push(load("rottne-f9-mobile", &late));
    machines.into_iter().map(|m| build(&m.expect("a bundled machine")).expect("it can be built")).collect()
}

/// Derivatives at a moving state far from rest.
fn derivatives(model: &dyn Model) -> (BlockArrow<f64>, usize) {
    let q: Vec<f64> = model.joint_limits().iter().map(|l| 0.6 * l.lower + 0.4 * l.upper).collect();
    let mut x = model.equilibrium(&q, EquilibriumMode::Hold, 50.0).expect("a pose inside the limits");
    let n = x.len();
    for (i, scale) in model.layout().scales.iter().enumerate().skip(q.len()) {
        x[i] += 0.4 * scale * (1.0 + i as f64).sin();
    }
    let mut derivatives = BlockArrow::new(model.layout().blocks());
    let u = vec![0.01; q.len()];
    model.linearise(&x, &u, 50.0, &mut vec![0.0; n], &mut derivatives);
    (derivatives, n)
}

#[test]
fn the_solution_satisfies_every_row_of_the_dense_system() {
    for model in models() {
        let (derivatives, n) = derivatives(model.as_ref());
        let mut jacobian = vec![0.0; n * n];
        derivatives.write_dense(n, &mut jacobian);
        for shift in [1.0, 1e2, 1e4, 1e7] {
            let mut schur = SchurFactors::default();
            assert!(schur.factor(&derivatives, shift));
            for unit in 0..n {
                let right = |i: usize| if i == unit { model.layout().scales[i] } else { 0.0 };
                let mut k: Vec<f64> = (0..n).map(right).collect();
                schur.solve(&derivatives, &mut k);
                for i in 0..n {
                    let terms = (0..n).map(|j| -jacobian[i * n + j] * k[j]).chain([shift * k[i], -right(i)]);
                    let (sum, size) = terms.fold((0.0, 0.0f64), |(sum, size), term| (sum + term, size + term.abs()));
                    assert!(sum.abs() <= 1e-12 * size, "shift {shift}, unit {unit}, row {i}: {sum} of {size}");
                }
            }
        }
    }
}

#[test]
fn products_are_those_of_the_dense_matrix() {
    for model in models() {
        let (derivatives, n) = derivatives(model.as_ref());
        let mut jacobian = vec![0.0; n * n];
        derivatives.write_dense(n, &mut jacobian);
        let k: Vec<f64> = (0..n).map(|i| model.layout().scales[i] * (2.0 * i as f64).cos()).collect();
        let mut product = vec![0.0; n];
        derivatives.add_product(&k, &mut product);
        // The product leaves out q' = q'.
        for i in derivatives.joints..n {
            let terms = (0..n).map(|j| jacobian[i * n + j] * k[j]);
            let (sum, size) = terms.fold((0.0, 0.0f64), |(sum, size), term| (sum + term, size + term.abs()));
            assert!((product[i] - sum).abs() <= 1e-13 * size, "{i}");
        }
        assert!(product[..derivatives.joints].iter().all(|v| *v == 0.0));
    }
}

#[test]
fn a_matrix_that_cannot_be_solved_is_refused() {
    let model = &models()[0];
    let (mut derivatives, _) = derivatives(model.as_ref());
    derivatives.by_q[0][0] = f64::NAN;
    assert!(!SchurFactors::default().factor(&derivatives, 1e3));
}

#[test]
fn products_with_the_derivative_of_a_matrix_are_derivatives_of_its_products() {
    for model in models() {
        let (matrix, n) = derivatives(model.as_ref());
        // Every entry turns with a rate of its own.
        let mut angle = 0.0;
        let moving = std::cell::RefCell::new(&mut angle);
        let matrix = matrix.map(|value| {
            **moving.borrow_mut() += 1.0;
            Dual { value, derivative: [value * f64::sin(**moving.borrow())] }
        });
        let k: Vec<f64> = (0..n).map(|i| model.layout().scales[i] * (2.0 * i as f64).cos()).collect();
        let product = |matrix: BlockArrow<f64>| {
            let mut y = vec![0.0; n];
            matrix.add_product(&k, &mut y);
            y
        };
        let along = product(matrix.along(|number: Dual<f64, 1>| number.value, |number| number.derivative[0]));
        let at = |h: f64| product(matrix.map(|number| number.value + h * number.derivative[0]));
        // Entries are products of two numbers at most, so that the difference is exact but for rounding.
        for ((along, ahead), behind) in along.iter().zip(at(0.5)).zip(at(-0.5)) {
            let size = ahead.abs().max(behind.abs()).max(1e-300);
            assert!((along - (ahead - behind)).abs() <= 1e-9 * size, "{along} {}", ahead - behind);
        }
    }
}
