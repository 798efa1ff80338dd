"""How exact default runs, fixed steps and batches are on bundled machines, under drives by full steps of the spools.

`python docs/validation/step_accuracy.py` drives every machine 50 times for 4 s from random poses with 0 to rated load,
compares with `rodas5p` at 1e-9, and writes docs/validation/step-accuracy.md.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import hydrocrane as hc

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from benches.tables import table  # noqa: E402

PAGE = Path(__file__).with_name("step-accuracy.md")
# Bundled machines with bristles in their friction, and the load (kg) that drives go up to.
MACHINES = {
    "rottne-f9-lab": 300.0,
    "rottne-f9-pump": 200.0,
    "rottne-f9-mobile": 400.0,
    "rottne-f9-ls": 200.0,
    "hiab-xs031": 200.0,
    "single-cylinder": 100.0,
}
DRIVES, SECONDS, HOLD = 50, 4.0, 0.5
TIGHT = hc.Solver(method="rodas5p", rtol=1e-9)
WAYS = {
    "default": hc.Solver(),
    # As crates/web/src/scenario.rs.
    "page": hc.Solver(method="hc-rosenbrock-3", step=1e-3),
    "1 ms": hc.Solver(step=1e-3),
    "5 ms": hc.Solver(step=5e-3),
    "10 ms": hc.Solver(step=1e-2),
    "20 ms": hc.Solver(step=2e-2),
}
SAYS = {"step-inexact", "step-too-long"}


def drives(machine: hc.Machine, load: float) -> Iterator[hc.Scenario]:
    """Random drives: every half second the spools jump to rest, half or full stroke."""
    lower, upper = machine.joint_limits.T
    times = np.arange(0.0, SECONDS, HOLD)
    for seed in range(DRIVES):
        draw = np.random.default_rng(seed)
        q = lower + draw.uniform(0.3, 0.7, lower.size) * (upper - lower)
        shares = draw.choice([-1.0, -0.5, 0.0, 0.0, 0.5, 1.0], size=(times.size, lower.size))
        spools = (shares * machine.spool_strokes).T
        yield hc.Scenario(
            machine=machine,
            joints=dict(zip(machine.joint_names, map(float, q), strict=True)),
            payload=float(load * draw.random()),
            commands={c: hc.Command(times, s, "hold") for c, s in zip(machine.cylinder_names, spools, strict=True)},
            duration=SECONDS,
        )


def tip(run: hc.Run) -> np.ndarray:
    return np.stack([run.columns["tip.x"].values, run.columns["tip.z"].values])


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Largest distance of two paths, mm."""
    count = min(one.shape[1], other.shape[1])
    return float(1e3 * np.hypot(*(one[:, :count] - other[:, :count])).max())


def in_batch(machine: hc.Machine, plans: list[hc.Scenario], exact: list[np.ndarray]) -> tuple[list[float], np.ndarray]:
    """The same drives as one batch by default, sampled at 50 ms: errors, mm, and where it says inexact."""
    sample, record = 0.05, plans[0].record_interval
    batch = hc.BatchSimulator(machine, len(plans), sample, payload=[plan.payload for plan in plans])
    batch.reset(q=[list(plan.joints.values()) for plan in plans])
    paths = []
    for k in range(round(SECONDS / sample)):
        held = int((k * sample + 1e-9) / HOLD)
        batch.step([[command.spool[held] for command in plan.commands.values()] for plan in plans])
        paths.append(batch.observe().tip)
    stride = round(sample / record)
    pairs = zip(np.moveaxis(np.array(paths), 0, 2), exact, strict=True)
    return [apart(path, other[:, stride::stride]) for path, other in pairs], ~batch.alive | batch.inexact


def row(name: str, way: str, errors: list[float], said: np.ndarray) -> list[str]:
    e = np.array(errors)
    silent = int(((e > 1) & ~said).sum())
    return [
        name,
        way,
        f"{np.median(e):.2g}",
        f"{e.max():.3g}",
        f"{int((e > 1).sum())}",
        f"{int((e > 3).sum())}",
        f"{silent}",
    ]


def rows() -> Iterator[list[str]]:
    for name, load in MACHINES.items():
        machine = hc.load_machine(name)
        plans = list(drives(machine, load))
        exact = [tip(hc.simulate(plan.changed(solver=TIGHT))) for plan in plans]
        for way, solver in WAYS.items():
            runs = [hc.simulate(plan.changed(solver=solver)) for plan in plans]
            errors = [apart(tip(run), other) for run, other in zip(runs, exact, strict=True)]
            said = np.array(
                [run.outcome.kind != "completed" or any(w.kind in SAYS for w in run.warnings) for run in runs]
            )
            yield row(name, way, errors, said)
        yield row(name, "batch", *in_batch(machine, plans, exact))


TEXT = """# How exact steps are

Written by `python docs/validation/step_accuracy.py`: largest distance of the tip from `rodas5p` at 1e-9. Each machine
is driven {drives} times for {seconds:g} s from a random pose with up to its load: every {hold:g} s all spools jump to
rest, half or full stroke. This is rougher than any operator; a path from here to there is followed far better.

Failures first: the last column counts drives that were more than 1 mm off without a warning of the run.

{table}

`default` is `auto` at its default tolerance, `page` is what the cockpit's page does (`hc-rosenbrock-3` with fixed steps
of 1 ms, here by the native core, which has its bits), `5 ms` and so on are fixed steps by `auto`, `batch` is
`hc.BatchSimulator` at its default. A fixed step is divided where its estimated error is large
([why](../theory/integration.md#fixed-steps)): the longer the steps, the more of them are.
"""


def main() -> None:
    warnings.simplefilter("ignore")
    heads = ["machine", "steps", "median [mm]", "largest [mm]", "above 1 mm", "above 3 mm", "above 1 mm, silent"]
    found = []
    for line in rows():
        print(*line, sep="\t", flush=True)
        found.append(line)
    found.sort(key=lambda line: -int(line[-1]))
    PAGE.write_text(TEXT.format(drives=DRIVES, seconds=SECONDS, hold=HOLD, table=table(heads, found)), encoding="utf-8")


if __name__ == "__main__":
    main()
