"""Values of the machine file that change in proportion to fitted ones.      theory:
docs/theory/identification/fitting.md

Break-away friction is the usual case: a fit of the Coulomb force alone does not change it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from hydrocrane.arrays import Array
from hydrocrane.errors import InputError, check_known
from hydrocrane.fitting.parameters import key_value
from hydrocrane.machine.machine import Machine

# The leading parameter of each tied key.
Ties: TypeAlias = Mapping[str, str]
# Change of the ratio of break-away to Coulomb friction above which a warning is given.
SHIFT = 0.1


@dataclass(frozen=True)
class Tie:
    """A key that is `ratio` times a fitted one, its `leader`."""

    key: str
    leader: str
    ratio: float


def ties_of(machine: Machine, ties: Ties, parameters: Sequence[str]) -> tuple[Tie, ...]:
    """The ties between keys of a machine, with the ratios of its file."""
    if not isinstance(ties, Mapping) or not all(isinstance(name, str) for pair in ties.items() for name in pair):
        raise InputError(
            f'ties are pairs of keys, such as {{"friction.lift.breakaway": "friction.lift.coulomb"}}; got {ties!r}'
        )
    found: list[Tie] = []
    for key, leader in ties.items():
        check_known(f"parameter that `{key}` is tied to", leader, parameters)
        other = next((name for name in (*parameters, *(tie.key for tie in found)) if _overlap(name, key)), None)
        if other is not None:
            raise InputError(f"`{key}` is tied to `{leader}`, and `{other}` among the parameters or ties moves it too")
        value, head = key_value(machine, key), key_value(machine, leader)
        if head == 0.0 or value == 0.0:
            zero = leader if head == 0.0 else key
            raise InputError(f"`{key}` cannot move in proportion to `{leader}`: `{zero}` is zero; fit both")
        found.append(Tie(key, leader, value / head))
    return tuple(found)


def _overlap(one: str, other: str) -> bool:
    """Whether two keys name the same value, or one names both values of a pair."""
    (path, _, element), (path_2, _, element_2) = one.partition("["), other.partition("[")
    return path == path_2 and (element == element_2 or not element or not element_2)


def tie_matrix(ties: Sequence[Tie], keys: Sequence[str], others: int) -> Array | None:
    """From values of the `keys` and of the `others` to those of the keys, of the ties and of the others; None without
    ties."""
    if not ties:
        return None
    rows = np.zeros((len(ties), len(keys) + others))
    for row, tie in zip(rows, ties, strict=True):
        row[list(keys).index(tie.leader)] = tie.ratio
    own = np.eye(len(keys) + others)
    return np.concatenate([own[: len(keys)], rows, own[len(keys) :]])


def left_behind(before: Machine, after: Machine, keys: Sequence[str], ties: Sequence[Tie]) -> Iterator[str]:
    """Warnings on break-away friction that was constant while the Coulomb friction changed."""
    moved = (*keys, *(tie.key for tie in ties))
    for key in keys:
        partner = key.replace(".coulomb", ".breakaway")
        if not (key.startswith("friction.") and partner != key) or any(_overlap(partner, name) for name in moved):
            continue
        coulomb = key_value(before, key), key_value(after, key)
        if abs(coulomb[1] - coulomb[0]) > SHIFT * abs(coulomb[0]):
            yield (
                f"`{partner}` is unchanged while `{key}` went from {coulomb[0]:.4g} to {coulomb[1]:.4g} N, so their "
                f"ratio has changed; fit both, or tie them with ties={{{partner!r}: {key!r}}}"
            )
