"""The command line in tests: in this process, which is quick, or in one of its own, as people run it."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
import warnings
from pathlib import Path

from hydrocrane.app.cli import main

Done = subprocess.CompletedProcess[str]


def run(*arguments: object, folder: Path | None = None) -> Done:
    """Runs ``hydrocrane`` with these arguments in `folder`."""
    out, err = io.StringIO(), io.StringIO()
    words = [str(argument) for argument in arguments]
    with (
        contextlib.chdir(folder or Path.cwd()),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(),
    ):
        try:
            main(words)
        except SystemExit as end:
            status = end.code
    code = status if isinstance(status, int) else int(status is not None)
    return subprocess.CompletedProcess(words, code, out.getvalue(), err.getvalue())


def run_in_a_process(*arguments: object, folder: Path | None = None) -> Done:
    """The same as a program of its own."""
    command = [sys.executable, "-m", "hydrocrane", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=300, check=False)
