"""Result of a fit: values with intervals, as a part of a machine file too, agreement, and what is not identifiable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from hydrocrane.arrays import Array, check_level, rms
from hydrocrane.asked import ask
from hydrocrane.errors import check_known
from hydrocrane.identification.report import (
    Report,
    Section,
    Table,
    comment,
    fitted_key,
    interval,
    signature,
    write_part,
)
from hydrocrane.identification.solve import labelled
from hydrocrane.identification.values.doubts import Accuracy, Information, SignalQuality, doubts
from hydrocrane.identification.values.models import modelled_signals
from hydrocrane.identification.values.parameters import Tie, left_behind
from hydrocrane.identification.values.search import FitTask, SearchResult
from hydrocrane.machine.machine import Machine
from hydrocrane.notebook import of_text
from hydrocrane.results.comparison import Difference
from hydrocrane.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def block(
    machine: Machine,
    known: Mapping[str, tuple[float, float]],
    logs: Sequence[str],
    motion: str,
    warnings: Sequence[str],
    date: str = "",
) -> str:
    """Tables of the keys in `known`, with their values in `machine`, class ``fitted``, source and intervals, SI."""
    names = ", ".join(dict.fromkeys(logs))
    source = f"{names}; fit of a {motion} motion, {signature(date)}"
    lines = [comment(f"Fitted to {names}; put it beside the machine file and add it to `include`.")]
    lines += [comment(f"warning: {warning}") for warning in warnings]
    tables: dict[str, list[str]] = {}
    for path in dict.fromkeys(key.partition("[")[0] for key in known):
        table, _, name = path.rpartition(".")
        mine = [key for key in known if key.partition("[")[0] == path]
        ends = " and ".join(f"{key.removeprefix(path)} {interval(*known[key])}".strip() for key in mine)
        tables.setdefault(table, []).append(fitted_key(name, _written(machine, path), source, ends))
    for table, rows in tables.items():
        lines += ["", f"[{table}]", *rows]
    return "\n".join(lines) + "\n"


def _written(machine: Machine, path: str) -> str:
    """A value, or both values of a pair, in the notation of a machine file."""
    stated = machine.value(path)
    texts = [f'"{v:.6g} {stated.unit}"' if stated.unit else f"{v:.6g}" for v in np.atleast_1d(stated.si).tolist()]
    return f"[{', '.join(texts)}]" if len(texts) > 1 else texts[0]


UNCHECKED = (
    "no log can check what is wrong with all of it alike: a clock that runs too fast or slow, positions on a wrong "
    "scale, the gain of the only sensor of a quantity; these change the fitted values and leave no residuals"
)


@dataclass(frozen=True)
class Fit:
    """A finished fit.

    Attributes
    ----------
    scenario : Scenario
    start : Machine
        With the values that the fit began from.
    motion : str
        ``simulated`` or ``measured``.
    accuracy : Accuracy or None
        Tolerance of the runs, and what a repeat with a tighter one says; None for a measured motion, which has no runs.
    notes : tuple of str
        Remarks about the logs.
    ties : tuple of Tie
        Keys that changed in proportion to fitted ones.
    looks : tuple of str
        What the residuals look like, of effects that are not fitted.

    Examples
    --------
    >>> log = hc.simulate("single-cylinder-step", overrides={"supply.pressure": "95 bar"}).data
    >>> found = hc.fit("single-cylinder-step", log, ["supply.pressure"], signals=["cylinder.test.x"])
    >>> print(f"{found.value('supply.pressure') / 1e5:.0f} bar, by {found.quality[0].signal}")
    95 bar, by cylinder.test.x
    """

    scenario: Scenario
    start: Machine
    found: SearchResult = field(repr=False)
    information: Information = field(repr=False)
    motion: str
    accuracy: Accuracy | None = None
    notes: tuple[str, ...] = ()
    ties: tuple[Tie, ...] = ()
    looks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<Fit of {len(self.names)} parameters to {len(self.task.models)} logs: {self._ended}>"

    def _repr_html_(self) -> str:
        return of_text(self.summary(), "print(fit.summary())")

    @property
    def task(self) -> FitTask:
        """Unknowns, models and logs."""
        return self.found.task

    @property
    def names(self) -> tuple[str, ...]:
        """All unknowns: keys, then errors of sensors."""
        return self.found.estimate.names

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of the machine file among the unknowns."""
        known = set(self.start.keys)
        return tuple(name for name in self.names if name.partition("[")[0] in known)

    @property
    def values(self) -> dict[str, float]:
        """Fitted value of every unknown, SI."""
        return dict(zip(self.names, self.found.estimate.values.tolist(), strict=True))

    def value(self, name: str) -> float:
        """Fitted value of one unknown, SI."""
        return self.values[self._checked(name)]

    def unit(self, name: str) -> str:
        """SI unit of an unknown; empty for a plain number."""
        path = self._checked(name).partition("[")[0]
        if path in self.start.keys:
            return self.start.value(path).unit
        signal, _, kind = path.rpartition(".")
        return {"span": "", "delay": "s"}.get(kind, self._units.get(signal, ""))

    def prior(self, name: str) -> float:
        """Value of one unknown before the fit, SI."""
        return self.task.unknowns[self.names.index(self._checked(name))].start

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Interval of one unknown, SI, at a level of confidence; priors count as data."""
        check_level(level)
        at = self.names.index(self._checked(name))
        half = self.information.factor(level) * float(self.information.deviations[at])
        low, high = self.task.unknowns[at].bounds
        value = self.value(name)
        return max(value - half, low), min(value + half, high)

    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Intervals of all unknowns, SI."""
        return {name: self.interval(name, level) for name in self.names}

    @property
    def correlation(self) -> xr.DataArray:
        """(k, k) correlations of the unknowns."""
        return labelled(self.names, self.information.correlation)

    @property
    def cannot_tell(self) -> tuple[str, ...]:
        """Combinations of parameters that the logs identify no better than the priors."""
        return self.information.not_identifiable

    @cached_property
    def machine(self) -> Machine:
        """The machine with the fitted values."""
        moved = {key: self.value(key) for key in self.keys}
        moved |= {tie.key: tie.ratio * self.value(tie.leader) for tie in self.ties}
        return self.start.changed(self.start.overrides_at(list(moved), list(moved.values())))

    @cached_property
    def differences(self) -> dict[tuple[str, str], Difference]:
        """Model and readings of each (log, signal), held-out ones included; times are those of the window."""
        found = {}
        for model, (y, _) in zip(self.task.models, self._read, strict=True):
            record = model.record
            for i, signal in enumerate(record.signals):
                good = np.isfinite(record.readings[:, i])
                unit = self._units[signal]
                found[record.name, signal] = Difference(
                    signal, unit, record.time[good] + record.begin, y[good, i], record.readings[good, i]
                )
        return found

    @cached_property
    def quality(self) -> tuple[SignalQuality, ...]:
        """Agreement of the model with each signal of each log."""
        rows = []
        for model, (y, _), outliers in zip(self.task.models, self._read, self.found.weights.outliers, strict=True):
            record = model.record
            for i, signal in enumerate(record.signals):
                rest = y[:, i] - record.readings[:, i]
                used, judged = record.used[:, i], record.judged[:, i]
                readings = record.readings[used | judged, i]
                rows.append(
                    SignalQuality(
                        log=record.name,
                        signal=signal,
                        unit=self._units[signal],
                        rms=rms(rest[used]),
                        held_out=rms(rest[judged]),
                        span=float(np.ptp(readings)),
                        noise=float(record.noise[i]),
                        outliers=float(np.mean(outliers[used, i])) if used.any() else 0.0,
                    )
                )
        return tuple(rows)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings to read before trusting the result, the most important first."""
        behind = left_behind(self.start, self.machine, self.keys, self.ties)
        known = self.information, self.accuracy, self.quality, self.differences, self.looks
        return (*doubts(self.found, *known), *behind)

    @cached_property
    def figure(self) -> Figure:
        """Model and log in one chart per signal of each log; the held-out part is shaded."""
        return cast("Figure", ask("plots", "fit", self))

    def summary(self) -> str:
        """Values, quality and warnings as text."""
        width = max(len(name) for name in self.names)
        lines = [f"fit of {len(self.names)} parameters, {self._ended}"]
        for name in self.names:
            low, high = self.interval(name)
            ends = f"95 %: {low:.5g} to {high:.5g}, was {self.prior(name):.5g}"
            lines.append(f"  {name:<{width}}  {self.value(name):.5g} {self.unit(name)}, {ends}")
        lines += [f"  {tie.key} moves with it, {tie.ratio:.4g} times `{tie.leader}`" for tie in self.ties]
        for q in self.quality:
            held = f", held out {q.held_out:.3g} ({q.held_out_share:.1%})" if np.isfinite(q.held_out) else ""
            lines.append(f"  {q.log}: {q.signal} rms {q.rms:.3g} {q.unit} ({q.share:.1%} of its range){held}")
        lines += [] if self.accuracy is None else [f"  {self.accuracy}"]
        lines += [f"the logs do not identify {text}" for text in self.cannot_tell]
        return "\n".join([*lines, *(f"warning: {text}" for text in self.warnings), *self.notes, UNCHECKED])

    def toml(self, *, date: str = "") -> str:
        """The fitted values as a part of a machine file, to be included; comments give the 95 % intervals."""
        known = {key: self.interval(key) for key in self.keys}
        for tie in self.ties:
            low, high = sorted(tie.ratio * end for end in self.interval(tie.leader))
            known[tie.key] = (low, high)
        return block(self.machine, known, [m.record.name for m in self.task.models], self.motion, self.warnings, date)

    def write(self, path: str | PathLike[str]) -> Path:
        """Write the part of a machine file."""
        return write_part(path, lambda _: self.toml())

    def report(self) -> Report:
        """A page with values, quality, pictures and warnings; ``.write("report.html")`` puts it into one file."""
        logs = ", ".join(dict.fromkeys(model.record.name for model in self.task.models))
        report = Report(f"Fit of {self.start.name}", f"Logs: {logs}. Motion: {self.motion}.")
        integrated = "" if self.accuracy is None else f"; {self.accuracy}"
        report.add(Section("Fitted values", self._ended + integrated, self._parameter_table(), warnings=self.warnings))
        quality = "How well the model follows the logs"
        report.stage(quality, lambda: Section(quality, table=self._quality_table(), figure=self.figure))
        report.stage("Correlation", lambda: Section("Correlation", table=self._correlation_table()))
        report.add(Section("The logs", "\n\n".join((*self.notes, UNCHECKED))))
        report.stage("Part of the machine file", lambda: Section("Part of the machine file", code=self.toml()))
        return report

    def _parameter_table(self) -> Table:
        rows = []
        for i, name in enumerate(self.names):
            low, high = self.interval(name)
            narrowed = float(self.information.narrowed[i])
            numbers = (f"{number:.5g}" for number in (self.prior(name), self.value(name), low, high))
            rows.append((name, self.unit(name) or "1", *numbers, f"{narrowed:.0%}" if narrowed > 0.0 else "-"))
        return Table(("parameter", "unit", "before", "fitted", "95 % from", "to", "deviation after"), tuple(rows))

    def _quality_table(self) -> Table:
        rows = []
        for q in self.quality:
            held = f"{q.held_out:.3g}" if np.isfinite(q.held_out) else "-"
            shares = (f"{q.rms:.3g}", f"{q.share:.1%}", held, f"{q.noise:.2g}", f"{q.outliers:.0%}")
            rows.append((f"{q.log}: {q.signal}", q.unit, *shares))
        headings = ("signal", "unit", "rms", "of its range", "rms held out", "noise", "weighed down")
        return Table(headings, tuple(rows))

    def _correlation_table(self) -> Table:
        numbers = tuple(map(str, range(1, len(self.names) + 1)))
        rows = zip(numbers, self.names, self.information.correlation.tolist(), strict=True)
        return Table(("", *numbers), tuple((f"{i} {name}", *(f"{v:.2f}" for v in row)) for i, name, row in rows))

    @property
    def _ended(self) -> str:
        estimate = self.found.estimate
        return "converged" if estimate.converged else f"NOT converged ({estimate.message})"

    @cached_property
    def _read(self) -> list[tuple[Array, Array]]:
        return self.task.read(self.found.estimate.values)

    @cached_property
    def _units(self) -> dict[str, str]:
        known = modelled_signals(self.start)
        return {signal: known.get(signal, "N") for model in self.task.models for signal in model.record.signals} | known

    def _checked(self, name: str) -> str:
        check_known("parameter of the fit", name, self.names)
        return name
