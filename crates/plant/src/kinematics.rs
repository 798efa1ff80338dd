//! Positions and velocities of links, pistons and tip.
//!
//! Slices of joints, cylinders and states have the lengths of the layout; SI units throughout.

use crate::crane::{array, Crane};
use crate::drawing::{self, Shape};
use crate::errors::StrokeError;
use crate::inverse::joint_from_stroke;
use crate::limits::JointLimits;
use crate::workspace;
use hydrocrane_num::portable;
use hydrocrane_physics::geometry::frames::Joint;

pub trait Kinematics {
    fn joint_limits(&self) -> &[JointLimits];
    /// Piston positions at the joint limits, ascending.
    fn stroke_limits(&self) -> Vec<[f64; 2]>;
    /// Piston positions and their derivatives (lever arms) with respect to their joints.
    fn strokes(&self, q: &[f64], x: &mut [f64], lever_arm: &mut [f64]);
    fn joints_from_strokes(&self, x: &[f64], q: &mut [f64]) -> Result<(), StrokeError>;
    /// Direction of each cylinder from its barrel pin to its rod pin, rad from x towards z in the inertial frame.
    fn cylinder_angles(&self, q: &[f64], angles: &mut [f64]);
    fn tip(&self, q: &[f64]) -> [f64; 2];
    /// Row-major `2 x n`.
    fn tip_jacobian(&self, q: &[f64], jacobian: &mut [f64]);
    /// No way from a joint to the tip is longer inside the joint limits, m.
    fn reach(&self) -> f64;
    /// Velocity (x, z) of the tip, m/s.
    fn tip_velocity(&self, q: &[f64], qd: &[f64]) -> [f64; 2];
    /// Centre of gravity of each moving link, (x, z) pairs in the inertial frame.
    fn centres_of_gravity(&self, q: &[f64], centres: &mut [f64]);
    /// Closed curves around the area that the tip can reach.
    fn workspace(&self) -> Vec<Vec<[f64; 2]>>;
    fn drawing(&self, q: &[f64]) -> Vec<Shape>;
}

impl<const N: usize> Kinematics for Crane<N> {
    fn joint_limits(&self) -> &[JointLimits] {
        &self.limits
    }

    fn stroke_limits(&self) -> Vec<[f64; 2]> {
        (0..N).map(|i| self.actuation_of(i).stroke_range(&self.limits[i])).collect()
    }

    fn strokes(&self, q: &[f64], x: &mut [f64], lever_arm: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for (c, (position, slope)) in self.plant().strokes(&pose).into_iter().enumerate() {
            x[c] = position;
            lever_arm[c] = slope;
        }
    }

    fn joints_from_strokes(&self, x: &[f64], q: &mut [f64]) -> Result<(), StrokeError> {
        for i in 0..N {
            q[i] = joint_from_stroke(&self.actuation_of(i), &self.limits[i], x[i])?;
        }
        Ok(())
    }

    fn cylinder_angles(&self, q: &[f64], angles: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for c in 0..N {
            let parent = pose.link(c);
            let turned = portable::atan2(parent.sin, parent.cos) + self.plant().actuations[c].slope(&pose.joints[c]);
            let (sin, cos) = portable::sin_cos(turned);
            angles[c] = portable::atan2(sin, cos);
        }
    }

    fn tip(&self, q: &[f64]) -> [f64; 2] {
        let tip = self.plant().mechanics.tip_position(&self.plant().mechanics.pose(&array::<N>(q)));
        [tip.x, tip.z]
    }

    fn tip_jacobian(&self, q: &[f64], jacobian: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let tip = self.plant().mechanics.tip_position(&pose);
        for j in 0..N {
            let column = pose.column(j, tip);
            jacobian[j] = column.x;
            jacobian[N + j] = column.z;
        }
    }

    fn reach(&self) -> f64 {
        let mechanics = &self.plant().mechanics;
        let link = |(joint, limits): (&Joint<f64>, &JointLimits)| {
            let slid = if joint.revolute {
                0.0
            } else {
                (limits.lower - joint.zero).abs().max((limits.upper - joint.zero).abs())
            };
            joint.at.norm() + slid
        };
        mechanics.joints.iter().zip(&self.limits).map(link).sum::<f64>() + mechanics.tip.norm()
    }

    fn tip_velocity(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let v = self.plant().mechanics.tip_velocity(&pose, &array::<N>(qd));
        [v.x, v.z]
    }

    fn centres_of_gravity(&self, q: &[f64], centres: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for (i, body) in self.plant().mechanics.bodies.iter().enumerate() {
            let r = pose.links[i].point(body.centre_of_gravity());
            centres[2 * i..2 * i + 2].copy_from_slice(&[r.x, r.z]);
        }
    }

    fn workspace(&self) -> Vec<Vec<[f64; 2]>> {
        workspace::boundary(&self.plant().mechanics, &self.limit_pairs())
    }

    fn drawing(&self, q: &[f64]) -> Vec<Shape> {
        drawing::draw(&self.machine, self.plant(), &array::<N>(q))
    }
}
