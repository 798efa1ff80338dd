"""Feeds damaged files, command lines and calls to the Python package, FMUs and controllers in C; options: ``--help``.

Workers try the files in processes of their own, with bounded memory and time. Whatever is not one clear message of the
package, or a result of finite numbers, is a failure. A line of JSON per kind of file goes to ``--output``.
"""

from __future__ import annotations

import argparse
import collections
import json
import os
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent
KINDS = (
    "study", "mapping", "log", "scenario", "hdf5", "matlab", "packed", "run", "store", "line", "fmi", "controller"
)  # fmt: skip
# Processor time of an input (s), wall time after which its worker is ended whatever it does (s), and what a worker may
# need beyond what it needs to begin (bytes).
PATIENCE, LONGEST_WAIT, MEMORY = 5.0, 60.0, 2**30
# Inputs of a kind that a worker gets at most, and how many are so few that one worker gets those of several kinds: it
# takes longer to begin than they do.
BATCH, FEW = 500, 100
# Seconds spent on making one input smaller.
SHRINKING = 15.0


@dataclass
class Failure:
    """An input that failed: panic (an exception of no kind of the package's), hang, memory, crash or wrong."""

    number: int
    kind: str
    text: str


@dataclass
class Report:
    """What came of the inputs of one kind."""

    kind: str
    seed: int
    inputs: int
    refused: int = 0
    ran: int = 0
    slowest: float = 0.0
    slowest_number: int = 0
    failures: list[dict[str, object]] = field(default_factory=list)


@cache
def program(kind: str) -> list[str]:
    """What tries the inputs of a kind, or of kinds with commas between; empty where nothing can be compiled."""
    if kind != "controller":
        return [sys.executable, str(HERE / "worker.py"), kind]
    import hydrocrane as hc
    from hydrocrane import _core
    from hydrocrane.export import controller

    compiler, library = shutil.which("cc"), controller.installed_library()
    if compiler is None or library is None:
        return []
    folder = Path(tempfile.mkdtemp())
    machine = hc.load_machine("rottne-f9-lab")
    parameters, size = _core.controller_parameters(machine.core, "tip", True, 0.0)
    (folder / "parameters").write_bytes(parameters)
    flags = ["-std=gnu99", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
    headers = ["-I", str(Path(controller.__file__).with_name("embedded"))]
    source, made = str(HERE / "controller_fuzz.c"), str(folder / "controller_fuzz")
    plain = [flag for flag in flags if "sanitize" not in flag]
    for tried in (flags, plain):
        done = subprocess.run(
            [compiler, *tried, *headers, source, str(library), "-lm", "-o", made], capture_output=True
        )
        if not done.returncode:
            return [made, str(folder / "parameters"), str(size), str(len(machine.joint_names))]
    return []


def worker(kind: str, *arguments: str, hear: Callable[[str], None]) -> None:
    """Run a worker and pass on its lines; it is ended where it says nothing for too long."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONFAULTHANDLER": ""}
    with tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(
            [*program(kind), *arguments],
            stdout=subprocess.PIPE, stderr=errors, text=True, env=environment,
        )  # fmt: skip
        lines: queue.Queue[str | None] = queue.Queue()

        def listen() -> None:
            for line in process.stdout or ():
                lines.put(line.rstrip("\n"))
            lines.put(None)

        threading.Thread(target=listen, daemon=True).start()
        while True:
            try:
                line = lines.get(timeout=LONGEST_WAIT)
            except queue.Empty:
                process.kill()
                hear("silent")
                break
            if line is None:
                break
            hear(line)
        if process.wait():
            errors.seek(0)
            hear(f"ended {process.returncode} {' '.join(errors.read()[-300:].split())}")


@dataclass
class Tried:
    """What came of some inputs of a kind: what each one did, its number and its time, s, and what failed."""

    done: list[tuple[str, int, float]] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)


def batch(kinds: list[str], seed: int, start: int, end: int) -> dict[str, Tried]:
    """The inputs `start` to `end` of each kind, with a new worker behind each input that ends one."""
    found = {kind: Tried() for kind in kinds}
    left, at = list(kinds), start
    while left:
        kind, begun = left[0], at - 1
        ended = False

        def hear(line: str) -> None:
            nonlocal kind, begun, ended
            what, _, rest = line.partition(" ")
            failures = found[kind].failures
            if what == "kind":
                begun = begun if rest == kind else start - 1
                kind = rest
            elif what == "begin":
                begun = int(rest)
            elif what in ("refused", "ran"):
                number, spent = rest.split()
                found[kind].done.append((what, int(number), float(spent)))
            elif what == "fault":
                number, sort, text = rest.split(" ", 2)
                failures.append(Failure(int(number), sort, text))
            elif what == "done":
                ended = True
            elif not failures or failures[-1].number != begun:
                failures.append(Failure(max(begun, start), "hang" if what == "silent" else "crash", rest))

        others = [str(start)] if len(left) > 1 else []
        worker(",".join(left), str(seed), str(at), str(end), *others, hear=hear)
        # A worker in C has one kind, and does not name it.
        after = max(begun, start if kind != left[0] else at) + 1
        left = [] if ended else left[left.index(kind) + (after >= end) :]
        at = start if after >= end else after
    return found


def signature(failure: Failure) -> str:
    """What failures share that read alike but for their numbers and names."""
    return f"{failure.kind} {re.sub(r'`[^`]*`|[-0-9.e+]+', '', failure.text)[:100]}"


def fuzz(kinds: list[str], seed: int, inputs: int, threads: int, folder: Path | None) -> list[Report]:
    """Try all inputs of some kinds, by one worker after the other or by several at once."""
    ranges = [(start, min(start + BATCH, inputs)) for start in range(0, inputs, BATCH)]
    with ThreadPoolExecutor(threads) as pool:
        parts = list(pool.map(lambda r: batch(kinds, seed, *r), ranges))
    return [told(kind, seed, inputs, [part[kind] for part in parts], folder) for kind in kinds]


def told(kind: str, seed: int, inputs: int, parts: list[Tried], folder: Path | None) -> Report:
    """What came of all inputs of a kind; failures that read alike are told once."""
    report = Report(kind, seed, inputs)
    found = [failure for part in parts for failure in part.failures]
    for what, number, spent in (entry for part in parts for entry in part.done):
        setattr(report, what, getattr(report, what) + 1)
        if spent > report.slowest:
            report.slowest, report.slowest_number = spent, number
    groups: dict[str, list[Failure]] = collections.defaultdict(list)
    for failure in sorted(found, key=lambda f: f.number):
        groups[signature(failure)].append(failure)
    for group in groups.values():
        first = group[0]
        file = keep(kind, seed, first, folder) if folder and kind != "controller" else None
        report.failures.append(
            {"class": first.kind, "text": first.text, "count": len(group), "number": first.number, "file": file}
        )
    return report


def keep(kind: str, seed: int, failure: Failure, folder: Path) -> str:
    """Write the input that failed, made as small as it gets, into `folder`."""
    from exercise import content

    lines = content(kind, seed, failure.number).split("\n")
    wanted, began = signature(failure), time.monotonic()
    size = max(len(lines) // 2, 1)
    while size and time.monotonic() - began < SHRINKING:
        at = 0
        while at < len(lines) and time.monotonic() - began < SHRINKING:
            rest = lines[:at] + lines[at + size :]
            if tried(kind, "\n".join(rest)) == wanted:
                lines = rest
            else:
                at += size
        size //= 2
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{kind}-{failure.number}.{'csv' if kind == 'log' else 'toml'}"
    path.write_bytes("\n".join(lines).encode(errors="surrogateescape"))
    return str(path)


def tried(kind: str, text: str) -> str | None:
    """The signature of what a text does in a worker, if it fails."""
    failures: list[Failure] = []

    def hear(line: str) -> None:
        what, _, rest = line.partition(" ")
        if what == "fault":
            _, sort, words = rest.split(" ", 2)
            failures.append(Failure(0, sort, words))
        elif what in ("silent", "ended") and not failures:
            failures.append(Failure(0, "hang" if what == "silent" else "crash", rest))

    with tempfile.NamedTemporaryFile(suffix=".txt", delete=False) as file:
        file.write(text.encode(errors="surrogateescape"))
    try:
        worker(kind, "--file", file.name, hear=hear)
    finally:
        os.unlink(file.name)
    return signature(failures[0]) if failures else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--inputs", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--failures", type=Path)
    parser.add_argument("--output", type=Path)
    given = parser.parse_args()
    kinds = [kind for kind in given.kinds.split(",") if program(kind)]
    inputs = given.inputs // len(kinds)
    apart = [[kind] for kind in kinds if inputs > FEW or kind == "controller"]
    together = [kind for kind in kinds if [kind] not in apart]
    sets = [*([together] if together else []), *apart]
    reports = [r for some in sets for r in fuzz(some, given.seed, inputs, given.threads, given.failures)]
    for report in reports:
        print(
            f"{report.kind}: {report.inputs} inputs, {report.refused} refused, {report.ran} ran,"
            f" slowest {1e3 * report.slowest:.0f} ms (number {report.slowest_number})"
        )
        for failure in report.failures:
            print("  {count} x {class}: {text} (number {number}, {file})".format(**failure))
    if given.output:
        given.output.write_text("".join(json.dumps(asdict(report)) + "\n" for report in reports), encoding="utf-8")
    sys.exit(int(any(report.failures for report in reports)))


if __name__ == "__main__":
    main()
