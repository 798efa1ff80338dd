"""Write ``forest-crane.csv``, the log of the tutorial: ``python docs/tutorials/make_log.py``.

A crane that is not quite the one of its machine file, as a logger of a workshop would write it: title lines,
semicolons, decimal commas, degrees, bar, per cent.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import hydrocrane as hc

LOG = Path(__file__).with_name("forest-crane.csv")
# What the machine file does not know.
TRUTH = {
    "supply.pressure": "133 bar",
    "valve.lift.nominal-flow": "5.3 l/min",
    "valve.jib.nominal-flow": "6.4 l/min",
    "friction.lift.coulomb": ["600 N", "900 N"],
    "friction.lift.breakaway": ["900 N", "1300 N"],
}
PAYLOAD, BOOM_ZERO, SAMPLES, SEED = 86.0, 0.4, 50.0, 7
# Openings of the valves, per cent, each from a time on, s.
LIFT = {1.0: 60, 5.0: 0, 7.0: -55, 10.5: 0, 12.0: 35, 16.0: 0, 18.0: -40, 22.0: 0}
JIB = {2.5: -50, 6.0: 0, 8.0: 45, 11.0: 0, 13.5: -30, 17.0: 0, 19.0: 60, 21.5: 0}


def ramped(steps: dict[float, float], stroke: float) -> tuple[list[float], list[float]]:
    """A command that changes within a fifth of a second, m of spool."""
    times, spools, now = [0.0], [0.0], 0.0
    for time, percent in steps.items():
        times += [time, time + 0.2]
        spools += [now, percent / 100.0 * stroke]
        now = spools[-1]
    return times, spools


def main() -> None:
    rng = np.random.default_rng(SEED)
    commands = {
        name: hc.Command(*ramped(steps, 0.05), interpolation="linear")
        for name, steps in {"lift": LIFT, "jib": JIB}.items()
    }
    plan = hc.Scenario(
        joints={"boom": 1.25, "jib": 1.7, "extension": 0.1},
        duration=24.0,
        commands=commands,
        record_interval=1.0 / SAMPLES,
    )
    run = hc.simulate(plan, payload=PAYLOAD, overrides=TRUTH, rtol=1e-6)
    time = run.columns.time
    columns = {"t_s": time}
    for title, signal, zero in (("boom [deg]", "joint.boom.q", BOOM_ZERO), ("jib [deg]", "joint.jib.q", 0.0)):
        angle = np.degrees(run.columns[signal].values) + zero + rng.normal(0, 0.01, time.size)
        columns[title] = np.round(angle / 0.011) * 0.011
    for cylinder in ("lift", "jib"):
        for side, title in (("p1", "A"), ("p2", "B")):
            pressure = run.columns[f"cylinder.{cylinder}.{side}"].values * 1e-5 + rng.normal(0, 0.25, time.size)
            columns[f"p {cylinder} {title} [bar]"] = np.round(pressure / 0.05) * 0.05
        columns[f"valve {cylinder} [%]"] = np.round(commands[cylinder].at(time) / 0.05 * 100.0, 1)
    rows = np.column_stack(list(columns.values()))
    table = [";".join(f"{value:.3f}".replace(".", ",") for value in row) for row in rows]
    titles = ["Workshop crane 3;;;", "recorded by: data logger 2;;;"]
    LOG.write_text("\n".join([*titles, ";".join(columns), *table]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
