//! The C functions of FMI 2.0 and FMI 3.0 over `hydrocrane-fmu`: the library inside every exported FMU.
//!
//! One library serves every machine: it reads what it is from the FMU's folder `resources`. Each function goes through
//! [`component::call`], which catches panics and turns problems into a status and a message for the tool's log.

mod component;
#[macro_use]
mod common;
mod fmi2;
mod fmi3;
mod pointers;
