"""Friction of the two cylinders in Tables 3-5 of the thesis, as far as the machine files do not have it."""

from __future__ import annotations

from dataclasses import dataclass

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
