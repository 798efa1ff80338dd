"""Twenty random machines: what docs/validation/random-machines.md judges of hundreds, with shorter drives."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[3] / "docs" / "validation"))

from random_machines import CHECKS, judged, random_case  # noqa: E402

SECONDS = 1.0


@pytest.mark.parametrize("seed", range(20))
def test_a_machine_that_nobody_tuned_for(seed):
    checks = [check for check in CHECKS if check != "fmu"]
    failed = [one for one in judged(seed, checks, partial(random_case, seconds=SECONDS)) if not one.holds]
    assert not failed


# Hose-burst valves; masses that a closing valve stops; swings between samples; a compensator that follows late.
@pytest.mark.parametrize("seed", [8, 28, 36, 43, 48])
def test_the_monitor_accuses_no_sensor_in_order(seed):
    (found,) = judged(seed, ["tip"], random_case)
    assert found.holds, found


def test_an_exported_machine_steps_as_the_simulator_does():
    (found,) = judged(1, ["fmu"], partial(random_case, seconds=SECONDS))
    assert found.holds, found
