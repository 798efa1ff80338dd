"""Columns of a closed loop in a run's dataset: readings, sticks, commands, set-points, and path deviation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrocrane._core_types import Samples
from hydrocrane.arrays import Array
from hydrocrane.files.columns import Column
from hydrocrane.machine.machine import Machine
from hydrocrane.results.recording import RecordedStage, Recording

# Tolerance between a time of the record and one of a sample or phase, s.
ROUNDING = 1e-9
# Number of points per block of distances: some hundred kilobytes.
TOGETHER = 64
# Every so many corners of a path bound how far a point can be from it, with room for rounding (m).
APART = 32
SLACK = 1e-9


def stage_rows(run: Recording) -> Iterator[tuple[slice, RecordedStage]]:
    """Rows of each stage among the times (m,) of a run, and its settings; at its begin the previous stage still
    applies."""
    first, stages = 0, run.stages
    for stage, end in zip(stages, [*(stage.begin for stage in stages[1:]), np.inf], strict=False):
        rows = slice(first, _after(run.time, end))
        first = rows.stop
        yield rows, stage


def machine_rows(run: Recording) -> Iterator[tuple[slice, Machine]]:
    """Rows during which each machine of a run applied; at a change the previous one still does."""
    for rows, stage in stage_rows(run):
        first, machine = rows.start, stage.machine
        for time, changed in stage.changes:
            last = min(max(_after(run.time, time), first), rows.stop)
            yield slice(first, last), machine
            first, machine = last, changed
        yield slice(first, rows.stop), machine


def _after(time: Array, until: float) -> int:
    """Number of the times (m,) up to `until`."""
    return int(time.searchsorted(until + ROUNDING, side="right"))


def sample_columns(tip: Array, machine: Machine, run: Recording) -> dict[str, Column]:
    """The samples of a run, each held over the times (m,) until the next one; NaN for a stage without samples.

    `tip` (m, axes) is the tip position.
    """
    time = run.time
    columns: dict[str, Column] = {}
    for (rows, stage), samples in zip(stage_rows(run), run.samples, strict=False):
        if not np.size(samples["t"]) or rows.start == rows.stop:
            continue
        held = np.searchsorted(samples["t"], time[rows] + ROUNDING, side="right") - 1
        found = _sampled(samples, held, machine, stage) | _set_point(tip[rows], machine, samples["set_points"], held)
        for name, column in found.items():
            columns.setdefault(name, Column(np.full(time.size, np.nan), column.attrs)).values[rows] = column.values
    return columns


def _sampled(samples: Samples, held: np.ndarray, machine: Machine, stage: RecordedStage) -> dict[str, Column]:
    units = dict(zip(machine.state_names, machine.state_units, strict=True))
    units |= {name: unit for name, unit, _ in machine.core.output_info}
    columns: dict[str, Column] = {}
    for signal, column in zip(samples["signals"], samples["measured"].T, strict=True):
        columns[f"measured.{signal}"] = _column(column[held], units[signal], f"{signal} as measured")
    axes = machine.core.stick_axes if stage.stick_mode == "tip" else machine.cylinder_names
    for axis, column in zip(axes, samples["sticks"].T, strict=True):
        columns[f"stick.{axis}"] = _column(column[held], "1", f"deflection of the stick, {axis}")
    for cylinder, column in zip(machine.cylinder_names, samples["commands"].T, strict=True):
        meaning = f"{cylinder} spool command of the controller"
        columns[f"controller.{cylinder}"] = _column(column[held], "m", meaning)
    return columns


def _set_point(tip: Array, machine: Machine, set_points: Array, held: np.ndarray) -> dict[str, Column]:
    if not np.isfinite(set_points).all(axis=1).any():
        return {}
    columns: dict[str, Column] = {}
    for axis, column in zip(machine.tip_axes, set_points.T, strict=True):
        columns[f"set_point.{axis}"] = _column(column[held], "m", f"set-point of the crane tip, {axis}")
    meaning = "distance of the crane tip from the path of its set-point"
    return columns | {"tip.deviation": _column(distance_to_path(tip, set_points), "m", meaning)}


def _column(values: Array, unit: str, meaning: str) -> Column:
    return Column(values, {"units": unit, "long_name": meaning})


def distance_to_path(points: Array, path: Array) -> Array:
    """Distance of each point (m, axes) from the nearest point of a polyline (k, axes); its NaN rows are left out."""
    path = path[np.isfinite(path).all(axis=1)]
    # A set-point at rest repeats; one is sufficient.
    moved = np.any(np.diff(path, axis=0) != 0, axis=1)
    path = path[np.concatenate([[True], moved])]
    begin, legs = path[:-1], np.diff(path, axis=0)
    if not len(legs):
        begin, legs = path, np.zeros_like(path)
    square = np.maximum((legs**2).sum(axis=1), np.finfo(np.float64).tiny)
    low, high = np.minimum(begin, begin + legs), np.maximum(begin, begin + legs)
    axes = range(path.shape[1])

    def distances(some: Array) -> Array:
        # No piece counts that is farther from all of these points than a corner is. They follow each other in time, and
        # so lie close together.
        off = [some[:, i, None] - begin[::APART, i] for i in axes]
        most = np.sqrt(_square(off).min(axis=1).max()) + SLACK
        near = ((high >= some.min(axis=0) - most) & (low <= some.max(axis=0) + most)).all(axis=1)
        near |= not near.any()  # Points that are no numbers are near to nothing.
        along = legs[near]
        off = [some[:, i, None] - begin[near, i] for i in axes]
        share = np.clip(sum(off[i] * along[:, i] for i in axes) / square[near], 0.0, 1.0)
        off = [off[i] - share * along[:, i] for i in axes]
        return np.sqrt(_square(off).min(axis=1))

    parts = [distances(points[i : i + TOGETHER]) for i in range(0, len(points), TOGETHER)]
    return np.concatenate(parts) if parts else np.empty(0)


def _square(off: list[Array]) -> Array:
    """Squares of the lengths of vectors, a component in each array."""
    return sum((r * r for r in off[1:]), off[0] * off[0])
