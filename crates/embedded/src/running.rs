//! A controller in the program's memory, with the monitor of its sensors if it has one.

use crate::named::Named;
use crate::status::Status;
use hydrocrane_control::interface::controller::{Controller, Measurement, Stick};
use hydrocrane_control::interface::notice::{Cause, Notice};
use hydrocrane_control::interface::signal::{Signal, PER_CYLINDER};
use hydrocrane_control::monitor::plausibility::{Kind, Monitor, Settings};
use hydrocrane_control::monitor::safe_state::{SafeState, SensorNotice};
use hydrocrane_control::parameter_block::{self, memory, Refusal};
use hydrocrane_control::reference::slow_down::{checked, LARGEST_READING};

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
    safe_state: Option<SafeState<N>>,
}

impl<const N: usize> Running<N> {
    /// What the header promises is enough.
    const FITS: () = assert!(size_of::<Self>() <= memory(N) && align_of::<Self>() == align_of::<Head>());

    /// Makes a controller in its place.
    ///
    /// # Safety
    /// The place is aligned and large enough.
    pub unsafe fn begin(place: *mut Self, block: &[u8]) -> Result<(), Refusal> {
        let () = Self::FITS;
        // SAFETY: the caller's promise.
        parameter_block::read::<N, _>(block, |parameters| unsafe {
            Named::begin(&raw mut (*place).controller, &parameters.model, &parameters.controller);
            let safe_state = &raw mut (*place).safe_state;
            match &parameters.monitor {
                Some(settings) => Self::begin_monitor(safe_state, settings),
                None => safe_state.write(None),
            }
            (&raw mut (*place).head).write(Head { mark: MARK, joints: N as u64 });
        })
    }

    /// # Safety
    /// As above. A function of its own, as those of the controllers are.
    #[inline(never)]
    unsafe fn begin_monitor(place: *mut Option<SafeState<N>>, settings: &Settings<N>) {
        // SAFETY: the caller's promise.
        unsafe { place.write(Some(SafeState::new(Monitor::new(settings.clone())))) };
    }

    pub fn period(&self) -> f64 {
        self.controller.period()
    }

    pub fn set_point(&self) -> Option<[f64; 2]> {
        self.controller.set_point()
    }

    pub fn reset(&mut self, first: &Measurement) -> Status {
        if !self.takes(first) {
            return Status::BadMeasurement;
        }
        if let Some(safe_state) = &mut self.safe_state {
            safe_state.reset(&mut self.controller, first);
            return Status::Ok;
        }
        self.controller.reset(first);
        let none = [[0.0; 2]; N];
        let p = if self.controller.reads_pressures() { first.p } else { &none };
        match (&self.controller, checked::<N>(&Measurement { p, ..*first })) {
            (Named::Lever(..), _) | (_, Ok(_)) => Status::Ok,
            (_, Err(fault)) => fault.into(),
        }
    }

    /// The commands are zero where it has none.
    pub fn step(&mut self, now: &Measurement, stick: Stick, spool: &mut [f64]) -> Status {
        if !self.takes(now) {
            return Status::BadMeasurement;
        }
        let answer = match &mut self.safe_state {
            Some(safe_state) => safe_state.step(&mut self.controller, now, stick, spool),
            None => self.controller.step(now, stick, spool),
        };
        match answer {
            Ok(()) if spool.iter().all(|u| u.is_finite()) => Status::Ok,
            answer => {
                spool.fill(0.0);
                answer.map_or_else(Status::from, |()| Status::NoCommand)
            }
        }
    }

    /// Whether a measurement can be handed on: a monitor sorts out readings, not times.
    fn takes(&self, measured: &Measurement) -> bool {
        match self.safe_state {
            Some(_) => measured.t.is_finite(),
            None => !measured.q.iter().chain(measured.p.as_flattened()).any(|reading| reading.abs() > LARGEST_READING),
        }
    }

    /// A bit for each kind of notice since the last call.
    pub fn notices(&mut self) -> u32 {
        let of_controller = self.controller.take_notices().iter().map(flag).fold(0, |all, one| all | one);
        let Some(safe_state) = &mut self.safe_state else { return of_controller };
        safe_state.take_news().iter().map(sensor_flag).fold(of_controller, |all, one| all | one)
    }

    /// Suspect sensors, and what is wrong with each.
    fn suspects(&self) -> impl Iterator<Item = (Signal, Kind)> + '_ {
        self.safe_state.iter().flat_map(|safe_state| safe_state.monitor().suspects())
    }

    /// A bit for each suspect sensor.
    pub fn suspect_bits(&self) -> u32 {
        self.suspects().fold(0, |all, (signal, _)| all | 1 << place(signal))
    }

    /// What is wrong with the sensor at this place among the bits; zero where nothing is.
    pub fn fault_of(&self, sensor: u32) -> i32 {
        self.suspects().find(|(signal, _)| place(*signal) == sensor).map_or(0, |(_, kind)| match kind {
            Kind::NoReading => 1,
            Kind::OutOfRange => 2,
            Kind::Jump(_) => 3,
            Kind::Frozen(_) => 4,
            Kind::Vanished => 5,
            Kind::InBadSample => 6,
        })
    }
}

/// Place of a sensor among the bits: of the first joint, of its cylinder's pressures, of the next joint.
fn place(signal: Signal) -> u32 {
    (PER_CYLINDER * signal.cylinder() + signal.place()) as u32
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
        Notice::Oscillates => 1 << 11,
        Notice::Strays(..) => 1 << 12,
        // No function of this library gives a goal.
        Notice::GivenUp { .. } | Notice::Arrived(_) => 0,
    }
}

fn sensor_flag(notice: &SensorNotice) -> u32 {
    match notice {
        SensorNotice::Stops(..) => 1 << 8,
        SensorNotice::Continued { .. } => 1 << 9,
        SensorNotice::Restarts => 1 << 10,
    }
}
