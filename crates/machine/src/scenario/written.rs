//! A scenario as the text of a file; reading it gives the same scenario.

use super::closed_loop::{ControllerChoice, Joystick, SensorQuality, StickMode};
use super::sensor_fault::{measured, FaultKind};
use super::{Burst, Goal, Interpolation, Pressures, Scenario, SupplyPressure};
use crate::keys::TIP_AXES;
use crate::model::Machine;
use crate::sections::coordinate;
use crate::text::merge::OverrideValue;
use crate::text::toml_text::{key, list, quantity, quoted, written};
use std::fmt::Write;

/// A scenario that a file cannot state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unwritable(pub String);

type Result = std::result::Result<(), Unwritable>;

impl Scenario {
    /// The scenario as a file. Numbers have all their digits. `machines` are those of its stages, which have the units
    /// of numeric overrides.
    ///
    /// # Errors
    /// A user-defined controller, or another machine as the controller model, which a file cannot state.
    pub fn to_toml(&self, machines: &[&Machine]) -> std::result::Result<String, Unwritable> {
        let mut writer = Writer { text: String::new(), machines };
        writer.head(self);
        writer.overrides("overrides", &self.overrides);
        writer.start(self);
        writer.payload(&self.load.changes);
        for command in &self.commands {
            let _ = write!(
                writer.text,
                "\n[command.{}]\ntime = {}\nspool = {}\ninterpolation = {}\n",
                key(&command.cylinder),
                list(&command.time, "s"),
                list(&command.spool, "m"),
                quoted(interpolation(command.interpolation))
            );
        }
        writer.supply(self.supply.as_ref());
        writer.goals(&self.goals)?;
        writer.control("", self.controller.as_ref(), self.joystick.as_ref(), &self.cylinders)?;
        for (i, phase) in self.phases.iter().enumerate() {
            let name = if phase.name.is_empty() { (i + 1).to_string() } else { phase.name.clone() };
            let table = format!("phase.{}", key(&name));
            let _ = write!(writer.text, "\n[{table}]\ntime = {}\n", quantity(phase.time, "s"));
            writer.overrides(&format!("{table}.overrides"), &phase.overrides);
            writer.control(
                &format!("{table}."),
                phase.controller.as_ref(),
                phase.joystick.as_ref(),
                &self.cylinders,
            )?;
        }
        writer.bursts(&self.faults.bursts);
        writer.faults(self);
        writer.solver(self);
        Ok(writer.text)
    }
}

struct Writer<'a> {
    text: String,
    machines: &'a [&'a Machine],
}

impl Writer<'_> {
    fn head(&mut self, scenario: &Scenario) {
        let _ = write!(
            self.text,
            "[scenario]\nname = {}\ntitle = {}\nmachine = {}\nduration = {}\nrecord-interval = {}\n",
            quoted(&scenario.name),
            quoted(&scenario.title),
            quoted(&scenario.machine),
            quantity(scenario.duration, "s"),
            quantity(scenario.record_interval, "s"),
        );
        self.optional("payload", scenario.load.payload, "kg");
        let _ = writeln!(self.text, "seed = {}", scenario.seed);
        if let Some(version) = &scenario.recorded.by {
            let _ = writeln!(self.text, "recorded-by = {}", quoted(version));
        }
        if let Some(contents) = &scenario.recorded.on {
            let _ = writeln!(self.text, "recorded-on = {}", quoted(contents));
        }
    }

    fn optional(&mut self, name: &str, value: Option<f64>, unit: &str) {
        if let Some(value) = value {
            let _ = writeln!(self.text, "{name} = {}", quantity(value, unit));
        }
    }

    fn overrides(&mut self, table: &str, overrides: &[(String, OverrideValue)]) {
        if overrides.is_empty() {
            return;
        }
        let _ = write!(self.text, "\n[{table}]\n");
        for (name, value) in overrides {
            let mut recorded = self.machines.iter().flat_map(|machine| machine.provenance.iter());
            let units = recorded.find(|entry| entry.key == *name).map_or(&[][..], |entry| &entry.value.units);
            let _ = writeln!(self.text, "{} = {}", quoted(name), written(value, units));
        }
    }

    fn start(&mut self, scenario: &Scenario) {
        if let Pressures::Equilibrium = scenario.initial.pressures {
            self.text.push_str("\n[initial]\npressures = \"equilibrium\"\n");
        }
        if !scenario.initial.joints.is_empty() {
            self.text.push_str("\n[initial.joint]\n");
        }
        for (name, q) in &scenario.initial.joints {
            let mut joints = self.machines.iter().flat_map(|machine| &machine.joints);
            let unit =
                joints.find(|joint| joint.name == *name).map_or("rad".into(), |joint| coordinate(&joint.kind).unit);
            let _ = writeln!(self.text, "{} = {}", key(name), quantity(*q, &unit));
        }
        if let Pressures::Explicit(pressures) = &scenario.initial.pressures {
            self.text.push_str("\n[initial.pressure]\n");
            for (name, pair) in pressures {
                let _ = writeln!(self.text, "{} = {}", key(name), list(pair, "Pa"));
            }
        }
    }

    fn payload(&mut self, changes: &[(f64, f64)]) {
        if !changes.is_empty() {
            let (times, masses): (Vec<f64>, Vec<f64>) = changes.iter().copied().unzip();
            let _ = write!(self.text, "\n[payload]\ntime = {}\nmass = {}\n", list(&times, "s"), list(&masses, "kg"));
        }
    }

    fn supply(&mut self, supply: Option<&SupplyPressure>) {
        let Some(SupplyPressure { time, pressure, interpolation: kind }) = supply else { return };
        let (time, pressure, kind) = (list(time, "s"), list(pressure, "Pa"), quoted(interpolation(*kind)));
        let _ = write!(self.text, "\n[supply]\ntime = {time}\npressure = {pressure}\ninterpolation = {kind}\n");
    }

    fn goals(&mut self, goals: &[Goal]) -> Result {
        if goals.is_empty() {
            return Ok(());
        }
        let times: Vec<f64> = goals.iter().map(|goal| goal.time).collect();
        let [x, z] = [0, 1].map(|axis| goals.iter().map(|goal| goal.place[axis]).collect::<Vec<_>>());
        let (times, x, z) = (list(&times, "s"), list(&x, "m"), list(&z, "m"));
        let _ = write!(self.text, "\n[goal]\ntime = {times}\nx = {x}\nz = {z}\n");
        let speeds: Vec<f64> = goals.iter().filter_map(|goal| goal.speed).collect();
        if speeds.len() == goals.len() {
            let _ = writeln!(self.text, "speed = {}", list(&speeds, "m/s"));
        } else if !speeds.is_empty() {
            let message = "a file states the speed of every goal or of none; give each goal a speed";
            return Err(Unwritable(message.into()));
        }
        let dropped: Vec<f64> = goals.iter().filter_map(|goal| goal.until).collect();
        if !dropped.is_empty() {
            let _ = writeln!(self.text, "drop = {}", list(&dropped, "s"));
        }
        Ok(())
    }

    fn control(
        &mut self,
        table: &str,
        choice: Option<&ControllerChoice>,
        stick: Option<&Joystick>,
        cylinders: &[String],
    ) -> Result {
        if let Some(choice) = choice {
            self.controller(table, choice)?;
        }
        if let Some(stick) = stick {
            self.joystick(table, stick, cylinders);
        }
        Ok(())
    }

    fn controller(&mut self, table: &str, choice: &ControllerChoice) -> Result {
        if choice.own.is_some() {
            let message = "a file cannot hold your own controller; name one of the package, or keep the script";
            return Err(Unwritable(message.into()));
        }
        if choice.other_model.is_some() {
            let message = "a file cannot hold another machine as the controller model; state it as overrides";
            return Err(Unwritable(message.into()));
        }
        let sensors = if choice.sensors == SensorQuality::Ideal { "ideal" } else { "data-sheet" };
        let _ = write!(self.text, "\n[{table}controller]\nname = {}\n", quoted(&choice.name));
        self.optional("period", choice.period, "s");
        let _ = write!(self.text, "delay = {}\nsensors = \"{sensors}\"\n", quantity(choice.delay, "s"));
        if let Some(on) = choice.monitor {
            let _ = writeln!(self.text, "monitor = \"{}\"", if on { "on" } else { "off" });
        }
        self.overrides(&format!("{table}controller.model"), &choice.model);
        Ok(())
    }

    fn joystick(&mut self, table: &str, stick: &Joystick, cylinders: &[String]) {
        let tip = stick.mode == StickMode::Tip;
        let _ = write!(self.text, "\n[{table}joystick]\nmode = \"{}\"\n", stick.mode.name());
        let _ = writeln!(self.text, "interpolation = {}", quoted(interpolation(stick.interpolation)));
        let _ = writeln!(self.text, "dead-zone = {:?}", stick.dead_zone);
        self.optional("full-speed", stick.full_speed, "m/s");
        let _ = writeln!(self.text, "ramp = {}", quantity(stick.ramp, "s"));
        if let Some(log) = &stick.log {
            let _ = writeln!(self.text, "log = {}", quoted(log));
            return;
        }
        let _ = writeln!(self.text, "time = {}", list(&stick.time, "s"));
        let names: Vec<&str> = if tip { TIP_AXES.to_vec() } else { cylinders.iter().map(String::as_str).collect() };
        for (name, axis) in names.iter().zip(&stick.axes) {
            let _ = writeln!(self.text, "{} = {}", key(name), list(axis, ""));
        }
        if !stick.precision.is_empty() {
            let _ = writeln!(self.text, "precision = {}", list(&stick.precision, ""));
        }
    }

    fn faults(&mut self, scenario: &Scenario) {
        let Some(choice) = &scenario.first_controller() else { return };
        for (i, fault) in scenario.faults.sensors.iter().enumerate() {
            let _ = write!(self.text, "\n[sensor-fault.{}]\nsignal = {}\n", i + 1, quoted(&fault.signal));
            let (kind, size) = match fault.kind {
                FaultKind::Freeze => ("freeze", None),
                FaultKind::Jump(size) => ("jump", Some(size)),
                FaultKind::DropOut => ("drop-out", None),
            };
            let _ = write!(self.text, "kind = \"{kind}\"\nfrom = {}\n", quantity(fault.from, "s"));
            self.optional("until", fault.until, "s");
            let signals = self.machines.first().map(|machine| measured(machine, choice)).unwrap_or_default();
            let known = signals.iter().find(|(signal, _)| *signal == fault.signal);
            self.optional("size", size, known.map_or("", |(_, quantity)| &quantity.unit));
        }
    }

    fn bursts(&mut self, bursts: &[Burst]) {
        for (i, burst) in bursts.iter().enumerate() {
            let (cylinder, side) = (quoted(&burst.cylinder), quoted(burst.side.name()));
            let (time, opening) = (quantity(burst.time, "s"), quantity(burst.opening, "m^2"));
            let _ = write!(
                self.text,
                "\n[burst.{}]\ncylinder = {cylinder}\nside = {side}\ntime = {time}\nopening = {opening}\n",
                i + 1
            );
        }
    }

    fn solver(&mut self, scenario: &Scenario) {
        let solver = &scenario.solver;
        let _ = write!(self.text, "\n[solver]\nmethod = {}\nrtol = {:?}\n", quoted(&solver.method), solver.rtol);
        self.optional("atol", solver.atol, "");
        let _ = writeln!(self.text, "max-step = {}", quantity(solver.max_step, "s"));
        self.optional("step", solver.step, "s");
    }
}

fn interpolation(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Hold => "hold",
        Interpolation::Linear => "linear",
    }
}
