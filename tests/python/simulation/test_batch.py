"""Batches of cranes and the environments on them."""

from __future__ import annotations

import multiprocessing
import re
import sys

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.errors import InputError, SimulationError
from hydrocrane.result_warning import DoubtfulResult

POSE = np.array([1.7, 1.7, 0.0])


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("rottne-f9-lab")


def commands(n: int, samples: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-0.02, 0.02, (samples, n, 3))


def test_a_batch_is_the_simulator_with_a_leading_axis(crane):
    batch, alone = hc.BatchSimulator(crane, 3, payload=20.0), hc.Simulator(crane, payload=20.0, rtol=1e-8)
    seen, one = batch.reset(q=POSE), alone.reset(q=POSE)
    np.testing.assert_array_equal(seen.tip[1], one.tip)
    for u in np.repeat(commands(3, 3), 20, axis=0):
        seen, one = batch.step(u), alone.step(u[1])
    assert seen.t.shape == (3,) and seen.q.shape == seen.qd.shape == (3, 3)
    assert seen.p.shape == (3, 3, 2) and seen.tip.shape == (3, 2)
    assert seen.t[1] == pytest.approx(one.t)
    np.testing.assert_allclose(seen.tip[1], one.tip, atol=1e-3)
    np.testing.assert_allclose(seen.p[1], one.p, atol=2e5)
    np.testing.assert_allclose(crane.tip(seen.q), seen.tip, atol=1e-14)
    assert batch.state.shape == (3, len(crane.state_names))
    np.testing.assert_array_equal(batch.state[:, :3], seen.q)


def test_a_smaller_tolerance_is_nearer_to_the_simulator(crane):
    u = np.repeat(commands(1, 4, seed=2), 25, axis=0)

    def path(simulator, reset, act) -> np.ndarray:
        simulator.reset(**reset)
        return np.array([np.reshape(simulator.step(act(row)).tip, 2) for row in u])

    exact = path(hc.Simulator(crane, rtol=1e-8), {"q": POSE}, lambda row: row[0])

    def error(tolerance: float) -> float:
        batch = hc.BatchSimulator(crane, 1, tolerance=tolerance)
        return np.linalg.norm(path(batch, {"q": POSE}, lambda row: row) - exact, axis=1).max()

    default, tight = error(0.02), error(1e-4)
    assert tight < 2e-5 and 5 * tight < default < 1e-3


def test_a_loose_tolerance_is_told_of(crane):
    assert [warning.kind for warning in hc.BatchSimulator(crane, 1, tolerance=0.5).warnings] == ["tolerance-too-loose"]
    assert hc.BatchSimulator(crane, 1, tolerance=0.02).warnings == ()


def test_the_size_of_the_batch_and_the_threads_do_not_matter(crane):
    u = commands(1000, 5, seed=3)

    def tips(part: slice, threads: int | None) -> np.ndarray:
        batch = hc.BatchSimulator(crane, len(range(1000)[part]), threads=threads)
        batch.reset(q=POSE)
        for row in u:
            batch.step(row[part])
        return batch.state

    everything = tips(slice(None), 2)
    np.testing.assert_array_equal(tips(slice(None), 1), everything)
    for part in (slice(0, 1), slice(5, 12), slice(40, 48)):
        np.testing.assert_array_equal(tips(part, None), everything[part])


def test_a_lost_crane_is_told_and_can_be_reset(crane):
    batch = hc.BatchSimulator(crane, 4)
    state = np.tile(crane.equilibrium(POSE), (4, 1))
    state[2, crane.state_names.index("joint.jib.qd")] = 4e4
    batch.reset(state=state)
    for _ in range(10):
        batch.step([0.0, 0.0, 0.0])
    np.testing.assert_array_equal(batch.alive, [True, True, False, True])
    assert batch.outcomes[2] in ("stroke-limit", "solver-failed") and batch.outcomes[0] == "completed"
    assert np.isfinite(batch.state).all() and batch.time[2] < batch.time[0]
    batch.reset(q=POSE, cranes=~batch.alive)
    assert batch.alive.all() and batch.time[2] == 0.0 and batch.time[0] == pytest.approx(0.1)


def test_payloads_are_each_crane_s_own(crane):
    batch = hc.BatchSimulator(crane, 3, payload=[0.0, 50.0, 100.0])
    batch.reset(q=POSE)
    states = batch.state
    for row, mass in zip(states, (0.0, 50.0, 100.0)):
        np.testing.assert_array_equal(row, crane.equilibrium(POSE, payload=mass))
    batch.set_payload(30.0, cranes=[0, 2])
    np.testing.assert_array_equal(batch.payload, [30.0, 50.0, 30.0])


@pytest.mark.filterwarnings("error")
def test_starts_that_the_supply_does_not_hold_are_told_together(crane):
    batch = hc.BatchSimulator(crane, 4, payload=[0.0, 900.0, 0.0, 950.0])
    batch.reset(q=POSE)
    (doubt,) = batch.warnings
    assert doubt.kind == "start-not-held" and doubt.text.startswith("2 of 4 cranes, the first being 1: ")
    batch.reset(state=batch.state[0], cranes=[1])
    assert batch.warnings[0].text.startswith("1 of 4 cranes, the first being 3: ")


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda b: b.step(np.zeros((4, 3))), "must have one row or 3, one per crane; got shape \\(4, 3\\)"),
        (lambda b: b.step(np.zeros(2)), "spool_commands must have shape"),
        (lambda b: b.step([0.0, np.nan, 0.0]), "must be finite"),
        (lambda b: b.reset(), "either q"),
        (lambda b: b.reset(q=POSE, cranes=[3]), "between 0 and 2"),
        (lambda b: b.reset(q=POSE, cranes=[0.5]), "numbers of cranes or 3 truth values"),
        (lambda b: b.reset(q=[[9.0, 9.0, 9.0]]), "its range is"),
        (lambda b: b.set_payload(-1.0), "zero or greater"),
        (lambda b: b.set_payload([1.0, 2.0]), "or 3 of them"),
        (lambda b: hc.BatchSimulator(b.machine, 0), "a whole number, one or more"),
        (lambda b: hc.BatchSimulator(b.machine, 2, 0.0), "greater than zero"),
        (lambda b: hc.BatchSimulator(b.machine, 2, step=-1.0), "step must be one number greater than zero, in seconds"),
        (lambda b: hc.BatchSimulator(b.machine, 2, tolerance=0.0), "tolerance must be one number greater than zero"),
        (
            lambda b: hc.BatchSimulator(b.machine, 2, tolerance=2.0),
            "tolerance must be at most 1, .* got 2.0; 0.01 is usual",
        ),
        (lambda b: hc.BatchSimulator(b.machine, 2, payload=[1.0, 2.0, 3.0]), "or 2 of them"),
    ],
)
def test_bad_input_is_one_clear_error(crane, call, says):
    batch = hc.BatchSimulator(crane, 3)
    batch.reset(q=POSE)
    with pytest.raises(hc.HydrocraneError, match=says):
        call(batch)


def test_a_step_before_the_reset_is_refused(crane):
    batch = hc.BatchSimulator(crane, 3)
    batch.reset(q=POSE, cranes=[0, 2])
    with pytest.raises(SimulationError, match="crane 1 has no state"):
        batch.step(np.zeros(3))


def test_environments_pass_the_checker_of_gymnasium():
    gymnasium = pytest.importorskip("gymnasium")
    from gymnasium.utils.env_checker import check_env

    import hydrocrane.gym  # noqa: F401

    env = gymnasium.make("hydrocrane/CraneTip-v0")
    check_env(env.unwrapped, skip_render_check=True)


def test_the_reward_is_what_the_task_says():
    pytest.importorskip("gymnasium")
    from hydrocrane.gym import CraneTipEnv

    env = CraneTipEnv(sample_time=0.05, duration=0.2)
    _, information = env.reset(seed=1, options={"q": POSE})
    target = information["target"]
    for sample in range(1, 5):
        observation, reward, lost, late, information = env.step(np.zeros(3))
        way = target - information["tip"]
        assert reward == pytest.approx(-0.05 * np.linalg.norm(way))
        np.testing.assert_allclose(observation[-2:], way, rtol=1e-6)
        assert not lost and late == (sample == 4)


def test_many_environments_are_one_environment_many_times():
    pytest.importorskip("gymnasium")
    from hydrocrane.gym import CraneTipEnv, CraneTipVectorEnv

    many = CraneTipVectorEnv(3, duration=0.3)
    observations, _ = many.reset(seed=7)
    alone = CraneTipEnv(duration=0.3)
    first, _ = alone.reset(seed=8)
    np.testing.assert_array_equal(observations[1], first)
    actions = np.random.default_rng(2).uniform(-0.3, 0.3, (6, 3, 3))
    for action in actions:
        observations, rewards, lost, late, _ = many.step(action)
        first, reward, one_lost, one_late, _ = alone.step(action[1])
        np.testing.assert_array_equal(observations[1], first)
        assert (rewards[1], lost[1], late[1]) == (reward, one_lost, one_late)
    assert late.all()
    # The next step begins anew: the action is ignored, the reward zero.
    observations, rewards, lost, late, _ = many.step(actions[0])
    assert not rewards.any() and not lost.any() and not late.any()
    np.testing.assert_array_equal(observations[1], alone.reset()[0])
    assert (np.abs(observations[:, -2:]).sum(axis=1) > 0).all()


def test_seeds_and_options_of_many_environments_are_those_of_one():
    pytest.importorskip("gymnasium")
    from hydrocrane.gym import CraneTipEnv, CraneTipVectorEnv

    many, alone = CraneTipVectorEnv(2), CraneTipEnv()
    many.reset(seed=[3, 5])
    alone.reset(seed=5)
    # Without a seed the random numbers go on.
    observations, information = many.reset(seed=[3, None])
    first, _ = alone.reset()
    np.testing.assert_array_equal(observations[1], first)
    requested = {"target": [4.0, 0.5], "q": POSE}
    observations, information = many.reset(options=requested)
    np.testing.assert_array_equal(information["target"], [[4.0, 0.5]] * 2)
    np.testing.assert_array_equal(observations, [alone.reset(options=requested)[0]] * 2)
    for env, target in ((many, [[4.0, 0.5], [3.0, 0.0]]), (alone, [4.0, 0.5])):
        _, information = env.reset(options={"target": target})
        np.testing.assert_array_equal(information["target"], target)
        with pytest.raises(InputError, match="goal"):
            env.reset(options={"goal": [4.0, 0.5]})
        with pytest.raises(InputError, match="shape"):
            env.reset(options={"target": [1.0, 2.0, 3.0]})
    with pytest.raises(InputError, match="3 seeds for 2 cranes"):
        many.reset(seed=[1, 2, 3])


def test_errors_name_what_is_no_machine():
    with pytest.raises(InputError, match="a bundled name or a path"):
        hc.BatchSimulator(7, 2)  # type: ignore[arg-type]


def test_a_sample_of_finest_steps_ends():
    """A step that is longer than the finest by rounding alone is accepted as finest."""
    state = [
        1.5134828501817597, 0.40337581753452606, 0.01566548002590673, 0.18410280828977837, -0.2979505740403005,
        -0.045805957377636965, 6456457.2988793375, 6555295.562788008, 0.0372966466296931, -2.72337745646386e-05,
        0.00037642026885938086, 9079900.867472902, 1054920.4526767326, 0.05000000000071489, -4.249285847110019e-09,
        0.0008428427513581401, 7575002.374976352, 12088093.769112196, -0.048063572630840164, 8.135707150083618e-05,
        -0.0016928398441667743,
    ]  # fmt: skip
    batch = hc.BatchSimulator("rottne-f9-lab", 1, 0.05)
    batch.reset(state=[state])
    for spools in ([-0.015088538825511933, -0.05, 0.0033193740993738177], [-0.05, 0.03296621441841126, -0.05]):
        batch.step([spools])
    assert batch.alive.all()


def _stepped(batch, u, sent):
    sent.send(batch.step(u).q)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not fork by default")
def test_a_forked_process_has_threads_of_its_own(crane):
    """The threads of a batch do not live on in a child; it starts its own, and ends without those of its parent."""
    n = 100
    batch = hc.BatchSimulator(crane, n, threads=2)
    u = commands(n, 1)[0]
    batch.reset(q=np.tile(POSE, (n, 1)))
    receive, send = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=_stepped, args=(batch, u, send))
    child.start()
    assert receive.poll(60.0), "the child hangs"
    found = receive.recv()
    child.join(60.0)
    assert child.exitcode == 0
    np.testing.assert_array_equal(found, batch.step(u).q)


def test_environments_refuse_targets_that_are_none():
    pytest.importorskip("gymnasium")
    from hydrocrane.gym import CraneTipEnv, CraneTipVectorEnv

    worlds = (CraneTipEnv(), CraneTipVectorEnv(2))
    for world in worlds:
        with pytest.raises(
            hc.InputError, match=r"`target`: \(x, z\) = \(4000, 0.5\) m is out of reach of .*; the nearest"
        ) as caught:
            world.reset(seed=1, options={"target": [4000.0, 0.5]})
        near = [float(x) for x in re.search(r"reach is \((.*), (.*)\) m", str(caught.value)).groups()]
        _, told = world.reset(seed=1, options={"target": near})
        np.testing.assert_allclose(np.atleast_2d(told["target"])[0], near)
        with pytest.raises(hc.InputError, match="target must be finite"):
            world.reset(options={"target": [np.nan, 0.5]})
        with pytest.raises(hc.InputError, match=r"`target` must have shape \(2,\)"):
            world.reset(options={"target": [1.0, 2.0, 3.0]})
    with pytest.raises(hc.InputError, match="out of reach"):
        worlds[1].reset(options={"target": [[2.5, 0.5], [9.0, 0.5]]})


def drawn_targets(task):
    from hydrocrane.gym.task import starts_and_targets

    return starts_and_targets([task.machine] * 64, [np.random.default_rng(seed) for seed in range(64)])[1]


def test_targets_lie_outside_of_the_ground_and_of_keep_out_regions():
    pytest.importorskip("gymnasium")
    from hydrocrane.gym import CraneTipEnv

    crane = hc.load_machine("rottne-f9-lab")
    tips = drawn_targets(CraneTipEnv(crane).task)
    height = float(np.median(tips[:, 1]))
    high = hc.load_machine("rottne-f9-lab", {"ground.height": height})
    world = CraneTipEnv(high)
    targets = drawn_targets(world.task)
    assert (targets[:, 1] >= height).all()
    # What was permitted at once is drawn as before.
    same = (targets == tips).all(axis=1)
    assert 3 < same.sum() < 40
    low = tips[np.argmin(tips[:, 1])]
    with pytest.raises(hc.InputError, match="in the ground there; give another one"):
        world.reset(options={"target": low})
    with pytest.raises(hc.InputError, match="of 1000 pairs of a start and a target, all had the tip"):
        CraneTipEnv(hc.load_machine("rottne-f9-lab", {"ground.height": 9.0})).reset()


def test_environments_refuse_samples_and_actions_that_are_none():
    pytest.importorskip("gymnasium")
    from hydrocrane.gym import CraneTipEnv, CraneTipVectorEnv

    with pytest.raises(hc.InputError, match="one sample or more; got duration=10 s, sample_time=50 s"):
        CraneTipEnv(sample_time=50)
    with pytest.raises(hc.InputError, match="sample_time"):
        CraneTipEnv(sample_time=0.0)
    for world in (CraneTipEnv(), CraneTipVectorEnv(2)):
        world.reset(seed=1)
        with pytest.raises(hc.InputError, match="action must have"):
            world.step(np.zeros(5))


def test_no_crane_carries_more_than_any_use():
    sim = hc.Simulator("rottne-f9-lab")
    cranes = hc.BatchSimulator("rottne-f9-lab", 2)
    pose = hc.load_machine("rottne-f9-lab").home
    sim.reset(q=pose)
    cranes.reset(q=pose)
    for load in (sim.set_payload, cranes.set_payload):
        for mass, word in ((1e7, "beyond any use"), (-1.0, "negative|zero")):
            with pytest.raises(hc.InputError, match=word):
                load(mass)


def test_every_target_that_is_drawn_is_within_reach():
    pytest.importorskip("gymnasium")
    from hydrocrane.gym import CraneTipEnv

    for name in ("rottne-f9-lab", "hiab-xs031", "rottne-f9-forwarder", "rottne-f9-mobile"):
        world = CraneTipEnv(machine=name)
        assert not world.task.machine.forbidden(drawn_targets(world.task)).any()
        for seed in range(5):
            _, drawn = world.reset(seed=seed)
            _, stated = world.reset(seed=seed, options={"target": drawn["target"]})
            np.testing.assert_array_equal(stated["target"], drawn["target"])


def test_parameters_of_an_option_are_a_mapping():
    gymnasium = pytest.importorskip("gymnasium")

    import hydrocrane.gym  # noqa: F401

    env = gymnasium.make("hydrocrane/CraneTip-v0")
    with pytest.raises(hc.InputError, match="parameters must map machine keys"):
        env.reset(options={"parameters": [1.0, 2.0]})


def test_unlikely_parameters_of_an_option_are_told():
    """A number is in SI: 140 are pascals."""
    gymnasium = pytest.importorskip("gymnasium")

    import hydrocrane.gym  # noqa: F401

    env = gymnasium.make("hydrocrane/CraneTip-v0")
    with pytest.warns(DoubtfulResult, match="supply.pressure is 140 Pa; usual is 5 bar to 500 bar"):
        env.reset(options={"parameters": {"supply.pressure": 140.0}})
