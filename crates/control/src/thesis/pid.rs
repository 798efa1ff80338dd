//! PID in velocity form with limits.                                 theory: docs/theory/control/heinze_pid.md
//!
//! du_t = k_p (e_t - e_{t-1}) + k_i e_t + k_d (e_t - 2 e_{t-1} + e_{t-2})                  thesis (129)
//! u_t  = u_{t-1} + du_t, kept within its limits                                            thesis (130)
//!
//! The gains act per sample, as in the thesis: k_i holds the period as a factor and k_d its inverse (128). Limiting
//! the sum is what keeps the integral from winding up. Departs from the source: (129) prints e_t + e_{t-2} in its
//! last term (E21); the program has the second difference.

/// Gains per sample, in units of output per unit of error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    pub proportional: f64,
    pub integral: f64,
    pub derivative: f64,
}

hydrocrane_num::stored!([] Gains { proportional: f64, integral: f64, derivative: f64 });

/// One loop and its memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid {
    gains: Gains,
    limits: [f64; 2],
    /// Errors of the last two samples, newest first.
    errors: [f64; 2],
    output: f64,
}

impl Pid {
    /// Starts with zero output and zero errors.
    pub fn new(gains: Gains, limits: [f64; 2]) -> Self {
        Pid { gains, limits, errors: [0.0; 2], output: 0.0 }
    }

    pub fn reset(&mut self) {
        self.errors = [0.0; 2];
        self.output = 0.0;
    }

    pub fn step(&mut self, error: f64) -> f64 {
        let [last, earlier] = self.errors;
        let g = &self.gains;
        let change =
            g.proportional * (error - last) + g.integral * error + g.derivative * (error - 2.0 * last + earlier);
        self.errors = [error, last];
        self.output = (self.output + change).max(self.limits[0]).min(self.limits[1]);
        self.output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: Gains = Gains { proportional: 2.0, integral: 0.1, derivative: 0.5 };

    /// (128) with sums and differences written out.
    fn positional(errors: &[f64]) -> f64 {
        let n = errors.len();
        let last = if n > 1 { errors[n - 2] } else { 0.0 };
        let sum: f64 = errors.iter().sum();
        GAINS.proportional * errors[n - 1] + GAINS.integral * sum + GAINS.derivative * (errors[n - 1] - last)
    }

    #[test]
    fn is_the_positional_form_as_long_as_no_limit_is_met() {
        let mut pid = Pid::new(GAINS, [-1e9, 1e9]);
        let errors = [0.3, -0.2, 0.25, 0.9, 0.1, -0.4];
        for n in 1..=errors.len() {
            assert!((pid.step(errors[n - 1]) - positional(&errors[..n])).abs() < 1e-14);
        }
    }

    #[test]
    fn leaves_its_limit_as_soon_as_the_error_falls() {
        let mut pid = Pid::new(Gains { derivative: 0.0, ..GAINS }, [-1.0, 1.0]);
        for _ in 0..1000 {
            assert_eq!(pid.step(5.0), 1.0);
        }
        assert!(pid.step(4.0) < 0.0, "no wind-up");
        pid.reset();
        assert_eq!(pid.step(0.0), 0.0);
    }
}
