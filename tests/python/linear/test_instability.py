"""An unstable loop says why, and what makes it stable; a machine by its name has a Bode picture."""

from __future__ import annotations

import re

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.linear import PidGains, cylinder_loops, pid_gains
from hydrocrane.machine.poses import in_words

POSE = np.deg2rad([100.0, 100.0, 0.0])


def scaled(share, integral, machine="rottne-f9-lab"):
    """The gains of the thesis times a share, with or without their integral part."""
    own = pid_gains(machine)
    return {c: PidGains(share * g.proportional, share * integral * g.integral, 0.0) for c, g in own.items()}


def stable(share):
    return cylinder_loops("rottne-f9-lab", POSE, gains=scaled(share, 0.0))[0].stable


@pytest.mark.parametrize(("integral", "pattern"), [(0.0, "all gains times"), (1.0, "no integral part and all other")])
def test_an_unstable_loop_names_its_oscillation_and_a_cure_that_holds(integral, pattern):
    loop = cylinder_loops("rottne-f9-lab", POSE, gains=scaled(1.0, integral))[0]
    assert not loop.stable and "Hz" in loop.advice and "natural mode" in loop.advice and pattern in loop.advice
    share = float(re.search(r"times ([\d.e-]+)$", loop.advice)[1])
    assert stable(share) and not stable(1.1 * share)


@pytest.mark.parametrize(
    ("machine", "gains", "cause"),
    [
        ("rottne-f9-lab", None, "the integral parts drive it"),
        ("hiab-xs031", "negative", "is a sign of a gain wrong"),
    ],
)
def test_what_grows_without_an_oscillation_is_called_no_oscillation(machine, gains, cause):
    crane = hc.load_machine(machine)
    given = gains and scaled(-1.0, 0.0, machine)
    advice = cylinder_loops(crane, crane.home, gains=given)[0].advice
    assert "grows steadily" in advice and cause in advice
    assert not re.search(r"natural mode|has a gain of| 0 Hz|nan|inf", advice)


def test_rounding_is_no_part_of_a_pose():
    """Against the range of its joint: half a millimetre of a short telescope is stated, 1e-13 mm of any is not."""
    crane = hc.load_machine("rottne-f9-lab")
    assert in_words(crane, crane.home).endswith("extension 0 mm")
    assert in_words(crane, [1.5, 1.5, -1.2e-17]).endswith("extension 0 mm")
    assert in_words(crane, [1.5, 1.5, -0.5e-3]).endswith("extension -0.5 mm")
    assert in_words(crane, np.deg2rad([100.123, 1e-12, 0.0])) == "boom 100.1 deg, jib 0 deg, extension 0 mm"


def test_a_stable_loop_has_no_advice():
    loops = cylinder_loops("rottne-f9-lab", POSE, gains=scaled(1e-3, 0.0))
    assert loops[0].stable and loops[0].advice == ""


def test_the_picture_of_unstable_loops_says_why():
    figure = hc.plots.loop_gains(cylinder_loops("rottne-f9-lab", POSE))
    assert "what makes it stable" in figure.get_supxlabel().replace("\n", " ")


@pytest.mark.parametrize("given", ["single-cylinder", "machine"])
def test_a_machine_has_a_bode_picture(given):
    figure = hc.bode(hc.load_machine("single-cylinder") if given == "machine" else given)
    assert [line.get_label() for line in figure.axes[0].lines][0].startswith("tip.z by ")
