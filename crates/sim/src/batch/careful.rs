//! A group on its way through one sample, and the cranes of it that cannot follow.
//!
//! The group takes its steps at once and looks at the end. A crane that is then nowhere sensible goes through the sample
//! again by itself, with smaller steps where they help, and is left at its last sensible state where they do not. It does
//! so in all lanes alike: that its neighbours are others cannot matter, and they do not notice.

use super::kernel::{Group, Mover, Stretch, WIDTH};
use super::line::{CommandLine, Plan};
use super::Fate;
use crate::outcome::OutcomeKind;

/// Most parts that a step is cut into.
const FINEST: usize = 64;

/// Moves a group from `start`, where `x` is too, through the stretches of a sample.
#[allow(clippy::too_many_arguments)]
pub(super) fn advance(
    mover: &mut dyn Mover,
    plan: &[Plan],
    line: &CommandLine,
    group: usize,
    payload: Group,
    start: &[Group],
    x: &mut [Group],
    fates: &mut [Fate; WIDTH],
) {
    let well = fates.map(|fate| fate.kind == OutcomeKind::Completed);
    if well == [false; WIDTH] {
        return;
    }
    for stretch in plan {
        let spools = line.at_spools(stretch, group);
        let spools = &spools[..line.cylinders()];
        mover.advance(Stretch { steps: stretch.steps, h: stretch.h, spools, payload }, x);
    }
    let sensible = mover.look(x).sensible;
    let duration: f64 = plan.iter().map(|stretch| stretch.steps as f64 * stretch.h).sum();
    for lane in 0..WIDTH {
        if !well[lane] {
            x.iter_mut().zip(start).for_each(|(x, start)| x[lane] = start[lane]);
        } else if sensible[lane] {
            fates[lane].time += duration;
        } else {
            let mut alone = Alone { x: start.iter().map(|lanes| [lanes[lane]; WIDTH]).collect(), time: 0.0 };
            let kind = alone.ride(mover, plan, line, (group, lane), payload[lane]);
            x.iter_mut().zip(&alone.x).for_each(|(x, alone)| x[lane] = alone[0]);
            fates[lane] = Fate { kind, time: fates[lane].time + alone.time };
        }
    }
}

/// One crane in all lanes.
struct Alone {
    x: Vec<Group>,
    /// s since the start of the sample.
    time: f64,
}

impl Alone {
    fn ride(
        &mut self,
        mover: &mut dyn Mover,
        plan: &[Plan],
        line: &CommandLine,
        (group, lane): (usize, usize),
        payload: f64,
    ) -> OutcomeKind {
        for stretch in plan {
            let spools = line.at_spools(stretch, group).map(|lanes| [lanes[lane]; WIDTH]);
            let spools = &spools[..line.cylinders()];
            for _ in 0..stretch.steps {
                let step = Stretch { steps: 1, h: stretch.h, spools, payload: [payload; WIDTH] };
                if let Err(kind) = self.step(mover, step) {
                    return kind;
                }
            }
        }
        OutcomeKind::Completed
    }

    /// One step, whole or in the fewest parts that lead somewhere sensible.
    fn step(&mut self, mover: &mut dyn Mover, step: Stretch) -> Result<(), OutcomeKind> {
        let mut parts = 1;
        loop {
            let mut next = self.x.clone();
            let part = Stretch { h: step.h / parts as f64, ..step };
            let arrived = arrives(mover, part, parts, &mut next);
            if arrived {
                self.x = next;
                self.time += step.h;
                return Ok(());
            }
            if parts == FINEST {
                let finite = next.iter().all(|lanes| lanes[0].is_finite());
                return Err(if finite { OutcomeKind::StrokeLimit } else { OutcomeKind::SolverFailed });
            }
            parts *= 2;
        }
    }
}

/// Takes a step several times; whether each led somewhere sensible.
fn arrives(mover: &mut dyn Mover, step: Stretch, times: usize, x: &mut [Group]) -> bool {
    for _ in 0..times {
        mover.advance(step, x);
        if !mover.look(x).sensible[0] {
            return false;
        }
    }
    true
}
