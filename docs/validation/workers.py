"""The processes that share the seeds of a page."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context

# The computer's cores, unless the variable says otherwise.
WORKERS = int(os.environ.get("WORKERS", os.cpu_count() or 1))


@cache
def processes() -> ProcessPoolExecutor:
    """Fresh processes, not copies of this one: a copy of a process with threads, as JAX has them, can stop for ever.

    They keep what they have loaded and computed until the program ends.
    """
    return ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn"))
