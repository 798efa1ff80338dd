"""Findings of the checks of a log."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Flag:
    """One finding about a log.

    Attributes
    ----------
    kind : str
        Stable short name, for example ``gap``; all of them in ``docs/reference/log-files.md``.
    signal : str
        The signal; empty if the finding concerns the whole log.
    start, end : float
        Begin and end, s.
    message : str
        The finding and its cure.
    fatal : bool
        Whether nothing can be computed from the log before this is cured.
    """

    kind: str
    signal: str
    start: float
    end: float
    message: str
    fatal: bool = False

    def __str__(self) -> str:
        return f"[{self.kind}] {self.message}"
