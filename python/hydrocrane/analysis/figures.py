"""Figures of a machine by which people see that a value is wrong, and what they say."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydrocrane.analysis.linear import modes
from hydrocrane.arrays import Array
from hydrocrane.errors import HydrocraneError
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.poses import SHOWN
from hydrocrane.result_warning import ResultWarning

# Poses per joint for that share, fewer with many joints; all of them are a few thousand at most.
_POSES, _MOST = 13, 3000
# Least range of a joint, in the unit of its SHOWN entry, and least share of its cylinder's stroke in it, unless the
# file says so: nobody buys a cylinder of twice the stroke that its pins allow. All bundled machines use nine tenths.
_LEAST = {"rad": 15.0, "m": 10.0}
_SHARE = 0.5
# A linkage that would turn so many times as far on its other side is on the wrong one.
_MIRRORED = 3.0
# Tables of valves that hold a load.
_HOLDING = "counterbalance", "pilot-check", "hose-burst"
# Pressure of the piston side that counts as a load, Pa.
_LIGHT = 1e5
# Share of a stated range that a stroke may cut: limits are written with two or three digits.
_ROUNDED = 0.01
# Share of its reach by which a tip may give way under the weight, because oil is compressed.
_SAG = 0.25
# A slide that travels so many times the travel of its piston has its cylinder at more than 45 degrees, as a mean.
_ACROSS = math.sqrt(2.0)
# Closing flow of a hose-burst valve that never closes.
_NEVER = "5000 l/min"


@dataclass(frozen=True)
class Figures:
    """A machine with its own payload at rest in the middle of all joint ranges.

    Attributes
    ----------
    force : (n_cyl,) array
        What each cylinder holds, N; positive pushes the piston out.
    pressure : (n_cyl,) array
        Pressure that this needs with the other side at that of the tank, Pa.
    carried : (n_cyl,) array
        Share of poses over all joint ranges in which the supply and the relief valves hold as much.
    speed : (n_cyl, 2) array
        Lowest and highest steady piston speed at full stroke of the valve, m/s.
    time : tuple of float or None
        Of the whole stroke at the slower of both, s; None where the cylinder cannot move both ways.
    mode : float or None
        Lowest natural frequency of links on oil, Hz.
    sag : float
        By how much the tip gives way under the weight at that frequency, m.
    oil : str
        Density and viscosities in words.
    """

    force: Array
    pressure: Array
    carried: Array
    speed: Array
    time: tuple[float | None, ...]
    mode: float | None
    sag: float
    oil: str


def figures(machine: Machine) -> Figures:
    """The figures that ``hydrocrane check`` prints.

    Examples
    --------
    >>> found = figures(hc.load_machine("rottne-f9-lab"))
    >>> print(found.pressure.round(-5), round(found.mode, 1))
    [1000000.       0.  100000.] 11.1
    """
    q = machine.home
    force = machine.static_cylinder_force(q)
    speed = machine.piston_speeds(q)
    strokes = machine.stroke_limits[:, 1] - machine.stroke_limits[:, 0]
    slowest = np.where((speed[:, 0] < 0.0) & (speed[:, 1] > 0.0), np.abs(speed).min(axis=1), 0.0)
    mode = _lowest(machine)
    gravity = float(np.asarray(machine.value("environment.gravity").si))
    everywhere = machine.static_cylinder_force(_grid(machine))
    return Figures(
        force=force,
        pressure=_pressure(machine, force),
        carried=(_pressure(machine, everywhere) <= _most(machine, everywhere)).mean(axis=0),
        speed=speed,
        time=tuple(float(s / v) if v > 0.0 else None for s, v in zip(strokes, slowest, strict=True)),
        mode=mode,
        sag=gravity / (2.0 * math.pi * mode) ** 2 if mode else 0.0,
        oil=_oil(machine),
    )


def _pressure(machine: Machine, force: Array) -> Array:
    """Of the loaded side with the other one at the pressure of the tank (..., n_cyl), Pa."""
    areas = machine.piston_areas
    tank = float(np.asarray(machine.value("supply.tank-pressure").si))
    pushed = (force + tank * areas[:, 1]) / areas[:, 0]
    pulled = (tank * areas[:, 0] - force) / areas[:, 1]
    return np.where(force >= 0.0, pushed, pulled)


def _most(machine: Machine, force: Array) -> Array:
    """Highest pressure that the side which bears `force` (..., n_cyl) can be held at, Pa."""
    piston_side, rod_side = machine.holdable_pressures.T
    return np.where(force >= 0.0, piston_side, rod_side)


def _grid(machine: Machine) -> Array:
    """Poses over all joint ranges, with their ends."""
    n = len(machine.joint_names)
    along = max(2, min(_POSES, int(_MOST ** (1.0 / n))))
    axes = [np.linspace(low, high, along) for low, high in machine.joint_limits]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, n)


def _lowest(machine: Machine) -> float | None:
    """Lowest frequency of a mode that is mostly in a joint, Hz; None where nothing swings, or nothing is at rest."""
    try:
        found = modes(machine, machine.home, friction="released")
    except HydrocraneError:
        return None
    of_joints = [f for f, state in zip(found.frequency, found.state, strict=True) if state.startswith("joint.")]
    return float(min(of_joints)) if of_joints else None


def _oil(machine: Machine) -> str:
    density, viscosity = (float(np.asarray(machine.value(f"fluid.{key}").si)) for key in ("density", "viscosity"))
    return f"{density:g} kg/m^3, {viscosity:.3g} Pa s, which is {1e6 * viscosity / density:.3g} cSt"


def doubts(machine: Machine, found: Figures) -> tuple[ResultWarning, ...]:
    """What no machine of this kind has, with its cure; kind ``implausible-value``."""
    texts = [
        *_cut(machine), *_narrow(machine), *_across(machine), *_weak(machine, found), *_idle(machine),
        *_closing(machine), *_soft(machine, found),
    ]  # fmt: skip
    return tuple(ResultWarning("implausible-value", text, cure) for text, cure in texts)


def _cut(machine: Machine) -> list[tuple[str, str]]:
    """Joints whose cylinders do not reach the limits that the file states."""
    texts = []
    for i, joint in enumerate(machine.joint_names):
        if f"joint.{joint}.limits" not in machine.keys:
            continue
        shown, size = SHOWN[machine.joint_units[i]]
        stated, (low, high) = np.asarray(machine.value(f"joint.{joint}.limits").si), machine.joint_limits[i]
        if high - low >= (1.0 - _ROUNDED) * (stated[1] - stated[0]):
            continue
        cylinder = machine.cylinder_names[i]
        texts.append((
            f"joint.{joint}.limits are {stated[0] / size:.4g} and {stated[1] / size:.4g} {shown}, but cylinder "
            f"`{cylinder}` has {1e3 * _stroke(machine, i):.4g} mm of stroke, which are {low / size:.4g} to "
            f"{high / size:.4g} {shown}",
            f"check the stroke, the lengths and the pins of cylinder.{cylinder}, `limits` and their units",
        ))  # fmt: skip
    return texts


def _narrow(machine: Machine) -> list[tuple[str, str]]:
    """Joints that hardly move."""
    texts = []
    for i, joint in enumerate(machine.joint_names):
        shown, size = SHOWN[machine.joint_units[i]]
        width = float(machine.joint_limits[i, 1] - machine.joint_limits[i, 0])
        moved = float(machine.stroke_limits[i, 1] - machine.stroke_limits[i, 0])
        stroke, cylinder = _stroke(machine, i), machine.cylinder_names[i]
        mirrored = _mirrored(machine, i)
        if mirrored is not None and mirrored > _MIRRORED * width:
            texts.append((
                f"joint.{joint} moves by {width / size:.3g} {shown} only, with the linkage on its other side by "
                f"{mirrored / size:.3g} {shown}",
                f"check cylinder.{cylinder}.linkage.side",
            ))  # fmt: skip
            continue
        stated = "machine file" in machine.joint_limit_reasons[i]
        if width / size >= _LEAST[machine.joint_units[i]] and (stated or moved >= _SHARE * stroke):
            continue
        reasons = " and ".join(dict.fromkeys(machine.joint_limit_reasons[i]))
        texts.append((
            f"joint.{joint} moves by {width / size:.3g} {shown} only, {1e3 * moved:.3g} of the {1e3 * stroke:.4g} mm "
            f"stroke of cylinder `{cylinder}`; its limits come from: {reasons}",
            f"check the pins and lengths of cylinder.{cylinder}, the `side` of its linkage, `limits` and their units",
        ))  # fmt: skip
    return texts


def _across(machine: Machine) -> list[tuple[str, str]]:
    """Slides whose cylinder stands across them."""
    widths, moved = (np.diff(limits, axis=1)[:, 0] for limits in (machine.joint_limits, machine.stroke_limits))
    return [
        (
            f"joint.{joint} slides by {1e3 * width:.4g} mm, while the piston of cylinder `{cylinder}` moves by "
            f"{1e3 * travel:.4g} mm: the cylinder stands across the slide",
            f"check joint.{joint}.direction and its unit, and the pins of cylinder.{cylinder}",
        )
        for joint, cylinder, unit, width, travel in zip(
            machine.joint_names, machine.cylinder_names, machine.joint_units, widths, moved, strict=True
        )
        if unit == "m" and width > _ACROSS * travel
    ]


def _mirrored(machine: Machine, cylinder: int) -> float | None:
    """Range of the joint with its linkage on the other side, rad; None without one, or where that cannot close."""
    key = f"cylinder.{machine.cylinder_names[cylinder]}.linkage.side"
    side = dict(machine.core.words).get(key)
    if side is None:
        return None
    try:
        low, high = machine.changed({key: "left" if side == "right" else "right"}).joint_limits[cylinder]
    except HydrocraneError:
        return None
    return float(high - low)


def _stroke(machine: Machine, cylinder: int) -> float:
    """Travel of a piston between its stops, m."""
    table = f"cylinder.{machine.cylinder_names[cylinder]}"
    if f"{table}.stroke" in machine.keys:
        return float(np.asarray(machine.value(f"{table}.stroke").si))
    barrel, piston = (machine.value(f"{table}.{part}-length").si for part in ("barrel", "piston"))
    return float(np.asarray(barrel) - np.asarray(piston))


def _weak(machine: Machine, found: Figures) -> list[tuple[str, str]]:
    """Cylinders that cannot carry the crane in the middle of all ranges."""
    there_is = _most(machine, found.force)
    return [
        (
            f"cylinder.{name} needs {1e-5 * pressure:.4g} bar to hold {1e-3 * force:.3g} kN in the middle of all joint "
            f"ranges, with {machine.payload_mass:g} kg at the tip, and supply and relief valves hold {1e-5 * most:.4g} "
            "bar there: it cannot lift",
            "check the supply pressure, the settings of relief valves, the bore, the pins, the masses and the payload, "
            "with their units",
        )
        for name, force, pressure, most in zip(
            machine.cylinder_names, found.force, found.pressure, there_is, strict=True
        )
        if pressure > most
    ]


def _idle(machine: Machine) -> list[tuple[str, str]]:
    """Load-holding valves of cylinders whose load always rests on the other side, which has none."""
    words = dict(machine.core.words)
    tables = [key.removesuffix(".side") for key in words if key.endswith(".side") and key.split(".")[0] in _HOLDING]
    if not tables:
        return []
    held = {table: (words[f"{table}.cylinder"], words[f"{table}.side"]) for table in tables}
    # A slope is where a machine stands, not what it is built for.
    level = machine.changed({"environment.slope": "0 deg"}) if "environment.slope" in machine.keys else machine
    poses = _grid(level)
    force = np.concatenate([level.static_cylinder_force(poses), level.static_cylinder_force(poses, payload=0.0)])
    light = _LIGHT * level.piston_areas[:, 0]
    rests = {"piston-side": force.min(axis=0) > light, "rod-side": force.max(axis=0) < -light}
    return [
        (
            f"{table} holds the {side} of cylinder `{cylinder}`, and its load rests on the {other} in all poses",
            f"check {table}.side, and the pins of the cylinder",
        )
        for table, (cylinder, side) in held.items()
        for other in rests
        if other != side
        and (cylinder, other) not in held.values()
        and rests[other][machine.cylinder_names.index(cylinder)]
    ]


def _closing(machine: Machine) -> list[tuple[str, str]]:
    """Hose-burst valves that close in an ordinary motion, at full stroke of the valve in the middle of all ranges."""
    words = dict(machine.core.words)
    texts = []
    for table in [
        key.removesuffix(".side") for key in words if key.startswith("hose-burst.") and key.endswith(".side")
    ]:
        cylinder, side = words[f"{table}.cylinder"], words[f"{table}.side"]
        i, piston = machine.cylinder_names.index(cylinder), side == "piston-side"
        opened = machine.changed({f"{table}.closing-flow": _NEVER}).piston_speeds(machine.home)[i]
        left = -opened[0] * machine.piston_areas[i, 0] if piston else opened[1] * machine.piston_areas[i, 1]
        closing = float(np.asarray(machine.value(f"{table}.closing-flow").si))
        if left > closing:
            texts.append((
                f"{table} closes at {6e4 * closing:.4g} l/min, and at full stroke of its valve {6e4 * left:.4g} l/min "
                f"leave the {side} of cylinder `{cylinder}` in the middle of all ranges: it stops this motion",
                f"check {table}.closing-flow and its unit: it lies above any flow that is wanted",
            ))  # fmt: skip
    return texts


def _soft(machine: Machine, found: Figures) -> list[tuple[str, str]]:
    """A tip that the compressed oil lets sink by a large share of its reach."""
    reach = float(np.linalg.norm(machine.tip(machine.home)))
    if found.mode is None or found.sag <= _SAG * reach:
        return []
    return [(
        f"the lowest natural frequency of links on oil is {found.mode:.3g} Hz: compressed oil alone would let the tip "
        f"give way by {found.sag:.3g} m at a reach of {reach:.3g} m",
        "check masses and payload, fluid.bulk-modulus, the dead volumes and the bores, with their units",
    )]  # fmt: skip
