"""A crane as Python sees it: geometry, mechanics, hydraulics and the full right-hand side.

Units are SI and radians, pressures are gauge. Every method takes single vectors or batches with any leading axes.
A pose or state far outside the joint ranges is refused, as in degrees or millimetres: :mod:`hydrocrane.machine.poses`.
A cylinder force is net of friction and end stop; positive pushes the piston out. A spool command is in metres of
spool stroke; positive extends the piston. Equation numbers are those of Heinze (2007).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Literal, TypeAlias, Unpack, cast

import numpy as np
from numpy.typing import ArrayLike

from hydrocrane import _core
from hydrocrane.arrays import Array, real_array, rows, vectors
from hydrocrane.asked import ask
from hydrocrane.errors import InputError, OutOfReachError, check_known, translated
from hydrocrane.machine.described import described
from hydrocrane.machine.measuring import Recorded, recorded_data, sensor_readings
from hydrocrane.machine.mechanics import Mechanics
from hydrocrane.machine.overrides import Override, Overrides, plain_overrides
from hydrocrane.machine.sensors import SensorFault
from hydrocrane.result_warning import DoubtfulResult, ResultWarning

if TYPE_CHECKING:
    import xarray as xr

    from hydrocrane.state_space.model import LinearModel
    from hydrocrane.state_space.options import Options


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


def machine_of_text(text: str, source: str, overrides: Overrides) -> Machine:
    """As :func:`load_machine`, from the text of a file, which can extend and include only bundled ones.

    Examples
    --------
    >>> from hydrocrane.machine.machine import machine_of_text
    >>> text = hc.load_machine("rottne-f9-lab").to_toml()
    >>> print(machine_of_text(text, "my text", {"supply.pressure": "100 bar"}).supply_pressure)
    10000000.0
    """
    given = plain_overrides(overrides)
    with translated():
        return Machine(_core.machine_of_text(text, source, list(given.items())), source, given)


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


MachineLike: TypeAlias = "Machine | str | PathLike[str]"


class Machine(Mechanics):
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

    def __reduce__(self) -> tuple[Callable[..., Machine], tuple[object, ...]]:
        if self.source in _core.bundled_machines():
            return load_machine, (self.source, self.overrides)
        return machine_of_text, (self.core.file_text, self.source, self.overrides)

    def to_toml(self) -> str:
        """The machine as the text of one file: all that its file extends and includes, and its overrides.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-pump")
        >>> "extends" in crane.to_toml()
        False
        """
        with translated():
            return self.core.to_toml()

    def changed(self, overrides: Overrides) -> Machine:
        """This machine with some values replaced, on top of its own overrides; see :func:`load_machine`.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab").changed({"supply.pressure": "100 bar"})
        >>> print(crane.supply_pressure, crane.overrides)
        10000000.0 {'supply.pressure': '100 bar'}
        """
        if not overrides:
            return self
        given = {**self.overrides, **plain_overrides(overrides)}
        with translated():
            return Machine(self.core.rebuilt(list(given.items())), self.source, given)

    def overrides_at(self, keys: Sequence[str], values: ArrayLike) -> dict[str, Override]:
        """Overrides that give `keys` these `values` (n_keys,), SI; ``[0]`` and ``[1]`` are the two values of a pair.

        Values of a pair that are not named stay as they are.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.overrides_at(["supply.pressure", "friction.extension.coulomb[1]"], [1e7, 400.0]))
        {'supply.pressure': 10000000.0, 'friction.extension.coulomb': [160.0, 400.0]}
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
        """The machine of a core object; this machine itself if it is its own.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> print(crane.made(crane.core) is crane)
        True
        """
        overrides = dict(core.overrides)
        if core.source == self.core.source and overrides == self.overrides:
            return self
        return Machine(core, self.source if core.source == self.core.source else core.source, overrides)

    # --- the whole plant ----------------------------------------------------------------------------------------

    def state_derivative(self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None) -> Array:
        """d(state)/dt (..., n_states); names in :attr:`state_names`.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> state = crane.equilibrium(q)
        >>> print(crane.state_derivative(state, [0.0, 0.0, 0.0]).shape, len(crane.state_names))
        (21,) 21
        """
        return self._over(self.core.state_derivative, *self._plant(state, spool_command), payload=payload)

    def reference_state_derivative(
        self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None
    ) -> Array:
        """The same right-hand side from the readable one-function reference model.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> state = crane.equilibrium(q)
        >>> spools = [0.01, 0.0, 0.0]
        >>> print(np.allclose(crane.state_derivative(state, spools), crane.reference_state_derivative(state, spools)))
        True
        """
        return self._over(self.core.reference_state_derivative, *self._plant(state, spool_command), payload=payload)

    def jacobian(self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None) -> Array:
        """Exact d(state_derivative)/d(state), (..., n_states, n_states).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> state = crane.equilibrium(q)
        >>> print(crane.jacobian(state, [0.0, 0.0, 0.0]).shape)
        (21, 21)
        """
        return self._over(self.core.jacobian, *self._plant(state, spool_command), payload=payload)

    def linearise(self, q: ArrayLike | None = None, **options: Unpack[Options]) -> LinearModel:
        """Linear model about a pose or a state, with the options of :func:`hydrocrane.linearise`.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.linearise(q).A.shape)
        (21, 21)
        """
        return cast("LinearModel", ask("linear", "linearise", self, q, **options))

    def casadi(self, *, parameters: Sequence[str] | None = None, outputs: Sequence[str] | None = None) -> ModuleType:
        """This machine for CasADi: a module with ``casadi.Function`` objects.

        They are ``derivative(x, u, p)``, ``linearise(x, u, p)`` with the derivatives by the states, and
        ``outputs(x, u, p)``. ``STATES``, ``INPUTS``, ``PARAMETERS``, ``VALUES`` and ``OUTPUTS`` name their entries. For
        arguments, and to write it as a file: :func:`hydrocrane.export_model`.

        Raises
        ------
        InputError
            If CasADi is not installed, and as :func:`hydrocrane.export_model`.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.casadi(parameters=["payload.mass"])  # doctest: +SKIP
        >>> model.derivative(state, spool_command, [100.0])  # doctest: +SKIP
        """
        return cast(ModuleType, ask("export", "model-in", self, "casadi", parameters, outputs))

    def jax(self, *, parameters: Sequence[str] | None = None, outputs: Sequence[str] | None = None) -> ModuleType:
        """This machine for JAX: a module with pure functions, for ``jit``, ``vmap`` and ``grad``.

        They are those of :meth:`casadi`; without ``p`` the parameters have the values of the file. JAX is switched to
        double precision.

        Raises
        ------
        InputError
            If JAX is not installed, and as :func:`hydrocrane.export_model`.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> model = crane.jax()  # doctest: +SKIP
        >>> rates = jax.jit(model.derivative)(state, spool_command)  # doctest: +SKIP
        """
        return cast(ModuleType, ask("export", "model-in", self, "jax", parameters, outputs))

    def outputs(self, state: ArrayLike, spool_command: ArrayLike, *, payload: float | None = None) -> dict[str, Array]:
        """Everything derived from the state by name: tip, piston, forces, flows, power; each of shape (...).

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> state = crane.equilibrium(q)
        >>> print(crane.outputs(state, [0.0, 0.0, 0.0])["cylinder.lift.force"].round())
        7916.0
        """
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

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> state = crane.equilibrium(q, payload=100)
        >>> pressures = dict(zip(crane.state_names, state))
        >>> print((1e-5 * pressures["cylinder.lift.p1"]).round(1))
        35.4
        """
        states, doubts = self.rest(q, mode, payload=payload)
        for text in dict.fromkeys(str(doubt) for doubt in doubts):
            warnings.warn(text, DoubtfulResult, stacklevel=2)
        return states

    def rest(
        self, q: ArrayLike, mode: Literal["hold", "steady"] = "hold", *, payload: float | None = None
    ) -> tuple[Array, tuple[ResultWarning, ...]]:
        """As :meth:`equilibrium`, with warnings returned in place of Python warnings.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab", {"supply.pressure": "20 bar"})
        >>> state, doubts = crane.rest(crane.home, payload=200)
        >>> print([doubt.kind for doubt in doubts])
        ['start-not-held']
        """
        check_known("equilibrium mode", mode, ("hold", "steady"))
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

        Examples
        --------
        >>> run = hc.simulate("vertical-lift-open-loop", duration=0.1)
        >>> read = run.machine.measure(run, seed=1)
        >>> print(float(abs(read["joint.boom.q"] - run.data["joint.boom.q"]).max()) < 0.01)
        True
        """
        data = recorded_data(recorded)
        mass = self.payload(data.attrs.get("payload") if payload is None else payload)
        return sensor_readings(self.core, data, mass, sensors=sensors, seed=seed, faults=faults, earlier=earlier)

    def pack_state(self, q: ArrayLike, qd: ArrayLike | None = None, p: ArrayLike | None = None) -> Array:
        """A state (n_states,) from joints q, rates qd and pressures p (n_cyl, 2), Pa; all else zero.

        Examples
        --------
        >>> crane = hc.load_machine("rottne-f9-lab")
        >>> q = np.deg2rad([100.0, 100.0, 0.0])
        >>> print(crane.pack_state(q)[crane.state_names.index("joint.boom.q")].round(4))
        1.7453
        """
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
