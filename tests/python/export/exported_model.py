"""Exported models under test: machines, states and the C file as a library."""

from __future__ import annotations

import ctypes
import importlib.util
import shutil
import subprocess
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import hydrocrane as hc

COMPILER = shutil.which("cc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler here")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
STATES = 200


def exportable(name: str) -> hc.Machine:
    """A bundled machine; that of the thesis's program without the friction that jumps."""
    return hc.load_machine(name, {"errata.friction-map": "corrected"} if name == "heinze-2007" else None)


def off(crane: hc.Machine, found: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference of derivatives, relative to the largest of its row, for changes of usual size."""
    sizes = {"Pa": 1e6, "rad": 0.1, "rad/s": 0.1, "m": 0.01, "m/s": 0.1, "1": 0.1}
    scale = np.array([sizes[unit] for unit in crane.core.state_units])
    largest = (np.abs(expected) * scale).max(axis=-1, keepdims=True)
    return float((np.abs(found - expected) * scale / np.maximum(largest, 1e-300)).max())


def agrees(dx: np.ndarray, expected: np.ndarray) -> bool:
    """Whether rates are the same to rounding."""
    return bool((np.abs(dx - expected) <= 1e-12 * np.abs(expected) + 1e-13 * np.abs(expected).max(axis=0)).all())


def module(file: Path) -> ModuleType:
    """A file of Python, imported without hydrocrane's help."""
    assert "import hydrocrane" not in file.read_text()
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None and spec.loader is not None
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


class CModel:
    """The functions of an exported C file."""

    def __init__(self, file: Path, *options: str) -> None:
        library = file.with_suffix(f".{len(options)}.so")
        command = [str(COMPILER), *STRICT, "-O2", "-shared", "-fPIC", *options, str(file), "-o", str(library), "-lm"]
        subprocess.run(command, check=True)
        self.library = ctypes.CDLL(str(library))

    def call(self, name: str, x: np.ndarray, u: np.ndarray, p: np.ndarray | None, *sizes: int) -> list[np.ndarray]:
        """The results of a function for rows of states and commands."""
        out = [np.full((len(x), size), np.nan) for size in sizes]
        for k in range(len(x)):
            arrays = [np.ascontiguousarray(x[k]), np.ascontiguousarray(u[k]), p, *(y[k] for y in out)]
            pointers = [None if a is None else a.ctypes.data_as(ctypes.c_void_p) for a in arrays]
            assert getattr(self.library, name)(*pointers) == 0
        return out

    def texts(self, name: str, count: int) -> list[str]:
        return [entry.decode() for entry in (ctypes.c_char_p * count).in_dll(self.library, name)]

    def integers(self, name: str, count: int) -> np.ndarray:
        return np.array((ctypes.c_int * count).in_dll(self.library, name))
