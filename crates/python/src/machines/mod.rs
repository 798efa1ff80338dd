//! Machines, scenarios, and what is asked of machines.

pub(crate) mod control;
pub(crate) mod files;
pub(crate) mod fmu;
pub(crate) mod friction;
pub(crate) mod logs;
pub(crate) mod machine;
pub(crate) mod scenario;
pub(crate) mod sensors;
pub(crate) mod tape;
