"""The page and the plain text of an identification."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING

import numpy as np

from hydrocrane.identification.dynamic_result import DYNAMIC, UNITS
from hydrocrane.identification.records import Record, name_of
from hydrocrane.identification.report import Report, Section, Table
from hydrocrane.identification.result import of_sensors, shown
from hydrocrane.identification.sensors import PRESSURES

if TYPE_CHECKING:
    from hydrocrane.identification.campaign_result import Identification


def campaign_report(found: Identification) -> Report:
    """Result first, then the stages in their order, the block last."""
    from hydrocrane import __version__

    title = f"Friction of cylinder {found.cylinder} of {found.rig.name}"
    origin = f"hydrocrane {__version__}, {datetime.date.today().isoformat()}. {found.rig.title}."
    report = Report(title, introduction=origin)
    report.stage("Result", lambda: _result(found))
    report.stage("Logs", lambda: _logs(found))
    for windows in found.windows:
        name = f"Steady motion in {name_of(windows.log)}"
        report.stage(name, lambda n=name, w=windows: Section(n, figure=w.plot()))
    if found.static is not None:
        for name, make in found.static.stages(found.cylinder)[:-1]:
            report.stage(name, make)
    if found.comparison is not None:
        report.stage("Load and pressure", lambda: _comparison(found))
    if found.dynamic is not None:
        # Of a fit that did not end there are first readings alone.
        ended = found.dynamic.estimate is not None
        for name, make in found.dynamic.stages()[: -1 if ended else 1]:
            report.stage(name, make)
    for stage in found.failures:
        report.add(Section(stage.name.capitalize(), failure=stage.message))
    report.stage("Block for the machine file", lambda: Section("Block for the machine file", code=found.toml()))
    return report


def _result(found: Identification) -> Section:
    rows = tuple((stage.name, stage.outcome, stage.message) for stage in found.stages)
    text = "\n\n".join(f"{s.name.capitalize()} {s.outcome}: {s.message}." for s in found.stages if s.message)
    table = Table(("parameter", "unit", "fitted", "95 % from", "to"), tuple(_parameters(found)))
    if not table.rows:
        return Section("Result", text, Table(("stage", "outcome", "reason"), rows), warnings=_once(found.warnings))
    return Section("Result", text, table, warnings=_once(found.warnings))


def _parameters(found: Identification) -> list[tuple[str, ...]]:
    """(label, unit, value, low, high) of everything that was fitted."""
    rows = []
    if found.static is not None:
        fit = found.static.fit
        for label, (low, high) in fit.intervals(0.95).items():
            if of_sensors(label):
                continue
            rows.append(_row(label, fit.unit(label), fit.value(label), low, high))
    if found.dynamic is not None and found.dynamic.estimate is not None:
        ends = found.dynamic.intervals(0.95)
        rows += [_row(name, UNITS[name], found.dynamic.params[name], *ends[name]) for name in DYNAMIC]
    return rows


def _row(label: str, unit: str, value: float, low: float, high: float) -> tuple[str, ...]:
    if not (np.isfinite(low) and np.isfinite(high)):
        return (label, unit, "-", "not told by the data", "")
    return (label, unit, shown(value, low, high), f"{low:.4g}", f"{high:.4g}")


def _once(texts: list[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(texts))


def _logs(found: Identification) -> Section:
    heads = ("log", "taken as", "samples", "seconds", "load [kg]", "supply [bar]", "zero taken off: p1, p2 [bar]")
    return Section("Logs", table=Table(heads, tuple(_log(record) for record in found.records)))


def _log(record: Record) -> tuple[str, ...]:
    time, zero = record.log.time, record.zero
    length = f"{time[-1] - time[0]:.4g}" if time.size else "0"
    shown = "none" if zero is None else ", ".join(f"{zero.zeros[name] * 1e-5:+.3f}" for name in PRESSURES)
    role = record.role or "not used"
    role = "left out: " + "; ".join(f.message for f in record.log.fatal) if record.log.fatal else role
    return (record.name, role, str(time.size), length, f"{record.payload:g}", f"{record.supply * 1e-5:g}", shown)


def _comparison(found: Identification) -> Section:
    assert found.comparison is not None
    return Section("Load and pressure", found.comparison.sentence, figure=found.comparison.plot())


def summary(found: Identification) -> str:
    """Stages, parameters and warnings as plain text."""
    lines = [f"{found.rig.name}, cylinder {found.cylinder}: {', '.join(record.name for record in found.records)}"]
    rows = _parameters(found)
    if rows:
        lines += ["", f"{'parameter':<28}{'fitted':>12}   {'95 % interval':<24}unit"]
        lines += [
            f"{label:<28}{value:>12}   {low + (' .. ' + high if high else ''):<24}{unit}"
            for label, unit, value, low, high in rows
        ]
    if found.comparison is not None:
        lines += ["", found.comparison.sentence]
    notable = [
        f"{s.name} {s.outcome}" + (f": {s.message}" if s.outcome == "skipped" else "")
        for s in found.stages
        if s.outcome != "done"
    ]
    lines += ["", *notable] if notable else []
    lines += ["", *(f"warning: {text}" for text in _once(found.warnings))] if found.warnings else []
    return "\n".join(lines)
