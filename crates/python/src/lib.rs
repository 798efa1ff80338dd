//! The Python module `hydrocrane._core`: converts, releases the interpreter lock, maps errors; no logic.

mod answers;
mod arrays;
mod batch;
mod closed_loop;
mod control;
mod files;
mod friction;
mod machine;
mod sensitivity;
mod sensors;
mod simulation;

use pyo3::prelude::*;

#[pymodule]
fn _core(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("MachineFileError", m.py().get_type::<files::MachineFileError>())?;
    m.add_class::<batch::BatchSimulator>()?;
    m.add_class::<machine::Machine>()?;
    m.add_class::<files::MachineTemplate>()?;
    m.add_class::<sensitivity::SensitivityExperiment>()?;
    m.add_class::<simulation::Simulator>()?;
    m.add_function(wrap_pyfunction!(files::load_machine, m)?)?;
    m.add_function(wrap_pyfunction!(files::load_scenario, m)?)?;
    m.add_function(wrap_pyfunction!(files::bundled_machines, m)?)?;
    m.add_function(wrap_pyfunction!(files::bundled_scenarios, m)?)?;
    m.add_function(wrap_pyfunction!(files::bundled_text, m)?)?;
    m.add_function(wrap_pyfunction!(friction::friction_map, m)?)?;
    m.add_function(wrap_pyfunction!(files::quantity, m)?)?;
    m.add_function(wrap_pyfunction!(files::json_schema, m)?)?;
    m.add_function(wrap_pyfunction!(files::key_list, m)?)?;
    m.add_function(wrap_pyfunction!(simulation::simulate, m)?)?;
    m.add_function(wrap_pyfunction!(closed_loop::simulate_controlled, m)?)?;
    m.add_function(wrap_pyfunction!(closed_loop::measure, m)?)?;
    m.add_function(wrap_pyfunction!(control::resolve_rates, m)?)?;
    m.add_function(wrap_pyfunction!(control::tip_gain_info, m)?)?;
    Ok(())
}
