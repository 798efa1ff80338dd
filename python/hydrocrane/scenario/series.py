"""Values against time that a run follows: spool commands, and a measured supply pressure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane.arrays import Array, brief, real_array
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import MachineLike, as_machine

if TYPE_CHECKING:
    from hydrocrane.logs.columns import LogLike

INTERPOLATIONS = tuple(_core.scenario_choices("command.<cylinder>.interpolation"))
# What makes a machine take a measured pressure.
MEASURED = {"supply.measured": "yes"}
# What logs and runs call the pressure; the second is that of a pump's mains, too.
SUPPLY, MAINS = SUPPLY_SIGNALS = ("supply.pressure", "mains.p")


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
        _check(self, "a command", "spool", "spool values")

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


@dataclass(frozen=True)
class SupplyPressure:
    """Supply pressure against time, which a run follows in place of the machine's constant one.

    The machine must not have a pump, which would determine its pressure. Controllers then still assume the machine's
    `supply.pressure`. The pressure is constant before the first time and after the last.

    Parameters
    ----------
    time : (k,) array_like
        s, increasing.
    pressure : (k,) array_like
        Gauge, Pa.
    interpolation : {"linear", "hold"}
        ``linear`` joins the points; ``hold`` keeps each value until the next time.

    Raises
    ------
    InputError
        If times and pressures do not match, or times do not increase.

    Examples
    --------
    >>> falling = hc.SupplyPressure([0.0, 2.0], [140e5, 110e5])
    >>> run = hc.simulate("vertical-lift-open-loop", supply=falling)
    >>> print((run.columns["mains.p"].values[[0, -1]] / 1e5).round())
    [140. 110.]
    """

    time: Array
    pressure: Array
    interpolation: str = "linear"

    __repr__ = brief

    if TYPE_CHECKING:
        # Whatever NumPy takes as an array may be given.
        def __init__(self, time: ArrayLike, pressure: ArrayLike, interpolation: str = "linear") -> None: ...

    def __post_init__(self) -> None:
        _check(self, "a supply pressure", "pressure", "pressures")

    @property
    def entry(self) -> tuple[Array, Array, bool]:
        """As the core takes it."""
        return self.time, self.pressure, self.interpolation == "linear"


def check_interpolation(word: str) -> None:
    check_known("interpolation", word, INTERPOLATIONS)


def _check(series: Command | SupplyPressure, what: str, name: str, plural: str) -> None:
    """Checks that times (k,) increase, and that there are as many values (k,), all finite."""
    times, values = real_array(series.time, "time"), real_array(getattr(series, name), name)
    if times.ndim != 1 or times.shape != values.shape or not times.size:
        raise InputError(f"{what} needs as many times as {plural}; got shapes {times.shape}, {values.shape}")
    if (np.diff(times) <= 0).any():
        raise InputError(f"the times of {what} must increase")
    check_interpolation(series.interpolation)
    object.__setattr__(series, "time", times)
    object.__setattr__(series, name, values)


SeriesKind = TypeVar("SeriesKind", Command, SupplyPressure)


def _made(kind: type[SeriesKind], value: object) -> SeriesKind | None:
    """Itself, or made of a dict of its parameters or of a pair (time, values); None of anything else."""
    if isinstance(value, kind):
        return value
    if isinstance(value, Mapping):
        return kind(**value)
    return kind(*value) if isinstance(value, list | tuple) and len(value) == 2 else None


# A command, a dict of its parameters, a pair (time, spool), or one constant spool value.
CommandLike: TypeAlias = Command | Mapping[str, ArrayLike] | Sequence[ArrayLike] | float
# By cylinder, or one pair (time (k,), spool (k, n_cyl)) for all.
Commands: TypeAlias = Mapping[str, CommandLike] | Sequence[ArrayLike]
# A pressure, what its parameters are, or a pair (time, pressure).
SupplyLike: TypeAlias = SupplyPressure | Mapping[str, ArrayLike] | Sequence[ArrayLike]


def as_command(cylinder: str, value: CommandLike) -> Command:
    found = _made(Command, value)
    if found is None and np.isscalar(value) and not isinstance(value, str):
        found = Command(np.array([0.0]), np.array([value]))
    if found is None:
        raise InputError(
            f"command of `{cylinder}` must be a Command, a pair (time, spool) or one number; got {value!r}"
        )
    return found


def as_supply(value: SupplyLike | None) -> SupplyPressure | None:
    found = _made(SupplyPressure, value)
    if found is None and value is not None:
        raise InputError(
            "supply must be a SupplyPressure or a pair (time, pressure), as hydrocrane.read_supply makes of a log; got "
            f"{value!r}"
        )
    return found


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


def read_supply(
    log: LogLike,
    *,
    column: str | None = None,
    unit: str | None = None,
    time: str | None = None,
    interpolation: str = "linear",
) -> SupplyPressure:
    """The supply pressure from a log.

    Parameters
    ----------
    log : path, or anything that :meth:`hydrocrane.Log.of` takes
        As :func:`hydrocrane.read_commands` takes it.
    column : str, optional
        Column of the pressures; default is ``supply.pressure``, ``mains.p``, as in saved runs, or ``supply``.
    unit : str, optional
        Its unit; default is the unit in the log, else Pa. Pressures are gauge; an absolute one, ``bara``, loses
        1.01325 bar.
    time : str, optional
        Column of the times; default is ``time`` or ``t``. In s unless the log states another unit.
    interpolation : {"linear", "hold"}
        Interpolation between two rows.

    Returns
    -------
    SupplyPressure
        For ``Scenario(supply=...)``.

    Raises
    ------
    InputError
        If the column is missing, has gaps or is no pressure, or the times do not increase.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("drive.csv").write_text("time,p_s\\n0,140\\n2,110\\n")
    >>> supply = hc.read_supply("drive.csv", column="p_s", unit="bar")
    >>> run = hc.simulate("vertical-lift-open-loop", supply=supply)
    """
    from hydrocrane.logs import Source, series_of, table_of

    check_interpolation(interpolation)
    table = table_of(log)
    found = column or table.first_of((SUPPLY, MAINS, "supply")) or SUPPLY
    wanted = {SUPPLY: Source(found, unit)}
    series = series_of(table, wanted, {SUPPLY: "Pa"}, time=time, complete=True)
    return SupplyPressure(series["time"], series[SUPPLY], interpolation)
