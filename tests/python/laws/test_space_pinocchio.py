"""Chains in space against Pinocchio: random machines, built there from the numbers that their files state.

Links stand at random, joints turn about axes of their own, about that across the plane, or slide in the plane; racks
and cylinders between pins move them; centres of gravity and pins lie beside the plane, and inertias are full tensors.
"""

from __future__ import annotations

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import _core

pin = pytest.importorskip("pinocchio")

COUNT = 200
PAYLOAD = 130.0
SEEDS = range(6)
GRAVITY, SLOPE = 9.81, 0.12


def cylinder(name, joint, place):
    """Tables of a cylinder with valve and seals of the laboratory crane's lift, moved as `place` says."""
    of_lab = _core.bundled_text("machine", "rottne-f9-lab")
    valve = of_lab[of_lab.index("[valve.lift]") : of_lab.index("[valve.lift.printed]")]
    friction = of_lab[of_lab.index("[friction.lift]") : of_lab.index("[friction.jib]")]
    tables = (valve + friction).replace("lift", name)
    return f"""
[cylinder.{name}]
joint = "{joint}"
{place}
bore = "100 mm"
rod-diameter = "40 mm"
dead-volume = "0.1 l"
internal-leakage = "0 m^3/(s Pa)"
external-leakage = "0 m^3/(s Pa)"
[cylinder.{name}.end-stop]
zone = "5 mm"
stiffness = "5e6 N/m"
damping = "5e4 N s/m"
{tables}"""


class Drawn:
    """A random chain: its text as a machine file, and its model in Pinocchio."""

    def __init__(self, seed):
        random = np.random.default_rng(seed)
        self.text = f"""[machine]
name = "drawn"
class = "assumed"
source = "random"
tip = "link5.tip"
[environment]
gravity = "{GRAVITY} m/s^2"
slope = "{SLOPE} rad"
[link.link0.point]
next = "(0.1, -0.2, 0.9) m"
"""
        self.pins = {}
        self.model = pin.Model()
        self.model.gravity.linear = GRAVITY * np.array([-np.sin(SLOPE), 0.0, -np.cos(SLOPE)])
        at, parent = np.array([0.1, -0.2, 0.9]), 0
        kinds = random.permutation(["own", "own", "own", "plane", "slide"])
        for i, kind in enumerate(kinds, start=1):
            zero, sense = random.uniform(-0.3, 0.3), random.choice([1.0, -1.0])
            next_at, mass = random.uniform(-1.5, 1.5, 3), random.uniform(20.0, 200.0)
            centre = 0.5 * next_at + random.uniform(-0.1, 0.1, 3)
            # The tensor of some points is one that a body can have.
            points = random.normal(scale=0.4, size=(6, 3))
            tensor = sum(mass / 6 * (p @ p * np.eye(3) - np.outer(p, p)) for p in points - points.mean(axis=0))
            self._link(i, next_at, mass, centre, tensor)
            self._joint(i, kind, random, at, zero, sense)
            if kind == "slide":
                along = np.array([np.cos(self.direction), 0.0, np.sin(self.direction)]) * sense
                joint, turned = pin.JointModelPrismaticUnaligned(along), np.eye(3)
                shift = at - along * zero
            else:
                axis = self.axis * sense
                joint, turned = pin.JointModelRevoluteUnaligned(axis), pin.AngleAxis(-zero, axis).matrix()
                shift = at
            parent = self.model.addJoint(parent, joint, pin.SE3(turned, shift), f"joint{i}")
            self.model.appendBodyToJoint(parent, pin.Inertia(mass, centre, tensor), pin.SE3.Identity())
            at = next_at
        self.tip = at
        load = pin.Inertia(PAYLOAD, self.tip, np.zeros((3, 3)))
        self.model.appendBodyToJoint(parent, load, pin.SE3.Identity())
        self.data, self.last = self.model.createData(), parent
        of_lab = _core.bundled_text("machine", "rottne-f9-lab")
        self.text += of_lab[of_lab.index("[fluid]") : of_lab.index("[fluid.printed]")]
        self.text += of_lab[of_lab.index("[supply]") : of_lab.index("# --- Sensors")]

    def _link(self, i, next_at, mass, centre, tensor):
        x, y, z = (float(number) for number in next_at)
        a, b, c = (float(number) for number in centre)
        self.text += f"""
[link.link{i}]
mass = "{mass!r} kg"
centre-of-gravity = "({a!r}, {b!r}, {c!r}) m"
inertia = "{float(tensor[1, 1])!r} kg m^2"
inertia-about = "centre-of-gravity"
inertia-x = "{float(tensor[0, 0])!r} kg m^2"
inertia-z = "{float(tensor[2, 2])!r} kg m^2"
inertia-xy = "{float(tensor[0, 1])!r} kg m^2"
inertia-xz = "{float(tensor[0, 2])!r} kg m^2"
inertia-yz = "{float(tensor[1, 2])!r} kg m^2"
[link.link{i}.point]
{"tip" if i == 5 else "next"} = "({x!r}, {y!r}, {z!r}) m"
pin = "(0, 0) m"
"""

    def _joint(self, i, kind, random, at, zero, sense):
        unit = "m" if kind == "slide" else "rad"
        positive = {
            ("slide", 1.0): "along", ("slide", -1.0): "against",
        }.get((kind, sense), "counter-clockwise" if sense > 0 else "clockwise")  # fmt: skip
        limits = f'limits = ["{zero - 0.9!r} {unit}", "{zero + 0.9!r} {unit}"]'
        own, place = "", 'rack-radius = "0.5 m"\nstroke = "2 m"'
        if kind == "own":
            self.axis = random.normal(size=3)
            self.axis /= np.linalg.norm(self.axis)
            own = f'axis = "({", ".join(repr(float(number)) for number in self.axis)})"'
            if random.random() < 0.5:
                place = self._pinned(i, at)
        elif kind == "plane":
            self.axis = np.array([0.0, -1.0, 0.0])
            own = 'convention = "relative"'
        else:
            self.direction = float(random.uniform(-np.pi, np.pi))
            own = f'direction = "{self.direction!r} rad"'
            # The pins lie 3 m apart along the slide where the joint is at zero, and 0.4 m across it.
            back = np.array([np.cos(self.direction), 0.0, np.sin(self.direction)]) * -3.0 * sense
            self.pins[i] = at + back + [0.0, 0.4, 0.0], np.zeros(3)
            self._point(i - 1, f"behind{i}", self.pins[i][0])
            place = f'barrel = "link{i - 1}.behind{i}"\nrod = "link{i}.pin"\nstroke = "2.2 m"\nclosed-length = "1.9 m"'
        self.text += f"""
[joint.joint{i}]
type = "{"prismatic" if kind == "slide" else "revolute"}"
parent = "link{i - 1}"
child = "link{i}"
at = "next"
zero = "{zero!r} {unit}"
positive = "{positive}"
{own}
{limits}
"""
        self.text += cylinder(f"c{i}", f"joint{i}", place)

    def _pinned(self, i, at):
        """Pins across the axis of the joint, at right angles where it is at zero, and beside each other along it."""
        out = np.cross(self.axis, [0.3, -0.5, 0.8])
        out /= np.linalg.norm(out)
        barrel = at + 1.2 * np.cross(self.axis, out) + 0.1 * self.axis
        rod = 0.5 * out - 0.2 * self.axis
        self.pins[i] = barrel, rod
        self._point(i - 1, f"behind{i}", barrel)
        self._point(i, f"before{i}", rod)
        return (
            f'barrel = "link{i - 1}.behind{i}"\nrod = "link{i}.before{i}"\nstroke = "1.1 m"\nclosed-length = "0.75 m"'
        )

    def _point(self, link, name, place):
        """A point in the table of a link."""
        head = f"[link.link{link}.point]\n"
        before, after = self.text.split(head)
        self.text = before + head + f'{name} = "({", ".join(repr(float(x)) for x in place)}) m"\n' + after


@pytest.fixture(scope="module", params=SEEDS)
def drawn(request, tmp_path_factory):
    chain = Drawn(request.param)
    path = tmp_path_factory.mktemp("drawn") / "drawn.toml"
    path.write_text(chain.text, encoding="utf-8")
    return hc.load_machine(path), chain


@pytest.fixture
def motions(drawn, random_poses):
    q = random_poses(drawn[0], COUNT, seed=21)
    return q, np.random.default_rng(22).normal(size=q.shape)


def assert_close(ours, theirs):
    """1e-9 of the largest entry of each sample."""
    theirs = np.array(theirs)
    largest = np.abs(theirs).reshape(len(theirs), -1).max(axis=1).reshape(-1, *[1] * (theirs.ndim - 1))
    assert (np.abs(ours - theirs) / largest).max() < 1e-9


def test_places_and_their_derivatives(drawn, motions):
    crane, chain = drawn
    tips, jacobians, centres = [], [], []
    for q in motions[0]:
        pin.computeJointJacobians(chain.model, chain.data, q)
        world = chain.data.oMi[chain.last].act(chain.tip)
        spatial = pin.getJointJacobian(chain.model, chain.data, chain.last, pin.ReferenceFrame.WORLD)
        tips.append(world)
        jacobians.append(spatial[:3] + np.cross(spatial[3:].T, world).T)
        links = range(1, chain.last + 1)
        # With its load the last link has another centre.
        centres.append([chain.data.oMi[i].act(chain.model.inertias[i].lever) for i in links][:-1])
    assert_close(crane.tip(motions[0]), tips)
    assert_close(crane.tip_jacobian(motions[0]), jacobians)
    assert_close(crane.centres_of_gravity(motions[0])[:, :-1], centres)


def test_cylinders_between_pins(drawn, motions):
    """Their lengths, and that they lengthen by what the pins part along them."""
    crane, chain = drawn
    strokes, slopes = crane.strokes(motions[0]), crane.stroke_jacobian(motions[0])
    for i, (barrel, rod) in chain.pins.items():
        middle = crane.value(f"cylinder.c{i}.closed-length").si + crane.value(f"cylinder.c{i}.stroke").si / 2
        lengths, rates = [], []
        for q in motions[0]:
            pin.computeJointJacobians(chain.model, chain.data, q)
            ends, columns = [], []
            for link, place in ((i - 1, barrel), (i, rod)):
                world = chain.data.oMi[link].act(place)
                spatial = pin.getJointJacobian(chain.model, chain.data, link, pin.ReferenceFrame.WORLD)
                ends.append(world)
                columns.append(spatial[:3] + np.cross(spatial[3:].T, world).T if link else np.zeros((3, 5)))
            between = ends[1] - ends[0]
            lengths.append(np.linalg.norm(between))
            rates.append(between @ (columns[1] - columns[0]) / lengths[-1])
        np.testing.assert_allclose(strokes[:, i - 1], np.array(lengths) - middle, atol=1e-12)
        np.testing.assert_allclose(slopes[:, i - 1], rates, atol=1e-12)


def test_equations_of_motion(drawn, motions):
    crane, chain = drawn
    mass, bias, accelerations = [], [], []
    force = np.random.default_rng(23).normal(scale=2e4, size=motions[0].shape)
    torque = np.einsum("mcj,mc->mj", crane.stroke_jacobian(motions[0]), force)
    for q, qd, own in zip(*motions, torque, strict=True):
        upper = np.triu(pin.crba(chain.model, chain.data, q))
        mass.append(upper + np.triu(upper, 1).T)
        bias.append(pin.nonLinearEffects(chain.model, chain.data, q, qd))
        accelerations.append(pin.aba(chain.model, chain.data, q, qd, own))
    assert_close(crane.mass_matrix(motions[0], payload=PAYLOAD), mass)
    assert_close(crane.bias_force(*motions, payload=PAYLOAD), bias)
    assert_close(crane.forward_dynamics(*motions, force, payload=PAYLOAD), accelerations)


def test_energies(drawn, motions):
    crane, chain = drawn
    kinetic = [pin.computeKineticEnergy(chain.model, chain.data, q, qd) for q, qd in zip(*motions, strict=True)]
    potential = [pin.computePotentialEnergy(chain.model, chain.data, q) for q in motions[0]]
    assert_close(crane.kinetic_energy(*motions, payload=PAYLOAD), kinetic)
    assert_close(crane.potential_energy(motions[0], payload=PAYLOAD), potential)


def test_exact_jacobian(drawn, random_states):
    """Against central differences of the whole state derivative."""
    crane, _ = drawn
    states, commands = random_states(crane, 3, seed=24)
    for state, command in zip(states, commands, strict=True):
        exact = crane.jacobian(state, command, payload=PAYLOAD)
        joints = 2 * len(crane.joint_names)
        for i in range(joints):
            step = 1e-6 * np.eye(len(state))[i]
            difference = crane.state_derivative(state + step, command, payload=PAYLOAD)
            difference = (difference - crane.state_derivative(state - step, command, payload=PAYLOAD)) / 2e-6
            rates = slice(joints // 2, joints)
            largest = np.abs(exact[rates]).max()
            assert np.abs(exact[rates, i] - difference[rates]).max() < 1e-6 * largest
