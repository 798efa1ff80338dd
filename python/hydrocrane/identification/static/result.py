"""A static friction map from measurements, with its uncertainty and the warnings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array, check_level
from hydrocrane.asked import ask
from hydrocrane.errors import InputError, check_known
from hydrocrane.identification.report import comment, head, interval, signature
from hydrocrane.identification.solve import correlation_of, labelled
from hydrocrane.identification.static.intervals import BOUND, Solved, akaike_weights, averaged, reach
from hydrocrane.identification.static.maps import (
    HELD,
    LABELS,
    LINEAR,
    LINEARITY,
    LOGARITHMIC,
    OF_SENSORS,
    OFFSET,
    PARAMETERS,
    Form,
    StaticMap,
    fitted_velocity,
    of_sensors,
    unit_of,
)
from hydrocrane.identification.static.points import DIRECTIONS, FrictionPoints, RejectedPoint
from hydrocrane.identification.static.residuals import HeldOut, ResidualAnalysis, Succession

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


# Forms within this difference of Akaike's criterion cannot be distinguished with certainty; others have considerably
# less support (Burnham and Anderson, Model Selection, 2002, section 2.6).
ALIKE = 4.0
# Multiple of the fastest measured speed at which an extrapolation is shown.
BEYOND = 2.0


@dataclass(frozen=True)
class Spread:
    """Covariance of the free parameters; rows and columns in the order of `labels`.

    Attributes
    ----------
    labels : tuple of str
        Free parameters as ``coulomb.extending``, then errors of the sensors that have a prior: ``offset``,
        ``span.p1``, ``span.p2``, ``linearity_error``.
    from_data, from_prior : ndarray, shape (m, m)
        Covariance due to the scatter of the points and due to the priors of the sensor errors; infinite on the diagonal
        of a parameter that the data do not identify.
    from_scatter : ndarray, shape (m, m)
        The part of `from_data` whose size was estimated from the scatter of the levels; the rest follows from the
        stated errors.
    bounds : ndarray, shape (m, k)
        The part of `from_prior` due to errors that are uniformly distributed within bounds: the largest effect of each
        error on each parameter.
    degrees_of_freedom : float
        Degrees of freedom of the scatter; infinite if the stated errors were used.
    scale : float
        Factor on the stated errors; 1 if a floor explains the scatter.
    condition : float
        Condition number of the fit with scaled columns; if it is large, parameters cannot be distinguished.
    floor : float
        Standard deviation of a whole level about the map beyond the stated errors, N, as found or as given.
    """

    labels: tuple[str, ...]
    from_data: Array
    from_prior: Array
    from_scatter: Array
    bounds: Array
    degrees_of_freedom: float
    scale: float
    condition: float
    floor: float = 0.0


@dataclass(frozen=True)
class StaticFit:
    """A static friction map and the data of its fit.

    Attributes
    ----------
    points : FrictionPoints
        All given points.
    law : StaticMap
        The map; NaN in a direction without points.
    method : str
        ``least-squares`` or ``graphical``.
    offsets : tuple of float
        Fitted constant error of the force in both directions, N: one for all logs, or one for each; empty without a
        prior.
    spans : (float, float)
        Fitted relative errors of the spans of p1 and p2; zero without a prior.
    linearity_error : float
        Fitted relative error of the velocity per metre of position, 1/m; zero without a prior.
    rejected : tuple of RejectedPoint
        Points left out.
    at_bounds : tuple of str
        Parameters that ended at a physical bound.
    warnings : tuple of str
        Parameters that are not identifiable from these data, and other limits.
    form, form_text
        Which terms the map has and which exponents are free; the same in words.
    unknowns : int
        Free parameters of the map.
    residual_analysis : ResidualAnalysis
        How far the levels lie off the map, and what the residuals may depend on; None for readings and
        alternatives.
    held_out : HeldOut
        How well the form predicts levels that it was not fitted to; None where `residual_analysis` is, and for a
        single level.
    successions : tuple of Succession
        Correlation of the residuals along time and velocity, if there are enough readings.
    aicc : float
        Akaike's information criterion, corrected for few levels; among fits of the same points a smaller value is
        likelier.
    alternatives : tuple of StaticFit
        Fits of the other forms that were tried, the likeliest first. The `intervals` are averaged
        over those within 4 AICc, by their likelihood.
    """

    points: FrictionPoints
    law: StaticMap
    method: str = "least-squares"
    offsets: tuple[float, ...] = ()
    spans: tuple[float, float] = (0.0, 0.0)
    linearity_error: float = 0.0
    spread: Spread | None = None
    rejected: tuple[RejectedPoint, ...] = ()
    at_bounds: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    solved: Solved | None = field(default=None, repr=False)
    form: Form = Form()
    form_text: str = ""
    unknowns: int = 0
    residual_analysis: ResidualAnalysis | None = None
    held_out: HeldOut | None = None
    successions: tuple[Succession, ...] = ()
    aicc: float = np.nan
    alternatives: tuple[StaticFit, ...] = field(default=(), repr=False)

    @property
    def offset(self) -> float:
        """Constant error of the force, N; the mean over the logs if each has its own."""
        return float(np.mean(self.offsets)) if self.offsets else 0.0

    @property
    def params(self) -> dict[str, tuple[float, float]]:
        """Keys of ``[friction.<name>]``, each (extending, retracting), SI."""
        return self.law.pairs

    def force(self, v: Array) -> Array:
        """Friction of the map, N, at velocities v, m/s."""
        return self.law.force(v)

    def force_error(self, v: Array) -> Array:
        """Standard error of the map's force, N, at velocities v (n,), m/s, of this form.

        Infinite at velocities where a parameter that is not identifiable has an effect.
        """
        spread = self._known_spread()
        at = [i for i, label in enumerate(spread.labels) if not of_sensors(label)]
        gradient = self.law.evaluate(v)[2][:, [LABELS.index(spread.labels[i]) for i in at]]
        covariance = (spread.from_data + spread.from_prior)[np.ix_(at, at)]
        blind = ~np.isfinite(np.diag(covariance))
        variance = np.einsum("ni,ij,nj->n", gradient, np.where(np.isfinite(covariance), covariance, 0.0), gradient)
        variance[(gradient[:, blind] != 0.0).any(axis=1)] = np.inf
        return np.sqrt(np.maximum(variance, 0.0))

    def force_interval(self, v: Array, level: float = 0.95) -> Array:
        """(n, 2) interval of friction, N, at velocities v (n,), m/s, averaged over all forms that the points hardly
        distinguish. Beyond the measured speeds these differ, and it widens, but friction drives nothing; infinite where
        nothing is known."""
        forms = (self, *self.rivals)
        weights = akaike_weights([fit.aicc for fit in forms])
        forces = np.stack([fit.force(v) for fit in forms])
        far = [reach(level, 1.0, fit._known_spread().degrees_of_freedom, np.empty(0)) for fit in forms]
        half = np.stack([k * fit.force_error(v) for k, fit in zip(far, forms, strict=True)])
        found = np.tile([-np.inf, np.inf], (v.size, 1))
        for i in np.flatnonzero(np.isfinite(half[0])):
            known = np.isfinite(half[:, i])
            middle, width = forces[known, i], half[known, i]
            ends = list(zip(middle - width, middle + width, strict=True))
            found[i] = averaged(weights[known] / weights[known].sum(), list(middle), ends, level)
            found[i] = np.clip(found[i], *((0.0, np.inf) if v[i] > 0.0 else (-np.inf, 0.0))) if v[i] else found[i]
        return found

    def value(self, label: str) -> float:
        """One parameter by its label, such as ``coulomb.extending``."""
        if of_sensors(label):
            name, _, log = label.partition(".")
            return self.offsets[int(log) - 1] if name == OFFSET and log else self._of_sensors[label]
        return float(self.law.values[LABELS.index(label)])

    def unit(self, label: str) -> str:
        """SI unit of a parameter by its label; that of the viscous coefficient depends on its exponent."""
        if of_sensors(label):
            return {OFFSET: "N", LINEARITY: "1/m"}.get(label.partition(".")[0], "1")
        if not label.startswith("viscous."):
            return unit_of(label)
        return unit_of(label, float(f"{self.value(label.replace('viscous', 'viscous-exponent')):.4g}"))

    @property
    def _of_sensors(self) -> dict[str, float]:
        return dict(zip(OF_SENSORS, (self.offset, *self.spans, self.linearity_error), strict=True))

    @cached_property
    def of_sensors(self) -> Array:
        """Force that the fitted sensor errors add to each point, N, (n,)."""
        offset = np.full(len(self.points), self.offset)
        if len(self.offsets) > 1:
            offset = np.array(self.offsets)[self.points.log]
        return (
            offset
            if self.points.chambers is None
            else offset + self.points.chambers @ (np.array(self.spans) * (1.0, -1.0))
        )

    @cached_property
    def residuals(self) -> Array:
        """Measured less fitted force, N, (n,), of all points, rejected ones included; sensor errors count as fitted."""
        return self.points.force - self.law.force(fitted_velocity(self.points, self.linearity_error)) - self.of_sensors

    @cached_property
    def accepted(self) -> NDArray[np.bool_]:
        """True for the points that were used, (n,)."""
        used = np.ones(len(self.points), dtype=bool)
        used[[r.index for r in self.rejected]] = False
        return used

    def shown_speeds(self, side: int) -> Array:
        """Speeds (n,) at which the friction of a direction is shown, m/s: the slowest, a middle and the fastest level,
        and :data:`BEYOND` times the fastest."""
        speed = np.abs(self.points.velocity[(self.points.direction == side) & (self.points.velocity != 0.0)])
        least, most = (float(speed.min()), float(speed.max())) if speed.size else (np.nan, np.nan)
        return np.array([least, np.sqrt(least * most), most, BEYOND * most])[: 4 * (speed.size > 0)]

    @property
    def covariance(self) -> xr.DataArray:
        """Covariance of the free parameters, in products of their SI units."""
        spread = self._known_spread()
        return labelled(spread.labels, spread.from_data + spread.from_prior)

    @property
    def correlation(self) -> xr.DataArray:
        """Correlation of the free parameters; NaN for one that is not identifiable."""
        spread = self._known_spread()
        return labelled(spread.labels, correlation_of(spread.from_data + spread.from_prior))

    def intervals(self, level: float = 0.95, *, method: str = "") -> dict[str, tuple[float, float]]:
        """Confidence intervals of the free parameters, SI, by label.

        Parameters
        ----------
        level : float
            Share of repeated experiments whose interval holds the true value.
        method : {"t", "profile"}
            ``t``: Student's t with the degrees of freedom of the levels, widened by the priors of the sensors (taken
            as known, hence Welch's degrees of freedom for the sum), in the logarithm for Stribeck velocity and
            exponent, and as ``profile`` where it would reach below zero. ``profile``: profile likelihood; slower, and
            correct where the map is strongly nonlinear in the parameter. The default is ``profile`` if an exponent is
            free.
        """
        check_level(level)
        spread = self._known_spread()
        chosen = method or self.interval_method
        check_known("method of intervals", chosen, ("t", "profile"))
        # Profiles are searched for: the block, the report and the warnings ask for the same ones.
        if (level, chosen) not in self._intervals:
            self._intervals[level, chosen] = {label: self._interval(label, level, chosen) for label in spread.labels}
        return dict(self._intervals[level, chosen])

    @property
    def interval_method(self) -> str:
        """Default method of the intervals: ``profile`` if an exponent is free, else ``t``."""
        return "profile" if any("exponent" in label for label in self._known_spread().labels) else "t"

    @cached_property
    def _intervals(self) -> dict[tuple[float, str], dict[str, tuple[float, float]]]:
        """Computed intervals by level and method."""
        return {}

    @cached_property
    def rivals(self) -> tuple[StaticFit, ...]:
        """The alternatives that the points hardly distinguish from the likeliest form."""
        least = min(fit.aicc for fit in (self, *self.alternatives))
        return tuple(fit for fit in self.alternatives if fit.aicc - least < ALIKE)

    @cached_property
    def for_machines(self) -> StaticFit:
        """This fit, or, if it has a Lorentzian, the likeliest one of a form that machine files have."""
        if not self.form.lorentzian:
            return self
        fits = [fit for fit in self.alternatives if not fit.form.lorentzian]
        if not fits:
            raise InputError("machine files have no Lorentzian map: fit a form with a Stribeck exponent")
        return fits[0]

    def _interval(self, label: str, level: float, method: str) -> tuple[float, float]:
        """The interval of a parameter over all forms that the points hardly distinguish and that determine it.

        A form that leaves a parameter open, such as a nearly flat Stribeck term the Coulomb force, says nothing on it.
        """
        alone = self._alone(label, level, method)
        rivals = self._rivals_in(label)
        if not rivals or not np.isfinite(alone).all():
            return alone
        others = ((fit, fit._linear(label, level)) for fit in rivals)
        models = [(self, alone), *((fit, ends) for fit, ends in others if _closed(label, fit.value(label), ends))]
        weights = akaike_weights([fit.aicc for fit, _ in models])
        low, high = averaged(weights, [fit.value(label) for fit, _ in models], [ends for _, ends in models], level)
        return (low if of_sensors(label) else max(low, 0.0)), high

    def _rivals_in(self, label: str) -> list[StaticFit]:
        """The rivals that have a parameter too.

        A viscous coefficient of a held exponent is one of that exponent: no other form has it. Of a free one it is the
        viscous force at 1 m/s, in forms of any exponent.
        """
        own = self.form.viscous_exponent
        one = label.startswith("viscous.") and own in (LINEAR, HELD)
        known = (fit for fit in self.rivals if np.isfinite(fit._deviation(label)))
        return [fit for fit in known if not one or fit.form.viscous_exponent == own]

    def _deviation(self, label: str) -> float:
        """Standard deviation of a parameter; infinite if it is not identifiable or missing."""
        spread = self._known_spread()
        if label not in spread.labels:
            return np.inf
        at = spread.labels.index(label)
        return float(np.sqrt(spread.from_data[at, at] + spread.from_prior[at, at]))

    def _alone(self, label: str, level: float, method: str) -> tuple[float, float]:
        """The interval of this form alone; beyond the physical bound of zero the map is not linear in a parameter."""
        sigma, linear = self._deviation(label), self._linear(label, level)
        if self.solved is None or of_sensors(label) or not 0.0 < sigma < np.inf:
            return linear
        curved = method == "profile" or -np.inf < linear[0] < 0.0
        return self.solved.ends(label, sigma, self._far(label, level)) if curved else linear

    def _far(self, label: str, level: float) -> float:
        """Half width of an interval in standard deviations, which are finite."""
        spread = self._known_spread()
        at = spread.labels.index(label)
        variance, bounds = spread.from_data[at, at] + spread.from_prior[at, at], spread.bounds[at]
        normal = max(variance - float(bounds @ bounds) / BOUND**2, 0.0)
        # The part estimated from the scatter has its degrees of freedom; the stated part counts as known.
        share = spread.from_scatter[at, at] / normal if normal > 0.0 else 0.0
        freedom = spread.degrees_of_freedom / share**2 if share > 0.0 else np.inf
        return reach(level, float(np.sqrt(normal)), freedom, bounds)

    def _linear(self, label: str, level: float) -> tuple[float, float]:
        """The interval of this form alone from the derivatives at the fit."""
        value, sigma = self.value(label), self._deviation(label)
        if not np.isfinite(sigma):
            return -np.inf, np.inf
        wide = self._far(label, level) * sigma
        if label.split(".")[0] in LOGARITHMIC:
            with np.errstate(over="ignore"):
                factor = float(np.exp(wide / value))
            # The range in which it was searched; if nothing in that is excluded, it is not identifiable.
            least, most = (0.0, np.inf) if self.solved is None else self.solved.edges(label)
            low, high = max(value / factor, least), min(value * factor, most)
            return (low, high) if low > least or high < most else (-np.inf, np.inf)
        return float(value - wide), float(value + wide)

    def toml(
        self,
        cylinder: str,
        *,
        name: str | None = None,
        source: Iterable[str] = (),
        date: str = "",
        bristles: Iterable[str] = (),
    ) -> str:
        """``[friction.<name>]`` with class ``fitted``; parameters that were held are ``assumed`` and say so.

        Parameters
        ----------
        cylinder : str
            The cylinder it belongs to; also the table's name unless `name` is given.
        source : iterable of str
            Names of the logs; default are those of the points.
        date : str
            Day of the fit, by default today.
        bristles : iterable of str
            Lines of the bristle parameters; with them the model is LuGre.

        Comments give the 95 % intervals.
        """
        if self.form.lorentzian:
            block = self.for_machines.toml(cylinder, name=name, source=source, date=date, bristles=bristles)
            return f"{comment('the likeliest form, a Lorentzian, is none of machine files: the next one')}\n{block}"
        missing = [name for side, name in enumerate(DIRECTIONS) if not self._finite(side)]
        if missing:
            raise InputError(
                f"no friction {missing[0]} was measured, so there is no block for a machine file; "
                f"add logs of the piston {missing[0]}"
            )
        added = list(bristles)
        logs = ", ".join(source) or ", ".join(self.points.source) or "points given in Python"
        origin = f"{logs}; {self.method} fit of {int(self.accepted.sum())} points, {signature(date)}"
        lines = head(name or cylinder, cylinder, origin, "lugre" if added else "static")
        # Exponents are rounded first, because the unit of the viscous coefficient contains them.
        powers = [float(f"{p:.4g}") for p in self.params["viscous-exponent"]]
        return "\n".join([*lines, *(self._line(key, powers) for key in PARAMETERS), *added]) + "\n"

    def _finite(self, side: int) -> bool:
        return bool(np.isfinite(self.law.values.reshape(-1, 2)[:, side]).all())

    def _line(self, key: str, powers: list[float]) -> str:
        """One key of the block."""
        values = []
        for side, direction in enumerate(DIRECTIONS):
            unit = unit_of(f"{key}.{direction}", powers[side])
            value = powers[side] if key == "viscous-exponent" else self.params[key][side]
            values.append(f"{value:.4g}" if unit == "1" else f'"{value:.5g} {unit}"')
        pair = f"[{', '.join(values)}]"
        if self.spread is None:
            return f"{key} = {pair}"
        if not any(label.startswith(f"{key}.") for label in self.spread.labels):
            return f'{key} = {{ value = {pair}, class = "assumed", source = "held in the fit" }}'
        known = self.intervals(0.95)
        ends = [known.get(f"{key}.{direction}") for direction in DIRECTIONS]
        return f"{key} = {pair}  # 95 %: {' and '.join(interval(*e) for e in ends if e is not None)}"

    def plot(self) -> Figure:
        """Points and map, near zero velocity and over the whole range, with residuals."""
        return cast("Figure", ask("plots", "static-fit", self))

    def _known_spread(self) -> Spread:
        if self.spread is None:
            raise InputError(f"a {self.method} reading has no intervals or covariance; use fit_static")
        return self.spread


def _closed(label: str, value: float, ends: tuple[float, float]) -> bool:
    """Whether an interval determines a parameter: it is finite, and that of a parameter of the map not wider than twice
    the value."""
    return bool(np.isfinite(ends).all() and (of_sensors(label) or ends[1] - ends[0] <= 2.0 * abs(value)))


def missing_directions(fit: StaticFit) -> list[str]:
    """Directions without any point."""
    return [name for side, name in enumerate(DIRECTIONS) if not (fit.points.direction == side).any()]
