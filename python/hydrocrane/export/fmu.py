"""Machines and controllers as FMUs: XML and a compiled library in a zip file; no compiler is needed."""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Sequence
from importlib.metadata import version
from os import PathLike
from pathlib import Path

from hydrocrane import _core
from hydrocrane.arrays import positive_number
from hydrocrane.control.controllers import NAMES
from hydrocrane.errors import InputError, check_known, translated
from hydrocrane.export.description import Description, Variable
from hydrocrane.export.model_description import model_description
from hydrocrane.export.platforms import IDENTIFIER, Platform, chosen
from hydrocrane.files.whole_file import written_whole
from hydrocrane.machine.machine import Machine, MachineLike, as_machine
from hydrocrane.machine.sensors import SENSORS
from hydrocrane.scenario.against_time import against_time
from hydrocrane.scenario.scenario import Scenario, scenario_entry

# Tables and keys of the machine file whose numbers become parameters of a plant.
PARAMETERS = ("supply", "pump", "mains", "tank-line", "friction")
# Suggested size of a step of a plant, s.
STEP = 1e-3
# Fixed time stamp, so that the same export has the same bytes.
_DATE = (1980, 1, 1, 0, 0, 0)


def export_fmu(
    source: MachineLike | Scenario,
    path: str | PathLike[str],
    *,
    fmi: int = 2,
    controller: str | None = None,
    monitor: bool | None = None,
    sensors: str = "ideal",
    parameters: Sequence[str] | None = None,
    platforms: Sequence[str] = (),
    step: float = STEP,
) -> Path:
    """Write a machine, or a controller that knows it, as an FMU. Returns the path of the file.

    A plant takes spool commands, ``cylinder.lift.command`` in m, and gives joints, pressures, tip and what the sensors
    read, under the names of ``run.data``. It can be stepped by the tool (co-simulation, with the bits of
    :class:`~hydrocrane.Simulator`) or integrated by it (model exchange). A controller takes what sensors read and
    sticks, and gives spool commands; it is for co-simulation.

    Parameters
    ----------
    source : Machine, str, path or Scenario
        A scenario gives the machine with its overrides and payload, the start, the solver and the seed; what drives
        the crane in it is left to the tool. A machine starts at rest in the middle of its joints' ranges.
    path : path
        File to write, ending in ``.fmu``.
    fmi : {2, 3}
        Version of the standard. FMI 2.0 is what most tools take.
    controller : {"tip", "heinze-pid", "lever"}, optional
        Export this controller instead of the machine.
    monitor : bool, optional
        Whether the controller's readings are watched, as in :class:`~hydrocrane.NamedController`.
    sensors : {"ideal", "data-sheet"}
        What ``measured.…`` of a plant tells. Data-sheet sensors are sampled at every step, so that such an FMU is for
        co-simulation only.
    parameters : sequence of str, optional
        Keys or tables of the machine file whose numbers become parameters; default is supply and friction. The payload
        is always one, and so are the gains of an exported ``tip``.
    platforms : sequence of str
        Platforms to put in; default is all that the installation holds.
    step : float
        Step that the file suggests for a plant, s; a controller suggests its period.

    Raises
    ------
    InputError
        An unknown name, a scenario that an FMU cannot state, and a library that the installation does not hold.
    MachineFileError
        A machine that is none.

    Examples
    --------
    >>> import hydrocrane as hc
    >>> hc.export_fmu("rottne-f9-lab", "crane.fmu").name
    'crane.fmu'
    """
    file = Path(path)
    if file.suffix.lower() != ".fmu":
        raise InputError(f"an FMU is a file that ends in .fmu, unlike `{file.name}`")
    if fmi not in (2, 3):
        raise InputError(f"fmi is 2 or 3, the version of the standard; got {fmi!r}")
    size = positive_number("step", step, "seconds")
    libraries = chosen(platforms)
    machine, scenario = _plan(source)
    if controller is not None:
        check_known("controller", controller, NAMES)
        if sensors != "ideal":
            raise InputError("sensors are those of a plant; a controller takes what they read")
        scenario = None
    elif monitor is not None:
        raise InputError("a monitor is a part of a controller; name one by `controller`")
    check_known("kind of sensors", sensors, SENSORS)
    keys = default_keys(machine) if parameters is None and controller is None else list(parameters or ())
    settings: dict[str, object] = {
        "role": "plant" if controller is None else "controller",
        "controller": controller,
        "monitor": controller not in (None, "lever") if monitor is None else monitor,
        "data-sheet": sensors == "data-sheet",
        "parameters": keys,
        "version": version("hydrocrane"),
    }
    resources = _resources(machine, scenario, settings)
    description = _description(machine, resources, controller, size)
    _pack(file, fmi, description, resources, libraries)
    return file


def _plan(source: MachineLike | Scenario) -> tuple[Machine, Scenario | None]:
    """The machine with all changes of the scenario, and the scenario with only start and solver."""
    if not isinstance(source, Scenario):
        machine = as_machine(source)
        joints = dict(zip(machine.joint_names, machine.home.tolist(), strict=True))
        return machine, Scenario(machine=machine.source, joints=joints, name=machine.name)
    found = against_time(source)
    if found is not None:
        field, what = found
        raise InputError(
            f"an FMU states no {what} against time: the tool sets parameters instead; leave `{field}` out of the "
            "scenario"
        )
    machine = source.load_machine()
    if source.payload is not None:
        machine = machine.changed({"payload.mass": source.payload})
    start = Scenario(
        machine=machine.source,
        joints=source.joints,
        pressures=source.pressures,
        solver=source.solver,
        seed=source.seed,
        duration=source.duration,
        name=source.name,
        title=source.title,
    )
    return machine, start


def default_keys(machine: Machine) -> list[str]:
    """The tables of :data:`PARAMETERS` that the machine has."""
    tables = {key.split(".")[0] for key in machine.keys}
    return [table for table in PARAMETERS if table in tables]


def _resources(machine: Machine, scenario: Scenario | None, settings: dict[str, object]) -> dict[str, str]:
    """The description files of the FMU, by name."""
    with translated():
        files = {"machine.toml": machine.core.to_toml()}
        if scenario is not None:
            head = (scenario.name, scenario.title, "machine.toml", "")
            entry = scenario_entry(scenario, machine.cylinder_names)
            files["scenario.toml"] = _core.scenario_text(machine.core, entry, head)
    digest = hashlib.sha256("\0".join([*files.values(), json.dumps(settings)]).encode()).hexdigest()
    parts = (digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])
    files["fmu.json"] = json.dumps({**settings, "token": "{" + "-".join(parts) + "}"}, indent=2) + "\n"
    return files


def _description(machine: Machine, resources: dict[str, str], controller: str | None, step: float) -> Description:
    settings = resources["fmu.json"]
    with translated():
        described = _core.fmu_variables(resources["machine.toml"], resources.get("scenario.toml"), settings)
    entries, exchanges, period = described
    return Description(
        name=machine.name if controller is None else f"{machine.name}-{controller}",
        title=machine.title if controller is None else f"controller {controller} of {machine.title}",
        token=json.loads(settings)["token"],
        version=version("hydrocrane"),
        identifier=IDENTIFIER,
        variables=tuple(Variable(*entry) for entry in entries),
        exchanges=exchanges,
        period=period,
        step=step if period is None else period,
        stop=5.0,
    )


def _pack(
    file: Path, fmi: int, description: Description, resources: dict[str, str], libraries: Sequence[Platform]
) -> None:
    with written_whole(file) as beside, zipfile.ZipFile(beside, "w") as archive:
        _add(archive, "modelDescription.xml", model_description(description, fmi))
        for name, text in resources.items():
            _add(archive, f"resources/{name}", text.encode())
        for platform in libraries:
            name = f"binaries/{platform.folder(fmi)}/{IDENTIFIER}{platform.suffix}"
            _add(archive, name, platform.library.read_bytes())


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    entry = zipfile.ZipInfo(name, _DATE)
    entry.compress_type = zipfile.ZIP_DEFLATED
    # A library needs the permission to be executed on some systems.
    entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
    # The default level takes four times as long for a tenth less size.
    archive.writestr(entry, content, compresslevel=1)
