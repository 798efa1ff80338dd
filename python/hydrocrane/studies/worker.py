"""A process that computes blocks of a study: what it shall do comes by its input, results go to its output.

Started by :class:`hydrocrane.studies.processes.Apart`; not for use by hand.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
from pathlib import Path
from typing import BinaryIO

from hydrocrane.errors import HydrocraneError


def main() -> None:
    commands, answers = _streams()
    # Ctrl-C goes to all processes of a terminal; the one that gathers the results decides what follows from it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.path[:] = pickle.load(commands)
    path, row, sent = pickle.load(commands)

    from hydrocrane.studies.board import Board, OnBoard
    from hydrocrane.studies.case import run_block
    from hydrocrane.studies.identity import received

    job, parent = None, os.getppid()
    watch = OnBoard(Board(Path(path)), row, lambda: os.getppid() != parent)
    while True:
        try:
            task = pickle.load(commands)
        except EOFError:
            return
        try:
            job = job or received(sent)
            answer: object = run_block(job, task, watch)
        except BaseException as error:  # Whatever ends a study where it is called ends it here too.
            answer = error
        try:
            answers.write(_sendable(answer))
            answers.flush()
        except BrokenPipeError:  # Nobody waits for it any more.
            os._exit(1)


def _streams() -> tuple[BinaryIO, BinaryIO]:
    """Input and output, kept from what cases print: that goes to the error output."""
    commands, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    return commands, answers


def _sendable(answer: object) -> bytes:
    try:
        return pickle.dumps(answer)
    except Exception:
        return pickle.dumps(HydrocraneError(f"{type(answer).__name__}: {answer}"))


if __name__ == "__main__":
    main()
