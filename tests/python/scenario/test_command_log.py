"""Spool commands from a log, by every way in: file, Python, command line, study. (The page: crates/web/tests.)"""

import numpy as np
import pytest
from typer.testing import CliRunner

import hydrocrane as hc
from hydrocrane.app.cli import app

PLAN = hc.Scenario(joints={"boom": 1.7, "jib": 1.7, "extension": 0.0}, duration=0.4)
TIMES, LIFT, JIB = [0.0, 0.1, 0.3], [0.0, 8.0, -4.0], [0.0, 0.002, 0.001]
LOG = "clock [ms];u_lift;jib\n;mm;m\n" + "".join(
    f"{1e3 * t:g};{u:g};{v:g}\n".replace(".", ",") for t, u, v in zip(TIMES, LIFT, JIB, strict=True)
)
SCENARIO = """
[scenario]
name = "logged"
machine = "rottne-f9-lab"
duration = "0.4 s"
[initial.joint]
boom = "1.7 rad"
jib = "1.7 rad"
extension = "0 m"
[command]
log = "drive.csv"
time = "clock"
[command.lift]
column = "u_lift"
[command.jib]
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "drive.csv").write_text(LOG, encoding="utf-8")
    (tmp_path / "logged.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def stated():
    """The same commands by numbers."""
    commands = {"lift": hc.Command(TIMES, 1e-3 * np.array(LIFT), "linear"), "jib": hc.Command(TIMES, JIB, "linear")}
    return hc.simulate(PLAN, commands=commands)


def end(run):
    return [run.data[name].values[-1] for name in run.machine.state_names]


def test_every_way_in_gives_the_same_run(folder, stated):
    log = folder / "drive.csv"
    read = hc.read_commands(log, "rottne-f9-lab", columns={"lift": "u_lift"}, units={"jib": "m"}, time="clock")
    assert end(hc.simulate(PLAN, commands=read)) == end(stated)
    from_file = hc.simulate(folder / "logged.toml")
    assert end(from_file) == end(stated)
    np.testing.assert_array_equal(from_file.data["cylinder.lift.command"], stated.data["cylinder.lift.command"])


def test_a_run_that_was_saved_as_csv_is_commanded_again(tmp_path, stated):
    saved = stated.save(tmp_path / "run.csv")
    again = hc.simulate(PLAN, commands=hc.read_commands(saved, stated.machine, interpolation="linear"))
    np.testing.assert_allclose(again.data["tip.z"], stated.data["tip.z"], atol=1e-5)


def test_the_command_line_takes_a_log(folder, tmp_path):
    plain = folder / "plain.csv"
    plain.write_text(LOG.replace("clock", "time").replace("u_lift", "lift"), encoding="utf-8")
    arguments = ["simulate", "vertical-lift-open-loop", "--command-log", str(plain), "--duration", "0.2"]
    done = CliRunner().invoke(app, [*arguments, "--film", "none", "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    run = hc.Run.load(tmp_path / "out/vertical-lift-open-loop.nc")
    assert run.data["cylinder.lift.command"].sel(time=0.1).item() == pytest.approx(8e-3)
    wrong = CliRunner().invoke(app, [*arguments[:2], "--command-log", str(folder / "drive.csv")])
    assert wrong.exit_code != 0 and "no time column" in str(wrong.exception)


def test_a_study_varies_the_log(folder):
    other = folder / "other.csv"
    logs = []
    for path, scale in ((folder / "one.csv", 1.0), (other, 0.5)):
        rows = "".join(f"{t},{scale * u}\n" for t, u in zip(TIMES, LIFT, strict=True))
        path.write_text(f"time,lift [mm]\n{rows}", encoding="utf-8")
        logs.append(str(path))
    data = hc.sweep(PLAN, {"command.log": logs}, measures=["end(cylinder.lift.x)"])
    moved = data["end(cylinder.lift.x)"].values
    assert moved[0] != moved[1] and np.isfinite(moved).all()
    with pytest.raises(hc.HydrocraneError, match="no time column"):
        hc.sweep(PLAN, {"command.log": [str(folder / "drive.csv")]}, measures=["end(tip.z)"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "no time column"),
        ({"time": "clock", "columns": {"lift": "lft"}}, "no column `lft`.*did you mean|no column `lft`"),
        ({"time": "clock", "columns": {"lft": "u_lift"}}, "did you mean `lift`"),
        ({"time": "clock", "columns": {"lift": "u_lift"}, "units": {"lift": "bar"}}, "give one of m"),
        ({"time": "clock", "interpolation": "cubic"}, "interpolation"),
    ],
)
def test_what_is_wrong_is_told(folder, options, words):
    with pytest.raises(hc.HydrocraneError, match=words):
        hc.read_commands(folder / "drive.csv", "rottne-f9-lab", **options)
    with pytest.raises(hc.HydrocraneError, match="no such file"):
        hc.read_commands(folder / "none.csv", "rottne-f9-lab")
