"""Distributes the blocks of a study to the workers of a Dask cluster; a block of a lost worker is run again."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.studies.board import task_of
from hydrocrane.studies.case import BlockResult, Job
from hydrocrane.studies.design import Cases, Place
from hydrocrane.studies.local import AHEAD, LOOK, Results, as_ready
from hydrocrane.studies.processes import NotComputed, apart, end_processes, pickled

if TYPE_CHECKING:
    from distributed import Client, Future

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
        _check_versions(client)
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
            yield from as_ready(submit, first, places, AHEAD * max(sum(client.nthreads().values()), 1))
        except (HydrocraneError, KeyboardInterrupt, GeneratorExit):
            raise
        except Exception as error:
            told = next(iter(str(error).splitlines()), "")
            raise NotComputed(f"the cluster failed: {type(error).__name__}: {told}") from error
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

    def __init__(self, future: Future[BlockResult], patience: _Patience) -> None:
        self.future, self._patience = future, patience

    def result(self) -> BlockResult:
        while True:
            with suppress(TimeoutError):
                return self.future.result(timeout=LOOK)
            self._patience.check()


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
