"""The signals of a rig's log, by their names, the units of logs, which the core reads, and findings about a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from hydrocrane import _core

# Standard atmosphere, Pa: difference of absolute and gauge pressure if no other is stated.
ATMOSPHERE = _core.ATMOSPHERE


class Signal(NamedTuple):
    """Meaning of a name in a log: SI units that it may have; the first one is assumed if none is stated."""

    units: tuple[str, ...]
    long_name: str


SIGNALS = {
    "x": Signal(("m",), "piston position, positive outwards"),
    "v": Signal(("m/s",), "piston velocity, positive outwards"),
    "p1": Signal(("Pa",), "piston-side pressure, gauge"),
    "p2": Signal(("Pa",), "rod-side pressure, gauge"),
    "force": Signal(("N",), "load cell: net force of the rod on its load, positive outwards"),
    "command": Signal(("m", "V", "1"), "spool command, positive extends"),
}
PRESSURES = ("p1", "p2")


def known_unit(text: str) -> bool:
    """Whether a log or a mapping may state this unit, ``"psig"``, ``"in/s"``, ``"40 bar"``."""
    try:
        _core.log_unit(text)
    except ValueError:
        return False
    return True


@dataclass(frozen=True)
class Flag:
    """One finding about a log.

    Attributes
    ----------
    kind : str
        Stable short name, for example ``gap``; all of them in ``docs/reference/log-files.md``.
    signal : str
        The signal; empty if the finding concerns the whole log.
    start, end : float
        Begin and end, s.
    message : str
        The finding and its cure.
    fatal : bool
        Whether nothing can be computed from the log before this is cured.
    """

    kind: str
    signal: str
    start: float
    end: float
    message: str
    fatal: bool = False

    def __str__(self) -> str:
        return f"[{self.kind}] {self.message}"
