"""What a run gives back: its data, how it ended, and what can be done with it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from hydrocrane import files, summary
from hydrocrane.errors import ResultFileError
from hydrocrane.payload import PayloadChange
from hydrocrane.result_warning import ResultWarning, from_json
from hydrocrane.verification import Verification

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure

    from hydrocrane.compare import Comparison
    from hydrocrane.machine import Machine

KINDS = ("completed", "stroke-limit", "solver-failed", "controller-failed", "bad-state", "interrupted")


@dataclass(frozen=True)
class Outcome:
    """How and when a run ended.

    Attributes
    ----------
    kind : str
        completed, stroke-limit, solver-failed, controller-failed, bad-state or interrupted.
    time : float
        s.
    message : str
        What happened and what helps; empty for a completed run.
    """

    kind: str
    time: float
    message: str

    @property
    def completed(self) -> bool:
        return self.kind == "completed"


@dataclass(frozen=True)
class Event:
    """Something worth knowing that happened at `time` (s) of a run, such as a controller without a usable command.

    `warning` is the kind of the warning that the event tells, and empty for any other event.
    """

    time: float
    text: str
    warning: str = ""


class Run:
    """The record of a run.

    Attributes
    ----------
    data : xarray.Dataset
        Over ``time``: every state by its name, ``tip.x``, ``tip.z``,
        ``cylinder.<c>.{x,v,force,friction,q1,q2,command}``, ``supply.{flow,power}``, ``payload``, ``ledger.*``; each
        with ``units`` and ``long_name``. Closed-loop runs add ``measured.*``, ``stick.*``, ``controller.<c>`` and,
        where the controller has one, ``set_point.{x,z}`` and ``tip.deviation``.
    """

    def __init__(self, data: xr.Dataset, machine: Machine | None = None) -> None:
        self.data = data
        self._machine = machine

    def __repr__(self) -> str:
        about = self.data.attrs
        return f"<Run {about['scenario']} on {about['machine']}: {self.outcome.kind} at {self.outcome.time:.4g} s>"

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Run:
        """Read a run saved as NetCDF."""
        return cls(files.load_netcdf(Path(path)))

    @cached_property
    def outcome(self) -> Outcome:
        about = self.data.attrs
        return Outcome(str(about["outcome"]), float(about["outcome_time"]), str(about["outcome_message"]))

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened on the way, in order of time: trouble of a controller, loads taken up and let go, warnings."""
        own = [Event(float(time), str(text)) for time, text in json.loads(self.data.attrs.get("events", "[]"))]
        doubts = [Event(warning.time, f"warning: {warning}", warning.kind) for warning in self.warnings]
        return tuple(sorted([*own, *doubts], key=lambda event: event.time))

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """Why the run may be wrong, in order of time, with cause and cure; see docs/reference/warnings.md."""
        return from_json(self.data.attrs.get("warnings", "[]"))

    @property
    def verification(self) -> Verification | None:
        """How the run differs from a tighter repeat; ``None`` where it was run without ``verify``."""
        found = json.loads(self.data.attrs.get("verification", "null"))
        return None if found is None else Verification(**found)

    @property
    def payload_changes(self) -> tuple[PayloadChange, ...]:
        """Loads taken up and let go, in order of time; rows at such a time have the state before it."""
        return tuple(PayloadChange.of(entry) for entry in json.loads(self.data.attrs.get("payload_changes", "[]")))

    @property
    def machine(self) -> Machine:
        """The machine that ran; a loaded run fetches it again by its source and overrides."""
        if self._machine is None:
            from hydrocrane.machine import load_machine

            about = self.data.attrs
            source = about["machine_source"]
            if ("/" in source or "\\" in source) and not Path(source).is_file():
                raise ResultFileError(f"this run's machine file {source} is gone; its data can still be read")
            self._machine = load_machine(source, json.loads(about["machine_overrides"]))
        return self._machine

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(json.loads(self.data.attrs["joint_names"]))

    @property
    def cylinder_names(self) -> tuple[str, ...]:
        return tuple(json.loads(self.data.attrs["cylinder_names"]))

    def summary(self) -> str:
        """A few lines of text: outcome, effort, tip, cylinders, energy."""
        return summary.text(self)

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the data; the suffix decides: ``.nc``, ``.mat``, ``.csv`` or ``.parquet``."""
        return files.save(self.data, Path(path))

    def plot(self, cylinder: str | None = None, *, path: str | PathLike[str] | None = None) -> Figure:
        """Charts as Figures 86-88 of the thesis: six for one cylinder, or those of all cylinders side by side.

        With `path` the picture is also written.
        """
        from hydrocrane.plots import charts

        figure = charts.overview(self) if cylinder is None else charts.cylinder_charts(self, cylinder)
        if path is not None:
            charts.write(figure, Path(path))
        return figure

    def animate(
        self,
        path: str | PathLike[str] | None = None,
        *,
        fps: int = 20,
        speed: float = 1.0,
        progress: Callable[[int, int], None] | None = None,
    ) -> Path | FuncAnimation:
        """Animate the crane as Figure 89: pillar, links, cylinders, torque linkage and the way of the tip.

        Parameters
        ----------
        path : path, optional
            ``.gif``, or ``.mp4`` where ffmpeg is found; without it the matplotlib animation is returned.
        fps : int
            Pictures per second of the film.
        speed : float
            1 is real time, 2 twice as fast.
        progress : callable, optional
            Called with (pictures done, pictures in all).
        """
        from hydrocrane.plots import animation

        if path is None:
            return animation.film(self, fps=fps, speed=speed)
        return animation.write(self, Path(path), fps=fps, speed=speed, progress=progress)

    def compare(self, log: Any, columns: Mapping[str, str] | None = None, *, shift: float = 0.0) -> Comparison:
        """Lay a measured log over this run; see :func:`hydrocrane.compare.compare`."""
        from hydrocrane.compare import compare

        return compare(self, log, columns, shift=shift)


def load_run(path: str | PathLike[str]) -> Run:
    """Read a run saved as NetCDF."""
    return Run.load(path)
