"""Runs blocks in processes of their own: on all cores whatever Python does, and apart from cases that crash."""

from __future__ import annotations

import dataclasses
import pickle
import subprocess
import sys
import threading
from contextlib import ExitStack, suppress
from pathlib import Path

import cloudpickle

from hydrocrane.errors import HydrocraneError, InputError
from hydrocrane.scenario.scenario import own_controllers
from hydrocrane.studies.board import TRIES, Board, board_of, killed
from hydrocrane.studies.case import Abandoned, BlockResult, BlockTask, Job, run_block, too_long
from hydrocrane.studies.identity import own_parts, received

# A case that does not stop by itself is ended with its process this much later than its limit, s: its own functions
# may hang, or a single step of the integrator may take long.
GRACE = 5.0
# Time between two looks at a case with a limit, s.
LOOK = 0.5


class NotComputed(HydrocraneError):
    """What should compute the cases of a study is gone; what it had computed is in the store."""


class NoProcesses(NotComputed):
    """No process can be started that computes cases."""


def pickled(job: Job) -> bytes:
    """A job as a process receives it, with the fingerprints of what is your own in it.

    Raises
    ------
    InputError
        If something of it cannot be sent to another process.
    """
    try:
        sent = cloudpickle.dumps(job)
        # Of what is made of it, as there.
        return pickle.dumps((sent, own_parts(pickle.loads(sent))))
    except Exception as error:
        raise InputError(f'the study cannot be sent to other processes: {error}; choose scheduler="threads"') from None


def sensible(job: Job) -> bool:
    """Whether cases may go to processes unasked: nothing of your own takes part, whose side effects would be lost."""
    return not own_controllers(job.plan) and all(measure.own is None for measure in job.measures)


class Apart:
    """A process that computes blocks; it is started when it is needed, and again when it has ended.

    Parameters
    ----------
    job : Job
    sent : bytes
        The job by :func:`pickled`.
    board : Board
    row : int
        Row of the board that the process keeps.
    """

    def __init__(self, job: Job, sent: bytes, board: Board, row: int) -> None:
        self.sent, self._job, self._board, self._row = sent, job, board, row
        self._process: subprocess.Popen[bytes] | None = None
        self._closed = self._over = False
        self._idle_deaths = 0
        self._busy = threading.Lock()

    def run(self, task: BlockTask) -> BlockResult:
        """The results of a block. A case with which the process ends twice is left out."""
        with self._busy:
            while not self._closed:
                process = self._process = self._process or self._started()
                try:
                    answer = _asked(process, task)
                except (EOFError, OSError, pickle.UnpicklingError):
                    task = self._without_the_case(task, process)
                    continue
                if isinstance(answer, BaseException):
                    raise answer
                self._idle_deaths = 0
                return answer
        raise Abandoned

    def close(self) -> None:
        """End the process, and with it a block that another thread waits for."""
        self._closed = True
        if (process := self._process) is not None:
            process.kill()
        with self._busy:
            if self._process is not None:
                _ended(self._process)

    def _started(self) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "hydrocrane.studies.worker"]
        # Embedded in another program, the executable is that program.
        if getattr(sys, "frozen", False) or not Path(sys.executable or "").name.lower().startswith(("python", "pypy")):
            raise NoProcesses(f"no Python can be started here: the executable is {sys.executable!r}")
        try:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        except OSError as error:
            raise NoProcesses(f"no process can be started: {error}") from None
        assert process.stdin is not None
        with suppress(OSError):
            for part in (sys.path, (str(self._board.path), self._row, self.sent)):
                pickle.dump(part, process.stdin)
        if self._job.limit is not None:
            threading.Thread(target=self._end_late_cases, args=(process, self._job.limit), daemon=True).start()
        return process

    def _end_late_cases(self, process: subprocess.Popen[bytes], limit: float) -> None:
        while process.poll() is None:
            case = self._board.at(self._row)
            if case is not None and case[1] > limit + GRACE:
                self._over = True
                process.kill()
            with suppress(subprocess.TimeoutExpired):
                process.wait(LOOK)

    def _without_the_case(self, task: BlockTask, process: subprocess.Popen[bytes]) -> BlockTask:
        """The block without the case with which the process ended, if it shall not be tried again."""
        self._process = None
        status = _ended(process)
        case = self._board.died(self._row)
        if self._closed:
            raise Abandoned
        if case is None:
            self._idle_deaths += 1
            if self._idle_deaths >= TRIES:
                raise NoProcesses(f"processes that compute cases end at once (status {status}); see what they print")
            return task
        result, deaths = None, self._board.deaths[case]
        if self._over:
            result = too_long(self._job, "it did not stop and was ended")
        elif deaths >= TRIES:
            result = killed(deaths, f" (status {status})")
        self._over = False
        return task if result is None else dataclasses.replace(task, given={**task.given, case: result})


def _asked(process: subprocess.Popen[bytes], task: BlockTask) -> BlockResult | BaseException:
    assert process.stdin is not None and process.stdout is not None
    pickle.dump(task, process.stdin)
    process.stdin.flush()
    answer = pickle.load(process.stdout)
    assert isinstance(answer, BlockResult | BaseException)
    return answer


def _ended(process: subprocess.Popen[bytes]) -> int:
    """The status of a process whose output has ended, or which is not wanted any more."""
    for stream in (process.stdin, process.stdout):
        with suppress(OSError):
            assert stream is not None
            stream.close()
    with suppress(subprocess.TimeoutExpired):
        process.wait(GRACE)
    process.kill()
    return process.wait()


# The process of each thread of a worker of a cluster.
_OF_THREADS: dict[int, tuple[Apart, ExitStack]] = {}


def apart(sent: bytes, task: BlockTask) -> BlockResult | BaseException:
    """Compute a block on a worker of a cluster, in a process beside it: a case that crashes costs no worker.

    What would end the worker, as `sys.exit` in a function of the user's own, is returned.
    """
    thread = threading.get_ident()
    kept = _OF_THREADS.get(thread)
    if kept is None or kept[0].sent != sent:
        _end(thread)
        stack = ExitStack()
        kept = Apart(received(sent), sent, stack.enter_context(board_of(None, 1)), 0), stack
        _OF_THREADS[thread] = kept
    try:
        return kept[0].run(task)
    except NoProcesses:
        return run_block(received(sent), task)
    except (KeyboardInterrupt, SystemExit) as error:
        return error


def end_processes() -> None:
    """End the processes beside a worker of a cluster."""
    for thread in list(_OF_THREADS):
        _end(thread)


def _end(thread: int) -> None:
    if kept := _OF_THREADS.pop(thread, None):
        kept[0].close()
        kept[1].close()
