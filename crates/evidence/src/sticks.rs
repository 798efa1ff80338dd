//! What random hands do with the sticks: full deflections held for random times, sweeps in between.

use hydrocrane_num::RandomStream;
use serde::{Deserialize, Serialize};

/// Sticks held for so many ticks of 1 ms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Move {
    pub ticks: u32,
    pub deflections: Vec<f64>,
}

/// The sticks change at the controllers' samples, ticks.
const SAMPLE: u32 = 10;
/// A deflection is held this long, samples; short times are the most frequent.
const HELD: [f64; 2] = [5.0, 300.0];
/// Shares of deflections that are full (either way) and none; the rest lies between.
const FULL: f64 = 0.65;
const CENTRED: f64 = 0.25;
/// Share of deflections that are reached in a straight line instead of at once.
const SWEPT: f64 = 0.2;

/// `axes` sticks for `ticks` of 1 ms; drive `number` under `seed`. The same numbers give the same sticks everywhere.
pub fn moves(seed: u64, number: u64, axes: usize, ticks: u32) -> Vec<Move> {
    let samples = ticks.div_ceil(SAMPLE) as usize;
    let sticks: Vec<Vec<f64>> = (0..axes)
        .map(|axis| stick(&mut RandomStream::new(seed, &format!("drive {number} axis {axis}")), samples))
        .collect();
    let mut moves: Vec<Move> = Vec::new();
    for sample in 0..samples {
        let deflections: Vec<f64> = sticks.iter().map(|stick| stick[sample]).collect();
        let length = SAMPLE.min(ticks - sample as u32 * SAMPLE);
        match moves.last_mut().filter(|last| last.deflections == deflections) {
            Some(last) => last.ticks += length,
            None => moves.push(Move { ticks: length, deflections }),
        }
    }
    moves
}

/// One stick, sample by sample.
fn stick(random: &mut RandomStream, samples: usize) -> Vec<f64> {
    let (mut path, mut held) = (Vec::with_capacity(samples), 0.0);
    while path.len() < samples {
        let long = random.uniform();
        let length = (HELD[0] + (HELD[1] - HELD[0]) * long * long) as usize;
        let (kind, level, swept) = (random.uniform(), random.symmetric(), random.uniform() < SWEPT);
        let wanted = if kind < FULL {
            level.signum()
        } else if kind < FULL + CENTRED {
            0.0
        } else {
            level
        };
        let share = |k: usize| if swept { (k + 1) as f64 / length as f64 } else { 1.0 };
        path.extend((0..length).map(|k| held + (wanted - held) * share(k)));
        held = wanted;
    }
    path.truncate(samples);
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_repeats_and_numbers_differ() {
        assert_eq!(moves(1, 4, 3, 5000), moves(1, 4, 3, 5000));
        assert_ne!(moves(1, 4, 3, 5000), moves(1, 5, 3, 5000));
        assert_ne!(moves(2, 4, 3, 5000), moves(1, 4, 3, 5000));
    }

    #[test]
    fn sticks_fill_the_time_and_reach_both_ends() {
        for ticks in [1, 9, 10, 4321] {
            assert_eq!(moves(0, 0, 2, ticks).iter().map(|m| m.ticks).sum::<u32>(), ticks);
        }
        let all = moves(0, 0, 2, 60_000);
        for axis in 0..2 {
            let held = |level: f64| all.iter().filter(|m| m.deflections[axis] == level).map(|m| m.ticks).sum::<u32>();
            assert!(held(1.0) > 10_000 && held(-1.0) > 10_000, "{} {}", held(1.0), held(-1.0));
        }
    }
}
