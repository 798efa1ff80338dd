"""Errors of sensors as unknowns of a fit: what a machine file says of them."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.identification.values.parameters import SensorError, unknown_error

# Two sensors read one pressure; the first states no accuracy.
TWO = """extends = "single-cylinder"
without = ["sensor.p1.accuracy"]

[sensor.second]
measures = "cylinder.test.p1"
kind = "pressure-transmitter"
class = "assumed"
range = "100 bar"
accuracy = 0.01
"""


@pytest.mark.parametrize(("kind", "deviation"), [("zero", 0.01 * 100e5 / np.sqrt(6.0)), ("span", 0.01 / np.sqrt(3.0))])
def test_accuracy_and_range_are_those_of_one_sensor(kind, deviation, tmp_path):
    file = tmp_path / "two.toml"
    file.write_text(TWO)
    unknown = unknown_error(hc.load_machine(file), SensorError("cylinder.test.p1", kind), 1e5, {})
    assert unknown.prior == (0.0, pytest.approx(deviation, rel=1e-12))
