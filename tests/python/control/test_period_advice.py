"""What the linear model says of the period of tip control, and whether stops agree."""

from __future__ import annotations

import pytest

import hydrocrane as hc
from hydrocrane.benchmark.stops import random_stop
from hydrocrane.linear import period_advice

LAB = "rottne-f9-lab"


def test_the_laboratory_crane_needs_half_of_the_default_and_rings_at_it() -> None:
    """Seed 36 with data-sheet sensors and 300 kg takes 1.2 s at 10 ms."""
    advice = period_advice(LAB)
    assert advice.too_long and 'control.period = "5 ms"' in str(advice)
    shorter = hc.load_machine(LAB, {"control.period": "5 ms"})
    assert not period_advice(shorter).too_long
    machines = (hc.load_machine(LAB), shorter)
    slow, fast = (random_stop(machine, 36, payload=300.0, sensors="data-sheet", end=8.0) for machine in machines)
    assert slow is not None and fast is not None
    assert slow.settling > 0.8 and fast.settling < 0.6


@pytest.mark.parametrize("machine", ["hiab-xs031", "rig-rottne"])
def test_slow_cranes_and_rigs_whose_modes_no_stop_excites_need_no_other_period(machine: str) -> None:
    advice = period_advice(machine)
    assert not advice.too_long and "damps all oil modes" in str(advice)
