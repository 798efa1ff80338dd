//! The functions of FMI 3.0.

use crate::common::{forget, keep, kept, write_state};
use crate::component::{call, free, instantiate, Component, Done, Interface, Logger, State, Status};
use crate::pointers::{answer, given, room, text};
use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

type Instance = *mut c_void;
type References = *const u32;
type Boolean = u8;
type Text = *const c_char;
type LogMessage = Option<unsafe extern "C" fn(*mut c_void, c_int, Text, Text)>;

/// Pairs of functions for types that no variable has.
macro_rules! other_types {
    ($($get:ident $set:ident $type:ty, $name:literal;)*) => {
        functions! {$(
            $get(references: References, count: usize, _values: *mut $type, _n: usize) |component| {
                let _ = references;
                component.none_of_type(count, $name)
            };
            $set(references: References, count: usize, _values: *const $type, _n: usize) |component| {
                let _ = references;
                component.none_of_type(count, $name)
            };
        )*}
    };
}

/// Functions about clocks, of which there are none.
macro_rules! clocks {
    ($($name:ident($($argument:ident: $type:ty),*);)*) => {
        functions! {$(
            $name(_references: References, count: usize, $($argument: $type),*) |component| component.none_of_type(count, "clock");
        )*}
    };
}

fn logger(environment: *mut c_void, log: LogMessage) -> Logger {
    Box::new(move |status, category, message| {
        if let Some(log) = log {
            // SAFETY: the tool gave both for this purpose.
            unsafe { log(environment, status as c_int, category.as_ptr(), message.as_ptr()) };
        }
    })
}

#[no_mangle]
pub extern "C" fn fmi3GetVersion() -> Text {
    c"3.0".as_ptr()
}

/// # Safety
/// As the standard of FMI 3.0 states for this function.
#[no_mangle]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _name: Text,
    token: Text,
    resources: Text,
    _visible: Boolean,
    logging: Boolean,
    environment: *mut c_void,
    log: LogMessage,
) -> Instance {
    let (token, resources) = (text(token), text(resources));
    instantiate(Path::new(&resources), &token, Interface::ModelExchange, logger(environment, log), logging != 0)
}

/// # Safety
/// As the standard of FMI 3.0 states for this function.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: Text,
    token: Text,
    resources: Text,
    _visible: Boolean,
    logging: Boolean,
    _event_mode: Boolean,
    _early_return: Boolean,
    _intermediate: References,
    _intermediate_count: usize,
    environment: *mut c_void,
    log: LogMessage,
    _update: *const c_void,
) -> Instance {
    let (token, resources) = (text(token), text(resources));
    instantiate(Path::new(&resources), &token, Interface::CoSimulation, logger(environment, log), logging != 0)
}

/// # Safety
/// As the standard of FMI 3.0 states for this function.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: Text,
    _token: Text,
    _resources: Text,
    _visible: Boolean,
    _logging: Boolean,
    environment: *mut c_void,
    log: LogMessage,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> Instance {
    let tell = logger(environment, log);
    tell(Status::Error, &c"logStatusError".into(), &c"this FMU has no scheduled execution; take co-simulation".into());
    std::ptr::null_mut()
}

/// # Safety
/// As the standard of FMI 3.0 states for this function.
#[no_mangle]
pub unsafe extern "C" fn fmi3FreeInstance(instance: Instance) {
    free(instance);
}

functions! {
    fmi3EnterInitializationMode(_tolerance_defined: Boolean, _tolerance: f64, start: f64, _stop_defined: Boolean, _stop: f64) |component| {
        component.set_up(start)?;
        component.enter_initialisation()
    };
    fmi3EnterStepMode() |component| component.none_of_type(1, "clock, so that there is no event mode to step from");
    fmi3EnterConfigurationMode() |component| component.none_of_type(1, "structural parameter, so that there is nothing to configure");
    fmi3ExitConfigurationMode() |component| component.none_of_type(1, "structural parameter, so that there is nothing to configure");
    fmi3GetFloat64(references: References, count: usize, values: *mut f64, n: usize) |component| {
        component.get(given(references, count)?, room(values, n)?)
    };
    fmi3SetFloat64(references: References, count: usize, values: *const f64, n: usize) |component| {
        component.set(given(references, count)?, given(values, n)?)
    };
    fmi3GetBinary(_references: References, count: usize, _sizes: *mut usize, _values: *mut *const u8, _n: usize) |component| {
        component.none_of_type(count, "binary")
    };
    fmi3SetBinary(_references: References, count: usize, _sizes: *const usize, _values: *const *const u8, _n: usize) |component| {
        component.none_of_type(count, "binary")
    };
    fmi3GetNumberOfVariableDependencies(_reference: u32, _count: *mut usize) |component| {
        no_dependencies(component)
    };
    fmi3GetVariableDependencies(
        _dependent: u32,
        _elements: *mut usize,
        _independents: *mut u32,
        _of_independents: *mut usize,
        _kinds: *mut c_int,
        _count: usize,
    ) |component| no_dependencies(component);
    fmi3GetDirectionalDerivative(
        unknowns: References,
        unknown_count: usize,
        knowns: References,
        known_count: usize,
        seed: *const f64,
        seed_count: usize,
        sensitivity: *mut f64,
        sensitivity_count: usize,
    ) |component| {
        let (unknowns, knowns) = (given(unknowns, unknown_count)?, given(knowns, known_count)?);
        component.directional(unknowns, knowns, given(seed, seed_count)?, room(sensitivity, sensitivity_count)?)
    };
    fmi3GetAdjointDerivative(
        _unknowns: References,
        _unknown_count: usize,
        _knowns: References,
        _known_count: usize,
        _seed: *const f64,
        _seed_count: usize,
        _sensitivity: *mut f64,
        _sensitivity_count: usize,
    ) |_component| Err("no adjoint derivatives; take directional ones".to_string().into());
    fmi3EvaluateDiscreteStates() |_component| Ok(Status::Ok);
    fmi3UpdateDiscreteStates(
        again: *mut Boolean,
        terminate: *mut Boolean,
        nominals: *mut Boolean,
        values: *mut Boolean,
        next_defined: *mut Boolean,
        next: *mut f64,
    ) |component| {
        answer(values, Boolean::from(component.update()?));
        for no in [again, terminate, nominals, next_defined] {
            answer(no, 0);
        }
        answer(next, 0.0);
        Ok(Status::Ok)
    };
    fmi3GetNumberOfEventIndicators(count: *mut usize) |_component| {
        answer(count, 0);
        Ok(Status::Ok)
    };
    fmi3GetNumberOfContinuousStates(count: *mut usize) |component| {
        answer(count, component.state_count());
        Ok(Status::Ok)
    };
    fmi3GetOutputDerivatives(_references: References, count: usize, _orders: *const i32, _values: *mut f64, _n: usize) |component| {
        component.none_of_type(count, "derivative of an output")
    };
    fmi3DoStep(
        now: f64,
        duration: f64,
        _final: Boolean,
        event: *mut Boolean,
        terminate: *mut Boolean,
        early: *mut Boolean,
        last: *mut f64,
    ) |component| {
        for no in [event, terminate, early] {
            answer(no, 0);
        }
        let done = component.step(now, duration);
        answer(last, component.time());
        done
    };
    fmi3ActivateModelPartition(_clock: u32, _time: f64) |component| component.none_of_type(1, "clock");
}

same_functions! {
    fmi3SetDebugLogging fmi3ExitInitializationMode fmi3Terminate fmi3Reset fmi3GetFMUState fmi3SetFMUState
    fmi3FreeFMUState fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState fmi3EnterEventMode
    fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep fmi3SetTime fmi3SetContinuousStates
    fmi3GetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetNominalsOfContinuousStates fmi3GetEventIndicators
}

other_types! {
    fmi3GetFloat32 fmi3SetFloat32 f32, "number of 32 bits";
    fmi3GetInt8 fmi3SetInt8 i8, "integer";
    fmi3GetUInt8 fmi3SetUInt8 u8, "integer";
    fmi3GetInt16 fmi3SetInt16 i16, "integer";
    fmi3GetUInt16 fmi3SetUInt16 u16, "integer";
    fmi3GetInt32 fmi3SetInt32 i32, "integer";
    fmi3GetUInt32 fmi3SetUInt32 u32, "integer";
    fmi3GetInt64 fmi3SetInt64 i64, "integer";
    fmi3GetUInt64 fmi3SetUInt64 u64, "integer";
    fmi3GetBoolean fmi3SetBoolean Boolean, "truth value";
    fmi3GetString fmi3SetString Text, "text";
}

clocks! {
    fmi3GetClock(_values: *mut Boolean);
    fmi3SetClock(_values: *const Boolean);
    fmi3GetIntervalDecimal(_intervals: *mut f64, _qualifiers: *mut c_int);
    fmi3GetIntervalFraction(_counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut c_int);
    fmi3GetShiftDecimal(_shifts: *mut f64);
    fmi3GetShiftFraction(_counters: *mut u64, _resolutions: *mut u64);
    fmi3SetIntervalDecimal(_intervals: *const f64);
    fmi3SetIntervalFraction(_counters: *const u64, _resolutions: *const u64);
    fmi3SetShiftDecimal(_shifts: *const f64);
    fmi3SetShiftFraction(_counters: *const u64, _resolutions: *const u64);
}

fn no_dependencies(_component: &Component) -> Done {
    Err("dependencies are those of modelDescription.xml: nothing changes them".to_string().into())
}
