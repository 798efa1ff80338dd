"""The sample period that tip control needs to damp the modes of a crane on its oil."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydrocrane.analysis.linear import modes
from hydrocrane.control.named import NamedController
from hydrocrane.errors import HydrocraneError
from hydrocrane.machine.machine import MachineLike, as_machine

# Poses that are looked at, the seed that draws them, and the shares of each joint's range between which they lie.
POSES, SEED, INNER = 24, 0, (0.15, 0.85)
# Speed of the tip before a stop, and speed at which it counts as standing, m/s.
SPEED, AT_REST = 0.3, 5e-3
# Angle by which a mode may turn in a period, rad: the damping gain then is 0.06 per period.
ANGLE = 0.9
# A stop behind two lags of the bandwidth w leaves a speed v with the share (w/omega)^2 in a mode omega. Commands are
# held for a period and excite more, and loads that come and go excite it at once.
BEYOND = 1.5


@dataclass(frozen=True)
class PeriodAdvice:
    """What the linear model of a machine says of the period of tip control.

    Attributes
    ----------
    period : float
        Period of the controller ``tip`` for this machine, s.
    needed : float
        Longest period that damps every mode which a stop excites, s.
    frequency : float
        Frequency of the fastest of these modes, Hz.
    """

    period: float
    needed: float
    frequency: float

    @property
    def too_long(self) -> bool:
        """Whether the period is longer than needed."""
        return self.period > self.needed

    def __str__(self) -> str:
        if not self.too_long:
            return f"control.period {self.period * 1e3:.4g} ms damps all oil modes that stops excite"
        rounded = float(f"{self.needed * 1e3:.1g}") * 1e-3
        shorter = rounded if rounded <= self.needed else float(f"{0.9 * self.needed * 1e3:.1g}") * 1e-3
        return (
            f"an oil mode of {self.frequency:.0f} Hz is hardly damped at control.period {self.period * 1e3:.4g} ms: "
            f'some stops ring for a second or more; cure: control.period = "{shorter * 1e3:.4g} ms"'
        )


def period_advice(machine: MachineLike) -> PeriodAdvice:
    """The period that ``tip`` needs for a machine, from its modes without payload in poses drawn over the workspace.

    Parameters
    ----------
    machine : Machine, str or path

    Examples
    --------
    >>> from hydrocrane.linear import period_advice
    >>> print(period_advice("rig-rottne"))
    control.period 10 ms damps all oil modes that stops excite
    """
    machine = as_machine(machine)
    rng = np.random.default_rng(SEED)
    low, high = machine.joint_limits.T
    fastest = 0.0
    for _ in range(POSES):
        q = low + (high - low) * rng.uniform(*INNER, len(low))
        try:
            found = modes(machine, q, payload=0.0, friction="released")
        except HydrocraneError:
            # A pose that closed valves cannot hold.
            continue
        own = [f for f, state in zip(found.frequency, found.state, strict=True) if state.startswith("joint.")]
        oscillating = [2.0 * math.pi * f for f in own if f > 0.0]
        bandwidth = min([machine.tip_gains["stick-bandwidth"], *oscillating[:1]])
        excited = BEYOND * bandwidth * math.sqrt(SPEED / AT_REST)
        fastest = max([fastest, *(omega for omega in oscillating if omega <= excited)])
    period = NamedController("tip", machine).period
    return PeriodAdvice(period, ANGLE / fastest if fastest > 0.0 else math.inf, fastest / (2.0 * math.pi))
