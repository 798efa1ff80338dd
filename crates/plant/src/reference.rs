//! The whole machine in one readable function: the reference for the fast right-hand side.
//!
//! Written from the description of the machine, with textbook steps instead of shared ones: link angles and
//! trigonometry, a Newton-Euler recursion for forces, the laws in plain `f64` with ordinary branches.

mod laws;
mod space;
mod supply;

use hydrocrane_machine::model::*;
use laws::{bulk_modulus, curve, flank, rounded};
use std::f64::consts::{FRAC_PI_4, PI};
use supply::supply_rates;

type V = [f64; 2];

fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1]]
}
fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1]]
}
fn scale(a: V, s: f64) -> V {
    [a[0] * s, a[1] * s]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
fn turn(a: V, angle: f64) -> V {
    [a[0] * angle.cos() - a[1] * angle.sin(), a[0] * angle.sin() + a[1] * angle.cos()]
}
/// Derivative of `turn` at angle zero: the velocity of a vector that turns at 1 rad/s.
fn quarter(a: V) -> V {
    [-a[1], a[0]]
}

/// Force of the ground on the tip with velocity `v`; the load hangs against `up`.
fn push_of_ground(ground: &Ground, load: &Payload, up: V, tip: V, v: V, payload: f64) -> V {
    let hang = match payload {
        m if m <= 0.0 => 0.0,
        // Below 1 kg a parabola replaces the root.
        m if m < 1.0 => load.hang + load.hang_growth * m * (3.0 - m) / 2.0,
        m => load.hang + load.hang_growth * m.sqrt(),
    };
    let at = sub(tip, scale(up, hang));
    // The highest of the supports, each with smooth flanks.
    let (mut height, mut slope) = (ground.height, 0.0);
    let mut supports: Vec<&Support> = ground.supports.iter().collect();
    supports.sort_by(|a, b| a.height.partial_cmp(&b.height).expect("numbers"));
    for s in supports {
        let (share, share_slope) = if at[0] < s.from { flank((at[0] - s.from + s.edge) / s.edge) } else { (1.0, 0.0) };
        let (falling, falling_slope) = if at[0] > s.to { flank((s.to + s.edge - at[0]) / s.edge) } else { (1.0, 0.0) };
        let rise = s.height - height;
        let (both, both_slope) = (share * falling, (share_slope - falling_slope) / s.edge);
        (height, slope) = (height + rise * both, slope * (1.0 - both) + rise * both_slope);
    }
    let depth = height - at[1];
    if depth <= 0.0 {
        return [0.0; 2];
    }
    let pressed = if depth < 2e-3 { depth * depth / 4e-3 } else { depth - 1e-3 };
    let hardening = 1.0 + ground.damping * (slope * v[0] - v[1]);
    let factor = match hardening {
        r if r <= -0.5 => 0.0,
        r if r < 0.5 => (r + 0.5) * (r + 0.5) / 2.0,
        r => r,
    };
    let normal = ground.stiffness * pressed * factor;
    let friction = ground.friction * normal * ((v[0] + slope * v[1]) / 0.02).tanh();
    add(scale([-slope, 1.0], normal), scale([1.0, slope], -friction))
}

/// A load-holding valve in series with the edge to the tank.
struct Held {
    /// What it leaves of the opening of the edge, m, and how far it is open itself.
    edge: f64,
    open: f64,
    /// What is left of the root of the pressure drop behind it, and how far it lets oil pass both ways.
    share: f64,
    free: f64,
}

/// State derivative of a corrected machine; `None` where any law is switched to as-printed.
///
/// Order of states: joint coordinates, joint rates, then per cylinder p1, p2, xs, vs and, with LuGre, z; with a pump those of
/// [`supply_rates`].
pub fn state_derivative(m: &Machine, x: &[f64], u: &[f64], payload: f64) -> Option<Vec<f64>> {
    let e = &m.errata;
    let laws = [e.gravity_sign, e.inertia_about, e.orifice_law, e.extension_leakage, e.extension_dead_volume];
    if !laws.iter().chain(&[e.leakage_viscosity, e.end_stop, e.friction_map]).all(|corrected| *corrected) {
        return None;
    }
    let n = m.joints.len();
    let (q, qd) = (&x[..n], &x[n..2 * n]);
    let mut dx = vec![0.0; x.len()];

    // Kinematics: frame angle and origin of every link, joint axes in the world.
    let mut angle = vec![0.0; n + 1];
    let mut origin = vec![[0.0; 2]; n + 1];
    let mut slide = vec![[0.0; 2]; n];
    let mut spin = vec![0.0; n];
    for (i, joint) in m.joints.iter().enumerate() {
        let travel = joint.sense * (q[i] - joint.zero);
        let mut at = joint.at;
        angle[i + 1] = angle[i];
        match joint.kind {
            // Seen from the side; `space.rs` has the masses that it turns.
            JointKind::Revolute(_) if joint.axis.is_some() => {}
            JointKind::Revolute(convention) => {
                let folded = if convention == AngleConvention::Included { joint.sense * PI } else { 0.0 };
                angle[i + 1] += m.links[i].axis + travel - folded - m.links[i + 1].axis;
                spin[i] = joint.sense;
            }
            JointKind::Prismatic { direction } => {
                let along = turn([1.0, 0.0], direction);
                at = add(at, scale(along, travel));
                slide[i] = turn(scale(along, joint.sense), angle[i]);
            }
        }
        origin[i + 1] = add(origin[i], turn(at, angle[i]));
    }
    let world = |p: &Point| add(origin[p.link], turn(p.position, angle[p.link]));
    // Velocity of a world point on the child link per unit rate of joint i.
    let velocity = |i: usize, p: V| add(slide[i], scale(quarter(sub(p, origin[i + 1])), spin[i]));

    // Cylinders: stroke, its slope, then flows, pressures, friction and force.
    let bristles = |c: &Cylinder| usize::from(c.friction.model == FrictionModel::LuGre);
    let states_of = |c: &Cylinder| 4 + bristles(c) + usize::from(c.valve.compensator_time_constant.is_some());
    let mains_at = 2 * n + m.cylinders.iter().map(states_of).sum::<usize>();
    let mains_pressure = if m.supply.measured || m.supply.mains.is_some() { x[mains_at] } else { m.supply.pressure };
    let load_pressure = if m.supply.mains.as_ref().is_some_and(|mains| mains.load_sensing.is_some()) {
        x[mains_at + 1]
    } else {
        m.supply.tank_pressure
    };
    // What returns is at the pressure of the tank line.
    let tank_pressure = match &m.supply.mains {
        Some(Mains { tank_line: Some(_), load_sensing, .. }) => x[mains_at + 1 + usize::from(load_sensing.is_some())],
        _ => m.supply.tank_pressure,
    };
    let (mut drawn, mut signal, mut given_back) = (0.0, tank_pressure, 0.0);
    let mut torque = vec![0.0; n];
    let mut s = 2 * n;
    for (i, c) in m.cylinders.iter().enumerate() {
        let barrel = world(&c.barrel_pin);
        let of_pins = |(pin, pin_velocity): (V, V)| {
            let rod = sub(pin, barrel);
            let length = dot(rod, rod).sqrt();
            (length - c.mid_length, dot(rod, pin_velocity) / length)
        };
        let (position, lever_arm) = match &c.rod_pin {
            RodPin::Point(p) if m.is_spatial() => space::stroke(m, c, p, q[i]),
            RodPin::Point(p) => {
                let on_child = if p.link == i + 1 { world(p) } else { barrel };
                let sign = if p.link == i + 1 { 1.0 } else { -1.0 };
                of_pins((world(p), scale(velocity(i, on_child), sign)))
            }
            RodPin::FourBar(l) => {
                let (t1, t3) = (world(&l.rocker_pivot), world(&l.coupler_pivot));
                let d = sub(t3, t1);
                let (r1, r2) = (l.rocker_length, l.coupler_length);
                let opening = ((r1 * r1 + dot(d, d) - r2 * r2) / (2.0 * r1 * dot(d, d).sqrt())).acos();
                let rocker = d[1].atan2(d[0]) + l.side * opening;
                let pin = add(t1, scale([rocker.cos(), rocker.sin()], r1));
                // The coupler has constant length: both ends have the same velocity along it.
                let coupler = sub(pin, t3);
                let swing = quarter(sub(pin, t1));
                of_pins((pin, scale(swing, dot(coupler, velocity(i, t3)) / dot(coupler, swing))))
            }
            RodPin::Rack(radius) => (radius * (q[i] - m.joints[i].zero), *radius),
        };
        let v = lever_arm * qd[i];
        let (p1, p2, xs, vs) = (x[s], x[s + 1], x[s + 2], x[s + 3]);
        // Of a compensator that follows late.
        let opening_at = s + 4 + bristles(c);
        let opening = c.valve.compensator_time_constant.map(|_| x[opening_at]);

        // Of so many cylinders in parallel together.
        let count = c.count;
        let a1 = count * FRAC_PI_4 * c.bore.powi(2);
        let a2 = count * FRAC_PI_4 * (c.bore.powi(2) - c.rod_diameter.powi(2));
        let dynamic = |area: f64| match c.port_diameter {
            Some(d) => m.fluid.density / 2.0 * ((area / (count * FRAC_PI_4 * d * d)).powi(2) - 1.0) * v * v,
            None => 0.0,
        };
        let (pa, pb) = (p1 - dynamic(a1), p2 - dynamic(a2));

        let valve = &c.valve;
        let c0 = valve.nominal_flow / ((valve.stroke - valve.overlap) * valve.edge_pressure_drop.sqrt());
        // Of an edge that opens with a growing `travel`, m.
        let opened = |edge: usize, travel: f64| match &valve.metering[edge] {
            Some(of) => (valve.stroke - valve.overlap) * of.full * curve(&of.points, travel.max(0.0) / valve.stroke),
            None => (travel - valve.overlap).max(0.0),
        };
        let edge = |opening: f64, dp: f64, leaking: f64| {
            let p_tr = valve.transition_pressure;
            let root = if dp.abs() < p_tr {
                dp * (3.0 - dp.abs() / p_tr) / (2.0 * p_tr.sqrt())
            } else {
                dp.signum() * dp.abs().sqrt()
            };
            c0 * opening * root + valve.leakage * leaking * dp
        };
        // What the line to a port takes, Pa, of the flow into the cylinder.
        let over_line =
            |port: usize, q: f64| match c.ports.lines[port].as_ref().and_then(|line| line.resistance.as_ref()) {
                Some(of) => of.laminar * q + of.turbulent * q * q.abs(),
                None => 0.0,
            };
        // What it, or it and a further `resistance`, leave of a drop to an edge of this opening behind or before them, by halving.
        let left_by = |port: usize, resistance: f64, opening: f64, whole: f64| {
            if over_line(port, 1.0) + resistance == 0.0 {
                return whole;
            }
            let (mut least, mut most) = (0.0, whole.abs());
            for _ in 0..200 {
                let middle = 0.5 * (least + most);
                let q = edge(opening, middle, 0.0);
                if middle + over_line(port, q) + resistance * q * q > whole.abs() {
                    most = middle;
                } else {
                    least = middle;
                }
            }
            most.copysign(whole)
        };
        let left = |port: usize, opening: f64, whole: f64| left_by(port, 0.0, opening, whole);
        // Flow per root of the pressure drop over the hole of a hose.
        let hole = |port: usize| {
            let leak = c.ports.leaks[port].as_ref();
            leak.map_or(0.0, |of| of.discharge_coefficient * of.opening * (2.0 / m.fluid.density).sqrt())
        };
        let (ps, pt) = (mains_pressure, tank_pressure);
        // Behind the compensator, as it is once it has settled, and now.
        let settled = |port: f64| match valve.compensator {
            Compensator::None => ps - port,
            Compensator::Before(setting) => ps - port - rounded(ps - port - setting, 0.2e5),
            Compensator::Behind => ps - port - rounded(load_pressure - port, 0.2e5),
        };
        let drop_to = |port: f64| opening.map_or_else(|| settled(port), |opening| opening * opening * (ps - port));
        let travel = 0.01 * valve.stroke;
        let closed = [0, 2].map(|edge| match &valve.metering[edge] {
            Some(of) => valve.stroke * of.points.iter().rfind(|point| point[1] == 0.0).map_or(0.0, |point| point[0]),
            None => valve.overlap,
        });
        let closed = closed[0].min(closed[1]);
        let (connected, _) = flank((xs.abs() - (closed - travel).max(0.0)) / travel);
        let fed_pressure = pt + connected * (if xs < 0.0 { pb } else { pa } - pt);
        // What a port's load-holding valve leaves of the edge to the tank of this `opening` in series with it; the pressure of the fed
        // port opens the valve, and a hose that leaks lies beside the edge.
        let held = |port: usize, opening: f64| {
            let valve = c.ports.holding[port].as_ref()?;
            let (pc, pilot) = ([pa, pb][port], if (port == 0) == (xs < 0.0) { fed_pressure } else { pt });
            let full = valve.nominal_flow / valve.nominal_pressure_drop.sqrt();
            let along = |own: f64, other: f64| own / (own * own + other * other + (1e-9 * full).powi(2)).sqrt();
            let (to_tank, out) = (c0 * opening, c0 * opening + hole(port));
            let share = |beyond: f64| rounded(beyond, 0.1) - rounded(beyond - 1.0, 0.1);
            let open = match &valve.kind {
                HoldingKind::Counterbalance(v) => share((pc + v.pilot_ratio * pilot - v.setting) / v.opening_pressure),
                HoldingKind::PilotCheck(v) => {
                    share((v.pilot_ratio * (pilot - pt) - (pc - pt) - v.spring_pressure) / v.opening_pressure)
                }
                HoldingKind::HoseBurst(v) => {
                    let series = to_tank * along(full, to_tank);
                    let wide_open = edge(out * along(full, out) / c0, left(port, series / c0, pc - pt), 0.0);
                    1.0 - (1.0 - v.bleed) * flank((wide_open / v.closing_flow - 1.0) / 0.1).0
                }
            };
            let share = along(full * open, out);
            let free = if matches!(valve.kind, HoldingKind::HoseBurst(_)) { open } else { 0.0 };
            Some(Held { edge: opening * share, open, share, free })
        };
        // An edge in series with the line of its port, and the leakage over it.
        let metered = |port: usize, opening: f64, dp: f64, leaking: f64| {
            edge(opening, left(port, opening, dp), 0.0) + edge(0.0, dp, leaking)
        };
        let returned = |port: usize, opening: f64, dp: f64| {
            let opening = opening.max(0.0) * valve.return_ratio[port];
            match held(port, opening) {
                Some(Held { edge, open, .. }) if dp >= 0.0 => metered(port, edge, dp, open),
                Some(Held { open, .. }) => metered(port, opening, dp, open),
                None => metered(port, opening, dp, 1.0),
            }
        };
        // A separate edge to the tank, active while the section moves in this direction, holds the port's pressure.
        let drained = |port: usize, by_spool: f64, travel_that_way: f64| match &valve.meter_out[port] {
            Some(of) => {
                let share = ([pa, pb][port] - of.pressure) / of.range;
                let (free, _) = flank((travel_that_way - (closed - travel).max(0.0)) / travel);
                (valve.stroke - valve.overlap) * free * (rounded(share, 0.1) - rounded(share - 1.0, 0.1))
            }
            None => by_spool,
        };
        let draining = match valve.kind {
            ValveKind::FourThree => [drained(0, opened(1, -xs), -xs), drained(1, opened(3, xs), xs)],
            ValveKind::Regenerative => [drained(0, opened(1, -xs), -xs), 0.0],
        };
        let sealed = |port: usize| {
            let behind = held(port, draining[port].max(0.0) * valve.return_ratio[port]);
            behind.map_or(1.0, |held| held.open)
        };
        // A check valve before the edges, or that of a port's load-holding valve.
        let holds = |port: usize| {
            let held = c.ports.holding[port].as_ref();
            held.is_some_and(|held| !matches!(held.kind, HoldingKind::HoseBurst(_)))
        };
        let checked = |port: usize, flow: f64| if valve.load_check || holds(port) { flow.max(0.0) } else { flow };
        // From the supply to a port: what the line leaves, of that what the compensator leaves.
        let fed = |port: usize, p: f64, opened: f64| {
            let beyond_line = ps - left(port, opened * opening.unwrap_or(1.0), ps - p);
            edge(opened, drop_to(beyond_line), 0.0) + edge(0.0, drop_to(p), sealed(port))
        };
        // What a section that gives way to another one gets.
        let share = match m.supply.mains.as_ref().and_then(|mains| Some((mains, mains.priority.as_ref()?))) {
            Some((mains, first)) if first.cylinder != i => {
                let highest = if mains.pump.control.is_some() { m.supply.pressure } else { mains.relief_pressure };
                let margin = mains.load_sensing.as_ref().map_or(0.0, |sensing| sensing.margin);
                let lacks = highest.min(load_pressure + margin) - ps;
                let beyond = (margin - lacks - first.margin) / first.range;
                rounded(beyond, 0.1) - rounded(beyond - 1.0, 0.1)
            }
            _ => 1.0,
        };
        let feeding = match valve.kind {
            ValveKind::FourThree => [opened(0, xs), opened(2, -xs)],
            ValveKind::Regenerative => [opened(0, xs), opened(2, xs.abs())],
        };
        let from_supply = match valve.kind {
            ValveKind::FourThree => [checked(0, fed(0, pa, feeding[0])), checked(1, fed(1, pb, feeding[1]))],
            ValveKind::Regenerative => [checked(0, fed(0, pa, feeding[0])), fed(1, pb, feeding[1])],
        };
        let to_tank = [returned(0, draining[0], pa - pt), returned(1, draining[1], pb - pt)];
        // Flow from the supply into a hose, flow out of its hole, and how far its pressure lies below that of the chamber.
        let spilled = |port: usize| {
            let (p, fed) = ([pa, pb][port], share * from_supply[port]);
            let Some(_) = &c.ports.leaks[port] else { return (fed, 0.0, 0.0) };
            let p_tr = 0.1e5;
            let root = match p {
                p if p <= 0.0 => 0.0,
                p if p < p_tr => p * (3.0 - p / p_tr) / (2.0 * p_tr.sqrt()),
                p => p.sqrt(),
            };
            let most = hole(port) * root;
            let Some(Held { share: beside, free, .. }) = held(port, draining[port].max(0.0) * valve.return_ratio[port])
            else {
                return (fed, most, 0.0);
            };
            // The hole in series with the edge, as a resistance that grows with the square of the flow.
            let throttled = feeding[port] * opening.unwrap_or(1.0);
            let passing = left_by(port, 1.0 / (hole(port).powi(2) + 1e-30), throttled, ps);
            let outward = (share * edge(feeding[port], drop_to(ps - passing), 0.0)).max(0.0).min(most);
            let lost = outward.max(beside * most);
            let kept = if most > 1e-12 { lost / most } else { 1.0 };
            (free * fed + (1.0 - free) * ((fed - most).max(0.0) + outward), lost, p * (1.0 - kept * kept))
        };
        let spilled = [spilled(0), spilled(1)];
        let from_supply = spilled.map(|(fed, ..)| fed);
        // Through relief and anti-cavitation valve of a port to the tank.
        let through = |port: usize| {
            let (valves, p) = (&c.ports.valves[port], [pa, pb][port]);
            let relieved = valves
                .relief
                .as_ref()
                .map_or(0.0, |v| v.nominal_flow / v.overpressure * rounded(p - pt - v.setting, 0.5e5));
            let refilled = valves.anti_cavitation.as_ref().map_or(0.0, |v| {
                let left = rounded(pt - p - v.opening_pressure, 0.02e5);
                let root =
                    if left < 0.1e5 { left * (3.0 - left / 0.1e5) / (2.0 * 0.1e5f64.sqrt()) } else { left.sqrt() };
                v.nominal_flow / (v.nominal_pressure_drop - v.opening_pressure).sqrt() * root
            });
            relieved - refilled
        };
        // Through the cross-over relief valves from port A to port B.
        let over = |port: usize, drop: f64| {
            c.ports.crossover[port]
                .as_ref()
                .map_or(0.0, |v| v.nominal_flow / v.overpressure * rounded(drop - v.setting, 0.5e5))
        };
        let across = over(0, pa - pb) - over(1, pb - pa);
        let q_a = from_supply[0] - to_tank[0] - through(0) - across - spilled[0].1;
        let q_b = to_tank[1] - from_supply[1] + through(1) - across + spilled[1].1;
        drawn += from_supply[0] + from_supply[1];
        // The load-sensing line sees the ports before the lines to the cylinder.
        let before_line =
            |port: usize, p: f64| p - spilled[port].2 + over_line(port, from_supply[port] - to_tank[port]);
        let before_line = if xs < 0.0 { before_line(1, pb) } else { before_line(0, pa) };
        let sensed = pt + connected * (before_line - pt);
        signal = signal.max(sensed);
        if let (Some(time_constant), Some(opening)) = (valve.compensator_time_constant, opening) {
            let taken = (ps - sensed) - settled(sensed);
            let wanted = match 1.0 - taken / (ps - sensed).max(0.2e5) {
                share if share < 1e-3 => share.max(0.0) * (3.0 - share.max(0.0) / 1e-3) / (2.0 * 1e-3f64.sqrt()),
                share => share.min(1.0).sqrt(),
            };
            dx[opening_at] = (wanted - opening) / time_constant;
        }

        let (k_int, k_ext) = match c.leakage {
            Leakage::Conductance { internal, external } => (internal, external),
            Leakage::Gap { gap, piston_length, gland_length, .. } => {
                let k = |d: f64, l: f64| PI * (d / 2.0 + gap) * gap.powi(3) / (6.0 * m.fluid.viscosity * l);
                (k(c.bore, piston_length), k(c.rod_diameter, gland_length))
            }
        };
        let (q_int, q_ext) = (count * k_int * (p1 - p2), count * k_ext * (p2 - pt));
        given_back += to_tank[0] + to_tank[1] + through(0) + through(1) + q_ext;

        let bulk = |p: f64| bulk_modulus(&m.fluid, p);
        let half = c.stroke / 2.0;
        // Capacity of a chamber with its line: volume per pressure.
        let capacity = |side: usize, p: f64, volume: f64| match &c.ports.lines[side] {
            Some(line) => (volume + line.volume + line.compliance * p) / bulk(p) + line.compliance,
            None => volume / bulk(p),
        };
        let swept = if c.motor { [0.0; 2] } else { [a1 * (half + position), a2 * (half - position)] };
        let volumes = [count * c.dead_volume[0] + swept[0], count * c.dead_volume[1] + swept[1]];
        dx[s] = (q_a - q_int - a1 * v) / capacity(0, p1, volumes[0]);
        dx[s + 1] = (a2 * v - q_b + q_int - q_ext) / capacity(1, p2, volumes[1]);
        let limited = |value: f64, limit: Option<f64>| limit.map_or(value, |l| value.clamp(-l, l));
        let w = valve.spool.natural_frequency;
        dx[s + 2] = limited(vs, valve.spool.velocity_limit);
        dx[s + 3] =
            limited(w * w * (u[i] - xs) - 2.0 * valve.spool.damping_ratio * w * vs, valve.spool.acceleration_limit);

        let f = &c.friction;
        let sense = usize::from(v < 0.0);
        let stribeck = f.coulomb[sense]
            + (f.breakaway[sense] - f.coulomb[sense])
                * (-(v / f.stribeck_velocity[sense]).abs().powf(f.stribeck_exponent[sense])).exp();
        let viscous = f.viscous[sense] * v.abs().powf(f.viscous_exponent[sense]).copysign(v);
        let friction = match f.model {
            FrictionModel::Static => (v / f.smoothing_velocity.unwrap_or(1e-3)).tanh() * stribeck + viscous,
            FrictionModel::LuGre => {
                let z = x[s + 4];
                if f.breakaway == [0.0; 2] {
                    // Without bristles a remaining deflection decays.
                    dx[s + 4] = -100.0 * z;
                    viscous
                } else {
                    let z_rate = v - f.bristle_stiffness * v.abs() / stribeck.max(1e-3) * z;
                    dx[s + 4] = z_rate;
                    let fade = f.bristle_damping_velocity.map_or(1.0, |v_d| (-(v / v_d).powi(2)).exp());
                    f.bristle_stiffness * z + f.bristle_damping * fade * z_rate + viscous
                }
            }
        };

        let stop = &c.end_stop;
        let lower = c.rod_contact.unwrap_or(-half).max(-half);
        let inner = ((lower + stop.zone - position) / stop.zone).max(0.0);
        let outer = ((position - half + stop.zone) / stop.zone).max(0.0);
        let push = |depth: f64| {
            let inside = depth.min(0.98);
            stop.stiffness * stop.zone * (inside / (1.0 - inside) + (depth - inside) / 0.02f64.powi(2))
        };
        let damping = stop.damping * (inner + outer).min(1.0) * v;
        let others = push(inner) - push(outer) - damping - friction;
        let force = p1 * a1 - p2 * a2 + count * others;
        torque[i] = lever_arm * force;
        s += states_of(c);
    }

    // Against gravity, in the frame of the base.
    let up = turn([0.0, 1.0], -m.environment.slope);
    if let Some(ground) = &m.ground {
        let at = world(&m.tip);
        let v = (0..n).fold([0.0; 2], |sum, j| add(sum, scale(velocity(j, at), qd[j])));
        let force = push_of_ground(ground, &m.payload, up, at, v, payload);
        for (j, torque) in torque.iter_mut().enumerate() {
            *torque += dot(velocity(j, at), force);
        }
    }

    // Newton-Euler: joint forces needed for given accelerations; its value at zero acceleration is the bias force, its
    // response to unit accelerations the mass matrix.
    let needed = |qdd: &[f64], qd: &[f64], gravity: V| {
        if m.is_spatial() {
            return space::joint_forces(m, q, qd, qdd, [gravity[0], 0.0, gravity[1]], payload);
        }
        let (mut rate, mut spin_up, mut a) = (0.0, 0.0, gravity);
        let mut parts: Vec<(usize, f64, f64, V, V)> = Vec::new();
        for i in 0..n {
            let r = sub(origin[i + 1], origin[i]);
            let coriolis = scale(quarter(slide[i]), 2.0 * rate * qd[i]);
            a = add(a, add(scale(quarter(r), spin_up), scale(r, -rate * rate)));
            a = add(a, add(scale(slide[i], qdd[i]), coriolis));
            rate += spin[i] * qd[i];
            spin_up += spin[i] * qdd[i];
            let link = &m.links[i + 1];
            let cog = link.centre_of_gravity;
            let about_cog = match link.inertia_about {
                InertiaAbout::Frame => link.inertia - link.mass * dot(cog, cog),
                InertiaAbout::CentreOfGravity => link.inertia,
            };
            let mut carry = |mass: f64, inertia: f64, local: V| {
                let arm = turn(local, angle[i + 1]);
                let at = add(a, add(scale(quarter(arm), spin_up), scale(arm, -rate * rate)));
                parts.push((i, inertia * spin_up, mass, add(origin[i + 1], arm), at));
            };
            carry(link.mass, about_cog, cog);
            if i == n - 1 {
                carry(payload, 0.0, m.tip.position);
            }
        }
        let joint_force = |j: usize| -> f64 {
            let outboard = parts.iter().filter(|part| part.0 >= j);
            outboard.map(|(_, moment, mass, at, a)| spin[j] * moment + mass * dot(*a, velocity(j, *at))).sum()
        };
        (0..n).map(joint_force).collect::<Vec<f64>>()
    };
    let bias = needed(&vec![0.0; n], qd, scale(up, m.environment.gravity));
    let still = vec![0.0; n];
    let columns: Vec<Vec<f64>> = (0..n)
        .map(|k| {
            let mut unit = still.clone();
            unit[k] = 1.0;
            needed(&unit, &still, [0.0; 2])
        })
        .collect();
    let system: Vec<f64> = (0..n * n).map(|i| columns[i % n][i / n]).collect();
    let mut qdd: Vec<f64> = (0..n).map(|j| torque[j] - bias[j]).collect();
    let mut inverse = hydrocrane_num::linear::dense::Inverse::default();
    inverse.of(n, &system);
    inverse.solve(&mut qdd);

    if let Some(mains) = &m.supply.mains {
        dx[mains_at..].copy_from_slice(&supply_rates(m, mains, &x[mains_at..], drawn, signal, given_back));
    }
    dx[..n].copy_from_slice(qd);
    dx[n..2 * n].copy_from_slice(&qdd);
    Some(dx)
}
