//! The controllers by name, one of them at a time, without a table of functions: how deep the stack gets can be read from the machine
//! code.

use hydrocrane_control::interface::controller::{Controller, Fault, Measurement, Stick};
use hydrocrane_control::interface::notice::News;
use hydrocrane_control::interface::signal::Signal;
use hydrocrane_control::lever::Lever;
use hydrocrane_control::model::controller_model::ControllerModel;
use hydrocrane_control::monitor::safe_state::Guarded;
use hydrocrane_control::parameter_block::Kind;
use hydrocrane_control::thesis::heinze_pid::{self, HeinzePid};
use hydrocrane_control::tip::{self, Tip};

// There is no heap for the larger ones.
#[allow(clippy::large_enum_variant)]
pub enum Named<const N: usize> {
    Tip(Tip<N>),
    HeinzePid(HeinzePid<N>),
    Lever(Lever<N>, ControllerModel<N>),
}

/// The same for whichever controller it is.
macro_rules! each {
    ($controller:expr, $name:ident => $body:expr) => {
        match $controller {
            Named::Tip($name) => $body,
            Named::HeinzePid($name) => $body,
            Named::Lever($name, _) => $body,
        }
    };
}

impl<const N: usize> Named<N> {
    /// Makes a controller in its place: a copy on the stack would double what is needed.
    ///
    /// # Safety
    /// The place is aligned and large enough.
    pub unsafe fn begin(place: *mut Self, model: &ControllerModel<N>, kind: &Kind<N>) {
        // SAFETY: the caller's promise.
        unsafe {
            match kind {
                Kind::Tip(settings) => Self::begin_tip(place, model, settings),
                Kind::HeinzePid(settings) => Self::begin_heinze_pid(place, model, settings),
                Kind::Lever(lever) => Self::begin_lever(place, model, lever),
            }
        }
    }

    /// # Safety
    /// As above. A function of its own: its copies lie on the stack after those of the parameters have gone.
    #[inline(never)]
    unsafe fn begin_tip(place: *mut Self, model: &ControllerModel<N>, settings: &tip::Settings<N>) {
        // SAFETY: the caller's promise.
        unsafe { place.write(Named::Tip(Tip::new(*model, settings.clone()))) };
    }

    /// # Safety
    /// As above.
    #[inline(never)]
    unsafe fn begin_heinze_pid(place: *mut Self, model: &ControllerModel<N>, settings: &heinze_pid::Settings<N>) {
        // SAFETY: the caller's promise.
        unsafe { place.write(Named::HeinzePid(HeinzePid::new(*model, settings.clone()))) };
    }

    /// # Safety
    /// As above.
    #[inline(never)]
    unsafe fn begin_lever(place: *mut Self, model: &ControllerModel<N>, lever: &Lever<N>) {
        // SAFETY: the caller's promise.
        unsafe { place.write(Named::Lever(lever.clone(), *model)) };
    }

    /// What has happened since the last call.
    pub fn take_notices(&mut self) -> News {
        match self {
            Named::Tip(tip) => tip.take_notices(),
            Named::HeinzePid(_) | Named::Lever(..) => News::default(),
        }
    }
}

impl<const N: usize> Guarded<N> for Named<N> {
    type Controller = Self;

    fn controller(&mut self) -> &mut Self {
        self
    }

    fn model(&self) -> &ControllerModel<N> {
        match self {
            Named::Tip(tip) => tip.model(),
            Named::HeinzePid(pid) => pid.model(),
            Named::Lever(_, model) => model,
        }
    }
}

impl<const N: usize> Controller for Named<N> {
    fn period(&self) -> f64 {
        each!(self, controller => controller.period())
    }

    fn reset(&mut self, first: &Measurement) {
        each!(self, controller => controller.reset(first));
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        each!(self, controller => controller.step(measured, stick, spool))
    }

    fn step_without(
        &mut self,
        measured: &Measurement,
        gaps: &[Signal],
        stick: Stick,
        spool: &mut [f64],
    ) -> Result<(), Fault> {
        each!(self, controller => controller.step_without(measured, gaps, stick, spool))
    }

    fn reads_pressures(&self) -> bool {
        each!(self, controller => controller.reads_pressures())
    }

    fn stands(&self) -> bool {
        each!(self, controller => controller.stands())
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        each!(self, controller => controller.set_point())
    }
}
