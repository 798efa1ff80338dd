//! What pressure supply and load can make in a chamber.
//!
//! At rest in a pose, p1 A1 - p2 A2 balances the load F and friction. With the other chamber on the supply p_s a chamber
//! holds at most `(p_s A_other + F) / A`, and the supply itself at least. In motion the load has kinetic energy: with
//! every piston at its greatest steady speed under the load, E = 1/2 q' M q'. A valve that shuts can turn all of it into
//! elastic energy of the oil in one chamber of volume V: that raises the pressure by sqrt(2 E K / V).

use hydrocrane_sim::Model;

/// A drive may reach this many times what supply and load can make.
pub const MARGIN: f64 = 1.5;
/// Near a dead centre a joint turns without bound while its piston hardly moves: speeds of joints are taken with at least
/// this share of the greatest dx/dq between the joint's limits.
const LEAST_GAIN: f64 = 0.2;
const SAMPLES: usize = 50;

/// Pressures, Pa.
#[derive(Debug, Clone, Copy)]
pub struct Bound {
    /// Supply and load at rest.
    pub rest: f64,
    /// What the moving load adds when it is stopped.
    pub motion: f64,
}

impl Bound {
    pub fn total(&self) -> f64 {
        self.rest + self.motion
    }
}

/// A machine with one payload.
pub struct Bounds<'a> {
    model: &'a dyn Model,
    payload: f64,
    least_gain: Vec<f64>,
}

impl<'a> Bounds<'a> {
    pub fn new(model: &'a dyn Model, payload: f64) -> Self {
        let limits = model.joint_limits();
        let n = limits.len();
        let mut least_gain = vec![0.0f64; n];
        let (mut x, mut lever_arm) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..=SAMPLES {
            let share = i as f64 / SAMPLES as f64;
            let q: Vec<f64> = limits.iter().map(|l| l.lower + share * (l.upper - l.lower)).collect();
            model.strokes(&q, &mut x, &mut lever_arm);
            for (least, g) in least_gain.iter_mut().zip(&lever_arm) {
                *least = least.max(LEAST_GAIN * g.abs());
            }
        }
        Bounds { model, payload, least_gain }
    }

    /// Both chambers of each cylinder in the pose `q`, in order.
    pub fn at(&self, q: &[f64]) -> Vec<Bound> {
        let machine = self.model.machine();
        let n = q.len();
        let (mut x, mut lever_arm, mut load) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        self.model.strokes(q, &mut x, &mut lever_arm);
        self.model.static_force(q, self.payload, &mut load);
        let energy = self.kinetic_energy(q, &lever_arm);
        let supply = machine.supply.pressure;
        let mut bounds = Vec::with_capacity(2 * n);
        for (c, cylinder) in machine.cylinders.iter().enumerate() {
            let [piston, ring] = cylinder.areas();
            let friction = self.model.steady_friction(c, 1.0).abs().min(supply * piston);
            for (area, other, force, side, dead) in [
                (piston, ring, load[c], 1.0, cylinder.dead_volume[0]),
                (ring, piston, -load[c], -1.0, cylinder.dead_volume[1]),
            ] {
                let rest = supply.max((supply * other + force + friction) / area);
                // Within its zone the end stop brakes the piston.
                let free = (0.5 * cylinder.stroke + side * x[c]).max(cylinder.end_stop.zone);
                let volume = cylinder.count * dead + area * free;
                let motion = (2.0 * energy * self.model.bulk_modulus(rest) / volume).sqrt();
                bounds.push(Bound { rest, motion });
            }
        }
        bounds
    }

    /// The most that the pistons can give the crane in the pose `q` at steady speeds, J.
    fn kinetic_energy(&self, q: &[f64], lever_arm: &[f64]) -> f64 {
        let n = q.len();
        let (mut speeds, mut mass, mut bias) = (vec![0.0; 2 * n], vec![0.0; n * n], vec![0.0; n]);
        self.model.piston_speeds(q, self.payload, &mut speeds);
        self.model.equations(q, &vec![0.0; n], self.payload, &mut mass, &mut bias);
        let rate = |i: usize, sense: usize| {
            let v = speeds[2 * i + sense];
            lever_arm[i].signum() * v / lever_arm[i].abs().max(self.least_gain[i])
        };
        let energy = |senses: usize| {
            let qd: Vec<f64> = (0..n).map(|i| rate(i, senses >> i & 1)).collect();
            let twice: f64 =
                (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| qd[i] * mass[i * n + j] * qd[j]).sum();
            0.5 * twice
        };
        (0..1usize << n).map(energy).fold(0.0, f64::max)
    }
}
