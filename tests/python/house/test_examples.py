"""The reference of the Python interface: every public name has an example, and every example gives what it says."""

from __future__ import annotations

import dataclasses
import doctest
import inspect
import re
import sys
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc

ROOT = Path(__file__).resolve().parents[3]
PUBLIC = sorted(hc._HOME)


def examples(name: str) -> doctest.DocTest:
    """Those of a public name; as on the site, `hc` and `np` are imported."""
    public = getattr(hc, name)
    file = sys.modules[public.__module__].__file__
    return doctest.DocTestParser().get_doctest(inspect.getdoc(public), {"hc": hc, "np": np}, f"hc.{name}", file, 0)


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_has_an_example(name):
    shown = examples(name).examples
    assert shown, f"hc.{name} has no example in its docstring"
    assert "Examples\n--------\n" in inspect.getdoc(getattr(hc, name))
    assert any(name in example.source for example in shown) or any(example.want for example in shown)


def test_the_reference_shows_every_public_name():
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs/site/python").glob("*.rst"))
    shown = re.findall(r"^\.\. auto(?:class|function|exception):: hydrocrane\.(\w+)$", pages, re.MULTILINE)
    assert sorted(shown) == PUBLIC


@pytest.mark.evidence
@pytest.mark.parametrize("name", PUBLIC)
def test_examples_of_a_public_name_run(name, tmp_path, monkeypatch):
    """In an empty folder, as a reader would."""
    monkeypatch.chdir(tmp_path)
    failures: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(examples(name), out=failures.append)
    assert not failures, "\n".join(failures)


# Public methods without an example, those of results of a fit, which takes seconds: this number only falls.
WITHOUT_EXAMPLE = 13


def methods() -> dict[str, str]:
    """Docstring of every method of a public class, its own or of a base without a public name, by `Class.method`."""
    found = {}
    for name in PUBLIC:
        public = getattr(hc, name)
        if not inspect.isclass(public) or issubclass(public, BaseException):
            continue
        bases = [base for base in public.__mro__[1:] if base.__module__.startswith("hydrocrane.")]
        for of in [public, *(base for base in bases if base.__name__ not in PUBLIC)]:
            for member, it in vars(of).items():
                made = getattr(it, "__func__", it)
                if inspect.isfunction(made) and not member.startswith("_"):
                    found[f"{name}.{member}"] = inspect.getdoc(made) or ""
    return found


def test_ever_fewer_methods_have_no_example():
    without = [name for name, text in methods().items() if ">>>" not in text]
    assert len(without) == WITHOUT_EXAMPLE, f"set WITHOUT_EXAMPLE to {len(without)}: {without}"


@pytest.mark.evidence
@pytest.mark.parametrize("name", [name for name, text in methods().items() if ">>>" in text])
def test_examples_of_a_method_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text, failures = methods()[name], []
    example = doctest.DocTestParser().get_doctest(text, {"hc": hc, "np": np}, f"hc.{name}", None, 0)
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=failures.append)
    assert not failures, "\n".join(failures)


@pytest.mark.parametrize("name", [name for name in PUBLIC if inspect.isclass(getattr(hc, name))])
def test_every_member_of_a_public_class_is_explained(name):
    """By its own docstring or, as every field, in that of the class: the site shows nothing without words."""
    public = getattr(hc, name)
    held = {member: inspect.getattr_static(public, member) for member in dir(public) if not member.startswith("_")}
    mute = {
        member
        for member, it in held.items()
        if (callable(getattr(public, member)) or isinstance(it, (property, cached_property))) and not inspect.getdoc(it)
    }
    if dataclasses.is_dataclass(public):
        mute |= {field.name for field in dataclasses.fields(public) if field.repr}
    words = inspect.getdoc(public) or ""
    assert not [member for member in mute if not re.search(rf"\b{member}\b", words)]


def test_the_reference_shows_inherited_members():
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs/site/python").glob("*.rst"))
    for name in PUBLIC:
        bases = getattr(getattr(hc, name), "__mro__", ())[1:-1]
        if any(base.__module__.startswith("hydrocrane.") and not issubclass(base, Exception) for base in bases):
            assert f".. autoclass:: hydrocrane.{name}\n   :inherited-members:\n" in pages, name
