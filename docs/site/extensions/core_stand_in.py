"""In place of the compiled core while docstrings are read: the package imports, and nothing can be computed."""

from __future__ import annotations

import sys

from sphinx.ext.autodoc.mock import _MockModule

CORE = "hydrocrane._core"


def install() -> None:
    """Put the stand-in where `import hydrocrane._core` finds it."""
    core = _MockModule(CORE)
    # What modules ask for while they are imported: default solvers are checked against the names of the methods.
    core.METHODS = ("auto", "rodas5p", "hc-exponential-4", "hc-rosenbrock-3", "tsit5")
    core.judged_quantity = lambda _key, _value: (None, None)
    sys.modules[CORE] = core
