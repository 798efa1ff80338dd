"""The cockpit as people meet it: a real browser drives a crane by keyboard, stick and gamepad."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from browser import served
from cockpit_tab import DRIVE, PICTURES, STARTS, Page, hold, table

import hydrocrane as hc
from hydrocrane.app.live import viewer_server

# What a gamepad is to a page: first stick half to the right, second axis up (negative).
GAMEPAD = """
window.pad = { id: "emulated", index: 0, connected: true, axes: [0, 0, 0, 0], buttons: [], mapping: "standard" };
navigator.getGamepads = () => [window.pad];
"""


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
    assert float(cockpit.tab.locator(".pad [role=slider]").first.get_attribute("aria-valuenow")) < -0.5
    cockpit.tab.mouse.up()
    cockpit.comes_to_rest()
    moved = cockpit.tip - start
    assert moved[0] < -0.1 and abs(moved[1]) < 0.05 * abs(moved[0]) + 0.005, moved


def test_a_click_sends_the_tip_to_a_point(cockpit):
    box = cockpit.tab.locator("#picture").bounding_box()
    aim = cockpit.tab.locator("#aim")

    def click(across, down):
        cockpit.tab.keyboard.press("g")
        assert aim.get_attribute("aria-pressed") == "true"
        cockpit.tab.mouse.click(box["x"] + across * box["width"], box["y"] + down * box["height"])
        assert aim.get_attribute("aria-pressed") == "false"

    click(0.01, 0.99)
    cockpit.until(lambda: "the tip cannot go to" in cockpit.notices())
    start = cockpit.tip
    click(0.6, 0.5)
    cockpit.until(lambda: "the tip has reached its goal" in cockpit.notices())
    goal = re.search(r"reached its goal \(([-\d.]+), ([-\d.]+)\)", cockpit.notices())
    assert np.abs(cockpit.tip - [float(number) for number in goal.groups()]).max() < 0.01
    assert np.abs(cockpit.tip - start).max() > 0.05


@pytest.mark.parametrize("hidden", [False, True])
def test_escape_or_hiding_the_page_drops_the_goal(cockpit, hidden):
    box = cockpit.tab.locator("#picture").bounding_box()
    cockpit.tab.keyboard.press("g")
    cockpit.tab.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    cockpit.wait(1)
    if hidden:
        cockpit.tab.evaluate(
            "() => { Object.defineProperty(document, 'hidden', { value: true, configurable: true });"
            " document.dispatchEvent(new Event('visibilitychange')); delete document.hidden; }"
        )
    else:
        cockpit.tab.keyboard.press("Escape")
    cockpit.until(lambda: "the goal is cancelled" in cockpit.notices())
    cockpit.comes_to_rest()
    assert "has reached its goal" not in cockpit.notices()


def test_shift_makes_a_stick_slow_and_so_does_a_switch(cockpit):
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(1)
    fast = cockpit.shown("speed")[0]
    cockpit.tab.keyboard.down("Shift")
    cockpit.wait(1)
    slow = cockpit.shown("speed")[0]
    cockpit.tab.keyboard.up("Shift")
    cockpit.tab.keyboard.press("x")
    cockpit.wait(1)
    switched = cockpit.shown("speed")[0]
    cockpit.tab.keyboard.up("ArrowUp")
    # A quarter of 0.15 m/s, the speed at full stick.
    assert 0.13 < fast < 0.17 and 0.03 < min(slow, switched) <= max(slow, switched) < 0.045, (fast, slow, switched)


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


def test_a_log_is_picked_up_where_one_lies_and_falls_to_the_ground(cockpit):
    cockpit.tab.locator("#grip").click()
    cockpit.until(lambda: "No log within reach" in cockpit.notices())
    assert table(cockpit.download("Data"))["payload"][-1] == 0.0
    reach, mass = max(x for curve in hc.load_machine("rottne-f9-lab").workspace() for x, _ in curve), 80.0
    # The ground is at -1.21 m; what hangs there reaches this far down from the tip.
    hangs = 0.12 + 2 * (0.1 + 0.022 * np.sqrt(mass))
    lead(cockpit, 0.62 * reach, -1.21 + hangs + 0.07)
    cockpit.tab.locator("#grip").click()
    cockpit.until(lambda: "carries 80 kg" in cockpit.notices())
    hold(cockpit, "ArrowUp", 1)
    cockpit.tab.keyboard.press("Space")
    cockpit.until(lambda: "carries 0 kg" in cockpit.notices())
    cockpit.tab.keyboard.press("Space")
    cockpit.until(lambda: "No log within reach" in cockpit.notices())


def test_a_log_is_set_down_with_levers_and_stays_where_it_is_let_go(cockpit):
    cockpit.begins_anew(lambda: cockpit.button("Start loaded").click())
    cockpit.tab.keyboard.press("2")
    cockpit.tab.locator(".lever").first.wait_for(timeout=STARTS)
    cockpit.tab.keyboard.down("KeyA")
    note = cockpit.tab.locator("#stage-note")
    cockpit.until(lambda: "The ground carries" in note.inner_text())
    cockpit.wait(1)
    cockpit.tab.keyboard.up("KeyA")
    cockpit.comes_to_rest()
    # 80 kg hang 0.714 m below the tip and sink in by the force over 200 kN/m.
    carried = 1000 * float(re.search(r"([0-9.]+) kN", note.inner_text())[1])
    underside = cockpit.tip[1] - 0.32 - 0.044 * np.sqrt(80)
    assert carried > 300 and underside == pytest.approx(-1.21 - 0.001 - carried / 2e5, abs=0.002)
    PICTURES.mkdir(parents=True, exist_ok=True)
    cockpit.tab.screenshot(path=PICTURES / "on-the-ground.png")
    cockpit.tab.keyboard.press("Space")
    cockpit.until(lambda: "carries 0 kg" in cockpit.notices())
    cockpit.until(lambda: not note.inner_text())
    assert table(cockpit.download("Data"))["tip.contact.z"].max() > 300


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
    cockpit.begins_anew(lambda: cockpit.button("Start loaded").click())
    for key in ("ArrowUp", "ArrowRight", "ArrowDown"):
        hold(cockpit, key, 0.7)
        if key == "ArrowRight":
            cockpit.tab.locator("#grip").click()
    cockpit.wait(0.3)
    path = tmp_path / "drive.toml"
    path.write_text(cockpit.download("Save"), encoding="utf-8")
    driven = table(cockpit.download("Data"))
    run = hc.simulate(path)
    assert run.outcome.completed and [float(run.data["payload"][row]) for row in (0, -1)] == [80.0, 0.0]
    rows = np.searchsorted(driven["time"], run.data["time"].values - 1e-6)
    assert rows.size > 200
    for name in ("tip.x", "tip.z"):
        # The drive's first row is the first after the reset.
        recorded = run.data[name].values[1:]
        assert np.abs(driven[name][rows[1:]] - recorded).max() < 1e-9
        assert np.ptp(recorded) > 0.05


def test_a_drive_with_changes_of_mode_and_knobs_is_repeated_by_the_native_core(cockpit, tmp_path):
    cockpit.button("Reset").click()
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(0.6)
    cockpit.tab.keyboard.press("2")
    cockpit.tab.locator(".lever").nth(2).wait_for(timeout=STARTS)
    cockpit.tab.keyboard.up("ArrowUp")
    cockpit.tab.keyboard.down("KeyQ")
    cockpit.wait(0.5)
    slider = cockpit.tab.locator("label", has_text="Supply pressure").locator("input")
    slider.fill("10000000")
    cockpit.wait(0.5)
    cockpit.tab.keyboard.up("KeyQ")
    cockpit.tab.keyboard.press("1")
    cockpit.wait(0.5)
    path = tmp_path / "drive.toml"
    path.write_text(cockpit.download("Save"), encoding="utf-8")
    driven = table(cockpit.download("Data"))
    plan = hc.load_scenario(path)
    assert [stage.driver for _, stage in plan.stages()] == ["tip", "lever", "lever", "tip"]
    run = hc.simulate(path)
    assert run.outcome.completed and (np.diff(driven["time"]) < 0.0101).all(), "no row is lost where a phase begins"
    rows = np.searchsorted(driven["time"], run.data["time"].values[1:] - 1e-6)
    for name in ("tip.x", "tip.z"):
        recorded = run.data[name].values[1:]
        assert np.abs(driven[name][rows] - recorded).max() < 1e-9
        assert np.ptp(recorded) > 0.01


def test_a_link_carries_a_machine_file_until_it_is_too_large(cockpit, tmp_path):
    path = tmp_path / "mine.toml"
    own = 'extends = "rottne-f9-lab"\n[supply]\nclass = "setting"\npressure = "120 bar"\n'
    path.write_text(own, encoding="utf-8")
    cockpit.tab.locator("#machine-file").set_input_files(path)
    cockpit.until(lambda: cockpit.tab.locator("select").first.input_value() != "rottne-f9-lab")
    cockpit.wait(0.5)
    cockpit.button("Link").click()
    cockpit.until(lambda: "#drive=" in cockpit.tab.url)
    with Page(cockpit.browser, cockpit.tab.url) as other:
        assert "120 bar" in other.tab.locator("label", has_text="Supply pressure").inner_text()
        assert not other.complaints
    noise = np.random.default_rng(1).integers(0, 2**62, 5000)
    path.write_text(own + "".join(f"# {n}\n" for n in noise), encoding="utf-8")
    cockpit.tab.locator("#machine-file").set_input_files(path)
    cockpit.wait(0.7)
    cockpit.button("Link").click()
    cockpit.until(lambda: "too long for a link" in cockpit.notices())
    assert "60 kB are safe" in cockpit.notices() and "machine file" in cockpit.notices()


def test_a_drive_is_shared_as_a_link_and_replayed(cockpit, address):
    cockpit.button("Reset").click()
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(1)
    cockpit.tab.keyboard.up("ArrowUp")
    cockpit.comes_to_rest()
    reached = cockpit.tip
    # Long enough for a slow computer to see it begin.
    cockpit.wait(4)
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


def test_a_scenario_that_is_served_is_played_until_a_stick_is_moved(browser, tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text(DRIVE + '[payload]\ntime = ["0.6 s", "20 s"]\nmass = ["40 kg", "0 kg"]\n', encoding="utf-8")
    with served(str(path)) as address, Page(browser, address) as page:
        page.until(lambda: "replay until 30.0 s" in page.tab.locator("#pace").inner_text())
        start = page.tip
        page.until(lambda: page.shown("time")[0] > 1.5)
        assert page.tip[1] > start[1] + 0.02 and "40 kg in place of 0 kg" in page.notices()
        page.tab.keyboard.down("ArrowDown")
        page.until(lambda: "replay" not in page.tab.locator("#pace").inner_text())
        page.tab.keyboard.up("ArrowDown")
        page.comes_to_rest()
        assert not page.complaints


def test_a_replay_of_straight_sticks_taken_over_is_saved_and_repeated(cockpit, tmp_path):
    path = tmp_path / "drive.toml"
    straight = DRIVE.replace('time = ["0.1 s"]\nz = [1]', 'interpolation = "linear"\ntime = ["0 s", "4 s"]\nz = [0, 1]')
    path.write_text(straight, encoding="utf-8")
    cockpit.tab.locator("#drive-file").set_input_files(path)
    cockpit.until(lambda: "replay until 30.0 s" in cockpit.tab.locator("#pace").inner_text())
    cockpit.wait(1.5)
    cockpit.tab.keyboard.down("ArrowRight")
    cockpit.wait(0.7)
    cockpit.tab.keyboard.up("ArrowRight")
    path.write_text(cockpit.download("Save"), encoding="utf-8")
    driven = table(cockpit.download("Data"))
    run = hc.simulate(path)
    rows = np.searchsorted(driven["time"], run.data["time"].values[1:] - 1e-6)
    for name in ("tip.x", "tip.z"):
        assert np.abs(driven[name][rows] - run.data[name].values[1:]).max() < 1e-9
        assert np.ptp(driven[name]) > 0.01


def test_a_task_is_scored_in_each_mode(cockpit):
    task = cockpit.tab.locator("label", has_text="Choose a task").locator("select")
    cockpit.begins_anew(lambda: task.select_option("line"))
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


def test_knobs_set_just_before_a_task_are_kept(cockpit, tmp_path):
    """Three choices in one turn of the page, before any is answered."""
    chosen = {
        "Full stick": ("input", "0.3"),
        "Supply pressure": ("input", "15000000"),
        "Choose a task": ("select", "square"),
    }
    found = [
        [cockpit.tab.locator("label", has_text=label).locator(kind).element_handle(), value]
        for label, (kind, value) in chosen.items()
    ]
    cockpit.tab.evaluate(
        """(found) => {
            for (const [element, value] of found) {
                element.value = value;
                element.dispatchEvent(new Event("change", { bubbles: true }));
            }
        }""",
        found,
    )
    cockpit.wait(1.0)
    for label, value in {"Full stick": "0.30 m/s", "Supply pressure": "150 bar"}.items():
        assert value in cockpit.tab.locator("label", has_text=label).inner_text()
    path = tmp_path / "drive.toml"
    path.write_text(cockpit.download("Save"), encoding="utf-8")
    assert hc.load_scenario(path).load_machine().value("supply.pressure").si == 15e6


def test_logs_are_moved_into_the_bunk(cockpit):
    """Three logs, gripped at their rings and let go over the bunk, at twice the speed of the clock and of the stick."""
    cockpit.tab.locator("label", has_text="Full stick").locator("input").fill("0.3")
    cockpit.tab.locator("label", has_text="Choose a task").locator("select").select_option("logs")
    cockpit.until(lambda: "ring" in cockpit.notices())
    cockpit.tab.keyboard.press("Space")
    cockpit.until(lambda: "No log within reach" in cockpit.notices())
    cockpit.tab.locator("#speed").select_option("2")
    reach = max(x for curve in hc.load_machine("rottne-f9-lab").workspace() for x, _ in curve)
    # The ground is at -1.21 m, the underside of a log of 40 kg is 0.6 m below the tip.
    ground, bunk = -1.21 + 0.32 + 0.044 * np.sqrt(40), 0.44 * reach
    for log in range(3):
        place = 0.86 * reach - log * 0.525
        lead(cockpit, place, ground + 0.5)
        lead(cockpit, place, ground + 0.07)
        cockpit.tab.keyboard.press("Space")
        cockpit.until(lambda: "carries 40 kg" in cockpit.notices())
        lead(cockpit, place, ground + 0.6)
        lead(cockpit, bunk, ground + 0.6)
        cockpit.tab.keyboard.press("Space")
        cockpit.until(lambda: "carries 0 kg" in cockpit.notices())
        cockpit.tab.evaluate("document.getElementById('notices').replaceChildren()")
    row = cockpit.tab.locator("#scores tr", has_text="logs, tip")
    row.wait_for(timeout=STARTS)
    seconds, worst, mean, work = (float(cell.split()[0]) for cell in row.locator("td").all_inner_texts())
    assert 10 < seconds < 300 and 0 <= mean <= worst < 300 and 5 < work < 200, (seconds, worst, mean, work)


def lead(cockpit, x, z):
    """Lead the tip to a place, one axis after the other, within 8 cm."""
    for axis, target, keys in ((1, z, ("ArrowDown", "ArrowUp")), (0, x, ("ArrowLeft", "ArrowRight"))):
        for _ in range(8):
            away = target - cockpit.tip[axis]
            if abs(away) < 0.06:
                break
            key = keys[int(away > 0)]
            cockpit.tab.keyboard.down(key)
            cockpit.until(lambda so=(away, axis, target): (so[2] - cockpit.tip[so[1]]) * so[0] < 0.1 * abs(so[0]))
            cockpit.tab.keyboard.up(key)
            cockpit.comes_to_rest()


@pytest.mark.parametrize("nonsense", ["AAAA", "%%%", "eJw", "S8zLAQA"])
def test_nonsense_in_a_link_is_one_clear_message(browser, address, nonsense):
    with Page(browser, f"{address.split('?')[0]}#drive={nonsense}") as page:
        page.tab.locator(".notice.error").wait_for(timeout=STARTS)
        assert len(page.notices()) < 400 and "undefined" not in page.notices()
        page.wait(0.3)
        assert page.shown("time")[0] > 0, "the usual crane stands in"
        assert not page.complaints


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run as `hydrocrane simulate` saves it."""
    path = tmp_path_factory.mktemp("run") / "lift.nc"
    hc.simulate("vertical-lift-open-loop", duration=4.0).save(path)
    return hc.load_run(path)


def test_a_run_is_looked_at(browser, address, run):
    with served(run) as viewer, Page(browser, viewer) as page:
        assert not page.tab.locator("#modes").is_visible() and page.tab.locator(".pad").count() == 0
        page.tab.locator("#speed").select_option("2")
        page.until(lambda: page.tab.locator("#timeline-time").inner_text() == "4.00 of 4.00 s")
        page.wait(0.3)
        assert np.abs(page.tip - [run.data["tip.x"][-1], run.data["tip.z"][-1]]).max() <= 0.0005
        work = sum(float(run.data[f"ledger.{c}.supply"][-1]) for c in run.cylinder_names)
        assert page.shown("work")[0] == pytest.approx(work / 1000, abs=0.051)
        driven = table(page.download("Data"))
        for name in ("tip.z", "joint.boom.q", "cylinder.lift.p1", "cylinder.lift.friction", "supply.power"):
            np.testing.assert_allclose(driven[name], run.data[name].values, rtol=1e-12, atol=1e-12)
        # There and back, slowly enough to be seen.
        page.tab.locator("#speed").select_option("0.1")
        page.tab.locator("#timeline").fill("250")
        page.until(lambda: 0.9 < page.shown("time")[0] < 1.6)
        page.button("Reset").click()
        page.until(lambda: page.shown("time")[0] < 0.6)
        assert not page.complaints


def test_the_viewer_serves_page_and_run_alone(run, address):
    with viewer_server(run) as server:
        names = set(server.files)
        table = np.frombuffer(server.files["/recorded.bin"][1], "<f8")
        assert server.server_address[0] == "127.0.0.1" and {"/chosen.json", "/recorded.bin"} < names
        assert not any(".nc" in name or ".." in name for name in names)
        about = json.loads(server.files["/chosen.json"][1])["recording"]
        rows = table.reshape(-1, len(about["columns"]))
        np.testing.assert_array_equal(rows[:, about["columns"].index("tip.x")], run.data["tip.x"])
        np.testing.assert_array_equal(rows[:, 0], run.data["time"])


def test_a_scenario_is_replayed_with_the_log_of_its_commands(cockpit, tmp_path):
    scenario = DRIVE.partition("[joystick]")[0] + '[command]\nlog = "drive.csv"\n'
    (tmp_path / "logged.toml").write_text(scenario, encoding="utf-8")
    (tmp_path / "drive.csv").write_text("time [s],lift [mm]\n0,0\n0.5,20\n30,20\n", encoding="utf-8")
    files = cockpit.tab.locator("#drive-file")
    files.set_input_files(tmp_path / "logged.toml")
    cockpit.until(lambda: "drive.csv" in cockpit.notices())
    files.set_input_files([tmp_path / "logged.toml", tmp_path / "drive.csv"])
    cockpit.until(lambda: "replay until 30.0 s" in cockpit.tab.locator("#pace").inner_text())
    start = cockpit.tip
    cockpit.wait(2.0)
    assert cockpit.tip[1] > start[1] + 0.02
    assert cockpit.tab.locator(".lever").count() == 3, "levers stand ready to take over"
