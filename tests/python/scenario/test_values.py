"""A value is refused in Python where a file may not state it, and nowhere else."""

import pytest

import hydrocrane as hc

SCENARIO = """
[scenario]
name = "test"
machine = "single-cylinder"
duration = "1 s"
[initial.joint]
slide = "0.5 m"
[controller]
name = "lever"
[joystick]
mode = "lever"
time = ["0 s"]
test = [0.5]
"""
TIP = {"controller": "tip"}

# Table, key and unit in a file; what makes the same in Python; values of which some are refused.
VALUES = {
    "duration": ("scenario", "duration", "s", lambda v: hc.Scenario(duration=v), (1e-6, -1.0, 0.0, 5.0, 1e6, 1e8)),
    "record": (
        "scenario", "record-interval", "s", lambda v: hc.Scenario(record_interval=v), (0.0, 1e-9, 0.01, 1e9),
    ),
    "payload": ("scenario", "payload", "kg", lambda v: hc.Scenario(payload=v), (-1.0, 0.0, 80.0, 1e9)),
    "period": ("controller", "period", "s", lambda v: hc.Scenario(period=v, **TIP), (0.0, 9e-5, 1e-4, 0.5, 3.0)),
    "delay": ("controller", "delay", "s", lambda v: hc.Scenario(delay=v, **TIP), (-1e-3, 0.0, 0.01, 100.0)),
    "of a phase": ("controller", "period", "s", lambda v: hc.Phase(1.0, period=v, **TIP), (-1.0, 0.01, 3.0)),
    "dead zone": ("joystick", "dead-zone", "", lambda v: hc.Joystick([0.0], dead_zone=v), (-0.1, 0.0, 0.5, 1.0)),
    "ramp": ("joystick", "ramp", "s", lambda v: hc.Joystick([0.0], ramp=v), (-1.0, 0.0, 0.2)),
    "rtol": ("solver", "rtol", "", lambda v: hc.Solver(rtol=v), (0.0, 1e-20, 1e-6, 1e3)),
    "max step": ("solver", "max-step", "s", lambda v: hc.Solver(max_step=v), (0.0, 1e-9, 0.05, 1e6)),
    "step": ("solver", "step", "s", lambda v: hc.Solver(step=v), (-1.0, 1e-3, 1e-12)),
}  # fmt: skip


def accepted(call):
    try:
        call()
    except hc.HydrocraneError:
        return False
    return True


@pytest.mark.parametrize("name", VALUES)
def test_python_and_files_refuse_the_same(name, tmp_path):
    table, key, unit, in_python, values = VALUES[name]
    verdicts = []
    for value in values:
        line = f"{key} = " + (f'"{value} {unit}"' if unit else str(value))
        text = SCENARIO.replace('duration = "1 s"\n', "") if key == "duration" else SCENARIO
        head = f"[{table}]\n"
        text = text.replace(head, f"{head}{line}\n") if head in text else f"{text}{head}{line}\n"
        file = tmp_path / "scenario.toml"
        file.write_text(text)
        verdicts.append(accepted(lambda: hc.load_scenario(file)))
        assert accepted(lambda: in_python(value)) == verdicts[-1], f"{name} = {value}"
    assert set(verdicts) == {True, False}


def test_a_phase_has_the_bounds_of_a_scenario():
    with pytest.raises(hc.InputError, match="did you mean `data-sheet`"):
        hc.Phase(1.0, controller="tip", sensors="datasheet")
