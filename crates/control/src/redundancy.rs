//! Joint rates for a velocity of the tip.                      theory: docs/theory/control/redundancy.md
//!
//! least sum_i w_i (q'_i - q'_pref,i)^2   with   J q' = s v + c   and   lower_i <= q'_i <= upper_i
//!
//! for the largest s in 0 to 1: v is what the stick asks for and may be slowed down, but not turned; c corrects the
//! path and is not slowed down. Without limits the answer is a weighted pseudo-inverse. A joint at its limit is held there
//! and the others take over its share, as long as two are left (saturation in the null space); where even that does not
//! reach, s shrinks.
//!
//! With levers, every joint moves as it is asked to but one, which holds the height: [`level`].

use hydrocrane_num::Real;

/// What the tip shall do, m/s.
#[derive(Debug, Clone, Copy)]
pub struct Task {
    pub velocity: [f64; 2],
    pub correction: [f64; 2],
}

/// What the joints should rather do, and how far they can.
#[derive(Debug, Clone, Copy)]
pub struct Preference<const N: usize> {
    pub weights: [f64; N],
    pub rates: [f64; N],
    /// Lower and upper bound of each rate, zero between them.
    pub bounds: [[f64; 2]; N],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<const N: usize> {
    pub rates: [f64; N],
    /// s
    pub scale: f64,
}

/// Damping of the 2 x 2 system relative to its trace: finite rates where the chain is singular.
const DAMPING: f64 = 1e-9;

pub fn resolve<const N: usize>(jacobian: &[[f64; N]; 2], task: &Task, prefer: &Preference<N>) -> Motion<N> {
    let slower = || {
        // No room for the whole correction: motion and correction shrink together, which s = 0 always allows.
        let together = hydrocrane_num::array::from_fn(|r| task.velocity[r] + task.correction[r]);
        let task = Task { velocity: together, correction: [0.0; 2] };
        fastest(jacobian, &task, &Preference { rates: [0.0; N], ..*prefer })
    };
    fastest(jacobian, task, prefer).or_else(slower).unwrap_or(Motion { rates: [0.0; N], scale: 0.0 })
}

/// Rates of joints that move as `asked`, while joint `follower` takes back what the others change of the tip's height.
pub fn level<const N: usize>(jacobian: &[[f64; N]; 2], asked: &[f64; N], follower: usize) -> [f64; N] {
    let lift = jacobian[1];
    let others: f64 = (0..N).filter(|&i| i != follower).map(|i| lift[i] * asked[i]).sum();
    // Where the follower moves the tip on a level line, the smallest step of the others takes it out of its bounds.
    let taken_back = others / lift[follower].abs().max(LEAST_LIFT).copysign(lift[follower]);
    hydrocrane_num::array::from_fn(|i| asked[i] - if i == follower { taken_back } else { 0.0 })
}

/// As [`level`], with a `correction` of the height, m/s; all are slowed down together, so that the height holds.
pub fn level_within<const N: usize>(
    jacobian: &[[f64; N]; 2],
    asked: &[f64; N],
    follower: usize,
    correction: f64,
    bounds: &[[f64; 2]; N],
) -> Motion<N> {
    let gain = jacobian[1][follower];
    let [low, high] = bounds[follower];
    let corrected = (correction * gain / (gain * gain + LIFT_IN_FULL * LIFT_IN_FULL)).clamp(low, high);
    let base = hydrocrane_num::array::from_fn(|i| if i == follower { corrected } else { 0.0 });
    let line = Line { base, slope: level(jacobian, asked, follower) };
    line.fastest(bounds, &[None; N]).unwrap_or(Motion { rates: [0.0; N], scale: 0.0 })
}

/// The motion of largest s, if any keeps the bounds: free, or with joints held at a bound one after the other.
fn fastest<const N: usize>(jacobian: &[[f64; N]; 2], task: &Task, prefer: &Preference<N>) -> Option<Motion<N>> {
    let mut held = [None; N];
    let mut best = Line::new(jacobian, task, prefer, &held).fastest(&prefer.bounds, &held);
    for _ in 2..N {
        if best.is_some_and(|b| b.scale >= 1.0) {
            break;
        }
        let mut found: Option<(Motion<N>, usize, f64)> = None;
        for joint in (0..N).filter(|&i| held[i].is_none()) {
            for bound in prefer.bounds[joint] {
                let mut trial = held;
                trial[joint] = Some(bound);
                let motion = Line::new(jacobian, task, prefer, &trial).fastest(&prefer.bounds, &trial);
                let better = |m: &Motion<N>| found.is_none_or(|(f, ..)| prefer.prefers(m, &f));
                if let Some(motion) = motion.filter(better) {
                    found = Some((motion, joint, bound));
                }
            }
        }
        let Some((motion, joint, bound)) = found else { break };
        held[joint] = Some(bound);
        if best.is_none_or(|b| prefer.prefers(&motion, &b)) {
            best = Some(motion);
        }
    }
    best
}

impl<const N: usize> Preference<N> {
    /// Whether `a` is faster than `b`, or as fast with less effort.
    fn prefers(&self, a: &Motion<N>, b: &Motion<N>) -> bool {
        let effort =
            |m: &Motion<N>| (0..N).map(|i| self.weights[i] * (m.rates[i] - self.rates[i]).square()).sum::<f64>();
        a.scale > b.scale || a.scale == b.scale && effort(a) < effort(b)
    }
}

/// Rates as a function of s: `base + s slope`.
struct Line<const N: usize> {
    base: [f64; N],
    slope: [f64; N],
}

impl<const N: usize> Line<N> {
    fn new(j: &[[f64; N]; 2], task: &Task, prefer: &Preference<N>, held: &[Option<f64>; N]) -> Self {
        let start: [f64; N] = hydrocrane_num::array::from_fn(|i| held[i].unwrap_or(prefer.rates[i]));
        let rest: [f64; 2] =
            hydrocrane_num::array::from_fn(|r| task.correction[r] - (0..N).map(|i| j[r][i] * start[i]).sum::<f64>());
        let give: [f64; N] =
            hydrocrane_num::array::from_fn(|i| if held[i].is_some() { 0.0 } else { 1.0 / prefer.weights[i] });
        let normal = |r: usize, c: usize| (0..N).map(|i| j[r][i] * give[i] * j[c][i]).sum::<f64>();
        let (a, b, d) = (normal(0, 0), normal(0, 1), normal(1, 1));
        let damping = (DAMPING * (a + d)).max(f64::MIN_POSITIVE);
        let (a, d) = (a + damping, d + damping);
        let determinant = a * d - b * b;
        let pull = |v: [f64; 2]| {
            let y = [(d * v[0] - b * v[1]) / determinant, (a * v[1] - b * v[0]) / determinant];
            hydrocrane_num::array::from_fn(|i| give[i] * (j[0][i] * y[0] + j[1][i] * y[1]))
        };
        let correction: [f64; N] = pull(rest);
        Line { base: hydrocrane_num::array::from_fn(|i| start[i] + correction[i]), slope: pull(task.velocity) }
    }

    fn at(&self, scale: f64) -> [f64; N] {
        hydrocrane_num::array::from_fn(|i| self.base[i] + scale * self.slope[i])
    }

    /// At the largest s in 0 to 1 that keeps all bounds, if any.
    fn fastest(&self, bounds: &[[f64; 2]; N], held: &[Option<f64>; N]) -> Option<Motion<N>> {
        let (mut least, mut most) = (0.0f64, 1.0f64);
        for i in (0..N).filter(|&i| held[i].is_none()) {
            let ([low, high], base, slope) = (bounds[i], self.base[i], self.slope[i]);
            if slope.abs() < STILL {
                if base < low - STILL || base > high + STILL {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - base) / slope, (high - base) / slope);
            (least, most) = (least.max(a.min(b)), most.min(a.max(b)));
        }
        (least <= most).then(|| Motion { rates: self.at(most), scale: most })
    }
}

/// What a joint lifts the tip per its own motion (m/rad, m/m): guard at zero, and from where on it corrects in full.
const LEAST_LIFT: f64 = 1e-6;
const LIFT_IN_FULL: f64 = 0.05;
/// Rates that count as zero, rad/s or m/s.
const STILL: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    /// The laboratory crane at (100 deg, 100 deg, 0).
    const J: [[f64; 3]; 2] = [[0.929, 1.4097, 0.342], [2.8251, 0.5652, -0.9397]];
    const WIDE: [[f64; 2]; 3] = [[-1.0, 1.0]; 3];

    fn prefer(bounds: [[f64; 2]; 3]) -> Preference<3> {
        Preference { weights: [1.0, 2.0, 3.0], rates: [0.0; 3], bounds }
    }

    fn tip(rates: &[f64; 3]) -> [f64; 2] {
        hydrocrane_num::array::from_fn(|r| (0..3).map(|i| J[r][i] * rates[i]).sum())
    }

    #[test]
    fn gives_the_tip_its_velocity_with_the_least_weighted_effort() {
        let task = Task { velocity: [0.1, 0.05], correction: [0.01, -0.02] };
        let m = resolve(&J, &task, &prefer(WIDE));
        let v = tip(&m.rates);
        assert!(m.scale == 1.0 && (v[0] - 0.11).abs() < 1e-8 && (v[1] - 0.03).abs() < 1e-8);
        // Any step along the null space costs more.
        let null = [
            J[0][1] * J[1][2] - J[0][2] * J[1][1],
            J[0][2] * J[1][0] - J[0][0] * J[1][2],
            J[0][0] * J[1][1] - J[0][1] * J[1][0],
        ];
        let slope: f64 = (0..3).map(|i| [1.0, 2.0, 3.0][i] * m.rates[i] * null[i]).sum();
        assert!(slope.abs() < 1e-8);
    }

    #[test]
    fn keeps_the_direction_when_a_joint_cannot_follow() {
        let task = Task { velocity: [2.0, 1.0], correction: [0.0; 2] };
        let bounds = [[-0.1, 0.1], [-0.2, 0.3], [-0.05, 0.05]];
        let m = resolve(&J, &task, &prefer(bounds));
        let v = tip(&m.rates);
        assert!(m.scale > 0.0 && m.scale < 1.0);
        assert!((v[0] - 2.0 * m.scale).abs() < 1e-8 && (v[1] - m.scale).abs() < 1e-8);
        assert!((0..3).all(|i| m.rates[i] >= bounds[i][0] - 1e-12 && m.rates[i] <= bounds[i][1] + 1e-12));
    }

    #[test]
    fn other_joints_take_over_from_one_at_its_limit() {
        let task = Task { velocity: [0.3, 0.0], correction: [0.0; 2] };
        let free = resolve(&J, &task, &prefer(WIDE));
        let bounds = [[-1.0, 1.0], [-1.0, 0.5 * free.rates[1]], [-1.0, 1.0]];
        let m = resolve(&J, &task, &prefer(bounds));
        let v = tip(&m.rates);
        assert!(m.scale == 1.0 && (v[0] - 0.3).abs() < 1e-6 && v[1].abs() < 1e-6);
        assert!((m.rates[1] - bounds[1][1]).abs() < 1e-12);
    }

    #[test]
    fn the_follower_holds_the_height_and_slows_the_others_down_at_its_bound() {
        let asked = [0.1, -0.05, 0.0];
        let free = level_within(&J, &asked, 2, 0.0, &WIDE);
        assert!(free.scale == 1.0 && tip(&free.rates)[1].abs() < 1e-12);
        assert_eq!(free.rates[..2], asked[..2]);
        let bounds = [[-1.0, 1.0], [-1.0, 1.0], [-0.1, 0.1]];
        let slow = level_within(&J, &asked, 2, 0.0, &bounds);
        assert!((slow.rates[2].abs() - 0.1).abs() < 1e-12 && tip(&slow.rates)[1].abs() < 1e-12);
        assert!((slow.rates[0] / slow.rates[1] - asked[0] / asked[1]).abs() < 1e-9);
        // Its own lever changes the height; an error of the height is corrected even at rest.
        assert!((tip(&level_within(&J, &[0.0, 0.0, 0.1], 2, 0.0, &WIDE).rates)[1] + 0.09397).abs() < 1e-9);
        assert!(tip(&level_within(&J, &[0.0; 3], 2, 0.02, &WIDE).rates)[1] > 0.019);
    }

    #[test]
    fn a_follower_that_lifts_nothing_stops_the_others() {
        let flat = [J[0], [2.8, 0.5, 0.0]];
        let m = level_within(&flat, &[0.3, 0.1, 0.0], 2, 0.01, &WIDE);
        assert!(m.rates.iter().all(|r| r.is_finite()) && m.rates[0].abs() < 1e-6 && m.scale < 1e-5);
        assert_eq!(level_within(&[[0.6], [0.8]], &[0.3], 0, 0.0, &[[-1.0, 1.0]]).rates, [0.3]);
    }

    #[test]
    fn finite_where_the_chain_is_singular_or_has_one_joint() {
        let line = [[1.0, 2.0, 0.5], [0.0, 0.0, 0.0]];
        let up = Task { velocity: [0.0, 1.0], correction: [0.0; 2] };
        assert!(resolve(&line, &up, &prefer(WIDE)).rates.iter().all(|r| r.is_finite()));
        let one = Preference { weights: [1.0], rates: [0.0], bounds: [[-1.0, 1.0]] };
        let m = resolve(&[[0.6], [0.8]], &Task { velocity: [0.3, 0.4], correction: [0.0; 2] }, &one);
        assert!((m.rates[0] - 0.5).abs() < 1e-6);
    }
}
