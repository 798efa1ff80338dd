//! `[supply]`, `[pump.<name>]` and `[mains]`: the oil supply.

use crate::errors::{ErrorKind, MachineError};
use crate::model::{
    Compensator, Engine, LoadSensing, Machine, Mains, PressureControl, Pump, Supply, Valve, MOST_PUMPS,
};
use crate::number::Number;
use crate::reading::reader::Reader;
use crate::sections::{accumulator, required_table, Result};
use crate::units::quantities::{Kind, PER_TURN, VOLUME};
use std::f64::consts::TAU;

/// Share of its nominal flow that a valve takes at full stroke at least: nobody buys one twice as large as its circuit.
const HALF: f64 = 0.5;
/// Default ratio of relief pressure to supply pressure.
const RELIEF: f64 = 1.15;

#[derive(Debug, Clone, Copy, PartialEq)]
enum PumpKind {
    ConstantPressure,
    Fixed,
    PressureCompensated,
    LoadSensing,
}

impl PumpKind {
    const ALL: [PumpKind; 4] =
        [PumpKind::ConstantPressure, PumpKind::Fixed, PumpKind::PressureCompensated, PumpKind::LoadSensing];

    /// Keys that a pump of this kind does not have, and the kind that has them.
    fn superfluous(self) -> (&'static [&'static str], &'static str) {
        match self {
            PumpKind::ConstantPressure => (
                &[
                    "displacement",
                    "speed",
                    "rated-speed",
                    "droop",
                    "rated-torque",
                    "volumetric-efficiency",
                    "hydromechanical-efficiency",
                    "control-range",
                    "time-constant",
                    "torque-limit",
                    "ls-margin",
                    "ls-time-constant",
                ],
                "pressure-compensated",
            ),
            PumpKind::Fixed => (&["control-range", "time-constant", "torque-limit"], "pressure-compensated"),
            PumpKind::PressureCompensated => (&["ls-margin", "ls-time-constant"], "load-sensing"),
            PumpKind::LoadSensing => (&[], ""),
        }
    }
}

pub fn read<T: Number>(root: &Reader) -> Result<Supply<T>> {
    let table = required_table(root, "supply")?;
    let mut supply: Supply<T> = Supply {
        pressure: table.quantity("pressure")?,
        rated: table.required("pressure", "a pressure")?.quantity_of_file()?,
        tank_pressure: table.quantity("tank-pressure")?,
        measured: table.choice_or_default("measured", &[true, false])?,
        mains: None,
    };
    if supply.pressure.plain() < supply.tank_pressure.plain() {
        return Err(table
            .error(ErrorKind::OutOfRange, "pressure", "the supply pressure lies below the tank pressure")
            .help("raise `pressure` or lower `tank-pressure`"));
    }
    supply.mains = mains(root, &supply)?;
    if supply.measured && supply.mains.is_some() {
        let message = "the pump determines the pressure, so a measured pressure cannot be prescribed";
        return Err(table.error(ErrorKind::ConflictingKeys, "measured", message).help(
            "leave the measured pressure of the supply out of the scenario, or take the machine without its pump",
        ));
    }
    Ok(supply)
}

/// Refuses flow sharing without a load-sensing line; warns of a small pump or a small margin.
pub fn check<T: Number>(root: &Reader, machine: &Machine<T>) -> Result<()> {
    let mut valves = machine.cylinders.iter().map(|cylinder| &cylinder.valve);
    let mains = machine.supply.mains.as_ref();
    let senses = mains.is_some_and(|mains| mains.load_sensing.is_some());
    if let Some(valve) = valves.find(|valve| matches!(valve.compensator, Compensator::Behind)).filter(|_| !senses) {
        let message = format!("`{}`: compensated behind the spool, but no pump senses the load", valve.name);
        return Err(root
            .error(ErrorKind::ConflictingKeys, "valve", message)
            .help("use a [pump.<name>] of type \"load-sensing\", or a \"fixed\" one with `ls-margin`"));
    }
    let Some(mains) = mains else { return Ok(()) };
    check_margin(root, machine, mains)?;
    check_drops(root, machine, mains)?;
    check_size(root, machine, mains)
}

/// Warns if one section takes more than the pump gives.
fn check_size<T: Number>(root: &Reader, machine: &Machine<T>, mains: &Mains<T>) -> Result<()> {
    let [free, given] = [false, true].map(|limited| given(&machine.supply, mains, limited));
    let asked = machine.cylinders.iter().map(|c| (asked(machine, &c.valve), &c.valve.name));
    let Some((most, valve)) = asked.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(most, _)| *most > given) else {
        return Ok(());
    };
    let [idle, free, given, asked] = [mains.pumps().map(idle).sum(), free, given, most].map(|flow: f64| 60e3 * flow);
    let pressure = machine.supply.pressure.plain() / 1e5;
    let limited =
        mains.pumps().find(|pump| pump.control.as_ref().is_some_and(|control| control.torque_limit.is_some()));
    if let Some(pump) = limited.filter(|_| asked <= free) {
        pump_table(root, &pump.name)?.required("torque-limit", "a torque")?.warn(
            format!(
                "small: at {pressure:.0} bar it leaves {given:.1} of {free:.1} l/min, and valve `{valve}` alone takes {asked:.1} l/min at full stroke"
            ),
            "check its unit, use a larger one, or expect the mains pressure to fall".into(),
        );
        return Ok(());
    }
    pump_table(root, &mains.pump.name)?.required("displacement", "a volume")?.warn(
        format!(
            "small: it gives {idle:.1} l/min without a load and {given:.1} l/min at {pressure:.0} bar, and valve `{valve}` alone takes {asked:.1} l/min at full stroke"
        ),
        "use a larger one, or expect the mains pressure to fall".into(),
    );
    Ok(())
}

/// Flow of a pump at full displacement without a load, m^3/s.
fn idle<T: Number>(pump: &Pump<T>) -> f64 {
    pump.displacement.plain() / TAU * pump.speed.plain()
}

/// Flow of all pumps at the supply pressure and, where they are `limited`, the displacement that their torque limits leave, m^3/s: the
/// least that they give.
pub fn given<T: Number>(supply: &Supply<T>, mains: &Mains<T>, limited: bool) -> f64 {
    mains.pumps().map(|pump| given_by(supply, pump, limited)).sum()
}

fn given_by<T: Number>(supply: &Supply<T>, pump: &Pump<T>, limited: bool) -> f64 {
    let rise = supply.pressure.plain() - supply.tank_pressure.plain();
    let (full, mechanical_loss) =
        (pump.displacement.plain() / TAU * rise, 1.0 / pump.hydromechanical_efficiency.plain() - 1.0);
    let limit = pump.control.as_ref().and_then(|control| control.torque_limit.as_ref()).filter(|_| limited);
    let share = limit.map_or(1.0, |limit| (limit.plain() / full - mechanical_loss).clamp(0.0, 1.0));
    // Speed loss of an engine at the supply pressure.
    let lost = pump
        .engine
        .as_ref()
        .map_or(0.0, |of| of.droop.plain() * full * (share + mechanical_loss) / of.rated_torque.plain());
    let leaking = (1.0 - pump.volumetric_efficiency.plain()) * pump.rated_speed.plain() / pump.speed.plain();
    idle(pump) * (share * (1.0 - lost.min(1.0)) - leaking).max(0.0)
}

/// Flow that a section takes at full stroke, m^3/s. Its compensator leaves the edge its setting; without one the supply pressure falls
/// over both edges, if there is no load.
pub fn asked<T: Number>(machine: &Machine<T>, valve: &Valve<T>) -> f64 {
    let sensing = machine.supply.mains.as_ref().and_then(|mains| mains.load_sensing.as_ref());
    let drop = match (&valve.compensator, sensing) {
        (Compensator::Before(setting), _) => setting.plain(),
        (Compensator::Behind, Some(sensing)) => sensing.margin.plain(),
        _ => 0.5 * (machine.supply.pressure.plain() - machine.supply.tank_pressure.plain()),
    };
    valve.feed_at(drop)
}

/// Warns if a compensator needs the whole margin.
fn check_margin<T: Number>(root: &Reader, machine: &Machine<T>, mains: &Mains<T>) -> Result<()> {
    let Some(sensing) = &mains.load_sensing else { return Ok(()) };
    // At full displacement the margin of a controlled pump is smaller.
    let left = sensing.margin.plain() - control_range(mains);
    for valve in machine.cylinders.iter().map(|cylinder| &cylinder.valve) {
        let Compensator::Before(setting) = valve.compensator else { continue };
        if setting.plain() > left {
            let (left, setting) = (left / 1e5, setting.plain() / 1e5);
            let least = |pump: &&Pump<T>| pump.margin.is_some_and(|margin| margin.plain() == sensing.margin.plain());
            let pump = mains.pumps().find(least).unwrap_or(&mains.pump);
            pump_table(root, &pump.name)?.required("ls-margin", "a pressure")?.warn(
                format!("small: it leaves {left:.1} bar at full displacement, and the compensator of valve `{}` takes {setting:.1} bar", valve.name),
                "raise it, lower `control-range`, or expect this section to be slow at high pump flow".into(),
            );
        }
    }
    Ok(())
}

/// Warns if what feeds an edge leaves a section half of its nominal flow or less: of all sections, the margin is named, of some, the nominal
/// drops.
fn check_drops<T: Number>(root: &Reader, machine: &Machine<T>, mains: &Mains<T>) -> Result<()> {
    let Some(sensing) = &mains.load_sensing else { return Ok(()) };
    let margin = sensing.margin.plain();
    let over = |valve: &Valve<T>| match &valve.compensator {
        Compensator::Before(setting) => setting.plain(),
        _ => margin,
    };
    let small = |valve: &&Valve<T>| libm::sqrt(over(valve) / valve.edge_pressure_drop.plain()) <= HALF;
    let valves = || machine.cylinders.iter().map(|cylinder| &cylinder.valve);
    let words = |valve: &Valve<T>| {
        let [over, nominal] = [over(valve), valve.edge_pressure_drop.plain()].map(|of| of / 1e5);
        let share = 100.0 * libm::sqrt(over / nominal);
        format!("over an edge there are {over:.1} bar, and the nominal flow of valve `{}` needs {nominal:.1} bar: at full stroke it takes {share:.0} % of it", valve.name)
    };
    let cure = "check the units of `ls-margin`, `compensator-setting` and the nominal drop: bar or MPa?";
    let own = |valve: &&Valve<T>| matches!(valve.compensator, Compensator::Before(_));
    if let Some(valve) = valves().next().filter(|_| valves().all(|valve| small(&valve) && !own(&valve))) {
        let of_pump = pump_table(root, &mains.pump.name)?;
        of_pump.required("ls-margin", "a pressure")?.warn(format!("small: {}", words(valve)), cure.into());
        return Ok(());
    }
    let tables = root.named_tables("valve")?;
    for valve in valves().filter(small) {
        let Some((_, table)) = tables.iter().find(|(name, _)| *name == valve.name) else { continue };
        let drop = ["nominal-edge-pressure-drop", "nominal-pressure-drop"].into_iter().find(|key| table.has(key));
        if let Some(key) = drop.filter(|_| !table.is_doubted()) {
            table.required(key, "a pressure")?.warn(format!("large: {}", words(valve)), cure.into());
        }
    }
    Ok(())
}

/// Fall of the mains at which all pumps are at full displacement, Pa.
pub fn control_range<T: Number>(mains: &Mains<T>) -> f64 {
    let ranges = mains.pumps().filter_map(|pump| pump.control.as_ref());
    ranges.map(|control| control.range.plain()).fold(0.0, f64::max)
}

fn pump_table<'a>(root: &Reader<'a>, pump: &str) -> Result<Reader<'a>> {
    let tables = root.named_tables("pump")?;
    let own = tables.into_iter().find(|(name, _)| *name == pump);
    Ok(own.expect("the table that the pump was read from").1)
}

fn mains<T: Number>(root: &Reader, supply: &Supply<T>) -> Result<Option<Mains<T>>> {
    let table = root.table("mains")?;
    match (pumps(root, supply)?, table) {
        (None, None) => accumulator::refuse_without_mains(root),
        (Some(_), None) => Err(root.missing("mains", "add the table [mains] with the `volume` of the lines")),
        (None, Some(_)) => Err(root
            .error(ErrorKind::ConflictingKeys, "mains", "a pump must determine its pressure, but there is none")
            .help("add a [pump.<name>] of type \"fixed\" or \"pressure-compensated\", or omit [mains]")),
        (Some(_), Some(_)) if supply.pressure.plain() == supply.tank_pressure.plain() => {
            let message = "the supply pressure equals the tank pressure: its pump has nothing to do";
            Err(root.error(ErrorKind::OutOfRange, "supply", message).help("raise `supply.pressure`"))
        }
        (Some((pumps, load_sensing)), Some(table)) => {
            let mains = lines(&table, supply, pumps, load_sensing)?;
            Ok(Some(Mains { accumulator: accumulator::read(root, supply, &mains)?, ..mains }))
        }
    }
}

fn lines<T: Number>(
    table: &Reader,
    supply: &Supply<T>,
    mut pumps: Vec<Pump<T>>,
    load_sensing: Option<LoadSensing<T>>,
) -> Result<Mains<T>> {
    let pump = pumps.remove(0);
    let default = supply.pressure * if pump.control.is_some() { RELIEF } else { 1.0 };
    let mains = Mains {
        volume: table.quantity("volume")?,
        compliance: table.quantity_or_default("hose-compliance")?,
        relief_pressure: table.optional_quantity("relief-pressure")?.unwrap_or(default),
        relief_gradient: table.quantity_or_default("relief-gradient")?,
        pump,
        further: pumps,
        load_sensing,
        accumulator: None,
        tank_line: None,
        priority: None,
    };
    if mains.pump.control.is_none() || mains.relief_pressure.plain() > supply.pressure.plain() {
        return Ok(mains);
    }
    Err(table
        .error(
            ErrorKind::OutOfRange,
            "relief-pressure",
            "the relief valve opens before the pump reduces its displacement",
        )
        .help("set it some 10 to 20 % above `supply.pressure`"))
}

/// All pumps, and the load-sensing line that they feel; `None` without a pump, or with an ideal one.
type Pumps<T> = (Vec<Pump<T>>, Option<LoadSensing<T>>);

fn pumps<T: Number>(root: &Reader, supply: &Supply<T>) -> Result<Option<Pumps<T>>> {
    let tables = root.named_tables("pump")?;
    let Some((first, others)) = tables.split_first() else { return Ok(None) };
    if tables.len() > MOST_PUMPS {
        let message = format!("{} pumps: the mains have {MOST_PUMPS} at most", tables.len());
        return Err(root.error(ErrorKind::TooLarge, "pump", message).help("join the smallest ones in one"));
    }
    let Some(pump_of_first) = pump(first.0, &first.1, supply)? else {
        return match others.first() {
            Some((name, table)) => {
                Err(unlike(table, "type", name, first.0, "a supply at constant pressure needs no other pump"))
            }
            None => Ok(None),
        };
    };
    let (kind, sensing) = (first.1.text("type")?, load_sensing::<T>(&first.1)?);
    let mut pumps = vec![pump_of_first];
    for (name, table) in others {
        let own = pump(name, table, supply)?.filter(|_| table.text("type").is_ok_and(|own| own == kind));
        let Some(own) = own else {
            return Err(unlike(table, "type", name, first.0, "pumps that feed the same mains are of one type"));
        };
        let line = load_sensing::<T>(table)?;
        let differs = |of: fn(&LoadSensing<T>) -> f64| line.as_ref().map(of) != sensing.as_ref().map(of);
        if line.is_some() != sensing.is_some() {
            return Err(unlike(
                table,
                "ls-margin",
                name,
                first.0,
                "all pumps that feed the same mains follow the load, or none",
            ));
        }
        if differs(|of| of.time_constant.plain()) {
            let message = "pumps that feed the same mains feel one load-sensing line";
            return Err(unlike(table, "ls-time-constant", name, first.0, message));
        }
        if own.control.is_none() && differs(|of| of.margin.plain()) {
            return Err(unlike(table, "ls-margin", name, first.0, "one valve unloads all fixed pumps"));
        }
        pumps.push(own);
    }
    let sensing = sensing.map(|of| LoadSensing { margin: least_margin(&pumps).unwrap_or(of.margin), ..of });
    Ok(Some((pumps, sensing)))
}

/// The least of the pumps' margins; each of several equal ones has its share in it.
fn least_margin<T: Number>(pumps: &[Pump<T>]) -> Option<T> {
    let margins = || pumps.iter().filter_map(|pump| pump.margin);
    let least = margins().map(|margin| margin.plain()).fold(f64::INFINITY, f64::min);
    let equal = || margins().filter(|margin| margin.plain() == least);
    let sum = equal().reduce(|sum, margin| sum + margin)?;
    Some(sum / equal().count() as f64)
}

/// A pump that does not fit beside the first one.
fn unlike(table: &Reader, key: &str, name: &str, first: &str, message: &str) -> MachineError {
    table
        .error(ErrorKind::ConflictingKeys, key, format!("pump `{name}` differs from pump `{first}`: {message}"))
        .help(format!("state the same `{key}` in both, or leave one pump out"))
}

/// `None`: an ideal one.
fn pump<T: Number>(name: &str, table: &Reader, supply: &Supply<T>) -> Result<Option<Pump<T>>> {
    let kind = table.choice("type", &PumpKind::ALL)?;
    let (superfluous, other) = kind.superfluous();
    if let Some(key) = superfluous.iter().find(|key| table.has(key)) {
        let kind = table.text("type")?;
        return Err(table
            .error(ErrorKind::ConflictingKeys, key, format!("a pump of type `{kind}` has none"))
            .help(format!("omit it, or choose type \"{other}\"")));
    }
    if kind == PumpKind::LoadSensing && !table.has("ls-margin") {
        return Err(table
            .missing("ls-margin", "give the pressure that the pump keeps above the load pressure, some 15 to 30 bar"));
    }
    if kind == PumpKind::ConstantPressure {
        return Ok(None);
    }
    let control = (kind != PumpKind::Fixed).then(|| control(table, supply)).transpose()?;
    Ok(Some(Pump {
        name: name.into(),
        displacement: displacement(table)?,
        speed: table.quantity("speed")?,
        rated_speed: match table.optional_quantity("rated-speed")? {
            Some(rated) => rated,
            None => T::c(table.required("speed", "a speed")?.quantity_of_file()?),
        },
        engine: engine(table)?,
        volumetric_efficiency: efficiency(table, "volumetric-efficiency")?,
        hydromechanical_efficiency: efficiency(table, "hydromechanical-efficiency")?,
        control,
        margin: load_sensing(table)?.map(|of| of.margin),
    }))
}

/// Per revolution, which the unit may state, m^3.
pub fn displacement<T: Number>(table: &Reader) -> Result<T> {
    let [volume, per_turn] = [VOLUME, PER_TURN].map(Kind::quantity);
    table.required("displacement", &volume.example())?.quantity_or(&volume, &per_turn, TAU)
}

/// `None`: the pump does not follow the load.
fn load_sensing<T: Number>(table: &Reader) -> Result<Option<LoadSensing<T>>> {
    let Some(margin) = table.optional_quantity("ls-margin")? else {
        return match table.has("ls-time-constant") {
            true => Err(table
                .error(
                    ErrorKind::ConflictingKeys,
                    "ls-time-constant",
                    "there is no load-sensing line without `ls-margin`",
                )
                .help("give `ls-margin`, or omit it")),
            false => Ok(None),
        };
    };
    Ok(Some(LoadSensing { margin, time_constant: table.quantity_or_default("ls-time-constant")? }))
}

/// `None`: the speed is constant.
fn engine<T: Number>(table: &Reader) -> Result<Option<Engine<T>>> {
    let Some(droop) = table.optional_quantity::<T>("droop")? else {
        return match table.has("rated-torque") {
            true => Err(table
                .error(ErrorKind::ConflictingKeys, "rated-torque", "counts for nothing without `droop`")
                .help("give `droop`, the share of the speed that is lost at this torque, or leave it out")),
            false => Ok(None),
        };
    };
    if droop.plain() >= 1.0 {
        let message = "the engine would stand still at its rated torque";
        return Err(table.error(ErrorKind::OutOfRange, "droop", message).help("give a share: 0.05, or \"5 %\""));
    }
    Ok(Some(Engine { droop, rated_torque: table.quantity("rated-torque")? }))
}

fn control<T: Number>(table: &Reader, supply: &Supply<T>) -> Result<PressureControl<T>> {
    let control: PressureControl<T> = PressureControl {
        range: table.quantity_or_default("control-range")?,
        time_constant: table.quantity_or_default("time-constant")?,
        torque_limit: table.optional_quantity("torque-limit")?,
    };
    if control.range.plain() < supply.pressure.plain() {
        return Ok(control);
    }
    Err(table
        .error(ErrorKind::OutOfRange, "control-range", "not below the supply pressure")
        .help("data sheets state some 2 to 15 bar"))
}

fn efficiency<T: Number>(table: &Reader, key: &str) -> Result<T> {
    let efficiency: T = table.quantity(key)?;
    if efficiency.plain() <= 1.0 {
        return Ok(efficiency);
    }
    Err(table.error(ErrorKind::OutOfRange, key, "exceeds 1").help("give a share: 0.95, or \"95 %\""))
}
