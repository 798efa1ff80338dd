"""A log condensed to means over blocks, which are longer where the signals hardly change.
theory: docs/theory/identification/dynamic.md"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrocrane.arrays import Array

# Length of a block as a share of the time since the last corner, and its largest as a share of the log.
GROWTH = 0.1
LONGEST = 1.0 / 400.0


@dataclass(frozen=True)
class Blocks:
    """A log in blocks: single samples after a change of the command, means of many samples later.

    The response to a step of the spool decays, so blocks may grow with the time since the last corner of the command. A
    mean has the information of its samples as long as a parabola describes the signal within the block.

    Attributes
    ----------
    first, count : (b,) arrays
        Index of a block's first sample, and its number of samples.
    nodes : (k,) array
        Times, s, at which a simulated signal must be known for its means: one to three per block.
    places : (b, 3) array
        Indices of the nodes at a block's first sample, middle and last sample.
    """

    first: NDArray[np.intp]
    count: NDArray[np.intp]
    nodes: Array
    places: NDArray[np.intp]

    @classmethod
    def of(cls, time: Array, corners: Array) -> Blocks:
        """Blocks of samples at `time` (n,), s. No block contains one of the `corners`, s, in its interior."""
        first = _starts(time, corners)
        count = np.diff(np.append(first, time.size))
        begin, end = time[first], time[first + count - 1]
        nodes, places = np.unique(np.stack([begin, 0.5 * (begin + end), end], axis=-1), return_inverse=True)
        return cls(first, count, nodes, np.asarray(places).reshape(-1, 3))

    def mean(self, samples: Array) -> Array:
        """(b, ...) means of samples (n, ...)."""
        shape = (-1, *[1] * (samples.ndim - 1))
        return np.asarray(np.add.reduceat(samples, self.first, axis=0) / self.count.reshape(shape))

    def mean_of_nodes(self, values: Array) -> Array:
        """(b, ...) means over a block's samples of a signal known at the nodes (k, ...), exact for parabolas."""
        ends = np.where(self.count > 1, (self.count + 1) / (6.0 * np.maximum(self.count - 1, 1)), 0.0)
        weights = np.stack([ends, 1.0 - 2.0 * ends, ends], axis=-1)
        return np.asarray(np.einsum("bj,bj...->b...", weights, values[self.places]))


def _starts(time: Array, corners: Array) -> NDArray[np.intp]:
    """Index of the first sample of each block."""
    interval = (time[-1] - time[0]) / (time.size - 1)
    most = max(int(LONGEST * time.size), 1)
    edges = np.unique(np.concatenate([[0], np.searchsorted(time, corners), [time.size]]))
    starts = []
    for begin, end in zip(edges[:-1], edges[1:], strict=True):
        at = int(begin)
        while at < end:
            starts.append(at)
            since = time[at] - time[begin]
            at += int(np.clip(GROWTH * since / interval, 1, most))
    return np.array(starts, dtype=np.intp)
