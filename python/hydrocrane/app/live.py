"""``hydrocrane live`` and ``view``: the cockpit on a machine or scenario, or on a run."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from hydrocrane.app.arguments import RunName, Settings, named_run, number
from hydrocrane.app.console import say
from hydrocrane.errors import InputError, translated

if TYPE_CHECKING:
    from hydrocrane.app.serving.live_server import Server
    from hydrocrane.arrays import Array
    from hydrocrane.machine.machine import Machine
    from hydrocrane.machine.overrides import Override
    from hydrocrane.results.run import Run

# What the page is asked for, as JSON.
Request: TypeAlias = dict[str, object]


def drive_request(target: str, settings: Mapping[str, Override]) -> Request:
    """What the page is asked to open: a machine, or a scenario that it plays until somebody takes over.

    Both are checked here as everywhere on the command line.
    """
    import hydrocrane as hc
    from hydrocrane.app.options import is_scenario

    if not is_scenario(target):
        return machine_request(hc.load_machine(target, dict(settings)))
    plan = hc.load_scenario(target).changed(overrides=dict(settings))
    plan.initial_state(plan.load_machine())
    # The hoses of the machine are tight; those of the scenario burst in the page.
    own = machine_request(plan.changed(bursts=()).load_machine())
    name = f"./{own['machine']}" if "text" in own else None
    files = {own["machine"]: own["text"]} if "text" in own else {}
    return {"scenario": plan.to_toml(machine=name), "scenario-name": Path(target).name, "files": files}


def machine_request(machine: Machine) -> Request:
    """A machine as the page is asked for it: in one file, because the page has no folder to look for others in."""
    from hydrocrane import _core

    path = Path(machine.source)
    request: Request = {"machine": machine.source, "overrides": dict(machine.overrides)}
    if path.suffix == ".toml":
        with translated():
            request |= {"machine": path.name, "text": _core.machine_text(str(path))}
    elif machine.source not in _core.bundled_machines():  # That of a saved run.
        request |= {"machine": "machine.toml", "text": machine.core.file_text}
    return request


def cockpit_server(target: str | None = None, settings: Mapping[str, Override] | None = None, port: int = 0) -> Server:
    """A server for the page, opened on a machine or scenario where one is given; port 0 takes any free one."""
    from hydrocrane.app.serving.live_server import CHOSEN, Server, own_page

    files = own_page()
    if target is not None:
        request = drive_request(target, settings or {})
        files[CHOSEN] = ("application/json", json.dumps(request).encode())
    return Server(files, port)


def live(
    target: Annotated[
        str, typer.Argument(help="Machine or scenario: file or bundled name.", metavar="[MACHINE|SCENARIO]")
    ] = "rottne-f9-lab",
    settings: Settings = [],  # noqa: B006
    port: Annotated[int, number("Port on this computer; 0 takes any free one.", int, least=0, most=65535)] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
    bridge: Annotated[
        str | None,
        typer.Option(help="In place of the page, serve programs: udp://127.0.0.1:5005 or ws://.", metavar="URL"),
    ] = None,
    controller: Annotated[
        str | None, typer.Option(help="With --bridge: serve this controller of the machine in place of the crane.")
    ] = None,
    period: Annotated[str | None, typer.Option(help="With --bridge: between samples of the crane; 1 ms.")] = None,
    watchdog: Annotated[
        str, typer.Option(help="With --bridge: time without a packet after which the inputs go to zero.")
    ] = "100 ms",
    sensors: Annotated[str, typer.Option(help="With --bridge: ideal or data-sheet.")] = "ideal",
    at: Annotated[list[str], typer.Option(help="With --bridge: JOINT=VALUE of the start; else mid-range.")] = [],  # noqa: B006
) -> None:
    """Drive a crane in the browser, with mouse, keyboard or joystick, or from programs; Ctrl-C ends."""
    from hydrocrane.app.options import overrides

    if bridge is not None:
        from hydrocrane.app.serving.bridge import part_of, serve_bridge

        changed = overrides(settings)
        part = part_of(target, changed, controller=controller, period=period, sensors=sensors, at=at)
        serve_bridge(part, bridge, watchdog)
        return
    if controller or period or at or sensors != "ideal":
        raise InputError("--controller, --period, --sensors and --at are for --bridge; the page has its own")
    with cockpit_server(target, overrides(settings), port) as server:
        say(f"the cockpit is at {server.address}  (Ctrl-C ends)")
        serve(server, browser=browser)


def serve(server: Server, *, browser: bool) -> None:
    """Serve until Ctrl-C, with the page opened where `browser` says so."""
    import webbrowser

    if browser:
        webbrowser.open(server.address)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        say("ended")


def recording(run: Run) -> tuple[Request, Array]:
    """What the page is asked to show, and the table (m, columns) of the run: time first, SI.

    Names are those of the page: commands at the valves are ``command.<cylinder>``, ledger entries are summed over all
    cylinders.
    """
    import numpy as np

    data, machine = run.data, run.machine
    missing = [name for name in machine.state_names if name not in data]
    if missing or not data.sizes["time"]:
        lack = f"`{missing[0]}`" if missing else "rows"
        raise InputError(f"this run has no {lack}, so the crane cannot be drawn; simulate it again")
    columns: dict[str, Array] = {"time": data.time.values}
    for name, values in data.items():
        if values.dims == ("time",) and values.dtype.kind == "f":
            shown = _shown(str(name))
            columns[shown] = columns[shown] + values.values if shown in columns else values.values
    begin = data.isel(time=0)
    outcome = run.outcome
    request = machine_request(machine) | {
        "controller": "lever",
        "payload": float(begin["payload"]),
        "joints": {joint: float(begin[f"joint.{joint}.q"]) for joint in run.joint_names},
    }
    about = {
        "title": data.attrs["title"],
        "source": data.attrs["source"],
        "outcome": f"{outcome.kind} at {outcome.time:g} s",
        "columns": list(columns),
        "events": [[event.time, event.text, event.warning] for event in run.events],
    }
    return {**request, "recording": about}, np.column_stack(list(columns.values()))


def _shown(name: str) -> str:
    command = re.fullmatch(r"cylinder\.(.+)\.command", name)
    if command:
        return f"command.{command[1]}"
    return re.sub(r"^ledger\..+\.", "ledger.", name)


def viewer_server(run: Run, port: int = 0) -> Server:
    """A server for the page and the run."""
    from hydrocrane.app.serving.live_server import CHOSEN, RECORDED, Server, own_page

    files = own_page()
    request, table = recording(run)
    files[CHOSEN] = ("application/json", json.dumps(request).encode())
    files[RECORDED] = ("application/octet-stream", table.astype("<f8").tobytes())
    return Server(files, port)


def view(
    run: RunName,
    settings: Settings = [],  # noqa: B006
    port: Annotated[int, number("Port on this computer; 0 takes any free one.", int, least=0, most=65535)] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Look at a run in the browser: moving crane, charts, replay at any speed; Ctrl-C ends."""
    with viewer_server(named_run(run, settings), port) as server:
        say(f"the run is at {server.address}  (Ctrl-C ends)")
        serve(server, browser=browser)
