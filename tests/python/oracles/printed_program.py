"""The right-hand side that the thesis's program computes, stated a second time.

Source: Heinze (2007), program CRANE_MAIN (section 7.2) and data DIMENSION (section 7.3).
Everything the program does is kept, also where the thesis's own equations say otherwise:
gravity acts upwards, inertia tensors count about the centres of gravity, the low-pressure
orifice law jumps, `abs(p)` stands in the bulk modulus, and so on (see
`reproductions/heinze-2007/ERRATA.md`). It shares no code and no method with hydrocrane: planar
vectors are complex numbers `x + 1j z`, stroke derivatives come from a complex step through the
arc-sine chain of equations (17)-(24), and the mechanics from link Jacobians written by hand.

All quantities SI, angles in radians. The state has the thesis's order, six entries per cylinder:
`[q, qd, p1, p2, xs, vs]` for alpha, beta, x3; 18 in all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

GRAVITY = 9.81
DENSITY = 1000.0
BULK_MAX, BULK_PRESSURE, BULK_C1, BULK_C2 = 1e9, 200e5, 90.0, 3.0
SUPPLY, TANK = 140e5, 0.0
SPOOL_STROKE = 0.05
SPOOL_FREQUENCY, SPOOL_DAMPING = 2 * np.pi * 161.2, 0.481
DISCHARGE = 1e-4 / (SPOOL_STROKE * np.sqrt(0.5 * 150e5))  # equation (65)
TRANSITION, BLEND_LOW, BLEND_HIGH = 3e5, 2e5, 4e5
COULOMB, STICTION, STRIBECK, VISCOUS = 100.0, 750.0, 0.005, 3500.0
LEAKAGE_MU, LEAKAGE_GAP, GLAND = 0.6, 1e-4, 0.01
STOP_STIFFNESS = 5e6

PILLAR_JOINT = 0.73j
LIFT_ON_PILLAR, LIFT_ON_BOOM = 0.115 + 0.033j, 0.199 - 0.061j
JIB_CYLINDER_ON_BOOM = 1.519 + 0.214j
ROCKER_ON_BOOM, JIB_JOINT = 2.231 + 0.109j, 2.309 + 0.081j
COUPLER_ON_JIB = -0.035 + 0.094j
ROCKER, COUPLER = 0.182, 0.194
EXTENSION_ON_JIB, EXTENSION_ON_BEAM = 0.255 + 0.207j, 1.058 + 0.107j
TIP_ON_BEAM = 1.136 - 0.051j
MASSES = np.array([68.2, 27.54, 10.11])
CENTRES = np.array([1.085 + 0.082j, 0.403 + 0.097j, 0.678 + 0.004j])
INERTIAS = np.array([118.644, 7.9, 5.942])

STATE_NAMES = tuple(
    name
    for joint, cylinder in (("boom", "lift"), ("jib", "jib"), ("extension", "extension"))
    for name in (
        f"joint.{joint}.q",
        f"joint.{joint}.qd",
        *(f"cylinder.{cylinder}.{part}" for part in ("p1", "p2", "xs", "vs")),
    )
)


@dataclass(frozen=True)
class Cylinder:
    """One cylinder as DIMENSION gives it, lengths in metres."""

    offsets: float
    barrel: float
    piston: float
    rod: float
    bore: float
    rod_diameter: float
    dead_factor: float = 1.0
    leaks_from_piston_side: bool = False
    blends_port_a: bool = False
    regenerative: bool = False

    @property
    def areas(self) -> np.ndarray:
        """Piston-side and rod-side area, m^2."""
        full = np.pi / 4 * self.bore**2
        return np.array([full, full - np.pi / 4 * self.rod_diameter**2])

    @property
    def port_area(self) -> float:
        return np.pi / 4 * 0.01**2

    @property
    def mid_volumes(self) -> np.ndarray:
        """Chamber volumes at mid-stroke, equations (84) and (85), m^3."""
        return 0.02 * self.port_area * self.dead_factor + self.areas * (self.barrel - self.piston) / 2

    @property
    def mid_length(self) -> float:
        """Pin-to-pin length at mid-stroke, equation (2), m."""
        return self.offsets + (self.barrel + self.piston) / 2 + self.rod

    @property
    def leakages(self) -> tuple[float, float]:
        """Internal and external coefficient, equation (99), m^3/(s Pa)."""

        def gap(diameter: float, length: float) -> float:
            return np.pi * (diameter / 2 + LEAKAGE_GAP) * LEAKAGE_GAP**3 / (6 * LEAKAGE_MU * length)

        return gap(self.bore, self.piston), gap(self.rod_diameter, GLAND)


CYLINDERS = (
    Cylinder(0.060, 0.43, 0.1, 0.31, 0.1, 0.04, blends_port_a=True),
    Cylinder(0.130, 0.445, 0.1, 0.31, 0.09, 0.045),
    Cylinder(
        0.080, 0.71, 0.08, 0.71, 0.05, 0.03, dead_factor=np.pi / 4, leaks_from_piston_side=True, regenerative=True
    ),
)


def lift_stroke(alpha):
    """Piston position of cylinder 1 by the law of cosines, equation (40) with the bracket negative."""
    to_pillar, to_boom = LIFT_ON_PILLAR - PILLAR_JOINT, LIFT_ON_BOOM
    psi = -np.arctan(to_pillar.real / to_pillar.imag) - np.arctan(to_boom.imag / to_boom.real)
    a, b = abs(to_pillar), abs(to_boom)
    length = np.sqrt(a * a + b * b - 2 * a * b * np.cos(alpha - psi))
    return length - CYLINDERS[0].mid_length


def jib_stroke(beta):
    """Piston position of cylinder 2 through the torque links, equations (17)-(24), (41), (42)."""
    base = JIB_JOINT - ROCKER_ON_BOOM
    slope = np.arctan(base.imag / base.real)
    theta1 = 1.5 * np.pi - beta + np.arctan(COUPLER_ON_JIB.real / COUPLER_ON_JIB.imag) + slope
    d2 = abs(base) ** 2 + abs(COUPLER_ON_JIB) ** 2 - 2 * abs(base) * abs(COUPLER_ON_JIB) * np.cos(theta1)
    theta2 = np.arccos((ROCKER**2 + COUPLER**2 - d2) / (2 * ROCKER * COUPLER))
    diagonal = np.sqrt(d2)
    epsilon = (
        np.arcsin(abs(COUPLER_ON_JIB) / diagonal * np.sin(theta1))
        + np.arcsin(COUPLER / diagonal * np.sin(theta2))
        + slope
    )
    arm = ROCKER_ON_BOOM - JIB_CYLINDER_ON_BOOM
    dx, dz = arm.real + ROCKER * np.cos(epsilon), arm.imag + ROCKER * np.sin(epsilon)
    return np.sqrt(dx * dx + dz * dz) - CYLINDERS[1].mid_length


def strokes(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Piston positions (3,) in m and their own derivatives dx_i/dq_i (3,)."""
    step = 1e-30
    lift, jib = lift_stroke(q[0] + 1j * step), jib_stroke(q[1] + 1j * step)
    return (np.array([lift.real, jib.real, q[2]]), np.array([lift.imag / step, jib.imag / step, 1.0]))


def beam_offset(x3: float) -> complex:
    """Origin of the telescopic beam in the jib frame, m."""
    return EXTENSION_ON_JIB + CYLINDERS[2].mid_length + x3 - EXTENSION_ON_BEAM


def tip(q: np.ndarray) -> np.ndarray:
    """Crane tip (x, z) in the inertial frame, equation (34), m."""
    boom = np.exp(1j * (q[0] - np.pi / 2))
    jib = -boom * np.exp(1j * q[1])
    point = PILLAR_JOINT + boom * JIB_JOINT + jib * (beam_offset(q[2]) + TIP_ON_BEAM)
    return np.array([point.real, point.imag])


def mechanics(q: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass matrix (3, 3), rate terms (3,) and gravity terms (3,) of `M qdd = rate + gravity + Q`.

    The gravity terms push upwards, as the program's potential energy `-m g z` makes them.
    """
    boom = np.exp(1j * (q[0] - np.pi / 2))
    jib = -boom * np.exp(1j * q[1])
    reach = [CENTRES[1], beam_offset(q[2]) + CENTRES[2]]
    omega2, omega3 = qd[0], qd[0] + qd[1]
    knee, knee_acc = 1j * boom * JIB_JOINT, -(omega2**2) * boom * JIB_JOINT
    jacobians = [[1j * boom * CENTRES[0], 0, 0]]
    accelerations = [-(omega2**2) * boom * CENTRES[0]]
    for r, slides in zip(reach, (0.0, 1.0)):
        swing = 1j * jib * r
        jacobians.append([knee + swing, swing, slides * jib])
        coriolis = slides * 2j * omega3 * qd[2] * jib
        accelerations.append(knee_acc - omega3**2 * jib * r + coriolis)
    jac, acc = np.array(jacobians, dtype=complex), np.array(accelerations)
    spin = np.array([[1.0, 0, 0], [1, 1, 0], [1, 1, 0]])
    mass = np.einsum("k,ki,kj->ij", MASSES, jac.conj(), jac).real + np.einsum("k,ki,kj->ij", INERTIAS, spin, spin)
    rate = -np.einsum("k,ki,k->i", MASSES, jac.conj(), acc).real
    gravity = GRAVITY * MASSES @ jac.imag
    return mass, rate, gravity


def edge_flow(xs: float, dp: float, blends: bool) -> float:
    """Flow through one metering edge with the program's branches, m^3/s."""
    turbulent = DISCHARGE * xs * np.sign(dp) * np.sqrt(abs(dp))
    low = DISCHARGE * xs * dp * abs(dp) / TRANSITION / (2 * np.sqrt(TRANSITION))
    if not blends:
        return turbulent if abs(dp) >= TRANSITION else low
    share = np.clip((abs(dp) - BLEND_LOW) / (BLEND_HIGH - BLEND_LOW), 0.0, 1.0)
    return share * turbulent + (1 - share) * low


def port_flows(cylinder: Cylinder, p: np.ndarray, xs: float, v: float) -> tuple[float, float]:
    """Flow into chamber 1 and out of chamber 2, m^3/s, connector pressure rise subtracted."""
    inner = p - DENSITY / 2 * ((cylinder.areas / cylinder.port_area) ** 2 - 1) * v**2
    if xs >= 0:
        dp1 = SUPPLY - inner[0]
        dp2 = inner[1] - (SUPPLY if cylinder.regenerative else TANK)
    else:
        dp1, dp2 = inner[0] - TANK, SUPPLY - inner[1]
    return edge_flow(xs, dp1, cylinder.blends_port_a), edge_flow(xs, dp2, False)


def pressure_rates(cylinder: Cylinder, p: np.ndarray, xs: float, x: float, v: float) -> np.ndarray:
    """Rates of both chamber pressures, equations (105) and (106), Pa/s."""
    flow_in, flow_out = port_flows(cylinder, p, xs, v)
    internal, external = cylinder.leakages
    across = internal * (p[0] - p[1])
    outside = external * (p[0] if cylinder.leaks_from_piston_side else p[1])
    signs = np.array([1.0, -1.0])
    volumes = cylinder.mid_volumes + signs * cylinder.areas * x
    bulk = 0.5 * BULK_MAX * np.log10(BULK_C1 * np.abs(p) / BULK_PRESSURE + BULK_C2)
    net = np.array([flow_in - across, across - flow_out - outside]) - signs * cylinder.areas * v
    return bulk / volumes * net


def friction(v: float) -> float:
    """Friction force against the motion, N; exactly zero at rest."""
    return VISCOUS * v + np.sign(v) * (COULOMB + STICTION * np.exp(-abs(v) / STRIBECK))


def stop_force(cylinder: Cylinder, x: float) -> float:
    """Spring of the end stop, N, acting from one twentieth of the barrel before the end."""
    free = (cylinder.barrel - cylinder.piston) / 2 - cylinder.barrel / 20
    return -STOP_STIFFNESS * np.sign(x) * max(abs(x) - free, 0.0)


def state_derivative(state: np.ndarray, command: np.ndarray) -> np.ndarray:
    """Rate of the 18 states for three spool commands in metres (the program's `i`)."""
    y = np.asarray(state, dtype=float).reshape(3, 6)
    q, qd, p, xs, vs = y[:, 0], y[:, 1], y[:, 2:4], y[:, 4], y[:, 5]
    x, slope = strokes(q)
    v = slope * qd
    force = np.array(
        [
            p[i, 0] * c.areas[0] - p[i, 1] * c.areas[1] + stop_force(c, x[i]) - friction(v[i])
            for i, c in enumerate(CYLINDERS)
        ]
    )
    mass, rate, gravity = mechanics(q, qd)
    out = np.empty((3, 6))
    out[:, 0] = qd
    out[:, 1] = np.linalg.solve(mass, rate + gravity + slope * force)
    for i, c in enumerate(CYLINDERS):
        out[i, 2:4] = pressure_rates(c, p[i], xs[i], x[i], v[i])
    out[:, 4] = vs
    out[:, 5] = SPOOL_FREQUENCY**2 * (np.asarray(command) - xs) - 2 * SPOOL_DAMPING * SPOOL_FREQUENCY * vs
    return out.ravel()
