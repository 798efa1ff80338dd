"""A crane as Python sees it: geometry, mechanics, hydraulics and the full right-hand side.

Units are SI and radians, pressures are gauge. Every method takes single vectors or batches with any leading axes.
A pose far outside the joint ranges is refused, as it is in degrees or millimetres: :mod:`hydrocrane.machine.poses`.
A cylinder force is net of friction and end stop; positive pushes the piston out. A spool command is in metres of
spool stroke; positive extends the piston. Equation numbers are those of Heinze (2007).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias, Unpack, cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane._core_types import Passivity
from hydrocrane.arrays import Array, real_array, rows, scalars, vectors
from hydrocrane.errors import HydrocraneError, InputError, OutOfReachError, translated, unknown
from hydrocrane.machine.described import described
from hydrocrane.machine.measuring import Recorded, recorded_data, sensor_readings
from hydrocrane.machine.overrides import Override, Overrides, plain_overrides
from hydrocrane.machine.poses import poses
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.machine.stated import Stated
from hydrocrane.result_warning import DoubtfulResult, ResultWarning

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.linear.linearise import Options
    from hydrocrane.linear.model import LinearModel


def load_machine(source: str | PathLike[str], overrides: Overrides | None = None) -> Machine:
    """Load a machine file.

    Parameters
    ----------
    source : str or path
        Name of a bundled machine, or a path to a TOML file.
    overrides : mapping, optional
        Dotted key to value, for example ``{"supply.pressure": "100 bar", "payload.mass": 200}``; a number is SI,
        a string needs its unit. They have priority over the file; a scenario's own payload has priority over them.

    Raises
    ------
    MachineFileError
        With file, line, column, key and cure.

    Examples
    --------
    >>> crane = hc.load_machine("rottne-f9-lab", {"supply.pressure": "100 bar"})
    >>> print(crane.name, crane.supply_pressure)
    rottne-f9-lab 10000000.0
    """
    given = {} if overrides is None else plain_overrides(overrides)
    with translated():
        core = _core.load_machine(str(source), list(given.items()))
    path = Path(source)
    bundled = str(source) in _core.bundled_machines()
    return Machine(core, str(source) if bundled else str(path.resolve()), given)


def as_machine(machine: MachineLike) -> Machine:
    """`machine` itself, or the machine with this name or path.

    Raises
    ------
    InputError
        If it is neither a machine, nor a name, nor a path.
    """
    if isinstance(machine, Machine):
        return machine
    if isinstance(machine, str | PathLike):
        return load_machine(machine)
    raise InputError(f"a machine is given as a Machine, a bundled name or a path of a file; got {machine!r}")


def bundled_machines() -> tuple[str, ...]:
    """Names of the machines of the package.

    Examples
    --------
    >>> "rottne-f9-lab" in hc.bundled_machines()
    True
    """
    return tuple(_core.bundled_machines())


# Poses of a tip, nested like the tips.
Poses: TypeAlias = "list[Array] | list[Poses]"
MachineLike: TypeAlias = "Machine | str | PathLike[str]"


class Machine(Stated):
    """A loaded machine; made by :func:`load_machine`, never changed afterwards.

    Examples
    --------
    >>> crane = hc.load_machine("rottne-f9-lab")
    >>> q = np.deg2rad([100.0, 100.0, 0.0])
    >>> print(crane.joint_names, crane.tip(q).round(3))
    ('boom', 'jib', 'extension') [ 2.825 -0.199]
    >>> many = crane.tip(np.tile(q, (5, 1)))
    >>> print(many.shape, crane.static_cylinder_force(q).round(-2))
    (5, 2) [7900. -900. -100.]
    """

    def __init__(self, core: _core.Machine, source: str, overrides: dict[str, Override]) -> None:
        self.core = core
        self.source = source
        self.overrides = overrides

    def __repr__(self) -> str:
        return f"<Machine {self.name}: joints {', '.join(self.joint_names)}; {len(self.state_names)} states>"

    def _repr_html_(self) -> str:
        return described(self.core, self.provenance_tally, self.warnings)

    def __reduce__(self) -> tuple[Callable[[str, Overrides], Machine], tuple[str, dict[str, Override]]]:
        return load_machine, (self.source, self.overrides)

    def changed(self, overrides: Overrides) -> Machine:
        """This machine with some values replaced, on top of its own overrides; see :func:`load_machine`."""
        if not overrides:
            return self
        given = {**self.overrides, **plain_overrides(overrides)}
        with translated():
            return Machine(self.core.rebuilt(list(given.items())), self.source, given)

    def overrides_at(self, keys: Sequence[str], values: ArrayLike) -> dict[str, Override]:
        """Overrides that give `keys` these `values` (n_keys,), SI; ``[0]`` and ``[1]`` are the two values of a pair.

        Values of a pair that are not named stay as they are.
        """
        found: dict[str, Override] = {}
        for key, value in zip(keys, real_array(values, "values").tolist(), strict=True):
            name, _, side = key.partition("[")
            if not side:
                found[name] = value
                continue
            pair = found.setdefault(name, np.broadcast_to(self.value(name).si, (2,)).tolist())
            cast("list[float]", pair)[int(side[0])] = value
        return found

    def made(self, core: _core.Machine) -> Machine:
        """The machine of a core object; this machine itself if it is its own."""
        overrides = dict(core.overrides)
        if core.source == self.core.source and overrides == self.overrides:
            return self
        return Machine(core, self.source if core.source == self.core.source else core.source, overrides)

    # --- description ---------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the machine, as its file states it."""
        return self.core.name

    @property
    def title(self) -> str:
        """What it is, in a few words."""
        return self.core.title

    @property
    def description(self) -> str:
        """What the machine file says about it."""
        return self.core.description

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints from the base to the tip, in the order of every `q`."""
        return tuple(self.core.joint_names)

    @cached_property
    def joint_units(self) -> tuple[str, ...]:
        """Unit of each joint coordinate: ``rad`` or ``m``."""
        return tuple(self.core.joint_units)

    @cached_property
    def cylinder_names(self) -> tuple[str, ...]:
        """Cylinder names; cylinder i moves joint i."""
        return tuple(self.core.cylinder_names)

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in the order of every state vector."""
        return tuple(self.core.state_names)

    @cached_property
    def state_units(self) -> tuple[str, ...]:
        """SI unit of each state."""
        return tuple(self.core.state_units)

    @cached_property
    def joint_limits(self) -> Array:
        """(n, 2) lowest and highest coordinate, rad or m; reasons in :attr:`joint_limit_reasons`."""
        return np.array(self.core.joint_limits, dtype=np.float64)

    @property
    def joint_limit_reasons(self) -> tuple[tuple[str, str], ...]:
        """Per joint, what sets its lower and its upper limit."""
        return tuple((low, high) for low, high in self.core.joint_limit_reasons)

    @cached_property
    def stroke_limits(self) -> Array:
        """(n_cyl, 2) piston positions from mid-stroke, m."""
        return np.array(self.core.stroke_limits, dtype=np.float64)

    @cached_property
    def spool_strokes(self) -> Array:
        """(n_cyl,) largest spool displacement, m."""
        return np.array(self.core.spool_strokes, dtype=np.float64)

    @property
    def supply_pressure(self) -> float:
        """Pa, gauge."""
        return float(self.core.supply_pressure)

    @property
    def payload_mass(self) -> float:
        """Default payload at the tip, kg."""
        return float(self.core.payload_mass)

    def clearance(self, place: ArrayLike) -> Array:
        """Distance of places (..., 2) from the nearest :attr:`keep_out` region, m, negative inside."""
        lead, (points,) = rows(vectors(place, "place", ("x", "z")))
        return self.core.clearance(points).reshape(lead)

    @cached_property
    def home(self) -> Array:
        """(n,) pose in the middle of the joint limits."""
        return self.joint_limits.mean(axis=1)

    @cached_property
    def piston_areas(self) -> Array:
        """(n_cyl, 2) piston-side and rod-side area, m^2."""
        return np.array(self.core.areas, dtype=np.float64)

    @cached_property
    def holdable_pressures(self) -> Array:
        """(n_cyl, 2) highest pressure at which piston side and rod side carry a load at rest, Pa.

        The least of the highest pressure of the mains, at which the pump still gives its leakage, and the pressures to
        which relief valves at the port are tight, with the tank's pressure on the other side.
        """
        return np.array(self.core.holdable, dtype=np.float64)

    # --- geometry -----------------------------------------------------------------------------------------------

    def strokes(self, q: ArrayLike) -> Array:
        """Piston positions from mid-stroke (..., n_cyl), m, of joint coordinates q (..., n)   (40)-(42)."""
        return self._over(self.core.strokes, self._joints(q))

    def joints_from_strokes(self, x: ArrayLike) -> Array:
        """Joint coordinates (..., n) of piston positions x (..., n_cyl), on the branch inside the joint limits.

        Raises
        ------
        OutOfReachError
            If no pose inside the limits has these strokes.
        """
        x = vectors(x, "x", self.cylinder_names)
        return self._over(self.core.joints_from_strokes, x, error=OutOfReachError)

    def stroke_jacobian(self, q: ArrayLike) -> Array:
        """d(strokes)/d(q), (..., n_cyl, n)."""
        return self._over(self.core.stroke_jacobian, self._joints(q))

    @property
    def tip_gains(self) -> dict[str, float]:
        """Gains of the controller ``tip`` by their keys in ``[control.tip]``, SI: from the file, else the defaults."""
        return dict(self.core.tip_gains)

    def cylinder_slopes(self, q: ArrayLike) -> Array:
        """Direction of each cylinder from barrel to rod (..., n_cyl), rad from x towards z; thesis (15), (28)."""
        return self._over(self.core.cylinder_slopes, self._joints(q))

    def centres_of_gravity(self, q: ArrayLike) -> Array:
        """Centre of gravity of each moving link (..., n, 2) in the inertial frame, m; thesis (31)-(33)."""
        return self._over(self.core.centres_of_gravity, self._joints(q))

    def tip(self, q: ArrayLike) -> Array:
        """Crane tip in the inertial frame (..., 2): x forward, z up, m   (30)-(34)."""
        return self._over(self.core.tip, self._joints(q))

    def tip_jacobian(self, q: ArrayLike) -> Array:
        """d(tip)/d(q), (..., 2, n)."""
        return self._over(self.core.tip_jacobian, self._joints(q))

    def inverse_kinematics(self, tip: ArrayLike, x3: float = 0.0) -> Poses:
        """Poses that put the tip at `tip` (2,) with the telescope at `x3`, m   (35)-(39).

        Returns
        -------
        list of (n,) arrays
            Only poses inside the joint limits, best first; empty if none reaches it. A batch of tips (..., 2)
            gives lists nested in its leading axes.
        """
        tip = vectors(tip, "tip", ("x", "z"))
        extension = real_array(x3, "x3")
        if extension.ndim:
            raise InputError(f"x3 must be one number in metres, got shape {extension.shape}")
        if tip.ndim > 1:
            return [self.inverse_kinematics(point, float(extension)) for point in tip]
        with translated():
            found = self.core.inverse_kinematics(np.ascontiguousarray(tip), float(extension))
        return [np.array(pose, dtype=np.float64) for pose in found]

    def workspace(self) -> list[Array]:
        """Boundary curves of the tip's reach, each (k, 2) in the inertial frame, m   (3.1.3)."""
        return [np.asarray(curve, dtype=np.float64) for curve in self.core.workspace()]

    def drawing(self, q: ArrayLike) -> list[tuple[str, str, Array]]:
        """Lines of the crane in pose q (n,): (kind, name, (k, 2) points in the inertial frame, m).

        `kind` is one of ``link``, ``cylinder-barrel``, ``cylinder-rod``, ``torque-link``, ``joint``, ``tip``.
        """
        q = self._joints(q)
        if q.ndim != 1:
            raise InputError(f"drawing takes one pose of shape ({len(self.joint_names)},), got shape {q.shape}")
        with translated():
            return [(kind, name, np.asarray(line)) for kind, name, line in self.core.drawing(np.ascontiguousarray(q))]

    # --- mechanics ----------------------------------------------------------------------------------------------

    def mass_matrix(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Mass matrix M (..., n, n)   (59)."""
        return self._over(self.core.mass_matrix, self._joints(q), payload=payload)

    def bias_force(self, q: ArrayLike, qd: ArrayLike, *, payload: float | None = None) -> Array:
        """Coriolis, centrifugal and gravity terms h (..., n): M qdd + h = J_l^T f_cyl.

        It is minus the thesis's h of (60), without the cylinder forces Q.
        """
        return self._over(self.core.bias_force, self._joints(q), self._joints(qd, "qd"), payload=payload)

    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, cylinder_force: ArrayLike, *, payload: float | None = None
    ) -> Array:
        """Joint accelerations (..., n) under net cylinder forces (..., n_cyl), N."""
        force = vectors(cylinder_force, "cylinder_force", self.cylinder_names)
        return self._over(self.core.forward_dynamics, self._joints(q), self._joints(qd, "qd"), force, payload=payload)

    def static_cylinder_force(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Net cylinder forces (..., n_cyl) that hold the crane at rest, N."""
        return self._over(self.core.static_cylinder_force, self._joints(q), payload=payload)

    def piston_speeds(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Lowest and highest steady piston speed (..., n_cyl, 2) at full spool stroke under the load at rest, m/s.

        Negative retracts. One piston moves and the other spools are closed; the whole circuit counts: pump and its
        limits, compensators, load-holding and port valves, friction. Zero if the supply cannot move the load.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-mobile")
        >>> slow = crane.changed({"pump.main.displacement": "5 ml"})
        >>> q = crane.home
        >>> print(bool((abs(slow.piston_speeds(q)) < abs(crane.piston_speeds(q))).any()))
        True
        """
        return self._over(self.core.piston_speeds, self._joints(q), payload=payload)

    def spool_positions(self, shares: ArrayLike) -> Array:
        """Spool positions (..., n_cyl), m, that have signed `shares` (..., n_cyl) of the steady speed at full stroke.

        A share is that of the speed through the valve alone; positive extends, 0 is the middle. Overlaps and curves of
        the metering edges are in it; dead bands and gains of `valve.<name>.command` are not.
        Source: docs/theory/control/feed_forward.md.

        Examples
        --------
        >>> import hydrocrane as hc
        >>> hc.load_machine("rottne-f9-mobile").spool_positions([0.5, 0.0, -1.0])
        array([ 0.0275,  0.    , -0.05  ])
        """
        return self._over(self.core.spool_positions, vectors(shares, "shares", self.cylinder_names))

    def kinetic_energy(self, q: ArrayLike, qd: ArrayLike, *, payload: float | None = None) -> Array:
        """Kinetic energy (...), J   (45)."""
        return self._over(self.core.kinetic_energy, self._joints(q), self._joints(qd, "qd"), payload=payload)

    def potential_energy(self, q: ArrayLike, *, payload: float | None = None) -> Array:
        """Potential energy (...), J   (52), increasing upwards."""
        return self._over(self.core.potential_energy, self._joints(q), payload=payload)

    # --- hydraulics and friction --------------------------------------------------------------------------------

    def orifice_flow(self, spool: ArrayLike, dp: ArrayLike, cylinder: str | None = None) -> Array:
        """Flow through one metering edge, m^3/s   (64)-(74).

        Parameters
        ----------
        spool : array_like
            Opening of the edge, m of spool stroke.
        dp : array_like
            Pressure drop across the edge, Pa; broadcasts against `spool`.
        cylinder : str, optional
            Cylinder of the valve; the first one by default.
        """
        return self._per_cylinder(self.core.orifice_flow, cylinder, spool=spool, dp=dp)

    def edge_areas(self, spool: ArrayLike, cylinder: str | None = None) -> Array:
        """Areas (..., 4) of the metering edges at spool positions, m: supply to A, A to tank, supply to B, B to tank.

        Shares of the area that has the nominal flow at the nominal drop: times :meth:`orifice_flow` at the opening
        of the full stroke they give flows. `cylinder` says whose valve, the first one's by default.
        """
        index = self._index_of(cylinder)
        lead, (column,) = scalars(real_array(spool, "spool"))
        with translated():
            return np.asarray(self.core.edge_areas(index, column)).reshape((*lead, 4))

    def friction_map(self, v: ArrayLike, cylinder: str | None = None) -> Array:
        """Steady friction force, N, at piston velocity v, m/s; positive against positive velocity   (107)-(113)."""
        return self._per_cylinder(self.core.friction_map, cylinder, v=v)

    def bulk_modulus(self, p: ArrayLike) -> Array:
        """Effective bulk modulus of the fluid at gauge pressure p, Pa   (96)."""
        return self._over_scalars(self.core.bulk_modulus, p=p)

    def density(self, p: ArrayLike) -> Array:
        """Density of the fluid at gauge pressure p, kg/m^3."""
        return self._over_scalars(self.core.density, p=p)

    def passivity(self) -> list[Passivity]:
        """Per cylinder with LuGre friction, whether and up to which velocity the passivity condition holds."""
        return self.core.passivity()

    # --- the whole plant ----------------------------------------------------------------------------------------

    def state_derivative(self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None) -> Array:
        """d(state)/dt (..., n_states); names in :attr:`state_names`."""
        return self._over(self.core.state_derivative, *self._plant(state, spool_command), payload=payload)

    def reference_state_derivative(
        self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None
    ) -> Array:
        """The same right-hand side from the readable one-function reference model."""
        return self._over(self.core.reference_state_derivative, *self._plant(state, spool_command), payload=payload)

    def jacobian(self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None) -> Array:
        """Exact d(state_derivative)/d(state), (..., n_states, n_states)."""
        return self._over(self.core.jacobian, *self._plant(state, spool_command), payload=payload)

    def linearise(self, q: ArrayLike | None = None, **options: Unpack[Options]) -> LinearModel:
        """Linear model about a pose or a state; see :func:`hydrocrane.linearise`."""
        from hydrocrane.linear.linearise import linearise

        return linearise(self, q, **options)

    def outputs(self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None) -> dict[str, Array]:
        """Everything derived from the state by name: tip, piston, forces, flows, power; each of shape (...)."""
        table = self._over(self.core.outputs, *self._plant(state, spool_command), payload=payload)
        return {name: table[..., i] for i, (name, _, _) in enumerate(self.core.output_info)}

    def equilibrium(
        self, q: ArrayLike, mode: Literal["hold", "steady"] = "hold", *, payload: float | None = None
    ) -> Array:
        """State at rest in pose q, (..., n_states).

        ``hold`` has the spools centred, friction 0, and p1 A1 - p2 A2 equal to the static force with the lower
        chamber at the machine's back pressure; ``steady`` also opens the spools so that the pressures stay constant.

        If the supply cannot press a piston so far into its end stop, the piston rests on the stop instead: the state
        then has another joint coordinate than `q`, and a ``DoubtfulResult`` says so. Another one says where the supply,
        or a relief valve of a port, does not hold the load. The lower chamber has less than the back pressure where
        that keeps such a valve closed.

        Raises
        ------
        OutOfReachError
            If the pose is outside the joint limits, or nothing can hold the crane in it.
        """
        states, doubts = self.rest(q, mode, payload=payload)
        for text in dict.fromkeys(str(doubt) for doubt in doubts):
            warnings.warn(text, DoubtfulResult, stacklevel=2)
        return states

    def rest(
        self, q: ArrayLike, mode: Literal["hold", "steady"] = "hold", *, payload: float | None = None
    ) -> tuple[Array, tuple[ResultWarning, ...]]:
        """As :meth:`equilibrium`, with warnings returned in place of Python warnings."""
        if mode not in ("hold", "steady"):
            raise unknown("equilibrium mode", mode, ("hold", "steady"))
        lead, (table,) = rows(self._joints(q))
        mass = self.payload(payload)
        with translated(OutOfReachError):
            found = [self.core.equilibrium(np.ascontiguousarray(pose), mode, mass) for pose in table]
        pairs = zip(table, found, strict=True)
        entries = [self.core.doubts_at_rest(np.ascontiguousarray(pose), x, mass) for pose, x in pairs]
        doubts = tuple(ResultWarning(*entry) for of_pose in entries for entry in of_pose)
        return np.array(found, dtype=np.float64).reshape(*lead, len(self.state_names)), doubts

    def measure(
        self,
        recorded: Recorded | xr.Dataset,
        *,
        sensors: str = "data-sheet",
        seed: int = 0,
        faults: Sequence[SensorFault] = (),
        payload: float | None = None,
        earlier: int = 0,
    ) -> xr.Dataset:
        """Sensor readings of a run, at the times at which it was recorded.

        One run can be read with any number of seeds. Transmitters lag behind the pressure, which is linear between
        records; every sensor starts settled.

        Parameters
        ----------
        recorded : Run or xarray.Dataset
            A run of this machine, or its data, with every state.
        sensors : {"data-sheet", "ideal"}
            Sensors as in the machine file with errors drawn by `seed`, or true values.
        faults : sequence of SensorFault
        payload : float, optional
            kg at the tip; that of the run by default.
        earlier : int
            Readings that the sensors took before, at rest: another number keeps their errors and draws
            other noise, as in a second run with the same sensors.

        Returns
        -------
        xarray.Dataset
            Over ``time``: every joint coordinate and chamber pressure and every other signal with a sensor,
            each by the name of the signal, with ``units`` and ``long_name``.
        """
        data = recorded_data(recorded)
        mass = self.payload(data.attrs.get("payload") if payload is None else payload)
        return sensor_readings(self.core, data, mass, sensors=sensors, seed=seed, faults=faults, earlier=earlier)

    def pack_state(self, q: ArrayLike, qd: ArrayLike | None = None, p: ArrayLike | None = None) -> Array:
        """A state (n_states,) from joints q, rates qd and pressures p (n_cyl, 2), Pa; all else zero."""
        q = self._joints(q)
        rate = np.zeros_like(q) if qd is None else self._joints(qd, "qd")
        pressure = np.zeros((len(self.cylinder_names), 2)) if p is None else vectors(p, "p", ("p1", "p2"))
        if q.ndim != 1 or rate.ndim != 1 or pressure.shape != (len(self.cylinder_names), 2):
            raise InputError(
                f"pack_state takes q and qd of shape ({len(self.joint_names)},) and p of shape "
                f"({len(self.cylinder_names)}, 2); got {q.shape}, {rate.shape}, {pressure.shape}"
            )
        values = {f"joint.{j}.q": q[i] for i, j in enumerate(self.joint_names)}
        values |= {f"joint.{j}.qd": rate[i] for i, j in enumerate(self.joint_names)}
        for i, cylinder in enumerate(self.cylinder_names):
            values |= {f"cylinder.{cylinder}.p1": pressure[i, 0], f"cylinder.{cylinder}.p2": pressure[i, 1]}
        return np.array([values.get(name, 0.0) for name in self.state_names])

    # --- helpers ------------------------------------------------------------------------------------------------

    def _joints(self, value: ArrayLike, name: str = "q") -> Array:
        return poses(self, value) if name == "q" else vectors(value, name, self.joint_names)

    def _plant(self, state: ArrayLike, spool_command: ArrayLike) -> tuple[Array, Array]:
        return vectors(state, "state", self.state_names), vectors(spool_command, "spool_command", self.cylinder_names)

    def payload(self, payload: float | None = None) -> float:
        """A mass at the tip in kg, checked; the machine's own if none is given."""
        if payload is None:
            return self.payload_mass
        mass = real_array(payload, "payload")
        if mass.ndim or mass < 0:
            raise InputError(f"payload must be one mass in kg, zero or more; got {payload!r}")
        return float(mass)

    def _over(
        self,
        function: Callable[..., Array],
        *arrays: Array,
        error: type[HydrocraneError] = InputError,
        **options: float | None,
    ) -> Array:
        """Call a core function row by row over the broadcast leading axes."""
        extra = [self.payload(options["payload"])] if "payload" in options else []
        lead, tables = rows(*arrays)
        with translated(error):
            result = np.asarray(function(*tables, *extra))
        return result.reshape(lead + result.shape[1:])[()]

    def _over_scalars(self, function: Callable[..., Array], *before: int, **named: ArrayLike) -> Array:
        lead, columns = scalars(*(real_array(value, name) for name, value in named.items()))
        with translated():
            return np.asarray(function(*before, *columns)).reshape(lead)[()]

    def _per_cylinder(self, function: Callable[..., Array], cylinder: str | None, **named: ArrayLike) -> Array:
        return self._over_scalars(function, self._index_of(cylinder), **named)

    def _index_of(self, cylinder: str | None) -> int:
        if cylinder is not None and cylinder not in self.cylinder_names:
            raise unknown("cylinder", cylinder, self.cylinder_names)
        return 0 if cylinder is None else self.cylinder_names.index(cylinder)
