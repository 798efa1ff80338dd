"""Files of a release: they parse, say one version, and cite what they list."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest
import yaml

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
