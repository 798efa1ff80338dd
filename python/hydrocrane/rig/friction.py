"""Friction of the two cylinders in Tables 3-5 of the thesis, as far as the machine files do not have it, and the choice
of the bristle damping of a LuGre seal without a usable measurement (E19)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from hydrocrane.arrays import positive_number
from hydrocrane.errors import InputError, check_known

Pair = tuple[float, float]


@dataclass(frozen=True)
class StaticRow:
    """One row of Table 3; pairs are (extending, retracting).

    Attributes
    ----------
    alpha_0, alpha_1 : tuple of float
        Coulomb force and Stribeck rise, N.
    alpha_2 : tuple of float
        Viscous coefficient, N (s/m)^delta_v.
    v_sigma : tuple of float
        Stribeck velocity, m/s.
    """

    alpha_0: Pair
    alpha_1: Pair
    alpha_2: Pair
    v_sigma: Pair


# By rig and load, kg.
TABLE_3: dict[tuple[str, int], StaticRow] = {
    ("rig-rottne", 0): StaticRow((160, 280), (180, 120), (8000, 12000), (0.002, 0.002)),
    ("rig-rottne", 115): StaticRow((170, 350), (450, 450), (10500, 12000), (0.004, 0.002)),
    ("rig-kalmar", 0): StaticRow((105, 80), (350, 300), (1250, 1800), (0.01, 0.015)),
    ("rig-kalmar", 115): StaticRow((140, 100), (310, 350), (1200, 1800), (0.015, 0.02)),
}


def loaded_friction(rig: str = "rig-rottne", load: int = 115) -> dict[str, list[float]]:
    """Overrides that give `rig` the friction of Table 3 with `load` kg (0 or 115), for the cylinder `test`."""
    rigs = sorted({name for name, _ in TABLE_3})
    check_known("rig", rig, rigs)
    if (rig, load) not in TABLE_3:
        raise InputError(f"Table 3 has loads of 0 and 115 kg, not {load!r}")
    row = TABLE_3[rig, load]
    return {
        "friction.test.coulomb": list(row.alpha_0),
        "friction.test.breakaway": [c + s for c, s in zip(row.alpha_0, row.alpha_1, strict=True)],
        "friction.test.viscous": list(row.alpha_2),
        "friction.test.stribeck-velocity": list(row.v_sigma),
    }


# Largest velocity at which the friction of the rig was measured, m/s (thesis 5.2.2).
FASTEST = 0.1


class BristleDamping(NamedTuple):
    """``bristle-damping``, sigma_1 at rest, N s/m; ``bristle-damping-velocity`` over which it fades, m/s, or None."""

    damping: float
    velocity: float | None


def most_damping(coulomb: float, velocity: float | None = None, *, fastest: float = FASTEST) -> float:
    """Largest sigma_1 at rest, N s/m, for which friction never returns energy.

    This holds if sigma_1(v) abs(v) <= 4 g(v), and g(v) is at least the Coulomb force F_C. Damping that fades as
    exp(-(v/v_d)^2) has its largest sigma_1(v) abs(v), sigma_1 v_d / sqrt(2 e), at v = v_d / sqrt(2).

    Parameters
    ----------
    coulomb : float
        The smaller of the Coulomb forces of both directions, N.
    velocity : float, optional
        v_d, m/s; None if the damping is constant.
    fastest : float
        Speed up to which a constant damping satisfies the bound, m/s.
    """
    return 4.0 * coulomb / fastest if velocity is None else 4.0 * coulomb * math.sqrt(2.0 * math.e) / velocity


def bristle_damping(
    stiffness: float,
    mass: float,
    coulomb: float,
    *,
    damping_ratio: float = 1.0,
    margin: float = 2.0,
    fastest: float = FASTEST,
    fading: bool = True,
) -> BristleDamping:
    """Bristle damping from a damping ratio at rest and a margin of passivity in motion.

    At rest the mass oscillates on the bristles, m x'' + sigma_1 x' + sigma_0 x = 0 (127): sigma_1 = 2 zeta sqrt(sigma_0
    m). In motion friction satisfies the bound of ``most_damping`` with `margin`: v_d is small enough for it, and not
    larger than `fastest`, because there are no measurements above this speed. Without fading sigma_1 itself is limited
    so that the bound holds up to `fastest`.

    Parameters
    ----------
    stiffness : float
        sigma_0, N/m.
    mass : float
        Moving mass on the unloaded rig, kg.
    coulomb : float
        The smaller of the Coulomb forces of both directions, N.
    damping_ratio, margin, fastest : float
        zeta; factor of safety against the bound; m/s.
    fading : bool
        Whether the damping fades with speed or is constant.
    """
    given = {"stiffness": stiffness, "mass": mass, "coulomb": coulomb, "damping_ratio": damping_ratio}
    for name, value in {**given, "margin": margin, "fastest": fastest}.items():
        positive_number(name, value)
    damping = 2 * damping_ratio * math.sqrt(stiffness * mass)
    if not fading:
        return BristleDamping(min(damping, most_damping(coulomb, fastest=fastest) / margin), None)
    # The bound is proportional to 1/v_d.
    return BristleDamping(damping, min(fastest, most_damping(coulomb, 1.0) / (margin * damping)))
