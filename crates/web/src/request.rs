//! The request of a page: machine, start, controller, sensors, as JSON.

use crate::knobs::friction;
use crate::knobs::ground;
use crate::knobs::values::stated;
use crate::problem::{problem, Problem};
use hydrocrane_machine::scenario::{Burst, BurstEntry, StickMode};
use hydrocrane_machine::{
    bundled_scenarios, is_path, load, parse, parse_scenario, scenario, whole_text_of, Machine, OverrideValue,
    CONTROLLERS, MOST_SEED,
};
use hydrocrane_sim::assembly::AssemblyError;
use hydrocrane_sim::model::controllers::LEVER;
use hydrocrane_sim::{BuildError, CHAINS};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// All settings of a drive; SI units.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Request {
    /// Bundled name, or the name of the file whose `text` is given.
    #[serde(default)]
    pub machine: String,
    pub text: Option<String>,
    /// Names and texts of further files: what the machine extends and includes; of a scenario, its machine and its logs.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
    /// Machine keys to change.
    #[serde(default)]
    pub overrides: Map<String, Value>,
    /// Coulomb, breakaway and viscous friction of all cylinders, as a share of the machine's.
    #[serde(default = "one")]
    pub friction: f64,
    /// Start pose, rad or m; missing joints have the value of a bundled scenario, or their middle.
    #[serde(default)]
    pub joints: Map<String, Value>,
    /// kg; the machine's own where it is not given.
    pub payload: Option<f64>,
    #[serde(default = "tip")]
    pub controller: String,
    /// Hoses that burst, a list of [`BurstEntry`].
    #[serde(default)]
    pub bursts: Value,
    /// Speed of the tip at full stick, m/s.
    pub full_speed: Option<f64>,
    /// Whether the sensors are those of the data sheets.
    #[serde(default)]
    pub real_sensors: bool,
    #[serde(default)]
    pub seed: u64,
    #[serde(default)]
    pub delay: f64,
    #[serde(default)]
    pub dead_zone: f64,
    #[serde(default)]
    pub ramp: f64,
    /// A scenario to replay, which replaces everything above except the `files`, and what errors call it.
    pub scenario: Option<String>,
    pub scenario_name: Option<String>,
    /// Whether the drawn ground is solid, if the machine states no ground.
    #[serde(default)]
    pub ground: bool,
    /// Continue from the present state if the machine has the same states.
    #[serde(default)]
    pub keep_state: bool,
}

fn one() -> f64 {
    1.0
}

fn tip() -> String {
    "tip".into()
}

/// Mode of the page in which levers move the joints and `tip` holds the height.
pub const HEIGHT: &str = "height";

/// Longest request, bytes: one with a machine and a drive of an hour in it.
const LONGEST_REQUEST: usize = 32 << 20;
/// Share of the machine's friction, from which on it is no friction.
const MOST_FRICTION: f64 = 100.0;
/// s
const MOST_RAMP: f64 = 60.0;
const MOST_DELAY: f64 = 60.0;
/// kg
const MOST_PAYLOAD: f64 = 1e6;

impl Request {
    /// An empty request.
    pub fn plain() -> Self {
        Request {
            machine: String::new(),
            text: None,
            files: BTreeMap::new(),
            overrides: Map::new(),
            friction: one(),
            joints: Map::new(),
            payload: None,
            bursts: Value::Null,
            controller: tip(),
            full_speed: None,
            real_sensors: false,
            seed: 0,
            delay: 0.0,
            dead_zone: 0.0,
            ramp: 0.0,
            scenario: None,
            scenario_name: None,
            ground: false,
            keep_state: false,
        }
    }

    pub fn read(text: &str) -> Result<Self, Problem> {
        if text.len() > LONGEST_REQUEST {
            return Err(Problem::plain(format!("the request is longer than {} MiB", LONGEST_REQUEST >> 20)));
        }
        let mut request: Request = serde_json::from_str(text)
            .map_err(|error| Problem::plain(format!("the request cannot be read: {error}")))?;
        request.check_numbers()?;
        request.check_agreement()?;
        let text = request.text.take().map(|text| (request.machine.clone(), text));
        if text.is_some() || (request.scenario.is_none() && is_path(&request.machine)) {
            let files: Vec<_> = text.into_iter().chain(std::mem::take(&mut request.files)).collect();
            let whole = whole_text_of(&request.machine, &files).map_err(|error| Problem::file(&error))?;
            request.text = Some(whole);
        }
        Ok(request)
    }

    fn check_numbers(&self) -> Result<(), Problem> {
        for (name, value, most) in [
            ("friction", self.friction, MOST_FRICTION),
            ("dead-zone", self.dead_zone, 1.0),
            ("ramp", self.ramp, MOST_RAMP),
            ("delay", self.delay, MOST_DELAY),
            ("payload", self.payload.unwrap_or(0.0), MOST_PAYLOAD),
        ] {
            if !(0.0..=most).contains(&value) {
                return Err(Problem::plain(format!("`{name}` is {value}; it must be zero or greater, up to {most}")));
            }
        }
        if self.seed > MOST_SEED {
            return Err(Problem::plain(format!(
                "`seed` is {}; it must be a whole number up to {MOST_SEED}",
                self.seed
            )));
        }
        if self.dead_zone == 1.0 {
            return Err(Problem::plain("a dead zone of 1 covers the whole stick"));
        }
        Ok(())
    }

    /// `payload` stands for `payload.mass` of the machine: an override beside it must be equal. (The other knobs of the
    /// page, such as `full-speed`, count before the overrides, which may be those of a drive that goes on.)
    fn check_agreement(&self) -> Result<(), Problem> {
        for scenario::Stated { field, value, unit, key, .. } in scenario::stated(self.payload, None, None, None) {
            let Some(other) = self.overrides.get(&key) else { continue };
            let other = override_value(&key, other)?;
            if let Some(wrong) = scenario::contradiction(&OverrideValue::Number(value), unit, &key, &other) {
                return Err(Problem::plain(format!("`{field}` {wrong}; omit one")));
            }
        }
        Ok(())
    }

    /// Stick mode of the requested mode.
    pub fn stick_mode(&self) -> StickMode {
        match self.controller.as_str() {
            LEVER => StickMode::Lever,
            HEIGHT => StickMode::Height,
            _ => StickMode::Tip,
        }
    }

    /// The controller of the mode.
    pub fn law(&self) -> &str {
        match self.stick_mode() {
            StickMode::Height => CONTROLLERS[0].0,
            _ => &self.controller,
        }
    }

    /// The machine with all changes, and the list of changes. Keys that were changed `before` and no longer are have
    /// the machine's value in it, so that the list also states their return.
    pub fn machine(
        &self,
        before: &[(String, OverrideValue)],
    ) -> Result<(Machine, Vec<(String, OverrideValue)>), Problem> {
        let mut changes = self
            .overrides
            .iter()
            .map(|(key, value)| Ok((key.clone(), override_value(key, value)?)))
            .collect::<Result<Vec<_>, Problem>>()?;
        if let Some(speed) = self.full_speed {
            let speeds = CONTROLLERS.iter().map(|(name, _)| format!("control.{name}.full-speed"));
            replace(&mut changes, speeds.map(|key| (key, OverrideValue::Number(speed))).collect());
        }
        if self.ground {
            let own = changes.iter().filter(|(key, _)| !ground::is_its(key)).cloned().collect::<Vec<_>>();
            let others = ground::drawn(&self.load(&own)?);
            changes.extend(others.into_iter().filter(|(key, _)| !self.overrides.contains_key(key)));
        }
        let mut machine = self.load(&changes)?;
        if self.friction != 1.0 {
            replace(&mut changes, friction::changes(&machine, self.friction));
            machine = self.load(&changes)?;
        }
        let lost = |key: &String| !changes.iter().any(|(kept, _)| kept == key);
        let back: Vec<_> = before
            .iter()
            .filter(|(key, _)| lost(key))
            .map(|(key, value)| (key.clone(), stated(&machine, key).unwrap_or_else(|| value.clone())))
            .collect();
        if !back.is_empty() {
            changes.extend(back);
            machine = self.load(&changes)?;
        }
        Ok((machine, changes))
    }

    /// The machine without changes.
    pub fn plain_machine(&self) -> Result<Machine, Problem> {
        self.load(&[])
    }

    fn load(&self, changes: &[(String, OverrideValue)]) -> Result<Machine, Problem> {
        let loaded = match &self.text {
            Some(text) => parse(text, &self.machine, changes),
            None => load(&self.machine, changes),
        };
        loaded.map_err(|error| Problem::file(&error))
    }

    /// The hoses that burst.
    pub fn bursts(&self) -> Result<Vec<Burst>, Problem> {
        if self.bursts.is_null() {
            return Ok(Vec::new());
        }
        if !CHAINS {
            return Err(problem(AssemblyError::Build(String::new(), BuildError::Pump)));
        }
        let entries: Vec<BurstEntry> = serde_json::from_value(self.bursts.clone())
            .map_err(|error| Problem::plain(format!("`bursts` cannot be read: {error}")))?;
        entries.iter().map(Burst::of).collect::<Result<_, _>>().map_err(Problem::plain)
    }

    /// Start pose of each joint that is stated: here, or in a bundled scenario of the machine.
    pub fn pose(&self, machine: &Machine) -> Result<Vec<Option<f64>>, Problem> {
        for name in self.joints.keys() {
            if !machine.joints.iter().any(|joint| joint.name == *name) {
                let known: Vec<&str> = machine.joints.iter().map(|joint| joint.name.as_str()).collect();
                return Err(Problem::plain(format!("there is no joint `{name}`; there are {}", known.join(", "))));
            }
        }
        let usual = if self.text.is_none() { usual_pose(&self.machine) } else { Vec::new() };
        let stated = |name: &str| {
            let here = self.joints.get(name).and_then(Value::as_f64);
            here.or_else(|| usual.iter().find(|(joint, _)| joint == name).map(|(_, q)| *q))
        };
        Ok(machine.joints.iter().map(|joint| stated(&joint.name)).collect())
    }
}

/// Start of the first bundled scenario of a machine.
fn usual_pose(machine: &str) -> Vec<(String, f64)> {
    let scenarios = bundled_scenarios().iter().filter_map(|(name, text)| parse_scenario(text, name, &[]).ok());
    let first = scenarios.into_iter().find(|scenario| scenario.machine == machine);
    first.map(|scenario| scenario.initial.joints).unwrap_or_default()
}

/// `changes` with `others`, which have priority.
fn replace(changes: &mut Vec<(String, OverrideValue)>, others: Vec<(String, OverrideValue)>) {
    changes.retain(|(key, _)| !others.iter().any(|(other, _)| other == key));
    changes.extend(others);
}

fn override_value(key: &str, value: &Value) -> Result<OverrideValue, Problem> {
    Ok(match value {
        Value::Bool(flag) => OverrideValue::Bool(*flag),
        Value::String(text) => OverrideValue::Text(text.clone()),
        Value::Number(number) => OverrideValue::Number(number.as_f64().unwrap_or(f64::NAN)),
        Value::Array(items) => {
            OverrideValue::List(items.iter().map(|item| override_value(key, item)).collect::<Result<_, _>>()?)
        }
        _ => return Err(Problem::plain(format!("override `{key}`: give a number, a text, true, false or a list"))),
    })
}
