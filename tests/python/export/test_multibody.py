"""URDF in Pinocchio and MJCF in MuJoCo: the same mass matrices, gravity, tips and strokes as here."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import run
from multibody import in_mujoco, in_pinocchio, pinocchio_model

import hydrocrane as hc
from hydrocrane import _core

NAMES = [name for name in hc.bundled_machines() if name != "heinze-2007"]
COUNT = 40
PAYLOAD = 80.0


@pytest.fixture(scope="module", params=NAMES)
def crane(request):
    return hc.load_machine(request.param)


@pytest.fixture
def poses(crane, random_poses):
    q = random_poses(crane, COUNT, seed=3)
    return q, np.random.default_rng(4).normal(size=q.shape)


def along(crane, places):
    """Of places (x, y, z) what the crane's tip has."""
    return places[:, ["xyz".index(axis) for axis in crane.tip_axes]]


def assert_close(ours, theirs, bound):
    """Relative to the largest entry of each sample."""
    ours, theirs = np.array(ours), np.array(theirs)
    largest = np.abs(theirs).reshape(len(theirs), -1).max(axis=1)
    largest = np.maximum(largest, 1e-6 * largest.max())
    assert np.abs(ours - theirs).reshape(len(theirs), -1).max(axis=1) == pytest.approx(0.0, abs=bound * largest.max())
    assert (np.abs(ours - theirs).reshape(len(theirs), -1).max(axis=1) < bound * largest).all()


@pytest.mark.parametrize("payload", [0.0, PAYLOAD])
def test_pinocchio_reads_the_machine(crane, poses, payload, tmp_path):
    pin = pytest.importorskip("pinocchio")
    path = hc.export_urdf(crane, tmp_path / "crane.urdf", payload=payload)
    model = pinocchio_model(pin, path, crane)
    assert tuple(model.names)[1:] == crane.joint_names
    np.testing.assert_allclose(
        np.stack([model.lowerPositionLimit, model.upperPositionLimit], axis=-1), crane.joint_limits, rtol=1e-14
    )
    q, qd = poses
    mass, bias, place = in_pinocchio(pin, model, q, qd)
    assert_close(crane.mass_matrix(q, payload=payload), mass, 1e-9)
    assert_close(crane.bias_force(q, qd, payload=payload), bias, 1e-9)
    assert_close(crane.tip(q), along(crane, place), 1e-9)


@pytest.mark.parametrize("payload", [0.0, PAYLOAD])
def test_mujoco_reads_the_machine(crane, poses, payload, tmp_path):
    mujoco = pytest.importorskip("mujoco")
    path = hc.export_mjcf(crane, tmp_path / "crane.xml", payload=payload)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    np.testing.assert_allclose(model.jnt_range, crane.joint_limits, rtol=1e-12)
    n = len(crane.joint_names)
    mass, bias, place = in_mujoco(mujoco, model, *poses)
    lever = []
    for q, qd in zip(*poses, strict=True):
        data.qpos[:], data.qvel[:] = q, qd
        # A unit force at every cylinder between pins gives a row of the stroke Jacobian.
        rows = []
        for cylinder in range(n):
            data.ctrl[:] = np.eye(n)[cylinder]
            mujoco.mj_forward(model, data)
            rows.append(data.qfrc_actuator.copy())
        lever.append(rows)
    q, qd = poses
    assert_close(crane.mass_matrix(q, payload=payload), mass, 1e-6)
    assert_close(crane.bias_force(q, qd, payload=payload), bias, 1e-6)
    assert_close(crane.tip(q), along(crane, place), 1e-6)
    ours = crane.stroke_jacobian(q)
    for i in range(n):
        by_tendon = model.actuator_trntype[i] == mujoco.mjtTrn.mjTRN_TENDON
        expected = ours[:, i] if by_tendon else np.tile(np.eye(n)[i], (COUNT, 1))
        np.testing.assert_allclose(np.array(lever)[:, i], expected, atol=1e-9)


@pytest.mark.parametrize("name", ["rottne-f9-lab"])
def test_a_closed_linkage_has_the_lever_arm(name, tmp_path, random_poses):
    """The cylinder of the linkage pulls at the rocker; what reaches the joint over the coupler is force times dx/dq."""
    mujoco = pytest.importorskip("mujoco")
    crane = hc.load_machine(name)
    path = hc.export_mjcf(crane, tmp_path / "crane.xml", linkages=True)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    assert model.nv == 4 and model.neq == 1
    rocker = model.joint("jib.rocker").qposadr[0]
    joints = [model.joint(joint).qposadr[0] for joint in crane.joint_names]
    length = model.tendon_length0[model.tendon("jib.coupler").id]
    assert length == pytest.approx(0.194, abs=1e-9)

    def world_angle(q):
        pivot, pin, _ = next(p for kind, owner, p in crane.drawing(q) if (kind, owner) == ("torque-link", "jib"))
        return np.arctan2(*(pin - pivot)[::-1]), pin

    for q in random_poses(crane, 10, seed=6, margin=0.1):
        data.qpos[joints] = q
        # The rocker turns in the boom, whose coordinate turns it as well.
        data.qpos[rocker] = world_angle(q)[0] - world_angle(crane.home)[0] - (q[0] - crane.home[0])
        mujoco.mj_forward(model, data)
        assert data.ten_length[model.tendon("jib.coupler").id] == pytest.approx(length, abs=1e-9)
        np.testing.assert_allclose(data.site("jib.rod").xpos[[0, 2]], world_angle(q)[1], atol=1e-9)
        # Virtual work: with the coupler's length kept, the cylinder's tendon moves by dx/dq of the crane.
        pull, held = _row(mujoco, model, data, "jib"), _row(mujoco, model, data, "jib.coupler")
        jib = joints[1]
        found = pull[jib] - pull[rocker] * held[jib] / held[rocker]
        assert found == pytest.approx(crane.stroke_jacobian(q)[1, 1], rel=1e-8)


def _row(mujoco, model, data, tendon):
    """d(length)/d(q) of a tendon (nv,)."""
    moved, row = data.qpos.copy(), np.zeros(model.nv)
    for k in range(model.nv):
        lengths = []
        for side in (1e-6, -1e-6):
            data.qpos[:] = moved
            data.qpos[k] += side
            mujoco.mj_forward(model, data)
            lengths.append(data.ten_length[model.tendon(tendon).id])
        row[k] = (lengths[0] - lengths[1]) / 2e-6
    data.qpos[:] = moved
    mujoco.mj_forward(model, data)
    return row


def test_what_cannot_be_exported_says_why(tmp_path):
    text = _core.bundled_text("machine", "single-cylinder").replace("link.mass", "link.tip")
    (tmp_path / "named.toml").write_text(text.replace('"mass"', '"tip"').replace('"mass.', '"tip.'), encoding="utf-8")
    for export in (hc.export_urdf, hc.export_mjcf):
        with pytest.raises(hc.InputError, match="is called `tip`"):
            export(tmp_path / "named.toml", tmp_path / "x")
        with pytest.raises(hc.InputError, match="sign of gravity as printed"):
            export("heinze-2007", tmp_path / "x")
        with pytest.raises(hc.InputError, match="payload"):
            export("single-cylinder", tmp_path / "x", payload=-1.0)
        with pytest.raises(hc.ResultFileError):
            export("single-cylinder", tmp_path)
    assert not (tmp_path / "x").exists()


@pytest.mark.evidence
def test_commands(tmp_path):
    for kind, suffix in (("urdf", "urdf"), ("mjcf", "xml")):
        done = run("export", kind, "rottne-f9-lab", "--payload", 50, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / f"rottne-f9-lab.{suffix}").is_file() and "written" in done.stdout
        assert f"hydrocrane export {kind}" in run("export", kind, "--help").stdout
    assert run("export", "mjcf", "rottne-f9-lab", "--linkages", "-o", "closed.xml", folder=tmp_path).returncode == 0
    done = run("export", "urdf", "heinze-2007", folder=tmp_path)
    assert done.returncode == 2 and "gravity-sign" in done.stderr
