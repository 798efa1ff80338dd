"""Study files, the command that runs them, and the picture."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from command_line import run

import hydrocrane as hc

# That cases fail is what some of them are for.
pytestmark = pytest.mark.filterwarnings("ignore:.*cases have no results")

ROOT = Path(__file__).resolve().parents[3]

GOOD = """
[study]
scenario = "single-cylinder-step"
measures = ["end(tip.z)"]
signals = ["tip.z"]
resample = "50 ms"

[keys]
payload.mass = ["50 kg", -1.0, 100]
"supply.pressure" = { low = "100 bar", high = "140 bar", count = 2 }

[overrides]
"cylinder.test.bore" = "65 mm"
friction.test.bristle-damping = 3000.0
"""


def command(*arguments, folder):
    return run("sweep", *arguments, folder=folder)


@pytest.fixture
def study(tmp_path):
    def write(text=GOOD):
        path = tmp_path / "masses.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_file_says_what_a_call_says(study):
    file = hc.load_study(study())
    assert (file.name, str(file.store)) == ("masses", "masses.zarr")
    overrides = {"cylinder.test.bore": 0.065, "friction.test.bristle-damping": 3000.0}
    keys = {"payload.mass": [50.0, -1.0, 100.0], "supply.pressure": [100e5, 140e5]}
    same = {
        "measures": ["end(tip.z)"],
        "signals": ["tip.z"],
        "resample": 0.05,
        "overrides": overrides,
        "progress": False,
    }
    found, wanted = file.study.run(progress=False), hc.sweep("single-cylinder-step", keys, **same)
    assert found.equals(wanted) and found.outcome.values[0, 0] == "completed"


def test_paths_are_taken_from_the_folder_of_the_file(study, tmp_path):
    (tmp_path / "my-machine.toml").write_text('extends = "single-cylinder"\n')
    text = GOOD.replace("[study]", '[study]\nmachine = "my-machine.toml"')
    assert hc.load_study(study(text)).study.base_machine.source == str((tmp_path / "my-machine.toml").resolve())


def test_the_example_of_the_project_loads():
    cases = hc.load_study(ROOT / "scenarios/studies/pressure-and-payload.toml").study.cases
    assert cases.shape == (4, 6) and cases.axes[1][0] == pytest.approx(60e5)


WRONG = {
    "no table": ("[study]\nscenario = 'x'\n", ["[keys]"]),
    "no scenario": ("[study]\n[keys]\nseed = [1]\n", ["scenario", "single-cylinder-step"]),
    "unknown key": (GOOD.replace("resample", "resmaple"), ["study.resmaple", "`resample`"]),
    "unknown table": (GOOD.replace("[overrides]", "[override]"), ["override", "`overrides`"]),
    "wrong type": (GOOD.replace('["end(tip.z)"]', '"end(tip.z)"'), ["study.measures", "list"]),
    "a number for a word": (GOOD.replace('"single-cylinder-step"', "1"), ["study.scenario", "str"]),
    "no TOML": ("[study\n", ["masses.toml", "line 1"]),
    "unknown scenario": (GOOD.replace("cylinder-step", "cylinder-stepp"), ["single-cylinder-step"]),
    "unknown measure": (GOOD.replace("end(tip.z)", "end(tip.y)"), ["tip.y"]),
    "unknown override": (GOOD.replace("cylinder.test.bore", "cylinder.test.boer"), ["boer", "`bore`"]),
}


@pytest.mark.parametrize(("text", "words"), WRONG.values(), ids=WRONG)
def test_a_wrong_file_is_one_clear_error(study, text, words):
    with pytest.raises(hc.HydrocraneError) as caught:
        hc.load_study(study(text)).study.run(progress=False)
    for word in words:
        assert word in str(caught.value), str(caught.value)


@pytest.mark.evidence
def test_a_missing_file_is_one_clear_error(tmp_path):
    with pytest.raises(hc.InputError, match="no such study file: .*nowhere.toml"):
        hc.load_study(tmp_path / "nowhere.toml")
    done = command("nowhere.toml", folder=tmp_path)
    assert done.returncode == 2 and "Traceback" not in done.stderr and done.stderr.count("error:") == 1


@pytest.mark.evidence
def test_the_command_runs_a_study_and_goes_on(study, tmp_path):
    study()
    done = command("masses.toml", "--picture", "masses.png", "--workers", 1, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines()]
    assert ["completed", "4", "66.7%"] in rows and ["invalid-input", "2", "33.3%"] in rows
    assert "2 x override" in done.stdout and "masses.zarr" in done.stdout
    assert (tmp_path / "masses.png").stat().st_size > 10_000
    written = (tmp_path / "masses.zarr/outcome/c").stat().st_mtime_ns
    assert command("masses.toml", folder=tmp_path).returncode == 0
    assert (tmp_path / "masses.zarr/outcome/c").stat().st_mtime_ns == written
    study(GOOD.replace("50 kg", "51 kg"))
    other = command("masses.toml", folder=tmp_path)
    assert other.returncode == 2 and "another study" in other.stderr and "--overwrite" in other.stderr
    assert command("masses.toml", "--overwrite", folder=tmp_path).returncode == 0


@pytest.mark.evidence
def test_a_wrong_measure_for_the_picture_costs_no_runs(study, tmp_path):
    study()
    done = command("masses.toml", "--picture", "a.png", "--measure", "end(tip.x)", folder=tmp_path)
    assert done.returncode == 2 and "end(tip.z)" in done.stderr and not (tmp_path / "masses.zarr").exists()


@pytest.mark.evidence
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(study, tmp_path):
    text = GOOD.replace("count = 2", "count = 100000").replace('signals = ["tip.z"]', "signals = []")
    study(text)
    running = subprocess.Popen(
        [sys.executable, "-m", "hydrocrane", "sweep", "masses.toml"], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    chunks = tmp_path / "masses.zarr/outcome/c"
    deadline = time.monotonic() + 240
    while not (chunks.exists() and any(chunks.iterdir())) and time.monotonic() < deadline:
        time.sleep(0.02)
    os.kill(running.pid, signal.SIGINT)
    message = running.communicate(timeout=240)[1]
    assert running.returncode == 1 and "Traceback" not in message, message
    assert "of 300000 cases; the same call resumes there" in " ".join(message.split())
    done = int((hc.open_study(tmp_path / "masses.zarr").outcome.values != "").sum())
    assert 0 < done < 300000 and f"stopped after {done} of" in " ".join(message.split())


# --- pictures -------------------------------------------------------------------------------------------------------


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    plt.close("all")


def studied(keys, **options):
    return hc.sweep("single-cylinder-step", keys, duration=0.3, progress=False, **options)


def test_one_key_is_a_line_in_the_units_of_pictures():
    data = studied({"supply.pressure": [100e5, 120e5, 140e5]})
    axes = hc.plots.sweep(data, "largest_pressure").axes[0]
    (line,) = axes.lines
    assert np.allclose(line.get_xdata(), [100, 120, 140])
    assert np.allclose(line.get_ydata(), data["largest_pressure"].values / 1e5)
    assert axes.get_xlabel() == "supply.pressure [bar]" and axes.get_ylabel() == "largest_pressure [bar]"


def test_two_keys_are_a_field_with_failed_cases_marked():
    data = studied({"payload.mass": [100.0, 50.0, -1.0], "solver.method": ["tsit5", "rodas5p"]})
    axes = hc.plots.sweep(data, "tip_way").axes[0]
    # Rows from the smallest mass upwards, the words in alphabetic order.
    wanted = data["tip_way"].values[[2, 1, 0]][:, [1, 0]] * 1e3
    assert np.allclose(np.ma.filled(axes.collections[0].get_array(), np.nan), wanted, equal_nan=True)
    assert axes.lines[0].get_ydata().tolist() == [-1.0, -1.0]
    assert [text.get_text() for text in axes.get_xticklabels()] == ["rodas5p", "tsit5"]


def test_drawn_cases_are_points_over_each_key():
    keys = {"payload.mass": (50.0, 90.0), "supply.pressure": ("100 bar", "140 bar")}
    data = studied(keys, method="latin", n=6)
    panels = hc.plots.sweep(data, "tip_way").axes
    assert [axes.get_xlabel() for axes in panels] == ["payload.mass [kg]", "supply.pressure [bar]"]
    assert np.allclose(panels[1].lines[0].get_xdata(), data["supply.pressure"].values / 1e5)


def test_what_cannot_be_drawn_is_said():
    keys = {"payload.mass": [50.0, 60.0], "supply.pressure": [1e7, 2e7], "seed": [1.0, 2.0]}
    data = studied(keys, signals=["tip.z"])
    with pytest.raises(hc.InputError, match=r"choose values of seed"):
        hc.plots.sweep(data, "tip_way")
    assert hc.plots.sweep(data.sel(seed=1.0), "tip_way").axes
    with pytest.raises(hc.InputError, match="tip_wya"):
        hc.plots.sweep(data, "tip_wya")
    with pytest.raises(hc.InputError, match="figure of the study"):
        hc.plots.sweep(data, "tip.z")
    with pytest.raises(hc.InputError, match="one case"):
        hc.plots.sweep(data.isel({name: [0] for name in keys}), "tip_way")
