"""Twenty random machines: what docs/validation/random-machines.md judges of hundreds, with shorter drives."""

from __future__ import annotations

import warnings
from functools import partial
from pathlib import Path

import pytest
from random_machines import CHECKS, SAYS, judged, kinds, random_case

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


def warned_of(seed: int, folder: Path) -> set[str]:
    """Kinds of the warnings of the default run; those of numpy about the generator do not count."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return kinds(random_case(seed, folder).driven)


# Its default run is 15.5 mm off: every method at 1e-4 is at least 7 mm off.
def test_a_run_whose_errors_add_up_says_so(tmp_path):
    assert "tolerance-too-loose" in warned_of(287, tmp_path)


# Its tip is 1.6 mm off and a pressure 3.3 % of the supply: a load that rings at 5 Hz is out of phase.
def test_a_run_whose_pressures_are_off_says_so(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        told = [warning.text for warning in random_case(158, tmp_path).driven.warnings if warning.kind in SAYS]
    assert len(told) == 1 and "the pressure on the rod side of cylinder `cylinder1` off by" in told[0]


# The tip is 0.6 mm off at most.
@pytest.mark.parametrize("seed", [0, 15, 31, 49])
def test_a_run_within_its_promise_does_not(seed, tmp_path):
    assert "tolerance-too-loose" not in warned_of(seed, tmp_path)


# Pressures of 2300 and 1450 bar, for 60 ms: the tables of the oil end at 800 bar.
@pytest.mark.parametrize("seed", [138, 198])
def test_a_ledger_that_is_open_at_a_peak_of_pressure_says_so(seed, tmp_path):
    assert "energy-ledger-open" in warned_of(seed, tmp_path)
