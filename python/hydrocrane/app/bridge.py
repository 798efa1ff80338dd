"""``hydrocrane live --bridge``: a crane or a controller over UDP or WebSocket, in real time.

Packets: docs/reference/bridge-packets.md. How it is used: docs/howto/hardware-in-the-loop.md.
"""

from __future__ import annotations

import json
import math
import threading
import time
from dataclasses import dataclass, field

import hydrocrane as hc
from hydrocrane.app.bridge_packets import MOST_VALUES, Kind, Packet, PacketFlag, read
from hydrocrane.app.bridge_parts import Part, checked
from hydrocrane.app.bridge_transport import Peer, Transport
from hydrocrane.errors import HydrocraneError, InputError

# Longest time without a look at whether to stop, s.
_LOOK = 0.1
# Silence after which a program gets no more samples, and another one may take the bridge over, s.
_SILENCE = 1.0
# A controller's samples may be so many periods apart before it is told.
_UNEVEN = 1.5


@dataclass
class BridgeRecord:
    """What a bridge has done.

    Attributes
    ----------
    samples, late : int
        Steps, and how many of them came later than a period after their time.
    worst : float
        Longest time by which a sample was late, s.
    problems : int
        Packets that were refused.
    """

    samples: int = 0
    late: int = 0
    worst: float = 0.0
    problems: int = 0


@dataclass
class _Client:
    peer: Peer | None = None
    heard: float = -math.inf
    # Of its packets with values.
    time: float = -math.inf
    sequence: int = 0
    values: tuple[float, ...] | None = None
    told: set[str] = field(default_factory=set)


class Bridge:
    """Serves a part to one program at a time.

    Parameters
    ----------
    part : Part
    transport : Transport
        Open; the bridge closes it.
    watchdog : float
        Time without values after which the inputs go to zero, s.

    Raises
    ------
    InputError
        A watchdog that is no time.
    """

    def __init__(self, part: Part, transport: Transport, *, watchdog: float = 0.1) -> None:
        if not (math.isfinite(watchdog) and watchdog > 0):
            raise InputError(f"the watchdog is a time greater than zero, in seconds; got {watchdog!r}")
        assert max(len(part.inputs), len(part.outputs)) <= MOST_VALUES
        self.part, self.watchdog, self.record = part, watchdog, BridgeRecord()
        self._client, self._ended = _Client(), ""
        self._transport = transport

    @property
    def address(self) -> str:
        """Where programs reach it."""
        return str(self._transport.address)

    def close(self) -> None:
        self._transport.close()

    def serve(self, stop: threading.Event | None = None) -> None:
        """Serve until `stop` is set, or for ever."""
        stop = stop or threading.Event()
        if not self.part.by_clock:
            while not stop.is_set():
                self._take_packets(time.monotonic() + _LOOK)
            return
        due = time.monotonic()
        while not stop.is_set():
            due += self.part.period
            self._take_packets(due)
            late = time.monotonic() - due
            if late > self.part.period:
                # Time that is lost is not made up for: the crane would jump.
                due += late
                self.record.late += 1
                self.record.worst = max(self.record.worst, late)
            self._go_on(PacketFlag.late if late > self.part.period else PacketFlag(0))

    def _take_packets(self, until: float) -> None:
        """Take in what comes until a time of the clock, and what is there then."""
        while True:
            wait = until - time.monotonic()
            came = self._transport.receive(min(max(wait, 0.0), _LOOK))
            if came is not None:
                self._take(*came)
            if wait <= (0.0 if came is not None else _LOOK):
                return

    def _take(self, data: bytes, peer: Peer) -> None:
        now, client = time.monotonic(), self._client
        if client.peer not in (None, peer) and now - client.heard < _SILENCE:
            self._refuse(peer, 0, "another program uses the bridge; it is free after a second of silence")
            return
        try:
            packet = read(data, len(self.part.inputs))
            self._check(packet, peer)
        except InputError as error:
            self._refuse(peer, 0, str(error))
            return
        if client.peer != peer:
            client = self._client = _Client(peer)
        client.heard = now
        if packet.kind is Kind.hello:
            self._send(Packet(Kind.description, packet.sequence, self._time(), text=self._description()))
        elif packet.kind is Kind.reset:
            self._reset(packet)
        else:
            client.sequence, client.time, client.values = packet.sequence, packet.time, packet.values
            if not self.part.by_clock:
                self._answer(packet)

    def _check(self, packet: Packet, peer: Peer) -> None:
        if packet.kind is not Kind.values:
            return
        checked(self.part, packet.values)
        if peer == self._client.peer and packet.time <= self._client.time:
            raise InputError(
                f"the time of packets must increase; {packet.time} s came after {self._client.time} s, so this one is "
                "ignored: send a reset to restart"
            )

    def _reset(self, packet: Packet) -> None:
        self.part.reset()
        self._ended = ""
        self._client.time, self._client.values = -math.inf, None
        self._client.sequence = packet.sequence
        self._send(Packet(Kind.sample, packet.sequence, self._time(), values=tuple(self.part.now())))

    def _go_on(self, flags: PacketFlag) -> None:
        """A step of a part that goes by the clock."""
        client = self._client
        fresh = client.values is not None and time.monotonic() - client.heard < self.watchdog
        values = client.values if fresh and client.values is not None else (0.0,) * len(self.part.inputs)
        if not fresh:
            flags |= PacketFlag.watchdog
        self._step(self.part.time, values, flags)

    def _answer(self, packet: Packet) -> None:
        """A step of a controller, for the packet that has its measurements."""
        step, period = packet.time - self.part.time, self.part.period
        if math.isfinite(step) and not period / _UNEVEN < step < period * _UNEVEN:
            self._tell(f"samples are {step:.4g} s apart; the controller assumes {period:.4g} s", "uneven")
        self._step(packet.time, packet.values, PacketFlag(0))

    def _step(self, now: float, values: tuple[float, ...], flags: PacketFlag) -> None:
        if not self._ended:
            try:
                self.part.step(now, values)
                self.record.samples += 1
            except HydrocraneError as error:
                self._ended = str(error)
        if self._ended:
            flags |= PacketFlag.ended
            self._tell(f"{self._ended}; send a reset to restart", self._ended)
        if self.part.fault is not None:
            flags |= PacketFlag.fault
            self._tell(self.part.fault, self.part.fault)
        # A single packet, perhaps with another's address, must not start a stream without an end.
        if time.monotonic() - self._client.heard < max(_SILENCE, self.watchdog):
            self._send(Packet(Kind.sample, self._client.sequence, self._time(), flags, tuple(self.part.now())))

    def _time(self) -> float:
        return self.part.time if math.isfinite(self.part.time) else 0.0

    def _tell(self, text: str, what: str) -> None:
        """Tell the program something, once."""
        if what not in self._client.told:
            self._client.told.add(what)
            self._send(Packet(Kind.problem, self._client.sequence, self._time(), text=text))

    def _refuse(self, peer: Peer, sequence: int, why: str) -> None:
        self.record.problems += 1
        self._send(Packet(Kind.problem, sequence, self._time(), text=why), peer)

    def _send(self, packet: Packet, peer: Peer | None = None) -> None:
        peer = peer or self._client.peer
        if peer is not None:
            self._transport.send(packet.packed(), peer)

    def _description(self) -> str:
        part = self.part
        inputs = [
            {"name": s.name, "unit": s.unit} | ({"low": s.low, "high": s.high} if math.isfinite(s.low) else {})
            for s in part.inputs
        ]
        outputs = [{"name": s.name, "unit": s.unit} for s in part.outputs]
        told = {
            "program": f"hydrocrane {hc.__version__}",
            "machine": part.machine.name,
            "role": part.role,
            "period": part.period,
            "watchdog": self.watchdog if part.by_clock else None,
            "inputs": inputs,
            "outputs": outputs,
        }
        return json.dumps(told)
