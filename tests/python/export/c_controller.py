"""A controller that was exported as C, compiled with the system's compiler: as a program, as a library for ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.export.controller import installed_library

COMPILER = shutil.which("cc")
FLAGS = ("-O2", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler `cc` here")
needs_library = pytest.mark.skipif(
    installed_library() is None, reason="no static library of the controllers here: make controller builds it"
)


def compiled(folder: Path, *options: str) -> None:
    """Runs the compiler in the folder; its warnings are errors."""
    done = subprocess.run([str(COMPILER), *FLAGS, *options], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


class Recorder:
    """A controller by name that notes what it was given and what it answered."""

    def __init__(self, name: str, **settings):
        self.inner = hc.NamedController(name, **settings)
        self.samples: list[list[float]] = []
        self.commands: list[list[float]] = []

    def reset(self, machine, obs):
        self.machine = machine
        self.inner.reset(machine, obs)

    def step(self, obs, command):
        read = {f"joint.{joint}.q": q for joint, q in zip(self.machine.joint_names, obs.q, strict=True)}
        for cylinder, pair in zip(self.machine.cylinder_names, obs.p, strict=True):
            read |= {f"cylinder.{cylinder}.p{side + 1}": pair[side] for side in (0, 1)}
        readings = [float(obs.measured.get(name, value)) for name, value in read.items()]
        self.samples.append([obs.t, *readings, *map(float, command.axes)])
        spool = self.inner.step(obs, command)
        self.commands.append([float(u) for u in spool])
        return spool


def answered(folder: Path, samples: list[list[float]]) -> tuple[list[int], np.ndarray, list[str]]:
    """Statuses and commands of the example in `folder` for these samples, and what it tells the operator."""
    text = "".join(" ".join(value.hex() for value in sample) + "\n" for sample in samples)
    done = subprocess.run([str(folder / "example")], input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines()]
    assert len(rows) == len(samples)
    commands = np.array([[float.fromhex(u) for u in row[1:]] for row in rows])
    return [int(row[0]) for row in rows], commands, done.stderr.splitlines()


def example(machine, name: str, folder: Path, **settings) -> Path:
    """The exported controller with its example compiled."""
    hc.export_controller(machine, folder, controller=name, **settings)
    sources = ("example.c", "hydrocrane_parameters.c")
    compiled(folder, *sources, "-L.", "-lhydrocrane_controller", "-o", "example")
    return folder


class Sample(ctypes.Structure):
    _fields_ = (("t", ctypes.c_double), ("q", ctypes.c_void_p), ("p", ctypes.c_void_p))


def loaded(folder: Path) -> ctypes.CDLL:
    """The static library as one that Python can call."""
    (folder / "stop.c").write_text(
        "#include <stdlib.h>\nvoid hydrocrane_stop(void);\nvoid hydrocrane_stop(void) { abort(); }\n"
    )
    library = installed_library()
    # One function brings the object file of all of them in.
    compiled(folder, "-shared", "-fPIC", "-Wl,-u,hydrocrane_create", "stop.c", str(library), "-o", "controller.so")
    functions = ctypes.CDLL(str(folder / "controller.so"))
    functions.hydrocrane_period.restype = ctypes.c_double
    functions.hydrocrane_text.restype = ctypes.c_char_p
    functions.hydrocrane_create.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t)
    for name in ("reset", "period", "notices", "suspects", "sensor_fault", "set_point", "step"):
        getattr(functions, f"hydrocrane_{name}").argtypes = {
            "reset": (ctypes.c_void_p, ctypes.c_void_p),
            "period": (ctypes.c_void_p,),
            "notices": (ctypes.c_void_p,),
            "suspects": (ctypes.c_void_p,),
            "sensor_fault": (ctypes.c_void_p, ctypes.c_uint32),
            "set_point": (ctypes.c_void_p, ctypes.c_void_p),
            "step": (
                ctypes.c_void_p,
                ctypes.c_void_p,
                ctypes.c_int32,
                ctypes.c_void_p,
                ctypes.c_size_t,
                ctypes.c_void_p,
                ctypes.c_size_t,
            ),
        }[name]
    return functions
