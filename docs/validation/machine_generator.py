"""Random machines that are legal and plausible, as text of machine files.

Chains of one to six joints, of 50 kg to 30 t, with every optional part of a circuit. From the seed `SLEWING` on the
first of them slews, so that the machine moves in space. `machine(seed)` always writes the same text.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import hydrocrane as hc

GRAVITY = 9.81
# From this seed on machines slew: up to five joints on a slewing gear.
SLEWING = 1000
# Range of angles about the middle of a joint in which a stroke is looked for, and its number of points.
SPAN, POINTS = np.deg2rad(75.0), 301
# The longest cylinder is this many times its middle length, the shortest the inverse: open is below twice closed.
REACH_OF_CYLINDER = 1.3
# A lever is at least this share of that in the middle of the range.
LEAST_LEVER = 0.4
# Share of the supply pressure that the rated load asks for at the least favourable pose.
LOADED = 0.7


@dataclass(frozen=True)
class RandomMachine:
    """A machine file, and what a test needs to know of it: its rated load, kg, and the parts that were drawn."""

    seed: int
    text: str
    rated: float
    parts: tuple[str, ...]

    def load(self, folder: Path) -> hc.Machine:
        path = folder / f"random-{self.seed}.toml"
        path.write_text(self.text, encoding="utf-8")
        return hc.load_machine(path)


@dataclass
class Draft:
    """Tables of a file as they come; a section is a joint with its cylinder and valve."""

    rng: np.random.Generator
    supply: float = 0.0
    # Whether all seals have bristles; else some friction is a static map.
    bristles: bool = True
    # Draws what was added later, so that the rest of a seed's machine stays.
    later: np.random.Generator = field(default_factory=np.random.default_rng)
    tables: dict[str, dict[str, Any]] = field(default_factory=dict)
    parts: set[str] = field(default_factory=set)

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def log_between(self, low: float, high: float) -> float:
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def one_of(self, *choices: str) -> str:
        return choices[self.rng.integers(len(choices))]

    def put(self, table: str, **values: Any) -> None:
        """Adds keys to a table; underscores stand for hyphens."""
        own = self.tables.setdefault(table, {})
        own.update({key.replace("_", "-"): value for key, value in values.items()})

    def part(self, table: str, **values: Any) -> None:
        self.parts.add(table.split(".")[0])
        self.put(table, **values)

    def text(self) -> str:
        lines: list[str] = []
        for name, values in self.tables.items():
            lines += ["", f"[{name}]", *(f"{key} = {json.dumps(value)}" for key, value in values.items())]
        return "\n".join(lines[1:]) + "\n"


@dataclass(frozen=True)
class Section:
    """A cylinder as the circuit needs it: areas, m^2, travel, m, flow at full stroke, m^3/s, and the side that
    carries the load."""

    name: str
    areas: tuple[float, float]
    travel: float
    flow: float
    loaded: int
    regenerative: bool

    @property
    def sides(self) -> tuple[str, str]:
        """The side that carries the load, and the other one."""
        names = ("piston-side", "rod-side")
        return names[self.loaded], names[1 - self.loaded]


def si(value: float, unit: str = "") -> Any:
    """A value with four digits, as text with its unit if it has one."""
    return f"{value:.4g} {unit}" if unit else float(f"{value:.4g}")


def bar(pressure: float) -> str:
    return si(pressure / 1e5, "bar")


def lpm(flow: float) -> str:
    return si(6e4 * flow, "l/min")


def point(place: Any) -> str:
    return f"({place[0]:.4f}, {place[1]:.4f}) m"


def polar(radius: float, angle: float) -> np.ndarray:
    return radius * np.array([np.cos(angle), np.sin(angle)])


def machine(seed: int) -> RandomMachine:
    """The machine of a seed."""
    draft = Draft(np.random.default_rng([36, seed]), later=np.random.default_rng([42, seed]))
    count = int(draft.rng.integers(1, 6 if seed >= SLEWING else 7))
    mass = draft.log_between(50.0, 30e3)
    # From 1.5 m at 50 kg to 10 m at 30 t, as cranes and excavators have it.
    reach = 1.5 * (mass / 50.0) ** 0.3 * draft.between(0.8, 1.2)
    # Half of an excavator or a loader crane is what moves.
    mass *= 0.5
    rated = float(f"{mass * draft.between(0.05, 0.2):.3g}")
    draft.supply = 1e5 * round(draft.between(100.0, 350.0), -1)
    draft.bristles = draft.chance(0.6)
    draft.put("machine", name=f"random-{seed}", tip=f"link{count}.tip", **{"class": "assumed", "source": "drawn"})
    draft.put("environment", gravity=f"{GRAVITY} m/s^2")
    if draft.later.random() < 0.5:
        draft.parts.add("slope")
        draft.put("environment", slope=si(draft.later.uniform(-15.0, 15.0), "deg"))
    sections = chain(draft, count, mass, reach, rated)
    if seed >= SLEWING:
        sections.append(slewing(draft, count, mass, reach, rated))
    compensated = circuit(draft, sections)
    for section in sections:
        valve(draft, section, compensated)
        beside(draft, section)
    fluid(draft)
    owned = {"class": "assumed", "source": "drawn"}
    for name, values in draft.tables.items():
        draft.tables[name] = owned | values
    return RandomMachine(seed, draft.text(), rated, tuple(sorted(draft.parts)))


def chain(draft: Draft, count: int, mass: float, reach: float, rated: float) -> list[Section]:
    """Links, joints and cylinders, the base first."""
    lengths = draft.rng.dirichlet(np.full(count, 12.0)) * reach
    masses = draft.between(0.5, 0.9) ** np.arange(count)
    masses *= mass / masses.sum()
    draft.put("link.link0", outline=["(0, -0.5) m", "(0, 0) m"])
    draft.put("link.link0.point", joint1="(0, 0) m")
    before = 0.25 * reach
    sections = []
    for i, (length, own) in enumerate(zip(lengths, masses, strict=True), 1):
        centre = draft.between(0.4, 0.55) * length
        draft.put(
            f"link.link{i}", mass=si(own, "kg"), centre_of_gravity=point((centre, draft.between(-0.05, 0.05) * length)),
            inertia=si(own * length**2 / 12.0 * draft.between(0.7, 1.3), "kg m^2"), inertia_about="centre-of-gravity",
        )  # fmt: skip
        end = {"tip": point((length, 0.0))} if i == count else {f"joint{i + 1}": point((length, 0.0))}
        draft.put(f"link.link{i}.point", **end)
        beyond = np.concatenate([[centre], length + np.cumsum([0.0, *lengths[i:]])[:-1] + 0.5 * lengths[i:]])
        weight = GRAVITY * (masses[i - 1 :].sum() + rated)
        torque = GRAVITY * float(masses[i - 1 :] @ beyond + rated * lengths[i - 1 :].sum())
        slides = draft.chance(0.15 if i == 1 else 0.35)
        draft.parts.add("prismatic" if slides else "revolute")
        place = prismatic if slides else revolute
        sections.append(place(draft, i, before, float(length), weight if slides else torque))
        before = float(length)
    return sections


def slewing(draft: Draft, count: int, mass: float, reach: float, rated: float) -> Section:
    """A slewing gear below the first link, whose axis leans a little, and what the links weigh out of the plane."""
    draft.parts.add("slewing")
    draft.put("link.carrier", outline=["(-0.5, -0.5) m", "(0.5, -0.5) m"])
    draft.put("link.carrier.point", joint0="(0, 0) m")
    own = 0.3 * mass
    draft.put(
        "link.link0", mass=si(own, "kg"), centre_of_gravity=f"({draft.between(-0.1, 0.1) * reach:.4f}, 0, 0.1) m",
        inertia=si(own * (0.1 * reach) ** 2, "kg m^2"), inertia_about="centre-of-gravity",
    )  # fmt: skip
    for i in range(count + 1):
        link = draft.tables[f"link.link{i}"]
        yy = float(link["inertia"].split()[0])
        # As of a beam whose sides are not alike; the second moments of mass stay positive.
        xx = yy * draft.log_between(0.02, 0.3)
        zz = yy + xx * draft.between(-0.8, 0.8)
        link |= {"inertia-x": si(xx, "kg m^2"), "inertia-z": si(zz, "kg m^2")}
        link["inertia-xz"] = si(xx * draft.between(-0.2, 0.2), "kg m^2")
        x, z = link["centre-of-gravity"].strip("() m").split(",")[:: 1 if i else 2]
        link["centre-of-gravity"] = f"({x}, {draft.between(-0.03, 0.03) * reach:.4f}, {z}) m"
    lean = [f"{draft.between(-0.15, 0.15):.3f}" for _ in range(2)]
    half = draft.between(60.0, 200.0)
    draft.put(
        "joint.joint0", type="revolute", axis=f"({lean[0]}, {lean[1]}, 1)", parent="carrier", child="link0",
        at="joint0", limits=[si(-half, "deg"), si(half, "deg")],
    )  # fmt: skip
    radius, travel = draft.between(0.03, 0.08) * reach, 2.1 * np.deg2rad(half)
    # Enough to hold the machine on its leaning base and to move it.
    torque = GRAVITY * (1.3 * mass + rated) * reach * draft.between(0.2, 0.35)
    section = cylinder(draft, 0, 1.0, travel * radius, torque / radius, 0)
    table = draft.tables["cylinder.cylinder0"]
    del table["barrel"], table["closed-length"]
    table["rack-radius"] = f"{radius:.5f} m"
    if draft.chance(0.5):
        table["rod-diameter"] = "0 mm"
        area = section.areas[0]
        return Section(section.name, (area, area), section.travel, section.flow, 0, False)
    return section


def prismatic(draft: Draft, i: int, before: float, length: float, weight: float) -> Section:
    """A telescope, or a lift or a slide at the base; its coordinate is the travel from fully retracted."""
    direction = draft.rng.choice([0.0, 90.0]) if i == 1 else draft.between(-5.0, 5.0) * draft.chance(0.3)
    travel = draft.between(0.35, 0.7) * (length if i == 1 else min(before, length))
    closed = travel * draft.between(1.15, 1.4)
    along, across = (polar(1.0, np.deg2rad(direction + turn)) for turn in (0.0, 90.0))
    aside = draft.between(0.02, 0.1) * length * across
    at = np.array([0.0 if i == 1 else before, 0.0])
    draft.tables[f"link.link{i - 1}.point"][f"barrel{i}"] = point(at + aside - closed * along)
    draft.tables[f"link.link{i}.point"][f"rod{i}"] = point(aside)
    draft.put(
        f"joint.joint{i}", type="prismatic", parent=f"link{i - 1}", child=f"link{i}", at=f"joint{i}",
        direction=si(direction, "deg"),
    )  # fmt: skip
    return cylinder(draft, i, closed, travel, weight, 0, rod=f"link{i}.rod{i}")


def revolute(draft: Draft, i: int, before: float, length: float, torque: float) -> Section:
    """A cylinder across a joint, or through a four-bar; the pins are drawn, the range of the joint follows."""
    at = np.array([0.0 if i == 1 else before, 0.0])
    middle = np.deg2rad(draft.between(15.0, 50.0) if i == 1 else draft.between(-80.0, -5.0))
    linked = i > 1 and draft.chance(0.25)
    pins = (
        four_bar(draft, i, at, middle, min(before, length))
        if linked
        else triangle(draft, i, at, middle, before, length)
    )
    angles = middle + np.linspace(-SPAN, SPAN, POINTS)
    lengths = pins.lengths(angles)
    low, high = stroke_range(lengths)
    lever = np.gradient(lengths, angles)[POINTS // 2]
    closed, opened = sorted(lengths[[low, high]])
    draft.put(
        f"joint.joint{i}", type="revolute", convention="relative", parent=f"link{i - 1}", child=f"link{i}",
        at=f"joint{i}", limits=[si(np.rad2deg(angles[end]), "deg") for end in (low, high)],
    )  # fmt: skip
    force = torque / (0.75 * abs(lever))
    return cylinder(draft, i, closed, opened - closed, force, 0 if lever > 0 else 1, **pins.keys)


@dataclass(frozen=True)
class Pins:
    """Distance of the pins of barrel and rod over the angle of the joint, and what the cylinder's table says of the
    rod."""

    lengths: Any
    keys: dict[str, str]


def triangle(draft: Draft, i: int, at: np.ndarray, middle: float, before: float, length: float) -> Pins:
    """Barrel and rod on the two links of the joint, below it or above."""
    below = draft.chance(0.75 if i == 1 else 0.3)
    on_parent, on_child = draft.between(0.3, 0.6) * before, draft.between(0.2, 0.5) * length
    between = np.deg2rad(draft.between(75.0, 105.0))
    if i == 1:
        angle = np.deg2rad(draft.between(-110.0, -50.0) if below else draft.between(110.0, 160.0))
    else:
        angle = np.deg2rad(draft.between(185.0, 215.0) if below else draft.between(145.0, 175.0))
    of_child = angle - middle + (between if below else -between)
    barrel = at + polar(on_parent, angle)
    draft.tables[f"link.link{i - 1}.point"][f"barrel{i}"] = point(barrel)
    draft.tables[f"link.link{i}.point"][f"rod{i}"] = point(polar(on_child, of_child))

    def lengths(angles: np.ndarray) -> np.ndarray:
        rod = at[:, None] + polar(on_child, of_child + angles)
        return np.hypot(*(rod - barrel[:, None]))

    return Pins(lengths, {"rod": f"link{i}.rod{i}"})


def four_bar(draft: Draft, i: int, at: np.ndarray, middle: float, size: float) -> Pins:
    """A linkage as buckets and jibs have it, drawn in its middle position."""
    draft.parts.add("linkage")
    rod = at + polar(draft.between(0.2, 0.3) * size, np.deg2rad(draft.between(85.0, 110.0)))
    rocker = at + polar(draft.between(0.12, 0.2) * size, np.deg2rad(draft.between(165.0, 185.0)))
    arm, turned = draft.between(0.12, 0.2) * size, np.deg2rad(draft.between(20.0, 50.0))
    coupler = at + polar(arm, turned)
    barrel = at + polar(draft.between(0.7, 0.9) * size, np.deg2rad(draft.between(160.0, 172.0)))
    arms = coupler - rocker, rod - rocker
    left = bool(arms[0][0] * arms[1][1] > arms[0][1] * arms[1][0])
    r, c = (float(np.hypot(*(rod - pivot))) for pivot in (rocker, coupler))
    draft.tables[f"link.link{i - 1}.point"] |= {f"barrel{i}": point(barrel), f"rocker{i}": point(rocker)}
    draft.tables[f"link.link{i}.point"][f"coupler{i}"] = point(polar(arm, turned - middle))
    draft.put(
        f"cylinder.cylinder{i}.linkage", rocker_pivot=f"link{i - 1}.rocker{i}", coupler_pivot=f"link{i}.coupler{i}",
        rocker_length=si(r, "m"), coupler_length=si(c, "m"), side="left" if left else "right",
    )  # fmt: skip

    def lengths(angles: np.ndarray) -> np.ndarray:
        way = at[:, None] + polar(arm, turned - middle + angles) - rocker[:, None]
        far = np.hypot(*way)
        along = (far**2 + r**2 - c**2) / (2 * far)
        with np.errstate(invalid="ignore"):
            aside = np.sqrt(r**2 - along**2) * (1 if left else -1)
        pin = rocker[:, None] + (along * way + aside * np.array([-way[1], way[0]])) / far
        return np.hypot(*(pin - barrel[:, None]))

    return Pins(lengths, {})


def stroke_range(lengths: np.ndarray) -> tuple[int, int]:
    """Indices of the ends of the stroke: the widest range about the middle in which the cylinder fits and has a
    lever."""
    middle = len(lengths) // 2
    slope = np.gradient(lengths)
    with np.errstate(invalid="ignore"):
        good = (slope / slope[middle] > LEAST_LEVER) & (
            np.abs(np.log(lengths / lengths[middle])) < np.log(REACH_OF_CYLINDER)
        )
    bad = np.flatnonzero(~good)
    return int(bad[bad < middle].max(initial=-1)) + 1, int(bad[bad > middle].min(initial=len(lengths))) - 1


def cylinder(draft: Draft, i: int, closed: float, travel: float, force: float, loaded: int, **rod: str) -> Section:
    """Cylinders that hold `force` at `LOADED` times the supply pressure, with their stops and their friction."""
    count = int(draft.later.choice([1, 2, 3], p=[0.75, 0.2, 0.05]))
    force /= count
    ratio = draft.between(0.45, 0.7)
    area = max(force / (LOADED * draft.supply), 3e-4) / (1.0 if loaded == 0 else 1 - ratio**2)
    bore = float(f"{np.sqrt(4 * area / np.pi):.3g}")
    areas = (np.pi / 4 * bore**2, np.pi / 4 * bore**2 * (1 - ratio**2))
    flow = areas[0] * travel / draft.between(3.0, 9.0)
    own = f"cylinder.cylinder{i}"
    volumes = [si(1e3 * area * travel * draft.between(0.02, 0.08), "l") for area in areas]
    leak = flow / draft.supply * draft.log_between(1e-5, 1e-3)
    draft.put(
        own, joint=f"joint{i}", barrel=f"link{i - 1}.barrel{i}", **rod, bore=si(1e3 * bore, "mm"),
        rod_diameter=si(1e3 * ratio * bore, "mm"), stroke=f"{travel:.5f} m", closed_length=f"{closed:.5f} m",
        dead_volume=volumes, internal_leakage=si(leak, "m^3/(s Pa)"),
        external_leakage=si(leak * draft.chance(0.3) * 0.1, "m^3/(s Pa)"),
    )  # fmt: skip
    zone, most = draft.between(0.03, 0.06) * travel, 2 * draft.supply * areas[0]
    stop = {"stiffness": si(most / zone, "N/m"), "damping": si(0.01 * most / zone, "N s/m")}
    draft.put(f"{own}.end-stop", zone=si(1e3 * zone, "mm"), **stop)
    friction(draft, i, draft.supply * areas[0], flow / areas[0], travel * areas[0] * ratio**2)
    if count > 1:
        draft.parts.add("cylinders in parallel")
        draft.put(own, count=count)
    return Section(f"cylinder{i}", (count * areas[0], count * areas[1]), travel, count * flow, loaded, False)


def friction(draft: Draft, i: int, force: float, speed: float, steel: float) -> None:
    """Friction of seals that take some per cent of the largest force; `steel` is the volume of the rod, m^3."""
    model = "lugre" if draft.bristles or draft.chance(0.5) else "static"
    draft.parts.add(f"friction {model}")
    coulomb = [force * draft.log_between(0.003, 0.03) for _ in range(2)]
    breakaway = [draft.between(1.1, 2.2) * value for value in coulomb]
    exponent = draft.rng.choice([1.0, 1.5])
    stribeck = speed * draft.log_between(0.02, 0.2), float(draft.rng.choice([1.0, 2.0]))
    viscous = force * draft.log_between(0.005, 0.05) / speed**exponent
    draft.put(
        f"friction.cylinder{i}", cylinder=f"cylinder{i}", model=model, coulomb=[si(v, "N") for v in coulomb],
        breakaway=[si(v, "N") for v in breakaway], stribeck_velocity=si(stribeck[0], "m/s"),
        stribeck_exponent=stribeck[1], viscous_exponent=float(exponent),
        viscous=si(viscous, "N s/m" if exponent == 1 else "N s^1.5/m^1.5"),
    )  # fmt: skip
    if model == "static":
        draft.put(f"friction.cylinder{i}", smoothing_velocity=si(speed * draft.log_between(3e-3, 3e-2), "m/s"))
        return
    stiffness = min(breakaway) / draft.log_between(5e-5, 2e-3)
    # Critical damping of the rod on its bristles; the velocity keeps damping below friction at every speed.
    damping = 2 * np.sqrt(stiffness * 7850.0 * steel)
    draft.put(
        f"friction.cylinder{i}", bristle_stiffness=si(stiffness, "N/m"), bristle_damping=si(damping, "N s/m"),
        bristle_damping_velocity=si(min(0.1, 3 * min(coulomb) / damping), "m/s"),
    )  # fmt: skip


def circuit(draft: Draft, sections: list[Section]) -> str:
    """Supply, pump and what stands on their lines; returns the compensators that sections may have, or "none"."""
    draft.put(
        "supply", pressure=bar(draft.supply), tank_pressure=bar(1e5 * draft.between(0.0, 3.0) * draft.chance(0.5))
    )
    draft.put("equilibrium", back_pressure=bar(1e5 * draft.between(5.0, 20.0)))
    kind = draft.one_of("none", "fixed", "pressure-compensated", "load-sensing", "load-sensing", "fixed-ls")
    draft.parts.add(f"pump {kind}")
    if kind == "none":
        return draft.one_of("none", "before-spool")
    flows = sorted((section.flow for section in sections), reverse=True)
    # At least what the smallest pumps give.
    given = max(sum(flows[:2]) * draft.between(0.6, 1.3), 3.5e-5)
    pump(draft, kind, given, draft.between(18.0, 30.0) * 1e5)
    volume = given * draft.log_between(0.3, 2.0)
    draft.put(
        "mains",
        volume=si(1e3 * max(volume, 6e-5), "l"),
        relief_gradient=si(6e4 * given / draft.between(2.0, 10.0), "l/(min bar)"),
    )
    if draft.chance(0.5):
        draft.put("mains", hose_compliance=si(1e6 * volume * 1e-4 * draft.between(0.3, 1.5), "ml/bar"))
    if kind == "pressure-compensated" and draft.chance(0.4):
        draft.part(
            "accumulator.gas",
            volume=si(1e3 * given * draft.between(1.0, 10.0), "l"),
            precharge=bar(draft.supply * draft.between(0.4, 0.8)),
        )
    if draft.chance(0.3):
        draft.part(
            "tank-line", volume=si(1e3 * max(volume, 6e-5), "l"), nominal_flow=lpm(given),
            nominal_pressure_drop=bar(1e5 * draft.between(0.5, 3.0)),
        )  # fmt: skip
    senses = kind in ("load-sensing", "fixed-ls")
    return draft.one_of("none", "before-spool", "behind-spool") if senses else draft.one_of("none", "before-spool")


def pump(draft: Draft, kind: str, given: float, margin: float) -> None:
    speed, volumetric = draft.between(1200.0, 2200.0), draft.between(0.88, 0.97)
    torque = given * draft.supply / (2 * np.pi * speed / 60)
    own = "pump.main"
    draft.put(
        own, type=kind.removesuffix("-ls"), displacement=si(1e6 * given / (speed / 60 * volumetric), "ml"),
        speed=si(speed, "rpm"), volumetric_efficiency=si(volumetric),
        hydromechanical_efficiency=si(draft.between(0.85, 0.95)),
    )  # fmt: skip
    if kind.startswith("fixed"):
        if kind == "fixed-ls":
            draft.put(own, ls_margin=bar(margin))
        return
    draft.put(own, control_range=bar(1e5 * draft.between(3.0, 8.0)), time_constant=si(draft.between(30.0, 150.0), "ms"))
    if kind == "load-sensing":
        draft.put(own, ls_margin=bar(margin), ls_time_constant=si(draft.between(5.0, 60.0), "ms"))
    if draft.chance(0.4) and torque > 10.0:
        draft.parts.add("torque-limit")
        draft.put(own, torque_limit=si(torque * draft.between(0.5, 1.0), "N m"))
    if draft.chance(0.3):
        draft.put(own, droop=si(draft.between(0.02, 0.1)), rated_torque=si(1.2 * torque, "N m"))


def valve(draft: Draft, section: Section, compensated: str) -> None:
    """The spool valve of a section, with the optional parts that its compensator leaves."""
    own = f"valve.{section.name}"
    regenerative = compensated == "none" and section.loaded == 0 and draft.chance(0.15)
    frequency, stroke = draft.log_between(5.0, 80.0), draft.between(2.0, 12.0)
    drop = draft.log_between(5.0, 35.0)
    draft.put(
        own, cylinder=section.name, type="regenerative" if regenerative else "4/3", stroke=si(stroke, "mm"),
        nominal_flow=lpm(section.flow), transition_pressure=bar(1e5 * draft.log_between(0.5, 3.0)),
        natural_frequency=si(frequency, "Hz"), damping_ratio=si(draft.between(0.5, 1.0)),
    )  # fmt: skip
    if compensated == "before-spool":
        setting = draft.between(5.0, 10.0)
        draft.put(own, compensator=compensated, compensator_setting=si(setting, "bar"))
    else:
        draft.put(own, nominal_edge_pressure_drop=si(drop, "bar"))
    if compensated == "behind-spool":
        draft.put(own, compensator=compensated)
    draft.parts.add("regenerative" if regenerative else f"compensator {compensated}")
    if compensated != "none" and draft.chance(0.2):
        draft.put(own, compensator_time_constant=si(draft.log_between(3.0, 50.0), "ms"))
    if draft.chance(0.6):
        draft.put(own, overlap=si(stroke * draft.between(0.01, 0.12), "mm"))
    if draft.chance(0.3):
        draft.put(own, leakage=si(section.flow / draft.supply * draft.log_between(1e-5, 1e-3), "m^3/(s Pa)"))
    if draft.chance(0.3):
        draft.put(own, velocity_limit=si(1e-3 * stroke / draft.between(0.03, 0.2), "m/s"))
    if draft.chance(0.3):
        draft.put(own, delay=si(draft.between(2.0, 30.0), "ms"))
    if regenerative:
        return
    if draft.chance(0.2):
        metering(draft, own)
    elif draft.chance(0.6):
        # The chamber that carries the load leaves through a narrow edge.
        narrow = [draft.between(0.3, 0.6) if side == section.loaded else draft.between(0.7, 1.2) for side in (0, 1)]
        draft.put(own, return_area_ratio=[si(ratio) for ratio in narrow])
    if compensated == "none" and draft.chance(0.3):
        draft.put(own, load_check="yes")
        draft.parts.add("load-check")


def metering(draft: Draft, own: str) -> None:
    """Edges that open slowly at first."""
    draft.parts.add("metering")
    draft.tables[own].pop("overlap", None)
    travel = [0.0, 0.1, 0.3, 0.6, 1.0]
    for edge in ("supply-to-a", "a-to-tank", "supply-to-b", "b-to-tank"):
        power = draft.between(1.0, 2.0)
        draft.put(f"{own}.metering.{edge}", travel=travel, area=[si(share**power) for share in travel])


def beside(draft: Draft, section: Section) -> None:
    """Valves and lines between the spool valve and the cylinder."""
    name, (carrying, other) = section.name, section.sides
    on = {"cylinder": name}
    regenerative = draft.tables[f"valve.{name}"]["type"] == "regenerative"
    held = draft.one_of("counterbalance", "pilot-check", "hose-burst", *["none"] * 4)
    if held != "none" and not (regenerative and carrying == "rod-side"):
        holding(draft, held, section, carrying)
    for side in section.sides:
        short = f"{name}-{side.split('-')[0]}"
        if draft.chance(0.25):
            # Some stand below what the load needs.
            setting = draft.supply * (draft.between(0.3, 1.0) if draft.chance(0.2) else draft.between(1.05, 1.4))
            draft.part(
                f"port-relief.{short}",
                **on,
                side=side,
                setting=bar(setting),
                nominal_flow=lpm(1.5 * section.flow),
            )
        if draft.chance(0.25):
            draft.part(
                f"anti-cavitation.{short}", **on, side=side, nominal_flow=lpm(1.5 * section.flow),
                nominal_pressure_drop=bar(1e5 * draft.between(1.0, 5.0)),
            )  # fmt: skip
        if draft.chance(0.2):
            line(draft, short, section, side, side == carrying and held != "none")
    if draft.chance(0.1):
        draft.part(
            f"crossover-relief.{name}",
            **on,
            side=carrying,
            setting=bar(draft.supply * draft.between(1.1, 1.5)),
            nominal_flow=lpm(section.flow),
        )
    opening = 1e6 * section.flow * draft.log_between(1e-2, 0.1) / np.sqrt(2 * draft.supply / 870.0)
    if draft.chance(0.1) and opening > 0.1:
        draft.part(f"hose-leak.{name}", **on, side=other, opening=si(opening, "mm^2"))


def holding(draft: Draft, kind: str, section: Section, side: str) -> None:
    on: dict[str, Any] = {
        "cylinder": section.name,
        "side": side,
        "nominal_flow": lpm(section.flow * draft.between(1.2, 2.0)),
    }
    on["nominal_pressure_drop"] = bar(1e5 * draft.between(4.0, 12.0))
    match kind:
        case "counterbalance":
            on |= {"setting": bar(1.3 * LOADED * draft.supply), "pilot_ratio": si(draft.between(2.0, 8.0))}
        case "pilot-check":
            on |= {"pilot_ratio": si(draft.between(3.0, 8.0))}
        case "hose-burst":
            on |= {"closing_flow": lpm(section.flow * draft.between(1.6, 2.5)), "bleed": si(draft.between(0.01, 0.05))}
    draft.part(f"{kind}.{section.name}", **on)


def line(draft: Draft, short: str, section: Section, side: str, held: bool) -> None:
    """A hose; where a valve holds the load of its side, it has a resistance alone."""
    own: dict[str, Any] = {"cylinder": section.name, "side": side}
    if held or draft.chance(0.5):
        own |= {"nominal_flow": lpm(section.flow), "nominal_pressure_drop": bar(1e5 * draft.between(1.0, 8.0))}
    if not held:
        # Oil at 4 m/s.
        bore = np.sqrt(4 / np.pi * section.flow / 4.0)
        length = draft.between(1.0, 6.0)
        own |= {"length": si(length, "m"), "inner_diameter": si(max(1e3 * bore, 4.0), "mm")}
        own |= {"compliance": si(1e6 * np.pi / 4 * bore**2 * length * 1e-4, "ml/bar")} if draft.chance(0.5) else {}
    draft.part(f"line.{short}", **own)


def fluid(draft: Draft) -> None:
    draft.put(
        "fluid", density=si(draft.between(840.0, 900.0), "kg/m^3"), viscosity=si(draft.log_between(0.01, 0.1), "Pa s")
    )
    draft.put("fluid", cavitation="free-gas", vacuum="-1 bar")
    if draft.chance(0.6):
        draft.put("fluid", bulk_modulus=si(draft.between(0.9, 1.7), "GPa"))
    else:
        draft.put(
            "fluid",
            bulk_modulus_max=si(draft.between(1.0, 1.8), "GPa"),
            bulk_c1=90,
            bulk_c2=3,
            bulk_reference_pressure="200 bar",
        )
