//! A crane or a cylinder with spool commands, stepped by our loop (co-simulation) or integrated by the tool (model
//! exchange).

use crate::fault::{sound, Fault, NO_STATE};
use crate::kept::Kept;
use crate::parameters::{overrides, parameters, Parameter, PAYLOAD};
use crate::part::Part;
use crate::resources::{Resources, MACHINE, SCENARIO};
use crate::variable::{Kind, Use, Variable};
use hydrocrane_machine::model::FrictionModel;
use hydrocrane_machine::scenario::{parse_scenario_with, Scenario};
use hydrocrane_machine::{Machine, Template};
use hydrocrane_sim::assembly::{options, start, RunSettings};
use hydrocrane_sim::{
    at_spools, build, change_payload, has_hysteresis, longest_delay, Archive, Model, OutcomeKind, SensorMode, Sensors,
    Simulator, Task, Warning,
};
use std::sync::Arc;

/// Outputs that are not available while the plant moves.
const ENERGY: &str = "energy.";

pub struct PlantPart {
    template: Template,
    scenario: Scenario,
    sensors: SensorMode,
    variables: Vec<Variable>,
    parameters: Vec<Parameter>,
    /// Whether parameters have changed since `model` was built.
    stale: bool,
    model: Arc<dyn Model>,
    /// Requested mass at the tip, and that of the file, kg.
    payload: f64,
    own_payload: f64,
    /// Start values of the joints in the file.
    own_joints: Vec<(String, f64)>,
    /// Spool commands, m.
    commands: Vec<f64>,
    /// Simulation time at which the plant began, s.
    began: f64,
    motion: Motion,
    /// Outputs at the present state, if they were requested.
    outputs: Option<Vec<f64>>,
}

/// Storage of the state of the plant.
enum Motion {
    /// Before the first step; computed on request.
    Start(Option<Start>),
    Stepped(Box<Simulator>),
    /// The tool integrates it.
    Exchanged {
        time: f64,
        x: Vec<f64>,
        payload: f64,
    },
}

struct Start {
    x: Vec<f64>,
    readings: Vec<f64>,
    /// Warnings.
    doubts: Vec<String>,
}

impl PlantPart {
    /// # Errors
    /// What is wrong with machine, scenario or settings.
    pub fn open(resources: &Resources) -> Result<Self, String> {
        let template = Template::of_text(&resources.machine, MACHINE).map_err(|error| error.to_string())?;
        let text = resources.scenario.as_deref().unwrap_or_default();
        let scenario = parse_scenario_with(text, SCENARIO, &[(MACHINE.into(), resources.machine.clone())]);
        let scenario = scenario.map_err(|error| error.to_string())?;
        let machine = template.build(&[]).map_err(|error| error.to_string())?;
        let parameters = parameters(&machine, &resources.settings.parameters)?;
        let model = build(&machine).map_err(|error| format!("{MACHINE}: {error}"))?;
        let sensors = if resources.settings.data_sheet { SensorMode::DataSheet } else { SensorMode::Ideal };
        let mut part = PlantPart {
            template,
            own_joints: scenario.initial.joints.clone(),
            scenario,
            sensors,
            variables: Vec::new(),
            parameters,
            stale: false,
            payload: machine.payload.mass,
            own_payload: machine.payload.mass,
            commands: vec![0.0; machine.cylinders.len()],
            model,
            began: 0.0,
            motion: Motion::Start(None),
            outputs: None,
        };
        part.variables = part.described()?;
        Ok(part)
    }

    fn described(&self) -> Result<Vec<Variable>, String> {
        let (machine, layout) = (self.model.machine(), self.model.layout());
        let mut all = vec![Variable::time()];
        for (c, cylinder) in machine.cylinders.iter().enumerate() {
            let (name, stroke) = (format!("cylinder.{}.command", cylinder.name), cylinder.valve.stroke);
            let text = format!("{} spool command, positive extends", cylinder.name);
            let command = Variable::new(&name, Kind::Command(c), Use::Input, "m", text);
            all.push(command.starting(0.0).within([-stroke, stroke]).about(stroke));
        }
        let payload = Variable::new(PAYLOAD, Kind::Payload, Use::Tunable, "kg", "mass at the tip");
        all.push(payload.starting(self.own_payload).within([0.0, f64::INFINITY]));
        all.extend(self.parameters.iter().enumerate().map(|(i, parameter)| parameter.variable(i)));
        for (i, (joint, &unit)) in machine.joints.iter().zip(&layout.units).enumerate() {
            let text = format!("{} joint coordinate at the start, at rest", joint.name);
            let pose = Variable::new(&format!("initial.joint.{}", joint.name), Kind::Pose(i), Use::Fixed, unit, text);
            all.push(pose.starting(self.pose(i)?));
        }
        for (i, name) in layout.names.iter().enumerate() {
            let shown = [".q", ".qd", ".p1", ".p2", "mains.p"].iter().any(|end| name.ends_with(end));
            let usage = if shown { Use::Output } else { Use::Local };
            let state = Variable::new(name, Kind::State(i), usage, layout.units[i], layout.long_names[i].as_str());
            all.push(state.about(layout.scales[i]));
        }
        for (i, name) in layout.names.iter().enumerate() {
            let text = format!("derivative of: {}", layout.long_names[i]);
            let mut rate = Variable::new("rate", Kind::Rate(i), Use::Local, &per_second(layout.units[i]), text);
            rate.name = format!("der({})", crate::names::structured(name));
            all.push(rate);
        }
        for (i, output) in self.model.output_info().iter().enumerate().filter(|(_, o)| !o.name.starts_with(ENERGY)) {
            let usage = if output.name.starts_with("tip.") { Use::Output } else { Use::Local };
            all.push(Variable::new(&output.name, Kind::Output(i), usage, output.unit, output.long_name.as_str()));
        }
        all.extend(self.readings()?);
        set_apart(&mut all);
        Ok(all)
    }

    /// Sensor readings; ideal sensors read states.
    fn readings(&self) -> Result<Vec<Variable>, String> {
        let (layout, outputs) = (self.model.layout(), self.model.output_info());
        let sensors = self.new_sensors()?;
        let reading = |(i, signal): (usize, &str)| {
            let state = layout.names.iter().position(|name| name == signal);
            let kind = state.filter(|_| self.sensors == SensorMode::Ideal).map_or(Kind::Reading(i), Kind::State);
            let unit = state.map(|state| layout.units[state]);
            let unit = unit.or_else(|| outputs.iter().find(|output| output.name == signal).map(|output| output.unit));
            let text = format!("{signal} as its sensor reads it");
            Variable::new(&format!("measured.{signal}"), kind, Use::Output, unit.unwrap_or_default(), text)
        };
        Ok(sensors.signals().enumerate().map(reading).collect())
    }

    fn new_sensors(&self) -> Result<Sensors, String> {
        Sensors::new(self.model.as_ref(), self.sensors, self.scenario.seed, &[])
    }

    /// Start value of a joint.
    fn pose(&self, joint: usize) -> Result<f64, String> {
        let name = &self.model.machine().joints[joint].name;
        let stated = self.scenario.initial.joints.iter().find(|(joint, _)| joint == name);
        stated.map(|(_, value)| *value).ok_or_else(|| format!("{SCENARIO} states no start of joint {name}"))
    }

    /// Builds the machine again if parameters have changed, and returns whether they had.
    fn refresh(&mut self) -> Result<bool, Fault> {
        if !self.stale {
            return Ok(false);
        }
        let machine = self.template.build(&overrides(&self.parameters)).map_err(|error| error.to_string())?;
        self.model = build(&machine).map_err(|error| format!("{MACHINE}: {error}"))?;
        self.stale = false;
        Ok(true)
    }

    /// A simulator at the start.
    fn simulator(&self, x: &[f64]) -> Result<Simulator, String> {
        let (solver, settings) = (&self.scenario.solver, RunSettings { ledger: false, max_steps: u64::MAX });
        let options = options(solver, self.model.machine(), Task::States, self.payload, settings);
        let mut simulator =
            Simulator::new(self.model.clone(), solver.max_step, options).with_sensors(self.new_sensors()?);
        simulator.reset(x)?;
        Ok(simulator)
    }

    fn start(&mut self) -> Result<&Start, Fault> {
        self.refresh()?;
        if let Motion::Start(None) = &self.motion {
            let (x, doubts) =
                start(&self.scenario, self.model.as_ref(), self.payload).map_err(|error| error.to_string())?;
            let readings = self.simulator(&x)?.sensors().readings().to_vec();
            self.motion = Motion::Start(Some(Start { x, readings, doubts: doubts.iter().map(in_words).collect() }));
        }
        match &self.motion {
            Motion::Start(Some(start)) => Ok(start),
            _ => Err("the start is over".to_string().into()),
        }
    }

    fn state(&mut self) -> Result<&[f64], Fault> {
        if let Motion::Start(_) = self.motion {
            return Ok(&self.start()?.x);
        }
        Ok(match &self.motion {
            Motion::Stepped(simulator) => simulator.state().unwrap_or_default(),
            Motion::Exchanged { x, .. } => x,
            Motion::Start(_) => &[],
        })
    }

    fn reading(&mut self, index: usize) -> Result<f64, Fault> {
        match &self.motion {
            Motion::Stepped(simulator) => Ok(simulator.sensors().readings()[index]),
            _ => Ok(self.start()?.readings[index]),
        }
    }

    fn output(&mut self, index: usize) -> Result<f64, Fault> {
        if self.outputs.is_none() {
            let (x, payload) = (self.state()?.to_vec(), self.carried());
            let mut outputs = vec![0.0; self.model.output_info().len()];
            self.model.outputs_without_oil(&x, payload, &mut outputs);
            self.outputs = Some(outputs);
        }
        Ok(self.outputs.as_ref().map_or(f64::NAN, |outputs| outputs[index]))
    }

    /// Mass at the tip in the present state, kg.
    fn carried(&self) -> f64 {
        match &self.motion {
            Motion::Start(_) => self.payload,
            Motion::Stepped(simulator) => simulator.payload(),
            Motion::Exchanged { payload, .. } => *payload,
        }
    }

    /// The derivative at the present state, or the reason why this state is impossible.
    fn derivative(&mut self) -> Result<Vec<f64>, Fault> {
        if let Motion::Exchanged { .. } = self.motion {
            self.refresh()?;
        }
        let (x, payload) = (self.state()?.to_vec(), self.carried());
        if !self.model.admissible(&x) {
            return Err(Fault::Impossible(OUTSIDE.to_string()));
        }
        let u: Vec<f64> = at_spools(self.model.machine(), &self.commands).into_iter().map(|(u, _)| u).collect();
        let mut dx = vec![0.0; x.len()];
        self.model.derivative(&x, &u, payload, &mut dx);
        match dx.iter().all(|dx| dx.is_finite()) {
            true => Ok(dx),
            false => Err(Fault::Impossible("the state has no finite derivative".to_string())),
        }
    }

    /// Applies the values that the tool has set since the last step.
    fn take_up_changes(&mut self) -> Result<(), Fault> {
        let changed = self.refresh()?;
        let Motion::Stepped(simulator) = &mut self.motion else { return Ok(()) };
        if changed {
            simulator.change_machine(self.model.clone())?;
        }
        if simulator.payload() != self.payload {
            simulator.set_payload(self.payload);
        }
        Ok(())
    }
}

const OUTSIDE: &str = "a piston is outside its cylinder: the state is beyond an end of a stroke";

/// Keys of the printed laws of a machine that have a jump; every other law is continuous.
fn laws_that_jump(machine: &Machine) -> impl Iterator<Item = &'static str> {
    // A smoothing velocity takes the jump out of the friction.
    let mut frictions = machine.cylinders.iter().map(|cylinder| &cylinder.friction);
    let stick = frictions.any(|f| f.model == FrictionModel::Static && f.smoothing_velocity.is_none());
    let jumps = [("friction-map", !machine.errata.friction_map && stick), ("orifice-law", !machine.errata.orifice_law)];
    jumps.into_iter().filter(|(_, jumps)| *jumps).map(|(key, _)| key)
}

fn in_words_of_a_jump(key: &str) -> String {
    format!(
        "`errata.{key}` is \"as-printed\", a law with a jump, at which a method with error control takes very many steps; let \
         hydrocrane step this FMU (co-simulation), with fixed steps (`solver.step` of a scenario)"
    )
}

/// A key of the file can be the name of a state as well: the share of a pump's displacement, and its size. The parameter then
/// stands below `parameter`.
fn set_apart(variables: &mut [Variable]) {
    for i in 0..variables.len() {
        let taken = variables.iter().any(|v| v.name == variables[i].name && !matches!(v.kind, Kind::Parameter(_)));
        if taken && matches!(variables[i].kind, Kind::Parameter(_)) {
            variables[i].name.insert_str(0, "parameter.");
        }
    }
}

fn in_words(warning: &Warning) -> String {
    format!("{}; {}", warning.text, warning.cure)
}

fn per_second(unit: &str) -> String {
    match unit {
        "" | "1" => "1/s".to_string(),
        "rad/s" => "rad/s^2".to_string(),
        "m/s" => "m/s^2".to_string(),
        unit => format!("{unit}/s"),
    }
}

impl Part for PlantPart {
    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Delays, hysteresis and sensors that are sampled have states that no tool could integrate.
    fn exchanges(&self) -> bool {
        let machine = self.model.machine();
        self.sensors == SensorMode::Ideal && longest_delay(machine) == 0.0 && !has_hysteresis(machine)
    }

    fn period(&self) -> Option<f64> {
        None
    }

    fn reset(&mut self) {
        self.stale |= self.parameters.iter().any(|parameter| parameter.value != parameter.start);
        self.parameters.iter_mut().for_each(|parameter| parameter.value = parameter.start);
        self.payload = self.own_payload;
        self.scenario.initial.joints.clone_from(&self.own_joints);
        self.commands.fill(0.0);
        (self.began, self.motion, self.outputs) = (0.0, Motion::Start(None), None);
    }

    fn get(&mut self, kind: Kind) -> Result<f64, Fault> {
        match kind {
            Kind::Time => Ok(self.time()),
            Kind::Command(c) => Ok(self.commands[c]),
            Kind::Payload => Ok(self.payload),
            Kind::Parameter(i) => Ok(self.parameters[i].value),
            Kind::Pose(i) => Ok(self.pose(i)?),
            Kind::State(i) => Ok(self.state()?[i]),
            Kind::Rate(i) => Ok(self.derivative()?[i]),
            Kind::Output(i) => self.output(i),
            Kind::Reading(i) => self.reading(i),
            Kind::Stick(_) | Kind::SetPoint(_) => Err("a plant has no sticks".to_string().into()),
        }
    }

    fn set(&mut self, kind: Kind, value: f64) -> Result<(), Fault> {
        if !value.is_finite() {
            return Err(format!("the value must be a finite number, not {value}").into());
        }
        match kind {
            Kind::Command(c) => {
                self.commands[c] = value;
                return Ok(());
            }
            Kind::Payload if value < 0.0 => {
                return Err(format!("a payload of {value} kg; it must not be negative").into())
            }
            Kind::Payload => self.payload = value,
            Kind::Parameter(i) => {
                self.stale |= self.parameters[i].value != value;
                self.parameters[i].value = value;
            }
            Kind::Pose(i) => {
                let name = &self.model.machine().joints[i].name;
                let joints = self.scenario.initial.joints.iter_mut();
                joints.filter(|(joint, _)| joint == name).for_each(|(_, start)| *start = value);
            }
            _ => return Err("this variable is computed and cannot be set".to_string().into()),
        }
        if let Motion::Start(start) = &mut self.motion {
            *start = None;
        }
        self.outputs = None;
        Ok(())
    }

    fn begin(&mut self, start: f64) -> Result<Vec<String>, Fault> {
        self.began = start;
        Ok(self.start()?.doubts.clone())
    }

    fn step(&mut self, duration: f64) -> Result<Vec<String>, Fault> {
        self.outputs = None;
        if let Motion::Start(_) = self.motion {
            let x = self.start()?.x.clone();
            self.motion = Motion::Stepped(Box::new(self.simulator(&x)?));
        } else {
            self.take_up_changes()?;
        }
        let Motion::Stepped(simulator) = &mut self.motion else { return Err(NOT_STEPPED.to_string().into()) };
        let outcome = simulator.step_for(&self.commands, duration);
        let news = simulator.warnings().iter().map(in_words).collect();
        match outcome.kind {
            OutcomeKind::Completed => Ok(news),
            kind => Err(Fault::Impossible(format!("{} at {} s: {}", kind.name(), self.time(), outcome.message))),
        }
    }

    fn time(&self) -> f64 {
        match &self.motion {
            Motion::Start(_) => self.began,
            Motion::Stepped(simulator) => self.began + simulator.time(),
            Motion::Exchanged { time, .. } => *time,
        }
    }

    fn exchange(&mut self) -> Result<Vec<String>, Fault> {
        if !self.exchanges() {
            return Err(crate::part::NO_EXCHANGE.to_string().into());
        }
        if let Motion::Start(_) = self.motion {
            let x = self.start()?.x.clone();
            self.motion = Motion::Exchanged { time: self.began, x, payload: self.payload };
        }
        Ok(laws_that_jump(self.model.machine()).map(in_words_of_a_jump).collect())
    }

    fn set_time(&mut self, now: f64) {
        if let Motion::Exchanged { time, .. } = &mut self.motion {
            *time = now;
        }
    }

    fn update(&mut self) -> Result<bool, Fault> {
        self.refresh()?;
        self.outputs = None;
        let Motion::Exchanged { time, x, payload } = &mut self.motion else { return Ok(false) };
        if *payload == self.payload {
            return Ok(false);
        }
        change_payload(self.model.as_ref(), *time, x, [*payload, self.payload]);
        *payload = self.payload;
        Ok(true)
    }

    fn states(&mut self) -> Result<Vec<f64>, Fault> {
        Ok(self.state()?.to_vec())
    }

    fn set_states(&mut self, states: &[f64]) -> Result<(), Fault> {
        let Motion::Exchanged { x, .. } = &mut self.motion else {
            return Err(crate::part::NO_EXCHANGE.to_string().into());
        };
        if states.len() != x.len() {
            return Err(format!("{} states were set, and there are {}", states.len(), x.len()).into());
        }
        if let Some(state) = states.iter().find(|state| !state.is_finite()) {
            return Err(Fault::Impossible(format!("a state is {state}")));
        }
        x.copy_from_slice(states);
        self.outputs = None;
        Ok(())
    }

    fn rates(&mut self) -> Result<Vec<f64>, Fault> {
        self.derivative()
    }

    fn nominals(&self) -> Vec<f64> {
        self.model.layout().scales.clone()
    }

    fn keep(&mut self) -> Result<Kept, Fault> {
        let mut archive = Archive::writing();
        self.archive(&mut archive)?;
        Ok(Kept::Bytes(archive.into_bytes()))
    }

    fn put_back(&mut self, state: &Kept) -> Result<(), Fault> {
        let bytes = state.bytes()?;
        let mut archive = Archive::reading(&bytes);
        self.archive(&mut archive)?;
        sound(&archive)
    }

    fn directional(&mut self, unknowns: &[Kind], along: &[(Kind, f64)]) -> Result<Vec<f64>, Fault> {
        self.refresh()?;
        let (x, payload) = (self.state()?.to_vec(), self.carried());
        let spools = at_spools(self.model.machine(), &self.commands);
        let (mut dx, mut du) = (vec![0.0; x.len()], vec![0.0; spools.len()]);
        for (kind, change) in along {
            match kind {
                Kind::State(i) => dx[*i] += change,
                Kind::Command(c) => du[*c] += change * spools[*c].1,
                Kind::Time => {}
                _ => return Err("derivatives are by states, spool commands and time".to_string().into()),
            }
        }
        let u: Vec<f64> = spools.into_iter().map(|(u, _)| u).collect();
        let rates = unknowns.iter().any(|kind| matches!(kind, Kind::Rate(_)));
        let rates = rates.then(|| self.rates_along(&x, &u, payload, &dx, &du));
        let outputs = unknowns.iter().any(|kind| matches!(kind, Kind::Output(_)));
        let outputs = outputs.then(|| {
            let mut found = vec![0.0; self.model.output_info().len()];
            self.model.output_derivatives(&x, &dx, payload, &mut found);
            found
        });
        let of = |kind: &Kind| match (kind, &rates, &outputs) {
            (Kind::State(i), ..) => Ok(dx[*i]),
            (Kind::Rate(i), Some(rates), _) => Ok(rates[*i]),
            (Kind::Output(i), _, Some(outputs)) => Ok(outputs[*i]),
            _ => {
                Err("derivatives are of states, their derivatives and outputs; sensors are sampled".to_string().into())
            }
        };
        unknowns.iter().map(of).collect()
    }
}

const NOT_STEPPED: &str = "the tool has begun to integrate this plant and cannot step it as well";

impl PlantPart {
    /// Visits the changing state, for writing or reading.
    fn archive(&mut self, archive: &mut Archive) -> Result<(), Fault> {
        let before: Vec<f64> = self.parameters.iter().map(|parameter| parameter.value).collect();
        self.parameters.iter_mut().for_each(|parameter| archive.number(&mut parameter.value));
        self.stale |= self.parameters.iter().zip(before).any(|(parameter, before)| parameter.value != before);
        archive.number(&mut self.payload);
        archive.number(&mut self.began);
        archive.numbers(&mut self.commands);
        self.scenario.initial.joints.iter_mut().for_each(|(_, value)| archive.number(value));
        self.outputs = None;
        let mut kind = match self.motion {
            Motion::Start(_) => 0,
            Motion::Stepped(_) => 1,
            Motion::Exchanged { .. } => 2,
        };
        archive.whole(&mut kind);
        match kind {
            0 => self.motion = Motion::Start(None),
            1 => self.archive_simulator(archive)?,
            2 => self.archive_state(archive),
            _ => return Err(NO_STATE.to_string().into()),
        }
        Ok(())
    }

    fn archive_simulator(&mut self, archive: &mut Archive) -> Result<(), Fault> {
        let mut x = if archive.reads() { vec![0.0; self.model.layout().len()] } else { self.state()?.to_vec() };
        archive.numbers(&mut x);
        if archive.reads() {
            // The machine and its simulator are made again, and their state is then restored.
            self.refresh()?;
            self.motion = Motion::Stepped(Box::new(self.simulator(&x)?));
        }
        if let Motion::Stepped(simulator) = &mut self.motion {
            simulator.archive(archive);
        }
        Ok(())
    }

    fn archive_state(&mut self, archive: &mut Archive) {
        if archive.reads() {
            let states = self.model.layout().len();
            self.motion = Motion::Exchanged { time: 0.0, x: vec![0.0; states], payload: 0.0 };
        }
        if let Motion::Exchanged { time, x, payload } = &mut self.motion {
            archive.number(time);
            archive.numbers(x);
            archive.number(payload);
        }
    }

    /// Directional derivative of the state derivative along `dx` of the state and `du` of the spool commands.
    fn rates_along(&self, x: &[f64], u: &[f64], payload: f64, dx: &[f64], du: &[f64]) -> Vec<f64> {
        let n = x.len();
        let (mut jacobian, mut along) = (vec![0.0; n * n], vec![0.0; n]);
        self.model.jacobian(x, u, payload, &mut jacobian);
        self.model.command_derivative(x, u, du, &mut along);
        for (along, row) in along.iter_mut().zip(jacobian.chunks_exact(n)) {
            *along += row.iter().zip(dx).map(|(derivative, dx)| derivative * dx).sum::<f64>();
        }
        along
    }
}
