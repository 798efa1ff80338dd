"""Random stops that took long before their causes were known."""

from __future__ import annotations

import pytest
from tip_stops import random_stop

import hydrocrane as hc


@pytest.mark.parametrize("seed", [1, 15, 19, 21])
def test_counts_of_encoders_lengthen_no_stop(seed: int) -> None:
    """1.2 s where a change of a reading took the observed position beyond the boundary of the counts."""
    crane = hc.load_machine("rottne-f9-lab", {"control.period": "5 ms"})
    stop = random_stop(crane, seed, payload=80.0, sensors="data-sheet", end=8.0)
    assert stop is not None and stop.settling < 0.6


@pytest.mark.parametrize("seed", [4, 10])
def test_a_stick_let_go_at_the_bounds_of_the_joints_rings_nothing(seed: int) -> None:
    """1.6 and 0.8 s where the lags kept speed that the joints did not have, and the telescope reversed at once."""
    stop = random_stop(hc.load_machine("rottne-f9-lab"), seed, end=8.0)
    assert stop is not None and stop.settling < 0.6


@pytest.mark.parametrize("seed", [7, 31, 42])
def test_a_reading_of_the_telescope_that_changes_kicks_no_other_joint(seed: int) -> None:
    """1.2, 3.5 and 1.3 s where boom and jib took up each change within a sample."""
    stop = random_stop(hc.load_machine("rottne-f9-lab"), seed, sensors="data-sheet", end=8.0)
    assert stop is not None and stop.settling < 0.6


@pytest.mark.parametrize("seed", [208, 216])
def test_loads_near_the_supply_pressure_are_damped(seed: int) -> None:
    """7.4 and 6.3 s with a valve that stayed closed towards the load, and damped the other way as any other."""
    stop = random_stop(hc.load_machine("hiab-xs031"), seed, payload=300.0)
    assert stop is not None and stop.settling < 3.0


@pytest.mark.parametrize(("seed", "most", "drift"), [(486, 4.0, 1.5e-3), (330, 6.5, 5e-3)])
def test_the_oil_is_compressed_for_the_weighed_payload(seed: int, most: float, drift: float) -> None:
    """6.2 and 10.0 s, and 18 and 57 mm, where the oil was compressed for the stated payload: 300 kg near the dead
    centre of the lift, where a millimetre of its piston is 5 cm at the tip."""
    stop = random_stop(hc.load_machine("hiab-xs031"), seed, payload=300.0)
    assert stop is not None and stop.settling < most and stop.drift < drift
