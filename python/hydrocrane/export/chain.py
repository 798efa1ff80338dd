"""The open chain of a machine in space, for multibody programs.

The plane of the crane is x forward, z up, and y to the left. Angles count from x towards z, which is a rotation about
-y. Frames are those of the machine file: the frame of a link is at the joint that moves it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.machine.description import DescriptionRecord, described, pairs
from hydrocrane.machine.machine import Machine

# (x, z) in the plane, m.
Place = tuple[float, float]
# (x, y, z).
Vector = tuple[float, float, float]
# Axis about which angles count from x towards z.
ACROSS = (0.0, -1.0, 0.0)
# Names of additional parts in the exported files.
RESERVED = ("tip", "payload", "world")
# Number of poses in which lever arms and speeds are evaluated for the limits of effort and speed.
_POSES = 25


@dataclass(frozen=True)
class Link:
    """A link: its mass (kg), centre of gravity (m), outline (m), and elements xx, yy, zz, xy, xz, yz of its tensor of
    inertia about the centre of gravity (kg m^2)."""

    name: str
    mass: float
    centre: Vector
    inertia: tuple[float, float, float, float, float, float]
    outline: tuple[Place, ...]


@dataclass(frozen=True)
class Joint:
    """A joint from link `index` to link `index + 1`.

    Attributes
    ----------
    at : (x, y, z)
        Origin of the child's frame on the parent at coordinate zero, m.
    about : (x, y, z)
        Axis about which the child's frame is turned against the parent's.
    angle : float
        Angle of that turn at coordinate zero, rad.
    axis : (x, y, z)
        Axis of the motion, in the child's frame: `about`, or against it.
    effort, speed : float
        Largest generalised force (N m or N) at supply pressure and largest rate (rad/s or m/s) over the range; rough.
    """

    name: str
    revolute: bool
    at: Vector
    about: Vector
    angle: float
    axis: Vector
    limits: tuple[float, float]
    effort: float
    speed: float

    def angle_at(self, q: float) -> float:
        """Angle of the child's frame against the parent's at a coordinate, rad about `about`."""
        return self.angle + float(np.dot(self.about, self.axis)) * q if self.revolute else self.angle

    def place_at(self, q: float) -> Vector:
        """Origin of the child's frame on the parent at a coordinate, m."""
        x, y, z = self.at if self.revolute else (at + along * q for at, along in zip(self.at, self.axis, strict=True))
        return x, y, z


@dataclass(frozen=True)
class Pin:
    """A point (x, y, z) fixed in a link, m."""

    link: int
    at: Vector


@dataclass(frozen=True)
class FourBar:
    """Torque linkage: a rocker on the parent, a coupler to the child, joined in the pin that the rod moves."""

    rocker: Pin
    coupler: Pin
    rocker_length: float
    coupler_length: float


@dataclass(frozen=True)
class Cylinder:
    """A cylinder from its barrel's pin to its rod's: a point of a link, or the common pin of a linkage."""

    name: str
    barrel: Pin
    # `None`: a rack.
    rod: Pin | FourBar | None


@dataclass(frozen=True)
class Chain:
    """A machine without its hydraulics. `links[0]` is fixed; `gravity` is that of free fall (x, z), m/s^2."""

    name: str
    gravity: Place
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    cylinders: tuple[Cylinder, ...]
    tip: Pin
    payload: float


def open_chain(machine: Machine, payload: float | None) -> Chain:
    """The chain of a machine with a mass at its tip.

    Raises
    ------
    InputError
        A machine that no other program can represent, with the reason.
    """
    if not machine.errata["gravity-sign"]:
        raise InputError(
            f"{machine.name} has the sign of gravity as printed in the thesis, which no other program has; set "
            'errata.gravity-sign = "corrected" to export it'
        )
    about = described(machine.core)
    for record in about.records("links"):
        if record.text("name") in RESERVED:
            raise InputError(
                f"a link of {machine.name} is called `{record.text('name')}`, which is a name of the exported file; "
                "call the link otherwise"
            )
    links = tuple(_link(record, machine.errata["inertia-about"]) for record in about.records("links"))
    return Chain(
        name=machine.name,
        gravity=_gravity(*(about.record("environment").number(key) for key in ("gravity", "slope"))),
        links=links,
        joints=tuple(_joint(machine, about, i) for i in range(len(machine.joint_names))),
        cylinders=tuple(_cylinder(record) for record in about.records("cylinders")),
        tip=_pin(about.record("tip")),
        payload=machine.payload(payload),
    )


def _gravity(acceleration: float, slope: float) -> Place:
    return -acceleration * math.sin(slope), -acceleration * math.cos(slope)


def _link(record: DescriptionRecord, about_frame_counts: bool) -> Link:
    mass, (x, z) = record.number("mass"), record.place("centre_of_gravity")
    about_frame = record.record("inertia_about").kind == "Frame" and about_frame_counts
    inertia = record.number("inertia") - (mass * (x * x + z * z) if about_frame else 0.0)
    outline = tuple(pairs(record.fields["outline"]))
    solid = record.fields["solid"]
    if isinstance(solid, DescriptionRecord):
        xx, zz, xy, xz, yz = (solid.number(name) for name in ("xx", "zz", "xy", "xz", "yz"))
        return Link(record.text("name"), mass, (x, solid.number("y"), z), (xx, inertia, zz, xy, xz, yz), outline)
    # In the plane nothing turns about x and z.
    return Link(record.text("name"), mass, (x, 0.0, z), (inertia, inertia, inertia, 0.0, 0.0, 0.0), outline)


def _joint(machine: Machine, about: DescriptionRecord, index: int) -> Joint:
    record, (parent, child) = about.records("joints")[index], about.records("links")[index : index + 2]
    kind, sense, zero = record.record("kind"), record.number("sense"), record.number("zero")
    (x, z), own = record.place("at"), record.direction("axis")
    revolute, across = kind.kind == "Revolute", own or ACROSS
    if own:
        angle = -sense * zero
        axis = (sense * own[0], sense * own[1], sense * own[2])
    elif revolute:
        included = kind.record("0").kind == "Included"
        angle = parent.number("axis") - child.number("axis") - sense * (zero + (math.pi if included else 0.0))
        axis = (0.0, -sense, 0.0)
    else:
        angle, direction = 0.0, kind.number("direction")
        axis = (sense * math.cos(direction), 0.0, sense * math.sin(direction))
        x, z = x - zero * axis[0], z - zero * axis[2]
    low, high = (float(limit) for limit in machine.joint_limits[index])
    effort, speed = _effort_and_speed(machine, index)
    at = (x, record.number("aside"), z)
    return Joint(machine.joint_names[index], revolute, at, across, angle, axis, (low, high), effort, speed)


def _effort_and_speed(machine: Machine, index: int) -> tuple[float, float]:
    """Largest effort at the pressures that can be held and largest speed at full stroke under the load, over the range
    of one joint with the others in mid-range."""
    low, high = machine.joint_limits[index]
    poses = np.tile(machine.home, (_POSES, 1))
    poses[:, index] = np.linspace(low, high, _POSES + 2)[1:-1]
    levers = np.abs(machine.stroke_jacobian(poses)[:, index, index])
    speeds = np.abs(machine.piston_speeds(poses)[:, index]).max(axis=-1)
    effort = (machine.holdable_pressures * machine.piston_areas)[index].max() * levers.max()
    return float(effort), float((speeds / levers).max())


def _cylinder(record: DescriptionRecord) -> Cylinder:
    rod, barrel = record.record("rod_pin"), _pin(record.record("barrel_pin"))
    if rod.kind == "Rack":
        return Cylinder(record.text("name"), barrel, None)
    inside = rod.record("0")
    end: Pin | FourBar = (
        _pin(inside)
        if rod.kind == "Point"
        else FourBar(
            _pin(inside.record("rocker_pivot")),
            _pin(inside.record("coupler_pivot")),
            inside.number("rocker_length"),
            inside.number("coupler_length"),
        )
    )
    return Cylinder(record.text("name"), barrel, end)


def _pin(record: DescriptionRecord) -> Pin:
    x, z = record.place("position")
    return Pin(int(record.number("link")), (x, record.number("aside"), z))
