//! The number type that records.

use crate::operation::{Kind, Operand, Operation};
use crate::recorder::{recording, Table};
use hydrocrane_machine::Number;
use hydrocrane_num::{portable, Field, Mask, Real};
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// A number of a law that is being recorded: a constant, or the result of an operation of this thread's tape.
///
/// Constants are folded, with the bits of the laws, and so is what a finite number does not change: x + 0, 1 x, 0 x. So parts that a
/// machine lacks leave no operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Traced {
    Constant(f64),
    Recorded(u32),
}

/// Outcome of a comparison of such numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TracedMask {
    Known(bool),
    Recorded(u32),
}

impl Default for Traced {
    fn default() -> Self {
        Traced::Constant(0.0)
    }
}

/// A state, by its index.
pub fn state(index: usize) -> Traced {
    Traced::Recorded(recording(|tape| tape.input(Kind::State, index, f64::NAN)))
}

/// A spool command.
pub fn command(index: usize) -> Traced {
    Traced::Recorded(recording(|tape| tape.input(Kind::Command, index, f64::NAN)))
}

/// A parameter, which choices of formulas see with this `value`.
pub fn parameter(index: usize, value: f64) -> Traced {
    Traced::Recorded(recording(|tape| tape.input(Kind::Parameter, index, value)))
}

use Traced::Constant;

impl Traced {
    pub fn operand(self) -> Operand {
        match self {
            Constant(x) => Operand::Constant(x.to_bits()),
            Traced::Recorded(at) => Operand::Recorded(at),
        }
    }

    fn one(self, kind: Kind) -> Self {
        match self {
            Constant(x) => Constant(kind.of([x, 0.0, 0.0])),
            _ => Traced::Recorded(recording(|tape| tape.apply(kind, [self.operand(), Operand::None, Operand::None]))),
        }
    }

    fn two(self, kind: Kind, other: Self) -> Self {
        match (self, other) {
            (Constant(a), Constant(b)) => Constant(kind.of([a, b, 0.0])),
            _ => Traced::Recorded(recording(|tape| tape.apply(kind, [self.operand(), other.operand(), Operand::None]))),
        }
    }

    /// The operation whose result it is.
    pub(crate) fn operation(self) -> Option<Operation> {
        let Traced::Recorded(at) = self else { return None };
        Some(recording(|tape| tape.operations[at as usize]))
    }

    /// `-(self * other)`
    fn times_negative(self, other: Self) -> Self {
        match other {
            Constant(x) => self * Constant(-x),
            _ => -(self * other),
        }
    }

    /// The number whose negative this was recorded as.
    fn negated(self) -> Option<Self> {
        match self.operation()? {
            Operation { kind: Kind::Negate, operands: [Operand::Recorded(of), ..] } => Some(Traced::Recorded(of)),
            _ => None,
        }
    }
}

impl TracedMask {
    fn operand(self) -> Operand {
        match self {
            TracedMask::Known(holds) => Operand::Constant(f64::from(u8::from(holds)).to_bits()),
            TracedMask::Recorded(at) => Operand::Recorded(at),
        }
    }

    fn recorded(kind: Kind, operands: [Operand; 2]) -> Self {
        TracedMask::Recorded(recording(|tape| tape.apply(kind, [operands[0], operands[1], Operand::None])))
    }
}

impl Add for Traced {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match (self, other) {
            (Constant(0.0), x) | (x, Constant(0.0)) => x,
            _ => match (self.negated(), other.negated()) {
                (_, Some(b)) => self - b,
                (Some(a), None) => other - a,
                _ => self.two(Kind::Add, other),
            },
        }
    }
}

impl Sub for Traced {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match (self, other) {
            (x, Constant(0.0)) => x,
            (Constant(0.0), x) => -x,
            _ if self == other => Constant(0.0),
            _ => match other.negated() {
                Some(b) => self + b,
                None => self.two(Kind::Subtract, other),
            },
        }
    }
}

impl Mul for Traced {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (Constant(a), Constant(b)) => Constant(a * b),
            (Constant(0.0), _) | (_, Constant(0.0)) => Constant(0.0),
            (Constant(1.0), x) | (x, Constant(1.0)) => x,
            (Constant(-1.0), x) | (x, Constant(-1.0)) => -x,
            _ => match (self.negated(), other.negated()) {
                (Some(a), Some(b)) => a * b,
                (Some(a), None) => a.times_negative(other),
                (None, Some(b)) => b.times_negative(self),
                _ => self.two(Kind::Multiply, other),
            },
        }
    }
}

impl Div for Traced {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        match (self, other) {
            (Constant(a), Constant(b)) => Constant(a / b),
            (x, Constant(1.0)) => x,
            (Constant(0.0), _) => Constant(0.0),
            _ => self.two(Kind::Divide, other),
        }
    }
}

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        self.negated().unwrap_or_else(|| self.one(Kind::Negate))
    }
}

macro_rules! with_constants {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator<f64> for Traced {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                self.$method(Constant(other))
            }
        }
    )*};
}

with_constants!(Add add, Sub sub, Mul mul, Div div);

impl AddAssign for Traced {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Traced {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl BitAnd for TracedMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        match (self, other) {
            (TracedMask::Known(true), mask) | (mask, TracedMask::Known(true)) => mask,
            (TracedMask::Known(false), _) | (_, TracedMask::Known(false)) => TracedMask::Known(false),
            _ => Self::recorded(Kind::And, [self.operand(), other.operand()]),
        }
    }
}

impl BitOr for TracedMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        match (self, other) {
            (TracedMask::Known(false), mask) | (mask, TracedMask::Known(false)) => mask,
            (TracedMask::Known(true), _) | (_, TracedMask::Known(true)) => TracedMask::Known(true),
            _ => Self::recorded(Kind::Or, [self.operand(), other.operand()]),
        }
    }
}

impl Not for TracedMask {
    type Output = Self;
    fn not(self) -> Self {
        match self {
            TracedMask::Known(holds) => TracedMask::Known(!holds),
            TracedMask::Recorded(_) => Self::recorded(Kind::Not, [self.operand(), Operand::None]),
        }
    }
}

impl Mask for TracedMask {}

impl Field for Traced {
    type Mask = TracedMask;

    fn c(x: f64) -> Self {
        Constant(x)
    }
    fn select(mask: TracedMask, a: Self, b: Self) -> Self {
        match mask {
            TracedMask::Known(true) => a,
            TracedMask::Known(false) => b,
            _ if a == b => a,
            _ if is_positive_part(mask, a, b) => a.one(Kind::Positive),
            _ => {
                let operands = [mask.operand(), a.operand(), b.operand()];
                Traced::Recorded(recording(|tape| tape.apply(Kind::Select, operands)))
            }
        }
    }
    fn nearer_zero(self, other: Self) -> TracedMask {
        self.abs().lt(other.abs())
    }
    fn finite(self) -> TracedMask {
        self.abs().le(Constant(f64::MAX))
    }
}

/// Whether a selection of `x` where `mask` holds, else of `otherwise`, is the positive part of `x` as the laws write it, with the slope 1/2 at
/// zero: what is half of neither above nor below zero is zero.
fn is_positive_part(mask: TracedMask, x: Traced, otherwise: Traced) -> bool {
    let (TracedMask::Recorded(at), zero) = (mask, Constant(0.0)) else { return false };
    let above = Operation { kind: Kind::Less, operands: [zero.operand(), x.operand(), Operand::None] };
    recording(|tape| tape.operations[at as usize]) == above
        && otherwise.operation().is_some_and(|operation| operation.kind == Kind::Select)
        && otherwise == Traced::select(x.lt(zero), zero, x * Constant(0.5))
}

/// A function of its own for every closure: the laws stay short enough to be compiled in little time.
#[inline(never)]
fn called<O>(mut f: impl FnMut() -> O) -> O {
    f()
}

impl Real for Traced {
    fn look_up_row<const K: usize>(
        self,
        starts: impl Fn(usize) -> Option<f64>,
        f: impl Fn(f64) -> [f64; K],
    ) -> [Self; K] {
        if let Constant(x) = self {
            return f(x).map(Constant);
        }
        let starts: Vec<f64> = (0..).map_while(starts).collect();
        let rows: Vec<[f64; K]> = std::iter::once(f64::NEG_INFINITY).chain(starts.iter().copied()).map(f).collect();
        let columns = (0..K).map(|k| rows.iter().map(|row| row[k]).collect()).collect();
        recording(|tape| tape.row(Table { starts, columns }, self.operand())).map(Traced::Recorded)
    }
    fn outlined<O>(f: impl FnMut() -> O) -> O {
        called(f)
    }
    fn outlined_if_dual<O>(f: impl FnMut() -> O) -> O {
        called(f)
    }
    fn sqrt(self) -> Self {
        self.one(Kind::Root)
    }
    fn exp(self) -> Self {
        self.one(Kind::Exp)
    }
    fn ln(self) -> Self {
        self.one(Kind::Ln)
    }
    fn sin_cos(self) -> (Self, Self) {
        (self.one(Kind::Sin), self.one(Kind::Cos))
    }
    fn tanh(self) -> Self {
        self.one(Kind::Tanh)
    }
    fn abs(self) -> Self {
        self.one(Kind::Magnitude)
    }
    /// What is recorded is finite.
    fn lt(self, other: Self) -> TracedMask {
        match (self, other) {
            (Constant(a), Constant(b)) => TracedMask::Known(a < b),
            (_, Constant(f64::INFINITY)) | (Constant(f64::NEG_INFINITY), _) => TracedMask::Known(true),
            (Constant(f64::INFINITY), _) | (_, Constant(f64::NEG_INFINITY)) => TracedMask::Known(false),
            _ if self == other => TracedMask::Known(false),
            _ => TracedMask::recorded(Kind::Less, [self.operand(), other.operand()]),
        }
    }
    fn le(self, other: Self) -> TracedMask {
        match (self, other) {
            (Constant(a), Constant(b)) => TracedMask::Known(a <= b),
            (_, Constant(f64::INFINITY)) | (Constant(f64::NEG_INFINITY), _) => TracedMask::Known(true),
            (Constant(f64::INFINITY), _) | (_, Constant(f64::NEG_INFINITY)) => TracedMask::Known(false),
            _ if self == other => TracedMask::Known(true),
            _ => TracedMask::recorded(Kind::LessOrEqual, [self.operand(), other.operand()]),
        }
    }
}

/// Values of a machine file; those that are parameters are recorded.
impl Number for Traced {
    fn read(value: f64, variable: impl FnOnce() -> Option<usize>) -> Self {
        variable().map_or(Constant(value), |index| parameter(index, value))
    }
    fn plain(self) -> f64 {
        recording(|tape| tape.value(self.operand()))
    }
    fn always(self, value: f64) -> bool {
        if let Constant(x) = self {
            return x == value;
        }
        if self.plain() == value {
            recording(|tape| tape.note_decisive(self.operand()));
        }
        false
    }
    fn stated_sin_cos(self) -> (Self, Self) {
        match self {
            Constant(angle) => {
                let (sin, cos) = portable::sin_cos(angle);
                (Constant(sin), Constant(cos))
            }
            _ => self.sin_cos(),
        }
    }
}
