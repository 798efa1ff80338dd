"""How packets reach the bridge: addresses, what a transport is, and ``udp://``."""

from __future__ import annotations

import os
import select
import socket
import time
from contextlib import ExitStack
from ipaddress import ip_address
from typing import NamedTuple, Protocol
from urllib.parse import urlsplit

from hydrocrane.errors import InputError

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
