//! State layout: the only place that defines indices.
//!
//! Order: joint coordinates, joint rates, then per cylinder p1, p2, xs, vs and, with LuGre friction, z.

use hydrocrane_ode::AxisStates;

/// Largest number of joints of a chain.
pub const MAX_JOINTS: usize = hydrocrane_ode::MAX_BORDER;

/// Index, name and scale of each state.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    joints: usize,
    axes: Vec<AxisStates>,
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
    /// Spool stroke, m, and natural frequency, rad/s.
    pub spool: (f64, f64),
}

impl Layout {
    pub fn new(units: &[Unit]) -> Self {
        let mut layout = Layout {
            joints: units.len(),
            axes: Vec::new(),
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
            layout.axes.push(AxisStates { p1: first, p2: first + 1, xs: first + 2, vs: first + 3, z });
            let (c, (stroke, frequency)) = (&u.cylinder, u.spool);
            layout.push(format!("cylinder.{c}.p1"), "Pa", format!("{c} piston-side pressure"), 1e6);
            layout.push(format!("cylinder.{c}.p2"), "Pa", format!("{c} rod-side pressure"), 1e6);
            layout.push(format!("cylinder.{c}.xs"), "m", format!("{c} spool position"), stroke);
            layout.push(format!("cylinder.{c}.vs"), "m/s", format!("{c} spool velocity"), stroke * frequency);
            if u.bristle {
                layout.push(format!("cylinder.{c}.z"), "m", format!("{c} bristle deflection"), 1e-3);
            }
        }
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
        self.axes[cylinder].p1
    }
    pub fn p2(&self, cylinder: usize) -> usize {
        self.axes[cylinder].p2
    }
    pub fn xs(&self, cylinder: usize) -> usize {
        self.axes[cylinder].xs
    }
    pub fn vs(&self, cylinder: usize) -> usize {
        self.axes[cylinder].vs
    }
    /// `None` with the static friction map.
    pub fn z(&self, cylinder: usize) -> Option<usize> {
        self.axes[cylinder].z
    }
    /// The states of each cylinder.
    pub fn axes(&self) -> &[AxisStates] {
        &self.axes
    }
    /// All states of a cylinder.
    pub fn own(&self, cylinder: usize) -> AxisStates {
        self.axes[cylinder]
    }
}
