"""The cockpit for everybody: other keyboards, sliders by keys, several sticks, screen readers, strong contrasts."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from browser import served
from cockpit_tab import PICTURES, STARTS, Page, hold, table

import hydrocrane as hc

ROOT = Path(__file__).resolve().parents[3]
AXE = ROOT / "cockpit/node_modules/axe-core/axe.min.js"
# Names that lack what a button shows are among the experimental rules.
WRONG = """async () => {
  const rules = { "label-content-name-mismatch": { enabled: true } };
  const { violations } = await axe.run(document, { rules });
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target).join(" ")}`);
}"""
AZERTY = """
const layout = new Map([["KeyQ", "a"], ["KeyA", "q"], ["KeyW", "z"], ["KeyS", "s"], ["KeyE", "e"], ["KeyD", "d"]]);
Object.defineProperty(navigator, "keyboard", { value: { getLayoutMap: async () => layout } });
"""
# A browser that does not tell the layout.
SILENT = 'Object.defineProperty(navigator, "keyboard", { value: undefined });'
GAMEPADS = """
const pad = (index) => ({ id: "twin", index, connected: true, axes: [0, 0, 0, 0], buttons: [], mapping: "" });
window.pads = [null, pad(1), pad(2)];
navigator.getGamepads = () => window.pads;
"""
# A doubt that the core tells of, twice.
DOUBTS = """
window.Worker = class extends window.Worker {
  set onmessage(act) {
    let told = 0;
    super.onmessage = (event) => {
      act(event);
      if (event.data.tell !== "rows" || told++ > 1) return;
      const doubt = { time: told, text: "lift p1 is 312 bar", warning: "pressure-above-rating", cure: "Carry less." };
      act({ data: { tell: "happened", events: [doubt], ended: null } });
    };
  }
};
"""
# The next phase has other states, which ends a replay.
STUCK = """
[scenario]
name = "stuck"
machine = "rottne-f9-lab"
duration = "9 s"
[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0 mm"
[controller]
name = "tip"
[joystick]
time = ["0 s"]
z = [0]
[phase.levers]
time = "0.3 s"
[phase.levers.overrides]
"friction.lift.model" = "static"
[phase.levers.controller]
name = "lever"
[phase.levers.joystick]
mode = "lever"
time = ["0.3 s"]
lift = [0]
"""


@pytest.fixture
def stuck(browser, address, tmp_path):
    """A page whose drive has ended."""
    path = tmp_path / "drive.toml"
    path.write_text(STUCK, encoding="utf-8")
    with Page(browser, address) as page:
        if AXE.is_file():
            page.context.add_init_script(path=AXE)
            page.tab.reload()
            page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
        page.tab.locator("#drive-file").set_input_files(path)
        page.until(lambda: "The drive ended" in page.notices())
        yield page
        assert not page.complaints


# --- modes and the end of a drive -----------------------------------------------------------------------------------


def test_after_the_end_of_a_drive_reset_begins_anew(stuck):
    pause, pace = stuck.tab.locator("#pause"), stuck.tab.locator("#pace")
    assert "Ended" in pause.inner_text() and pause.is_disabled() and "ended" in pace.inner_text()
    stuck.wait(2.5)
    assert "too slow" not in pace.inner_text()
    stuck.button("Reset").click()
    stuck.until(lambda: "Pause" in pause.inner_text())
    assert pause.is_enabled() and not stuck.notices()
    then = stuck.shown("time")[0]
    stuck.wait(1.5)
    assert stuck.shown("time")[0] > then + 0.7 and "ended" not in pace.inner_text()


def test_a_slow_clock_and_a_pause_are_no_slow_computer(cockpit):
    pace, speed = cockpit.tab.locator("#pace"), cockpit.tab.locator("#speed")
    speed.select_option("2")
    cockpit.until(lambda: cockpit.shown("time")[0] > 3)
    slow = False
    for act in (
        lambda: speed.select_option("0.1"),
        lambda: speed.select_option("1"),
        *[lambda: cockpit.tab.keyboard.press("KeyP")] * 2,
    ):
        act()
        for _ in range(6):
            cockpit.wait(0.2)
            load = float(re.search(r"takes (\d+) %", pace.get_attribute("title"))[1])
            slow = slow or ("too slow" in pace.inner_text() and load < 50)
    assert not slow


@pytest.mark.parametrize("machine", ["rig-kalmar", "single-cylinder"])
def test_one_cylinder_offers_neither_stick_nor_tasks_nor_logs(browser, address, machine):
    with Page(browser, f"{address}?machine={machine}") as page:
        assert page.tab.locator("#modes button:visible").all_inner_texts() == ["lever"]
        mode = page.tab.locator("label", has_text="Mode").locator("option")
        assert [option.get_attribute("value") for option in mode.all()] == ["lever"]
        assert page.tab.locator(".lever").count() == 1 and page.tab.locator(".pad").count() == 0
        assert not page.button("Grip").is_visible() and page.tab.locator("label", has_text="Choose a task").count() == 0
        page.tab.keyboard.press("1")
        page.wait(0.3)
        assert not page.notices() and page.tab.locator(".lever").count() == 1
        assert not page.complaints


def test_a_paused_page_draws_nothing(cockpit):
    drawn = "() => new Promise((tell) => setTimeout(() => tell(window.drawn), 1500))"
    cockpit.tab.keyboard.press("KeyP")
    cockpit.wait(0.5)
    cockpit.tab.evaluate("""() => {
      window.drawn = 0;
      const fill = CanvasRenderingContext2D.prototype.fillRect;
      CanvasRenderingContext2D.prototype.fillRect = function (...given) { window.drawn++; fill.apply(this, given); };
    }""")
    assert cockpit.tab.evaluate(drawn) == 0
    cockpit.tab.locator("#view-buttons button").first.click()
    assert 0 < cockpit.tab.evaluate(drawn) < 5
    cockpit.tab.keyboard.press("KeyP")
    assert cockpit.tab.evaluate(drawn) > 5


def test_a_warning_says_that_it_is_one_and_what_helps(browser, address):
    with Page(browser, address, DOUBTS) as page:
        warning = page.tab.locator(".notice.warning")
        page.until(lambda: "2.00 s" in page.notices())
        assert warning.count() == 1 and "Warning 2.00 s: lift p1 is 312 bar" in warning.inner_text()
        assert "Carry less." in warning.inner_text()
        page.tab.keyboard.press("2")
        page.tab.locator(".lever").first.wait_for(timeout=STARTS)
        assert warning.count() == 1, "another knob makes the drive no better"
        page.button("Reset").click()
        page.until(lambda: warning.count() == 0)


# --- knobs and keys -------------------------------------------------------------------------------------------------


def test_a_slider_moved_by_keys_keeps_them(cockpit):
    slider = cockpit.tab.locator("label", has_text="Supply pressure").locator("input")
    start = cockpit.tip
    slider.focus()
    for presses in (1, 3, 1):
        for _ in range(presses):
            cockpit.tab.keyboard.press("ArrowUp")
        cockpit.wait(0.6)
    assert cockpit.tab.evaluate("() => document.activeElement.dataset.key") == "Supply pressure"
    assert "165 bar" in cockpit.tab.locator("label", has_text="Supply pressure").inner_text()
    cockpit.tab.keyboard.down("ArrowUp")
    cockpit.wait(0.4)
    cockpit.tab.keyboard.up("ArrowUp")
    assert np.abs(cockpit.tip - start).max() < 0.01, "the crane stands"
    mode = cockpit.tab.locator("label", has_text="Mode").locator("select")
    mode.focus()
    cockpit.tab.keyboard.press("ArrowDown")
    cockpit.until(lambda: cockpit.tab.locator("#modes [aria-pressed=true]").count() == 0)
    assert cockpit.tab.evaluate("() => document.activeElement.dataset.key") == "Mode"


def test_a_knob_whose_value_is_refused_goes_back(cockpit):
    crane = cockpit.tab.locator("label", has_text="Crane").locator("select")
    crane.evaluate("(it) => it.add(new Option('none', 'none'))")
    crane.select_option("none")
    cockpit.until(lambda: "none" in cockpit.notices())
    assert crane.input_value() == "rottne-f9-lab"


def test_the_friction_of_a_replay_is_what_was_set(cockpit):
    friction = cockpit.tab.locator("label", has_text="Friction")
    friction.locator("input").fill("3")
    cockpit.wait(0.6)
    cockpit.button("Link").click()
    cockpit.until(lambda: "#drive=" in cockpit.tab.url)
    with Page(cockpit.browser, cockpit.tab.url) as other:
        other.until(lambda: "300 %" in other.tab.locator("label", has_text="Friction").inner_text())


def test_the_full_stick_of_a_machine_stays_its_own(cockpit, tmp_path):
    assert "0.15 m/s" in cockpit.tab.locator("label", has_text="Full stick").inner_text()
    path = tmp_path / "mine.toml"
    own = 'extends = "rottne-f9-lab"\n[control.tip]\nclass = "setting"\nsource = "mine"\nfull-speed = "0.12 m/s"\n'
    path.write_text(own, encoding="utf-8")
    cockpit.tab.locator("#machine-file").set_input_files(path)
    cockpit.until(lambda: "0.12 m/s" in cockpit.tab.locator("label", has_text="Full stick").inner_text())


def test_a_second_stick_is_read_and_can_be_chosen(browser, address):
    with Page(browser, address, GAMEPADS) as page:
        start = page.tip
        page.tab.evaluate("window.pads[2].axes = [0, -1, 0, 0]")
        page.until(lambda: page.tip[1] > start[1] + 0.1)
        page.tab.locator("summary", has_text="Gamepad").click()
        page.tab.locator(".axis-row select").nth(1).select_option(label="twin: axis 2")
        page.comes_to_rest()
        page.tab.evaluate("window.pads[1].axes = [0, 1, 0, 0]")
        then = page.tip
        page.until(lambda: page.tip[1] < then[1] - 0.1)
        assert not page.complaints


@pytest.mark.parametrize("script", [AZERTY, SILENT], ids=["told by the browser", "learnt"])
def test_keys_are_called_what_is_printed_on_them(browser, address, script):
    with Page(browser, address, script) as page:
        page.tab.keyboard.press("2")
        page.tab.locator(".lever").nth(2).wait_for(timeout=STARTS)
        marks = page.tab.locator(".lever").first.locator("kbd")
        if script == SILENT:
            assert marks.all_inner_texts() == ["Q", "A"]
            for code, letter in (("KeyQ", "a"), ("KeyA", "q"), ("KeyW", "z")):
                pressed = {"code": code, "key": letter}
                page.tab.evaluate(
                    "(it) => ['keydown', 'keyup'].forEach((e) => window.dispatchEvent(new KeyboardEvent(e, it)))",
                    pressed,
                )
        page.until(lambda: marks.all_inner_texts() == ["A", "Q"])
        assert "A Z E out, Q S D in" in page.tab.locator(".help").inner_text()
        start = page.tip
        hold(page, "KeyQ", 1.5)
        assert page.tip[1] > start[1] + 0.05, "the place of a key counts"


def test_sticks_can_be_reached_and_moved_by_keys(cockpit):
    cockpit.tab.keyboard.press("2")
    levers = cockpit.tab.locator(".lever[role=slider]")
    levers.nth(2).wait_for(timeout=STARTS)
    start = table(cockpit.download("Data"))["cylinder.jib.x"][-1]
    levers.nth(1).focus()
    hold(cockpit, "ArrowUp", 1.2)
    assert table(cockpit.download("Data"))["cylinder.jib.x"][-1] > start + 5e-3
    facts = ("tabindex", "aria-label", "aria-valuemin", "aria-valuemax", "aria-valuenow", "aria-orientation")
    assert [levers.nth(1).get_attribute(name) for name in facts] == ["0", "Lever of jib", "-1", "1", "0.00", "vertical"]


# --- eyes and ears --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def axe():
    if not AXE.is_file():
        pytest.skip("axe-core is not installed: npm ci in cockpit")


def test_axe_finds_nothing_wrong(axe, browser, address):
    with Page(browser, address) as page:
        page.context.add_init_script(path=AXE)
        page.tab.reload()
        page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
        assert page.tab.evaluate(WRONG) == [], "at the start"
        page.tab.keyboard.press("2")
        page.tab.locator(".lever").first.wait_for(timeout=STARTS)
        hold(page, "KeyA", 0.5)
        assert page.tab.evaluate(WRONG) == [], "while levers move"
        page.tab.keyboard.press("1")
        page.tab.locator(".pad").wait_for(timeout=STARTS)
        for summary in page.tab.locator("#panel summary").all():
            summary.click()
        page.tab.locator("#grip").click()
        page.tab.emulate_media(color_scheme="dark")
        page.wait(0.3)
        assert page.tab.evaluate(WRONG) == [], "dark, with all panels open and a message"
        PICTURES.mkdir(parents=True, exist_ok=True)
        page.tab.screenshot(path=PICTURES / "dark.png")


def test_axe_finds_nothing_wrong_where_a_drive_has_ended(axe, stuck):
    assert stuck.tab.evaluate(WRONG) == []


def test_axe_finds_nothing_wrong_where_a_run_is_looked_at(axe, browser):
    run = hc.simulate("vertical-lift-open-loop", duration=0.5)
    with served(run) as viewer, Page(browser, viewer) as page:
        page.context.add_init_script(path=AXE)
        page.tab.reload()
        page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
        assert page.tab.evaluate(WRONG) == []


def test_own_colours_leave_knobs_and_legend(cockpit):
    cockpit.tab.emulate_media(forced_colors="active")
    colour = "(it) => getComputedStyle(it).backgroundColor"
    knob, pad = (cockpit.tab.locator(name).evaluate(colour) for name in (".knob", ".pad"))
    assert knob != pad
    marks = {mark.evaluate(colour) for mark in cockpit.tab.locator("#legend .mark").all()}
    assert len(marks) == 5
    PICTURES.mkdir(parents=True, exist_ok=True)
    cockpit.tab.screenshot(path=PICTURES / "forced-colours.png")


def luminance(colour):
    shares = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)]) / 255
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]


@pytest.mark.parametrize("theme", ["LIGHT", "DARK"])
def test_text_in_charts_can_be_read(theme):
    """It is drawn, so that no tool sees it: axes are `faint` on a card, at 4.5 to 1 as other text."""
    source = (ROOT / "cockpit/src/palette.ts").read_text(encoding="utf-8")
    faint = re.search(r'faint: "(#\w{6})"', source.split(f"{theme}: Palette")[1])[1]
    style = (ROOT / "cockpit/src/style.css").read_text(encoding="utf-8")
    cards = re.findall(r"--card: (#\w{6})", style)
    card = cards[0] if theme == "LIGHT" else cards[1]
    dark, light = sorted([luminance(faint), luminance(card)])
    assert (light + 0.05) / (dark + 0.05) >= 4.5
