"""Files of a release: they parse, say one version, and cite what they list."""

from __future__ import annotations

import json
import os
import re
import runpy
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from hydrocrane.export import controller, platforms, present_platform
from hydrocrane.export.platforms import PLATFORMS

ROOT = Path(__file__).resolve().parents[3]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
# Actions that exist and are wanted; any other is a slip or a decision.
ACTIONS = {
    "PyO3/maturin-action",
    "actions/checkout",
    "actions/download-artifact",
    "actions/setup-node",
    "actions/setup-python",
    "actions/upload-artifact",
    "dtolnay/rust-toolchain",
    "openjournals/openjournals-draft-action",
    "pypa/gh-action-pypi-publish",
}


def text_of(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_workflows_name_jobs_actions_and_targets_that_exist(path):
    jobs = yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"]
    targets = set(re.findall(r"^([\w-]+):", text_of("Makefile"), re.MULTILINE))
    for job in jobs.values():
        needs = job.get("needs", [])
        assert set([needs] if isinstance(needs, str) else needs) <= set(jobs)
        for step in job["steps"]:
            assert ("uses" in step) != ("run" in step)
            if "uses" in step:
                action, _, version = step["uses"].partition("@")
                assert action in ACTIONS and version
            for made in re.findall(r"\bmake ([\w -]+)", step.get("run", "")):
                assert set(made.split()) <= targets


def test_artifacts_that_are_fetched_were_kept():
    jobs = yaml.safe_load(text_of(".github/workflows/wheels.yml"))["jobs"]
    steps = [step for job in jobs.values() for step in job["steps"] if "artifact" in step.get("uses", "")]
    kept = {step["with"]["name"] for step in steps if "upload" in step["uses"]}
    assert {step["with"]["name"] for step in steps if "download" in step["uses"] and "name" in step["with"]} <= kept


def test_wheels_hold_the_fmu_library_of_every_platform():
    jobs = yaml.safe_load(text_of(".github/workflows/wheels.yml"))["jobs"]
    built = {entry["platform"]: entry["name"] for entry in jobs["fmu"]["strategy"]["matrix"]["include"]}
    assert built == {name: platform.library.name for name, platform in PLATFORMS.items()}
    tried = "\n".join(step.get("run", "") for step in jobs["wheels"]["steps"])
    assert re.findall(r"--platform (\S+)", tried) == list(PLATFORMS)


# What the operating systems call themselves and their processors, and the platform here.
COMPUTERS = {
    ("Linux", "x86_64"): "linux-x86_64",
    ("Linux", "aarch64"): "linux-aarch64",
    ("Darwin", "x86_64"): "darwin-x86_64",
    ("Darwin", "arm64"): "darwin-aarch64",
    ("Windows", "AMD64"): "windows-x86_64",
}


def on(monkeypatch, system, machine):
    """As on another computer, to the package and to the recipe's script."""
    for module in (present_platform, sys.modules["platform"]):
        monkeypatch.setattr(module, "system", lambda: system)
        monkeypatch.setattr(module, "machine", lambda: machine)


@pytest.mark.parametrize(("system", "machine"), COMPUTERS)
def test_an_installed_wheel_finds_the_controller_library_that_was_built_for_it(system, machine, tmp_path, monkeypatch):
    """The workflow puts it where the package looks on such a computer."""
    jobs = yaml.safe_load(text_of(".github/workflows/wheels.yml"))["jobs"]
    built = {entry["platform"]: entry["library"] for entry in jobs["controller"]["strategy"]["matrix"]["include"]}
    on(monkeypatch, system, machine)
    monkeypatch.setattr(controller, "LIBRARIES", tmp_path)
    assert controller.installed_library() is None
    library = tmp_path / COMPUTERS[system, machine] / built[COMPUTERS[system, machine]]
    library.parent.mkdir()
    library.write_bytes(b"")
    assert controller.installed_library() == library


def test_every_wheel_holds_the_controller_library_of_its_platform():
    jobs = yaml.safe_load(text_of(".github/workflows/wheels.yml"))["jobs"]
    built = [entry["platform"] for entry in jobs["controller"]["strategy"]["matrix"]["include"]]
    wheels = {entry["name"]: entry["platform"] for entry in jobs["wheels"]["strategy"]["matrix"]["include"]}
    assert set(built) == set(wheels.values()) == set(COMPUTERS.values())
    taken = [step["with"].get("name", "") for step in jobs["wheels"]["steps"] if "download" in step.get("uses", "")]
    assert "controller-${{ matrix.platform }}" in taken
    included = tomllib.loads(text_of("pyproject.toml"))["tool"]["maturin"]["include"]
    carried = {entry["path"] for entry in included if "wheel" in entry["format"]}
    for folder in (controller.LIBRARIES, platforms.LIBRARIES):
        assert f"{folder.relative_to(ROOT).as_posix()}/**/*" in carried


# Cargo as far as the recipe's script knows it: it tells what it made, a library among crates without one.
CARGO = """#!{python}
import json, os, sys
embedded = "--manifest-path" in sys.argv
name, kind = ("hydrocrane_controller", "staticlib") if embedded else ("hydrocrane_fmu", "cdylib")
files = [os.environ["MADE"] + "/" + file for file in os.environ[kind].split()]
for name, kind, files in (("libm", "lib", []), (name, kind, files)):
    target = {{"name": name, "crate_types": [kind]}}
    print(json.dumps({{"reason": "compiler-artifact", "target": target, "filenames": files}}))
print(json.dumps({{"reason": "build-finished", "success": True}}))
"""
FILES = {
    "Linux": ("libhydrocrane_fmu.so", "libhydrocrane_controller.a"),
    "Darwin": ("libhydrocrane_fmu.dylib", "libhydrocrane_controller.a"),
    "Windows": ("hydrocrane_fmu.dll.lib hydrocrane_fmu.dll", "hydrocrane_controller.lib"),
}


@pytest.mark.skipif(os.name == "nt", reason="the stand-in for cargo is a script of Unix")
@pytest.mark.parametrize(("system", "machine"), COMPUTERS)
def test_the_recipe_puts_the_libraries_where_the_package_looks(system, machine, tmp_path, monkeypatch):
    made, root = tmp_path / "made", tmp_path / "root"
    made.mkdir(), root.mkdir()
    for kind, files in zip(("cdylib", "staticlib"), FILES[system], strict=True):
        monkeypatch.setenv(kind, files)
        for file in files.split():
            (made / file).write_bytes(kind.encode())
    monkeypatch.setenv("MADE", str(made))
    (tmp_path / "cargo").write_text(CARGO.format(python=sys.executable))
    (tmp_path / "cargo").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    on(monkeypatch, system, machine)
    put = runpy.run_path(str(ROOT / "conda/libraries.py"))["build"](root)
    package = root / "python/hydrocrane"
    monkeypatch.setattr(controller, "LIBRARIES", package / "controller_library")
    monkeypatch.setattr(platforms, "LIBRARIES", package / "fmu_library")
    assert controller.installed_library() == put[1] and put[1].read_bytes() == b"staticlib"
    here = COMPUTERS[system, machine]
    # No FMU is for Macs with processors of Intel.
    assert platforms.installed() == ((here,) if here in PLATFORMS else ()) and put[0].read_bytes() == b"cdylib"


def test_the_recipe_builds_the_libraries_and_tries_them():
    recipe = yaml.safe_load(text_of("conda/recipe.yaml"))
    assert recipe["build"]["script"][0] == "python conda/libraries.py"
    tried = "\n".join(line for test in recipe["tests"] for line in test.get("script", ()))
    assert "export fmu" in tried and "installed_library()" in tried


def test_there_is_one_version():
    project = tomllib.loads(text_of("pyproject.toml"))["project"]
    crates = tomllib.loads(text_of("Cargo.toml"))["workspace"]["package"]
    recipe = yaml.safe_load(text_of("conda/recipe.yaml"))
    citation = yaml.safe_load(text_of("CITATION.cff"))
    archive = json.loads(text_of(".zenodo.json"))
    versions = {part["version"] for part in (project, crates, recipe["context"], citation, archive)}
    assert versions == {project["version"]}


def test_the_recipe_asks_for_what_the_package_needs():
    needs = tomllib.loads(text_of("pyproject.toml"))["project"]["dependencies"]
    wanted = {re.sub(r"^matplotlib\b", "matplotlib-base", need).replace(">=", " >=", 1) for need in needs}
    run = set(yaml.safe_load(text_of("conda/recipe.yaml"))["requirements"]["run"])
    assert run - {"python >=3.11"} == wanted


def test_the_citation_file_is_whole():
    """The keys that the format (1.2.0) requires, and those of a reference."""
    citation = yaml.safe_load(text_of("CITATION.cff"))
    assert citation["cff-version"] == "1.2.0" and citation["message"] and citation["title"]
    assert all("name" in author or "family-names" in author for author in citation["authors"])
    for reference in citation["references"]:
        assert {"type", "title", "authors"} <= set(reference)


def test_the_paper_cites_what_it_lists_and_keeps_to_the_journal_s_form():
    paper, listed = text_of("paper/paper.md"), text_of("paper/paper.bib")
    keys = re.findall(r"^@\w+\{(\w+),", listed, re.MULTILINE)
    assert len(set(keys)) == len(keys) and set(re.findall(r"@(\w+)", paper.partition("# Summary")[2])) == set(keys)
    head, body = re.match(r"---\n(.*?)\n---\n(.*)", paper, re.DOTALL).groups()
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= set(yaml.safe_load(head))
    wanted = ["Summary", "Statement of need", "State of the field", "Software design", "Research impact statement"]
    titles = re.findall(r"^# (.*)$", body, re.MULTILINE)
    assert [title for title in titles if title in wanted] == wanted and titles[-1] == "References"
    assert 750 <= len(body.split()) <= 1750


def test_actions_are_pinned_by_their_commits():
    """A tag can be moved to other code."""
    used = [found for path in WORKFLOWS for found in re.findall(r"uses: (.+)", path.read_text("utf-8"))]
    assert len(used) > 20
    pinned = re.compile(r"[\w-]+/[\w-]+@[0-9a-f]{40} # \S.*")
    assert not [use for use in used if not pinned.fullmatch(use)]
