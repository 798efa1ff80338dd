"""Pictures of the laws of a machine: flows of its valves, friction of its cylinders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import MachineLike, as_machine
from hydrocrane.machine.overrides import Override
from hydrocrane.plots.style import COLOURS, FIELD, MUTED, figure, styled, title

if TYPE_CHECKING:
    from hydrocrane.machine.machine import Machine

OPENINGS = (0.25, 0.5, 0.75, 1.0)


@styled
def flow_law(machine: MachineLike, cylinder: str | None = None) -> Figure:
    """Flow over pressure drop at several openings: near zero with laminar flow, and over the whole range."""
    machine = as_machine(machine)
    name = machine.cylinder_names[0] if cylinder is None else cylinder
    check_known("cylinder", name, machine.cylinder_names)
    fig, (near, whole) = figure(10.0, 4.3, ncols=2)
    _opened(near, machine, name, np.linspace(-10e5, 10e5, 801))
    _opened(whole, machine, name, np.linspace(-1, 1, 801) * machine.supply_pressure)
    near.set_title("small pressure drop: laminar to turbulent")
    whole.set_title("up to supply pressure")
    near.legend(title="spool opening", loc="upper left")
    title(fig, "Flow through a metering edge", f"valve of cylinder {name}, {machine.name}")
    return fig


def _opened(axes: Axes, machine: Machine, cylinder: str, dp: np.ndarray) -> None:
    import matplotlib as mpl

    full = machine.spool_strokes[machine.cylinder_names.index(cylinder)]
    shades = mpl.colormaps[FIELD](np.linspace(0.8, 0.1, len(OPENINGS)))
    for opening, shade in zip(OPENINGS, shades, strict=True):
        flow = machine.orifice_flow(opening * full, dp, cylinder)
        axes.plot(dp * 1e-5, flow * 6e4, color=shade, label=f"{opening:.0%}")
    axes.axhline(0.0, color=MUTED, lw=0.7, zorder=1)
    axes.axvline(0.0, color=MUTED, lw=0.7, zorder=1)
    axes.set_xlabel("pressure drop [bar]")
    axes.set_ylabel("flow [l/min]")
    axes.margins(x=0)


# Speed far above any Stribeck velocity, where only Coulomb and viscous friction remain, m/s.
_FAST = 10.0


@styled
def friction_maps(machine: MachineLike, cylinder: str | None = None) -> Figure:
    """Six charts of one cylinder's seal friction.

    Coulomb; with viscous friction; with stiction, which acts at rest only (dots); with the Stribeck effect; and the
    influence of the Stribeck velocity and of its exponent. Each one is the machine's own law with single keys
    overridden.
    """
    machine = as_machine(machine)
    name = machine.cylinder_names[0] if cylinder is None else cylinder
    check_known("cylinder", name, machine.cylinder_names)
    laws = _Laws(machine, name)
    fig, axes = figure(12.0, 7.2, nrows=2, ncols=3)
    v = _velocities(laws.stribeck_velocity)
    steps = [
        ("Coulomb", laws.without_stribeck(viscous=False)),
        ("Coulomb and viscous", laws.without_stribeck(viscous=True)),
        ("with stiction", laws.without_stribeck(viscous=True)),
        ("with the Stribeck effect", machine),
    ]
    for panel, (heading, variant) in zip(axes.flat, steps, strict=False):
        _curve(panel, variant, name, v, COLOURS[0])
        panel.set_title(heading)
    axes[0, 2].plot([0.0, 0.0], [laws.breakaway[0], -laws.breakaway[1]], "o", color=COLOURS[4], ms=5)
    _varied(axes[1, 1], name, v, "Stribeck velocity", {f"x {k:g}": laws.with_stribeck_velocity(k) for k in (0.5, 1, 2)})
    _varied(axes[1, 2], name, v, "Stribeck exponent", {f"{e:g}": laws.with_exponent(e) for e in (0.5, 1, 2, 4)})
    top = max(abs(y) for panel in axes.flat for y in panel.get_ylim())
    for panel in axes.flat:
        panel.set_ylim(-top, top)
    title(fig, "Friction of the piston at steady velocity", f"cylinder {name}, {machine.name}")
    return fig


def _velocities(scale: float) -> np.ndarray:
    """Velocities with a higher density near zero, where the map is steep, m/s."""
    s = np.linspace(-1, 1, 2001)
    return 12 * scale * np.sign(s) * np.abs(s) ** 3


def _curve(axes: Axes, machine: Machine, cylinder: str, v: np.ndarray, colour: str, label: str = "") -> None:
    axes.plot(v * 1e3, machine.friction_map(v, cylinder), color=colour, label=label)
    axes.axhline(0.0, color=MUTED, lw=0.7, zorder=1)
    axes.axvline(0.0, color=MUTED, lw=0.7, zorder=1)
    axes.set_xlabel("piston velocity [mm/s]")
    axes.set_ylabel("friction [N]")
    axes.margins(x=0)


def _varied(axes: Axes, cylinder: str, v: np.ndarray, heading: str, machines: dict[str, Machine]) -> None:
    for (label, machine), colour in zip(machines.items(), COLOURS, strict=False):
        _curve(axes, machine, cylinder, v, colour, label)
    axes.set_title(f"influence of the {heading}")
    axes.legend(loc="upper left")


class _Laws:
    """Variants of a machine that differ in the friction of one cylinder.

    The scales of a variant follow from the machine's own map: without viscous friction its value at high speed is the
    Coulomb force, and the Stribeck velocity is where the Stribeck rise has decreased to 1/e.
    """

    def __init__(self, machine: Machine, cylinder: str) -> None:
        self.machine = machine
        self.key = f"friction.{cylinder}"
        self.cylinder = cylinder
        if not any(key.startswith(self.key + ".") for key, _, _ in machine.provenance):
            raise InputError(f"{machine.name} has no friction table named `{cylinder}` after its cylinder to vary")
        dry = self._variant(viscous=[0.0, 0.0])
        self.coulomb = [float(abs(dry.friction_map(sign * _FAST, cylinder))) for sign in (1.0, -1.0)]
        scales = [self._stribeck(dry, side) for side in (0, 1)]
        self.breakaway, self.velocities = zip(*scales, strict=True)
        self.stribeck_velocity = max(self.velocities)

    def without_stribeck(self, *, viscous: bool) -> Machine:
        changes: dict[str, Override] = {"breakaway": self.coulomb}
        return self._variant(**changes) if viscous else self._variant(**changes, viscous=[0.0, 0.0])

    def with_stribeck_velocity(self, factor: float) -> Machine:
        return self._variant(**{"stribeck-velocity": [factor * v for v in self.velocities]})

    def with_exponent(self, exponent: float) -> Machine:
        return self._variant(**{"stribeck-exponent": [exponent, exponent]})

    def _stribeck(self, dry: Machine, side: int) -> tuple[float, float]:
        """Peak force and Stribeck velocity in one direction."""
        v = np.geomspace(1e-5, 1.0, 4000)
        force = np.abs(dry.friction_map(v if side == 0 else -v, self.cylinder))
        peak = int(np.argmax(force))
        level = self.coulomb[side] + (force[peak] - self.coulomb[side]) / np.e
        below = np.flatnonzero(force[peak:] <= level)
        return float(force[peak]), float(v[peak + below[0]]) if below.size else 0.01

    def _variant(self, **changes: Override) -> Machine:
        return self.machine.changed({f"{self.key}.{name}": value for name, value in changes.items()})
