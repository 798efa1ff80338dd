//! Spool positions that commands have asked for, in a list of bounded length.  theory: docs/theory/control/plausibility.md
//!
//! Commands that follow each other faster than the list can tell apart become one span with the interval of all of them. What a spool
//! can have had in a time then holds a little more, never less.

use crate::model::oil_displacement::Interval;
use arrayvec::ArrayVec;

/// Spans that are kept. Over a memory of 0.3 s, that of a slow pilot-operated valve, commands 5 ms apart still have one each.
const MOST: usize = 64;

#[derive(Debug, Clone)]
pub struct SpoolHistory<const N: usize> {
    /// Oldest first.
    spans: ArrayVec<Span<N>, MOST>,
    /// How far back anybody asks, s.
    memory: f64,
}

/// Positions asked for from a time on until the next span begins.
#[derive(Debug, Clone, Copy)]
struct Span<const N: usize> {
    /// s
    from: f64,
    /// m
    spools: [Interval; N],
}

impl<const N: usize> SpoolHistory<N> {
    /// Of the last `memory` (s).
    pub fn new(memory: f64) -> Self {
        SpoolHistory { spans: ArrayVec::new(), memory }
    }

    pub fn clear(&mut self) {
        self.spans.clear();
    }

    /// Least time from one span to the next, s: one more span reaches back beyond the memory, and one is new.
    fn resolution(&self) -> f64 {
        self.memory / (MOST - 2) as f64
    }

    /// Adds the positions (m) asked for at time `t` (s), which must not decrease.
    pub fn add(&mut self, t: f64, spools: [f64; N]) {
        let first = self.spans.iter().skip(1).take_while(|span| span.from < t - self.memory).count();
        self.spans.drain(..first);
        let (resolution, full) = (self.resolution(), self.spans.is_full());
        match self.spans.last_mut() {
            Some(last) if full || t < last.from + resolution => {
                for (all, spool) in last.spools.iter_mut().zip(spools) {
                    *all = all.joined(Interval::at(spool));
                }
            }
            _ => self.spans.push(Span { from: t, spools: spools.map(Interval::at) }),
        }
    }

    /// All positions that spool `c` was asked to have since `begin` (s), with the one that held then; `unknown` is all that somebody
    /// else can have asked for before the first command.
    pub fn since(&self, c: usize, begin: f64, unknown: Interval) -> Interval {
        let later = self.spans.partition_point(|span| span.from <= begin);
        let acting = match later {
            0 => unknown,
            n => self.spans[n - 1].spools[c],
        };
        self.spans.iter().skip(later).map(|span| span.spools[c]).chain([acting]).fold(Interval::NONE, Interval::joined)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNKNOWN: Interval = Interval { low: -0.06, high: 0.06 };

    /// What one may ask for, from every command.
    fn exact(sent: &[(f64, f64)], begin: f64) -> Interval {
        let acting = sent.iter().rev().find(|(t, _)| *t <= begin).map_or(UNKNOWN, |(_, spool)| Interval::at(*spool));
        Interval::hull(sent.iter().filter(|(t, _)| *t > begin).map(|(_, spool)| *spool)).joined(acting)
    }

    fn spool(k: usize) -> f64 {
        0.05 * (0.37 * k as f64).sin()
    }

    #[test]
    fn commands_slower_than_the_resolution_are_all_kept() {
        let (memory, period) = (0.3, 0.005);
        let (mut history, mut sent) = (SpoolHistory::<1>::new(memory), Vec::new());
        for k in 0..500 {
            let t = period * k as f64;
            history.add(t, [spool(k)]);
            sent.push((t, spool(k)));
            for back in [0.0, 0.004, 0.1, 0.299, memory] {
                assert_eq!(history.since(0, t - back, UNKNOWN), exact(&sent, t - back), "{t} {back}");
            }
        }
        assert!(!history.spans.is_full());
    }

    #[test]
    fn faster_commands_are_joined_and_none_is_missing() {
        for (memory, period) in [(0.05, 2e-4), (0.3, 1e-3), (2.0, 0.01), (0.05, 0.0)] {
            let (mut history, mut sent) = (SpoolHistory::<1>::new(memory), Vec::new());
            for k in 0..20_000 {
                let t = period * k as f64;
                history.add(t, [spool(k / 20)]);
                sent.push((t, spool(k / 20)));
                if k % 97 == 0 {
                    let earlier = history.resolution() + period;
                    for back in [0.0, 0.3 * memory, memory] {
                        let found = history.since(0, t - back, UNKNOWN);
                        let (least, most) = (exact(&sent, t - back), exact(&sent, t - back - earlier));
                        assert!(found.low <= least.low && found.high >= least.high, "{memory} {period} {k}");
                        assert!(found.low >= most.low && found.high <= most.high, "{memory} {period} {k}");
                    }
                }
            }
        }
    }
}
