"""Straight lines after some seconds of driving, as a test of what ``tip`` has learnt of valves, supply and leakage.

The crane makes random moves for 10 s, each with its return within a second. Then the tip is moved up, down, out and in,
with pauses between. The model of the controller is the machine of the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import seed_number
from hydrocrane.benchmark.cases import START
from hydrocrane.control.joystick import Joystick
from hydrocrane.errors import HydrocraneError
from hydrocrane.machine.machine import Machine, load_machine
from hydrocrane.machine.overrides import Override
from hydrocrane.results.run import Run
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.simulation.running import simulate

# Number of moves with return, and the times of a move, a pause and a line, s.
MOVES, MOVE, PAUSE, LENGTH = 5, 1.0, 1.5, 2.5
# Times before the first move and after a line, until the tip is at rest, s.
BEGIN, REST = 0.3, 0.4
# m/s at full stick, share of it on a line, and the time of a full deflection, s.
FULL_SPEED, SHARE, RAMP = 0.2, 0.5, 0.2
DIRECTIONS = ((0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0))
WARM_UP = 2.0 * MOVES * MOVE


@dataclass(frozen=True)
class AfterDriving:
    """Result of such a drive.

    Attributes
    ----------
    deviation : float
        Largest distance of the tip from its four lines, m.
    run : Run
        The drive with the lines; ``run.learnt`` has the learnt values.
    """

    deviation: float
    run: Run


def lines_after_driving(
    machine: Machine,
    unstated: Mapping[str, Override],
    seed: int,
    *,
    learning_time: float | None = None,
    start: Mapping[str, float] = START,
) -> AfterDriving:
    """Drive `machine` with the overrides `unstated`, which the controller model does not have.

    Parameters
    ----------
    machine : Machine
        Also the controller model.
    unstated : mapping
        Overrides of the crane alone.
    seed : int
        Of the moves.
    learning_time : float, optional
        ``control.tip.learning-time`` in place of the machine's, s; 0 switches learning off.
    start : mapping
        Joint coordinates, rad or m; by default those of the benchmark's tasks, which fit the laboratory crane.

    Raises
    ------
    InputError
        Bad overrides, or another machine.
    HydrocraneError
        If the run ends early.

    Examples
    --------
    >>> crane = hydrocrane.load_machine("rottne-f9-lab")
    >>> lines_after_driving(crane, {"supply.pressure": 98e5}, seed=3).deviation < 1e-3
    True
    """
    gains = {} if learning_time is None else {"control.tip.learning-time": learning_time}
    times, sticks = _sticks(seed_number(seed))
    plan = Scenario(
        machine=machine.source,
        overrides={**machine.overrides, **unstated},
        joints=dict(start),
        duration=times[-1] + 1.0,
        joystick=Joystick(times, {"x": sticks[:, 0], "z": sticks[:, 1]}, full_speed=FULL_SPEED, ramp=RAMP),
        controller_model=load_machine(machine.source, {**machine.overrides, **gains}),
        # The monitor would report sensor faults because of the unknown machine.
        monitor=False,
    )
    run = simulate(plan, ledger=False)
    if not run.outcome.completed:
        raise HydrocraneError(f"the drive ended: {run.outcome.message}")
    return AfterDriving(_deviation(run), run)


def _sticks(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Times, s, and deflections held from each on, (k, 2)."""
    rng = np.random.default_rng(seed)
    legs: list[tuple[float, np.ndarray]] = []
    for _ in range(MOVES):
        angle, share = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.4, 1.0)
        legs += [(MOVE, sign * share * np.array([np.cos(angle), np.sin(angle)])) for sign in (1.0, -1.0)]
    for direction in DIRECTIONS:
        legs += [(PAUSE, np.zeros(2)), (LENGTH, SHARE * np.array(direction))]
    times = BEGIN + np.concatenate([[0.0], np.cumsum([lasts for lasts, _ in legs])])
    return times, np.array([*(stick for _, stick in legs), np.zeros(2)])


def _deviation(run: Run) -> float:
    begin, most = BEGIN + WARM_UP, 0.0
    for direction in DIRECTIONS:
        begin += PAUSE
        part = run.data.sel(time=slice(begin, begin + LENGTH + REST))
        way = np.stack([part["tip.x"] - part["tip.x"][0], part["tip.z"] - part["tip.z"][0]], axis=1)
        most = max(most, float(np.abs(way @ np.array([direction[1], -direction[0]])).max()))
        begin += LENGTH
    return most
