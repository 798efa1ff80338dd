"""What a log has to say about itself."""

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
        Which signal; empty where the finding concerns the whole log.
    start, end : float
        From when to when, s.
    message : str
        What was found and what cures it.
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
