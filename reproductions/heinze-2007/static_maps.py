"""The static chain for the scripts of Figures 65 to 69 and Table 3: logs of constant velocities to parameters."""

from __future__ import annotations

from functools import cache

from laboratory import NOISE_ONLY, RIGS, VISCOUS_EXPONENT, experiment, windows

from hydrocrane import rig
from hydrocrane.identification import OffsetPrior, StaticIdentification, StaticMap, identify_static

LOADS = (0, 115)
# Standard deviation of a pressure transmitter's zero after its calibration, Pa.
ZERO = 2e3


@cache
def log_of(cylinder: str, load: int, ideal: bool = False) -> rig.RigLog:
    """Ten constant velocities both ways; the friction is the row of Table 3 with this load.

    `ideal` sensors have noise and converters but neither zero, span nor linearity errors.
    """
    overrides = {**rig.loaded_friction(RIGS[cylinder], load), **(NOISE_ONLY if ideal else {})}
    return experiment("constant-velocity", cylinder, payload=load, overrides=overrides)


@cache
def identified(cylinder: str, load: int, ideal: bool = False) -> StaticIdentification:
    """The chain: zero calibration, windows of steady motion, reading by ruler and fit."""
    log = log_of(cylinder, load, ideal)
    areas = tuple(log.run.machine.piston_areas[0])
    return identify_static(
        windows(log),
        exponents={"viscous-exponent": VISCOUS_EXPONENT[RIGS[cylinder]]},
        bias=OffsetPrior.of_pressures(areas=areas, deviations=(ZERO, ZERO)),
    )


def truth(cylinder: str, load: int) -> StaticMap:
    """The row of Table 3 as a map."""
    pairs = {key.split(".")[-1]: value for key, value in rig.loaded_friction(RIGS[cylinder], load).items()}
    return StaticMap.of({**pairs, "viscous-exponent": VISCOUS_EXPONENT[RIGS[cylinder]]})
