//! Complex numbers over any [`Real`], as far as linear systems need them.

use crate::{Field, Real};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `re + i im`
#[derive(Debug, Clone, Copy, Default)]
pub struct Complex<T> {
    pub re: T,
    pub im: T,
}

impl<T: Real> Complex<T> {
    #[inline(always)]
    pub fn new(re: T, im: T) -> Self {
        Complex { re, im }
    }

    /// The real part of `self * o`.
    #[inline(always)]
    pub fn re_of_product(self, o: Self) -> T {
        self.re * o.re - self.im * o.im
    }
}

impl<T: Real> Neg for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Complex { re: -self.re, im: -self.im }
    }
}

impl<T: Real> Add for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Complex { re: self.re + o.re, im: self.im + o.im }
    }
}

impl<T: Real> Sub for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Complex { re: self.re - o.re, im: self.im - o.im }
    }
}

impl<T: Real> Mul for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Complex { re: self.re_of_product(o), im: self.re * o.im + self.im * o.re }
    }
}

/// Without care for squares that overflow: numbers of linear systems in scaled units are far from there.
impl<T: Real> Div for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let inverse = T::c(1.0) / (o.re.square() + o.im.square());
        let (re, im) = (o.re * inverse, o.im * inverse);
        Complex { re: self.re * re + self.im * im, im: self.im * re - self.re * im }
    }
}

impl<T: Real> Add<f64> for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: f64) -> Self {
        Complex { re: self.re + o, im: self.im }
    }
}

impl<T: Real> Sub<f64> for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: f64) -> Self {
        Complex { re: self.re - o, im: self.im }
    }
}

impl<T: Real> Mul<f64> for Complex<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        Complex { re: self.re * o, im: self.im * o }
    }
}

impl<T: Real> AddAssign for Complex<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<T: Real> SubAssign for Complex<T> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<T: Real> Field for Complex<T> {
    type Mask = T::Mask;

    #[inline(always)]
    fn c(x: f64) -> Self {
        Complex { re: T::c(x), im: T::c(0.0) }
    }
    #[inline(always)]
    fn select(mask: T::Mask, a: Self, b: Self) -> Self {
        Complex { re: T::select(mask, a.re, b.re), im: T::select(mask, a.im, b.im) }
    }
    /// By the sum of the sizes of both parts, which serves as well as the root of their squares.
    #[inline(always)]
    fn nearer_zero(self, other: Self) -> T::Mask {
        (self.re.abs() + self.im.abs()).lt(other.re.abs() + other.im.abs())
    }
    #[inline(always)]
    fn finite(self) -> T::Mask {
        self.re.finite() & self.im.finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quotient_times_its_divisor_is_the_dividend() {
        let (a, b) = (Complex { re: 1.5, im: -2.0 }, Complex { re: -0.25, im: 3.0 });
        let off = a / b * b - a;
        assert!(off.re.abs() < 1e-15 && off.im.abs() < 1e-15);
        assert_eq!((a * b).re, a.re_of_product(b));
        // i i = -1
        let i = Complex { re: 0.0, im: 1.0 };
        assert_eq!([(i * i).re, (i * i).im], [-1.0, 0.0]);
    }

    #[test]
    fn sizes_and_masks_see_both_parts() {
        let (small, large) = (Complex { re: 1.0, im: 0.5 }, Complex { re: -0.25, im: 3.0 });
        assert!(small.nearer_zero(large) && !large.nearer_zero(small));
        assert!(small.finite() && !Complex { re: 0.0, im: f64::NAN }.finite());
    }
}
