"""Pictures of the cockpit: ``python docs/pictures/cockpit.py``. Needs what its browser tests need."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Any

from PIL import Image

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parents[1] / "tests/python"))

from browser import chromium, served  # noqa: E402

FRAMES, PAUSE = 32, 120


def hold(tab: Any, seconds: float, *keys: str) -> None:
    for key in keys:
        tab.keyboard.down(key)
    tab.wait_for_timeout(1000 * seconds)
    for key in keys:
        tab.keyboard.up(key)


def ready(browser: Any, address: str, **about: Any) -> Any:
    tab = browser.new_page(viewport={"width": 1400, "height": 850}, **about)
    tab.goto(address)
    tab.locator(".stick").first.wait_for()
    tab.wait_for_timeout(1500)
    return tab


def film(tab: Any) -> list[Image.Image]:
    """The crane takes a log up, over and down."""
    frames = []
    moves = [("ArrowUp",), ("ArrowLeft",), ("ArrowDown",), ("ArrowRight",)]
    tab.locator("button", has_text="Start loaded").click()
    tab.wait_for_timeout(500)
    for keys in moves:
        for key in keys:
            tab.keyboard.down(key)
        for _ in range(FRAMES // len(moves)):
            tab.wait_for_timeout(PAUSE)
            shot = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
            frames.append(shot.resize((840, 510), Image.Resampling.LANCZOS).quantize(160, Image.Quantize.FASTOCTREE))
        for key in keys:
            tab.keyboard.up(key)
    return frames


def logs(tab: Any) -> None:
    """The innermost log on its way from the ground."""
    tab.locator("label", has_text="Choose a task").locator("select").select_option("logs")
    tab.wait_for_timeout(1500)
    hold(tab, 2.1, "ArrowDown")
    hold(tab, 1.2, "ArrowLeft")
    tab.wait_for_timeout(400)
    tab.keyboard.press("Space")
    tab.wait_for_timeout(300)
    tab.keyboard.down("ArrowUp")
    tab.wait_for_timeout(1900)
    tab.keyboard.down("ArrowLeft")
    tab.wait_for_timeout(700)


def main() -> None:
    with served("rottne-f9-lab") as address, chromium() as browser:
        tab = ready(browser, address)
        tab.locator("button", has_text="Start loaded").click()
        tab.wait_for_timeout(500)
        hold(tab, 2.0, "ArrowUp", "ArrowRight")
        for key in ("ArrowUp", "ArrowLeft"):
            tab.keyboard.down(key)
        tab.wait_for_timeout(7000)
        tab.screenshot(path=FOLDER / "cockpit.png")
        tab.close()
        tab = ready(browser, address, color_scheme="dark")
        tab.keyboard.press("2")
        tab.locator(".lever").first.wait_for()
        hold(tab, 1.5, "KeyQ", "KeyS")
        tab.keyboard.down("KeyE")
        tab.wait_for_timeout(2000)
        tab.screenshot(path=FOLDER / "cockpit-lever.png")
        tab.close()
        tab = ready(browser, address)
        logs(tab)
        tab.screenshot(path=FOLDER / "cockpit-logs.png")
        tab.close()
        frames = film(ready(browser, address))
        frames[0].save(FOLDER / "cockpit.gif", save_all=True, append_images=frames[1:], duration=2 * PAUSE, loop=0)


if __name__ == "__main__":
    main()
