//! Pressure transmitter.                            theory: docs/theory/sensor/pressure_transmitter.md
//!
//! 0 to 400 bar, 0.3 % of full scale, 4 ms        thesis (2.2.3.1, Figure 90)
//!     tau dy/dt = p - y,   tau = rise time / ln 9
//! then zero point, span and noise of an analogue sensor. The rise time of a data sheet goes from 10 to 90 %.
//! A live zero, the share of the supply voltage that stands for no pressure, shows readings below zero and beyond full
//! scale by live zero / (1 - 2 live zero) of the range; without one, pressures below zero read zero.

use super::analogue::{Analogue, Quality, Range};
use super::Converter;
use hydrocrane_num::{portable, Archive, RandomStream};

#[derive(Debug, Clone, PartialEq)]
pub struct PressureTransmitter {
    sensor: Analogue,
    time_constant: f64,
    /// Pressure behind the lag and the pressure in front of it at `since`, Pa.
    lagged: f64,
    ahead: f64,
    since: f64,
}

/// exp(-h/tau) as last computed: the transmitters of a machine are often alike.
#[derive(Debug, Clone, Copy)]
pub struct Decay {
    ratio: f64,
    left: f64,
}

impl Default for Decay {
    fn default() -> Self {
        Decay { ratio: 0.0, left: 1.0 }
    }
}

impl Decay {
    fn over(&mut self, ratio: f64) -> f64 {
        if ratio != self.ratio {
            *self = Decay { ratio, left: portable::exp(-ratio) };
        }
        self.left
    }
}

/// What the output stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Full scale, Pa.
    pub full: f64,
    /// Share of the supply voltage at no pressure, and left above full scale; below one half.
    pub live_zero: f64,
}

impl PressureTransmitter {
    /// Rise time in s.
    pub fn new(scale: Scale, bits: Option<u32>, rise_time: f64, quality: Quality, random: RandomStream) -> Self {
        let Scale { full, live_zero } = scale;
        let beyond = full * live_zero / (1.0 - 2.0 * live_zero);
        let converter = Converter { low: -beyond, high: full + beyond, bits };
        // The data sheet speaks of the range, not of what the converter spans.
        let range = Range { low: 0.0, high: full };
        PressureTransmitter {
            sensor: Analogue::within(range, converter, quality, random),
            time_constant: rise_time / portable::ln(9.0),
            lagged: 0.0,
            ahead: 0.0,
            since: 0.0,
        }
    }

    /// Starts settled at the pressure `p`.
    pub fn settle(&mut self, t: f64, p: f64) {
        (self.lagged, self.ahead, self.since) = (p, p, t);
    }

    /// Goes on to time `t`, the pressure having changed to `p` along a straight line: exact for that line.
    pub fn follow(&mut self, t: f64, p: f64) {
        self.follow_with(t, p, &mut Decay::default());
    }

    /// The same, with what is left of a lag as it was for the transmitter before.
    pub fn follow_with(&mut self, t: f64, p: f64, decay: &mut Decay) {
        let h = t - self.since;
        if h <= 0.0 {
            return;
        }
        if self.time_constant > 0.0 {
            let slope = (p - self.ahead) / h;
            let offset = self.lagged - self.ahead + slope * self.time_constant;
            self.lagged = p - slope * self.time_constant + offset * decay.over(h / self.time_constant);
        } else {
            self.lagged = p;
        }
        (self.ahead, self.since) = (p, t);
    }

    /// What changes while it measures.
    pub fn archive(&mut self, archive: &mut Archive) {
        for number in [&mut self.lagged, &mut self.ahead, &mut self.since] {
            archive.number(number);
        }
        self.sensor.random.archive(archive);
    }

    pub fn read(&mut self) -> f64 {
        self.sensor.read(self.lagged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCALE: Scale = Scale { full: 400e5, live_zero: 0.0 };

    fn exact(rise_time: f64) -> PressureTransmitter {
        PressureTransmitter::new(SCALE, None, rise_time, Quality::default(), RandomStream::new(0, "p1"))
    }

    #[test]
    fn the_rise_time_is_that_of_the_data_sheet() {
        let mut transmitter = exact(4e-3);
        transmitter.settle(0.0, 0.0);
        // A step: the pressure has risen before the first microsecond is over.
        let mut crossings = [0.0; 2];
        transmitter.follow(1e-9, 100e5);
        for i in 1..20_000 {
            transmitter.follow(f64::from(i) * 1e-6, 100e5);
            let y = transmitter.read();
            if y < 10e5 {
                crossings[0] = f64::from(i) * 1e-6;
            }
            if y < 90e5 {
                crossings[1] = f64::from(i) * 1e-6;
            }
        }
        assert!((crossings[1] - crossings[0] - 4e-3).abs() < 2e-6, "{crossings:?}");
    }

    #[test]
    fn transmitters_in_a_row_follow_as_each_does_alone() {
        let (mut decay, rises) = (Decay::default(), [4e-3, 4e-3, 1e-3, 4e-3]);
        for rise in rises {
            let (mut alone, mut in_a_row) = (exact(rise), exact(rise));
            alone.follow(1e-3, 50e5);
            in_a_row.follow_with(1e-3, 50e5, &mut decay);
            assert_eq!(alone, in_a_row);
        }
    }

    #[test]
    fn a_ramp_is_followed_exactly_whatever_the_steps() {
        let tau = 4e-3 / 9f64.ln();
        for steps in [1, 7] {
            let mut transmitter = exact(4e-3);
            transmitter.settle(0.0, 10e5);
            for i in 1..=steps {
                let t = 0.01 * f64::from(i) / f64::from(steps);
                transmitter.follow(t, 10e5 + 1e8 * t);
            }
            let expected = 10e5 + 1e8 * (0.01 - tau + tau * (-0.01 / tau).exp());
            assert!((transmitter.read() - expected).abs() < 1e-3);
        }
    }

    #[test]
    fn vacuum_reads_zero_and_a_settled_one_reads_within_its_accuracy() {
        let quality = Quality { accuracy: 0.003, ..Quality::default() };
        for seed in 0..100 {
            let mut transmitter =
                PressureTransmitter::new(SCALE, Some(12), 4e-3, quality, RandomStream::new(seed, "p1"));
            transmitter.settle(0.0, 120e5);
            assert!((transmitter.read() - 120e5).abs() <= 0.003 * 400e5 + 0.5 * 400e5 / 4095.0);
            transmitter.settle(0.0, -10e5);
            assert_eq!(transmitter.read(), 0.0);
        }
    }

    #[test]
    fn a_live_zero_shows_the_zero_point_on_both_sides_and_keeps_the_accuracy() {
        let quality = Quality { accuracy: 0.003, ..Quality::default() };
        let scale = Scale { live_zero: 0.1, ..SCALE };
        let (mut below, mut largest, mut at_full_scale) = (0, 0.0f64, 0.0f64);
        for seed in 0..200 {
            let mut transmitter = PressureTransmitter::new(scale, None, 4e-3, quality, RandomStream::new(seed, "p1"));
            transmitter.settle(0.0, 0.0);
            let zero = transmitter.read();
            below += u32::from(zero < 0.0);
            largest = largest.max(zero.abs());
            transmitter.settle(0.0, -100e5);
            assert!(
                (transmitter.read() + 50e5).abs() < 1e-6,
                "the output ends at 0 V: an eighth of the range below zero"
            );
            transmitter.settle(0.0, 400e5);
            at_full_scale = at_full_scale.max((transmitter.read() - 400e5).abs());
        }
        assert!((60..140).contains(&below), "{below} of 200");
        for largest in [largest, at_full_scale] {
            assert!(largest <= 0.003 * 400e5 && largest > 0.9 * 0.003 * 400e5, "{largest}");
        }
    }
}
