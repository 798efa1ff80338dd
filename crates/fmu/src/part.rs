//! What every FMU does, whatever it holds.

use crate::variable::{Kind, Variable};

/// Why something was not done. The text says what is wrong and what helps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// What was asked for is wrong.
    Wrong(String),
    /// The machine cannot go there; from where it was, a smaller step may be possible.
    Impossible(String),
}

impl From<String> for Fault {
    fn from(text: String) -> Self {
        Fault::Wrong(text)
    }
}

/// What stands behind an FMU. Messages say what is wrong and what helps.
pub trait Part: Send {
    fn variables(&self) -> &[Variable];
    /// Whether it can be solved by a method of the simulation tool.
    fn exchanges(&self) -> bool;
    /// Time between the samples of a controller, s.
    fn period(&self) -> Option<f64>;
    /// Back to the start values.
    fn reset(&mut self);
    fn get(&mut self, kind: Kind) -> Result<f64, Fault>;
    /// Takes a finite number, which counts from the next evaluation on.
    fn set(&mut self, kind: Kind, value: f64) -> Result<(), Fault>;
    /// Ends the initialisation; the simulation begins at time `start` (s). What makes the start doubtful is returned.
    fn begin(&mut self, start: f64) -> Result<Vec<String>, Fault>;
    /// Goes on by `duration` (s). What should be told although the step was made is returned.
    fn step(&mut self, duration: f64) -> Result<Vec<String>, Fault>;
    /// s
    fn time(&self) -> f64;
    /// Begins to be solved by the tool.
    fn exchange(&mut self) -> Result<(), Fault> {
        Err(NO_EXCHANGE.to_string().into())
    }
    fn set_time(&mut self, _time: f64) {}
    /// Takes up a change of parameters at an event; whether states jumped.
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
    /// Everything that changes while it runs, as bytes; `None` where it cannot be kept.
    fn save(&mut self) -> Option<Vec<u8>> {
        None
    }
    /// Goes back to what [`Self::save`] gave. After an error the part is of no use until it is reset.
    fn load(&mut self, _bytes: &[u8]) -> Result<(), Fault> {
        Err("this FMU cannot keep its state".to_string().into())
    }
    /// How `unknowns` change where the known variables change `along` a direction, exact.
    fn directional(&mut self, _unknowns: &[Kind], _along: &[(Kind, f64)]) -> Result<Vec<f64>, Fault> {
        Err("a controller has no derivatives: it is sampled".to_string().into())
    }
}

pub(crate) const NO_EXCHANGE: &str =
    "this FMU is for co-simulation only; hydrocrane's documentation of `export fmu` says why";
