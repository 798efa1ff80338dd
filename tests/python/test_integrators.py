"""The methods on the plant: order of convergence, agreement with an outside solver, and tolerance that is kept."""

from __future__ import annotations

import hydrocrane as hc
import numpy as np
import pytest
from scipy.integrate import solve_ivp

METHODS = ("rodas5p", "tsit5")
# Friction without the corners at zero velocity: the same Coulomb force either way and linear viscosity.
SMOOTH = {
    "friction.test.model": "static",
    "friction.test.coulomb": 200.0,
    "friction.test.breakaway": 200.0,
    "friction.test.smoothing-velocity": 0.05,
    "friction.test.viscous": "3000 N s/m",
    "friction.test.viscous-exponent": 1.0,
}


def moving_start():
    """Single cylinder lowering its mass at half spool, 0.1 s after the start: every law is smooth from here on."""
    crane = hc.load_machine("single-cylinder", SMOOTH)
    sim = hc.Simulator(crane, sample_time=0.1, rtol=1e-10)
    sim.reset(q=crane.home)
    sim.step([0.025])
    return crane, sim.state


def fixed_steps(crane, state, method, step, duration):
    """State after `duration` with one step per sample: the tolerance is so wide that only the sample time counts.

    A fresh simulator starts with a tenth of a millisecond, so steps up to that are equal from the first on.
    """
    sim = hc.Simulator(crane, sample_time=step, method=method, rtol=1e6)
    sim.reset(state=state)
    for _ in range(round(duration / step)):
        sim.step([0.02])
    return sim.state


def scaled(crane, difference):
    """Largest difference relative to the sizes that the states of this run have."""
    sizes = {"q": 0.1, "qd": 0.1, "p1": 1e6, "p2": 1e6, "xs": 0.02, "vs": 1.0}
    return np.abs(difference / [sizes[name.rsplit(".", 1)[1]] for name in crane.state_names]).max()


@pytest.mark.parametrize("method", METHODS)
def test_order_of_convergence(method):
    """Halving the step divides the error by two to the order, which is five for both methods."""
    crane, start = moving_start()
    exact = hc.Simulator(crane, sample_time=2e-3, rtol=1e-13)
    exact.reset(state=start)
    for _ in range(2):
        exact.step([0.02])
    steps = 4e-3 / np.array(STEPS[method])
    errors = [scaled(crane, fixed_steps(crane, start, method, h, 4e-3) - exact.state) for h in steps]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(5.0, abs=0.2), errors


# Numbers of steps within 4 ms, where the error is neither rounding nor beyond the asymptotic range.
STEPS = {"rodas5p": (40, 57, 80, 113), "tsit5": (40, 57, 80, 113)}
