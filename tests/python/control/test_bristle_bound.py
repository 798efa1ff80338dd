"""What a valve that acts like a leak can damp beside bristles: the table of ``docs/theory/control/regulate.md``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).resolve().parents[3] / "docs" / "theory" / "control" / "regulate.md"
RATIOS = (0.25, 0.4, 0.6)


def added(beta: float, ratio: float) -> float:
    """Damping ratio of a mode of frequency 1 on its oil, beside bristles `beta` times as stiff as the oil."""
    leak = 2.0 * ratio
    roots = np.roots([1.0, leak, 1.0 + beta, beta * leak])
    swinging = roots[np.abs(roots.imag) > 1e-9]
    return float(np.max(-swinging.real / np.abs(swinging))) if swinging.size else 1.0


def most(beta: float) -> float:
    """The bound of the page."""
    return 0.5 * (np.sqrt(1.0 + 1.0 / beta) - 1.0)


def stated() -> dict[float, list[str]]:
    """Cells of the page's table by stiffness of the bristles."""
    rows = [line.strip().strip("|").split("|") for line in PAGE.read_text(encoding="utf-8").splitlines()]
    cells = [[cell.strip() for cell in row] for row in rows]
    return {float(row[0]): row[1:] for row in cells if len(row) == 5 and row[0].replace(".", "").isdigit()}


def test_the_table_gives_the_roots() -> None:
    table = stated()
    assert len(table) == 5
    for beta, cells in table.items():
        assert cells[:3] == [f"{added(beta, ratio):.2f}" for ratio in RATIOS]
        assert cells[3] == (f"{most(beta):.2f}" if beta else "-")


@pytest.mark.parametrize("beta", [0.6, 1.2, 1.4, 2.4])
def test_no_gain_adds_more_than_the_bound(beta: float) -> None:
    best = max(added(beta, ratio) for ratio in np.linspace(0.05, 5.0, 1000))
    assert 0.999 * most(beta) < best < most(beta) * (1.0 + 1e-9)
