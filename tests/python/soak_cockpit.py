"""Half an hour in the cockpit, in a real browser: python tests/python/soak_cockpit.py [MINUTES]

Somebody drives by keyboard, changes modes, starts with loads and drops them, and saves. Tells how the page keeps
time, whether its memory grows after the first minutes, and whether the tip ever leaps. Ends with 1 where something is
wrong.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
from browser import NoBrowser, chromium, served
from cockpit_tab import Page

from hydrocrane.errors import InputError

# Farthest that a tip gets from where its velocity takes it between two rows of 10 ms, m: it rings while valves close.
LEAP = 3e-3
# Growth of memory after the first minutes that is none, MiB.
NOISE = 2.0
# Share of the time after which memory has settled.
WARM = 0.3
# Sees the rows of the charts, one per 10 ms, on their way into the page.
WATCH = """
window.seen = { rows: 0, leap: 0, at: 0, speed: 0, gaps: 0, lost: 0, frames: 0, load: 0 };
window.Worker = class extends window.Worker {
  constructor(...given) {
    super(...given);
    let [places, last] = [null, null];
    this.addEventListener("message", ({ data }) => {
      const seen = window.seen;
      if (data.tell === "opened") {
        const names = data.description.signals.map(({ name }) => name);
        places = ["time", "tip.x", "tip.z", "tip.vx", "tip.vz"].map((name) => names.indexOf(name));
        if (data.fresh) last = null;
      }
      if (data.tell !== "rows" || !places) return;
      [seen.lost, seen.load] = [data.pace.lost, data.pace.load];
      for (let at = 0; at < data.history.length; at += data.width) {
        const [t, x, z, vx, vz] = places.map((place) => data.history[at + place]);
        const speed = Math.hypot(vx, vz);
        if (last && t > last.t) {
          const leap = Math.hypot(x - last.x, z - last.z) - Math.max(speed, last.speed) * (t - last.t);
          if (leap > seen.leap) [seen.leap, seen.at] = [leap, t];
          if (t - last.t > 0.0101) seen.gaps++;
        }
        seen.speed = Math.max(seen.speed, speed);
        seen.rows++;
        last = { t, x, z, speed };
      }
    });
  }
};
const count = () => { window.seen.frames++; requestAnimationFrame(count); };
requestAnimationFrame(count);
"""
# Before the worker's own text: its core's memory can be asked for.
TELL_MEMORY = """
const plain = WebAssembly.instantiate;
WebAssembly.instantiate = async (...given) => {
  const made = await plain(...given);
  self.cores = [...(self.cores ?? []), made.instance.exports.memory];
  return made;
};
"""
MEMORY = "self.cores.reduce((sum, memory) => sum + memory.buffer.byteLength, 0)"
KEYS = {
    "tip": ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"],
    "lever": ["KeyQ", "KeyA", "KeyW", "KeyS", "KeyE", "KeyD"],
}


def memory(page: Page, session: Any) -> tuple[float, float]:
    """MiB of the page's objects that are in use, and of the core."""
    session.send("HeapProfiler.collectGarbage")
    counters = {entry["name"]: entry["value"] for entry in session.send("Performance.getMetrics")["metrics"]}
    core = sum(worker.evaluate(MEMORY) for worker in page.tab.workers if "worker-" in worker.url)
    return counters["JSHeapUsedSize"] / 2**20, core / 2**20


def drive(page: Page, draws: np.random.Generator, part: int) -> None:
    """About ten seconds of somebody at the keys."""
    tab = page.tab
    mode = "lever" if part % 5 == 3 else "tip"
    tab.keyboard.press("2" if mode == "lever" else "1")
    for _ in range(6):
        keys = draws.choice(KEYS[mode], size=draws.integers(1, 3), replace=False)
        for key in keys:
            tab.keyboard.down(key)
        page.wait(float(draws.uniform(0.3, 1.8)))
        for key in keys:
            tab.keyboard.up(key)
        page.wait(float(draws.uniform(0.1, 0.8)))
    if part % 4 == 1:
        page.button("Start loaded").click()
    elif part % 4 == 3:
        tab.keyboard.press("Space")
    if part % 6 == 5:
        page.download("Save")
    if part % 12 == 11:
        tab.locator("#reset").click()


def soak(page: Page, minutes: float) -> int:
    session = page.context.new_cdp_session(page.tab)
    session.send("Performance.enable")
    draws = np.random.default_rng(1)
    began, part = time.monotonic(), 0
    taken: list[tuple[float, float, float]] = []
    while (passed := time.monotonic() - began) < 60 * minutes:
        drive(page, draws, part)
        part += 1
        taken.append((passed / 60, *memory(page, session)))
    wall = time.monotonic() - began
    seen = page.tab.evaluate("window.seen")
    settled = next(entry for entry in taken if entry[0] >= WARM * minutes)
    growth = [last - first for first, last in zip(settled[1:], taken[-1][1:], strict=True)]
    print(f"{wall / 60:.1f} min, {seen['rows'] / 100 / 60:.1f} min of them simulated, {part} turns of driving")
    print(f"time given up: {seen['lost']:.1f} s; {seen['frames'] / wall:.0f} frames per second; gaps: {seen['gaps']}")
    print(f"computing at the end: {100 * seen['load']:.0f} % of one core")
    print(f"page {settled[1]:.1f} -> {taken[-1][1]:.1f} MiB, core {settled[2]:.1f} -> {taken[-1][2]:.1f} MiB")
    print(f"largest leap of the tip: {1e3 * seen['leap']:.3f} mm in 10 ms, at {seen['at']:.2f} s")
    wrong = [f"memory grows by {size:.1f} MiB" for size in growth if size > NOISE]
    wrong += [f"the tip leaps by {1e3 * seen['leap']:.1f} mm"] if seen["leap"] > LEAP else []
    wrong += [f"{seen['gaps']} gaps between rows"] if seen["gaps"] else []
    wrong += page.complaints
    for text in wrong:
        print(f"wrong: {text}")
    return 1 if wrong or not seen["rows"] else 0


def main(minutes: float) -> int:
    def telling(route: Any) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, body=TELL_MEMORY + answer.text())

    try:
        # Where a drive was chosen, the browser keeps no files of its own.
        with chromium() as browser, served("rottne-f9-lab") as address, Page(browser, address, WATCH) as page:
            page.context.route("**/worker-*.js", telling)
            page.tab.reload()
            page.until(lambda: "tip" in page.tab.locator("#readout").inner_text())
            return soak(page, minutes)
    except (NoBrowser, InputError) as reason:
        print(f"not driven in a browser: {reason}")
        return 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 30.0))
