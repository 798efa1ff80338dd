"""Distributes the blocks of a study: to threads, to processes of this computer, or to workers of a Dask cluster."""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing, contextmanager, suppress
from itertools import islice
from queue import SimpleQueue
from typing import TYPE_CHECKING, Protocol, TypeVar

from hydrocrane.arrays import whole_number
from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.studies.board import Board, OnBoard, task_of
from hydrocrane.studies.case import BlockResult, BlockTask, Job, run_block
from hydrocrane.studies.design import Cases, Place, size_of
from hydrocrane.studies.processes import Apart, NoProcesses, NotComputed, apart, end_processes, pickled, sensible

if TYPE_CHECKING:
    from distributed import Client
    from distributed import Future as Remote

# Blocks in progress per worker: one that is computed and one that waits, so that no worker idles while results are
# written.
AHEAD = 2
# Seconds between two looks at what runs.
LOOK = 1.0
# Each way is measured for as long as processes take to start, s.
START = 0.4
# Processes are tried if threads would need longer for what is left, s: start and stretch are at most a tenth of it.
WORTH = 2 * START / 0.1
WAYS = THREADS, PROCESSES = "threads", "processes"
Results = Generator[tuple[Place, BlockResult], None, None]
# Computes a block in a row of the board.
Compute = Callable[[BlockTask, int], BlockResult]


class Pending(Protocol):
    """A block in progress, in a thread or on a worker."""

    def result(self) -> BlockResult: ...


F = TypeVar("F", bound=Pending)


def thread_count(given: int | None = None) -> int:
    """`given`, checked; default is the number of cores available to this process."""
    if given is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return whole_number("workers", given)


class Local:
    """The workers of this computer.

    Parameters
    ----------
    job, cases, board
        What is computed, and where that is recorded.
    look : callable
        Called about every second.
    """

    def __init__(self, job: Job, cases: Cases, board: Board, look: Callable[[], None]) -> None:
        self._job, self._cases, self._board, self._look = job, cases, board, look

    def results(self, places: Sequence[Place], workers: int, scheduler: str | None) -> Results:
        """Results of the blocks in the order in which they become ready.

        Parameters
        ----------
        scheduler : {"threads", "processes"} or None
            None begins with threads, tries processes if enough is left, and goes on with the faster of the two.
        """
        suspect = set(self._board.deaths)
        alone = [place for place in places if suspect.intersection(self._cases.numbers(place))] if suspect else []
        rest = [place for place in places if place not in alone]
        free = scheduler is None and sensible(self._job)
        # A case with which a process may have ended is computed alone: if it ends again, that was the reason.
        for some, count in ((alone, 1), (rest, workers)):
            if not some:
                continue
            if scheduler == PROCESSES:
                yield from self._in_processes(some, count)
            elif free and some is alone:
                yield from self._in_processes_if_any(some, count)
            elif free and count > 1:
                yield from self._as_measured(some, count)
            else:
                yield from self._in_threads(some, count)

    def _as_measured(self, places: Sequence[Place], workers: int) -> Results:
        """In threads; if enough is left, for a stretch in processes, and then in what computes more cases a second."""
        waiting, left = iter(places), sum(map(size_of, places))
        threads, processes = _Pace(workers), _Pace(workers)
        in_threads = math.inf

        def first() -> Iterator[Place]:
            nonlocal in_threads
            while threads.seconds < START or threads.time_for(left) < WORTH:
                if (place := next(waiting, None)) is None:
                    return
                yield place
            in_threads = threads.time_for(1)

        def second() -> Iterator[Place]:
            slower = None
            while not slower and (place := next(waiting, None)) is not None:
                yield place
                if slower is None and processes.seconds >= START:
                    slower = processes.time_for(1) > in_threads

        def counted(pace: _Pace, results: Results) -> Results:
            nonlocal left
            with closing(results):
                for place, result in results:
                    left -= len(result.outcomes)
                    pace.add(len(result.outcomes))
                    yield place, result

        yield from counted(threads, self._in_threads(first(), workers))
        if left:
            yield from counted(processes, self._in_processes_if_any(second(), workers))
        if left:
            yield from self._in_threads(waiting, workers)

    def _in_processes_if_any(self, places: Iterable[Place], workers: int) -> Results:
        """In processes; what they leave, where none can be started, in threads."""
        waiting, left = iter(places), dict[tuple[int, ...], Place]()

        def noted() -> Iterator[Place]:
            for place in waiting:
                left[_corner(place)] = place
                yield place

        try:
            for place, result in self._in_processes(noted(), workers):
                del left[_corner(place)]
                yield place, result
        except NoProcesses:
            yield from self._in_threads([*left.values(), *waiting], workers)

    def _in_threads(self, places: Iterable[Place], workers: int) -> Results:
        stop = threading.Event()

        def compute(task: BlockTask, row: int) -> BlockResult:
            return run_block(self._job, task, OnBoard(self._board, row, stop.is_set))

        return self._pooled(compute, stop.set, places, workers)

    def _in_processes(self, places: Iterable[Place], workers: int) -> Results:
        sent = pickled(self._job)
        crew = [Apart(self._job, sent, self._board, row) for row in range(workers)]

        def compute(task: BlockTask, row: int) -> BlockResult:
            return crew[row].run(task)

        def stop() -> None:
            for one in crew:
                one.close()

        yield from self._pooled(compute, stop, places, workers)

    def _pooled(self, compute: Compute, stop: Callable[[], None], places: Iterable[Place], workers: int) -> Results:
        """Blocks computed by as many threads as there are workers, each with a row of the board at a time."""
        rows: SimpleQueue[int] = SimpleQueue()
        for row in range(workers):
            rows.put(row)
        pool = ThreadPoolExecutor(workers, thread_name_prefix="study")

        def computed(place: Place) -> BlockResult:
            row = rows.get()
            try:
                return compute(task_of(self._cases, place, self._board), row)
            finally:
                rows.put(row)

        def submit(place: Place) -> Future[BlockResult]:
            return pool.submit(computed, place)

        def first(futures: list[Future[BlockResult]]) -> set[Future[BlockResult]]:
            self._look()
            return wait(futures, timeout=LOOK, return_when=FIRST_COMPLETED).done

        try:
            yield from as_ready(submit, first, places, AHEAD * workers)
        finally:
            stop()
            pool.shutdown(cancel_futures=True)


class _Pace:
    """Time per case of a stretch, from as many results on as there are workers: their start does not count."""

    def __init__(self, workers: int) -> None:
        self._starting, self._cases, self._began, self._latest = workers, 0, math.inf, -math.inf

    def add(self, cases: int) -> None:
        """Cases that are done now."""
        self._latest = time.monotonic()
        if self._starting:
            self._starting, self._began = self._starting - 1, self._latest
        else:
            self._cases += cases

    @property
    def seconds(self) -> float:
        return max(self._latest - self._began, 0.0)

    def time_for(self, cases: int) -> float:
        """Time that so many cases take, s; zero while none has been measured."""
        return self.seconds / self._cases * cases if self._cases else 0.0


def _corner(place: Place) -> tuple[int, ...]:
    return tuple(part.start for part in place)


def as_ready(
    submit: Callable[[Place], F], first: Callable[[list[F]], Iterable[F]], places: Iterable[Place], most: int
) -> Results:
    """Submit blocks, at most `most` at a time, and yield each when it is done.

    Parameters
    ----------
    submit : callable
        Starts a block and returns its future.
    first : callable
        Waits until some of the futures are done, or for a time, and returns those that are.
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


# Time-out for scheduler and workers, s.
CONNECT = 30
# Seconds without a worker after which the study stops; it can be resumed.
WORKERS_AWAITED = 600.0


def on_cluster(
    job: Job, cases: Cases, places: Sequence[Place], scheduler: str | Client, look: Callable[[], None]
) -> Results:
    """Results of the blocks in the order in which they become ready.

    Parameters
    ----------
    scheduler : str or distributed.Client
        Address of a scheduler, or your own client.
    look : callable
        Called about every second.
    """
    from distributed import wait

    sent = pickled(job)
    with _client(scheduler) as client:
        patience = _Patience(client)
        futures = set()

        def submit(place: Place) -> _Block:
            block = _Block(client.submit(apart, sent, task_of(cases, place), pure=False), patience)
            futures.add(block.future)
            return block

        def first(under_way: list[_Block]) -> list[_Block]:
            look()
            with client.as_current(), suppress(TimeoutError):
                wait([block.future for block in under_way], timeout=LOOK, return_when="FIRST_COMPLETED")
            done = [block for block in under_way if block.future.done()]
            futures.difference_update(block.future for block in done)
            if done:
                patience.renew()
            else:
                patience.check()
            return done

        try:
            _check_versions(client)
            yield from as_ready(submit, first, places, AHEAD * max(sum(client.nthreads().values()), 1))
        except (HydrocraneError, KeyboardInterrupt, GeneratorExit):
            raise
        except Exception as error:
            failure = f"{type(error).__name__}: {next(iter(str(error).splitlines()), '')}"
            closed = client.status in ("closing", "closed")
            raise NotComputed("the client was closed" if closed else f"the cluster failed: {failure}") from error
        finally:
            with suppress(Exception):
                client.cancel(list(futures))
                client.run(end_processes, wait=False)


class _Patience:
    """Ends a study whose cluster has had no worker for too long."""

    def __init__(self, client: Client) -> None:
        self._client, self._seen = client, time.monotonic()

    def renew(self) -> None:
        """A block is done, so there was a worker; the scheduler need not be asked."""
        self._seen = time.monotonic()

    def check(self) -> None:
        if self._client.nthreads():
            self.renew()
        elif time.monotonic() - self._seen > WORKERS_AWAITED:
            raise NotComputed(f"the cluster has had no worker for {WORKERS_AWAITED:g} s")


class _Block:
    """A block under way on the cluster. Results of a lost worker are computed again, perhaps by none."""

    def __init__(self, future: Remote[BlockResult | BaseException], patience: _Patience) -> None:
        self.future, self._patience = future, patience

    def result(self) -> BlockResult:
        while True:
            with suppress(TimeoutError):
                answer = self.future.result(timeout=LOOK)
                break
            self._patience.check()
        if isinstance(answer, BaseException):
            raise answer
        return answer


@contextmanager
def _client(scheduler: str | Client) -> Iterator[Client]:
    try:
        from distributed import Client
    except ImportError:
        raise InputError("a scheduler needs the package distributed; install hydrocrane[dask]") from None
    if isinstance(scheduler, Client):
        yield scheduler
        return
    try:
        client = Client(str(scheduler), set_as_default=False, timeout=CONNECT)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"no Dask scheduler answers at {scheduler}: {error}") from None
    try:
        yield client
    finally:
        client.close()


def _version() -> str:
    from hydrocrane import __version__

    return str(__version__)


def _check_versions(client: Client) -> None:
    """Checks that the workers have the same version of hydrocrane."""
    try:
        client.wait_for_workers(1, timeout=CONNECT)
    except TimeoutError:
        raise InputError(
            f"the scheduler has no workers, and none connected within {CONNECT} s; start `dask worker`"
        ) from None
    try:
        versions = client.run(_version)
    except ImportError as error:
        raise InputError(f"a worker cannot import what a study needs: {error}; install hydrocrane there") from None
    for worker, version in versions.items():
        if version != _version():
            raise InputError(f"worker {worker} has hydrocrane {version}, here it is {_version()}; install one version")
