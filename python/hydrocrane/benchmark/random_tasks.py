"""Random straight lines that a machine can drive, as tasks that were not used for tuning.

The same seed gives the same lines on every computer.
"""

from __future__ import annotations

import numpy as np

from hydrocrane.arrays import Array, seed_number
from hydrocrane.benchmark.cases import Case
from hydrocrane.benchmark.conditions import Condition
from hydrocrane.benchmark.fitted_tasks import INNER, SHORTEST, STEP, walk
from hydrocrane.benchmark.tasks import LINE, SPEEDS, straight
from hydrocrane.errors import InputError
from hydrocrane.machine.machine import Machine

# Share of the speed that is feasible along the whole line, and the fastest line, m/s.
SHARES, FASTEST = (0.3, 0.9), SPEEDS[-1]
REFERENCE = Condition()
# Most attempts per line, after which the machine counts as one without such lines.
MOST_DRAWS = 200


def random_lines(machine: Machine, count: int, *, seed: int = 0, condition: Condition = REFERENCE) -> list[Case]:
    """Random lines of `machine`, each from its own pose.

    A crane that slews has them in the plane of its boom, with the slewing joint at zero.

    The pose is uniform between the shares ``INNER`` of each joint's range, the direction uniform over the circle, the
    length uniform between ``SHORTEST`` and ``LINE``, and the speed a share of the highest one under the static load
    along the whole line. A line is drawn again if the machine cannot follow it, or if the supply pressure cannot move
    some cylinder in both directions under its load.

    Parameters
    ----------
    machine : Machine
    count : int
        Lines wanted, at least one.
    seed : int
        Zero or greater.
    condition : Condition
        The same for all lines; the feasible speed includes its payload.

    Raises
    ------
    InputError
        If a machine has hardly any such lines.

    Examples
    --------
    >>> import hydrocrane as hc
    >>> from hydrocrane.benchmark.random_tasks import random_lines
    >>> [case.task.name for case in random_lines(hc.load_machine("rottne-f9-lab"), 2, seed=1)]  # doctest: +SKIP
    """
    if count < 1:
        raise InputError(f"count must be at least 1, got {count}")
    machine.require_plane("lines of the tip", slewing=True)
    random = np.random.default_rng(seed_number(seed))
    laden = machine.changed({"payload.mass": condition.payload}) if condition.payload else machine
    cases: list[Case] = []
    for _ in range(MOST_DRAWS * count):
        drawn = _drawn(laden, random, f"random {seed}-{len(cases)}", condition)
        if drawn is not None:
            cases.append(drawn)
        if len(cases) == count:
            return cases
    raise InputError(
        f"{machine.name} has few straight lines of {SHORTEST:g} m and more: {len(cases)} of {count} were found in "
        f"{MOST_DRAWS * count} draws"
    )


def _drawn(machine: Machine, random: np.random.Generator, name: str, condition: Condition) -> Case | None:
    """One line, or None if it is not feasible. Both cases use the same number of random numbers."""
    lower, upper = machine.joint_limits.T
    q: Array = lower + (upper - lower) * random.uniform(*INNER, size=lower.size)
    q[: machine.first_in_plane] = 0.0
    angle, length, share = random.uniform(0.0, 2.0 * np.pi), random.uniform(SHORTEST, LINE), random.uniform(*SHARES)
    direction = np.array([np.cos(angle), np.sin(angle)])
    found = walk(machine, q, direction, length)
    if found.length < length - STEP or not machine.piston_speeds(found.poses).all():
        return None
    speed = float(min(FASTEST, share * found.feasible_speed))
    task = straight(f"{name}, {speed:.2g} m/s", [length * direction], speed)
    return Case(task, condition, start=tuple(float(x) for x in q))
