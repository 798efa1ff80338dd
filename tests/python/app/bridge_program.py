"""A program that uses the bridge, as tests need one."""

from __future__ import annotations

import json
import socket
import struct
import threading
from contextlib import ExitStack, contextmanager

from websockets.sync.client import connect

from hydrocrane.app.serving.bridge import Bridge, part_of, transport_of
from hydrocrane.app.serving.bridge_transport import HEADER, Kind, Packet, PacketFlag, address_of

HERE = "127.0.0.1"


class Program:
    """A client of the bridge, over what its address says."""

    def __init__(self, address: str) -> None:
        where = address_of(address)
        if where.scheme == "ws":
            used = ExitStack()
            connection = used.enter_context(connect(address, compression=None, close_timeout=0.2))
            self.send, self.close = connection.send, used.close
            self._received = lambda: connection.recv(10.0)
            return
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.settimeout(10.0)
        made.connect((where.host, where.port))
        self.send, self.close = made.send, made.close
        self._received = lambda: made.recv(65_535)

    def values(self, sequence: int, at: float, values) -> None:
        self.send(Packet(Kind.values, sequence, at, values=tuple(values)).packed())

    def next(self, kind: Kind) -> Packet:
        """The next packet of a kind."""
        while True:
            data = self._received()
            magic, version, got, sequence, count, at, flags = HEADER.unpack_from(data)
            assert (magic, version) == (b"HYCB", 1)
            if got == kind:
                body = data[HEADER.size :]
                text = body.decode() if kind in (Kind.description, Kind.problem) else ""
                values = () if text else struct.unpack(f"<{count}d", body)
                return Packet(Kind(got), sequence, at, PacketFlag(flags), values, text)

    def describe(self) -> dict:
        self.send(Packet(Kind.hello).packed())
        return json.loads(self.next(Kind.description).text)


@contextmanager
def bridge_alone(part, scheme, **how):
    """A bridge in a thread of its own."""
    bridge, stop = Bridge(part, transport_of(f"{scheme}://{HERE}:0"), **how), threading.Event()
    thread = threading.Thread(target=bridge.serve, args=(stop,), daemon=True)
    thread.start()
    try:
        yield bridge
    finally:
        stop.set()
        thread.join(10.0)
        bridge.close()
    assert not thread.is_alive()


@contextmanager
def served(part, scheme="udp", **how):
    """A program and the bridge that it uses."""
    with bridge_alone(part, scheme, **how) as bridge:
        program = Program(bridge.address)
        try:
            yield program, bridge
        finally:
            program.close()


def plant(**how):
    return part_of("single-cylinder", {}, **how)
