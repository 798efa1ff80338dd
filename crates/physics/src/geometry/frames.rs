//! Frames of the links and the joints between them.             theory: docs/theory/geometry/frames.md
//!
//! Revolute:   child frame angle = parent frame angle + offset + sense (q - zero)     thesis (4), (5)
//! Prismatic:  child origin = at + direction (q - zero), orientation kept             thesis (6)
//!
//! Angles count from x towards z. The thesis turns about y by `pi/2 - alpha` and `pi - beta`, which is the
//! opposite sense: its boom frame stands at the angle `alpha - pi/2`, its jib frame at `beta - pi` from that.

use super::MovingPoint;
use hydrocrane_num::{Dual, Real, Vec2};

/// A joint of the chain.
#[derive(Debug, Clone, Copy)]
pub struct Joint<T> {
    /// Place of the child's origin on the parent at `q = zero`, m.
    pub at: Vec2<T>,
    /// Prismatic: unit vector of growing `q` in the parent frame; zero for a revolute joint.
    pub direction: Vec2<T>,
    /// Frame angle of the child in the parent at `q = zero`, rad; 0 for a prismatic joint.
    pub offset: T,
    /// Coordinate of the neutral position, rad or m.
    pub zero: T,
    /// Revolute: +1 or -1, the derivative of the frame angle with respect to `q`; 0 for a prismatic joint.
    pub sense: T,
    pub revolute: bool,
}

/// A joint at a given coordinate: the child frame in the parent frame, and how it moves with the coordinate.
#[derive(Debug, Clone, Copy, Default)]
pub struct JointPose<T> {
    pub cos: T,
    pub sin: T,
    pub origin: Vec2<T>,
    /// Derivative of the frame angle with respect to `q`.
    pub turn: T,
    /// Derivative of `origin` with respect to `q`.
    pub slide: Vec2<T>,
    /// Coordinate from the neutral position, rad or m.
    pub travel: T,
}

hydrocrane_num::stored!([] Joint<f64> {
    at: Vec2<f64>,
    direction: Vec2<f64>,
    offset: f64,
    zero: f64,
    sense: f64,
    revolute: bool,
});

impl<T: Copy> Joint<T> {
    /// The same joint with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Joint<U> {
        Joint {
            at: self.at.map(f),
            direction: self.direction.map(f),
            offset: f(&self.offset),
            zero: f(&self.zero),
            sense: f(&self.sense),
            revolute: self.revolute,
        }
    }
}

impl Joint<f64> {
    /// The same joint in constants of another number type.
    pub fn lift<U: Real>(&self) -> Joint<U> {
        self.map(&mut |number| U::c(*number))
    }
}

impl<T: Real> Joint<T> {
    #[inline(always)]
    pub fn pose(&self, q: T) -> JointPose<T> {
        self.posed(q, self.angle(q).sin_cos())
    }

    /// Angle of the child's frame in the parent's, rad.
    #[inline(always)]
    pub fn angle(&self, q: T) -> T {
        self.offset + self.sense * (q - self.zero)
    }

    /// [`Self::pose`] where sine and cosine of the angle are known.
    #[inline(always)]
    pub fn posed(&self, q: T, (sin, cos): (T, T)) -> JointPose<T> {
        let travel = q - self.zero;
        JointPose {
            cos,
            sin,
            origin: self.at + self.direction * travel,
            turn: self.sense,
            slide: self.direction,
            travel,
        }
    }
}

impl<T: Real> JointPose<T> {
    /// The same pose with its derivatives by the coordinate.
    #[inline(always)]
    pub fn moving(&self) -> JointPose<Dual<T, 1>> {
        let by_q = |value: T, slope: T| Dual { value, derivative: [slope] };
        JointPose {
            cos: by_q(self.cos, -self.sin * self.turn),
            sin: by_q(self.sin, self.cos * self.turn),
            origin: Vec2::new(by_q(self.origin.x, self.slide.x), by_q(self.origin.z, self.slide.z)),
            turn: Dual::constant(self.turn),
            slide: self.slide.map(&mut |number| Dual::constant(*number)),
            travel: by_q(self.travel, T::c(1.0)),
        }
    }

    /// A point of the child link, in the parent frame, with its derivative.
    #[inline(always)]
    pub fn carry(&self, point: Vec2<T>) -> MovingPoint<T> {
        let arm = point.rotate(self.cos, self.sin);
        MovingPoint { position: self.origin + arm, rate: self.slide + arm.perp() * self.turn }
    }
}
