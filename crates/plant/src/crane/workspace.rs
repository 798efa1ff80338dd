//! Boundary of the area that the tip can reach (thesis 3.1.3).

use crate::equations::plant::Plant;
use hydrocrane_machine::Machine;
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;

/// Points per edge of the joint rectangle.
const POINTS: usize = 120;

/// Whether a place (x, z), m, is in a region that the tip must keep out of, or in the ground.
pub fn forbidden(machine: &Machine, [x, z]: [f64; 2]) -> bool {
    let within = |corners: &[[f64; 2]]| {
        let before = corners.iter().cycle().skip(corners.len().saturating_sub(1));
        // Edges that a ray to the right crosses.
        let crossed = before
            .zip(corners)
            .filter(|(a, b)| (a[1] > z) != (b[1] > z) && x < a[0] + (z - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
        crossed.count() % 2 == 1
    };
    machine.keep_out.iter().any(|(_, corners)| within(corners)) || machine.ground.as_ref().is_some_and(|g| z < g.height)
}

/// Closed curves of the tip around the rectangle of the first two revolute joints, one for each combination of
/// end positions of the other joints, and the paths of the other joints that join their corners; where the chain
/// can stretch straight inside the limits, also the arc of full reach. A chain without two revolute joints gives
/// the tip's path along each of its joints. Where a crane slews, in the plane of its boom.
pub fn boundary<const N: usize>(plant: &Plant<f64, N>, limits: &[[f64; 2]; N]) -> Vec<Vec<[f64; 2]>> {
    let in_plane: Vec<usize> = (0..N).filter(|&i| plant.space().is_none_or(|s| !s.stances[i].leaves_plane)).collect();
    let revolute: Vec<usize> =
        in_plane.iter().copied().filter(|&i| plant.mechanics.joints[i].revolute).take(2).collect();
    let tip = |q: &[f64; N]| plant.tip_in_plane(q);
    let [first, second] = revolute[..] else { return paths(&in_plane, limits, tip) };
    let others: Vec<usize> = in_plane.into_iter().filter(|i| !revolute.contains(i)).collect();
    let mut curves = Vec::new();
    for combination in 0..1usize << others.len() {
        let mut q = [0.0; N];
        for (bit, &joint) in others.iter().enumerate() {
            q[joint] = limits[joint][combination >> bit & 1];
        }
        curves.push(around(&mut q, first, second, limits, tip));
        if let Some(straight) = stretched(plant, q, first, second, limits[second]) {
            q[second] = straight;
            curves.push(sweep(&mut q, first, limits[first], tip));
        }
    }
    for &joint in &others {
        for corner in 0..4 {
            let mut q: [f64; N] = hydrocrane_num::array::from_fn(|i| limits[i][0]);
            q[first] = limits[first][corner & 1];
            q[second] = limits[second][corner >> 1];
            curves.push(sweep(&mut q, joint, limits[joint], tip));
        }
    }
    curves
}

fn paths<const N: usize>(
    joints: &[usize],
    limits: &[[f64; 2]; N],
    tip: impl Fn(&[f64; N]) -> [f64; 2],
) -> Vec<Vec<[f64; 2]>> {
    let mut q: [f64; N] = hydrocrane_num::array::from_fn(|i| limits[i][0]);
    joints.iter().map(|&i| sweep(&mut q, i, limits[i], &tip)).collect()
}

fn sweep<const N: usize>(
    q: &mut [f64; N],
    joint: usize,
    [from, to]: [f64; 2],
    tip: impl Fn(&[f64; N]) -> [f64; 2],
) -> Vec<[f64; 2]> {
    (0..=POINTS)
        .map(|i| {
            q[joint] = from + (to - from) * i as f64 / POINTS as f64;
            tip(q)
        })
        .collect()
}

fn around<const N: usize>(
    q: &mut [f64; N],
    first: usize,
    second: usize,
    limits: &[[f64; 2]; N],
    tip: impl Fn(&[f64; N]) -> [f64; 2],
) -> Vec<[f64; 2]> {
    let ([a0, a1], [b0, b1]) = (limits[first], limits[second]);
    let mut curve = Vec::with_capacity(4 * POINTS + 4);
    q[second] = b0;
    curve.extend(sweep(q, first, [a0, a1], &tip));
    curve.extend(sweep(q, second, [b0, b1], &tip));
    curve.extend(sweep(q, first, [a1, a0], &tip));
    curve.extend(sweep(q, second, [b1, b0], &tip));
    curve
}

/// The second joint's coordinate where both rods are in line, if it lies inside its limits.
fn stretched<const N: usize>(
    plant: &Plant<f64, N>,
    mut q: [f64; N],
    first: usize,
    second: usize,
    [low, high]: [f64; 2],
) -> Option<f64> {
    let mut bend = |coordinate: f64| {
        q[second] = coordinate;
        let pose = plant.side_view(&q);
        let elbow = pose.links[second].origin;
        let (inner, outer) = (elbow - pose.links[first].origin, plant.mechanics.tip_position(&pose) - elbow);
        (inner.x * outer.z - inner.z * outer.x, inner.dot(outer))
    };
    let (mut a, mut b) = (low, high);
    let sign = bend(a).0;
    if sign * bend(b).0 > 0.0 {
        return None;
    }
    for _ in 0..80 {
        let middle = 0.5 * (a + b);
        if bend(middle).0 * sign > 0.0 {
            a = middle;
        } else {
            b = middle;
        }
    }
    (bend(a).1 > 0.0).then_some(a)
}
