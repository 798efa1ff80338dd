//! Options of the command line: `--name value` or `--name=value`.

use std::collections::HashMap;
use std::str::FromStr;

pub struct Arguments(HashMap<String, String>);

impl Arguments {
    /// The options after the program's name; an error where one is unknown or lacks its value.
    pub fn read(given: impl Iterator<Item = String>, known: &[&str]) -> Result<Self, String> {
        let mut found = HashMap::new();
        let mut given = given;
        while let Some(argument) = given.next() {
            let name = argument.strip_prefix("--").ok_or_else(|| format!("`{argument}`: options begin with --"))?;
            let (name, value) = match name.split_once('=') {
                Some((name, value)) => (name.to_string(), value.to_string()),
                None => (name.to_string(), given.next().ok_or_else(|| format!("--{name} needs a value"))?),
            };
            if !known.contains(&name.as_str()) {
                return Err(format!("no option --{name}; there are --{}", known.join(", --")));
            }
            found.insert(name, value);
        }
        Ok(Arguments(found))
    }

    pub fn text(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    /// A number, or `default` where the option is not given.
    pub fn number<T: FromStr>(&self, name: &str, default: T) -> Result<T, String> {
        self.text(name).map_or(Ok(default), |text| text.parse().map_err(|_| format!("--{name} {text}: give a number")))
    }

    /// The parts of a list with commas; `default` where the option is not given.
    pub fn list(&self, name: &str, default: &[&str]) -> Vec<String> {
        let given = self.text(name).map(|text| text.split(',').map(|part| part.trim().to_string()).collect());
        given.unwrap_or_else(|| default.iter().map(|part| part.to_string()).collect())
    }
}
