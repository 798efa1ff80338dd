//! Active damping of the modes on the oil.                            theory: docs/theory/control/regulate.md
//!
//! In the coordinate of a mode, s is the deflection of the oil and w the speed that the valves give:
//!     s' = r - w,    r' = -omega^2 s,    y = s + b,    z = s - i r/omega,    z' = i omega z - w
//!     u = min(2 zeta omega, c(e)/(T |U|)) Re((z - Q) U*)/|U|                    within the noise n: gain at most (v_q/n)^2/(2 N T)
//!
//! y follows from the chamber pressures; b is what the load differs from the planned one. An observer with real poles finds z and b.
//! Q is what the commands that are still under way to the spools will do to the mode, U what the next one will do: z - Q is what no
//! command has dealt with, and u pushes against it. Commands may be as late as promised: e is what the phase is then wrong by.

use crate::model::controller_model::Posture;
use crate::model::oil_modes::OilModes;
use crate::model::valve_answer::{turned, UnderWay, ValveAnswer};
use hydrocrane_num::{portable, Complex, Real};

/// How the modes are damped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampingGains {
    /// zeta, damping ratio that is added.
    pub ratio: f64,
    /// Speed of the tip in a mode that is left to friction, m/s.
    pub quiet: f64,
    /// s
    pub period: f64,
    /// Of the largest gain, and of what is promised of the valves' delay.
    pub share: f64,
}

hydrocrane_num::stored!([] DampingGains { ratio: f64, quiet: f64, period: f64, share: f64 });

/// Poles of the observer, in frequencies of the mode. Fast ones bear a frequency that the model has not quite; where they are faster
/// than EXACT per period, they let noise pass, and the least will do.
const FASTEST: f64 = 1.5;
const LEAST: f64 = 0.8;
const EXACT: f64 = 0.3;
const OFFSET: f64 = 2.5;
/// Largest gain, per period: a larger one damps slow modes no faster.
const MOST: f64 = 0.2;
/// Promise: commands may act so many periods later than the controller knows.
const LATE: f64 = 2.0;
/// Error of the phase by such a command from which on the law takes the valves to act later, rad.
const BORNE: f64 = 0.6;
/// Share by which the frequency of a mode can be wrong: over a long lag the phase is wrong by so much of its angle.
const DOUBT: f64 = 0.1;
/// Half of the gain that any command within the promise needs to turn the damping of a mode, wrong by that share, into its opposite is at least
/// this much (1/rad) times what the error of its phase lacks to where it ends, rad.
const MARGIN: f64 = 0.3;
const FAST: f64 = 1.2;
/// Time constant with which the level of noise follows the innovations, s.
const NOISE_TIME: f64 = 3.0;
/// Multiple of that level which counts as quiet.
const NOISE: f64 = 3.0;

/// Median of the size of what is normally distributed, in its deviations.
const MEDIAN: f64 = 0.6745;

/// Over how many of its periods, and how long (s), a swing is watched at least, and the share of it that must be gone then: closed valves alone
/// have a damping ratio of 0.001, by which 3.7 % are gone.
const WATCHED: f64 = 6.0;
const WATCHED_FOR: f64 = 0.3;
const FADED: f64 = 0.02;
/// Multiple of what counts as quiet from which on a swing that goes on is reported: 5.6 mm/s, and well above what noise makes of a quiet mode.
const REPORTED: f64 = 8.0;
/// The same, and the share that must be gone, once it has been reported: it is followed until it dies out or is no longer damped.
const SWINGS: f64 = 2.0;
const DYING: f64 = 0.3;
/// Time after the set-point has moved in which a loop that oscillates shows, s: later, noise of hours would tell of one some time.
const SHOWS: f64 = 30.0;

/// Whether a mode dies out while the valves damp it, but for what the motion asked for excites: a stop at once makes it as fast as the tip was.
/// Where it does not, and what they gave is enough for that in the worst phase, they keep it going.
#[derive(Debug, Clone, Copy)]
struct Watch {
    /// Share of the gain that is left.
    trust: f64,
    /// Largest speeds of the tip in the mode in the last window and in this one, m/s; the same of the set-point.
    before: f64,
    largest: f64,
    moved: [f64; 2],
    /// What the valves gave to the mode in this window, as a speed of the tip that turns with the mode, m/s.
    given: Complex<f64>,
    /// How long this window is to last, s.
    left: f64,
    /// Whether the swing has gone on from the window before the last one to the last one.
    went_on: bool,
}

impl Watch {
    const NEW: Watch = Watch {
        trust: 1.0,
        before: f64::INFINITY,
        largest: 0.0,
        moved: [0.0; 2],
        given: Complex { re: 0.0, im: 0.0 },
        left: f64::INFINITY,
        went_on: false,
    };

    /// Takes in the speed of the tip in a mode `omega` (rad/s), of which `quiet` can be noise, what the valves `given` to the mode add to it in
    /// this period, and the `pace` of the set-point, m/s; whether the gain was halved.
    fn look(&mut self, (speed, given): (f64, f64), quiet: f64, pace: f64, omega: f64, period: f64) -> bool {
        let window = (WATCHED * core::f64::consts::TAU / omega).max(WATCHED_FOR);
        self.largest = self.largest.max(speed);
        self.given = turn(omega * period) * self.given + Complex::new(given, 0.0);
        self.moved[1] = self.moved[1].max(pace);
        self.left = self.left.min(window) - period;
        if self.left > 0.0 {
            return false;
        }
        let excited = self.moved[0].max(self.moved[1]);
        let (reported, faded) = if self.trust < 1.0 { (SWINGS, DYING) } else { (REPORTED, FADED) };
        // What closed valves would have taken, and what it has grown by.
        let needed = FADED * self.before + (self.largest - self.before).max(0.0);
        let enough = self.given.re.square() + self.given.im.square() > needed.square();
        let goes_on = enough && self.largest > (1.0 - faded) * self.before && self.largest > reported * quiet + excited;
        // Once, it may have begun late.
        let keeps_on = goes_on && self.went_on;
        // Less where it grows fast.
        let kept = 0.5 * (self.before / self.largest).min(1.0);
        *self = Watch {
            trust: if keeps_on { kept * self.trust } else { self.trust },
            before: self.largest,
            moved: [self.moved[1], 0.0],
            left: window,
            went_on: goes_on,
            ..Watch::NEW
        };
        keeps_on
    }
}

/// Medians of the innovations of a mode and of the noise in them, as speeds of the tip, m/s. A stop, which no model foresees, hardly moves them.
#[derive(Debug, Clone, Copy)]
struct Innovations {
    level: f64,
    noise: f64,
    last: [f64; 2],
    /// How many were taken in.
    samples: f64,
}

impl Innovations {
    fn new(gains: DampingGains) -> Self {
        let least = gains.quiet / NOISE;
        Innovations { level: least, noise: least, last: [0.0; 2], samples: 0.0 }
    }

    /// Takes in one of a mode that turns by an angle with this `cosine` in a period; the speeds of the tip up to which the mode counts as
    /// quiet: for the damping, which leaves what the model does not foresee, and for who looks for a swing in noise.
    fn follow(&mut self, innovation: f64, cosine: f64, gains: DampingGains) -> [f64; 2] {
        let [before, first] = self.last;
        self.last = [innovation, before];
        self.samples += 1.0;
        // No swing of the mode adds to this; white noise leaves it as large as it is.
        let noise = (innovation - 2.0 * cosine * before + first) / portable::sqrt(2.0 + 4.0 * cosine.square());
        let step = gains.period / NOISE_TIME;
        let toward = |level: &mut f64, size: f64, factor: f64| {
            *level = if size > *level { *level * factor } else { *level / factor }.max(gains.quiet / NOISE);
            NOISE * *level
        };
        let quiet = toward(&mut self.level, innovation.abs(), 1.0 + step);
        // Steps of 1/n find a median soon, also from far away.
        [quiet, toward(&mut self.noise, noise.abs(), 1.0 + step.max(1.0 / self.samples))]
    }
}

/// Oil deflections as observed, in joint coordinates, because the modes change with the pose.
#[derive(Debug, Clone, Copy)]
pub struct Damping<const N: usize> {
    gains: DampingGains,
    /// s, rad or m
    deflection: [f64; N],
    /// r, rad/s or m/s
    rate: [f64; N],
    /// b as a torque, N m or N
    offset: [f64; N],
    /// Joint rates that the valves give for damping over this period and gave over the one before, rad/s or m/s, and those that they will give.
    given: [[f64; N]; 2],
    coming: [UnderWay; N],
    /// Per mode.
    innovations: [Innovations; N],
    watches: [Watch; N],
    /// Whether a gain was halved at the last sample.
    pub halved: bool,
}

impl<const N: usize> Damping<N> {
    /// At rest; `excess` is what the torques of the cylinders exceed the planned ones by, N m or N.
    pub fn at(gains: DampingGains, excess: &[f64; N], answers: &[&ValveAnswer; N]) -> Self {
        let zero = [0.0; N];
        Damping {
            gains,
            deflection: zero,
            rate: zero,
            offset: *excess,
            given: [zero; 2],
            coming: hydrocrane_num::array::from_fn(|c| UnderWay::at(0.0, answers[c])),
            innovations: [Innovations::new(gains); N],
            watches: [Watch::NEW; N],
            halved: false,
        }
    }

    /// Begins the observer anew with this `excess`.
    pub fn begin_anew(&mut self, excess: &[f64; N], answers: &[&ValveAnswer; N]) {
        *self = Damping { watches: self.watches, ..Damping::at(self.gains, excess, answers) };
    }

    /// Takes in a sample of the torques' `excess` over the planned ones, if they were measured; joint rates to ask the valves for on top, if
    /// the pose has modes.
    /// `(pace, stood)`: speed of the set-point, m/s, and for how long it has stood, s; `bearable`: joint rates that the valves can give, rad/s or m/s.
    pub fn step(
        &mut self,
        modes: &OilModes<N>,
        posture: &Posture<N>,
        answers: &[&ValveAnswer; N],
        excess: Option<&[f64; N]>,
        (pace, stood): (f64, f64),
        bearable: &[f64; N],
    ) -> Option<[f64; N]> {
        let g = self.gains;
        let (deflection, rate) = (modes.of_motion(&self.deflection), modes.of_motion(&self.rate));
        let [given, before] = self.given.map(|given| modes.of_motion(&given));
        let offset = modes.of_torque(&self.offset);
        let (torque, reach) = (excess.map(|excess| modes.of_torque(excess)), modes.reach(posture));
        let (mut s, mut r, mut b, mut w) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
        self.halved = false;
        for m in 0..N {
            let omega = modes.frequency[m];
            let angle = omega * g.period;
            // A mode without a spring, and one that samples cannot tell.
            if !(angle > 0.0 && angle < FAST) {
                b[m] = torque.map_or(offset[m], |torque| torque[m]);
                continue;
            }
            let square = omega * omega;
            let seen = Seen { state: Complex::new(deflection[m], -rate[m] / omega), offset: -offset[m] / square };
            let turned_by = turn(angle);
            let (of_motion, shares) = modes.of_each_joint(m);
            // Of the fastest that the mode can be: its turn in a period, how much farther it lags behind a valve than at `omega`, and the error
            // of its phase where a command is as late as promised and the law takes it to be `late`, in periods.
            let (faster, promised) = (modes.faster[m].max(DOUBT), g.share * LATE);
            let fastest = (1.0 + faster) * angle;
            let behind = answers.iter().map(|answer| answer.valve.further_behind(omega, faster)).fold(0.0, f64::max);
            let error = |late: f64| fastest * (promised - late) + behind;
            // One that is on time is wrong by no more than half of the promise.
            let late = ((error(0.0) - BORNE) / fastest).clamp(0.0, 0.5 * promised);
            let pushed = (given[m] + late * (before[m] - given[m])) / omega;
            let (seen, innovation) = seen.next(angle, turned_by, pushed, torque.map(|torque| -torque[m] / square));
            let [sent, next, last] = turned(angle, answers, &self.coming, &of_motion, &shares);
            let back = Complex::new(1.0 - late * (1.0 - turned_by.re), -late * turned_by.im);
            let (sent, next) = (back * sent + last * (late * given[m]), back * next);
            let size = portable::sqrt(next.re.square() + next.im.square());
            let ahead = (seen.state - sent * g.period).re_of_product(Complex::new(next.re, -next.im)) / size;
            let at_tip = reach[m] * omega;
            let speed = at_tip * portable::sqrt(seen.state.re.square() + seen.state.im.square());
            let [quiet, noise] = self.innovations[m].follow(at_tip * innovation, turned_by.re, g);
            let beyond = |quiet: f64| (speed / quiet - 1.0).clamp(0.0, 1.0);
            let swing = (speed, at_tip * g.period * given[m]);
            self.halved |= stood < SHOWS && self.watches[m].look(swing, noise, pace, omega, g.period);
            // What the valves pass of it is limited.
            let largest = g.share * MOST.min(MARGIN * (FAST - error(late))).max(0.0) / (g.period * size);
            let gain = (2.0 * g.ratio * omega).min(largest) * self.watches[m].trust;
            let low = gain.min(borne::<N>(g, noise / (NOISE * MEDIAN)));
            w[m] = (gain * beyond(quiet)).max(low * beyond(g.quiet)) * ahead;
            (s[m], r[m], b[m]) = (seen.state.re, -seen.state.im * omega, -seen.offset * square);
        }
        (self.deflection, self.rate) = (modes.motion(&s), modes.motion(&r));
        self.offset = modes.torque(&b);
        let asked = modes.motion(&w);
        // More than the valves can give would be believed to be given.
        let borne = (0..N).fold(1.0f64, |borne, i| borne.min(bearable[i] / asked[i].abs()));
        let asked = asked.map(|rate| borne * rate);
        if asked.iter().any(|rate| !rate.is_finite()) {
            return None;
        }
        let given = hydrocrane_num::array::from_fn(|c| self.coming[c].send(asked[c], answers[c]));
        self.given = [given, self.given[0]];
        Some(asked)
    }
}

/// A mode as observed: s - i r/omega, and b.
#[derive(Debug, Clone, Copy)]
struct Seen {
    state: Complex<f64>,
    offset: f64,
}

impl Seen {
    /// After a period in which the mode turned by `angle` (rad), as a number `turned`, `pushed` by the valves (w/omega), with a measurement of y
    /// if there is one; and by how much that differs from what was predicted.
    fn next(self, angle: f64, turned: Complex<f64>, pushed: f64, measured: Option<f64>) -> (Seen, f64) {
        // Under constant w the mode turns about s = 0, r = w.
        let middle = Complex::new(0.0, -pushed);
        let predicted = turned * (self.state - middle) + middle;
        let innovation = measured.map_or(0.0, |measured| measured - predicted.re - self.offset);
        let [fast, slow] = poles(angle);
        let (from_fast, from_slow, one) = (turned - fast, turned - slow, turned - 1.0);
        // By the residues of the characteristic polynomial.
        let gain = from_fast * from_fast * from_slow * 2.0 / (turned * Complex::new(0.0, 2.0 * turned.im) * one);
        let of_offset = (1.0 - fast).square() * (1.0 - slow) / (one.re.square() + one.im.square());
        (Seen { state: predicted + gain * innovation, offset: self.offset + of_offset * innovation }, innovation)
    }
}

impl DampingGains {
    /// Share of the largest gain and of the promise for forces that are measured or estimated. An estimated force is no more than what the
    /// position lacks to a model of the flow, errors of which a large gain turns into creep; and an unknown load makes modes far slower than
    /// the model says, which adds to the delay that the law takes the valves to have.
    pub fn share(measured: bool) -> f64 {
        if measured {
            1.0
        } else {
            0.5
        }
    }
}

/// Gain (1/s) with which `noise` (m/s, deviation) leaves `N` modes together half of the quiet speed.
fn borne<const N: usize>(gains: DampingGains, noise: f64) -> f64 {
    (gains.quiet / noise).square() / (2.0 * N as f64 * gains.period)
}

/// Poles of the observer for a mode that turns by `angle` in a period: a double one for the oscillation, one for the offset.
fn poles(angle: f64) -> [f64; 2] {
    let fast = (FASTEST * angle).min(EXACT.max(LEAST * angle));
    [fast, OFFSET * angle].map(|rate| portable::exp(-rate))
}

/// e^(i angle)
fn turn(angle: f64) -> Complex<f64> {
    let (sine, cosine) = portable::sin_cos(angle);
    Complex::new(cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode of `omega` (rad/s) with an offset, free, observed for `samples` periods of 10 ms from nothing known.
    fn observed(omega: f64, samples: usize) -> (Seen, Complex<f64>) {
        let (angle, offset) = (omega * 0.01, 0.3);
        let mut seen = Seen { state: Complex::new(0.0, 0.0), offset: 0.0 };
        let mut state = Complex::new(1.0, -0.5);
        for _ in 0..samples {
            state = turn(angle) * state;
            (seen, _) = seen.next(angle, turn(angle), 0.0, Some(state.re + offset));
        }
        (seen, state)
    }

    #[test]
    fn the_observer_finds_deflection_rate_and_offset() {
        for omega in [8.0, 25.0, 80.0] {
            let (seen, state) = observed(omega, (80.0 / (omega * 0.01)) as usize);
            let off = seen.state - state;
            assert!(off.re.abs() < 1e-6 && off.im.abs() < 1e-6 && (seen.offset - 0.3).abs() < 1e-6, "{omega} {seen:?}");
        }
    }

    #[test]
    fn its_error_falls_as_its_slowest_pole_says() {
        let (omega, n) = (25.0, 60);
        let error = |samples| {
            let (seen, state) = observed(omega, samples);
            let off = seen.state - state;
            (off.re.powi(2) + off.im.powi(2)).sqrt()
        };
        // A double pole: its power times the number of samples.
        let [fast, _] = poles(omega * 0.01);
        let share = error(n + 20) / error(n) / (fast.powi(20) * (n + 20) as f64 / n as f64);
        assert!((0.8..1.2).contains(&share), "{share}");
    }

    #[test]
    fn noise_is_found_beside_a_swing() {
        let gains = DampingGains { ratio: 0.25, quiet: 0.7e-3, period: 0.005, share: 1.0 };
        let mut chance = hydrocrane_num::RandomStream::new(1, "noise");
        for (angle, sigma) in [(0.1, 2e-3), (0.6, 2e-3), (1.2, 5e-3)] {
            let mut found = Innovations::new(gains);
            for k in 0..400 {
                let swing = 0.02 * portable::sin_cos(angle * f64::from(k)).0;
                found.follow(swing + sigma * chance.normal(), portable::sin_cos(angle).1, gains);
            }
            let share = found.noise / (MEDIAN * sigma);
            assert!((0.7..1.4).contains(&share), "{angle} {share}");
        }
    }

    #[test]
    fn within_noise_a_gain_leaves_what_is_promised() {
        let gains = DampingGains { ratio: 0.25, quiet: 0.7e-3, period: 0.005, share: 1.0 };
        for (omega, noise) in [(40.0, 2e-3), (60.0, 4e-3), (100.0, 4e-3)] {
            let (gain, angle) = (borne::<1>(gains, noise), omega * gains.period);
            let mut chance = hydrocrane_num::RandomStream::new(2, "noise");
            let mut seen = Seen { state: Complex::new(0.0, 0.0), offset: 0.0 };
            let (mut state, mut pushed, mut squares) = (seen.state, 0.0, 0.0);
            for _ in 0..200_000 {
                let middle = Complex::new(0.0, -pushed);
                state = turn(angle) * (state - middle) + middle;
                let read = state.re + noise / omega * chance.normal();
                (seen, _) = seen.next(angle, turn(angle), pushed, Some(read));
                pushed = gain * seen.state.re / omega;
                squares += (omega * state.im).square();
            }
            let share = portable::sqrt(squares / 200_000.0) / (0.5 * gains.quiet);
            assert!((0.7..1.3).contains(&share), "{omega} {noise}: {share}");
        }
    }

    #[test]
    fn what_the_valves_give_is_foreseen() {
        // s' = r - w, r' = -omega^2 s, in small steps.
        let (omega, w) = (25.0, 0.4);
        let (mut s, mut r) = (1.0, 3.0);
        for _ in 0..100_000 {
            (s, r) = (s + 1e-7 * (r - w), r - 1e-7 * omega * omega * s);
        }
        let seen = Seen { state: Complex::new(1.0, -3.0 / omega), offset: 0.0 };
        let (next, _) = seen.next(omega * 0.01, turn(omega * 0.01), w / omega, Some(s));
        assert!((next.state.re - s).abs() < 1e-4 && (next.state.im + r / omega).abs() < 1e-4, "{next:?} {s} {r}");
    }
}
