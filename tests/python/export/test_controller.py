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


def driven(machine: hc.Machine, name: str, samples: int, **settings) -> Recorder:
    """A controller that drives a simulator with sticks back and forth."""
    recorder = Recorder(name, **settings)
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
@pytest.mark.parametrize("monitor", [True, False])
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
def test_the_compiled_example_gives_the_bits_of_the_named_controller(machine, name, monitor, tmp_path):
    crane = hc.load_machine(machine)
    recorder = driven(crane, name, 150, monitor=monitor)
    statuses, commands, told = answered(example(crane, name, tmp_path, monitor=monitor), recorder.samples)
    assert set(statuses) == {0} and not told
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
    statuses, commands, told = answered(example(crane, "tip", tmp_path), recorder.samples)
    assert set(statuses) == {0} and len(statuses) > 300 and not told
    assert commands.tobytes() == np.array(recorder.commands).tobytes()


# Of a line of 0.1 m/s up: drop-outs that are ridden through, an outlier, a position that freezes for a second.
FAULTS = (
    hc.SensorFault("joint.boom.q", "drop-out", 0.8, until=0.83),
    hc.SensorFault("cylinder.lift.p1", "drop-out", 1.2, until=1.25),
    hc.SensorFault("joint.jib.q", "jump", 1.8, size=0.05, until=1.81),
    hc.SensorFault("joint.boom.q", "freeze", 2.4, until=3.5),
)
TOLD = (
    ("joint 0: position gives no reading", "joint 0: position works again"),
    ("joint 0: pressure of the piston side gives no reading", "joint 0: pressure of the piston side works again"),
    ("joint 1: position jumped", "joint 1: position works again"),
    ("joint 0: position is frozen", "the crane stops", "joint 0: position works again", "control restarts"),
)


@needs_compiler
@needs_library
@pytest.mark.parametrize("sensors", ["ideal", pytest.param("data-sheet", marks=pytest.mark.evidence)])
def test_failing_sensors_lead_to_the_same_bits_and_words(sensors, tmp_path):
    """A case of the benchmark in which sensors fail: the crane goes on, stops and restarts as on the PC."""
    crane = hc.load_machine(benchmark.MACHINE)
    recorder = Recorder("tip", delay=0.002)
    scenario = benchmark.scenario_of(crane, recorder, benchmark.quick_cases()[0])
    run = hc.simulate(scenario.changed(sensor_faults=FAULTS, sensors=sensors))
    assert run.outcome.completed
    statuses, commands, told = answered(example(crane, "tip", tmp_path, delay=0.002), recorder.samples)
    assert set(statuses) == {0} and len(statuses) > 300
    assert commands.tobytes() == np.array(recorder.commands).tobytes()
    assert [text.partition(": ")[2] for text in told] == [text for texts in TOLD for text in texts]
    events = [text for text in recorder.inner.notices if "tip stands" not in text]
    assert [text.partition("`")[2].partition("`")[0] for text in events] == [fault.signal for fault in FAULTS] + [""]
    # The monitor did something.
    without = answered(example(crane, "tip", tmp_path / "without", monitor=False), recorder.samples)
    assert 9 in without[0] and without[1].tobytes() != commands.tobytes()


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
    assert "without a monitor" in parameters
    monitored = ("export", "controller", "single-cylinder", "--c", "--monitor", "--delay", "3 ms")
    assert run(*monitored, "-o", tmp_path / "monitored").returncode == 0
    exported = hc.export_controller("single-cylinder", tmp_path / "python", delay=0.003)
    for name in ("hydrocrane_parameters.h", "hydrocrane_parameters.c"):
        assert (exported / name).read_text() == (tmp_path / "monitored" / name).read_text()
    assert "with a monitor" in (exported / "hydrocrane_parameters.h").read_text()
    wrong = run("export", "controller", "single-cylinder", "--delay", "3 kg", "-o", tmp_path / "wrong")
    assert wrong.returncode == 2 and "--delay" in wrong.stderr and not (tmp_path / "wrong").exists()
    hc.export_controller("single-cylinder", tmp_path / "late", delay=0.2)
    changed = [(tmp_path / name / "hydrocrane_parameters.c").read_text() for name in ("python", "late")]
    assert changed[0] != changed[1], "the monitor knows the delay"


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
    assert functions == set(re.findall(r"\b(hydrocrane_\w+)\(", header)) and len(functions) == 10
    modes = dict(re.findall(r"const (TIP|LEVERS|HEIGHT): i32 = (\d)", code))
    assert modes == dict(re.findall(r"HYDROCRANE_(TIP|LEVERS|HEIGHT) = (\d)", header))
    running = (ROOT / "crates/embedded/src/running.rs").read_text()
    bits = [
        sorted(map(int, re.findall(form, text)))
        for form, text in ((r"1 << (\d+)", header), (r"=> 1 << (\d+)", running))
    ]
    assert bits[0] == bits[1] == list(range(13))
    kinds = re.findall(r"Kind::(\w+).* => (\d)", running)
    told = re.findall(r"HYDROCRANE_SENSOR_(\w+) = ([1-6]),?\n", header)
    alike = {"Jump": "Jumped"}
    assert [(alike.get(kind, kind).lower(), number) for kind, number in kinds] == [
        (name.replace("_", "").lower(), number) for name, number in told
    ]


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
    assert 50_000 < found["code"] < 350_000, found
    assert all(1_000 < size < 120_000 for size in found["stack"].values()), found
