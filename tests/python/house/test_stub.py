"""The stub of the compiled core says what the core is."""

import subprocess
import sys

import pytest


@pytest.mark.evidence
def test_stub_matches_the_compiled_module() -> None:
    """Every name and signature in `_core.pyi` exists in the module, and the other way round."""
    check = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "hydrocrane._core"], capture_output=True, text=True, check=False
    )
    assert check.returncode == 0, check.stdout + check.stderr
