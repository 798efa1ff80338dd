"""The short form of `make fuzz` for the files that Python reads, and whether the tool finds what it is to find."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "fuzz"
sys.path.insert(0, str(FOLDER))

import exercise  # noqa: E402
import fuzz_files  # noqa: E402
import worker  # noqa: E402

pytestmark = pytest.mark.evidence


def test_damaged_files_are_refused_or_run(tmp_path):
    output = tmp_path / "report.jsonl"
    command = [sys.executable, FOLDER / "fuzz_files.py", "--inputs", "480", "--threads", "2", "--output", output]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    for line in output.read_text().splitlines():
        report = json.loads(line)
        assert report["refused"] + report["ran"] == report["inputs"] >= 40


def wrong(*_):
    raise AssertionError("a number that is none")


def recursive(*_):
    return recursive()


@pytest.mark.parametrize(
    ("act", "fault"),
    [
        (lambda *_: bytearray(2**40), "memory"),
        (lambda *_: {}["no"], "panic KeyError"),
        (recursive, "panic RecursionError"),
        (wrong, "wrong a number"),
    ],
)
def test_every_kind_of_fault_is_told(act, fault, monkeypatch, capsys):
    monkeypatch.setitem(exercise.KINDS, "log", act)
    worker.one("log", 7, "")
    assert f"fault 7 {fault}" in capsys.readouterr().out


def test_a_hang_is_ended(tmp_path):
    code = (
        f"import sys; sys.path.insert(0, {str(FOLDER)!r}); import exercise, worker; worker.PATIENCE = 0.3\n"
        "def forever(*_):\n    while True: pass\n"
        "exercise.KINDS['log'] = forever\n"
        "worker.main('log', '0', '3', '5')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert "fault 3 hang" in done.stdout


def test_an_input_that_ends_its_worker_costs_no_other_one(monkeypatch):
    """The first kind ends its worker at its last number, the second at its first one."""
    begun = []

    def ends(kinds, seed, at, end, *following, hear):
        for kind in kinds.split(","):
            hear(f"kind {kind}")
            for number in range(int(at), int(end)):
                hear(f"begin {number}")
                begun.append((kind, number))
                if (kind, number) in (("log", 4), ("study", 2)):
                    return hear("ended -9 no more")
                hear(f"ran {number} 0.5")
            at = following[0] if following else at
        return hear("done")

    monkeypatch.setattr(fuzz_files, "worker", ends)
    found = fuzz_files.batch(["log", "study", "line"], 0, 2, 5)
    assert begun == [(kind, number) for kind in ("log", "study", "line") for number in (2, 3, 4)]
    assert {kind: [(f.number, f.kind) for f in tried.failures] for kind, tried in found.items()} == {
        "log": [(4, "crash")], "study": [(2, "crash")], "line": []
    }  # fmt: skip
    assert {kind: [number for _, number, _ in tried.done] for kind, tried in found.items()} == {
        "log": [2, 3], "study": [3, 4], "line": [2, 3, 4]
    }  # fmt: skip


def test_a_number_makes_the_same_file_again():
    for kind in exercise.KINDS:
        assert exercise.content(kind, 0, 5) == exercise.content(kind, 0, 5)
        assert exercise.content(kind, 0, 5) != exercise.content(kind, 1, 5)
