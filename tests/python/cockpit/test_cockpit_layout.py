"""The cockpit as a newcomer sees it: layout on every screen, scale, charts, ghosts, gamepad buttons."""

from __future__ import annotations

import re
import shutil
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
from browser import answering
from cockpit_tab import PICTURES, STARTS, Page, hold

import hydrocrane as hc
from hydrocrane.app.serving.live_server import PAGE

SCREENS = {"wide": (1440, 900), "narrow": (1024, 768), "upright": (390, 844), "lying": (844, 390)}
# Pixels of a colour on a canvas, within what smooth edges change.
COPY = """
  const it = document.querySelector(where);
  const copy = new OffscreenCanvas(it.width, it.height).getContext("2d", { willReadFrequently: true });
  copy.drawImage(it, 0, 0);
"""
COUNT = f"""([where, colour]) => {{ {COPY}
  const {{ data }} = copy.getImageData(0, 0, it.width, it.height);
  let count = 0;
  for (let at = 0; at < data.length; at += 4)
    count += colour.every((value, i) => Math.abs(data[at + i] - value) < 3) && data[at + 3] > 20;
  return count;
}}"""
CORNERS = f"""(where) => {{ {COPY}
  return [1, it.width - 2].map((x) => [...copy.getImageData(x, it.height - 2, 1, 1).data].slice(0, 3));
}}"""
SOIL, VEHICLE, LOG, GHOST = (233, 228, 218), (179, 188, 197), (156, 107, 63), (125, 91, 166)
SHADE = (213, 94, 0)
PAD = """
window.pads = ["one", "two"].map((id, index) => (
  { id, index, connected: true, axes: [0, 0, 0, 0], buttons: Array.from({ length: 12 }, () => ({ pressed: false })) }));
navigator.getGamepads = () => window.pads;
window.press = (pad, button, pressed) => (window.pads[pad].buttons[button] = { pressed });
"""


def box(page, where):
    found = page.tab.locator(where).bounding_box()
    assert found, where
    return found["x"], found["y"], found["x"] + found["width"], found["y"] + found["height"]


def inside(inner, outer, slack=1.0):
    return all((outer[i] - inner[i]) * (1 if i < 2 else -1) <= slack for i in range(4))


def apart(one, other):
    return one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]


def coloured(page, colour, where="#picture"):
    return page.tab.evaluate(COUNT, [where, list(colour)])


def scale(page):
    """Pixels per metre, as the scale bar says."""
    left, _, right, _ = box(page, "#scale-bar")
    number, unit = page.tab.locator("#scale").inner_text().split()
    return (right - left) / (float(number) * {"m": 1.0, "cm": 0.01}[unit])


def test_every_screen_shows_crane_stick_and_what_to_do_first(cockpit):
    PICTURES.mkdir(parents=True, exist_ok=True)
    cockpit.tab.locator("#speed").select_option("0.1")
    for name, (width, height) in SCREENS.items():
        cockpit.tab.set_viewport_size({"width": width, "height": height})
        cockpit.wait(0.3)
        cockpit.tab.screenshot(path=PICTURES / f"screen-{name}.png")
        screen, stage, hint = (0, 0, width, height), box(cockpit, "#stage"), box(cockpit, "#hint")
        for part in ("#picture", ".pad", "#grip", "#hint", "#reset", "#bar .files >> nth=0", "#bar .files >> nth=1"):
            assert inside(box(cockpit, part), screen), (name, part)
        assert apart(hint, box(cockpit, ".pad")) and apart(hint, box(cockpit, "#grip")), name
        # The tip is right of the middle of the picture.
        assert apart(hint, stage) or hint[2] < 0.5 * (stage[0] + stage[2]), name
        assert inside(box(cockpit, ".pad"), stage) == (name == "lying"), name
        assert cockpit.tab.evaluate("() => document.documentElement.scrollWidth") <= width, name
    # One, two and three columns.
    columns = {}
    for width in (899, 900, 1199, 1200):
        cockpit.tab.set_viewport_size({"width": width, "height": 800})
        cockpit.wait(0.1)
        stage, charts, panel = (box(cockpit, part)[0] for part in ("#stage", "#charts", "#panel"))
        columns[width] = len({round(stage), round(charts), round(panel)})
        whole = cockpit.tab.evaluate("() => document.documentElement.scrollHeight") <= 800
        assert whole == (width >= 900), "the page itself does not scroll where there are columns"
    assert columns == {899: 1, 900: 2, 1199: 2, 1200: 3}
    # What one grabs does not move away from the hand.
    before = box(cockpit, ".pad")
    hold(cockpit, "ArrowUp", 0.3)
    assert not cockpit.tab.locator("#hint").is_visible() and box(cockpit, ".pad") == before


def test_the_picture_is_to_scale(cockpit):
    cockpit.tab.locator("#speed").select_option("0.1")
    assert cockpit.tab.evaluate(CORNERS, "#picture") == [list(SOIL), list(SOIL)], "the ground goes on on both sides"
    assert coloured(cockpit, VEHICLE) > 100
    # Two clicks out of reach are told with their places.
    frame = box(cockpit, "#picture")
    clicks = np.array([(frame[0] + 40, frame[1] + 80), (frame[0] + 340, frame[1] + 180)])
    places = []
    for x, z in clicks.tolist():
        cockpit.tab.keyboard.press("g")
        cockpit.tab.mouse.click(x, z)
        cockpit.until(lambda: "cannot go to" in cockpit.notices())
        place = re.search(r"cannot go to \(([-\d.]+), ([-\d.]+)\)", cockpit.notices())
        places.append([float(number) for number in place.groups()])
        cockpit.tab.locator(".notice button").first.click()
    pixels = (clicks[1] - clicks[0]) / (np.subtract(*places[::-1]))
    assert pixels == pytest.approx([scale(cockpit), -scale(cockpit)], rel=0.02)
    # The end of a log of 3 m has the area that its mass needs at 850 kg/m^3, less its edge and rings.
    reach = max(x for curve in hc.load_machine("rottne-f9-lab").workspace() for x, _ in curve)
    cockpit.tab.mouse.move(*(clicks[0] + pixels * (np.array([0.62 * reach, -1.21]) - places[0])).tolist())
    cockpit.tab.mouse.wheel(0, -1000)
    mass = cockpit.tab.locator("label", has_text="Log").locator("input")
    for kilograms in (20, 80, 180):
        mass.fill(str(kilograms))
        cockpit.wait(0.3)
        drawn = coloured(cockpit, LOG) / scale(cockpit) ** 2
        assert 0.65 < drawn / (kilograms / (850 * 3)) < 1.0, (kilograms, drawn)


def settled(tab, bar) -> float:
    """Width of the scale bar once the first view of the crane stands."""
    width = None
    while width != (width := bar.bounding_box()["width"]):
        tab.wait_for_timeout(500)
    return width


def test_within_another_page_the_wheel_scrolls_that_page(browser, tmp_path):
    """As on the first page of the site; `hydrocrane live` itself lets no page embed it."""
    if not PAGE.is_dir():
        pytest.skip("the cockpit is not built: run `make cockpit`")
    shutil.copytree(PAGE, tmp_path / "cockpit")
    around = '<link rel=icon href=data:,><iframe src="cockpit/index.html" width=1000 height=600></iframe>'
    around += '<p style="height: 3000px">'
    (tmp_path / "index.html").write_text(around, encoding="utf-8")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(SimpleHTTPRequestHandler, directory=tmp_path))
    with answering(server), browser.new_context(viewport={"width": 1100, "height": 800}) as context:
        tab = context.new_page()
        tab.goto(f"http://127.0.0.1:{server.server_port}/")
        bar = tab.frame_locator("iframe").locator("#scale-bar")
        bar.wait_for(timeout=STARTS)
        before = settled(tab, bar)
        tab.mouse.move(300, 300)
        tab.mouse.wheel(0, 100)
        tab.wait_for_timeout(500)
        assert tab.evaluate("() => scrollY") == 100 and bar.bounding_box()["width"] == before
        tab.keyboard.down("Control")
        tab.mouse.wheel(0, -100)
        tab.wait_for_timeout(500)
        assert tab.evaluate("() => scrollY") == 100 and bar.bounding_box()["width"] != before


def test_charts_show_saturation_and_one_time(cockpit):
    charts = cockpit.tab.locator(".chart")
    note = cockpit.tab.locator(".open")
    assert charts.count() == 2 and not note.is_visible()
    cockpit.button("+ Chart").click()
    assert charts.count() == 3 and "Spool positions" in charts.nth(2).locator("select").evaluate(
        "(it) => it.selectedOptions[0].text"
    )
    cockpit.tab.locator("label", has_text="Full stick").locator("input").fill("1")
    cockpit.tab.keyboard.down("ArrowUp")
    note.wait_for(timeout=STARTS)
    cockpit.tab.keyboard.up("ArrowUp")
    cockpit.wait(0.3)
    assert "85 %" in note.inner_text() and coloured(cockpit, SHADE, ".chart canvas") > 50
    left, top, right, bottom = box(cockpit, ".chart .u-over >> nth=0")
    cockpit.tab.keyboard.press("p")
    cockpit.tab.mouse.move(left + 0.05 * (right - left), 0.5 * (top + bottom))
    times = cockpit.tab.locator(".cursor-time")
    cockpit.until(lambda: times.first.inner_text())
    told = times.all_inner_texts()
    assert len(told) == 3 and len(set(told)) == 1 and 0.5 < float(told[0].split()[0]) < 1.5, told
    charts.nth(1).locator("button").click()
    assert charts.count() == 2


def test_an_earlier_drive_is_a_ghost_to_race_against(cockpit):
    ghost = cockpit.tab.locator("label", has_text="Show as a ghost").locator("select")
    ghost.select_option("last")
    hold(cockpit, "ArrowLeft", 1.5)
    cockpit.comes_to_rest()
    reached = cockpit.tip
    assert coloured(cockpit, GHOST) == 0, "there is no earlier drive yet"
    cockpit.begins_anew(lambda: cockpit.tab.locator("#reset").click())
    cockpit.until(lambda: coloured(cockpit, GHOST) > 30)
    waiting = coloured(cockpit, GHOST)
    # It starts with the first motion; then it goes where that drive went.
    hold(cockpit, "ArrowUp", 0.4)
    cockpit.wait(2)
    assert coloured(cockpit, GHOST) > 30 and np.abs(cockpit.tip - reached).max() > 0.05 and waiting
    ghost.select_option("none")
    cockpit.until(lambda: coloured(cockpit, GHOST) == 0)


def test_buttons_of_every_gamepad_can_be_assigned(browser, address):
    with Page(browser, address, PAD) as page:

        def press(pad, button):
            page.tab.evaluate("([pad, button]) => window.press(pad, button, true)", [pad, button])
            page.wait(0.3)
            page.tab.evaluate("([pad, button]) => window.press(pad, button, false)", [pad, button])
            page.wait(0.2)

        press(1, 0)
        assert "No log within reach" in page.notices(), "the first button of any gamepad grips"
        page.tab.locator(".notice button").first.click()
        page.tab.locator("summary", has_text="Gamepad").click()
        rows = page.tab.locator(".axis-row")
        grip = rows.filter(has_text="Grip or let go")
        grip.locator("button").click()
        assert "Press it" in grip.locator("button").inner_text()
        press(1, 5)
        page.until(lambda: "two: button 6" in grip.locator("select").evaluate("(it) => it.selectedOptions[0].text"))
        page.tab.locator(".notice").evaluate_all("(all) => all.forEach((it) => it.remove())")
        press(1, 0)
        press(0, 5)
        assert not page.notices(), "neither the old button nor that of another gamepad"
        press(1, 5)
        assert "No log within reach" in page.notices()
        # An axis by moving it: that way is up.
        up = rows.filter(has_text="Tip, up and down")
        up.locator("button").click()
        page.tab.evaluate("() => (window.pads[1].axes[3] = 1)")
        page.until(lambda: "two: axis 4" in up.locator("select").evaluate("(it) => it.selectedOptions[0].text"))
        start = page.tip
        page.until(lambda: page.tip[1] > start[1] + 0.05)
        # Slow while held, told by the speed; pause and reset.
        page.tab.evaluate("() => window.press(0, 1, true)")
        page.until(lambda: 0.02 < page.shown("speed")[0] < 0.05)
        page.tab.evaluate("() => { window.pads[1].axes[3] = 0; window.press(0, 1, false); }")
        press(0, 9)
        assert "paused" in page.tab.locator("#pace").inner_text()
        press(0, 8)
        page.until(lambda: page.shown("time")[0] < 3 and "paused" not in page.tab.locator("#pace").inner_text())
        press(0, 3)
        page.tab.locator(".lever").first.wait_for(timeout=STARTS)
        page.tab.reload()
        page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
        page.tab.locator("summary", has_text="Gamepad").click()
        assert "two: button 6" in grip.locator("select").evaluate("(it) => it.selectedOptions[0].text")
        assert not page.complaints
