//! Exact derivatives, as further operations of the tape.
//!
//! Forward, operation by operation, and only by the states that a number depends on: each has a short list of derivatives.

use crate::operation::{Kind, Operand, Operation};
use crate::recorder::recording;
use crate::traced::{Traced, TracedMask};
use hydrocrane_num::{Field, Real};

/// A derivative that is not zero everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    pub row: usize,
    pub column: usize,
    pub value: Traced,
}

/// Derivatives by the states, ascending.
type Gradient = Vec<(u32, Traced)>;

/// The derivatives of `results` of the tape that is being recorded by the states, row by row.
pub fn by_states(results: &[Traced]) -> Vec<Entry> {
    let (operations, needed) =
        recording(|tape| (tape.operations.clone(), tape.needed(results.iter().map(|result| result.operand()))));
    let mut gradients: Vec<Gradient> = vec![Vec::new(); operations.len()];
    for i in (0..operations.len()).filter(|i| needed[*i]) {
        gradients[i] = gradient(Traced::Recorded(i as u32), &operations[i], &gradients);
    }
    let rows = results.iter().enumerate().filter_map(|(row, result)| match result {
        Traced::Recorded(at) => Some((row, &gradients[*at as usize])),
        Traced::Constant(_) => None,
    });
    rows.flat_map(|(row, entries)| {
        entries.iter().map(move |(column, value)| Entry { row, column: *column as usize, value: *value })
    })
    .collect()
}

/// That of an operation whose result is `value`.
fn gradient(value: Traced, Operation { kind, operands }: &Operation, before: &[Gradient]) -> Gradient {
    let none = Vec::new();
    let of = |k: usize| match operands[k] {
        Operand::Recorded(at) => &before[at as usize],
        _ => &none,
    };
    let [a, b] = [0, 1].map(|k| number(operands[k]));
    let one = Traced::Constant(1.0);
    let scaled = |slope: &dyn Fn() -> Traced| if of(0).is_empty() { Vec::new() } else { times(of(0), slope()) };
    match kind {
        Kind::State => match operands[0] {
            Operand::Index(at) => vec![(at, one)],
            _ => none,
        },
        Kind::Add => joined(of(0), of(1), |a, b| a + b),
        Kind::Subtract => joined(of(0), of(1), |a, b| a - b),
        Kind::Multiply => joined(of(0), of(1), |da, db| da * b + db * a),
        Kind::Divide if of(0).is_empty() && of(1).is_empty() => none,
        Kind::Divide => {
            let inverse = one / b;
            joined(of(0), of(1), |da, db| (da - db * value) * inverse)
        }
        Kind::Negate => scaled(&|| -one),
        Kind::Root => scaled(&|| Traced::Constant(0.5) / value),
        Kind::Exp => scaled(&|| value),
        Kind::Ln => scaled(&|| one / a),
        Kind::Sin => scaled(&|| a.sin_cos().1),
        Kind::Cos => scaled(&|| -a.sin_cos().0),
        Kind::Tanh => scaled(&|| one - value * value),
        Kind::Magnitude => scaled(&|| Traced::select(a.lt(Traced::Constant(0.0)), -one, one)),
        Kind::Select => match operands[0] {
            Operand::Recorded(at) => joined(of(1), of(2), |da, db| Traced::select(TracedMask::Recorded(at), da, db)),
            _ => none,
        },
        _ => none,
    }
}

fn number(operand: Operand) -> Traced {
    match operand {
        Operand::Recorded(at) => Traced::Recorded(at),
        Operand::Constant(bits) => Traced::Constant(f64::from_bits(bits)),
        _ => Traced::default(),
    }
}

fn times(gradient: &Gradient, slope: Traced) -> Gradient {
    kept(gradient.iter().map(|(column, d)| (*column, *d * slope)))
}

/// `f` of both derivatives by each state; zero where there is none.
fn joined(a: &Gradient, b: &Gradient, f: impl Fn(Traced, Traced) -> Traced) -> Gradient {
    let zero = Traced::Constant(0.0);
    let (mut a, mut b) = (a.iter().copied().peekable(), b.iter().copied().peekable());
    let mut out = Vec::new();
    loop {
        let column = match (a.peek(), b.peek()) {
            (Some((i, _)), Some((j, _))) => *i.min(j),
            (Some((i, _)), None) | (None, Some((i, _))) => *i,
            (None, None) => return kept(out.into_iter()),
        };
        let da = a.next_if(|(i, _)| *i == column).map_or(zero, |(_, d)| d);
        let db = b.next_if(|(i, _)| *i == column).map_or(zero, |(_, d)| d);
        out.push((column, f(da, db)));
    }
}

fn kept(gradient: impl Iterator<Item = (u32, Traced)>) -> Gradient {
    gradient.filter(|(_, d)| *d != Traced::Constant(0.0)).collect()
}
