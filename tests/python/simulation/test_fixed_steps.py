"""Fixed steps from Python: runs, closed loops, the stepping interface, scenario files, and what they cost."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.errors import MachineFileError
from hydrocrane.results.energy import energy_balance

# Accepted and rejected steps of bundled runs, with the room that rounding needs to move a step size.
EFFORT = {
    ("vertical-lift-open-loop", "rodas5p"): (851, 25),
    ("vertical-lift-open-loop", "hc-exponential-4"): (620, 145),
    ("vertical-lift-open-loop", "tsit5"): (1678, 121),
    ("hiab-lift", "rodas5p"): (241, 68),
    ("single-cylinder-step", "rodas5p"): (471, 36),
    ("tip-vertical-line", "rodas5p"): (3281, 496),
}
FIXED = {"method": "hc-rosenbrock-3", "step": 5e-3}


def tip(run):
    return np.stack([run.data["tip.x"], run.data["tip.z"]], axis=-1)


def apart(one, other):
    """Largest distance of the tips at the recorded times, m."""
    return np.linalg.norm(tip(one) - tip(other), axis=-1).max()


def test_a_summary_states_how_far_the_tip_is_off_or_that_nobody_knows():
    for solver in (hc.Solver(), hc.Solver(step=0.01)):
        run = hc.simulate("hiab-lift", ledger=False, solver=solver)
        exact = hc.simulate("hiab-lift", ledger=False, method="rodas5p", rtol=1e-9)
        assert 0.1 * apart(run, exact) < run.data.attrs["tip_error"] < 1e-3
        assert "put the tip off by at most" in run.summary()
    line = hc.simulate("tip-vertical-line", duration=0.1)
    assert "tip_error" not in line.data.attrs
    assert "not estimated under a controller; `verify`" in line.summary()


@pytest.mark.parametrize("friction", ["lugre", "static"])
def test_fixed_steps_by_default_keep_a_drive_within_a_millimetre(friction):
    names = hc.load_machine("hiab-xs031").cylinder_names
    crane = hc.load_machine("hiab-xs031", {f"friction.{name}.model": friction for name in names})
    times = np.arange(0.0, 4.0, 0.5)
    shares = np.random.default_rng(1).choice([-1.0, -0.5, 0.0, 0.5, 1.0], (len(times), 3))
    spools = zip(crane.cylinder_names, (shares * crane.spool_strokes).T, strict=True)
    joints = dict(zip(crane.joint_names, map(float, crane.home), strict=True))
    commands = {c: hc.Command(times, s, "hold") for c, s in spools}
    plan = hc.Scenario(machine=crane, joints=joints, commands=commands, duration=4.0)
    exact = hc.simulate(plan, method="rodas5p", rtol=1e-9, ledger=False)
    run = hc.simulate(plan, step=5e-3, ledger=False)
    assert run.data.attrs["solver_method"] == "hc-exponential-4"
    assert apart(run, exact) < 1e-3


@pytest.mark.parametrize(("scenario", "method"), EFFORT)
def test_effort_of_bundled_runs(scenario, method):
    about = hc.simulate(scenario, method=method, ledger=False).data.attrs
    found = about["solver_steps"], about["solver_rejected"]
    for count, measured in zip(found, EFFORT[scenario, method], strict=True):
        assert abs(count - measured) <= 4 + measured / 20, found


def test_every_interval_between_commands_is_divided_evenly():
    """Open loop: commands at 0.3, 0.8, 1.6 ... s and the end at 5 s are multiples of 5 ms. Tip control at 100 Hz: every
    sample has 2 ms before its command arrives and 8 ms after it, so two and three steps of at most 3 ms."""
    about = hc.simulate("vertical-lift-open-loop", ledger=False, **FIXED).data.attrs
    # A few steps in which the spools jump are cut.
    effort = [about[f"solver_{key}"] for key in ("steps", "rhs", "jacobians", "factorisations")]
    assert all(1000 <= count <= 1040 for count in effort), effort
    about = hc.simulate("tip-vertical-line", duration=1.0, ledger=False, method="hc-rosenbrock-3", step=3e-3).data.attrs
    assert (about["solver_steps"], about["solver_rejected"]) == (400, 0)
    assert about["solver_max_step"] == 3e-3


def test_tip_control_at_one_step_per_sample_is_exact_to_micrometres():
    plan = hc.load_scenario("tip-vertical-line").changed(sensors="ideal", delay=0.0)
    exact = hc.simulate(plan, rtol=1e-9, ledger=False)
    for step, most in ((1e-2, 50e-6), (5e-3, 20e-6), (2.5e-3, 5e-6)):
        run = hc.simulate(plan, method="hc-rosenbrock-3", step=step, ledger=False)
        assert run.data.attrs["solver_steps"] == round(plan.duration / step)
        assert apart(run, exact) < most


def test_the_ledger_closes_with_the_step():
    def residual(step):
        return energy_balance(hc.simulate("vertical-lift-open-loop", method="hc-rosenbrock-3", step=step)).residual

    assert residual(1e-3) < 0.1 * residual(5e-3)


def test_stepping_is_the_run():
    crane = hc.load_machine("rottne-f9-lab")
    pose = {"boom": np.deg2rad(100), "jib": np.deg2rad(100), "extension": 0.0}
    plan = hc.Scenario(
        joints=pose, commands={"lift": 0.02}, duration=0.5, record_interval=0.01, solver=hc.Solver(**FIXED)
    )
    run = hc.simulate(plan, ledger=False)
    simulator = hc.Simulator(crane, 0.01, **FIXED)
    simulator.reset(q=list(pose.values()))
    for _ in range(50):
        observed = simulator.step([0.02, 0.0, 0.0])
    np.testing.assert_allclose(observed.tip, tip(run)[-1], atol=1e-12)


def test_slopes_by_parameters_follow_the_fixed_steps():
    keys = ["payload.mass", "supply.pressure"]
    fixed = hc.sensitivities("single-cylinder-step", keys, method="hc-rosenbrock-3", step=5e-4)
    exact = hc.sensitivities("single-cylinder-step", keys, rtol=1e-8)
    for name in ("joint.slide.q", "cylinder.test.p1"):
        one, other = (np.asarray(found.data[name]) for found in (fixed, exact))
        assert np.abs(one - other).max() < 0.02 * np.abs(other).max(), name


def write(tmp_path, solver):
    path = tmp_path / "fixed.toml"
    head = (
        '[scenario]\nname = "fixed"\nmachine = "single-cylinder"\nduration = "1 s"\n[initial.joint]\nslide = "0 mm"\n'
    )
    path.write_text(f"{head}[solver]\n{solver}\n", encoding="utf-8")
    return path


def test_a_scenario_file_asks_for_fixed_steps(tmp_path):
    plan = hc.load_scenario(write(tmp_path, 'method = "hc-rosenbrock-3"\nstep = "2 ms"'))
    assert plan.solver == hc.Solver(method="hc-rosenbrock-3", step=2e-3)
    assert hc.simulate(plan).data.attrs["solver_steps"] == 500
    # A method named without a step chooses its steps by the tolerances.
    assert plan.changed(method="rodas5p").solver.step is None
    assert plan.changed(method="rodas5p", step=1e-3).solver.step == 1e-3


@pytest.mark.parametrize("method", ["rodas5p", "hc-exponential-4", "hc-rosenbrock-3"])
def test_any_stiff_method_takes_fixed_steps_or_steps_by_tolerances(method):
    exact = tip(hc.simulate("vertical-lift-open-loop", rtol=1e-9))[-1]
    even = hc.simulate("vertical-lift-open-loop", method=method, step=1e-3)
    assert even.outcome.completed and "steps of 1 ms" in even.summary()
    # A few intervals are no whole number of steps, and steps in which spools jump are cut.
    assert 5000 <= even.data.attrs["solver_steps"] <= 5025
    free = [hc.simulate("vertical-lift-open-loop", method=method, rtol=rtol) for rtol in (1e-4, 1e-6)]
    assert free[0].data.attrs["solver_steps"] < free[1].data.attrs["solver_steps"]
    assert "rtol" in free[0].summary()
    for run, most in ((even, 1e-5), (free[0], 2e-5), (free[1], 5e-7)):
        assert np.linalg.norm(tip(run)[-1] - exact) < most, run.summary()


def test_a_step_alone_asks_for_fixed_steps(tmp_path):
    stated = hc.simulate(hc.load_scenario(write(tmp_path, 'method = "hc-exponential-4"\nstep = "2 ms"')))
    chosen = hc.simulate(hc.load_scenario(write(tmp_path, 'step = "2 ms"')))
    assert chosen.data.attrs["solver_method"] == "hc-exponential-4" and chosen.data.attrs["solver_choice"] == "auto"
    assert "hc-exponential-4 (chosen: auto), steps of 2 ms" in chosen.summary()
    for name in chosen.machine.state_names:
        assert (chosen.data[name].values == stated.data[name].values).all()


@pytest.mark.parametrize(
    ("solver", "slug", "words"),
    [
        ('method = "hc-rosenbrock-3"\nstep = "0 ms"', "out-of-range", ["solver.step"]),
        ('method = "hc-rosenbrock-3"\nstep = "-1 ms"', "out-of-range", ["solver.step"]),
        ('method = "ros3"\nstep = "1 ms"', "invalid-choice", ["hc-rosenbrock-3"]),
    ],
)
def test_a_file_with_a_wrong_step_is_refused(tmp_path, solver, slug, words):
    with pytest.raises(MachineFileError) as caught:
        hc.load_scenario(write(tmp_path, solver))
    assert caught.value.slug == slug
    assert all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize("changes", [{"step": 0.0}, {"method": "hc-exponential-4", "step": -0.005}])
def test_a_wrong_step_from_python_is_refused(changes):
    with pytest.raises(hc.InputError, match="step"):
        hc.simulate("single-cylinder-step", **changes)
    with pytest.raises(hc.InputError, match="step"):
        hc.Simulator(hc.load_machine("single-cylinder"), **changes)


def test_the_printed_machine_runs_in_steps_of_milliseconds():
    """Its friction jumps at standstill; methods that control their error need a hundred times the steps."""
    plan = hc.load_scenario("heinze-2007-open-loop").changed(duration=2.0)
    loose, fine = (hc.simulate(plan, method="hc-rosenbrock-3", step=step, ledger=False) for step in (2e-3, 1e-4))
    assert loose.outcome.completed and loose.data.attrs["solver_steps"] == 1000
    assert apart(loose, fine) < 3e-3
