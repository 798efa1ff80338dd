"""Distributes the blocks of a study to the workers of a Dask cluster; a block of a lost worker is run again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from hydrocrane.errors import InputError
from hydrocrane.studies.case import BlockResult, Job, run_block
from hydrocrane.studies.design import Cases, Place
from hydrocrane.studies.local import AHEAD, Results, as_ready

if TYPE_CHECKING:
    from distributed import Client, Future

# Time-out for scheduler and workers, s.
CONNECT = 30


def on_cluster(job: Job, cases: Cases, places: Sequence[Place], scheduler: str | Client) -> Results:
    """Results of the blocks in the order in which they become ready.

    Parameters
    ----------
    scheduler : str or distributed.Client
        Address of a scheduler, or your own client.
    """
    from distributed import wait

    with _client(scheduler) as client:
        _check_versions(client)
        futures = set()

        def submit(place: Place) -> Future[BlockResult]:
            future = client.submit(run_block, job, cases.values(place), pure=False)
            futures.add(future)
            return future

        def first(under_way: list[Future[BlockResult]]) -> set[Future[BlockResult]]:
            with client.as_current():
                done = wait(under_way, return_when="FIRST_COMPLETED").done
            futures.difference_update(done)
            return done

        try:
            yield from as_ready(submit, first, places, AHEAD * max(sum(client.nthreads().values()), 1))
        finally:
            client.cancel(list(futures))


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
