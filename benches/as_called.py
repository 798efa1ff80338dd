"""What a call takes in all, as a user makes it: reading files, building the model, the run, labels, charts.

    python benches/as_called.py                   # this checkout alone
    python benches/as_called.py --other ../before # paired with another checkout, built like this one
    python benches/as_called.py --keep            # also into results.json, from where the page takes it

The core alone is measured beside it: the laws and a batch of cranes, called from Python.

CPU time of the whole process. A round measures each checkout in processes of its own, one right after the other; a
figure is the least of the rounds, since what else a computer does only ever adds to it, and a ratio the median of their
pairs. Build both for release (``make .venv/.built``).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).with_name("results.json")
sys.path.insert(0, str(ROOT))

from benches.computer import commit_of, processor  # noqa: E402
from benches.tables import digits, table  # noqa: E402

# Cranes of each kind, and a drive through whose states they go: in the plane, with a pump and mobile valves, in space.
DRIVEN = {
    "rottne-f9-lab": "vertical-lift-open-loop",
    "rottne-f9-mobile": "vertical-lift-open-loop",
    "rottne-f9-forwarder": "forwarder-swing",
}
# What is called in one process, each so often that its median counts.
CALLS = {
    'hc.load_machine("rottne-f9-lab")': 100,
    'hc.load_scenario("vertical-lift-open-loop")': 100,
    'hc.simulate("vertical-lift-open-loop")': 100,
    'hc.simulate("vertical-lift-open-loop").data': 100,
    'hc.simulate("vertical-lift-open-loop", machine="rottne-f9-mobile")': 30,
    'hc.simulate("forwarder-swing")': 30,
    'hc.simulate("tip-vertical-line")': 30,
    'hc.simulate("tip-vertical-line").data': 30,
    **{f'cranes["{machine}"].rates()': 100 for machine in DRIVEN},
    **{f'cranes["{machine}"].jacobians()': 30 for machine in DRIVEN},
    **{f'cranes["{machine}"].second()': 10 for machine in DRIVEN},
}
# A thousand states of a crane as a run goes through them, and a thousand cranes that are driven for a second from them.
IN_ONE_PROCESS = """
import json, statistics, sys, time
import numpy as np
import hydrocrane as hc
class Cranes:
    def __init__(self, machine, scenario):
        crane = hc.load_machine(machine)
        run = hc.simulate(scenario, machine=crane).data
        states = np.ascontiguousarray(np.stack([run[name].values for name in crane.state_names], axis=1))
        rng = np.random.default_rng(0)
        self.core, self.states = crane.core, states[rng.integers(0, len(states), 1000)]
        self.commands = rng.uniform(-0.5, 0.5, (1000, len(crane.cylinder_names))) * crane.spool_strokes
        self.batch = hc.BatchSimulator(crane, 1000, sample_time=0.01, threads=1)
    def rates(self):
        self.core.state_derivative(self.states, self.commands, 0.0)
    def jacobians(self):
        self.core.jacobian(self.states, self.commands, 0.0)
    def second(self):
        self.batch.reset(state=self.states)
        for _ in range(100):
            self.batch.step(self.commands)
cranes = {machine: Cranes(machine, scenario) for machine, scenario in json.loads(sys.argv[2]).items()}
found = {}
for call, count in json.loads(sys.argv[1]).items():
    code = compile(call, call, "eval")
    eval(code)
    times = []
    for _ in range(count):
        began = time.process_time()
        eval(code)
        times.append(time.process_time() - began)
    found[call] = statistics.median(times)
print(json.dumps(found))
"""
# What the page calls those that no user calls.
IN_WORDS = {
    "rates": "right-hand side at 1000 states, by `core.state_derivative`",
    "jacobians": "dense Jacobian at 1000 states, by `core.jacobian`",
    "second": "a second of 1000 cranes, by `hc.BatchSimulator` on one thread",
}
COMMAND = "from hydrocrane.app.cli import main; main()"
# Dask belongs to no plain installation, and xarray imports it wherever it is there.
PLAIN = 'import sys; sys.modules["dask"] = None; '
PROCESSES = {
    "import hydrocrane": "import hydrocrane",
    "hydrocrane simulate --film none": PLAIN + COMMAND,
    "hydrocrane simulate --film none, Dask installed": COMMAND,
}


def cpu_of_process(checkout: Path, code: str, *arguments: str) -> tuple[float, str]:
    """CPU time (s) of a process that runs `code` with the package of a checkout, and what it printed."""
    before = os.times()
    environment = {**os.environ, "PYTHONPATH": str(checkout / "python")}
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], env=environment, check=True, capture_output=True, text=True
    )
    after = os.times()
    used = after.children_user - before.children_user + after.children_system - before.children_system
    return used, done.stdout


def measured(checkout: Path) -> dict[str, float]:
    """Every figure of a checkout once, s."""
    found: dict[str, float] = json.loads(
        cpu_of_process(checkout, IN_ONE_PROCESS, json.dumps(CALLS), json.dumps(DRIVEN))[1]
    )
    for name, code in PROCESSES.items():
        with tempfile.TemporaryDirectory() as folder:
            arguments = ["simulate", "vertical-lift-open-loop", "--film", "none", "--output", folder]
            found[name] = cpu_of_process(checkout, code, *arguments)[0]
    return found


def rounds(checkouts: list[Path], count: int) -> list[list[dict[str, float]]]:
    """Per round the figures of each checkout."""
    # The first one fills the caches of the system.
    for checkout in checkouts:
        cpu_of_process(checkout, COMMAND, "machines")
    return [[measured(checkout) for checkout in checkouts] for _ in range(count)]


def summary(found: list[list[dict[str, float]]]) -> dict[str, dict[str, float]]:
    """The least of each figure, s; of two checkouts also the median ratio of the pairs, the other's to this one's."""
    figures = {}
    for name in found[0][0]:
        ours = [pair[0][name] for pair in found]
        figures[name] = {"seconds": min(ours)}
        if len(found[0]) > 1:
            theirs = [pair[1][name] for pair in found]
            figures[name]["other_seconds"] = min(theirs)
            figures[name]["ratio"] = statistics.median(b / a for a, b in zip(ours, theirs, strict=True))
    return figures


def in_words(name: str) -> str:
    """A figure as the page names it."""
    of_cranes = re.fullmatch(r'cranes\["(.+)"\]\.(\w+)\(\)', name)
    return f"`{of_cranes[1]}`, {IN_WORDS[of_cranes[2]]}" if of_cranes else f"`{name}`"


def printed(figures: dict[str, dict[str, float]]) -> str:
    heads = ["what", "CPU time [ms]", "before [ms]", "before to now"]
    rows = []
    for name, figure in figures.items():
        cells = [in_words(name), digits(figure["seconds"] * 1e3)]
        if "ratio" in figure:
            cells += [digits(figure["other_seconds"] * 1e3), digits(figure["ratio"])]
        rows.append(cells)
    return table(heads[: len(rows[0])], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--other", type=Path, help="another checkout, with its compiled module in place")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--keep", action="store_true", help="write the figures into results.json")
    given = parser.parse_args()
    checkouts = [ROOT, *([given.other.resolve()] if given.other else [])]
    figures = summary(rounds(checkouts, given.rounds))
    print(printed(figures))
    if given.keep:
        results = json.loads(RESULTS.read_text(encoding="utf-8"))
        results["as_called"] = {
            "rounds": given.rounds,
            "processor": processor(),
            "commits": [commit_of(checkout) for checkout in checkouts],
            "figures": figures,
        }
        RESULTS.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
