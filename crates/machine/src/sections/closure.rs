//! Checks that a cylinder can be mounted: pins on the right links, and a linkage that can close.

use crate::errors::ErrorKind;
use crate::model::{Cylinder, FourBar, Joint, JointKind, Link, Point, RodPin};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::link::point_path;
use crate::sections::Result;

pub fn check<T: Number>(table: &Reader, cylinder: &Cylinder<T>, joint: &Joint<T>, links: &[Link<T>]) -> Result<()> {
    let pins = Pins { table, parent: cylinder.joint, links, joint };
    match &cylinder.rod_pin {
        RodPin::Point(rod) => {
            pins.on_joint("barrel", &cylinder.barrel_pin)?;
            pins.on_joint("rod", rod)?;
            if rod.link == cylinder.barrel_pin.link {
                return Err(pins.misplaced("rod", rod, "the rod's pin sits on the barrel's link"));
            }
            pins.length_reachable(cylinder, rod)
        }
        RodPin::FourBar(linkage) => {
            pins.on_link("barrel", &cylinder.barrel_pin, pins.parent)?;
            pins.on_link("linkage.rocker-pivot", &linkage.rocker_pivot, pins.parent)?;
            pins.on_link("linkage.coupler-pivot", &linkage.coupler_pivot, pins.parent + 1)?;
            pins.linkage_closes(linkage)
        }
        RodPin::Rack(_) => Ok(()),
    }
}

struct Pins<'a, T> {
    table: &'a Reader<'a>,
    /// Index of the joint's parent link; the child is the next one.
    parent: usize,
    links: &'a [Link<T>],
    joint: &'a Joint<T>,
}

impl<T: Number> Pins<'_, T> {
    fn misplaced(&self, key: &str, point: &Point<T>, message: &str) -> crate::errors::MachineError {
        let [parent, child] = [self.parent, self.parent + 1].map(|link| self.links[link].name.as_str());
        let help = format!("joint `{}` connects `{parent}` and `{child}`", self.joint.name);
        let message = format!("`{}`: {message}", point_path(&self.links[point.link], point));
        let place_key = key.split('.').next().unwrap_or(key);
        self.table.error(ErrorKind::MisplacedPin, place_key, message).help(help)
    }

    fn on_joint(&self, key: &str, point: &Point<T>) -> Result<()> {
        if point.link == self.parent || point.link == self.parent + 1 {
            return Ok(());
        }
        Err(self.misplaced(key, point, "the pin is on neither link of the cylinder's joint"))
    }

    fn on_link(&self, key: &str, point: &Point<T>, link: usize) -> Result<()> {
        if point.link == link {
            return Ok(());
        }
        let message = format!("the {} belongs on link `{}`", key.trim_start_matches("linkage."), self.links[link].name);
        Err(self.misplaced(key, point, &message))
    }

    /// The cylinder's range of lengths must meet the distances its pins can have.
    fn length_reachable(&self, cylinder: &Cylinder<T>, rod: &Point<T>) -> Result<()> {
        let lengths = [-0.5, 0.5].map(|end| cylinder.mid_length.plain() + end * cylinder.stroke.plain());
        let distances = self.distances(&cylinder.barrel_pin, rod);
        if lengths[0] <= distances[1] && lengths[1] >= distances[0] {
            return Ok(());
        }
        let message = format!(
            "the cylinder measures {:.4} to {:.4} m between its pins, which are {:.4} to {:.4} m apart",
            lengths[0], lengths[1], distances[0], distances[1]
        );
        Err(self
            .table
            .place
            .error(ErrorKind::CannotClose, &self.table.path, message)
            .help("check the pins, the lengths of the cylinder and their units"))
    }

    /// The triangle of rocker, coupler and the distance of their pivots must close in some position of the joint.
    fn linkage_closes(&self, linkage: &FourBar<T>) -> Result<()> {
        let [rocker, coupler] = [linkage.rocker_length, linkage.coupler_length].map(T::plain);
        let [least, most] = [(rocker - coupler).abs(), rocker + coupler];
        let distances = self.distances(&linkage.rocker_pivot, &linkage.coupler_pivot);
        if least <= distances[1] && most >= distances[0] {
            return Ok(());
        }
        let message = format!(
            "the pivots are {:.4} to {:.4} m apart, rocker and coupler span {least:.4} to {most:.4} m",
            distances[0], distances[1]
        );
        Err(self
            .table
            .error(ErrorKind::CannotClose, "linkage", message)
            .help("check the pivots, the lengths of rocker and coupler and their units"))
    }

    /// Least and largest distance of two points, one on each link of the joint, over all positions of the joint, m.
    fn distances(&self, a: &Point<T>, b: &Point<T>) -> [f64; 2] {
        let (on_parent, on_child) = if a.link == self.parent { (a, b) } else { (b, a) };
        let (arm, child) = (from_joint(self.joint, on_parent, true), from_joint(self.joint, on_child, false));
        match self.joint.kind {
            JointKind::Revolute(_) => {
                let axis = self.joint.turning_axis();
                let [(r1, along1), (r2, along2)] = [arm, child].map(|pin| split(pin, axis));
                [r1 - r2, r1 + r2].map(|in_plane| libm::hypot(in_plane, along1 - along2))
            }
            JointKind::Prismatic { direction } => {
                let (sin, cos) = libm::sincos(direction.plain());
                let offset = [child[0] - arm[0], child[1] - arm[1], child[2] - arm[2]];
                [split(offset, [cos, 0.0, sin]).0, f64::INFINITY]
            }
        }
    }
}

/// A pin as (x, y, z) from the joint, in the frame of its link, m.
pub fn from_joint<T: Number>(joint: &Joint<T>, pin: &Point<T>, on_parent: bool) -> [f64; 3] {
    let place = pin.in_space().map(T::plain);
    if !on_parent {
        return place;
    }
    let at = joint.at_in_space().map(T::plain);
    [place[0] - at[0], place[1] - at[1], place[2] - at[2]]
}

/// How far a vector leads away from an axis, and along it.
pub fn split(v: [f64; 3], axis: [f64; 3]) -> (f64, f64) {
    let along: f64 = v.iter().zip(axis).map(|(v, axis)| v * axis).sum();
    let away = [v[0] - along * axis[0], v[1] - along * axis[1], v[2] - along * axis[2]];
    (libm::sqrt(away.iter().map(|x| x * x).sum()), along)
}
