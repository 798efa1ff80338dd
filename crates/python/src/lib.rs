//! The Python module `hydrocrane._core`: converts, releases the interpreter lock, maps errors; no logic.

mod answers;
mod arrays;
mod batch;
mod control;
mod errors;
mod files;
mod fmu;
mod friction;
mod live;
mod logs;
mod machine;
mod overrides;
mod own_controller;
mod record;
mod run;
mod scenario;
mod sensitivity;
mod sensors;
mod simulation;
mod stepped_controller;
mod tape;
mod text_rows;

use hydrocrane_machine::scenario::METHODS;
use hydrocrane_machine::{log_columns, log_units};
use hydrocrane_sim::promises;
use pyo3::prelude::*;

#[pymodule]
fn _core(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("MachineFileError", m.py().get_type::<errors::MachineFileError>())?;
    m.add_class::<batch::BatchSimulator>()?;
    m.add_class::<live::LiveSimulator>()?;
    m.add_class::<machine::Machine>()?;
    m.add_class::<sensitivity::SensitivityExperiment>()?;
    m.add_class::<simulation::Simulator>()?;
    m.add_class::<stepped_controller::SteppedController>()?;
    m.add_function(wrap_pyfunction!(stepped_controller::controller_parameters, m)?)?;
    m.add_function(wrap_pyfunction!(files::load_machine, m)?)?;
    m.add_function(wrap_pyfunction!(files::load_scenario, m)?)?;
    m.add_function(wrap_pyfunction!(files::machine_of_text, m)?)?;
    m.add_function(wrap_pyfunction!(files::tables_of, m)?)?;
    m.add_function(wrap_pyfunction!(files::bundled_machines, m)?)?;
    m.add_function(wrap_pyfunction!(files::bundled_scenarios, m)?)?;
    m.add_function(wrap_pyfunction!(files::bundled_text, m)?)?;
    m.add_function(wrap_pyfunction!(fmu::fmu_variables, m)?)?;
    m.add_function(wrap_pyfunction!(fmu::exponents_of_unit, m)?)?;
    m.add_function(wrap_pyfunction!(friction::friction_map, m)?)?;
    m.add_function(wrap_pyfunction!(files::quantity, m)?)?;
    m.add_function(wrap_pyfunction!(files::name_fault, m)?)?;
    m.add_function(wrap_pyfunction!(files::text_fault, m)?)?;
    m.add_function(wrap_pyfunction!(files::path_fault, m)?)?;
    m.add_function(wrap_pyfunction!(scenario::stated_fields, m)?)?;
    m.add_function(wrap_pyfunction!(scenario::contradiction, m)?)?;
    m.add_function(wrap_pyfunction!(scenario::judged_quantity, m)?)?;
    m.add_function(wrap_pyfunction!(scenario::scenario_choices, m)?)?;
    m.add("PoseFault", m.py().get_type::<errors::PoseFault>())?;
    m.add("METHODS", METHODS.to_vec())?;
    m.add("PROMISES", [promises::TIP, promises::PRESSURE, promises::BRIEF])?;
    m.add_function(wrap_pyfunction!(run::run, m)?)?;
    m.add_function(wrap_pyfunction!(text_rows::csv_rows, m)?)?;
    m.add_function(wrap_pyfunction!(simulation::method_for, m)?)?;
    m.add_function(wrap_pyfunction!(run::stages, m)?)?;
    m.add_function(wrap_pyfunction!(run::machine_changes, m)?)?;
    m.add_function(wrap_pyfunction!(run::start_state, m)?)?;
    m.add_function(wrap_pyfunction!(run::command_table, m)?)?;
    m.add_function(wrap_pyfunction!(run::scenario_text, m)?)?;
    m.add_function(wrap_pyfunction!(logs::read_text, m)?)?;
    m.add_function(wrap_pyfunction!(logs::split_name, m)?)?;
    m.add_function(wrap_pyfunction!(logs::unit_of, m)?)?;
    m.add_function(wrap_pyfunction!(logs::first_of, m)?)?;
    m.add_function(wrap_pyfunction!(logs::time_column, m)?)?;
    m.add_function(wrap_pyfunction!(logs::counted_in, m)?)?;
    m.add_function(wrap_pyfunction!(logs::log_unit, m)?)?;
    m.add_function(wrap_pyfunction!(logs::in_si, m)?)?;
    m.add("TIP_AXES", hydrocrane_machine::TIP_AXES)?;
    m.add("TIME_NAMES", log_columns::TIME_NAMES)?;
    m.add("ATMOSPHERE", log_units::ATMOSPHERE)?;
    m.add_function(wrap_pyfunction!(sensors::measure, m)?)?;
    m.add_function(wrap_pyfunction!(files::json_schema, m)?)?;
    m.add_function(wrap_pyfunction!(files::key_list, m)?)?;
    m.add_function(wrap_pyfunction!(files::machine_text, m)?)?;
    m.add_function(wrap_pyfunction!(tape::tape, m)?)?;
    m.add_function(wrap_pyfunction!(control::resolve_rates, m)?)?;
    m.add_function(wrap_pyfunction!(control::tip_gain_units, m)?)?;
    Ok(())
}
