"""Conditions of the benchmark of tip control: load, sensors, sampling, and machines other than that of the file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydrocrane.errors import InputError, unknown
from hydrocrane.machine.machine import Machine
from hydrocrane.machine.overrides import Override
from hydrocrane.machine.sensors import SensorFault

FRICTION_KEYS = ("coulomb", "breakaway", "viscous")
# Keys of leakage that are proportional to the flow.
CONDUCTANCES = ("internal-leakage", "external-leakage", "leakage")
# Leakage through a gap is proportional to its cube.
GAP = "leakage-gap"


@dataclass(frozen=True)
class Variant:
    """A machine that differs from that of the file.

    Attributes
    ----------
    overrides : callable
        Function from the machine to its changed keys.
    known : bool
        Whether the controller model has these changes too; otherwise it is that of the file.
    pressures : bool
        Whether the chamber pressures are measured.
    """

    overrides: Callable[[Machine], dict[str, Override]]
    known: bool = False
    pressures: bool = True


def _valves(machine: Machine) -> list[tuple[str, float]]:
    """Keys of the valves' tables, and their strokes, m."""
    strokes = [key for key in machine.keys if key.startswith("valve.") and key.endswith(".stroke")]
    return [(key.removesuffix(".stroke"), float(machine.value(key).si)) for key in strokes]


def at_valves(key: str, value: Callable[[float], float]) -> Callable[[Machine], dict[str, Override]]:
    """The key of every valve with a value as a function of its stroke, m."""
    return lambda machine: {f"{valve}.{key}": value(stroke) for valve, stroke in _valves(machine)}


def _later(machine: Machine) -> dict[str, Override]:
    keys = [f"{valve}.delay" for valve, _ in _valves(machine)]
    return {key: 0.02 + (float(machine.value(key).si) if key in machine.keys else 0.0) for key in keys}


def _supply(share: float) -> Callable[[Machine], dict[str, Override]]:
    return lambda machine: {"supply.pressure": share * machine.supply_pressure}


def _leakage(times: float) -> Callable[[Machine], dict[str, Override]]:
    def overrides(machine: Machine) -> dict[str, Override]:
        factors = dict.fromkeys(CONDUCTANCES, times) | {GAP: times ** (1.0 / 3.0)}
        stated = [key for key in machine.keys if key.rsplit(".", 1)[-1] in factors and ".printed." not in key]
        stated = [key for key in stated if key.startswith(("cylinder.", "valve."))]
        return {key: factors[key.rsplit(".", 1)[1]] * float(machine.value(key).si) for key in stated}

    return overrides


VARIANTS: dict[str, Variant] = {
    "dead band 5 %": Variant(at_valves("command.dead-band", lambda stroke: 0.05 * stroke)),
    "offset 2 %": Variant(at_valves("command.offset", lambda stroke: 0.02 * stroke)),
    "gain 0.8": Variant(at_valves("command.gain", lambda stroke: 0.8)),
    "known dead band 5 %": Variant(at_valves("command.dead-band", lambda stroke: 0.05 * stroke), known=True),
    "supply - 30 %": Variant(_supply(0.7)),
    "leakage x 10": Variant(_leakage(10.0)),
    "spools of 8 Hz": Variant(at_valves("natural-frequency", lambda stroke: 2.0 * np.pi * 8.0), known=True),
    "dead time 50 ms": Variant(at_valves("delay", lambda stroke: 0.05), known=True),
    "valves 20 ms later": Variant(_later),
    "joint sensors only": Variant(lambda machine: {"control.tip.pressures": "estimated"}, known=True, pressures=False),
}


@dataclass(frozen=True)
class Condition:
    """Condition of a task; the defaults are the reference.

    Attributes
    ----------
    payload : float
        At the tip, kg; a task that picks up and releases a load does so with this one.
    sensors : {"ideal", "data-sheet"}
    period : float or None
        Sample time, s; ``None``: that of the controller.
    friction : float
        Factor on the machine's seal friction: Coulomb, break-away and viscous.
    variant : str
        Name of another machine among ``VARIANTS``; empty: the machine of the file.
    drop_out : float
        Time without a reading of any joint sensor, once, in the middle of the motion, s.
    """

    payload: float = 0.0
    sensors: str = "ideal"
    period: float | None = None
    friction: float = 1.0
    variant: str = ""
    drop_out: float = 0.0

    def __post_init__(self) -> None:
        if self.variant and self.variant not in VARIANTS:
            raise unknown("variant of a machine", self.variant, VARIANTS)
        if not 0.0 <= self.drop_out < np.inf:
            raise InputError(f"a drop-out takes a time of zero or more seconds; got {self.drop_out!r}")

    def __str__(self) -> str:
        parts = [
            f"{self.payload:g} kg" if self.payload else "",
            self.sensors if self.sensors != "ideal" else "",
            f"{self.period * 1e3:g} ms" if self.period else "",
            f"friction x {self.friction:g}" if self.friction != 1.0 else "",
            self.variant,
            f"no reading for {self.drop_out * 1e3:g} ms" if self.drop_out else "",
        ]
        return ", ".join(part for part in parts if part) or "reference"

    def overrides(self, machine: Machine) -> dict[str, Override]:
        """Overrides of the crane."""
        return friction_overrides(machine, self.friction) | self._variant_overrides(machine)

    def known(self, machine: Machine) -> Machine:
        """The controller model."""
        known = self.variant and VARIANTS[self.variant].known
        return machine.changed(self._variant_overrides(machine)) if known else machine

    def sensor_faults(self, machine: Machine, time: float, *, by_name: bool = True) -> list[SensorFault]:
        """Faults at `time`, s, for a controller by name or your own one."""
        missing = [f"joint.{joint}.q" for joint in machine.joint_names] if self.drop_out else []
        faults = [SensorFault(signal, "drop-out", time, until=time + self.drop_out) for signal in missing]
        if by_name or not self.variant or VARIANTS[self.variant].pressures:
            return faults
        # A controller by name sees in the machine's file that there are no sensors; others get no readings.
        unmeasured = [f"cylinder.{cylinder}.p{side}" for cylinder in machine.cylinder_names for side in (1, 2)]
        return faults + [SensorFault(signal, "drop-out", 0.0) for signal in unmeasured]

    def _variant_overrides(self, machine: Machine) -> dict[str, Override]:
        return VARIANTS[self.variant].overrides(machine) if self.variant else {}


def friction_overrides(machine: Machine, share: float) -> dict[str, Override]:
    """Overrides that scale the forces of every seal friction in a machine's file by `share`."""
    if share == 1.0:
        return {}
    stated = [key for key in machine.keys if key.startswith("friction.") and key.rsplit(".", 1)[1] in FRICTION_KEYS]
    if not stated:
        raise InputError(f"{machine.name} has no friction that could be scaled")
    return {key: (share * np.asarray(machine.value(key).si)).tolist() for key in stated}
