"""Segmentation of a position record into straight pieces."""

from __future__ import annotations

import heapq

import numpy as np

from hydrocrane.arrays import Array

# Most initial pieces of a record, and their least number of samples.
MOST_PIECES, LEAST_SAMPLES = 1500, 4
# Allowed excess of the sum of squares of a straight piece over its expectation, in standard deviations for white noise.
EXCESS = 4.0


class _Sums:
    """Cumulative sums, from which the residual of a line through any stretch follows directly."""

    def __init__(self, time: Array, x: Array) -> None:
        t, y = time - time.mean(), x - x.mean()
        self.table = np.concatenate(
            [np.zeros((1, 5)), np.cumsum(np.stack([t, y, t * t, t * y, y * y], axis=1), axis=0)]
        )

    def line(self, a: int, b: int) -> tuple[float, float]:
        """Sum of squared residuals and travel of the line through samples a .. b - 1."""
        st, sy, stt, sty, syy = self.table[b] - self.table[a]
        n = b - a
        ctt, cty, cyy = stt - st * st / n, sty - st * sy / n, syy - sy * sy / n
        if ctt <= 0.0:
            return 0.0, 0.0
        # The samples of a line are evenly spaced, so their variance gives its length: n^2 / 12 squared intervals.
        travel = abs(cty / ctt) * np.sqrt(12.0 * ctt / n)
        return max(cyy - cty * cty / ctt, 0.0), float(travel)


def straight_pieces(time: Array, x: Array, sigma: float, straightness: float, cuts: list[int]) -> list[tuple[int, int]]:
    """(first, last + 1) of pieces over which position is straight within its noise.

    Neighbours are joined, the straightest pair first, as long as the joint piece is straight: bottom-up segmentation
    (Keogh et al., Segmenting Time Series, 2004).

    Parameters
    ----------
    time, x : (n,) arrays
        s, m; without gaps.
    sigma : float
        Standard deviation of the position sensor, m.
    straightness : float
        Deviation from the line that still counts as straight, as a share of the piece's travel.
    cuts : list of int
        Samples that no piece spans, where the command changes.
    """
    n = x.size
    sums = _Sums(time, x)
    count = int(np.clip(n // LEAST_SAMPLES, 1, MOST_PIECES))
    fixed = {0, n, *(cut for cut in cuts if 0 < cut < n)}
    edges = sorted(fixed | set(np.linspace(0, n, count + 1).astype(int).tolist()))

    def crookedness(a: int, b: int) -> float:
        """Residual over the allowed one; up to 1 the piece is straight."""
        squares, travel = sums.line(a, b)
        allowed = sigma**2 + (straightness * travel) ** 2
        size = b - a
        return squares / (allowed * (size + EXCESS * np.sqrt(2.0 * size)))

    after = dict(zip(edges[:-1], edges[1:]))
    before = {b: a for a, b in after.items()}
    heap = [(crookedness(a, after[b]), a, b, after[b]) for a, b in after.items() if b in after and b not in fixed]
    heapq.heapify(heap)
    while heap:
        cost, a, middle, b = heapq.heappop(heap)
        if cost > 1.0:
            break
        if after.get(a) != middle or after.get(middle) != b:
            continue
        del after[middle], before[middle]
        after[a], before[b] = b, a
        if b in after and b not in fixed:
            heapq.heappush(heap, (crookedness(a, after[b]), a, b, after[b]))
        if a in before and a not in fixed:
            heapq.heappush(heap, (crookedness(before[a], b), before[a], a, b))
    return sorted(after.items())


def command_changes(command: Array, sigma: float, step: float) -> list[int]:
    """Samples at which a command jumps; empty if it changes all the time, like a ramp or the output of a controller."""
    jumps = np.flatnonzero(np.abs(np.diff(command)) > max(6.0 * sigma, 1.5 * step if sigma else 0.0, 1e-9)) + 1
    return [] if jumps.size > 0.1 * command.size else [int(i) for i in jumps]
