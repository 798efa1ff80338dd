"""Errors of integration do not show in a fit, however loose the tolerance that it begins with."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

STEP = "single-cylinder-step"
SUPPLY, FLOW = "supply.pressure", "valve.test.nominal-flow"


@pytest.fixture(scope="module")
def log() -> dict[str, np.ndarray]:
    truth = hc.simulate(STEP, overrides={SUPPLY: "95 bar"}, rtol=1e-9, method="rodas5p", ledger=False).columns
    rng = np.random.default_rng(2)
    noise = {"cylinder.test.x": 2e-5, "cylinder.test.p1": 2e4, "cylinder.test.p2": 2e4}
    clean = {name: truth[name].values for name in noise}
    return {"time": truth.time, **{name: clean[name] + rng.normal(0, noise[name], truth.time.size) for name in noise}}


def test_a_loose_tolerance_is_tightened_until_it_no_longer_moves_the_values(log: dict[str, np.ndarray]):
    loose, tight = (hc.fit(STEP, log, [SUPPLY, FLOW], rtol=rtol) for rtol in (1e-2, 1e-7))
    for name in (SUPPLY, FLOW):
        low, high = tight.interval(name)
        assert abs(loose.value(name) - tight.value(name)) < 0.1 * (high - low)
    low, high = loose.interval(SUPPLY)
    assert low < 95e5 < high
    assert loose.accuracy is not None and loose.accuracy.negligible and "rtol 0.0001" in loose.summary()


def test_a_measured_motion_has_no_tolerance(log: dict[str, np.ndarray]):
    found = hc.fit(STEP, log, ["link.mass.body.load.mass"], motion="measured")
    assert found.accuracy is None and "integrated" not in found.summary()
