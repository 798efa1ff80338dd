"""CVODE and diffsol on the core's compiled laws: ``benches/solvers``, a Rust library that Python only starts."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

import hydrocrane as hc
from benches.problem import MAX_STEP, NotAvailable, Problem, Solution, Solver, clocked

CRATE = Path(__file__).resolve().parents[1] / "solvers"
ROOM = 1024
CVODE = {"CVODE BDF": "cvode-bdf", "CVODE Adams": "cvode-adams"}
DIFFSOL = {
    "diffsol BDF": "diffsol-bdf",
    "diffsol TR-BDF2": "diffsol-tr-bdf2",
    "diffsol ESDIRK34": "diffsol-esdirk34",
    "diffsol Tsit45": "diffsol-tsit45",
}
DOUBLES = ctypes.POINTER(ctypes.c_double)


class RawTask(ctypes.Structure):
    """The same fields in the same order as ``RawTask`` of the library."""

    _fields_ = (
        ("machine", ctypes.c_char_p),
        ("payload", ctypes.c_double),
        ("states", ctypes.c_size_t),
        ("start", DOUBLES),
        ("sizes", DOUBLES),
        ("max_step", ctypes.c_double),
        ("commands", ctypes.c_size_t),
        ("times", DOUBLES),
        ("spools", DOUBLES),
        ("records", ctypes.c_size_t),
        ("record", DOUBLES),
        ("end", ctypes.c_double),
    )


class Effort(ctypes.Structure):
    _fields_ = (("rhs", ctypes.c_uint64), ("jacobians", ctypes.c_uint64), ("steps", ctypes.c_uint64))


class Message(ctypes.Structure):
    """Room for one text of the library."""

    _fields_ = (("text", ctypes.c_char_p), ("room", ctypes.c_size_t))


def machine_file(crane: hc.Machine, folder: Path) -> str:
    """Where the library finds the machine: by its name, or in a file that says what is changed on it."""
    if not crane.overrides:
        return crane.source
    about = [f'extends = "{crane.source}"', 'machine = { name = "changed", class = "setting", source = "a benchmark" }']
    changes = [f"{key} = {json.dumps(value)}" for key, value in crane.overrides.items()]
    path = folder / "changed.toml"
    path.write_text("\n".join(about + changes), encoding="utf-8")
    return str(path)


@cache
def library() -> ctypes.CDLL:
    """The solvers, built if need be with the settings of the product."""
    if shutil.which("cargo") is None:
        raise NotAvailable("Rust's cargo is not installed")
    manifest = str(CRATE / "Cargo.toml")
    done = subprocess.run(
        ["cargo", "build", "--release", "--locked", "--quiet", "--manifest-path", manifest],
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise NotAvailable(f"its library cannot be built: {last}")
    prefix, suffix = {"win32": ("", "dll"), "darwin": ("lib", "dylib")}.get(sys.platform, ("lib", "so"))
    loaded = ctypes.CDLL(str(CRATE / f"target/release/{prefix}hydrocrane_solvers.{suffix}"))
    loaded.prepare.restype = ctypes.c_void_p
    loaded.solve.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_double] + [ctypes.c_void_p] * 3
    loaded.release.argtypes = [ctypes.c_void_p]
    loaded.evaluate.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_bool]
    loaded.evaluate.restype = None
    return loaded


def sundials() -> str:
    """Where scikit-sundae keeps the shared library of CVODE."""
    spec = importlib.util.find_spec("sksundae")
    if spec is None or spec.origin is None:
        raise NotAvailable("scikit-sundae, which brings SUNDIALS, is not installed")
    home = Path(spec.origin).parents[1]
    found = [
        path for folder in home.glob("scikit_sundae*") for path in folder.rglob("*sundials_cvode*") if path.is_file()
    ]
    if not found:
        raise NotAvailable("scikit-sundae is here without its shared library of CVODE")
    return str(found[0])


class Task:
    """The problem as the library holds it."""

    def __init__(self, problem: Problem) -> None:
        self.library, self.shape = library(), (problem.record.size, problem.start.size)
        self.text = ctypes.create_string_buffer(ROOM)
        self.message = Message(ctypes.cast(self.text, ctypes.c_char_p), ROOM)
        # Alive as long as the raw task that points at them.
        tables = (problem.start, problem.sizes, problem.times, problem.spools, problem.record)
        kept = [np.ascontiguousarray(table, dtype=float) for table in tables]
        start, sizes, times, spools, record = (table.ctypes.data_as(DOUBLES) for table in kept)
        counts = (len(problem.times), times, spools, problem.record.size, record, problem.end)
        with tempfile.TemporaryDirectory() as folder:
            machine = machine_file(problem.crane, Path(folder)).encode()
            raw = RawTask(machine, problem.payload, problem.start.size, start, sizes, MAX_STEP, *counts)
            self.handle = self.library.prepare(ctypes.byref(raw), ctypes.byref(self.message))
        if not self.handle:
            raise NotAvailable(self.text.value.decode())

    def __del__(self) -> None:
        if getattr(self, "handle", None):
            self.library.release(self.handle)

    def solve(self, solver: str, shared: str, rtol: float) -> Solution:
        states, effort = np.full(self.shape, np.nan), Effort()
        given = (self.handle, solver.encode(), shared.encode(), rtol, states.ctypes.data)

        def work() -> np.ndarray:
            failed = self.library.solve(*given, ctypes.byref(effort), ctypes.byref(self.message))
            return np.empty((0, self.shape[1])) if failed else states

        return clocked(work, lambda: {name: getattr(effort, name) for name, _ in Effort._fields_})

    def evaluate(self, states: np.ndarray, structured: bool) -> None:
        """The laws once at each row, with the structured Jacobian or without."""
        self.library.evaluate(self.handle, states.ctypes.data, len(states), structured)


def _solvers(problem: Problem, names: dict[str, str], shared: str) -> dict[str, Solver]:
    task = Task(problem)
    return {name: lambda rtol, key=key: task.solve(key, shared, rtol) for name, key in names.items()}


def cvode(problem: Problem) -> dict[str, Solver]:
    return _solvers(problem, CVODE, sundials())


def diffsol(problem: Problem) -> dict[str, Solver]:
    return _solvers(problem, DIFFSOL, "")
