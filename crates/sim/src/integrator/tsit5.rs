//! Tsit5: explicit Runge-Kutta method of order 5(4), 7 stages, first same as last.
//!
//! Coefficients and interpolant: Ch. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column
//! simplifying assumption, Comput. Math. Appl. 62 (2011) 770-775, doi 10.1016/j.camwa.2011.06.002.

#![allow(clippy::excessive_precision)] // coefficients as published

use super::{add_combination, Effort, Method, Point, Target};
use crate::system::System;

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
    n: usize,
    m: usize,
    /// Slopes of states and quadratures, stage by stage.
    k: [Vec<f64>; STAGES],
    kappa: [Vec<f64>; STAGES],
    argument: Vec<f64>,
    /// Start of the last accepted step, its size and its slopes over states then quadratures.
    start: Vec<f64>,
    step: f64,
    slopes: [Vec<f64>; STAGES],
    effort: Effort,
}

impl Tsit5 {
    pub fn new(n: usize, m: usize) -> Self {
        Tsit5 {
            n,
            m,
            k: std::array::from_fn(|_| vec![0.0; n]),
            kappa: std::array::from_fn(|_| vec![0.0; m]),
            argument: vec![0.0; n],
            start: vec![0.0; n + m],
            step: 0.0,
            slopes: std::array::from_fn(|_| vec![0.0; n + m]),
            effort: Effort::default(),
        }
    }
}

impl Method for Tsit5 {
    fn order(&self) -> u32 {
        5
    }

    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64]) {
        system.derivative(t, x, &mut self.k[0], &mut self.kappa[0]);
        self.effort.derivatives += 1;
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, from: Point, to: &mut Target) -> bool {
        for i in 1..STAGES {
            self.argument.copy_from_slice(from.x);
            add_combination(&mut self.argument, h, A[i], &self.k);
            system.derivative(t + NODES[i] * h, &self.argument, &mut self.k[i], &mut self.kappa[i]);
        }
        self.effort.derivatives += STAGES as u64 - 1;
        to.x.copy_from_slice(&self.argument);
        to.w.copy_from_slice(from.w);
        add_combination(&mut to.w, h, A[STAGES - 1], &self.kappa);
        to.error.fill(0.0);
        add_combination(&mut to.error, h, &ERROR, &self.k);
        self.step = h;
        true
    }

    fn accept(&mut self, from: Point, _to: Point) {
        self.start[..self.n].copy_from_slice(from.x);
        self.start[self.n..].copy_from_slice(from.w);
        for (i, slopes) in self.slopes.iter_mut().enumerate() {
            slopes[..self.n].copy_from_slice(&self.k[i]);
            slopes[self.n..].copy_from_slice(&self.kappa[i]);
        }
    }

    fn interpolate(&self, theta: f64, x: &mut [f64], w: &mut [f64]) {
        let b = interpolant(theta);
        let at = |i: usize| {
            let sum: f64 = b.iter().zip(&self.slopes).map(|(b, slopes)| b * slopes[i]).sum();
            self.start[i] + self.step * sum
        };
        (0..self.n).for_each(|i| x[i] = at(i));
        (0..self.m).for_each(|i| w[i] = at(self.n + i));
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// Weights of the slopes at the fraction `t` of a step.
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
