"""A measured supply pressure against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from numpy.typing import ArrayLike

from hydrocrane.arrays import Array, brief
from hydrocrane.errors import InputError
from hydrocrane.scenario.command import check_interpolation, checked_series

if TYPE_CHECKING:
    from hydrocrane.logs.columns import LogLike

# What makes a machine take a measured pressure.
MEASURED = {"supply.measured": "yes"}
# What logs and runs call the pressure; the second is that of a pump's mains, too.
SUPPLY, MAINS = SUPPLY_SIGNALS = ("supply.pressure", "mains.p")


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
        time, pressure = checked_series("a supply pressure", self.time, self.pressure, "pressures", "pressure")
        check_interpolation(self.interpolation)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "pressure", pressure)

    @property
    def entry(self) -> tuple[Array, Array, bool]:
        """As the core takes it."""
        return self.time, self.pressure, self.interpolation == "linear"


# A pressure, what its parameters are, or a pair (time, pressure).
SupplyLike: TypeAlias = SupplyPressure | Mapping[str, ArrayLike] | Sequence[ArrayLike]


def as_supply(value: SupplyLike | None) -> SupplyPressure | None:
    if value is None or isinstance(value, SupplyPressure):
        return value
    if isinstance(value, Mapping):
        return SupplyPressure(**value)  # type: ignore[arg-type]
    if isinstance(value, list | tuple) and len(value) == 2:
        return SupplyPressure(*value)
    raise InputError(
        f"supply must be a SupplyPressure or a pair (time, pressure), as hydrocrane.read_supply makes of a log; got "
        f"{value!r}"
    )


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
