"""The benchmark of tip control: figures are right where the answer is known, runs repeat, files are whole."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.app import control
from hydrocrane.app.cli import main
from hydrocrane.benchmark import tasks
from hydrocrane.benchmark.cases import Case, Result, quick_cases, run_case, scenario_of
from hydrocrane.benchmark.conditions import VARIANTS, Condition, friction_overrides
from hydrocrane.benchmark.fitted_tasks import walk
from hydrocrane.benchmark.metrics import TipMotion, metrics, nearest_on_path, significant
from hydrocrane.benchmark.random_tasks import random_lines
from hydrocrane.benchmark.suite import MACHINE, RANDOM_LINES, Benchmark, all_cases, benchmark
from hydrocrane.plots.benchmark import control_benchmark

pytestmark = pytest.mark.evidence

EVERY_TASK = [*tasks.lines(), tasks.square(), tasks.circle(), tasks.reach(), tasks.pick_and_place()]


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine(MACHINE)


@pytest.fixture(scope="module")
def quick(crane):
    return benchmark(["tip"], quick_cases(), machine=crane, seed=3)


def followed(task, *, offset=(0.0, 0.0), late=0.0):
    """A made-up motion: the tip goes where it is asked to, `offset` (m) aside and `late` (s)."""
    time = np.arange(0.0, task.duration, 1e-3)

    def at(table, t):
        return np.column_stack([np.interp(t, task.time, column) for column in table.T])

    still = np.zeros_like(time)
    return TipMotion(
        time=time,
        tip=at(task.displacement, time - late) + offset,
        tip_velocity=at(task.velocity, time - late),
        asked=at(task.displacement, time),
        asked_velocity=at(task.velocity, time),
        set_point=at(task.displacement, time - late),
        command=np.zeros((time.size, 3)),
        power=still + 50.0,
        end_stops=still,
    )


# --- tasks ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("task", EVERY_TASK, ids=lambda task: task.name)
def test_a_task_asks_for_what_its_stick_can_say(task):
    """Deflections within the stick's range, full at the task's speed, and centred at both ends."""
    deflections = np.column_stack(list(task.deflections.values()))
    assert np.hypot(*deflections.T).max() == pytest.approx(1.0, abs=1e-5)
    assert not deflections[0].any() and not deflections[-1].any()
    assert (np.diff(task.time) > 0).all() and task.moving_time < task.duration - 1.0
    steps = np.diff(task.velocity, axis=0) / np.diff(task.time)[:, np.newaxis]
    assert np.hypot(*steps.T).max() < 1.01 * task.speed * np.hypot(1 / tasks.RAMP, task.speed / tasks.RADIUS)


@pytest.mark.parametrize(
    ("task", "end", "largest"),
    [
        (tasks.lines()[0], (0.0, tasks.LINE), (0.0, tasks.LINE)),
        (tasks.square(), (0.0, 0.0), (tasks.SIDE, tasks.SIDE)),
        (tasks.circle(), (0.0, 0.0), (2 * tasks.RADIUS, tasks.RADIUS)),
        (tasks.reach(), (0.0, 0.0), (-tasks.REACH[0], 0.0)),
        (tasks.pick_and_place(), (0.0, 0.0), (0.46, 0.3)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_stick_integrates_to_the_shape(task, end, largest):
    way = task.displacement
    np.testing.assert_allclose(way[-1], end, atol=1e-6)
    np.testing.assert_allclose(np.abs(way).max(axis=0), largest, atol=1e-5)


def test_the_log_is_taken_up_on_a_slow_way_and_let_go_at_rest():
    task = tasks.pick_and_place()
    taken, released = task.carries
    speed = np.interp(task.time, task.time, np.hypot(*task.velocity.T))
    assert np.interp(taken, task.time, speed) == pytest.approx(tasks.GRIP_SPEED, rel=1e-3)
    assert np.interp(released, task.time, speed) == 0.0
    places = [[np.interp(t, task.time, column) for column in task.displacement.T] for t in task.carries]
    np.testing.assert_allclose(places, [(0.03, -0.3), (0.46, -0.2)], atol=1e-3)


def test_the_circle_is_round():
    way = tasks.circle().displacement + (tasks.RADIUS, 0.0)
    np.testing.assert_allclose(np.hypot(*way.T), tasks.RADIUS, atol=1e-5)


def test_every_path_lies_in_the_workspace(crane):
    tip = crane.tip([np.radians(100.0), np.radians(100.0), 0.0])
    for task in EVERY_TASK:
        places = tip + task.displacement[::20]
        poses = [[pose for x3 in (-0.2, 0.0, 0.2) for pose in crane.inverse_kinematics(p, x3=x3)] for p in places]
        assert all(poses), task.name


# --- figures --------------------------------------------------------------------------------------------------------


def test_a_perfect_motion_has_no_error():
    for task in (tasks.lines()[4], tasks.square(), tasks.circle()):
        found = metrics(followed(task))
        assert found.path_max < 1e-9 and found.rho < 1e-12 and found.speed_error < 1e-12
        assert found.reached > 0.99 and found.score > 0.99
        assert found.energy == pytest.approx(50.0 * task.duration, rel=1e-3)
        assert found.end_stop_hits == 0 and found.spool_rms == 0
        assert task.moving_time - 0.1 < found.time <= task.moving_time


@pytest.mark.parametrize("task", EVERY_TASK, ids=lambda task: task.name)
def test_a_tip_that_stands_reaches_nothing(task):
    """Also where the path ends at its start, and with a tip that shivers."""
    motion = followed(task)
    shiver = 1e-4 * np.sin(50.0 * motion.time)[:, np.newaxis]
    found = metrics(replace(motion, tip=motion.asked[0] + shiver, tip_velocity=0.0 * motion.tip_velocity))
    assert found.reached < 0.01 and found.score < 0.01


def test_a_tip_that_never_rests_scores_below_one_that_stands():
    """The score was 92 % beside a crane that shakes."""
    motion = followed(tasks.lines()[0])
    shake = 0.05 * np.sin(50.0 * motion.time)[:, np.newaxis]
    shaken = metrics(replace(motion, tip_velocity=motion.tip_velocity + shake))
    stands = metrics(replace(motion, tip=motion.asked[0] + 0.0 * motion.tip, tip_velocity=0.0 * motion.tip_velocity))
    assert shaken.path_rms < 1e-9 and shaken.score < -0.3 < stands.score < 0.01
    # One that comes to rest a second later loses a third.
    late = np.where((motion.time < motion.time[-1] - 1.0)[:, np.newaxis], 0.006 * np.ones(2), 0.0)
    found = metrics(replace(motion, tip_velocity=motion.tip_velocity + late))
    assert found.score == pytest.approx(1.0 / (1.0 + found.settling / 2.0), rel=0.01) and found.settling > 0.1


@pytest.mark.parametrize("share", [0.25, 0.6])
def test_a_tip_that_stops_short_reaches_its_share(share):
    motion = followed(tasks.square())
    stopped = np.argmax(np.hypot(*np.diff(motion.tip, axis=0).T).cumsum() > share * 4 * tasks.SIDE)
    tip = motion.tip.copy()
    tip[stopped:] = tip[stopped]
    assert metrics(replace(motion, tip=tip)).reached == pytest.approx(share, abs=0.01)


def test_being_late_is_no_deviation_but_an_error():
    """At constant speed v a delay T leaves the tip v T behind: rho = T, whatever v."""
    for task in tasks.lines():
        found = metrics(followed(task, late=0.05))
        assert found.path_max < 1e-12
        assert found.rho == pytest.approx(0.05, rel=1e-9)
        assert found.rho_set_point < 1e-12


def test_being_aside_is_deviation():
    found = metrics(followed(tasks.lines()[0], offset=(3e-3, 1e-3)))
    assert found.path_max == pytest.approx(3e-3) and found.path_rms == pytest.approx(3e-3)
    assert found.end_error == pytest.approx(np.hypot(3e-3, 1e-3))
    assert found.rho_set_point == pytest.approx(found.end_error / tasks.SPEEDS[0], rel=1e-6)


def test_distance_from_a_corner_and_beyond_the_ends():
    path = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0]])
    points = np.array([[0.3, -0.2], [1.3, -0.4], [-2.0, 0.1], [1.1, 7.0]])
    nearest = nearest_on_path(points, path)
    np.testing.assert_allclose(nearest, [[0.3, 0.0], [1.0, -0.0], [-2.0, 0.0], [1.0, 7.0]], atol=1e-12)
    closed = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]])
    np.testing.assert_allclose(nearest_on_path(np.array([[-1.0, 0.0]]), closed), [[0.0, 0.0]])
    np.testing.assert_allclose(nearest_on_path(points, np.zeros((5, 2))), np.zeros((4, 2)))


def test_effort_and_hits_are_counted():
    motion = followed(tasks.lines()[1])
    turn = 2 * np.pi * motion.time
    wave = np.sin(turn)[:, np.newaxis] * [1.0, 0.5, 0.0]
    stops = 2.0 * (np.sin(turn / 2) > 0.5)
    found = metrics(replace(motion, command=wave, end_stops=stops, set_point=None))
    assert found.spool_travel == pytest.approx(4.0 * 1.5 / 3, rel=0.02)
    assert found.spool_rms == pytest.approx(np.sqrt((0.5 + 0.125) / 3), rel=0.02)
    assert found.end_stop_hits == 4
    assert np.isnan(found.rho_set_point)


def test_a_tip_that_never_rests_has_no_time():
    motion = followed(tasks.lines()[0])
    assert np.isnan(metrics(replace(motion, tip_velocity=motion.tip_velocity + 0.01)).time)


@pytest.mark.parametrize(("value", "text"), [(0.0, "0.00"), (0.2753, "0.28"), (-15.58, "-15.6"), (1333.2, "1333")])
def test_numbers_of_the_table(value, text):
    assert significant(value) == text


# --- runs -----------------------------------------------------------------------------------------------------------


def test_tip_keeps_to_the_lines(quick):
    """Within 5 mm on ideal sensors also where the stick asks for more than the pump gives, 20 mm on real ones."""
    assert [result.outcome.kind for result in quick.results] == ["completed"] * 3
    slow, fast, real = (result.metrics for result in quick.results)
    assert slow.path_max < 5e-3 and slow.path_rms < 2e-3
    assert fast.path_max < 10e-3
    assert real.path_max < 20e-3 and real.path_rms < 8e-3


def test_the_slow_line_ends_where_the_stick_says(quick):
    """The stick's full speed reaches the controller: a speed the valves can give leads to the line's end."""
    slow = quick.results[0].metrics
    assert slow.end_error < 0.01
    assert slow.speed_error < 0.25


def test_the_thesis_controller_is_worse(crane, quick):
    slow = quick.results[0]
    theirs = run_case(crane, "heinze-pid", slow.case)
    assert theirs.metrics is not None and theirs.metrics.path_max > 20 * slow.metrics.path_max


def test_runs_repeat_by_their_seed(crane, quick):
    again, other = (run_case(crane, "tip", quick.results[2].case, seed=seed) for seed in (3, 4))
    assert again.row == quick.results[2].row
    assert other.metrics != again.metrics


def test_a_controller_of_ones_own_is_measured(crane):
    def idle(obs, command):
        return np.zeros(3)

    task = tasks.lines()[2]
    found = run_case(crane, idle, Case(task))
    assert found.controller == "idle" and found.outcome.kind == "completed"
    assert found.metrics.path_max < 5e-3
    assert found.metrics.end_error == pytest.approx(tasks.LINE, abs=5e-3)
    assert np.isnan(found.metrics.rho_set_point) and found.row["rho_set_point"] is None
    assert found.score < 0.01 and found.row["remark"] == "stands still: 0% of the path"


def test_a_controller_that_does_nothing_comes_last_of_those_that_rest(crane):
    def idle(obs, command):
        return np.zeros(3)

    cases = [Case(tasks.lines()[2]), Case(tasks.square())]
    found = benchmark([idle, "heinze-pid", "pi", "tip"], cases, machine=crane)
    # The thesis's controller drifts for ever.
    assert list(found.standings) == ["tip", "pi", "idle", "heinze-pid"]
    assert found.standings["heinze-pid"] < 0.0 <= found.standings["idle"] < 0.01 < found.standings["pi"]
    assert found.standings["tip"] > 0.5
    assert control.benchmark_table(found).columns[0]._cells[::2] == list(found.standings)
    assert "idle 0% (never moves the tip)" in control._standings(found)


def test_an_exception_in_a_controller_is_a_result(crane):
    def broken(obs, command):
        raise ArithmeticError("lost it")

    found = run_case(crane, broken, Case(tasks.lines()[2]))
    assert found.outcome.kind == "controller-failed" and "ArithmeticError: lost it" in found.message


def test_a_controller_that_fails_is_a_result(crane):
    def broken(obs, command):
        return [0.0]

    found = run_case(crane, broken, Case(tasks.lines()[2]))
    assert found.outcome.kind == "controller-failed" and "1 spool commands for 3" in found.message


def test_conditions_reach_the_run(crane):
    case = Case(tasks.circle(), Condition(payload=200.0, sensors="data-sheet", period=0.02, friction=2.0))
    plan = scenario_of(crane, "tip", case, seed=5)
    assert (plan.payload, plan.sensors, plan.period, plan.seed) == (200.0, "data-sheet", 0.02, 5)
    assert str(case.condition) == "200 kg, data-sheet, 20 ms, friction x 2"


def test_the_log_hangs_on_the_tip_from_the_grip_to_the_release(crane):
    case = Case(tasks.pick_and_place(), Condition(payload=100.0))
    plan = scenario_of(crane, "tip", case)
    assert plan.payload == 0.0 and list(plan.payload_changes.values()) == [100.0, 0.0]
    found = run_case(crane, "tip", case)
    assert found.outcome.kind == "completed" and found.metrics.path_max < 0.015 and found.metrics.end_error < 0.005


def test_friction_is_unknown_to_the_controller(crane):
    plan = scenario_of(crane, "tip", Case(tasks.circle(), Condition(friction=2.0)))
    true = plan.load_machine()
    model = plan.controller_model
    v = np.array([-0.05, 0.05])
    np.testing.assert_allclose(true.friction_map(v), 2.0 * crane.friction_map(v))
    np.testing.assert_array_equal(model.friction_map(v), crane.friction_map(v))


@pytest.mark.parametrize("source", [MACHINE, "heinze-2007", "child.toml"])
def test_friction_is_scaled_at_every_speed(source, tmp_path, monkeypatch):
    """Also where the file says nothing of friction itself, and on top of overrides."""
    monkeypatch.chdir(tmp_path)
    value = '{ value = ["90 N", "95 N"], class = "assumed", source = "test" }'
    child = f'extends = "{MACHINE}"\n[machine]\nname = "child"\n[friction.lift]\ncoulomb = {value}\n'
    Path("child.toml").write_text(child, encoding="utf-8")
    one = hc.load_machine(
        source, {"friction.jib.coulomb": ["100 N", "150 N"], "friction.jib.breakaway": [200.0, 250.0]}
    )
    doubled = hc.load_machine(source, {**one.overrides, **friction_overrides(one, 2.0)})
    v = np.array([-0.2, -0.02, 1e-4, 0.05])
    for cylinder in one.cylinder_names:
        np.testing.assert_allclose(doubled.friction_map(v, cylinder), 2.0 * one.friction_map(v, cylinder), rtol=1e-9)
    assert friction_overrides(one, 1.0) == {}


def test_every_condition_of_the_benchmark_is_there(crane):
    cases = all_cases(crane)
    conditions = {case.condition for case in cases}
    assert {c.payload for c in conditions} == {0.0, 100.0, 200.0}
    assert {c.friction for c in conditions} == {0.5, 1.0, 2.0}
    assert {c.sensors for c in conditions} == {"ideal", "data-sheet"}
    assert {c.period for c in conditions} == {None, 0.01, 0.02, 0.05, 0.1}
    assert {c.variant for c in conditions} == {"", *VARIANTS} and {c.drop_out for c in conditions} == {0.0, 0.05}
    drawn = [case for case in cases if case.task.name.startswith("random")]
    names = {case.task.name for case in cases} - {case.task.name for case in drawn}
    assert names == {task.name for task in EVERY_TASK}
    assert len(drawn) == 3 * RANDOM_LINES and {c.condition.sensors for c in drawn} == {"ideal", "data-sheet"}
    assert {c.condition.variant for c in drawn} == {"", "joint sensors only"}


def stated(machine, key):
    """A value that a machine states, SI, or one of several choices."""
    return machine.value(key).si if key in machine.keys else machine.overrides.get(key)


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_variant_changes_the_crane_and_the_controller_model_only_where_it_is_known(crane, variant):
    condition = Condition(variant=variant)
    plan = scenario_of(crane, "tip", Case(tasks.lines()[1], condition))
    changed = condition.overrides(crane)
    assert changed
    for key, value in changed.items():
        assert stated(plan.load_machine(), key) == pytest.approx(value)
        assert (stated(plan.controller_model, key) == pytest.approx(value)) == VARIANTS[variant].known


def test_a_drop_out_takes_every_joint_sensor_in_the_middle_of_the_motion(crane):
    task = tasks.lines()[1]
    plan = scenario_of(crane, "tip", Case(task, Condition(drop_out=0.05)))
    assert {fault.signal for fault in plan.sensor_faults} == {f"joint.{joint}.q" for joint in crane.joint_names}
    assert all(fault.until - fault.time == pytest.approx(0.05) for fault in plan.sensor_faults)
    assert all(0.0 < fault.time < task.moving_time for fault in plan.sensor_faults)


def test_a_condition_that_is_none_is_told():
    with pytest.raises(hc.InputError, match="dead band 5 %"):
        Condition(variant="dead band 5")
    with pytest.raises(hc.InputError, match="drop-out"):
        Condition(drop_out=-1.0)


# --- random lines and the simple controller -------------------------------------------------------------------------


@pytest.mark.parametrize("name", [MACHINE, "hiab-xs031"])
def test_random_lines_repeat_and_are_feasible(name):
    machine = hc.load_machine(name)
    lines, again, others = (random_lines(machine, 6, seed=seed) for seed in (4, 4, 5))
    assert [c.start for c in lines] == [c.start for c in again] != [c.start for c in others]
    for case in lines:
        found = walk(machine, case.start, case.task.displacement[-1] / np.linalg.norm(case.task.displacement[-1]))
        assert case.task.speed < found.feasible_speed + 1e-9
        assert machine.piston_speeds(np.array(case.start)).all()
    with pytest.raises(hc.InputError, match="at least 1"):
        random_lines(machine, 0)


def test_a_machine_without_lines_has_no_random_ones():
    with pytest.raises(hc.InputError, match="few straight lines"):
        random_lines(hc.load_machine("single-cylinder"), 3)


@pytest.mark.parametrize(("name", "most"), [(MACHINE, 1e-3), ("hiab-xs031", 1e-2), ("sany-sy19e", 1e-2)])
def test_random_lines_are_followed(name, most):
    machine = hc.load_machine(name)
    worst = [run_case(machine, "tip", case).metrics.path_max for case in random_lines(machine, 30, seed=3)]
    assert np.median(worst) < 0.2 * most and np.percentile(worst, 95) < most and max(worst) < 2.0 * most


def test_the_simple_controller_goes_the_way_and_is_no_match(crane):
    found = benchmark(["pi", "tip"], quick_cases()[:1], machine=crane)
    simple, tip = (result.metrics for result in found.results)
    assert found.results[0].controller == "pi" and found.results[0].outcome.completed
    assert simple.reached > 0.99 and 5e-4 < simple.path_max < 2e-2 and tip.path_max < 0.5 * simple.path_max
    assert simple.vibration < 1e-3


def test_the_simple_controller_holds_its_last_readings(crane):
    line = tasks.lines()[1]
    found, undisturbed = benchmark(["pi"], [Case(line, Condition(drop_out=0.05)), Case(line)], machine=crane).results
    assert found.outcome.completed and found.metrics.reached > 0.99
    assert found.metrics.path_rms != undisturbed.metrics.path_rms
    assert found.metrics.path_max < undisturbed.metrics.path_max + 1e-3


def test_without_pressures_one_that_needs_them_is_refused_and_says_so(crane):
    case = Case(tasks.lines()[1], Condition(variant="joint sensors only"))
    results = {
        result.controller: result for result in benchmark(["tip", "pi", "heinze-pid"], [case], machine=crane).results
    }
    assert results["tip"].outcome.completed and results["tip"].metrics.path_max < 1e-3
    assert results["heinze-pid"].outcome.completed
    refused = results["pi"]
    assert refused.metrics is None and refused.score == 0.0
    assert "chamber pressure" in refused.message


def test_settling_counts_from_the_centred_stick():
    motion = followed(tasks.lines()[4], late=0.3)
    found = metrics(motion)
    assert found.settling == pytest.approx(0.3, abs=0.02) and found.vibration == 0.0
    assert metrics(replace(motion, tip_velocity=motion.tip_velocity + 0.01)).vibration > 0.01


# --- output ---------------------------------------------------------------------------------------------------------


def test_files_hold_every_run(quick, tmp_path):
    table, text = quick.save(tmp_path / "new")
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    content = json.loads(text.read_text(encoding="utf-8"))
    assert content["machine"] == MACHINE and content["seed"] == 3
    for row, entry, result in zip(rows, content["results"], quick.results, strict=True):
        assert entry == result.row
        assert float(row["path_max"]) == result.metrics.path_max


def test_the_page_is_drawn_with_refused_runs_too(quick, tmp_path):
    refused = Result("other", quick.results[0].case, hc.Outcome("refused", 0.0, "no such period"))
    figure = control_benchmark(Benchmark(MACHINE, 3, (*quick.results, refused)))
    figure.savefig(tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 10_000
    with pytest.raises(hc.InputError, match="nothing to draw"):
        control_benchmark(Benchmark(MACHINE, 3, (refused,)))


def test_the_command_prints_and_writes(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["control", "benchmark", "tip", "--quick", "-o", str(tmp_path)])
    assert not ended.value.code
    out = capsys.readouterr().out
    assert "out 0.2 m/s" in out and "100 kg, data-sheet" in out and "mean score: tip" in out
    assert {p.name for p in tmp_path.iterdir()} == {f"control-benchmark.{suffix}" for suffix in ("csv", "json", "png")}


def test_runs_that_do_not_come_to_their_end_are_told(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["control", "benchmark", "lever", "--quick", "-o", str(tmp_path)])
    assert ended.value.code == 1
    told = " ".join(capsys.readouterr().out.split())
    assert told.count("refused; controller `lever` does not support the stick mode `tip`") == 4
    assert not (tmp_path / "control-benchmark.png").exists()


def test_wrong_input_is_one_message(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["control", "benchmark", "tipp", "--quick"])
    assert ended.value.code == 2
    assert "did you mean `tip`?" in " ".join(capsys.readouterr().err.split())
    with pytest.raises(hc.InputError, match="boom, jib, extension"):
        benchmark(["tip"], quick_cases(), machine="single-cylinder")
    with pytest.raises(hc.InputError, match="seed must be"):
        benchmark(["tip"], quick_cases(), seed=-1)
    with pytest.raises(hc.InputError, match="one controller"):
        benchmark([], quick_cases())


def test_slow_sampling_and_slow_spools_cost_little(crane):
    """A correction of the path that is more than whole in a period made 113 mm at 100 ms."""
    line = next(task for task in tasks.lines() if task.name == "out 0.1 m/s")
    for condition in (Condition(period=0.1), Condition(variant="spools of 8 Hz"), Condition(variant="dead time 50 ms")):
        found = run_case(crane, "tip", Case(line, condition)).metrics
        assert found.reached > 0.99 and found.path_max < 2e-3, condition
