"""How a crane is linearised."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from numpy.typing import ArrayLike

Friction = Literal["held", "released", "smoothed"]
Side = Literal["extend", "retract"]


class Options(TypedDict, total=False):
    """Keywords of :func:`linearise`."""

    state: ArrayLike | None
    command: ArrayLike | None
    inputs: str | Sequence[str] | None
    outputs: str | Sequence[str] | None
    mode: Literal["hold", "steady"]
    side: Side
    friction: Friction
    payload: float | None
