"""Third benchmark: studies in threads, in processes and on a cluster; killed, poisoned, larger than the memory.

``python benches/sweep_reliability.py`` takes some ten minutes and writes ``docs/validation/sweeps.md`` with its figures
in ``sweep_reliability.json`` beside this file. The tests in ``tests/python/studies`` run its parts with few cases.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import make_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr

import hydrocrane as hc
from hydrocrane.studies.distribution import WAYS, thread_count
from hydrocrane.studies.processes import NotComputed

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


# --- the same numbers everywhere -----------------------------------------------------------------------------------


def equal(folder: Path, sizes: tuple[int, ...], *, duration: float = 0.5) -> list[dict[str, Any]]:
    """Studies of several sizes on one thread, in threads, in processes and on two Dask workers."""
    rows = []
    with cluster(folder) as (address, _):
        for cases in sizes:
            plain = run(None, cases, duration=duration, workers=1, scheduler="threads")
            ways = {"threads": "threads", "processes": "processes", "Dask": address}
            found = {name: run(None, cases, duration=duration, scheduler=way) for name, way in ways.items()}
            rows.append({"cases": cases} | {name: bool(data.identical(plain)) for name, data in found.items()})
    return rows


def paces(counts: tuple[tuple[int, float], ...], *, rounds: int = 3) -> list[dict[str, Any]]:
    """Cases per second by one thread, by a thread per core, by a process per core, and as chosen.

    The ways take turns, so that another load of the computer meets all of them; the median of the rounds counts.
    """
    ways: dict[str, dict[str, Any]] = {
        "one": {"workers": 1, "scheduler": "threads"},
        "threads": {"scheduler": "threads"},
        "processes": {"scheduler": "processes"},
        "chosen": {},
    }
    rows = []
    for cases, duration in counts:
        found: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(rounds):
            for name, options in ways.items():
                began = time.perf_counter()
                run(None, cases, duration=duration, **options)
                found[name].append(cases / (time.perf_counter() - began))
        rows.append(
            {"cases": cases, "duration": duration}
            | {name: float(np.median(found[name])) for name in ways}
            | {f"{name}_gain": float(np.median(np.divide(found[name], found["one"]))) for name in ways}
        )
    return rows


# --- killed and resumed ---------------------------------------------------------------------------------------------

# Where every case that is computed leaves its payload: the same file in each life, for it is a part of the study.
JOURNAL = "SWEEP_JOURNAL"


def journal(run: hc.Run) -> float:
    """A measure that leaves a mark."""
    file = os.open(os.environ[JOURNAL], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(file, np.float64(run.data.attrs["payload"]).tobytes())
    os.close(file)
    return 1.0


def live(store: Path, cases: int, duration: float, scheduler: str) -> xr.Dataset:
    """One life of the study."""
    return run(store, cases, duration=duration, scheduler=scheduler, measures=["tip_way", "pump_energy", journal])


def killed(
    folder: Path, cases: int, *, scheduler: str = "threads", kills: int = 2, duration: float = 5.0
) -> dict[str, Any]:
    """Kill the study `kills` times with SIGKILL, resume it each time, and compare it with an undisturbed one."""
    folder = folder / scheduler
    folder.mkdir()
    store, lives, known = folder / "killed.zarr", [], set()
    for number in range(kills + 1):
        log = folder / "life.log"
        command = [sys.executable, __file__, "--live", str(store), "--scheduler", scheduler]
        began = time.perf_counter()
        child = subprocess.Popen(
            [*command, "--cases", str(cases), "--duration", str(duration)], env={**os.environ, JOURNAL: str(log)}
        )
        if number < kills:
            _kill_at(child, log, (cases - len(known)) // (kills + 1 - number))
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        computed = np.fromfile(log, dtype=np.float64)
        log.unlink()
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
    place = folder / "undisturbed.zarr"
    command = [sys.executable, __file__, "--live", str(place), "--cases", str(cases), "--duration", str(duration)]
    child = subprocess.Popen(command, env={**os.environ, JOURNAL: str(folder / "life.log")})
    _, _, usage = os.wait4(child.pid, 0)
    child.returncode = 0
    undisturbed, resumed = hc.open_study(place), hc.open_study(store)
    outcomes, counts = np.unique(undisturbed.outcome.values.astype(str), return_counts=True)
    return {
        "cases": cases,
        "workers": thread_count(),
        "block": int(np.prod(_blocks(store))),
        "lives": lives,
        "identical": bool(resumed.identical(undisturbed)),
        "outcomes": {str(name): int(count) for name, count in zip(outcomes, counts, strict=True)},
        "undisturbed_cpu_seconds": usage.ru_utime + usage.ru_stime,
        "stored_MB": sum(file.stat().st_size for file in store.rglob("*") if file.is_file()) / 1e6,
    }


def _blocks(store: Path) -> tuple[int, ...]:
    """Cases of a block along each dimension."""
    return zarr.open_group(store, mode="r")["outcome"].chunks


def _kill_at(child: subprocess.Popen[bytes], log: Path, count: int) -> None:
    """Kill the child once it has computed `count` cases."""
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
    return set(data["payload.mass"].values[data.outcome.values == "completed"])


# --- a case that ends its process, a function that hangs, a full disk ----------------------------------------------

DEADLY = 7


def deadly(run: hc.Run) -> float:
    """A measure that ends the process of one case."""
    if run.data.attrs["payload"] == DEADLY:
        os.kill(os.getpid(), signal.SIGKILL)
    return 1.0


def poison(store: Path, scheduler: str, cases: int) -> xr.Dataset:
    """A study of which one case ends its process."""
    loads = {"payload.mass": [float(load) for load in range(cases)]}
    options = {"duration": 0.1, "progress": False, "store": store, "scheduler": scheduler, "measures": [deadly]}
    return hc.sweep(SCENARIO, loads, **options)


def poisoned(folder: Path, cases: int) -> list[dict[str, Any]]:
    """How often the study must be called where one case ends its process, and what it then holds."""
    rows = []
    with cluster(folder) as (address, _):
        for name, scheduler in (("threads", "threads"), ("processes", "processes"), ("Dask", address)):
            store = folder / f"poisoned-{name}.zarr"
            command = [sys.executable, __file__, "--poison", str(store), "--scheduler", scheduler]
            calls = 1
            while subprocess.run([*command, "--cases", str(cases)], stderr=subprocess.DEVNULL).returncode and calls < 9:
                calls += 1
            outcomes = hc.open_study(store).outcome.values
            rows.append(
                {
                    "way": name,
                    "calls": calls,
                    "killed": int((outcomes == "killed").sum()),
                    "completed": int((outcomes == "completed").sum()),
                    "right": bool(outcomes[DEADLY] == "killed"),
                }
            )
    return rows


def full_disk(folder: Path, cases: int) -> dict[str, Any]:
    """A study whose store may not grow beyond a limit of the operating system, and then may."""
    store = folder / "full.zarr"
    command = [sys.executable, __file__, "--signals", str(store), "--cases", str(cases), "--duration", "1"]
    first = subprocess.run(["sh", "-c", 'ulimit -f 16; exec "$@"', "sh", *command], stderr=subprocess.PIPE, text=True)
    done = int((hc.open_study(store).outcome.values != "").sum()) if store.exists() else 0
    second = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    whole = run(None, cases, signals=SIGNALS, duration=1.0)
    return {
        "cases": cases,
        "done": done,
        "error": first.stderr.strip().splitlines()[-1].replace(str(store), "STORE") if first.stderr.strip() else "",
        "statuses": [first.returncode, second.returncode],
        "identical": bool(hc.open_study(store).load().identical(whole)),
    }


# --- a lost worker --------------------------------------------------------------------------------------------------


class Workers(list[subprocess.Popen[bytes]]):
    """The workers of a cluster, and its scheduler."""

    scheduler: subprocess.Popen[bytes]


@contextmanager
def cluster(folder: Path, workers: int = 2) -> Iterator[tuple[str, Workers]]:
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
        found = Workers(started[1:])
        found.scheduler = started[0]
        yield json.loads(place.read_text())["address"], found
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


def lost_scheduler(folder: Path, cases: int, *, duration: float = 5.0) -> dict[str, Any]:
    """Kill the scheduler half-way; the same call resumes on a new one."""
    store, killed = folder / "scheduler.zarr", []

    def watch(scheduler: subprocess.Popen[bytes], done: int, total: int) -> None:
        if done >= total // 2 and not killed:
            killed.append(done)
            scheduler.kill()

    (folder / "first").mkdir()
    (folder / "second").mkdir()
    error = ""
    with cluster(folder / "first") as (address, workers):
        try:
            tell = functools.partial(watch, workers.scheduler)
            run(store, cases, scheduler=address, progress=tell, duration=duration)
        except NotComputed as lost:
            error = str(lost).replace(str(store), "STORE")
    done = int((hc.open_study(store).outcome.values != "").sum())
    with cluster(folder / "second") as (address, _):
        data = run(store, cases, scheduler=address, duration=duration)
    return {
        "cases": cases,
        "killed_after": killed[0],
        "done": done,
        "error": error,
        "identical": bool(data.load().identical(run(None, cases, duration=duration))),
    }


# --- resumed after a change -----------------------------------------------------------------------------------------

OFFSET = 1.0


class Holding:
    """A controller of one's own with a gain."""

    share = 1.0

    def __init__(self, gain: float | np.ndarray) -> None:
        self.gain = gain

    def step(self, obs: Any, command: Any) -> list[float]:
        return [self.share * float(np.sum(self.gain)) * (0.1 - obs.q[0])]

    def gained(self, run: hc.Run) -> float:
        return float(np.sum(self.gain)) * run.outcome.time


def scaled(run: hc.Run, factor: float = 1.0) -> float:
    """A measure that takes an argument and reads a value of the module."""
    return factor * OFFSET * run.outcome.time


def _of_module(value: float) -> dict[str, Any]:
    globals()["OFFSET"] = value
    return {"measures": [scaled]}


def _closure(value: float) -> dict[str, Any]:
    return {"measures": {"own": lambda run: value * run.outcome.time}}


def _default(value: float) -> dict[str, Any]:
    def own(run: hc.Run, factor: float = value) -> float:
        return factor * run.outcome.time

    return {"measures": {"own": own}}


def _controller(own: Any) -> dict[str, Any]:
    plan = hc.Scenario(machine="single-cylinder", joints={"slide": 0.0}, controller=own, duration=0.05)
    return {"scenario": plan}


# A controller of one's own as a data class, whose method is changed.
Held = make_dataclass("Held", [("gain", float, 1.0)])


def _attribute(value: float) -> dict[str, Any]:
    Holding.share = value
    return _controller(Holding(1.0))


def _method(value: float) -> dict[str, Any]:
    Held.step = lambda self, obs, command: [value * (0.1 - obs.q[0])]
    return _controller(Held())


def _helper(value: float) -> dict[str, Any]:
    @functools.cache
    def helper() -> float:
        return value

    def nested(run: hc.Run) -> float:
        return (lambda: helper() * run.outcome.time)()

    return {"measures": {"own": nested}}


def changes(folder: Path) -> dict[str, Callable[[float], dict[str, Any]]]:
    """What a study is called with, before a change and after it."""

    def log(value: float) -> dict[str, Any]:
        file = folder / "commands.csv"
        file.write_text(f"time,test\n0,0\n0.01,{value / 1e3}\n1,{value / 1e3}\n", encoding="utf-8")
        return {"keys": {"command.log": [str(file)]}}

    def other(value: float) -> dict[str, Any]:
        place = folder / f"modules-{value:g}"
        place.mkdir(exist_ok=True)
        texts = {"settings": f"GAIN = {value}\n", "reading": "import settings\ndef own(run): return settings.GAIN\n"}
        for name, text in texts.items():
            (place / f"{name}.py").write_text(text, encoding="utf-8")
            sys.modules.pop(name, None)
        sys.path.insert(0, str(place))
        return {"measures": {"own": importlib.import_module("reading").own}}

    return {
        "gain of an own controller": lambda value: _controller(Holding(value)),
        "array of an own controller": lambda value: _controller(Holding(np.array([0.5, value]))),
        "attribute of its class": _attribute,
        "method of a data class": _method,
        "content of a log that a key names": log,
        "argument of `functools.partial`": lambda value: {"measures": {"own": functools.partial(scaled, factor=value)}},
        "variable of a closure": _closure,
        "default of an argument": _default,
        "value of the module that a measure reads": _of_module,
        "constant of another module": other,
        "helper of a nested function, behind a cache": _helper,
        "object of a bound method": lambda value: {"measures": {"own": Holding(value).gained}},
    }


def changed(folder: Path) -> list[dict[str, Any]]:
    """Whether a study is refused after a change that its values do not show, and resumed without one."""
    rows = []
    plain = {"scenario": "single-cylinder-step", "keys": {"payload.mass": [50.0, 100.0]}, "duration": 0.05}
    for number, (name, given) in enumerate(changes(folder).items()):
        store = folder / f"changed-{number}.zarr"

        def study(value: float, given: Any = given, store: Path = store) -> xr.Dataset:
            return hc.sweep(**{**plain, "store": store, "progress": False, **given(value)})

        first = study(1.0)
        same, told = study(1.0).identical(first), ""
        try:
            study(2.0)
        except hc.ResultFileError as error:
            told = str(error)
        rows.append({"what": name, "resumed": bool(same), "refused": "holds another study" in told})
    return rows


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


def sections(folder: Path, cases: int, duration: float) -> dict[str, Callable[[], Any]]:
    """What is measured, by its name in the results."""
    few = max(cases // 10, 20)
    sizes = tuple(size for size in (1, 7, 60, 100, 333, 1500, 2000, 20000) if size <= cases)
    return {
        "equal": lambda: equal(folder, sizes),
        "pace": lambda: paces(((3000, 0.5), (3000, 5.0))),
        "killed": lambda: [{"way": way, **killed(folder, cases, scheduler=way, duration=duration)} for way in WAYS],
        "poisoned": lambda: poisoned(folder, 100),
        "lost_worker": lambda: lost_worker(folder, few, duration=duration),
        "lost_scheduler": lambda: lost_scheduler(folder, few, duration=duration),
        "full_disk": lambda: full_disk(folder, 200),
        "changed": lambda: changed(folder),
        "memory": lambda: memory(folder, (cases // 20, cases // 5), duration=duration),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20000)
    parser.add_argument("--duration", type=float, default=5.0)
    parser.add_argument("--only", nargs="*", help="sections to measure; the others keep their figures")
    parser.add_argument("--live", type=Path, help="be one life of the study")
    parser.add_argument("--poison", type=Path, help="be the study of which one case ends its process")
    parser.add_argument("--scheduler", default="threads")
    parser.add_argument("--signals", type=Path, help="be a study with signals")
    given = parser.parse_args()
    if given.live:
        live(given.live, given.cases, given.duration, given.scheduler)
    elif given.poison:
        poison(given.poison, given.scheduler, given.cases)
    elif given.signals:
        run(given.signals, given.cases, signals=SIGNALS, duration=given.duration)
    else:
        from sweep_page import add

        for name in given.only or sections(Path(), given.cases, given.duration):
            with tempfile.TemporaryDirectory() as place:
                add(name, sections(Path(place), given.cases, given.duration)[name]())


if __name__ == "__main__":
    main()
