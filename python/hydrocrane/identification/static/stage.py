"""The static stage: from steady windows to the static map, with its part of the report and the graphical construction
of Figure 67 as code (121)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol, Unpack

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError
from hydrocrane.identification.report import Report, Section, Stage, Table, parameter_row, shown
from hydrocrane.identification.static.fit import MapOptions, fit_static
from hydrocrane.identification.static.intervals import akaike_weights
from hydrocrane.identification.static.maps import EXPONENTS, FAR, PARAMETERS, StaticMap, of_sensors, stribeck_share
from hydrocrane.identification.static.points import DIRECTIONS, FrictionPoints, SteadyWindow
from hydrocrane.identification.static.residuals import ORDERS, chance_text
from hydrocrane.identification.static.result import ALIKE, StaticFit


def graphical(points: FrictionPoints, *, exponents: Mapping[str, float] | None = None) -> StaticFit:
    """Read the parameters from the averaged curve, without optimisation.

    Per direction: a straight line of force over \\|v\\|^delta_v through the fast levels gives Coulomb force (where it
    meets zero velocity) and viscous coefficient (its slope); the slowest level, taken for v -> 0, gives the
    break-away force; the Stribeck velocity is where the force without its viscous part has fallen to
    alpha_0 + alpha_1/e   (121). The exponents are taken as given.

    Returns
    -------
    StaticFit
        It has no intervals. `warnings` states what limits each number.
    """
    taken = {**EXPONENTS, **(exponents or {})}
    pairs = np.full((len(PARAMETERS), 2), np.nan)
    pairs[PARAMETERS.index("stribeck-exponent")] = taken["stribeck-exponent"]
    pairs[PARAMETERS.index("viscous-exponent")] = taken["viscous-exponent"]
    limits: list[str] = []
    for side, name in enumerate(DIRECTIONS):
        here = points.levels.direction == side
        if not here.any():
            limits.append(f"{name}: no points")
            continue
        speed = np.abs(points.levels.velocity[here])
        force = np.abs(points.levels.force[here])
        read, said = _read(speed, force, float(taken["viscous-exponent"]))
        pairs[[0, 1, 2, 4], side] = read
        limits += [f"{name}: {text}" for text in said]
    if np.isnan(pairs[0]).all():
        raise InputError("no friction points to read")
    law = StaticMap(pairs.ravel())
    return StaticFit(points=points, law=law, method="graphical", warnings=tuple(limits))


def _read(speed: Array, force: Array, exponent: float) -> tuple[list[float], list[str]]:
    """Coulomb, break-away, Stribeck velocity, viscous coefficient of one direction, with warnings."""
    said = []
    if speed.size < 3:
        said.append(f"{speed.size} velocity level(s): Coulomb, Stribeck and viscous friction cannot be distinguished")
    lowest = int(np.argmin(force))
    coulomb, viscous = _line(speed[lowest:], force[lowest:], exponent)
    stribeck = _stribeck_velocity(speed, force - viscous * speed**exponent, coulomb)
    beyond = speed > FAR * stribeck
    if beyond.sum() >= 2:
        coulomb, viscous = _line(speed[beyond], force[beyond], exponent)
        stribeck = _stribeck_velocity(speed, force - viscous * speed**exponent, coulomb)
    else:
        said.append(
            f"fewer than two levels beyond {FAR:g} Stribeck velocities: Coulomb force and viscous coefficient mixed"
        )
    slowest = int(np.argmin(speed))
    breakaway = max(float(force[slowest]), coulomb)
    if speed[slowest] > 0.0:
        lost = 1.0 - stribeck_share(speed[slowest] / stribeck, 2.0)
        said.append(
            f"break-away force read at the slowest level, {speed[slowest] * 1e3:.3g} mm/s, where about "
            f"{100 * lost:.1f} % of the Stribeck rise is gone"
        )
    gap = _gap(speed, stribeck)
    said.append(f"Stribeck velocity read between levels {gap[0] * 1e3:.3g} and {gap[1] * 1e3:.3g} mm/s")
    return [coulomb, breakaway, stribeck, viscous], said


def _line(speed: Array, force: Array, exponent: float) -> tuple[float, float]:
    """Coulomb force and viscous coefficient of a straight line over |v|^exponent; neither below zero."""
    power = speed**exponent
    if speed.size < 2:
        return float(force.min()), 0.0
    slope, start = np.polyfit(power / power.max(), force, 1)
    slope /= power.max()
    if slope < 0.0:
        return float(force.min()), 0.0
    return (float(start), float(slope)) if start > 0.0 else (0.0, float(force @ power / (power @ power)))


def _stribeck_velocity(speed: Array, dry: Array, coulomb: float) -> float:
    """Speed at which `dry` friction falls below coulomb + rise/e, interpolated in the logarithm of the speed
    (121)."""
    order = np.argsort(speed)
    speed, dry = speed[order], dry[order]
    target = coulomb + (dry[0] - coulomb) / np.e
    below = np.flatnonzero(dry <= target)
    moving = speed[speed > 0.0]
    if below.size == 0 or below[0] == 0 or moving.size < 2:
        return float(np.sqrt(moving[0] * moving[-1])) if moving.size else 1e-3
    k = int(below[0])
    if speed[k - 1] == 0.0:
        return float(speed[k])
    share = (dry[k - 1] - target) / (dry[k - 1] - dry[k])
    return float(speed[k - 1] * (speed[k] / speed[k - 1]) ** share)


def _gap(speed: Array, velocity: float) -> tuple[float, float]:
    """The neighbouring levels of a velocity, m/s."""
    slower, faster = speed[speed <= velocity], speed[speed >= velocity]
    return float(slower.max(initial=0.0)), float(faster.min(initial=np.inf))


class RejectedWindow(Protocol):
    """An unused stretch of a log."""

    @property
    def start(self) -> float: ...
    @property
    def end(self) -> float: ...
    @property
    def reason(self) -> str: ...


@dataclass(frozen=True)
class StaticIdentification:
    """Result of the static stage: points, graphical reading, fit.

    Attributes
    ----------
    points : FrictionPoints
    reading : StaticFit
        Result of the construction of Figure 67, as a check of the fit.
    fit : StaticFit
    rejected_windows : tuple
        Stretches of the logs that were not steady, with the reason.
    """

    points: FrictionPoints
    reading: StaticFit
    fit: StaticFit
    rejected_windows: tuple[RejectedWindow, ...] = ()

    def report(self, cylinder: str, *, title: str = "Friction identification") -> Report:
        """A report with the sections of this stage; later stages add theirs."""
        report = Report(title, introduction=f"Cylinder {cylinder}.")
        for name, make in self.stages(cylinder):
            report.stage(name, make)
        return report

    def stages(self, cylinder: str) -> list[Stage]:
        """(title, function that makes the section) in the order of the report."""
        return [
            ("Data", self._data),
            ("Static friction", self._map),
            ("Parameters", self._parameters),
            ("Friction of the map", self._predicted),
            ("Forms of the map", self._forms),
            ("Residuals", self._left_over),
            ("Prediction of levels left out", self._held_out),
            ("Neighbouring residuals", self._neighbours),
            ("Correlation", self._correlation),
            ("Points left out", self._points_left_out),
            ("Windows left out", self._windows),
            ("Block for the machine file", lambda: self._block(cylinder)),
        ]

    def _data(self) -> Section:
        levels = self.points.levels
        rows = tuple(
            (
                f"{v * 1e3:.3g}", DIRECTIONS[d], str(n), f"{f:.1f}", "-" if np.isnan(s) else f"{s:.2g}", f"{e:.2g}",
            )
            for v, d, n, f, s, e in zip(
                levels.velocity, levels.direction, levels.count, levels.force, levels.scatter, levels.error, strict=True
            )
        )  # fmt: skip
        text = f"{len(self.points)} steady windows at {levels.count.size} velocity levels."
        if self.points.source:
            text += f" Logs: {', '.join(self.points.source)}."
        heads = ("velocity [mm/s]", "direction", "windows", "force [N]", "scatter [N]", "error of one [N]")
        return Section("Data", text, Table(heads, rows))

    def _windows(self) -> Section:
        if not self.rejected_windows:
            return Section("Windows left out", "None was given.")
        rows = tuple((f"{w.start:.2f}", f"{w.end:.2f}", w.reason) for w in self.rejected_windows)
        return Section("Windows left out", table=Table(("from [s]", "to [s]", "reason"), rows))

    def _map(self) -> Section:
        spread = self.fit.spread
        text = ""
        if spread is not None:
            text = (
                f"Scatter about the map {spread.scale:.2f} of what the stated errors and {spread.floor:.2g} N more of "
                "each level lead to expect; "
                f"{spread.degrees_of_freedom:g} degrees of freedom, condition number {spread.condition:.2g}."
            )
        return Section("Static friction", text, figure=self.fit.plot(), warnings=self.fit.warnings)

    def _parameters(self) -> Section:
        intervals = self.fit.intervals(0.95)
        rows = tuple(self._row(label, ends) for label, ends in intervals.items())
        held = [name for name in EXPONENTS if not any(label.startswith(f"{name}.") for label in intervals)]
        shown = (f"{name} at {', '.join(f'{v:g}' for v in self.fit.params[name])}" for name in held)
        text = f"Held: {'; '.join(shown)}." if held else "No parameter was held."
        text += f"\n\n{self._method()}"
        heads = ("parameter", "unit", "fitted", "95 % from", "to", "by ruler")
        return Section("Parameters", text, Table(heads, rows), warnings=self.reading.warnings)

    def _method(self) -> str:
        """Description of the method of the intervals."""
        found = {
            "profile": "Intervals follow the profile likelihood, because an exponent is free and the map then far from "
            "linear in its parameters; those of the errors of the sensors are linear.",
            "t": "Intervals are linear, with Student's t, in the logarithm for the Stribeck velocity: no exponent is "
            "free.",
        }[self.fit.interval_method]
        rivals = len(self.fit.rivals)
        others = f" They are averaged by likelihood with linear intervals of other forms: {rivals}." if rivals else ""
        return found + others

    def _row(self, label: str, ends: tuple[float, float]) -> tuple[str, ...]:
        ruler = "-" if of_sensors(label) else f"{self.reading.value(label):.4g}"
        return (*parameter_row(label, self.fit.unit(label), self.fit.value(label), *ends), ruler)

    def _predicted(self) -> Section:
        """Friction at measured speeds and beyond; any form determines it better than its own parameters."""
        rows = []
        for side, (name, sign) in enumerate(zip(DIRECTIONS, (1.0, -1.0), strict=True)):
            speeds = self.fit.shown_speeds(side)
            for v, (low, high) in zip(speeds, self.fit.force_interval(sign * speeds), strict=True):
                ends = sorted((sign * low, sign * high))
                value = float(sign * self.fit.force(sign * v))
                where = "beyond the levels" if v > speeds[-2] else "measured"
                rows.append(parameter_row(f"{name}, {v * 1e3:.3g} mm/s", where, value, *ends))
        heads = ("friction", "speed", "fitted [N]", "95 % from", "to")
        text = "Intervals are averaged over the forms by their weights, as those of the parameters."
        return Section("Friction of the map", text, Table(heads, tuple(rows)))

    def _forms(self) -> Section:
        """The fitted forms, the likeliest first."""
        fits = (self.fit, *self.fit.alternatives)
        weights = akaike_weights([fit.aicc for fit in fits])
        least = min(fit.aicc for fit in fits)
        rows = tuple(self._form(fit, weight, least) for fit, weight in zip(fits, weights, strict=True))
        text = (
            f"{len(fits)} forms were fitted to the same points; the first is used, and intervals are averaged over "
            f"those within {ALIKE:g} AICc by their weights."
        )
        heads = ("form", "parameters", "AICc more", "weight", "floor [N]", "Coulomb extending [N]", "retracting [N]")
        return Section("Forms of the map", text, Table(heads, rows))

    def _form(self, fit: StaticFit, weight: float, least: float) -> tuple[str, ...]:
        floor = fit.spread.floor if fit.spread else np.nan
        coulomb = (shown(value, value, floor) if np.isfinite(value) else "-" for value in fit.params["coulomb"])
        return (
            fit.form_text,
            str(fit.unknowns),
            f"{fit.aicc - least:.1f}",
            f"{weight:.2g}",
            f"{floor:.2g}",
            *coulomb,
        )

    def _left_over(self) -> Section:
        """Residuals over their possible causes."""
        analysis = self.fit.residual_analysis
        if analysis is None or not analysis.causes:
            return Section("Residuals", "Too few points to test further dependences of friction.")
        text = (
            f"The levels lie {analysis.floor:.2g} N off the map beyond the errors of their points, "
            f"{analysis.point_error:.2g} N in the median: {100 * analysis.floor / analysis.force:.2g} % of the friction"
            f", {chance_text(analysis.p_value)} if the map describes them."
        )
        rows = tuple(
            (cause.name, f"{100 * cause.change:+.2g}", f"{cause.p_value:.2g}", "yes" if cause.shows else "no")
            for cause in analysis.causes
        )
        table = Table(("depends on", "change of friction [%]", "chance without it", "shows"), rows)
        return Section("Residuals", text, table, analysis.plot(), analysis.warnings)

    def _held_out(self) -> Section:
        """Levels predicted by fits to the other levels."""
        title, found = "Prediction of levels left out", self.fit.held_out
        if found is None:
            return Section(title, "A single level cannot be predicted from others.")
        rows = tuple(
            (
                f"{v * 1e3:.3g}",
                DIRECTIONS[d],
                f"{within:+.3g}",
                *(("-", "-") if np.isnan(e) else (f"{e:+.3g}", f"{s:.3g}")),
            )
            for v, d, within, e, s in zip(
                found.velocity, found.direction, found.within, found.error, found.promised, strict=True
            )
        )
        heads = (
            "velocity [mm/s]", "direction", "measured - fitted [N]", "measured - predicted [N]",
            "standard deviation promised [N]",
        )  # fmt: skip
        return Section(title, found.sentence, Table(heads, rows), warnings=found.warnings)

    def _neighbours(self) -> Section:
        """Correlation of residuals along time and velocity."""
        title, found = "Neighbouring residuals", self.fit.successions
        if not found:
            return Section(title, "Too few windows and levels to test the correlation of residuals.")
        rows = tuple(
            (
                ORDERS[each.order][0], str(each.count), f"{each.correlation:+.2f}", f"{each.p_value:.2g}",
                f"{each.effective:.3g}", "yes" if each.shows else "no",
            )
            for each in found
        )  # fmt: skip
        heads = ("residuals of", "readings", "correlation", "chance without it", "count as", "shows")
        text = (
            "Correlation of neighbours, corrected for the effect of the fit itself; correlated readings count for less."
        )
        warnings = tuple(each.warning for each in found if each.shows)
        return Section(title, text, Table(heads, rows), warnings=warnings)

    def _correlation(self) -> Section:
        """Correlation of all unknowns with the parameters of the map; columns are numbered to save width."""
        table = self.fit.correlation
        names = [str(n) for n in table["parameter"].values]
        columns = [i for i, name in enumerate(names) if not of_sensors(name)]
        rows = tuple(
            (f"{i} {name}", *("-" if np.isnan(row[k]) else f"{row[k]:+.2f}" for k in columns))
            for i, (name, row) in enumerate(zip(names, table.values, strict=True), 1)
        )
        text = "Columns are those of the rows with the same number."
        if len(columns) < len(names):
            text += " `fit.correlation` also has the correlations between sensor errors."
        return Section("Correlation", text, Table(("", *(str(k + 1) for k in columns)), rows))

    def _points_left_out(self) -> Section:
        if not self.fit.rejected:
            return Section("Points left out", "None.")
        p = self.points
        rows = tuple(
            (str(r.index), f"{p.velocity[r.index] * 1e3:.3g}", f"{p.force[r.index]:.1f}", r.reason)
            for r in self.fit.rejected
        )
        return Section("Points left out", table=Table(("point", "velocity [mm/s]", "force [N]", "reason"), rows))

    def _block(self, cylinder: str) -> Section:
        return Section("Block for the machine file", code=self.fit.toml(cylinder))


def identify_static(
    windows: Iterable[SteadyWindow] | FrictionPoints,
    *,
    source: Iterable[str] = (),
    rejected_windows: Iterable[RejectedWindow] = (),
    **options: Unpack[MapOptions],
) -> StaticIdentification:
    """Static friction from steady windows.

    Parameters
    ----------
    windows : iterable or FrictionPoints
        Accepted windows with velocity, force and their standard errors.
    source : iterable of str
        Names of the logs, for the report and the block.
    rejected_windows : iterable
        Windows with start, end, reason, for the report; default are those that `windows` has.
    **options
        `exponents`, `held`, `bias`, `span`, `linearity_error`, `velocity_share`, `symmetric` and `loss` of
        :func:`fit_static`.
    """
    points = windows if isinstance(windows, FrictionPoints) else FrictionPoints.from_windows(windows, source=source)
    fit = fit_static(points, **options)
    taken = {name: value for name in EXPONENTS if np.isfinite(value := float(np.nanmean(fit.params[name])))}
    rejected = tuple(rejected_windows) or tuple(getattr(windows, "rejected", ()))
    return StaticIdentification(points, graphical(points, exponents=taken), fit, rejected)
