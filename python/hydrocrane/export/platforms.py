"""The compiled libraries of an installation for exported FMUs, one per platform."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hydrocrane.errors import InputError, check_known

LIBRARIES = Path(__file__).parents[1] / "fmu_library"
# Also the name of the library in an FMU.
IDENTIFIER = "hydrocrane_fmu"


@dataclass(frozen=True)
class Platform:
    """A platform by its name here, and the folders of FMI 2.0 and 3.0 for its library."""

    name: str
    fmi2: str
    fmi3: str
    suffix: str

    @property
    def library(self) -> Path:
        """Path of the library, if the installation has it."""
        return LIBRARIES / self.name / f"{IDENTIFIER}{self.suffix}"

    def folder(self, fmi: int) -> str:
        """Folder for the library inside an FMU."""
        return self.fmi2 if fmi == 2 else self.fmi3


PLATFORMS = {
    platform.name: platform
    for platform in (
        Platform("linux-x86_64", "linux64", "x86_64-linux", ".so"),
        Platform("linux-aarch64", "aarch64-linux", "aarch64-linux", ".so"),
        Platform("windows-x86_64", "win64", "x86_64-windows", ".dll"),
        Platform("darwin-aarch64", "darwin64", "aarch64-darwin", ".dylib"),
    )
}


def installed() -> tuple[str, ...]:
    """Names of the platforms with a library in this installation."""
    return tuple(name for name, platform in PLATFORMS.items() if platform.library.is_file())


def chosen(names: Sequence[str]) -> list[Platform]:
    """The platforms of these names; without names all that are installed.

    Raises
    ------
    InputError
        An unknown name, or a missing library.
    """
    for name in names:
        check_known("platform", name, PLATFORMS)
    there = installed()
    missing = [name for name in names if name not in there]
    if missing or not there:
        what = f"the FMU library for {', '.join(missing)}" if missing else "any FMU library"
        held = f"; it holds {', '.join(there)}" if there else ""
        raise InputError(
            f"this installation of hydrocrane does not have {what}{held}; `make fmu` in a clone of the repository "
            "builds the library for the present computer"
        )
    return [PLATFORMS[name] for name in names or there]
