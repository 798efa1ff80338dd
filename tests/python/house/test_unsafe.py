"""Every `unsafe` of the crates is known, and says why it is sound."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
# How often each file says it. A further one needs a reason beside it, and its number here.
KNOWN = {
    "embedded/src/lib.rs": 42,
    "embedded/src/named.rs": 8,
    "embedded/src/running.rs": 4,
    "evidence/src/clock.rs": 1,
    "fmi/src/common.rs": 4,
    "fmi/src/component.rs": 2,
    "fmi/src/fmi2.rs": 3,
    "fmi/src/fmi3.rs": 5,
    "fmi/src/pointers.rs": 4,
    "lanes/src/own_numbers.rs": 1,
    "num/src/array.rs": 1,
    "num/src/lanes/register_x86.rs": 21,
}
# A type of a function that a tool hands over is no claim.
SAID = re.compile(r"\bunsafe\b(?! extern \"C\" fn\()")
REASON = re.compile(r"//.*(SAFETY|# Safety)")
FOR_ALL = "// SAFETY of every block"


def claims(text: str) -> list[tuple[int, bool]]:
    """Line of each `unsafe`, and whether a reason stands above it in its block of lines without a gap."""
    found, lines = [], text.split("\n")
    for at, line in enumerate(lines):
        if SAID.search(line.partition("//")[0]):
            begin = next((i for i in range(at, -1, -1) if not lines[i].strip()), 0)
            above = lines[begin : at + 1]
            whole = any(FOR_ALL in earlier for earlier in lines[:at])
            found.append((at + 1, whole or any(map(REASON.search, above))))
    return found


def test_every_unsafe_is_counted_and_has_its_reason():
    files = sorted(path for part in ("src", "tests", "benches") for path in (ROOT / "crates").glob(f"*/{part}/**/*.rs"))
    found = {path.relative_to(ROOT / "crates").as_posix(): claims(path.read_text(encoding="utf-8")) for path in files}
    silent = [f"crates/{path}:{line}" for path, all_ in found.items() for line, said in all_ if not said]
    assert not silent, f"say in a comment `SAFETY: ...` above why it is sound: {', '.join(silent)}"
    assert {path: len(all_) for path, all_ in found.items() if all_} == KNOWN


def test_a_reason_counts_only_in_its_own_block():
    text = '// SAFETY: a.\nunsafe { f() };\n\nunsafe { g() };\n// unsafe\ntype T = Option<unsafe extern "C" fn(u8)>;\n'
    assert claims(text) == [(2, True), (4, False)]
