//! The common interface of all FMUs.

use crate::fault::Fault;
use crate::kept::Kept;
use crate::variable::{Kind, Variable};

/// The content of an FMU. Messages state cause and cure.
pub trait Part: Send {
    fn variables(&self) -> &[Variable];
    /// Whether it can be solved by a method of the simulation tool.
    fn exchanges(&self) -> bool;
    /// Time between the samples of a controller, s.
    fn period(&self) -> Option<f64>;
    /// Back to the start values.
    fn reset(&mut self);
    fn get(&mut self, kind: Kind) -> Result<f64, Fault>;
    /// Sets a finite number, which is used from the next evaluation on.
    fn set(&mut self, kind: Kind, value: f64) -> Result<(), Fault>;
    /// Ends the initialisation; the simulation begins at time `start` (s). Returns warnings on the start.
    fn begin(&mut self, start: f64) -> Result<Vec<String>, Fault>;
    /// Advances by `duration` (s). Returns messages of a successful step.
    fn step(&mut self, duration: f64) -> Result<Vec<String>, Fault>;
    /// s
    fn time(&self) -> f64;
    /// Begins model exchange. Returns warnings.
    fn exchange(&mut self) -> Result<Vec<String>, Fault> {
        Err(NO_EXCHANGE.to_string().into())
    }
    fn set_time(&mut self, _time: f64) {}
    /// Applies a change of parameters at an event; returns whether states jumped.
    fn update(&mut self) -> Result<bool, Fault> {
        Ok(false)
    }
    fn states(&mut self) -> Result<Vec<f64>, Fault> {
        Ok(Vec::new())
    }
    fn set_states(&mut self, _states: &[f64]) -> Result<(), Fault> {
        Err(NO_EXCHANGE.to_string().into())
    }
    fn rates(&mut self) -> Result<Vec<f64>, Fault> {
        Ok(Vec::new())
    }
    fn nominals(&self) -> Vec<f64> {
        Vec::new()
    }
    /// The changing state.
    fn keep(&mut self) -> Result<Kept, Fault>;
    /// Puts back a state from [`Self::keep`], or its bytes. After an error the part must be reset.
    fn put_back(&mut self, state: &Kept) -> Result<(), Fault>;
    /// Exact directional derivatives of `unknowns` `along` a direction of the known variables.
    fn directional(&mut self, _unknowns: &[Kind], _along: &[(Kind, f64)]) -> Result<Vec<f64>, Fault> {
        Err("a controller has no derivatives: it is sampled".to_string().into())
    }
}

pub(crate) const NO_EXCHANGE: &str =
    "this FMU is for co-simulation only; hydrocrane's documentation of `export fmu` says why";
