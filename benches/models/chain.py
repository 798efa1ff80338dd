"""Machine files of planar chains with as many equal links and cylinders as wanted."""

from __future__ import annotations

from pathlib import Path

HEAD = """
[machine]
name = "chain-{n}"
title = "Chain of {n} equal links"
description = "Horizontal chain of {n} links of one metre, a cylinder at every joint; for benchmarks."
class = "assumed"
source = "made for the benchmark of growth"
tip = "link{n}.end"

[environment]
gravity = "9.81 m/s^2"

[link.link0]
axis = "0 deg"

[fluid]
density = "870 kg/m^3"
bulk-modulus-max = "1 GPa"
bulk-c1 = 90
bulk-c2 = 3
bulk-reference-pressure = "200 bar"
cavitation = "free-gas"
vacuum = "-1 bar"
viscosity = "0.04 Pa s"

[supply]
pressure = "140 bar"
tank-pressure = "0 bar"

[payload]
mass = "0 kg"

[equilibrium]
back-pressure = "10 bar"
"""

POINTS = """
[link.link{i}.point]
end = "(1, 0) m"
barrel = "(0.4, -0.25) m"
rod = "(0.3, -0.1) m"
"""

JOINT = """
[link.link{i}]
mass = "20 kg"
centre-of-gravity = "(0.5, 0) m"
inertia = "1.7 kg m^2"
inertia-about = "centre-of-gravity"

[joint.joint{i}]
type = "revolute"
convention = "relative"
parent = "link{before}"
child = "link{i}"
at = "end"

[cylinder.cylinder{i}]
joint = "joint{i}"
barrel = "link{before}.barrel"
rod = "link{i}.rod"
bore = "60 mm"
rod-diameter = "35 mm"
stroke = "300 mm"
closed-length = "760 mm"
dead-volume = ["0.05 l", "0.05 l"]
internal-leakage = "1e-14 m^3/(s Pa)"
external-leakage = "0 m^3/(s Pa)"

[cylinder.cylinder{i}.end-stop]
zone = "20 mm"
stiffness = "5e6 N/m"
damping = "5e4 N s/m"

[valve.valve{i}]
cylinder = "cylinder{i}"
type = "4/3"
stroke = "50 mm"
nominal-flow = "1e-4 m^3/s"
nominal-pressure-drop = "150 bar"
transition-pressure = "3 bar"
natural-frequency = "161.2 Hz"
damping-ratio = 0.481

[friction.friction{i}]
cylinder = "cylinder{i}"
model = "lugre"
coulomb = ["200 N", "300 N"]
breakaway = ["400 N", "450 N"]
stribeck-velocity = ["2 mm/s", "2 mm/s"]
stribeck-exponent = 2
viscous = ["8000 N s^1.5/m^1.5", "12000 N s^1.5/m^1.5"]
viscous-exponent = 1.5
smoothing-velocity = "1 mm/s"
bristle-stiffness = "1.5e5 N/m"
bristle-damping = "2000 N s/m"
bristle-damping-velocity = "0.1 m/s"
"""


def write_chain(links: int, folder: Path) -> Path:
    """The file of a chain; the first link stands still."""
    parts = [HEAD.format(n=links), POINTS.format(i=0)]
    parts += [JOINT.format(i=i, before=i - 1) + POINTS.format(i=i) for i in range(1, links + 1)]
    path = folder / f"chain-{links}.toml"
    path.write_text("".join(parts), encoding="utf-8")
    return path
