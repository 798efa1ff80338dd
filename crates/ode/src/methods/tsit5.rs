//! Tsit5: explicit Runge-Kutta method of order 5(4), 7 stages, first same as last.
//!
//! Coefficients and interpolant: Ch. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column
//! simplifying assumption, Comput. Math. Appl. 62 (2011) 770-775, doi 10.1016/j.camwa.2011.06.002.

#![allow(clippy::excessive_precision)] // coefficients as published

use crate::linear::rows::{set_scaled_sum, sum, with_avx2, write, write_with_avx2, Block, Shape};
use crate::linear::system::System;
use crate::methods::method::{Effort, Method, Restart, Target};
use hydrocrane_num::Archive;

const STAGES: usize = 7;

const A: [&[f64]; STAGES] = [
    &[],
    &[0.161],
    &[-0.008_480_655_492_356_989, 0.335_480_655_492_357],
    &[2.897_153_057_105_493_5, -6.359_448_489_975_075, 4.362_295_432_869_581_5],
    &[5.325_864_828_439_257, -11.748_883_564_062_828, 7.495_539_342_889_836_5, -0.092_495_066_361_755_25],
    &[
        5.861_455_442_946_42,
        -12.920_969_317_847_11,
        8.159_367_898_576_159,
        -0.071_584_973_281_401,
        -0.028_269_050_394_068_383,
    ],
    &[
        0.096_460_766_818_065_23,
        0.01,
        0.479_889_650_414_499_6,
        1.379_008_574_103_742,
        -3.290_069_515_436_081,
        2.324_710_524_099_774,
    ],
];

const NODES: [f64; STAGES] = [0.0, 0.161, 0.327, 0.9, 0.980_025_540_904_509_7, 1.0, 1.0];

const ERROR: [f64; STAGES] = [
    -0.001_780_011_052_225_777_14,
    -0.000_816_434_459_656_746_9,
    0.007_880_878_010_261_995,
    -0.144_711_007_173_262_9,
    0.582_357_165_452_555_2,
    -0.458_082_105_929_186_97,
    0.015_151_515_151_515_152,
];

pub struct Tsit5 {
    shape: Shape,
    /// Derivatives at the stages.
    k: Vec<Block>,
    start: Vec<Block>,
    argument: Vec<Block>,
    /// Size of the last attempt.
    step: f64,
    effort: Effort,
}

impl Tsit5 {
    pub fn new(n: usize) -> Self {
        let shape = Shape::new(n);
        let (k, start, argument) = (shape.rows(STAGES), shape.rows(1), shape.rows(1));
        Tsit5 { shape, k, start, argument, step: 0.0, effort: Effort::default() }
    }

    /// Derivative `I`; the last one is at the new state.
    #[inline(always)]
    fn stage<const I: usize>(&mut self, system: &dyn System, t: f64, h: f64) {
        let (done, k) = self.shape.split::<I>(&mut self.k);
        set_scaled_sum(&mut self.argument, &self.start, h, A[I], done);
        system.derivative(t + NODES[I] * h, self.shape.states(&self.argument), self.shape.states_mut(k));
    }
}

impl Method for Tsit5 {
    fn order(&self) -> u32 {
        5
    }

    /// The last derivative of a step is the first of the next.
    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], restart: Restart) {
        if restart == Restart::None {
            let blocks = self.k.len() / STAGES;
            self.k.copy_within((STAGES - 1) * blocks.., 0);
            return;
        }
        let (_, first) = self.shape.split::<0>(&mut self.k);
        system.derivative(t, x, self.shape.states_mut(first));
        self.effort.derivatives += 1;
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool {
        self.shape.states_mut(&mut self.start).copy_from_slice(x);
        with_avx2(
            #[inline(always)]
            || {
                self.stage::<1>(system, t, h);
                self.stage::<2>(system, t, h);
                self.stage::<3>(system, t, h);
                self.stage::<4>(system, t, h);
                self.stage::<5>(system, t, h);
                self.stage::<6>(system, t, h);
            },
        );
        self.effort.derivatives += STAGES as u64 - 1;
        self.step = h;
        to.x.copy_from_slice(self.shape.states(&self.argument));
        let derivatives = self.shape.all::<STAGES>(&self.k);
        write(&mut to.error, |i| sum(&ERROR, &derivatives, i).map(|error| h * error));
        true
    }

    fn interpolate(&self, theta: f64, x: &mut [f64]) {
        let (b, derivatives) = (interpolant(theta), self.shape.all::<STAGES>(&self.k));
        write_with_avx2(
            x,
            #[inline(always)]
            |i| {
                let (sum, start) = (sum(&b, &derivatives, i), &self.start[i]);
                hydrocrane_num::array::from_fn(|lane| start[lane] + self.step * sum[lane])
            },
        );
    }

    /// The derivative at the end of the last step.
    fn archive(&mut self, _system: &dyn System, _t: f64, archive: &mut Archive) {
        let (_, last) = self.shape.split::<{ STAGES - 1 }>(&mut self.k);
        archive.numbers(self.shape.states_mut(last));
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// Weights of the derivatives at the fraction `t` of a step.
fn interpolant(t: f64) -> [f64; STAGES] {
    let t2 = t * t;
    [
        -1.053_088_497_729_021_6
            * t
            * (t - 1.329_989_018_975_141_2)
            * (t2 - 1.436_402_854_171_635_1 * t + 0.713_981_691_707_420_9),
        0.1017 * t2 * (t2 - 2.196_656_833_824_975_4 * t + 1.294_985_250_737_463_1),
        2.490_627_285_651_252_793 * t2 * (t2 - 2.385_356_454_720_616_57 * t + 1.578_034_682_080_924_86),
        -16.548_102_889_244_902_72 * (t - 1.217_129_272_955_332_44) * (t - 0.616_204_060_378_000_89) * t2,
        47.379_521_962_819_281_22 * (t - 1.203_071_208_372_362_603) * (t - 0.658_047_292_653_547_382) * t2,
        -34.870_657_861_496_609_74 * (t - 1.2) * (t - 2.0 / 3.0) * t2,
        2.5 * (t - 1.0) * (t - 0.6) * t2,
    ]
}
