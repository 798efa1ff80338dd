"""The virtual friction rig: one hanging cylinder, its experiments, and their logs (thesis 5.2).

::

    from hydrocrane import rig
    log = rig.run("constant-velocity", payload=20, seed=3)
    log.data, log.truth, log.save("log.csv")
"""

from hydrocrane.rig.experiments import experiments
from hydrocrane.rig.friction import TABLE_3, BristleDamping, bristle_damping, loaded_friction
from hydrocrane.rig.log import RigLog, Segment
from hydrocrane.rig.running import run, scenario, series
from hydrocrane.rig.steady import SteadyMotion, steady_motion

__all__ = [
    "TABLE_3",
    "BristleDamping",
    "RigLog",
    "Segment",
    "SteadyMotion",
    "bristle_damping",
    "experiments",
    "loaded_friction",
    "run",
    "scenario",
    "series",
    "steady_motion",
]
