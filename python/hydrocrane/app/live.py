"""``hydrocrane live``: serve the cockpit page on this computer alone, with the machine to be driven.

The page simulates in the browser; the server only hands out files. It knows them by name from the start, so that no
request reaches any other.
"""

from __future__ import annotations

import json
import mimetypes
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hydrocrane.app.console import say
from hydrocrane.errors import InputError

if TYPE_CHECKING:
    from hydrocrane.machine import Machine
    from hydrocrane.scenario import Scenario

PAGE = Path(__file__).with_name("cockpit_page")
HOST = "127.0.0.1"
POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
# What a computer's own list may lack or have otherwise.
TYPES = {".js": "text/javascript", ".wasm": "application/wasm", ".css": "text/css", ".html": "text/html; charset=utf-8"}
CHOSEN = "/chosen.json"

Files = Mapping[str, tuple[str, bytes]]


def page_files(folder: Path = PAGE) -> dict[str, tuple[str, bytes]]:
    """Address to (type, content) of every file of the built page."""
    if not (folder / "index.html").is_file():
        raise InputError(
            "the cockpit page is not built: run `make cockpit` in the project's folder, which needs Node.js 20 or newer, "
            "or install a wheel, which carries it"
        )
    files = {}
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        kind = TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream"
        files["/" + path.relative_to(folder).as_posix()] = (kind, path.read_bytes())
    return {"/": files["/index.html"], **files}


def drive_request(target: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """What the page is asked to open: a machine or a scenario, checked here as everywhere on the command line."""
    import hydrocrane as hc
    from hydrocrane.app.options import is_scenario

    if not is_scenario(target):
        return _machine_request(hc.load_machine(target, dict(settings)))
    plan = hc.load_scenario(target).changed(overrides=dict(settings))
    crane = plan.load_machine()
    plan.initial_state(crane)
    return {**_machine_request(crane), **_scenario_request(plan)}


def _machine_request(crane: Machine) -> dict[str, Any]:
    path = Path(crane.source)
    request: dict[str, Any] = {"machine": crane.source, "overrides": dict(crane.overrides)}
    if path.suffix == ".toml":
        request |= {"machine": path.name, "text": path.read_text(encoding="utf-8")}
    return request


def _scenario_request(plan: Scenario) -> dict[str, Any]:
    """Start, load, controller and sensors; its sticks and spool commands are left to whoever drives."""
    request: dict[str, Any] = {"joints": dict(plan.joints), "seed": plan.seed}
    if plan.payload is not None:
        request["payload"] = plan.payload
    if isinstance(plan.driver, str):
        request |= {"controller": plan.driver, "delay": plan.delay, "real-sensors": plan.sensors == "data-sheet"}
    if plan.joystick is not None:
        request |= {"dead-zone": plan.joystick.dead_zone, "ramp": plan.joystick.ramp}
        if plan.joystick.full_speed is not None:
            request["full-speed"] = plan.joystick.full_speed
    return request


class Handler(BaseHTTPRequestHandler):
    """Answers GET and HEAD for the files it knows."""

    server: Server
    server_version = "hydrocrane"
    sys_version = ""

    def do_GET(self) -> None:
        self._answer(with_content=True)

    def do_HEAD(self) -> None:
        self._answer(with_content=False)

    def _answer(self, *, with_content: bool) -> None:
        # Another host's page whose name leads here must not read what is served.
        if self.headers.get("Host") not in self.server.hosts:
            return self.send_error(HTTPStatus.FORBIDDEN)
        found = self.server.files.get(self.path.partition("?")[0])
        if found is None:
            return self.send_error(HTTPStatus.NOT_FOUND)
        kind, content = found
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        if with_content:
            self.wfile.write(content)
        return None

    def end_headers(self) -> None:
        for name, value in HEADERS.items():
            self.send_header(name, value)
        super().end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """The terminal stays quiet."""


class Server(ThreadingHTTPServer):
    """A server on the loopback address."""

    daemon_threads = True

    def __init__(self, files: Files, port: int = 0) -> None:
        try:
            super().__init__((HOST, port), Handler)
        except OSError as error:
            raise InputError(f"port {port} cannot be used ({error.strerror}); choose another with --port") from error
        self.files = files
        self.hosts = {f"{name}:{self.server_port}" for name in (HOST, "localhost")}

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self.server_port}/" + ("?chosen" if CHOSEN in self.files else "")


def cockpit_server(target: str | None = None, settings: Mapping[str, Any] | None = None, port: int = 0) -> Server:
    """A server for the page, opened on a machine or scenario where one is given; port 0 takes any free one."""
    files = page_files()
    if target is not None:
        request = drive_request(target, settings or {})
        files[CHOSEN] = ("application/json", json.dumps(request).encode())
    return Server(files, port)


def live(
    target: Annotated[
        str, typer.Argument(help="Machine or scenario: file or bundled name.", metavar="[MACHINE|SCENARIO]")
    ] = "rottne-f9-lab",
    settings: Annotated[
        list[str], typer.Option("--set", help='Override a machine key: KEY=VALUE, e.g. supply.pressure="100 bar".')
    ] = [],  # noqa: B006
    port: Annotated[int, typer.Option(help="Port on this computer; 0 takes any free one.", min=0, max=65535)] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Drive a crane in the browser, with mouse, keyboard or joystick; Ctrl-C ends."""
    import webbrowser

    from hydrocrane.app.options import overrides

    with cockpit_server(target, overrides(settings), port) as server:
        say(f"the cockpit is at {server.address}  (Ctrl-C ends)")
        if browser:
            webbrowser.open(server.address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            say("ended")
