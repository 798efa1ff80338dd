"""The benchmarks measure what they say: same model, same task, and a page that shows the numbers of the file."""

from __future__ import annotations

import importlib.util
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

from benches import as_called, report, tables  # noqa: E402
from benches.compete import Effort, compete, curve, operating_point  # noqa: E402
from benches.competitors import casadi_cvodes, compiled, exudyn_crane, own, scipy_solvers  # noqa: E402
from benches.measures import batch, growth, laws  # noqa: E402
from benches.models import crane as model  # noqa: E402
from benches.models.chain import write_chain  # noqa: E402
from benches.problem import NotAvailable, Problem, Solution, clocked  # noqa: E402


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("rottne-f9-lab")


@pytest.fixture(scope="module")
def problem():
    return Problem(hc.load_scenario("vertical-lift-open-loop").changed(duration=0.6))


def scaled_difference(crane, states, commands, found):
    """Largest difference of rates over the size of the rate, at least a millionth of the state's size per second."""
    exact = crane.state_derivative(states, commands)
    floor = 1e-6 * np.abs(exact).max(axis=0)
    return (np.abs(found - exact) / np.maximum(np.abs(exact), floor)).max()


def test_the_independent_model_equals_the_core(crane, random_states):
    states, commands = random_states(crane, 300, seed=5)
    numbers = model.parameters(crane)
    found = np.stack([model.state_derivative(x, u, numbers) for x, u in zip(states, commands, strict=True)])
    assert scaled_difference(crane, states, commands, found) < 1e-9


def test_the_independent_model_reads_its_numbers_from_the_machine(crane, random_states):
    heavy = hc.load_machine("rottne-f9-lab", {"link.jib.mass": "35 kg", "fluid.bulk-modulus-max": "1.5 GPa"})
    states, commands = random_states(crane, 20, seed=6)
    numbers = model.parameters(heavy)
    found = np.stack([model.state_derivative(x, u, numbers) for x, u in zip(states, commands, strict=True)])
    assert scaled_difference(heavy, states, commands, found) < 1e-9
    assert scaled_difference(crane, states, commands, found) > 1e-3


def test_the_symbolic_model_equals_the_core(crane, random_states):
    ca = pytest.importorskip("casadi")
    x, u = ca.SX.sym("x", len(crane.state_names)), ca.SX.sym("u", model.JOINTS)
    rate = ca.Function("rate", [x, u], [model.state_derivative(x, u, model.parameters(crane), casadi_cvodes.arrays())])
    states, commands = random_states(crane, 50, seed=7)
    found = np.stack([np.array(rate(x, u)).ravel() for x, u in zip(states, commands, strict=True)])
    assert scaled_difference(crane, states, commands, found) < 1e-9


def test_every_solver_meets_the_reference(problem):
    solvers = own.solvers(problem) | scipy_solvers.on_core(problem)
    for name, solve in solvers.items():
        run = solve(1e-7)
        assert run.states.shape == (problem.record.size, problem.start.size), name
        assert problem.tip_error(run.states) < 1e-6, name
        assert run.seconds > 0 and run.counts["rhs"] > 100, name


def test_compiled_solvers_meet_the_reference(problem):
    """Where their library has been built: that takes minutes, and only benchmarks need it."""
    if not list(compiled.CRATE.glob("target/release/*hydrocrane_solvers.*")):
        pytest.skip("the library of solvers is not built; `make bench` does")
    families = [compiled.diffsol] + ([compiled.cvode] if importlib.util.find_spec("sksundae") else [])
    for family in families:
        for name, solve in family(problem).items():
            run = solve(1e-8)
            assert problem.tip_error(run.states) < 1e-5, name
            assert run.counts["rhs"] > run.counts["steps"] > 100, name


def test_casadi_meets_the_reference(problem):
    pytest.importorskip("casadi")
    if not any(map(shutil.which, ("gcc", "clang", "cc"))):
        pytest.skip("no C compiler")
    run = casadi_cvodes.solvers(problem)["CasADi CVODES"](1e-7)
    assert problem.tip_error(run.states) < 1e-5


def test_exudyn_moves_much_the_same_crane(problem):
    pytest.importorskip("exudyn")
    run = exudyn_crane.Model(problem).run(2e-3)
    apart = np.linalg.norm(run.states - problem.exact, axis=1)
    # It has neither spool dynamics nor bristles: alike, and not equal.
    assert apart[0] < 1e-9 and 1e-5 < apart.max() < 2e-3


def test_the_tip_error_is_the_largest_distance(problem):
    states = problem.integrate("rodas5p", 1e-12)["states"]
    assert problem.tip_error(states) == 0.0
    states[30, 0] += 1e-4
    reach = np.linalg.norm(problem.tip(states)[30] - problem.exact[30])
    assert problem.tip_error(states) == pytest.approx(reach) and reach > 1e-4
    assert problem.tip_error(states[:-1]) == np.inf


def test_a_race_compares_at_equal_error_and_names_what_is_missing(problem, monkeypatch):
    def unavailable(_problem):
        raise NotAvailable("nobody has installed it")

    monkeypatch.setitem(compete.__globals__["FAMILIES"], "CVODE", unavailable)
    families = ("hydrocrane", "CVODE", "SciPy, compiled laws")
    found = compete(problem, Effort(per_decade=1, pairs=3, long_pairs=1), families, say=lambda _line: None)
    assert found["missing"] == {"CVODE": "nobody has installed it"}
    ours = found["rows"][found["ours"]]
    assert ours["tip_error_m"] <= 1e-5
    for name, row in found["rows"].items():
        if row["family"] != "hydrocrane":
            assert row["tip_error_m"] <= ours["tip_error_m"], name
            assert row["ratio_low"] <= row["ratio"] <= row["ratio_high"], name
    assert found["rows"]["SciPy LSODA, compiled laws"]["ratio"] > 1


def test_a_long_run_ends_its_curve_at_the_target(problem):
    asked = []

    def slow(rtol):
        asked.append(rtol)
        states = problem.integrate("rodas5p", rtol)["states"]
        return Solution(states, 1.0)

    points = curve(problem, slow, Effort(per_decade=1), target=1e-5)
    assert points[-1]["tip_error_m"] <= 1e-5 < points[-2]["tip_error_m"] and len(asked) == len(points)
    assert operating_point(points, 1e-5) == points[-1] and operating_point(points, 0.0) is None


def test_the_clock_counts_work_and_not_waiting():
    import time

    idle = clocked(lambda: time.sleep(0.05) or np.zeros((1, 1))).seconds
    assert idle < 0.03


@pytest.mark.parametrize("joints", [1, 2, 6])
def test_a_chain_of_any_length_can_be_run(tmp_path, joints):
    machine = hc.load_machine(write_chain(joints, tmp_path))
    assert len(machine.joint_names) == joints and len(machine.state_names) == 7 * joints
    run = growth.chain_problem(joints, tmp_path).integrate("rodas5p", 1e-4)
    assert run["outcome"][0] == "completed"


def test_laws_cost_something(problem, monkeypatch):
    def unbuilt(_problem):
        raise NotAvailable("not built")

    monkeypatch.setattr(laws, "Task", unbuilt)
    found = laws.measure(problem)
    assert 0 < found["rhs_ns"] < found["dense_jacobian_ns"] and found["rhs_ns"] < found["rhs_one_python_call_ns"]


def test_random_manoeuvres_start_at_rest_inside_the_limits(crane):
    start, commands = batch.manoeuvres(crane, 5)
    low, high = crane.joint_limits.T
    assert ((start[:, :3] > low) & (start[:, :3] < high)).all() and (start[:, 3:6] == 0).all()
    assert (np.abs(commands) <= 0.5 * crane.spool_strokes).all() and commands.shape == (10, 5, 3)


def test_the_page_shows_the_numbers_of_the_file():
    results = json.loads(report.RESULTS.read_text(encoding="utf-8"))
    assert report.PAGE.read_text(encoding="utf-8") == report.page(results), "run python -m benches.report"
    assert report.PICTURE.is_file()


def test_the_page_says_what_was_not_measured():
    results = json.loads(report.RESULTS.read_text(encoding="utf-8"))
    results["exudyn"] = {"not_available": "exudyn is not installed"}
    del results["growth"]
    text = report.page(results)
    assert "Not measured: exudyn is not installed." in text and "Not measured.\n" in text


@pytest.mark.parametrize(
    "value, text", [(0.1234, "0.123"), (12.34, "12.3"), (1234.5, "1234"), (0, "0"), (3e-5, "0.0000300")]
)
def test_numbers_are_rounded_for_readers(value, text):
    assert tables.digits(value) == text


def test_calls_of_two_checkouts_are_compared_pair_by_pair():
    found = [[{"call": 1e-3}, {"call": 3e-3}], [{"call": 2e-3}, {"call": 4e-3}], [{"call": 4e-3}, {"call": 8e-3}]]
    figures = as_called.summary(found)
    assert figures == {"call": {"seconds": 1e-3, "other_seconds": 3e-3, "ratio": 2.0}}
    assert as_called.printed(figures).endswith("| `call` | 1.00 | 3.00 | 2.00 |")
    alone = as_called.summary([[{"call": 1e-3}]])
    assert as_called.printed(alone).endswith("| `call` | 1.00 |")
