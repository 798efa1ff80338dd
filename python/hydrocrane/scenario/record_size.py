"""Limit of the memory that a record takes, reckoned before a run, so that no run fails for lack of memory."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import Protocol

from hydrocrane.arrays import real_array
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine

# Default limit of the memory of one record, of a run or of a case of a study, or of the state of a batch, bytes.
MOST_BYTES = 2e9
# Smallest limit that can be given: smaller ones are gigabytes without their unit.
_LEAST_BYTES = 1e6
_BYTES = 8
_PREFIXES = {"": 0, "k": 1, "M": 2, "G": 3, "T": 4}
# Time between samples of one's own controllers and of those by name whose machine states none, s.
_PERIOD = 0.01


class RecordedPlan(Protocol):
    """What a scenario says of its record."""

    @property
    def duration(self) -> float: ...
    @property
    def record_limit(self) -> float | str | None: ...
    @property
    def has_controller(self) -> bool: ...
    @property
    def period(self) -> float | None: ...


def row_count(duration: float, interval: float) -> float:
    """Times from 0 to `duration` (s) every `interval` (s); a float, because it may exceed the range of integers."""
    steps = duration / interval * (1 + 1e-12) if interval > duration / 1e300 else math.inf
    return math.floor(steps) + 1.0 if math.isfinite(steps) else math.inf


def bytes_of(limit: float | str | None) -> float:
    """A limit of memory in bytes: a number of bytes or a text, ``"8 GB"``; ``None`` is the default, 2 GB.

    Examples
    --------
    >>> print(bytes_of("8 GB"), bytes_of("512 MiB"), bytes_of(None))
    8000000000.0 536870912.0 2000000000.0
    """
    if limit is None:
        return MOST_BYTES
    if isinstance(limit, str):
        found = re.fullmatch(r"\s*([0-9.]+)\s*([kMGT]?)(i?)B\s*", limit)
        try:
            size = float(found[1]) * (1024 if found[3] else 1000) ** _PREFIXES[found[2]] if found else math.nan
        except ValueError:
            size = math.nan
    else:
        number = real_array(limit, "record_limit")
        size = float(number) if not number.ndim else math.nan
    if not size >= _LEAST_BYTES:
        raise InputError(f'record_limit is a size of memory with its unit, 1 MB or more, such as "8 GB"; got {limit!r}')
    return size


def row_numbers(machine: Machine, *, ledger: bool = False, controlled: bool = False) -> int:
    """Numbers that a run on `machine` keeps for each of its times: as many as it has columns, or one more.

    Examples
    --------
    >>> run = hc.simulate("vertical-lift-open-loop", duration=0.1)
    >>> print(row_numbers(run.machine, ledger=True) == len(run.columns))
    True
    """
    plain, entries, sampled = _numbers(machine)
    # With the deviation from the path.
    return plain + (entries if ledger else 0) + (sampled + 1 if controlled else 0)


# The cases of a study ask with one machine.
@lru_cache(8)
def _numbers(machine: Machine) -> tuple[int, int, int]:
    """Numbers of a time, of the ledger at a time, and most numbers of a sample."""
    core, cylinders = machine.core, len(machine.cylinder_names)
    # Time, payload, states, commands, outputs.
    plain = 2 + len(machine.state_names) + cylinders + len(core.output_info)
    return plain, len(core.ledger_info), _sampled(machine)


def _sampled(machine: Machine) -> int:
    """Readings of joints, pistons and chambers, sticks, commands, set-point."""
    cylinders, sticks = len(machine.cylinder_names), len(machine.core.stick_axes)
    return len(machine.joint_names) + 4 * cylinders + max(cylinders, sticks) + len(machine.tip_axes)


def check_record(
    machine: Machine,
    plan: RecordedPlan,
    rows: float,
    *,
    ledger: bool = False,
    parameters: int = 0,
    interval: str = "record_interval",
) -> None:
    """Refuse a run of `plan` on `machine` whose record of `rows` times would take more than its limit.

    It has derivatives by so many `parameters` besides. The times follow from the argument `interval`.

    Raises
    ------
    InputError
        With the size and the cure.
    """
    numbers = row_numbers(machine, ledger=ledger, controlled=plan.has_controller) * (1 + parameters)
    samples = 0.0
    if plan.has_controller:
        stated = float(machine.value("control.period").si) if "control.period" in machine.keys else _PERIOD
        samples = (1 + _numbers(machine)[2]) * row_count(plan.duration, plan.period or stated)
    counted = f"{rows:.4g} times {numbers} numbers" + (f" and {samples:.3g} of its samples" if samples else "")
    cure = f'a longer {interval}, a shorter duration, or a higher record_limit ("8 GB") if there is memory'
    check_size("the record of this run", rows * numbers + samples, counted, cure, bytes_of(plan.record_limit))


def check_size(what: str, numbers: float, counted: str, cure: str, most: float = MOST_BYTES) -> None:
    """Refuse so many `numbers`, in words `counted`, if they need more than `most` bytes.

    Raises
    ------
    InputError
        With the number of bytes and the `cure`.
    """
    size = numbers * _BYTES
    if size > most:
        raise InputError(f"{what} would take {_shown(size)} ({counted}), more than {_shown(most)}; give {cure}")


def _shown(size: float) -> str:
    if math.isinf(size):
        return "more bytes than can be counted"
    return f"{size / 1e9:.3g} GB"
