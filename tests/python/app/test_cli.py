"""The command line: what it answers, writes and refuses."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from command_line import run, run_in_a_process

import hydrocrane as hc

COMMANDS = (
    "simulate", "plot", "view", "animate", "workspace", "circuit", "loadchart", "modes", "machines", "check", "new",
    "cite", "sweep", "live", "schema", "linearise", "bode",
)  # fmt: skip
BAD_FILES = sorted((Path(__file__).parents[2] / "data" / "bad").glob("*.toml"))


def works(*arguments, folder=None):
    done = run(*arguments, folder=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


def fails(*arguments, folder=None):
    """Exit status 2, nothing on stdout, one message and no traceback on stderr."""
    done = run(*arguments, folder=folder)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.count("error:") == 1
    return done.stderr


def test_help_answers_at_once_as_it_loads_nothing_heavy():
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "hydrocrane", "--help"], capture_output=True, text=True, check=True
    )
    assert "simulate" in done.stdout
    loaded = {line.rsplit("|", 1)[-1].strip() for line in done.stderr.splitlines()}
    assert "hydrocrane.app.cli" in loaded
    assert not loaded & {"numpy", "scipy", "xarray", "pandas", "matplotlib", "hydrocrane._core"}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_help_shows_an_example(command):
    assert f"hydrocrane {command}" in works(command, "--help")


def test_it_is_a_program():
    done = run_in_a_process("--version")
    assert done.returncode == 0 and done.stdout.strip() == f"hydrocrane {hc.__version__}"
    done = run_in_a_process("check", "no-such-machine")
    assert done.returncode == 2 and not done.stdout and done.stderr.startswith("error:")


@pytest.mark.evidence
def test_simulate_writes_data_charts_and_film(tmp_path):
    out = works("simulate", "vertical-lift-open-loop", "--duration", "0.2", "--also", "csv", "-o", tmp_path)
    names = {
        f"vertical-lift-open-loop{end}" for end in (".nc", ".csv", "-lift.png", "-jib.png", "-extension.png", ".gif")
    }
    assert {path.name for path in tmp_path.iterdir()} == names
    for name in names:
        assert name in out
    assert "completed at 0.2 s" in out
    assert hc.load_run(tmp_path / "vertical-lift-open-loop.nc").outcome.completed


@pytest.mark.evidence
def test_a_drive_of_another_version_warns(tmp_path):
    drive = tmp_path / "drive.toml"
    head = '[scenario]\nname = "drive"\nmachine = "single-cylinder"\nduration = "0.1 s"\nrecorded-by = "0.0.1"\n'
    drive.write_text(
        head + '[initial.joint]\nslide = "0 m"\n[joystick]\nmode = "lever"\ntime = ["0 s"]\ntest = [0.1]\n',
        encoding="utf-8",
    )
    for version, warned in (("0.0.1", True), (hc.__version__, False)):
        drive.write_text(drive.read_text(encoding="utf-8").replace("0.0.1", version), encoding="utf-8")
        done = run("simulate", drive, "--film", "none", folder=tmp_path)
        assert done.returncode == 0, done.stderr
        assert ("recorded with version 0.0.1" in done.stderr) is warned


@pytest.mark.evidence
def test_set_reaches_the_machine(tmp_path):
    settings = ["--set", 'supply.pressure="100 bar"', "--set", "payload.mass=120 kg"]
    works("simulate", "vertical-lift-open-loop", "--duration", 0.05, *settings, "--film", "none", "-o", tmp_path)
    run = hc.load_run(tmp_path / "vertical-lift-open-loop.nc")
    assert run.machine.supply_pressure == pytest.approx(100e5)
    assert run.machine.payload_mass == 120.0


@pytest.mark.evidence
def test_plot_and_animate_a_saved_run(tmp_path):
    run = hc.simulate("vertical-lift-open-loop", duration=0.1)
    run.save(tmp_path / "run.nc")
    works("plot", "run.nc", folder=tmp_path)
    works("plot", "run.nc", "--cylinder", "lift", "-o", "lift.svg", folder=tmp_path)
    works("animate", "run.nc", "-o", "film.gif", folder=tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"run.nc", "run-cylinders.png", "lift.svg", "film.gif"}


@pytest.mark.evidence
@pytest.mark.parametrize("chart", ["joint-stroke", "flow-law", "friction"])
def test_charts_of_a_machine(tmp_path, chart):
    works("plot", "rottne-f9-lab", "--chart", chart, folder=tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == [f"rottne-f9-lab-{chart}.png"]


@pytest.mark.evidence
def test_workspace_loadchart_and_modes(tmp_path):
    works("workspace", "rottne-f9-lab", folder=tmp_path)
    table = works("loadchart", "rottne-f9-lab", "--samples", 8, folder=tmp_path)
    assert "reach, m" in table and "at the best height" in table and "at the worst permitted height" in table
    out = works("modes", "rottne-f9-lab", "--at", "boom=100 deg", "--samples", 3, folder=tmp_path)
    assert "cylinder.lift." in out and "record every" in out and "in larger motions" in out
    chosen = works("loadchart", "rottne-f9-lab", "--samples", 8, "--height", "50 cm", folder=tmp_path)
    assert "kg at z = 0.5 m" in chosen and "best height" not in chosen
    assert len(list(tmp_path.glob("rottne-f9-lab-*.png"))) == 3


@pytest.mark.evidence
def test_modes_with_static_friction_warn(tmp_path):
    static = [word for c in ("lift", "jib", "extension") for word in ("--set", f"friction.{c}.model=static")]
    done = run("modes", "rottne-f9-lab", "--samples", 0, *static, folder=tmp_path)
    assert done.returncode == 0 and done.stdout.count("joint.extension.qd") == 1, done.stdout
    assert "smoothed static friction is a damper" in done.stdout
    for words in (
        "static friction of lift, jib, extension acts at rest as a damper",
        "modes at 120, 161 Hz would appear",
    ):
        assert " ".join(done.stderr.split()).count(words) == 1, done.stderr


def test_machines_lists_all_with_their_tally():
    out = works("machines")
    for name in (*hc.bundled_machines(), "measured", "assumed", *hc.bundled_scenarios()):
        assert name in out


@pytest.mark.parametrize("name", [*hc.bundled_machines(), *hc.bundled_scenarios()])
def test_check_accepts_what_is_bundled(name):
    assert "no errors found" in works("check", name)


def test_check_reports_limits_passivity_and_provenance():
    out = works("check", "rottne-f9-lab")
    for word in ("3 degrees of freedom", "boom", "deg", "LuGre", "provenance of"):
        assert word in out


@pytest.mark.parametrize("path", BAD_FILES, ids=lambda path: path.stem)
def test_check_refuses_bad_files(path):
    """Either a machine or a scenario; the message names the file and the kind of mistake."""
    message = fails("check", path)
    assert path.name in message
    assert path.stem in message


def test_there_are_bad_files():
    assert len(BAD_FILES) > 5


@pytest.mark.evidence
@pytest.mark.parametrize("machine", hc.bundled_machines())
def test_new_writes_a_starter_that_runs(tmp_path, machine):
    folder = tmp_path / "mine"
    works("new", folder, "--machine", machine)
    assert tomllib.loads((folder / "scenario.toml").read_text())["scenario"]["machine"] == "machine.toml"
    works("check", folder / "machine.toml")
    works("simulate", folder / "scenario.toml", "--duration", 0.05, "--film", "none", "-o", tmp_path / "out")
    assert "exists already" in fails("new", folder, "--machine", machine)


@pytest.mark.evidence
def test_cite_prints_bibtex():
    assert "@mastersthesis{heinze2007" in works("cite", "rottne-f9-lab")


@pytest.mark.evidence
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["simulate", "vertical-lift"], "vertical-lift-open-loop"),
        (["simulate", "vertical-lift-open-loop", "--set", "supply.presure=1"], "pressure"),
        (["simulate", "vertical-lift-open-loop", "--set", "nonsense"], "KEY=VALUE"),
        (["simulate", "vertical-lift-open-loop", "--film", "avi"], "gif, mp4 or none"),
        (["workspace", "rotne-f9-lab"], "rottne-f9-lab"),
        (["plot", "missing.nc"], "no such file"),
        (["plot", "rottne-f9-lab", "--chart", "friction", "--cylinder", "lif"], "did you mean `lift`"),
        (["modes", "rottne-f9-lab", "--at", "boom=100 furlongs"], "boom='100 deg'"),
        (["modes", "rottne-f9-lab", "--at", "jib=2"], "with a unit, such as jib='100 deg'"),
        (["modes", "rottne-f9-lab", "--at", "extension=2 rad"], "extension='100 mm'"),
        (["modes", "rottne-f9-lab", "--at", "extension=100 m"], "-315 to 315 mm); choose a pose inside it"),
        (["modes", "rottne-f9-lab", "--at", "jib=900 deg"], "(900 deg) and its range is"),
        (["modes", "rottne-f9-lab", "--at", "jib=90 deg", "--at", "jib=80 deg"], "gives `jib` twice"),
        (["check", "rottne-f9-lab", "--set", "payload.mass=1 kg", "--set", "payload.mass=2 kg"], "twice; keep one"),
        (["modes", "rottne-f9-lab", "--at", "bom=1"], "did you mean `boom`"),
        (["check", "no-such-file.toml"], "no-such-file.toml"),
        (["workspace", "vertical-lift-open-loop"], "its machine is `rottne-f9-lab`"),
        (["cite", "vertical-lift-open-loop"], "its machine is `rottne-f9-lab`"),
        (["modes", "run.nc"], "saved run"),
        (["plot", "rottne-f9-lab"], "takes a scenario or a saved run"),
        (["simulate", "rottne-f9-lab"], "takes a scenario"),
        (["simulate", "vertical-lift-open-loop", "-o", __file__], "--output is a folder"),
        (["simulate", "vertical-lift-open-loop", "--also", "ods"], "unknown suffix `.ods`"),
        (["loadchart", "rottne-f9-lab", "--height", "highest"], "best, worst, or a length with its unit"),
        (["loadchart", "rottne-f9-lab", "--height", "2"], "a length with its unit"),
        (["loadchart", "rottne-f9-lab", "-o", "x.xlsx"], "choose a suffix"),
        (["modes", "rottne-f9-lab", "--samples", "1"], "samples must be a whole number, at least 2"),
        (["new", "x", "--machine", "rottne"], "rottne-f9-lab"),
        (["simulate", "vertical-lift-open-loop", "--duration", "-1"], "duration"),
    ],
)
def test_wrong_input_is_one_clean_message(tmp_path, arguments, words):
    assert words in " ".join(fails(*arguments, folder=tmp_path).split())


NUMBERS = (
    ("simulate", "vertical-lift-open-loop", "--duration", "1_0"),
    ("simulate", "vertical-lift-open-loop", "--payload", "1_0"),
    ("control", "benchmark", "--seed", "1_0"),
    ("animate", "vertical-lift-open-loop", "--fps", "2_0"),
    ("sweep", "study.toml", "--workers", "1_0"),
    ("live", "rottne-f9-lab", "--port", "80_80"),
    ("rig", "run", "friction-rig", "--seed", "1_0"),
)


@pytest.mark.parametrize("command", NUMBERS, ids=" ".join)
def test_a_number_with_an_underscore_is_a_misprint(command):
    done = run(*command)
    assert done.returncode == 2
    assert command[-2] in done.stderr and f"`{command[-1]}` is not a" in done.stderr


@pytest.mark.parametrize(
    ("command", "meant"),
    [
        (("plot", "rottne-f9-lab", "--chart", "joint-strok"), "joint-stroke"),
        (("bode", "rottne-f9-lab", "--friction", "relesed"), "released"),
        (("fit", "flow-valve-lift", "log.csv", "-p", "payload.mass", "--motion", "mesured"), "measured"),
    ],
)
def test_a_misspelt_choice_is_told_the_nearest(command, meant):
    done = run(*command)
    assert done.returncode == 2 and f"did you mean `{meant}`?" in " ".join(done.stderr.replace("│", " ").split())


def test_a_map_without_a_pose_that_holds_the_load_is_not_drawn(tmp_path):
    done = run("modes", "rottne-f9-lab", "--payload", "50000", "--samples", "4", folder=tmp_path)
    assert done.returncode == 0 and "carry less, or draw no map" in done.stderr and "NaN" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_no_option_reads_numbers_by_itself():
    # They have one reader, which takes what files take.
    for path in Path(hc.__file__).parent.joinpath("app").glob("*.py"):
        plain = re.search(r"Annotated\[\s*(int|float)( \| None)?,\s*typer", path.read_text())
        assert plain is None, f"{path.name}: {plain.group()}"
