"""The cockpit without a browser: what its server hands out, and a drive in WebAssembly against the native core."""

from __future__ import annotations

import gzip
import http.client
import json
import shutil
import socket
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from browser import hosted

import hydrocrane as hc
from hydrocrane.app.live import cockpit_server, drive_request
from hydrocrane.app.serving.live_server import (
    CONNECTIONS,
    KEEPER,
    PAGE,
    Handler,
    Server,
    host_names,
    own_page,
    page_files,
)
from hydrocrane.errors import InputError, MachineFileError

ROOT = Path(__file__).resolve().parents[3]
# A chain of four joints.
LONG = ROOT / "tests/data/two-telescopes.toml"


# --- the server -----------------------------------------------------------------------------------------------------


@pytest.fixture
def page(tmp_path):
    """A built page in miniature, with a secret beside it."""
    folder = tmp_path / "page"
    (folder / "assets").mkdir(parents=True)
    (folder / "index.html").write_text("<p>crane</p>", encoding="utf-8")
    (folder / "assets" / "core.wasm").write_bytes(b"\0asm")
    (tmp_path / "secret.txt").write_text("nobody's business", encoding="utf-8")
    return folder


@pytest.fixture
def ask(page):
    """Ask a running server: (status, headers, content)."""
    with hosted({**page_files(page), "/chosen.json": ("application/json", b"{}")}) as server:

        def ask(path, method="GET", host=None, **headers):
            connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
            named = {name.replace("_", "-"): value for name, value in headers.items()}
            connection.request(method, path, headers={"Host": host or f"127.0.0.1:{server.server_port}"} | named)
            answer = connection.getresponse()
            content = answer.read()
            connection.close()
            return answer.status, dict(answer.getheaders()), content

        ask.server = server
        yield ask


def test_the_server_hands_out_the_page_with_strict_headers(ask):
    status, headers, content = ask("/?chosen")
    assert (status, content) == (200, b"<p>crane</p>")
    assert headers["Content-Type"].startswith("text/html") and headers["X-Content-Type-Options"] == "nosniff"
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "unsafe-inline" not in policy and "'unsafe-eval'" not in policy
    status, headers, content = ask("/assets/core.wasm", "HEAD")
    assert (status, headers["Content-Type"], content) == (200, "application/wasm", b"")


def test_the_server_compresses_what_a_browser_takes_compressed(ask):
    ask.server.files = {"/": ("text/html", b"crane " * 500), "/recorded.bin": ("application/octet-stream", b"0" * 500)}
    for coding in ("gzip, deflate, br", "deflate;q=1, gzip;q=0.5"):
        _, headers, content = ask("/", Accept_Encoding=coding)
        assert headers["Content-Encoding"] == "gzip" and gzip.decompress(content) == b"crane " * 500
        assert int(headers["Content-Length"]) == len(content) < 300 and headers["Vary"] == "Accept-Encoding"
    for coding in ("identity", "gzip;q=0", "gzip;q=0.0", "xgzip"):
        _, headers, content = ask("/", Accept_Encoding=coding)
        assert "Content-Encoding" not in headers and content == b"crane " * 500
    assert "Content-Encoding" not in ask("/recorded.bin", Accept_Encoding="gzip")[1]


def test_a_browser_keeps_what_its_name_tells_and_asks_after_the_rest(ask):
    page, asset = ("text/html", b"crane"), ("application/wasm", b"\0asm")
    ask.server.files = {"/": page, "/assets/core-BfT9xa-_.wasm": asset, "/assets/core.wasm": asset}
    assert "immutable" in ask("/assets/core-BfT9xa-_.wasm")[1]["Cache-Control"]
    for path in ("/", "/assets/core.wasm", "/none", "/assets/none-BfT9xa-_.wasm"):
        assert ask(path)[1]["Cache-Control"] == "no-cache", path
    tag = ask("/")[1]["ETag"]
    assert ask("/", If_None_Match=tag)[::2] == (304, b"")
    assert ask("/", If_None_Match=tag, Accept_Encoding="gzip")[0] == 200, "it is another text when compressed"
    ask.server.files = {"/": ("text/html", b"another crane")}
    assert ask("/", If_None_Match=tag)[::2] == (200, b"another crane")


@pytest.mark.parametrize(
    "path",
    ["/../secret.txt", "/%2e%2e/secret.txt", "//secret.txt", "/assets/../../secret.txt", "/assets", "/etc/passwd", "*"],
)
def test_the_server_hands_out_nothing_else(ask, path):
    status, headers, content = ask(path)
    assert status == 404 and b"business" not in content and headers["X-Content-Type-Options"] == "nosniff"


def test_the_server_is_for_this_computer_alone(ask):
    assert ask.server.server_address[0] == "127.0.0.1"
    assert ask("/", host="evil.example")[0] == 403
    assert ask("/", host=f"localhost:{ask.server.server_port}")[0] == 200
    assert ask("/", "POST")[0] == 501


def test_the_port_that_browsers_leave_out_of_addresses_is_answered_too(ask):
    assert host_names(80) == {"127.0.0.1", "localhost", "127.0.0.1:80", "localhost:80"}
    assert host_names(8000) == {"127.0.0.1:8000", "localhost:8000"}
    assert ask("/", host="127.0.0.1")[0] == 403


def half_open(port, count):
    """Connections that begin to ask and say no more."""
    for _ in range(count):
        begun = socket.create_connection(("127.0.0.1", port), timeout=10)
        begun.sendall(b"GET / HTTP/1.1\r\n")
        yield begun


def test_connections_that_say_no_more_are_few_and_in_nobodys_way(ask):
    before = threading.active_count()
    begun = list(half_open(ask.server.server_port, 200))
    assert ask("/")[0] == 200
    assert threading.active_count() - before <= CONNECTIONS + 2
    for connection in begun:
        connection.close()


def test_a_connection_that_says_no_more_is_closed(ask, monkeypatch):
    monkeypatch.setattr(Handler, "timeout", 0.2)
    (connection,) = half_open(ask.server.server_port, 1)
    began = time.monotonic()
    assert connection.recv(100) == b"" and time.monotonic() - began < 5
    connection.close()


def test_the_page_of_a_program_on_this_computer_knows_it_and_is_not_kept(page):
    (page / "index.html").write_text("<html><p>crane</p>", encoding="utf-8")
    (page / "service-worker.js").write_text("", encoding="utf-8")
    assert KEEPER in page_files(page) and b"live" not in page_files(page)["/"][1]
    files = own_page(page)
    assert KEEPER not in files and files["/"][1] == files["/index.html"][1] == b'<html data-served="live"><p>crane</p>'


def test_a_port_in_use_is_one_clear_error(ask):
    with pytest.raises(InputError, match="choose another with --port"):
        Server({}, ask.server.server_port)


def test_a_page_that_is_not_built_says_how_to_build_it(tmp_path):
    with pytest.raises(InputError, match="make cockpit"):
        page_files(tmp_path)


# --- what is driven -------------------------------------------------------------------------------------------------


def test_a_machine_file_goes_to_the_page_as_text(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('extends = "rottne-f9-lab"\n[supply]\nclass = "setting"\npressure = "120 bar"\n', encoding="utf-8")
    request = drive_request(str(path), {"payload.mass": 20.0})
    assert request == {"machine": "mine.toml", "text": path.read_text(), "overrides": {"payload.mass": 20.0}}
    assert drive_request("hiab-xs031", {}) == {"machine": "hiab-xs031", "overrides": {}}


def test_a_machine_in_several_files_goes_to_the_page_as_one_text(tmp_path):
    base = 'extends = "rottne-f9-lab"\n[supply]\nclass = "setting"\npressure = "60 bar"\n'
    (tmp_path / "base.toml").write_text(base, encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text('extends = "base.toml"\n', encoding="utf-8")
    request = drive_request(str(path), {})
    alone = tmp_path / "alone.toml"
    alone.write_text(request["text"], encoding="utf-8")
    assert request["machine"] == "mine.toml" and "extends" not in request["text"]
    assert hc.load_machine(alone).supply_pressure == 60e5


# Everything that a scenario states beside the solver: the page has its own steps.
EVERYTHING = hc.Scenario(
    joints={"boom": 1.745, "jib": 1.745, "extension": 0.2},
    pressures={"lift": (60e5, 5e5), "jib": (20e5, 20e5), "extension": (15e5, 20e5)},
    payload=20.0,
    payload_changes={0.3: 40.0},
    joystick=hc.Joystick([0.1], {"z": [0.5]}, full_speed=0.2, dead_zone=0.05, ramp=0.1),
    goals=[hc.Goal(1.5, 2.6, 0.35)],
    delay=0.004,
    sensors="data-sheet",
    sensor_faults=[hc.SensorFault("cylinder.lift.p1", "freeze", 0.2)],
    bursts=[hc.Burst("jib", "rod-side", 0.6, 2e-6)],
    controller_model={"supply.pressure": 120e5},
    monitor=False,
    phases=[hc.Phase(1.0, {"control.tip.full-speed": 0.1})],
    supply=hc.SupplyPressure([0.0, 1.0], [140e5, 120e5]),
    seed=3,
    duration=2.0,
    solver=hc.Solver("hc-rosenbrock-3", step=1e-3),
)


def test_a_scenario_goes_to_the_page_with_all_that_it_states(tmp_path):
    request = drive_request(str(EVERYTHING.save(tmp_path / "all.toml")), {"friction.lift.coulomb": 400.0})
    assert sorted(request) == ["files", "scenario", "scenario-name"] and request["files"] == {}
    asked = tmp_path / "asked.toml"
    asked.write_text(request["scenario"], encoding="utf-8")
    wanted = EVERYTHING.changed(overrides={"friction.lift.coulomb": 400.0})
    assert hc.load_scenario(asked).to_toml() == wanted.changed(controller="tip").to_toml()


def test_a_scenario_on_a_machine_of_ones_own_takes_its_file_along(tmp_path):
    machine = tmp_path / "mine.toml"
    machine.write_text('extends = "rottne-f9-lab"\n', encoding="utf-8")
    plan = hc.Scenario(machine=str(machine), joints=EVERYTHING.joints, commands={"lift": 0.002})
    request = drive_request(str(plan.save(tmp_path / "lift.toml")), {})
    assert (request["files"], request["scenario-name"]) == ({"mine.toml": machine.read_text()}, "lift.toml")
    assert 'machine = "./mine.toml"' in request["scenario"]


def test_what_is_wrong_is_said_before_a_server_starts(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text('extends = "rottne-f9-lab"\n[suply]\n', encoding="utf-8")
    with pytest.raises(MachineFileError, match="bad.toml:2:"):
        drive_request(str(path), {})


# --- the compiled core ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drive():
    """Drive a compiled core in Node: (request, moves) to its answer."""
    if not PAGE.exists():
        pytest.skip("the cockpit is not built: run `make cockpit`")
    node = shutil.which("node")
    if node is None:
        pytest.skip("no Node.js to run WebAssembly in")

    def drive(request, moves, core="core"):
        (file,) = (PAGE / "assets").glob(f"{core}-*.wasm")
        done = subprocess.run(
            [node, ROOT / "cockpit/tests/drive.mjs", file],
            input=json.dumps({"request": request, "moves": moves}),
            capture_output=True,
            text=True,
            timeout=300,
            check=True,
        )
        return json.loads(done.stdout)

    return drive


def restless(axes, seconds):
    """Somebody who changes the sticks every now and then, takes up a log and lets it go."""
    draws = np.random.default_rng(axes)
    moves = [{"axes": list(draws.uniform(-1, 1, axes)), "ticks": 370} for _ in range(int(seconds / 0.37))]
    moves[len(moves) // 3]["mass"] = 40.0
    moves[len(moves) // 2]["mass"] = 0.0
    left = round(1000 * seconds) - sum(move["ticks"] for move in moves)
    # One more step takes the sample at the end, until which the drive is written down.
    return [*moves, {"ticks": left}, {"ticks": 1}]


REQUESTS = {
    "tip": {"machine": "rottne-f9-lab", "full-speed": 0.25, "dead-zone": 0.02, "ramp": 0.15},
    "lever": {"machine": "rottne-f9-lab", "controller": "lever", "friction": 1.3, "real-sensors": True, "seed": 5,
              "overrides": {"supply.pressure": 150e5}},
}  # fmt: skip


@pytest.mark.parametrize("mode", REQUESTS)
def test_a_drive_in_webassembly_is_repeated_by_the_native_core(drive, mode, tmp_path):
    """60 s of driving, saved as a scenario and simulated, end at the same tip within 1e-9 m."""
    driven = drive(REQUESTS[mode], restless(2 if mode == "tip" else 3, 60.0))
    path = tmp_path / "drive.toml"
    path.write_text(driven["saved"]["saved"], encoding="utf-8")
    run = hc.simulate(path)
    assert run.outcome.completed and run.outcome.time == 60.0
    names = [signal["name"] for signal in driven["description"]["signals"]]
    start, end = driven["rows"][0], driven["rows"][-2]
    assert end[names.index("time")] == pytest.approx(60.0, abs=1e-9)
    tips = np.array([[row[names.index(n)] for n in ("tip.x", "tip.z")] for row in (start, end)])
    native = np.array([run.data["tip.x"][-1], run.data["tip.z"][-1]])
    assert np.abs(tips[1] - tips[0]).max() > 0.05, "the drive leads somewhere"
    assert np.abs(tips[1] - native).max() < 1e-9
    work = sum(float(run.data[f"ledger.{c}.supply"][-1]) for c in run.cylinder_names)
    assert end[names.index("ledger.supply")] == pytest.approx(work, rel=1e-9) and work > 1e3


def test_a_drive_with_changes_on_the_way_is_repeated_by_the_native_core(drive, tmp_path):
    """60 s with two changes of mode, weaker supply, more friction, and a load."""
    moves = restless(3, 60.0)
    weak = {"controller": "lever", "overrides": {"supply.pressure": 105e5}}
    for part, request in [(30, {"controller": "lever"}), (60, weak), (90, {**weak, "friction": 1.4}),
                          (120, {**weak, "controller": "tip", "real-sensors": True})]:  # fmt: skip
        # Between two samples: the change goes on to the next one, 7 ms later.
        moves[part - 1]["ticks"] += 3
        moves[part]["request"] = request
    driven = drive(REQUESTS["tip"], moves)
    names = [signal["name"] for signal in driven["description"]["signals"]]
    path = tmp_path / "drive.toml"
    path.write_text(driven["saved"]["saved"], encoding="utf-8")
    plan = hc.load_scenario(path)
    assert [stage.driver for _, stage in plan.stages()] == ["tip", "lever", "lever", "lever", "tip"]
    assert plan.recorded_by == hc.__version__ and plan.payload_changes
    run = hc.simulate(path)
    assert run.outcome.completed and run.outcome.time == pytest.approx(60.04)
    rows = np.array(driven["rows"])[:, : len(names)]
    at = np.searchsorted(run.data.time.values, rows[:, 0] - 1e-6).clip(max=run.data.sizes["time"] - 1)
    same = np.abs(run.data.time.values[at] - rows[:, 0]) < 1e-6
    assert same[-2] and same.sum() > 20
    for name in ("tip.x", "tip.z"):
        driven_tip, native = rows[same, names.index(name)], run.data[name].values[at[same]]
        assert np.ptp(native) > 0.1 and np.abs(driven_tip - native).max() < 1e-9, name


def test_a_scenario_that_is_served_is_played_as_it_runs(drive, tmp_path):
    """Nobody takes over, and loads, faults, goals, phases, bursts and pressures are those of the run."""
    request = drive_request(str(EVERYTHING.save(tmp_path / "all.toml")), {})
    played = drive(request, [{"ticks": 2000}], core="chains")
    run = hc.simulate(tmp_path / "all.toml")
    assert run.outcome.completed and len(run.payload_changes) == 1
    names = [signal["name"] for signal in played["description"]["signals"]]
    signals = ["tip.x", "tip.z", "payload", "cylinder.lift.p1", "cylinder.jib.lost2", "mains.p"]
    end = [played["rows"][-1][names.index(name)] for name in signals]
    np.testing.assert_allclose(end, [run.data[name].values[-1] for name in signals], rtol=1e-9, atol=1e-9)


def test_the_first_core_is_light(drive):
    (file,) = (PAGE / "assets").glob("core-*.wasm")
    texts = [*(ROOT / "machines").glob("*.toml"), *(ROOT / "scenarios").glob("*.toml")]
    code = file.stat().st_size - sum(text.stat().st_size for text in texts)
    assert code < 1.7e6, "names of functions left in it, or laws for other chains?"


def test_a_chain_that_the_first_core_has_no_laws_for_is_driven_by_the_second(drive, tmp_path):
    (tmp_path / LONG.name).write_bytes(LONG.read_bytes())
    request = {"machine": LONG.name, "text": LONG.read_text(encoding="utf-8"), "controller": "lever"}
    error = drive(request, [])["error"]
    assert error["slug"] == "chain" and "4 joints" in error["message"]
    driven = drive(request, restless(4, 10.0), core="chains")
    path = tmp_path / "drive.toml"
    path.write_text(driven["saved"]["saved"], encoding="utf-8")
    run = hc.simulate(path)
    names = [signal["name"] for signal in driven["description"]["signals"]]
    tips = np.array([[row[names.index(n)] for n in ("tip.x", "tip.z")] for row in driven["rows"]])
    native = np.array([run.data["tip.x"][-1], run.data["tip.z"][-1]])
    assert run.outcome.completed and np.abs(tips[-2] - tips[0]).max() > 0.02
    assert np.abs(tips[-2] - native).max() < 1e-9


def test_hoses_burst_in_the_second_core_as_in_a_run(drive, tmp_path):
    request = {**REQUESTS["tip"], "bursts": [["lift", "piston-side", 2.0034, 2e-6]]}
    driven = drive(request, restless(2, 5.0), core="chains")
    path = tmp_path / "drive.toml"
    path.write_text(driven["saved"]["saved"], encoding="utf-8")
    for asked in (request, {"scenario": path.read_text(encoding="utf-8")}):
        assert drive(asked, [])["error"]["slug"] == "chain"
    replayed = drive({"scenario": path.read_text(encoding="utf-8")}, [{"ticks": 5000}], core="chains")
    run = hc.simulate(path)
    names = [signal["name"] for signal in driven["description"]["signals"]]
    signals = ["tip.x", "tip.z", "cylinder.lift.lost1"]
    native = [run.data[name].values[-1] for name in signals]
    assert run.outcome.completed and native[2] > 0.0
    for row in (driven["rows"][-2], replayed["rows"][-1]):
        assert row[names.index("time")] == pytest.approx(5.0, abs=1e-9)
        np.testing.assert_allclose([row[names.index(name)] for name in signals], native, rtol=0.0, atol=1e-9)


def test_webassembly_tells_the_errors_of_the_command_line(drive, tmp_path):
    text = 'extends = "rottne-f9-lab"\n\n[supply]\npresure = "140 bar"\n'
    told = drive({"machine": "mine.toml", "text": text}, [])["error"]
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    with pytest.raises(MachineFileError) as native:
        hc.load_machine(tmp_path / "mine.toml")
    assert told["message"] == str(native.value).replace(f"{tmp_path}/", "")
    assert (told["line"], told["slug"]) == (4, "unknown-key")


def test_the_command_serves_what_it_is_asked_to(page, monkeypatch):
    monkeypatch.setattr("hydrocrane.app.serving.live_server.PAGE", page)
    with cockpit_server("single-cylinder") as server:
        assert server.address.endswith("/?chosen")
        assert json.loads(server.files["/chosen.json"][1])["machine"] == "single-cylinder"
