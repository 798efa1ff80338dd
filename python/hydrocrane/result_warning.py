"""Warnings of results, with cause and cure."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass


class DoubtfulResult(UserWarning):
    """The category of Python warnings about results without an attribute ``warnings``."""


@dataclass(frozen=True)
class ResultWarning:
    """A warning that a result may be wrong.

    Attributes
    ----------
    kind : str
        Short stable name, one of those in ``docs/reference/warnings.md``.
    text : str
        The finding, with numbers and units.
    cure : str
        The cure.
    time : float
        Begin, s; 0 for a result without a time.
    key : str or None
        Key of the machine or scenario file whose value it is about; ``None`` if it is not about one value.
    """

    kind: str
    text: str
    cure: str
    time: float = 0.0
    key: str | None = None

    def __str__(self) -> str:
        return f"{self.text}; {self.cure}"


def to_json(warnings: Iterable[ResultWarning]) -> str:
    """The warnings as one text, for the attributes of a file."""
    return json.dumps([asdict(warning) for warning in warnings])


def from_json(text: str) -> tuple[ResultWarning, ...]:
    """The warnings that :func:`to_json` wrote."""
    return tuple(ResultWarning(**entry) for entry in json.loads(text))
