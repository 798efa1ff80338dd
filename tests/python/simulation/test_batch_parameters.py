"""Cranes of a batch with values of their own, and the environments that draw them."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.errors import InputError, MachineFileError, OutOfReachError
from hydrocrane.gym import CraneTipEnv, CraneTipVectorEnv, RandomMachine, RandomMachines

# Twenty keys from all parts of a crane.
KEYS = (
    "environment.gravity", "link.boom.mass", "link.jib.inertia", "cylinder.lift.bore", "cylinder.jib.rod-diameter",
    "cylinder.lift.dead-length", "cylinder.extension.leakage-gap", "cylinder.jib.linkage.rocker-length",
    "cylinder.lift.end-stop.stiffness", "valve.lift.stroke", "valve.jib.nominal-flow",
    "valve.extension.natural-frequency", "friction.lift.bristle-stiffness", "friction.jib.coulomb[0]",
    "fluid.density", "fluid.bulk-modulus-max", "supply.pressure", "equilibrium.back-pressure",
)  # fmt: skip


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("rottne-f9-lab")


def drawn(crane, n: int, seed: int = 0) -> dict[str, np.ndarray]:
    random = np.random.default_rng(seed)
    found = {"payload.mass": random.uniform(0.0, 40.0, n), "valve.lift.delay": random.uniform(0.0, 0.033, n)}
    for name in KEYS:
        key, _, place = name.removesuffix("]").partition("[")
        nominal = float(np.atleast_1d(crane.value(key).si)[int(place or 0)])
        found[name] = nominal * random.uniform(0.97, 1.03, n)
    return found


def agree(crane, n: int, samples: int, compared: list[int]) -> None:
    """Cranes with twenty values of their own are those of batches of one, to the bit, and single cranes."""
    parameters = drawn(crane, n)
    batch = hc.BatchSimulator(crane, n, parameters=parameters)
    batch.reset(q=crane.home)
    np.testing.assert_array_equal(batch.payload, parameters["payload.mass"])
    commands = np.random.default_rng(1).uniform(-0.01, 0.01, (samples // 5, n, 3)).repeat(5, axis=0)
    for row in commands:
        seen = batch.step(row)
    assert batch.alive.all()
    for i, own in zip(compared, batch.machines(compared), strict=True):
        assert all(own.value(key).si == parameters[key][i] for key in ("cylinder.lift.bore", "valve.lift.delay"))
        alone, exact = hc.BatchSimulator(own, 1), hc.Simulator(own, rtol=1e-7)
        alone.reset(q=crane.home)
        exact.reset(q=crane.home)
        for row in commands:
            one, single = alone.step(row[i]), exact.step(row[i])
        np.testing.assert_array_equal(alone.state[0], batch.state[i])
        np.testing.assert_array_equal(one.tip[0], seen.tip[i])
        np.testing.assert_allclose(single.tip, seen.tip[i], atol=2e-4)


def test_cranes_with_twenty_values_of_their_own_are_as_if_alone(crane):
    agree(crane, 40, 30, [0, 7, 8, 39])


@pytest.mark.evidence
def test_ten_thousand_cranes_are_as_if_alone(crane):
    agree(crane, 10_000, 50, list(range(0, 10_000, 499)))


def of_each_key(name: str) -> None:
    """One crane for each key that is a number, with a value beside the nominal one: each moves as that machine."""
    crane = hc.load_machine(name)
    cranes = []
    for key in crane.keys:
        values = np.atleast_1d(crane.value(key).si)
        # An outline is a table of points.
        if not key.startswith("sensor.") and not key.endswith(".outline"):
            own = f"{key}[0]" if values.size > 1 else key
            cranes.append((own, float(values[0]) * (1.0 + 1e-4) or 1e-9))
    batch = hc.BatchSimulator(crane, len(cranes))
    batch.reset(q=crane.home)
    taken = []
    for i, (key, value) in enumerate(cranes):
        try:
            batch.reset(q=crane.home, cranes=[i], parameters={key: value})
            taken.append(i)
        except hc.HydrocraneError as error:
            # A part that it adds, a value that this machine cannot have, an exponent on which units of others depend.
            known = ("adds a part", "out-of-range", "crossed-limits", "wrong-dimension", "cannot-build")
            assert any(reason in str(error) for reason in known), (key, error)
    assert len(taken) > 0.8 * len(cranes)
    commands = 0.2 * crane.spool_strokes
    for _ in range(3):
        batch.step(commands)
    for i, own in zip(taken, batch.machines(taken), strict=True):
        alone = hc.BatchSimulator(own, 1)
        alone.reset(q=crane.home)
        for _ in range(3):
            alone.step(commands)
        np.testing.assert_array_equal(alone.state[0], batch.state[i], err_msg=f"{name}: {cranes[i]}")


def test_every_number_of_a_machine_can_differ():
    of_each_key("rottne-f9-lab")


@pytest.mark.evidence
@pytest.mark.parametrize("name", hc.bundled_machines())
def test_every_number_of_every_machine_can_differ(name):
    of_each_key(name)


def test_values_change_at_a_reset_of_some_cranes(crane):
    batch = hc.BatchSimulator(crane, 3)
    assert batch.parameters == {} and batch.machines() == [crane] * 3
    batch.reset(q=crane.home)
    before = batch.state
    batch.reset(q=crane.home, cranes=[1], parameters={"payload.mass": "30 kg", "valve.lift.delay": [0.02]})
    np.testing.assert_array_equal(batch.payload, [0.0, 30.0, 0.0])
    np.testing.assert_array_equal(batch.parameters["payload.mass"], [0.0, 30.0, 0.0])
    np.testing.assert_array_equal(batch.parameters["valve.lift.delay"], [np.nan, 0.02, np.nan])
    np.testing.assert_array_equal(batch.state[[0, 2]], before[[0, 2]])
    assert not np.array_equal(batch.state[1], before[1])
    assert [machine.payload() for machine in batch.machines([0, 1])] == [0.0, 30.0]
    # They stay until they are changed.
    batch.reset(q=crane.home)
    np.testing.assert_array_equal(batch.payload, [0.0, 30.0, 0.0])
    batch.reset(q=crane.home, parameters={"payload.mass": 5.0})
    np.testing.assert_array_equal(batch.payload, [5.0] * 3)


def test_a_payload_of_the_batch_counts_before_that_of_the_machines(crane):
    batch = hc.BatchSimulator(crane, 2, payload=7.0, parameters={"payload.mass": [1.0, 2.0]})
    batch.reset(q=crane.home)
    np.testing.assert_array_equal(batch.payload, [7.0, 7.0])


def test_a_start_that_its_own_machine_does_not_hold_has_a_warning(crane):
    batch = hc.BatchSimulator(crane, 3, payload=200.0, parameters={"supply.pressure": [190e5, 20e5, 190e5]})
    batch.reset(q=crane.home)
    (warning,) = batch.warnings
    assert warning.kind == "start-not-held" and warning.text.startswith("1 of 3 cranes, the first being 1:")


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"cylinder.lift.bohr": 0.04}, "unknown key"),
        ({"cylinder.lift.bore": [0.1] * 3}, "needs one value, or 2, one for each crane; got 3"),
        ({"cylinder.lift.bore": ["0.1 m", "40 kg"]}, "another quantity"),
        ({"cylinder.lift.bore": [0.1, np.nan]}, "finite"),
        ({"friction.lift.model": "static"}, "is not one number"),
        ({"machine.title": "another"}, "is not one number"),
        ("cylinder.lift.bore", "map machine keys"),
    ],
)
def test_what_is_no_number_for_each_crane_is_refused(crane, parameters, message):
    with pytest.raises((InputError, MachineFileError), match=message):
        hc.BatchSimulator(crane, 2, parameters=parameters)


def test_an_error_names_crane_and_key(crane):
    batch = hc.BatchSimulator(crane, 4)
    batch.reset(q=crane.home)
    with pytest.raises(InputError, match=r"crane 2: `ground.height` adds a part"):
        batch.reset(q=crane.home, cranes=[2], parameters={"link.boom.mass": 70.0, "ground.height": -3.0})
    with pytest.raises(MachineFileError, match=r"crane 3: .*cylinder.lift.bore") as raised:
        batch.reset(q=crane.home, cranes=[1, 3], parameters={"cylinder.lift.bore": [0.1, -0.1]})
    assert raised.value.key == "cylinder.lift.bore"
    with pytest.raises(OutOfReachError, match="crane 1: "):
        batch.reset(q=crane.joint_limits[:, 1], cranes=[0, 1], parameters={"cylinder.lift.barrel-length": [0.43, 0.42]})
    assert batch.parameters == {}


RANGES = {
    "payload.mass": (0.0, 40.0),
    "cylinder.lift.bore": ["98 mm", "102 mm"],
    "valve.lift.delay": {"values": [0, 0.05]},
}


def test_an_environment_takes_a_machine_as_an_option():
    env = CraneTipEnv()
    plain = env.reset(seed=1)[1]
    assert "parameters" not in plain
    _, found = env.reset(seed=1, options={"parameters": {"payload.mass": "20 kg"}})
    assert found["parameters"] == {"payload.mass": 20.0}
    np.testing.assert_array_equal(found["target"], plain["target"])
    with pytest.raises(InputError, match="is not one number"):
        env.reset(options={"parameters": {"friction.lift.model": "static"}})


def test_a_machine_is_drawn_for_each_episode_and_a_seed_gives_it_again():
    env = RandomMachine(gymnasium.wrappers.TimeLimit(CraneTipEnv(), 5), RANGES)
    first, again, other = (env.reset(seed=seed)[1]["parameters"] for seed in (3, 3, 4))
    assert first == again != other and set(first) == set(RANGES)
    assert env.reset()[1]["parameters"] != other
    assert 0.098 <= first["cylinder.lift.bore"] <= 0.102 and first["valve.lift.delay"] in (0.0, 0.05)
    assert env.reset(seed=3, options={"parameters": {"payload.mass": 1.0}})[1]["parameters"]["payload.mass"] == 1.0
    with pytest.raises(MachineFileError, match="unknown key"):
        RandomMachine(CraneTipEnv(), {"payload.mas": (0.0, 1.0)})
    with pytest.raises(InputError, match="ranges"):
        RandomMachine(CraneTipEnv(), {})


def test_a_crane_of_a_batch_draws_and_moves_like_one_crane():
    many = RandomMachines(CraneTipVectorEnv(3, duration=0.2, threads=1), RANGES)
    seen, facts = many.reset(seed=5)
    alone = [RandomMachine(CraneTipEnv(duration=0.2), RANGES) for _ in range(3)]
    for i, env in enumerate(alone):
        one, own = env.reset(seed=5 + i)
        assert own["parameters"] == {name: values[i] for name, values in facts["parameters"].items()}
        np.testing.assert_array_equal(one, seen[i])
    for _ in range(4):
        seen = many.step(np.full((3, 3), 0.1))[0]
        for i, env in enumerate(alone):
            np.testing.assert_array_equal(env.step(np.full(3, 0.1))[0], seen[i])
    # The next step begins the next episode, with other machines.
    seen, before = many.step(np.zeros((3, 3)))[0], facts["parameters"]
    for i, env in enumerate(alone):
        np.testing.assert_array_equal(env.reset()[0], seen[i])
    assert (many.unwrapped._cranes.parameters["payload.mass"] != before["payload.mass"]).all()


def test_a_new_episode_of_a_batch_tells_what_was_drawn():
    """One crane is lost first, so that the cranes begin anew at different samples."""
    many = RandomMachines(CraneTipVectorEnv(3, duration=0.2, threads=1), {"payload.mass": (0.0, 100.0)})
    _, before = many.reset(seed=1)
    zero, told = np.zeros((3, 3), dtype=np.float32), []
    many.unwrapped._samples[1] = 2
    for _ in range(7):
        told.append(many.step(zero)[4])
    assert [bool(information) for information in told] == [False, False, True, False, True, False, False]
    for information, anew in ((told[2], [False, True, False]), (told[4], [True, False, True])):
        assert information["_parameters"].tolist() == information["_target"].tolist() == anew
        masses, targets = information["parameters"]["payload.mass"], information["target"]
        assert (masses != before["parameters"]["payload.mass"]).tolist() == anew
        assert (targets != before["target"]).any(axis=1).tolist() == anew
        before = information


def test_machines_are_drawn_for_the_cranes_of_this_package():
    with pytest.raises(InputError, match="CraneTipEnv, itself or in other wrappers; got a CartPoleEnv"):
        RandomMachine(gymnasium.make("CartPole-v1"), {"payload.mass": (0.0, 1.0)})
    other = gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode="sync")
    with pytest.raises(InputError, match="CraneTipVectorEnv, itself or in other wrappers"):
        RandomMachines(other, {"payload.mass": (0.0, 1.0)})
