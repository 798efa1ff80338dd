"""A search that ends where fewer unknowns would not fit better, outliers, and what residuals look like.

Logs come from the rig that :mod:`oracles.rig` integrates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from oracles.rig import Rig

import hydrocrane as hc
from hydrocrane.identification.records import FittedLog
from hydrocrane.identification.solve import Unknown
from hydrocrane.identification.values.models import SensorReading
from hydrocrane.identification.values.search import FitTask, searched

RIG = "rig-rottne"
PLAN = hc.Scenario(machine=RIG, joints={"slide": 0.0}, duration=4.0)
NAMES = ["valve.test.nominal-flow", "friction.test.viscous[0]"]
# Corners of the spool command, (s, um).
COURSE = ((0, 0), (0.3, 0), (0.5, 300), (1.5, 300), (1.7, 0), (2.0, 0), (2.2, -250), (3.2, -250), (3.4, 0), (4, 0))


def log(
    *, held: float = 0.0, dead: float = 0.0, noise: float = 1.0, seed: int = 0, **values: float
) -> dict[str, np.ndarray]:
    """Readings of a rig with these values; commands are joined by lines, or `held` for so long, s; `dead` um of them
    open nothing.
    """
    rig, rng = Rig(**values), np.random.default_rng(seed)
    times, spools = (np.array(column, dtype=float) for column in zip(*COURSE, strict=True))
    if held:
        at = np.arange(0.0, 4.0, held)
        level = np.interp(at, times, spools)
        times = np.column_stack([at, np.append(at[1:], 4.0) - 1e-6]).ravel()
        spools = np.repeat(level, 2)
    opens, opened = times, spools
    if dead:
        at = np.arange(0.0, 4.0, 0.01)
        opened = np.interp(at, times, spools)
        opened, opens = np.sign(opened) * np.maximum(np.abs(opened) - dead, 0.0), at
    p1 = 30e5
    begin = [0.0, 0.0, p1, (p1 * rig.a1 + rig.mass * rig.gravity) / rig.a2, 0.0, 0.0, 0.0]
    time = np.arange(0.0, 4.0, 0.02)
    states = rig.integrate(begin, opens, 1e-6 * opened, time[1:], 1e-8)[: time.size]
    found = {"time": time, "cylinder.test.command": 1e-6 * np.interp(time, times, spools)}
    for name, column, size in (("x", 0, 2e-5), ("p1", 2, 2e4), ("p2", 3, 2e4)):
        found[f"cylinder.test.{name}"] = states[:, column] + noise * size * rng.normal(size=time.size)
    return found


@dataclass(frozen=True)
class Hollow:
    """Two signals: `a` is described at q = 0 only, `b` equally badly there, and twice as well at q = 1."""

    record: FittedLog
    solver: None = None

    def predict(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        c, q = values
        t = self.record.time - 0.5
        bump, shape = np.exp(-(((q - 1.0) / 0.5) ** 2)), np.sign(np.sin(20.0 * t))
        y = np.stack([c + np.sin(6.0 * t) + 0.1 * q * t, c + 0.5 * (1.0 - 0.6 * bump) * shape], axis=1)
        over = 0.6 * bump * (q - 1.0) / 0.25 * shape
        return y, np.stack([np.ones_like(y), np.stack([0.1 * t, over], axis=1)], axis=-1)

    def with_solver(self, solver: hc.Solver) -> Hollow:
        return self


def test_a_key_more_does_not_fit_worse():
    """By their ranges the signals weigh the same, and a search with both keys ends at q = 1, where `a` is given up."""
    rng, time = np.random.default_rng(0), np.linspace(0.0, 1.0, 400)
    readings = np.stack([np.sin(6.0 * (time - 0.5)), np.zeros(400)], axis=1) + 1e-3 * rng.normal(size=(400, 2))
    readings[:, 1] += np.linspace(-0.01, 0.01, 400)
    record = FittedLog("log", time, 0.0, ("a", "b"), readings, np.full(2, 1e-3), np.zeros(400, dtype=bool), None)
    unknowns = (Unknown("c", 0.0, 1.0), Unknown("q", 0.3, 1.0))
    found = searched(FitTask(unknowns, (Hollow(record),), SensorReading(()), 2, 2, True), 1, 0, map, lambda _: None)
    assert abs(found.estimate["q"]) < 0.1


def test_a_first_sample_that_is_wrong_moves_nothing():
    """The start of the run comes from the first samples; an outlier is like no neighbour and hides no correlation."""
    clean = log(viscous=[9000.0, 9000.0], seed=1)
    spoilt = {name: column.copy() for name, column in clean.items()}
    for name, size in (("x", 0.05), ("p1", 40e5)):
        spoilt[f"cylinder.test.{name}"][0] += size
    fits = [hc.fit(PLAN, columns, NAMES) for columns in (clean, spoilt)]
    for name in NAMES:
        low, high = fits[0].interval(name)
        assert low < fits[1].value(name) < high


@pytest.mark.parametrize(
    ("made", "said"),
    [
        ({"bulk-modulus-max": 0.75e9}, "lower `fluid.bulk-modulus-max`"),
        ({"held": 0.1}, 'interpolation="hold"'),
        ({"dead": 20.0}, "wider dead zone, `valve.test.overlap`"),
    ],
    ids=["soft oil", "held commands", "dead zone"],
)
def test_what_the_residuals_look_like_is_named(made: dict[str, float], said: str):
    found = hc.fit(PLAN, log(**made), NAMES)
    assert any(said in text and "effective" in text for text in found.warnings), found.warnings
    right = hc.fit(PLAN, log(), NAMES)
    assert not any("look like" in text for text in right.warnings), right.warnings
    assert "a clock that runs too fast" in right.summary()
