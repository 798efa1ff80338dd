"""Which method integrates a run, and how finely."""

from __future__ import annotations

from dataclasses import dataclass

from hydrocrane._core_types import SolverEntry
from hydrocrane.arrays import check_positive
from hydrocrane.errors import InputError, unknown

AUTO = "auto"
METHODS = (AUTO, "rodas5p", "ros4l", "tsit5", "ros3l")
FIXED_STEPS = "ros3l"


@dataclass(frozen=True)
class Solver:
    """Integration method, and its tolerances or its step.

    ``auto`` takes the fastest suitable method: ``ros3l`` where `step` is given, else ``ros4l`` where all friction has
    bristles (LuGre), else ``rodas5p``; sensitivities take ``rodas5p``. ``Run.data.attrs["solver_method"]`` says which.
    ``rodas5p`` and ``ros4l`` are stiff methods with the exact Jacobian, ``tsit5`` is explicit: they choose their
    steps, up to `max_step` (s). ``ros3l``, stiff as well, takes equal steps no longer than `step` (s) between changes
    of a command, for real time: it cuts a step only where its error is gross, into at most 256 parts. `atol` scales the
    absolute tolerances of all states together; ``None`` leaves them in their fixed proportion to `rtol`.
    """

    method: str = AUTO
    rtol: float = 1e-4
    atol: float | None = None
    max_step: float = 0.05
    step: float | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise unknown("method", self.method, METHODS)
        for name in ("rtol", "max_step"):
            check_positive(name, getattr(self, name))
        for name in ("atol", "step"):
            if getattr(self, name) is not None:
                check_positive(name, getattr(self, name))
        if self.step is None and self.method == FIXED_STEPS:
            raise InputError(f"`{self.method}` takes fixed steps: give their size in seconds, for example step=0.005")
        if self.step is not None and self.method not in (AUTO, FIXED_STEPS):
            raise InputError(
                f"`{self.method}` chooses its steps itself: leave `step` out, give `max_step` for the largest one, "
                f"or take method=`{FIXED_STEPS}`"
            )

    @property
    def entry(self) -> SolverEntry:
        """As the core takes it."""
        return {
            "method": self.method,
            "rtol": float(self.rtol),
            "atol": None if self.atol is None else float(self.atol),
            "max_step": float(self.max_step),
            "step": None if self.step is None else float(self.step),
        }


def named(method: str, choice: str) -> str:
    """The method that was taken, and that nobody stated it where it was chosen."""
    return f"{method} (chosen: {AUTO})" if choice == AUTO else method
