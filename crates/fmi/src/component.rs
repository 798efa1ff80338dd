//! One instance of an FMU, with the common part of FMI 2.0 and 3.0: modes, values, steps, states, messages.

use hydrocrane_fmu::{open, Fault, Kept, Kind, Part, Resources, Use, NO_STATE};
use std::ffi::{c_int, c_void, CString};
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::path::Path;

/// Results of functions, of both versions of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
}

/// Mode of the instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    Instantiated,
    Initialising,
    Event,
    Continuous,
    Stepping,
    Terminated,
}

impl Mode {
    const ALL: [Mode; 6] =
        [Mode::Instantiated, Mode::Initialising, Mode::Event, Mode::Continuous, Mode::Stepping, Mode::Terminated];

    fn name(self) -> &'static str {
        match self {
            Mode::Instantiated => "instantiated",
            Mode::Initialising => "in initialization mode",
            Mode::Event => "in event mode",
            Mode::Continuous => "in continuous-time mode",
            Mode::Stepping => "in step mode",
            Mode::Terminated => "terminated",
        }
    }
}

/// Whether a tool steps the instance or integrates it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    ModelExchange,
    CoSimulation,
}

/// A state of an instance that a tool keeps.
pub struct State {
    mode: Mode,
    /// s
    start: f64,
    part: Kept,
}

impl State {
    fn head(&self) -> [u8; 9] {
        let mut head = [self.mode as u8; 9];
        head[1..].copy_from_slice(&self.start.to_le_bytes());
        head
    }

    /// Number of its bytes. Tools ask for it before each [`Self::bytes`].
    pub fn length(&self) -> Result<usize, Problem> {
        Ok(self.head().len() + self.part.length()?)
    }

    pub fn bytes(&self) -> Result<Vec<u8>, Problem> {
        Ok([&self.head()[..], &self.part.bytes()?].concat())
    }

    pub fn of_bytes(bytes: &[u8]) -> Result<Self, Problem> {
        let damaged = || Problem::from(NO_STATE.to_string());
        let (head, rest) = bytes.split_first_chunk::<1>().ok_or_else(damaged)?;
        let (start, part) = rest.split_first_chunk::<8>().ok_or_else(damaged)?;
        let mode = Mode::ALL.get(usize::from(head[0])).copied().ok_or_else(damaged)?;
        Ok(State { mode, start: f64::from_le_bytes(*start), part: Kept::Bytes(part.to_vec()) })
    }
}

/// Sends a message to the tool.
pub type Logger = Box<dyn Fn(Status, &CString, &CString)>;

pub struct Component {
    part: Box<dyn Part>,
    interface: Interface,
    logger: Logger,
    /// Whether informative messages are wanted too.
    pub chatty: bool,
    mode: Mode,
    /// After a panic the instance is unusable.
    broken: bool,
    start: f64,
}

/// A problem with its status.
pub struct Problem(pub Status, pub String);

impl From<String> for Problem {
    fn from(text: String) -> Self {
        Problem(Status::Error, text)
    }
}

impl From<Fault> for Problem {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Wrong(text) => Problem(Status::Error, text),
            Fault::Impossible(text) => Problem(Status::Discard, text),
        }
    }
}

/// Longest step, s: nobody waits for a longer one.
const LONGEST_STEP: f64 = 86_400.0;

pub type Done = Result<Status, Problem>;

/// Calls `f` on the instance. A problem becomes a status and a message, and so does a panic, after which the instance
/// refuses all calls.
///
/// # Safety
/// `instance` is null or what [`instantiate`] gave, and not freed.
pub unsafe fn call(instance: *mut c_void, function: &str, f: impl FnOnce(&mut Component) -> Done) -> c_int {
    let Some(component) = instance.cast::<Component>().as_mut() else { return Status::Error as c_int };
    if component.broken {
        return Status::Fatal as c_int;
    }
    let Problem(status, text) = match catch_unwind(AssertUnwindSafe(|| f(component))) {
        Ok(Ok(status)) => return status as c_int,
        Ok(Err(problem)) => problem,
        Err(panic) => {
            component.broken = true;
            Problem(Status::Fatal, format!("a defect of hydrocrane, please report it: {}", panic_text(panic.as_ref())))
        }
    };
    component.tell(status, &format!("{function}: {text}"));
    status as c_int
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_string())).unwrap_or_default()
}

fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// An instance of the FMU whose files lie in the folder `resources`; null if they are unusable; the log has the reason.
pub fn instantiate(resources: &Path, token: &str, interface: Interface, logger: Logger, chatty: bool) -> *mut c_void {
    let made =
        catch_unwind(|| {
            let resources = Resources::read(resources)?;
            if resources.settings.token != token {
                let (own, asked) = (&resources.settings.token, token);
                return Err(format!(
                    "modelDescription.xml ({asked}) and resources ({own}) are of two exports; unzip one FMU as it is"
                ));
            }
            let part = open(&resources).map_err(|error| format!("the machine of this FMU is damaged: {error}"))?;
            match interface == Interface::CoSimulation || part.exchanges() {
                true => Ok(part),
                false => Err("this FMU is for co-simulation only: a delay, a sampled sensor or a controller is in it"
                    .to_string()),
            }
        });
    let made = made.unwrap_or_else(|panic| {
        Err(format!("a defect of hydrocrane, please report it: {}", panic_text(panic.as_ref())))
    });
    match made {
        Ok(part) => {
            let mode = Mode::Instantiated;
            let component = Component { part, interface, logger, chatty, mode, broken: false, start: 0.0 };
            Box::into_raw(Box::new(component)).cast()
        }
        Err(text) => {
            logger(Status::Error, &c_text("logStatusError"), &c_text(&text));
            std::ptr::null_mut()
        }
    }
}

/// # Safety
/// As [`call`]; the instance is of no use afterwards.
pub unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        drop(Box::from_raw(instance.cast::<Component>()));
    }
}

impl Component {
    pub fn tell(&self, status: Status, text: &str) {
        let category = match status {
            Status::Ok => "logAll",
            Status::Warning => "logStatusWarning",
            Status::Discard => "logStatusDiscard",
            Status::Error => "logStatusError",
            Status::Fatal => "logStatusFatal",
        };
        (self.logger)(status, &c_text(category), &c_text(text));
    }

    /// Refuses calls that the present mode does not allow.
    fn require(&self, modes: &[Mode]) -> Result<(), Problem> {
        if modes.contains(&self.mode) {
            return Ok(());
        }
        let names: Vec<&str> = modes.iter().map(|mode| mode.name()).collect();
        Err(format!("the instance is {}; this is for one that is {}", self.mode.name(), names.join(" or ")).into())
    }

    fn go(&mut self, from: &[Mode], to: Mode) -> Done {
        self.require(from)?;
        self.mode = to;
        Ok(Status::Ok)
    }

    /// Sets the time at which the simulation begins, s.
    pub fn set_up(&mut self, start: f64) -> Done {
        self.require(&[Mode::Instantiated])?;
        if !start.is_finite() {
            return Err(format!("the simulation cannot begin at time {start}").into());
        }
        self.start = start;
        Ok(Status::Ok)
    }

    pub fn enter_initialisation(&mut self) -> Done {
        self.go(&[Mode::Instantiated], Mode::Initialising)
    }

    pub fn exit_initialisation(&mut self) -> Done {
        self.require(&[Mode::Initialising])?;
        let mut doubts = self.part.begin(self.start)?;
        self.mode = match self.interface {
            Interface::CoSimulation => Mode::Stepping,
            Interface::ModelExchange => {
                doubts.extend(self.part.exchange()?);
                Mode::Event
            }
        };
        Ok(self.warned(&doubts))
    }

    pub fn enter_events(&mut self) -> Done {
        if self.interface == Interface::CoSimulation {
            return Err("events are for model exchange; in co-simulation values are set between steps"
                .to_string()
                .into());
        }
        self.go(&[Mode::Event, Mode::Continuous], Mode::Event)
    }

    pub fn enter_continuous(&mut self) -> Done {
        self.go(&[Mode::Event, Mode::Continuous], Mode::Continuous)
    }

    pub fn terminate(&mut self) -> Done {
        self.go(&[Mode::Event, Mode::Continuous, Mode::Stepping], Mode::Terminated)
    }

    pub fn reset(&mut self) -> Done {
        self.part.reset();
        (self.mode, self.start) = (Mode::Instantiated, 0.0);
        Ok(Status::Ok)
    }

    fn variable(&self, reference: u32) -> Result<(Kind, Use, String), Problem> {
        let variables = self.part.variables();
        let found =
            variables.get(reference as usize).map(|variable| (variable.kind, variable.usage, variable.name.clone()));
        found.ok_or_else(|| {
            format!("there is no variable {reference}: value references go from 0 to {}", variables.len() - 1).into()
        })
    }

    pub fn get(&mut self, references: &[u32], values: &mut [f64]) -> Done {
        same(references.len(), values.len())?;
        for (reference, value) in references.iter().zip(values) {
            let kind = self.kind(*reference)?;
            *value = self.part.get(kind)?;
        }
        Ok(Status::Ok)
    }

    fn kind(&self, reference: u32) -> Result<Kind, Problem> {
        match self.part.variables().get(reference as usize) {
            Some(variable) => Ok(variable.kind),
            None => self.variable(reference).map(|(kind, ..)| kind),
        }
    }

    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Done {
        same(references.len(), values.len())?;
        for (reference, value) in references.iter().zip(values) {
            let Some(variable) = self.part.variables().get(*reference as usize) else {
                return self.variable(*reference).map(|_| Status::Ok);
            };
            let (kind, usage) = (variable.kind, variable.usage);
            if let Some(why) = self.refused(usage) {
                let (.., name) = self.variable(*reference)?;
                return Err(format!("`{name}` {why}").into());
            }
            if let Err(fault) = self.part.set(kind, *value) {
                let (.., name) = self.variable(*reference)?;
                let Problem(status, text) = fault.into();
                return Err(Problem(status, format!("`{name}`: {text}")));
            }
        }
        Ok(Status::Ok)
    }

    /// The reason if a variable cannot be set now.
    fn refused(&self, usage: Use) -> Option<&'static str> {
        let before = matches!(self.mode, Mode::Instantiated | Mode::Initialising);
        match usage {
            Use::Input => None,
            Use::Fixed if before => None,
            Use::Fixed => Some("is fixed once the initialization has ended"),
            Use::Tunable if self.mode == Mode::Continuous => Some("can be set at an event, not while time goes on"),
            Use::Tunable => None,
            Use::Output | Use::Local | Use::Independent => Some("is computed and cannot be set"),
        }
    }

    /// Refuses references to variables of a type that the FMU does not have.
    pub fn none_of_type(&self, count: usize, kind: &str) -> Done {
        match count {
            0 => Ok(Status::Ok),
            _ => Err(format!("no variable of this FMU is a {kind}; all are floating-point numbers of 64 bits").into()),
        }
    }

    /// Steps from time `now` by `duration`, s.
    pub fn step(&mut self, now: f64, duration: f64) -> Done {
        self.require(&[Mode::Stepping])?;
        if !(duration.is_finite() && duration >= 0.0) {
            return Err(format!("a step of {duration} s; it must be zero or more").into());
        }
        if duration > LONGEST_STEP {
            return Err(format!("a step of {duration} s; ask for steps of at most {LONGEST_STEP} s, a day").into());
        }
        let own = self.part.time();
        // Tools sum up steps with different rounding. Also false for NaN.
        let together = (now - own).abs() <= 1e-9 * own.abs().max(1.0) + 1e-6 * duration;
        if !together {
            return Err(
                format!("a step from {now} s was asked for, and the FMU is at {own} s; go on from there").into()
            );
        }
        if duration == 0.0 {
            return Ok(Status::Ok);
        }
        let news = self.part.step(duration)?;
        Ok(self.warned(&news))
    }

    /// Sends the warnings of the simulation.
    fn warned(&self, news: &[String]) -> Status {
        news.iter().for_each(|text| self.tell(Status::Warning, text));
        if news.is_empty() {
            Status::Ok
        } else {
            Status::Warning
        }
    }

    /// s
    pub fn time(&self) -> f64 {
        self.part.time()
    }

    pub fn set_time(&mut self, time: f64) -> Done {
        self.require(&[Mode::Event, Mode::Continuous])?;
        if !time.is_finite() {
            return Err(format!("time {time} s is no finite number").into());
        }
        self.part.set_time(time);
        Ok(Status::Ok)
    }

    /// Whether the states jumped.
    pub fn update(&mut self) -> Result<bool, Problem> {
        self.require(&[Mode::Initialising, Mode::Event])?;
        Ok(self.part.update()?)
    }

    pub fn states(&mut self, states: &mut [f64]) -> Done {
        filled(states, &self.part.states()?)
    }

    pub fn set_states(&mut self, states: &[f64]) -> Done {
        self.require(&[Mode::Event, Mode::Continuous])?;
        self.part.set_states(states)?;
        Ok(Status::Ok)
    }

    pub fn rates(&mut self, rates: &mut [f64]) -> Done {
        filled(rates, &self.part.rates()?)
    }

    pub fn nominals(&mut self, nominals: &mut [f64]) -> Done {
        filled(nominals, &self.part.nominals())
    }

    pub fn state_count(&self) -> usize {
        self.part.nominals().len()
    }

    pub fn directional(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64], sensitivity: &mut [f64]) -> Done {
        same(knowns.len(), seed.len())?;
        same(unknowns.len(), sensitivity.len())?;
        let unknowns = unknowns.iter().map(|unknown| self.kind(*unknown)).collect::<Result<Vec<_>, _>>()?;
        let knowns = knowns.iter().map(|known| self.kind(*known)).collect::<Result<Vec<_>, _>>()?;
        let along: Vec<(Kind, f64)> = knowns.into_iter().zip(seed.iter().copied()).collect();
        sensitivity.copy_from_slice(&self.part.directional(&unknowns, &along)?);
        Ok(Status::Ok)
    }

    /// The changing state of the instance.
    pub fn keep(&mut self) -> Result<State, Problem> {
        Ok(State { mode: self.mode, start: self.start, part: self.part.keep()? })
    }

    pub fn put_back(&mut self, state: &State) -> Done {
        self.part.put_back(&state.part)?;
        (self.mode, self.start) = (state.mode, state.start);
        Ok(Status::Ok)
    }
}

fn same(references: usize, values: usize) -> Result<(), Problem> {
    match references == values {
        true => Ok(()),
        false => Err(format!("{values} values for {references} variables").into()),
    }
}

fn filled(room: &mut [f64], values: &[f64]) -> Done {
    same(values.len(), room.len())?;
    room.copy_from_slice(values);
    Ok(Status::Ok)
}
