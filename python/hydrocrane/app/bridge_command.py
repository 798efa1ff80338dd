"""What ``hydrocrane live --bridge`` serves, as its options say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import hydrocrane as hc
from hydrocrane.app.bridge import Bridge
from hydrocrane.app.bridge_parts import Control, Driven, Part, Plant
from hydrocrane.app.bridge_transport import Transport, Udp, address_of, is_local
from hydrocrane.app.console import say, warn
from hydrocrane.app.options import is_scenario, pose
from hydrocrane.errors import InputError
from hydrocrane.scenario.against_time import OPERATED, against_time
from hydrocrane.units import converted

if TYPE_CHECKING:
    from hydrocrane.machine.overrides import Override

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
    from hydrocrane.app.bridge_websocket import WebSocket

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
