//! Oil, metering edges, spools, chambers and end stops (thesis 4).

pub mod chamber;
pub mod compensator;
pub mod connector;
pub mod counterbalance;
pub mod end_stop;
pub mod fluid;
pub mod leakage;
pub mod load_sensing;
pub mod mains;
pub mod meter_out;
pub mod metering;
pub mod orifice;
pub mod pump;
pub mod relief_valve;
pub mod spool;
pub mod spool_valve;
