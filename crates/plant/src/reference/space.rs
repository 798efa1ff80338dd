//! Joint forces of a chain in space, link by link: Newton's and Euler's laws at each centre of gravity, projected on the joints.

use hydrocrane_machine::model::*;

type V = [f64; 3];

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
fn scale(a: V, s: f64) -> V {
    a.map(|x| x * s)
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
/// A vector turned by an angle about a unit vector.
fn turned(v: V, about: V, angle: f64) -> V {
    let across = scale(cross(about, v), angle.sin());
    add(add(scale(v, angle.cos()), across), scale(about, dot(about, v) * (1.0 - angle.cos())))
}

/// A joint: what a unit rate gives to all it carries, and where.
struct Placed {
    spin: V,
    slide: V,
    origin: V,
}

/// A mass with its place, acceleration and rate of angular momentum, and the joint that carries it.
struct Part {
    joint: usize,
    mass: f64,
    at: V,
    acceleration: V,
    moment: V,
}

/// A joint at a coordinate, in the frame of its parent: where the child's origin lies, the angle by which it is turned about the axis,
/// and what a unit rate gives, as an angular rate and as a velocity.
struct Standing {
    at: V,
    axis: V,
    angle: f64,
    spin: V,
    slide: V,
}

fn standing(m: &Machine, i: usize, q: f64) -> Standing {
    let joint = &m.joints[i];
    let (at, axis, travel) = (joint.at_in_space(), joint.turning_axis(), joint.sense * (q - joint.zero));
    match joint.kind {
        JointKind::Revolute(convention) => {
            let mut angle = travel;
            if joint.axis.is_none() {
                let folded = if convention == AngleConvention::Included { std::f64::consts::PI } else { 0.0 };
                angle += m.links[i].axis - m.links[i + 1].axis - joint.sense * folded;
            }
            Standing { at, axis, angle, spin: scale(axis, joint.sense), slide: [0.0; 3] }
        }
        JointKind::Prismatic { direction } => {
            let along = [direction.cos(), 0.0, direction.sin()];
            let at = add(at, scale(along, travel));
            Standing { at, axis, angle: 0.0, spin: [0.0; 3], slide: scale(along, joint.sense) }
        }
    }
}

/// Distance of the pins of cylinder `c` less that at mid-stroke, m, and its derivative by the coordinate of its joint.
pub fn stroke(m: &Machine, c: &Cylinder, rod: &Point, q: f64) -> (f64, f64) {
    let (on_parent, on_child) = if rod.link == c.joint { (rod, &c.barrel_pin) } else { (&c.barrel_pin, rod) };
    let Standing { at, axis, angle, spin, slide } = standing(m, c.joint, q);
    let arm = turned(on_child.in_space(), axis, angle);
    let rate = add(slide, cross(spin, arm));
    let between = add(add(at, arm), scale(on_parent.in_space(), -1.0));
    let length = dot(between, between).sqrt();
    (length - c.mid_length, dot(between, rate) / length)
}

/// Forces along the joints that the accelerations `qdd` need at the rates `qd`; `up` is the acceleration against gravity, m/s^2.
pub fn joint_forces(m: &Machine, q: &[f64], qd: &[f64], qdd: &[f64], up: V, payload: f64) -> Vec<f64> {
    let vector = |axes: &[V; 3], local: V| {
        add(add(scale(axes[0], local[0]), scale(axes[1], local[1])), scale(axes[2], local[2]))
    };
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (mut origin, mut rate, mut spin_up, mut a) = ([0.0; 3], [0.0; 3], [0.0; 3], up);
    let (mut links, mut parts): (Vec<Placed>, Vec<Part>) = (Vec::new(), Vec::new());
    for i in 0..m.joints.len() {
        let Standing { at, axis, angle, spin, slide } = standing(m, i, q[i]);
        let [spin, slide, about] = [spin, slide, axis].map(|local| vector(&axes, local));
        let r = vector(&axes, at);
        origin = add(origin, r);
        let inwards = cross(rate, cross(rate, r));
        a = add(a, add(cross(spin_up, r), inwards));
        a = add(a, add(scale(slide, qdd[i]), scale(cross(rate, slide), 2.0 * qd[i])));
        spin_up = add(spin_up, add(scale(spin, qdd[i]), scale(cross(rate, spin), qd[i])));
        rate = add(rate, scale(spin, qd[i]));
        axes = axes.map(|axis| turned(axis, about, angle));
        links.push(Placed { spin, slide, origin });

        let link = &m.links[i + 1];
        let solid = link.solid.unwrap_or(Solid { y: 0.0, xx: 0.0, zz: 0.0, xy: 0.0, xz: 0.0, yz: 0.0 });
        let [x, z] = link.centre_of_gravity;
        let yy = match link.inertia_about {
            InertiaAbout::Frame => link.inertia - link.mass * (x * x + z * z),
            InertiaAbout::CentreOfGravity => link.inertia,
        };
        let tensor = [[solid.xx, solid.xy, solid.xz], [solid.xy, yy, solid.yz], [solid.xz, solid.yz, solid.zz]];
        let times = |v: V| {
            let local = axes.map(|axis| dot(axis, v));
            vector(&axes, tensor.map(|row| dot(row, local)))
        };
        let mut carry = |mass: f64, local: V, moment: V| {
            let arm = vector(&axes, local);
            let acceleration = add(a, add(cross(spin_up, arm), cross(rate, cross(rate, arm))));
            parts.push(Part { joint: i, mass, at: add(origin, arm), acceleration, moment });
        };
        carry(link.mass, [x, solid.y, z], add(times(spin_up), cross(rate, times(rate))));
        if i == m.joints.len() - 1 {
            carry(payload, m.tip.in_space(), [0.0; 3]);
        }
    }
    let joint_force = |(j, link): (usize, &Placed)| -> f64 {
        let outboard = parts.iter().filter(|part| part.joint >= j);
        outboard
            .map(|part| {
                let velocity = add(link.slide, cross(link.spin, add(part.at, scale(link.origin, -1.0))));
                dot(link.spin, part.moment) + part.mass * dot(part.acceleration, velocity)
            })
            .sum()
    };
    links.iter().enumerate().map(joint_force).collect()
}
