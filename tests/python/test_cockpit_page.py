"""The cockpit as people meet it: a real browser drives a crane by keyboard, stick and gamepad."""

from __future__ import annotations

import csv
import io
import re
import time

import numpy as np
import pytest
from browser import NoBrowser, chromium, served

import hydrocrane as hc
from hydrocrane.errors import InputError

STARTS = 20_000
DRIVE = """
[scenario]
name = "up"
machine = "rottne-f9-lab"
duration = "30 s"
[initial.joint]
boom = "100 deg"
jib = "100 deg"
[joystick]
time = ["0.1 s"]
z = [1]
full-speed = "0.1 m/s"
"""
# What a gamepad is to a page: first stick half to the right, second axis up (negative).
GAMEPAD = """
window.pad = { id: "emulated", index: 0, connected: true, axes: [0, 0, 0, 0], buttons: [], mapping: "standard" };
navigator.getGamepads = () => [window.pad];
"""


@pytest.fixture(scope="module")
def browser():
    try:
        with chromium() as found:
            yield found
    except NoBrowser as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="module")
def address():
    try:
        with served() as found:
            yield found
    except InputError as reason:
        pytest.skip(str(reason))


@pytest.fixture
def cockpit(browser, address):
    """A page with a crane at rest; whatever the page complains of fails the test."""
    with Page(browser, address) as page:
        yield page
        assert not page.complaints


class Page:
    """One tab with a cockpit."""

    def __init__(self, browser, address, script=""):
        self.browser = browser
        self.context = browser.new_context(viewport={"width": 1400, "height": 850})
        self.tab = self.context.new_page()
        self.complaints: list[str] = []
        self.tab.on("console", lambda m: m.type in ("error", "warning") and self.complaints.append(m.text))
        self.tab.on("pageerror", lambda error: self.complaints.append(str(error)))
        if script:
            self.tab.add_init_script(script)
        self.tab.goto(address)
        self.until(lambda: "tip" in self.tab.locator("#readout").inner_text())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.context.close()

    def shown(self, name):
        """Numbers of the readout behind a name."""
        text = self.tab.locator("#readout").inner_text()
        return [float(n) for n in re.findall(r"-?\d+\.?\d*", re.search(rf"{name}\s+([-\d., ]+)", text)[1])]

    def wait(self, seconds):
        self.tab.wait_for_timeout(1000 * seconds)

    @property
    def tip(self):
        return np.array(self.shown("tip"))

    def button(self, text):
        return self.tab.locator("button", has_text=text)

    def notices(self):
        return self.tab.locator("#notices").inner_text()

    def until(self, so):
        """Wait until `so()`: asked from here, because the page's policy forbids it to run text as code."""
        end = time.monotonic() + STARTS / 1000
        while not so():
            assert time.monotonic() < end, "the page does not get there"
            self.wait(0.05)

    def comes_to_rest(self):
        self.until(lambda: self.shown("speed")[0] < 0.005)

    def download(self, text):
        with self.tab.expect_download() as waiting:
            self.button(text).click()
        return waiting.value.path().read_text(encoding="utf-8")


def test_the_keyboard_moves_the_tip_and_letting_go_stops_it(cockpit):
    start = cockpit.tip
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(2)
    cockpit.tab.keyboard.up("ArrowUp")
    cockpit.comes_to_rest()
    moved = cockpit.tip - start
    assert moved[1] > 0.1 and abs(moved[0]) < 0.05 * moved[1] + 0.005, moved


def test_the_stick_on_the_screen_moves_the_tip(cockpit):
    start = cockpit.tip
    box = cockpit.tab.locator(".pad").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    cockpit.tab.mouse.move(x, y)
    cockpit.tab.mouse.down()
    cockpit.tab.mouse.move(x - 50, y, steps=4)
    cockpit.wait(2)
    assert float(cockpit.tab.locator(".pad").get_attribute("aria-valuenow")) < -0.5
    cockpit.tab.mouse.up()
    cockpit.comes_to_rest()
    moved = cockpit.tip - start
    assert moved[0] < -0.1 and abs(moved[1]) < 0.05 * abs(moved[0]) + 0.005, moved


def test_a_gamepad_moves_the_tip_until_it_is_pulled_out(browser, address):
    with Page(browser, address, GAMEPAD) as page:
        start = page.tip
        page.tab.evaluate("window.pad.axes = [0, -1, 0, 0]")
        page.wait(2)
        assert "emulated" in page.tab.locator("#readout").inner_text()
        page.tab.evaluate("navigator.getGamepads = () => [null]")
        page.comes_to_rest()
        moved = page.tip - start
        assert moved[1] > 0.1 and abs(moved[0]) < 0.1 * moved[1] + 0.005, moved
        assert not page.complaints


def test_whoever_looks_elsewhere_holds_no_stick(cockpit):
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(1)
    assert cockpit.shown("speed")[0] > 0.05
    cockpit.tab.evaluate("window.dispatchEvent(new Event('blur'))")
    cockpit.comes_to_rest()


def test_a_page_that_falls_silent_holds_no_stick(cockpit):
    """As when its tab goes to the background: the page stops telling, the simulation centres the sticks and goes on."""
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(1)
    before = cockpit.shown("time")[0]
    cockpit.tab.evaluate("{ const end = performance.now() + 2500; while (performance.now() < end); }")
    cockpit.wait(0.3)
    data = table(cockpit.download("Data"))
    after = data["time"] > before + 1.5
    still = np.hypot(data["tip.vx"], data["tip.vz"])[after & (data["time"] < before + 2.3)]
    assert still.size > 20 and still.max() < 0.02


def test_the_mode_changes_while_driving(cockpit):
    cockpit.wait(0.5)
    began, tip = cockpit.shown("time")[0], cockpit.tip
    cockpit.tab.keyboard.press("2")
    cockpit.tab.locator(".lever").nth(2).wait_for(timeout=STARTS)
    assert cockpit.shown("time")[0] >= began and np.abs(cockpit.tip - tip).max() < 0.01
    cockpit.tab.keyboard.down("KeyQ")
    cockpit.wait(1.5)
    cockpit.tab.keyboard.up("KeyQ")
    assert cockpit.tip[1] > tip[1] + 0.05, "the lift cylinder lifts"
    cockpit.button("lever").wait_for()
    assert cockpit.button("lever").get_attribute("aria-pressed") == "true"


def test_a_log_is_picked_up(cockpit):
    cockpit.wait(0.3)
    cockpit.button("Pick up").click()
    cockpit.tab.locator(".notice", has_text="80 kg").wait_for(timeout=STARTS)
    cockpit.wait(0.2)
    assert table(cockpit.download("Data"))["payload"][-1] == 80.0


def test_a_bad_machine_file_is_told_with_its_place_and_the_drive_goes_on(cockpit, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('extends = "rottne-f9-lab"\n[suply]\npressure = "90 bar"\n', encoding="utf-8")
    cockpit.tab.locator("#machine-file").set_input_files(path)
    cockpit.tab.locator(".notice.error").wait_for(timeout=STARTS)
    assert "mine.toml:2:" in cockpit.notices() and "supply" in cockpit.notices()
    then = cockpit.shown("time")[0]
    cockpit.wait(0.5)
    assert cockpit.shown("time")[0] > then
    path.write_text('extends = "hiab-xs031"\n', encoding="utf-8")
    cockpit.tab.locator("#machine-file").set_input_files(path)
    cockpit.until(lambda: cockpit.tab.title().startswith("mine.toml") or "hiab" in cockpit.tab.title())


def test_a_recorded_drive_is_repeated_by_the_native_core(cockpit, tmp_path):
    cockpit.button("Reset").click()
    for key in ("ArrowUp", "ArrowRight", "ArrowDown"):
        cockpit.tab.keyboard.down(key)
        cockpit.wait(0.7)
        cockpit.tab.keyboard.up(key)
        if key == "ArrowUp":
            cockpit.button("Pick up").click()
    cockpit.wait(0.3)
    path = tmp_path / "drive.toml"
    path.write_text(cockpit.download("Scenario"), encoding="utf-8")
    driven = table(cockpit.download("Data"))
    run = hc.simulate(path)
    assert run.outcome.completed and float(run.data["payload"][-1]) == 80.0
    rows = np.searchsorted(driven["time"], run.data["time"].values - 1e-6)
    assert rows.size > 200
    for name in ("tip.x", "tip.z"):
        # The drive's first row is the first after the reset.
        recorded = run.data[name].values[1:]
        assert np.abs(driven[name][rows[1:]] - recorded).max() < 1e-9
        assert np.ptp(recorded) > 0.05


def test_a_drive_is_shared_as_a_link_and_replayed(cockpit, address):
    cockpit.button("Reset").click()
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(1)
    cockpit.tab.keyboard.up("ArrowUp")
    cockpit.comes_to_rest()
    reached = cockpit.tip
    cockpit.button("Link").click()
    cockpit.until(lambda: "#drive=" in cockpit.tab.url)
    with Page(cockpit.browser, cockpit.tab.url) as other:
        assert "replay" in other.tab.locator("#pace").inner_text()
        other.until(lambda: "replay" not in other.tab.locator("#pace").inner_text())
        other.comes_to_rest()
        assert np.abs(other.tip - reached).max() < 0.0015, "to the digits shown"
        assert not other.complaints


def test_a_saved_drive_is_replayed_until_a_stick_is_moved(cockpit, tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text(DRIVE, encoding="utf-8")
    cockpit.tab.locator("#drive-file").set_input_files(path)
    cockpit.until(lambda: "replay until 30.0 s" in cockpit.tab.locator("#pace").inner_text())
    start = cockpit.tip
    cockpit.wait(1.5)
    assert cockpit.tip[1] > start[1] + 0.05
    cockpit.tab.keyboard.down("ArrowDown")
    cockpit.until(lambda: "replay" not in cockpit.tab.locator("#pace").inner_text())
    cockpit.tab.keyboard.up("ArrowDown")
    cockpit.comes_to_rest()


def test_a_task_is_scored_in_each_mode(cockpit):
    task = cockpit.tab.locator("label", has_text="Lead the tip").locator("select")
    task.select_option("line")
    cockpit.until(lambda: cockpit.shown("time")[0] < 1)
    cockpit.tab.keyboard.down("ArrowUp")
    row = cockpit.tab.locator("#scores tr", has_text="line, tip")
    row.wait_for(timeout=STARTS)
    cockpit.tab.keyboard.up("ArrowUp")
    seconds, worst, mean, work = (float(cell.split()[0]) for cell in row.locator("td").all_inner_texts())
    assert 2 < seconds < 15 and 0 <= mean <= worst < 15 and 1 < work < 50, (seconds, worst, mean, work)
    cockpit.button("Reset").click()
    cockpit.tab.keyboard.press("2")
    cockpit.tab.locator(".lever").first.wait_for()
    cockpit.tab.keyboard.down("KeyQ")
    cockpit.wait(2.5)
    cockpit.tab.keyboard.up("KeyQ")
    assert cockpit.tab.locator("#scores tr").count() == 2, "the lift alone leads past the end of the line"


@pytest.mark.parametrize("nonsense", ["AAAA", "%%%", "eJw", "S8zLAQA"])
def test_nonsense_in_a_link_is_one_clear_message(browser, address, nonsense):
    with Page(browser, f"{address.split('?')[0]}#drive={nonsense}") as page:
        page.tab.locator(".notice.error").wait_for(timeout=STARTS)
        assert len(page.notices()) < 400 and "undefined" not in page.notices()
        page.wait(0.3)
        assert page.shown("time")[0] > 0, "the usual crane stands in"
        assert not page.complaints


def table(text):
    """A CSV file by column."""
    head, *rows = csv.reader(io.StringIO(text))
    return {name.split(" [")[0]: np.array(column, dtype=float) for name, column in zip(head, zip(*rows))}
