//! The controllers as a static library for C programs without an operating system: no heap, no threads, no files.
//!
//! The interface is python/hydrocrane/export/embedded/hydrocrane_controller.h; a test holds both equal. Memory and parameters come
//! from the program. Whatever is not a command leaves zeros in the place of the commands, and a status that says why.
#![no_std]

mod named;
mod running;
mod status;

use core::ffi::c_char;
use core::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};
use hydrocrane_control::controller::{Measurement, Stick};
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

/// The measurement of a sample with `N` joints.
///
/// # Safety
/// Its pointers must be null or hold for `N` joints.
unsafe fn measured<'a, const N: usize>(sample: *const Sample) -> Result<Measurement<'a>, Status> {
    // SAFETY: the caller's promise.
    let Some(Sample { t, q, p }) = (unsafe { sample.as_ref() }) else { return Err(Status::NullPointer) };
    if q.is_null() || p.is_null() {
        return Err(Status::NullPointer);
    }
    if ![*q as usize, *p as usize].iter().all(|place| place.is_multiple_of(align_of::<f64>())) {
        return Err(Status::Misaligned);
    }
    // SAFETY: the caller's promise.
    let (q, p) = unsafe { (core::slice::from_raw_parts(*q, N), core::slice::from_raw_parts(*p, N)) };
    Ok(Measurement { t: *t, q, p })
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
    sized!(joints, N => match unsafe { measured::<N>(first) } {
        Ok(first) => unsafe { &mut *memory.cast::<Running<N>>() }.reset(&first),
        Err(status) => status,
    }, else Status::OtherJoints)
}

/// Writes one spool command per cylinder, m, positive extends; zeros with any status but `Ok`.
///
/// # Safety
/// `memory` must be null or have been given to `hydrocrane_create`; every other pointer must be null or hold for the numbers of joints
/// and axes.
#[no_mangle]
pub unsafe extern "C" fn hydrocrane_step(
    memory: *mut u8,
    now: *const Sample,
    mode: i32,
    axes: *const f64,
    count: usize,
    spool: *mut f64,
) -> Status {
    // SAFETY: the caller's promise; the head says what the memory holds.
    let joints = match unsafe { joints(memory) } {
        Ok(joints) => joints,
        Err(status) => return status,
    };
    if spool.is_null() || axes.is_null() {
        return Status::NullPointer;
    }
    if ![spool as usize, axes as usize].iter().all(|place| place.is_multiple_of(align_of::<f64>())) {
        return Status::Misaligned;
    }
    sized!(joints, N => {
        // SAFETY: the caller's promise.
        let (spool, axes) = unsafe {
            (core::slice::from_raw_parts_mut(spool, N), core::slice::from_raw_parts(axes, count))
        };
        spool.fill(0.0);
        OUTPUT.store(spool.as_mut_ptr(), Ordering::Relaxed);
        OUTPUTS.store(N, Ordering::Relaxed);
        let stick = match (mode, axes) {
            (TIP, &[x, z]) => Stick::Tip([x, z]),
            (LEVERS, levers) if count == N => Stick::Lever(levers),
            (HEIGHT, levers) if count == N => Stick::Height(levers),
            _ => return Status::BadStick,
        };
        match unsafe { measured::<N>(now) } {
            Ok(now) => unsafe { &mut *memory.cast::<Running<N>>() }.step(&now, stick, spool),
            Err(status) => status,
        }
    }, else Status::OtherJoints)
}

/// Where the controller wants the tip (x, z), m.
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

/// Where the commands of the present step lie.
static OUTPUT: AtomicPtr<f64> = AtomicPtr::new(core::ptr::null_mut());
static OUTPUTS: AtomicUsize = AtomicUsize::new(0);

unsafe extern "C" {
    /// The program's own: closes the valves and does not come back.
    safe fn hydrocrane_stop() -> !;
}

/// A mistake of this library: the commands become zero, and the program decides.
#[panic_handler]
fn stop(_: &core::panic::PanicInfo) -> ! {
    let output = OUTPUT.load(Ordering::Relaxed);
    if !output.is_null() {
        // SAFETY: the step that was under way has checked them.
        unsafe { core::slice::from_raw_parts_mut(output, OUTPUTS.load(Ordering::Relaxed)) }.fill(0.0);
    }
    hydrocrane_stop()
}
