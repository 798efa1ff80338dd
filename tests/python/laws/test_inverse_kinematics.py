"""Poses from tips and from strokes: the inverse functions undo the forward ones over the whole workspace."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

CRANES = ("rottne-f9-lab", "hiab-xs031")


@pytest.fixture(scope="module", params=CRANES)
def crane(request):
    return hc.load_machine(request.param)


def joint_of_the_boom(crane):
    """Height of the first joint, m."""
    return dict(zip(CRANES, (0.73, 0.85), strict=True))[crane.name]


def assert_inverse(crane, poses):
    """Every pose is among the solutions for its own tip; every solution reaches the tip within the limits."""
    low, high = crane.joint_limits.T
    for pose, tip in zip(poses, crane.tip(poses), strict=True):
        found = crane.inverse_kinematics(tip, x3=pose[-1])
        assert 1 <= len(found) <= 2
        for solution in found:
            np.testing.assert_allclose(crane.tip(solution), tip, rtol=0, atol=1e-9)
            assert ((solution >= low - 1e-12) & (solution <= high + 1e-12)).all()
            assert solution[-1] == pose[-1]
        assert min(np.abs(solution - pose).max() for solution in found) < 1e-9


def test_tips_over_the_whole_workspace(crane, random_poses):
    assert_inverse(crane, random_poses(crane, 500, seed=61, margin=1e-3))


def test_tips_below_the_joint_of_the_boom(crane, random_poses):
    poses = random_poses(crane, 2000, seed=62, margin=1e-3)
    low = poses[crane.tip(poses)[:, 1] < joint_of_the_boom(crane) - 1.0]
    assert len(low) > 50
    assert_inverse(crane, low[:200])


def test_tips_behind_the_pillar(crane, random_poses):
    poses = random_poses(crane, 2000, seed=63, margin=1e-3)
    behind = poses[crane.tip(poses)[:, 0] < -0.2]
    assert len(behind) > 20
    assert_inverse(crane, behind[:200])


def test_nothing_reaches_outside_the_workspace(crane):
    reach = max(np.linalg.norm(curve - [0.0, joint_of_the_boom(crane)], axis=1).max() for curve in crane.workspace())
    for angle in np.linspace(0.0, 2 * np.pi, 24, endpoint=False):
        far = np.array([0.0, joint_of_the_boom(crane)]) + (reach + 0.5) * np.array([np.cos(angle), np.sin(angle)])
        for x3 in np.linspace(*crane.joint_limits[-1], 3):
            assert crane.inverse_kinematics(far, x3=float(x3)) == []


def test_nothing_reaches_with_the_telescope_beyond_its_limit(crane):
    tip = crane.tip(crane.home)
    low, high = crane.joint_limits[-1]
    assert crane.inverse_kinematics(tip, x3=float(low - 0.01)) == []
    assert crane.inverse_kinematics(tip, x3=float(high + 0.01)) == []


def test_joints_from_strokes_undo_strokes(corrected, random_poses):
    """Over the whole limits, dead centres included: and with them poses where the stroke hardly changes."""
    poses = random_poses(corrected, 500, seed=64, margin=0.0)
    np.testing.assert_allclose(corrected.joints_from_strokes(corrected.strokes(poses)), poses, rtol=0, atol=1e-9)


def test_joints_from_strokes_reach_both_limits(corrected):
    for end in corrected.joint_limits.T:
        np.testing.assert_allclose(corrected.joints_from_strokes(corrected.strokes(end)), end, rtol=0, atol=1e-9)


def test_strokes_outside_are_refused_by_name(corrected):
    low, high = corrected.stroke_limits.T
    for i, cylinder in enumerate(corrected.cylinder_names):
        for outside in (low[i] - 1e-3, high[i] + 1e-3):
            x = corrected.strokes(corrected.home)
            x[i] = outside
            with pytest.raises(hc.OutOfReachError, match=cylinder):
                corrected.joints_from_strokes(x)
