"""Distributes the blocks of a study to the threads of this process; the core computes without the interpreter lock."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from typing import Protocol, TypeVar

from hydrocrane.errors import InputError
from hydrocrane.studies.case import BlockResult, Job, run_block
from hydrocrane.studies.design import Cases, Place

# Blocks in progress per worker: one that is computed and one that waits, so that no worker idles while results are
# written.
AHEAD = 2
Results = Generator[tuple[Place, BlockResult], None, None]


class Pending(Protocol):
    """A block in progress, in a thread or on a worker."""

    def result(self) -> BlockResult: ...


F = TypeVar("F", bound=Pending)


def thread_count(given: int | None = None) -> int:
    """`given`, checked; default is the number of cores available to this process."""
    if given is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(given, bool) or not isinstance(given, int) or given < 1:
        raise InputError(f"workers must be a whole number, one or more; got {given!r}")
    return given


def in_threads(job: Job, cases: Cases, places: Sequence[Place], workers: int) -> Results:
    """Results of the blocks in the order in which they become ready."""
    stop = threading.Event()
    pool = ThreadPoolExecutor(workers, thread_name_prefix="study")

    def submit(place: Place) -> Future[BlockResult]:
        return pool.submit(run_block, job, cases.values(place), stop.is_set)

    def first(futures: list[Future[BlockResult]]) -> set[Future[BlockResult]]:
        return wait(futures, return_when=FIRST_COMPLETED).done

    try:
        yield from as_ready(submit, first, places, AHEAD * workers)
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)


def as_ready(
    submit: Callable[[Place], F], first: Callable[[list[F]], Iterable[F]], places: Sequence[Place], most: int
) -> Results:
    """Submit blocks, at most `most` at a time, and yield each when it is done.

    Parameters
    ----------
    submit : callable
        Starts a block and returns its future.
    first : callable
        Waits until some of the futures are done, and returns these.
    """
    waiting = iter(places)
    under_way: dict[F, Place] = {}
    while True:
        under_way |= {submit(place): place for place in islice(waiting, most - len(under_way))}
        if not under_way:
            return
        for future in first(list(under_way)):
            place = under_way.pop(future)
            yield place, future.result()
