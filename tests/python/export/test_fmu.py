"""Exported FMUs in FMPy: valid, with the bits of the native simulation, states kept, exact derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
from fmu_in_fmpy import STEP, Unit, commands, inputs

import hydrocrane as hc


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def fmi(request):
    return request.param


@pytest.fixture
def crane():
    return hc.load_machine("rottne-f9-lab")


# FMPy takes seconds to parse the names of many variables.
QUICK = [("single-cylinder", "lever")]
CONTROLLERS = [("rottne-f9-lab", "tip"), ("rottne-f9-mobile", "lever"), ("heinze-2007", "heinze-pid")]
MORE = [(name, None) for name in hc.bundled_machines()] + CONTROLLERS


@pytest.mark.parametrize(
    ("name", "controller"), QUICK + [pytest.param(*case, marks=pytest.mark.evidence) for case in MORE]
)
def test_an_export_is_valid_and_always_the_same_file(name, controller, fmi, tmp_path):
    file, again = (hc.export_fmu(name, tmp_path / f"{i}.fmu", fmi=fmi, controller=controller) for i in ("one", "two"))
    assert validate_fmu(str(file)) == []
    assert file.read_bytes() == again.read_bytes()


@pytest.mark.parametrize(
    "name",
    ["rottne-f9-lab", *(pytest.param(n, marks=pytest.mark.evidence) for n in ("single-cylinder", "rottne-f9-mobile"))],
)
def test_co_simulation_has_the_bits_of_the_native_simulation(name, fmi, tmp_path):
    machine = hc.load_machine(name)
    unit = Unit(hc.export_fmu(machine, tmp_path / "one.fmu", fmi=fmi), tmp_path / "unzipped").begin()
    native = hc.Simulator(machine, sample_time=STEP)
    native.reset(q=machine.home)
    assert unit.get(machine.state_names).tobytes() == native.state.tobytes()
    for i, u in enumerate(commands(300, len(machine.cylinder_names))):
        unit.set(dict(zip(inputs(machine), u, strict=True)))
        obs = native.step(u)
        unit.step(i * STEP)
        assert unit.get(machine.state_names).tobytes() == native.state.tobytes(), i
    assert unit.get(["tip.x", "tip.z"]).tobytes() == obs.tip.tobytes()
    assert unit.get([f"measured.{name}" for name in obs.measured]).tolist() == list(obs.measured.values())
    outputs = machine.outputs(native.state, u)
    names = [n for n in outputs if not n.startswith("energy.")]
    assert unit.get(names).tolist() == [outputs[name].item() for name in names]
    unit.close()


@pytest.mark.evidence
def test_a_scenario_gives_start_payload_solver_and_sensors(crane, tmp_path):
    pose = {"boom": 1.9, "jib": 1.6, "extension": 0.1}
    plan = hc.Scenario(machine=crane, joints=pose, payload=50.0, seed=7, solver=hc.Solver(method="rodas5p", rtol=1e-6))
    file = hc.export_fmu(plan, tmp_path / "one.fmu", sensors="data-sheet")
    unit = Unit(file, tmp_path / "unzipped").begin()
    assert unit.description.modelExchange is None
    native = hc.Simulator(crane, STEP, payload=50.0, method="rodas5p", rtol=1e-6, sensors="data-sheet", seed=7)
    obs = native.reset(q=list(pose.values()))
    names = [f"measured.{name}" for name in obs.measured]
    assert unit.get(names).tolist() == list(obs.measured.values())
    for i, u in enumerate(commands(100, 3)):
        unit.set(dict(zip(inputs(crane), u, strict=True)))
        unit.step(i * STEP)
        obs = native.step(u)
        assert unit.get(names).tolist() == list(obs.measured.values()), i
    unit.close()


@pytest.mark.evidence
def test_parameters_are_those_of_the_machine_file(crane, fmi, tmp_path):
    """Before the start all of them, on the way the tunable ones."""
    unit = Unit(hc.export_fmu(crane, tmp_path / "one.fmu", fmi=fmi), tmp_path / "unzipped")
    unit.begin(
        {"supply.pressure": 9e6, "friction.lift.coulomb[1]": 500.0, "initial.joint.boom": 1.9, "payload.mass": 30}
    )
    changed = crane.changed({"supply.pressure": 9e6, **crane.overrides_at(["friction.lift.coulomb[1]"], [500.0])})
    native = hc.Simulator(changed, STEP, payload=30.0)
    native.reset(q=[1.9, *crane.home[1:]])
    u = np.array([0.02, -0.01, 0.01])
    unit.set(dict(zip(inputs(crane), u, strict=True)))
    for i in range(200):
        if i == 100:
            unit.set({"payload.mass": 80.0})
            native.set_payload(80.0)
        unit.step(i * STEP)
        native.step(u)
        assert unit.get(crane.state_names).tobytes() == native.state.tobytes(), i
    before = unit.get(["joint.boom.qd"])
    unit.set({"supply.pressure": 4e6})
    for i in range(200, 400):
        unit.step(i * STEP)
    assert unit.get(["supply.pressure"]) == [4e6] and unit.get(["joint.boom.qd"]) < 0.9 * before
    unit.close()


SOLVERS = [hc.Solver(method="tsit5"), hc.Solver(step=1e-3), hc.Solver(method="rodas5p")]
CASES = [(solver, sensors) for solver in SOLVERS for sensors in ("ideal", "data-sheet")] + [(hc.Solver(), "ideal")]


@pytest.mark.parametrize(
    ("solver", "sensors"),
    [(hc.Solver(), "data-sheet"), *(pytest.param(*case, marks=pytest.mark.evidence) for case in CASES)],
)
def test_a_state_that_is_put_back_goes_on_with_the_same_bits(crane, solver, sensors, fmi, tmp_path):
    """In the same instance and in a fresh one."""
    joints = dict(zip(crane.joint_names, crane.home, strict=True))
    plan = hc.Scenario(machine=crane, joints=joints, solver=solver, seed=3)
    file = hc.export_fmu(plan, tmp_path / "one.fmu", fmi=fmi, sensors=sensors)
    unit, other = (Unit(file, tmp_path / "unzipped").begin() for _ in range(2))
    names = [v.name for v in unit.description.modelVariables if v.causality in ("output", "local")]
    moves = commands(120, 3)

    def drive(driven: Unit, first: int, last: int) -> bytes:
        seen = []
        for i in range(first, last):
            driven.set(dict(zip(inputs(crane), moves[i], strict=True)))
            driven.step(i * STEP)
            seen.append(driven.get(names))
        return np.array(seen).tobytes()

    drive(unit, 0, 60)
    unit.set({"payload.mass": 20.0})
    drive(unit, 60, 70)
    kept = unit.save()
    seen = drive(unit, 70, 120)
    unit.load(kept)
    assert drive(unit, 70, 120) == seen
    other.load(kept)
    assert drive(other, 70, 120) == seen
    unit.close()
    other.close()


def test_directional_derivatives_are_those_of_the_jacobian(crane, fmi, tmp_path):
    unit = Unit(hc.export_fmu(crane, tmp_path / "one.fmu", fmi=fmi), tmp_path / "unzipped", exchange=True).begin()
    rng = np.random.default_rng(0)
    x, u = crane.equilibrium(crane.home), np.array([0.01, -0.004, 0.002])
    x = x + 1e-3 * rng.standard_normal(x.size) * np.abs(x).clip(1e-3)
    unit.set(dict(zip(inputs(crane), u, strict=True)))
    unit.fmu.enterContinuousTimeMode()
    unit.set_states(x)
    names, rates = list(crane.state_names), [f"der({name})" for name in crane.state_names]
    assert unit.get(rates).tobytes() == crane.state_derivative(x, u).tobytes()
    jacobian = crane.jacobian(x, u)
    for i, name in enumerate(names):
        found = unit.directional(rates, [name], [1.0])
        assert np.abs(found - jacobian[:, i]).max() <= 1e-12 * np.abs(jacobian[:, i]).max()
    seed = rng.standard_normal(len(names)) * np.abs(x).clip(1e-3)
    along = unit.directional(rates, names, seed)
    assert np.allclose(along, jacobian @ seed, rtol=1e-12, atol=1e-12 * np.abs(jacobian @ seed).max())
    # The right-hand side is linear in the commands.
    for c, name in enumerate(inputs(crane)):
        step = 1e-3 * np.eye(3)[c]
        difference = (crane.state_derivative(x, u + step) - crane.state_derivative(x, u - step)) / 2e-3
        assert np.allclose(unit.directional(rates, [name], [1.0]), difference, rtol=1e-9, atol=1e-6)
    unit.close()


@pytest.mark.parametrize(
    ("overrides", "commands"),
    [
        ({}, [0.0, 0.01, 0.2]),
        ({"valve.lift.command.dead-band": "2 mm"}, [0.0, 0.001, 0.01]),
        ({"valve.lift.acceleration-limit": "100 m/s^2"}, [0.0, 0.001]),
    ],
    ids=["plain", "dead-band", "acceleration-limit"],
)
def test_derivatives_by_commands_where_tools_linearise(overrides, commands, tmp_path):
    crane = hc.load_machine("rottne-f9-lab", overrides)
    unit = Unit(hc.export_fmu(crane, tmp_path / "one.fmu"), tmp_path / "unzipped", exchange=True).begin()
    unit.fmu.enterContinuousTimeMode()
    name, rates = inputs(crane)[0], [f"der({name})" for name in crane.state_names]
    for command in commands:
        ends = []
        for step in (1e-7, -1e-7):
            unit.set({name: command + step})
            ends.append(unit.get(rates))
        unit.set({name: command})
        assert np.allclose(unit.directional(rates, [name], [1.0]), (ends[0] - ends[1]) / 2e-7, rtol=1e-6, atol=1e-3)
    unit.close()


# Sizes of states by their unit, for differences.
SIZES = {"rad": 1.0, "rad/s": 0.1, "m": 1e-3, "m/s": 0.1, "Pa": 1e6, "1": 1.0}


def differences(unit, rates, set_to, at, step):
    """Central differences of the rates by one number, that `set_to` sets."""
    ends = []
    for moved in (at + step, at - step):
        set_to(moved)
        ends.append(unit.get(rates))
    set_to(at)
    return (ends[0] - ends[1]) / (2.0 * step)


@pytest.mark.evidence
@pytest.mark.parametrize("name", hc.bundled_machines())
def test_derivatives_of_every_machine_where_tools_linearise(name, tmp_path):
    """By commands at rest, in the dead band, open and beyond the stroke; by states with open and saturated spools."""
    machine = hc.load_machine(name)
    # A delay is no state, so such machines are exported for co-simulation only.
    delays = [key for key in machine.keys if key.endswith(".delay")]
    machine = machine.changed(dict.fromkeys(delays, "0 s"))
    unit = Unit(hc.export_fmu(machine, tmp_path / "one.fmu"), tmp_path / "unzipped", exchange=True).begin()
    unit.fmu.enterContinuousTimeMode()
    names, rates = list(machine.state_names), [f"der({name})" for name in machine.state_names]
    unit_of = dict(zip(names, machine.state_units, strict=True))
    rest, strokes = machine.equilibrium(machine.home), machine.spool_strokes
    spools = [names.index(f"cylinder.{c}.xs") for c in machine.cylinder_names]
    for share in (0.0, 0.01, 0.6, 1.2):
        for sense in (1.0, -1.0):
            unit.set(dict(zip(inputs(machine), sense * share * strokes, strict=True)))
            for c, command in enumerate(inputs(machine)):
                by = differences(unit, rates, lambda v, of=command: unit.set({of: v}), sense * share * strokes[c], 1e-7)
                found = unit.directional(rates, [command], [1.0])
                assert np.allclose(found, by, rtol=1e-5, atol=1e-6 * np.abs(by).max() + 1e-3), (share, command)
        if share < 0.1:
            continue
        # In motion, since printed friction jumps at rest.
        x = rest + np.array([0.01 if state.endswith(".qd") else 0.0 for state in names])
        x[spools] = min(share, 1.0) * strokes * np.resize([1.0, -1.0], strokes.size)
        for i, state in enumerate(names):

            def moved(value, i=i):
                x[i] = value
                unit.set_states(x)

            unit.set_states(x)
            step = 1e-6 * max(abs(x[i]), SIZES[unit_of[state]])
            # A slewing angle changes nothing, and differences see the rounding of the rates.
            rounding = 1e-15 * np.abs(unit.get(rates)) / step
            by = differences(unit, rates, moved, x[i], step)
            found = unit.directional(rates, [state], [1.0])
            assert np.allclose(found, by, rtol=1e-4, atol=1e-4 * np.abs(by).max() + rounding), (share, state, found, by)
    unit.close()


@pytest.mark.evidence
def test_directional_derivatives_of_outputs(crane, fmi, tmp_path):
    """Against central differences of the native outputs, which have no exact derivatives."""
    unit = Unit(hc.export_fmu(crane, tmp_path / "one.fmu", fmi=fmi), tmp_path / "unzipped", exchange=True).begin()
    u = np.zeros(3)
    x = crane.equilibrium(crane.home)
    x[3:6] = 0.02, -0.03, 0.01
    # Away from the centre, where the flow through a spool has a kink.
    x[[8, 13, 18]] = 0.004, -0.003, 0.002
    unit.fmu.enterContinuousTimeMode()
    unit.set_states(x)
    told = crane.outputs(x, u)
    names = [name for name in told if not name.startswith("energy.")]
    seed = np.random.default_rng(1).standard_normal(x.size) * np.abs(x).clip(1e-3)
    found = unit.directional(names, list(crane.state_names), seed)
    h = 1e-5
    ahead, behind = crane.outputs(x + h * seed, u), crane.outputs(x - h * seed, u)
    differences = np.array([(ahead[name] - behind[name]) / (2 * h) for name in names]).ravel()
    size = np.array([abs(told[name]) for name in names]).ravel()
    assert not [
        (name, f, d)
        for name, f, d, s in zip(names, found, differences, size, strict=True)
        if abs(f - d) > 1e-6 * (s + abs(d)) + 1e-9
    ]
    unit.close()


@pytest.mark.evidence
def test_model_exchange_in_cvode_is_within_a_millionth(crane, fmi, tmp_path):
    """All joints and pressures, relative to their scales, against a tight native run under the same commands."""
    file = hc.export_fmu(crane, tmp_path / "one.fmu", fmi=fmi)
    names = [*(f"joint.{j}.{k}" for k in ("q", "qd") for j in crane.joint_names), "tip.x", "tip.z"]
    held = {"cylinder.lift.command": 0.01, "cylinder.jib.command": -0.006, "cylinder.extension.command": 0.004}
    found = simulate_fmu(
        str(file),
        fmi_type="ModelExchange",
        solver="CVode",
        stop_time=0.5,
        output_interval=0.01,
        relative_tolerance=1e-9,
        start_values=held,
        output=names,
    )
    native = hc.Simulator(crane, 0.01, rtol=1e-10)
    native.reset(q=crane.home)
    for row in list(found)[1:]:
        obs = native.step(list(held.values()))
        wanted = np.array([*obs.q, *obs.qd, *obs.tip])
        assert np.abs(np.array(list(row)[1:]) - wanted).max() < 1e-6, row[0]
    assert np.abs(obs.q - crane.home).max() > 0.01


# A spool that changes its side while a piston runs into its end stop; `t` in s, commands in m.
KINKS = np.array(
    [(0.0, -0.05, 0.05), (0.4, -0.05, 0.05), (0.4, 0.02, 0.05), (0.6, 0.02, 0.05)],
    dtype=[("time", float), ("cylinder.lift.command", float), ("cylinder.extension.command", float)],
)


@pytest.mark.evidence
def test_model_exchange_needs_no_events_where_laws_have_kinks(crane, fmi, tmp_path):
    """The error falls with CVODE's tolerance over the edges of a spool, an end stop and chambers that cavitate."""
    crane = crane.changed({"equilibrium.back-pressure": 5e4})
    entry = crane.joint_limits[2, 1] - 0.0355
    start = entry - 0.01
    file = hc.export_fmu(crane, tmp_path / "one.fmu", fmi=fmi)
    native = hc.Simulator(crane, 0.01, rtol=1e-11)
    native.reset(q=[*crane.home[:2], start])
    lifts = np.repeat(KINKS["cylinder.lift.command"][[0, 2]], [40, 20])
    seen = [native.step([lift, 0.0, 0.05]) for lift in lifts]
    assert seen[-1].q[2] > entry + 1e-3 and min(obs.p.min() for obs in seen) < -0.5e5

    def errors(tolerance: float) -> tuple[float, float]:
        """Of coordinates and of rates."""
        found = simulate_fmu(
            str(file),
            fmi_type="ModelExchange",
            solver="CVode",
            stop_time=0.6,
            output_interval=0.01,
            relative_tolerance=tolerance,
            start_values={"initial.joint.extension": start},
            input=KINKS,
            output=[f"joint.{joint}.{kind}" for joint in crane.joint_names for kind in ("q", "qd")],
            record_events=False,
        )
        q, qd = (np.array([found[f"joint.{joint}.{kind}"][1:] for joint in crane.joint_names]) for kind in ("q", "qd"))
        return np.abs(q - np.array([o.q for o in seen]).T).max(), np.abs(qd - np.array([o.qd for o in seen]).T).max()

    loose, tight = errors(1e-7), errors(1e-9)
    assert tight[0] < 1e-6 and tight[1] < 1e-5
    assert tight[0] < 0.2 * loose[0] and tight[1] < 0.2 * loose[1]


def test_laws_that_jump_are_told_to_who_integrates(fmi, tmp_path):
    """The printed laws of 2007; the other machines have none."""
    for name, jumps in (("heinze-2007", {"friction-map", "orifice-law"}), ("single-cylinder", set())):
        file = hc.export_fmu(name, tmp_path / f"{name}.fmu", fmi=fmi)
        unit = Unit(file, tmp_path / name, exchange=True).begin()
        texts = [text for text in unit.messages.texts if "jump" in text]
        assert {text.partition("errata.")[2].partition("`")[0] for text in texts} == jumps
        unit.close()


def test_crane_and_controller_coupled_are_the_native_closed_loop(crane, fmi, tmp_path):
    """The controller first, then the crane: its commands count from the sample on."""
    plant = Unit(hc.export_fmu(crane, tmp_path / "crane.fmu", fmi=fmi), tmp_path / "plant").begin()
    file = hc.export_fmu(crane, tmp_path / "tip.fmu", fmi=fmi, controller="tip")
    controller = Unit(file, tmp_path / "controller").begin()
    native, own = hc.Simulator(crane, 0.01), hc.NamedController("tip", crane)
    obs = native.reset(q=crane.home)
    own.reset(crane, obs)
    readings = [f"measured.{name}" for name in obs.measured]
    for i in range(150):
        stick = np.array([0.3 * np.sin(0.05 * i), 0.2])
        obs = native.step(own.step(obs, hc.Stick("tip", stick)))
        measured = dict(zip(readings, plant.get(readings), strict=True))
        controller.set({**measured, "stick.x": stick[0], "stick.z": stick[1]})
        controller.step(i * 0.01, 0.01)
        plant.set(dict(zip(inputs(crane), controller.get(inputs(crane)), strict=True)))
        plant.step(i * 0.01, 0.01)
        assert plant.get(crane.state_names).tobytes() == native.state.tobytes(), i
    assert np.abs(obs.q - crane.home).max() > 0.01
    plant.close()
    controller.close()


@pytest.mark.evidence
def test_a_controller_samples_by_its_own_period(crane, tmp_path):
    """Between its samples the commands stay; a longer step holds several."""
    file = hc.export_fmu(crane, tmp_path / "tip.fmu", controller="tip")
    fine, coarse = (Unit(file, tmp_path / "unzipped").begin() for _ in range(2))
    told = []
    for unit, count, step in ((fine, 50, 2e-3), (coarse, 5, 20e-3)):
        unit.set({"stick.z": 0.5})
        seen = []
        for i in range(count):
            unit.step(i * step, step)
            seen.append(unit.get(["cylinder.lift.command"])[0])
        told.append(seen)
        unit.close()
    assert len(set(told[0])) == 10
    assert told[0][-1] == told[1][-1] != 0.0


def test_a_controller_that_is_put_back_goes_on_with_the_same_bits(crane, fmi, tmp_path):
    """From its copy more than once, and from its bytes in a fresh instance, in the middle of a motion."""
    file = hc.export_fmu(crane, tmp_path / "tip.fmu", fmi=fmi, controller="tip")
    check_states_of_controller(crane, "tip", file, tmp_path)


@pytest.mark.evidence
@pytest.mark.parametrize(
    ("name", "controller", "settings"),
    [
        ("rottne-f9-lab", "tip", {"monitor": False}),
        ("rottne-f9-lab", "heinze-pid", {}),
        ("rottne-f9-mobile", "lever", {}),
        ("hiab-xs031", "tip", {"parameters": ["supply"]}),
    ],
)
def test_every_controller_can_be_put_back(name, controller, settings, fmi, tmp_path):
    machine = hc.load_machine(name)
    file = hc.export_fmu(machine, tmp_path / "one.fmu", fmi=fmi, controller=controller, **settings)
    check_states_of_controller(machine, controller, file, tmp_path)


def check_states_of_controller(machine, controller, file, folder):
    """Readings of a native run drive instances without a loop, so that only their states can make a difference."""
    units = [Unit(file, folder / "unzipped").begin() for _ in range(2)]
    unit, other = units
    period = hc.NamedController(controller, machine, monitor=False).period
    native, own = hc.Simulator(machine, period), hc.NamedController(controller, machine)
    obs = native.reset(q=machine.home)
    own.reset(machine, obs)
    axes = [name.partition(".")[2] for name in unit.variables if name.startswith("stick.")]
    moves = []
    for i in range(90):
        stick = 0.4 * np.sin(0.07 * i + np.arange(len(axes)))
        sticks = {f"stick.{axis}": value for axis, value in zip(axes, stick, strict=True)}
        moves.append({f"measured.{name}": value for name, value in obs.measured.items()} | sticks)
        obs = native.step(own.step(obs, hc.Stick("lever" if controller == "lever" else "tip", stick)))
    names = [v.name for v in unit.description.modelVariables if v.causality in ("output", "independent")]

    def drive(driven: Unit, first: int, last: int, change: float = 0.0) -> bytes:
        seen = []
        for i in range(first, last):
            driven.set({name: value + (change if "stick" in name else 0.0) for name, value in moves[i].items()})
            driven.step(i * period, period)
            seen.append(driven.get(names))
        return np.array(seen).tobytes()

    before = unit.save()
    drive(unit, 0, 50)
    state, kept = unit.keep(), unit.save()
    seen = drive(unit, 50, 90)
    unit.put_back(state)
    assert drive(unit, 50, 90, 0.1) != seen
    unit.put_back(state)
    assert drive(unit, 50, 90) == seen
    # The instance that was copied is of no account: bytes are enough, and so is the start.
    drive(other, 0, 3, 0.1)
    other.load(kept)
    assert drive(other, 50, 90) == seen
    assert other.save() == unit.save()
    other.load(before)
    drive(other, 0, 50)
    assert other.save() == kept
    unit.let_go(state)
    for one in units:
        one.close()
