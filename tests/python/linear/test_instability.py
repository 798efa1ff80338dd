"""An unstable loop says why, and what makes it stable; a machine by its name has a Bode picture."""

from __future__ import annotations

import re

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.linear import PidGains, cylinder_loops, pid_gains

POSE = np.deg2rad([100.0, 100.0, 0.0])


@pytest.fixture(scope="module")
def gains():
    own = pid_gains("rottne-f9-lab")
    return {c: PidGains(30 * g.proportional, 30 * g.integral, 30 * g.derivative) for c, g in own.items()}


def test_an_unstable_loop_names_its_oscillation_and_a_cure_that_holds(gains):
    loops = cylinder_loops("rottne-f9-lab", POSE, gains=gains)
    advice = loops[0].advice
    assert not loops[0].stable and "Hz" in advice and "natural mode" in advice
    share = float(re.search(r"all gains times ([\d.e-]+)", advice)[1])
    smaller = {c: PidGains(share * g.proportional, share * g.integral, share * g.derivative) for c, g in gains.items()}
    assert cylinder_loops("rottne-f9-lab", POSE, gains=smaller)[0].stable
    larger = {c: PidGains(1.1 * g.proportional, 1.1 * g.integral, 1.1 * g.derivative) for c, g in smaller.items()}
    assert not cylinder_loops("rottne-f9-lab", POSE, gains=larger)[0].stable


def test_a_delay_that_is_the_reason_is_told():
    loops = cylinder_loops("rottne-f9-lab", POSE, delay=0.3)
    assert loops[0].stable or "no delay in place of 300 ms" in loops[0].advice


def test_a_stable_loop_has_no_advice():
    loops = cylinder_loops("rottne-f9-lab", POSE)
    assert loops[0].stable and loops[0].advice == ""


def test_the_picture_of_unstable_loops_says_why(gains):
    figure = hc.plots.loop_gains(cylinder_loops("rottne-f9-lab", POSE, gains=gains))
    assert "what makes it stable" in figure.get_supxlabel().replace("\n", " ")


@pytest.mark.parametrize("given", ["single-cylinder", "machine"])
def test_a_machine_has_a_bode_picture(given):
    figure = hc.bode(hc.load_machine("single-cylinder") if given == "machine" else given)
    assert [line.get_label() for line in figure.axes[0].lines][0].startswith("tip.z by ")
