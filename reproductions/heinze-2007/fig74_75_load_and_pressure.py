"""Figures 74 and 75: does friction depend on the supply pressure or on the load? Section 5.2.4 as a statistical test.

Two worlds are measured: one whose friction is the same throughout, as the section concludes, and for the load one whose
friction is that of Table 3.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from common import figure, save
from laboratory import RIGS, experiment

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.identification import FrictionComparison

CYLINDER = "Rottne"
# Each group's calibration lasts differently, so that the noise of one is not that of the other.
LEADS = (1.0, 1.3, 1.7)
# Groups of each test: settings of the rig, the first the reference.
TESTS = {
    "pressure, same friction": [{"supply": 140e5}, {"supply": 100e5}],
    "load, same friction": [{"payload": load} for load in (0, 20, 115)],
    "load, friction of Table 3": [
        {"payload": load, "overrides": rig.loaded_friction(RIGS[CYLINDER], load)} for load in (0, 115)
    ],
}


@cache
def comparison(test: str) -> FrictionComparison:
    """The comparison that the default call makes of the logs of all groups."""
    name = "pressure-variation" if test.startswith("pressure") else "load-variation"
    logs = [experiment(name, CYLINDER, calibration=lead, **given) for lead, given in zip(LEADS, TESTS[test])]
    found = hc.identify_friction(logs, RIGS[CYLINDER]).comparison
    assert found is not None
    return found


def bound(found: FrictionComparison) -> float:
    """Largest difference that the 95 % intervals still allow at any common velocity, N."""
    return float(max(np.max(np.abs(found_interval)) for d in found.differences for found_interval in d.interval(0.95)))


def compute() -> dict[str, float]:
    numbers = {}
    for test in TESTS:
        found = comparison(test)
        numbers[f"{test}.told apart"] = float(found.conclusion in ("different", "different-within-margin"))
        numbers[f"{test}.beyond the margin"] = float(found.conclusion == "different")
        numbers[f"{test}.p"], numbers[f"{test}.equivalence p"] = found.p_value, found.equivalence_p
        numbers[f"{test}.bound N"] = bound(found)
        numbers[f"{test}.largest share"] = float(found.effect.share[found.effect.largest])
    return numbers


def repeatability(key: str) -> float:
    """Least-squares solutions repeat to their step tolerance, not to rounding."""
    return 1e-2 if key.endswith("N") else 1e-3


def report(numbers: dict[str, float]) -> list[str]:
    """The verdicts with what they rest on."""
    lines = [
        "| groups | verdict | p of one map for all | largest difference | no more than, 95 % |",
        "|---|---|---|---|---|",
    ]
    for test in TESTS:
        apart, beyond = (numbers[f"{test}.{what}"] for what in ("told apart", "beyond the margin"))
        verdict = "they differ" if beyond else "they differ, by less than 10 %" if apart else "no difference found"
        lines.append(
            f"| {test} | {verdict} | {numbers[f'{test}.p']:.2g} | {100 * numbers[f'{test}.largest share']:+.0f} % | "
            f"{numbers[f'{test}.bound N']:.0f} N |"
        )
    return lines


def draw() -> None:
    fig, axes = figure(2, 3, (12.0, 6.5))
    for column, test in zip(axes.T, TESTS):
        found = comparison(test)
        for axis, sign, side in zip(column, (1.0, -1.0), (0, 1)):
            for group, fit in found.fits.items():
                here = fit.points.direction == side
                speeds = np.geomspace(4e-4, 0.105, 200)
                (line,) = axis.plot(1e3 * speeds, sign * fit.force(sign * speeds), label=group)
                axis.plot(
                    1e3 * fit.points.speed[here], sign * fit.points.force[here], "o", ms=3.5, color=line.get_color()
                )
            axis.set(xscale="log", ylim=(0, 850 if "Table" in test else 700))
        column[0].set_title(f"Figure {74 if test.startswith('pressure') else 75}: {test}", fontsize=9.5)
        column[0].legend(frameon=False)
        column[1].set_xlabel("speed [mm/s]")
    axes[0, 0].set_ylabel("extending: friction [N]")
    axes[1, 0].set_ylabel("retracting: friction [N]")
    save(fig, "fig74_75_load_and_pressure")
