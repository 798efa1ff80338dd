"""The signals of a rig's log, by their names."""

from __future__ import annotations

from typing import NamedTuple


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
