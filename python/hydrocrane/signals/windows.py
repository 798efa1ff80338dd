"""Windows of steady motion, the result of the search and the input of identification."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast, overload

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.asked import ask
from hydrocrane.logs.log import Log
from hydrocrane.logs.signals import Flag
from hydrocrane.signals.friction import RigParameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Window:
    """One stretch of constant velocity with its friction.

    Attributes
    ----------
    start, end : float
        s.
    velocity, velocity_error : float
        Mean and its standard error, m/s; positive extending.
    force, force_error : float
        Mean friction force and its standard error, N; positive against positive velocity.
    direction : int
        1 extending, -1 retracting.
    samples : int
    effective_samples : float
        Number of independent samples with the same error of the force.
    chambers : (float, float)
        Means of p1 A1 and p2 A2, N.
    position : float
        Mean of x, m.
    before : float
        Displacement from the beginning of the motion to the window, m.
    """

    start: float
    end: float
    velocity: float
    velocity_error: float
    force: float
    force_error: float
    direction: int
    samples: int
    effective_samples: float = float("nan")
    chambers: tuple[float, float] | None = None
    position: float = float("nan")
    before: float = float("nan")


@dataclass(frozen=True)
class Rejected:
    """A stretch of the log that is no window, with the reason."""

    start: float
    end: float
    velocity: float
    reason: str


@dataclass(frozen=True)
class SteadyWindows(Sequence[Window]):
    """The windows of one log, in the order of time; a sequence of :class:`Window`.

    Attributes
    ----------
    windows : tuple of Window
    rejected : tuple of Rejected
    flags : tuple of Flag
        Flags of the log and of the whole set of windows.
    log : Log
    rig : RigParameters
    load_cell : bool
    """

    windows: tuple[Window, ...]
    rejected: tuple[Rejected, ...]
    flags: tuple[Flag, ...]
    log: Log
    rig: RigParameters
    load_cell: bool = False

    def __len__(self) -> int:
        return len(self.windows)

    def __iter__(self) -> Iterator[Window]:
        return iter(self.windows)

    @overload
    def __getitem__(self, index: int) -> Window: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Window, ...]: ...
    def __getitem__(self, index: int | slice) -> Window | tuple[Window, ...]:
        return self.windows[index]

    def summary(self) -> str:
        """Windows, rejected stretches and flags as a table."""
        lines = ["   from      to    velocity [mm/s]       friction [N]     samples"]
        for w in self.windows:
            speed = f"{w.velocity * 1e3:9.4f} +- {w.velocity_error * 1e3:.4f}"
            lines.append(f"{w.start:7.3f} {w.end:7.3f}  {speed}  {w.force:9.1f} +- {w.force_error:.1f}  {w.samples:7d}")
        lines += [f"{r.start:7.3f} {r.end:7.3f}  left out: {r.reason}" for r in self.rejected]
        return "\n".join(lines + [str(flag) for flag in self.flags])

    def plot(self) -> Figure:
        """The log with its windows, and friction over velocity."""
        return cast("Figure", ask("plots", "steady-windows", self))


def friction_over_velocity(windows: Sequence[Window]) -> tuple[Array, Array, Array]:
    """Velocities, forces and standard errors of the forces (k,) of windows, sorted by velocity; m/s, N, N."""
    ordered = sorted(windows, key=lambda w: w.velocity)
    columns = np.array([[w.velocity, w.force, w.force_error] for w in ordered], dtype=np.float64).reshape(-1, 3)
    return columns[:, 0], columns[:, 1], columns[:, 2]
