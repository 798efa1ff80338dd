//! A controller by name: measurements and sticks in, spool commands out, sample by sample.

use crate::controller_state::{ControllerState, Going, Inputs};
use crate::fault::{Fault, NO_STATE};
use crate::history::History;
use crate::kept::Kept;
use crate::parameters::{overrides, parameters, Parameter};
use crate::part::Part;
use crate::resources::{Resources, MACHINE};
use crate::variable::{Kind, Use, Variable};
use hydrocrane_machine::{Machine, Template};
use hydrocrane_sim::controller::{Measurement, Stick};
use hydrocrane_sim::model::controllers::{tip_gains, LEVER};
use hydrocrane_sim::{build, EquilibriumMode, Model, Sensors};
use std::sync::Arc;

/// Share of a period by which a sample may be early: times are sums of steps.
const ROUNDING: f64 = 1e-6;

pub struct ControllerPart {
    template: Template,
    name: String,
    monitor: bool,
    token: String,
    variables: Vec<Variable>,
    parameters: Vec<Parameter>,
    stale: bool,
    model: Arc<dyn Model>,
    /// Joint coordinates, then the pressures of each cylinder.
    readings: Vec<f64>,
    sticks: Vec<f64>,
    /// m
    command: Vec<f64>,
    going: Option<Going>,
    history: History,
    began: f64,
    /// Since the beginning, s.
    time: f64,
    period: f64,
}

impl ControllerPart {
    /// # Errors
    /// What is wrong with the machine or the settings.
    pub fn open(resources: &Resources) -> Result<Self, String> {
        let settings = &resources.settings;
        let name = settings.controller.clone().ok_or("resources/fmu.json names no controller; export the FMU again")?;
        let template = Template::of_text(&resources.machine, MACHINE).map_err(|error| error.to_string())?;
        let machine = template.build(&[]).map_err(|error| error.to_string())?;
        let model = build(&machine).map_err(|error| format!("{MACHINE}: {error}"))?;
        let mut all = gains(&machine, &name);
        all.extend(parameters(&machine, &settings.parameters)?);
        let mut part = ControllerPart {
            period: model.controller(&name)?.period(),
            template,
            monitor: settings.monitor,
            token: settings.token.clone(),
            variables: Vec::new(),
            parameters: all,
            stale: false,
            readings: first_readings(model.as_ref()),
            sticks: vec![0.0; if name == LEVER { machine.cylinders.len() } else { machine.tip_axes().len() }],
            command: vec![0.0; machine.cylinders.len()],
            model,
            name,
            going: None,
            history: History::new(0),
            began: 0.0,
            time: 0.0,
        };
        part.history = part.no_history();
        part.variables = part.described();
        Ok(part)
    }

    fn described(&self) -> Vec<Variable> {
        let (machine, layout) = (self.model.machine(), self.model.layout());
        let mut all = vec![Variable::time()];
        for (i, signal) in Sensors::ideal(self.model.as_ref()).signals().enumerate() {
            let state = layout.names.iter().position(|name| name == signal);
            let unit = state.map_or("", |state| layout.units[state]);
            let text = format!("{signal} as its sensor reads it; NaN: no reading");
            let reading = Variable::new(&format!("measured.{signal}"), Kind::Reading(i), Use::Input, unit, text);
            all.push(reading.starting(self.readings[i]));
        }
        for i in 0..self.sticks.len() {
            let axis = if self.name == LEVER { machine.cylinders[i].name.as_str() } else { machine.tip_axes()[i] };
            let text = format!("deflection of the stick {axis}");
            let stick = Variable::new(&format!("stick.{axis}"), Kind::Stick(i), Use::Input, "", text);
            all.push(stick.starting(0.0).within([-1.0, 1.0]));
        }
        for (i, parameter) in self.parameters.iter().enumerate() {
            all.push(Variable { usage: Use::Fixed, ..parameter.variable(i) });
        }
        for (c, cylinder) in machine.cylinders.iter().enumerate() {
            let text = format!("{} spool command, positive extends", cylinder.name);
            let name = format!("cylinder.{}.command", cylinder.name);
            all.push(Variable::new(&name, Kind::Command(c), Use::Output, "m", text).about(cylinder.valve.stroke));
        }
        if self.name != LEVER {
            for i in self.model.tip_axes() {
                let axis = ["x", "y", "z"][*i];
                let text = format!("where the controller wants the tip, {axis}");
                all.push(Variable::new(&format!("set_point.{axis}"), Kind::SetPoint(*i), Use::Output, "m", text));
            }
        }
        all
    }

    fn no_history(&self) -> History {
        History::new(self.inputs().width())
    }

    fn inputs(&self) -> Inputs {
        Inputs {
            token: self.token.clone(),
            parameters: self.parameters.iter().map(|parameter| parameter.value).collect(),
            readings: self.readings.clone(),
            sticks: self.sticks.clone(),
            began: self.began,
            time: self.time,
        }
    }

    /// Takes all values of `inputs` over.
    fn take_over(&mut self, inputs: Inputs) {
        for (parameter, value) in self.parameters.iter_mut().zip(inputs.parameters) {
            self.stale |= parameter.value != value;
            parameter.value = value;
        }
        (self.readings, self.sticks) = (inputs.readings, inputs.sticks);
        (self.began, self.time) = (inputs.began, inputs.time);
    }

    /// Begins anew and takes these samples, of time, readings and sticks.
    fn repeat(&mut self, samples: &[Vec<f64>]) -> Result<(), Fault> {
        (self.going, self.history) = (None, self.no_history());
        self.command.fill(0.0);
        let (readings, sticks) = (self.readings.clone(), self.sticks.clone());
        for sample in samples {
            let (values, sticks) = sample[1..].split_at(readings.len());
            self.readings.copy_from_slice(values);
            self.sticks.copy_from_slice(sticks);
            self.sample(sample[0])?;
        }
        (self.readings, self.sticks) = (readings, sticks);
        Ok(())
    }

    fn measured(&self) -> (Vec<f64>, Vec<[f64; 2]>) {
        let (q, p) = self.readings.split_at(self.model.layout().joints());
        (q.to_vec(), p.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect())
    }

    /// Builds the machine again if parameters have changed.
    fn refresh(&mut self) -> Result<(), Fault> {
        if self.stale {
            let machine = self.template.build(&overrides(&self.parameters)).map_err(|error| error.to_string())?;
            self.model = build(&machine).map_err(|error| format!("{MACHINE}: {error}"))?;
            self.stale = false;
        }
        Ok(())
    }

    /// The controller, which begins with the first sample.
    fn begun(&mut self, first: &Measurement) -> Result<Going, Fault> {
        if let Some(going) = self.going.take() {
            return Ok(going);
        }
        self.refresh()?;
        let controller = self.model.controller(&self.name)?;
        let mut controller = if self.monitor { self.model.with_sensor_monitor(controller, 0.0) } else { controller };
        controller.reset(first);
        self.period = controller.period();
        Ok(Going { controller, samples: 0, fault: None })
    }

    /// A sample at time `t` (s); returns messages for the tool.
    fn sample(&mut self, t: f64) -> Result<Vec<String>, Fault> {
        self.history.push([t].iter().chain(&self.readings).chain(&self.sticks).copied());
        let (q, p) = self.measured();
        let measured = Measurement { t, q: &q, p: &p };
        let mut going = self.begun(&measured)?;
        let stick = match (self.name.as_str(), self.sticks.as_slice()) {
            (LEVER, levers) => Stick::Lever(levers),
            (_, axes) => Stick::Tip(axes),
        };
        let answer = going.controller.step(&measured, stick, &mut self.command);
        let fault = answer.err().map(|fault| format!("the spools are centred: {fault}"));
        if fault.is_some() {
            self.command.fill(0.0);
        }
        let mut news: Vec<String> = going.controller.notices().into_iter().map(|news| news.text).collect();
        news.extend(fault.clone().filter(|_| fault != going.fault));
        (going.fault, going.samples) = (fault, going.samples + 1);
        self.going = Some(going);
        Ok(news)
    }

    /// Time of the next sample since the beginning, s.
    fn due(&self) -> f64 {
        self.going.as_ref().map_or(0.0, |going| going.samples as f64 * self.period)
    }

    fn set_point(&self, axis: usize) -> f64 {
        let wanted = self.going.as_ref().and_then(|going| going.controller.set_point_in_space());
        let (q, _) = self.measured();
        wanted.unwrap_or_else(|| self.model.tip(&q))[axis]
    }
}

/// Gains of a controller, including defaults.
fn gains(machine: &Machine, controller: &str) -> Vec<Parameter> {
    let own = tip_gains(machine).filter(|_| controller == "tip");
    own.map(|(name, unit, value)| {
        let key = format!("control.tip.{name}");
        Parameter { key, element: None, unit: unit.to_string(), value, start: value }
    })
    .collect()
}

/// Sensor readings at rest in the middle of all ranges.
fn first_readings(model: &dyn Model) -> Vec<f64> {
    let middle: Vec<f64> = model.joint_limits().iter().map(|limits| 0.5 * (limits.lower + limits.upper)).collect();
    let (layout, payload) = (model.layout(), model.machine().payload.mass);
    let rest = model.equilibrium(&middle, EquilibriumMode::Hold, payload);
    let pressures = (0..middle.len()).flat_map(|c| [layout.p1(c), layout.p2(c)]);
    let pressures = pressures.map(|i| rest.as_ref().map_or(0.0, |x| x[i]));
    middle.iter().copied().chain(pressures).collect()
}

impl Part for ControllerPart {
    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn exchanges(&self) -> bool {
        false
    }

    fn period(&self) -> Option<f64> {
        Some(self.period)
    }

    fn reset(&mut self) {
        self.stale |= self.parameters.iter().any(|parameter| parameter.value != parameter.start);
        self.parameters.iter_mut().for_each(|parameter| parameter.value = parameter.start);
        for variable in &self.variables {
            if let (Kind::Reading(i), Some(start)) = (variable.kind, variable.start) {
                self.readings[i] = start;
            }
        }
        self.sticks.fill(0.0);
        self.command.fill(0.0);
        (self.going, self.history) = (None, self.no_history());
        (self.began, self.time) = (0.0, 0.0);
    }

    fn get(&mut self, kind: Kind) -> Result<f64, Fault> {
        Ok(match kind {
            Kind::Time => self.time(),
            Kind::Command(c) => self.command[c],
            Kind::Stick(i) => self.sticks[i],
            Kind::Reading(i) => self.readings[i],
            Kind::Parameter(i) => self.parameters[i].value,
            Kind::SetPoint(axis) => self.set_point(axis),
            _ => return Err("a controller has no such variable".to_string().into()),
        })
    }

    fn set(&mut self, kind: Kind, value: f64) -> Result<(), Fault> {
        if !value.is_finite() && !matches!(kind, Kind::Reading(_)) {
            return Err(format!("the value must be a finite number, not {value}").into());
        }
        match kind {
            Kind::Reading(i) => self.readings[i] = value,
            Kind::Stick(i) => self.sticks[i] = value.clamp(-1.0, 1.0),
            Kind::Parameter(i) => {
                self.stale |= self.parameters[i].value != value;
                self.parameters[i].value = value;
            }
            _ => return Err("this variable is computed and cannot be set".to_string().into()),
        }
        Ok(())
    }

    fn begin(&mut self, start: f64) -> Result<Vec<String>, Fault> {
        self.began = start;
        self.refresh()?;
        self.period = self.model.controller(&self.name)?.period();
        Ok(Vec::new())
    }

    /// Samples that are due before the end of the step see the inputs as they are; the first is due at the beginning.
    fn step(&mut self, duration: f64) -> Result<Vec<String>, Fault> {
        let (end, early) = (self.time + duration, ROUNDING * self.period);
        let mut news = Vec::new();
        while self.due() < end - early {
            let due = self.due();
            // A sample at the beginning of the step has the time that the plant has there, to the last bit.
            let now = if (due - self.time).abs() <= early { self.time } else { due };
            news.extend(self.sample(now)?);
        }
        self.time = end;
        Ok(news)
    }

    fn time(&self) -> f64 {
        self.began + self.time
    }

    fn keep(&mut self) -> Result<Kept, Fault> {
        Ok(Kept::Controller(Box::new(ControllerState {
            inputs: self.inputs(),
            command: self.command.clone(),
            going: self.going.as_ref().map(Going::copied).transpose()?,
            history: self.history.clone(),
        })))
    }

    fn put_back(&mut self, state: &Kept) -> Result<(), Fault> {
        match state {
            Kept::Controller(state) if state.inputs.token == self.token => {
                self.take_over(state.inputs.clone());
                self.command.clone_from(&state.command);
                self.going = state.going.as_ref().map(Going::copied).transpose()?;
                self.history = state.history.clone();
            }
            Kept::Controller(_) => return Err(NO_STATE.to_string().into()),
            Kept::Bytes(bytes) => {
                let (inputs, samples) = self.inputs().read(bytes)?;
                self.take_over(inputs);
                self.repeat(&samples)?;
            }
        }
        self.refresh()?;
        self.period = match &self.going {
            Some(going) => going.controller.period(),
            None => self.model.controller(&self.name)?.period(),
        };
        Ok(())
    }
}
