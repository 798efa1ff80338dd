//! Pump, load sensing, mains and relief valve: the laws of `physics`, from the state of the supply and what the valves draw to its rates.

use crate::cylinders::hydraulic_axis::SupplyPressures;
use hydrocrane_num::{root, Real};
use hydrocrane_physics::hydraulics::accumulator::Accumulator;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::load_sensing::{self, LoadSensing};
use hydrocrane_physics::hydraulics::mains::Mains;
use hydrocrane_physics::hydraulics::pump::{PressureControl, Pump};
use hydrocrane_physics::hydraulics::relief_valve::ReliefValve;
use hydrocrane_physics::hydraulics::tank_line::{Return, TankLine};

/// Largest number of pumps that feed the mains.
pub const MAX_PUMPS: usize = hydrocrane_machine::model::MOST_PUMPS;

/// Shares of the displacements of all pumps in use.
pub type Shares<T> = [T; MAX_PUMPS];

/// A pump with what turns its swivel.
#[derive(Debug, Clone, Copy)]
pub struct ControlledPump<T> {
    pub pump: Pump<T>,
    /// `None`: the displacement is fixed. All pumps of a supply have one, or none has.
    pub control: Option<PressureControl<T>>,
    /// Over the pressure of the load-sensing line, Pa; counts with a control only. `None`: the pump does not follow the load.
    pub margin: Option<T>,
}

/// A supply whose pressure follows from what flows in and out.
#[derive(Debug, Clone, Copy)]
pub struct Supply<T> {
    /// From the first place on; there is at least one.
    pub pumps: [Option<ControlledPump<T>>; MAX_PUMPS],
    /// What the pumps keep at most, Pa.
    pub highest: T,
    /// With the least margin of the pumps. `None`: the pressure does not follow the load. With a fixed pump, the relief valve unloads it.
    pub sensing: Option<LoadSensing<T>>,
    pub mains: Mains<T>,
    pub relief: ReliefValve<T>,
    pub accumulator: Option<Accumulator<T>>,
    /// `None`: what returns is at the pressure of the tank.
    pub tank_line: Option<TankLine<T>>,
}

/// What happens in the supply at one state.
#[derive(Debug, Clone, Copy)]
pub struct SupplyRates<T> {
    /// Of the pressure of the mains, Pa/s, and of the shares of the displacements, 1/s.
    pub pressure_rate: T,
    pub swivel_rates: Shares<T>,
    /// Of the pressure of the load-sensing line, Pa/s.
    pub load_rate: T,
    /// Of the pressure of the tank line, Pa/s.
    pub tank_rate: T,
    /// Flows of the pumps into the mains and of the relief valve out of them, m^3/s.
    pub pump_flow: T,
    pub relief_flow: T,
}

impl<T: Copy> Supply<T> {
    /// The same with `f` of every number.
    pub fn map<'a, U>(&'a self, f: &mut dyn FnMut(&'a T) -> U) -> Supply<U> {
        Supply {
            pumps: self.pumps.each_ref().map(|of| {
                of.as_ref().map(|of| ControlledPump {
                    pump: of.pump.map(f),
                    control: of.control.as_ref().map(|control| control.map(f)),
                    margin: of.margin.as_ref().map(&mut *f),
                })
            }),
            highest: f(&self.highest),
            sensing: self.sensing.as_ref().map(|sensing| sensing.map(f)),
            mains: self.mains.map(f),
            relief: self.relief.map(f),
            accumulator: self.accumulator.as_ref().map(|accumulator| accumulator.map(f)),
            tank_line: self.tank_line.as_ref().map(|line| line.map(f)),
        }
    }
}

/// What the valves ask of the supply.
#[derive(Debug, Clone, Copy)]
pub struct Demand<T> {
    /// Flow that they draw, m^3/s.
    pub drawn: T,
    /// Highest pressure that they give to the load-sensing line, Pa.
    pub signal: T,
    /// Flow that they and the cylinders' leakage return, m^3/s; counts with a tank line only.
    pub returned: T,
}

/// Rounds after which the speed of an engine under its load is found: each leaves less than a hundredth of what was missing.
const ENGINE_ROUNDS: usize = 8;

impl<T: Real> Supply<T> {
    /// At the `pressures`, with the shares `e` of the displacements.
    #[inline(always)]
    pub fn rates(
        &self,
        fluid: &Fluid<T>,
        pressures: &SupplyPressures<T>,
        e: &Shares<T>,
        Demand { drawn, signal, returned }: Demand<T>,
    ) -> SupplyRates<T> {
        let SupplyPressures { supply, load, tank } = *pressures;
        let reservoir = self.reservoir(tank);
        let zero = T::c(0.0);
        let (mut pump_flow, mut swivel_rates) = (zero, [zero; MAX_PUMPS]);
        for (of, (rate, e)) in self.pumps().zip(swivel_rates.iter_mut().zip(e)) {
            pump_flow += of.pump.flow(*e, supply - reservoir);
            if let Some(control) = &of.control {
                *rate = control.swivel_rate(&of.pump, *e, supply, self.setting(of, load), reservoir);
            }
        }
        let relief_flow = self.relief(load).flow(supply);
        let stiffness = self.stiffness(fluid.bulk_modulus(supply), supply);
        SupplyRates {
            pressure_rate: stiffness * (pump_flow - relief_flow - drawn),
            swivel_rates,
            load_rate: match &self.sensing {
                Some(sensing) => sensing.rate(signal, load),
                None => zero,
            },
            tank_rate: match &self.tank_line {
                Some(line) => {
                    let stiffness = line.volume.stiffness(fluid.bulk_modulus(tank), tank);
                    stiffness * (returned + relief_flow - line.flow(tank).whole)
                }
                None => zero,
            },
            pump_flow,
            relief_flow,
        }
    }

    /// What the pumps give at the `pressures` once their swivels have settled, and what the relief valve takes of it, m^3/s.
    pub fn given(&self, pressures: &SupplyPressures<T>) -> (T, T) {
        let SupplyPressures { supply, load, tank } = *pressures;
        let shares = self.settled_shares(pressures);
        let mut given = T::c(0.0);
        self.pumps().zip(shares).for_each(|(of, e)| given += of.pump.flow(e, supply - self.reservoir(tank)));
        (given, self.relief(load).flow(supply))
    }

    /// The shares of the displacements that are asked for at the `pressures`.
    pub fn settled_shares(&self, pressures: &SupplyPressures<T>) -> Shares<T> {
        let SupplyPressures { supply, load, tank } = *pressures;
        let mut shares = [T::c(1.0); MAX_PUMPS];
        for (of, share) in self.pumps().zip(&mut shares) {
            if let Some(control) = &of.control {
                *share = control.wanted(&of.pump, supply, self.setting(of, load), self.reservoir(tank));
            }
        }
        shares
    }

    /// Its pumps, in the order of their shares.
    #[inline(always)]
    pub fn pumps(&self) -> impl Iterator<Item = &ControlledPump<T>> {
        self.pumps.iter().flatten()
    }

    /// Whether the pumps turn their swivels.
    #[inline(always)]
    fn swivels(&self) -> bool {
        self.pumps().any(|of| of.control.is_some())
    }

    /// Pressure of the tank that the pump draws from, Pa, where what returns is at the pressure `tank` (Pa).
    #[inline(always)]
    pub fn reservoir(&self, tank: T) -> T {
        self.tank_line.as_ref().map_or(tank, |line| line.tank)
    }

    /// What leaves the tank line at its pressure `tank` (Pa); `None` without one.
    pub fn into_tank(&self, tank: T) -> Option<Return<T>> {
        self.tank_line.as_ref().map(|line| line.flow(tank))
    }

    /// Rise of the pressure of the mains `p` (Pa) per volume that flows in, Pa/m^3, with the oil's bulk modulus (Pa).
    #[inline(always)]
    fn stiffness(&self, bulk: T, p: T) -> T {
        match &self.accumulator {
            Some(accumulator) => accumulator.with_mains(&self.mains, p).stiffness(bulk, p),
            None => self.mains.stiffness(bulk, p),
        }
    }

    /// Energy of the oil and the hoses of mains and tank line and of the gas, J, from the oil's `energy_density` (J/m^3) by pressure (Pa).
    pub fn stored(&self, energy_density: impl Fn(T) -> T, pressures: &SupplyPressures<T>) -> T {
        let SupplyPressures { supply, tank, .. } = *pressures;
        let mains = self.stored_in_mains(energy_density(supply), supply);
        self.tank_line.as_ref().map_or(mains, |line| mains + line.volume.energy(energy_density(tank), tank))
    }

    fn stored_in_mains(&self, energy_density: T, p: T) -> T {
        match &self.accumulator {
            Some(accumulator) => {
                self.mains.energy(energy_density, p) + accumulator.oil(p) * energy_density + accumulator.energy(p)
            }
            None => self.mains.energy(energy_density, p),
        }
    }

    /// What a pump keeps at zero displacement, Pa, at the pressure `load` (Pa) of the load-sensing line.
    #[inline(always)]
    fn setting(&self, pump: &ControlledPump<T>, load: T) -> T {
        match pump.margin {
            Some(margin) => load_sensing::setting(self.highest, load, margin),
            None => self.highest,
        }
    }

    /// Whether anything but the relief valve keeps the pressure of the mains.
    pub fn is_controlled(&self) -> bool {
        self.swivels() || self.sensing.is_some()
    }

    /// The highest pressure that a pump keeps at zero displacement, or a fixed one is unloaded at, and what the mains lack at the shares
    /// `e` of the displacements, Pa. Above zero the pumps give all they can and cannot keep the pressure, or have yet to swivel out.
    pub fn setting_and_shortfall(&self, pressures: &SupplyPressures<T>, e: &Shares<T>) -> (T, T) {
        let SupplyPressures { supply, load, .. } = *pressures;
        if !self.swivels() {
            let set = self.relief(load).pressure;
            return (set, set - supply);
        }
        // The pump that has most left says what the mains lack.
        let (mut highest, mut lacks) = (T::c(f64::NEG_INFINITY), T::c(f64::INFINITY));
        for (of, e) in self.pumps().zip(e) {
            let range = of.control.as_ref().map_or(T::c(0.0), |control| control.range);
            let set = self.setting(of, load);
            (highest, lacks) = (highest.max(set), lacks.min(set - *e * range - supply));
        }
        (highest, lacks)
    }

    /// The relief valve; that of a fixed pump opens where the load asks for no more.
    #[inline(always)]
    fn relief(&self, load: T) -> ReliefValve<T> {
        match &self.sensing {
            Some(sensing) if !self.swivels() => {
                ReliefValve { pressure: sensing.setting(self.relief.pressure, load), ..self.relief }
            }
            _ => self.relief,
        }
    }

    /// A pressure of the mains, Pa, at which the pumps give no more than the relief valve and their own leakage take.
    pub fn ceiling(&self) -> T {
        let mut full = T::c(0.0);
        self.full_flows(&[T::c(0.0); MAX_PUMPS], T::c(0.0)).iter().for_each(|flow| full += *flow);
        let ReliefValve { pressure, gradient } = self.relief;
        self.highest.max(pressure + pressure - self.relief.tight_to() + full / gradient)
    }

    /// Pressure of the mains and shares of the displacements at rest, with the load-sensing line at the pressure `load` and what returns
    /// at `tank` (Pa), where the valves draw `drawn` (m^3/s).
    pub fn at_rest(&self, tank: T, load: T, drawn: T) -> (T, Shares<T>) {
        let (idle, reservoir) = (T::c(0.0), self.reservoir(tank));
        let mut found = self.at_rest_with(&self.full_flows(&[idle; MAX_PUMPS], idle), [tank, load], drawn);
        for _ in 0..ENGINE_ROUNDS {
            let (p, e) = found;
            found = self.at_rest_with(&self.full_flows(&e, p - reservoir), [tank, load], drawn);
        }
        found
    }

    /// Pressure of the tank line at rest, Pa; `None` without one.
    pub fn tank_line_at_rest(&self, pressures: &SupplyPressures<T>, returned: T) -> Option<T> {
        let relieved = self.relief(pressures.load).flow(pressures.supply);
        self.tank_line.as_ref().map(|line| line.at_rest(returned + relieved))
    }

    /// Flows at full displacement without losses, m^3/s, at the pressure `rise` (Pa); zero where there is no pump.
    fn full_flows(&self, e: &Shares<T>, rise: T) -> Shares<T> {
        let mut full = [T::c(0.0); MAX_PUMPS];
        for (of, (full, e)) in self.pumps().zip(full.iter_mut().zip(e)) {
            *full = of.pump.full_flow(*e, rise);
        }
        full
    }

    /// The same while the pumps give `full` (m^3/s) at full displacement: all laws are linear then.
    fn at_rest_with(&self, full: &Shares<T>, [tank, load]: [T; 2], drawn: T) -> (T, Shares<T>) {
        let (zero, mut shares) = (T::c(0.0), [T::c(1.0); MAX_PUMPS]);
        let (mut leakage, mut sum) = (zero, zero);
        for (of, full) in self.pumps().zip(full) {
            leakage += of.pump.leakage;
            sum += *full;
        }
        let given = leakage * self.reservoir(tank) - drawn;
        if !self.swivels() {
            let ReliefValve { pressure, gradient } = self.relief(load);
            return ((sum + gradient * pressure + given) / (leakage + gradient), shares);
        }
        let mut highest = T::c(f64::NEG_INFINITY);
        self.pumps().for_each(|of| highest = highest.max(self.setting(of, load)));
        // A pump that keeps less than the others do rests at zero displacement.
        let gives = |set: T, p: T| p.lt(set) | highest.le(set);
        let mut p = T::c(f64::NEG_INFINITY);
        for _ in 0..MAX_PUMPS {
            let (mut steepness, mut kept) = (zero, zero);
            for (of, full) in self.pumps().zip(full) {
                if let Some(control) = &of.control {
                    let set = self.setting(of, load);
                    let steep = T::select(gives(set, p), *full / control.range, zero);
                    (steepness, kept) = (steepness + steep, kept + steep * set);
                }
            }
            p = (kept + given) / (leakage + steepness);
        }
        for (of, share) in self.pumps().zip(&mut shares) {
            let (set, range) = (self.setting(of, load), of.control.as_ref().map_or(T::c(1.0), |control| control.range));
            *share = T::select(gives(set, p), (set - p) / range, zero);
        }
        (p, shares)
    }
}

impl Supply<f64> {
    /// The highest pressure of the mains, Pa, that the pumps reach while nothing is drawn and the sections ask for all of it.
    pub fn reach(&self, tank: f64) -> f64 {
        let lacking = |supply: f64| {
            let (given, relieved) = self.given(&SupplyPressures { supply, load: self.highest, tank });
            relieved - given
        };
        root(tank, self.ceiling(), ROUNDING, lacking)
    }
}

/// Pressure that is rounding, Pa.
const ROUNDING: f64 = 1e-3;
