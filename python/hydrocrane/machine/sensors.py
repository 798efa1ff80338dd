"""Sensors of a machine: their readings and their faults."""

from __future__ import annotations

from dataclasses import dataclass

from hydrocrane import _core
from hydrocrane.arrays import real_array
from hydrocrane.errors import InputError, check_known

SENSORS = tuple(_core.scenario_choices("controller.sensors"))
FAULTS = tuple(_core.scenario_choices("sensor-fault.<name>.kind"))


@dataclass(frozen=True)
class SensorFault:
    """A sensor that fails at `time` (s) and works again from `until` (s) on, if given.

    ``freeze``: the reading stays constant; ``jump``: `size` (SI) is added; ``drop-out``: there is no reading (NaN).

    Examples
    --------
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> signal = list(crane.sensors)[0]
    >>> frozen = hc.SensorFault(signal, "freeze", 1.0)
    >>> print(frozen.kind, frozen.time)
    freeze 1.0
    """

    signal: str
    kind: str
    time: float = 0.0
    size: float = 0.0
    until: float | None = None

    def __post_init__(self) -> None:
        check_known("fault of a sensor", self.kind, FAULTS)
        for name in ("time", "size", "until"):
            value = getattr(self, name)
            if value is not None and real_array(value, name).ndim:
                raise InputError(f"{name} of a sensor's fault must be one number; got {value!r}")
        if self.until is not None and self.until <= self.time:
            raise InputError(f"a sensor's fault must end after it begins; got {self.until:g} s after {self.time:g} s")

    @property
    def entry(self) -> tuple[str, str, float, float, float]:
        """In the form of the core."""
        until = float("inf") if self.until is None else float(self.until)
        return self.signal, self.kind, float(self.time), until, float(self.size)
