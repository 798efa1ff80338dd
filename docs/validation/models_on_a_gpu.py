"""The exported model on a GPU: CUDA C by nvcc, and JAX; writes the numbers of models-on-a-gpu.md.

Run with a Python that has hydrocrane and a JAX that sees the GPU, where nvcc is at hand; takes some two minutes.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import marked_page
import numpy as np

import hydrocrane as hc

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parents[1]))

from benches.measures.batch import HOLD, SAMPLE, exact_tips, manoeuvres  # noqa: E402

SOURCE, PAGE = HERE / "models_on_a_gpu.cu", HERE / "models-on-a-gpu.md"
MACHINES = ("rottne-f9-lab", "hiab-xs031", "rottne-f9-mobile")
# Cranes that move, steps of Runge-Kutta, s, and rounds that are timed.
SIZES, STEP, ROUNDS = (1_000, 10_000, 100_000), 1e-3, 5
# Manoeuvres whose errors are measured, and how long all cranes move, s.
CHECKED, MOVED = 50, 1.0
MISSING = "this needs an NVIDIA GPU and nvcc"


def gpu() -> str | None:
    """Name of the GPU; None without one or without nvcc."""
    if not (shutil.which("nvcc") and shutil.which("nvidia-smi")):
        return None
    asked = ["nvidia-smi", "--query-gpu=name", "--format=csv,noheader"]
    told = subprocess.run(asked, capture_output=True, text=True, check=False)
    return told.stdout.splitlines()[0] if told.returncode == 0 and told.stdout else None


def places(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the values of `hydrocrane_sparse_many`, from the exported text."""
    rows, columns = (text.split(f"hydrocrane_{k}s[] = {{")[1].split("}")[0].split(",") for k in ("row", "column"))
    return np.array(rows, int), np.array(columns, int)


class OnGpu:
    """Cranes of one machine on the device, driven like a batch; `fused` lets nvcc fuse products with sums."""

    def __init__(self, crane: hc.Machine, fused: bool = False) -> None:
        self.crane = crane
        with tempfile.TemporaryDirectory() as folder:
            text = hc.export_model(crane, Path(folder) / "crane.cu", to="cuda", parameters=[], outputs=[]).read_text()
            library = Path(folder) / "cranes.so"
            options = ["-O3", "-arch=native", "-shared", "-Xcompiler", "-fPIC", f"--fmad={str(fused).lower()}"]
            began = time.perf_counter()
            subprocess.run(["nvcc", *options, "-I", folder, "-o", str(library), str(SOURCE)], check=True)
            self.compiled = time.perf_counter() - began
            self.core = ctypes.CDLL(str(library))
        self.places = places(text)
        self.cranes = 0

    def begin(self, x: np.ndarray) -> None:
        """Put cranes in these states (cranes, states)."""
        self.cranes = len(x)
        self._call("begin", ctypes.c_int(self.cranes), _rows(x))

    def __call__(self, _: object, u: np.ndarray) -> OnGpu:
        """One sample of 10 ms under these spools (cranes, cylinders)."""
        self._call("step", ctypes.c_int(round(SAMPLE / STEP)), ctypes.c_double(STEP), _rows(u))
        return self

    def evaluate(self, u: np.ndarray) -> None:
        """Derivatives at the states, with all partial ones."""
        self._call("evaluate", _rows(u))

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """States, derivatives (cranes, states) and partial derivatives (cranes, nonzeros)."""
        n = len(self.crane.state_names)
        found = [np.empty((rows, self.cranes)) for rows in (n, n, len(self.places[0]))]
        self._call("read", *(array.ctypes.data_as(ctypes.c_void_p) for array in found))
        return tuple(array.T for array in found)

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        return np.ascontiguousarray(self.read()[0])

    def _call(self, name: str, *arguments: object) -> None:
        if error := getattr(self.core, name)(*arguments):
            raise RuntimeError(f"{name} ended with CUDA's error {error}")


def _rows(numbers: np.ndarray) -> ctypes.c_void_p:
    """Number i of crane k at [i * cranes + k]."""
    return np.ascontiguousarray(np.asarray(numbers, float).T).ctypes.data_as(ctypes.c_void_p)


def seconds(work: Callable[[], object]) -> float:
    """Median wall time of ROUNDS calls after a first one."""
    work()
    took = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        work()
        took.append(time.perf_counter() - began)
    return median(took)


def differences() -> list[str]:
    """A row for each machine: how far the kernels are from the core."""
    lines = []
    for name in MACHINES:
        crane = hc.load_machine(name)
        start, commands = manoeuvres(crane, CHECKED)
        cranes = OnGpu(crane)
        cranes.begin(start)
        cranes.evaluate(commands[0])
        _, dx, values = cranes.read()
        exact, jacobian = crane.state_derivative(start, commands[0]), crane.jacobian(start, commands[0])
        scale = np.abs(exact).max(axis=0)
        off = np.abs(dx - exact) / np.where(scale > 0, scale, 1.0)
        steep = np.abs(jacobian).max(axis=-1)[:, cranes.places[0]]
        apart = np.abs(values - jacobian[:, *cranes.places]) / np.where(steep > 0, steep, 1.0)
        lines.append(f"| `{name}` | {off.max():.1e} | {apart.max():.1e} | {cranes.compiled:.0f} |")
    return lines


def moved() -> list[str]:
    """A row for each way to step cranes and each number of them."""
    import exported_models
    import jax

    crane = exported_models.CRANE
    start, commands = manoeuvres(crane, CHECKED)
    exact, commands = exact_tips(crane, start, commands[: round(MOVED / HOLD)]), commands[: round(MOVED / HOLD)]
    own = OnGpu(crane, fused=True)
    ways = {"CUDA C, steps of 1 ms": own, "JAX, steps of 1 ms": exported_models.many(STEP)}
    lines = []
    for name, way in ways.items():
        own.begin(start)
        errors = exported_models.off_their_paths(exported_models.path(way, start, commands), exact)
        for count in SIZES:
            pick = np.arange(count) % CHECKED
            held = [np.ascontiguousarray(spools[pick]) for spools in commands]

            def run(way=way, pick=pick, held=held) -> None:
                own.begin(start[pick])
                x = jax.numpy.array(start[pick])
                for spools in held:
                    for _ in range(round(HOLD / SAMPLE)):
                        x = way(x, spools)
                if way is not own:
                    jax.block_until_ready(x)

            took = seconds(run)
            figures = [f"{1e3 * np.max(errors):.2g}", f"{1e6 * np.median(errors):.2g}", f"{count * MOVED / took:,.0f}"]
            lines.append(" | ".join([f"| {name}", f"{count:,}", *figures]) + " |")
    return lines


def numbers(name: str) -> list[str]:
    return [
        f"Measured on {name}.",
        "",
        "## Kernels against the core",
        "",
        "| machine | derivatives, relative difference | partial derivatives | nvcc, s |",
        "|" + "---|" * 4,
        *differences(),
        "",
        "## Moving cranes",
        "",
        f"`rottne-f9-lab` for {MOVED:g} s.",
        "",
        "| | cranes | worst tip error, mm | median, um | crane-seconds a second |",
        "|" + "---|" * 5,
        *moved(),
    ]


def main() -> None:
    name = gpu()
    if name is None:
        sys.exit(MISSING)
    marked_page.write(PAGE, numbers(name))


if __name__ == "__main__":
    main()
