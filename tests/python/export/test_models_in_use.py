"""The pages that show exported models in use, in their short forms: each fails where a demand is missed."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[3] / "docs/validation"


# In processes of their own: one that has imported JAX must not fork.
@pytest.mark.evidence
@pytest.mark.parametrize(("script", "library"), [("time_optimal", "casadi"), ("exported_models", "jax")])
def test_a_page_of_exported_models(script, library):
    if importlib.util.find_spec(library) is None:
        pytest.skip(f"no {library} here")
    ran = subprocess.run([sys.executable, str(SCRIPTS / f"{script}.py"), "--short"], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
