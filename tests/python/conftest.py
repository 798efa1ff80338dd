"""Machines and random states that the evidence tests share, and the browser with a cockpit."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from browser import NoBrowser, chromium, served
from cockpit_tab import Page

import hydrocrane as hc
from hydrocrane.errors import InputError
from hydrocrane.studies import case

# Experiments that tests and the pages of docs/validation share.
sys.path.append(str(Path(__file__).resolve().parents[2] / "docs" / "validation"))
CORRECTED = ("rottne-f9-lab", "hiab-xs031", "single-cylinder")


def pytest_collection_modifyitems(items):
    """Whatever needs the browser, or the page's compiled core, runs alone and belongs to the slower evidence.

    Studies come first: they are long files, and at the end all cores but one would wait for them.
    """
    items.sort(key=lambda item: item.path.parent.name != "studies")
    for item in items:
        if {"browser", "address", "cockpit", "drive"} & set(item.fixturenames):
            item.add_marker("browser")
            item.add_marker("evidence")


@pytest.fixture(autouse=True)
def no_figure_is_left():
    """Closes what a test has drawn, so that open figures do not add up over the tests of one process."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture(scope="session", params=CORRECTED)
def corrected(request):
    """Every bundled machine whose laws are the corrected, smooth ones."""
    return hc.load_machine(request.param)


@pytest.fixture(scope="session")
def random_poses():
    """Poses (count, n) uniform over the joint limits, less a `margin` (fraction of the range) at both ends."""

    def draw(crane, count, seed, margin=0.02):
        low, high = crane.joint_limits.T
        share = np.random.default_rng(seed).uniform(margin, 1.0 - margin, (count, len(low)))
        return low + (high - low) * share

    return draw


@pytest.fixture(scope="session")
def random_states(random_poses):
    """States (count, n_states) and commands (count, n_cyl): whole workspace, end stops, slow and fast, cavitation."""

    def draw(crane, count, seed):
        rng = np.random.default_rng(seed)
        poses = random_poses(crane, count, seed + 1, margin=0.002)
        strokes = dict(zip(crane.cylinder_names, crane.spool_strokes, strict=True))

        def column(owner, kind):
            match kind:
                case "q":
                    return poses[:, crane.joint_names.index(owner)]
                case "qd":
                    # Not slower than 1e-3, so that differences do not step over the change of sign of friction.
                    return rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-3, 0, count)
                case "p1":
                    return rng.uniform(-0.95e5, 200e5, count)
                case "p2":
                    # Every fifth one near or below tank pressure.
                    return rng.uniform(-0.95e5, np.where(rng.random(count) < 0.2, 3e5, 200e5))
                case "xs":
                    return rng.uniform(-1, 1, count) * strokes[owner]
                case "vs":
                    return rng.normal(size=count) * 0.2
                case "z":
                    return rng.normal(size=count) * 1e-3
                case "p" | "load":
                    return rng.uniform(-0.5e5, 1.2 * crane.supply_pressure, count)
                case "compensator" | "displacement":
                    return rng.uniform(0.0, 1.0, count)
            raise ValueError(kind)

        states = np.stack([column(*name.partition(".")[2].rpartition(".")[::2]) for name in crane.state_names], axis=-1)
        return states, rng.uniform(-1, 1, (count, len(strokes))) * crane.spool_strokes

    return draw


@pytest.fixture(scope="module")
def browser():
    try:
        with chromium() as found:
            yield found
    except NoBrowser as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="module")
def address():
    """Where the built page is served."""
    try:
        with served() as found:
            yield found
    except InputError as reason:
        pytest.skip(str(reason))


@pytest.fixture
def cockpit(browser, address):
    """A page with a crane at rest; whatever the page complains of fails the test."""
    with Page(browser, address) as page:
        yield page
        assert not page.complaints


@pytest.fixture
def computed(monkeypatch):
    """Values of every case that is run, in order."""
    seen, plain = [], case.run_case

    def counted(job, values, *rest):
        seen.append(tuple(values))
        return plain(job, values, *rest)

    monkeypatch.setattr(case, "run_case", counted)
    return seen
