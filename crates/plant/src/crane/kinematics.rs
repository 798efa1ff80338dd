//! Positions and velocities of links, pistons and tip.
//!
//! Slices of joints, cylinders and states have the lengths of the layout; SI units throughout.

use crate::crane::drawing::{self, Shape};
use crate::crane::inverse::joint_from_stroke;
use crate::crane::limits::JointLimits;
use crate::crane::workspace;
use crate::crane::{array, Crane};
use crate::errors::StrokeError;
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
    /// Which of x, y and z the tip moves along.
    fn tip_axes(&self) -> &'static [usize];
    /// (x, y, z) in the inertial frame, m; y is 0 in the plane.
    fn tip(&self, q: &[f64]) -> [f64; 3];
    /// (x, z) of the tip seen from the side, m: where a crane slews, in the plane of its boom.
    fn tip_in_plane(&self, q: &[f64]) -> [f64; 2];
    /// Row-major `3 x n`.
    fn tip_jacobian(&self, q: &[f64], jacobian: &mut [f64]);
    /// No line from a joint to the tip is longer inside the joint limits, m.
    fn reach(&self) -> f64;
    /// Velocity (x, y, z) of the tip, m/s.
    fn tip_velocity(&self, q: &[f64], qd: &[f64]) -> [f64; 3];
    /// Centre of gravity of each moving link, (x, y, z) in the inertial frame.
    fn centres_of_gravity(&self, q: &[f64], centres: &mut [f64]);
    /// Closed curves around the area that the tip can reach, where a crane slews in the plane of its boom; none of another chain in space.
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
        let pose = self.plant().side_view(&array::<N>(q));
        for c in 0..N {
            let parent = pose.link(c);
            let turned = portable::atan2(parent.sin, parent.cos) + self.plant().actuations[c].slope(&pose.joints[c]);
            let (sin, cos) = portable::sin_cos(turned);
            angles[c] = portable::atan2(sin, cos);
        }
    }

    fn tip_axes(&self) -> &'static [usize] {
        if self.machine.is_spatial() {
            &[0, 1, 2]
        } else {
            &[0, 2]
        }
    }

    fn tip(&self, q: &[f64]) -> [f64; 3] {
        let tip = self.plant().tip_position(&self.plant().mechanics.pose(&array::<N>(q)));
        [tip.x, tip.y, tip.z]
    }

    fn tip_in_plane(&self, q: &[f64]) -> [f64; 2] {
        self.plant().tip_in_plane(&array::<N>(q))
    }

    fn tip_jacobian(&self, q: &[f64], jacobian: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for (j, column) in self.plant().tip_columns(&pose).into_iter().enumerate() {
            for (row, number) in [column.x, column.y, column.z].into_iter().enumerate() {
                jacobian[row * N + j] = number;
            }
        }
    }

    fn reach(&self) -> f64 {
        let (mechanics, space) = (&self.plant().mechanics, self.plant().space());
        let link = |(i, (joint, limits)): (usize, (&Joint<f64>, &JointLimits))| {
            let slid = if joint.revolute {
                0.0
            } else {
                (limits.lower - joint.zero).abs().max((limits.upper - joint.zero).abs())
            };
            space.map_or(joint.at.norm(), |space| space.stances[i].at.norm()) + slid
        };
        let links = mechanics.joints.iter().zip(&self.limits).enumerate().map(link).sum::<f64>();
        links + space.map_or(mechanics.tip.norm(), |space| space.tip.norm())
    }

    fn tip_velocity(&self, q: &[f64], qd: &[f64]) -> [f64; 3] {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let v = self.plant().tip_velocity(&pose, &array::<N>(qd));
        [v.x, v.y, v.z]
    }

    fn centres_of_gravity(&self, q: &[f64], centres: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for (r, out) in self.plant().centres_of_gravity(&pose).into_iter().zip(centres.chunks_exact_mut(3)) {
            out.copy_from_slice(&[r.x, r.y, r.z]);
        }
    }

    fn workspace(&self) -> Vec<Vec<[f64; 2]>> {
        if self.machine.is_spatial() && !self.machine.slews() {
            return Vec::new();
        }
        workspace::boundary(self.plant(), &self.limit_pairs())
    }

    fn drawing(&self, q: &[f64]) -> Vec<Shape> {
        drawing::draw(&self.machine, self.plant(), &array::<N>(q))
    }
}
