"""Centres of gravity and cylinder directions of the lab crane against the thesis's vector chains, written out here."""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

ALPHA, BETA, X3 = np.deg2rad(112.0), np.deg2rad(83.0), 0.11


@pytest.fixture(scope="module")
def crane() -> hc.Machine:
    return hc.load_machine("rottne-f9-lab")


def rotation(angle: float) -> np.ndarray:
    """Thesis A_y(angle), restricted to x and z."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def test_centres_of_gravity_are_those_of_the_vector_chains(crane: hc.Machine) -> None:
    """Thesis (31)-(33)."""
    to_boom = rotation(np.pi / 2 - ALPHA)
    to_jib = to_boom @ rotation(np.pi - BETA)
    joint_2 = np.array([0.0, 0.73])
    joint_3 = joint_2 + to_boom @ [2.309, 0.081]
    telescope = np.array([0.255, 0.207]) + [0.04 + 0.355 + X3 + 0.04 + 0.71 + 0.04, 0.0] - [1.058, 0.107]
    expected = [
        joint_2 + to_boom @ [1.085, 0.082],
        joint_3 + to_jib @ [0.403, 0.097],
        joint_3 + to_jib @ (telescope + [0.678, 0.004]),
    ]
    np.testing.assert_allclose(crane.centres_of_gravity([ALPHA, BETA, X3]), expected, atol=1e-14)


def test_cylinders_point_from_barrel_to_rod(crane: hc.Machine) -> None:
    """The drawn cylinders lie along the slopes; the extension cylinder lies along the jib."""
    pose = [ALPHA, BETA, X3]
    slopes = crane.cylinder_slopes(pose)
    rods = [line for kind, _, line in crane.drawing(pose) if kind == "cylinder-rod"]
    for slope, (mouth, pin) in zip(slopes, rods, strict=True):
        np.testing.assert_allclose(np.arctan2(*(pin - mouth)[::-1]), slope, atol=1e-12)
    np.testing.assert_allclose(slopes[2], ALPHA - np.pi / 2 + BETA - np.pi, atol=1e-14)


def test_workspace_boundary_is_reached_and_bounds(crane: hc.Machine) -> None:
    """The closed curves are reached with the telescope at its ends; no pose lies beyond the outermost points."""
    curves = crane.workspace()
    for curve in curves[:2]:
        for tip in curve[::20]:
            assert any(crane.inverse_kinematics(tip, x3=x3) for x3 in crane.joint_limits[2])
    limits = crane.joint_limits
    rng = np.random.default_rng(3)
    tips = crane.tip(rng.uniform(limits[:, 0], limits[:, 1], (2000, 3)))
    points = np.concatenate(curves)
    assert (tips >= points.min(axis=0) - 1e-9).all() and (tips <= points.max(axis=0) + 1e-9).all()


def test_telescope_joins_the_corners_of_the_boundary(crane: hc.Machine) -> None:
    """The last four curves are paths of the telescope alone: straight, and as long as its travel."""
    for path in crane.workspace()[-4:]:
        ends = np.linalg.norm(path[-1] - path[0])
        along = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        np.testing.assert_allclose([ends, along], np.ptp(crane.joint_limits[2]), rtol=1e-12)


def test_limits_of_a_file_end_at_the_stroke() -> None:
    short = hc.load_machine("tests/data/small-excavator.toml", {"cylinder.arm.stroke": "51 mm"})
    assert short.joint_limit_reasons[1] == ("stroke end", "machine file")
    assert short.stroke_limits[1][1] == pytest.approx(0.0255, abs=1e-12)
    turned = hc.load_machine("rottne-f9-forwarder", {"cylinder.slew.stroke": "62 mm"})
    assert turned.joint_limit_reasons[0] == ("stroke end", "stroke end")
    np.testing.assert_allclose(turned.stroke_limits[0], [-0.031, 0.031], atol=1e-12)
