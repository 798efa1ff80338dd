"""Result of an identification from several logs: friction parameters, and the outcome of each stage."""

from __future__ import annotations

import datetime
import json
from dataclasses import dataclass, field
from functools import partial
from os import PathLike
from pathlib import Path

from hydrocrane.arrays import brief
from hydrocrane.errors import InputError
from hydrocrane.identification.bristles.fit import UNITS, DynamicFit
from hydrocrane.identification.bristles.readings import DYNAMIC
from hydrocrane.identification.records import STEADY, FrictionLog, name_of
from hydrocrane.identification.report import (
    Report,
    Section,
    Table,
    comment,
    head,
    interval,
    parameter_row,
    signature,
    write_part,
)
from hydrocrane.identification.sensors import PRESSURES
from hydrocrane.identification.static.comparison import FrictionComparison
from hydrocrane.identification.static.maps import of_sensors
from hydrocrane.identification.static.stage import StaticIdentification
from hydrocrane.machine.machine import Machine
from hydrocrane.notebook import card
from hydrocrane.signals import SteadyWindows

FADING = "bristle-damping-velocity"


@dataclass(frozen=True)
class Stage:
    """Outcome of one stage.

    Attributes
    ----------
    name : str
    outcome : {"done", "skipped", "failed"}
    message : str
        Why it was skipped or failed.
    """

    name: str
    outcome: str = "done"
    message: str = ""


@dataclass(frozen=True)
class LeftOut:
    """A stretch of a log that was not steady."""

    start: float
    end: float
    reason: str


@dataclass
class Identification:
    """Friction of a rig's cylinder as identified from its logs. The result of a failed stage is None.

    Attributes
    ----------
    rig : Machine
    records : list of FrictionLog
        The logs, each with its role.
    stages : list of Stage
        In order of execution.
    windows : list of SteadyWindows
        Windows of each usable steady log.
    static : StaticIdentification or None
        The static map (119), (122).
    comparison : FrictionComparison or None
        Whether friction depends on load or supply pressure; None if all logs have the same.
    dynamic : DynamicFit or None
        Bristle stiffness and damping.
    warnings : list of str
        Limits of the results.

    Examples
    --------
    >>> from hydrocrane import rig
    >>> log = rig.run("constant-velocity", seed=3, calibration=1.0)
    >>> found = hc.identify_friction([log], "rig-rottne")
    >>> print(found.static is not None, found.dynamic is not None, found.records[0].role)
    True False steady
    """

    rig: Machine
    records: list[FrictionLog] = field(default_factory=list)
    stages: list[Stage] = field(default_factory=list)
    windows: list[SteadyWindows] = field(default_factory=list)
    static: StaticIdentification | None = None
    comparison: FrictionComparison | None = None
    dynamic: DynamicFit | None = None
    warnings: list[str] = field(default_factory=list)

    __repr__ = brief

    @property
    def cylinder(self) -> str:
        """Name of the rig's cylinder."""
        return self.rig.cylinder_names[0]

    @property
    def failures(self) -> tuple[Stage, ...]:
        """The stages that failed."""
        return tuple(stage for stage in self.stages if stage.outcome == "failed")

    def toml(self, cylinder: str | None = None, *, date: str = "", file_name: str = "friction.toml") -> str:
        """The block ``[friction.<cylinder>]`` for a machine file, with comments on its origin.

        Without a static map the block holds only the bristle parameters; the including file must have the others.
        """
        cylinder = cylinder or self.cylinder
        bristles = _bristles(self)
        static = None if self.static is None else self.static.fit
        if static is None and not bristles:
            reasons = "; ".join(f"{stage.name}: {stage.message}" for stage in self.stages if stage.message)
            raise InputError(f"nothing was identified, so there is nothing to write. {reasons}")
        if static is not None:
            used = static.points.source + _dynamic_names(self)
            block = static.toml(cylinder, source=dict.fromkeys(used), date=date, bristles=bristles)
        else:
            source = f"{', '.join(_dynamic_names(self))}; output-error fit, {signature(date)}"
            block = "\n".join([*head(cylinder, cylinder, source, "lugre"), *bristles]) + "\n"
        return "\n".join([*_preface(self, cylinder, file_name), block])

    def write(self, path: str | PathLike[str], cylinder: str | None = None) -> Path:
        """Write the block to a file that a machine file can include."""
        return write_part(path, lambda name: self.toml(cylinder, file_name=name))

    def report(self) -> Report:
        """Everything in one page: result first, then the stages in their order, the block last."""
        from hydrocrane import __version__

        title = f"Friction of cylinder {self.cylinder} of {self.rig.name}"
        origin = f"hydrocrane {__version__}, {datetime.date.today().isoformat()}. {self.rig.title}."
        report = Report(title, introduction=origin)
        report.stage("Result", lambda: _result(self))
        report.stage("Logs", lambda: _logs(self))
        for windows in self.windows:
            name = f"Steady motion in {name_of(windows.log)}"
            report.stage(name, partial(_windows, name, windows))
        if self.static is not None:
            for name, make in self.static.stages(self.cylinder)[:-1]:
                report.stage(name, make)
        found = self.comparison
        if found is not None:
            report.stage("Load and pressure", lambda: Section("Load and pressure", found.sentence, figure=found.plot()))
        if self.dynamic is not None:
            # A fit that failed has only initial estimates.
            ended = self.dynamic.estimate is not None
            for name, make in self.dynamic.stages()[: -1 if ended else 1]:
                report.stage(name, make)
        for stage in self.failures:
            report.add(Section(stage.name.capitalize(), failure=stage.message))
        report.stage("Block for the machine file", lambda: Section("Block for the machine file", code=self.toml()))
        return report

    def _repr_html_(self) -> str:
        return card(f"Friction of cylinder {self.cylinder}", self.summary().splitlines(), "print(found.summary())")

    def summary(self) -> str:
        """Stages, parameters with their 95 % intervals, and warnings as plain text."""
        lines = [f"{self.rig.name}, cylinder {self.cylinder}: {', '.join(record.name for record in self.records)}"]
        rows = _parameters(self)
        if rows:
            lines += ["", f"{'parameter':<28}{'fitted':>12}   {'95 % interval':<24}unit"]
            lines += [
                f"{label:<28}{value:>12}   {low + (' .. ' + high if high else ''):<24}{unit}"
                for label, unit, value, low, high in rows
            ]
        if self.comparison is not None:
            lines += ["", self.comparison.sentence]
        notable = [
            f"{s.name} {s.outcome}" + (f": {s.message}" if s.outcome == "skipped" else "")
            for s in self.stages
            if s.outcome != "done"
        ]
        lines += ["", *notable] if notable else []
        lines += ["", *(f"warning: {text}" for text in _once(self.warnings))] if self.warnings else []
        return "\n".join(lines)


def _windows(name: str, windows: SteadyWindows) -> Section:
    return Section(name, figure=windows.plot())


def _result(found: Identification) -> Section:
    rows = tuple((stage.name, stage.outcome, stage.message) for stage in found.stages)
    text = "\n\n".join(f"{s.name.capitalize()} {s.outcome}: {s.message}." for s in found.stages if s.message)
    table = Table(("parameter", "unit", "fitted", "95 % from", "to"), tuple(_parameters(found)))
    if not table.rows:
        return Section("Result", text, Table(("stage", "outcome", "reason"), rows), warnings=_once(found.warnings))
    return Section("Result", text, table, warnings=_once(found.warnings))


def _parameters(found: Identification) -> list[tuple[str, str, str, str, str]]:
    """(label, unit, value, low, high) of all fitted parameters."""
    rows = []
    if found.static is not None:
        fit = found.static.fit
        for label, (low, high) in fit.intervals(0.95).items():
            if of_sensors(label):
                continue
            rows.append(parameter_row(label, fit.unit(label), fit.value(label), low, high))
    if found.dynamic is not None and found.dynamic.estimate is not None:
        ends = found.dynamic.intervals(0.95)
        rows += [parameter_row(name, UNITS[name], found.dynamic.params[name], *ends[name]) for name in DYNAMIC]
    return rows


def _once(texts: list[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(texts))


def _logs(found: Identification) -> Section:
    heads = ("log", "taken as", "samples", "seconds", "load [kg]", "supply [bar]", "zero taken off: p1, p2 [bar]")
    return Section("Logs", table=Table(heads, tuple(_log(record) for record in found.records)))


def _log(record: FrictionLog) -> tuple[str, ...]:
    time, zero = record.log.time, record.zero
    length = f"{time[-1] - time[0]:.4g}" if time.size else "0"
    shown = "none" if zero is None else ", ".join(f"{zero.zeros[name] * 1e-5:+.3f}" for name in PRESSURES)
    role = record.role or "not used"
    role = "left out: " + "; ".join(f.message for f in record.log.fatal) if record.log.fatal else role
    return (record.name, role, str(time.size), length, f"{record.payload:g}", f"{record.supply * 1e-5:g}", shown)


def _preface(found: Identification, cylinder: str, file_name: str) -> list[str]:
    lines = [
        f"Friction of the cylinder `{cylinder}`, identified on {found.rig.name}. A machine file takes it over with",
        f"    include = [{json.dumps(file_name, ensure_ascii=False)}]",
        "above its first table. Comments hold 95 % intervals.",
    ]
    if not _bristles(found):
        lines.append(
            'The bristles were not identified; without `model = "static"` those of the including file stay in use.'
        )
    lines += [f"Not finished: {stage.name}: {stage.message}" for stage in found.failures]
    return [comment(line) for line in lines]


def _dynamic_names(found: Identification) -> tuple[str, ...]:
    if found.dynamic is None or found.dynamic.estimate is None:
        return ()
    return tuple(r.name for r in found.records if r.role not in (STEADY, "") and not r.log.fatal)


def _bristles(found: Identification) -> list[str]:
    """Lines of the fitted bristle parameters; the velocity over which damping fades was held."""
    fit = found.dynamic
    if fit is None or fit.estimate is None:
        return []
    ends = fit.intervals(0.95)
    lines = []
    for name in DYNAMIC:
        lines.append(f'{name} = "{fit.params[name]:.5g} {UNITS[name]}"  # 95 %: {interval(*ends[name])}')
    key = f"friction.{found.cylinder}.{FADING}"
    if key in found.rig.keys:
        source = json.dumps(f"held in the fit, from {found.rig.name}")
        value = f"{float(found.rig.value(key).si):.5g} m/s"
        lines.append(f'{FADING} = {{ value = "{value}", class = "assumed", source = {source} }}')
    return lines
