"""First readings of both bristle parameters from every motion of every log, as the thesis takes them (5.2.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrocrane.errors import InputError
from hydrocrane.identification import bristle
from hydrocrane.identification.motions import motions
from hydrocrane.identification.rig_unknowns import DYNAMIC, key_of, number, rig_map
from hydrocrane.identification.static_map import StaticMap
from hydrocrane.logs import Log
from hydrocrane.machine.machine import Machine

Readings = dict[str, dict[str, bristle.Reading]]


def first_readings(
    ramps: Sequence[Log],
    steps: Sequence[Log],
    rig: Machine,
    law: StaticMap | None = None,
    *,
    payload: float | None = None,
) -> tuple[Readings, list[str]]:
    """Stiffness from the ramps, then damping from the steps.

    Parameters
    ----------
    ramps, steps : sequences of Log
        As for :func:`fit_dynamic`.
    rig : Machine
    law : StaticMap, optional
        Default is the rig's.
    payload : float, optional
        kg.

    Returns
    -------
    readings : dict
        ``bristle-stiffness`` and ``bristle-damping``, each by the name of a motion.
    warnings : list of str
        What could not be read, and why.
    """
    law = rig_map(rig) if law is None else law
    found: Readings = {name: {} for name in DYNAMIC}
    warnings = []
    for motion in (m for log in ramps for m in motions(log, rig, payload)):
        try:
            found["bristle-stiffness"][motion.name] = bristle.stiffness(motion, law)
        except InputError as error:
            warnings.append(f"{motion.name}: no reading of the stiffness: {error}")
    known = [r.value for r in found["bristle-stiffness"].values()]
    stiffness = float(np.mean(known)) if known else number(rig, key_of(rig, "friction", "bristle-stiffness"))
    for motion in (m for log in steps for m in motions(log, rig, payload)):
        try:
            found["bristle-damping"][motion.name] = bristle.damping(motion, law, stiffness)
        except InputError as error:
            warnings.append(f"{motion.name}: no reading of the damping: {error}")
    return found, warnings
