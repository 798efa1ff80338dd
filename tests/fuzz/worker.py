"""Tries damaged files one after the other; says which one it is at, so that whoever reads knows what ended it.

``worker.py KINDS SEED START END [NEXT]``, or ``worker.py KIND --file PATH``. Kinds are tried in turn, the first one
from the number START, the others from NEXT. A line per event: ``kind KIND``, for each of its inputs ``begin N``, then
``refused N S``, ``ran N S`` or ``fault N CLASS TEXT``, and ``done`` at the end. N is the number of the input, S its
processor time in seconds.
"""

from __future__ import annotations

import os
import sys
import threading
import time
import traceback
from pathlib import Path

from exercise import STUDY, content, exercise
from fuzz_files import MEMORY, PATIENCE

# The input under way and the processor time at its beginning.
under_way: tuple[int, float] | None = None


def bounded_memory() -> None:
    """What the process needs by now and `MEMORY` more, where the system can set a limit."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    except (ImportError, OSError, ValueError):
        return


def watch() -> None:
    """Ends the process when an input has had its time."""
    while True:
        time.sleep(0.1)
        seen = under_way
        if seen is not None and time.process_time() - seen[1] > PATIENCE:
            print(f"fault {seen[0]} hang not done after {PATIENCE:g} s of processor time", flush=True)
            os._exit(0)


def one(kind: str, number: int, text: str) -> None:
    global under_way
    print(f"begin {number}", flush=True)
    began = time.process_time()
    under_way = (number, began)
    try:
        said = exercise(kind, text)
    except MemoryError:
        said = f"fault {number} memory {last_place()}"
    except AssertionError as error:
        said = f"fault {number} wrong {' '.join(str(error).split())[:300]}"
    except BaseException as error:
        text = " ".join(str(error).split())[:200]
        said = f"fault {number} panic {type(error).__name__} {last_place()} {text}"
    under_way = None
    print(said if said.startswith("fault") else f"{said} {number} {time.process_time() - began:.4f}", flush=True)


def last_place() -> str:
    """File and line of the package where an exception arose."""
    frames = [frame for frame in traceback.extract_tb(sys.exc_info()[2]) if "hydrocrane" in frame.filename]
    return f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else "outside"


def main(kinds: str, *rest: str) -> None:
    # What is imported late, and the threads of a study, are in memory before the limit counts.
    exercise("study", STUDY)
    bounded_memory()
    threading.Thread(target=watch, daemon=True).start()
    if rest[0] == "--file":
        one(kinds, 0, Path(rest[1]).read_bytes().decode(errors="surrogateescape"))
        return
    seed, start, end, *following = map(int, rest)
    for kind in kinds.split(","):
        print(f"kind {kind}", flush=True)
        for number in range(start, end):
            one(kind, number, content(kind, seed, number))
        start = following[0] if following else start
    print("done", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
