"""The formulas by which the reproduction reads bristles, on signals whose bristles are known."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "reproductions" / "heinze-2007"))
stiffness = importlib.import_module("table4_bristle_stiffness")
step = importlib.import_module("fig73_step")

LIMIT, RATE = 340.0, 10.0


@pytest.mark.parametrize("power", [1, 2, 3])
def test_the_corrected_formula_solves_its_equation_and_the_printed_one_only_by_chance(power):
    """(124) with the friction force c t: dz = (1 - c t / limit) dx; (125) integrates it by parts   (E18). For x over
    t^n the printed formula takes (n + 2) / (2 (n + 1)) in place of n / (n + 1): right for n = 2 alone."""
    time = np.linspace(0.0, 30.0, 3001)
    x = 1e-3 * (time / 30.0) ** power
    force = RATE * time
    exact = cumulative_trapezoid(1 - force / LIMIT, x, initial=0.0)
    corrected, printed, measured = (
        stiffness.deflection(way, time, x, force, LIMIT) for way in ("corrected", "printed", "measured force")
    )
    np.testing.assert_allclose(corrected, exact, atol=1e-9)
    np.testing.assert_allclose(measured, exact)
    off = (power / (power + 1) - (power + 2) / (2 * (power + 1))) * RATE * 30.0 / LIMIT * 1e-3
    assert printed[-1] - exact[-1] == pytest.approx(off, abs=1e-9)


@pytest.mark.parametrize("interval", [1e-3, 2e-3])
def test_noise_of_the_position_alone_gives_a_negative_damping(interval):
    """(127) with backward differences of white noise: -3 m/(2 h), for any noise (E19)."""
    mass, time = 5.0, np.arange(0, 40.0, interval)
    noise = 5e-5 * np.random.default_rng(1).normal(size=time.size)
    found = step.damped_slope(noise, np.zeros_like(noise), mass, 0.0, interval)
    # Four standard errors of a regression over so many samples.
    assert found == pytest.approx(-1.5 * mass / interval, rel=4 / np.sqrt(time.size))


def test_without_noise_the_printed_way_finds_the_damping():
    """The same regression on the motion of a mass on a spring and a damper: positive, and right."""
    mass, spring, damper, interval = 5.0, 1.1e5, 800.0, 1e-5
    time = np.arange(0, 0.05, interval)
    x = 1e-4 * np.sin(300.0 * time)
    velocity, acceleration = 0.03 * np.cos(300.0 * time), -9.0 * np.sin(300.0 * time)
    force = mass * acceleration + spring * x + damper * velocity
    found = step.damped_slope(x, force, mass, spring, interval)
    assert found == pytest.approx(damper, rel=0.03)
