//! A controller in the program's memory.

use crate::status::Status;
use hydrocrane_control::controller::{Controller, Measurement, Stick};
use hydrocrane_control::controller_model::ControllerModel;
use hydrocrane_control::heinze_pid::{self, HeinzePid};
use hydrocrane_control::lever::Lever;
use hydrocrane_control::notice::{Cause, Notice};
use hydrocrane_control::parameter_block::{self, memory, Parameters, Refusal};
use hydrocrane_control::slow_down::checked;
use hydrocrane_control::tip::{self, Tip};

/// Says what the memory holds.
#[derive(Clone, Copy)]
#[repr(C, align(8))]
pub struct Head {
    mark: u64,
    joints: u64,
}

const MARK: u64 = u64::from_le_bytes(*b"hydrocr\x01");

impl Head {
    pub const EMPTY: Head = Head { mark: 0, joints: 0 };

    /// Number of joints, if there is a controller.
    pub fn joints(self) -> Option<u64> {
        (self.mark == MARK).then_some(self.joints)
    }
}

/// A controller behind its head.
#[repr(C)]
pub struct Running<const N: usize> {
    head: Head,
    controller: Named<N>,
}

// There is no heap for the larger ones.
#[allow(clippy::large_enum_variant)]
enum Named<const N: usize> {
    Tip(Tip<N>),
    HeinzePid(HeinzePid<N>),
    Lever(Lever<N>),
}

/// The same for whichever controller it is. Without a table of functions it can be read from the machine code how deep the stack gets.
macro_rules! each {
    ($controller:expr, $name:ident => $body:expr) => {
        match $controller {
            Named::Tip($name) => $body,
            Named::HeinzePid($name) => $body,
            Named::Lever($name) => $body,
        }
    };
}

impl<const N: usize> Running<N> {
    /// What the header promises is enough.
    const FITS: () = assert!(size_of::<Self>() <= memory(N) && align_of::<Self>() == align_of::<Head>());

    /// Makes a controller in its place: a copy on the stack would double what is needed.
    ///
    /// # Safety
    /// The place is aligned and large enough.
    pub unsafe fn begin(place: *mut Self, block: &[u8]) -> Result<(), Refusal> {
        let () = Self::FITS;
        let parameters = parameter_block::read::<N>(block)?;
        // SAFETY: the caller's promise.
        unsafe {
            let controller = &raw mut (*place).controller;
            match &parameters {
                Parameters::Tip(model, settings) => Self::begin_tip(controller, model, settings),
                Parameters::HeinzePid(model, settings) => Self::begin_heinze_pid(controller, model, settings),
                Parameters::Lever(lever) => controller.write(Named::Lever(lever.clone())),
            }
            (&raw mut (*place).head).write(Head { mark: MARK, joints: N as u64 });
        }
        Ok(())
    }

    /// # Safety
    /// The place is aligned and large enough. A function of its own: its copies lie on the stack after those of the parameters have gone.
    #[inline(never)]
    unsafe fn begin_tip(place: *mut Named<N>, model: &ControllerModel<N>, settings: &tip::Settings<N>) {
        // SAFETY: the caller's promise.
        unsafe { place.write(Named::Tip(Tip::new(*model, settings.clone()))) };
    }

    /// # Safety
    /// As above.
    #[inline(never)]
    unsafe fn begin_heinze_pid(place: *mut Named<N>, model: &ControllerModel<N>, settings: &heinze_pid::Settings<N>) {
        // SAFETY: the caller's promise.
        unsafe { place.write(Named::HeinzePid(HeinzePid::new(*model, settings.clone()))) };
    }

    pub fn period(&self) -> f64 {
        each!(&self.controller, controller => controller.period())
    }

    pub fn set_point(&self) -> Option<[f64; 2]> {
        each!(&self.controller, controller => controller.set_point())
    }

    pub fn reset(&mut self, first: &Measurement) -> Status {
        each!(&mut self.controller, controller => controller.reset(first));
        let none = [[0.0; 2]; N];
        let reads_pressures = each!(&self.controller, controller => controller.reads_pressures());
        let p = if reads_pressures { first.p } else { &none };
        match (&self.controller, checked::<N>(&Measurement { p, ..*first })) {
            (Named::Lever(_), _) | (_, Ok(_)) => Status::Ok,
            (_, Err(fault)) => fault.into(),
        }
    }

    /// The commands are zero where it has none.
    pub fn step(&mut self, now: &Measurement, stick: Stick, spool: &mut [f64]) -> Status {
        match each!(&mut self.controller, controller => controller.step(now, stick, spool)) {
            Ok(()) if spool.iter().all(|u| u.is_finite()) => Status::Ok,
            answer => {
                spool.fill(0.0);
                answer.map_or_else(Status::from, |()| Status::NoCommand)
            }
        }
    }

    /// A bit for each kind of notice since the last call.
    pub fn notices(&mut self) -> u32 {
        let Named::Tip(tip) = &mut self.controller else { return 0 };
        tip.take_notices().iter().map(flag).fold(0, |all, one| all | one)
    }
}

fn flag(notice: &Notice) -> u32 {
    match notice {
        Notice::Stands(Cause::Load(_), _) => 1 << 0,
        Notice::Stands(Cause::Lag, _) => 1 << 1,
        Notice::Stands(Cause::Region, _) => 1 << 2,
        Notice::Stands(Cause::Holding(_), _) => 1 << 3,
        Notice::Stands(Cause::Range(_), _) => 1 << 4,
        Notice::Sinks(_) => 1 << 5,
        Notice::RunsAway(_) => 1 << 6,
        Notice::Yields(_) => 1 << 7,
        // No function of this library gives a goal.
        Notice::GivenUp { .. } | Notice::Arrived(_) => 0,
    }
}
