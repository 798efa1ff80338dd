//! What a valve does beyond its model, learnt from motion.       theory: docs/theory/control/estimate.md
//!
//! s: opening that the command asks for, as a signed share of the whole; o: the one that it gives
//!     o = g_e (s - t_e) for s > t_e,   o = g_r (s + t_r) for s < -t_r,   0 between
//! with a gain g and a threshold t for either sense. The piston's speed is v = l v_closed + |o| (v_full - v_closed) with a factor l of
//! leakage: linear in g, g t and l.
//! Ridge regression with exponential forgetting keeps them near what is known as far as the motion tells nothing.

use crate::estimate::model_error::{Compared, ModelError};
use crate::model::signal_chain::SignalChain;
use hydrocrane_num::linear::symmetric::cholesky;
use hydrocrane_num::{portable, Real};

/// What a valve does beyond its model; indices: retracting, extending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValveFit {
    /// g
    pub gain: [f64; 2],
    /// t, shares of the whole opening.
    pub threshold: [f64; 2],
    /// l
    pub leakage: f64,
}

/// As its model has it.
pub const NOMINAL: ValveFit = ValveFit { gain: [1.0; 2], threshold: [0.0; 2], leakage: 1.0 };

/// Bounds of the gains, of the thresholds and of the leakage.
const GAINS: [f64; 2] = [0.4, 1.6];
const THRESHOLD: f64 = 0.12;
const LEAKAGES: [f64; 2] = [0.0, 40.0];
/// Width over which a command passes the middle of its thresholds, share of the distance between them.
const WIDTH: f64 = 0.02;
/// What is believed of gains, thresholds and leakage beforehand: standard deviations.
const BELIEF: [f64; 3] = [0.3, 0.03, 10.0];
/// Standard deviation by which the piston's speed differs from the law, share of its full speed, and the time over which it stays so, s.
const ERROR: f64 = 0.01;
const ERROR_TIME: f64 = 0.2;
/// Share of the full speed from which on motion is told from standstill.
const LEAST: f64 = 0.02;
/// Standard deviations that something exceeds which is certain.
const CERTAIN: f64 = 2.0;
/// Share of the memory of the observer that must hold usable samples.
const USABLE: f64 = 0.95;

impl ValveFit {
    /// Opening that the command for `s` gives.
    pub fn opening(&self, s: f64) -> f64 {
        let [retracting, extending] = self.threshold;
        if s > extending {
            self.gain[1] * (s - extending)
        } else {
            self.gain[0] * (s + retracting).min(0.0)
        }
    }

    /// Opening to ask for so that it is `opening`.
    pub fn asked(&self, opening: f64) -> f64 {
        let [retracting, extending] = self.threshold;
        let (middle, half) = (0.5 * (extending - retracting), 0.5 * (extending + retracting));
        let width = WIDTH * half;
        let side = if width > 0.0 { (opening / width).clamp(-1.0, 1.0) } else { 0.0 };
        opening / self.gain[usize::from(opening > 0.0)] + middle + half * side
    }

    /// Piston speed that a sample leads to, m/s.
    pub fn speed(&self, sample: &Sample) -> f64 {
        self.leakage * sample.closed + self.opening(sample.asked).abs() * sample.reach
    }

    /// The signal chain that a file states for a valve which does this behind `chain`, with spools of this `overlap` and `stroke` (m).
    pub fn chain(&self, chain: &SignalChain, overlap: f64, stroke: f64) -> SignalChain {
        let SignalChain { offset, gain, dead_band, limits } = *chain;
        // Where the straight line of either sense has u = 0, as a spool position.
        let line = |i: usize, sense: f64| {
            let within = self.gain[i] * self.threshold[i] * (stroke - overlap) - overlap * (1.0 - self.gain[i]);
            self.gain[i] * (offset - sense * gain * dead_band) - sense * within
        };
        let (retracting, extending) = (line(0, -1.0), line(1, 1.0));
        let gain = gain * 0.5 * (self.gain[0] + self.gain[1]);
        let dead_band = (0.5 * (retracting - extending) / gain).max(0.0);
        SignalChain { offset: 0.5 * (retracting + extending), gain, dead_band, limits }
    }

    /// Middle between the thresholds.
    fn middle(&self) -> f64 {
        0.5 * (self.threshold[1] - self.threshold[0])
    }
}

/// What was learnt of a valve, as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearntValve {
    /// From the command to the spool, as a machine file states it.
    pub chain: SignalChain,
    /// l, times the leakage of the model.
    pub leakage: f64,
}

/// A sample of a valve.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// s
    pub asked: f64,
    /// v_closed and, towards the sense of the opening, v_full - v_closed, m/s.
    pub closed: f64,
    pub reach: f64,
    /// Mean size of the speeds at full opening towards either sense, m/s.
    pub full: f64,
    /// Speed that was expected, m/s, and the one that winds or damps the oil.
    pub expected: f64,
    pub compression: f64,
    /// Whether the law holds: not at rest, not at an end stop, measured.
    pub usable: bool,
}

/// The estimator of one valve.
#[derive(Debug, Clone, Copy)]
pub struct Learning {
    /// Share of what is known that a sample of motion makes forget, and its weight.
    forgetting: f64,
    weight: f64,
    /// Signals behind the two lags of the observer and that of the valve: the regressors, v as expected, usable, compression, what the oil gives.
    lags: [[f64; COUNT + 4]; 3],
    /// Share by which the last of them goes on in a period.
    valve_share: f64,
    information: [[f64; COUNT]; COUNT],
    target: [f64; COUNT],
    /// L L' = A of the last solution.
    root: [[f64; COUNT]; COUNT],
    /// The best guess.
    pub fit: ValveFit,
    /// What it does not explain.
    pub error: ModelError,
}

impl Learning {
    /// Nothing learnt; `forget` s of motion are remembered, none where it is zero. `period` and the mean `lag` of the valve in s.
    pub fn new(forget: f64, period: f64, lag: f64) -> Self {
        let forgetting = if forget > 0.0 { (period / forget).min(1.0) } else { 0.0 };
        let mut learning = Learning {
            forgetting,
            weight: (period / ERROR_TIME).min(1.0),
            lags: [[0.0; COUNT + 4]; 3],
            valve_share: 1.0 - portable::exp(-period / lag),
            information: [[0.0; COUNT]; COUNT],
            target: [0.0; COUNT],
            root: [[0.0; COUNT]; COUNT],
            fit: NOMINAL,
            error: ModelError::new(period),
        };
        for (i, belief) in beliefs().into_iter().enumerate() {
            learning.information[i][i] = belief;
            learning.root[i][i] = portable::sqrt(belief);
            learning.target[i] = belief * BEFOREHAND[i];
        }
        learning
    }

    /// Takes in a sample, the speed that the observer finds missing, m/s, and the way F/k that the oil gives, m; by how much more the same command
    /// is now expected to give, m/s. `lag_share`: by which either lag of the observer goes on in a period.
    pub fn learn(&mut self, sample: &Sample, missing: f64, given: f64, lag_share: f64) -> f64 {
        let extending = sample.asked > self.fit.middle();
        let (mut now, first) = ([0.0; COUNT + 4], if extending { 2 } else { 0 });
        let asked = if extending { sample.asked } else { -sample.asked };
        (now[first], now[first + 1]) = (asked * sample.reach, -sample.reach);
        now[4] = sample.closed;
        (now[COUNT], now[COUNT + 1]) = (sample.expected, f64::from(u8::from(sample.usable)));
        (now[COUNT + 2], now[COUNT + 3]) = (sample.compression, given);
        for (i, now) in now.into_iter().enumerate() {
            self.lags[0][i] += lag_share * (now - self.lags[0][i]);
            self.lags[1][i] += lag_share * (self.lags[0][i] - self.lags[1][i]);
            self.lags[2][i] += self.valve_share * (self.lags[1][i] - self.lags[2][i]);
        }
        let [.., expected, usable, compression, _] = self.lags[2];
        let model = (0..COUNT).map(|i| BEFOREHAND[i] * self.lags[2][i]).sum();
        // What is measured is behind no valve.
        let now = Compared { found: expected + missing, model, compression, given: self.lags[1][COUNT + 3] };
        self.error.compare(&now, sample.usable);
        let found = now.found / sample.full;
        if !(usable > USABLE && sample.usable && self.forgetting > 0.0 && found.abs() > LEAST) {
            return 0.0;
        }
        self.regress(&hydrocrane_num::array::from_fn(|i| self.lags[2][i] / sample.full), found);
        let before = self.fit.speed(sample);
        self.solve();
        let more = self.fit.speed(sample) - before;
        self.explain(more);
        more
    }

    /// What the law explains now (m/s) is not missing any more.
    pub fn explain(&mut self, speed: f64) {
        self.lags.iter_mut().for_each(|lag| lag[COUNT] += speed);
    }

    fn regress(&mut self, regressors: &[f64; COUNT], found: f64) {
        for i in 0..COUNT {
            let belief = beliefs()[i];
            for j in 0..COUNT {
                let new =
                    self.weight * regressors[i] * regressors[j] + self.forgetting * if i == j { belief } else { 0.0 };
                self.information[i][j] += new - self.forgetting * self.information[i][j];
            }
            let new = self.weight * regressors[i] * found + self.forgetting * belief * BEFOREHAND[i];
            self.target[i] += new - self.forgetting * self.target[i];
        }
    }

    /// Solves again for the best parameters.
    fn solve(&mut self) {
        let l = cholesky(&self.information);
        let mut x = backwards(&l, forwards(&l, self.target));
        // The best with a leakage within its bounds.
        let beyond = x[4] - x[4].clamp(LEAKAGES[0], LEAKAGES[1]);
        let along = backwards(&l, forwards(&l, [0.0, 0.0, 0.0, 0.0, 1.0]));
        (0..COUNT).for_each(|i| x[i] -= beyond * along[i] / along[4]);
        if x.iter().any(|x| !x.is_finite()) {
            return;
        }
        let gain = [x[0], x[2]].map(|g| g.clamp(GAINS[0], GAINS[1]));
        let [retracting, extending] = [x[1] / gain[0], x[3] / gain[1]].map(|t| t.clamp(-THRESHOLD, THRESHOLD));
        // A valve that opens both ways at once is none.
        let (half, middle) = ((0.5 * (extending + retracting)).max(0.0), 0.5 * (extending - retracting));
        let leakage = x[4].clamp(LEAKAGES[0], LEAKAGES[1]);
        (self.root, self.fit) = (l, ValveFit { gain, threshold: [half - middle, half + middle], leakage });
    }

    /// As far as it is certain that the valve differs from its model, for a piston at rest that would move at `closed` (m/s) with closed
    /// edges; `full`: mean size of the speeds at full opening, m/s.
    pub fn certain(&self, closed: f64, full: f64) -> ValveFit {
        let certain = |value: f64, combination: [f64; COUNT]| {
            let squares = forwards(&self.root, combination).iter().map(|y| y * y).sum::<f64>();
            // The error may also last for ever, as those of the sensors do: no motion averages it out.
            let doubt = CERTAIN * ERROR * portable::sqrt(1.0 + squares);
            // Nothing up to the doubt, all of it from twice the doubt on.
            value * (value.abs() / doubt - 1.0).clamp(0.0, 1.0)
        };
        let ValveFit { gain, threshold: [retracting, extending], leakage } = self.fit;
        let half = certain(0.5 * (retracting + extending), [0.0, 0.5, 0.0, 0.5, 0.0]);
        // Leakage and an offset are hard to tell apart; what they do together to a piston at rest is known better.
        let creep = (leakage - 1.0) * closed / full - self.fit.middle();
        let middle = -certain(creep, [0.0, 0.5, 0.0, -0.5, closed / full]);
        ValveFit { gain, threshold: [half - middle, half + middle], leakage: 1.0 }
    }
}

/// Solution of L y = b.
fn forwards(l: &[[f64; COUNT]; COUNT], mut b: [f64; COUNT]) -> [f64; COUNT] {
    for i in 0..COUNT {
        let known: f64 = (0..i).map(|j| l[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / l[i][i];
    }
    b
}

/// Solution of L' x = b.
fn backwards(l: &[[f64; COUNT]; COUNT], mut b: [f64; COUNT]) -> [f64; COUNT] {
    for i in (0..COUNT).rev() {
        let known: f64 = (i + 1..COUNT).map(|j| l[j][i] * b[j]).sum();
        b[i] = (b[i] - known) / l[i][i];
    }
    b
}

/// How many parameters there are: g_r, g_r t_r, g_e, g_e t_e, l; and what they are beforehand.
const COUNT: usize = 5;
const BEFOREHAND: [f64; COUNT] = [1.0, 0.0, 1.0, 0.0, 1.0];

/// Information that is believed of them beforehand.
fn beliefs() -> [f64; COUNT] {
    let [gain, threshold, leakage] = BELIEF.map(|deviation| (ERROR / deviation).square());
    [gain, threshold, gain, threshold, leakage]
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::RandomStream;

    const PERIOD: f64 = 0.01;
    const SHARE: f64 = 0.05;

    /// Drives a valve that does what `truth` says by random openings; what is learnt in `seconds`.
    fn learnt(truth: ValveFit, seconds: f64, noise: f64) -> Learning {
        let mut learning = Learning::new(10.0, PERIOD, 0.0);
        let mut random = RandomStream::new(1, "valve");
        let (mut asked, mut missing, mut lag) = (0.2, 0.0, 0.0);
        let full = [-0.05, 0.06];
        for k in 0..(seconds / PERIOD) as usize {
            if k % 120 == 0 {
                asked = random.symmetric() * 0.6;
            }
            let reach = |o: f64| full[usize::from(o > 0.0)];
            let closed = 1e-5 * (2.0 + (0.003 * k as f64).sin());
            let sample = Sample {
                asked,
                closed,
                reach: reach(asked),
                full: 0.055,
                expected: 0.0,
                compression: 0.0,
                usable: true,
            };
            let sample = Sample { expected: learning.fit.speed(&sample), ..sample };
            // The observer's two lags on what is missing.
            lag += SHARE * (truth.speed(&sample) - learning.fit.speed(&sample) - lag);
            missing += SHARE * (lag - missing);
            let shift = learning.learn(&sample, missing + noise * random.symmetric(), 0.0, SHARE);
            (lag, missing) = (lag - shift, missing - shift);
        }
        learning
    }

    const TRUTH: ValveFit = ValveFit { gain: [0.7, 0.8], threshold: [0.03, 0.07], leakage: 8.0 };

    #[test]
    fn gains_and_thresholds_are_found_from_motion() {
        let fit = learnt(TRUTH, 20.0, 0.0).fit;
        for i in 0..2 {
            assert!((fit.gain[i] - TRUTH.gain[i]).abs() < 0.05, "{fit:?}");
            assert!((fit.threshold[i] - TRUTH.threshold[i]).abs() < 0.02, "{fit:?}");
        }
    }

    #[test]
    fn the_opening_asked_for_is_given() {
        for k in -20..=20 {
            let opening = 0.05 * f64::from(k) + 0.01;
            assert!((TRUTH.opening(TRUTH.asked(opening)) - opening).abs() < 1e-12, "{opening}");
            assert_eq!((NOMINAL.asked(opening), NOMINAL.opening(opening)), (opening, opening));
        }
    }

    #[test]
    fn a_chain_of_the_file_says_what_was_learnt() {
        let (stated, stroke) = (SignalChain { offset: 5e-4, gain: 0.9, dead_band: 1e-3, limits: [-0.05, 0.05] }, 0.05);
        for overlap in [0.0, 2e-3] {
            let fit = ValveFit { gain: [0.8; 2], threshold: [0.01, 0.06], leakage: 1.0 };
            let chain = fit.chain(&stated, overlap, stroke);
            for u in [-0.04, -0.02, 0.02, 0.03] {
                let share = |x: f64| (x.abs() - overlap) / (stroke - overlap) * x.signum();
                let learnt = fit.opening(share(stated.spool(u)));
                assert!((share(chain.spool(u)) - learnt).abs() < 1e-12, "{u} {overlap}");
            }
        }
        let same = NOMINAL.chain(&stated, 2e-3, stroke);
        assert!((same.offset - stated.offset).abs() < 1e-15 && (same.dead_band - stated.dead_band).abs() < 1e-15);
    }

    #[test]
    fn whatever_is_measured_stays_within_bounds_and_is_finite() {
        let mut learning = Learning::new(0.5, PERIOD, 0.0);
        let mut random = RandomStream::new(2, "nonsense");
        for _ in 0..5000 {
            let reach = 0.1 * random.symmetric();
            let sample = Sample {
                asked: random.symmetric(),
                closed: 0.1 * random.symmetric(),
                reach,
                full: 0.1,
                compression: 0.0,
                expected: 0.1,
                usable: true,
            };
            learning.learn(&sample, 100.0 * random.symmetric(), 0.0, SHARE);
            let ValveFit { gain, threshold, leakage } = learning.fit;
            assert!(gain.iter().all(|g| (GAINS[0]..=GAINS[1]).contains(g)), "{gain:?}");
            assert!(
                threshold[0] + threshold[1] >= -1e-12 && threshold.iter().all(|t| t.abs() <= 2.0 * THRESHOLD),
                "{threshold:?}"
            );
            assert!((LEAKAGES[0]..=LEAKAGES[1]).contains(&leakage));
            // Never less certain than beforehand.
            let l = cholesky(&learning.information);
            assert!((0..COUNT).all(|i| l[i][i] > 0.0 && learning.information[i][i] >= beliefs()[i] * (1.0 - 1e-9)));
        }
    }

    #[test]
    fn standstill_teaches_nothing_and_zero_time_switches_it_off() {
        let mut learning = Learning::new(10.0, PERIOD, 0.0);
        let still = Sample {
            asked: 0.01,
            closed: 0.0,
            reach: 0.05,
            full: 0.05,
            expected: 5e-4,
            compression: 0.0,
            usable: true,
        };
        (0..1000).for_each(|_| assert_eq!(learning.learn(&still, -5e-4, 0.0, SHARE), 0.0));
        assert_eq!(learning.fit, NOMINAL);
        let mut off = Learning::new(0.0, PERIOD, 0.0);
        let moving = Sample { asked: 0.5, expected: 0.025, ..still };
        (0..1000).for_each(|_| assert_eq!(off.learn(&moving, -0.01, 0.0, SHARE), 0.0));
        assert_eq!(off.fit, NOMINAL);
    }
}
