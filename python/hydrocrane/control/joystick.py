"""Sticks of the operator, against time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane.arrays import Array, brief, real_array, scenario_quantity
from hydrocrane.errors import InputError, check_known

if TYPE_CHECKING:
    from hydrocrane.logs.columns import LogLike

MODES = tuple(_core.scenario_choices("joystick.mode"))
# The stick modes of each controller by name.
MODES_OF = {"tip": ("tip", "height"), "heinze-pid": ("tip",), "lever": ("lever",)}
TIP_AXES = tuple(_core.TIP_AXES)
INTERPOLATIONS = tuple(_core.scenario_choices("joystick.interpolation"))
# Rounding error by which a deflection may exceed its end; it counts as the end.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Stick:
    """The sticks at one sample.

    Attributes
    ----------
    mode : {"tip", "lever", "height"}
    axes : (2,), (3,) or (n_cyl,) array
        Deflections in -1 to 1: x (forward) and z (up), of a crane that slews also slew (across), or one per cylinder.
    full_speed : float or None
        Speed of the tip at full deflection, m/s, if the joystick states it.

    Examples
    --------
    >>> stick = hc.Stick("tip", np.array([0.0, 0.2]))
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> plant, controller = hc.Simulator(crane), hc.NamedController("tip")
    >>> obs = plant.reset(q=np.deg2rad([100.0, 100.0, 0.0]))
    >>> controller.reset(crane, obs)
    >>> print(len(controller.step(obs, stick)), "spool commands")
    3 spool commands
    """

    mode: str
    axes: Array
    full_speed: float | None = None

    __repr__ = brief

    @property
    def velocity(self) -> Array:
        """Commanded velocity of the tip, m/s: (2,) forward and up, or (3,) with that across.

        The slewing joint may limit the last one.
        """
        if self.mode != "tip" or self.full_speed is None:
            raise InputError("only a stick of mode `tip` with a full_speed commands a velocity")
        return self.axes * self.full_speed


class StickFields(TypedDict, total=False):
    """Fields of a joystick besides its times, axes and mode."""

    interpolation: str
    dead_zone: float
    full_speed: float | None
    ramp: float
    precision: ArrayLike


@dataclass(frozen=True)
class Joystick:
    """Deflections of the sticks against time.

    Parameters
    ----------
    time : (k,) array_like
        s, increasing. Before the first time the sticks are centred.
    axes : mapping
        ``x`` and ``z`` in mode ``tip`` (one stick moves the tip), of a crane that slews also ``slew``; cylinder names
        in modes ``lever`` and ``height`` (one axis per cylinder): deflections (k,) in -1 to 1. An axis left out stays
        centred.
    mode : {"tip", "lever", "height"}
        ``height``: a lever commands the speed of its piston, and one joint, the telescope, holds the tip's height, see
        docs/howto/hold-the-height.md.
    interpolation : {"hold", "linear"}
    dead_zone : float
        Dead zone around the centre, share of the deflection; the rest counts from 0 to 1.
    full_speed : float, optional
        Speed of the tip at full deflection, m/s; default is the machine's or the controller's own. In mode ``height``
        it is that of goals.
    ramp : float
        Time that a stick takes from its centre to its end, s.
    precision : (k,) array_like
        Share of the full speed at each time, 0 to 1, for precise work; empty: full speed.

    Examples
    --------
    >>> up = hc.Joystick([0.5, 2.0], {"z": [1.0, 0.0]}, full_speed=0.1, ramp=0.2)
    >>> start = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
    >>> run = hc.simulate(hc.Scenario(joints=start, joystick=up, duration=3.0))
    >>> z = run.columns["tip.z"].values
    >>> print(f"up by {z[-1] - z[0]:.2f} m")
    up by 0.15 m
    """

    time: Array
    axes: Mapping[str, Array] = field(default_factory=dict)
    mode: str = "tip"
    interpolation: str = "hold"
    dead_zone: float = 0.0
    full_speed: float | None = None
    ramp: float = 0.0
    precision: Array = field(default_factory=lambda: np.empty(0))

    __repr__ = brief

    if TYPE_CHECKING:
        # Any array_like is accepted.
        def __init__(
            self,
            time: ArrayLike,
            axes: Mapping[str, ArrayLike] = ...,
            mode: str = "tip",
            interpolation: str = "hold",
            dead_zone: float = 0.0,
            full_speed: float | None = None,
            ramp: float = 0.0,
            precision: ArrayLike = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        check_known("stick mode", self.mode, MODES)
        check_known("interpolation", self.interpolation, INTERPOLATIONS)
        time = real_array(self.time, "time")
        if time.ndim != 1 or (np.diff(time) <= 0).any():
            raise InputError("the times of a joystick must be a list that increases")
        axes = {str(name): _deflections(name, values, time) for name, values in self.axes.items()}
        if self.mode == "tip":
            for name in axes:
                check_known("stick axis", name, TIP_AXES)
        if scenario_quantity("joystick.dead-zone", "dead_zone", self.dead_zone) >= 1:
            raise InputError(f"dead_zone must be below 1, otherwise it covers the whole stick; got {self.dead_zone!r}")
        scenario_quantity("joystick.ramp", "ramp", self.ramp)
        if self.full_speed is not None:
            scenario_quantity("joystick.full-speed", "full_speed", self.full_speed)
        precision = real_array(self.precision, "precision")
        if precision.size and precision.shape != time.shape:
            raise InputError(f"precision has shape {precision.shape} for {time.size} times")
        if ((precision < 0) | (precision > 1)).any():
            raise InputError("precision is a share of the full speed, from 0 to 1")
        object.__setattr__(self, "precision", precision)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "axes", axes)

    @classmethod
    def from_log(
        cls,
        log: LogLike,
        *,
        mode: str = "tip",
        columns: Mapping[str, str] | None = None,
        **more: Unpack[StickFields],
    ) -> Joystick:
        """A joystick from a log.

        Parameters
        ----------
        log : path of a CSV, MATLAB or NetCDF file, or Dataset, DataFrame, mapping
            With a time column (``time`` or ``t``, s) and one column of deflections, -1 to 1, per axis, named ``x`` or
            ``stick.x`` and so on.
        mode : {"tip", "lever", "height"}
        columns : mapping, optional
            Log column -> axis, if the names differ.
        **more
            Other fields of a joystick; ``interpolation`` is ``linear`` unless given.

        Examples
        --------
        >>> log = {"time": [0.0, 1.0, 2.0], "stick.z": [0.0, 0.5, 0.0]}
        >>> stick = hc.Joystick.from_log(log)
        >>> print(stick.at(0.5).axes)
        [0.   0.25]
        """
        from hydrocrane.logs import TIME_NAMES, Source, series_of, table_of

        table = table_of(log)
        if columns is None:
            names = dict.fromkeys(_core.split_name(name)[0] for name in table.columns)
            short = {name: name.removeprefix("stick.") for name in names if name.lower() not in TIME_NAMES}
            own = {name: axis for name, axis in short.items() if axis != "precision"}
            prefixed = {name: axis for name, axis in own.items() if name != axis}
            given = prefixed or {name: axis for name, axis in own.items() if mode != "tip" or axis in TIP_AXES}
        else:
            given = dict(columns)
        if not given:
            known = ", ".join(table.columns)
            raise InputError(f"the log has no column of a stick axis; it has {known}; name it with columns=")
        if mode == "tip" and not set(given.values()) & set(TIP_AXES):
            levers = ", ".join(given.values())
            raise InputError(
                f'the log has levers, {levers}, and no stick axis x, z or slew; give mode="lever" or "height"'
            )
        wanted = {f"stick.{axis}": Source(name) for name, axis in given.items()}
        precision = table.first_of(("stick.precision", "precision"))
        if precision is not None and "precision" not in more:
            wanted["stick.precision"] = Source(precision)
        series = series_of(table, wanted, dict.fromkeys(wanted, "1"), every=columns is None, complete=True)
        if "stick.precision" in wanted:
            more["precision"] = series.pop("stick.precision")
        time = series.pop("time")
        fields: StickFields = {"interpolation": "linear", **more}
        return cls(time, {name.removeprefix("stick."): values for name, values in series.items()}, mode, **fields)

    def table(self, cylinders: tuple[str, ...]) -> Array:
        """Deflections (k, axes), in the order x, z, slew or that of `cylinders`; without ``slew`` there are two.

        Examples
        --------
        >>> stick = hc.Joystick([0.0, 1.0], {"z": [0.5, 0.0]})
        >>> print(stick.table(()).tolist())
        [[0.0, 0.5], [0.0, 0.0]]
        """
        tip = TIP_AXES if TIP_AXES[2] in self.axes else TIP_AXES[:2]
        names = tip if self.mode == "tip" else cylinders
        for name in self.axes:
            check_known("stick axis", name, names)
        centred = np.zeros(self.time.size)
        return np.column_stack([self.axes.get(name, centred) for name in names])

    def at(self, t: float, cylinders: tuple[str, ...] = ()) -> Stick:
        """The sticks at time t, after the dead zone and without the ramp, for your own loops.

        Examples
        --------
        >>> stick = hc.Joystick([0.0, 1.0], {"z": [0.5, 0.0]}, dead_zone=0.1)
        >>> print(stick.at(0.5).axes.round(3), stick.at(1.5).axes)
        [0.    0.444] [0. 0.]
        """
        table = self.table(cylinders)
        row = int(np.searchsorted(self.time, t + 1e-12, side="right")) - 1
        if row < 0:
            raw = np.zeros(table.shape[1])
        elif self.interpolation == "linear":
            raw = np.array([np.interp(t, self.time, column) for column in table.T])
        else:
            raw = table[row]
        raw = np.clip(raw, -1.0, 1.0)
        beyond = (raw - np.clip(raw, -self.dead_zone, self.dead_zone)) / (1.0 - self.dead_zone)
        return Stick(self.mode, self._share(row, t) * beyond, self.full_speed)

    def _share(self, row: int, t: float) -> float:
        """Share of the full speed at time t, after the time of `row`."""
        if row < 0 or not self.precision.size:
            return 1.0
        if self.interpolation == "linear":
            return float(np.interp(t, self.time, self.precision))
        return float(self.precision[row])


def _deflections(name: str, values: ArrayLike, time: Array) -> Array:
    array = real_array(values, f"the deflection of `{name}`")
    if array.shape != time.shape:
        raise InputError(f"the deflection of `{name}` has shape {array.shape} for {time.size} times")
    if (np.abs(array) > 1 + ROUNDING).any():
        raise InputError(f"the deflection of `{name}` reaches {np.abs(array).max():.9g}; a stick ends at 1")
    return np.clip(array, -1.0, 1.0)
