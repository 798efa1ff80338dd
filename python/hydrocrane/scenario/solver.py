"""Integration method of a run, and its accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from hydrocrane import _core
from hydrocrane._core_types import SolverEntry
from hydrocrane.arrays import scenario_quantity, unusual_quantity
from hydrocrane.errors import check_known
from hydrocrane.result_warning import ResultWarning

AUTO = "auto"
METHODS = tuple(_core.METHODS)
# What `auto` takes for fixed steps where `hc-exponential-4` does not suit.
FIXED_STEPS = "hc-rosenbrock-3"
# Factor on the tolerance of a repeat, and the tightest tolerance; with fixed steps a repeat has half the step.
TIGHTER, TIGHTEST = 1e-2, 1e-12


_NUMBERS = "rtol", "max_step", "atol", "step"


def _key(name: str) -> str:
    return f"solver.{name.replace('_', '-')}"


def unusual(quantities: Mapping[str, float]) -> dict[str, ResultWarning]:
    """Warnings on values (SI) that are unusual at their keys of a scenario file, as a file with them has; by key."""
    said = {key: unusual_quantity(key, value) for key, value in quantities.items()}
    return {key: ResultWarning("implausible-value", *texts, key=key) for key, texts in said.items() if texts}


@dataclass(frozen=True)
class Solver:
    """Integration method, and its tolerances or its step.

    ``auto`` selects the fastest suitable method: ``hc-exponential-4`` if all friction has bristles (LuGre) or if `step`
    is given and no law jumps. Else, and for sensitivities, it is ``rodas5p``, or ``hc-rosenbrock-3`` with `step`.
    ``Run.data.attrs["solver_method"]`` states the selected one. These three are stiff methods with the exact Jacobian;
    ``tsit5`` is explicit.

    Without `step`, the tolerances control the step size, up to `max_step` (s). With it steps are equal, no longer than
    `step` (s) between changes of a command, for real time: a step is divided only if its error is large, into at most
    256 parts. `atol` scales the absolute tolerances of all states together; ``None`` keeps them in their fixed
    proportion to `rtol`.

    Examples
    --------
    >>> fine = hc.Solver(rtol=1e-6)
    >>> run = hc.simulate("vertical-lift-open-loop", solver=fine, duration=1.0)
    >>> print(run.data.attrs["solver_method"])
    hc-exponential-4
    """

    method: str = AUTO
    rtol: float = 3e-5
    atol: float | None = None
    max_step: float = 0.05
    step: float | None = None

    def __post_init__(self) -> None:
        check_known("method", self.method, METHODS)
        for name in _NUMBERS:
            if name in ("rtol", "max_step") or getattr(self, name) is not None:
                scenario_quantity(_key(name), name, getattr(self, name))

    @property
    def quantities(self) -> dict[str, float]:
        """The numbers that are given, by their keys in a scenario file."""
        given = {name: getattr(self, name) for name in _NUMBERS}
        return {_key(name): float(value) for name, value in given.items() if value is not None}

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

    @property
    def settings(self) -> str:
        """Its tolerance, or its step, in words."""
        return f"rtol {self.rtol:g}" if self.step is None else f"steps of {self.step * 1e3:g} ms"

    def tightened(self) -> Solver:
        """The solver of a repeat: with a hundredth of the tolerance, or half the step.

        Examples
        --------
        >>> print(hc.Solver(rtol=1e-4).tightened().rtol < 1.1e-6)
        True
        """
        if self.step is not None:
            return replace(self, step=0.5 * self.step)
        rtol = max(self.rtol * TIGHTER, TIGHTEST)
        return replace(self, rtol=rtol, atol=None if self.atol is None else self.atol * rtol / self.rtol)


def named(method: str, choice: str) -> str:
    """The selected method, and a remark if ``auto`` selected it."""
    return f"{method} (chosen: {AUTO})" if choice == AUTO else method
