//! The machine as lines, for charts and animations.

use crate::equations::plant::Plant;
use hydrocrane_machine::model::{Machine, Point, RodPin};
use hydrocrane_num::{portable, Vec2};
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;
use hydrocrane_physics::geometry::chain::ChainPose;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShapeKind {
    Link,
    CylinderBarrel,
    CylinderRod,
    TorqueLink,
    Joint,
    Tip,
}

impl ShapeKind {
    pub fn name(self) -> &'static str {
        match self {
            ShapeKind::Link => "link",
            ShapeKind::CylinderBarrel => "cylinder-barrel",
            ShapeKind::CylinderRod => "cylinder-rod",
            ShapeKind::TorqueLink => "torque-link",
            ShapeKind::Joint => "joint",
            ShapeKind::Tip => "tip",
        }
    }
}

/// A polyline in the inertial frame, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    pub kind: ShapeKind,
    pub name: String,
    pub line: Vec<[f64; 2]>,
}

pub fn draw<const N: usize>(machine: &Machine, plant: &Plant<f64, N>, q: &[f64; N]) -> Vec<Shape> {
    let pose = plant.side_view(q);
    let mut shapes = Vec::new();
    for link in 0..=N {
        shapes.push(Shape {
            kind: ShapeKind::Link,
            name: machine.links[link].name.clone(),
            line: outline(machine, link).into_iter().map(|p| world(&pose, link, p)).collect(),
        });
    }
    for c in 0..N {
        cylinder(machine, plant, &pose, c, &mut shapes);
    }
    for j in 0..N {
        let at = pose.links[j].origin;
        shapes.push(Shape { kind: ShapeKind::Joint, name: machine.joints[j].name.clone(), line: vec![[at.x, at.z]] });
    }
    let tip = plant.mechanics.tip_position(&pose);
    shapes.push(Shape { kind: ShapeKind::Tip, name: machine.tip.name.clone(), line: vec![[tip.x, tip.z]] });
    shapes
}

/// The outline given in the file, else the closed convex line around the link's joint, its points and the next joint or
/// the tip; a plain line where these lie on one.
fn outline(machine: &Machine, link: usize) -> Vec<[f64; 2]> {
    let l = &machine.links[link];
    if !l.outline.is_empty() {
        return l.outline.clone();
    }
    let end = machine.joints.get(link).map_or(machine.tip.position, |next| next.at);
    let points = l.points.iter().map(|point| point.position);
    around([[0.0, 0.0], end].into_iter().chain(points).collect())
}

/// The convex hull of points (Andrew's monotone chain), closed, or a line where it has no area.
fn around(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..] {
                if turn(a, b, point) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain
    };
    let lower = half(&mut points.iter().copied());
    let upper = half(&mut points.iter().rev().copied());
    if lower.len() == 2 && upper.len() == 2 {
        return lower;
    }
    lower.into_iter().chain(upper.into_iter().skip(1)).collect()
}

fn world<const N: usize>(pose: &ChainPose<f64, N>, link: usize, p: [f64; 2]) -> [f64; 2] {
    let r = pose.link(link).point(Vec2::c(p));
    [r.x, r.z]
}

fn cylinder<const N: usize>(
    machine: &Machine,
    plant: &Plant<f64, N>,
    pose: &ChainPose<f64, N>,
    c: usize,
    shapes: &mut Vec<Shape>,
) {
    let description = &machine.cylinders[c];
    let at = |p: &Point| world(pose, p.link, p.position);
    let barrel = at(&description.barrel_pin);
    let rod = match &description.rod_pin {
        RodPin::Point(p) => at(p),
        RodPin::FourBar(linkage) => {
            let pin = plant.actuations[c].moving_pin(&pose.joints[c]);
            let pin = world(pose, description.joint, [pin.x, pin.z]);
            shapes.push(Shape {
                kind: ShapeKind::TorqueLink,
                name: description.name.clone(),
                line: vec![at(&linkage.rocker_pivot), pin, at(&linkage.coupler_pivot)],
            });
            pin
        }
        RodPin::Rack(_) => return,
    };
    // The barrel is drawn as long as the stroke, from its pin towards the rod pin.
    let (dx, dz) = (rod[0] - barrel[0], rod[1] - barrel[1]);
    let length = portable::hypot(dx, dz);
    let closed = description.mid_length - description.stroke / 2.0;
    let share = (closed.min(length) / length).min(1.0);
    let mouth = [barrel[0] + share * dx, barrel[1] + share * dz];
    shapes.push(Shape { kind: ShapeKind::CylinderBarrel, name: description.name.clone(), line: vec![barrel, mouth] });
    shapes.push(Shape { kind: ShapeKind::CylinderRod, name: description.name.clone(), line: vec![mouth, rod] });
}

#[cfg(test)]
mod tests {
    use super::around;

    #[test]
    fn a_link_is_drawn_around_all_its_pins() {
        let square = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.25], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        assert_eq!(around(square.to_vec()), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]);
        assert_eq!(around(vec![[2.0, 2.0], [0.0, 0.0], [1.0, 1.0]]), [[0.0, 0.0], [2.0, 2.0]]);
        assert_eq!(around(vec![[3.0, 4.0], [3.0, 4.0]]), [[3.0, 4.0]]);
    }
}
