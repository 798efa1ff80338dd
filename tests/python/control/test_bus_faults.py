"""Whole frames of a bus that fail: the crane goes on without them for a moment, then stops; it never follows them."""

from __future__ import annotations

import dataclasses

import bus_faults as bus
import numpy as np
import pytest

import hydrocrane as hc

LOST = {case.samples: case for case in bus.CASES if case.name == "frame lost"}
# Those that no reading contradicts, or that are seen only once the piston has moved.
LATE = {"frame repeated", "frame frozen", "one frame late", "two frames late", "pressures exchanged"}
CORRUPT = [case for case in bus.CASES if case.name not in {*LATE, "frame lost"}]
BRIEF = {"frame zeroed", "pressures zeroed", "50 ms nothing, then zeroed", "bit 12 flipped"}


def ids(case):
    return f"{case.name} {'for good' if case.samples is None else case.samples}"


def held(machine, payload, stick, case):
    """A corrupt frame does what one does that never came."""
    crane = hc.load_machine(machine)
    corrupt = bus.drive(crane, payload, stick, case)
    lost = bus.drive(crane, payload, stick, LOST[case.samples])
    assert (corrupt.seen is None) == (lost.seen is None)
    assert np.allclose(corrupt.spools, lost.spools, atol=2e-3), ids(case)
    assert np.allclose(corrupt.tip, lost.tip, atol=3e-3), ids(case)


@pytest.mark.parametrize("case", [case for case in CORRUPT if case.name in BRIEF], ids=ids)
@pytest.mark.parametrize("machine", ["rottne-f9-lab", "hiab-xs031"])
def test_a_corrupt_frame_is_left_out(machine, case):
    held(machine, bus.MACHINES[machine], (0.0, 0.0), case)


@pytest.mark.evidence
@pytest.mark.parametrize("case", CORRUPT, ids=ids)
def test_every_corrupt_frame_is_left_out_at_rest_and_in_motion(case):
    for machine, payload in bus.MACHINES.items():
        for stick in bus.DIRECTIONS:
            held(machine, payload, stick, case)


@pytest.mark.parametrize("stick", [(0.0, 0.0), (0.0, 1.0)])
def test_zeros_without_a_monitor_would_open_the_valves(stick):
    """The fault is one: a controller that believes it opens a valve fully."""
    crane = hc.load_machine("rottne-f9-lab")
    controller = hc.NamedController("tip", crane, monitor=False)
    obs = hc.Simulator(crane).reset(q=crane.home)
    controller.reset(crane, obs)
    zero = dataclasses.replace(obs, t=0.01, q=0.0 * obs.q, p=0.0 * obs.p, measured={})
    assert max(np.abs(controller.step(zero, hc.Stick("tip", np.array(stick))))) > 0.04
