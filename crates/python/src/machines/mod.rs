//! Machines and what is asked of them.

pub(crate) mod control;
pub(crate) mod files;
pub(crate) mod fmu;
pub(crate) mod friction;
pub(crate) mod logs;
pub(crate) mod machine;
pub(crate) mod sensors;
pub(crate) mod tape;
