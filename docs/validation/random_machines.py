"""Random machines, judged: laws, solver and derived numbers on chains and circuits that nobody tuned for.

    python docs/validation/random_machines.py --seeds 0:300 --page
    python docs/validation/random_machines.py --seeds 0:40 --only accuracy

`--page` writes docs/validation/random-machines.md. Without it the findings are printed, failures first; fails where a
check fails.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np
from machine_generator import machine

import hydrocrane as hc
from hydrocrane.analysis.capacity import capacity

ROOT = Path(__file__).resolve().parents[2]
TIGHT = hc.Solver(method="rodas5p", rtol=1e-9)
SECONDS = 4.0
# Errors of the default run, m and share of the supply pressure; pressures count outside of 20 ms about a kink.
TIP, PRESSURE, WINDOW = 3e-3, 0.03, 0.02
# A drive that a start this far away, rad or m, moves by more than the error cannot be told by any solver.
NUDGE = 1e-6
# Share of the energy that flowed by which a ledger may be open; errors of the Jacobian and of the readable right-hand side.
LEDGER, JACOBIAN, READABLE = 0.01, 1e-5, 1e-10
# Time, s, in which a crane at rest is watched, and what its tip may move, mm: leakage of a thousandth of the flow.
REST, MOVED = 2.0, 20.0
# Time under tip control, s, and words of a monitor that stops or rides through.
CONTROLLED = 8.0
ALARMS = ("no other reading confirms", "gives no reading", "is frozen", "is out of range")
# Warnings that say of a run that its figures are not those of the machine.
SAYS = {"step-inexact", "step-too-long", "not-converged", "energy-ledger-open"}


@dataclass(frozen=True)
class Finding:
    """What a check came to: its figure in the unit of the check, and a word where it fails or does not apply."""

    seed: int
    check: str
    holds: bool
    figure: float = np.nan
    text: str = ""


class Case:
    """A machine with a seed, and what several checks share."""

    def __init__(self, seed: int, crane: hc.Machine, rated: float, folder: Path) -> None:
        self.seed, self.crane, self.folder = seed, crane, folder
        self.rng = np.random.default_rng([37, seed])
        self.payload = float(self.rng.choice([0.0, 0.5, 1.0])) * rated
        self.drive = self._drive()

    def draws_for(self, check: str) -> None:
        """Random numbers that do not depend on the checks before."""
        self.rng = np.random.default_rng([38, self.seed, list(CHECKS).index(check)])

    def start(self, q: np.ndarray | None = None) -> dict[str, float]:
        return dict(zip(self.crane.joint_names, self.crane.home if q is None else q, strict=True))

    def _drive(self) -> hc.Scenario:
        """Steps and ramps to full spool on every section, each held for 0.2 to 1.5 s."""
        commands = {}
        kind = str(self.rng.choice(["hold", "linear"]))
        for name, stroke in zip(self.crane.cylinder_names, self.crane.spool_strokes, strict=True):
            times = np.cumsum(self.rng.uniform(0.2, 1.5, 30))
            times = times[times < SECONDS]
            values = stroke * self.rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0], len(times))
            commands[name] = hc.Command(np.r_[0.0, times], np.r_[0.0, values], kind)
        return hc.Scenario(
            machine=self.crane, joints=self.start(), payload=self.payload, commands=commands, duration=SECONDS
        )

    @cached_property
    def driven(self) -> hc.Run:
        return hc.simulate(self.drive)

    def pressures(self, run: hc.Run) -> np.ndarray:
        return np.array(
            [run.columns[f"cylinder.{c}.p{side}"].values for c in self.crane.cylinder_names for side in (1, 2)]
        )

    def finding(self, check: str, holds: bool, figure: float = np.nan, text: str = "") -> Finding:
        return Finding(self.seed, check, bool(holds), float(figure), text)


def times_of(run: hc.Run) -> np.ndarray:
    return run.columns["time"].values


def tips(run: hc.Run) -> np.ndarray:
    return np.array([run.columns[f"tip.{axis}"].values for axis in "xz"])


def kinds(run: hc.Run) -> set[str]:
    return {warning.kind for warning in run.warnings} - {"implausible-value"}


def accuracy(case: Case) -> Finding:
    """Default run against a tight one: the tip, and pressures outside of 20 ms about a kink; mm."""
    run = case.driven
    exact = hc.simulate(case.drive.changed(solver=TIGHT))
    count = min(len(times_of(run)), len(times_of(exact)))
    if exact.outcome.kind != run.outcome.kind or abs(len(times_of(run)) - len(times_of(exact))) > 1:
        return case.finding(
            "accuracy",
            False,
            text=f"ends otherwise: {run.outcome.kind}, tight {exact.outcome.kind} ({exact.outcome.message})",
        )
    tip = np.hypot(*(tips(run)[:, :count] - tips(exact)[:, :count])).max()
    pressure = beyond_window(
        case.pressures(run)[:, :count], case.pressures(exact)[:, :count], case.drive.record_interval
    )
    pressure /= case.crane.supply_pressure
    said = kinds(run) & SAYS
    good = tip <= TIP and pressure <= PRESSURE
    text = f"tip {1e3 * tip:.3g} mm, pressure {100 * pressure:.2g} % of supply, {run.outcome.kind} by {run.data.attrs['solver_method']}"
    if not good and not said:
        moved = sensitivity(case, tips(exact)[:, :count], count)
        if moved > tip:
            return case.finding(
                "accuracy", True, 1e3 * tip, f"{text}; a start 1 um away moves the tip by {1e3 * moved:.3g} mm"
            )
    return case.finding("accuracy", good or bool(said), 1e3 * tip, "; ".join([text, *sorted(kinds(run))]))


def beyond_window(run: np.ndarray, exact: np.ndarray, interval: float) -> float:
    """Largest distance of `run` from all that `exact` was within `WINDOW` about the same time, Pa."""
    half = round(WINDOW / interval)
    padded = np.pad(exact, [(0, 0), (half, half)], mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=1)
    return float(np.maximum(run - around.max(axis=2), around.min(axis=2) - run).max())


def sensitivity(case: Case, exact: np.ndarray, count: int) -> float:
    """How far the tip of the tight run moves if the start moves by `NUDGE`, the largest over the joints, m."""
    moved = 0.0
    for i in range(len(case.crane.joint_names)):
        q = case.crane.home.copy()
        q[i] += NUDGE
        run = hc.simulate(case.drive.changed(solver=TIGHT, joints=case.start(q)))
        moved = max(moved, np.hypot(*(tips(run)[:, :count] - exact[:, : len(times_of(run))])).max())
    return float(moved)


def ledger(case: Case) -> Finding:
    """Stored energy against what the ledger brought, share of what flowed; %."""
    columns = case.driven.columns
    energy = sum(columns[name].values for name in columns if name.startswith("energy."))
    terms = [columns[name] for name in columns if name.startswith("ledger.")]
    brought = sum(term.attrs["sign"] * term.values for term in terms)
    flowed = 0.5 * sum(np.abs(np.diff(term.values)).sum() for term in terms) + np.ptp(energy)
    share = np.abs(energy - energy[0] - brought).max() / max(flowed, 1.0)
    return case.finding("ledger", share < LEDGER or bool(kinds(case.driven) & SAYS), 100 * share)


def states(case: Case, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States (count, ns) near those of the drive, commands, and the scale of each state."""
    columns = case.driven.columns
    table = np.array([columns[name].values for name in case.crane.state_names]).T
    kind = [name.rsplit(".", 1)[1] for name in case.crane.state_names]
    least = np.array([{"p1": 1e5, "p2": 1e5, "p": 1e5}.get(k, 1e-4) for k in kind])
    scale = np.maximum(table.std(axis=0), least)
    picked = table[case.rng.integers(len(table), size=count)]
    commands = case.rng.uniform(-1, 1, (count, len(case.crane.cylinder_names))) * case.crane.spool_strokes
    near = picked + 1e-2 * scale * case.rng.normal(size=picked.shape)
    # Openings lie between closed and open.
    opens = [k in ("compensator", "displacement") for k in kind]
    near[:, opens] = np.clip(near[:, opens], 0.0, 1.0)
    return near, commands, scale


def jacobian(case: Case) -> Finding:
    """The exact Jacobian against differences, relative to the largest entry of its row; where there is a corner, between both sides."""
    x, u, scale = states(case, 40)
    rates = lambda state: case.crane.state_derivative(state, u[:, None], payload=case.payload)  # noqa: E731
    exact = case.crane.jacobian(x, u, payload=case.payload) * scale
    largest = np.abs(exact).max(axis=-1, keepdims=True)
    worst = np.full(exact.shape, np.inf)
    for step in (1e-5, 1e-6, 1e-7):
        moves = np.diag(scale) * step
        middle = rates(x[:, None])
        sides = [np.swapaxes(sign * (rates(x[:, None] + sign * moves) - middle) / step, -1, -2) for sign in (-1, 1)]
        low, high = np.minimum(*sides), np.maximum(*sides)
        outside = np.maximum(np.maximum(low - exact, exact - high), 0.0)
        worst = np.minimum(worst, outside / np.where(largest > 0, largest, 1.0))
    at = np.unravel_index(np.argmax(worst), worst.shape)
    names = case.crane.state_names
    return case.finding("jacobian", worst.max() < JACOBIAN, worst.max(), f"rate of {names[at[1]]} by {names[at[2]]}")


def readable(case: Case) -> Finding:
    """The readable right-hand side against the fast one, relative to the component or its usual size."""
    x, u, _ = states(case, 200)
    ours = case.crane.state_derivative(x, u, payload=case.payload)
    theirs = case.crane.reference_state_derivative(x, u, payload=case.payload)
    scale = np.abs(theirs) + np.median(np.abs(theirs), axis=0)
    error = np.abs(ours - theirs) / np.where(scale > 0, scale, 1.0)
    worst = np.unravel_index(np.argmax(error), error.shape)
    return case.finding("readable", error.max() < READABLE, error.max(), f"rate of {case.crane.state_names[worst[1]]}")


def sinks(case: Case, q: np.ndarray, payload: float) -> tuple[float, set[str]]:
    """How far the tip moves with all spools centred from rest, mm, and what the run warns of."""
    run = hc.simulate(hc.Scenario(machine=case.crane, joints=case.start(q), payload=payload, duration=REST))
    return float(1e3 * np.hypot(*(tips(run) - tips(run)[:, :1])).max()), kinds(run)


def equilibrium(case: Case) -> Finding:
    """A crane at rest stays, or its run says that it does not; mm in `REST`."""
    low, high = case.crane.joint_limits.T
    q = low + (high - low) * case.rng.uniform(0.1, 0.9, len(low))
    moved, said = sinks(case, q, case.payload)
    return case.finding("equilibrium", moved < MOVED or bool(said), moved, ", ".join(sorted(said)))


def chart(case: Case) -> Finding:
    """A load that the load chart allows is held, or the run says that it is not; mm in `REST`."""
    found = hc.load_chart(case.crane, samples=5)
    payload, poses = found.payload.ravel(), found.q.reshape(-1, len(case.crane.joint_names))
    low, high = case.crane.joint_limits.T
    inside = (np.abs(2 * poses - low - high) < 0.8 * (high - low)).all(axis=1)
    held = np.flatnonzero(inside & np.isfinite(payload) & (payload > 0) & (payload < found.ceiling))
    if not held.size:
        return case.finding("chart", True, text="holds nothing in any pose of the grid")
    chosen = case.rng.choice(held)
    moved, said = sinks(case, poses[chosen], 0.95 * payload[chosen])
    return case.finding("chart", moved < MOVED or bool(said), moved, ", ".join(sorted(said)))


def tip_control(case: Case) -> Finding:
    """Tip control under its monitor with a random stick: no alarm on sensors that are all right; mm off the path."""
    times = np.arange(0.5, CONTROLLED - 1.0, 1.0)
    x, z = case.rng.uniform(-1, 1, (2, len(times)))
    stick = hc.Joystick([*times, CONTROLLED - 1.0], {"x": [*x, 0.0], "z": [*z, 0.0]})
    plan = hc.Scenario(
        machine=case.crane,
        joints=case.start(),
        payload=case.payload,
        controller="tip",
        joystick=stick,
        duration=CONTROLLED,
    )
    try:
        run = hc.simulate(plan)
    except hc.InputError as refused:
        return case.finding("tip", True, text=f"refused: {refused}")
    alarms = [event.text for event in run.events if any(word in event.text for word in ALARMS)]
    deviation = 1e3 * np.nanmax(np.abs(run.columns["tip.deviation"].values), initial=0.0)
    good = not alarms and run.outcome.kind == "completed"
    return case.finding(
        "tip", good, deviation, "; ".join([*alarms[:1], *([] if good else [run.outcome.kind, run.outcome.message])])
    )


def fmu(case: Case) -> Finding:
    """An exported FMU steps as the simulator does; the largest difference of a state, relative."""
    sys.path.append(str(ROOT / "tests/python/export"))
    from fmu_in_fmpy import STEP, Unit, inputs

    plan = case.drive.changed(commands={})
    unit = Unit(hc.export_fmu(plan, case.folder / f"{case.seed}.fmu"), case.folder / f"fmu-{case.seed}").begin()
    native = hc.Simulator(case.crane, STEP, payload=case.payload)
    native.reset(q=case.crane.home)
    apart = 0.0
    for i in range(200):
        u = np.array([case.drive.commands[name].at(np.array([20 * i * STEP]))[0] for name in case.crane.cylinder_names])
        unit.set(dict(zip(inputs(case.crane), u, strict=True)))
        native.step(u)
        unit.step(i * STEP)
        theirs = unit.get(case.crane.state_names)
        apart = max(apart, float((np.abs(theirs - native.state) / np.maximum(np.abs(native.state), 1e-9)).max()))
    unit.close()
    return case.finding("fmu", apart == 0.0, apart)


CHECKS: dict[str, Callable[[Case], Finding]] = {
    "accuracy": accuracy, "ledger": ledger, "jacobian": jacobian, "readable": readable, "equilibrium": equilibrium,
    "chart": chart, "tip": tip_control, "fmu": fmu,
}  # fmt: skip


def random_case(seed: int, folder: Path) -> Case:
    drawn = machine(seed)
    return Case(seed, drawn.load(folder), drawn.rated, folder)


def bundled_case(name: str, seed: int, folder: Path) -> Case:
    """A bundled machine; its rated load is 60 % of what it holds in the middle of its ranges."""
    crane = hc.load_machine(name)
    most, _ = capacity(crane, crane.home, 1e5)
    return Case(seed, crane, 0.6 * float(np.nan_to_num(most)) * (most < 1e5), folder)


def judged(
    seeds: Iterable[int], checks: Iterable[str], drawn: Callable[[int], Case], progress: bool = False
) -> list[Finding]:
    """All findings; an error of the program is a failure of its check."""
    found = []
    for seed in seeds:
        case = None
        for check in checks:
            before = time.perf_counter()
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    case = case or drawn(seed)
                    case.draws_for(check)
                    found.append(CHECKS[check](case))
            except Exception as error:  # noqa: BLE001
                found.append(Finding(seed, check, False, text=f"{type(error).__name__}: {error}"))
            if progress:
                last = found[-1]
                print(
                    f"{seed} {check} {'holds' if last.holds else 'FAILS'} {last.figure:.3g} ({time.perf_counter() - before:.1f} s) {last.text}",
                    flush=True,
                )
    return found


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0:40", help="from:to")
    parser.add_argument("--only", default=",".join(CHECKS), help="checks, with commas between")
    parser.add_argument("--bundled", action="append", default=[], help="drives of this bundled machine in their place")
    given = parser.parse_args(arguments)
    first, last = map(int, given.seeds.split(":"))
    found: list[Finding] = []
    with tempfile.TemporaryDirectory() as folder:
        at = Path(folder)
        sources = [partial(bundled_case, name, folder=at) for name in given.bundled] or [
            partial(random_case, folder=at)
        ]
        for source in sources:
            found += judged(range(first, last), given.only.split(","), source, progress=True)
    failed = [one for one in found if not one.holds]
    print(f"{len(found) - len(failed)} of {len(found)} hold")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main(sys.argv[1:])
