//! The interface of a model: all functions of a machine, over slices, without its size in the type. A binding or an
//! exporter needs nothing else.
//!
//! Slices of joints, cylinders and states have the lengths in [`StateSpace::layout`]; SI units throughout.

pub(crate) mod build;
pub(crate) mod controller_model;
pub mod controllers;
pub(crate) mod gain;
pub(crate) mod method_choice;
pub(crate) mod model_change;
pub(crate) mod payload;
pub(crate) mod sensor_monitor;

use crate::model::controller_model::cylinder_model;
use hydrocrane_control::interface::controller::Controller;
use hydrocrane_control::model::inverse_kinematics::{self, Printed, TooFewRevolute};
use hydrocrane_control::parameter_block;
#[cfg(feature = "batch")]
use hydrocrane_control::reference::keep_out::Region;
#[cfg(feature = "batch")]
use hydrocrane_control::reference::reach;
#[cfg(feature = "batch")]
use hydrocrane_lanes::{Demand, InLanes, StepKernel};
use hydrocrane_plant::{Crane, Dynamics, Hydraulics, Kinematics, Plant, StateSpace, Statics};

/// A crane with functions beyond its equations: controllers with it as their model, and copies of it in lanes.
pub trait Model: Kinematics + Dynamics + Hydraulics + StateSpace + Statics {
    /// `held`: coordinate given to every prismatic joint.
    fn inverse_kinematics(&self, tip: [f64; 2], held: f64) -> Result<Vec<Vec<f64>>, TooFewRevolute>;
    /// Distance of a place (x, y, z) of the tip from the nearest keep-out region, m, negative inside; infinite without regions.
    #[cfg(feature = "batch")]
    fn clearance(&self, place: [f64; 3]) -> f64 {
        let sections = self.machine().sections(place);
        let regions = self.machine().keep_out.iter().map(|(_, corners)| Region::new(corners.clone()));
        let nearest = |region: Region| sections.map(|section| region.clearance(section).distance);
        regions.flat_map(nearest).fold(f64::INFINITY, f64::min)
    }
    /// Per cylinder the spool position (m) that has a signed share of the steady speed at full stroke.
    fn spool_positions(&self, shares: &[f64], spools: &mut [f64]);
    /// The same machine for groups of cranes; the arguments are those of [`InLanes`].
    #[cfg(feature = "batch")]
    fn step_kernel(&self, demand: &Demand, own: &[usize], wanted: Option<&str>) -> Box<dyn StepKernel>;
    /// All numbers of its laws, always in the same order.
    #[cfg(feature = "batch")]
    fn numbers(&self) -> Vec<f64>;
    /// What decides its laws besides numbers, as text: two machines with the same can be in one batch.
    #[cfg(feature = "batch")]
    fn structure(&self) -> String;
    /// The joint rates at `q` after a load is picked up at rest: the payload changes from the first to the second `mass` (kg). With these
    /// `numbers` in place of its own.
    #[cfg(feature = "batch")]
    fn picked_up(&self, numbers: &[f64], q: &[f64], qd: &[f64], mass: [f64; 2]) -> Vec<f64>;
    /// The place of the tip within the joint limits that is nearest to `place`, (x, y, z), m.
    #[cfg(feature = "batch")]
    fn nearest_tip(&self, place: [f64; 3]) -> [f64; 3];
    /// The controller `name` with this machine as its controller model; the error lists the names.
    fn controller(&self, name: &str) -> Result<Box<dyn Controller>, String>;
    /// Parameters of the controller `name` as a block for a machine without an operating system. `monitored`: with a monitor of the
    /// sensors; commands leave so long (s) after each sample.
    fn controller_parameters(&self, name: &str, monitored: Option<f64>) -> Result<Vec<u8>, String>;
    /// `controller` with a monitor of the machine's sensors; its commands leave `delay` (s) after each sample.
    fn with_sensor_monitor(&self, controller: Box<dyn Controller>, delay: f64) -> Box<dyn Controller>;
}

/// Without batches nothing is asked of a plant.
#[cfg(not(feature = "batch"))]
trait InLanes {}
#[cfg(not(feature = "batch"))]
impl<const N: usize> InLanes for Plant<f64, N> {}

impl<const N: usize> Model for Crane<N>
where
    Plant<f64, N>: InLanes,
{
    fn inverse_kinematics(&self, tip: [f64; 2], held: f64) -> Result<Vec<Vec<f64>>, TooFewRevolute> {
        let errata = &self.machine().errata;
        let printed = Printed {
            quadrant: !errata.ik_quadrant,
            unreachable: !errata.ik_unreachable,
            extension: !errata.ik_extension,
        };
        let held =
            hydrocrane_num::array::from_fn(|i| if self.plant().mechanics.joints[i].revolute { 0.0 } else { held });
        let found = inverse_kinematics::solve(&self.plant().mechanics, &self.limit_pairs(), tip, &held, printed)?;
        Ok(found.into_iter().map(|q| q.to_vec()).collect())
    }

    fn spool_positions(&self, shares: &[f64], spools: &mut [f64]) {
        for (c, (share, spool)) in shares.iter().zip(spools).enumerate() {
            *spool = cylinder_model(self, c).spool(*share);
        }
    }

    #[cfg(feature = "batch")]
    fn step_kernel(&self, demand: &Demand, own: &[usize], wanted: Option<&str>) -> Box<dyn StepKernel> {
        self.plant().in_lanes(self.layout(), demand, own, wanted)
    }

    #[cfg(feature = "batch")]
    fn numbers(&self) -> Vec<f64> {
        self.plant().numbers()
    }

    #[cfg(feature = "batch")]
    fn structure(&self) -> String {
        format!("{:?} {:?} {}", self.layout().names, self.machine().errata, self.plant().structure())
    }

    #[cfg(feature = "batch")]
    fn picked_up(&self, numbers: &[f64], q: &[f64], qd: &[f64], mass: [f64; 2]) -> Vec<f64> {
        let plant = self.plant().with(numbers);
        let [q, qd]: [[f64; N]; 2] = [q, qd].map(|row| hydrocrane_num::array::from_fn(|i| row[i]));
        plant.attach(&plant.mechanics.pose(&q), &qd, mass[0], mass[1] - mass[0]).rates.to_vec()
    }

    #[cfg(feature = "batch")]
    fn nearest_tip(&self, place: [f64; 3]) -> [f64; 3] {
        reach::nearest(&self.limit_pairs(), place, |q| {
            let mut rows = [[0.0; N]; 3];
            self.tip_jacobian(q, rows.as_flattened_mut());
            (self.tip(q), rows)
        })
    }

    fn controller(&self, name: &str) -> Result<Box<dyn Controller>, String> {
        controllers::build(self, name)
    }

    fn controller_parameters(&self, name: &str, monitored: Option<f64>) -> Result<Vec<u8>, String> {
        parameter_block::written(&controllers::parameters(self, name, monitored)?)
    }

    fn with_sensor_monitor(&self, controller: Box<dyn Controller>, delay: f64) -> Box<dyn Controller> {
        sensor_monitor::with_sensor_monitor(self, controller, delay)
    }
}
