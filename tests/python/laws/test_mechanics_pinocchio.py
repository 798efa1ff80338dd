"""Mechanics against Pinocchio: the same chains, built here from the numbers printed in the machines' sources.

Pinocchio computes in three dimensions with recursive algorithms; hydrocrane in the plane with Jacobians. The plane is
x forward, z up, and angles run from x towards z, so that revolute joints turn about -y.
"""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc

pin = pytest.importorskip("pinocchio")

COUNT = 200
PAYLOADS = (0.0, 80.0, 750.0)


def in_plane(x: float, z: float) -> np.ndarray:
    return np.array([x, 0.0, z])


def turned(angle: float) -> np.ndarray:
    """Rotation matrix from x towards z."""
    return pin.utils.rotate("y", -angle)


def body(mass: float, centre: tuple[float, float], inertia: float) -> pin.Inertia:
    """Mass (kg), centre of gravity (m) and moment of inertia about it (kg m^2); only turning about y matters."""
    return pin.Inertia(mass, in_plane(*centre), inertia * np.eye(3))


def body_about_frame(mass: float, centre: tuple[float, float], inertia: float) -> pin.Inertia:
    return body(mass, centre, inertia - mass * (centre[0] ** 2 + centre[1] ** 2))


class Chain:
    """A Pinocchio model: `joints` are (kind, place on the parent, frame angle at zero), `bodies` one list per link."""

    def __init__(self, gravity, joints, bodies, tip, payload):
        self.model = pin.Model()
        self.model.gravity.linear = in_plane(0.0, -gravity)
        parent = 0
        for i, (kind, at, angle) in enumerate(joints):
            turning = kind == "revolute"
            # A sliding link keeps its parent's orientation; its angle is the direction of sliding.
            joint = (
                pin.JointModelRevoluteUnaligned(np.array([0.0, -1.0, 0.0]))
                if turning
                else pin.JointModelPrismaticUnaligned(in_plane(np.cos(angle), np.sin(angle)))
            )
            placement = pin.SE3(turned(angle) if turning else np.eye(3), in_plane(*at))
            parent = self.model.addJoint(parent, joint, placement, f"joint{i}")
            for inertia in bodies[i]:
                self.model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
        self.tip_on_link = in_plane(*tip)
        self.model.appendBodyToJoint(
            parent, pin.Inertia(payload, self.tip_on_link, np.zeros((3, 3))), pin.SE3.Identity()
        )
        self.data = self.model.createData()
        self.last = parent

    def mass_matrix(self, q):
        upper = np.triu(pin.crba(self.model, self.data, q))
        return upper + np.triu(upper, 1).T

    def bias(self, q, qd):
        return pin.nonLinearEffects(self.model, self.data, q, qd)

    def acceleration(self, q, qd, torque):
        return pin.aba(self.model, self.data, q, qd, torque)

    def point(self, q, link, place):
        """World position (2,) and Jacobian (2, n) of a point of a link; link 0 is the base."""
        pin.computeJointJacobians(self.model, self.data, q)
        if link == 0:
            return np.array(place), np.zeros((2, self.model.nv))
        world = self.data.oMi[link].act(in_plane(*place))
        spatial = pin.getJointJacobian(self.model, self.data, link, pin.ReferenceFrame.WORLD)
        linear = spatial[:3] + np.cross(spatial[3:].T, world).T
        return world[[0, 2]], linear[[0, 2]]


def laboratory_crane(payload):
    """Heinze (2007), program DIMENSION: inertias about the link frames.

    The boom stands at the angle alpha - 90 deg, the jib at beta - 180 deg from it.
    """
    return Chain(
        gravity=9.81,
        joints=[
            ("revolute", (0.0, 0.73), -np.pi / 2),
            ("revolute", (2.309, 0.081), -np.pi),
            ("prismatic", (0.382, 0.100), 0.0),
        ],
        bodies=[
            [body_about_frame(68.2, (1.085, 0.082), 118.644)],
            [body_about_frame(27.54, (0.403, 0.097), 7.9)],
            [body_about_frame(10.11, (0.678, 0.004), 5.942)],
        ],
        tip=(1.136, -0.051),
        payload=payload,
    )


def loader_crane(payload):
    """Petrovic & Mattila (2022), data repository: several bodies on each link, inertias about their own centres."""
    return Chain(
        gravity=9.8066,
        joints=[
            ("revolute", (-0.189261, 0.85), 0.0),
            ("revolute", (1.59687, 0.100002), 0.0),
            ("prismatic", (1.5943733034, 0.2780458856), 0.928646e-3),
        ],
        bodies=[
            [
                body(25.52660174, (0.252349, 0.102075), 0.67891020),
                body(54.58702836, (0.999380, 0.132068), 5.97255351),
                body(10.34519231, (0.266930, -0.199718), 0.55785997),
                body(17.36281648, (0.827047, -0.093343), 0.90763033),
            ],
            [
                body(33.92850233, (0.657387, 0.088902), 7.40915161),
                body(10.34519231, (0.223006, -0.259984), 0.55785997),
                body(9.26136143, (0.975299, 0.277471), 1.48398069),
            ],
            [
                body(6.73059863, (-0.631971, -0.000587), 0.91790),
                body(570.18877059, (0.254788, -0.130107), 67.38128576),
            ],
        ],
        tip=(0.4051166966, -0.1238788856),
        payload=payload,
    )


# Cylinder pins: (link, point) of the barrel and of the rod, where the cylinder joins two links directly.
PINS = {
    "rottne-f9-lab": {0: ((1, (0.199, -0.061)), (0, (0.115, 0.033))), 2: ((2, (0.255, 0.207)), (3, (1.058, 0.107)))},
    "hiab-xs031": {
        0: ((0, (0.185, -0.085)), (1, (0.3733125533, -0.0457569910))),
        1: ((1, (0.4733107372, -0.0394946286)), (2, (0.2962797110, -0.0877857213))),
        2: ((2, (0.3533738385, 0.2768934361)), (3, (0.0, 0.0))),
    },
}
BUILD = {"rottne-f9-lab": laboratory_crane, "hiab-xs031": loader_crane}


@pytest.fixture(scope="module", params=BUILD)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def crane(name):
    return hc.load_machine(name)


@pytest.fixture
def motions(crane, random_poses):
    """Poses and rates (COUNT, n)."""
    q = random_poses(crane, COUNT, seed=11)
    return q, np.random.default_rng(12).normal(size=q.shape)


def assert_close(ours, theirs):
    """1e-9 relative, entry by entry; entries that cancel, against the largest one of their sample."""
    theirs = np.array(theirs)
    largest = np.abs(theirs).reshape(len(theirs), -1).max(axis=1)
    floor = 1e-4 * largest.reshape(-1, *[1] * (theirs.ndim - 1))
    assert (np.abs(ours - theirs) / (np.abs(theirs) + floor)).max() < 1e-9


def test_tip_and_its_jacobian(name, crane, motions):
    chain = BUILD[name](0.0)
    place = (chain.tip_on_link[0], chain.tip_on_link[2])
    points, jacobians = zip(*(chain.point(q, chain.last, place) for q in motions[0]), strict=True)
    assert_close(crane.tip(motions[0]), points)
    assert_close(crane.tip_jacobian(motions[0]), jacobians)


@pytest.mark.parametrize("payload", PAYLOADS)
def test_mass_matrix(name, crane, motions, payload):
    chain = BUILD[name](payload)
    assert_close(crane.mass_matrix(motions[0], payload=payload), [chain.mass_matrix(q) for q in motions[0]])


@pytest.mark.parametrize("payload", PAYLOADS)
def test_bias_force(name, crane, motions, payload):
    chain = BUILD[name](payload)
    theirs = [chain.bias(q, qd) for q, qd in zip(*motions, strict=True)]
    assert_close(crane.bias_force(*motions, payload=payload), theirs)


@pytest.mark.parametrize("payload", PAYLOADS)
def test_forward_dynamics(name, crane, motions, payload):
    chain = BUILD[name](payload)
    force = np.random.default_rng(13).normal(scale=2e4, size=motions[0].shape)
    torque = np.einsum("mcj,mc->mj", crane.stroke_jacobian(motions[0]), force)
    theirs = [chain.acceleration(*sample) for sample in zip(*motions, torque, strict=True)]
    assert_close(crane.forward_dynamics(*motions, force, payload=payload), theirs)


def test_energies(name, crane, motions):
    """Potential energy is counted from the inertial frame's origin."""
    chain = BUILD[name](80.0)
    kinetic = [pin.computeKineticEnergy(chain.model, chain.data, q, qd) for q, qd in zip(*motions, strict=True)]
    potential = [pin.computePotentialEnergy(chain.model, chain.data, q) for q in motions[0]]
    assert_close(crane.kinetic_energy(*motions, payload=80.0), kinetic)
    np.testing.assert_allclose(crane.potential_energy(motions[0], payload=80.0), potential, rtol=1e-9, atol=1e-9)


def test_stroke_jacobian_of_cylinders_between_two_pins(name, crane, motions):
    """A cylinder lengthens by what its pins part along its axis."""
    chain = BUILD[name](0.0)
    ours = crane.stroke_jacobian(motions[0])
    for cylinder, (barrel, rod) in PINS[name].items():
        theirs = []
        for q in motions[0]:
            start, start_rate = chain.point(q, *barrel)
            end, end_rate = chain.point(q, *rod)
            axis = (end - start) / np.linalg.norm(end - start)
            theirs.append(axis @ (end_rate - start_rate))
        assert_close(ours[:, cylinder], theirs)
