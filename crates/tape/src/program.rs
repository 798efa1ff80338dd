//! Operations in a stable order under names, as writers of other languages need them.
//!
//! States are `x0`, `x1`, ..., spool commands `u0`, ..., parameters `p0`, ..., results of operations `t0`, ..., truth values `m0`, ...,
//! and places in tables `i0`, ...; `c0`, ... are what the prologue keeps. Constants are the shortest decimals that give their bits.

use crate::operation::{Kind, Operand, Operation};
use crate::recorder::{Table, Tape};
use crate::traced::Traced;
use std::cmp::Reverse;
use std::collections::HashMap;

#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    pub result: String,
    pub operation: &'static str,
    pub operands: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Function {
    pub steps: Vec<Step>,
    pub results: Vec<String>,
}

/// Functions of states and spool commands with what they share.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    pub tables: Vec<Table>,
    /// What depends on parameters alone. Its results are what the functions know as `c0`, `c1`, ...
    pub prologue: Function,
    /// These results for the values of the file.
    pub kept: Vec<f64>,
    pub functions: Vec<Function>,
}

/// The operations that each of some lists of results needs.
pub fn program(tape: &Tape, functions: &[Vec<Traced>]) -> Program {
    let moving = moving(tape);
    let rests = |operand: Operand| matches!(operand, Operand::Recorded(at) if !moving[at as usize]);
    let mut keeps: Vec<Operand> = Vec::new();
    let mut names: HashMap<Operand, String> = HashMap::new();
    let mut keep = |operand: Operand| {
        if rests(operand) && !names.contains_key(&operand) {
            names.insert(operand, format!("c{}", keeps.len()));
            keeps.push(operand);
        }
    };
    for results in functions {
        let results = || results.iter().map(|result| result.operand());
        let needed = tape.needed(results());
        for i in (0..needed.len()).filter(|i| needed[*i] && moving[*i]) {
            tape.operations[i].operands.iter().for_each(|operand| keep(*operand));
        }
        results().for_each(&mut keep);
    }
    let functions =
        functions.iter().map(|results| function(tape, results.iter().map(|result| result.operand()).collect(), &names));
    Program {
        tables: tape.tables.clone(),
        functions: functions.collect(),
        kept: keeps.iter().map(|operand| tape.value(*operand)).collect(),
        prologue: function(tape, keeps.clone(), &HashMap::new()),
    }
}

/// Which operations depend on states or commands.
fn moving(tape: &Tape) -> Vec<bool> {
    let mut moving: Vec<bool> = Vec::with_capacity(tape.operations.len());
    for operation in &tape.operations {
        let moves = matches!(operation.kind, Kind::State | Kind::Command) || operation.needs().any(|at| moving[at]);
        moving.push(moves);
    }
    moving
}

/// What `results` need beyond the numbers that have `names` already.
fn function(tape: &Tape, results: Vec<Operand>, names: &HashMap<Operand, String>) -> Function {
    let mut names = names.clone();
    let known: Vec<bool> =
        (0..tape.operations.len() as u32).map(|at| names.contains_key(&Operand::Recorded(at))).collect();
    let mut needed = vec![false; tape.operations.len()];
    let mark = |needed: &mut [bool], at: usize| needed[at] |= !known[at];
    for operand in &results {
        if let Operand::Recorded(at) = operand {
            mark(&mut needed, *at as usize);
        }
    }
    for i in (0..needed.len()).rev() {
        if needed[i] {
            tape.operations[i].needs().for_each(|at| mark(&mut needed, at));
        }
    }
    let input = |i: usize| matches!(tape.operations[i].kind, Kind::State | Kind::Command | Kind::Parameter);
    let inputs: Vec<usize> = (0..needed.len()).filter(|i| needed[*i] && input(*i)).collect();
    for i in inputs {
        needed[i] = false;
        if let Operation { kind, operands: [Operand::Index(index), ..] } = tape.operations[i] {
            names.insert(Operand::Recorded(i as u32), format!("{}{index}", kind.letter()));
        }
    }
    let mut steps = Vec::new();
    for i in calls_together(tape, longest_chains_first(tape, &needed, &results)) {
        let operation = &tape.operations[i];
        let operands = operation.operands.iter().filter(|operand| **operand != Operand::None);
        let operands = operands.map(|operand| text(*operand, &names)).collect();
        let result = format!("{}{}", operation.kind.letter(), steps.len());
        names.insert(Operand::Recorded(i as u32), result.clone());
        steps.push(Step { result, operation: operation.kind.name(), operands });
    }
    Function { steps, results: results.iter().map(|operand| text(*operand, &names)).collect() }
}

/// The operations among the `wanted` that `results` need, one result after the other, each behind what it needs. Of its operands the
/// one that ends the longest chain comes first: then few results wait for others, and what takes longest begins early.
fn longest_chains_first(tape: &Tape, wanted: &[bool], results: &[Operand]) -> Vec<usize> {
    let mut lengths = vec![0; wanted.len()];
    for i in (0..wanted.len()).filter(|i| wanted[*i]) {
        lengths[i] = 1 + tape.operations[i].needs().map(|at| lengths[at]).max().unwrap_or(0);
    }
    let recorded = |operand: &Operand| match operand {
        Operand::Recorded(at) if wanted[*at as usize] => Some(*at as usize),
        _ => None,
    };
    let mut open: Vec<usize> = results.iter().rev().filter_map(recorded).collect();
    let mut waits = wanted.to_vec();
    let mut order = Vec::new();
    while let Some(i) = open.last().copied() {
        let mut needed: Vec<usize> = tape.operations[i].needs().filter(|at| waits[*at]).collect();
        needed.sort_by_key(|at| Reverse(lengths[*at]));
        open.extend(needed.iter().rev());
        if needed.is_empty() {
            open.pop();
            if std::mem::take(&mut waits[i]) {
                order.push(i);
            }
        }
    }
    order
}

/// `order` with exponentials, logarithms and the like next to each other where none needs the other, each with what it needs before it
/// and all else behind: compilers call them, and across a call no result stays in a register.
fn calls_together(tape: &Tape, mut order: Vec<usize>) -> Vec<usize> {
    let called =
        |i: usize| matches!(tape.operations[i].kind, Kind::Exp | Kind::Ln | Kind::Sin | Kind::Cos | Kind::Tanh);
    // Calls one after the other before each operation, at most.
    let mut levels = vec![0; tape.operations.len()];
    for i in &order {
        let before = tape.operations[*i].needs().map(|at| levels[at] + usize::from(called(at)));
        levels[*i] = before.max().unwrap_or(0);
    }
    let mut stages = vec![usize::MAX; tape.operations.len()];
    for i in order.iter().rev() {
        let mut needed = stages[*i];
        if called(*i) {
            (needed, stages[*i]) = (2 * levels[*i], 2 * levels[*i] + 1);
        }
        tape.operations[*i].needs().for_each(|at| stages[at] = stages[at].min(needed));
    }
    order.sort_by_key(|i| stages[*i]);
    order
}

fn text(operand: Operand, names: &HashMap<Operand, String>) -> String {
    match operand {
        Operand::Constant(bits) => format!("{:?}", f64::from_bits(bits)),
        Operand::Index(index) => index.to_string(),
        _ => names.get(&operand).cloned().unwrap_or_default(),
    }
}
