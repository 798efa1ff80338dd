//! Machine and scenario files, good and bad. One binary: linking takes longer than compiling.

mod bad_files;
mod bounds;
mod closed_doors;
mod closed_loop;
mod command_log;
mod ground;
mod include;
mod log_columns;
mod machines;
mod overrides;
mod phases;
mod robustness;
mod supply_log;
mod units_of_the_trade;
mod wrong_files;
