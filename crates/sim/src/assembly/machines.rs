//! Machines of a scenario from bundled names, paths, or one text in memory, each made once.

use super::{AssemblyError, Surroundings};
use crate::model::build::build;
use crate::model::Model;
use hydrocrane_control::interface::controller::Controller;
use hydrocrane_machine::scenario::Stage;
use hydrocrane_machine::{load, parse, OverrideValue};
use std::sync::Arc;

/// The machines of a scenario without user-defined controllers.
pub struct Machines<'a> {
    /// Bundled name or path; the name of the `text` where there is one.
    pub machine: &'a str,
    pub text: Option<&'a str>,
}

impl Surroundings for Machines<'_> {
    fn machine(
        &mut self,
        source: Option<&str>,
        overrides: &[(String, OverrideValue)],
    ) -> Result<Arc<dyn Model>, AssemblyError> {
        let name = source.unwrap_or(self.machine);
        let machine = match self.text.filter(|_| source.is_none()) {
            Some(text) => parse(text, name, overrides)?,
            None => load(name, overrides)?,
        };
        build(&machine).map_err(|error| AssemblyError::Build(name.into(), error))
    }

    fn own_controller(&mut self, _: usize, _: &Stage, _: &Arc<dyn Model>) -> Option<Box<dyn Controller>> {
        None
    }
}

/// Surroundings that make each machine once: most phases change the sticks or the controller, and no value of the machine.
pub(super) struct Once<'a> {
    pub inner: &'a mut dyn Surroundings,
    pub made: Vec<Made>,
}

/// Source and overrides of a machine, and its model.
type Made = (Option<String>, Vec<(String, OverrideValue)>, Arc<dyn Model>);

impl Surroundings for Once<'_> {
    fn machine(
        &mut self,
        source: Option<&str>,
        overrides: &[(String, OverrideValue)],
    ) -> Result<Arc<dyn Model>, AssemblyError> {
        let same = self.made.iter().rev().find(|(from, with, _)| from.as_deref() == source && with == overrides);
        if let Some((_, _, model)) = same {
            return Ok(model.clone());
        }
        let model = self.inner.machine(source, overrides)?;
        self.made.push((source.map(str::to_string), overrides.to_vec(), model.clone()));
        Ok(model)
    }

    fn own_controller(
        &mut self,
        number: usize,
        stage: &Stage,
        controller_model: &Arc<dyn Model>,
    ) -> Option<Box<dyn Controller>> {
        self.inner.own_controller(number, stage, controller_model)
    }
}
