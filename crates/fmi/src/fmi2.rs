//! The functions of FMI 2.0.

use crate::common::{forget, keep, kept, write_state};
use crate::component::{call, free, instantiate, Component, Interface, Logger, State, Status};
use crate::pointers::{answer, given, room, text};
use std::ffi::{c_char, c_int, c_void, CString};
use std::path::PathBuf;

type Instance = *mut c_void;
type References = *const u32;
type Boolean = c_int;
type Text = *const c_char;
type Log = Option<unsafe extern "C" fn(*mut c_void, Text, c_int, Text, Text, ...)>;

/// What a tool hands over to be called.
#[repr(C)]
pub struct Callbacks {
    log: Log,
    _allocate: *const c_void,
    _free: *const c_void,
    _step_finished: *const c_void,
    environment: *mut c_void,
}

#[repr(C)]
pub struct EventInfo {
    again: Boolean,
    terminate: Boolean,
    nominals_changed: Boolean,
    values_changed: Boolean,
    next_defined: Boolean,
    next: f64,
}

/// Pairs of functions for types that no variable has.
macro_rules! other_types {
    ($($get:ident $set:ident $type:ty, $name:literal;)*) => {
        functions! {$(
            $get(_references: References, count: usize, _values: *mut $type) |component| component.none_of_type(count, $name);
            $set(_references: References, count: usize, _values: *const $type) |component| component.none_of_type(count, $name);
        )*}
    };
}

fn logger(name: CString, environment: *mut c_void, log: Log) -> Logger {
    Box::new(move |status, category, message| {
        if let Some(log) = log {
            // The message is a format of `printf`, in which a per cent sign is written twice.
            let format = CString::new(message.to_string_lossy().replace('%', "%%")).unwrap_or_default();
            // SAFETY: the tool gave both for this purpose.
            unsafe { log(environment, name.as_ptr(), status as c_int, category.as_ptr(), format.as_ptr()) };
        }
    })
}

/// The folder of a resource location, which is a URI such as `file:///C:/models/fmu/resources`.
fn folder(location: &str) -> PathBuf {
    let path = location.strip_prefix("file:").map_or(location, |rest| match rest.strip_prefix("//") {
        // Behind the slashes stands the name of a computer, which is empty or this one.
        Some(rest) => rest.strip_prefix("localhost").unwrap_or(rest),
        None => rest,
    });
    let bytes = unescaped(path);
    let path = String::from_utf8_lossy(&bytes).into_owned();
    // `/C:/folder` is `C:/folder` on Windows.
    match cfg!(windows) {
        true => path.trim_start_matches('/').into(),
        false => path.into(),
    }
}

/// `%20` is a space.
fn unescaped(path: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let digits = (first == b'%').then(|| after.get(..2).and_then(|two| std::str::from_utf8(two).ok())).flatten();
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        };
    }
    bytes
}

#[no_mangle]
pub extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

#[no_mangle]
pub extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

/// # Safety
/// As the standard of FMI 2.0 states for this function.
#[no_mangle]
pub unsafe extern "C" fn fmi2Instantiate(
    name: Text,
    kind: c_int,
    token: Text,
    resources: Text,
    callbacks: *const Callbacks,
    _visible: Boolean,
    logging: Boolean,
) -> Instance {
    let (name, token, location) = (text(name), text(token), text(resources));
    let (log, environment) = callbacks.as_ref().map_or((None, std::ptr::null_mut()), |c| (c.log, c.environment));
    let interface = if kind == 0 { Interface::ModelExchange } else { Interface::CoSimulation };
    let logger = logger(CString::new(name).unwrap_or_default(), environment, log);
    instantiate(&folder(&location), &token, interface, logger, logging != 0)
}

/// # Safety
/// As the standard of FMI 2.0 states for this function.
#[no_mangle]
pub unsafe extern "C" fn fmi2FreeInstance(instance: Instance) {
    free(instance);
}

functions! {
    fmi2SetupExperiment(_tolerance_defined: Boolean, _tolerance: f64, start: f64, _stop_defined: Boolean, _stop: f64) |component| {
        component.set_up(start)
    };
    fmi2EnterInitializationMode() |component| component.enter_initialisation();
    fmi2GetReal(references: References, count: usize, values: *mut f64) |component| {
        component.get(given(references, count)?, room(values, count)?)
    };
    fmi2SetReal(references: References, count: usize, values: *const f64) |component| {
        component.set(given(references, count)?, given(values, count)?)
    };
    fmi2GetDirectionalDerivative(
        unknowns: References,
        unknown_count: usize,
        knowns: References,
        known_count: usize,
        seed: *const f64,
        sensitivity: *mut f64,
    ) |component| {
        let (unknowns, knowns) = (given(unknowns, unknown_count)?, given(knowns, known_count)?);
        component.directional(unknowns, knowns, given(seed, known_count)?, room(sensitivity, unknown_count)?)
    };
    fmi2NewDiscreteStates(info: *mut EventInfo) |component| {
        let values_changed = Boolean::from(component.update()?);
        let (again, terminate, nominals_changed, next_defined) = (0, 0, 0, 0);
        answer(info, EventInfo { again, terminate, nominals_changed, values_changed, next_defined, next: 0.0 });
        Ok(Status::Ok)
    };
    fmi2SetRealInputDerivatives(_references: References, count: usize, _orders: *const c_int, _values: *const f64) |component| {
        component.none_of_type(count, "input that is interpolated")
    };
    fmi2GetRealOutputDerivatives(_references: References, count: usize, _orders: *const c_int, _values: *mut f64) |component| {
        component.none_of_type(count, "derivative of an output")
    };
    fmi2DoStep(now: f64, duration: f64, _final: Boolean) |component| component.step(now, duration);
    fmi2CancelStep() |_component| Err("steps are made at once: there is none to cancel".to_string().into());
    fmi2GetStatus(_kind: c_int, value: *mut c_int) |_component| {
        answer(value, Status::Ok as c_int);
        Ok(Status::Ok)
    };
    fmi2GetRealStatus(_kind: c_int, value: *mut f64) |component| {
        answer(value, component.time());
        Ok(Status::Ok)
    };
    fmi2GetIntegerStatus(_kind: c_int, _value: *mut c_int) |_component| Err("there is no such status".to_string().into());
    fmi2GetBooleanStatus(_kind: c_int, value: *mut Boolean) |_component| {
        answer(value, 0);
        Ok(Status::Ok)
    };
    fmi2GetStringStatus(_kind: c_int, value: *mut Text) |_component| {
        answer(value, c"".as_ptr());
        Ok(Status::Ok)
    };
}

same_functions! {
    fmi2SetDebugLogging fmi2ExitInitializationMode fmi2Terminate fmi2Reset fmi2GetFMUstate fmi2SetFMUstate
    fmi2FreeFMUstate fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate fmi2EnterEventMode
    fmi2EnterContinuousTimeMode fmi2CompletedIntegratorStep fmi2SetTime fmi2SetContinuousStates
    fmi2GetContinuousStates fmi2GetDerivatives fmi2GetNominalsOfContinuousStates fmi2GetEventIndicators
}

other_types! {
    fmi2GetInteger fmi2SetInteger c_int, "integer";
    fmi2GetBoolean fmi2SetBoolean Boolean, "truth value";
    fmi2GetString fmi2SetString Text, "text";
}
