"""Controllers for programs in C: parameters as C, a header, an example, and the compiled library where there is one."""

from __future__ import annotations

from importlib.metadata import version
from os import PathLike
from pathlib import Path

from hydrocrane import _core
from hydrocrane.control.named import NamedController
from hydrocrane.errors import translated
from hydrocrane.export.present_platform import present
from hydrocrane.files.whole_file import written_whole
from hydrocrane.machine.machine import Machine, MachineLike, as_machine

# Written as they stand.
_FILES = Path(__file__).parent / "embedded"
LIBRARIES = Path(__file__).parents[1] / "controller_library"
# Bytes of a number, and of a line of the parameters.
_WORD = 8


def library_name(platform: str) -> str:
    """Name of the static library on a platform: Microsoft's compilers have one of their own."""
    return "hydrocrane_controller.lib" if platform.startswith("windows") else "libhydrocrane_controller.a"


def installed_library() -> Path | None:
    """The static library for the present computer, if the installation has it."""
    library = LIBRARIES / present() / library_name(present())
    return library if library.is_file() else None


def export_controller(
    machine: MachineLike,
    folder: str | PathLike[str],
    *,
    controller: str = "tip",
    monitor: bool | None = None,
    delay: float = 0.0,
) -> Path:
    """Write a controller of a machine for a program in C, with the bits of :class:`~hydrocrane.NamedController`.

    The folder gets the parameters (``hydrocrane_parameters.c`` and ``.h``), the header ``hydrocrane_controller.h``,
    ``example.c``, ``README.md`` with the line that compiles them, and the static library for the present computer where
    the installation has it (for Microsoft's compilers on Windows). The library needs neither a heap nor an operating
    system.

    Parameters
    ----------
    machine : Machine, str or path
        Controller model, with its gains and its period (``control.period``), in SI units.
    folder : path
        Folder to write into; it is made if it does not exist. Files of the same names are replaced.
    controller : {"tip", "heinze-pid", "lever"}
    monitor : bool, optional
        Whether readings are checked, and the spools centred if they are not plausible; default is as in
        :class:`~hydrocrane.NamedController`: not for ``lever``, which reads no sensors.
    delay : float
        Time from a sample until the command leaves the target, s, which the monitor assumes.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    InputError
        An unknown controller, an invalid delay, and keep-out regions that the library has no room for.
    MachineFileError
        An invalid machine.
    ResultFileError
        A folder that cannot be written to.

    Examples
    --------
    >>> import hydrocrane as hc
    >>> folder = hc.export_controller("rottne-f9-lab", "controller")
    >>> (folder / "example.c").is_file()
    True
    """
    crane, place = as_machine(machine), Path(folder)
    named = NamedController(controller, crane, monitor=monitor, delay=delay)
    with translated():
        block, memory = _core.controller_parameters(crane.core, controller, named.monitored, named.delay)
    library = installed_library()
    texts = {name: (_FILES / name).read_text(encoding="utf-8") for name in ("hydrocrane_controller.h", "example.c")}
    texts["hydrocrane_parameters.h"] = _header(crane, named, len(block), memory)
    texts["hydrocrane_parameters.c"] = _source(block)
    texts["README.md"] = _readme(crane, named, memory, library is not None)
    for name, text in texts.items():
        with written_whole(place / name) as beside:
            beside.write_text(text, encoding="utf-8")
    if library is not None:
        with written_whole(place / library.name) as beside:
            beside.write_bytes(library.read_bytes())
    return place


def _header(machine: Machine, controller: NamedController, length: int, memory: int) -> str:
    joints = len(machine.joint_names)
    levers = controller.name == "lever"
    return f"""\
/* {controller.name} of {_comment(machine.name)}, exported by hydrocrane {version("hydrocrane")},
 * {"with" if controller.monitored else "without"} a monitor of the sensors.
 *
 * Joints: {_comment(", ".join(machine.joint_names))}. Cylinders: {_comment(", ".join(machine.cylinder_names))}. */
#ifndef HYDROCRANE_PARAMETERS_H
#define HYDROCRANE_PARAMETERS_H

#include <stdint.h>

/* Number of joints and of cylinders; axes and mode of the stick. */
#define HYDROCRANE_JOINTS {joints}
#define HYDROCRANE_AXES {joints if levers else 2}
#define HYDROCRANE_MODE {"HYDROCRANE_LEVERS" if levers else "HYDROCRANE_TIP"}
/* Bytes of memory that the controller needs. */
#define HYDROCRANE_MEMORY {memory}
/* Time between two samples, s. */
#define HYDROCRANE_PERIOD {controller.period!r}

extern const uint8_t hydrocrane_parameters[{length}];

#endif
"""


def _comment(text: str) -> str:
    """A text that neither ends a comment of C nor begins one."""
    return text.replace("*/", "* /").replace("/*", "/ *")


def _source(block: bytes) -> str:
    words = (block[i : i + _WORD] for i in range(0, len(block), _WORD))
    lines = "".join(f"    {', '.join(f'0x{byte:02x}' for byte in word)},\n" for word in words)
    return (
        '#include "hydrocrane_parameters.h"\n\n'
        f"/* Written by hydrocrane; the last number is a checksum. */\n"
        f"const uint8_t hydrocrane_parameters[{len(block)}] = {{\n{lines}}};\n"
    )


def _readme(machine: Machine, controller: NamedController, memory: int, library: bool) -> str:
    joints = len(machine.joint_names)
    name = library_name(present())
    compiling = (
        f"cl /O2 example.c hydrocrane_parameters.c {name}"
        if name.endswith(".lib")
        else "cc -O2 example.c hydrocrane_parameters.c -L. -lhydrocrane_controller -o example"
    )
    there = (
        f"`{name}` is for the computer that wrote this folder."
        if library
        else f"This installation had no `{name}`: `make controller` in a clone of hydrocrane builds it."
    )
    sensors = (
        "A monitor checks the readings. A sensor that fails for a moment is left out; one that fails for longer stops "
        "the crane.\n`hydrocrane_suspects` says which sensors are suspect. A reading that is missing is NaN."
        if controller.monitored
        else "The controller has no monitor of the sensors. Check readings before you give them to it."
    )
    return f"""\
# {controller.name} of {machine.name} in C

{there} This compiles the example:

    {compiling}

For a target without an operating system, build the library in a clone of hydrocrane {version("hydrocrane")},
for example for a Cortex-M4F or M7F:

    rustup target add thumbv7em-none-eabihf
    cargo build --release --manifest-path crates/embedded/Cargo.toml --no-default-features --features joints-{joints} \\
        --target thumbv7em-none-eabihf

It lies in `crates/embedded/target/thumbv7em-none-eabihf/release`. Your program gives {memory} bytes of memory and
the function `hydrocrane_stop`. It calls `hydrocrane_create` once, `hydrocrane_reset` with a first sample, then
`hydrocrane_step` once per `HYDROCRANE_PERIOD`. Every status but `HYDROCRANE_OK` comes with commands of zero: centre
the spools.

{sensors}
"""
