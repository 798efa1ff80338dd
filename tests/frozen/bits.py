"""The last state of many short runs, bit for bit: a change of structure must not move a number.

`python tests/frozen/bits.py` compares with `bits.json` and names what moved; with `--write` it replaces the file. A
number that moves on purpose stands under "Numbers that moved" in the CHANGELOG. Bits are those of every platform.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import hydrocrane as hc

HERE = Path(__file__).resolve().parent
FILE, DRIVE = HERE / "bits.json", HERE / "drive.toml"
# Friction as printed jumps, which makes adaptive methods crawl; the explicit method crawls with stiff bristles.
PRINTED = "heinze-2007-open-loop"
SECONDS, EXPLICIT_SECONDS, PRINTED_SECONDS = 1.0, 0.05, 0.05
STEP = 1e-3

Runs = Iterator[tuple[str, Callable[[], np.ndarray]]]


def digest(numbers: np.ndarray) -> str:
    return hashlib.sha256(np.ascontiguousarray(numbers, dtype="<f8").tobytes()).hexdigest()[:16]


def last_state(scenario: str | Path, seconds: float, **changes: object) -> np.ndarray:
    run = hc.simulate(scenario, duration=seconds, **changes)
    if run.outcome.kind != "completed":
        raise RuntimeError(f"{scenario} {changes}: {run.outcome.message}")
    return np.array([run.data[name].values[-1] for name in run.machine.state_names])


def open_loops() -> Runs:
    for name in hc.bundled_scenarios():
        for method in ("rodas5p", "hc-exponential-4", "tsit5", "hc-rosenbrock-3"):
            seconds = PRINTED_SECONDS if name == PRINTED else EXPLICIT_SECONDS if method == "tsit5" else SECONDS
            changes = {"method": method} | ({"step": STEP} if method == "hc-rosenbrock-3" else {})
            yield f"{name} by {method}", lambda n=name, s=seconds, c=changes: last_state(n, s, **c)


def closed_loops() -> Runs:
    for machine in ("rottne-f9-lab", "hiab-xs031"):
        for controller in ("tip", "heinze-pid", "lever"):
            for sensors in ("ideal", "data-sheet"):
                name = f"{controller} on {machine} with {sensors} sensors"
                yield name, lambda m=machine, c=controller, s=sensors: closed_loop(m, c, s)
    yield "a saved drive", lambda: last_state(DRIVE, SECONDS)


def closed_loop(machine: str, controller: str, sensors: str) -> np.ndarray:
    crane = hc.load_machine(machine)
    mode = "lever" if controller == "lever" else "tip"
    axes = {"tip": ("x", "z"), "lever": crane.cylinder_names}[mode]
    stick = hc.Joystick([0.0, 0.1, 0.7], {axis: [0.3, 1.0, -0.4] for axis in axes}, mode=mode)
    start = dict(zip(crane.joint_names, crane.joint_limits.mean(axis=1).tolist(), strict=True))
    scenario = hc.Scenario(
        machine=machine, joints=start, joystick=stick, controller=controller, sensors=sensors, duration=SECONDS
    )
    run = hc.simulate(scenario)
    return np.array([run.data[name].values[-1] for name in crane.state_names])


def others() -> Runs:
    for machine in ("rottne-f9-lab", "hiab-xs031", "single-cylinder"):
        yield f"a batch of {machine}", lambda m=machine: batch(m)
    keys = ["friction.lift.bristle-stiffness", "payload.mass", "supply.pressure", "cylinder.lift.bore"]
    yield "sensitivities", lambda: sensitivities(keys)
    yield "a study", study


def batch(machine: str) -> np.ndarray:
    crane, n = hc.load_machine(machine), 11
    cranes = hc.BatchSimulator(crane, n, sample_time=0.01, payload=np.linspace(0.0, 200.0, n))
    cranes.reset(crane.joint_limits.mean(axis=1))
    strokes = np.asarray(crane.spool_strokes)
    for sample in range(40):
        shares = np.cos(0.1 * sample * np.arange(1.0, n + 1.0))[:, None] * np.linspace(0.3, 1.0, len(strokes))
        cranes.step(shares * strokes)
    return cranes.state


def sensitivities(keys: list[str]) -> np.ndarray:
    found = hc.sensitivities("vertical-lift-open-loop", keys, duration=0.5).data
    return np.concatenate([np.ravel(found[name].values[-1]) for name in sorted(map(str, found.data_vars))])


def study() -> np.ndarray:
    keys = {"payload.mass": [0.0, 50.0, 100.0], "supply.pressure": ["120 bar", "140 bar"]}
    with tempfile.TemporaryDirectory() as folder:
        done = hc.sweep("vertical-lift-open-loop", keys, duration=SECONDS, store=Path(folder) / "study.zarr").load()
    numbers = [done[name].values for name in sorted(map(str, done.data_vars)) if done[name].dtype.kind == "f"]
    return np.concatenate([np.ravel(each) for each in numbers])


def main(arguments: list[str]) -> None:
    warnings.simplefilter("ignore")
    found = {}
    for runs in (open_loops(), closed_loops(), others()):
        for name, run in runs:
            found[name] = digest(run())
    if arguments == ["--write"]:
        FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return
    known = json.loads(FILE.read_text(encoding="utf-8"))
    moved = [name for name in known | found if known.get(name) != found.get(name)]
    if moved:
        sys.exit("numbers moved:\n" + "\n".join(moved))
    print(f"{len(found)} runs end in the same bits")


if __name__ == "__main__":
    main(sys.argv[1:])
