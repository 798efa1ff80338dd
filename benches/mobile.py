"""How fast a crane of four sections on a load-sensing pump runs, each with a compensator and a counterbalance valve.

python -m benches.mobile            # times real time at rtol 1e-4, and the error of the tip
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import hydrocrane as hc
from benches.models.chain import write_chain
from benches.problem import MAX_STEP, clocked
from hydrocrane import _core
from hydrocrane.scenario.scenario import scenario_entry

JOINTS = 4
RTOL, REFERENCE = 1e-4, 1e-9
RUNS = 15
METHODS = ("auto", "hc-exponential-4", "rodas5p")

PUMP = {
    "supply.pressure": "180 bar",
    "pump.main.type": "load-sensing",
    "pump.main.displacement": "45 ml",
    "pump.main.speed": "1500 rpm",
    "pump.main.volumetric-efficiency": 0.94,
    "pump.main.hydromechanical-efficiency": 0.9,
    "pump.main.ls-margin": "20 bar",
    "mains.volume": "1 l",
    "mains.hose-compliance": "0.1 ml/bar",
}


def section(i: int) -> dict[str, object]:
    """The keys of section `i`: 20 l/min at 8 bar over the edge, the load held at the piston side."""
    return {
        f"valve.valve{i}.nominal-flow": "20 l/min",
        f"valve.valve{i}.nominal-pressure-drop": "16 bar",
        f"valve.valve{i}.natural-frequency": "15 Hz",
        f"valve.valve{i}.damping-ratio": 0.8,
        f"valve.valve{i}.compensator": "before-spool",
        f"valve.valve{i}.compensator-setting": "8 bar",
        f"valve.valve{i}.return-area-ratio": [0.4, 1.0],
        f"counterbalance.c{i}.cylinder": f"cylinder{i}",
        f"counterbalance.c{i}.side": "piston-side",
        f"counterbalance.c{i}.setting": "200 bar",
        f"counterbalance.c{i}.pilot-ratio": 3,
        f"counterbalance.c{i}.nominal-flow": "40 l/min",
        f"counterbalance.c{i}.nominal-pressure-drop": "10 bar",
    }


def plan(folder: Path) -> hc.Scenario:
    """All four sections up and down again, within ten seconds."""
    keys = dict(PUMP)
    for i in range(1, JOINTS + 1):
        keys |= section(i)
    crane = hc.load_machine(write_chain(JOINTS, folder), keys)
    times = np.array([0.0, 0.5, 1.5, 4.0, 5.0, 6.0, 8.5, 9.5])
    shape = np.array([0.0, 0.0, 1.0, 1.0, 0.0, -1.0, -1.0, 0.0])
    strokes = dict(zip(crane.cylinder_names, crane.spool_strokes, strict=True))
    commands = {name: hc.Command(times, 0.1 * strokes[name] * shape, "linear") for name in crane.cylinder_names}
    joints = dict.fromkeys(crane.joint_names, 0.0)
    return hc.Scenario(machine=crane, joints=joints, commands=commands, duration=10.0)


def measure(given: hc.Scenario) -> list[dict[str, float | str]]:
    """Times real time, and the largest error of the tip, m, by method."""
    crane = given.load_machine()
    record = given.record_times()

    def states(method: str, rtol: float) -> np.ndarray:
        solver = hc.Solver(method=method, rtol=rtol, max_step=MAX_STEP)
        entry = scenario_entry(given.changed(solver=solver), crane.cylinder_names)
        raw = _core.run(crane.core, entry, record, False, None, None)
        if raw["outcome"][0] != "completed":
            raise RuntimeError(f"{method} at {rtol:g} ended early: {raw['outcome']}")
        return raw["states"]

    def tip(of: np.ndarray) -> np.ndarray:
        return crane.tip(of[:, : len(crane.joint_names)])

    exact = tip(states("rodas5p", REFERENCE))
    rows: list[dict[str, float | str]] = []
    for method in METHODS:
        runs = [clocked(lambda method=method: states(method, RTOL)) for _ in range(RUNS)]
        error = float(np.linalg.norm(tip(runs[0].states) - exact, axis=1).max())
        factor = float(given.duration) / min(run.seconds for run in runs)
        rows.append({"method": method, "times_real_time": factor, "tip_error_m": error})
    return rows


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        for row in measure(plan(Path(folder))):
            error = 1e3 * float(row["tip_error_m"])
            print(f"{row['method']}: {row['times_real_time']:.0f} times real time, tip error {error:.4f} mm")
