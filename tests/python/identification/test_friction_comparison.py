"""Does friction change with load? The test finds what differs, and calls equal only what is."""

from __future__ import annotations

from dataclasses import replace

import foreign_rig
import matplotlib.pyplot as plt
import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.identification import FrictionComparison, StaticMap, compare_friction, synthetic_points

pytestmark = pytest.mark.evidence

# Thesis Table 3, Rottne cylinder.
UNLOADED = StaticMap.of(
    {"coulomb": (160, 280), "breakaway": (340, 400), "stribeck-velocity": 0.002, "viscous": (8000, 12000)}
)
LOADED = StaticMap.of(
    {"coulomb": (170, 350), "breakaway": (620, 800), "stribeck-velocity": (0.004, 0.002), "viscous": (10500, 12000)}
)


def test_the_rows_of_table_3_differ():
    """The thesis calls the deviation little; its own table has more than twice the friction at some speed."""
    groups = {"0 kg": synthetic_points(UNLOADED, seed=1), "115 kg": synthetic_points(LOADED, seed=2)}
    found = compare_friction(groups)
    assert found.conclusion == "different" and found.p_value < 1e-6
    effect = found.effect
    assert effect.share[effect.largest] > 0.8
    true = np.abs(LOADED.force(effect.velocity)) - np.abs(UNLOADED.force(effect.velocity))
    low, high = effect.interval(0.999)
    assert ((low <= true) & (true <= high)).all()
    assert "115 kg against 0 kg" in found.sentence
    assert len(found.plot().axes) == 4
    plt.close("all")


def test_equal_groups_are_called_equal():
    """Of 10 studies at 5 % more than three false alarms happen once in 10^3."""
    conclusions = []
    for seed in range(10):
        groups = {str(k): synthetic_points(UNLOADED, seed=100 * k + seed) for k in (1, 2, 3)}
        conclusions.append(compare_friction(groups).conclusion)
    assert sum(v.startswith("different") for v in conclusions) <= 3
    assert conclusions.count("equivalent") >= 6


def test_p_values_of_equal_groups_are_even():
    """Their mean over 30 studies is 1/2 to within four standard errors of an even distribution."""
    p = [
        compare_friction({"a": synthetic_points(UNLOADED, seed=s), "b": synthetic_points(UNLOADED, seed=1000 + s)})
        for s in range(30)
    ]
    assert abs(np.mean([found.p_value for found in p]) - 0.5) < 4 / np.sqrt(12 * 30)


def test_noise_leaves_it_undecided():
    groups = {
        "a": synthetic_points(UNLOADED, seed=1, force_error=60),
        "b": synthetic_points(UNLOADED, seed=2, force_error=60),
    }
    found = compare_friction(groups)
    assert found.conclusion == "undecided" and "not ruled out" in found.sentence


def test_a_small_difference_is_found_and_called_small():
    values = UNLOADED.values.copy()
    values[:4] *= 1.04
    groups = {
        "a": synthetic_points(UNLOADED, seed=1, force_error=1),
        "b": synthetic_points(StaticMap(values), seed=2, force_error=1),
    }
    found = compare_friction(groups)
    assert found.conclusion == "different-within-margin" and "by less than 10 %" in found.sentence


def test_a_shift_of_the_sensors_is_no_difference_of_friction():
    shifted = {"a": synthetic_points(UNLOADED, seed=1), "b": synthetic_points(UNLOADED, seed=2, offset=15.0)}
    assert compare_friction(shifted).p_value < 1e-3
    allowed = compare_friction(shifted, bias=[0.0, 15.0])
    assert allowed.p_value > 0.05
    low, high = allowed.effect.interval()
    assert (low <= 0.0).all() and (high >= 0.0).all()
    # An error that all logs share shifts no group against another.
    assert compare_friction(shifted, bias=15.0).p_value < 1e-3


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"margin": 10}, "0.1 means 10 %"),
        ({"significance": 0.0}, "significance"),
        ({"bias": -1.0}, "bias"),
        ({"span": 0.002}, "chambers"),
    ],
)
def test_wrong_arguments_are_named(arguments, said):
    groups = {"a": synthetic_points(UNLOADED), "b": synthetic_points(UNLOADED, seed=1)}
    with pytest.raises(hc.InputError, match=said):
        compare_friction(groups, **arguments)


def test_what_cannot_be_compared_is_said():
    points = synthetic_points(UNLOADED)
    with pytest.raises(hc.InputError, match="two groups"):
        compare_friction({"a": points})
    with pytest.raises(hc.InputError, match="no velocities in common"):
        compare_friction({"a": points.select(points.direction == 0), "b": points.select(points.direction == 1)})
    few = synthetic_points(UNLOADED, speeds=[0.01, 0.02])
    with pytest.raises(hc.InputError, match="add levels"):
        compare_friction({"a": few, "b": few})


def test_span_errors_that_go_with_the_pressures_are_no_difference():
    """At another supply pressure transmitters with wrong spans shift the directions by different forces."""
    spans = np.array([2e-3, -2e-3])
    groups = {}
    for name, seed, back in (("140 bar", 1, 6e4), ("100 bar", 2, 3e4)):
        points = synthetic_points(UNLOADED, seed=seed)
        second = np.where(points.direction == 0, 0.5 * back, back)
        chambers = np.stack([second + points.force, second], axis=-1) * (1.0 + spans)
        groups[name] = replace(points, force=chambers[:, 0] - chambers[:, 1], chambers=chambers)
    assert compare_friction(groups).p_value < 1e-6
    assert compare_friction(groups, span=2e-3).p_value > 0.05


def pressures_compared(seed: int, **change) -> FrictionComparison:
    """Logs of a foreign rig at two pressures, read by the same sensors, in the default call."""
    truth = foreign_rig.drawn(seed, **change)
    logs = []
    for k, (back, supply) in enumerate(((5e5, 140e5), (60e5, 200e5))):
        motion = foreign_rig.imposed(truth, back=back, seconds=2.0, seed=seed)
        logs.append(foreign_rig.read(motion, seed, earlier=k, source=f"{k}"))
        logs[-1].data.attrs.update(supply=supply, payload=0.0)
    found = hc.identify_friction(logs, "rig-rottne", zero=(0, 1)).comparison
    assert found is not None
    return found


def test_equal_friction_at_two_pressures_raises_no_alarm():
    """More than two of six false alarms happen in 0.2 % of all studies at 5 %; sensors taken as exact make six."""
    alarms = [pressures_compared(seed).conclusion.startswith("different") for seed in range(6)]
    assert sum(alarms) <= 2, alarms


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_friction_that_grows_with_pressure_is_found(seed):
    """10 % per 100 bar are 5.5 % in slow motion, and less in fast."""
    assert pressures_compared(seed, by_pressure=0.1).p_value < 1e-4


@pytest.mark.study
@pytest.mark.parametrize("name", ["pressure-variation", "load-variation"])
def test_false_alarms_of_the_whole_command(name):
    """The rig has one friction. Of 40 studies at 5 % more than five false alarms happen in one study of 70."""
    runs = rig.series(name, "rig-rottne", calibration=1.0, load_cell=False)
    earlier = np.cumsum([0, *(run.data.sizes["time"] for run in runs)])
    alarms = 0
    for seed in range(40):
        logs = [run.reread(seed, earlier=int(before)) for run, before in zip(runs, earlier, strict=False)]
        found = hc.identify_friction(logs, "rig-rottne").comparison
        alarms += found.conclusion.startswith("different")
    assert alarms <= 5
