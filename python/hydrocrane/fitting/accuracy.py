"""A tolerance of integration that the noise of the logs asks for.    theory: docs/theory/identification/fitting.md

Errors of integration move the least sum of squares and roughen its neighbourhood, so a search may end anywhere within
them. Residuals and derivatives of a repeat with a tighter tolerance say how far the fit is from the least sum of the
repeat. This distance is judged by the standard deviations that follow from the logs' noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from hydrocrane.errors import HydrocraneError
from hydrocrane.fitting.information import Information, information
from hydrocrane.fitting.search import SearchResult, refined

# Distance to the least sum of the repeat that needs no tighter tolerance, in standard deviations: an interval that
# covers it is sqrt(1 + 0.2^2) = 1.02 times as wide.
NEGLIGIBLE = 0.2
# Most changes to a tighter tolerance: each is a hundredth of the one before, or half the step.
TIGHTENINGS = 2


@dataclass(frozen=True)
class Accuracy:
    """What a repeat with a tighter tolerance says of a fit.

    Attributes
    ----------
    used, repeat : str
        Tolerances of the fit and of the repeat, in words.
    moved : float
        Distance from the fit to the least sum of squares of the repeat, in standard deviations.
    trouble : str
        Why there is no repeat; empty if there is one.
    """

    used: str
    repeat: str
    moved: float = 0.0
    trouble: str = ""

    @property
    def negligible(self) -> bool:
        """Whether the intervals need no errors of integration."""
        return not self.trouble and self.moved <= NEGLIGIBLE

    def __str__(self) -> str:
        if self.trouble:
            return f"integrated with {self.used}; a repeat with {self.repeat} is not possible: {self.trouble}"
        return f"integrated with {self.used}; {self.repeat} would move it by {self.moved:.2g} standard deviations"


def accurate(found: SearchResult, tell: Callable[[str], None]) -> tuple[SearchResult, Information, Accuracy | None]:
    """The search carried on with tighter tolerances until a repeat with the next one agrees, its intervals, and what
    the last repeat says; None for a fit without runs."""
    for left in reversed(range(TIGHTENINGS + 1)):
        solver = found.task.models[0].solver
        if solver is None:
            break
        finer = found.task.with_solver(solver.tightened())
        accuracy = Accuracy(solver.settings, solver.tightened().settings)
        try:
            known = information(finer, found.weights, found.estimate)
        except HydrocraneError as error:
            return found, information(found.task, found.weights, found.estimate), replace(accuracy, trouble=str(error))
        accuracy = replace(accuracy, moved=known.moved)
        if accuracy.negligible or not left:
            return found, known, accuracy
        tell(f"{accuracy}: searching with {accuracy.repeat}")
        found = refined(replace(found, task=finer), tell)
    return found, information(found.task, found.weights, found.estimate), None
