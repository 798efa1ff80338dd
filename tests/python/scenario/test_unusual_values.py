"""A value that is unusual is told of, whether a file states it or Python."""

from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc

FILE = """[scenario]
name = "loose"
machine = "rottne-f9-lab"
duration = "0.2 s"
[initial.joint]
boom = "100 deg"
jib = "100 deg"
extension = "0 mm"
[solver]
rtol = 2
"""


def told(run: hc.Run) -> list[str]:
    return [warning.text for warning in run.warnings if warning.kind == "implausible-value"]


@pytest.mark.parametrize("method", ["auto", "rodas5p", "tsit5"])
def test_no_run_is_silent_about_a_tolerance_of_two(method: str) -> None:
    """`tsit5` and runs under a controller have no estimate of the error of the whole run."""
    plan = hc.Scenario(machine="rottne-f9-lab", joints={"boom": 1.7, "jib": 1.7, "extension": 0.0}, duration=0.1)
    run = hc.simulate(plan, solver=hc.Solver(method=method, rtol=2.0))
    assert told(run) == ["solver.rtol is 2; usual is 1e-12 to 0.1"]
    assert told(hc.simulate("tip-vertical-line", duration=0.1, rtol=2.0)) == told(run)
    assert told(hc.simulate(plan, rtol=1e-3)) == []


def test_stepped_simulations_tell_too() -> None:
    plant = hc.Simulator("rottne-f9-lab", 0.01, rtol=0.5)
    plant.reset(q=np.array([1.7, 1.7, 0.0]))
    assert [warning.text for warning in plant.warnings] == ["solver.rtol is 0.5; usual is 1e-12 to 0.1"]


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"payload": 6e4}, "scenario.payload is 60000 kg; usual is 0.01 kg to 50 t"),
        ({"delay": 3.0, "controller": "tip"}, "controller.delay is 3 s; usual is 0.1 ms to 1 s"),
        ({"max_step": 50.0}, "solver.max-step is 50 s; usual is 0.01 ms to 1 s"),
    ],
)
def test_other_values_are_told_of(fields: dict, text: str) -> None:
    plan = hc.Scenario(machine="rottne-f9-lab", joints={"boom": 1.7, "jib": 1.7, "extension": 0.0})
    (warning,) = plan.changed(**fields).warnings
    assert (warning.kind, warning.text) == ("implausible-value", text)


def test_a_file_tells_once_and_no_longer_when_the_value_is_usual(tmp_path: Path) -> None:
    path = tmp_path / "loose.toml"
    path.write_text(FILE, encoding="utf-8")
    plan = hc.load_scenario(path)
    (warning,) = plan.warnings
    assert warning.text.endswith("loose.toml:10:8: solver.rtol is 2; usual is 1e-12 to 0.1")
    assert told(hc.simulate(plan)) == [warning.text]
    assert plan.changed(rtol=1e-4).warnings == ()


def test_a_warning_has_the_key_of_its_value(tmp_path: Path) -> None:
    path = tmp_path / "loose.toml"
    path.write_text(FILE + 'max-step = "5 s"\n', encoding="utf-8")
    plan = hc.load_scenario(path)
    assert [warning.key for warning in plan.warnings] == ["solver.rtol", "solver.max-step"]
    assert [warning.key for warning in plan.changed(max_step=0.01).warnings] == ["solver.rtol"]
    assert [warning.key for warning in plan.changed(rtol=1e-4, payload=6e4).warnings] == [
        "solver.max-step",
        "scenario.payload",
    ]
    saved = hc.simulate(plan, duration=0.1).save(tmp_path / "run.nc")
    assert {"solver.rtol", "solver.max-step"} <= {warning.key for warning in hc.load_run(saved).warnings}
    machine = hc.load_machine("single-cylinder", {"cylinder.test.bore": "63 m"})
    assert [warning.key for warning in machine.warnings] == ["cylinder.test.bore"]
