//! Memory that a simulation tool passes.

use std::ffi::{c_char, CStr};

/// `count` numbers at `first`.
///
/// # Errors
/// A missing pointer.
///
/// # Safety
/// A pointer that is not null must point to `count` values that stay as they are meanwhile.
pub unsafe fn given<'a, T>(first: *const T, count: usize) -> Result<&'a [T], String> {
    match (count, first.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(MISSING.to_string()),
        _ => Ok(std::slice::from_raw_parts(first, count)),
    }
}

/// Room for `count` values at `first`.
///
/// # Errors
/// A missing pointer.
///
/// # Safety
/// A pointer that is not null must point to room for `count` values that nobody else uses meanwhile.
pub unsafe fn room<'a, T>(first: *mut T, count: usize) -> Result<&'a mut [T], String> {
    match (count, first.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err(MISSING.to_string()),
        _ => Ok(std::slice::from_raw_parts_mut(first, count)),
    }
}

/// Writes a result if the tool wants one.
///
/// # Safety
/// A pointer that is not null must point to room for one value.
pub unsafe fn answer<T>(place: *mut T, value: T) {
    if !place.is_null() {
        place.write(value);
    }
}

/// A text; empty for a null pointer.
///
/// # Safety
/// A pointer that is not null must point to a text that ends with zero.
pub unsafe fn text(first: *const c_char) -> String {
    if first.is_null() {
        return String::new();
    }
    CStr::from_ptr(first).to_string_lossy().into_owned()
}

const MISSING: &str = "the tool gave no memory for values (a null pointer)";
