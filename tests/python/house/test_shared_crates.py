"""The module for Python is built of the crates that the Rust tests have compiled: same features, same profile."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
CARGO = os.environ.get("CARGO", "cargo")

pytestmark = pytest.mark.skipif(shutil.which(CARGO) is None, reason="no cargo here")


def crates(*selection: str) -> list[tuple[int, str]]:
    """Depth in the tree, and name, version and features, of every crate that cargo compiles for this selection."""
    options = ["--offline", "--no-dedupe", "--prefix", "depth", "--format", " {p} {f}"]
    command = [CARGO, "tree", "--manifest-path", str(ROOT / "Cargo.toml"), *selection, *options]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = re.findall(r"^(\d+) (.+?) *$", done.stdout, flags=re.MULTILINE)
    return [(int(depth), crate) for depth, crate in lines]


def below(name: str, tree: list[tuple[int, str]]) -> set[str]:
    """The crate `name` with everything that it is made of."""
    first = next(i for i, (_, crate) in enumerate(tree) if crate.startswith(f"{name} "))
    depth = tree[first][0]
    after = next((i for i in range(first + 1, len(tree)) if tree[i][0] <= depth), len(tree))
    return {crate for _, crate in tree[first:after]}


def test_tests_and_module_share_the_simulation():
    """Another feature anywhere below would compile it twice, which is half of a build."""
    module = below("hydrocrane-sim", crates("--package", "hydrocrane-python", "--edges", "normal,build"))
    tests = {crate for _, crate in crates("--workspace", "--edges", "normal,build,dev")}
    assert len(module) > 10
    assert module <= tests, f"with other features in `cargo test --workspace`: {sorted(module - tests)}"
