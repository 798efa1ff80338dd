"""The packets of the bridge, byte by byte; docs/reference/bridge-packets.md says the same in words."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag

from hydrocrane.errors import InputError

MAGIC = b"HYCB"
VERSION = 1
# Magic, version, kind, sequence, count, time, flags; little-endian, without gaps.
HEADER = struct.Struct("<4sHHIIdQ")
# More values than any crane has, and far below what a datagram holds.
MOST_VALUES = 1024
_TEXT = 60_000


class Kind(IntEnum):
    hello = 1
    values = 2
    reset = 3
    description = 17
    sample = 18
    problem = 19


class PacketFlag(IntFlag):
    # The inputs are neutral, as none came in time.
    watchdog = 1
    # The simulation has ended; a reset starts it anew.
    ended = 2
    # The sample came later than one period after its time.
    late = 4
    # The controller had no command; the spools are in their centres.
    fault = 8


@dataclass(frozen=True)
class Packet:
    """A packet as read.

    Attributes
    ----------
    sequence : int
        Of the sender; answers repeat it.
    time : float
        Of the sender's clock, s.
    values : tuple of float
        In the order of the description.
    text : str
        Of a description or problem.
    """

    kind: Kind
    sequence: int = 0
    time: float = 0.0
    flags: PacketFlag = PacketFlag(0)
    values: tuple[float, ...] = ()
    text: str = ""

    def packed(self) -> bytes:
        """As bytes."""
        if self.kind in (Kind.description, Kind.problem):
            body = self.text.encode()[:_TEXT]
            count = len(body)
        else:
            body = struct.pack(f"<{len(self.values)}d", *self.values)
            count = len(self.values)
        return HEADER.pack(MAGIC, VERSION, self.kind, self.sequence, count, self.time, self.flags) + body


def read(data: bytes, inputs: int) -> Packet:
    """A packet from a program, for a bridge that takes so many inputs.

    Raises
    ------
    InputError
        What is wrong with it.
    """
    if len(data) < HEADER.size:
        raise InputError(f"a packet has a header of {HEADER.size} bytes; this one has {len(data)} bytes in all")
    magic, version, kind, sequence, count, time, _ = HEADER.unpack_from(data)
    if magic != MAGIC:
        raise InputError(f"a packet begins with {MAGIC!r}; this one with {magic!r}")
    if version != VERSION:
        raise InputError(f"this bridge speaks version {VERSION} of the packets; this one has version {version}")
    if kind not in (Kind.hello, Kind.values, Kind.reset):
        wanted = ", ".join(f"{k.value} ({k.name})" for k in (Kind.hello, Kind.values, Kind.reset))
        raise InputError(f"a program sends packets of kind {wanted}; this one has kind {kind}")
    wanted_count = inputs if kind == Kind.values else 0
    if count != wanted_count:
        raise InputError(f"a packet of kind {kind} has {wanted_count} values here; this one says {count}")
    if len(data) != HEADER.size + 8 * count:
        whole = HEADER.size + 8 * count
        raise InputError(f"a packet of {count} values has {whole} bytes; this one has {len(data)}")
    if not math.isfinite(time):
        raise InputError(f"the time of a packet is a number of seconds; this one says {time}")
    return Packet(Kind(kind), sequence, time, values=struct.unpack_from(f"<{count}d", data, HEADER.size))
