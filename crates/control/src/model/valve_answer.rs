//! What valves do with commands that hold for a period.             theory: docs/theory/control/valve.md
//!
//! w_k = sum_i h_i u_(k-i),   h_i = S_i - S_(i-1),   sum_i h_i = 1
//!
//! S_i is the mean over the i-th period of the answer to a unit step: a dead time, then x'' + 2 zeta w x' + w^2 x = w^2 u, (76) to (82).
//! Everything that compares a measurement with what was commanded does so through these shares.

use hydrocrane_num::{portable, Complex};

/// Periods over which a command acts at most.
pub const MOST: usize = 96;
/// Share of a step from which on it counts as done: less than the tolerance of a valve.
const DONE: f64 = 0.01;

/// From the commands to the flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValveDynamics {
    /// Dead time, s.
    pub delay: f64,
    /// rad/s
    pub natural_frequency: f64,
    pub damping_ratio: f64,
}

hydrocrane_num::stored!([] ValveDynamics { delay: f64, natural_frequency: f64, damping_ratio: f64 });

impl ValveDynamics {
    /// Mean time from a command to the middle of its effect beyond that of a valve without any lag, s.
    pub fn lag(&self) -> f64 {
        self.delay + 2.0 * self.damping_ratio / self.natural_frequency
    }

    /// By how much more an oscillation that is `faster` than `omega` (rad/s) by this share lags behind the valve than one of `omega`, rad.
    pub fn further_behind(&self, omega: f64, faster: f64) -> f64 {
        let x = omega / self.natural_frequency;
        let (y, swing) = ((1.0 + faster) * x, 2.0 * self.damping_ratio);
        // Of (1 - x^2 + i swing x)* (1 - y^2 + i swing y).
        let (im, re) = (swing * (y - x) * (1.0 + x * y), (1.0 - x * x) * (1.0 - y * y) + swing * swing * x * y);
        faster * omega * self.delay + portable::atan2(im, re)
    }

    /// How far the spool swings beyond a step, as a share of it.
    pub fn overshoot(&self) -> f64 {
        let ratio = self.damping_ratio;
        if ratio < 1.0 {
            portable::exp(-core::f64::consts::PI * ratio / portable::sqrt(1.0 - ratio * ratio))
        } else {
            0.0
        }
    }

    /// Integral over time of the answer to a unit step, s: of x'' + 2 zeta w x' + w^2 x = w^2, x' + 2 zeta w x + w^2 I = w^2 t.
    fn integral(&self, since: f64) -> f64 {
        let t = since - self.delay;
        if t <= 0.0 {
            return 0.0;
        }
        let (w, decay) = (self.natural_frequency, self.damping_ratio * self.natural_frequency);
        let square = w * w - decay * decay;
        let turning = portable::sqrt(square.abs());
        // e^(-a t) cos(b t) and e^(-a t) sin(b t)/b, with b = i |b| above critical damping.
        let (even, odd) = if turning * t < 1e-6 {
            let fading = portable::exp(-decay * t);
            (fading, fading * t)
        } else if square > 0.0 {
            let (sine, cosine) = portable::sin_cos(turning * t);
            let fading = portable::exp(-decay * t);
            (fading * cosine, fading * sine / turning)
        } else {
            let [slow, fast] = [turning - decay, -turning - decay].map(|rate| portable::exp(rate * t));
            (0.5 * (slow + fast), 0.5 * (slow - fast) / turning)
        };
        let (position, speed) = (1.0 - even - decay * odd, w * w * odd);
        t - (speed + 2.0 * decay * position) / (w * w)
    }

    /// Mean of the answer to a unit step over period `i` (s each) after it.
    fn mean(&self, i: usize, period: f64) -> f64 {
        (self.integral((i + 1) as f64 * period) - self.integral(i as f64 * period)) / period
    }

    /// Least period (s) at which [`MOST`] of them hold the answer, if this one is too short.
    pub fn too_short(&self, period: f64) -> Option<f64> {
        let left = |period: f64| (1.0 - self.mean(MOST - 1, period)).abs();
        if left(period) < DONE {
            return None;
        }
        let mut least = period;
        while left(least) >= DONE && least < 1.0 {
            least *= 1.1;
        }
        Some(least)
    }
}

/// The shares h of a valve.
#[derive(Debug, Clone, Copy)]
pub struct ValveAnswer {
    shares: [f64; MOST],
    count: usize,
    pub valve: ValveDynamics,
}

impl ValveAnswer {
    /// To commands that hold for one `period` (s) each.
    pub fn new(valve: &ValveDynamics, period: f64) -> Self {
        let means: [f64; MOST] = hydrocrane_num::array::from_fn(|i| valve.mean(i, period));
        let count = means.iter().rposition(|mean| (1.0 - mean).abs() >= DONE).map_or(1, |last| (last + 2).min(MOST));
        let shares = hydrocrane_num::array::from_fn(|i| {
            let before = if i == 0 { 0.0 } else { means[i - 1] };
            // The last one takes what is left.
            let mean = if i + 1 == count { 1.0 } else { means[i] };
            if i < count {
                mean - before
            } else {
                0.0
            }
        });
        ValveAnswer { shares, count, valve: *valve }
    }
}

/// What a valve will give of what has been sent, period by period from now on.
#[derive(Debug, Clone, Copy)]
pub struct UnderWay([f64; MOST]);

impl UnderWay {
    /// Of a command that has always been `value`, when the next one is about to be sent.
    pub fn at(value: f64, answer: &ValveAnswer) -> Self {
        let mut coming = [0.0; MOST];
        for i in (0..answer.count.saturating_sub(1)).rev() {
            coming[i] = coming[i + 1] + value * answer.shares[i + 1];
        }
        UnderWay(coming)
    }

    /// Sends a command, and what the valve gives over the period that begins with it.
    pub fn send(&mut self, command: f64, answer: &ValveAnswer) -> f64 {
        let coming = &mut self.0[..answer.count];
        coming.iter_mut().zip(&answer.shares).for_each(|(coming, share)| *coming += share * command);
        let given = coming[0];
        coming.copy_within(1.., 0);
        coming[answer.count - 1] = 0.0;
        given
    }

    /// What is still to come in all, in periods of the commands' unit.
    pub fn sum(&self, answer: &ValveAnswer) -> f64 {
        self.0[..answer.count].iter().sum()
    }
}

/// What is under way from several valves to an oscillation that turns by `angle` (rad) in a period, with `weights` for what each valve
/// gives; what a command of one to all of them would give, with `each`; and what one gives over the coming period. In periods of the commands'
/// unit, turned back to now.
pub fn turned(
    angle: f64,
    answers: &[&ValveAnswer],
    coming: &[UnderWay],
    weights: &[f64],
    each: &[f64],
) -> [Complex<f64>; 3] {
    let (sine, cosine) = portable::sin_cos(angle);
    let back = Complex::new(cosine, -sine);
    let zero = Complex::new(0.0, 0.0);
    let (mut sent, mut one) = (zero, zero);
    let count = answers.iter().map(|answer| answer.count).max().unwrap_or(0);
    for i in (0..count).rev() {
        let (mut given, mut share) = (0.0, 0.0);
        for (c, answer) in answers.iter().enumerate() {
            given += weights[c] * coming[c].0[i];
            share += each[c] * answer.shares[i];
        }
        sent = back * sent + Complex::new(given, 0.0);
        one = back * one + Complex::new(share, 0.0);
    }
    // Over a period: (1 - e^(-i a))/(i a).
    let over = if angle > 1e-6 { Complex::new(sine / angle, (cosine - 1.0) / angle) } else { Complex::new(1.0, 0.0) };
    [over * sent, over * one, over]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.01;

    /// Mean over each of `count` periods of the answer to `commands`, by small steps of the equation.
    fn stepped(valve: &ValveDynamics, commands: &[f64], count: usize) -> Vec<f64> {
        const STEPS: usize = 2000;
        let (w, (mut x, mut v)) = (valve.natural_frequency, (0.0, 0.0));
        let command = |t: f64| if t < 0.0 { 0.0 } else { commands.get((t / PERIOD) as usize).copied().unwrap_or(0.0) };
        let mean = |k: usize| {
            let mut sum = 0.0;
            for j in 0..STEPS {
                let t = PERIOD * (k as f64 + (j as f64 + 0.5) / STEPS as f64);
                let step = PERIOD / STEPS as f64;
                v += step * w * (w * (command(t - valve.delay) - x) - 2.0 * valve.damping_ratio * v);
                x += step * v;
                sum += x / STEPS as f64;
            }
            sum
        };
        (0..count).map(mean).collect()
    }

    fn valves() -> [ValveDynamics; 5] {
        let valve = |delay, hertz: f64, damping_ratio| ValveDynamics {
            delay,
            natural_frequency: core::f64::consts::TAU * hertz,
            damping_ratio,
        };
        [
            valve(0.0, 60.0, 0.7),
            valve(0.025, 8.0, 0.8),
            valve(0.05, 5.0, 1.0),
            valve(0.013, 12.0, 1.6),
            valve(0.004, 6.0, 0.4),
        ]
    }

    #[test]
    fn what_is_given_is_what_the_equation_of_the_spool_gives() {
        let commands: Vec<f64> = (0..60).map(|k| if k < 30 { (0.4 * f64::from(k)).sin() + 0.5 } else { 0.0 }).collect();
        for valve in valves() {
            let answer = ValveAnswer::new(&valve, PERIOD);
            let mut coming = UnderWay::at(0.0, &answer);
            let given: Vec<f64> = commands.iter().map(|u| coming.send(*u, &answer)).collect();
            for (k, (given, true_mean)) in given.iter().zip(stepped(&valve, &commands, 60)).enumerate() {
                assert!((given - true_mean).abs() < 2.5 * DONE, "{valve:?} {k}: {given} {true_mean}");
            }
        }
    }

    #[test]
    fn nothing_is_lost_and_a_constant_stays() {
        for valve in valves() {
            let answer = ValveAnswer::new(&valve, PERIOD);
            let mut coming = UnderWay::at(3.0, &answer);
            assert!((coming.send(3.0, &answer) - 3.0).abs() < 1e-12);
            let (mut coming, mut given) = (UnderWay::at(0.0, &answer), 0.0);
            for k in 0..40 {
                given += coming.send(f64::from(k % 7), &answer);
                let sent: f64 = (0..=k).map(|k| f64::from(k % 7)).sum();
                assert!((given + coming.sum(&answer) - sent).abs() < 1e-9);
            }
            // The mean time is the lag of the valve.
            let mean: f64 = answer.shares.iter().enumerate().map(|(i, share)| share * i as f64 * PERIOD).sum();
            assert!((mean - answer.valve.lag()).abs() < 0.02 * answer.valve.lag() + 0.02 * PERIOD, "{valve:?} {mean}");
        }
    }

    #[test]
    fn an_oscillation_ends_where_it_was_foreseen() {
        // z' = i omega z - w, by the exact step under a constant w.
        let omega: f64 = 18.0;
        let turn = Complex::new((omega * PERIOD).cos(), (omega * PERIOD).sin());
        for valve in valves() {
            let answer = ValveAnswer::new(&valve, PERIOD);
            let mut coming = [UnderWay::at(0.0, &answer)];
            let mut z = Complex::new(0.3, -0.2);
            let push = |z: Complex<f64>, w: f64| {
                let middle = Complex::new(0.0, -w / omega);
                turn * (z - middle) + middle
            };
            for k in 0..25 {
                let given = coming[0].send((0.7 * f64::from(k)).sin(), &answer);
                z = push(z, given);
            }
            let [sent, ..] = turned(omega * PERIOD, &[&answer], &coming, &[1.0], &[1.0]);
            let foreseen = z - sent * PERIOD;
            let mut turned_on = foreseen;
            for _ in 0..MOST {
                z = push(z, coming[0].send(0.0, &answer));
                turned_on = turn * turned_on;
            }
            let off = z - turned_on;
            assert!(off.re.abs() < 1e-9 && off.im.abs() < 1e-9, "{valve:?} {off:?}");
        }
    }

    #[test]
    fn a_faster_oscillation_lags_further_behind_by_the_phase_of_the_valve() {
        // The inverse of the valve, e^(i w d) (1 - x^2 + 2 i zeta x), by many small turns.
        let at = |valve: &ValveDynamics, omega: f64| {
            let x = omega / valve.natural_frequency;
            let (sine, cosine) = (omega * valve.delay).sin_cos();
            Complex::new(cosine, sine) * Complex::new(1.0 - x * x, 2.0 * valve.damping_ratio * x)
        };
        for valve in valves() {
            for (omega, faster) in [(8.0, 0.1), (30.0, 0.1), (60.0, 0.5), (90.0, 0.1)] {
                let steps = 1000;
                let turned: f64 = (0..steps)
                    .map(|k| {
                        let [now, next] = [k, k + 1].map(|k| omega * (1.0 + faster * f64::from(k) / f64::from(steps)));
                        let (now, next) = (at(&valve, now), at(&valve, next));
                        (next.im * now.re - next.re * now.im).atan2(next.re * now.re + next.im * now.im)
                    })
                    .sum();
                let further = valve.further_behind(omega, faster);
                assert!((further - turned).abs() < 1e-9, "{valve:?} {omega} {further} {turned}");
            }
        }
    }

    #[test]
    fn a_period_that_is_too_short_is_reported() {
        let slow = valves()[2];
        assert_eq!(slow.too_short(0.01), None);
        let least = slow.too_short(5e-4).expect("too short");
        assert!(least > 5e-4 && slow.too_short(least).is_none(), "{least}");
    }
}
