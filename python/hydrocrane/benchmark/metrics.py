"""Figures of how well a crane tip follows its command.

Path deviation is the distance perpendicular to the path, so a lag along the path does not count. The tracking error is
the distance from the commanded position at the same time, so a lag counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrocrane.arrays import Array, rms

# Speed below which the tip counts as at rest, m/s.
AT_REST = 5e-3
# Time at the end of a run for the figure of vibration, s.
LAST = 0.5
# Energy in the springs of the end stops above which a piston counts as having hit one, J.
HIT = 0.1
# RMS deviation (m), settling (s) and RMS speed at the end (m/s) that each halve the score.
HALVING, HALVING_SETTLING, HALVING_REST = 0.01, 2.0, AT_REST
# RMS speed at the end of a tip that never rests at which its score is -1, m/s.
SHAKES = 0.1
# Points of a path for the figure of progress; largest step of progress, as a share of the path; and how much nearer to
# the tip a place must be per metre that it is farther ahead, m.
PLACES, AHEAD, RELUCTANCE = 500, 0.2, 0.01


@dataclass(frozen=True)
class TipMotion:
    """The data of a run for the metrics; all arrays have the same times.

    Attributes
    ----------
    time : (m,) array
        s.
    tip, tip_velocity : (m, 2) arrays
        The true tip, m and m/s.
    asked, asked_velocity : (m, 2) arrays
        Position and velocity of the tip that the stick commands, m and m/s.
    set_point : (m, 2) array or None
        The controller's own set-point of the tip, m.
    command : (m, n_cyl) array
        Spool commands as shares of the strokes.
    power : (m,) array
        Drawn from the pump, W.
    end_stops : (m,) array
        Energy in the springs of the end stops, J.
    """

    time: Array
    tip: Array
    tip_velocity: Array
    asked: Array
    asked_velocity: Array
    set_point: Array | None
    command: Array
    power: Array
    end_stops: Array


@dataclass(frozen=True)
class Metrics:
    """Figures of one run, SI.

    Attributes
    ----------
    score : float
        ``reached / ((1 + path_rms / 10 mm) (1 + settling / 2 s) (1 + vibration / 5 mm/s))``: 1 for the whole path
        without deviation and a stop at once, 0 for a tip that does not move. A tip that never rests has
        ``-vibration / 100 mm/s``, at least -1: less than one that stands.
    reached : float
        Share of the path's length that the tip followed, in the order of the path.
    path_max, path_rms : float
        Distance of the tip from the commanded path, m.
    end_error : float
        Distance of the tip from the end of the path at the end of the run, m.
    speed_error : float
        RMS of the tip's speed less the commanded one while the stick is deflected, as a share of the largest.
    time : float
        Time at which the tip is finally at rest, s; NaN if it never is.
    settling : float
        From the centring of the stick to that time, s; zero if the tip is at rest earlier.
    vibration : float
        RMS speed of the tip over the last ``LAST`` s of the run, m/s.
    energy : float
        Drawn from the pump, J.
    end_stop_hits : int
    spool_rms : float
        RMS of the spool commands, share of stroke.
    spool_travel : float
        Travel of the spool commands per second, strokes, mean over the cylinders; noisy control makes it large.
    rho : float
        max|e| / max|v|, s: tracking error against the stick's integral, over the largest commanded speed.
    rho_set_point : float
        The same against the controller's own set-point, as in published values, over the largest speed of the tip; NaN
        for a controller without a set-point.
    """

    score: float
    reached: float
    path_max: float
    path_rms: float
    end_error: float
    speed_error: float
    time: float
    settling: float
    vibration: float
    energy: float
    end_stop_hits: int
    spool_rms: float
    spool_travel: float
    rho: float
    rho_set_point: float


def metrics(motion: TipMotion) -> Metrics:
    """All figures of a motion."""
    aside = _length(motion.tip - nearest_on_path(motion.tip, motion.asked))
    error = _length(motion.tip - motion.asked)
    fastest = float(_length(motion.asked_velocity).max())
    reached, path_rms, rest = share_reached(motion.tip, motion.asked), rms(aside), _rest_from(motion)
    settling = float(np.maximum(rest - _centred_from(motion), 0.0))
    vibration = rms(_length(motion.tip_velocity[motion.time >= motion.time[-1] - LAST]))
    return Metrics(
        score=_score(reached, path_rms, settling, vibration),
        reached=reached,
        path_max=float(aside.max()),
        path_rms=path_rms,
        end_error=float(error[-1]),
        speed_error=_speed_error(motion, fastest),
        time=rest,
        settling=settling,
        vibration=vibration,
        energy=float(0.5 * (motion.power[1:] + motion.power[:-1]) @ np.diff(motion.time)),
        end_stop_hits=int(np.count_nonzero(np.diff((motion.end_stops > HIT).astype(int)) == 1)),
        spool_rms=rms(motion.command),
        spool_travel=spool_travel(motion.time, motion.command),
        rho=float(error.max()) / fastest,
        rho_set_point=_own_rho(motion),
    )


def _score(reached: float, path_rms: float, settling: float, vibration: float) -> float:
    if np.isnan(settling):
        return -min(vibration / SHAKES, 1.0)
    lost = (1.0 + path_rms / HALVING) * (1.0 + settling / HALVING_SETTLING) * (1.0 + vibration / HALVING_REST)
    return reached / lost


def spool_travel(time: Array, command: Array) -> float:
    """Travel of spool commands (m, n_cyl), shares of stroke, per second: strokes, mean over the cylinders."""
    return float(np.abs(np.diff(command, axis=0)).sum(axis=0).mean() / np.ptp(time))


def nearest_on_path(points: Array, path: Array) -> Array:
    """Places (m, 2) nearest to points (m, 2) on a path (k, 2) of straight pieces.

    An open path continues straight at both ends, so a late stop on a line is no deviation.
    """
    corners = _corners(path)
    nearest = np.broadcast_to(corners[0], points.shape).copy()
    begin, legs = corners[:-1], np.diff(corners, axis=0)
    low, high = np.zeros(len(legs)), np.ones(len(legs))
    if len(legs) and _length(corners[-1] - corners[0]) > 1e-3 * _length(legs).sum():
        low[0], high[-1] = -np.inf, np.inf
    distance = np.full(len(points), np.inf)
    for corner, along, least, most in zip(begin, legs, low, high, strict=True):
        share = np.clip((points - corner) @ along / (along @ along), least, most)
        place = corner + share[:, np.newaxis] * along
        here = _length(points - place)
        closer = here < distance
        nearest[closer], distance[closer] = place[closer], here[closer]
    return nearest


def share_reached(points: Array, asked: Array) -> float:
    """Progress of points (m, 2) along a path that is commanded at the same times (m, 2), as a share of its length.

    The place on the path never moves back, is never ahead of the command, and advances by at most a share ``AHEAD`` of
    the path at once. A tip that stays at the start of a closed path is thus not at its end.
    """
    travelled = np.concatenate([[0.0], np.cumsum(_length(np.diff(asked, axis=0)))])
    whole = travelled[-1]
    if whole == 0:
        return 1.0
    place = np.linspace(0.0, whole, PLACES + 1)
    path = np.column_stack([np.interp(place, travelled, column) for column in asked.T])
    latest = np.searchsorted(place, travelled * (1 + 1e-12), side="right")
    at, most = 0, int(AHEAD * PLACES)
    for point, end in zip(points, latest, strict=True):
        ahead = slice(at, max(at + 1, min(int(end), at + most)))
        away = _length(path[ahead] - point) + RELUCTANCE * (place[ahead] - place[at])
        at += int(np.argmin(away))
    return at / PLACES


def significant(value: float) -> str:
    """A number with three significant digits, at most two of them behind the point, and no exponent."""
    digits = 2 - int(np.floor(np.log10(abs(value)))) if value else 2
    return f"{value:.{min(max(digits, 0), 2)}f}"


def _corners(path: Array) -> Array:
    """Corners of the path with its first and last point; repetitions and points on a line are left out."""
    moved = np.concatenate([[True], _length(np.diff(path, axis=0)) > 1e-9])
    points = path[moved]
    if len(points) < 3:
        return np.asarray(points)
    legs = np.diff(points, axis=0)
    legs = legs / _length(legs)[:, np.newaxis]
    turns = _length(np.diff(legs, axis=0)) > 1e-6
    return np.asarray(points[np.concatenate([[True], turns, [True]])])


def _speed_error(motion: TipMotion, fastest: float) -> float:
    wanted = _length(motion.asked_velocity)
    moving = wanted > 0
    return rms((_length(motion.tip_velocity) - wanted)[moving]) / fastest


def _rest_from(motion: TipMotion) -> float:
    fast = np.flatnonzero(_length(motion.tip_velocity) > AT_REST)
    if not fast.size:
        return float(motion.time[0])
    return float(motion.time[fast[-1] + 1]) if fast[-1] + 1 < motion.time.size else float("nan")


def _centred_from(motion: TipMotion) -> float:
    """Time after which the stick stays at its centre, s."""
    asked = np.flatnonzero(_length(motion.asked_velocity) > 0.0)
    return float(motion.time[min(asked[-1] + 1, motion.time.size - 1)]) if asked.size else float(motion.time[0])


def _own_rho(motion: TipMotion) -> float:
    if motion.set_point is None:
        return float("nan")
    error, speed = _length(motion.tip - motion.set_point), _length(motion.tip_velocity).max()
    return float(np.nanmax(error) / speed) if speed > 0 and np.isfinite(error).any() else float("nan")


def _length(vectors: Array) -> Array:
    """Length of the vectors along the last axis."""
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))
