"""The largest gain of the damping, docs/theory/control/damping.md: one mode, its observer and a late command, sampled.

The period is the unit of time; the mode turns by ``angle`` in it. The laws are those of
``crates/control/src/damping.rs``, written a second time.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[3] / "docs" / "theory" / "control" / "damping.md"
# Delay of the valve that the law knows, in periods.
VALVE = 0.2
GAINS = np.arange(0.005, 1.5, 0.005)


def given(angle: float) -> float:
    """c of the law."""
    return min(0.2, 0.25 * (1.3 - angle))


def turned(angle: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """(s, r/omega) after a mode has turned by `angle`, and what a steady speed of the valves adds."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return turn, (np.eye(2) - turn) @ [0.0, 1.0 / speed]


def radius(angle: float, gain: float, late: float, faster: float = 0.0) -> float:
    """Largest eigenvalue of the loop per period; `late`: delay that the law does not know, in periods."""
    omega = angle * (1.0 + faster)
    whole, part = divmod(late + VALVE, 1.0)
    whole = int(whole)
    before, from_older = turned(omega * part, omega)
    after, from_newer = turned(omega * (1.0 - part), omega)
    turn = np.exp(1j * angle)
    fast, slow = np.exp(-min(1.5 * angle, max(0.3, 0.8 * angle))), np.exp(-2.5 * angle)
    correction = 2 * (turn - fast) ** 2 * (turn - slow) / (turn * 2j * turn.imag * (turn - 1))
    of_offset = (1 - fast) ** 2 * (1 - slow) / abs(turn - 1) ** 2

    def step(x: np.ndarray) -> np.ndarray:
        plant, seen, offset, past = x[:2], x[2] + 1j * x[3], x[4], x[5:]
        middle = -1j * past[0] / angle
        predicted = turn * (seen - middle) + middle
        innovation = plant[0] - predicted.real - offset
        seen, offset = predicted + correction * innovation, offset + of_offset * innovation
        speed = gain * (np.exp(1j * angle * (0.5 + VALVE)) * seen).real
        sent = np.array([speed, *past])
        plant = after @ (before @ plant + from_older * sent[whole + 1]) + from_newer * sent[whole]
        return np.array([*plant, seen.real, seen.imag, offset, *sent[: whole + 1]])

    loop = np.column_stack([step(x) for x in np.eye(6 + whole)])
    return float(np.abs(np.linalg.eigvals(loop)).max())


def largest(angle: float, late: float, faster: float = 0.0) -> float:
    """Largest gain of ``GAINS`` up to which the loop is stable, zero if there is none."""
    stable = [radius(angle, gain, late, faster) < 1.0 + 1e-9 for gain in GAINS]
    return float(GAINS[-1] if all(stable) else GAINS[max(stable.index(False) - 1, 0)] if stable[0] else 0.0)


def rows() -> list[list[str]]:
    text = PAGE.read_text(encoding="utf-8")
    table = text[text.index("half a period late") : text.index("**One direction.**")]
    return [re.split(r" *\| *", line.strip("| ")) for line in table.splitlines()[2:] if line.startswith("|")]


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_the_page_shows_the_stable_gains(row: list[str]) -> None:
    angle = float(row[0])
    found = [largest(angle, late, faster) for late, faster in ((0, 0), (0.5, 0), (1, 0), (1, 0.1))]
    for shown, gain in zip(row[1:5], found, strict=True):
        if shown.startswith(">"):
            assert gain == GAINS[-1]
        else:
            assert float(shown) == pytest.approx(gain, abs=0.0051)
    assert float(row[5]) == pytest.approx(max(given(angle), 0.0), abs=0.0051)


def test_the_gain_leaves_half_of_the_margin_and_damps() -> None:
    for angle in np.arange(0.05, 1.2, 0.05):
        gain = min(0.8 * angle, given(angle))
        assert gain <= 0.5 * largest(angle, 1.0, 0.1) + 1e-9, angle
        # The amplitude falls by half the gain; it still falls where the command is late by half a period.
        assert radius(angle, gain, 0.0) < 1.0 - 0.4 * gain
        assert radius(angle, gain, 0.5) < 1.0
