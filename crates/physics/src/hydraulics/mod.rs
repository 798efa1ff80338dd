//! Oil, metering edges, spools, chambers and end stops (thesis 4).

pub mod accumulator;
pub mod chamber;
pub mod compensator;
pub mod connector;
pub mod counterbalance;
pub mod crossover_relief;
pub mod end_stop;
pub mod fluid;
pub mod hose_burst;
pub mod hose_leak;
pub mod leakage;
pub mod line;
pub mod load_holding;
pub mod load_sensing;
pub mod mains;
pub mod meter_out;
pub mod metering;
pub mod orifice;
pub mod pilot_check;
pub mod port_valves;
pub mod priority;
pub mod pump;
pub mod relief_valve;
pub mod spool;
pub mod spool_valve;
pub mod tank_line;
