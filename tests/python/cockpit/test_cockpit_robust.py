"""The cockpit where things go wrong: slow computers, hidden tabs, reloads, nonsense, no network."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import hosted, served
from cockpit_tab import PICTURES, STARTS, Page, hold, table

import hydrocrane as hc
from hydrocrane.app.serving.live_server import PAGE, own_page, page_files

# A chain of four joints.
LONG = Path(__file__).resolve().parents[2] / "data/two-telescopes.toml"
# Farthest that a tip at 0.3 m/s gets between two rows of 10 ms, m, with its ringing.
FARTHEST = 5e-3
# A processor that takes 2 ms for each ms.
SLOW = """
const plain = WebAssembly.instantiate;
WebAssembly.instantiate = async (...given) => {
  const core = (await plain(...given)).instance.exports;
  const advance = (ticks) => {
    const end = performance.now() + 2 * ticks;
    while (performance.now() < end);
    return core.advance(ticks);
  };
  return { instance: { exports: { ...core, advance } } };
};
"""
# A tab in the background draws nothing until it comes back.
HIDE = """() => {
  window.awake = window.requestAnimationFrame;
  window.asleep = [];
  window.requestAnimationFrame = (act) => window.asleep.push(act);
  Object.defineProperty(document, "hidden", { value: true, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""
SHOW = """() => {
  window.requestAnimationFrame = window.awake;
  Object.defineProperty(document, "hidden", { value: false, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
  window.asleep.forEach((act) => window.requestAnimationFrame(act));
}"""


def rows_without_jumps(page):
    """The drive so far: nothing is left out of it, and nothing leaps."""
    data = table(page.download("Data"))
    assert np.allclose(np.diff(data["time"]), 0.01, atol=1e-9)
    assert np.hypot(np.diff(data["tip.x"]), np.diff(data["tip.z"])).max() < FARTHEST
    return data


# --- too little computer --------------------------------------------------------------------------------------------


def test_a_slow_processor_falls_behind_and_says_so(browser):
    def slowed(route):
        answer = route.fetch()
        route.fulfill(response=answer, body=SLOW + answer.text())

    # Where a drive was chosen, the browser keeps no files of its own.
    with served("rottne-f9-lab") as chosen, Page(browser, chosen) as page:
        page.context.route("**/worker-*.js", slowed)
        page.tab.reload()
        page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
        start = page.tip
        page.tab.keyboard.down("ArrowUp")
        page.until(lambda: "this computer is too slow" in page.tab.locator("#pace").inner_text())
        pace = page.tab.locator("#pace").inner_text()
        page.tab.keyboard.up("ArrowUp")
        assert 0.1 < float(pace.split(": ")[1].split()[0]) < 0.7 and "lost" in pace, pace
        page.comes_to_rest()
        assert rows_without_jumps(page)["tip.z"][-1] > start[1] + 0.02
        assert not page.complaints


def test_a_page_that_draws_slowly_steers_all_the_same(cockpit):
    session = cockpit.context.new_cdp_session(cockpit.tab)
    session.send("Emulation.setCPUThrottlingRate", {"rate": 12})
    start = cockpit.tip
    hold(cockpit, "ArrowUp", 2)
    cockpit.comes_to_rest()
    session.send("Emulation.setCPUThrottlingRate", {"rate": 1})
    data = rows_without_jumps(cockpit)
    assert data["tip.z"][-1] > start[1] + 0.1 and abs(data["tip.x"][-1] - start[0]) < 0.05


# --- out of sight ---------------------------------------------------------------------------------------------------


def test_a_hidden_tab_lets_go_and_goes_on_where_it_was(cockpit):
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(1)
    hidden_at = cockpit.shown("time")[0]
    cockpit.tab.evaluate(HIDE)
    cockpit.wait(2)
    cockpit.tab.evaluate(SHOW)
    cockpit.tab.keyboard.up("ArrowUp")
    cockpit.comes_to_rest()
    data = rows_without_jumps(cockpit)
    asleep = (data["time"] > hidden_at + 1) & (data["time"] < hidden_at + 1.8)
    assert asleep.sum() > 50 and np.hypot(data["tip.vx"], data["tip.vz"])[asleep].max() < 0.02
    before = cockpit.tip
    hold(cockpit, "ArrowUp", 1)
    assert cockpit.tip[1] > before[1] + 0.05, "it can be driven again"


def test_a_reload_in_the_middle_of_a_drive_begins_anew_at_rest(cockpit):
    start = cockpit.tip
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(1)
    cockpit.tab.reload()
    cockpit.until(lambda: "tip" in cockpit.tab.locator("#readout").inner_text())
    cockpit.tab.keyboard.up("ArrowUp")
    cockpit.comes_to_rest()
    assert np.abs(cockpit.tip - start).max() < 0.01
    rows_without_jumps(cockpit)


# --- nonsense -------------------------------------------------------------------------------------------------------

NONSENSE = {
    "empty": b"",
    "binary": bytes(range(256)) * 50,
    "a page": b"<!doctype html><p>not a crane</p>",
    "of itself": b'extends = "mine.toml"\n',
    "not a number": b'extends = "rottne-f9-lab"\n[supply]\nclass = "setting"\npressure = nan\n',
    "long": b"x = 1 # " + b"crane " * 200_000,
    "deep": b"x = " + b"[" * 20_000,
}


@pytest.mark.parametrize("kind", ["machine", "drive"])
def test_nonsense_in_files_is_one_message_and_the_drive_goes_on(cockpit, tmp_path, kind):
    path = tmp_path / "mine.toml"
    for what, content in NONSENSE.items():
        path.write_bytes(content)
        cockpit.tab.locator(f"#{kind}-file").set_input_files(path)
        notice = cockpit.tab.locator(".notice.error")
        notice.wait_for(timeout=STARTS)
        told = notice.all_inner_texts()
        assert len(told) == 1 and len(told[0]) < 1000 and "stopped" not in told[0], (what, told)
        notice.locator("button").click()
        then = cockpit.shown("time")[0]
        cockpit.wait(0.4)
        assert cockpit.shown("time")[0] > then, what


# --- every crane, every mode ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("machine", hc.bundled_machines())
def test_every_machine_can_be_driven(browser, address, machine):
    PICTURES.mkdir(parents=True, exist_ok=True)
    with Page(browser, f"{address}?machine={machine}") as page:
        assert page.tab.title().startswith(machine)
        page.tab.keyboard.press("2")
        page.tab.locator(".lever").first.wait_for(timeout=STARTS)
        for key in ("KeyQ", "KeyW", "KeyE", "KeyR")[: page.tab.locator(".lever").count()]:
            hold(page, key, 0.8)
        page.tab.keyboard.down("KeyA")
        page.wait(0.8)
        page.tab.screenshot(path=PICTURES / f"{machine}.png")
        page.tab.keyboard.up("KeyA")
        data = table(page.download("Data"))
        strokes = [column for name, column in data.items() if name.startswith("cylinder.") and name.endswith(".x")]
        assert strokes and all(np.isfinite(column).all() and np.ptp(column) > 2e-3 for column in strokes)
        assert not page.complaints


def test_a_longer_chain_brings_a_core_of_its_own(browser, address):
    with Page(browser, address) as page:
        fetched = []
        page.context.on("request", lambda request: fetched.append(request.url.rsplit("/", 1)[-1]))
        page.tab.reload()
        page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
        page.tab.locator("#machine-file").set_input_files(LONG)
        page.until(lambda: page.tab.title().startswith("two-telescopes"))
        assert [name.split("-")[0] for name in fetched if name.endswith(".wasm")][-1:] == ["chains"]
        page.tab.keyboard.press("2")
        page.tab.locator(".lever").nth(3).wait_for(timeout=STARTS)
        hold(page, "KeyR", 0.8)
        assert np.ptp(table(page.download("Data"))["cylinder.second.x"]) > 2e-3
        assert not page.complaints


def test_a_hose_bursts_in_a_replay_and_beside_whoever_takes_over(browser, address, tmp_path):
    start = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
    torn = hc.Burst("lift", "piston-side", time=0.4, opening=1e-6)
    stick = hc.Joystick([0.0, 20.0], {"z": [0.1, 0.0]})
    path = hc.Scenario(joints=start, joystick=stick, bursts=torn, duration=30.0).save(tmp_path / "torn.toml")
    with Page(browser, address) as page:
        page.tab.locator("#drive-file").set_input_files(path)
        page.until(lambda: "replay until 30.0 s" in page.tab.locator("#pace").inner_text())
        page.until(lambda: "oil left through the hose" in page.notices())
        hold(page, "ArrowUp", 0.8)
        path.write_text(page.download("Save"), encoding="utf-8")
        lost = table(page.download("Data"))["cylinder.lift.lost1"]
        assert lost[0] == 0.0 and lost[-1] > 0.0
        assert hc.load_scenario(path).bursts == (torn,)
        assert not page.complaints


def test_the_controller_of_the_thesis_moves_the_tip_up(cockpit):
    mode = cockpit.tab.locator("label", has_text="Mode").locator("select")
    mode.select_option("heinze-pid")
    cockpit.tab.locator("#modes button[aria-pressed=false]").nth(2).wait_for()
    start = cockpit.tip
    hold(cockpit, "ArrowUp", 2)
    cockpit.comes_to_rest()
    moved = cockpit.tip - start
    assert moved[1] > 0.1 and abs(moved[0]) < 0.2 * moved[1], moved


def test_the_hint_goes_with_the_first_motion(cockpit):
    assert "arrow key" in cockpit.tab.locator("#hint").inner_text()
    hold(cockpit, "ArrowUp", 0.2)
    cockpit.until(lambda: not cockpit.tab.locator("#hint").is_visible())


# --- no network -----------------------------------------------------------------------------------------------------


def another_build(files):
    """The page of a later version."""
    style = next(name for name in files if name.endswith(".css"))
    names = {style: "/assets/later.css"}
    changed = {}
    for name, (kind, content) in files.items():
        content = content.replace(style[1:].encode(), names[style][1:].encode())
        content = content.replace(b"<body>", b'<body data-build="later">').replace(b'VERSION = "', b'VERSION = "later')
        changed[names.get(name, name)] = (kind, content)
    return changed


def test_the_page_works_without_a_network_and_is_never_stale(browser):
    if not (PAGE / "service-worker.js").is_file():
        pytest.skip("the cockpit is not built: run `make cockpit`")
    kept = "async () => navigator.serviceWorker.controller ? await caches.keys() : []"
    with hosted(page_files()) as server, Page(browser, server.address) as page:

        def again():
            page.tab.goto(server.address)
            page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
            return page.tab.evaluate("() => document.body.dataset.build ?? 'first'")

        page.until(lambda: page.tab.evaluate(kept))
        first = page.tab.evaluate(kept)
        page.context.set_offline(True)
        assert again() == "first"
        hold(page, "ArrowUp", 0.5)
        assert page.shown("time")[0] > 0
        page.context.set_offline(False)
        server.files = another_build(server.files)
        assert again() == "later", "the newest page where there is a network"
        page.until(lambda: len(page.tab.evaluate(kept)) == 1 and page.tab.evaluate(kept) != first)
        page.context.set_offline(True)
        assert again() == "later"


@pytest.mark.parametrize("after", ["another program", "hydrocrane live"])
def test_the_kept_page_gives_way_to_what_has_its_address_next(browser, after):
    if not (PAGE / "service-worker.js").is_file():
        pytest.skip("the cockpit is not built: run `make cockpit`")
    other = {"/": ("text/html", b"<link rel=icon href=data:,><p>another program</p>")}
    kept = (
        "async () => [await caches.keys(), await navigator.serviceWorker.getRegistrations()].map((all) => all.length)"
    )
    with hosted(page_files()) as server, Page(browser, server.address) as page:
        page.until(lambda: page.tab.evaluate("() => navigator.serviceWorker.controller !== null"))
        page.until(lambda: page.tab.evaluate(kept) == [1, 1])
        server.files = other if after == "another program" else own_page()
        page.tab.goto(server.address)
        page.until(lambda: page.tab.evaluate(kept) == [0, 0])
        if after == "another program":
            assert page.tab.locator("body").inner_text() == "another program"
