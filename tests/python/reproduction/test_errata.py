"""Each erratum switch, flipped alone, has the effect that the errata of the thesis report."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import printed_controller as controller
from oracles import printed_program as program

import hydrocrane as hc

POSE = np.array([np.deg2rad(100.0), np.deg2rad(100.0), 0.0])
BAR = 1e5
L_MIN = 1e-3 / 60


def printed(switch: str | None = None):
    """The machine as printed, one switch corrected."""
    return hc.load_machine("heinze-2007", overrides={f"errata.{switch}": "corrected"} if switch else None)


def state(crane, q=POSE, **values: float) -> np.ndarray:
    """A state at rest at `q` with single entries set, e.g. `extension_p1=...`."""
    x = np.zeros(len(crane.state_names))
    for joint, value in zip(crane.joint_names, q):
        x[crane.state_names.index(f"joint.{joint}.q")] = value
    for key, value in values.items():
        group, entry = key.split("_")
        kind = "joint" if entry in ("q", "qd") else "cylinder"
        x[crane.state_names.index(f"{kind}.{group}.{entry}")] = value
    return x


def rate(crane, x: np.ndarray, name: str) -> float:
    """One component of the state derivative at closed commands."""
    return float(crane.state_derivative(x, np.zeros(len(crane.cylinder_names)))[crane.state_names.index(name)])


def test_gravity_sign():
    """E1. Printed, the crane falls upwards: 3.76 rad/s^2 from rest; cylinder 1 would pull with 7916 N."""
    upward = printed()
    np.testing.assert_allclose(-upward.bias_force(POSE, np.zeros(3)), [1647.5, 107.5, -93.2], atol=0.05)
    assert rate(upward, state(upward), "joint.boom.qd") == pytest.approx(3.757, abs=1e-3)
    assert upward.static_cylinder_force(POSE)[0] == pytest.approx(-7916.2, abs=0.05)
    downward = printed("gravity-sign")
    np.testing.assert_allclose(downward.bias_force(POSE, np.zeros(3)), [1647.5, 107.5, -93.2], atol=0.05)
    assert rate(downward, state(downward), "joint.boom.qd") == pytest.approx(-3.757, abs=1e-3)
    assert downward.static_cylinder_force(POSE)[0] == pytest.approx(7916.2, abs=0.05)


def test_inertia_about():
    """E2. Tensors about the link frames counted about the centres of gravity: M11 1.2 to 1.4 times too large."""
    heavy, right = printed(), printed("inertia-about")
    q = np.random.default_rng(0).uniform([0.8, 0.3, -0.3], [2.3, 3.0, 0.3], (500, 3))
    ratio = np.diagonal(heavy.mass_matrix(q), axis1=1, axis2=2) / np.diagonal(right.mass_matrix(q), axis1=1, axis2=2)
    assert 1.19 < ratio[:, 0].min() < 1.25 and 1.3 < ratio[:, 0].max() < 1.38
    assert 1.33 < ratio[:, 1].min() < 1.45 and 1.5 < ratio[:, 1].max() < 1.63
    np.testing.assert_allclose(ratio[:, 2], 1.0)
    excess = heavy.mass_matrix(POSE) - right.mass_matrix(POSE)
    steiner = [68.2 * (1.085**2 + 0.082**2), 27.54 * (0.403**2 + 0.097**2), 10.11 * (0.678**2 + 0.004**2)]
    assert excess[1, 1] == pytest.approx(steiner[1] + steiner[2], rel=1e-9)
    assert excess[0, 0] == pytest.approx(sum(steiner), rel=1e-9)


def test_orifice_law():
    """E3, E4. Printed, flow is quadratic below 3 bar and doubles there on five of six ports."""
    flow_as_printed, flow_corrected = printed().orifice_flow, printed("orifice-law").orifice_flow
    c0 = 1e-4 / (0.05 * np.sqrt(75e5))
    dp = np.array([1.0, 2.0, 3.0 - 1e-9, 3.0]) * BAR
    spool = np.ones_like(dp)
    jib = {"cylinder": "jib"}
    np.testing.assert_allclose(flow_as_printed(spool, dp, **jib) / c0, [30.4, 121.7, 273.9, 547.7], atol=0.05)
    np.testing.assert_allclose(flow_corrected(spool, dp, **jib) / c0, [243.4, 426.0, 547.7, 547.7], atol=0.05)
    lift = flow_as_printed(spool, dp, cylinder="lift") / c0
    np.testing.assert_allclose(lift[2:], (273.9 + 547.7) / 2, atol=0.05)  # blended, no jump


def test_extension_leakage():
    """E9. Printed, cylinder 3 leaks outwards from p1: 1.42 instead of 0.79 l/min at 180 and 100 bar."""

    def lost(crane):
        x = state(crane, extension_p1=180 * BAR, extension_p2=100 * BAR)
        dry = state(crane, extension_p1=180 * BAR, extension_p2=180 * BAR)
        return flow_into_rod_side(crane, x), flow_into_rod_side(crane, dry)

    internal = 2.738e-13 * 80 * BAR
    as_printed, _ = lost(printed())
    right, _ = lost(printed("extension-leakage"))
    assert (internal - as_printed) / L_MIN == pytest.approx(1.42, abs=0.01)
    assert (internal - right) / L_MIN == pytest.approx(0.79, abs=0.01)


def flow_into_rod_side(crane, x: np.ndarray, cylinder: str = "extension") -> float:
    """Net flow into the rod-side chamber with a closed valve at rest: V p2' / E, m^3/s."""
    p2 = x[crane.state_names.index(f"cylinder.{cylinder}.p2")]
    volume = {
        "extension": 1.2337e-6 + np.pi / 4 * (0.05**2 - 0.03**2) * 0.315,
        "lift": 1.5708e-6 + np.pi / 4 * (0.1**2 - 0.04**2) * (0.165 - crane.strokes(POSE)[0]),
    }[cylinder]
    bulk = 0.5e9 * np.log10(90 * p2 / 200e5 + 3)
    return rate(crane, x, f"cylinder.{cylinder}.p2") * volume / bulk


def test_extension_dead_volume():
    """E10. pi/4 twice: the dead volume of cylinder 3 is 1.23 instead of 1.57 cm^3."""
    full = {"lift_p1": 0.0}
    x_out = 0.31  # nearly all of the rod-side chamber is dead volume there

    def volume(crane):
        x = state(crane, q=[*POSE[:2], x_out], extension_p1=50 * BAR, extension_p2=50 * BAR, **full)
        x[crane.state_names.index("joint.extension.qd")] = 1e-3
        bulk = 0.5e9 * np.log10(90 * 50 / 200 + 3)
        area = np.pi / 4 * (0.05**2 - 0.03**2)
        external = 1.3177238e-12 * 50 * BAR
        return (area * 1e-3 - external) * bulk / rate(crane, x, "cylinder.extension.p2")

    swept = np.pi / 4 * (0.05**2 - 0.03**2) * (0.315 - x_out)
    assert volume(printed()) - swept == pytest.approx(1.2337e-6, rel=1e-3)
    assert volume(printed("extension-dead-volume")) - swept == pytest.approx(1.5708e-6, rel=1e-3)


def test_leakage_viscosity():
    """E11. The 0.6 is no friction coefficient but a viscosity; with 0.04 Pa s leakage is 15 times larger."""

    def external(crane):
        x = state(crane, lift_p1=100 * BAR, lift_p2=100 * BAR)
        return -flow_into_rod_side(crane, x, "lift")

    assert external(printed()) / L_MIN == pytest.approx(1.05, abs=0.005)
    assert external(printed("leakage-viscosity")) / external(printed()) == pytest.approx(15.0, rel=1e-6)


def test_end_stop():
    """E14. Printed, supply pressure pushes piston 1 through its stop: 5 MN/m yields 22.0 mm, the zone is 21.5 mm.

    Corrected, the stop holds the piston inside its cylinder against the full supply force, and damps.
    """
    angle = np.deg2rad(135.75)  # the last 0.1 mm of the stroke of cylinder 1
    q = np.array([angle, POSE[1], 0.0])

    def stop(crane, rates=(0.0, 0.0, 0.0)):
        bare = hc.load_machine("heinze-2007", overrides=WITHOUT_STOPS | dict(crane))
        full = hc.load_machine("heinze-2007", overrides=dict(crane))
        x = state(full, q=q, lift_p1=140 * BAR, boom_qd=rates[0])
        gap = [rate(m, x, "joint.boom.qd") for m in (full, bare)]
        inertia = np.linalg.inv(full.mass_matrix(q))[0, 0] * full.stroke_jacobian(q)[0, 0]
        return (gap[0] - gap[1]) / inertia

    push = 140 * BAR * np.pi / 4 * 0.1**2
    as_printed = {}
    right = {"errata.end-stop": "corrected"}
    assert -push < stop(as_printed) < 0
    assert stop(right) < -push
    assert stop(as_printed, (0.1, 0, 0)) == pytest.approx(stop(as_printed), rel=1e-6)
    assert stop(right, (0.1, 0, 0)) < stop(right)


@pytest.mark.evidence
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # the printed run ends in negative chamber volumes
def test_end_stop_in_the_published_run():
    """E14. Run on past 5 s, the published vertical task drives piston 1 to its end and dies; a real stop holds."""

    def run(switch: str | None):
        return controller.published_run(program_order(printed(switch)), "vertical", duration=15.0)

    with pytest.raises(RuntimeError, match=r"t = 1[23]\."):
        run(None)
    _, states = run("end-stop")
    assert 0.1435 < program.lift_stroke(states[:, 0]).max() < 0.165


def program_order(crane):
    """hydrocrane's state derivative with the states in the thesis's order."""
    order = np.array([crane.state_names.index(name) for name in program.STATE_NAMES])
    inverse = np.argsort(order)
    return lambda x, u: crane.state_derivative(x[inverse], u)[order]


WITHOUT_STOPS = {
    f"cylinder.{name}.end-stop.{key}": value
    for name in ("lift", "jib", "extension")
    for key, value in (("stiffness", 20.0), ("damping", 0.0))
}


def test_friction_map():
    """E15. Printed, 750 N of stiction come on top of Coulomb friction: 850 N at break-away, not 750 N."""
    slow, fast = np.array([1e-9]), np.array([0.1])
    as_printed, right = printed(), printed("friction-map")
    assert as_printed.friction_map(slow, cylinder="lift")[0] == pytest.approx(850.0, rel=1e-4)
    assert right.friction_map(np.array([1e-4]), cylinder="lift")[0] < 750.0
    assert as_printed.friction_map(fast, cylinder="lift")[0] == pytest.approx(450.0, rel=1e-4)
    speeds = np.linspace(1e-6, 0.2, 4000)
    assert as_printed.friction_map(speeds, cylinder="lift").max() == pytest.approx(850.0, rel=1e-3)
    assert right.friction_map(speeds[speeds < 0.02], cylinder="lift").max() <= 750.0


TABLE_1_ANGLES = {"joint.boom.limits": ["45 deg", "172 deg"], "joint.jib.limits": ["5 deg", "178 deg"]}


def test_smoothed_printed_friction_is_the_printed_one_away_from_rest_and_lets_a_stiff_method_cross_it():
    widths = {f"friction.{name}.smoothing-velocity": "1 mm/s" for name in ("lift", "jib", "extension")}
    jumping, smooth = printed(), hc.load_machine("heinze-2007", overrides=widths)
    command = np.zeros(3)
    slow, fast = (state(jumping, extension_qd=speed) for speed in (1e-4, 0.02))
    np.testing.assert_allclose(
        smooth.state_derivative(fast, command), jumping.state_derivative(fast, command), rtol=1e-12, atol=1e-9
    )
    assert not np.allclose(smooth.state_derivative(slow, command), jumping.state_derivative(slow, command), rtol=1e-3)

    crossing = hc.simulate("heinze-2007-open-loop", machine=smooth, method="rodas5p", rtol=1e-4)
    reference = hc.simulate("heinze-2007-open-loop", machine=jumping, method="tsit5", rtol=1e-3)
    assert crossing.outcome.kind == "completed"
    assert crossing.data.attrs["solver_steps"] < 1500
    apart = np.hypot(*(crossing.data[f"tip.{axis}"] - reference.data[f"tip.{axis}"] for axis in "xz"))
    assert apart.max() < 3e-3


def test_ik_quadrant():
    """E23. Unsigned arc cosines put alpha on the wrong side once the tip is behind the pillar."""
    behind = np.array([np.deg2rad(45.0), np.deg2rad(40.0), 0.31])

    def error(**switch: str) -> float:
        overrides = TABLE_1_ANGLES | {"errata.ik-extension": "corrected"} | switch
        crane = hc.load_machine("heinze-2007", overrides=overrides)
        tip = crane.tip(behind)
        assert tip[0] < 0
        return np.rad2deg(min(np.abs(q - behind).max() for q in crane.inverse_kinematics(tip, x3=behind[2])))

    assert error() == pytest.approx(10.556, abs=1e-3)
    assert error(**{"errata.ik-quadrant": "corrected"}) < 1e-9


def test_ik_unreachable():
    """E24. A set-point 5 m before the start is out of reach; printed, a pose is returned all the same."""
    room_to_stretch = {"cylinder.jib.rod-length": "340 mm", "cylinder.jib.barrel-offset": "5 mm"}
    machines = [
        hc.load_machine("heinze-2007", overrides=room_to_stretch | switch)
        for switch in ({}, {"errata.ik-unreachable": "corrected"})
    ]
    target = machines[0].tip(POSE) + [5.0, 0.0]
    assert np.linalg.norm(target - [0.0, 0.73]) > 4.2
    [carried_on] = machines[0].inverse_kinematics(target)
    assert np.linalg.norm(machines[0].tip(carried_on) - target) > 0.5
    assert machines[1].inverse_kinematics(target) == []


def test_ik_extension():
    """E25. Printed, targets count with x3 = 0: from x3 = 0.2 m a lever at rest sends 100, 100 to 94.9, 106.5 deg."""
    extended = np.array([*POSE[:2], 0.2])
    sent_elsewhere = printed().inverse_kinematics(printed().tip(extended), x3=0.2)[0]
    np.testing.assert_allclose(np.rad2deg(sent_elsewhere[:2]), [94.91, 106.51], atol=0.01)
    assert sent_elsewhere[2] == 0.0
    right = printed("ik-extension")
    np.testing.assert_allclose(right.inverse_kinematics(right.tip(extended), x3=0.2)[0], extended, atol=1e-12)


def test_every_switch_is_tested():
    tested = {name.removeprefix("test_").replace("_", "-") for name in globals() if name.startswith("test_")}
    assert set(printed().errata) <= tested
