"""How packets reach the bridge, and what they hold byte by byte; docs/reference/bridge-packets.md says the same."""

from __future__ import annotations

import asyncio
import logging
import math
import os
import queue
import re
import select
import socket
import struct
import threading
import time
from contextlib import ExitStack
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from ipaddress import ip_address
from typing import TYPE_CHECKING, NamedTuple, Protocol
from urllib.parse import urlsplit

from hydrocrane.errors import InputError

if TYPE_CHECKING:
    from websockets.asyncio.server import Server, ServerConnection

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


# Host and port of a program.
Peer = tuple[str, int]

# Most bytes of a packet.
LARGEST = 65_535


class Address(NamedTuple):
    """Where programs reach a bridge."""

    scheme: str
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}://{host}:{self.port}"


def address_of(url: str) -> Address:
    """Scheme, host and port of ``udp://HOST:PORT`` or ``ws://HOST:PORT``; a port 0 takes any free one."""
    wrong = InputError(
        f"--bridge takes udp://HOST:PORT or ws://HOST:PORT, for example udp://127.0.0.1:5005; got `{url}`"
    )
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError:
        raise wrong from None
    if parts.scheme not in ("udp", "ws") or not parts.hostname or port is None or parts.path or parts.query:
        raise wrong
    return Address(parts.scheme, parts.hostname, port)


def is_local(host: str) -> bool:
    """Whether only programs on this computer reach `host`."""
    try:
        return host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        return False


class Transport(Protocol):
    """Carries packets between the bridge and programs."""

    @property
    def address(self) -> Address:
        """Where programs reach it."""

    def receive(self, wait: float) -> tuple[bytes, Peer] | None:
        """The next packet and who sent it; ``None`` if none came within `wait` seconds."""

    def send(self, data: bytes, peer: Peer) -> None:
        """Send without waiting; what cannot be sent is lost, since the next sample is as good."""

    def close(self) -> None:
        """End."""


def bound(address: Address, kind: socket.SocketKind) -> socket.socket:
    """A socket of this address that never waits.

    Raises
    ------
    InputError
        The address cannot be had.
    """
    with ExitStack() as undo:
        try:
            family, _, _, _, where = socket.getaddrinfo(address.host, address.port, type=kind)[0]
            made = undo.enter_context(socket.socket(family, kind))
            if kind is socket.SOCK_STREAM and os.name == "posix":
                # A bridge can start again on the port of one that has just ended.
                made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            made.bind(where)
        except OSError as error:
            raise InputError(f"the bridge cannot use {address}: {error.strerror or error}") from None
        made.setblocking(False)
        undo.pop_all()
        return made


class Udp:
    """One datagram is one packet."""

    def __init__(self, address: Address) -> None:
        self._socket = bound(address, socket.SOCK_DGRAM)

    @property
    def address(self) -> Address:
        host, port = self._socket.getsockname()[:2]
        return Address("udp", host, port)

    def receive(self, wait: float) -> tuple[bytes, Peer] | None:
        until = time.monotonic() + wait
        while select.select([self._socket], [], [], max(until - time.monotonic(), 0.0))[0]:
            try:
                data, peer = self._socket.recvfrom(LARGEST)
            except OSError:
                # A program that has gone answers what was sent to it with an error.
                continue
            return data, (peer[0], peer[1])
        return None

    def send(self, data: bytes, peer: Peer) -> None:
        try:
            self._socket.sendto(data, peer)
        except OSError:
            # Nobody listens any more, or the network is full.
            return

    def close(self) -> None:
        self._socket.close()


# Connections at a time; only one program uses the bridge, the others are told so.
_CONNECTIONS = 16
# Packets that wait for the bridge, and bytes that wait for a slow program. More are lost, as datagrams are.
_WAITING = 1024
_UNSENT = 256 * 1024
# Time that a program has to agree to the end, s.
_GOODBYE = 0.5

# Any page that is open in a browser could connect to this computer; only pages of this computer may. Other programs
# send no origin.
_ORIGINS = [None, re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")]

# Failed handshakes are the business of who asks for the log.
_LOG = logging.getLogger(__name__)
_LOG.addHandler(logging.NullHandler())


class WebSocket:
    """A server with a thread of its own, so that a slow connection never delays a sample.

    Raises
    ------
    InputError
        The address cannot be had, or the package `websockets` is missing.
    """

    def __init__(self, address: Address) -> None:
        try:
            import websockets.asyncio.server
        except ImportError:
            raise InputError("ws:// needs the package websockets; install hydrocrane[websocket]") from None
        self._websockets = websockets.asyncio.server
        self._socket = bound(address, socket.SOCK_STREAM)
        host, port = self._socket.getsockname()[:2]
        self.address = Address("ws", host, port)
        self._packets: queue.Queue[tuple[bytes, Peer]] = queue.Queue(_WAITING)
        self._connections: dict[Peer, ServerConnection] = {}
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._server = asyncio.run_coroutine_threadsafe(self._opened(), self._loop).result()

    async def _opened(self) -> Server:
        serve = self._websockets.serve
        # Compression would cost more time than packets of some hundred bytes are worth.
        return await serve(
            self._handle,
            sock=self._socket,
            origins=_ORIGINS,
            compression=None,
            max_size=LARGEST,
            close_timeout=_GOODBYE,
            logger=_LOG,
        )

    async def _handle(self, connection: ServerConnection) -> None:
        if len(self._connections) >= _CONNECTIONS:
            await connection.close(1013, f"the bridge has {_CONNECTIONS} connections")
            return
        peer = (connection.remote_address[0], connection.remote_address[1])
        self._connections[peer] = connection
        try:
            async for message in connection:
                data = message.encode() if isinstance(message, str) else bytes(message)
                if not self._packets.full():
                    self._packets.put_nowait((data, peer))
        finally:
            del self._connections[peer]

    def receive(self, wait: float) -> tuple[bytes, Peer] | None:
        try:
            return self._packets.get(timeout=wait) if wait > 0 else self._packets.get_nowait()
        except queue.Empty:
            return None

    def send(self, data: bytes, peer: Peer) -> None:
        self._loop.call_soon_threadsafe(self._push, data, peer)

    def _push(self, data: bytes, peer: Peer) -> None:
        connection = self._connections.get(peer)
        if connection is not None and connection.transport.get_write_buffer_size() < _UNSENT:
            self._websockets.broadcast([connection], data)

    def close(self) -> None:
        async def closed() -> None:
            self._server.close()
            await self._server.wait_closed()

        asyncio.run_coroutine_threadsafe(closed(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
