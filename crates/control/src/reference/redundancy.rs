//! Joint rates for a velocity of the tip.                      theory: docs/theory/control/reference.md
//!
//! least sum_i w_i (q'_i - q'_pref,i)^2   with   J q' = s v + r c   and   lower_i <= q'_i <= upper_i
//!
//! v is what the stick asks for and may be slowed down, but not turned; c corrects the path. First the largest r in 0 to 1 that a part
//! of the bounds allows, then the largest s in 0 to 1. What the tip can do, {J q'}, is a polygon whose edges are as the columns of J:
//!
//! s = min over n with n v > 0 of (h(n) - n r c)/(n v),   h(n) = sum_i max(n J_i lower_i, n J_i upper_i),   n normal to a column
//!
//! The least effort is found by its multipliers y: q'_i = clamp(q'_pref,i + J_i y/w_i).
//!
//! With levers, every joint moves as it is asked to but one, which holds the height: [`level`].

use hydrocrane_num::{portable, Real};

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

/// Share of what joints could give the tip if all moved it alike, below which they hardly move it and are slowed down: at full speed they would
/// go back and forth about a singular pose.
const BARRED: f64 = 0.1;
/// Share of the bounds that the correction may take: the motion keeps the rest, and a correction that a pose hardly allows is made slowly.
const CORRECTING: f64 = 0.25;

/// At the largest s.
pub fn resolve<const N: usize>(jacobian: &[[f64; N]; 2], task: &Task, prefer: &Preference<N>) -> Motion<N> {
    resolved(jacobian, task, prefer, false)
}

/// With less of it where joints hardly move the tip.
pub fn resolve_steadily<const N: usize>(jacobian: &[[f64; N]; 2], task: &Task, prefer: &Preference<N>) -> Motion<N> {
    resolved(jacobian, task, prefer, true)
}

fn resolved<const N: usize>(
    jacobian: &[[f64; N]; 2],
    task: &Task,
    prefer: &Preference<N>,
    steadily: bool,
) -> Motion<N> {
    let task = &task.possible(jacobian);
    let (correction, room) = rooms(jacobian, task, &prefer.bounds);
    let scale = if steadily { room.faded(jacobian, &prefer.bounds, task.velocity) } else { room.share.min(1.0) };
    let target = hydrocrane_num::array::from_fn(|r| correction[r] + scale * task.velocity[r]);
    let edge = room.edge.filter(|_| scale == room.share).unwrap_or_default();
    let bounds = hydrocrane_num::array::from_fn(|i| at_edge(prefer.bounds[i], edge, [jacobian[0][i], jacobian[1][i]]));
    Motion { rates: least_effort(jacobian, target, &Preference { bounds, ..*prefer }), scale }
}

/// r c, and how much room that leaves for v.
fn rooms<const N: usize>(jacobian: &[[f64; N]; 2], task: &Task, bounds: &[[f64; 2]; N]) -> ([f64; 2], Room) {
    let rows = [&jacobian[0][..], &jacobian[1][..]];
    let few = bounds.map(|bounds| bounds.map(|bound| CORRECTING * bound));
    let corrected = room(rows, &few, [0.0; 2], task.correction).faded(jacobian, &few, task.correction);
    let correction = task.correction.map(|c| corrected * c);
    (correction, room(rows, bounds, correction, task.velocity))
}

/// How much of a way joints can do, more than all of it included, and the normal of the edge of what they can do at all that bounds it.
struct Room {
    share: f64,
    edge: Option<[f64; 2]>,
}

impl Room {
    /// What joints take of this `way`: by its length and the speeds that each joint alone would give the tip there.
    fn faded<const N: usize>(&self, jacobian: &[[f64; N]; 2], bounds: &[[f64; 2]; N], direction: [f64; 2]) -> f64 {
        let Some(edge) = self.edge else { return 1.0 };
        let mut all = 0.0;
        for (i, bounds) in bounds.iter().enumerate() {
            let column = [jacobian[0][i], jacobian[1][i]];
            let [low, high] = at_edge(*bounds, edge, column);
            all += low.abs().max(high.abs()) * portable::sqrt(dot(column, column));
        }
        // Where nothing moves the tip there is no share either.
        let used = self.share * portable::sqrt(dot(direction, direction)) / (BARRED * all).max(f64::MIN_POSITIVE);
        (self.share * used.min(1.0)).min(1.0)
    }
}

impl Task {
    /// What one joint can do of it where the tip has no more in its plane.
    fn possible<const N: usize>(&self, jacobian: &[[f64; N]; 2]) -> Task {
        let mut moving = (0..N).filter(|&i| [jacobian[0][i], jacobian[1][i]] != [0.0; 2]);
        let (Some(joint), None) = (moving.next(), moving.next()) else { return *self };
        let along = [jacobian[0][joint], jacobian[1][joint]];
        let square = dot(along, along).max(f64::MIN_POSITIVE);
        let part = |v: [f64; 2]| along.map(|a| a * (dot(along, v) / square));
        Task { velocity: part(self.velocity), correction: part(self.correction) }
    }
}

/// Bounds of a joint with this column of the Jacobian on the edge that has the normal `n`: but for those along it every joint is at a bound.
fn at_edge([low, high]: [f64; 2], n: [f64; 2], column: [f64; 2]) -> [f64; 2] {
    let gain = dot(n, column);
    if gain.abs() <= ALONG * portable::sqrt(dot(n, n) * dot(column, column)) {
        [low, high]
    } else if gain > 0.0 {
        [high; 2]
    } else {
        [low; 2]
    }
}

/// Largest share of `way` that joints within `bounds` can add to `from`, which they can do.
fn room(jacobian: [&[f64]; 2], bounds: &[[f64; 2]], from: [f64; 2], direction: [f64; 2]) -> Room {
    let column = |i: usize| [jacobian[0][i], jacobian[1][i]];
    let mut room = Room { share: f64::INFINITY, edge: None };
    for i in 0..bounds.len() {
        let [x, z] = column(i);
        // The edges beside the column, and where all are parallel the ends of it.
        for n in [[-z, x], [z, -x], [x, z], [-x, -z]] {
            let towards = dot(n, direction);
            // A column along the way bounds nothing.
            if towards <= ALONG * portable::sqrt(dot(n, n) * dot(direction, direction)) {
                continue;
            }
            let mut farthest = 0.0;
            for (j, bounds) in bounds.iter().enumerate() {
                let gain = dot(n, column(j));
                farthest += (gain * bounds[0]).max(gain * bounds[1]);
            }
            let share = ((farthest - dot(n, from)) / towards).max(0.0);
            if share < room.share {
                room = Room { share, edge: Some(n) };
            }
        }
    }
    room
}

/// Rates of least effort that give the tip the velocity `target`, which it can have.
fn least_effort<const N: usize>(jacobian: &[[f64; N]; 2], target: [f64; 2], prefer: &Preference<N>) -> [f64; N] {
    let give: [f64; N] = prefer.weights.map(|weight| 1.0 / weight);
    let pulled = |y: [f64; 2], i: usize| prefer.rates[i] + give[i] * (jacobian[0][i] * y[0] + jacobian[1][i] * y[1]);
    let rates = |y: [f64; 2]| -> [f64; N] {
        hydrocrane_num::array::from_fn(|i| pulled(y, i).max(prefer.bounds[i][0]).min(prefer.bounds[i][1]))
    };
    let missing = |q: &[f64; N]| -> [f64; 2] {
        hydrocrane_num::array::from_fn(|r| target[r] - (0..N).map(|i| jacobian[r][i] * q[i]).sum::<f64>())
    };
    let mut y = [0.0; 2];
    let mut now = rates(y);
    let mut off = missing(&now);
    let all = (0..N).map(|i| give[i] * (jacobian[0][i].square() + jacobian[1][i].square())).sum::<f64>();
    let damping = (DAMPING * all).max(f64::MIN_POSITIVE);
    for _ in 0..STEPS {
        let size = dot(off, off);
        if size <= STILL.square() {
            break;
        }
        // Joints beyond a bound give nothing, nor do those at one that are led on.
        let free = |i: usize| {
            let ([low, high], at) = (prefer.bounds[i], pulled(y, i));
            let led = jacobian[0][i] * off[0] + jacobian[1][i] * off[1];
            low < high && (at > low && at < high || at == low && led > 0.0 || at == high && led < 0.0)
        };
        let normal = |r: usize, c: usize| {
            (0..N).filter(|&i| free(i)).map(|i| jacobian[r][i] * give[i] * jacobian[c][i]).sum::<f64>()
        };
        let (a, b, d) = (normal(0, 0) + damping, normal(0, 1), normal(1, 1) + damping);
        let determinant = a * d - b * b;
        let step = [(d * off[0] - b * off[1]) / determinant, (a * off[1] - b * off[0]) / determinant];
        // The residual is the slope of a concave function, piecewise linear along the step: to its highest point, between the two bends
        // that a joint at a bound makes there.
        let slope = |length: f64| dot(missing(&rates([y[0] + length * step[0], y[1] + length * step[1]])), step);
        let mut ends = [(0.0, dot(off, step)), (f64::INFINITY, 0.0)];
        for i in 0..N {
            let speed = give[i] * (jacobian[0][i] * step[0] + jacobian[1][i] * step[1]);
            for bound in prefer.bounds[i] {
                let length = (bound - pulled(y, i)) / speed;
                if length.is_finite() && length > ends[0].0 && length < ends[1].0 {
                    let there = slope(length);
                    ends[usize::from(there <= 0.0)] = (length, there);
                }
            }
        }
        let [(from, up), (to, down)] = ends;
        let length = if to.is_finite() { from + (to - from) * up / (up - down) } else { from.max(1.0) };
        y = [y[0] + length * step[0], y[1] + length * step[1]];
        now = rates(y);
        off = missing(&now);
    }
    now
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
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
    line.fastest(bounds).unwrap_or(Motion { rates: [0.0; N], scale: 0.0 })
}

/// Rates as a function of s: `base + s slope`.
struct Line<const N: usize> {
    base: [f64; N],
    slope: [f64; N],
}

impl<const N: usize> Line<N> {
    fn at(&self, scale: f64) -> [f64; N] {
        hydrocrane_num::array::from_fn(|i| self.base[i] + scale * self.slope[i])
    }

    /// At the largest s in 0 to 1 that keeps all bounds, if any.
    fn fastest(&self, bounds: &[[f64; 2]; N]) -> Option<Motion<N>> {
        let (mut least, mut most) = (0.0f64, 1.0f64);
        for i in 0..N {
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
/// Cosine of an angle that counts as none.
const ALONG: f64 = 1e-12;
/// Steps that find the multipliers at most.
const STEPS: usize = 24;
/// Damping of the 2 x 2 system relative to its trace: steps that are finite where joints at bounds leave one direction.
const DAMPING: f64 = 1e-9;
/// Rates that count as zero, rad/s or m/s, and velocities, m/s.
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
    fn about_a_singular_pose_rates_are_as_large_as_it_is_far() {
        // Two joints of which one turns the tip by an angle off what the other does.
        let wide = [[-1.0, 1.0]; 2];
        let rate = |angle: f64| {
            let jacobian = [[1.0, f64::cos(angle)], [0.0, f64::sin(angle)]];
            let up = Task { velocity: [0.0, 3.0], correction: [0.0; 2] };
            resolve_steadily(&jacobian, &up, &Preference { weights: [1.0; 2], rates: [0.0; 2], bounds: wide }).rates[1]
        };
        for angle in [1e-6, 1e-3, 0.1] {
            assert!((rate(angle) / angle - 1.0 / (2.0 * BARRED)).abs() < 0.1, "{} at {angle}", rate(angle) / angle);
            assert!((rate(-angle) + rate(angle)).abs() < 1e-9);
        }
        assert!((rate(1.0) - 1.0).abs() < 1e-9);
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
