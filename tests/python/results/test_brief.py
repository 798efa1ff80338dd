"""What a result shows of itself: one line in a console, a card in a notebook."""

from __future__ import annotations

import dataclasses
import inspect

import numpy as np
import pytest

import hydrocrane as hc
import hydrocrane.linear
from hydrocrane import rig
from hydrocrane.arrays import brief

LONGEST = 1500


@pytest.fixture(scope="module")
def run():
    return hc.simulate("vertical-lift-open-loop", duration=0.5)


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("rottne-f9-lab")


@pytest.fixture(scope="module")
def log():
    return rig.run("constant-velocity", seed=3, calibration=1.0)


@pytest.fixture(scope="module")
def results(run, crane, log):
    pose = np.deg2rad([100.0, 100.0, 0.0])
    apart = run.compare({"time": run.columns.time, "tip.z": run.columns["tip.z"].values})
    return [
        apart,
        apart["tip.z"],
        hc.identify_friction([log], "rig-rottne"),
        hc.modes(crane, pose),
        hc.mode_map(crane, samples=5),
        hc.load_chart(crane, samples=5),
        hc.sensitivities("vertical-lift-open-loop", ["payload.mass"], duration=0.2),
        log,
        crane.value("supply.pressure"),
        crane.value("friction.lift.coulomb"),
        *hc.linear.cylinder_loops(crane, pose),
        crane.linearise(pose),
        run,
    ]


def test_a_result_is_one_short_line(results):
    for result in results:
        assert len(repr(result)) < LONGEST and "\n" not in repr(result), repr(result)[:300]


def test_a_result_is_a_card_in_a_notebook(results):
    shown = [result for result in results if not isinstance(result, hc.linear.Loop | type(results[1]))]
    for result in shown:
        if type(result).__name__ == "ModeMap":
            continue
        text = result._repr_html_()
        assert text.startswith("<div") and 100 < len(text.encode()) < 25_000, text[:200]


def test_cards_tell_numbers_with_units(crane, log):
    assert "11.08 Hz" in hc.modes(crane, np.deg2rad([100.0, 100.0, 0.0]))._repr_html_()
    assert "14000000" in crane.value("supply.pressure")._repr_html_().replace("1.4e+07", "14000000")
    assert "rig-rottne" in log._repr_html_() and "mm/s" in log._repr_html_()


def test_every_public_result_with_arrays_shows_them_by_their_shape():
    public = [getattr(hc, name) for name in hc.__all__] + [getattr(hc.linear, name) for name in hc.linear.__all__]
    classes = [found for found in public if inspect.isclass(found) and dataclasses.is_dataclass(found)]
    arrays = [
        c for c in classes if any("Array" in str(f.type) or "ndarray" in str(f.type) for f in dataclasses.fields(c))
    ]
    assert len(arrays) > 5
    assert not [c.__name__ for c in arrays if c.__repr__ is not brief and "__repr__" not in inspect.getsource(c)]
