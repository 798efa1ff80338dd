//! The files in an FMU's folder `resources`, which describe its content.

use hydrocrane_machine::read_file;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Content of the FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    Plant,
    Controller,
}

/// Further settings: `fmu.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Settings {
    pub role: Role,
    /// Name of a controller, in its role.
    #[serde(default)]
    pub controller: Option<String>,
    /// Whether the controller has a monitor.
    #[serde(default)]
    pub monitor: bool,
    /// Whether a plant's sensors are those of data sheets, drawn by the scenario's seed.
    #[serde(default)]
    pub data_sheet: bool,
    /// Values of the machine that are parameters: keys, or tables with all their keys.
    pub parameters: Vec<String>,
    /// Identifier that the model description has too, so that files of two exports are not mixed.
    pub token: String,
    /// Version of hydrocrane that exported it.
    pub version: String,
}

/// The files as text.
#[derive(Debug, Clone, PartialEq)]
pub struct Resources {
    /// A machine that needs no other file.
    pub machine: String,
    /// Start of a plant, and its integration.
    pub scenario: Option<String>,
    pub settings: Settings,
}

pub const MACHINE: &str = "machine.toml";
pub const SCENARIO: &str = "scenario.toml";
pub const SETTINGS: &str = "fmu.json";

impl Resources {
    /// Reads the files of a folder.
    ///
    /// # Errors
    /// Which file cannot be read, and why.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let settings = Self::settings(&text(folder, SETTINGS)?)?;
        let scenario = (settings.role == Role::Plant).then(|| text(folder, SCENARIO)).transpose()?;
        Ok(Resources { machine: text(folder, MACHINE)?, scenario, settings })
    }

    /// The settings from their text.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn settings(text: &str) -> Result<Settings, String> {
        serde_json::from_str(text)
            .map_err(|error| format!("resources/{SETTINGS} is damaged: {error}; export the FMU again"))
    }
}

fn text(folder: &Path, name: &str) -> Result<String, String> {
    let file = folder.join(name);
    let cannot =
        |why: String| format!("cannot read {}: {why}; unzip the whole FMU, or export it again", file.display());
    let bytes = read_file(&file).map_err(|error| cannot(error.to_string()))?;
    String::from_utf8(bytes).map_err(|_| cannot("it is no text".to_string()))
}
