"""Many cranes at once: how exact random manoeuvres are, and how many crane-seconds a second of computing brings."""

from __future__ import annotations

import threading
import time
from typing import Any, NamedTuple

import numpy as np

import hydrocrane as hc
from benches.problem import MAX_STEP, NotAvailable
from hydrocrane import _core
from hydrocrane.scenario.scenario import scenario_entry

MACHINE = "rottne-f9-lab"
TOLERANCES = (0.05, 0.02, 0.005)
# What throughput by instruction set and free of memory is measured with: the default.
USUAL = 0.02
SAMPLE = 0.01
# Tip error that the goal allows, m.
TIP_ERROR = 1e-3
MANOEUVRES, DURATION, HOLD = 200, 5.0, 0.5
# Share of the spools' strokes that random commands stay within, and of the joints' ranges left free at both ends.
OPENING, MARGIN = 0.5, 0.1
EXACT = 1e-9
SIZES = (1_000, 10_000, 100_000)
THREADS = (1, 2)
# Few enough cranes to stay in the cache of one core, enough to fill its lanes.
IN_CACHE = 512
# Crane-seconds of one throughput measurement, and the samples of a manoeuvre that are run for it.
WORK = 10_000.0
SAMPLES = (round(HOLD / SAMPLE), round(DURATION / SAMPLE))
ROUNDS = 3
# Cranes of a call that is timed by itself: one, and as many as have lanes in the widest registers.
FEW = (1, 8)
CALLS = 300


def batch(crane: hc.Machine, n: int, **options: Any) -> Any:
    """A batch simulator of n cranes."""
    if not hasattr(hc, "BatchSimulator"):
        raise NotAvailable("this version has no BatchSimulator")
    return hc.BatchSimulator(crane, n, sample_time=SAMPLE, **options)


def manoeuvres(crane: hc.Machine, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Start states (count, states) at rest, and commands (changes, count, cylinders), each held for HOLD."""
    rng = np.random.default_rng(seed)
    low, high = crane.joint_limits.T
    poses = low + (high - low) * rng.uniform(MARGIN, 1 - MARGIN, (count, low.size))
    changes = round(DURATION / HOLD)
    openings = rng.uniform(-OPENING, OPENING, (changes, count, len(crane.cylinder_names)))
    return np.stack([crane.equilibrium(pose) for pose in poses]), openings * crane.spool_strokes


def exact_tips(crane: hc.Machine, start: np.ndarray, commands: np.ndarray) -> list[np.ndarray]:
    """Path of every tip (samples, 2) by the adaptive method; shorter where a run ends at a limit."""
    record = np.arange(round(DURATION / SAMPLE) + 1) * SAMPLE
    times = np.arange(len(commands)) * HOLD
    solver = hc.Solver(method="rodas5p", rtol=EXACT, max_step=MAX_STEP)
    tips = []
    for k, x in enumerate(start):
        state = dict(zip(crane.state_names, x, strict=True))
        plan = hc.Scenario(
            machine=crane,
            joints={joint: state[f"joint.{joint}.q"] for joint in crane.joint_names},
            pressures={c: (state[f"cylinder.{c}.p1"], state[f"cylinder.{c}.p2"]) for c in crane.cylinder_names},
            commands=(times, commands[:, k]),
            duration=DURATION,
            solver=solver,
        )
        raw = _core.run(crane.core, scenario_entry(plan, crane.cylinder_names), record, False, None, None)
        tips.append(crane.tip(raw["states"][:, : len(crane.joint_names)]))
    return tips


def accuracy(
    crane: hc.Machine, tolerance: float, start: np.ndarray, commands: np.ndarray, exact: list[np.ndarray]
) -> dict[str, Any]:
    """Worst and median distance of the tips from the exact paths, over all samples of each manoeuvre."""
    simulator = batch(crane, len(start), tolerance=tolerance)
    simulator.reset(state=start)
    path = [crane.tip(start[:, : len(crane.joint_names)])]
    for spools in commands:
        path += [simulator.step(spools).tip for _ in range(round(HOLD / SAMPLE))]
    found = np.stack(path, axis=1)
    errors = [float(np.linalg.norm(a[: len(e)] - e, axis=1).max()) for a, e in zip(found, exact, strict=True)]
    within = sum(error <= TIP_ERROR for error in errors)
    found = {"worst_m": max(errors), "median_m": float(np.median(errors)), "within_1_mm": within}
    return {"tolerance": tolerance, "manoeuvres": len(start)} | found


class Herd(NamedTuple):
    """A batch, where its cranes start, and their commands, each held for HOLD."""

    simulator: Any
    start: np.ndarray
    commands: list[np.ndarray]


def herd(crane: hc.Machine, n: int, tolerance: float, threads: int, **options: Any) -> Herd:
    """A few hundred of the manoeuvres whose errors are measured, repeated until there are n."""
    start, commands = manoeuvres(crane, min(n, MANOEUVRES))
    rows = np.arange(n) % len(start)
    simulator = batch(crane, n, tolerance=tolerance, threads=threads, **options)
    return Herd(simulator, np.ascontiguousarray(start[rows]), [np.ascontiguousarray(held[rows]) for held in commands])


def throughput(herds: list[Herd]) -> dict[str, float]:
    """Best of ROUNDS by the wall clock and by CPU time; each batch in a thread of its own, from rest on."""
    cranes = sum(len(h.start) for h in herds)
    samples = int(np.clip(round(WORK / (cranes * SAMPLE)), *SAMPLES))

    def work(h: Herd) -> None:
        for k in range(samples):
            h.simulator.step(h.commands[k // SAMPLES[0]])

    found = {"crane_seconds_per_second": 0.0, "crane_seconds_per_cpu_second": 0.0}
    for _ in range(ROUNDS):
        for h in herds:
            h.simulator.reset(state=h.start)
        threads = [threading.Thread(target=work, args=(h,)) for h in herds]
        clocks = time.perf_counter(), time.process_time()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        took = time.perf_counter() - clocks[0], time.process_time() - clocks[1]
        done = cranes * samples * SAMPLE
        found = {name: max(best, done / t) for (name, best), t in zip(found.items(), took, strict=True)}
    return found


def by_size(crane: hc.Machine, tolerance: float, sizes: tuple[int, ...] = SIZES) -> list[dict[str, Any]]:
    """Per number of cranes and threads; and how independent threads in cache scale, which needs no memory."""
    rows = []
    for n in sizes:
        for threads in THREADS:
            rows.append({"cranes": n, "threads": threads} | throughput([herd(crane, n, tolerance, threads)]))
    return rows


def free_of_memory(crane: hc.Machine, tolerance: float) -> list[dict[str, Any]]:
    """One and two threads, each with a batch of its own that stays in cache: what two cores can give at all."""
    rows = []
    for threads in THREADS:
        herds = [herd(crane, IN_CACHE, tolerance, 1) for _ in range(threads)]
        rows.append({"cranes": IN_CACHE, "threads": threads} | throughput(herds))
    return rows


def by_instruction_set(crane: hc.Machine, tolerance: float, n: int) -> list[dict[str, Any]]:
    """One thread with narrower and wider vectors, as far as this processor has them."""
    rows = []
    for name in ("sse2", "avx2", "avx512"):
        try:
            one = herd(crane, n, tolerance, 1, instruction_set=name)
        except hc.HydrocraneError:
            continue
        rows.append({"instruction_set": name} | throughput([one]))
    return rows


def calls(crane: hc.Machine) -> list[dict[str, Any]]:
    """CPU time of one call that steps few cranes on one thread: no work is done crane by crane in Python."""
    start, commands = manoeuvres(crane, 1)
    simulators = {n: batch(crane, n, tolerance=USUAL, threads=1) for n in FEW}
    least = dict.fromkeys(FEW, float("inf"))
    # By turns, so that a slow moment of the computer meets them all. All take the same steps of the same manoeuvre.
    for _ in range(CALLS):
        for n, simulator in simulators.items():
            simulator.reset(state=np.repeat(start, n, axis=0))
            spools = np.repeat(commands[0], n, axis=0)
            began = time.process_time()
            simulator.step(spools)
            least[n] = min(least[n], time.process_time() - began)
    return [{"cranes": n, "seconds": seconds} for n, seconds in least.items()]


def measure(count: int = MANOEUVRES, sizes: tuple[int, ...] = SIZES) -> dict[str, Any]:
    crane = hc.load_machine(MACHINE)
    batch(crane, 1)
    start, commands = manoeuvres(crane, count)
    exact = exact_tips(crane, start, commands)
    rows = []
    for tolerance in TOLERANCES:
        found = accuracy(crane, tolerance, start, commands, exact)
        rows.append(found | {"throughput": by_size(crane, tolerance, sizes)})
    return {
        "tolerances": rows,
        "calls": calls(crane),
        "free_of_memory": free_of_memory(crane, USUAL),
        "instruction_sets": by_instruction_set(crane, USUAL, sizes[0]),
    }
