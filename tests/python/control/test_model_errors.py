"""Cranes that differ from the machine file of their controller: a tip off its path is told with the likely error."""

from __future__ import annotations

from dataclasses import replace

import pytest

import hydrocrane as hc
from hydrocrane.benchmark import Condition, random_lines
from hydrocrane.benchmark.cases import motion_of, scenario_of
from hydrocrane.benchmark.conditions import friction_overrides
from hydrocrane.benchmark.metrics import metrics
from hydrocrane.machine.overrides import Override

LOADER, LOAD = "hiab-xs031", 80.0
BULK = "fluid.bulk-modulus"


def said(machine: hc.Machine, changes: dict[str, Override], seed: int = 31) -> list[tuple[float, str]]:
    """Distance from each line, m, and what the run says of it, empty if nothing."""
    found = []
    for case in random_lines(machine, 6, seed=seed, condition=Condition(payload=LOAD)):
        plan = scenario_of(machine, "tip", case)
        plan = replace(plan, overrides=dict(plan.overrides) | changes, duration=case.task.duration + 2.0)
        run = hc.simulate(plan, ledger=False, on_error="stop")
        texts = [warning.text for warning in run.warnings if warning.kind == "tip-off-path"]
        found.append((metrics(motion_of(run, case.task)).path_max, texts[0] if texts else ""))
    return found


def flows(machine: hc.Machine, factor: float) -> dict[str, Override]:
    keys = [key for key in machine.keys if key.endswith("nominal-flow")]
    return {key: factor * float(machine.value(key).si) for key in keys}


def test_a_crane_as_its_file_says_is_told_of_nothing():
    assert not any(text for _, text in said(hc.load_machine(LOADER), {}))


@pytest.mark.parametrize("error", ["flow", "oil", "friction"])
def test_the_likely_error_is_named(error: str) -> None:
    machine = hc.load_machine(LOADER)
    changes, words = {
        "flow": (flows(machine, 0.7), "times the flow"),
        "oil": ({BULK: 0.4 * float(machine.value(BULK).si)}, "times as far"),
        "friction": (friction_overrides(machine, 3.0), "another force"),
    }[error]
    texts = [text for _, text in said(machine, changes) if text]
    assert texts and 2 * sum(words in text for text in texts) > len(texts), texts
