"""The fits of several forms of a map to the same points, the likeliest first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from hydrocrane.arrays import Array
from hydrocrane.identification.form import LINEAR, Form
from hydrocrane.identification.least_squares import Problem, level_means, scale_of, with_floor

# Iterations of the weights, which depend on the slope of the map and on the estimated scatter.
ROUNDS = 4
# Difference of AICc up to which a form has substantial support (Burnham and Anderson 2002, section 2.6).
TOLD = 2.0
# Relative change of the weights at convergence.
SETTLED = 1e-5


@dataclass(frozen=True)
class Candidate:
    """A form fitted to the points.

    Attributes
    ----------
    problem : Problem
        With the estimated floor.
    x : ndarray
        Unknowns.
    sigma : ndarray, shape (n,)
        Standard deviation of each point, N.
    aicc : float
        Akaike's criterion, corrected for few levels.
    """

    form: Form
    problem: Problem
    x: Array
    sigma: Array
    aicc: float


def candidates_of(
    forms: Sequence[Form], stribeck_exponents: Sequence[str], problem: Callable[[Form], Problem]
) -> list[Candidate]:
    """Fits of all forms, the best first; the best ones also with the further freedoms of the Stribeck exponent.

    Forms with more unknowns than levels are left out if others have fewer.
    """
    found = _fitted(forms, problem)
    best = min(found, key=lambda candidate: candidate.aicc).form
    if any(best.stribeck):
        alike = [form for form in forms if form.stribeck == best.stribeck]
        more = [replace(form, stribeck_exponent=freedom) for form in alike for freedom in stribeck_exponents]
        found += [c for c in _fitted(more, problem) if c.problem.unknowns <= c.problem.points.levels.count.size]
    found.sort(key=lambda candidate: candidate.aicc)
    # Speeds that do not tell a viscous exponent of 1 from another one are no evidence for the other one.
    near = [c for c in found if c.aicc < found[0].aicc + TOLD and c.form.viscous_exponent == LINEAR]
    return [*near[:1], *(c for c in found if c not in near[:1])]


def _fitted(forms: Sequence[Form], problem: Callable[[Form], Problem]) -> list[Candidate]:
    problems = [(form, problem(form)) for form in forms]
    least = min((p.unknowns for _, p in problems), default=0)
    return [refined(form, p) for form, p in problems if p.unknowns <= max(p.points.levels.count.size, least)]


def refined(form: Form, problem: Problem) -> Candidate:
    """Linear-loss least squares with weights from the slope of the map and the estimated scatter."""
    x, scale, before = problem.begin(problem.start), 1.0, np.zeros(len(problem.points))
    for _ in range(ROUNDS):
        problem = with_floor(problem, x)
        sigma = problem.standard_deviation(problem.theta(x))
        if np.allclose(sigma * scale, before, rtol=SETTLED, atol=0.0):
            break
        before = sigma * scale
        x = problem.solve(x, before).x
        scale = scale_of(problem, x, sigma)[0]
    return Candidate(form, problem, x, sigma, aicc(problem, x))


def aicc(problem: Problem, x: Array) -> float:
    """Akaike's information criterion of a fit, of the means of the levels.

    If the levels scatter by their stated errors, the variances are known, and -2 log L + 2 k is unbiased for any number
    of levels. If they scatter more, one variance is estimated, and the correction for few levels applies (Hurvich and
    Tsai, Biometrika 76, 1989). The likelier case counts. The priors of the sensors are part of the likelihood.
    """
    stated = replace(problem, floor=0.0) if problem.free_floor else problem
    sigma = np.maximum(stated.standard_deviation(problem.theta(x)), 1e-9 * float(np.abs(problem.points.force).max()))
    weight, mean, _ = level_means(problem.points, problem.residuals(x)[0], sigma)
    variance = 1.0 / weight
    prior = sum(((x[i] - p.mean) / p.deviation) ** 2 for i, p in enumerate(problem.priors.values(), problem.unknowns))

    def deviance(more: float) -> float:
        total = variance + more
        return float(np.sum(np.log(total) + mean**2 / total) + prior)

    levels, k = mean.size, problem.unknowns
    known = deviance(0.0) + 2.0 * k
    spare = levels - k - 2
    if spare <= 0:
        return known
    largest = np.log(float(np.max(mean**2)) + float(variance.min()))
    found = minimize_scalar(lambda u: deviance(np.exp(u)), bounds=(largest - 25.0, largest + 1.0), method="bounded")
    return min(known, float(found.fun) + 2.0 * (k + 1) * levels / spare)
