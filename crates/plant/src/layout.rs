//! State layout: the only place that defines indices.
//!
//! Order: joint coordinates, joint rates, then per cylinder p1, p2, xs, vs, with LuGre friction z, and with a compensator that follows
//! late its opening; at the end, with a pump or a
//! measured supply, the pressure of the mains, where the pump senses the load that of the load-sensing line, with a tank line its
//! pressure, and where the pumps swivel the share of each one's displacement.

use hydrocrane_ode::{AxisStates, SharedStates, StateBlocks};

/// Largest number of joints of a chain.
pub const MAX_JOINTS: usize = hydrocrane_ode::MAX_BORDER;

/// Index, name and scale of each state.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    joints: usize,
    blocks: StateBlocks,
    load: Option<usize>,
    tank: Option<usize>,
    pub names: Vec<String>,
    pub units: Vec<&'static str>,
    pub long_names: Vec<String>,
    /// Scale of the state: its absolute tolerance is `rtol` times this.
    pub scales: Vec<f64>,
}

/// Properties of one joint and its cylinder that the layout needs.
#[derive(Debug, Clone)]
pub struct Unit {
    pub joint: String,
    pub cylinder: String,
    pub revolute: bool,
    pub bristle: bool,
    /// Whether its compensator follows late.
    pub opening: bool,
    /// Spool stroke, m, and natural frequency, rad/s.
    pub spool: (f64, f64),
}

/// Properties of the pumps that the layout needs.
#[derive(Debug, Clone)]
pub struct PumpUnit {
    pub names: Vec<String>,
    /// Whether they sense the load.
    pub senses: bool,
    /// Whether their displacements change.
    pub swivels: bool,
    /// Whether the oil returns through a tank line.
    pub returns: bool,
}

impl Layout {
    /// `measured`: the pressure of the supply is a state that a run prescribes.
    pub fn new(units: &[Unit], pump: Option<&PumpUnit>, measured: bool) -> Self {
        let mut layout = Layout {
            joints: units.len(),
            blocks: StateBlocks::default(),
            load: None,
            tank: None,
            names: Vec::new(),
            units: Vec::new(),
            long_names: Vec::new(),
            scales: Vec::new(),
        };
        for u in units {
            let unit = if u.revolute { "rad" } else { "m" };
            layout.push(format!("joint.{}.q", u.joint), unit, format!("{} joint coordinate", u.joint), 0.1);
        }
        for u in units {
            let unit = if u.revolute { "rad/s" } else { "m/s" };
            layout.push(format!("joint.{}.qd", u.joint), unit, format!("{} joint rate", u.joint), 0.1);
        }
        for u in units {
            let first = layout.names.len();
            let z = u.bristle.then_some(first + 4);
            let opening = u.opening.then_some(first + 4 + usize::from(u.bristle));
            layout.blocks.axes.push(AxisStates { p1: first, p2: first + 1, xs: first + 2, vs: first + 3, z, opening });
            let (c, (stroke, frequency)) = (&u.cylinder, u.spool);
            layout.push(format!("cylinder.{c}.p1"), "Pa", format!("{c} piston-side pressure"), 1e6);
            layout.push(format!("cylinder.{c}.p2"), "Pa", format!("{c} rod-side pressure"), 1e6);
            layout.push(format!("cylinder.{c}.xs"), "m", format!("{c} spool position"), stroke);
            layout.push(format!("cylinder.{c}.vs"), "m/s", format!("{c} spool velocity"), stroke * frequency);
            if u.bristle {
                layout.push(format!("cylinder.{c}.z"), "m", format!("{c} bristle deflection"), 1e-3);
            }
            if u.opening {
                let long_name = format!("{c} opening of the compensator: flow over that with it fully open");
                layout.push(format!("cylinder.{c}.compensator"), "1", long_name, 0.1);
            }
        }
        let first = layout.names.len();
        if measured || pump.is_some() {
            layout.push("mains.p".into(), "Pa", "pressure of the mains".into(), 1e6);
        }
        if let Some(PumpUnit { senses, returns, .. }) = pump {
            if *senses {
                layout.load = Some(layout.names.len());
                layout.push("mains.load".into(), "Pa", "pressure of the load-sensing line".into(), 1e6);
            }
            if *returns {
                layout.tank = Some(layout.names.len());
                layout.push("tank_line.p".into(), "Pa", "pressure of the tank line".into(), 1e5);
            }
        }
        let acting = layout.names.len() - first;
        if let Some(PumpUnit { names, swivels: true, .. }) = pump {
            for name in names {
                layout.push(format!("pump.{name}.displacement"), "1", format!("{name} share of the displacement"), 0.1);
            }
        }
        layout.blocks.shared = SharedStates { first, count: layout.names.len() - first, acting };
        layout
    }

    fn push(&mut self, name: String, unit: &'static str, long_name: String, scale: f64) {
        self.names.push(name);
        self.units.push(unit);
        self.long_names.push(long_name);
        self.scales.push(scale);
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.names.len()
    }
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }
    pub fn joints(&self) -> usize {
        self.joints
    }
    pub fn q(&self, joint: usize) -> usize {
        joint
    }
    pub fn qd(&self, joint: usize) -> usize {
        self.joints + joint
    }
    pub fn p1(&self, cylinder: usize) -> usize {
        self.blocks.axes[cylinder].p1
    }
    pub fn p2(&self, cylinder: usize) -> usize {
        self.blocks.axes[cylinder].p2
    }
    pub fn xs(&self, cylinder: usize) -> usize {
        self.blocks.axes[cylinder].xs
    }
    pub fn vs(&self, cylinder: usize) -> usize {
        self.blocks.axes[cylinder].vs
    }
    /// `None` with the static friction map.
    pub fn z(&self, cylinder: usize) -> Option<usize> {
        self.blocks.axes[cylinder].z
    }
    /// The opening of a compensator; `None` where it follows at once.
    pub fn opening(&self, cylinder: usize) -> Option<usize> {
        self.blocks.axes[cylinder].opening
    }
    /// Which states belong to which cylinder, and which to the supply.
    pub fn blocks(&self) -> &StateBlocks {
        &self.blocks
    }
    /// All states that are pressures of oil.
    pub fn pressures(&self) -> impl Iterator<Item = usize> + '_ {
        let chambers = self.blocks.axes.iter().flat_map(|at| [at.p1, at.p2]);
        chambers.chain([self.mains(), self.load(), self.tank()].into_iter().flatten())
    }
    /// The pressure of the mains; `None` where it is constant.
    pub fn mains(&self) -> Option<usize> {
        (self.blocks.shared.count > 0).then_some(self.blocks.shared.first)
    }
    /// The pressure of the load-sensing line; `None` without one.
    pub fn load(&self) -> Option<usize> {
        self.load
    }
    /// The pressure of the tank line; `None` without one.
    pub fn tank(&self) -> Option<usize> {
        self.tank
    }
    /// The share of the first pump's displacement; `None` where it is fixed.
    pub fn swivel(&self) -> Option<usize> {
        self.swivels().next()
    }
    /// The shares of the displacements of all pumps.
    pub fn swivels(&self) -> std::ops::Range<usize> {
        let SharedStates { first, count, acting } = self.blocks.shared;
        first + acting..first + count
    }
    /// All states of a cylinder.
    pub fn own(&self, cylinder: usize) -> AxisStates {
        self.blocks.axes[cylinder]
    }
}
