//! Step size control around a [`Method`].

use crate::linear::system::System;
use crate::methods::method::{flush, Effort, Method, Restart, Target};
use crate::quadratures::Quadratures;
use crate::step_size::{equal_part, longest_part, EVEN};
use hydrocrane_num::{portable, Archive};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Relative tolerance.
    pub relative: f64,
    /// Absolute tolerance, in units of each state's scale.
    pub absolute: f64,
    /// Largest step, s, so that commands and contacts are not stepped over. Fixed steps have this size at most.
    pub max_step: f64,
}

/// How step sizes are chosen; any method can be stepped in either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepControl {
    /// From the error of each step relative to the tolerances.
    Adaptive,
    /// The least number of equal steps not longer than the largest one; a step is divided only if its error is too
    /// large.
    Even,
}

/// Why no step was possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepFailure {
    /// Every smaller step led outside the admissible states.
    NotAdmissible,
    /// The step size fell below rounding.
    TooSmall,
    /// A fixed step ended with numbers that are not finite, or the error of its smallest parts is too large.
    NotFinite,
}

/// Smallest step, relative to the time, and absolute in seconds.
const LEAST_STEP: f64 = 1e-13;

/// The smallest step from time `t`, s.
pub fn least_step(t: f64) -> f64 {
    LEAST_STEP * t.abs().max(1.0)
}

/// Bounds of the change of step size from one step to the next.
const SHRINK: f64 = 0.2;
const GROW: f64 = 6.0;
const SAFETY: f64 = 0.9;
/// Growth beyond which errors do not oscillate about the tolerance but are far below it.
const DOUBLE: f64 = 2.0;
/// Error of a fixed step above which it is divided, and the same where laws jump: there shorter steps help little.
const GROSS: f64 = 3e-3;
const GROSS_WITH_JUMPS: f64 = 0.1;
/// The same bound per square of a step (1/s^2) where laws are smooth, because the errors of more steps add up.
const GROSS_PER_SQUARE: f64 = 300.0;
/// Size of a step, s, below which the bound falls with the fifth power: such short steps are those of a fast
/// controller, which amplifies their errors. It is at least the bound of a step of 0.2 ms, so that a step that a
/// command cuts short is not refused.
const FINE: f64 = 1e-3;
const LEAST_GROSS: f64 = 1e-7;
/// Before the first interval of fixed steps.
const NOT_JUDGED: (f64, f64) = (f64::NEG_INFINITY, GROSS);
/// Largest number of parts of a fixed step.
const MOST_PARTS: u32 = 256;
/// Number of attempts that must advance by a least time (s); a slower run would need minutes for a second.
pub const CRAWL_ATTEMPTS: u64 = 100_000;
const CRAWL_ADVANCE: f64 = 1e-2;
/// Error of the smallest part, relative to the bound, above which the run ends.
const HOPELESS: f64 = 100.0;

/// The next step of the wanted size within the remaining interval. A remainder under 1 % is merged; two short steps are made
/// equal.
fn portion(remaining: f64, wanted: f64) -> f64 {
    if remaining <= wanted * 1.01 {
        remaining
    } else if remaining < 2.0 * wanted {
        0.5 * remaining
    } else {
        wanted
    }
}

/// What is measured relative to the tolerances: the error of the last attempt, or another change at the present state.
enum Change<'a> {
    Error,
    Other(&'a [f64]),
}

/// Sizes of steps, past and to come.
struct Sizes {
    /// Of the next attempt.
    next: f64,
    /// Of the last accepted step under the same right-hand side, with its error norm.
    last: Option<(f64, f64)>,
    /// Of the first whole step after the last restart.
    first: Option<f64>,
    /// Whether no whole step was taken since a restart.
    restarted: bool,
}

/// A method with its state over time.
pub struct Stepper {
    method: Box<dyn Method>,
    tolerances: Tolerances,
    control: StepControl,
    pub t: f64,
    pub x: Vec<f64>,
    quadratures: Quadratures,
    /// See [`Self::global_error`].
    global_error: Option<Vec<f64>>,
    /// Whether laws jump: a step over a jump has the same error, however short it is.
    jumps: bool,
    sizes: Sizes,
    /// Last accepted interval.
    from: f64,
    target: Target,
    /// Tolerances of the present step.
    allowed: Vec<f64>,
    /// Restart of the next step; `None`: the step has begun.
    restart: Option<Restart>,
    pub accepted: u64,
    pub rejected: u64,
    /// Attempts and time (s) at which the watch for slow progress last restarted.
    mark: (u64, f64),
    /// End of the present interval of fixed steps, and the error above which its steps are divided.
    judged: (f64, f64),
    /// Time at which the error of the smallest parts of a fixed step was first too large, s.
    pub unresolved: Option<f64>,
}

impl Stepper {
    pub fn new(method: Box<dyn Method>, tolerances: Tolerances, t: f64, x: &[f64], quadratures: usize) -> Self {
        Stepper {
            method,
            tolerances,
            control: StepControl::Adaptive,
            t,
            x: x.to_vec(),
            quadratures: Quadratures::new(x.len(), quadratures),
            global_error: None,
            jumps: false,
            sizes: Sizes { next: 0.0, last: None, first: None, restarted: true },
            from: t,
            target: Target::new(x.len()),
            allowed: vec![0.0; x.len()],
            restart: Some(Restart::State),
            accepted: 0,
            rejected: 0,
            mark: (0, t),
            judged: NOT_JUDGED,
            unresolved: None,
        }
    }

    /// Chooses step sizes in this way.
    pub fn with_control(mut self, control: StepControl) -> Self {
        self.control = control;
        self
    }

    /// States whether laws jump, as printed friction does.
    pub fn with_jumps(mut self, jumps: bool) -> Self {
        self.jumps = jumps;
        self
    }

    /// Error above which fixed steps of size `h` (s) are divided.
    fn gross(&self, h: f64) -> f64 {
        if self.jumps {
            return GROSS_WITH_JUMPS;
        }
        // A step that is shorter only by rounding does not count as short.
        let fine = if h < FINE * (1.0 - EVEN) { h / FINE } else { 1.0 };
        (GROSS_PER_SQUARE * h * h * fine * fine * fine).clamp(LEAST_GROSS, GROSS)
    }

    /// Estimates the error of the state from now on, or no longer; a step over a jump of a law says nothing of the others.
    pub fn follow_error(&mut self, wanted: bool) {
        let followed = wanted && (self.control == StepControl::Adaptive || !self.jumps);
        self.global_error = followed.then(|| vec![0.0; self.x.len()]);
    }

    /// Estimated error of the state: the errors of the steps so far, each carried on by the linearised equations. The method of a drive
    /// alone carries none.
    pub fn global_error(&self) -> Option<&[f64]> {
        if cfg!(feature = "methods") {
            self.global_error.as_deref()
        } else {
            None
        }
    }

    /// Takes no longer steps than `max_step` (s) from now on.
    pub fn set_max_step(&mut self, max_step: f64) {
        self.tolerances.max_step = max_step;
    }

    /// Restarts after a change of the state or of the right-hand side, for example when a load is picked up.
    pub fn restart(&mut self) {
        self.refresh();
        self.restart = Some(Restart::State);
        self.quadratures.restart();
        self.judged = NOT_JUDGED;
        self.sizes.next = self.sizes.first.unwrap_or(0.0);
        self.sizes.restarted = true;
    }

    /// Restarts after a small change of commands: the step size is kept as a first guess.
    pub fn refresh(&mut self) {
        self.restart = Some(self.restart.map_or(Restart::State, |restart| restart.max(Restart::Input)));
        self.sizes.last = None;
    }

    /// Takes one accepted step, at most to `limit`.
    pub fn step(&mut self, system: &dyn System, limit: f64) -> Result<(), StepFailure> {
        if let Some(restart) = self.restart.take() {
            self.method.begin(system, self.t, &self.x, restart);
            self.quadratures.begin(system, &self.x);
        }
        if self.control == StepControl::Even {
            return self.even_step(system, limit);
        }
        if self.sizes.next == 0.0 {
            self.sizes.next = self.first_step(system);
        }
        let least = least_step(self.t);
        let remaining = limit - self.t;
        let mut failure = StepFailure::TooSmall;
        let mut rejected_before = false;
        loop {
            let wanted = self.sizes.next.min(self.tolerances.max_step);
            let h = portion(remaining, wanted);
            if h < least && h < remaining {
                return Err(failure);
            }
            let norm = self.attempt(system, h, &mut failure);
            if norm <= 1.0 {
                let most = if rejected_before { 1.0 } else { GROW };
                let next = h * self.growth(h, norm).clamp(SHRINK, most);
                self.sizes.last = Some((h, norm));
                // A step cut short by the limit has no information for the next restart.
                if self.sizes.restarted && h >= wanted {
                    self.sizes.first = Some(h);
                    self.sizes.restarted = false;
                }
                self.take(system, h, limit);
                // A step cut short by the limit does not disprove the size that was wanted.
                self.sizes.next = if h < wanted { next.max(wanted) } else { next };
                return Ok(());
            }
            rejected_before = true;
            self.rejected += 1;
            let factor = SAFETY * portable::pow(norm, -1.0 / self.estimate_order());
            self.sizes.next = h * if norm.is_finite() { factor.clamp(SHRINK, 1.0) } else { SHRINK };
        }
    }

    /// Takes one of the fewest equal steps to `limit` that are not longer than the largest step, or a part of one if
    /// the error of the whole step is too large. The number of parts and the work of a step are bounded.
    fn even_step(&mut self, system: &dyn System, limit: f64) -> Result<(), StepFailure> {
        // Without a limit the step is the largest one.
        let whole = equal_part(limit - self.t, self.tolerances.max_step);
        // The remainder of a divided step has the bound of the whole step.
        if self.judged.0 != limit {
            self.judged = (limit, self.gross(whole));
        }
        let gross = self.judged.1;
        let least = self.least_part();
        let mut h = if self.sizes.next > 0.0 { equal_part(whole, self.sizes.next) } else { whole };
        loop {
            let mut failure = StepFailure::NotFinite;
            let norm = match self.reach(system, h) {
                Ok(()) => system.error_size(&self.x, &self.target.x, &self.target.error) / gross,
                Err(found) => {
                    failure = found;
                    f64::INFINITY
                }
            };
            let last = h <= longest_part(least);
            if norm <= 1.0 || (last && norm <= HOPELESS) {
                if norm > 1.0 {
                    self.unresolved.get_or_insert(self.t);
                }
                self.sizes.next =
                    (h * (SAFETY * portable::pow(norm, -1.0 / self.estimate_order())).clamp(SHRINK, GROW)).max(least);
                self.take(system, h, limit);
                return Ok(());
            }
            if last {
                return Err(failure);
            }
            self.rejected += 1;
            let factor = SAFETY * portable::pow(norm, -1.0 / self.estimate_order());
            h = equal_part(whole, (h * if factor.is_finite() { factor.clamp(SHRINK, 0.5) } else { SHRINK }).max(least));
        }
    }

    fn estimate_order(&self) -> f64 {
        f64::from(self.method.estimate_order())
    }

    /// Change of step size after an accepted step: the filter H211b (b = 4) of G. Soderlind, Digital filters in adaptive
    /// time-stepping, ACM Trans. Math. Softw. 29 (2003) 1-26, doi 10.1145/641876.641877. It uses the last two errors and
    /// steps, because errors oscillate with the crane and answering each at once would reject every other step.
    /// An error so small that it allows twice the step is answered at once.
    fn growth(&self, h: f64, norm: f64) -> f64 {
        match self.sizes.last {
            Some((last_h, last_norm)) if norm > (SAFETY / DOUBLE).powi(self.method.estimate_order() as i32) => {
                SAFETY * portable::pow(norm * last_norm, -0.25 / self.estimate_order()) * (last_h / h).sqrt().sqrt()
            }
            _ => SAFETY * portable::pow(norm, -1.0 / self.estimate_order()),
        }
    }

    /// Error norm of an attempt relative to the tolerances; infinite if the attempt fails.
    fn attempt(&mut self, system: &dyn System, h: f64, failure: &mut StepFailure) -> f64 {
        match self.reach(system, h) {
            Ok(()) => {
                *failure = StepFailure::TooSmall;
                self.norm(system, Change::Error)
            }
            Err(found) => {
                *failure = if found == StepFailure::NotFinite { StepFailure::TooSmall } else { found };
                f64::INFINITY
            }
        }
    }

    /// Attempts a step; the error says why it is not usable.
    fn reach(&mut self, system: &dyn System, h: f64) -> Result<(), StepFailure> {
        if !self.method.attempt(system, self.t, h, &self.x, &mut self.target) {
            return Err(StepFailure::NotFinite);
        }
        // Without an early exit, so that the compiler vectorises it.
        if !self.target.x.iter().fold(true, |so_far, v| so_far & v.is_finite()) {
            return Err(StepFailure::NotFinite);
        }
        if !system.admissible(&self.target.x) {
            return Err(StepFailure::NotAdmissible);
        }
        Ok(())
    }

    /// Size of a change relative to the tolerances of the present step: the root of the sum of the mean squares of all parts.
    /// Tolerances follow from the old state: those from a wrong new state would accept it, unless they only narrow. The
    /// largest norm of the state and its resolved tangents counts.
    fn norm(&mut self, system: &dyn System, of: Change) -> f64 {
        let Tolerances { relative, absolute, .. } = self.tolerances;
        let n = self.x.len() / (1 + system.tangents());
        for ((tolerance, x), scale) in self.allowed.iter_mut().zip(&self.x).zip(system.scales()) {
            *tolerance = absolute * scale + relative * x.abs();
        }
        let (change, to) = match of {
            Change::Error => (&self.target.error[..], &self.target.x[..]),
            Change::Other(change) => (change, &self.x[..]),
        };
        system.narrow(&self.x[..n], &to[..n], &mut self.allowed[..n]);
        let own = n as f64 / system.parts() as f64;
        let of_block = |(change, allowed): (&[f64], &[f64])| {
            let sum: f64 = change.iter().zip(allowed).map(|(e, allowed)| (e / allowed).powi(2)).sum();
            (sum / own).sqrt()
        };
        let resolved = system.scales().len() / n;
        let blocks = change.chunks_exact(n).zip(self.allowed.chunks_exact(n)).take(resolved);
        blocks.map(of_block).fold(1e-10, f64::max)
    }

    fn take(&mut self, system: &dyn System, h: f64, limit: f64) {
        self.from = self.t;
        self.t = if h >= limit - self.t { limit } else { self.t + h };
        std::mem::swap(&mut self.x, &mut self.target.x);
        flush(&mut self.x);
        self.quadratures.follow(system, self.method.as_ref(), h, &self.x);
        if let Some(error) = self.global_error.as_mut().filter(|_| cfg!(feature = "methods")) {
            if self.method.carry(h, error) {
                error.iter_mut().zip(&self.target.error).for_each(|(error, own)| *error += own);
                flush(error);
            } else {
                self.global_error = None;
            }
        }
        self.accepted += 1;
        self.restart = Some(Restart::None);
    }

    /// A first step from the size of the state, its derivative and the change of this derivative (Hairer, Norsett, Wanner:
    /// Solving Ordinary Differential Equations I, section II.4).
    fn first_step(&mut self, system: &dyn System) -> f64 {
        let n = self.x.len();
        let (mut f0, mut f1) = (vec![0.0; n], vec![0.0; n]);
        system.derivative(self.t, &self.x, &mut f0);
        let (size, derivative) =
            (self.norm(system, Change::Other(&self.x.clone())), self.norm(system, Change::Other(&f0)));
        let probe = if size < 1e-5 || derivative < 1e-5 { 1e-6 } else { 0.01 * size / derivative }.min(1e-3);
        let ahead: Vec<f64> = self.x.iter().zip(&f0).map(|(x, f)| x + probe * f).collect();
        system.derivative(self.t + probe, &ahead, &mut f1);
        let bend: Vec<f64> = f1.iter().zip(&f0).map(|(a, b)| (a - b) / probe).collect();
        let curvature = self.norm(system, Change::Other(&bend));
        let order = self.estimate_order();
        let second = portable::pow(0.01 / derivative.max(curvature), 1.0 / order).max(1e-9);
        let h = (100.0 * probe).min(second).min(self.tolerances.max_step);
        if h.is_finite() {
            h
        } else {
            1e-6
        }
    }

    /// Estimated error of the last step, if steps are fixed; a step over a jump of a law says nothing of the others.
    pub fn fixed_step_error(&self) -> Option<&[f64]> {
        (self.control == StepControl::Even && !self.jumps).then_some(&self.target.error[..])
    }

    /// Start of the last accepted step.
    pub fn previous_time(&self) -> f64 {
        self.from
    }

    /// The quadratures at the present time.
    pub fn integrals(&self) -> &[f64] {
        &self.quadratures.w
    }

    /// The state at a time inside the last accepted step.
    pub fn interpolate(&self, t: f64, x: &mut [f64]) {
        if t >= self.t {
            x.copy_from_slice(&self.x);
        } else {
            self.method.interpolate(self.fraction(t), x);
        }
    }

    /// The same for these `states`, by increasing index; others may be written too.
    pub fn interpolate_some(&self, t: f64, states: &[usize], x: &mut [f64]) {
        if t >= self.t {
            x.copy_from_slice(&self.x);
        } else {
            self.method.interpolate_some(self.fraction(t), states, x);
        }
    }

    /// The quadratures at a time inside the last accepted step.
    pub fn interpolate_integrals(&self, t: f64, w: &mut [f64]) {
        if t >= self.t {
            w.copy_from_slice(&self.quadratures.w);
        } else {
            self.quadratures.interpolate(self.fraction(t), w);
        }
    }

    /// Time `t` as a fraction of the last accepted step.
    fn fraction(&self, t: f64) -> f64 {
        (t - self.from) / (self.t - self.from)
    }

    /// All data that determine the next steps of the same `system`, without integrals.
    pub fn archive(&mut self, system: &dyn System, archive: &mut Archive) {
        archive.numbers(&mut self.x);
        for number in [
            &mut self.t,
            &mut self.sizes.next,
            &mut self.from,
            &mut self.mark.1,
            &mut self.judged.0,
            &mut self.judged.1,
        ] {
            archive.number(number);
        }
        for whole in [&mut self.accepted, &mut self.rejected, &mut self.mark.0] {
            archive.whole(whole);
        }
        archive.flag(&mut self.sizes.restarted);
        archive.option(&mut self.sizes.first, Archive::number);
        archive.option(&mut self.unresolved, Archive::number);
        archive.option(&mut self.sizes.last, |archive, (size, norm)| {
            archive.number(size);
            archive.number(norm);
        });
        archive.option(&mut self.restart, |archive, restart| restart.archive(archive));
        if self.restart != Some(Restart::State) {
            self.method.archive(system, self.t, archive);
        }
    }

    pub fn effort(&self) -> Effort {
        self.method.effort()
    }

    /// Size of the smallest part of a fixed step, s.
    pub fn least_part(&self) -> f64 {
        self.tolerances.max_step / f64::from(MOST_PARTS)
    }

    /// Advance (s) of a large number of attempts, if it is below the bound. Call once per step.
    pub fn crawls(&mut self) -> Option<f64> {
        let attempts = self.accepted + self.rejected;
        if attempts < self.mark.0 + CRAWL_ATTEMPTS {
            return None;
        }
        let (_, since) = std::mem::replace(&mut self.mark, (attempts, self.t));
        Some(self.t - since).filter(|advance| *advance < CRAWL_ADVANCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gross(jumps: bool, h: f64) -> f64 {
        let tolerances = Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 1e-3 };
        let method = Box::new(crate::methods::rosenbrock3::Rosenbrock3::new(1));
        Stepper::new(method, tolerances, 0.0, &[1.0], 0).with_jumps(jumps).gross(h)
    }

    #[test]
    fn the_bound_of_fixed_steps_falls_with_the_square_and_below_1_ms_with_the_fifth_power() {
        let ratio = |from: f64, to: f64| gross(false, from) / gross(false, to);
        assert!((ratio(3e-3, 1.5e-3) - 4.0).abs() < 1e-12);
        assert!((ratio(8e-4, 4e-4) - 32.0).abs() < 1e-9);
        assert!((ratio(1e-3, 0.999e-3) - 1.0).abs() < 0.01, "it jumps at 1 ms");
        assert!((ratio(1e-5, 1e-4) - 1.0).abs() < 1e-12);
        assert_eq!([gross(false, 1.0), gross(true, 1e-4)], [GROSS, GROSS_WITH_JUMPS]);
    }

    /// x' = 2000 (1 - x^2): the error of a step of 1 ms is too large, that of its parts is not.
    struct Fast;

    impl System for Fast {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&self, _: f64, x: &[f64], out: &mut [f64]) {
            out[0] = 2000.0 * (1.0 - x[0] * x[0]);
        }
        fn linearise(&self, t: f64, x: &[f64], at: &mut crate::linear::Linearisation) {
            self.derivative(t, x, &mut at.rate);
            at.dense(0)[0] = -4000.0 * x[0];
        }
        fn time_derivative(&self, _: f64, _: &[f64], _: &mut [f64]) -> bool {
            false
        }
        fn admissible(&self, _: &[f64]) -> bool {
            true
        }
        fn scales(&self) -> &[f64] {
            &[1.0]
        }
    }

    #[test]
    fn parts_of_a_step_that_is_cut_are_judged_as_the_step_is() {
        let tolerances = Tolerances { relative: 1e-4, absolute: 1e-4, max_step: 1e-3 };
        let method = Box::new(crate::methods::rosenbrock3::Rosenbrock3::new(1));
        let mut stepper = Stepper::new(method, tolerances, 0.0, &[0.0], 0).with_control(StepControl::Even);
        let mut parts = 0;
        while stepper.t < 1e-3 {
            stepper.step(&Fast, 1e-3).unwrap();
            assert_eq!(stepper.judged.1, GROSS_PER_SQUARE * 1e-6);
            parts += 1;
        }
        assert!(parts > 4, "{parts} parts");
        stepper.step(&Fast, 1.2e-3).unwrap();
        assert!(stepper.judged.1 <= 1e-7, "a step that a command cuts short has its own bound");
    }

    #[test]
    fn rounding_makes_no_step_of_1_ms_a_short_one() {
        let h = 1e-3 - 1e-12;
        assert_eq!(gross(false, h), GROSS_PER_SQUARE * h * h);
    }
}
