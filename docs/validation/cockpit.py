"""How the cockpit keeps time, in a headless browser; writes docs/validation/cockpit.md.

Needs the built page (`make cockpit`), playwright, Chromium and Node.js. Takes as long as it drives: 300 s, or as many
as the first argument says.
"""

from __future__ import annotations

import gzip
import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/python"))

from browser import chromium, hosted, served  # noqa: E402

from hydrocrane.app.serving.live_server import PAGE as BUILT  # noqa: E402
from hydrocrane.app.serving.live_server import page_files  # noqa: E402

PAGE = Path(__file__).with_name("cockpit.md")
# Milliseconds from a key to the first drawn picture that differs, with the crane at rest before.
LATENCY = """async () => {
  const canvas = document.getElementById("picture");
  const seen = () => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) sum = (sum * 31 + data[i] + 7 * data[i + 2]) | 0;
    return sum;
  };
  const frame = () => new Promise(requestAnimationFrame);
  await frame();
  const before = seen();
  const key = (kind) => document.body.dispatchEvent(new KeyboardEvent(kind, { code: "ArrowUp", bubbles: true }));
  const began = performance.now();
  key("keydown");
  let taken = NaN;
  while (performance.now() - began < 2000) {
    await frame();
    if (seen() !== before) { taken = performance.now() - began; break; }
  }
  key("keyup");
  return taken;
}"""
FRAMES = "() => { window.drawn = 0; const count = () => { window.drawn++; requestAnimationFrame(count); }; count(); }"


def weight(paths: Iterable[Path]) -> str:
    """MB of files, plain and compressed."""
    files = [path.read_bytes() for path in paths]
    plain, packed = sum(map(len, files)), sum(len(gzip.compress(f, 9)) for f in files)
    return f"{plain / 1e6:.2f} MB, compressed {packed / 1e6:.2f} MB"


def simulated(tab: Any) -> float:
    return float(re.search(r"time\s+([\d.]+)", tab.locator("#readout").inner_text())[1])


def drive(tab: Any, seconds: float) -> dict[str, float]:
    """Move the tip up and down for so long; how simulated and wall time compare."""
    tab.evaluate(FRAMES)
    drawn, began, first = tab.evaluate("window.drawn"), time.monotonic(), simulated(tab)
    loads = []
    for part in range(10**9):
        key = ("ArrowUp", "ArrowDown")[part % 2]
        tab.keyboard.down(key)
        tab.wait_for_timeout(1500)
        tab.keyboard.up(key)
        loads.append(float(re.search(r"takes (\d+) %", tab.locator("#pace").get_attribute("title"))[1]))
        if time.monotonic() - began > seconds:
            break
    wall = time.monotonic() - began
    lost = re.search(r"([\d.]+) s lost", tab.locator("#pace").inner_text())
    return {
        "wall": wall,
        "simulated": simulated(tab) - first,
        "lost": float(lost[1]) if lost else 0.0,
        "frames": (tab.evaluate("window.drawn") - drawn) / wall,
        "load": float(np.mean(loads)),
    }


def measure(seconds: float) -> dict[str, Any]:
    with served("rottne-f9-lab") as address, chromium() as browser:
        tab = browser.new_page(viewport={"width": 1400, "height": 850})
        errors: list[Exception] = []
        tab.on("pageerror", lambda error: errors.append(error))
        began = time.monotonic()
        tab.goto(address)
        while "tip" not in tab.locator("#readout").inner_text():
            tab.wait_for_timeout(5)
        loading = time.monotonic() - began
        tab.wait_for_timeout(3000)
        latencies = []
        for _ in range(20):
            latencies.append(tab.evaluate(LATENCY))
            # Back at the start, where the picture stands still.
            tab.locator("#reset").click()
            tab.wait_for_timeout(1500)
        found = drive(tab, seconds)
        tab.close()
        if errors:
            raise errors[0]
        offline = loading_offline(browser)
        return {
            "loading": loading,
            "offline": offline,
            "latencies": np.array(latencies),
            "browser": browser.version,
            **found,
        }


def loading_offline(browser: Any) -> float:
    """Seconds to the first picture of a page visited before, without a network."""
    with hosted(page_files()) as server:
        context = browser.new_context(viewport={"width": 1400, "height": 850})
        tab = context.new_page()
        tab.goto(server.address)
        while not tab.evaluate("navigator.serviceWorker.controller !== null"):
            tab.wait_for_timeout(50)
        context.set_offline(True)
        began = time.monotonic()
        tab.goto(server.address)
        while "tip" not in tab.locator("#readout").inner_text():
            tab.wait_for_timeout(5)
        return time.monotonic() - began


def soaked() -> dict[str, str]:
    """Half an hour of driving the core in Node: speed, memory, jumps."""
    core = next((BUILT / "assets").glob("core-*.wasm"))
    done = subprocess.run(
        ["node", ROOT / "cockpit/tests/soak.mjs", core, "30"], capture_output=True, text=True, check=True
    )
    times_real = float(re.search(r"([\d.]+) times real time", done.stdout)[1])
    speed, memory, way = (line.partition(": ")[2] for line in done.stdout.splitlines())
    sizes = memory.split()
    return {
        "30 min of driving in Node, without a page": speed,
        "a step of 1 ms there": f"{1000 / times_real:.1f} us",
        "memory of the core after 1, 10 and 30 min": f"{sizes[0]}, {sizes[9]}, {sizes[-1]} MiB",
        "largest travel of the tip in 1 ms": way.replace(" per ms", ""),
    }


def page(found: dict[str, Any]) -> str:
    files = [path for path in BUILT.rglob("*") if path.is_file()]
    cores = {name: [path for path in files if path.match(f"{name}-*.wasm")] for name in ("core", "chains")}
    low, mid, high = np.nanpercentile(found["latencies"], [0, 50, 100])
    rows = {
        "wall time": f"{found['wall']:.1f} s",
        "simulated time": f"{found['simulated']:.1f} s",
        "time given up (1 ms steps missed)": f"{found['lost']:.1f} s",
        "computing, share of one core": f"{found['load']:.0f} %",
        "frames drawn": f"{found['frames']:.0f} per second",
        "key to first changed picture": f"{mid:.0f} ms in the middle, {low:.0f} to {high:.0f} ms",
        "load time, address to first picture": f"{found['loading']:.2f} s",
        "weight of the page": weight(path for path in files if path not in cores["chains"]),
        "of it the compiled core": weight(cores["core"]),
        "the second core, fetched for chains of other than one or three joints": weight(cores["chains"]),
        "load time without a network, from the browser's own files": f"{found['offline']:.2f} s",
        **soaked(),
    }
    browser = f"headless Chromium {found['browser'].split('.')[0]}"
    machine = f"{os.cpu_count()} cores of a shared {platform.machine()} machine"
    table = "\n".join(f"| {name} | {value} |" for name, value in rows.items())
    return f"""# The cockpit, in numbers

The laboratory crane in mode `tip`, driven up and down by keyboard in {browser}, which draws without a
graphics processor, on {machine}. A step is 1 ms and carries the whole model,
controller and energy ledger. Written by `docs/validation/cockpit.py`; times depend on the machine and what else it
does.

| what | measured |
|---|---|
{table}

A key passes the page, the next sample of the controller (10 ms), the next message of the simulation (15 ms) and the
next frame before it is visible; the response time of the crane itself is not included.

The computed motion does not depend on any of this: a saved drive of 60 s, with changes of mode, supply, friction,
sensors and load on the way, is repeated by the native core to the same tip within 1e-9 m
(`tests/python/cockpit/test_cockpit.py`).
"""


if __name__ == "__main__":
    PAGE.write_text(page(measure(float(sys.argv[1]) if len(sys.argv) > 1 else 300.0)), encoding="utf-8")
