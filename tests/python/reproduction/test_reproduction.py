"""The reproduction of the thesis is complete, honest and repeatable."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path

import pytest

import hydrocrane as hc

pytestmark = pytest.mark.evidence

FOLDER = Path(__file__).resolve().parents[3] / "reproductions" / "heinze-2007"
sys.path.insert(0, str(FOLDER))
make = importlib.import_module("make")


def test_every_figure_and_table_is_listed_once():
    listed = [entry["id"] for entry in make.items()]
    wanted = [f"figure-{n}" for n in range(1, 95)] + [f"table-{n}" for n in range(1, 7)]
    assert listed == wanted


def test_statuses_are_in_the_vocabulary_and_argued():
    for entry in make.items() + make.statements():
        assert entry["status"] in make.STATUSES, entry["id"]
        assert entry["note"].strip(), entry["id"]
        judged = entry["status"] in make.JUDGED
        for key in ("metric", "unit", "tolerance", "tolerance-reason", "script", "number"):
            assert (key in entry) == judged, f"{entry['id']}: {key}"
        if judged:
            assert (FOLDER / entry["script"]).is_file(), entry["id"]


def test_statuses_follow_from_the_numbers():
    numbers = {script: make.expected(script) for script in make.scripts()}
    assert make.contradictions(make.items() + make.statements(), numbers) == []


def test_a_wrong_status_is_noticed():
    numbers = {script: make.expected(script) for script in make.scripts()}
    entries = [dict(entry, status="reproduced") for entry in make.items() if entry["id"] == "figure-33"]
    assert len(make.contradictions(entries, numbers)) == 1


@pytest.mark.parametrize("script", make.scripts())
def test_expected_numbers_still_hold(script):
    assert make.differences(script, make.compute(script)) == []


def test_page_is_the_generated_one():
    numbers = {script: make.expected(script) for script in make.scripts()}
    assert make.PAGE.read_text(encoding="utf-8") == make.page(numbers), "run reproductions/heinze-2007/make.py"


def test_every_switch_has_its_erratum():
    text = (FOLDER / "ERRATA.md").read_text(encoding="utf-8")
    named = set(re.findall(r"\| `([a-z-]+)` \|$", text, flags=re.MULTILINE))
    assert named == set(hc.load_machine("heinze-2007").errata)
