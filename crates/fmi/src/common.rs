//! What both versions of FMI have in common: the shape of a function, functions with the same arguments, states of a component.

use crate::component::{Done, Problem, State, Status};
use std::ffi::c_void;

/// Functions on an instance, whose bodies give a status or a problem.
macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),* $(,)?) |$component:ident| $body:expr;)*) => {$(
        /// # Safety
        /// As the standard of FMI states for this function.
        #[no_mangle]
        #[allow(clippy::too_many_arguments)]
        pub unsafe extern "C" fn $name(instance: Instance, $($argument: $type),*) -> c_int {
            call(instance, stringify!($name), |$component: &mut Component| $body)
        }
    )*};
}

/// The functions with the same arguments in both versions, by their names in one.
macro_rules! same_functions {
    ($log:ident $exit:ident $terminate:ident $reset:ident $get:ident $set:ident $free:ident $size:ident $write:ident $read:ident $events:ident $continuous:ident $completed:ident $time:ident $set_states:ident $states:ident $rates:ident $nominals:ident $indicators:ident) => {
        functions! {
            $log(on: Boolean, _count: usize, _categories: *const Text) |component| {
                component.chatty = on != 0;
                Ok(Status::Ok)
            };
            $exit() |component| component.exit_initialisation();
            $terminate() |component| component.terminate();
            $reset() |component| component.reset();
            $get(state: *mut *mut c_void) |component| keep(state, component.keep()?);
            $set(state: *mut c_void) |component| component.put_back(kept(state)?);
            $free(state: *mut *mut c_void) |_component| forget(state);
            $size(state: *mut c_void, size: *mut usize) |_component| {
                answer(size, kept(state)?.length()?);
                Ok(Status::Ok)
            };
            $write(state: *mut c_void, bytes: *mut u8, size: usize) |_component| {
                write_state(&kept(state)?.bytes()?, room(bytes, size)?)
            };
            $read(bytes: *const u8, size: usize, state: *mut *mut c_void) |_component| {
                keep(state, State::of_bytes(given(bytes, size)?)?)
            };
            $events() |component| component.enter_events();
            $continuous() |component| component.enter_continuous();
            $completed(_final: Boolean, event: *mut Boolean, terminate: *mut Boolean) |_component| {
                answer(event, 0);
                answer(terminate, 0);
                Ok(Status::Ok)
            };
            $time(time: f64) |component| component.set_time(time);
            $set_states(states: *const f64, count: usize) |component| component.set_states(given(states, count)?);
            $states(states: *mut f64, count: usize) |component| component.states(room(states, count)?);
            $rates(rates: *mut f64, count: usize) |component| component.rates(room(rates, count)?);
            $nominals(nominals: *mut f64, count: usize) |component| component.nominals(room(nominals, count)?);
            $indicators(_indicators: *mut f64, count: usize) |component| component.none_of_type(count, "event indicator");
        }
    };
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
