"""``hydrocrane view``: look at a run in the cockpit's page."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Annotated

import typer

from hydrocrane.app.arguments import RunName, Settings, named_run, number
from hydrocrane.app.console import say
from hydrocrane.app.live import Request, machine_request, serve
from hydrocrane.errors import InputError

if TYPE_CHECKING:
    from hydrocrane.app.live_server import Server
    from hydrocrane.arrays import Array
    from hydrocrane.results.run import Run


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
    from hydrocrane.app.live_server import CHOSEN, RECORDED, Server, own_page

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
