//! The exponential of a linearised system as a rational function: a sum over poles, solved side by side.
//!                                                              theory: docs/theory/integration.md
//!
//! The [7/8] Padé approximant of e^z has eight simple poles, four of them with their complex conjugates:
//!     r(z) = 2 Re sum_j c_j/(z - theta_j) = e^z + O(z^16)
//! and with phi_0 = e^z, phi_k = (phi_(k-1) - 1/(k-1)!)/z the same poles give phi_k = 2 Re sum_j c_j theta_j^-k/(z - theta_j).
//! Any other sum over them is given by the first eight terms of its power series. With z = h J and
//!     y_j = (theta_j/h I - J)^-1 f
//! all such functions of h J times h f are sums Re sum_j w_j y_j: one complex solve for each pole, the four of them in the
//! lanes of a register.

use crate::linear::{Factored, Linearisation};
use hydrocrane_num::lanes::register::{Register, WIDEST};
use hydrocrane_num::{Complex, Field, Lanes};

/// Number of conjugate pairs of poles.
const COUNT: usize = 4;
/// Terms of a power series that determine a sum over the poles.
pub const TERMS: usize = 2 * COUNT;

/// One number for each pole: real parts, imaginary parts.
pub type Weights = [[f64; COUNT]; 2];

/// Upper poles theta of the [7/8] Padé approximant of e^z, real and imaginary parts.
const POLES: Weights = [
    [10.169_446_006_657_514, 9.406_371_213_690_74, 7.738_688_146_830_548, 4.685_494_632_821_197],
    [1.649_201_796_822_227_7, 4.969_217_287_623_294, 8.370_879_306_237_983, 12.010_578_599_813_79],
];
/// Its residues c at the poles: e^z ~ 2 Re sum_j c_j/(z - theta_j).
const RESIDUES: Weights = [
    [2_612.620_846_868_210_7, -3_848.544_415_437_437, 1_334.864_737_460_017_3, -94.941_168_890_791_3],
    [-13_549.060_147_438_92, 5_690.315_433_804_313, -702.431_010_498_013_7, -25.476_662_481_767_77],
];
/// Weights with which a sum over the poles is z^m + O(z^8), m = 0 to 7.
const POWERS: [Weights; TERMS] = [
    [
        [218.558_903_638_410_27, -46.376_534_363_835_61, -91.386_220_608_024_4, -16.796_148_666_550_273],
        [-152.679_317_100_819_22, -185.443_815_088_116_45, -15.697_380_399_216_95, 18.749_374_657_986_486],
    ],
    [
        [-11_513.347_858_932_92, 3_453.373_913_273_441_8, 5_272.909_533_456_553, 771.064_412_202_925_8],
        [8_579.259_959_454_27, 9_893.595_725_336_778, 118.172_190_955_163_84, -1_313.841_347_516_145_3],
    ],
    [
        [309_381.449_387_213_9, -110_174.803_224_666_18, -144_418.423_387_746_56, -14_468.222_774_801_186],
        [-239_543.016_316_894_12, -263_631.331_836_475_4, 13_407.468_145_884_784, 40_903.672_456_617_74],
    ],
    [
        [-5_271_002.276_769_948, 2_143_598.139_744_277, 2_454_850.976_009_402, 118_153.161_016_268_83],
        [4_230_242.737_031_355, 4_449_797.916_694_775, -472_234.599_260_009_07, -738_092.575_288_222],
    ],
    [
        [60_589_359.199_647_55, -27_659_683.549_968_667, -27_714_175.720_174_167, 106_740.070_495_282_34],
        [-50_319_134.717_301_76, -50_301_595.120_778_6, 8_192_157.245_832_636, 8_355_412.337_551_919],
    ],
    [
        [-464_076_314.951_385_3, 236_609_351.197_560_37, 203_332_476.061_373_03, -10_460_072.307_548_065],
        [400_802_325.097_704_23, 376_374_036.401_064_5, -85_050_243.994_223_67, -59_357_422.110_681_206],
    ],
    [
        [2_180_546_162.864_841_5, -1_249_024_778.943_726_8, -875_994_142.193_944_8, 82_850_998.272_830_08],
        [-1_971_291_684.259_883_6, -1_699_270_007.726_937_3, 500_850_333.001_597_9, 244_875_963.240_952_25],
    ],
    [
        [-4_817_792_165.792_464, 3_112_754_375.460_843_6, 1_674_261_195.055_393, -228_682_604.723_772_14],
        [4_676_711_488.209_936, 3_470_748_741.611_263_3, -1_284_740_829.687_248_5, -452_052_027.971_506_95],
    ],
];

type Number<R> = Complex<Lanes<R>>;

/// Weights for the poles in registers, as many as are needed.
pub struct Spread<R>([Number<R>; COUNT]);

/// `sum_m t_m z^m` to eight terms.
pub fn series(terms: [f64; TERMS]) -> Weights {
    each(|j| terms.iter().zip(&POWERS).fold(Complex::c(0.0), |sum, (term, power)| sum + at(power, j) * *term))
}

/// phi_k
pub fn phi(k: usize) -> Weights {
    each(|j| {
        let quotient = (0..k).fold(at(&RESIDUES, j), |quotient, _| quotient / at(&POLES, j));
        quotient * -2.0
    })
}

pub fn scaled(weights: Weights, factor: f64) -> Weights {
    each(|j| at(&weights, j) * factor)
}

pub fn plus(a: Weights, b: Weights) -> Weights {
    each(|j| at(&a, j) + at(&b, j))
}

/// Every weight times its pole: the sum is z times the function, minus its value at infinity.
pub fn times_poles(weights: Weights) -> Weights {
    each(|j| at(&weights, j) * at(&POLES, j))
}

/// `-z` times the sum where `z` is large.
pub fn at_infinity(weights: Weights) -> f64 {
    weights[0].iter().sum()
}

fn at(weights: &Weights, j: usize) -> Complex<f64> {
    Complex::new(weights[0][j], weights[1][j])
}

fn each(of: impl Fn(usize) -> Complex<f64>) -> Weights {
    [hydrocrane_num::array::from_fn(|j| of(j).re), hydrocrane_num::array::from_fn(|j| of(j).im)]
}

/// Increments y of all states at all poles.
pub struct Increments<R>(Vec<Number<R>>);

/// The matrices `theta_j/h I - J` of a linearised system of `n` equations, factored.
pub struct Poles<R> {
    n: usize,
    at: Spread<R>,
    inverses: Spread<R>,
    powers: [Spread<R>; TERMS],
    /// Factors, one entry per register of poles.
    factored: Vec<Factored<Number<R>>>,
}

impl<R: Register> Spread<R> {
    pub fn new([re, im]: &Weights) -> Self {
        R::run(
            #[inline(always)]
            || {
                let mut numbers = [Number::c(0.0); COUNT];
                for register in 0..COUNT / R::WIDTH {
                    let from = register * R::WIDTH;
                    numbers[register] = Number::new(Lanes::load(&re[from..]), Lanes::load(&im[from..]));
                }
                Spread(numbers)
            },
        )
    }
}

impl<R: Register> Poles<R> {
    pub fn new(n: usize) -> Self {
        let inverses = each(|j| Complex::c(1.0) / at(&POLES, j));
        let factored = (0..COUNT / R::WIDTH).map(|_| Factored::default()).collect();
        Poles {
            n,
            at: Spread::new(&POLES),
            inverses: Spread::new(&inverses),
            powers: POWERS.each_ref().map(Spread::new),
            factored,
        }
    }

    /// Room for increments.
    pub fn increments(&self) -> Increments<R> {
        Increments(vec![Number::default(); self.n * self.factored.len()])
    }

    /// Factors the matrices for a step of size `h`; `false` if this fails.
    pub fn factor(&mut self, jacobian: &Linearisation, h: f64) -> bool {
        let inverse = 1.0 / h;
        R::run(
            #[inline(always)]
            || {
                let mut sound = true;
                for (factored, pole) in self.factored.iter_mut().zip(&self.at.0) {
                    sound &= !R::any(!factored.factor(jacobian, *pole * inverse));
                }
                sound
            },
        )
    }

    /// y_j = (theta_j/h I - J)^-1 (f + h f'/theta_j) with h and f' of a `drift`.
    pub fn solve(&self, jacobian: &Linearisation, f: &[f64], drift: Option<(f64, &[f64])>, y: &mut Increments<R>) {
        R::run(
            #[inline(always)]
            || {
                let (h, dfdt) = drift.unwrap_or((0.0, &[]));
                let rows = y.0.chunks_exact_mut(self.n);
                for ((factored, inverse), y) in self.factored.iter().zip(&self.inverses.0).zip(rows) {
                    for (y, f) in y.iter_mut().zip(f) {
                        *y = Number::c(*f);
                    }
                    for (y, dfdt) in y.iter_mut().zip(dfdt) {
                        *y += *inverse * (h * *dfdt);
                    }
                    factored.solve(jacobian, y);
                }
            },
        );
    }

    /// The sums over the poles of the increments, with one column of weights for each row of sums.
    pub fn sums<const ROWS: usize, const COLUMNS: usize>(
        &self,
        increments: [&Increments<R>; ROWS],
        weights: [[&Spread<R>; ROWS]; COLUMNS],
        sums: [&mut [f64]; COLUMNS],
    ) {
        self.sums_at(0..self.n, increments, weights, sums);
    }

    /// The same for these `states`; the others are left as they are.
    pub fn sums_of<const ROWS: usize, const COLUMNS: usize>(
        &self,
        states: &[usize],
        increments: [&Increments<R>; ROWS],
        weights: [[&Spread<R>; ROWS]; COLUMNS],
        sums: [&mut [f64]; COLUMNS],
    ) {
        self.sums_at(states.iter().copied(), increments, weights, sums);
    }

    #[inline(always)]
    fn sums_at<const ROWS: usize, const COLUMNS: usize>(
        &self,
        states: impl Iterator<Item = usize> + Clone,
        increments: [&Increments<R>; ROWS],
        weights: [[&Spread<R>; ROWS]; COLUMNS],
        mut sums: [&mut [f64]; COLUMNS],
    ) {
        R::run(
            #[inline(always)]
            || {
                let registers = COUNT / R::WIDTH;
                let mut totals = [[0.0; WIDEST]; COLUMNS];
                // Copies, which stay in registers while sums are written.
                let mut columns = [[[Number::c(0.0); COUNT]; ROWS]; COLUMNS];
                for column in 0..COLUMNS {
                    for row in 0..ROWS {
                        columns[column][row] = weights[column][row].0;
                    }
                }
                let mut rows: [&[Number<R>]; ROWS] = [&[]; ROWS];
                for row in 0..ROWS {
                    rows[row] = &increments[row].0[..registers * self.n];
                }
                for i in states.clone() {
                    for register in 0..registers {
                        let at = register * self.n + i;
                        for column in 0..COLUMNS {
                            let mut total = columns[column][0][register].re_of_product(rows[0][at]);
                            for row in 1..ROWS {
                                total += columns[column][row][register].re_of_product(rows[row][at]);
                            }
                            total.store(&mut totals[column][register * R::WIDTH..]);
                        }
                    }
                    for column in 0..COLUMNS {
                        let of = &totals[column];
                        sums[column][i] = (of[0] + of[1]) + (of[2] + of[3]);
                    }
                }
            },
        );
    }

    /// [`series`]
    #[inline(always)]
    pub fn series(&self, terms: [f64; TERMS]) -> Spread<R> {
        R::run(
            #[inline(always)]
            || {
                let mut sum = [Number::c(0.0); COUNT];
                for register in 0..COUNT / R::WIDTH {
                    for m in 0..TERMS {
                        sum[register] += self.powers[m].0[register] * terms[m];
                    }
                }
                Spread(sum)
            },
        )
    }
}

/// The function at a number `z`.
#[cfg(test)]
pub fn value(weights: Weights, z: Complex<f64>) -> Complex<f64> {
    let conjugate = |number: Complex<f64>| Complex { im: -number.im, ..number };
    (0..COUNT).fold(Complex::c(0.0), |sum, j| {
        let (weight, pole) = (at(&weights, j) * 0.5, at(&POLES, j));
        sum + weight / (pole - z) + conjugate(weight) / (conjugate(pole) - z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// phi_k by its power series.
    fn exact(k: usize, z: Complex<f64>) -> Complex<f64> {
        let mut term = Complex::c((1..=k).fold(1.0, |product, i| product / i as f64));
        let mut sum = term;
        for i in k + 1..60 {
            term = term * z * (1.0 / i as f64);
            sum += term;
        }
        sum
    }

    #[test]
    fn phi_functions_are_those_of_the_exponential() {
        for k in [1, 3, 4] {
            for z in [Complex::new(0.0, 0.0), Complex::new(-1.0, 0.0), Complex::new(0.0, 2.0), Complex::new(-1.0, -1.5)]
            {
                let off = value(phi(k), z) - exact(k, z);
                assert!(off.re.hypot(off.im) < 1e-10, "{k} {z:?}: {off:?}");
            }
        }
    }

    #[test]
    fn sums_have_the_power_series_they_are_given() {
        let terms = [1.0, -0.5, 0.2, 0.05, 0.0, 1e-3, -3e-4, 2e-5];
        let z = Complex::new(0.1, -0.2);
        let wanted = terms.iter().rev().fold(Complex::c(0.0), |sum, term| sum * z + *term);
        let off = value(series(terms), z) - wanted;
        assert!(off.re.hypot(off.im) < 1e-9, "{off:?}");
    }

    #[test]
    fn weights_times_their_poles_belong_to_z_times_the_function() {
        let (weights, z) = (phi(1), Complex::new(-0.7, 1.3));
        let off = value(times_poles(weights), z) - (z * value(weights, z) + at_infinity(weights));
        assert!(off.re.hypot(off.im) < 1e-9, "{off:?}");
    }
}
