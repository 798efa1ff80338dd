"""Spool commands against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane.arrays import Array, brief, real_array
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import MachineLike, as_machine

if TYPE_CHECKING:
    from hydrocrane.logs.columns import LogLike

INTERPOLATIONS = tuple(_core.scenario_choices("command.<cylinder>.interpolation"))


def checked_series(what: str, time: ArrayLike, values: ArrayLike, plural: str, name: str) -> tuple[Array, Array]:
    """Times (k,) that increase and as many values (k,), both finite."""
    times, series = real_array(time, "time"), real_array(values, name)
    if times.ndim != 1 or times.shape != series.shape or not times.size:
        raise InputError(f"{what} needs as many times as {plural}; got shapes {times.shape}, {series.shape}")
    if (np.diff(times) <= 0).any():
        raise InputError(f"the times of {what} must increase")
    return times, series


def check_interpolation(word: str) -> None:
    check_known("interpolation", word, INTERPOLATIONS)


@dataclass(frozen=True)
class Command:
    """Spool command of one cylinder against time.

    Parameters
    ----------
    time : (k,) array_like
        s, increasing.
    spool : (k,) array_like
        m of spool stroke; positive extends.
    interpolation : {"hold", "linear"}
        ``hold`` keeps each value until the next time and is zero before the first; ``linear`` joins the points and
        keeps the end values.

    Examples
    --------
    >>> lift = hc.Command([0.0, 1.0], [2e-3, 0.0])
    >>> run = hc.simulate("vertical-lift-open-loop", commands={"lift": lift}, duration=1.5)
    >>> print(run.outcome.kind)
    completed
    """

    time: Array
    spool: Array
    interpolation: str = "hold"

    __repr__ = brief

    if TYPE_CHECKING:
        # Any array_like is accepted.
        def __init__(self, time: ArrayLike, spool: ArrayLike, interpolation: str = "hold") -> None: ...

    def __post_init__(self) -> None:
        time, spool = checked_series("a command", self.time, self.spool, "spool values", "spool")
        check_interpolation(self.interpolation)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "spool", spool)

    def at(self, t: Array) -> Array:
        """Values at times t (m,), m.

        Examples
        --------
        >>> hc.Command([0.0, 1.0], [0.0, 0.004], "linear").at(0.5)
        array(0.002)
        """
        if self.interpolation == "linear":
            return np.asarray(np.interp(t, self.time, self.spool), dtype=np.float64)
        index = np.searchsorted(self.time, t, side="right") - 1
        return np.where(index < 0, 0.0, self.spool[index])


# A command, a dict of its parameters, a pair (time, spool), or one constant spool value.
CommandLike: TypeAlias = Command | Mapping[str, ArrayLike] | Sequence[ArrayLike] | float
# By cylinder, or one pair (time (k,), spool (k, n_cyl)) for all.
Commands: TypeAlias = Mapping[str, CommandLike] | Sequence[ArrayLike]


def as_command(cylinder: str, value: CommandLike) -> Command:
    if isinstance(value, Command):
        return value
    if isinstance(value, Mapping):
        return Command(**value)  # type: ignore[arg-type]
    if isinstance(value, list | tuple) and len(value) == 2:
        return Command(*value)
    if np.isscalar(value) and not isinstance(value, str):
        return Command(np.array([0.0]), np.array([value]))
    raise InputError(f"command of `{cylinder}` must be a Command, a pair (time, spool) or one number; got {value!r}")


def split_table(commands: object, cylinders: tuple[str, ...]) -> dict[str, Command]:
    if not isinstance(commands, tuple | list) or len(commands) != 2:
        raise InputError(f"commands must be a mapping by cylinder, or a pair (time (k,), spool (k, {len(cylinders)}))")
    time, table = real_array(commands[0], "time"), real_array(commands[1], "spool")
    if table.shape != (time.size, len(cylinders)):
        raise InputError(f"spool must have shape ({time.size}, {len(cylinders)}), one row per time; got {table.shape}")
    return {name: Command(time, table[:, i]) for i, name in enumerate(cylinders)}


def read_commands(
    log: LogLike,
    machine: MachineLike,
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    time: str | None = None,
    interpolation: str = "linear",
) -> dict[str, Command]:
    """Spool commands from a log.

    Parameters
    ----------
    log : path, or anything that :meth:`hydrocrane.Log.of` takes
        Of any format of :func:`hydrocrane.read_log`; ``[command] log`` of a scenario file reads texts.
    machine : Machine, str or path
        The machine whose cylinders get the commands.
    columns : mapping, optional
        Cylinder -> column of the log. By default every cylinder that has a column with its name,
        ``command.<cylinder>`` or ``cylinder.<cylinder>.command``, as in saved runs.
    units : mapping, optional
        Cylinder -> unit of its column; default is the unit in the log, else m.
    time : str, optional
        Column of the times; default is ``time`` or ``t``. In s unless the log states another unit.
    interpolation : {"linear", "hold"}
        Interpolation between two rows.

    Returns
    -------
    dict of Command
        By cylinder, for ``Scenario(commands=...)``.

    Raises
    ------
    InputError
        If a column is missing, has gaps or is no length, or the times do not increase.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("drive.csv").write_text("time,u_lift\\n0,2\\n1,0\\n")
    >>> commands = hc.read_commands("drive.csv", "rottne-f9-lab", columns={"lift": "u_lift"}, units={"lift": "mm"})
    >>> run = hc.simulate("vertical-lift-open-loop", commands=commands)
    """
    from hydrocrane.logs import Source, series_of, table_of

    check_interpolation(interpolation)
    own, columns, units = as_machine(machine), columns or {}, units or {}
    for cylinder in (*columns, *units):
        check_known("cylinder", cylinder, own.cylinder_names)
    asked = {cylinder for cylinder in own.cylinder_names if cylinder in columns or cylinder in units}
    table = table_of(log)
    wanted = {}
    for cylinder in own.cylinder_names:
        usual = (cylinder, f"command.{cylinder}", f"cylinder.{cylinder}.command")
        column = columns.get(cylinder) or table.first_of(usual)
        if cylinder in asked or (column and not asked):
            wanted[f"command.{cylinder}"] = Source(column or cylinder, units.get(cylinder))
    if not wanted:
        raise InputError(
            f"{table.source} has no column of a command; it has {', '.join(table.columns)}. Name its columns "
            f"{', '.join(own.cylinder_names)}, or state which is which with columns="
        )
    series = series_of(table, wanted, dict.fromkeys(wanted, "m"), time=time, complete=True)
    times = series.pop("time")
    return {name.removeprefix("command."): Command(times, spool, interpolation) for name, spool in series.items()}
