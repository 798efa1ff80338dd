"""The dynamic fit of both cylinders, for the scripts of Tables 4 and 5."""

from __future__ import annotations

from functools import cache

from laboratory import calibrated, experiment

from hydrocrane.identification.bristles.fit import DynamicFit, fit_dynamic

# Time between samples of the slow ramp and of the step, s: fine enough for the bristles, few enough to be quick.
INTERVALS = {"Rottne": (1e-2, 2e-3), "Kalmar": (5e-3, 2e-3)}
STEP = {"shares": (0.3, 0.5), "seconds": 0.1}


@cache
def fit(cylinder: str) -> DynamicFit:
    """sigma_0 and sigma_1 by output error from an extending ramp and steps; static map and valve have priors."""
    slow, fine = INTERVALS[cylinder]
    ramp = experiment("ramp", cylinder, interval=slow)
    end = ramp.segments[0].end - slow
    steps = experiment("step", cylinder, interval=fine, **STEP)
    first = calibrated(ramp)
    return fit_dynamic([first.between(first.time[0], end)], [calibrated(steps)], ramp.run.machine, calibrated=True)
