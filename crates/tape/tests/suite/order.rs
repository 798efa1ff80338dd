//! The order of operations.

use hydrocrane_num::Real;
use hydrocrane_tape::program::program;
use hydrocrane_tape::{record, state, Traced};

#[test]
fn functions_that_do_not_need_each_other_stand_together_behind_what_they_need() {
    let law = |[x, y, z]: [Traced; 3]| {
        let first = (x * y).exp() * z;
        let second = (y * z).ln() * x;
        vec![first + second, (first * second).tanh(), y * y]
    };
    let (results, tape) = record(|| law([0, 1, 2].map(state)));
    let steps = &program(&tape, &[results]).functions[0].steps;
    let order: Vec<&str> = steps.iter().map(|step| step.operation).collect();
    let expected = ["multiply", "multiply", "exp", "ln", "multiply", "multiply", "multiply", "tanh", "multiply", "add"];
    assert_eq!(order[..8], expected[..8]);
    let mut rest = [order[8], order[9]];
    rest.sort_unstable();
    assert_eq!(rest, ["add", "multiply"]);
}

#[test]
fn the_longest_chain_comes_first_and_one_result_after_the_other() {
    let law = |[x, y, z]: [Traced; 3]| vec![x * y + (z + 1.0).sqrt().sqrt(), (x - y).abs()];
    let (results, tape) = record(|| law([0, 1, 2].map(state)));
    let steps = &program(&tape, &[results]).functions[0].steps;
    let order: Vec<&str> = steps.iter().map(|step| step.operation).collect();
    assert_eq!(order, ["add", "root", "root", "multiply", "add", "subtract", "magnitude"]);
}
