//! Derivatives of small laws.

use hydrocrane_num::functions::smooth::positive_part;
use hydrocrane_num::{Field, Real};
use hydrocrane_tape::derivatives::by_states;
use hydrocrane_tape::{record, state, Kind, Tape, Traced};

/// Row, column and value of each derivative of a law of three states at `x`, and the tape.
fn derivatives(law: impl FnOnce([Traced; 3]) -> Vec<Traced>, x: [f64; 3]) -> (Vec<(usize, usize, f64)>, Tape) {
    let (entries, tape) = record(|| by_states(&law([0, 1, 2].map(state))));
    let operands: Vec<_> = entries.iter().map(|entry| entry.value.operand()).collect();
    let values = tape.evaluate(&operands, [&x, &[], &[]]);
    (entries.iter().zip(values).map(|(entry, value)| (entry.row, entry.column, value)).collect(), tape)
}

#[test]
fn results_may_be_states_constants_equal_and_used_by_others() {
    let law = |[x, y, _]: [Traced; 3]| {
        let product = x * y;
        vec![x, Traced::c(2.0), product, product, product * product, x - x]
    };
    let (found, _) = derivatives(law, [3.0, 5.0, 0.0]);
    let expected = [(0, 0, 1.0), (2, 0, 5.0), (2, 1, 3.0), (3, 0, 5.0), (3, 1, 3.0), (4, 0, 150.0), (4, 1, 90.0)];
    assert_eq!(found, expected);
}

#[test]
fn what_cancels_is_no_entry() {
    let (found, _) = derivatives(|[x, y, _]| vec![(x + y) - (x - y)], [3.0, 5.0, 0.0]);
    assert_eq!(found, [(0, 1, 2.0)]);
}

#[test]
fn an_infinite_derivative_of_the_side_that_is_not_selected_has_no_effect() {
    let law = |[x, y, _]: [Traced; 3]| vec![Traced::select(Traced::c(0.0).lt(x), x.sqrt(), y) * y];
    assert_eq!(derivatives(law, [0.0, 5.0, 0.0]).0, [(0, 0, 0.0), (0, 1, 10.0)]);
    assert_eq!(derivatives(law, [4.0, 5.0, 0.0]).0, [(0, 0, 1.25), (0, 1, 2.0)]);
}

/// Slopes of a chain are multiplied with each other before those of the three states and the three results that it joins: forward
/// and reverse multiply each of three by every slope, which takes 23 operations.
#[test]
fn a_chain_between_many_states_and_many_results_is_passed_once() {
    let law = |[x, y, z]: [Traced; 3]| {
        let waist = (x * y * z).exp().sqrt().exp();
        vec![waist.sqrt(), waist * waist, waist.exp()]
    };
    let (found, tape) = derivatives(law, [0.5, 0.25, 0.125]);
    assert_eq!(found.len(), 9);
    let results: Vec<_> = record(|| law([0, 1, 2].map(state))).1.operations;
    // y z, x z, 0.5 over a root and 2 waist: five. Two products along the chain, three with the states, nine with the results.
    assert_eq!(tape.operations.len() - results.len(), 5 + 2 + 3 + 9);
}

#[test]
fn a_positive_part_is_one_operation_with_the_mean_slope_at_zero() {
    for (x, slope) in [(-2.0, 0.0), (0.0, 0.5), (2.0, 1.0)] {
        let (found, _) = derivatives(|[x, y, _]| vec![positive_part(x) * y], [x, 3.0, 0.0]);
        assert_eq!(found, [(0, 0, 3.0 * slope), (0, 1, f64::max(x, 0.0))]);
    }
    for x in [|| state(0), || -state(0), || state(0) - 1.0] {
        let (part, tape) = record(|| positive_part(x()));
        let needed = tape.needed([part.operand()]);
        let kinds =
            tape.operations.iter().zip(&needed).filter(|(_, needed)| **needed).map(|(operation, _)| operation.kind);
        assert!(kinds.clone().any(|kind| kind == Kind::Positive) && kinds.clone().all(|kind| kind != Kind::Select));
    }
}
