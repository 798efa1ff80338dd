"""A scenario written as a file reads back the same."""

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import _core
from hydrocrane.scenario.scenario import scenario_entry

JOINTS = {"boom": 1.7, "jib": 1.65, "extension": 0.1}
CYLINDERS = ("lift", "jib", "extension")


def in_si(value):
    """An override in SI, whether it was a number or a text with its unit."""
    if isinstance(value, list):
        return [in_si(inner) for inner in value]
    try:
        return _core.quantity(value)[0] if isinstance(value, str) else value
    except ValueError:
        return value


def plain(value):
    """An entry with lists in place of arrays, and named things in one order, wherever its file lies."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items() if key != "places"}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def stated(plan):
    """All that a scenario states; sticks that stay centred count as left out."""
    entry = plain(scenario_entry(plan, CYLINDERS))
    loops = [entry["controller"], *(phase["controller"] for phase in entry["phases"])]
    for table in [entry, *entry["phases"], *(loop for loop in loops if loop is not None)]:
        for key in {"overrides", "controller_model"} & set(table):
            table[key] = [[name, in_si(value)] for name, value in table[key]]
    for stick in [entry["joystick"], *(phase["joystick"] for phase in entry["phases"])]:
        if stick is not None:
            stick["axes"] = sorted([name, column] for name, column in stick["axes"] if any(column))
    return entry | {"name": plan.name, "title": plan.title, "recorded_by": plan.recorded_by}


def drawn(seed):
    """Some scenario."""
    rng = np.random.default_rng(seed)

    def times(least=0.0):
        return np.unique(least + rng.uniform(0.001, 3.0, rng.integers(1, 6)))

    def deflections(at):
        return rng.uniform(-1.0, 1.0, at.size)

    def joystick(mode):
        at = times()
        names = ("x", "z") if mode == "tip" else CYLINDERS
        axes = {str(name): deflections(at) for name in rng.permutation(names)[: rng.integers(1, len(names) + 1)]}
        speed = float(rng.uniform(0.1, 1.0)) if rng.random() < 0.5 and mode == "tip" else None
        how = str(rng.choice(["hold", "linear"]))
        return hc.Joystick(at, axes, mode, how, float(rng.uniform(0, 0.3)), speed, float(rng.uniform(0, 0.3)))

    def loop(mode):
        name = "lever" if mode == "lever" else str(rng.choice(["tip", "heinze-pid"]))
        fields = {"controller": name, "joystick": joystick(mode), "delay": float(rng.uniform(0, 0.01))}
        if rng.random() < 0.5:
            fields["period"] = float(rng.uniform(1e-3, 0.05))
        if rng.random() < 0.5:
            fields |= {"controller_model": {"payload.mass": "80 kg", "supply.pressure": float(rng.uniform(1e7, 2e7))}}
        return fields | {
            "sensors": str(rng.choice(["ideal", "data-sheet"])),
            "monitor": rng.choice([None, True, False]),
        }

    fields = {
        "joints": {name: q + float(rng.uniform(-0.1, 0.0)) for name, q in JOINTS.items()} | {"extension": 0.1},
        "duration": float(rng.uniform(0.5, 5.0)),
        "record_interval": float(rng.uniform(1e-3, 0.1)),
        "payload": None if rng.random() < 0.5 else float(rng.uniform(0, 300)),
        "payload_changes": {float(t): float(rng.uniform(0, 100)) for t in times(0.1)} if rng.random() < 0.5 else {},
        "overrides": {"supply.pressure": "100 bar", "friction.lift.coulomb": [float(rng.uniform(50, 200)), 120.0]},
        "seed": int(rng.integers(0, 2**53)),
        "name": f"drawn-{seed}-ä",
        "title": 'back\\slash, "quoted" and ä',
        "solver": hc.Solver("hc-rosenbrock-3", step=float(rng.uniform(1e-3, 5e-3)))
        if rng.random() < 0.5
        else hc.Solver("rodas5p", rtol=float(rng.uniform(1e-8, 1e-3)), atol=None, max_step=0.02),
    }
    if rng.random() < 0.5:
        fields["pressures"] = {name: tuple(rng.uniform(0, 1e7, 2)) for name in CYLINDERS}
    if rng.random() < 0.3:
        how = str(rng.choice(["hold", "linear"]))
        commands = {name: hc.Command(at := times(), rng.uniform(-0.04, 0.04, at.size), how) for name in CYLINDERS[:2]}
        return hc.Scenario(**fields, commands=commands)
    mode = str(rng.choice(["tip", "lever"]))
    fields |= loop(mode)
    fields["monitor"] = None if fields["monitor"] is None else bool(fields["monitor"])
    faults = [
        hc.SensorFault("joint.boom.q", "jump", 0.1, 0.02, 1.0),
        hc.SensorFault("cylinder.jib.p2", "drop-out", 0.5),
    ]
    fields["sensor_faults"] = faults[: rng.integers(0, 3)]
    phases = [hc.Phase(float(rng.uniform(0.1, 0.3)), overrides={"supply.pressure": 9e6})]
    phases.append(hc.Phase(float(rng.uniform(0.4, 0.5)), **loop("tip")))
    fields["phases"] = phases[: rng.integers(0, 3)]
    return hc.Scenario(**fields)


@pytest.mark.parametrize("seed", range(40))
def test_a_scenario_reads_back_the_same(seed, tmp_path):
    plan = drawn(seed)
    again = hc.load_scenario(plan.save(tmp_path / "drawn.toml"))
    assert stated(again) == stated(plan)
    assert again.to_toml() == plan.to_toml()


@pytest.mark.parametrize("name", hc.bundled_scenarios())
def test_bundled_scenarios_read_back_the_same(name, tmp_path):
    plan = hc.load_scenario(name)
    cylinders = plan.load_machine().cylinder_names
    again = hc.load_scenario(plan.save(tmp_path / "again.toml"))
    assert plain(scenario_entry(again, cylinders)) == plain(scenario_entry(plan, cylinders))


def test_what_no_file_can_state_is_refused(tmp_path):
    plan = hc.Scenario(joints=JOINTS, controller=lambda obs, stick: [0.0, 0.0, 0.0])
    with pytest.raises(hc.InputError, match="cannot hold your own controller"):
        plan.to_toml()
    other = hc.Scenario(joints=JOINTS, controller="tip", controller_model=hc.load_machine("heinze-2007"))
    with pytest.raises(hc.InputError, match="state it as overrides"):
        other.to_toml()
    with pytest.raises(hc.InputError, match=r"ends in \.toml"):
        hc.Scenario(joints=JOINTS).save(tmp_path / "plan.txt")
