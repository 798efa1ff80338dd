"""``hydrocrane live --bridge``: a crane or a controller over UDP or WebSocket, in real time.

Packets: docs/reference/bridge-packets.md. How it is used: docs/howto/hardware-in-the-loop.md.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np

import hydrocrane as hc
from hydrocrane.app.console import say, warn
from hydrocrane.app.options import is_scenario, pose
from hydrocrane.app.serving.bridge_transport import (
    MOST_VALUES,
    Kind,
    Packet,
    PacketFlag,
    Peer,
    Transport,
    Udp,
    WebSocket,
    address_of,
    is_local,
    read,
)
from hydrocrane.arrays import Array
from hydrocrane.control.controllers import tip_read
from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.scenario.against_time import OPERATED, against_time
from hydrocrane.units import converted

if TYPE_CHECKING:
    from hydrocrane.machine.overrides import Override


@dataclass(frozen=True)
class BridgeSignal:
    """A value of the packets; `low` and `high` bound what a program may send."""

    name: str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    # NaN says that there is no reading.
    may_miss: bool = False


class Part(Protocol):
    """Something with inputs and outputs that goes on by a period at each step."""

    role: str
    machine: hc.Machine
    inputs: tuple[BridgeSignal, ...]
    outputs: tuple[BridgeSignal, ...]
    period: float
    # Whether it goes on with the clock of this computer, or with each packet.
    by_clock: bool

    @property
    def time(self) -> float:
        """Of the last step, s; minus infinity before a controller's first."""

    def reset(self) -> None:
        """Start anew."""

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        """Outputs after a period with these inputs; an error where it cannot go on."""

    def now(self) -> list[float]:
        """Outputs as they are."""

    @property
    def fault(self) -> str | None:
        """Why the last step gave no command."""


def _readings(machine: hc.Machine, signals: Sequence[str]) -> list[BridgeSignal]:
    units = dict(zip(machine.state_names, machine.state_units, strict=True))
    return [BridgeSignal(f"measured.{name}", units.get(name, "N")) for name in signals]


def _seen(machine: hc.Machine, obs: hc.Observation) -> list[BridgeSignal]:
    """What a crane tells."""
    units = dict(zip(machine.state_names, machine.state_units, strict=True))
    joints = [f"joint.{joint}.{kind}" for kind in ("q", "qd") for joint in machine.joint_names]
    pressures = [f"cylinder.{cylinder}.p{side}" for cylinder in machine.cylinder_names for side in (1, 2)]
    states = [BridgeSignal(name, units[name]) for name in joints + pressures]
    return [
        *states,
        *(BridgeSignal(f"tip.{axis}", "m") for axis in machine.tip_axes),
        *_readings(machine, list(obs.measured)),
    ]


def _values(obs: hc.Observation) -> list[float]:
    return [*obs.q.tolist(), *obs.qd.tolist(), *obs.p.ravel().tolist(), *obs.tip.tolist(), *obs.measured.values()]


def _commands(machine: hc.Machine) -> tuple[BridgeSignal, ...]:
    strokes = zip(machine.cylinder_names, np.abs(machine.spool_strokes).tolist(), strict=True)
    return tuple(BridgeSignal(f"cylinder.{name}.command", "m", -stroke, stroke) for name, stroke in strokes)


class Plant:
    """A crane under spool commands."""

    role, by_clock, fault = "plant", True, None

    def __init__(
        self,
        machine: hc.Machine,
        start: Array,
        period: float,
        *,
        sensors: str,
        payload: float | None = None,
        seed: int = 0,
        solver: hc.Solver | None = None,
    ) -> None:
        solver = solver or hc.Solver()
        self.machine, self.period, self._start = machine, period, start
        self._simulator = hc.Simulator(
            machine,
            period,
            payload=payload,
            sensors=sensors,
            seed=seed,
            method=solver.method,
            rtol=solver.rtol,
            step=solver.step,
        )
        self.reset()
        self.inputs, self.outputs = _commands(machine), tuple(_seen(machine, self._obs))

    @property
    def time(self) -> float:
        return self._simulator.time

    def reset(self) -> None:
        self._obs = self._simulator.reset(state=self._start)

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        self._obs = self._simulator.step(values)
        return self.now()

    def now(self) -> list[float]:
        return _values(self._obs)


class Driven:
    """A scenario's crane with its controller, under sticks: hoses burst and sensors fail as the scenario states."""

    role, by_clock, fault = "crane with controller", True, None

    def __init__(self, scenario: hc.Scenario) -> None:
        self._scenario = scenario
        self.reset()
        self.machine, self.period = self._live.machine, self._live.period
        self.inputs = tuple(BridgeSignal(f"stick.{axis}", "1", -1.0, 1.0) for axis in self._live.axes)
        self.outputs = tuple(_seen(self.machine, self._obs))

    @property
    def time(self) -> float:
        return self._live.time

    def reset(self) -> None:
        self._live = hc.LiveSimulator(self._scenario)
        self._obs = self._live.observation

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        self._live.set_stick(**dict(zip(self._live.axes, values, strict=True)))
        self._obs = self._live.step()
        return self.now()

    def now(self) -> list[float]:
        return _values(self._obs)


class Control:
    """A controller that waits for measurements and sticks."""

    role, by_clock = "controller", False

    def __init__(self, name: str, machine: hc.Machine) -> None:
        self.machine = machine
        self._controller = hc.NamedController(name, machine)
        self.period = self._controller.period
        lever = name == "lever"
        self._mode = "lever" if lever else "tip"
        axes = machine.cylinder_names if lever else machine.core.stick_axes
        joints = [f"joint.{joint}.q" for joint in machine.joint_names]
        self._signals = joints + [f"cylinder.{c}.p{side}" for c in machine.cylinder_names for side in (1, 2)]
        readings = [BridgeSignal(s.name, s.unit, may_miss=True) for s in _readings(machine, self._signals)]
        self.inputs = (*readings, *(BridgeSignal(f"stick.{axis}", "1", -1.0, 1.0) for axis in axes))
        self.outputs = _commands(machine)
        self.reset()

    @property
    def fault(self) -> str | None:
        return self._controller.fault

    def reset(self) -> None:
        self.time = -math.inf
        self._command = [0.0] * len(self.outputs)

    def step(self, time: float, values: Sequence[float]) -> list[float]:
        n = len(self.machine.joint_names)
        read = np.array(values[: len(self._signals)])
        q, p = read[:n], read[n:].reshape(-1, 2)
        measured = dict(zip(self._signals, read.tolist(), strict=True))
        obs = hc.Observation(t=time, q=q, qd=np.full(n, np.nan), p=p, tip=tip_read(self.machine, q), measured=measured)
        if self.time == -math.inf:
            self._controller.reset(self.machine, obs)
        self.time = time
        self._command = self._controller.step(obs, hc.Stick(self._mode, np.array(values[len(self._signals) :])))
        return self.now()

    def now(self) -> list[float]:
        return self._command


def checked(part: Part, values: Sequence[float]) -> None:
    """An :class:`InputError` for inputs that are no numbers or out of their range."""
    for signal, value in zip(part.inputs, values, strict=True):
        if math.isnan(value) and signal.may_miss:
            continue
        if not math.isfinite(value) or not signal.low <= value <= signal.high:
            bounds = f" between {signal.low:g} and {signal.high:g}" if math.isfinite(signal.low) else ""
            raise InputError(f"`{signal.name}` is a number{bounds}, unit {signal.unit}; got {value!r}")


# Longest time without a look at whether to stop, s.
_LOOK = 0.1
# Silence after which a program gets no more samples, and another one may take the bridge over, s.
_SILENCE = 1.0
# A controller's samples may be so many periods apart before that is reported.
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
    reported: set[str] = field(default_factory=set)


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
        if what not in self._client.reported:
            self._client.reported.add(what)
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
        described = {
            "program": f"hydrocrane {hc.__version__}",
            "machine": part.machine.name,
            "role": part.role,
            "period": part.period,
            "watchdog": self.watchdog if part.by_clock else None,
            "inputs": inputs,
            "outputs": outputs,
        }
        return json.dumps(described)


# Between samples of a crane under spool commands, s.
PERIOD = 1e-3


def part_of(
    target: str,
    settings: Mapping[str, Override],
    *,
    controller: str | None = None,
    period: str | None = None,
    sensors: str = "ideal",
    at: list[str] | None = None,
) -> Part:
    """A machine or an open-loop scenario as a plant, a scenario with its controller, or a controller alone."""
    scenario = is_scenario(target)
    if controller is not None:
        if scenario or at or period is not None or sensors != "ideal":
            raise InputError(
                "--controller serves a controller that knows a machine: give a machine, without --at, --period and "
                "--sensors; its period is the machine's, --set control.period='5 ms'"
            )
        return Control(controller, hc.load_machine(target, dict(settings)))
    seconds = PERIOD if period is None else converted("--period", period, "s")
    if not scenario:
        machine = hc.load_machine(target, dict(settings))
        start, _ = machine.rest(pose(machine, at or []))
        return Plant(machine, start, seconds, sensors=sensors)
    plan = hc.load_scenario(target).changed(overrides=dict(settings))
    if at:
        raise InputError(f"{target} states its start; --at is for machines")
    if plan.closed_loop:
        _check_plan(target, plan)
        if period is not None or sensors != "ideal":
            raise InputError(f"{target} states period and sensors of its controller; omit --period and --sensors")
        return Driven(plan)
    found = against_time(plan)
    if found is not None:
        field, what = found
        raise InputError(
            f"{target} has {what}, and a crane under another program's spool commands keeps its machine and load; "
            f"leave `{field}` out of the scenario, or give it a controller"
        )
    if plan.solver.atol is not None or plan.solver.max_step < seconds:
        key = "max-step" if plan.solver.atol is None else "atol"
        raise InputError(
            f"{target} states `solver.{key}`, and a crane under another program's spool commands is stepped by method, "
            f"rtol and step alone; leave `{key}` out of the scenario, and state a smaller rtol or a step"
        )
    machine = plan.load_machine()
    start = plan.initial_state(machine)
    return Plant(machine, start, seconds, sensors=sensors, payload=plan.payload, seed=plan.seed, solver=plan.solver)


def _check_plan(target: str, plan: hc.Scenario) -> None:
    found = against_time(plan, OPERATED)
    if found is not None:
        field, what = found
        raise InputError(
            f"{target} has {what}, which end when an operator takes over, and the program at the bridge is the "
            f"operator from the start on; leave `{field}` out of the scenario"
        )


def transport_of(url: str) -> Transport:
    """An open transport of this address.

    Raises
    ------
    InputError
        A wrong address, one that cannot be had, or ``ws://`` without the package that it needs.
    """
    address = address_of(url)
    if address.scheme == "udp":
        return Udp(address)
    return WebSocket(address)


def serve_bridge(part: Part, url: str, watchdog: str) -> None:
    """Serve until Ctrl-C."""
    wanted, silence = address_of(url), converted("--watchdog", watchdog, "s")
    bridge = Bridge(part, transport_of(url), watchdog=silence)
    if not is_local(wanted.host):
        warn(
            f"{bridge.address} answers everyone who reaches this computer; {wanted.scheme}://127.0.0.1 is for programs "
            "on it alone"
        )
    say(
        f"{part.role} {part.machine.name}: {len(part.inputs)} inputs, {len(part.outputs)} outputs, "
        f"a sample each {1e3 * part.period:g} ms at {bridge.address}  (Ctrl-C ends)"
    )
    try:
        bridge.serve()
    except KeyboardInterrupt:
        record = bridge.record
        late = f", {record.late} of them late, by {1e3 * record.worst:.1f} ms at most" if part.by_clock else ""
        say(f"ended after {record.samples} samples{late}; {record.problems} packets refused")
    finally:
        bridge.close()
