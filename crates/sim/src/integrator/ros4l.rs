//! ROS4L: linearly implicit method of order four, L-stable, with few right-hand sides.   theory: docs/theory/integration.md
//!
//! With G = (I - h gamma J)^-1 a chain of links
//!     w_1 = G h F_1,  w_2 = G w_1,  ...,  w_k = G (w_{k-1} + s_k N)
//! takes in, at its last three links, the bend N = h F_2 - h F_1 - h J u of the right-hand side at x + u, where
//! F_2 = f(t + c h, x + u) and u = u_1 w_1 + u_2 w_2. Then x_new = x + sum_k p_k w_k. The links are linear in what swings,
//! so that nine of them follow it to the eighth power of h; what bends is met to the fourth by N alone
//! (V. T. Luan, Appl. Numer. Math. 112 (2017) 91-103: one node of an exponential method, at c = 3/4).
//!
//! A step costs one right-hand side, a linearisation of where it ends, by which the next one begins, a factorisation and ten
//! solves. h J w_k = (w_k - w_{k-1} - s_k N)/gamma, so that no product with J is formed.

use super::rows::{add_sum, set, set_sum, sum, wide, write, write_wide, Block, Shape};
use super::{Effort, Linearisation, Method, Target};
use crate::system::System;

const SOLVES: usize = 9;
/// L-stable from here on; a swing is followed best where that begins.
const GAMMA: f64 = 0.172;
/// Where the second right-hand side is, as a share of the step: c.
const NODE: f64 = 0.75;
/// Share in the estimate of how the bends at the node and at the end differ.
const BENDS: f64 = 0.05;
/// First link that the bend joins.
const JOINED: usize = SOLVES - JOIN.len();
/// Degree of the interpolant.
const POWERS: usize = SOLVES - 1;
/// Weights of the first two links in the argument of the second right-hand side: both conditions of order two there.
const STAGE: [f64; 2] = [-0.135_174_418_604_651_15, 0.885_174_418_604_651_2];
/// Weights of the links in the step.
const P: [f64; SOLVES] = [
    0.172,
    -0.409_497_334_426_811_3,
    5.182_471_698_912_888,
    -17.495_879_513_141_933,
    32.486_163_173_844_574,
    -32.071_447_236_396_224,
    17.773_411_499_961_53,
    -5.309_062_017_078_713_5,
    0.671_839_728_324_690_1,
];
/// Weights of the bend where it joins the chain, at the last three solves.
const JOIN: [f64; 3] = [-0.191_292_524_354_830_32, -0.729_064_044_946_191_1, -0.409_896_349_287_324_7];
/// Those in the estimate: blind to everything up to a swing's sixth power of h, and to the bend.
const E: [f64; SOLVES] = [
    0.0,
    0.925_422_837_435_475_7,
    -5.711_659_938_710_187,
    14.836_080_046_116_13,
    -20.895_300_460_169_505,
    17.063_800_843_478_788,
    -7.939_380_736_072_844,
    1.880_160_322_019_471_6,
    -0.159_122_914_097_332_67,
];
/// Weights of the links inside a step, by rising powers of theta from the first on.
const INTERPOLANT: [[f64; POWERS]; SOLVES] = [
    [
        8.901_797_088_927_522,
        -98.923_760_471_441_07,
        413.491_592_085_722_3,
        -796.909_717_590_620_6,
        779.874_655_896_784_6,
        -393.920_773_534_672_83,
        96.674_432_773_566_44,
        -9.016_226_248_266_276,
    ],
    [
        -35.214_376_711_420_17,
        547.204_037_259_900_6,
        -2_598.089_578_221_744,
        5_343.528_963_887_706,
        -5_439.191_993_812_06,
        2_819.221_149_505_697_7,
        -704.428_469_088_098_6,
        66.560_769_845_591_38,
    ],
    [
        81.250_318_489_970_61,
        -1_426.842_037_386_396_4,
        7_318.705_627_616_016_5,
        -15_779.063_172_568_067,
        16_580.627_271_586_83,
        -8_787.802_647_261_968,
        2_231.778_165_190_212,
        -213.471_053_967_683_93,
    ],
    [
        -120.500_636_979_941_2,
        2_243.218_958_493_723,
        -12_034.653_007_530_573,
        26_792.429_614_030_698,
        -28_848.019_069_684_56,
        15_573.508_810_816_835,
        -4_011.439_375_610_919,
        387.958_826_951_596_05,
    ],
    [
        119.125_796_224_926_5,
        -2_285.128_349_279_944_4,
        12_584.216_746_162_81,
        -28_589.730_327_561_39,
        31_320.701_636_378_995,
        -17_148.790_430_426_994,
        4_468.310_524_135_222,
        -436.219_432_459_780_3,
    ],
    [
        -78.500_636_979_941_2,
        1_528.102_679_423_955_6,
        -8_536.140_297_957_83,
        19_611.130_587_949_137,
        -21_716.422_227_204_795,
        12_002.949_644_021_224,
        -3_153.183_461_472_199,
        309.992_264_984_052_44,
    ],
    [
        33.250_318_489_970_6,
        -650.679_246_688_722_1,
        3_656.816_318_079_330_4,
        -8_433.994_499_369_48,
        9_382.379_991_326_878,
        -5_208.017_229_389_366,
        1_373.522_251_051_491_6,
        -135.504_492_000_140_32,
    ],
    [
        -8.214_376_711_420_172,
        160.576_130_283_156_46,
        -902.353_144_113_216_7,
        2_076.324_503_903_050_3,
        -2_306.621_418_143_377_5,
        1_278.437_219_648_160_4,
        -336.604_505_885_790_05,
        33.146_529_002_358_406,
    ],
    [
        0.901_797_088_927_521_5,
        -17.528_411_634_231_766,
        98.005_743_879_484_7,
        -223.715_952_681_031_98,
        246.671_153_655_306_74,
        -135.585_743_378_918_04,
        35.370_438_906_515_005,
        -3.447_186_107_727_447,
    ],
];

/// The method for a [`System`].
pub struct Ros4l {
    shape: Shape,
    /// Where the step begins, and where its last attempt ended.
    here: Linearisation,
    ahead: Linearisation,
    /// df/dt, and whether any of it is not zero.
    time_derivative: Vec<Block>,
    driven: bool,
    links: Vec<Block>,
    /// N/h.
    bend: Vec<Block>,
    start: Vec<Block>,
    /// f at the start.
    rate: Vec<Block>,
    /// Of the second right-hand side; in the end the new state.
    argument: Vec<Block>,
    /// How the bends differ, for the error estimate.
    doubt: Vec<Block>,
    effort: Effort,
}

impl Ros4l {
    pub fn new(n: usize) -> Self {
        let shape = Shape::new(n);
        let row = || shape.rows(1);
        Ros4l {
            shape,
            here: Linearisation::new(n),
            ahead: Linearisation::new(n),
            time_derivative: row(),
            driven: false,
            links: shape.rows(SOLVES),
            bend: row(),
            start: row(),
            rate: row(),
            argument: row(),
            doubt: row(),
            effort: Effort::default(),
        }
    }

    /// Link `I` + 1 of the chain.
    #[inline(always)]
    fn link<const I: usize>(&mut self, h: f64) {
        let (done, link) = self.shape.split::<I>(&mut self.links);
        if I == 0 {
            set(link, &[1.0 / GAMMA], [&self.rate]);
        } else if I < JOINED {
            set(link, &[1.0 / (h * GAMMA)], [done[I - 1]]);
        } else {
            set(link, &[1.0 / (h * GAMMA), JOIN[I - JOINED] / GAMMA], [done[I - 1], &self.bend]);
        }
        if self.driven {
            add_sum(link, h, &[1.0], [&self.time_derivative]);
        }
        self.here.solve(self.shape.states_mut(link));
    }

    /// N/h, once two links are there.
    #[inline(always)]
    fn bend(&mut self, system: &dyn System, t: f64, h: f64) {
        let [first, second] = self.shape.all::<2>(&self.links);
        set_sum(&mut self.argument, &self.start, 1.0, &STAGE, [first, second]);
        let argument = self.shape.states(&self.argument);
        system.derivative(t + NODE * h, argument, self.shape.states_mut(&mut self.bend));
        let [one, two] = STAGE;
        let weights = [one / GAMMA - 1.0, (two - one) / (h * GAMMA), -two / (h * GAMMA)];
        add_sum(&mut self.bend, 1.0, &weights, [&self.rate, first, second]);
    }

    #[inline(always)]
    fn chain(&mut self, system: &dyn System, t: f64, h: f64) {
        self.link::<0>(h);
        self.link::<1>(h);
        self.bend(system, t, h);
        self.link::<2>(h);
        self.link::<3>(h);
        self.link::<4>(h);
        self.link::<5>(h);
        self.link::<6>(h);
        self.link::<7>(h);
        self.link::<8>(h);
    }

    /// The error estimate, once the system is linearised at the end: how differently the right-hand side bends there, and
    /// what the last links add to a swing.
    #[inline(always)]
    fn doubt(&mut self, h: f64, error: &mut [f64]) {
        let links = self.shape.all::<SOLVES>(&self.links);
        self.shape.states_mut(&mut self.doubt).copy_from_slice(&self.ahead.rate);
        let after = |k: usize| P.get(k + 1).copied().unwrap_or(0.0);
        let weights: [f64; SOLVES] = std::array::from_fn(|k| (after(k) - P[k]) / (h * GAMMA));
        add_sum(&mut self.doubt, 1.0, &weights, links);
        let joined: f64 = P[JOINED..].iter().zip(JOIN).map(|(p, s)| p * s).sum();
        add_sum(&mut self.doubt, 1.0, &[joined / GAMMA - 1.0 / (NODE * NODE)], [&self.bend]);
        self.here.solve(self.shape.states_mut(&mut self.doubt));
        write(error, |i| {
            let (swing, bend) = (sum(&E, &links, i), &self.doubt[i]);
            std::array::from_fn(|lane| BENDS / GAMMA * bend[lane] + swing[lane])
        });
    }
}

impl Method for Ros4l {
    fn order(&self) -> u32 {
        4
    }

    /// The bend's half goes with the fourth power, the swing's with the seventh.
    fn estimate_order(&self) -> u32 {
        5
    }

    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], goes_on: bool) {
        if goes_on {
            std::mem::swap(&mut self.here, &mut self.ahead);
        } else {
            system.linearise(t, x, &mut self.here);
            self.effort.jacobians += 1;
        }
        self.driven = system.time_derivative(t, x, self.shape.states_mut(&mut self.time_derivative));
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool {
        self.effort.factorisations += 1;
        if !self.here.factor(h * GAMMA) {
            return false;
        }
        self.shape.states_mut(&mut self.start).copy_from_slice(x);
        self.shape.states_mut(&mut self.rate).copy_from_slice(&self.here.rate);
        wide(
            #[inline(always)]
            || {
                self.chain(system, t, h);
                set_sum(&mut self.argument, &self.start, 1.0, &P, self.shape.all::<SOLVES>(&self.links));
            },
        );
        to.x.copy_from_slice(self.shape.states(&self.argument));
        system.linearise(t + h, &to.x, &mut self.ahead);
        self.effort.derivatives += 1;
        self.effort.jacobians += 1;
        wide(
            #[inline(always)]
            || self.doubt(h, &mut to.error),
        );
        true
    }

    fn interpolate(&self, theta: f64, x: &mut [f64]) {
        let weights = interpolant(theta);
        let links = self.shape.all::<SOLVES>(&self.links);
        write_wide(
            x,
            #[inline(always)]
            |i| {
                let (way, start) = (sum(&weights, &links, i), &self.start[i]);
                std::array::from_fn(|lane| start[lane] + way[lane])
            },
        );
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

/// Weights of the links at the fraction `theta` of a step.
#[inline(always)]
fn interpolant(theta: f64) -> [f64; SOLVES] {
    std::array::from_fn(|k| theta * INTERPOLANT[k].iter().rev().fold(0.0, |sum, c| sum * theta + c))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What stands before (h gamma J)^j in G^k: the binomial of k + j - 1 over j.
    fn power(k: usize, j: usize) -> f64 {
        (0..j).map(|i| (k + i) as f64 / (i + 1) as f64).product()
    }

    fn factorial(n: usize) -> f64 {
        (1..=n).map(|i| i as f64).product()
    }

    /// What stands before (hJ)^j h F_1 and before (hJ)^j N in the sum of the links with `weights`.
    fn series(weights: [f64; SOLVES], j: usize) -> [f64; 2] {
        let scale = GAMMA.powi(j as i32);
        let of_rate = (0..SOLVES).map(|k| weights[k] * power(k + 1, j)).sum::<f64>();
        let joined = |k: usize| (JOINED..=k).map(|i| JOIN[i - JOINED] * power(k - i + 1, j)).sum::<f64>();
        let of_bend = (JOINED..SOLVES).map(|k| weights[k] * joined(k)).sum::<f64>();
        [of_rate * scale, of_bend * scale]
    }

    fn assert_near(found: f64, wanted: f64, what: &str) {
        assert!((found - wanted).abs() < 1e-11, "{what}: {found} for {wanted}");
    }

    /// x(h) = x + sum_j (hJ)^j h F_1 / (j + 1)! + integral of e^((1 - s) hJ) N(s) with N(s) = s^2 h^3 A + s^3 h^4 B.
    #[test]
    fn a_step_is_exact_to_the_eighth_power_where_nothing_bends_and_to_the_fourth_where_it_does() {
        for j in 0..SOLVES - 1 {
            assert_near(series(P, j)[0], 1.0 / factorial(j + 1), &format!("(hJ)^{j}"));
        }
        for j in 0..3 {
            assert_near(series(P, j)[1] * NODE.powi(2), 2.0 / factorial(j + 3), &format!("(hJ)^{j} A"));
        }
        assert_near(series(P, 0)[1] * NODE.powi(3), 0.25, "B");
        assert_near(STAGE[0] + STAGE[1], NODE, "the node");
        assert_near(GAMMA * (STAGE[0] + 2.0 * STAGE[1]), 0.5 * NODE * NODE, "hJ at the node");
    }

    #[test]
    fn the_estimate_sees_the_seventh_power_of_a_swing_and_no_bend() {
        for j in 0..SOLVES - 3 {
            assert_near(series(E, j)[0], 0.0, &format!("(hJ)^{j}"));
        }
        assert_near(series(E, SOLVES - 3)[0], 0.1 / factorial(SOLVES - 2), "the power that is seen");
        assert_near(series(E, 0)[1], 0.0, "the bend");
    }

    #[test]
    fn the_interpolant_meets_its_conditions_everywhere_and_ends_with_the_step() {
        for theta in [0.0, 0.1, 0.5, 0.9, 1.0f64] {
            let weights = interpolant(theta);
            for j in 0..SOLVES - 1 {
                let wanted = theta.powi(j as i32 + 1) / factorial(j + 1);
                assert_near(series(weights, j)[0], wanted, &format!("(hJ)^{j} at {theta}"));
            }
            assert_near(series(weights, 0)[1] * NODE.powi(2), theta.powi(3) / 3.0, &format!("A at {theta}"));
        }
        interpolant(1.0).iter().zip(P).for_each(|(found, p)| assert_near(*found, p, "the end"));
    }

    /// R(z) at z = x + i y by weights of the links: what a step makes of x' = z x.
    fn linear(weights: [f64; SOLVES], x: f64, y: f64) -> [f64; 2] {
        let times = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
        let size = (1.0 - GAMMA * x).powi(2) + (GAMMA * y).powi(2);
        let g = [(1.0 - GAMMA * x) / size, GAMMA * y / size];
        let mut link = [x, y];
        let mut end = [1.0, 0.0];
        for weight in weights {
            link = times(link, g);
            end = [end[0] + weight * link[0], end[1] + weight * link[1]];
        }
        end
    }

    #[test]
    fn it_is_l_stable() {
        for i in 1..100_000 {
            let [re, im] = linear(P, 0.0, 0.002 * f64::from(i));
            assert!(re.hypot(im) <= 1.0 + 1e-13, "{i}: {}", re.hypot(im));
        }
        for (fast, left) in [(1e2, 0.2), (1e4, 1e-2), (1e8, 1e-6)] {
            let [end, _] = linear(P, -fast, 0.0);
            assert!(end.abs() < left, "{fast}: {end}");
        }
    }

    #[test]
    fn a_swing_of_14_hz_is_followed_in_steps_of_15_ms_inside_them_too() {
        let y = 14.0 * std::f64::consts::TAU * 0.015;
        for theta in [0.25, 0.5, 0.75, 1.0] {
            let [re, im] = linear(interpolant(theta), 0.0, y);
            let off = (re - (theta * y).cos()).hypot(im - (theta * y).sin());
            assert!(off < 5e-6, "{theta}: {off}");
        }
    }
}
