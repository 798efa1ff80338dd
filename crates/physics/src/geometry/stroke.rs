//! Piston position from the joint coordinate.                       theory: docs/theory/geometry/stroke.md
//!
//! x = pin-to-pin length - length at mid-stroke                              thesis (2), (40), (42)
//! g = dx/dq: piston velocity v = g q', generalized force Q = g f            thesis (53), (54)

use super::cylinder_triangle::{pin_distance, slope_angle};
use super::four_bar::FourBar;
use super::frames::JointPose;
use super::MovingPoint;
use hydrocrane_num::{Real, Vec2};

/// What the rod is pinned to.
#[derive(Debug, Clone, Copy)]
pub enum Mounting<T> {
    /// Pins on the parent and on the child link; the barrel hangs on one of them. They may lie `aside` of each other, m, along the axis
    /// of the joint.
    Pins { on_parent: Vec2<T>, on_child: Vec2<T>, barrel_on_child: bool, aside: T },
    /// Barrel on the parent link, rod on the common pin of a torque linkage.
    FourBar { barrel: Vec2<T>, linkage: FourBar<T> },
    /// The rod is a rack that turns a pinion of this pitch radius (m) on the joint: x = radius (q - zero).
    Rack { radius: T },
}

/// A cylinder as a function of the coordinate of the joint it moves.
#[derive(Debug, Clone, Copy)]
pub struct Actuation<T> {
    pub mounting: Mounting<T>,
    /// Pin-to-pin length with the piston at mid-stroke, m.
    pub mid_length: T,
}

hydrocrane_num::stored!([] enum Mounting<f64> {
    0: Pins { on_parent: Vec2<f64>, on_child: Vec2<f64>, barrel_on_child: bool, aside: f64 },
    1: FourBar { barrel: Vec2<f64>, linkage: FourBar<f64> },
    2: Rack { radius: f64 },
});
hydrocrane_num::stored!([] Actuation<f64> { mounting: Mounting<f64>, mid_length: f64 });

impl Actuation<f64> {
    /// Direction of the cylinder from its barrel pin to its rod pin, rad from x towards z in the parent frame.
    pub fn slope(&self, pose: &JointPose<f64>) -> f64 {
        let (fixed, moving) = self.pins(pose);
        match self.mounting {
            Mounting::Pins { barrel_on_child: true, .. } => slope_angle(moving.position, fixed),
            _ => slope_angle(fixed, moving.position),
        }
    }

    /// The same cylinder in constants of another number type.
    pub fn lift<U: Real>(&self) -> Actuation<U> {
        self.map(&mut |number| U::c(*number))
    }
}

impl<T: Copy> Actuation<T> {
    /// The same cylinder with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Actuation<U> {
        let mounting = match &self.mounting {
            Mounting::Pins { on_parent, on_child, barrel_on_child, aside } => Mounting::Pins {
                on_parent: on_parent.map(f),
                on_child: on_child.map(f),
                barrel_on_child: *barrel_on_child,
                aside: f(aside),
            },
            Mounting::FourBar { barrel, linkage } => {
                Mounting::FourBar { barrel: barrel.map(f), linkage: linkage.map(f) }
            }
            Mounting::Rack { radius } => Mounting::Rack { radius: f(radius) },
        };
        Actuation { mounting, mid_length: f(&self.mid_length) }
    }
}

impl<T: Real> Actuation<T> {
    /// Piston position from mid-stroke (m) and its derivative with respect to the joint coordinate.
    #[inline(always)]
    pub fn stroke(&self, pose: &JointPose<T>) -> (T, T) {
        if let Mounting::Rack { radius } = &self.mounting {
            return (*radius * pose.travel - self.mid_length, *radius);
        }
        let (fixed, moving) = self.pins(pose);
        let aside = if let Mounting::Pins { aside, .. } = &self.mounting { *aside } else { T::c(0.0) };
        let (length, slope) = pin_distance(fixed, moving, aside);
        (length - self.mid_length, slope)
    }

    /// The pin that moves with the joint, in the parent frame, m.
    pub fn moving_pin(&self, pose: &JointPose<T>) -> Vec2<T> {
        self.pins(pose).1.position
    }

    #[inline(always)]
    fn pins(&self, pose: &JointPose<T>) -> (Vec2<T>, MovingPoint<T>) {
        match &self.mounting {
            Mounting::Pins { on_parent, on_child, .. } => (*on_parent, pose.carry(*on_child)),
            Mounting::FourBar { barrel, linkage } => (*barrel, linkage.common_pin(pose.carry(linkage.coupler_pivot))),
            Mounting::Rack { .. } => (pose.origin, MovingPoint { position: pose.origin, rate: pose.slide }),
        }
    }

    /// Positive where the cylinder's linkage closes; always so without a four-bar.
    #[inline(always)]
    pub fn closure(&self, pose: &JointPose<T>) -> T {
        match &self.mounting {
            Mounting::Pins { .. } | Mounting::Rack { .. } => T::c(1.0),
            Mounting::FourBar { linkage, .. } => linkage.closure(pose.carry(linkage.coupler_pivot).position),
        }
    }
}
