//! Exact derivatives, as further operations of the tape.                     theory: docs/theory/tape.md
//!
//! Every operation has derivatives by its operands. They are the edges of a graph from the states to the results, and a derivative
//! of a result by a state is the sum over all paths of the products of their edges. Vertices between are eliminated one after the
//! other: each pair of an edge into a vertex and one out of it becomes an edge past it.

use crate::operation::{Kind, Operand, Operation};
use crate::recorder::recording;
use crate::traced::{Traced, TracedMask};
use hydrocrane_num::{Field, Real};
use std::collections::{BTreeMap, BTreeSet};

/// A derivative that is not zero everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    pub row: usize,
    pub column: usize,
    pub value: Traced,
}

const ZERO: Traced = Traced::Constant(0.0);
const ONE: Traced = Traced::Constant(1.0);

/// The derivatives of `results` of the tape that is being recorded by the states, row by row.
pub fn by_states(results: &[Traced]) -> Vec<Entry> {
    let (operations, needed) =
        recording(|tape| (tape.operations.clone(), tape.needed(results.iter().map(|result| result.operand()))));
    let mut graph = Graph::of(&operations, &needed, results);
    graph.eliminate_all(operations.len());
    let rows = graph.by.iter().skip(operations.len()).enumerate();
    let column = |vertex: u32| match operations[vertex as usize].operands[0] {
        Operand::Index(state) => state as usize,
        _ => unreachable!("only states are left"),
    };
    rows.flat_map(|(row, edges)| edges.iter().map(move |(at, value)| Entry { row, column: column(*at), value: *value }))
        .collect()
}

/// Operations, and behind them the results, by their index.
struct Graph {
    /// The derivatives of each by earlier ones.
    by: Vec<BTreeMap<u32, Traced>>,
    /// The later ones that have a derivative by it.
    of: Vec<BTreeSet<u32>>,
}

/// What an elimination costs, to be compared in this order: edges more than before, operations, and the place on the tape.
type Cost = (isize, usize, u32);

impl Graph {
    fn of(operations: &[Operation], needed: &[bool], results: &[Traced]) -> Self {
        let count = operations.len() + results.len();
        let mut graph = Graph { by: vec![BTreeMap::new(); count], of: vec![BTreeSet::new(); count] };
        let depends =
            |graph: &Graph, at: u32| operations[at as usize].kind == Kind::State || !graph.by[at as usize].is_empty();
        for (i, operation) in operations.iter().enumerate().filter(|(i, _)| needed[*i]) {
            for (k, operand) in operation.operands.iter().enumerate() {
                if let Operand::Recorded(at) = *operand {
                    if depends(&graph, at) {
                        graph.add(at, i as u32, slope(Traced::Recorded(i as u32), operation, k));
                    }
                }
            }
        }
        for (row, result) in results.iter().enumerate() {
            if let Traced::Recorded(at) = *result {
                if depends(&graph, at) {
                    graph.add(at, (operations.len() + row) as u32, ONE);
                }
            }
        }
        graph
    }

    /// Adds to the derivative of a vertex by another.
    fn add(&mut self, by: u32, of: u32, value: Traced) {
        let edges = &mut self.by[of as usize];
        let sum = edges.get(&by).map_or(value, |edge| plus(*edge, value));
        if sum == ZERO {
            edges.remove(&by);
            self.of[by as usize].remove(&of);
        } else {
            edges.insert(by, sum);
            self.of[by as usize].insert(of);
        }
    }

    /// Eliminates all of the first `count` vertices that are not states, the one with the least cost first.
    fn eliminate_all(&mut self, count: usize) {
        let between = |graph: &Graph, i: u32| (i as usize) < count && !graph.by[i as usize].is_empty();
        let mut costs: BTreeMap<u32, Cost> =
            (0..count as u32).filter(|i| between(self, *i)).map(|i| (i, self.cost(i))).collect();
        let mut queue: BTreeSet<Cost> = costs.values().copied().collect();
        while let Some((.., vertex)) = queue.pop_first() {
            costs.remove(&vertex);
            for at in self.eliminate(vertex) {
                if let Some(cost) = costs.get_mut(&at) {
                    queue.remove(cost);
                    *cost = self.cost(at);
                    queue.insert(*cost);
                }
            }
        }
    }

    /// Edges past a vertex in place of those that meet there. Returns the vertices whose cost may be another now.
    fn eliminate(&mut self, vertex: u32) -> BTreeSet<u32> {
        let (into, out) =
            (std::mem::take(&mut self.by[vertex as usize]), std::mem::take(&mut self.of[vertex as usize]));
        for later in &out {
            let slope = self.by[*later as usize].remove(&vertex).unwrap_or(ZERO);
            into.iter().for_each(|(earlier, edge)| self.add(*earlier, *later, times(*edge, slope)));
        }
        let mut near: BTreeSet<u32> = into.keys().chain(&out).copied().collect();
        for earlier in into.keys() {
            self.of[*earlier as usize].remove(&vertex);
            near.extend(&self.of[*earlier as usize]);
        }
        out.iter().for_each(|later| near.extend(self.by[*later as usize].keys()));
        near
    }

    fn cost(&self, vertex: u32) -> Cost {
        let (into, out) = (&self.by[vertex as usize], &self.of[vertex as usize]);
        let mut edges = -((into.len() + out.len()) as isize);
        let length = recording(|tape| tape.operations.len());
        for later in out {
            let others = &self.by[*later as usize];
            for (earlier, edge) in into {
                let product = times(*edge, others[&vertex]);
                match others.get(earlier) {
                    Some(other) => _ = plus(*other, product),
                    None => edges += 1,
                }
            }
        }
        let operations = recording(|tape| tape.cut(length));
        (edges, operations, vertex)
    }
}

/// The derivative of an operation, whose result is `value`, by one of its operands.
fn slope(value: Traced, Operation { kind, operands }: &Operation, by: usize) -> Traced {
    let [a, b] = [0, 1].map(|k| number(operands[k]));
    match (kind, by) {
        (Kind::Add, _) | (Kind::Subtract, 0) => ONE,
        (Kind::Subtract, _) | (Kind::Negate, _) => -ONE,
        (Kind::Multiply, 0) => b,
        (Kind::Multiply, _) => a,
        (Kind::Divide, 0) => ONE / b,
        (Kind::Divide, _) => -(value * (ONE / b)),
        (Kind::Root, _) => Traced::Constant(0.5) / value,
        (Kind::Exp, _) => value,
        (Kind::Ln, _) => ONE / a,
        (Kind::Sin, _) => a.sin_cos().1,
        (Kind::Cos, _) => -a.sin_cos().0,
        (Kind::Tanh, _) => ONE - value * value,
        (Kind::Magnitude, _) => Traced::select(a.lt(ZERO), -ONE, ONE),
        (Kind::Positive, _) => Traced::select(a.lt(ZERO), ZERO, Traced::select(ZERO.lt(a), ONE, Traced::Constant(0.5))),
        (Kind::Select, 1) => where_it_holds(operands[0], ONE, ZERO),
        (Kind::Select, 2) => where_it_holds(operands[0], ZERO, ONE),
        _ => ZERO,
    }
}

fn number(operand: Operand) -> Traced {
    match operand {
        Operand::Recorded(at) => Traced::Recorded(at),
        Operand::Constant(bits) => Traced::Constant(f64::from_bits(bits)),
        _ => Traced::default(),
    }
}

fn where_it_holds(mask: Operand, a: Traced, b: Traced) -> Traced {
    match mask {
        Operand::Recorded(at) => Traced::select(TracedMask::Recorded(at), a, b),
        _ => ZERO,
    }
}

/// The mask and the sides of a selection.
fn sides(x: Traced) -> Option<(Operand, Traced, Traced)> {
    let Operation { kind: Kind::Select, operands: [mask, a, b] } = x.operation()? else { return None };
    Some((mask, number(a), number(b)))
}

/// A product that is zero where a factor is a selection of zero, whatever the other factor is there: infinite, maybe.
fn times(x: Traced, y: Traced) -> Traced {
    for (x, y) in [(x, y), (y, x)] {
        match sides(x) {
            Some((mask, a, ZERO)) => return where_it_holds(mask, times(a, y), ZERO),
            Some((mask, ZERO, b)) => return where_it_holds(mask, ZERO, times(b, y)),
            _ => {}
        }
    }
    x * y
}

/// A sum, one selection of two by the same mask if no further sum comes of it.
fn plus(x: Traced, y: Traced) -> Traced {
    if let (Some((mask, a, b)), Some((other, c, d))) = (sides(x), sides(y)) {
        let lacks = |a: Traced, b: Traced| a == ZERO || b == ZERO;
        if mask == other && (lacks(a, c) || lacks(b, d)) {
            return where_it_holds(mask, plus(a, c), plus(b, d));
        }
    }
    x + y
}
