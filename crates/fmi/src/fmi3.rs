//! The functions of FMI 3.0.

use crate::component::{call, free, instantiate, Component, Done, Interface, Logger, Problem, State, Status};
use crate::pointers::{answer, given, room, text};
use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

type Instance = *mut c_void;
type References = *const u32;
type Boolean = u8;
type Text = *const c_char;
type LogMessage = Option<unsafe extern "C" fn(*mut c_void, c_int, Text, Text)>;

/// Functions on an instance, whose bodies give a status or a problem.
macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),* $(,)?) |$component:ident| $body:expr;)*) => {$(
        /// # Safety
        /// As the standard of FMI 3.0 states for this function.
        #[no_mangle]
        #[allow(clippy::too_many_arguments)]
        pub unsafe extern "C" fn $name(instance: Instance, $($argument: $type),*) -> c_int {
            call(instance, stringify!($name), |$component: &mut Component| $body)
        }
    )*};
}

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
    fmi3SetDebugLogging(on: Boolean, _count: usize, _categories: *const Text) |component| {
        component.chatty = on != 0;
        Ok(Status::Ok)
    };
    fmi3EnterInitializationMode(_tolerance_defined: Boolean, _tolerance: f64, start: f64, _stop_defined: Boolean, _stop: f64) |component| {
        component.set_up(start)?;
        component.enter_initialisation()
    };
    fmi3ExitInitializationMode() |component| component.exit_initialisation();
    fmi3EnterEventMode() |component| component.enter_events();
    fmi3EnterStepMode() |component| component.none_of_type(1, "clock, so that there is no event mode to step from");
    fmi3EnterConfigurationMode() |component| component.none_of_type(1, "structural parameter, so that there is nothing to configure");
    fmi3ExitConfigurationMode() |component| component.none_of_type(1, "structural parameter, so that there is nothing to configure");
    fmi3Terminate() |component| component.terminate();
    fmi3Reset() |component| component.reset();
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
    fmi3GetFMUState(state: *mut *mut c_void) |component| {
        keep(state, component.keep()?)
    };
    fmi3SetFMUState(state: *mut c_void) |component| {
        component.put_back(kept(state)?)
    };
    fmi3FreeFMUState(state: *mut *mut c_void) |_component| forget(state);
    fmi3SerializedFMUStateSize(state: *mut c_void, size: *mut usize) |_component| {
        answer(size, kept(state)?.length()?);
        Ok(Status::Ok)
    };
    fmi3SerializeFMUState(state: *mut c_void, bytes: *mut u8, size: usize) |_component| {
        write_state(&kept(state)?.bytes()?, room(bytes, size)?)
    };
    fmi3DeserializeFMUState(bytes: *const u8, size: usize, state: *mut *mut c_void) |_component| {
        keep(state, State::of_bytes(given(bytes, size)?)?)
    };
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
    fmi3EnterContinuousTimeMode() |component| component.enter_continuous();
    fmi3CompletedIntegratorStep(_final: Boolean, event: *mut Boolean, terminate: *mut Boolean) |_component| {
        answer(event, 0);
        answer(terminate, 0);
        Ok(Status::Ok)
    };
    fmi3SetTime(time: f64) |component| component.set_time(time);
    fmi3SetContinuousStates(states: *const f64, count: usize) |component| component.set_states(given(states, count)?);
    fmi3GetContinuousStates(states: *mut f64, count: usize) |component| component.states(room(states, count)?);
    fmi3GetContinuousStateDerivatives(rates: *mut f64, count: usize) |component| component.rates(room(rates, count)?);
    fmi3GetNominalsOfContinuousStates(nominals: *mut f64, count: usize) |component| component.nominals(room(nominals, count)?);
    fmi3GetEventIndicators(_indicators: *mut f64, count: usize) |component| component.none_of_type(count, "event indicator");
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

/// Hands a state over; one that the tool had there is replaced.
///
/// # Safety
/// `place` is null or points to null or to what this function wrote.
pub unsafe fn keep(place: *mut *mut c_void, state: State) -> Done {
    let Some(place) = place.as_mut() else { return Err("no place for the state (a null pointer)".to_string().into()) };
    match place.cast::<State>().as_mut() {
        Some(kept) => *kept = state,
        None => *place = Box::into_raw(Box::new(state)).cast(),
    }
    Ok(Status::Ok)
}

/// # Safety
/// `state` is null or what [`keep`] wrote.
pub unsafe fn kept<'a>(state: *mut c_void) -> Result<&'a State, Problem> {
    state.cast::<State>().as_ref().ok_or_else(|| "there is no state (a null pointer)".to_string().into())
}

/// # Safety
/// `place` is null or points to null or to what [`keep`] wrote.
pub unsafe fn forget(place: *mut *mut c_void) -> Done {
    if let Some(place) = place.as_mut().filter(|place| !place.is_null()) {
        drop(Box::from_raw(place.cast::<State>()));
        *place = std::ptr::null_mut();
    }
    Ok(Status::Ok)
}

pub fn write_state(state: &[u8], bytes: &mut [u8]) -> Done {
    match bytes.get_mut(..state.len()) {
        Some(bytes) => bytes.copy_from_slice(state),
        None => return Err(format!("{} bytes are too few for a state of {}", bytes.len(), state.len()).into()),
    }
    Ok(Status::Ok)
}
