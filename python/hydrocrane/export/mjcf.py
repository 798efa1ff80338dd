"""MJCF of MuJoCo: the chain with its cylinders as actuators, optionally with closed torque linkages.

A cylinder between two links is a tendon from pin to pin. Its length is the distance of the pins, so the force of its
actuator acts on the joints through the exact stroke Jacobian. A torque linkage has no such tendon: its cylinder either
acts on the joint itself, or the rocker is a separate body, with the coupler as a tendon of constant length.
"""

from __future__ import annotations

import math
from os import PathLike
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from hydrocrane.export.chain import ACROSS, Chain, Cylinder, FourBar, Joint, Link, Pin, Vector, open_chain
from hydrocrane.export.text import in_space, numbers, segments, thickness, written
from hydrocrane.export.urdf import TIP
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import Machine, MachineLike, as_machine

# Mass of the rocker of a closed linkage, kg; the machine file has none. Its length is a few decimetres.
ROCKER_MASS = 1e-3
# Moment of inertia of a point mass, kg m^2, because MuJoCo refuses zero.
LEAST = 1e-9


def export_mjcf(
    machine: MachineLike, path: str | PathLike[str], *, payload: float | None = None, linkages: bool = False
) -> Path:
    """Write a machine as MJCF for MuJoCo. Returns the path.

    Joints have the names, frames, coordinates and limits of the machine file, with y to the left; the site ``tip`` is
    the crane tip. Each cylinder is an actuator of its name whose control is the net cylinder force, N, positive pushes
    the piston out. It pulls at a tendon of the same name between the pins. The cylinder of a torque linkage acts on the
    joint (control in N m or N: the force times the lever arm), unless `linkages` closes the linkage.

    Parameters
    ----------
    machine : Machine, str or path
    path : path
        Path of the file, usually ``.xml``.
    payload : float, optional
        kg at the tip; the machine's own by default.
    linkages : bool
        Close torque linkages: the rocker is a body of 1 g with a joint ``<cylinder>.rocker``, the coupler a constraint.
        Its constraint is soft, like all constraints of MuJoCo.

    Raises
    ------
    InputError
        A machine with the printed sign of gravity.

    Examples
    --------
    >>> import hydrocrane as hc
    >>> hc.export_mjcf("hiab-xs031", "hiab.xml")  # doctest: +SKIP
    """
    machine = as_machine(machine)
    chain = open_chain(machine, payload)
    closed = [i for i, c in enumerate(chain.cylinders) if linkages and isinstance(c.rod, FourBar)]
    rockers = {chain.cylinders[i].name: _rocker_angle(machine, chain, i) for i in closed}
    return write_text(path, mjcf_text(chain, [float(q) for q in machine.home], rockers))


def mjcf_text(chain: Chain, home: list[float], rockers: dict[str, float]) -> str:
    """The document, with the pose `home` as its initial configuration.

    With closed linkages `rockers` has the angle of each rocker in the frame of its link in that pose.
    """
    root = Element("mujoco", model=chain.name)
    # Angles in radians; inertias as given, not from the geometry.
    SubElement(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
    SubElement(root, "option", gravity=in_space(chain.gravity), timestep="0.001", integrator="implicitfast")
    parent = SubElement(root, "worldbody")
    bodies = [parent]
    radius = thickness(chain)
    _add_drawing(parent, chain.links[0], radius)
    for link, joint, q in zip(chain.links[1:], chain.joints, home, strict=True):
        bodies.append(_add_body(bodies[-1], link, joint, q, radius))
    tip = bodies[chain.tip.link]
    if chain.payload > 0:
        load = SubElement(tip, "body", name="payload", pos=in_space(chain.tip.at))
        SubElement(load, "inertial", pos="0 0 0", mass=numbers([chain.payload]), diaginertia=numbers([LEAST] * 3))
    SubElement(tip, "site", name=TIP, pos=in_space(chain.tip.at))
    tendons, equalities = Element("tendon"), Element("equality")
    actuators = Element("actuator")
    for cylinder, joint in zip(chain.cylinders, chain.joints, strict=True):
        if cylinder.rod is None or (isinstance(cylinder.rod, FourBar) and cylinder.name not in rockers):
            SubElement(actuators, "motor", name=cylinder.name, joint=joint.name)
            continue
        if isinstance(cylinder.rod, FourBar):
            _close(bodies, tendons, equalities, cylinder, cylinder.rod, rockers[cylinder.name])
        else:
            _site(bodies, f"{cylinder.name}.rod", cylinder.rod)
        _site(bodies, f"{cylinder.name}.barrel", cylinder.barrel)
        _tendon(tendons, cylinder.name, f"{cylinder.name}.barrel", f"{cylinder.name}.rod", radius)
        SubElement(actuators, "motor", name=cylinder.name, tendon=cylinder.name)
    root.extend(section for section in (tendons, equalities, actuators) if len(section))
    head = (
        f"{chain.name}, written by hydrocrane. SI; x forward, z up; joint coordinates are those of the machine file. "
        "Controls are net cylinder forces, N, positive pushes the piston out"
        + ("." if all("tendon" in a.attrib for a in actuators) else "; of torque linkages, generalised forces.")
    )
    return written(root, head)


def _add_body(parent: Element, link: Link, joint: Joint, q: float, radius: float) -> Element:
    turned = _turned(joint.angle_at(q), joint.about)
    body = SubElement(parent, "body", name=link.name, pos=in_space(joint.place_at(q)), quat=turned)
    inertial = SubElement(body, "inertial", pos=in_space(link.centre), mass=numbers([link.mass]))
    moments, products = link.inertia[:3], link.inertia[3:]
    if any(products):
        inertial.set("fullinertia", numbers(link.inertia))
    else:
        inertial.set("diaginertia", numbers(max(moment, LEAST) for moment in moments))
    kind = "hinge" if joint.revolute else "slide"
    axis, limits = numbers(joint.axis), numbers(joint.limits)
    SubElement(body, "joint", name=joint.name, type=kind, axis=axis, range=limits, ref=numbers([q]))
    _add_drawing(body, link, radius)
    return body


def _turned(angle: float, about: Vector) -> str:
    """A rotation about an axis as a quaternion."""
    return numbers((math.cos(angle / 2), *(math.sin(angle / 2) * along for along in about)))


def _add_drawing(body: Element, link: Link, radius: float) -> None:
    """Capsules along the outline, without contacts."""
    for start, end in segments(link.outline):
        ends = f"{in_space(start)} {in_space(end)}"
        SubElement(
            body, "geom", type="capsule", fromto=ends, size=numbers([radius]), contype="0", conaffinity="0", mass="0"
        )


def _site(bodies: list[Element], name: str, pin: Pin) -> None:
    SubElement(bodies[pin.link], "site", name=name, pos=in_space(pin.at))


def _tendon(tendons: Element, name: str, first: str, last: str, radius: float) -> None:
    made = SubElement(tendons, "spatial", name=name, width=numbers([radius / 2]))
    for site in (first, last):
        SubElement(made, "site", site=site)


def _close(
    bodies: list[Element], tendons: Element, equalities: Element, cylinder: Cylinder, bar: FourBar, angle: float
) -> None:
    """The rocker as a body with its joint at zero in the initial configuration, and the coupler as a tendon of constant
    length."""
    name = f"{cylinder.name}.rocker"
    rocker = SubElement(
        bodies[bar.rocker.link], "body", name=name, pos=in_space(bar.rocker.at), quat=_turned(angle, ACROSS)
    )
    end = (bar.rocker_length, 0.0)
    inertia = ROCKER_MASS * bar.rocker_length**2 / 3
    middle = in_space((bar.rocker_length / 2, 0.0))
    SubElement(rocker, "inertial", pos=middle, mass=numbers([ROCKER_MASS]), diaginertia=numbers([inertia] * 3))
    SubElement(rocker, "joint", name=name, type="hinge", axis="0 -1 0")
    SubElement(rocker, "site", name=f"{cylinder.name}.rod", pos=in_space(end))
    coupler = f"{cylinder.name}.coupler"
    _site(bodies, coupler, bar.coupler)
    _tendon(tendons, coupler, f"{cylinder.name}.rod", coupler, 0.01)
    # Zero deviation from the initial length, as stiff as the time step allows.
    SubElement(equalities, "tendon", name=coupler, tendon1=coupler, polycoef="0 0 0 0 0", solref="0.002 1")


def _rocker_angle(machine: Machine, chain: Chain, index: int) -> float:
    """Angle of the rocker of a cylinder in the frame of its link, with the crane in mid-range, rad."""
    lines = {name: points for kind, name, points in machine.drawing(machine.home) if kind == "torque-link"}
    pivot, pin, _ = lines[chain.cylinders[index].name]
    turns = zip(chain.joints[:index], machine.home, strict=False)
    # Drawings show every link turned into the plane.
    link = sum(joint.angle_at(float(q)) for joint, q in turns if joint.about == ACROSS)
    return math.atan2(pin[1] - pivot[1], pin[0] - pivot[0]) - link
