//! The variables of an FMU. A variable's value reference is its index in the list.

/// Meaning of a variable. Numbers are indices in the lists of the machine or of the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Time,
    /// Spool command of a cylinder, m: input of a plant, output of a controller.
    Command(usize),
    /// Deflection of a stick, -1 to 1.
    Stick(usize),
    /// Sensor reading: output of a plant, input of a controller.
    Reading(usize),
    /// Mass at the tip, kg.
    Payload,
    /// A value of the machine file.
    Parameter(usize),
    /// Coordinate of a joint at the start.
    Pose(usize),
    State(usize),
    /// Derivative of a state by time.
    Rate(usize),
    /// Output of the plant besides its states.
    Output(usize),
    /// Set-point of the tip: x, then z, m.
    SetPoint(usize),
}

/// How a tool uses a variable: its causality, variability and initial value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    Independent,
    Input,
    /// May be set until the initialisation ends.
    Fixed,
    /// May be set at any time.
    Tunable,
    Output,
    Local,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    pub name: String,
    pub kind: Kind,
    pub usage: Use,
    /// SI; empty for a plain number.
    pub unit: String,
    pub description: String,
    /// Start value, if the variable has one.
    pub start: Option<f64>,
    /// Range of distinct values; values outside act like its ends.
    pub range: Option<[f64; 2]>,
    pub nominal: Option<f64>,
}

impl Variable {
    pub fn new(name: &str, kind: Kind, usage: Use, unit: &str, description: impl Into<String>) -> Self {
        let unit = if unit == "1" { "" } else { unit };
        Variable {
            name: crate::names::structured(name),
            kind,
            usage,
            unit: unit.to_string(),
            description: description.into(),
            start: None,
            range: None,
            nominal: None,
        }
    }

    pub fn starting(self, value: f64) -> Self {
        Variable { start: Some(value), ..self }
    }

    pub fn within(self, range: [f64; 2]) -> Self {
        Variable { range: Some(range), ..self }
    }

    pub fn about(self, nominal: f64) -> Self {
        Variable { nominal: Some(nominal), ..self }
    }

    pub fn time() -> Self {
        Self::new("time", Kind::Time, Use::Independent, "s", "simulation time")
    }
}
