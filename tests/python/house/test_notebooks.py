"""The notebooks of the documentation run from top to bottom."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[3] / "docs" / "notebooks"
# The last line of a cell that gives a figure back.
DRAWS = re.compile(r"(\w+\.)*plots?[.(]")
NOTEBOOKS = sorted(path for path in FOLDER.glob("*.md") if path.name != "README.md")


def test_there_are_notebooks_and_their_list_names_them():
    listed = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) >= 6 and all(f"]({path.name})" in listed for path in NOTEBOOKS)


@pytest.mark.evidence
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path):
    """In a kernel of its own; a cell that ends with a figure shows it, once."""
    jupytext = pytest.importorskip("jupytext", reason="the extra `docs` is not installed")
    nbclient = pytest.importorskip("nbclient", reason="the extra `docs` is not installed")
    if path.stem == "train-a-policy":
        pytest.importorskip("stable_baselines3", reason="the extra `rl` is not installed")
    notebook = jupytext.read(path)
    where = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources=where).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(cells) >= 3
    for cell in cells:
        pictures = sum("image/png" in output.get("data", {}) for output in cell.outputs)
        assert pictures == bool(DRAWS.match(cell.source.splitlines()[-1])), cell.source
