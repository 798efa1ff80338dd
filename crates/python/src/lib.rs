//! The Python module `hydrocrane._core`: converts, releases the interpreter lock, maps errors; no logic.

mod handed;
mod machines;
mod running;

use hydrocrane_machine::scenario::METHODS;
use hydrocrane_machine::units::{log_columns, log_units};
use hydrocrane_sim::event_loop::promises;
use pyo3::prelude::*;

#[pymodule]
fn _core(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("MachineFileError", m.py().get_type::<handed::errors::MachineFileError>())?;
    m.add_class::<running::batch::BatchSimulator>()?;
    m.add_class::<running::live::LiveSimulator>()?;
    m.add_class::<machines::machine::Machine>()?;
    m.add_class::<running::sensitivity::SensitivityExperiment>()?;
    m.add_class::<running::simulation::Simulator>()?;
    m.add_class::<running::stepped_controller::SteppedController>()?;
    m.add_function(wrap_pyfunction!(running::stepped_controller::controller_parameters, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::load_machine, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::load_scenario, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::machine_of_text, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::tables_of, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::bundled_machines, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::bundled_scenarios, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::bundled_text, m)?)?;
    m.add_function(wrap_pyfunction!(machines::fmu::fmu_variables, m)?)?;
    m.add_function(wrap_pyfunction!(machines::fmu::exponents_of_unit, m)?)?;
    m.add_function(wrap_pyfunction!(machines::friction::friction_map, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::quantity, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::name_fault, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::text_fault, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::path_fault, m)?)?;
    m.add_function(wrap_pyfunction!(machines::scenario::stated_fields, m)?)?;
    m.add_function(wrap_pyfunction!(machines::scenario::contradiction, m)?)?;
    m.add_function(wrap_pyfunction!(machines::scenario::judged_quantity, m)?)?;
    m.add_function(wrap_pyfunction!(machines::scenario::scenario_choices, m)?)?;
    m.add("PoseFault", m.py().get_type::<handed::errors::PoseFault>())?;
    m.add("METHODS", METHODS.to_vec())?;
    m.add("PROMISES", [promises::TIP, promises::PRESSURE, promises::BRIEF])?;
    m.add_function(wrap_pyfunction!(running::run::run, m)?)?;
    m.add_function(wrap_pyfunction!(handed::text_rows::csv_rows, m)?)?;
    m.add_function(wrap_pyfunction!(running::simulation::method_for, m)?)?;
    m.add_function(wrap_pyfunction!(running::run::stages, m)?)?;
    m.add_function(wrap_pyfunction!(running::run::machine_changes, m)?)?;
    m.add_function(wrap_pyfunction!(running::run::start_state, m)?)?;
    m.add_function(wrap_pyfunction!(running::run::command_table, m)?)?;
    m.add_function(wrap_pyfunction!(running::run::scenario_text, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::read_text, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::split_name, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::unit_of, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::first_of, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::time_column, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::counted_in, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::log_unit, m)?)?;
    m.add_function(wrap_pyfunction!(machines::logs::in_si, m)?)?;
    m.add("TIP_AXES", hydrocrane_machine::TIP_AXES)?;
    m.add("TIME_NAMES", log_columns::TIME_NAMES)?;
    m.add("ATMOSPHERE", log_units::ATMOSPHERE)?;
    m.add_function(wrap_pyfunction!(machines::sensors::measure, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::json_schema, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::key_list, m)?)?;
    m.add_function(wrap_pyfunction!(machines::files::machine_text, m)?)?;
    m.add_function(wrap_pyfunction!(machines::tape::tape, m)?)?;
    m.add_function(wrap_pyfunction!(machines::control::resolve_rates, m)?)?;
    m.add_function(wrap_pyfunction!(machines::control::tip_gain_units, m)?)?;
    Ok(())
}
