"""What files and links can do to the page: pictures without end, bombs, a simulation that hangs, pasted links."""

from __future__ import annotations

import base64
import json
import zlib

import pytest
from browser import served
from cockpit_tab import DRIVE, STARTS, Page

# Changes what the worker tells of a machine, before the page sees it.
TOLD = """
window.Worker = class extends window.Worker {
  set onmessage(act) {
    super.onmessage = (event) => {
      if (event.data.tell === "opened") (%s)(event.data.description);
      act(event);
    };
  }
};
"""
OUTLINE = "(it) => it['keep-out'].push({ name: 'x', corners: %s })"
REACH = "(it) => it.workspace.forEach((line) => line.forEach((p) => { p[0] *= %s; p[1] *= %s; }))"
OUTLINES = {
    "large": OUTLINE % "[[-1e6, -1e6], [1e6, -1e6], [1e6, 1e6], [-1e6, 1e6]]",
    "beyond floats": OUTLINE % "[[-1e300, 0], [1e300, 0], [1e300, 1e300]]",
    "many corners": OUTLINE % "Array.from({ length: 3e5 }, (_, i) => [i, i % 7])",
    "none": OUTLINE % "[]",
    "far tip": REACH % ("1e6", "1e6"),
    "tip beyond floats": REACH % ("1e305", "1e305"),
}
TEN_FRAMES = """() => new Promise((tell) => {
  let frames = 0;
  const count = () => (frames++ < 9 ? requestAnimationFrame(count) : tell(frames));
  count();
})"""
# The second machine that a worker is asked for never comes.
HANGS = """
const plain = WebAssembly.instantiate;
let opened = 0;
WebAssembly.instantiate = async (...given) => {
  const core = (await plain(...given)).instance.exports;
  const open = () => { while (++opened > 1); return core.open(); };
  return { instance: { exports: { ...core, open } } };
};
"""


def link(address, text):
    """The address that replays a scenario."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = packer.compress(text if isinstance(text, bytes) else text.encode()) + packer.flush()
    return f"{address.split('?')[0]}#drive={base64.urlsafe_b64encode(packed).decode().rstrip('=')}"


def answers(page):
    """Whether the page draws and the drive goes on."""
    then = page.shown("time")[0]
    frames = page.tab.evaluate(TEN_FRAMES)
    page.until(lambda: page.shown("time")[0] > then)
    return frames == 10


@pytest.mark.parametrize("outline", OUTLINES)
def test_a_picture_takes_bounded_work_whatever_a_machine_states(browser, address, outline):
    with Page(browser, address, TOLD % OUTLINES[outline]) as page:
        assert answers(page)
        page.tab.locator("label", has_text="Choose a task").locator("select").select_option("line")
        page.tab.locator("#view-buttons button").first.click()
        assert answers(page) and not page.complaints


@pytest.mark.parametrize("kind", ["long", "unpacks to much"])
def test_a_link_of_more_than_any_drive_is_refused(cockpit, kind):
    bomb = "drive=" + "A" * 500_000 if kind == "long" else link("", b"#" * 100_000_000)[1:]
    cockpit.tab.evaluate("(hash) => (location.hash = hash)", bomb)
    cockpit.until(lambda: "longer than any drive that can be shared" in cockpit.notices())
    assert "scenario file" in cockpit.notices() and answers(cockpit)


def test_a_link_that_is_pasted_into_the_open_page_is_replayed(cockpit, address):
    cockpit.tab.evaluate("(hash) => (location.hash = hash)", link(address, DRIVE).partition("#")[2])
    cockpit.until(lambda: "replay until 30.0 s" in cockpit.tab.locator("#pace").inner_text())
    cockpit.tab.evaluate("() => (location.hash = 'drive=AAAA')")
    cockpit.until(lambda: "was it cut short" in cockpit.notices())


def test_a_link_with_a_machine_of_its_own_is_replayed_too(browser, address):
    own = {"mine.toml": 'extends = "rottne-f9-lab"\n'}
    both = {"scenario": DRIVE.replace("rottne-f9-lab", "./mine.toml"), "files": own}
    with Page(browser, link(address, json.dumps(both))) as page:
        assert "replay" in page.tab.locator("#pace").inner_text() and not page.complaints


def test_a_link_to_this_computer_says_so(cockpit):
    cockpit.wait(0.3)
    cockpit.button("Link").click()
    cockpit.until(lambda: "replays the drive" in cockpit.notices())
    assert "while this program runs" in cockpit.notices() and "save the scenario" in cockpit.notices()


def test_a_simulation_that_hangs_is_ended_and_the_usual_crane_takes_its_place(browser):
    def hanging(route):
        answer = route.fetch()
        route.fulfill(response=answer, body=HANGS + answer.text())

    with served() as address, Page(browser, address) as page:
        page.context.route("**/worker-*.js", hanging)
        page.tab.reload()
        page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
        page.tab.locator("label", has_text="Crane").locator("select").select_option("hiab-xs031")
        notice = page.tab.locator(".notice.error")
        notice.wait_for(timeout=STARTS)
        assert "has not answered for 8 s" in notice.inner_text() and "default crane" in notice.inner_text()
        page.until(lambda: page.tab.title().startswith("rottne-f9-lab") and page.shown("time")[0] < 3)
        assert answers(page) and not page.complaints
