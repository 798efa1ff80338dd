"""The laboratory crane once more, as a person would write it in Python: for solvers that need the model in their terms.

Independent of the core: it reads the numbers of the machine file and nothing else;
``tests/python/house/test_benches.py`` holds it equal to the core. It runs on NumPy arrays and on CasADi's symbols
alike. Symbols, signs and units as in NOTATION.md; numbers in round brackets are equations of Heinze (2007).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

import hydrocrane as hc

JOINTS = 3
OWN_STATES = 5
CYLINDERS = ("lift", "jib", "extension")
LINKS = ("boom", "jib", "extension")
# Depth, relative to the zone of an end stop, from which on its spring goes on straight.
STRAIGHT = 0.98
# Velocity within which the root in viscous friction is rounded off, m/s.
LEAST_VELOCITY = 1e-9
LEAST_GAS = 1e-9


@dataclass(frozen=True)
class Arrays:
    """What the model needs of a library of arrays: elementary functions by NumPy's names, and four of its own."""

    functions: Any
    where: Callable[[Any, Any, Any], Any]
    column: Callable[[Any], Any]
    matrix: Callable[[list[list[Any]]], Any]
    join: Callable[[list[Any]], Any]
    solve: Callable[[Any, Any], Any]


NUMPY = Arrays(np, np.where, np.asarray, np.array, np.concatenate, np.linalg.solve)


@dataclass(frozen=True)
class Parameters:
    """Numbers of the machine in SI: points in their link's frame, and per cylinder arrays in the order of CYLINDERS."""

    point: dict[str, tuple[float, float]]
    mass: list[float]
    inertia: list[float]
    gravity: float
    four_bar: tuple[float, float]
    cylinder: dict[str, np.ndarray]
    fluid: dict[str, float]
    supply: float
    tank: float


def parameters(machine: hc.Machine) -> Parameters:
    """Read them from a loaded machine."""

    def value(key: str) -> Any:
        return machine.value(key).si

    def each(kind: str, key: str) -> np.ndarray:
        return np.array([value(f"{kind}.{name}.{key}") for name in CYLINDERS])

    places = {key[5:].replace(".point", ""): value(key) for key in machine.keys if ".point." in key}
    places |= {f"{name}.cog": value(f"link.{name}.centre-of-gravity") for name in LINKS}
    points = {name: (float(x), float(z)) for name, (x, z) in places.items()}
    mass = np.array([value(f"link.{name}.mass") for name in LINKS])
    about_frame = np.array([value(f"link.{name}.inertia") for name in LINKS])
    arms = np.array([points[f"{name}.cog"] for name in LINKS])
    return Parameters(
        point=points,
        mass=mass.tolist(),
        inertia=(about_frame - mass * (arms**2).sum(axis=1)).tolist(),
        gravity=value("environment.gravity"),
        four_bar=(value("cylinder.jib.linkage.rocker-length"), value("cylinder.jib.linkage.coupler-length")),
        cylinder=_cylinders(each, value("fluid.density"), value("fluid.viscosity")),
        fluid={name: value(f"fluid.{name}") for name in FLUID},
        supply=value("supply.pressure"),
        tank=value("supply.tank-pressure"),
    )


FLUID = ("bulk-modulus-max", "bulk-c1", "bulk-c2", "bulk-reference-pressure", "vacuum")


def _cylinders(each: Callable[[str, str], np.ndarray], density: float, viscosity: float) -> dict[str, np.ndarray]:
    """Areas, lengths and coefficients of the cylinders with their valves and their friction."""
    bore, rod, port = (each("cylinder", key) for key in ("bore", "rod-diameter", "port-diameter"))
    barrel, piston, rod_length = (each("cylinder", f"{key}-length") for key in ("barrel", "piston", "rod"))
    area_1, area_2, area_port = pi / 4 * bore**2, pi / 4 * (bore**2 - rod**2), pi / 4 * port**2
    gap, gland = each("cylinder", "leakage-gap"), each("cylinder", "gland-length")
    half = (barrel - piston) / 2
    drop = each("valve", "nominal-pressure-drop") / 2
    friction = {key: each("friction", key) for key in ("coulomb", "breakaway", "stribeck-velocity", "viscous")}
    pairs = {f"{key}-{way}": pair[:, i] for key, pair in friction.items() for i, way in enumerate(("out", "in"))}
    return pairs | {
        "area-1": area_1,
        "area-2": area_2,
        "rise-1": density / 2 * ((area_1 / area_port) ** 2 - 1),
        "rise-2": density / 2 * ((area_2 / area_port) ** 2 - 1),
        "half": half,
        "lower": np.maximum(-half, half - rod_length),
        "mid-length": each("cylinder", "barrel-offset")
        + (barrel + piston) / 2
        + rod_length
        + each("cylinder", "rod-offset"),
        "dead": area_port * each("cylinder", "dead-length"),
        "internal": pi * (bore / 2 + gap) * gap**3 / (6 * viscosity * piston),
        "external": pi * (rod / 2 + gap) * gap**3 / (6 * viscosity * gland),
        "zone": each("cylinder", "end-stop.zone"),
        "stop-stiffness": each("cylinder", "end-stop.stiffness"),
        "stop-damping": each("cylinder", "end-stop.damping"),
        "conductance": each("valve", "nominal-flow") / (each("valve", "stroke") * np.sqrt(drop)),
        "transition": each("valve", "transition-pressure"),
        "omega": each("valve", "natural-frequency"),
        "zeta": each("valve", "damping-ratio"),
        # The extension's valve connects port B to the supply while extending; the others have four edges.
        "regenerative": np.array([0.0, 0.0, 1.0]),
        "sigma-0": each("friction", "bristle-stiffness"),
        "sigma-1": each("friction", "bristle-damping"),
        "fade": each("friction", "bristle-damping-velocity"),
    }


def state_derivative(x: Any, u: Any, p: Parameters, a: Arrays = NUMPY) -> Any:
    """dx/dt of the 21 states (the core's order) at constant spool commands u, m."""
    q, qd = [x[i] for i in range(JOINTS)], [x[JOINTS + i] for i in range(JOINTS)]
    p1, p2, xs, vs, z = (x[2 * JOINTS + i :: OWN_STATES] for i in range(OWN_STATES))
    c = {name: a.column(values) for name, values in p.cylinder.items()}
    chain = Chain(q, p, a)
    lengths, gains = chain.cylinders()
    position = a.column(lengths) - c["mid-length"]
    gain = a.column(gains)
    v = gain * x[JOINTS : 2 * JOINTS]

    q_a, q_b = _flows(xs, p1 - c["rise-1"] * v**2, p2 - c["rise-2"] * v**2, c, p, a)
    internal, external = c["internal"] * (p1 - p2), c["external"] * (p2 - p.tank)
    volume_1 = c["dead"] + c["area-1"] * (c["half"] + position)
    volume_2 = c["dead"] + c["area-2"] * (c["half"] - position)
    p1_rate = _bulk_modulus(p1, p, a) / volume_1 * (q_a - internal - c["area-1"] * v)
    p2_rate = _bulk_modulus(p2, p, a) / volume_2 * (c["area-2"] * v - q_b + internal - external)
    friction, z_rate = _lugre(v, z, c, a)
    force = c["area-1"] * p1 - c["area-2"] * p2 + _end_stops(position, v, c, a) - friction
    mass, bias = chain.equations(qd)
    qdd = a.solve(mass, gain * force - bias)
    vs_rate = c["omega"] ** 2 * (u - xs) - 2 * c["zeta"] * c["omega"] * vs
    own = [(p1_rate[i], p2_rate[i], vs[i], vs_rate[i], z_rate[i]) for i in range(JOINTS)]
    return a.join([x[JOINTS : 2 * JOINTS], qdd] + [a.column(list(rates)) for rates in own])


def _flows(xs: Any, p_a: Any, p_b: Any, c: dict[str, Any], p: Parameters, a: Arrays) -> tuple[Any, Any]:
    """Flows into port A and out of port B, (64) with a parabola through zero below the transition pressure."""
    f = a.functions

    def edge(opening: Any, drop: Any) -> Any:
        size, p_tr = f.fabs(drop), c["transition"]
        inner = drop * (3 - size / p_tr) / (2 * f.sqrt(p_tr))
        outer = f.sign(drop) * f.sqrt(f.fmax(size, p_tr))
        return c["conductance"] * opening * a.where(size < p_tr, inner, outer)

    out, back = f.fmax(xs, 0), f.fmax(-xs, 0)
    four = 1 - c["regenerative"]
    into_a = edge(out, p.supply - p_a) - edge(back, p_a - p.tank)
    out_of_b = edge(four * out, p_b - p.tank) - edge(back + c["regenerative"] * out, p.supply - p_b)
    return into_a, out_of_b


def _bulk_modulus(pressure: Any, p: Parameters, a: Arrays) -> Any:
    """(96), and free gas by Boyle's law below zero."""
    f, oil = a.functions, p.fluid

    def liquid(pressure: Any) -> Any:
        share = oil["bulk-c1"] * pressure / oil["bulk-reference-pressure"] + oil["bulk-c2"]
        return oil["bulk-modulus-max"] / 2 * f.log10(share)

    y = f.fmax(1 - pressure / oil["vacuum"], LEAST_GAS)
    at_zero = liquid(0.0)
    gas = at_zero * y * (y - oil["vacuum"] / at_zero * (1 - y))
    return a.where(pressure < 0, gas, liquid(f.fmax(pressure, 0)))


def _lugre(v: Any, z: Any, c: dict[str, Any], a: Arrays) -> tuple[Any, Any]:
    """Friction force (115) and rate of the bristles (116), (117)."""
    f = a.functions

    def pick(name: str) -> Any:
        return a.where(v < 0, c[f"{name}-in"], c[f"{name}-out"])

    level = pick("coulomb") + (pick("breakaway") - pick("coulomb")) * f.exp(-((v / pick("stribeck-velocity")) ** 2))
    z_rate = v - c["sigma-0"] * f.fabs(v) / level * z
    viscous = pick("viscous") * v * f.sqrt(f.sqrt(v**2 + LEAST_VELOCITY**2))
    damping = c["sigma-1"] * f.exp(-((v / c["fade"]) ** 2))
    return c["sigma-0"] * z + damping * z_rate + viscous, z_rate


def _end_stops(position: Any, v: Any, c: dict[str, Any], a: Arrays) -> Any:
    """Force of both end stops on the piston, outward positive."""
    f = a.functions
    inner = f.fmax((c["lower"] + c["zone"] - position) / c["zone"], 0)
    outer = f.fmax((position - c["half"] + c["zone"]) / c["zone"], 0)

    def spring(depth: Any) -> Any:
        inside = f.fmin(depth, STRAIGHT)
        return inside / (1 - inside) + (depth - inside) / (1 - STRAIGHT) ** 2

    push = c["stop-stiffness"] * c["zone"] * (spring(inner) - spring(outer))
    return push - c["stop-damping"] * f.fmin(inner + outer, 1) * v


Vector = tuple[Any, Any]


def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1]


def _dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1]


def _perp(a: Vector) -> Vector:
    return -a[1], a[0]


class Chain:
    """The links at one pose: pillar upright at the origin, boom and jib turning, the extension sliding on the jib."""

    def __init__(self, q: list[Any], p: Parameters, a: Arrays) -> None:
        self.p, self.a, f = p, a, a.functions
        boom, jib = q[0] - pi / 2, q[0] + q[1] - 3 * pi / 2
        self.turn = {"boom": (f.cos(boom), f.sin(boom)), "jib": (f.cos(jib), f.sin(jib))}
        self.turn["extension"] = self.slide = self.turn["jib"]
        self.origin = {"boom": p.point["pillar.boom-joint"]}
        self.origin["jib"] = self.at("boom", p.point["boom.jib-joint"])
        start = p.point["jib.extension-origin"]
        self.origin["extension"] = self.at("jib", (start[0] + q[2], start[1]))

    def at(self, link: str, local: Any) -> Vector:
        """A point of a link in the inertial frame."""
        (cos, sin), (x, z) = self.turn[link], self.origin[link]
        return x + cos * local[0] - sin * local[1], z + sin * local[0] + cos * local[1]

    def point(self, name: str) -> Vector:
        return self.at(name.split(".")[0], self.p.point[name])

    def cylinders(self) -> tuple[list[Any], list[Any]]:
        """Distance of the pins of each cylinder, m, and its slope by the own joint."""
        barrel = self.point("boom.lift-barrel")
        lift = self._pins(_minus(barrel, self.p.point["pillar.lift-rod"]), self._swing("boom", barrel))
        pin, velocity = self.four_bar()
        jib = self._pins(_minus(pin, self.point("boom.jib-barrel")), velocity)
        rod = _minus(self.point("extension.rod"), self.point("jib.extension-barrel"))
        return tuple(zip(lift, jib, self._pins(rod, self.slide), strict=True))

    def _pins(self, between: Vector, velocity: Vector) -> Vector:
        length = self.a.functions.sqrt(_dot(between, between))
        return length, _dot(between, velocity) / length

    def _swing(self, link: str, place: Vector) -> Vector:
        """Velocity of a place that turns with a link, per rate of the link's joint."""
        return _perp(_minus(place, self.origin[link]))

    def four_bar(self) -> tuple[Vector, Vector]:
        """The jib cylinder's rod pin, where rocker and coupler meet, and its velocity per rate of the jib."""
        (r_1, r_2), f = self.p.four_bar, self.a.functions
        rocker, coupler = self.point("boom.rocker-pivot"), self.point("jib.coupler-pivot")
        between = _minus(coupler, rocker)
        square = _dot(between, between)
        along = (r_1**2 - r_2**2 + square) / (2 * square)
        aside = f.sqrt(r_1**2 / square - along**2)
        normal = _perp(between)
        arm = (along * between[0] + aside * normal[0], along * between[1] + aside * normal[1])
        pin = rocker[0] + arm[0], rocker[1] + arm[1]
        rod, swing = _minus(pin, coupler), _perp(arm)
        share = _dot(rod, self._swing("jib", coupler)) / _dot(rod, swing)
        return pin, (share * swing[0], share * swing[1])

    def equations(self, qd: list[Any]) -> tuple[Any, Any]:
        """Mass matrix and bias force of the joints, from the motion of the three centres of gravity."""
        boom, jib = self.origin["boom"], self.origin["jib"]
        turn_1, turn_2 = qd[0], qd[0] + qd[1]
        hinge = _minus(jib, boom)
        mass: list[list[Any]] = [[0.0] * JOINTS for _ in range(JOINTS)]
        bias: list[Any] = [0.0] * JOINTS
        for i, name in enumerate(LINKS):
            place = self.point(f"{name}.cog")
            columns, spins = [self._swing("boom", place)], (1.0, float(i > 0), 0.0)
            columns += [self._swing("jib", place)] if i > 0 else []
            columns += [self.slide] if name == "extension" else []
            inner, outer = (_minus(place, boom), (0.0, 0.0)) if i == 0 else (hinge, _minus(place, jib))
            coriolis = 2 * turn_2 * qd[2] if name == "extension" else 0.0
            pull = [-(turn_1**2) * inner[k] - turn_2**2 * outer[k] + coriolis * _perp(self.slide)[k] for k in (0, 1)]
            for j, column in enumerate(columns):
                bias[j] += self.p.mass[i] * _dot(column, (pull[0], pull[1] + self.p.gravity))
                for k, other in enumerate(columns):
                    mass[j][k] += self.p.mass[i] * _dot(column, other) + self.p.inertia[i] * spins[j] * spins[k]
        return self.a.matrix(mass), self.a.column(bias)
