//! What a tape holds.

use hydrocrane_num::Real;

/// What an operation does with its operands. Truth values are masks, one or zero where they are evaluated as numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Inputs, by their index.
    State,
    Command,
    Parameter,
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    Root,
    Exp,
    Ln,
    Sin,
    Cos,
    Tanh,
    Magnitude,
    Positive,
    Less,
    LessOrEqual,
    And,
    Or,
    Not,
    /// The second operand where the first, a mask, holds, else the third.
    Select,
    /// How many starts of a table's rows are at or below a number.
    Place,
    /// The entry of a column of a table at a place.
    Entry,
}

impl Kind {
    /// The name by which writers know it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::State => "state",
            Kind::Command => "command",
            Kind::Parameter => "parameter",
            Kind::Add => "add",
            Kind::Subtract => "subtract",
            Kind::Multiply => "multiply",
            Kind::Divide => "divide",
            Kind::Negate => "negate",
            Kind::Root => "root",
            Kind::Exp => "exp",
            Kind::Ln => "ln",
            Kind::Sin => "sin",
            Kind::Cos => "cos",
            Kind::Tanh => "tanh",
            Kind::Magnitude => "magnitude",
            Kind::Positive => "positive",
            Kind::Less => "less",
            Kind::LessOrEqual => "less_or_equal",
            Kind::And => "and",
            Kind::Or => "or",
            Kind::Not => "not",
            Kind::Select => "select",
            Kind::Place => "place",
            Kind::Entry => "entry",
        }
    }

    /// Whether it does not matter which operand comes first, to the bit.
    pub fn commutes(self) -> bool {
        matches!(self, Kind::Add | Kind::Multiply | Kind::And | Kind::Or)
    }

    /// First letter of the names of its results: truth values, places and numbers are of different types in other languages.
    pub fn letter(self) -> char {
        match self {
            Kind::Less | Kind::LessOrEqual | Kind::And | Kind::Or | Kind::Not => 'm',
            Kind::Place => 'i',
            Kind::State => 'x',
            Kind::Command => 'u',
            Kind::Parameter => 'p',
            _ => 't',
        }
    }

    /// Its result for plain numbers, with the bits of the laws. Inputs and tables have no operands that are numbers.
    pub fn of(self, [a, b, c]: [f64; 3]) -> f64 {
        let truth = |holds: bool| f64::from(u8::from(holds));
        match self {
            Kind::Add => a + b,
            Kind::Subtract => a - b,
            Kind::Multiply => a * b,
            Kind::Divide => a / b,
            Kind::Negate => -a,
            Kind::Root => Real::sqrt(a),
            Kind::Exp => Real::exp(a),
            Kind::Ln => Real::ln(a),
            Kind::Sin => Real::sin_cos(a).0,
            Kind::Cos => Real::sin_cos(a).1,
            Kind::Tanh => Real::tanh(a),
            Kind::Magnitude => Real::abs(a),
            Kind::Positive => {
                if a < 0.0 {
                    0.0
                } else {
                    a
                }
            }
            Kind::Less => truth(a < b),
            Kind::LessOrEqual => truth(a <= b),
            Kind::And => a * b,
            Kind::Or => a.max(b),
            Kind::Not => 1.0 - a,
            Kind::Select => {
                if a == 1.0 {
                    b
                } else {
                    c
                }
            }
            Kind::State | Kind::Command | Kind::Parameter | Kind::Place | Kind::Entry => f64::NAN,
        }
    }
}

/// What an operation works on. Constants are kept as bits, so that equal ones can be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Operand {
    None,
    /// Result of an earlier operation.
    Recorded(u32),
    Constant(u64),
    /// Of an input, a table or a column.
    Index(u32),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Operation {
    pub kind: Kind,
    pub operands: [Operand; 3],
}

impl Operation {
    /// The earlier operations whose results it needs.
    pub fn needs(&self) -> impl Iterator<Item = usize> + '_ {
        self.operands.iter().filter_map(|operand| match operand {
            Operand::Recorded(i) => Some(*i as usize),
            _ => None,
        })
    }
}
