"""Tuning of a controller by simulation: ``tip``, or the PI for comparison.

A pattern search over the logarithms of a few gains: each gain in turn is multiplied and divided by a factor, and an
improvement is kept. The factor decreases when no gain improves. Every trial runs the same cases with the same seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from hydrocrane import _core
from hydrocrane.benchmark.cases import Case, Result, run_case
from hydrocrane.benchmark.fitted_tasks import tuning_cases
from hydrocrane.benchmark.piston_pi import PistonPi
from hydrocrane.control.controllers import DEFAULT_PERIOD
from hydrocrane.errors import InputError, check_known
from hydrocrane.machine.machine import Machine, MachineLike, as_machine

# The gains of the piston loops; the others are limits and shares, which a search must not change.
TUNED = ("position-gain", "damping-ratio", "observer-bandwidth", "pressure-bandwidth")
UNITS = dict(_core.tip_gain_units())
# Gains of the PI.
PI_UNITS = {"proportional": "1/s", "integral": "1/s^2", "pressure": "m/(s Pa)", "corner": "rad/s"}
CONTROLLERS = ("tip", "pi")
# A rate above one per sample acts like an infinite one.
LARGEST = 1.0 / DEFAULT_PERIOD
# In metres of root-mean-square deviation: one full spool stroke of travel per second, so that tenths of a millimetre do
# not justify noise on the valves; a second until the tip rests; and a metre per second at the end, which no deviation
# could pay for.
EFFORT_PRICE, SETTLING_PRICE, REST_PRICE = 2e-4, 1e-3, 1.0
FIRST_FACTOR, LAST_FACTOR = 2.0, 1.15


@dataclass(frozen=True)
class Tuning:
    """Gains before and after, SI, with their cost, m.

    Attributes
    ----------
    before, after : dict
        Gains by key of ``[control.tip]``.
    cost_before, cost_after : float
        Of the worst case: the root-mean-square path deviation plus the prices of spool travel, settling and speed at
        rest, m.
    rest_before, rest_after : float
        Largest root-mean-square speed of the tip at the end of a case, m/s.
    trials : int
        Number of simulated sets of gains.
    machine, controller : str
    allowed : int
        Allowed number of sets of gains.
    seed : int
    """

    before: dict[str, float]
    after: dict[str, float]
    cost_before: float
    cost_after: float
    rest_before: float
    rest_after: float
    trials: int
    machine: str
    controller: str
    allowed: int
    seed: int

    @property
    def units(self) -> dict[str, str]:
        """Units by key."""
        return UNITS if self.controller == "tip" else PI_UNITS

    def toml(self) -> str:
        """The block for a machine file; for the PI, which is in no file, the arguments of its class."""
        if self.controller == "pi":
            return f"PistonPi({', '.join(f'{key}={value:.4g}' for key, value in self.after.items())})\n"
        start = ", ".join(f"{value:.4g}" for value in self.before.values())
        source = f"hydrocrane control tune {self.machine} --trials {self.allowed} --seed {self.seed}, from {start}"
        lines = ["[control.tip]", 'class = "fitted"', f'source = "{source}"']
        lines += [f"{key} = {_written(value, UNITS[key])}" for key, value in self.after.items()]
        return "\n".join(lines) + "\n"


def _written(value: float, unit: str) -> str:
    """A value in the notation of files: a plain number, or a text with its unit."""
    return f'"{value:.4g} {unit}"' if unit else f"{value:.4g}"


def tune(
    machine: MachineLike,
    *,
    controller: str = "tip",
    gains: Sequence[str] | None = None,
    cases: Sequence[Case] | None = None,
    trials: int = 60,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Tuning:
    """Search the gains of a controller for a machine whose tip can go up, down, out and in.

    Parameters
    ----------
    machine : Machine, str or path
    controller : {"tip", "pi"}
        ``pi``: :class:`hydrocrane.benchmark.piston_pi.PistonPi`, with the same search and the same cases.
    gains : sequence of str, optional
        Keys among ``TUNED``, or attributes of the PI; all of them by default.
    cases : sequence of Case, optional
        Simulated cases; by default those of :func:`hydrocrane.benchmark.fitted_tasks.tuning_cases`.
    trials : int
        Most sets of gains to simulate.
    progress : callable, optional
        Called with the trials done and their largest number.
    """
    machine = as_machine(machine)
    check_known("controller to tune", controller, CONTROLLERS)
    known = TUNED if controller == "tip" else tuple(PI_UNITS)
    gains = known if gains is None else gains
    for name in gains:
        check_known("gain to tune", name, known)
    if trials < 1:
        raise InputError(f"trials must be at least 1, got {trials}")
    chosen = list(tuning_cases(machine) if cases is None else cases)
    before = {name: machine.tip_gains[name] if controller == "tip" else getattr(PistonPi(), name) for name in gains}
    rest: list[tuple[dict[str, float], float]] = []

    def run(values: dict[str, float], case: Case) -> Result:
        if controller == "pi":
            return run_case(machine, PistonPi(**values), case, seed=seed)
        changed = machine.changed({f"control.tip.{name}": value for name, value in values.items()})
        return run_case(changed, "tip", case, seed=seed)

    def cost(values: dict[str, float]) -> float:
        if progress is not None:
            progress(len(rest), trials)
        results = [run(values, case) for case in chosen]
        if not rest:
            _check_start(machine, results)
        rest.append((values, max(result.metrics.vibration if result.metrics else math.inf for result in results)))
        return max(_price(result) for result in results)

    best, cost_before, least = pattern_search(cost, before, trials=trials, largest=LARGEST)
    first, last = (next(speed for values, speed in rest if values == gains) for gains in (before, best))
    return Tuning(before, best, cost_before, least, first, last, len(rest), machine.name, controller, trials, seed)


def pattern_search(
    cost: Callable[[dict[str, float]], float],
    start: Mapping[str, float],
    *,
    trials: int,
    largest: float = math.inf,
    factors: tuple[float, float] = (FIRST_FACTOR, LAST_FACTOR),
) -> tuple[dict[str, float], float, float]:
    """Values of least cost found by a pattern search over their logarithms, the cost of `start`, and their cost.

    Parameters
    ----------
    cost : callable
        Function of values by name; infinite if they are not allowed.
    start : mapping
        Start of the search, all greater than zero.
    trials : int
        Most calls of `cost`, at least one.
    largest : float
        Values above it are not tried.
    factors : (first, last)
        Each value is multiplied and divided by the first; if nothing improves, the factor is replaced by its root. The
        search ends at the last.
    """
    best, count = dict(start), 1
    cost_before = least = cost(best)
    factor, last = factors
    while factor > last and count < trials:
        improved = False
        for name in start:
            for step in (factor, 1.0 / factor):
                if count >= trials:
                    break
                if best[name] * step > largest:
                    continue
                trial = {**best, name: best[name] * step}
                count += 1
                price = cost(trial)
                if price < least:
                    best, least, improved = trial, price, True
                    break
        if not improved:
            factor = math.sqrt(factor)
    return best, cost_before, least


def _check_start(machine: Machine, results: Sequence[Result]) -> None:
    """Raises an error if a run with the machine's own gains does not end."""
    for result in results:
        if _price(result) == math.inf:
            raise InputError(
                f"the task {result.case.task.name} ({result.case.condition}) does not reach its end with the gains "
                f"of {machine.name}, so there is nothing to improve: {result.outcome.kind}, {result.message}"
            )


def _price(result: Result) -> float:
    """The cost of a run; infinite if it does not finish, so that such gains are never kept."""
    if not result.outcome.completed or result.metrics is None:
        return math.inf
    found, task = result.metrics, result.case.task
    # A tip that never rests takes all the time that it has.
    settling = task.duration - task.moving_time if math.isnan(found.settling) else found.settling
    moving = EFFORT_PRICE * found.spool_travel + SETTLING_PRICE * settling
    return found.path_rms + moving + REST_PRICE * found.vibration
