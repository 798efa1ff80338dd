"""Draw the pictures of the documentation: ``python docs/pictures/make.py``.

Those of the front page are drawn here; a tutorial draws its own, here or by running the page.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import drive_the_tip  # noqa: E402
import machine_file  # noqa: E402

import hydrocrane as hc  # noqa: E402
from hydrocrane.plots.style import write  # noqa: E402

FOLDER = Path(__file__).parent
PAGES = (FOLDER.parent / "tutorials" / "friction.md", FOLDER.parent / "gallery.md")


def front_page() -> None:
    run = hc.simulate("vertical-lift-open-loop")
    run.animate(FOLDER / "lift.gif", fps=10, speed=1.5)
    run.plot("lift", path=FOLDER / "lift.png")


def excavator() -> None:
    hc.simulate("excavator-swing").animate(FOLDER / "excavator.gif", fps=10, speed=1.5)


def of_how_to() -> None:
    write(hc.plots.circuit(hc.load_machine("rottne-f9-mobile")), FOLDER / "circuit.png")


def of_page(page: Path) -> None:
    """Run the Python of a page in an empty folder and keep the pictures that it draws and shows."""
    text = page.read_text(encoding="utf-8")
    code = "\n".join(re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE))
    shown = re.findall(r"\]\((?:\.\./)?pictures/([\w-]+\.png)\)", text)
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            exec(compile(code, page.name, "exec"), {"__name__": "page"})
            for name in shown:
                if Path(name).exists():
                    shutil.copy(name, FOLDER / name)
        finally:
            os.chdir(here)


if __name__ == "__main__":
    front_page()
    excavator()
    of_how_to()
    drive_the_tip.draw_all(FOLDER)
    machine_file.draw_all(FOLDER)
    for page in PAGES:
        of_page(page)
