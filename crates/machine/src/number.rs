//! The number type of a machine: plain, or with derivatives by some values of the file.

use hydrocrane_num::{portable, Dual, Field, Real};

/// A value of the file as an independent variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// Dotted path of the value.
    pub key: String,
    /// Which value of a pair or point; `None`: the only one, or both at once.
    pub element: Option<usize>,
}

/// Operations of a number of a machine file besides arithmetic.
///
/// Checks of a file and choices between formulas look at [`Number::plain`] values; all that enters the equations of motion is
/// computed in the type itself.
pub trait Number: Real {
    /// The `value` that stands in the file. `variable` is called where the type has derivatives: it gives the index of the
    /// independent variable that the value is, if it is one.
    fn read(value: f64, variable: impl FnOnce() -> Option<usize>) -> Self;
    /// The value without derivatives.
    fn plain(self) -> f64;
    /// Whether it equals `value` for all values of the independent variables.
    fn always(self, value: f64) -> bool;
    /// Sine and cosine of an angle that the file states; plain values have the bits of [`portable`].
    fn stated_sin_cos(self) -> (Self, Self) {
        let plain = self.plain();
        let (sin, cos) = portable::sin_cos(plain);
        let (sin, cos, beyond) = (Self::c(sin), Self::c(cos), self - plain);
        // The linear terms are exact for the derivatives.
        (sin + cos * beyond, cos - sin * beyond)
    }
}

impl Number for f64 {
    #[inline(always)]
    fn read(value: f64, _: impl FnOnce() -> Option<usize>) -> f64 {
        value
    }
    #[inline(always)]
    fn plain(self) -> f64 {
        self
    }
    #[inline(always)]
    fn always(self, value: f64) -> bool {
        self == value
    }
}

impl<const N: usize> Number for Dual<f64, N> {
    fn read(value: f64, variable: impl FnOnce() -> Option<usize>) -> Self {
        variable().map_or(Self::c(value), |index| Self::variable(value, index))
    }
    fn plain(self) -> f64 {
        self.value
    }
    fn always(self, value: f64) -> bool {
        self.value == value && self.derivative == [0.0; N]
    }
}
