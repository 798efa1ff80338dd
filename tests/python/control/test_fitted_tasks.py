"""Lines found for a machine: they are straight, inside its limits, and no faster than its pistons."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.app.cli import main
from hydrocrane.benchmark.cases import START, quick_cases, run_case
from hydrocrane.benchmark.fitted_tasks import (
    BEYOND,
    LATER,
    SPEEDS,
    STEP,
    fastest_rates,
    start_pose,
    tuning_cases,
    unknown_payload,
    walk,
    walks,
)
from hydrocrane.benchmark.tasks import SENSES
from hydrocrane.benchmark.tuning import UNITS

pytestmark = pytest.mark.evidence

# A search over the poses of a machine, once for all tests.
start_pose = cache(start_pose)
LAB, HIAB = hc.load_machine("rottne-f9-lab"), hc.load_machine("hiab-xs031")


@pytest.mark.parametrize("crane", [LAB, HIAB], ids=lambda crane: crane.name)
@pytest.mark.parametrize("sense", SENSES)
def test_a_walk_is_straight_and_inside_the_limits(crane, sense):
    found = walk(crane, start_pose(crane), np.array(SENSES[sense]))
    tips = crane.tip(found.poses)
    way = tips[0] + STEP * np.arange(len(tips))[:, np.newaxis] * SENSES[sense]
    assert found.length > 0.3
    assert np.hypot(*(tips - way).T).max() < 2e-3
    assert (found.poses > crane.joint_limits[:, 0]).all() and (found.poses < crane.joint_limits[:, 1]).all()


@pytest.mark.parametrize("crane", [LAB, HIAB], ids=lambda crane: crane.name)
def test_one_piston_at_least_is_at_its_full_speed(crane):
    """Nothing faster keeps the direction: two pistons, or as many as it takes, stand at a bound."""
    q = start_pose(crane)
    for sense in map(np.array, SENSES.values()):
        rates, share = fastest_rates(crane, q, BEYOND * sense, np.zeros(2), 1e6)
        np.testing.assert_allclose(crane.tip_jacobian(q) @ rates, share * BEYOND * sense, atol=1e-6)
        used = crane.stroke_jacobian(q) @ rates
        low, high = crane.piston_speeds(q).T
        assert (used > low - 1e-9).all() and (used < high + 1e-9).all()
        at_bound = np.isclose(used, low, rtol=1e-6) | np.isclose(used, high, rtol=1e-6)
        assert at_bound.sum() == len(used) - 1


def test_full_spool_gives_the_piston_speed():
    """The law's steady speed is that which the simulated piston reaches; the telescope barely changes its load."""
    q = np.array([START[joint] for joint in LAB.joint_names])
    for i, sense in enumerate((-1.0, 1.0)):
        full = float(sense * LAB.spool_strokes[2])
        run = hc.simulate(
            hc.Scenario(
                machine=LAB,
                joints=START,
                duration=0.8,
                commands={"extension": (np.array([0.0]), np.array([full]))},
            ),
            ledger=False,
        )
        speed = np.median(run.data["cylinder.extension.v"].values[-20:])
        assert speed == pytest.approx(LAB.piston_speeds(q)[2, i], rel=0.1)


def test_the_best_pose_has_room_each_way():
    best = walks(HIAB, start_pose(HIAB))
    assert min(w.length for w in best.values()) == pytest.approx(0.5)
    assert min(w.feasible_speed for w in best.values()) > SPEEDS[2]


def test_the_laboratory_crane_keeps_the_benchmarks_cases():
    names, own = ([(c.task.name, c.condition, c.start) for c in cases] for cases in (quick_cases(), tuning_cases(LAB)))
    assert own[:-1] == names and own[-1] == (names[0][0], LATER, names[0][2])
    np.testing.assert_allclose(start_pose(LAB), list(START.values()))


def test_the_unknown_payload_is_felt_and_carried():
    q = start_pose(HIAB)
    force, loaded = HIAB.static_cylinder_force(q), HIAB.static_cylinder_force(q, payload=unknown_payload(HIAB, q))
    assert np.abs(loaded).max() == pytest.approx(1.1 * np.abs(force).max(), rel=0.01)


def test_the_gains_that_every_machine_has_keep_the_loader_crane_on_its_lines():
    """Its file states none. Before inertia and bristles were fed forward it swung up to 38 mm aside."""
    assert not [key for key in HIAB.keys if key.startswith("control.tip.")]
    for case in tuning_cases(HIAB):
        assert run_case(HIAB, "tip", case).metrics.path_max < 5e-3, case.task.name


def test_every_gain_has_a_unit_in_one_place():
    assert set(LAB.tip_gains) == set(UNITS) and UNITS["observer-bandwidth"] == "rad/s"


def test_a_machine_without_a_plane_of_lines_is_told(capsys):
    with pytest.raises(hc.InputError, match="single-cylinder has no pose"):
        tuning_cases(hc.load_machine("single-cylinder"))
    with pytest.raises(SystemExit) as ended:
        main(["control", "tune", "single-cylinder"])
    assert ended.value.code == 2 and "up, down, out and in" in " ".join(capsys.readouterr().err.split())


def test_the_benchmark_of_another_machine_takes_its_own_lines(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["control", "benchmark", "tip", "--machine", "hiab-xs031", "-o", str(tmp_path)])
    assert not ended.value.code and "out 0.2 m/s" in capsys.readouterr().out
