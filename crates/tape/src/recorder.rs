//! The tape that is being recorded in this thread.

use crate::operation::{Kind, Operand, Operation};
use std::cell::RefCell;
use std::collections::HashMap;

/// Columns over ascending starts of rows; the first row reaches from minus infinity to the first start.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub starts: Vec<f64>,
    pub columns: Vec<Vec<f64>>,
}

/// Operations, each of which works on earlier ones; equal ones stand once.
#[derive(Debug, Default)]
pub struct Tape {
    pub operations: Vec<Operation>,
    pub tables: Vec<Table>,
    /// Where each operation stands.
    known: HashMap<Operation, u32>,
    /// Results for the values of the parameters that were given; NaN where they depend on states or commands.
    values: Vec<f64>,
    /// Parameters whose value lets a law take a shorter formula, which holds for this value alone.
    pub decisive: Vec<u32>,
}

thread_local! {
    static TAPE: RefCell<Tape> = RefCell::new(Tape::default());
}

/// Runs `f` and returns what it recorded. Numbers that were recorded before belong to another tape.
pub fn record<O>(f: impl FnOnce() -> O) -> (O, Tape) {
    let before = TAPE.with(RefCell::take);
    let out = f();
    (out, TAPE.with(|tape| tape.replace(before)))
}

/// Something of the tape that is being recorded.
pub(crate) fn recording<O>(f: impl FnOnce(&mut Tape) -> O) -> O {
    TAPE.with(|tape| f(&mut tape.borrow_mut()))
}

impl Tape {
    /// Where an operation stands, which is recorded if it is new; `value` for the values of the parameters.
    fn push(&mut self, operation: Operation, value: f64) -> u32 {
        let next = self.operations.len() as u32;
        let at = *self.known.entry(operation).or_insert(next);
        if at == next {
            self.operations.push(operation);
            self.values.push(value);
        }
        at
    }

    /// Forgets the operations from the one at `length` on. Returns how many they were.
    pub(crate) fn cut(&mut self, length: usize) -> usize {
        let tail = self.operations.split_off(length);
        tail.iter().for_each(|operation| _ = self.known.remove(operation));
        self.values.truncate(length);
        tail.len()
    }

    /// An input, by its index.
    pub(crate) fn input(&mut self, kind: Kind, index: usize, value: f64) -> u32 {
        let operands = [Operand::Index(index as u32), Operand::None, Operand::None];
        self.push(Operation { kind, operands }, value)
    }

    /// The result of a `kind` of operation on numbers or masks.
    pub(crate) fn apply(&mut self, kind: Kind, mut operands: [Operand; 3]) -> u32 {
        if kind.commutes() && operands[1] < operands[0] {
            operands.swap(0, 1);
        }
        let value = kind.of(operands.map(|operand| self.value(operand)));
        self.push(Operation { kind, operands }, value)
    }

    /// The entries of a row of `table` at a number.
    pub(crate) fn row<const K: usize>(&mut self, table: Table, x: Operand) -> [u32; K] {
        let row = |place: f64| table.columns.iter().map(move |column| column[place as usize]);
        let place = table.starts.iter().filter(|start| **start <= self.value(x)).count() as f64;
        let (known, values): (bool, Vec<f64>) = (!self.value(x).is_nan(), row(place).collect());
        let found = self.tables.iter().position(|other| *other == table);
        let index = found.unwrap_or_else(|| {
            self.tables.push(table);
            self.tables.len() - 1
        });
        let table = Operand::Index(index as u32);
        let nan = |value: f64| if known { value } else { f64::NAN };
        let place = self.push(Operation { kind: Kind::Place, operands: [table, x, Operand::None] }, nan(place));
        hydrocrane_num::array::from_fn(|k| {
            let operands = [table, Operand::Index(k as u32), Operand::Recorded(place)];
            self.push(Operation { kind: Kind::Entry, operands }, nan(values[k]))
        })
    }

    /// For the values of the parameters; NaN for what depends on states or commands.
    pub(crate) fn value(&self, operand: Operand) -> f64 {
        match operand {
            Operand::Constant(bits) => f64::from_bits(bits),
            Operand::Recorded(at) => self.values[at as usize],
            _ => f64::NAN,
        }
    }

    /// Notes the parameters that a number depends on as those that decide on a formula.
    pub(crate) fn note_decisive(&mut self, of: Operand) {
        let Operand::Recorded(at) = of else { return };
        let live = self.needed([of]);
        for i in (0..=at as usize).filter(|i| live[*i]) {
            if let Operation { kind: Kind::Parameter, operands: [Operand::Index(parameter), ..] } = self.operations[i] {
                self.decisive.push(parameter);
            }
        }
    }

    /// Whether a parameter is among the `needed` operations.
    pub(crate) fn uses_parameter(&self, needed: &[bool], index: usize) -> bool {
        let operands = [Operand::Index(index as u32), Operand::None, Operand::None];
        let at = self.known.get(&Operation { kind: Kind::Parameter, operands });
        at.is_some_and(|at| needed[*at as usize])
    }

    /// Which operations some results need.
    pub fn needed(&self, results: impl IntoIterator<Item = Operand>) -> Vec<bool> {
        let mut needed = vec![false; self.operations.len()];
        for result in results {
            if let Operand::Recorded(at) = result {
                needed[at as usize] = true;
            }
        }
        for i in (0..needed.len()).rev() {
            if needed[i] {
                self.operations[i].needs().for_each(|at| needed[at] = true);
            }
        }
        needed
    }

    /// The plain numbers that `results` are for states `x`, spool commands `u` and parameters `p`.
    pub fn evaluate(&self, results: &[Operand], [x, u, p]: [&[f64]; 3]) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.operations.len()];
        let get = |values: &[f64], operand: Operand| match operand {
            Operand::Constant(bits) => f64::from_bits(bits),
            Operand::Recorded(at) => values[at as usize],
            _ => f64::NAN,
        };
        for (i, needed) in self.needed(results.iter().copied()).iter().enumerate() {
            if !needed {
                continue;
            }
            let Operation { kind, operands } = self.operations[i];
            values[i] = match (kind, operands) {
                (Kind::State, [Operand::Index(at), ..]) => x[at as usize],
                (Kind::Command, [Operand::Index(at), ..]) => u[at as usize],
                (Kind::Parameter, [Operand::Index(at), ..]) => p[at as usize],
                (Kind::Place, [Operand::Index(table), x, _]) => {
                    let x = get(&values, x);
                    self.tables[table as usize].starts.iter().filter(|start| **start <= x).count() as f64
                }
                (Kind::Entry, [Operand::Index(table), Operand::Index(column), place]) => {
                    self.tables[table as usize].columns[column as usize][get(&values, place) as usize]
                }
                _ => kind.of(operands.map(|operand| get(&values, operand))),
            };
        }
        results.iter().map(|result| get(&values, *result)).collect()
    }
}
