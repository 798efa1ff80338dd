"""The largest gain of the damping, docs/theory/control/regulate.md: one mode, its observer and a late command, sampled.

The period is the unit of time; the mode turns by ``angle`` in it. The laws are those of
``crates/control/src/regulate/damping.rs``, written a second time.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[3] / "docs" / "theory" / "control" / "regulate.md"
# Valves: dead time, natural frequency per period, damping ratio. A dead time of a fifth of a period alone, and those
# of the page at 10 ms.
FAST = (0.2, np.inf, 1.0)
SLOW = {
    "15 Hz": (0.0, 0.3 * np.pi, 0.8),
    "10 ms, 12 Hz": (1.0, 0.24 * np.pi, 0.8),
    "25 ms, 8 Hz": (2.5, 0.16 * np.pi, 0.8),
    "50 ms, 5 Hz": (5.0, 0.1 * np.pi, 0.8),
    "200 ms": (20.0, np.inf, 1.0),
}
GAINS = np.arange(0.005, 1.5, 0.005)
# The promise: commands may be so many periods later than the law knows, of modes up to this share faster or slower.
LATE, DOUBT = (0.0, 1.0, 2.0), (-0.1, 0.0, 0.1)


def behind(angle: float, valve: tuple[float, float, float]) -> float:
    """Phase by which a steady oscillation lags behind the valve, rad."""
    delay, frequency, ratio = valve
    x = angle / frequency
    return delay * angle + float(np.angle(1.0 - x**2 + 2j * ratio * x))


def error(angle: float, shift: float, valve: tuple[float, float, float], faster: float = 0.1) -> float:
    """e of the law."""
    fastest = (1.0 + faster) * angle
    return fastest * (2.0 - shift) + behind(fastest, valve) - behind(angle, valve)


def shifted(angle: float, valve: tuple[float, float, float] = FAST, faster: float = 0.1) -> float:
    """r of the law, in periods."""
    return float(np.clip((error(angle, 0.0, valve, faster) - 0.6) / (angle * (1.0 + faster)), 0.0, 1.0))


def given(angle: float, valve: tuple[float, float, float] = FAST) -> float:
    """Largest gain of the law: c(e)/|U|."""
    shift = shifted(angle, valve)
    passed = abs(following(angle, believed(valve, shift)))
    return max(0.0, min(0.2, 0.3 * (1.2 - error(angle, shift, valve)))) / passed


def shares(valve: tuple[float, float, float], late: float = 0.0) -> np.ndarray:
    """Of a command that holds for a period, what the valve gives in each: means of the step's answer by small steps."""
    delay, frequency, ratio = valve
    fine, most = 200, 60
    time = np.arange(0, most, 1.0 / fine) + 0.5 / fine - delay - late
    after = np.maximum(time, 0.0)
    if np.isfinite(frequency):
        damped = frequency * np.sqrt(1.0 - ratio**2)
        swing = np.cos(damped * after) + ratio * frequency / damped * np.sin(damped * after)
        answer = 1.0 - np.exp(-ratio * frequency * after) * swing
    else:
        answer = 1.0 * (time > 0.0)
    means = answer.reshape(most, fine).mean(axis=1)
    count = int(np.flatnonzero(np.abs(1.0 - means) > 0.01)[-1]) + 2
    return np.diff(np.append([0.0], np.append(means[: count - 1], 1.0)))


def believed(valve: tuple[float, float, float], shift: float) -> np.ndarray:
    """Shares that the law works with: between those of the valve and the same a period later."""
    known = np.append(shares(valve), 0.0)
    return (1.0 - shift) * known + shift * np.roll(known, 1)


def following(angle: float, known: np.ndarray) -> complex:
    """U of the law: what the next command does to a mode, seen back."""
    turn = np.exp(1j * angle)
    return complex((1.0 - 1.0 / turn) / (1j * angle) * (known * turn ** -np.arange(len(known))).sum())


def radius(
    angle: float, gain: float, late: float, faster: float = 0.0, valve: tuple[float, float, float] = FAST
) -> float:
    """Largest eigenvalue of the loop per period; `late`: delay that the law does not know, in periods."""
    known, true = believed(valve, shifted(angle, valve)), shares(valve, late)
    count = max(len(known), len(true))
    known, true = (np.append(h, np.zeros(count - len(h))) for h in (known, true))

    def motion(omega: float) -> tuple[complex, complex]:
        """Turn of z in a period, and what a speed over it adds, seen back at its begin."""
        turn = np.exp(1j * omega)
        return turn, (1.0 - 1.0 / turn) / (1j * omega)

    (turn, push), (true_turn, true_push) = motion(angle), motion(angle * (1.0 + faster))
    fast, slow = np.exp(-min(1.5 * angle, max(0.3, 0.8 * angle))), np.exp(-2.5 * angle)
    correction = 2 * (turn - fast) ** 2 * (turn - slow) / (turn * 2j * turn.imag * (turn - 1))
    of_offset = (1 - fast) ** 2 * (1 - slow) / abs(turn - 1) ** 2
    back = turn ** -np.arange(count)
    # What each command sent so far will still do, and the next one.
    under_way = np.array([push * (known[j + 1 :] * back[: count - j - 1]).sum() for j in range(count)])
    next_one = following(angle, known)

    def step(x: np.ndarray) -> np.ndarray:
        plant, seen, offset, sent = x[0] + 1j * x[1], x[2] + 1j * x[3], x[4], x[5:]
        innovation = plant.real - seen.real - offset
        seen, offset = seen + correction * innovation, offset + of_offset * innovation
        left = seen - (under_way * sent).sum()
        sent = np.append(gain * (left * np.conj(next_one)).real / abs(next_one), sent[:-1])
        plant = true_turn * (plant - true_push * (true * sent).sum())
        seen = turn * (seen - push * (known * sent).sum())
        return np.array([plant.real, plant.imag, seen.real, seen.imag, offset, *sent])

    loop = np.column_stack([step(x) for x in np.eye(5 + count)])
    return float(np.abs(np.linalg.eigvals(loop)).max())


def largest(angle: float, late: float, faster: float = 0.0, valve: tuple[float, float, float] = FAST) -> float:
    """Largest gain of ``GAINS`` up to which the loop is stable, zero if there is none."""
    for before, gain in zip([0.0, *GAINS], GAINS, strict=False):
        if radius(angle, gain, late, faster, valve) > 1.0 + 1e-9:
            return float(before)
    return float(GAINS[-1])


def worst(angle: float, valve: tuple[float, float, float] = FAST) -> float:
    """Largest gain that every delay within the promise and every frequency within the doubt leaves stable."""
    return min(largest(angle, late, faster, valve) for late in LATE for faster in DOUBT)


def tables() -> list[list[list[str]]]:
    """Cells of the rows of both tables of the page: a valve without a lag, slow valves."""
    text = PAGE.read_text(encoding="utf-8")
    parts = text[text.index("two periods late | any") :].split("**Detector.**")[0].split("| valve |")
    return [
        [re.split(r" *\| *", line.strip("| ")) for line in part.splitlines()[2:] if line.startswith("|")]
        for part in parts
    ]


@pytest.mark.parametrize("row", tables()[0], ids=lambda row: row[0])
def test_the_page_shows_the_stable_gains(row: list[str]) -> None:
    angle = float(row[0])
    gains = [largest(angle, late) for late in LATE] + [worst(angle)]
    assert float(row[1]) == pytest.approx(shifted(angle), abs=0.0051)
    for cell, gain in zip(row[2:6], gains, strict=True):
        assert gain == GAINS[-1] if cell.startswith(">") else float(cell) == pytest.approx(gain, abs=0.0051)
    assert float(row[6]) == pytest.approx(given(angle), abs=0.0051)


def falls(angle: float, gain: float, late: float, faster: float, valve: tuple[float, float, float]) -> float:
    """Rate at which the amplitude falls at a period of 10 ms, 1/s."""
    return -100.0 * float(np.log(radius(angle, gain, late, faster, valve)))


def rates(angle: float, valve: tuple[float, float, float]) -> str:
    """What the page shows of a slow valve: the largest gain, and how fast a mode falls on time and at worst."""
    gain = given(angle, valve)
    if gain == 0.0:
        return "0"
    worst_rate = min(falls(angle, gain, late, faster, valve) for late in LATE for faster in DOUBT)
    return f"{gain:.2f}: {falls(angle, gain, 0.0, 0.0, valve):.1f}, {worst_rate:.1f}"


@pytest.mark.parametrize("row", tables()[1], ids=lambda row: row[0])
def test_the_page_shows_how_modes_behind_slow_valves_die_out(row: list[str]) -> None:
    assert row[1:] == [rates(angle, SLOW[row[0]]) for angle in (0.2, 0.4, 0.6, 0.8)]


@pytest.mark.parametrize("name", ["25 ms, 8 Hz", "50 ms, 5 Hz"])
def test_slow_valves_stay_stable_two_periods_late(name: str) -> None:
    for mode in (8.0, 15.0, 25.0, 40.0):
        for gain in (0.02, 0.2, 0.7, 1.5):
            assert all(radius(0.01 * mode, gain, late, 0.1, SLOW[name]) < 1.0 + 1e-9 for late in LATE), mode


@pytest.mark.parametrize("valve", [FAST, *SLOW.values()], ids=["fast", *SLOW])
def test_the_gain_leaves_half_of_the_margin_and_damps(valve: tuple[float, float, float]) -> None:
    for angle in np.arange(0.05, 1.2, 0.05):
        gain = min(0.8 * angle, given(angle, valve))
        for late in (0.0, 0.5, 1.0, 1.5, 2.0):
            for faster in DOUBT:
                assert radius(angle, 2.0 * gain, late, faster, valve) < 1.0 + 1e-9, (angle, late, faster)
        # The amplitude falls, by a share of the gain or of what a slow spool passes of it; where the command is on time
        # by half the gain but for what the law takes it to be late.
        passed = abs(following(angle, believed(valve, shifted(angle, valve))))
        least = max(0.19 * passed, 0.1 * min(1.0, passed / 0.31)) * gain
        for late in LATE:
            assert radius(angle, gain, late, 0.0, valve) < 1.0 - least + 1e-9, (angle, late)
            slowest = max(radius(angle, gain, late, faster, valve) for faster in DOUBT)
            assert slowest < 1.0 - 0.03 * passed * gain + 1e-9, (angle, late)
        turned = np.cos(angle * shifted(angle, valve))
        assert valve is not FAST or radius(angle, gain, 0.0) < 1.0 - 0.35 * turned * gain + 1e-9, angle


def describing(speed: float, amplitude: float, ratio: float) -> float:
    """Gain of inverse, spool and dead zone over that of the spool, whose frequency and overlap are the units."""
    steps, periods = 400, 6
    step = 2.0 * np.pi / speed / steps
    a = np.array([[0.0, 1.0], [-1.0, -2.0 * ratio]])
    inverse = np.linalg.inv(np.eye(2) - 0.5 * step * a)
    go, push = inverse @ (np.eye(2) + 0.5 * step * a), inverse @ np.array([0.0, step])
    state, first = np.zeros(2), 0.0
    for k in range(steps * periods):
        asked = amplitude * np.sin(speed * step * (k + 0.5))
        state = go @ state + push * (np.sign(asked) + asked)
        if k >= steps * (periods - 1):
            opening = np.sign(state[0]) * max(abs(state[0]) - 1.0, 0.0)
            first += opening * np.exp(-1j * speed * step * (k + 1)) / steps
    return abs(2.0 * first / amplitude * (1.0 - speed**2 + 2j * ratio * speed))


@pytest.mark.parametrize("row", re.findall(r"^\| 0\.[5-8], .*$", PAGE.read_text(encoding="utf-8"), re.M))
def test_the_page_shows_what_an_overlap_makes_of_small_commands(row: str) -> None:
    head, *shown = re.split(r" *\| *", row.strip("| "))
    ratio, overshoot = (float(number) for number in head.split(", "))
    assert overshoot == pytest.approx(np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2)), abs=6e-4)
    for gain, amplitude in zip(shown, (0.01, 0.03, 0.1, 0.3), strict=True):
        largest_gain = max(describing(speed, amplitude, ratio) for speed in (0.1, 0.2, 0.3, 0.5, 0.7))
        assert largest_gain == pytest.approx(float(gain), rel=0.05, abs=0.06)
