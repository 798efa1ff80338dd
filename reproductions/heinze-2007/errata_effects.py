"""What errata of the text alone do to results of this reproduction, in hydrocrane: E51 to E53 and E55 of ERRATA.md."""

from __future__ import annotations

import numpy as np
from common import RUN_REPEATABILITY, printed_program
from errata_switches import heights
from fig57_71_ramp import phases, response
from fig80_85_published_run import run
from laboratory import RIGS, experiment, windows
from static_maps import ZERO, truth

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.identification import OffsetPrior, identify_static

VALVES = ("regenerative", "4/3")
# The telescope at full spool, long enough for a steady speed; the printed laws take fixed steps.
START, LASTING, SAMPLE = (np.deg2rad(100.0), np.deg2rad(90.0), -0.2), 3.0, 0.01
SOLVERS = {"heinze-2007": {"method": "tsit5", "step": 2e-5}, "rottne-f9-lab": {}}
# Ramps of Table 4, without a unit there; read as force rates in N/s.
PRINTED_RAMPS = {"Rottne": 0.01, "Kalmar": 0.0001}
VISCOUS = "viscous"


def telescope_speed(machine: str, valve: str) -> float:
    """Speed of the extending telescope at full spool, m/s."""
    crane = hc.load_machine(machine, overrides={"valve.extension.type": valve})
    simulator = hc.Simulator(crane, sample_time=SAMPLE, **SOLVERS[machine])
    simulator.reset(q=np.array(START))
    command = np.array([0.0, 0.0, printed_program.SPOOL_STROKE])
    for _ in range(round(LASTING / SAMPLE)):
        observed = simulator.step(command)
    return float(observed.qd[2])


def e51_regenerative_valve() -> dict[str, float]:
    """Speeds with either valve, and the published heights with a plain one."""
    out = {f"{machine}.{valve}_m_s": telescope_speed(machine, valve) for machine in SOLVERS for valve in VALVES}
    plain = heights({"valve.extension.type": "4/3"})
    return out | {f"4/3.{key}": value for key, value in plain.items()}


def e52_viscous_exponent() -> dict[str, float]:
    """Table 3 without load in the round trip of its page, the viscous friction of both cylinders read either way."""
    out = {}
    for cylinder, name in RIGS.items():
        row = truth(cylinder, 0).pairs
        for exponent in (1.0, 1.5):
            overrides = {**rig.loaded_friction(name, 0), "friction.test.viscous-exponent": exponent}
            log = experiment("constant-velocity", cylinder, payload=0, overrides=overrides)
            found = identify_static(
                windows(log),
                exponents={"viscous-exponent": exponent},
                bias=OffsetPrior.of_pressures(areas=tuple(log.run.machine.piston_areas[0]), deviations=(ZERO, ZERO)),
            )
            off = [abs(a / b - 1) for a, b in zip(found.fit.params[VISCOUS], row[VISCOUS], strict=True)]
            out[f"{cylinder}.{exponent:g}.alpha_2_off"] = max(off)
            out[f"{cylinder}.{exponent:g}.at_100mm_s_n"] = float(log.run.machine.friction_map(np.array([0.1]))[0])
    return out


def e53_ramps() -> dict[str, float]:
    """sigma_0 by (126) with U = c t and the printed c, over the rig's slow ramp to break-away, N/m."""
    out = {}
    for cylinder, rate in PRINTED_RAMPS.items():
        found = response(cylinder, True)
        until = slice(phases(found)[1])
        time, z, force = (found[key][until] for key in ("time", "z", "friction"))
        out[f"{cylinder}.printed_c_n_m"] = float(z @ (rate * time) / (z @ z))
        out[f"{cylinder}.measured_force_n_m"] = float(z @ force / (z @ z))
        out[f"{cylinder}.force_rate_n_s"] = float(np.polyfit(time, force, 1)[0])
    return out


def e55_load_cell() -> dict[str, float]:
    """Largest force of cylinder 3 in the published runs, N."""
    full, ring = printed_program.CYLINDERS[2].areas
    return {
        f"{task}_largest_force_n": float(np.abs(full * states[:, 14] - ring * states[:, 15]).max())
        for task in ("vertical", "horizontal")
        for states in [run(task)[1]]
    }


CHECKS = (e51_regenerative_valve, e52_viscous_exponent, e53_ramps, e55_load_cell)


def repeatability(key: str) -> float:
    """Heights and forces of runs that amplify rounding; speeds of a piston with printed friction; fits."""
    if "largest_force" in key:
        return 500.0
    return RUN_REPEATABILITY if "z_at" in key else 1e-4 if key.endswith("m_s") else 1e-6


def compute() -> dict[str, float]:
    """All numbers, keyed `<check>.<name>`."""
    return {f"{check.__name__}.{key}": float(value) for check in CHECKS for key, value in check().items()}
