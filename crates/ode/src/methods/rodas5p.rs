//! Rodas5P: stiffly accurate Rosenbrock method of order 5(4), 8 stages, L-stable.
//!
//! Coefficients and interpolant: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and numerical
//! benchmarks within the Julia Differential Equations package, BIT 63:27 (2023), doi 10.1007/s10543-023-00967-x.
//!
//! Stage i, with W = I/(h gamma) - J:
//!     W k_i = f(t + c_i h, x + sum_j a_ij k_j) + sum_j C_ij/h k_j + h d_i f_t
//! and x_new = x + sum_j a_8j k_j + k_8, error k_8. A quadrature's row needs no solve:
//!     kappa_i = h gamma (g + sum_j C_ij/h kappa_j + g_x k_i).
//!
//! Tangents of the state are integrated with the derivative of the step: W k_i' = r' + J' k_i, where r' is the
//! right-hand side of the stage with tangents in place of states. One factorisation serves state and tangents.

use crate::linear::rows::{add_sum, sum, with_avx2, write_with_avx2, Block, Cell, Shape};
use crate::linear::system::System;
use crate::linear::{Factored, Linearisation};
use crate::methods::method::{Effort, Method, Restart, Target};
use crate::methods::rosenbrock::{stages, Linearised};
use crate::methods::tableau::{arguments, Tableau};

const STAGES: usize = 8;
const GAMMA: f64 = TABLEAU.gamma;

pub(crate) const TABLEAU: Tableau<STAGES> = Tableau {
    gamma: 0.211_937_563_194_290_14,
    a: A,
    arguments: arguments(A),
    c: [
        &[],
        &[-14.155_112_264_123_755],
        &[-17.972_960_358_859_52, -2.859_693_295_451_294],
        &[147.121_502_757_117_16, -1.412_214_027_182_13, 71.689_402_513_023_58],
        &[165.435_170_248_716_76, -0.459_282_345_649_112_6, 42.909_383_369_586_03, -5.961_986_721_573_306],
        &[
            24.854_864_614_690_072,
            -3.000_922_700_283_218_6,
            47.493_111_002_076_8,
            5.581_419_782_155_812_5,
            -0.661_069_182_524_947_1,
        ],
        &[
            30.912_732_140_285_99,
            -3.120_824_334_993_797_4,
            77.799_546_460_708_92,
            34.286_460_282_947_83,
            -19.097_331_116_725_623,
            -28.087_943_162_872_662,
        ],
        &[
            37.802_771_233_905_63,
            -3.257_196_902_907_227_6,
            112.269_188_494_963_27,
            66.934_723_124_404_7,
            -40.066_189_370_910_02,
            -54.667_802_628_779_68,
            -9.488_616_523_096_27,
        ],
    ],
    weights: LAST,
    error: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
};
const A: [&[f64]; STAGES] = [
    &[],
    &[3.0],
    &[2.849_394_379_747_939, 0.458_422_422_044_639_23],
    &[-6.954_028_509_809_101, 2.489_845_061_869_568, -10.358_996_098_473_584],
    &[2.802_998_627_562_896_4, 0.507_246_473_622_820_6, -0.398_831_254_177_052_4, -0.047_211_872_304_046_41],
    LAST.split_at(5).0,
    LAST.split_at(6).0,
    LAST.split_at(7).0,
];
/// Weights of the increments in the new state; the last three stages begin with them.
const LAST: [f64; STAGES] = [
    -7.502_846_399_306_121,
    2.561_846_144_803_919,
    -11.627_539_656_261_098,
    -0.182_687_676_599_422_56,
    0.030_198_172_008_377_946,
    1.0,
    1.0,
    1.0,
];

const NODES: [f64; STAGES] = [
    0.0,
    0.635_812_689_582_870_4,
    0.409_579_839_339_753_5,
    0.976_930_672_506_071_6,
    0.428_840_360_955_866_4,
    1.0,
    1.0,
    1.0,
];

const D: [f64; STAGES] = [
    GAMMA,
    -0.423_875_126_388_580_27,
    -0.338_462_712_623_592_4,
    1.804_645_287_288_273_4,
    2.325_825_639_765_069,
    0.0,
    0.0,
    0.0,
];

/// Weights of the increments in the three terms of the interpolant.
const H: [[f64; STAGES]; 3] = [
    [
        25.948_786_856_663_858,
        -2.557_972_484_584_623_5,
        10.433_815_404_888_879,
        -2.367_925_102_268_520_4,
        0.524_948_541_321_073,
        1.124_108_831_045_040_4,
        0.427_287_619_443_187_4,
        -0.172_022_210_701_554_93,
    ],
    [
        -9.915_688_506_951_71,
        -0.968_994_459_411_515_4,
        3.043_803_724_297_845_3,
        -24.495_224_566_215_796,
        20.176_138_334_709_044,
        15.980_663_614_246_51,
        -6.789_040_303_419_874,
        -6.710_236_069_923_372,
    ],
    [
        11.419_903_575_922_262,
        2.887_964_514_613_699_4,
        72.921_379_959_960_29,
        80.125_118_346_226_43,
        -52.072_871_366_152_654,
        -59.789_936_252_667_29,
        -0.155_826_842_827_519_13,
        4.883_087_185_713_722,
    ],
];

/// p_1 to p_3: e^z to order two as sum_k p_k G^k with G = 1/(1 - gamma z), zero where z is infinite. L-stable for gamma from
/// 0.1805 to 2.185 (Hairer and Wanner 1996, table IV.6.4).
const FLOW: [f64; 3] = {
    let third = 0.5 / (GAMMA * GAMMA) - 2.0 / GAMMA + 1.0;
    let second = 1.0 / GAMMA - 1.0 - 2.0 * third;
    [1.0 - second - third, second, third]
};

pub struct Rodas5p {
    shape: Shape,
    linearisation: Linearisation,
    factored: Factored<f64>,
    /// df/dt, and whether it is nonzero.
    time_derivative: Vec<Block>,
    driven: bool,
    /// Increments, stage by stage.
    k: Vec<Block>,
    start: Vec<Block>,
    /// Argument of a stage; at the end the new state.
    argument: Vec<Block>,
    /// Work space for an error that is carried on.
    carried: Vec<f64>,
    effort: Effort,
}

impl Rodas5p {
    pub fn new(n: usize) -> Self {
        let shape = Shape::new(n);
        Rodas5p {
            shape,
            linearisation: Linearisation::new(n),
            factored: Factored::default(),
            time_derivative: shape.rows(1),
            driven: false,
            k: shape.rows(STAGES),
            start: shape.rows(1),
            argument: shape.rows(1),
            carried: vec![0.0; n],
            effort: Effort::default(),
        }
    }
}

/// The system during a step.
struct Step<'a> {
    system: &'a dyn System,
    linearisation: &'a Linearisation,
    factored: &'a Factored<f64>,
    /// df/dt, unless it is zero.
    time_derivative: Option<&'a [Block]>,
    shape: Shape,
    t: f64,
    h: f64,
}

impl Linearised<Block> for Step<'_> {
    #[inline(always)]
    fn rate(&mut self, stage: usize, argument: &[Block], rate: &mut [Block]) {
        let t = self.t + NODES[stage] * self.h;
        self.system.derivative(t, self.shape.states(argument), self.shape.states_mut(rate));
    }

    #[inline(always)]
    fn drift(&self, stage: usize, k: &mut [Block]) {
        if let Some(dfdt) = self.time_derivative.filter(|_| D[stage] != 0.0) {
            add_sum(k, self.h, &[D[stage]], [dfdt]);
        }
    }

    #[inline(always)]
    fn solve(&self, r: &mut [Block]) {
        self.factored.solve_outlined(self.linearisation, self.shape.states_mut(r));
    }
}

impl Method for Rodas5p {
    fn order(&self) -> u32 {
        5
    }

    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], _restart: Restart) {
        system.linearise(t, x, &mut self.linearisation);
        self.driven = system.time_derivative(t, x, self.shape.states_mut(&mut self.time_derivative));
        self.effort.jacobians += 1;
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool {
        self.effort.factorisations += 1;
        if !self.factored.factor_outlined(&self.linearisation, 1.0 / (h * GAMMA)) {
            return false;
        }
        let Rodas5p { shape, linearisation, factored, time_derivative, k, start, argument, .. } = self;
        shape.states_mut(start).copy_from_slice(x);
        let (_, first) = shape.split::<0>(k);
        shape.states_mut(first).copy_from_slice(&linearisation.rate);
        let time_derivative = self.driven.then_some(&time_derivative[..]);
        let mut step = Step { system, linearisation, factored, time_derivative, shape: *shape, t, h };
        with_avx2(
            #[inline(always)]
            || {
                stages(&TABLEAU, &mut step, 1.0 / h, start, k, argument);
                // The new state continues the last stage.
                let (_, last) = shape.split::<{ STAGES - 1 }>(k);
                argument.iter_mut().zip(last).for_each(|(argument, k)| *argument = argument.plus(*k));
            },
        );
        self.effort.derivatives += STAGES as u64 - 1;
        let (_, last) = self.shape.split::<{ STAGES - 1 }>(&mut self.k);
        to.error.copy_from_slice(self.shape.states(last));
        to.x.copy_from_slice(self.shape.states(&self.argument));
        true
    }

    fn carry(&mut self, h: f64, error: &mut [f64]) -> bool {
        let (carried, shift) = (&mut self.carried, 1.0 / (h * GAMMA));
        carried.fill(0.0);
        for weight in FLOW.into_iter().rev() {
            carried.iter_mut().zip(&*error).for_each(|(sum, error)| *sum = shift * (*sum + weight * error));
            self.factored.solve_outlined(&self.linearisation, carried);
        }
        error.copy_from_slice(carried);
        true
    }

    fn interpolate(&self, theta: f64, x: &mut [f64]) {
        let rest = 1.0 - theta;
        let weights: [f64; STAGES] = hydrocrane_num::array::from_fn(|i| H[0][i] + theta * (H[1][i] + theta * H[2][i]));
        let increments = self.shape.all::<STAGES>(&self.k);
        write_with_avx2(
            x,
            #[inline(always)]
            |i| {
                let (bend, start, end) = (sum(&weights, &increments, i), &self.start[i], &self.argument[i]);
                hydrocrane_num::array::from_fn(|lane| {
                    rest * start[lane] + theta * end[lane] + theta * rest * bend[lane]
                })
            },
        );
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::tableau::Argument;

    #[test]
    fn an_error_is_carried_to_order_two_and_what_is_fast_is_gone() {
        let flow = |z: f64| FLOW.iter().rev().fold(0.0, |sum, weight| (sum + weight) / (1.0 - GAMMA * z));
        assert!(((flow(0.1) - 0.1f64.exp()) / (flow(0.05) - 0.05f64.exp()) - 8.0).abs() < 0.5);
        assert!(flow(-1e6).abs() < 1e-6 && (0..400).all(|i| flow(-0.1 * f64::from(i)).abs() <= 1.0));
    }

    #[test]
    fn the_last_two_stages_and_the_new_state_continue_the_stage_before() {
        let continued = TABLEAU.arguments.map(|argument| argument == Argument::Continued);
        assert_eq!(continued, [false, false, false, false, false, false, true, true]);
        assert_eq!((TABLEAU.weights.split_at(7).0, TABLEAU.weights[7]), (TABLEAU.a[7], 1.0));
    }

    #[test]
    fn the_coefficients_satisfy_every_condition_of_order_four_with_and_without_the_last_increment() {
        let (three, four) = TABLEAU.missed(TABLEAU.weights);
        assert!(three.iter().chain(&four).all(|miss| miss.abs() < 1e-12), "{three:?} {four:?}");
        let (three, four) = TABLEAU.missed(hydrocrane_num::array::from_fn(|i| TABLEAU.weights[i] - TABLEAU.error[i]));
        assert!(three.iter().chain(&four).all(|miss| miss.abs() < 1e-12), "{three:?} {four:?}");
    }

    #[test]
    fn times_follow_from_the_other_coefficients() {
        let (nodes, d) = TABLEAU.times();
        for i in 0..STAGES {
            assert!((nodes[i] - NODES[i]).abs() < 1e-12, "stage {i}: {} for {}", nodes[i], NODES[i]);
            assert!((d[i] - D[i]).abs() < 1e-12, "stage {i}: {} for {}", d[i], D[i]);
        }
    }
}
