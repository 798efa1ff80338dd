"""Third benchmark: studies that are killed, that lose a worker, and that are larger than the memory they may use.

``python benches/sweep_reliability.py`` takes some minutes and writes ``docs/validation/sweeps.md`` with its figures in
``sweep_reliability.json`` beside this file. ``tests/python/studies/test_study_store.py`` runs the same with few cases.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr

import hydrocrane as hc
from hydrocrane.studies import case, local

SCENARIO = "vertical-lift-open-loop"
BROKEN_SHARE = 0.01
# Key, a value that no crane has.
BROKEN = (
    ("payload.mass", -10.0),
    ("supply.pressure", -1.0),
    ("cylinder.lift.bore", 0.01),
    ("initial.joint.boom", 3.3),
)
SIGNALS = ("tip.x", "tip.z", "cylinder.lift.p1", "cylinder.lift.p2")


def keys(cases: int) -> dict[str, list[float]]:
    """Values of four keys, one in a hundred cases with a broken one. Every case has another payload."""
    rng = np.random.default_rng(20)
    drawn = {
        "payload.mass": rng.uniform(0.0, 100.0, cases),
        "supply.pressure": rng.uniform(100e5, 160e5, cases),
        "cylinder.lift.bore": rng.uniform(0.095, 0.105, cases),
        "initial.joint.boom": rng.uniform(1.70, 1.80, cases),
    }
    for i, place in enumerate(rng.choice(cases, max(round(BROKEN_SHARE * cases), 1), replace=False)):
        key, value = BROKEN[i % len(BROKEN)]
        drawn[key][place] = value - 1e-6 * place if key == "payload.mass" else value
    return {key: [float(value) for value in values] for key, values in drawn.items()}


def run(store: Path | None, cases: int, **options: Any) -> xr.Dataset:
    """The study, as a person would call it."""
    return hc.sweep(SCENARIO, keys(cases), method="list", store=store, **{"progress": False, **options})


# --- killed and resumed ---------------------------------------------------------------------------------------------


def live(store: Path, cases: int, log: Path, duration: float) -> None:
    """One life of the study: every case that is run leaves its payload in the log before it is run."""
    journal = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    plain = case.run_case

    def logged(job: case.Job, values: Any, should_stop: Any = None) -> case.CaseResult:
        os.write(journal, np.float64(values[0]).tobytes())
        return plain(job, values, should_stop)

    case.run_case = logged
    run(store, cases, duration=duration)


def killed(folder: Path, cases: int, *, kills: int = 2, duration: float = 5.0) -> dict[str, Any]:
    """Kill the study `kills` times with SIGKILL, resume it each time, and compare it with an undisturbed one."""
    store, lives, known = folder / "killed.zarr", [], set()
    for number in range(kills + 1):
        log = folder / f"life-{number}.log"
        command = [sys.executable, __file__, "--live", str(store), "--log", str(log)]
        began = time.perf_counter()
        child = subprocess.Popen([*command, "--cases", str(cases), "--duration", str(duration)])
        if number < kills:
            _kill_at(child, log, (cases - len(known)) // (kills + 1 - number))
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        computed = np.fromfile(log, dtype=np.float64)
        done = _done(store)
        lives.append(
            {
                "status": child.returncode,
                "seconds": time.perf_counter() - began,
                "computed": int(computed.size),
                "computed_although_done": len(known & set(computed)),
                "done_after": len(done),
                "peak_memory_MB": usage.ru_maxrss / 1024,
            }
        )
        known = done
    began, computing = time.perf_counter(), time.process_time()
    undisturbed = run(folder / "undisturbed.zarr", cases, duration=duration)
    seconds, computing = time.perf_counter() - began, time.process_time() - computing
    resumed = hc.open_study(store)
    outcomes, counts = np.unique(undisturbed.outcome.values.astype(str), return_counts=True)
    return {
        "cases": cases,
        "workers": local.thread_count(),
        "block": int(np.prod(_blocks(store))),
        "lives": lives,
        "identical": bool(resumed.identical(undisturbed)),
        "outcomes": {str(name): int(count) for name, count in zip(outcomes, counts, strict=True)},
        "undisturbed_seconds": seconds,
        "undisturbed_cpu_seconds": computing,
        "stored_MB": sum(file.stat().st_size for file in store.rglob("*") if file.is_file()) / 1e6,
    }


def _blocks(store: Path) -> tuple[int, ...]:
    """Cases of a block along each dimension."""
    return zarr.open_group(store, mode="r")["outcome"].chunks


def _kill_at(child: subprocess.Popen[bytes], log: Path, count: int) -> None:
    """Kill the child once it has begun `count` cases."""
    while child.poll() is None and (not log.exists() or log.stat().st_size < 8 * count):
        time.sleep(0.01)
    if child.poll() is not None:
        raise RuntimeError("the study was over before it could be killed; give it more cases")
    os.kill(child.pid, signal.SIGKILL)


def _done(store: Path) -> set[float]:
    """Payloads of the cases that a store has results of."""
    if not store.exists():
        return set()
    data = hc.open_study(store)
    return set(data["payload.mass"].values[data.outcome.values != ""])


# --- a lost worker --------------------------------------------------------------------------------------------------


@contextmanager
def cluster(folder: Path, workers: int = 2) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A Dask scheduler and its workers on this machine, each a process of its own: the address, and the workers."""
    place, log = folder / "scheduler.json", (folder / "cluster.log").open("wb")
    module, local = [sys.executable, "-m"], ["--host", "127.0.0.1"]
    scheduler = ["distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(place)]
    worker = ["distributed.cli.dask_worker", "--scheduler-file", str(place), "--nthreads", "1", "--no-nanny"]
    worker += ["--no-dashboard", "--local-directory", str(folder), *local]
    started = [subprocess.Popen([*module, *scheduler, *local], stdout=log, stderr=log)]
    try:
        while not place.exists():
            if started[0].poll() is not None:
                raise RuntimeError(f"the scheduler ended: {(folder / 'cluster.log').read_text()}")
            time.sleep(0.05)
        started += [subprocess.Popen([*module, *worker], stdout=log, stderr=log) for _ in range(workers)]
        yield json.loads(place.read_text())["address"], started[1:]
    finally:
        for process in started:
            process.kill()
            process.wait()
        log.close()


def lost_worker(folder: Path, cases: int, *, duration: float = 5.0) -> dict[str, Any]:
    """Run the study on two workers, kill one half-way, and compare with a local run."""
    from distributed import Client

    lost: list[int] = []
    with cluster(folder) as (address, workers):
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(len(workers), timeout=60)

        def watch(done: int, total: int) -> None:
            if done >= total // 2 and not lost:
                lost.append(done)
                workers[0].kill()

        began = time.perf_counter()
        data = run(folder / "cluster.zarr", cases, scheduler=address, progress=watch, duration=duration)
        seconds = time.perf_counter() - began
        left = workers[1].poll() is None
    local = run(None, cases, duration=duration)
    return {
        "cases": cases,
        "lost_after": lost[0],
        "one_worker_left": left,
        "missing": int((data.outcome.values == "").sum()),
        "identical": bool(data.load().identical(local)),
        "seconds": seconds,
    }


# --- memory ---------------------------------------------------------------------------------------------------------


def memory(folder: Path, counts: tuple[int, ...], *, duration: float = 5.0) -> list[dict[str, Any]]:
    """Peak memory of studies with signals, each in a process of its own."""
    rows = []
    for count in counts:
        store = folder / f"signals-{count}.zarr"
        command = [sys.executable, __file__, "--signals", str(store), "--cases", str(count)]
        child = subprocess.Popen([*command, "--duration", str(duration)])
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise RuntimeError(f"a study of {count} cases ended with status {child.returncode}")
        rows.append(
            {"cases": count, "signals_MB": hc.open_study(store).nbytes / 1e6, "peak_memory_MB": usage.ru_maxrss / 1024}
        )
    return rows


# --- page -----------------------------------------------------------------------------------------------------------


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20000)
    parser.add_argument("--duration", type=float, default=5.0)
    parser.add_argument("--live", type=Path, help="be one life of the study")
    parser.add_argument("--log", type=Path)
    parser.add_argument("--signals", type=Path, help="be a study with signals")
    given = parser.parse_args()
    if given.live:
        live(given.live, given.cases, given.log, given.duration)
    elif given.signals:
        run(given.signals, given.cases, signals=SIGNALS, duration=given.duration)
    else:
        from sweep_page import write_page

        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            found = {
                "killed": killed(folder, given.cases, duration=given.duration),
                "lost_worker": lost_worker(folder, max(given.cases // 10, 20), duration=given.duration),
                "memory": memory(folder, (given.cases // 20, given.cases // 5), duration=given.duration),
            }
        write_page(found)


if __name__ == "__main__":
    main()
