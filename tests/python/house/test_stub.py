"""The stub of the compiled core says what the core is."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[3] / "python" / "hydrocrane"


@pytest.mark.evidence
def test_stub_matches_the_compiled_module(tmp_path: Path) -> None:
    """Every name and signature in `_core.pyi` exists in the module, and the other way round."""
    # Beside the rest of the package mypy would read all of that too, which takes five times as long.
    alone = tmp_path / "hydrocrane"
    alone.mkdir()
    for name in ("_core.pyi", "_core_types.py"):
        shutil.copy(PACKAGE / name, alone)
    (alone / "__init__.pyi").touch()
    settings = tmp_path / "mypy.ini"
    settings.write_text(f"[mypy]\nmypy_path = {tmp_path}\nstrict = true\n", encoding="utf-8")
    command = [sys.executable, "-m", "mypy.stubtest", "--mypy-config-file", settings, "hydrocrane._core"]
    check = subprocess.run(command, capture_output=True, text=True, check=False)
    assert check.returncode == 0, check.stdout + check.stderr
