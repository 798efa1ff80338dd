//! The signal chain between a command and the spool, forwards and backwards.   theory: docs/theory/control/regulate.md
//!
//! x_s = limited(o + g z),   z = u -+ b beyond the dead band +-b, else 0
//! u = z + b sat(z / w),     z = (x_s - o)/g
//!
//! Forwards as the plant has it. Backwards the step of 2 b that a spool asks for as it passes the middle of its chain is spread over a
//! width w, so that noise there does not become steps of the command.

/// Signal chain of one valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalChain {
    /// o, spool position without a command, m.
    pub offset: f64,
    /// g
    pub gain: f64,
    /// b, commands up to this size do nothing, m.
    pub dead_band: f64,
    /// Lowest and highest spool position that a command can ask for, m.
    pub limits: [f64; 2],
}

hydrocrane_num::stored!([] SignalChain { offset: f64, gain: f64, dead_band: f64, limits: [f64; 2] });

/// w, share of the dead band.
const WIDTH: f64 = 0.01;

impl SignalChain {
    /// Passes commands on as they are, up to the spool's `stroke` (m).
    pub fn direct(stroke: f64) -> Self {
        SignalChain { offset: 0.0, gain: 1.0, dead_band: 0.0, limits: [-stroke, stroke] }
    }

    /// Spool position (m) after the command `u` (m).
    pub fn spool(&self, u: f64) -> f64 {
        let [low, high] = self.limits;
        (self.offset + self.gain * (u - u.clamp(-self.dead_band, self.dead_band))).clamp(low, high)
    }

    /// Command (m) that brings the spool to `spool` (m); zero where no command moves it.
    pub fn command(&self, spool: f64) -> f64 {
        let [low, high] = self.limits;
        let beyond = (spool.clamp(low, high) - self.offset) / self.gain;
        if !beyond.is_finite() {
            return 0.0;
        }
        let width = WIDTH * self.dead_band;
        let side = if width > 0.0 { (beyond / width).clamp(-1.0, 1.0) } else { 0.0 };
        beyond + side * self.dead_band
    }

    /// Spool positions that commands within the `stroke` (m) reach, lowest and highest, m.
    pub fn reach(&self, stroke: f64) -> [f64; 2] {
        let [one, other] = [-stroke, stroke].map(|u| self.spool(u));
        [one.min(other), one.max(other)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHAIN: SignalChain = SignalChain { offset: 1e-3, gain: -0.8, dead_band: 2.5e-3, limits: [-0.05, 0.045] };

    #[test]
    fn a_command_brings_the_spool_where_it_shall_be() {
        for k in -45..=40 {
            let spool = 1e-3 * f64::from(k) + 0.3e-3;
            // Between +-w of the middle a little is missing.
            assert!((CHAIN.spool(CHAIN.command(spool)) - spool).abs() < 1e-12, "{spool}");
        }
        assert_eq!(SignalChain::direct(0.05).command(0.0123), 0.0123);
        assert_eq!(SignalChain { gain: 0.0, ..CHAIN }.command(0.01), 0.0);
    }

    #[test]
    fn the_command_has_no_step_and_misses_the_spool_by_little() {
        let mut last = CHAIN.command(-0.01);
        for k in -10_000..10_000 {
            let spool = 1e-6 * f64::from(k);
            let u = CHAIN.command(spool);
            assert!((u - last).abs() < 130.0 * 1e-6, "{spool}");
            assert!((CHAIN.spool(u) - spool).abs() < 0.01 * CHAIN.dead_band, "{spool}");
            last = u;
        }
    }

    #[test]
    fn limits_and_gain_bound_what_commands_reach() {
        let [low, high] = CHAIN.reach(0.05);
        assert!((low - (1e-3 - 0.8 * 0.0475)).abs() < 1e-15 && (high - (1e-3 + 0.8 * 0.0475)).abs() < 1e-15);
        assert_eq!(SignalChain::direct(0.05).reach(0.05), [-0.05, 0.05]);
    }
}
