"""A tab of a browser with a cockpit, for tests and for driving it."""

from __future__ import annotations

import csv
import io
import re
import time
from pathlib import Path

import numpy as np

# Pictures to be looked at.
PICTURES = Path(__file__).resolve().parents[2] / "results/cockpit"

# A drive as the page saves it: the tip of the laboratory crane goes up.
DRIVE = """
[scenario]
name = "up"
machine = "rottne-f9-lab"
duration = "30 s"
[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0 mm"
[joystick]
time = ["0.1 s"]
z = [1]
full-speed = "0.1 m/s"
"""

# Longest that anything in a page takes, ms.
STARTS = 20_000


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

    def begins_anew(self, act):
        """What `act` does leads back to the start. The clock goes slowly meanwhile, so that a busy machine sees it."""
        self.until(lambda: self.shown("time")[0] > 1)
        self.tab.locator("#speed").select_option("0.1")
        act()
        self.until(lambda: self.shown("time")[0] < 1)
        self.tab.locator("#speed").select_option("1")

    def comes_to_rest(self):
        self.until(lambda: self.shown("speed")[0] < 0.005)

    def download(self, text):
        with self.tab.expect_download() as waiting:
            self.button(text).click()
        return waiting.value.path().read_text(encoding="utf-8")


def hold(page, key, seconds):
    page.tab.keyboard.down(key)
    page.wait(seconds)
    page.tab.keyboard.up(key)


def table(text):
    """A CSV file by column."""
    head, *rows = csv.reader(io.StringIO(text))
    return {name.split(" [")[0]: np.array(column, dtype=float) for name, column in zip(head, zip(*rows))}
