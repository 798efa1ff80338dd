"""The payload against time, and the effect of a change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hydrocrane._core_types import PayloadEntry
from hydrocrane.arrays import real_array
from hydrocrane.errors import InputError


@dataclass(frozen=True)
class PayloadChange:
    """A load picked up, or released, by the tip.

    Attributes
    ----------
    time : float
        s.
    before, after : float
        Payload, kg.
    velocity_before, velocity_after : (x, z), of a machine in space (x, y, z)
        Of the tip, m/s. A load that is picked up is at rest and brakes the tip at once; a release changes nothing.
    loss : float
        Kinetic energy that the impact turned into heat, J.

    Examples
    --------
    >>> run = hc.simulate("vertical-lift-open-loop", payload_changes={1.0: 50.0}, duration=1.5)
    >>> change = run.payload_changes[0]
    >>> print(change.time, change.before, change.after, change.loss > 0.0)
    1.0 0.0 50.0 True
    """

    time: float
    before: float
    after: float
    velocity_before: tuple[float, ...]
    velocity_after: tuple[float, ...]
    loss: float

    @classmethod
    def of(cls, entry: PayloadEntry) -> PayloadChange:
        """From the core's entry, also after a conversion to JSON and back.

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", payload_changes={0.05: 50.0}, duration=0.1)
        >>> print(run.payload_changes[0].after)
        50.0
        """
        time, (before, after), (incoming, outgoing), loss = entry
        speeds = [tuple(float(v) for v in velocity) for velocity in (incoming, outgoing)]
        return cls(float(time), float(before), float(after), speeds[0], speeds[1], float(loss))

    @property
    def text(self) -> str:
        """In words."""
        if self.after <= self.before:
            return f"releases {self.before - self.after:g} kg; payload {self.after:g} kg"
        speeds = [float(np.linalg.norm(v)) for v in (self.velocity_before, self.velocity_after)]
        braked = f"tip from {speeds[0]:.3g} to {speeds[1]:.3g} m/s, {self.loss:.3g} J lost"
        return f"picks up {self.after - self.before:g} kg; payload {self.after:g} kg, {braked}"


def payload_changes(given: object) -> dict[float, float]:
    """Time (s) to payload (kg) from then on, in order of time."""
    if not isinstance(given, Mapping):
        raise InputError(
            f"payload_changes must map times, s, to the payload from then on, kg, like {{2.0: 100.0}}; got {given!r}"
        )
    changes = {}
    for time, mass in given.items():
        t, m = real_array(time, "time of a payload change"), real_array(mass, f"payload at {time} s")
        if t.ndim or t <= 0:
            raise InputError(
                f"the payload changes at one time above zero, in s (`payload` is that of the start); got {time!r}"
            )
        if m.ndim or m < 0:
            raise InputError(f"the payload at {time:g} s must be one mass in kg, zero or more; got {mass!r}")
        changes[float(t)] = float(m)
    return dict(sorted(changes.items()))
