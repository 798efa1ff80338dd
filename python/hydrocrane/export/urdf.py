"""URDF: the open chain with limits and inertias, and its tip as a separate link."""

from __future__ import annotations

import math
from os import PathLike
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from scipy.spatial.transform import Rotation

from hydrocrane.export.chain import Chain, Joint, Link, Vector, open_chain
from hydrocrane.export.text import in_space, numbers, segments, thickness, written
from hydrocrane.files.whole_file import write_text
from hydrocrane.machine.machine import MachineLike, as_machine

TIP = "tip"


def export_urdf(machine: MachineLike, path: str | PathLike[str], *, payload: float | None = None) -> Path:
    """Write a machine's open chain as URDF. Returns the path.

    Links, joints and joint coordinates have the names, frames and zeros of the machine file, with y to the left. The
    link ``tip`` is fixed at the crane tip and has the payload's mass. A machine file in the plane has one moment of
    inertia; the other two have the same value and no effect, because nothing rotates about their axes. Limits of
    effort and velocity are rough: supply pressure on the piston, and full stroke under the load.

    URDF has no closed loops: cylinders and torque linkages are left out. Generalised forces are
    ``crane.stroke_jacobian(q).T @ force``.

    Parameters
    ----------
    machine : Machine, str or path
    path : path
        Path of the file, usually ``.urdf``.
    payload : float, optional
        kg at the tip; the machine's own by default.

    Raises
    ------
    InputError
        A machine with the printed sign of gravity.

    Examples
    --------
    >>> import hydrocrane as hc
    >>> hc.export_urdf("hiab-xs031", "hiab.urdf")  # doctest: +SKIP
    """
    chain = open_chain(as_machine(machine), payload)
    return write_text(path, urdf_text(chain))


def urdf_text(chain: Chain) -> str:
    """The document."""
    root = Element("robot", name=chain.name)
    radius = thickness(chain)
    for index, link in enumerate(chain.links):
        # The base is fixed; readers warn about a root with inertia.
        _add_link(root, link, radius, heavy=index > 0)
    for index, joint in enumerate(chain.joints):
        _add_joint(root, joint, chain.links[index].name, chain.links[index + 1].name)
    _add_tip(root, chain)
    x, z = chain.gravity
    gravity = f"{-z!r} m/s^2 along -z" if x == 0.0 else f"({x!r}, 0.0, {z!r}) m/s^2, because its base stands on a slope"
    head = (
        f"{chain.name}, written by hydrocrane. SI; x forward, z up; joint coordinates are those of the machine file. "
        f"Gravity of the machine: {gravity}."
    )
    return written(root, head)


def _add_link(root: Element, link: Link, radius: float, *, heavy: bool) -> None:
    made = SubElement(root, "link", name=link.name)
    if heavy:
        _inertial(made, link.mass, in_space(link.centre), link.inertia)
    for start, end in segments(link.outline):
        visual = SubElement(made, "visual")
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        slope = math.atan2(end[1] - start[1], end[0] - start[0])
        SubElement(visual, "origin", xyz=in_space(middle), rpy=numbers((0.0, -slope, 0.0)))
        size = (math.dist(start, end), 2 * radius, 2 * radius)
        SubElement(SubElement(visual, "geometry"), "box", size=numbers(size))


def _inertial(
    made: Element, mass: float, centre: str, inertia: tuple[float, float, float, float, float, float]
) -> None:
    inertial = SubElement(made, "inertial")
    SubElement(inertial, "origin", xyz=centre, rpy="0 0 0")
    SubElement(inertial, "mass", value=numbers([mass]))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    SubElement(inertial, "inertia", {name: numbers([value]) for name, value in zip(names, inertia, strict=True)})


def _add_joint(root: Element, joint: Joint, parent: str, child: str) -> None:
    made = SubElement(root, "joint", name=joint.name, type="revolute" if joint.revolute else "prismatic")
    SubElement(made, "parent", link=parent)
    SubElement(made, "child", link=child)
    SubElement(made, "origin", xyz=in_space(joint.at), rpy=numbers(_roll_pitch_yaw(joint.about, joint.angle)))
    SubElement(made, "axis", xyz=numbers(joint.axis))
    low, high = (numbers([limit]) for limit in joint.limits)
    SubElement(made, "limit", lower=low, upper=high, effort=numbers([joint.effort]), velocity=numbers([joint.speed]))


def _roll_pitch_yaw(about: Vector, angle: float) -> Vector:
    """Angles about the fixed axes x, y and z, one after the other, that turn by an angle about an axis, rad."""
    if about[0] == about[2] == 0.0:
        return 0.0, about[1] * angle, 0.0
    x, y, z = Rotation.from_rotvec(np.multiply(about, angle)).as_euler("xyz")
    return float(x), float(y), float(z)


def _add_tip(root: Element, chain: Chain) -> None:
    tip = SubElement(root, "link", name=TIP)
    if chain.payload > 0:
        _inertial(tip, chain.payload, "0 0 0", (0.0,) * 6)
    made = SubElement(root, "joint", name=f"{TIP}.fixed", type="fixed")
    SubElement(made, "parent", link=chain.links[chain.tip.link].name)
    SubElement(made, "child", link=TIP)
    SubElement(made, "origin", xyz=in_space(chain.tip.at), rpy="0 0 0")
