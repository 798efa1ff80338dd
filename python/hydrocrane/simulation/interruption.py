"""Ctrl-C during a computation: ask to stop first, interrupt the second time."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def interruptible() -> Iterator[Callable[[], bool] | None]:
    """A context in which the first Ctrl-C requests a stop; the second one interrupts as usual.

    Only the main thread receives signals; in other threads it does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield None
        return
    asked = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def ask(_number: int, _frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, ask)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)
