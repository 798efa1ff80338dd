//! The controllers as a static library for C programs without an operating system: no heap, no threads, no files.
//!
//! The interface is python/hydrocrane/export/embedded/hydrocrane_controller.h; a test holds both equal. Memory and parameters come
//! from the program. Whatever is not a command leaves zeros in the place of the commands, and a status that says why.
#![no_std]

mod named;
mod running;
mod status;

use core::ffi::c_char;
use hydrocrane_control::interface::controller::{Measurement, Stick};
use hydrocrane_control::parameter_block;
use running::{Head, Running};
use status::Status;

/// Runs the body for the number of joints as a constant, if this library serves it.
macro_rules! sized {
    ($joints:expr, $n:ident => $body:expr, else $other:expr) => {
        match $joints {
            #[cfg(feature = "joints-1")]
            1 => sized!(@ 1, $n, $body),
            #[cfg(feature = "joints-2")]
            2 => sized!(@ 2, $n, $body),
            #[cfg(feature = "joints-3")]
            3 => sized!(@ 3, $n, $body),
            #[cfg(feature = "joints-4")]
            4 => sized!(@ 4, $n, $body),
            #[cfg(feature = "joints-5")]
            5 => sized!(@ 5, $n, $body),
            #[cfg(feature = "joints-6")]
            6 => sized!(@ 6, $n, $body),
            _ => $other,
        }
    };
    (@ $number:literal, $n:ident, $body:expr) => {{
        const $n: usize = $number;
        $body
    }};
}

/// What the program gives for a sample.
#[repr(C)]
pub struct Sample {
    t: f64,
    q: *const f64,
    p: *const [f64; 2],
}

/// Modes of the stick.
const TIP: i32 = 0;
const LEVERS: i32 = 1;
const HEIGHT: i32 = 2;

/// Joints and axes that a library serves at most.
const MOST: usize = 6;

/// Makes a controller in the `bytes` of `memory`, of the parameters in `length` bytes.
///
/// # Safety
/// Both pointers must be null or hold for their lengths, and the memory must stay in its place.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_create(
    memory: *mut u8,
    bytes: usize,
    parameters: *const u8,
    length: usize,
) -> Status {
    if memory.is_null() || parameters.is_null() {
        return Status::NullPointer;
    }
    if !(memory as usize).is_multiple_of(align_of::<Head>()) {
        return Status::Misaligned;
    }
    if bytes < size_of::<Head>() {
        return Status::TooLittleMemory;
    }
    // SAFETY: the caller's promise.
    let (head, block) = unsafe { (memory.cast::<Head>(), core::slice::from_raw_parts(parameters, length)) };
    unsafe { head.write(Head::EMPTY) };
    let joints = match parameter_block::joints(block) {
        Ok(joints) => joints,
        Err(refusal) => return refusal.into(),
    };
    sized!(joints, N => {
        if bytes < size_of::<Running<N>>() {
            return Status::TooLittleMemory;
        }
        // SAFETY: aligned as its head is, and large enough.
        unsafe { Running::<N>::begin(memory.cast(), block) }.map_or_else(Status::from, |()| Status::Ok)
    }, else Status::OtherJoints)
}

/// The number of joints of the controller in `memory`.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`.
unsafe fn joints(memory: *const u8) -> Result<u64, Status> {
    if memory.is_null() {
        return Err(Status::NullPointer);
    }
    if !(memory as usize).is_multiple_of(align_of::<Head>()) {
        return Err(Status::Misaligned);
    }
    // SAFETY: the caller's promise.
    unsafe { memory.cast::<Head>().read() }.joints().ok_or(Status::NotCreated)
}

/// Time between samples, s; zero without a controller.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_period(memory: *const u8) -> f64 {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let Ok(joints) = (unsafe { joints(memory) }) else { return 0.0 };
    sized!(joints, N => unsafe { &*memory.cast::<Running<N>>() }.period(), else 0.0)
}

/// A sample with `N` joints, copied: the program may overwrite it with the commands.
struct Read<const N: usize> {
    t: f64,
    q: [f64; N],
    p: [[f64; 2]; N],
}

impl<const N: usize> Read<N> {
    /// # Safety
    /// The pointers of the sample must be null or hold for `N` joints.
    unsafe fn of(sample: *const Sample) -> Result<Self, Status> {
        // SAFETY: the caller's promise.
        let Sample { t, q, p } = unsafe { checked(sample)?.read() };
        unsafe {
            Ok(Read { t, q: checked(q)?.cast::<[f64; N]>().read(), p: checked(p)?.cast::<[[f64; 2]; N]>().read() })
        }
    }

    fn measurement(&self) -> Measurement<'_> {
        Measurement { t: self.t, q: &self.q, p: &self.p }
    }
}

/// A pointer that can be read.
fn checked<T>(place: *const T) -> Result<*const T, Status> {
    match place {
        null if null.is_null() => Err(Status::NullPointer),
        place if !place.is_aligned() => Err(Status::Misaligned),
        place => Ok(place),
    }
}

/// The axes of a stick, copied; `MOST` at most.
///
/// # Safety
/// The pointer must be null or hold for `count` numbers.
unsafe fn deflections(axes: *const f64, count: usize) -> Result<[f64; MOST], Status> {
    let axes = checked(axes)?;
    if count > MOST {
        return Err(Status::BadStick);
    }
    let mut deflections = [0.0; MOST];
    // SAFETY: the caller's promise.
    deflections[..count].copy_from_slice(unsafe { core::slice::from_raw_parts(axes, count) });
    Ok(deflections)
}

/// Starts anew from a first sample.
///
/// # Safety
/// As for `hydrocrane_step`.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_reset(memory: *mut u8, first: *const Sample) -> Status {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let joints = match unsafe { joints(memory) } {
        Ok(joints) => joints,
        Err(status) => return status,
    };
    // SAFETY: the caller's promise.
    sized!(joints, N => match unsafe { Read::<N>::of(first) } {
        Ok(first) => unsafe { &mut *memory.cast::<Running<N>>() }.reset(&first.measurement()),
        Err(status) => status,
    }, else Status::OtherJoints)
}

/// Writes one spool command per cylinder, m, positive extends, into the `spools` numbers at `spool`; zeros with any status but `Ok`.
/// Sample and axes may lie in the same place.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`; every other pointer must be null or hold for the numbers of joints,
/// axes and spools.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_step(
    memory: *mut u8,
    now: *const Sample,
    mode: i32,
    axes: *const f64,
    count: usize,
    spool: *mut f64,
    spools: usize,
) -> Status {
    // SAFETY: the caller's promise.
    unsafe {
        let status = step(memory, now, (mode, axes, count), spool, spools);
        if status != Status::Ok {
            clear(spool, spools);
        }
        status
    }
}

/// Puts zeros in the place of the commands, aligned or not.
///
/// # Safety
/// `spool` must be null or hold `spools` numbers.
unsafe fn clear(spool: *mut f64, spools: usize) {
    let places = if spool.is_null() { 0 } else { spools.min(MOST) };
    for c in 0..places {
        // SAFETY: the caller's promise.
        unsafe { spool.add(c).write_unaligned(0.0) };
    }
}

/// Writes commands only where there are some: a mistake of the library leaves the zeros from before.
///
/// # Safety
/// As for `hydrocrane_step`.
unsafe fn step(
    memory: *mut u8,
    now: *const Sample,
    (mode, axes, count): (i32, *const f64, usize),
    spool: *mut f64,
    spools: usize,
) -> Status {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let joints = match unsafe { joints(memory) } {
        Ok(joints) => joints,
        Err(status) => return status,
    };
    if let Err(status) = checked(spool) {
        return status;
    }
    sized!(joints, N => {
        // SAFETY: the caller's promise.
        let (now, axes) = match unsafe { (Read::<N>::of(now), deflections(axes, count)) } {
            (Ok(now), Ok(axes)) => (now, axes),
            (Err(status), _) | (_, Err(status)) => return status,
        };
        unsafe { clear(spool, spools) };
        if spools != N {
            return Status::OtherSpools;
        }
        let stick = match (mode, &axes[..count]) {
            (TIP, axes) => Stick::Tip(axes),
            (LEVERS, levers) if count == N => Stick::Lever(levers),
            (HEIGHT, levers) if count == N => Stick::Height(levers),
            _ => return Status::BadStick,
        };
        let mut commands = [0.0; N];
        let status = unsafe { &mut *memory.cast::<Running<N>>() }.step(&now.measurement(), stick, &mut commands);
        if status == Status::Ok {
            // SAFETY: not null, aligned, and as long as there are commands.
            unsafe { spool.cast::<[f64; N]>().write(commands) };
        }
        status
    }, else Status::OtherJoints)
}

/// Where the controller wants the tip (x, z), m; of a crane that slews with the slewing joint turned back to zero.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`, `place` null or hold two numbers.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_set_point(memory: *const u8, place: *mut [f64; 2]) -> Status {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let joints = match unsafe { joints(memory) } {
        Ok(joints) => joints,
        Err(status) => return status,
    };
    if place.is_null() {
        return Status::NullPointer;
    }
    let set_point = sized!(joints, N => unsafe { &*memory.cast::<Running<N>>() }.set_point(), else None);
    match set_point {
        // SAFETY: the caller's promise.
        Some(found) => unsafe { place.write(found) },
        None => return Status::NoSetPoint,
    }
    Status::Ok
}

/// What has happened since the last call, a bit each.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_notices(memory: *mut u8) -> u32 {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let Ok(joints) = (unsafe { joints(memory) }) else { return 0 };
    sized!(joints, N => unsafe { &mut *memory.cast::<Running<N>>() }.notices(), else 0)
}

/// The sensors that are suspect now, a bit each.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_suspects(memory: *const u8) -> u32 {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let Ok(joints) = (unsafe { joints(memory) }) else { return 0 };
    sized!(joints, N => unsafe { &*memory.cast::<Running<N>>() }.suspect_bits(), else 0)
}

/// What is wrong with the sensor of a bit of `hydrocrane_suspects`; zero where nothing is, or where there is no such sensor.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_sensor_fault(memory: *const u8, sensor: u32) -> i32 {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let Ok(joints) = (unsafe { joints(memory) }) else { return 0 };
    sized!(joints, N => unsafe { &*memory.cast::<Running<N>>() }.fault_of(sensor), else 0)
}

/// A status in words.
#[no_mangle]
pub extern "C" fn hydrocrane_text(status: i32) -> *const c_char {
    status::text(status).as_ptr()
}

// SAFETY: it takes nothing and gives nothing, so that its declaration is all that can be wrong.
unsafe extern "C" {
    /// The program's own: closes the valves and does not come back.
    safe fn hydrocrane_stop() -> !;
}

/// A mistake of this library: the commands of the present step are zero, and the program decides.
#[panic_handler]
fn stop(_: &core::panic::PanicInfo) -> ! {
    hydrocrane_stop()
}
