"""Checks before a fit whether a log can come from the machine."""

from __future__ import annotations

import numpy as np

from hydrocrane.logs import Log
from hydrocrane.machine.machine import Machine

# Number of poses of a log that are checked.
POSES = 50
# Largest load in excess of that of the file, kg.
MORE = 300.0
# Difference of forces that counts as clear, as a share of the force at supply pressure.
CLEAR = 0.1


def swapped_pressures(machine: Machine, log: Log) -> list[str]:
    """Cylinders whose pressures carry the crane only if p1 and p2 are exchanged.

    The required static force is that along the log's poses for any load from zero to :data:`MORE` above that of the
    file.
    """
    names = [f"joint.{j}.q" for j in machine.joint_names]
    if not all(name in log for name in names):
        return []
    rows = np.unique(np.linspace(0, log.time.size - 1, POSES).astype(int))
    q = np.stack([log[name][rows] for name in names], axis=1)
    good = np.isfinite(q).all(axis=1)
    loads = (0.0, machine.payload_mass + MORE)
    empty, loaded = (machine.static_cylinder_force(q[good], payload=load) for load in loads)
    low, high = np.minimum(empty, loaded), np.maximum(empty, loaded)
    found = []
    for c, name in enumerate(machine.cylinder_names):
        signals = [f"cylinder.{name}.p{side}" for side in (1, 2)]
        if not all(signal in log for signal in signals):
            continue
        p1, p2 = (log[signal][rows][good] for signal in signals)
        piston, rod = machine.piston_areas[c]
        outside = [
            float(np.nanmedian(np.maximum(np.maximum(low[:, c] - force, force - high[:, c]), 0.0)))
            for force in (piston * p1 - rod * p2, piston * p2 - rod * p1)
        ]
        if outside[0] > CLEAR * piston * machine.supply_pressure and outside[1] < 0.2 * outside[0]:
            found.append(
                f"{log.source}: the pressures of `{name}` do not carry the crane by {outside[0]:.3g} N, but would if "
                f"`{signals[0]}` and `{signals[1]}` were exchanged: are the columns swapped?"
            )
    return found
