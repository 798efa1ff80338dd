//! hc-exponential-4: linearly implicit method of order four, L-stable, with few right-hand sides.   theory: docs/theory/integration.md
//!
//! An exponential Rosenbrock method whose phi-functions are sums over the [poles](crate::methods::poles) of a Padé approximant. With
//! N(u) = h F(x + u) - h F_1 - hJ u, the remainder of the right-hand side beyond its linearisation at the start,
//!     u = c phi_1(c hJ) h F_1,   v = phi_1(hJ) h F_1 + 2/c^2 phi_3(hJ) N(u),   x_new = x + v + d,
//!     d = (6 phi_4(hJ) - 2 c phi_3(hJ)) (N(v) - N(u)/c^2)/(1 - c).
//! This integrates the terms s^2 and s^3 of a remainder N(s) exactly, and with c = 3/5 most of s^4. The linear part is of order
//! fifteen. The next step begins with the linearisation at x + v, shifted by d, which is far smaller.
//!
//! Its error is estimated by d and by a third value of the remainder, at c/2 on the way: what the terms s^2 and s^3 leave of it there,
//!     r = N(w) - (c/2)^2 A - (c/2)^3 B,   A + c B = N(u)/c^2,   A + B = N(v),
//! acts as phi_1(hJ) r if it lasts over the step. Kinks that lie between the other two values are seen by it.
//!
//! A step costs two right-hand sides, a linearisation, a factorisation and four solves for four complex numbers side by side.
//! Products with J are not formed: for y = (theta/h I - J)^-1 f, J y = theta/h y - f.

use crate::linear::system::System;
use crate::linear::Linearisation;
use crate::methods::method::{flush, Effort, Method, Restart, Target};
use crate::methods::poles::{
    at_infinity, phi, plus, scaled, series, times_poles, Increments, Poles, Spread, Weights, TERMS,
};
use hydrocrane_num::lanes::native::NativeSimd;
use hydrocrane_num::lanes::register::Register;
use hydrocrane_num::Archive;

/// c: position of the second right-hand side as a share of the step.
const NODE: f64 = 0.6;
/// Position of the third value of the remainder, which the estimate takes.
const HALFWAY: f64 = 0.5 * NODE;
/// Weight of d in the estimate.
const BENDS: f64 = 0.2;
/// Weight of (hJ)^7 h F_1 in the estimate.
const POWER: f64 = 1e-8;

/// The method for `n` equations, with the poles in registers where the processor has them.
pub fn method(n: usize) -> Box<dyn Method> {
    if NativeSimd::is_available() {
        Box::new(Exponential4::<NativeSimd>::new(n))
    } else {
        Box::new(Exponential4::<f64>::new(n))
    }
}

/// theta^k phi_k(theta hJ) to the sixth power of hJ; fast components have reached their end.
fn on_the_way(theta: f64, k: u32) -> Weights {
    let mut terms = flow(theta, k);
    // -z times the function where z is large: the first term of phi_(k-1).
    let end = terms[0] * f64::from(k) / theta;
    terms[TERMS - 1] = 0.0;
    let slow = series(terms);
    plus(slow, scaled(last_power(), (end - at_infinity(slow)) / at_infinity(last_power())))
}

/// Weight of N(u) in v.
fn of_bend() -> Weights {
    scaled(phi(3), 2.0 / (NODE * NODE))
}

/// Weight of N(v) - N(u)/c^2 in d.
fn of_rest() -> Weights {
    scaled(plus(scaled(phi(4), 6.0), scaled(phi(3), -2.0 * NODE)), 1.0 / (1.0 - NODE))
}

/// (hJ)^7 h F_1
fn last_power() -> Weights {
    series(hydrocrane_num::array::from_fn(|m| f64::from(u8::from(m == TERMS - 1))))
}

/// The power series of theta^k phi_k(theta z).
fn flow(theta: f64, k: u32) -> [f64; TERMS] {
    let mut next = (1..=k).fold(1.0, |product, i| product * theta / f64::from(i));
    hydrocrane_num::array::from_fn(|m| {
        let term = next;
        next *= theta / (f64::from(k) + m as f64 + 1.0);
        term
    })
}

/// The power series of h F_1 and N(u) inside a step.
fn inside(theta: f64) -> [[f64; TERMS]; 2] {
    [flow(theta, 1), flow(theta, 3).map(|term| 2.0 / (NODE * NODE) * term)]
}

/// Share of d inside a step: the effect of the term s^3.
fn share(theta: f64) -> f64 {
    theta.powi(3) * (theta / 4.0 - NODE / 3.0) / (1.0 / 4.0 - NODE / 3.0)
}

/// The method for a [`System`].
struct Exponential4<R> {
    /// Linearisations at the start of the step and at the end of its last attempt.
    here: Linearisation,
    ahead: Linearisation,
    /// df/dt, and whether it is nonzero.
    time_derivative: Vec<f64>,
    driven: bool,
    weights: StepWeights<R>,
    poles: Poles<R>,
    /// Increments by F_1, by N(u)/h and by (N(v) - N(u)/c^2)/h.
    rates: Increments<R>,
    bends: Increments<R>,
    rests: Increments<R>,
    /// Increments by r/h.
    misses: Increments<R>,
    start: Vec<f64>,
    /// x + u; at the end of an attempt x + v, where `ahead` was made
    argument: Vec<f64>,
    /// h J u + h F_1, then h J v + h F_1, over h.
    product: Vec<f64>,
    /// N(u)/h, then (N(v) - N(u)/c^2)/h.
    bend: Vec<f64>,
    /// r/h
    miss: Vec<f64>,
    /// d
    correction: Vec<f64>,
    effort: Effort,
}

/// Weights of a sum over the poles, and of hJ times this sum.
struct SumAndProduct<R> {
    sum: Spread<R>,
    product: Spread<R>,
}

/// Weights of the increments in a step.
struct StepWeights<R> {
    on_the_way: SumAndProduct<R>,
    /// At c/2, by F_1 and by N(u).
    halfway: [SumAndProduct<R>; 2],
    of_rate: SumAndProduct<R>,
    of_bend: SumAndProduct<R>,
    of_rest: Spread<R>,
    last_power: Spread<R>,
    /// e^(hJ)
    flow: Spread<R>,
}

impl<R: Register> SumAndProduct<R> {
    fn new(weights: Weights) -> Self {
        SumAndProduct { sum: Spread::new(&weights), product: Spread::new(&times_poles(weights)) }
    }
}

impl<R: Register> Exponential4<R> {
    fn new(n: usize) -> Self {
        let poles = Poles::new(n);
        let room = || vec![0.0; n];
        Exponential4 {
            here: Linearisation::new(n),
            ahead: Linearisation::new(n),
            time_derivative: room(),
            driven: false,
            weights: StepWeights {
                on_the_way: SumAndProduct::new(on_the_way(NODE, 1)),
                halfway: [
                    SumAndProduct::new(on_the_way(HALFWAY, 1)),
                    SumAndProduct::new(scaled(on_the_way(HALFWAY, 3), 2.0 / (NODE * NODE))),
                ],
                of_rate: SumAndProduct::new(phi(1)),
                of_bend: SumAndProduct::new(of_bend()),
                of_rest: Spread::new(&of_rest()),
                last_power: Spread::new(&scaled(last_power(), POWER)),
                flow: Spread::new(&phi(0)),
            },
            rates: poles.increments(),
            bends: poles.increments(),
            rests: poles.increments(),
            misses: poles.increments(),
            poles,
            start: room(),
            argument: room(),
            product: room(),
            bend: room(),
            miss: room(),
            correction: room(),
            effort: Effort::default(),
        }
    }

    /// Weights of the increments by F_1 and by N(u) inside a step.
    #[inline(always)]
    fn inside(&self, theta: f64) -> [Spread<R>; 2] {
        // Not by `map`, which copies registers through memory.
        let [of_rate, of_bend] = inside(theta);
        [self.poles.series(of_rate), self.poles.series(of_bend)]
    }
}

impl<R: Register> Method for Exponential4<R> {
    fn order(&self) -> u32 {
        4
    }

    /// d and r are of fourth order, the rest of the estimate of eighth.
    fn estimate_order(&self) -> u32 {
        5
    }

    fn begin(&mut self, system: &dyn System, t: f64, x: &[f64], restart: Restart) {
        if restart == Restart::State {
            system.linearise(t, x, &mut self.here);
            self.effort.jacobians += 1;
        } else {
            std::mem::swap(&mut self.here, &mut self.ahead);
        }
        if restart == Restart::Input {
            system.update_input(t, x, &mut self.here);
        }
        self.driven = system.time_derivative(t, x, &mut self.time_derivative);
    }

    fn attempt(&mut self, system: &dyn System, t: f64, h: f64, x: &[f64], to: &mut Target) -> bool {
        self.effort.factorisations += 1;
        if !self.poles.factor(&self.here, h) {
            return false;
        }
        let Exponential4 {
            here,
            ahead,
            weights,
            poles,
            rates,
            bends,
            rests,
            misses,
            argument,
            product,
            bend,
            miss,
            correction,
            ..
        } = self;
        self.start.copy_from_slice(x);
        poles.solve(here, &here.rate, self.driven.then_some((h, &self.time_derivative)), rates);
        let on = &weights.on_the_way;
        poles.sums([rates], [[&on.sum], [&on.product]], [argument, product]);
        argument.iter_mut().zip(x).for_each(|(argument, x)| *argument += x);
        system.derivative(t + NODE * h, argument, bend);
        bend.iter_mut().zip(&*product).for_each(|(bend, product)| *bend -= product / h);
        poles.solve(here, bend, None, bends);
        let [rate, bent] = &weights.halfway;
        poles.sums([rates, bends], [[&rate.sum, &bent.sum], [&rate.product, &bent.product]], [argument, product]);
        argument.iter_mut().zip(x).for_each(|(argument, x)| *argument += x);
        system.derivative(t + HALFWAY * h, argument, miss);
        miss.iter_mut().zip(&*product).for_each(|(miss, product)| *miss -= product / h);
        let ([rate, bent], end) = ([&weights.of_rate, &weights.of_bend], &mut to.x);
        poles.sums([rates, bends], [[&rate.sum, &bent.sum], [&rate.product, &bent.product]], [end, product]);
        end.iter_mut().zip(x).for_each(|(end, x)| *end += x);
        // The next step goes on from rates at this state.
        flush(end);
        system.linearise(t + h, end, ahead);
        argument.copy_from_slice(end);
        self.effort.derivatives += 2;
        self.effort.jacobians += 1;
        bend.iter_mut()
            .zip(ahead.rate.iter().zip(&*product))
            .for_each(|(rest, (rate, product))| *rest = rate - product / h);
        poles.solve(here, bend, None, rests);
        poles.sums([rests], [[&weights.of_rest]], [correction]);
        // So far `miss` is the remainder less what N(u) alone would let expect; B adds its part.
        const CUBE: f64 = HALFWAY * HALFWAY * (HALFWAY - NODE) / (1.0 - NODE);
        miss.iter_mut().zip(&*bend).for_each(|(miss, rest)| *miss -= CUBE * rest);
        poles.solve(here, miss, None, misses);
        flush(correction);
        ahead.shift(correction);
        poles.sums([rates, misses], [[&weights.last_power, &weights.of_rate.sum]], [&mut to.error]);
        for ((end, error), correction) in end.iter_mut().zip(&mut to.error).zip(&*correction) {
            *end += correction;
            *error += BENDS * correction;
        }
        true
    }

    fn carry(&mut self, h: f64, error: &mut [f64]) -> bool {
        // Neither is needed any more after an attempt.
        let Exponential4 { here, weights, poles, rests, product, .. } = self;
        product.iter_mut().zip(&*error).for_each(|(per_time, error)| *per_time = error / h);
        poles.solve(here, product, None, rests);
        poles.sums([rests], [[&weights.flow]], [error]);
        true
    }

    fn interpolate(&self, theta: f64, x: &mut [f64]) {
        let [of_rate, of_bend] = self.inside(theta);
        self.poles.sums([&self.rates, &self.bends], [[&of_rate, &of_bend]], [x]);
        let share = share(theta);
        for ((x, start), correction) in x.iter_mut().zip(&self.start).zip(&self.correction) {
            *x += start + share * correction;
        }
    }

    fn interpolate_some(&self, theta: f64, states: &[usize], x: &mut [f64]) {
        let [of_rate, of_bend] = self.inside(theta);
        self.poles.sums_of(states, [&self.rates, &self.bends], [[&of_rate, &of_bend]], [x]);
        let share = share(theta);
        for &i in states {
            x[i] += self.start[i] + share * self.correction[i];
        }
    }

    /// The linearisation at the end of the last step follows from where it was made and by how much it was shifted.
    fn archive(&mut self, system: &dyn System, t: f64, archive: &mut Archive) {
        archive.numbers(&mut self.argument);
        archive.numbers(&mut self.correction);
        if archive.reads() {
            system.linearise(t, &self.argument, &mut self.ahead);
            self.ahead.shift(&self.correction);
        }
    }

    fn effort(&self) -> Effort {
        self.effort
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::poles::value;
    use hydrocrane_num::Complex;

    /// (6 phi_4 - 2 c phi_3)/(1 - c) and so on at z = 0, where phi_k = 1/k!: the integral of a remainder s^2 or s^3 with J = 0.
    #[test]
    fn a_step_integrates_the_square_and_the_cube_of_a_bend() {
        let (first, rest) = (value(of_bend(), Complex::new(0.0, 0.0)).re, value(of_rest(), Complex::new(0.0, 0.0)).re);
        for power in [2, 3] {
            let at_node = NODE.powi(power);
            let whole = first * at_node + rest * (1.0 - at_node / (NODE * NODE));
            assert!((whole - 1.0 / f64::from(power + 1)).abs() < 1e-11, "{power}: {whole}");
        }
    }

    #[test]
    fn at_the_node_what_is_linear_is_met_to_the_seventh_power_of_the_step_and_what_is_fast_has_arrived() {
        let off = |z: f64| (1.0 + z * value(on_the_way(NODE, 1), Complex::new(z, 0.0)).re - (NODE * z).exp()).abs();
        assert!(off(0.1) < 1e-11 && (200.0..600.0).contains(&(off(2.0) / off(1.0))), "{} {}", off(1.0), off(2.0));
        assert!(off(-1e6) < 1e-3 && off(-1e9) < 1e-6);
    }

    /// x' = z x from 1 over a step of size 1.
    struct Linear(Complex<f64>);

    impl System for Linear {
        fn dimension(&self) -> usize {
            2
        }
        fn derivative(&self, _t: f64, x: &[f64], dx: &mut [f64]) {
            let rate = self.0 * Complex::new(x[0], x[1]);
            dx.copy_from_slice(&[rate.re, rate.im]);
        }
        fn linearise(&self, t: f64, x: &[f64], at: &mut Linearisation) {
            self.derivative(t, x, &mut at.rate);
            at.dense(0).copy_from_slice(&[self.0.re, -self.0.im, self.0.im, self.0.re]);
        }
        fn time_derivative(&self, _t: f64, _x: &[f64], _dfdt: &mut [f64]) -> bool {
            false
        }
        fn admissible(&self, _x: &[f64]) -> bool {
            true
        }
        fn scales(&self) -> &[f64] {
            &[1.0; 2]
        }
    }

    /// The states at `theta` and at the end of the step.
    fn step(z: Complex<f64>, theta: f64, method: &mut dyn Method) -> [Complex<f64>; 2] {
        let (mut inside, mut target) = ([0.0; 2], Target::new(2));
        method.begin(&Linear(z), 0.0, &[1.0, 0.0], Restart::State);
        assert!(method.attempt(&Linear(z), 0.0, 1.0, &[1.0, 0.0], &mut target));
        method.interpolate(theta, &mut inside);
        [Complex::new(inside[0], inside[1]), Complex::new(target.x[0], target.x[1])]
    }

    fn size(z: Complex<f64>) -> f64 {
        z.re.hypot(z.im)
    }

    #[test]
    fn it_is_l_stable() {
        let end = |re: f64, im: f64| size(step(Complex::new(re, im), 0.5, &mut Exponential4::<f64>::new(2))[1]);
        for i in 1..2000 {
            let y = 0.01 * 1.01f64.powi(i);
            assert!(end(0.0, y) < 1.0 + 1e-9, "{y}: {}", end(0.0, y));
        }
        for (fast, left) in [(1e1, 1e-4), (1e2, 0.03), (1e4, 0.01), (1e8, 1e-6)] {
            assert!(end(-fast, 0.0) < left, "{fast}: {}", end(-fast, 0.0));
        }
    }

    #[test]
    fn a_swing_of_14_hz_is_followed_in_steps_of_25_ms_inside_them_too() {
        let y = 14.0 * std::f64::consts::TAU * 0.025;
        for theta in [0.25, 0.5, 0.75] {
            let exact = |theta: f64| Complex::new((theta * y).cos(), (theta * y).sin());
            let [inside, end] = step(Complex::new(0.0, y), theta, &mut Exponential4::<f64>::new(2));
            assert!(size(end - exact(1.0)) < 1e-11, "{}", size(end - exact(1.0)));
            assert!(size(inside - exact(theta)) < 1e-7, "{theta}: {}", size(inside - exact(theta)));
        }
    }

    #[test]
    fn an_error_is_carried_as_the_state_is() {
        for z in [Complex::new(-0.3, 1.2), Complex::new(2.0, 5.0), Complex::new(-2.0, 0.0)] {
            let (mut method, mut error) = (Exponential4::<f64>::new(2), [1e-3, 0.0]);
            let [_, end] = step(z, 0.5, &mut method);
            assert!(method.carry(1.0, &mut error));
            let off = Complex::new(1e3 * error[0], 1e3 * error[1]) - end;
            assert!(size(off) < 1e-9, "{z:?}: {off:?}");
        }
    }

    #[test]
    fn some_states_inside_a_step_are_those_of_all() {
        let mut method = method(2);
        let (mut all, mut some, mut target) = ([0.0; 2], [0.0; 2], Target::new(2));
        let z = Complex::new(-0.3, 1.2);
        method.begin(&Linear(z), 0.0, &[1.0, 0.0], Restart::State);
        assert!(method.attempt(&Linear(z), 0.0, 1.0, &[1.0, 0.0], &mut target));
        method.interpolate(0.3, &mut all);
        method.interpolate_some(0.3, &[1], &mut some);
        assert_eq!((some[0], some[1].to_bits()), (0.0, all[1].to_bits()));
    }

    #[test]
    fn registers_give_the_bits_of_single_numbers() {
        for z in [Complex::new(-0.3, 1.2), Complex::new(-40.0, 3.0)] {
            let alone = step(z, 0.3, &mut Exponential4::<f64>::new(2));
            let chosen = step(z, 0.3, method(2).as_mut());
            assert_eq!(
                alone.map(|z| [z.re.to_bits(), z.im.to_bits()]),
                chosen.map(|z| [z.re.to_bits(), z.im.to_bits()])
            );
        }
    }
}
