"""Exported controllers in C have the bits of those on the PC."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from c_controller import Recorder, answered, example, needs_compiler, needs_library
from command_line import run

import hydrocrane as hc
from hydrocrane import benchmark

ROOT = Path(__file__).resolve().parents[3]
TARGET = "thumbv7em-none-eabihf"
C_FILES = ROOT / "python/hydrocrane/export/embedded"


def driven(machine: hc.Machine, name: str, samples: int) -> Recorder:
    """A controller that drives a simulator with sticks back and forth."""
    recorder = Recorder(name, monitor=False)
    plant = hc.Simulator(machine, sample_time=0.01)
    obs = plant.reset(q=machine.home)
    recorder.reset(machine, obs)
    axes = len(machine.cylinder_names) if name == "lever" else 2
    for k in range(samples):
        deflection = np.array([0.5 * np.sin(0.11 * k + i) for i in range(axes)])
        stick = hc.Stick("lever" if name == "lever" else "tip", deflection if k < 0.8 * samples else 0.0 * deflection)
        obs = plant.step(recorder.step(obs, stick))
    assert recorder.inner.fault is None
    return recorder


@needs_compiler
@needs_library
@pytest.mark.parametrize(
    ("machine", "name"),
    [
        ("rottne-f9-lab", "tip"),
        ("single-cylinder", "lever"),
        pytest.param("rottne-f9-lab", "heinze-pid", marks=pytest.mark.evidence),
        pytest.param("rottne-f9-mobile", "tip", marks=pytest.mark.evidence),
        pytest.param("hiab-xs031", "tip", marks=pytest.mark.evidence),
    ],
)
def test_the_compiled_example_gives_the_bits_of_the_named_controller(machine, name, tmp_path):
    crane = hc.load_machine(machine)
    recorder = driven(crane, name, 150)
    statuses, commands = answered(example(crane, name, tmp_path), recorder.samples)
    assert set(statuses) == {0}
    assert np.any(commands)
    assert commands.tobytes() == np.array(recorder.commands).tobytes()


@pytest.mark.evidence
@needs_compiler
@needs_library
@pytest.mark.parametrize("case", range(3))
def test_a_benchmark_case_is_repeated_bit_for_bit(case, tmp_path):
    """As the benchmark runs it, with its monitor of the sensors, which lets sound readings pass."""
    crane = hc.load_machine(benchmark.MACHINE)
    recorder = Recorder("tip")
    scenario = benchmark.scenario_of(crane, recorder, benchmark.quick_cases()[case])
    run = hc.simulate(scenario)
    assert run.outcome.completed and not recorder.inner.notices
    statuses, commands = answered(example(crane, "tip", tmp_path), recorder.samples)
    assert set(statuses) == {0} and len(statuses) > 300
    assert commands.tobytes() == np.array(recorder.commands).tobytes()


def test_an_export_is_always_the_same_files(tmp_path):
    one, two = (hc.export_controller("rottne-f9-lab", tmp_path / name) for name in ("one", "two"))
    names = sorted(path.name for path in one.iterdir())
    assert {"README.md", "example.c", "hydrocrane_controller.h", "hydrocrane_parameters.c"} <= set(names)
    assert all((one / name).read_bytes() == (two / name).read_bytes() for name in names)


def test_the_command_line_writes_the_folder(tmp_path):
    done = run("export", "controller", "single-cylinder", "--c", "--controller", "lever", "-o", tmp_path / "c")
    assert done.returncode == 0 and (tmp_path / "c/example.c").is_file()
    parameters = (tmp_path / "c/hydrocrane_parameters.h").read_text()
    assert "#define HYDROCRANE_JOINTS 1\n" in parameters and "HYDROCRANE_LEVERS" in parameters


def test_the_header_says_what_the_library_does():
    """Statuses and functions of the header are those of the Rust code."""
    header = (C_FILES / "hydrocrane_controller.h").read_text()
    status = (ROOT / "crates/embedded/src/status.rs").read_text()
    code = (ROOT / "crates/embedded/src/lib.rs").read_text()
    own = re.findall(r"^    (\d+) (\w+) c\"", status, flags=re.MULTILINE)
    told = re.findall(r"HYDROCRANE_(\w+) = (\d+)", header.split("typedef struct")[0])
    assert [(number, name.lower()) for number, name in own] == [
        (number, name.replace("_", "").lower()) for name, number in told
    ]
    functions = set(re.findall(r"extern \"C\" fn (\w+)", code)) | {"hydrocrane_stop"}
    assert functions == set(re.findall(r"\b(hydrocrane_\w+)\(", header)) and len(functions) == 8
    modes = dict(re.findall(r"const (TIP|LEVERS|HEIGHT): i32 = (\d)", code))
    assert modes == dict(re.findall(r"HYDROCRANE_(TIP|LEVERS|HEIGHT) = (\d)", header))


def target_installed() -> bool:
    """Whether this toolchain compiles for the target, and the tools are there that read what it makes."""
    if not all(map(shutil.which, ("rustc", "cargo", "llvm-objdump", "size"))):
        return False
    command = ["rustc", "--print", "target-libdir", "--target", TARGET]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode == 0 and Path(done.stdout.strip()).is_dir()


@pytest.mark.evidence
@pytest.mark.skipif(not target_installed(), reason=f"rustup target add {TARGET}, and llvm-objdump, are needed")
def test_a_processor_without_an_operating_system_has_room_for_it(monkeypatch):
    """It compiles and links with nothing but the function that stops the valves. No call is recursive or hidden, so
    that the deepest stack can be read from the machine code."""
    monkeypatch.syspath_prepend(str(ROOT))
    from benches.controller_on_target import on_target

    found = on_target(3)
    assert 50_000 < found["code"] < 300_000, found
    assert all(1_000 < size < 120_000 for size in found["stack"].values()), found
