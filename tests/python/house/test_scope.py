"""docs/scope.md against the keys of machine files: what can be stated is modelled, and is not said to be missing."""

from __future__ import annotations

import json
import re
from pathlib import Path

from hydrocrane import _core

ROOT = Path(__file__).resolve().parents[3]
MODELLED, MISSING = "## What is modelled", "## What is not modelled"
# Laws of the machine itself: controllers have pages of their own.
LAWS = re.compile(r"theory/(geometry|dynamics|hydraulics|friction|sensor)/")


def section(heading: str) -> str:
    text = (ROOT / "docs/scope.md").read_text(encoding="utf-8")
    return text.partition(f"{heading}\n")[2].partition("\n## ")[0]


def keys() -> list[dict[str, str]]:
    return json.loads(_core.key_list("machine"))


def test_every_law_that_a_key_names_is_among_what_is_modelled():
    laws = {source.partition("#")[0] for key in keys() if LAWS.match(source := key["source"])}
    assert laws
    linked = set(re.findall(r"\]\((theory/[\w/]+\.md)\)", section(MODELLED)))
    assert not laws - linked


def test_nothing_that_has_a_key_of_its_own_is_said_to_be_missing():
    names = {key["path"].split(".")[-1] for key in keys() if key["form"] not in ("table", "tables", "text")}
    rows = re.findall(r"^\| ([^|]+) \|", section(MISSING), re.MULTILINE)
    assert len(rows) > 5
    for row in rows:
        # In the singular too.
        words = {form for word in re.findall(r"[a-z]+", row.lower()) for form in (word, word.removesuffix("s"))}
        assert not words & names, f"{row}: {words & names}"
