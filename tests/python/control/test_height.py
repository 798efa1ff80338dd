"""Levers move their joints while one joint holds the tip's height within millimetres, or all stop and say why."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

CRANE = hc.load_machine("rottne-f9-lab")
START = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
JOINTS = list(START)


def run_of(levers: dict[str, list[float]], **changes: object) -> hc.Run:
    """The levers out at 0.5 s and centred at 3.5 s."""
    stick = hc.Joystick([0.5, 3.5], levers, mode="height")
    return hc.simulate(hc.Scenario(**{"joints": START, "joystick": stick, "duration": 6.0, **changes}))


def joints(run: hc.Run) -> np.ndarray:
    return np.column_stack([run.columns[f"joint.{name}.q"].values for name in JOINTS])


def height(run: hc.Run) -> np.ndarray:
    z = run.columns["tip.z"].values
    return z - z[0]


@pytest.mark.parametrize("payload", [0.0, 100.0])
@pytest.mark.parametrize(("sensors", "most"), [("ideal", 1e-3), ("data-sheet", 4e-3)])
@pytest.mark.parametrize(
    "levers", [{"lift": [0.9, 0.0]}, {"lift": [-0.9, 0.0]}, {"jib": [0.9, 0.0]}, {"jib": [-0.9, 0.0]}]
)
def test_the_telescope_follows_and_the_height_holds(levers, sensors, most, payload) -> None:
    run = run_of(levers, payload=payload, sensors=sensors, seed=1)
    moved = joints(run) - joints(run)[0]
    out, still = (0, 1) if "lift" in levers else (1, 0)
    assert np.abs(height(run)).max() < most
    assert abs(moved[-1, out]) > np.deg2rad(1.5) and abs(moved[-1, 2]) > 0.08
    # What is not asked to move keeps its angle, as far as its sensor tells it.
    assert np.abs(moved[:, still]).max() < np.deg2rad(0.02 if sensors == "ideal" else 0.15)
    assert np.ptp(run.columns["set_point.z"].values[:-1]) < 1e-9


def test_both_levers_at_once_are_slowed_down_together_where_the_telescope_cannot_follow() -> None:
    ratios, speeds = [], []
    for share in (0.1, 1.0):
        run = run_of({"lift": [share, 0.0], "jib": [-0.75 * share, 0.0]})
        assert np.abs(height(run)).max() < 1e-3
        lift, jib = (np.ptp(run.columns[f"cylinder.{c}.x"].values[90:110]) for c in ("lift", "jib"))
        ratios.append(lift / jib)
        speeds.append(lift)
    assert ratios[1] == pytest.approx(ratios[0], rel=0.03)
    assert 2 < speeds[1] / speeds[0] < 5, "together they ask the telescope for more than it has"


def test_the_lever_of_the_telescope_itself_changes_the_height_that_is_held() -> None:
    run = run_of({"extension": [0.3, 0.0]})
    moved = joints(run)[-1] - joints(run)[0]
    assert moved[2] > 0.02 and np.abs(moved[:2]).max() < 1e-3
    off = run.columns["tip.z"].values - run.columns["set_point.z"].values
    assert height(run)[-1] < -0.02 and np.abs(off[:-1]).max() < 1e-3


def test_another_joint_holds_the_height_where_the_file_says_so() -> None:
    run = run_of({"lift": [0.6, 0.0]}, overrides={"control.tip.height-joint": "jib"})
    moved = joints(run)[-1] - joints(run)[0]
    assert np.abs(height(run)).max() < 2e-3
    assert moved[0] > np.deg2rad(2) and abs(moved[1]) > np.deg2rad(2) and abs(moved[2]) < 1e-3


def test_at_the_end_of_the_telescope_everything_stops_and_an_event_says_why() -> None:
    run = run_of({"lift": [-1.0, -1.0]}, duration=10.0)
    assert np.abs(height(run)).max() < 1e-3
    assert [event.text for event in run.events] == [
        "the tip stands or hardly moves although the stick is deflected: the straight line leads "
        "out of the range of the joints: joint `extension`; steer another way"
    ]
    assert np.abs(np.diff(joints(run)[-50:, 0])).max() < np.deg2rad(0.002)


def test_a_telescope_that_lies_level_lets_nothing_lower_the_tip() -> None:
    """Along a level jib the telescope holds no height: what is left is to stop."""
    level = {"boom": np.deg2rad(100), "jib": np.deg2rad(169), "extension": 0.0}
    direction = CRANE.tip_jacobian(list(level.values()))[:, 2]
    assert abs(direction[1]) < 0.03
    for sense in (-1.0, 1.0):
        run = run_of({"lift": [sense, sense]}, joints=level)
        assert np.abs(height(run)).max() < 5e-3


def test_the_way_into_a_region_ends_before_it() -> None:
    tip = CRANE.tip(list(START.values()))
    x, z = tip[0] - 0.15, tip[1]
    wall = [f"({a}, {b}) m" for a, b in ((x, z - 1), (x, z + 1), (x - 0.02, z + 1), (x - 0.02, z - 1))]
    run = run_of({"jib": [0.6, 0.6]}, overrides={"keep-out.pillar.outline": wall})
    assert np.abs(height(run)).max() < 1e-3
    assert run.columns["tip.x"].values.min() > x + 0.045
    assert "a keep-out region lies ahead" in run.events[-1].text


def test_random_levers_and_a_soft_machine_stay_bounded() -> None:
    rng = np.random.default_rng(7)
    times = np.arange(0.5, 6.0, 0.75)
    levers = {name: np.append(rng.uniform(-1, 1, times.size - 1), 0.0) for name in ("lift", "jib")}
    for sensors, most in (("ideal", 5e-3), ("data-sheet", 6e-3)):
        run = hc.simulate(
            hc.Scenario(joints=START, joystick=hc.Joystick(times, levers, mode="height"), sensors=sensors, duration=8.0)
        )
        assert run.outcome.completed and np.abs(height(run)).max() < most


def test_a_goal_and_levers_take_turns_without_a_jump_of_the_speed() -> None:
    stick = hc.Joystick([3.0, 4.0, 4.05], {"lift": [0.4, 0.4, 0.0]}, mode="height")
    tip = CRANE.tip(list(START.values()))
    goals = [hc.Goal(0.2, tip[0] - 0.3, tip[1] + 0.1, speed=0.1), hc.Goal(4.05, tip[0], tip[1])]
    run = hc.simulate(hc.Scenario(joints=START, joystick=stick, goals=goals, duration=9.0))
    texts = [event.text for event in run.events]
    assert texts[0].startswith("the stick takes over") and texts[-1].startswith("the tip has reached its goal")
    x = np.column_stack([run.columns["set_point.x"].values, run.columns["set_point.z"].values])[:-1]
    jumps = np.abs(np.diff(x, 2, axis=0)).max() / 0.01
    # The lags of the stick change the speed of the levers by this much in a sample.
    assert jumps < 0.3 * 15 / 2.7 * 0.01 + 0.02


def test_the_mode_stands_in_a_file_and_is_driven_live(tmp_path) -> None:
    live = hc.LiveSimulator(hc.Scenario(joints=START, joystick=hc.Joystick([], {}, mode="height")))
    before = live.step().tip
    live.set_stick(lift=0.4)
    live.step(1.0)
    live.set_stick()
    assert live.step(1.0).tip[1] == pytest.approx(before[1], abs=1e-3)
    saved = hc.load_scenario(live.scenario().save(tmp_path / "drive.toml"))
    assert saved.joystick.mode == "height" and saved.driver == "tip"
    run = hc.simulate(saved)
    assert np.abs(height(run)).max() < 1e-3 and run.columns["tip.x"].values[-1] != before[0]


def test_a_phase_changes_between_levers_with_and_without_the_height() -> None:
    raw = hc.Joystick([0.0, 2.0], {"lift": [0.1, 0.0]}, mode="lever")
    held = hc.Joystick([0.5, 2.0], {"lift": [0.3, 0.0]}, mode="height")
    run = hc.simulate(hc.Scenario(joints=START, joystick=held, phases=[hc.Phase(3.0, joystick=raw)], duration=4.0))
    assert (
        [stage.driver for _, stage in run.scenario.stages()] == ["tip", "lever"] if hasattr(run, "scenario") else True
    )
    assert np.abs(height(run)[:300]).max() < 1e-3


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (
            lambda: hc.Scenario(joints=START, controller="lever", joystick=hc.Joystick([0], {}, mode="height")),
            "does not support",
        ),
        (
            lambda: hc.Scenario(joints=START, controller="heinze-pid", joystick=hc.Joystick([0], {}, mode="height")),
            "does not",
        ),
        (lambda: hc.Joystick([0], {}, mode="hight"), "height"),
        (lambda: run_of({"x": [0.5, 0.0]}), r"unknown stick axis `x`"),
        (lambda: run_of({}, overrides={"control.tip.height-joint": "telescope"}), "there is no joint `telescope`"),
    ],
)
def test_what_does_not_fit_is_an_error(make, why) -> None:
    with pytest.raises(hc.HydrocraneError, match=why):
        make()


def test_a_file_whose_controller_does_not_hold_heights_is_an_error(tmp_path) -> None:
    path = tmp_path / "levers.toml"
    path.write_text(
        '[scenario]\nname = "s"\nmachine = "rottne-f9-lab"\nduration = "1 s"\n[initial.joint]\nboom = "100 deg"\n'
        'jib = "100 deg"\nextension = "0 mm"\n[controller]\nname = "lever"\n[joystick]\nmode = "height"\n'
        'time = ["0 s"]\nlift = [0.5]\n'
    )
    with pytest.raises(hc.MachineFileError, match="`lever` needs the stick mode `lever`, the joystick has `height`"):
        hc.load_scenario(path)
