//! Derivatives of a cylinder's laws by narrow dual numbers: each law is differentiated only by the local numbers on which it
//! depends; the results are then expanded to all six.

use crate::cylinders::hydraulic_axis::{FrictionLaw, FrictionOutput, HydraulicAxis, LawOutputs, Port, SupplyPressures};

use crate::cylinders::in_chains::in_chains;
use crate::cylinders::local::{LocalState, StateRates};
use hydrocrane_num::{Dual, Real};
use hydrocrane_ode::Row;
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::end_stop::EndStop;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::parts::{AnyParts, Parts};
use hydrocrane_physics::hydraulics::spool::Spool;

/// A number with its derivatives by the local numbers of a cylinder, in the order of [`LocalState`].
pub type WithDerivatives<L> = Dual<L, 6>;
const X: usize = 0;
const V: usize = 1;
const P1: usize = 2;
const P2: usize = 3;
const SPOOL: usize = 4;
const Z: usize = 5;

/// A number of a port with its derivatives by v, p1, p2, spool and the pressures of mains and load-sensing line.
type CoupledPort<L> = Dual<L, 6>;

/// All but the first of these.
const AT_P1: usize = 1;
const AT_P2: usize = 2;
const AT_SPOOL: usize = 3;
const AT_MAINS: usize = 4;
const AT_LOAD: usize = 5;

/// Number of pressures that feed a valve: of mains and load-sensing line.
pub const FEEDING: usize = 2;

/// Those by the local numbers.
#[inline(always)]
fn by_states<L: Real>(number: CoupledPort<L>) -> WithDerivatives<L> {
    let [v, p1, p2, spool, ..] = number.derivative;
    Dual { value: number.value, derivative: [v, p1, p2, spool] }.among([V, P1, P2, SPOOL])
}

/// Those by the pressures of mains and load-sensing line.
#[inline(always)]
fn by_feeding<L: Real>(number: CoupledPort<L>) -> [L; 2] {
    [number.derivative[AT_MAINS], number.derivative[AT_LOAD]]
}

/// The opening of the compensator, if it follows late, as a constant.
#[inline(always)]
fn still<L: Real, const K: usize>(s: &LocalState<L>) -> Option<Dual<L, K>> {
    in_chains(s.opening).map(Dual::constant)
}

/// Below this speed the secant of friction is the one at this speed, m/s.
const CREEP: f64 = 1e-9;

/// Parameters of the laws, lifted to dual numbers with as many variables as each law depends on.
#[derive(Debug, Clone)]
pub struct Lifted<L> {
    chambers: Chambers<L>,
    bulk: Fluid<Dual<L, 1>>,
    friction: FrictionLaw<Dual<L, 2>>,
    end_stop: EndStop<Dual<L, 2>>,
    spool: Spool<Dual<L, 2>>,
    ports: HydraulicAxis<Dual<L, 3>>,
    single: HydraulicAxis<Dual<L, 1>>,
    whole: HydraulicAxis<WithDerivatives<L>>,
}

/// Kinematics of a piston: lever arm g, dg/dq and the rate of its joint.
#[derive(Debug, Clone, Copy)]
pub struct Piston<T> {
    pub lever_arm: T,
    pub lever_arm_derivative: T,
    pub rate: T,
}

impl<T: Real> Piston<T> {
    /// The chain rule from local numbers to states.
    #[inline(always)]
    pub fn row(&self, number: &WithDerivatives<T>) -> Row<T> {
        let d = &number.derivative;
        Row {
            q: d[X] * self.lever_arm + d[V] * self.lever_arm_derivative * self.rate,
            qd: d[V] * self.lever_arm,
            p1: d[P1],
            p2: d[P2],
            xs: d[SPOOL],
            z: d[Z],
        }
    }
}

/// Rates of a cylinder and their derivatives by states.
#[derive(Debug, Clone, Copy)]
pub struct RateDerivatives<L> {
    pub rates: StateRates<L>,
    pub p1: Row<L>,
    pub p2: Row<L>,
    pub z: Row<L>,
    pub force: Row<L>,
}

/// Derivatives of a cylinder on mains of variable pressure.
#[derive(Debug, Clone, Copy)]
pub struct SupplyDerivatives<L> {
    /// Signal of the valve to the load-sensing line, Pa.
    pub signal: L,
    /// Of the flow from the supply, and of that signal.
    pub drawn: Row<L>,
    pub by_signal: Row<L>,
    /// By the pressures of the mains and of the load-sensing line: of p1', p2', of the flow and of the signal.
    pub p1: [L; FEEDING],
    pub p2: [L; FEEDING],
    pub flow: [L; FEEDING],
    pub signal_by: [L; FEEDING],
}

/// Derivatives of a cylinder with a tank line.
#[derive(Debug, Clone, Copy)]
pub struct TankDerivatives<L> {
    /// By the pressure of the tank line: of p1', p2', of the flow from the supply, of the signal and of the flow that returns.
    pub p1: L,
    pub p2: L,
    pub flow: L,
    pub signal: L,
    pub returned: L,
    /// Of the flow that returns by the states, and by the pressures of mains and load-sensing line.
    pub by_states: Row<L>,
    pub by_feeding: [L; FEEDING],
}

/// Derivatives of a cylinder whose compensator follows late.
#[derive(Debug, Clone, Copy)]
pub struct OpeningDerivatives<L> {
    /// By the opening: of p1', p2', of the flow from the supply, of the signal and of the flow that returns.
    pub p1: L,
    pub p2: L,
    pub flow: L,
    pub signal: L,
    pub returned: L,
    /// Its rate, 1/s, and the derivatives of that by the states, by the pressures of mains and load-sensing line, by that of the tank line and by itself.
    pub rate: L,
    pub by_states: Row<L>,
    pub by_feeding: [L; FEEDING],
    pub by_tank: L,
    pub own: L,
}

/// Derivatives along one number: of p1', p2', of the flow from the supply, of the signal, of the flow that returns and of the rate of the
/// compensator's opening.
#[derive(Debug, Clone, Copy, Default)]
struct AlongOne<L> {
    p1: L,
    p2: L,
    flow: L,
    signal: L,
    returned: L,
    opening: L,
    /// The rate of the opening itself, 1/s.
    rate: L,
}

/// The local numbers as variables.
#[inline(always)]
fn variables<L: Real>(s: &LocalState<L>) -> LocalState<WithDerivatives<L>> {
    LocalState {
        x: Dual::variable(s.x, X),
        v: Dual::variable(s.v, V),
        p1: Dual::variable(s.p1, P1),
        p2: Dual::variable(s.p2, P2),
        spool: Dual::variable(s.spool, SPOOL),
        z: Dual::variable(s.z, Z),
        opening: still(s),
    }
}

impl<L: Real> Lifted<L> {
    pub fn new(unit: &HydraulicAxis<L>, fluid: &Fluid<L>) -> Self {
        Lifted {
            chambers: unit.chambers,
            bulk: fluid.map(&mut |number| Dual::constant(*number)),
            friction: unit.friction.map(&mut |number| Dual::constant(*number)),
            end_stop: unit.end_stop.map(&mut |number| Dual::constant(*number)),
            spool: unit.spool.map(&mut |number| Dual::constant(*number)),
            ports: unit.map(&mut |number| Dual::constant(*number)),
            single: unit.map(&mut |number| Dual::constant(*number)),
            whole: unit.map(&mut |number| Dual::constant(*number)),
        }
    }

    /// Every number that is read; `fed`: by a supply of variable pressure. Copies that nothing reads would cost a batch as much as the others.
    pub fn each<'a>(&'a self, fed: bool, f: &mut dyn FnMut(&'a L)) {
        self.bulk.map(&mut |number| f(&number.value));
        self.friction.map(&mut |number| f(&number.value));
        self.end_stop.map(&mut |number| f(&number.value));
        self.spool.map(&mut |number| f(&number.value));
        self.whole.chambers.map(&mut |number| f(&number.value));
        self.whole.leakage.map(&mut |number| f(&number.value));
        if fed {
            self.chambers.map(f);
        }
        if fed || self.single.compensator_lag().is_some() {
            self.single.map(&mut |number| f(&number.value));
        }
        if fed || self.whole.valve.couples_ports() {
            self.whole.each_at_ports(&mut |number| f(&number.value));
        }
        self.ports.each_at_ports(&mut |number| f(&number.value));
    }

    /// Rates and derivatives; `P` as in [`HydraulicAxis::rates`].
    #[inline(always)]
    pub fn derivatives<P: Parts>(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> RateDerivatives<L> {
        let outputs = self.outputs::<P>(supply_pressures, s, self.ports::<P>(supply_pressures, s));
        self.assembled::<P>(supply_pressures, s, piston, &outputs)
    }

    /// From the outputs of the laws.
    #[inline(always)]
    fn assembled<P: Parts>(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
        outputs: &LawOutputs<WithDerivatives<L>>,
    ) -> RateDerivatives<L> {
        let pressures = supply_pressures.map(&mut |number| Dual::constant(*number));
        let linearised = self.whole.assemble::<P>(&pressures, &variables(s), outputs);
        RateDerivatives {
            rates: linearised.of_states().map(|number| number.value),
            p1: piston.row(&linearised.p1_rate),
            p2: piston.row(&linearised.p2_rate),
            z: piston.row(&linearised.z_rate),
            force: piston.row(&linearised.force),
        }
    }

    /// The same on mains of variable pressure, with the derivatives of and by the supply.
    #[inline(always)]
    pub fn derivatives_on_mains(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> (RateDerivatives<L>, SupplyDerivatives<L>) {
        let ports = self.coupled_ports(supply_pressures, s);
        let [a, b] = &ports;
        let outputs = self.outputs::<AnyParts>(supply_pressures, s, [a.map(by_states), b.map(by_states)]);
        let bulk = (outputs.bulk.0.value, outputs.bulk.1.value);
        let by_supply = self.by_supply(supply_pressures, s, piston, &ports, bulk);
        (self.assembled::<AnyParts>(supply_pressures, s, piston, &outputs), by_supply)
    }

    /// Derivatives of and by the supply, with the bulk moduli of the oil in both chambers, Pa.
    #[inline(always)]
    fn by_supply(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
        [a, b]: &[Port<CoupledPort<L>>; 2],
        bulk: (L, L),
    ) -> SupplyDerivatives<L> {
        let signal = self.whole.valve.connection.signal(
            Dual::variable(s.spool, AT_SPOOL),
            [a.at_valve(), b.at_valve()],
            Dual::constant(supply_pressures.tank),
        );
        let (stiffness_1, stiffness_2) = self.chambers.stiffness::<AnyParts>(bulk, s.x, (s.p1, s.p2));
        let ([supply_1, load_1], [supply_2, load_2]) = (by_feeding(a.inflow()), by_feeding(b.inflow()));
        SupplyDerivatives {
            drawn: piston.row(&by_states(a.fed + b.fed)),
            signal: signal.value,
            by_signal: piston.row(&by_states(signal)),
            p1: [stiffness_1 * supply_1, stiffness_1 * load_1],
            p2: [stiffness_2 * supply_2, stiffness_2 * load_2],
            flow: by_feeding(a.fed + b.fed),
            signal_by: by_feeding(signal),
        }
    }

    /// Derivatives by the pressure of the tank line, and of what returns to it.
    #[inline(always)]
    pub fn by_tank(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        piston: &Piston<L>,
    ) -> TankDerivatives<L> {
        let [a, b] = self.coupled_ports(supply_pressures, s);
        let (_, leaked) = self.whole.leakage.flows(
            Dual::variable(s.p1, AT_P1),
            Dual::variable(s.p2, AT_P2),
            Dual::constant(supply_pressures.tank),
        );
        let returned = a.drained + b.drained + a.relieved + b.relieved + leaked;
        let SupplyPressures { supply, load, tank } = supply_pressures.map(&mut |number| Dual::constant(*number));
        let pressures = SupplyPressures { supply, load, tank: Dual::variable(tank.value, 0) };
        let by_line = self.along(&pressures, &s.map(Dual::constant));
        TankDerivatives {
            p1: by_line.p1,
            p2: by_line.p2,
            flow: by_line.flow,
            signal: by_line.signal,
            returned: by_line.returned,
            by_states: piston.row(&by_states(returned)),
            by_feeding: [returned.derivative[AT_MAINS], returned.derivative[AT_LOAD]],
        }
    }

    /// Derivatives of and by the `opening` of a compensator that follows late.
    #[inline(always)]
    pub fn by_opening(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        opening: L,
        piston: &Piston<L>,
    ) -> OpeningDerivatives<L> {
        // One variable after the other: few cylinders need this, and all of it at once would be long code.
        let numbers =
            [s.v, s.p1, s.p2, s.spool, opening, supply_pressures.supply, supply_pressures.load, supply_pressures.tank];
        let mut found = [AlongOne::default(); 8];
        for (variable, found) in found.iter_mut().enumerate() {
            let mut lifted = numbers.map(Dual::constant);
            lifted[variable].derivative[0] = L::c(1.0);
            let [v, p1, p2, spool, opening, supply, load, tank] = lifted;
            let local = LocalState { v, p1, p2, spool, opening: Some(opening), ..s.map(Dual::constant) };
            *found = self.along(&SupplyPressures { supply, load, tank }, &local);
        }
        let own = &found[4];
        let [v, p1, p2, spool, by_own, supply, load, tank] = found.map(|along| along.opening);
        let none = L::c(0.0);
        let derivative = [none, v, p1, p2, spool, none];
        OpeningDerivatives {
            p1: own.p1,
            p2: own.p2,
            flow: own.flow,
            signal: own.signal,
            returned: own.returned,
            rate: own.rate,
            by_states: piston.row(&Dual { value: none, derivative }),
            by_feeding: [supply, load],
            by_tank: tank,
            own: by_own,
        }
    }

    /// Derivatives along the one variable of `pressures` and `local`.
    #[inline(always)]
    fn along(&self, pressures: &SupplyPressures<Dual<L, 1>>, local: &LocalState<Dual<L, 1>>) -> AlongOne<L> {
        L::outlined(
            #[inline(always)]
            || {
                let rates = self.single.rates::<AnyParts>(&self.bulk, pressures, local);
                let at_valve = rates.at_valve();
                let signal = self.single.valve.connection.signal(local.spool, [at_valve.a, at_valve.b], pressures.tank);
                let none = || Dual::constant(L::c(0.0));
                let opening = self.single.opening_rate(local.spool, &at_valve).unwrap_or_else(none);
                AlongOne {
                    p1: rates.p1_rate.derivative[0],
                    p2: rates.p2_rate.derivative[0],
                    flow: rates.edges.supply().derivative[0],
                    signal: signal.derivative[0],
                    returned: rates.returned().derivative[0],
                    opening: opening.derivative[0],
                    rate: opening.value,
                }
            },
        )
    }

    /// Both ports with the derivatives by all their arguments.
    #[inline(always)]
    fn coupled_ports(&self, supply_pressures: &SupplyPressures<L>, s: &LocalState<L>) -> [Port<CoupledPort<L>>; 2] {
        let pressures = SupplyPressures {
            supply: Dual::variable(supply_pressures.supply, AT_MAINS),
            load: Dual::variable(supply_pressures.load, AT_LOAD),
            tank: Dual::constant(supply_pressures.tank),
        };
        let [v, p1, p2] = [Dual::variable(s.v, 0), Dual::variable(s.p1, AT_P1), Dual::variable(s.p2, AT_P2)];
        let spool = Dual::variable(s.spool, AT_SPOOL);
        let ports = self.whole.ports(&pressures, v, [p1, p2], still(s));
        let a = L::outlined_if_dual(
            #[inline(always)]
            || self.whole.port_a::<AnyParts>(&ports, spool),
        );
        let b = L::outlined_if_dual(
            #[inline(always)]
            || self.whole.port_b::<AnyParts>(&ports, spool),
        );
        [a, b]
    }

    /// Derivative of a friction map minus its secant F/v through standstill; zero with bristles.
    #[inline(always)]
    pub fn tangent_less_secant(&self, v: L) -> L {
        if self.friction.has_bristle() {
            return L::c(0.0);
        }
        L::outlined(
            #[inline(always)]
            || self.tangent_less_secant_of_static(v),
        )
    }

    #[inline(always)]
    fn tangent_less_secant_of_static(&self, v: L) -> L {
        let at = L::select(L::c(CREEP).lt(v.abs()), v, L::c(CREEP));
        let friction = self.friction.evaluate(Dual::variable(at, 0), Dual::constant(L::c(0.0))).force;
        friction.derivative[0] - friction.value / at
    }

    /// (xs', vs') with their derivatives by (xs, vs).
    #[inline(always)]
    pub fn spool_rates(&self, position: L, velocity: L, command: L) -> [Dual<L, 2>; 2] {
        let (position, velocity) = (Dual::variable(position, 0), Dual::variable(velocity, 1));
        let (position_rate, velocity_rate) = self.spool.rates(position, velocity, Dual::constant(command));
        [position_rate, velocity_rate]
    }

    /// Both ports with their derivatives by the local numbers.
    #[inline(always)]
    fn ports<P: Parts>(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
    ) -> [Port<WithDerivatives<L>>; 2] {
        if P::EXPECTED && self.whole.valve.couples_ports() {
            let [a, b] = self.coupled_ports(supply_pressures, s);
            [a.map(by_states), b.map(by_states)]
        } else {
            let a = L::outlined_if_dual(
                #[inline(always)]
                || self.port_a::<P>(supply_pressures, s),
            );
            let b = L::outlined_if_dual(
                #[inline(always)]
                || self.port_b::<P>(supply_pressures, s),
            );
            [a, b]
        }
    }

    /// The outputs of the laws with their derivatives by the local numbers.
    #[inline(always)]
    fn outputs<P: Parts>(
        &self,
        supply_pressures: &SupplyPressures<L>,
        s: &LocalState<L>,
        [port_a, port_b]: [Port<WithDerivatives<L>>; 2],
    ) -> LawOutputs<WithDerivatives<L>> {
        LawOutputs {
            port_a,
            port_b,
            crossed: self.crossed::<P>(supply_pressures, s),
            bulk: (self.bulk_modulus(s.p1).among([P1]), self.bulk_modulus(s.p2).among([P2])),
            friction: self.friction(s),
            stops: self.stops(s),
        }
    }

    #[inline(always)]
    fn bulk_modulus(&self, p: L) -> Dual<L, 1> {
        self.bulk.bulk_modulus(Dual::variable(p, 0))
    }

    #[inline(always)]
    fn port_a<P: Parts>(&self, supply_pressures: &SupplyPressures<L>, s: &LocalState<L>) -> Port<WithDerivatives<L>> {
        let [v, p1, spool] = [Dual::variable(s.v, 0), Dual::variable(s.p1, 1), Dual::variable(s.spool, 2)];
        let ports = self.ports.ports(
            &supply_pressures.map(&mut |number| Dual::constant(*number)),
            v,
            [p1, Dual::constant(s.p2)],
            P::part(still(s)),
        );
        self.ports.port_a::<P>(&ports, spool).map(|number| number.among([V, P1, SPOOL]))
    }

    #[inline(always)]
    fn port_b<P: Parts>(&self, supply_pressures: &SupplyPressures<L>, s: &LocalState<L>) -> Port<WithDerivatives<L>> {
        let [v, p2, spool] = [Dual::variable(s.v, 0), Dual::variable(s.p2, 1), Dual::variable(s.spool, 2)];
        let ports = self.ports.ports(
            &supply_pressures.map(&mut |number| Dual::constant(*number)),
            v,
            [Dual::constant(s.p1), p2],
            P::part(still(s)),
        );
        self.ports.port_b::<P>(&ports, spool).map(|number| number.among([V, P2, SPOOL]))
    }

    /// Flow through the cross-over relief valves.
    #[inline(always)]
    fn crossed<P: Parts>(&self, supply_pressures: &SupplyPressures<L>, s: &LocalState<L>) -> WithDerivatives<L> {
        if !P::EXPECTED || self.ports.crossover.is_none() {
            return Dual::constant(L::c(0.0));
        }
        let [v, p1, p2] = [Dual::variable(s.v, 0), Dual::variable(s.p1, 1), Dual::variable(s.p2, 2)];
        let ports = self.ports.ports(&supply_pressures.map(&mut |number| Dual::constant(*number)), v, [p1, p2], None);
        self.ports.crossed::<P>(&ports).among([V, P1, P2])
    }

    #[inline(always)]
    fn friction(&self, s: &LocalState<L>) -> FrictionOutput<WithDerivatives<L>> {
        let friction = self.friction.evaluate(Dual::variable(s.v, 0), Dual::variable(s.z, 1));
        friction.map(|number| number.among([V, Z]))
    }

    #[inline(always)]
    fn stops(&self, s: &LocalState<L>) -> (WithDerivatives<L>, WithDerivatives<L>) {
        let (spring, damping) = self.end_stop.force(Dual::variable(s.x, 0), Dual::variable(s.v, 1));
        (spring.among([X, V]), damping.among([X, V]))
    }
}
