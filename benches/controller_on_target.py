"""``python -m benches.controller_on_target``: time per sample of the controllers in C on this computer; size, memory
and stack for a Cortex-M4F, compiled and not run. Writes ``controller_on_target.json`` and the table of the how-to.

It needs a C compiler, the static library (``make controller``), ``llvm-objdump`` and the Rust target
``thumbv7em-none-eabihf``."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.computer import processor
from benches.stack_of_elf import deepest

ROOT = Path(__file__).parents[1]
RESULTS = Path(__file__).with_name("controller_on_target.json")
PAGE = ROOT / "docs/howto/controller-on-target.md"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
TARGET = "thumbv7em-none-eabihf"
MACHINE = "rottne-f9-lab"
# Controllers, and whether with a monitor of the sensors.
CASES = (("tip", True), ("tip", False), ("heinze-pid", True), ("heinze-pid", False), ("lever", False))
SAMPLES = 1000
FUNCTIONS = ("create", "reset", "step")
ENTRIES = (*FUNCTIONS, "period", "set_point", "notices", "suspects", "sensor_fault", "text")


def samples(machine: hc.Machine, name: str, monitor: bool) -> str:
    """Lines of samples while the controller drives the simulator."""
    plant, controller = hc.Simulator(machine, sample_time=0.01), hc.NamedController(name, machine, monitor=monitor)
    obs = plant.reset(q=machine.home)
    controller.reset(machine, obs)
    lines = []
    for k in range(SAMPLES):
        axes = 0.4 * np.sin(0.02 * k + np.arange(len(machine.cylinder_names) if name == "lever" else 2))
        lines.append(" ".join(float(x).hex() for x in (obs.t, *obs.q, *obs.p.ravel(), *axes)))
        obs = plant.step(controller.step(obs, hc.Stick("lever" if name == "lever" else "tip", axes)))
    return "\n".join(lines) + "\n"


def timed(controller: str, monitor: bool) -> dict[str, float]:
    """Mean and longest time of a sample, us."""
    machine = hc.load_machine(MACHINE)
    with tempfile.TemporaryDirectory() as place:
        folder = hc.export_controller(machine, place, controller=controller, monitor=monitor)
        shutil.copy(Path(__file__).with_suffix(".c"), folder / "bench.c")
        command = ["cc", "-O2", "bench.c", "hydrocrane_parameters.c", "-L.", "-lhydrocrane_controller", "-o", "bench"]
        subprocess.run(command, cwd=folder, check=True)
        lines = samples(machine, controller, monitor)
        done = subprocess.run([str(folder / "bench")], input=lines, capture_output=True, text=True, check=True)
    mean, longest = (1e-3 * float(word) for word in done.stdout.split())
    return {"mean": mean, "longest": longest}


def linked(place: Path, joints: int) -> Path:
    """A program for the target that has all functions of the library and nothing else."""
    build = ["cargo", "build", "--quiet", "--release", "--target", TARGET, "--no-default-features"]
    manifest = ["--manifest-path", str(ROOT / "crates/embedded/Cargo.toml"), "--features", f"joints-{joints}"]
    subprocess.run([*build, *manifest, "--target-dir", str(place)], check=True)
    root = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True).stdout.strip()
    linker = next(Path(root).rglob("rust-lld"))
    library, program = place / TARGET / "release/libhydrocrane_controller.a", place / "controller.elf"
    roots = [word for entry in ENTRIES for word in ("-u", f"hydrocrane_{entry}")]
    options = ["-flavor", "gnu", "-static", "--gc-sections", "-Ttext=0x8000000", "-e", "hydrocrane_step"]
    stop = ["--defsym", "hydrocrane_stop=0x7000001"]
    subprocess.run([str(linker), *options, *roots, *stop, str(library), "-o", str(program)], check=True)
    return program


def on_target(joints: int) -> dict[str, Any]:
    """Size of the code and constants, and stack below each function, bytes."""
    with tempfile.TemporaryDirectory() as place:
        program = linked(Path(place), joints)
        sizes = subprocess.run(["size", str(program)], capture_output=True, text=True, check=True).stdout
        code = int(sizes.splitlines()[1].split()[0])
        return {"code": code, "stack": {name: deepest(program, f"hydrocrane_{name}")[0] for name in FUNCTIONS}}


def table(found: dict[str, Any]) -> str:
    """The table of the page."""
    rows = "".join(
        f"| `{case['controller']}` | {'yes' if case['monitor'] else 'no'} | {case['mean']:.2f} us | "
        f"{case['longest']:.2f} us |\n"
        for case in found["time"]
    )
    target, kilo = found["target"], 1024
    stack = ", ".join(f"`hydrocrane_{name}` {size / kilo:.1f} KiB" for name, size in target["stack"].items())
    return (
        f"{BEGIN}\n| controller | monitor | mean time per sample | slowest sample |\n|---|---|---|---|\n{rows}\n"
        f"One core of {found['processor']}; {found['machine']}, {SAMPLES} samples in motion, the shortest time of each "
        f"in 200 passes. For `{TARGET}` with three joints and all three controllers: {target['code'] / kilo:.0f} KiB "
        f"of code and constants, {target['parameters'] / kilo:.1f} KiB of parameters (`tip` with a monitor), "
        f"{target['memory'] / kilo:.1f} KiB of memory for controller and monitor, and stack at most {stack}. The stack "
        f"was read from the machine code; nothing was run on such a processor.\n{END}"
    )


def main() -> None:
    """Measure and write."""
    block, memory = hc._core.controller_parameters(hc.load_machine(MACHINE).core, "tip", monitor=True, delay=0.0)
    found = {
        "processor": processor(),
        "machine": MACHINE,
        "time": [{"controller": name, "monitor": monitor, **timed(name, monitor)} for name, monitor in CASES],
        "target": {**on_target(3), "parameters": len(block), "memory": memory},
    }
    RESULTS.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    page = PAGE.read_text(encoding="utf-8")
    head, rest = page.split(BEGIN)
    PAGE.write_text(head + table(found) + rest.split(END)[1], encoding="utf-8")
    print(table(found))


if __name__ == "__main__":
    main()
