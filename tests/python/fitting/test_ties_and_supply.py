"""Values that move in proportion to fitted ones, and logs that bring the pressure of the supply."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import hydrocrane as hc
from hydrocrane.app.cli import app
from hydrocrane.identification.values.doubts import doubtful_columns
from hydrocrane.identification.values.parameters import left_behind
from hydrocrane.results.comparison import Difference

DURATION = 8.0
# The file's friction is two thirds of the truth's, in the same proportion.
TRUTH = {"friction.lift.coulomb": [420, 735], "friction.lift.breakaway": [840, 1470]}
FILE = {"friction.lift.coulomb": [280, 735], "friction.lift.breakaway": [560, 1470]}
MASS, COULOMB = 130.0, 420.0
TIE = {"friction.lift.breakaway[0]": "friction.lift.coulomb[0]"}
NAMES = ["payload.mass", "friction.lift.coulomb[0]"]


def plan() -> hc.Scenario:
    times = [0.0, 0.5, 2.5, 3.0, 5.0, 5.5, 7.5]
    lift, jib = [0, 0.03, 0.0, -0.03, 0.0, 0.02, 0.0], [0, -0.03, 0.0, 0.03, 0.0, -0.02, 0.0]
    pose = {"boom": 1.3, "jib": 1.8, "extension": 0.2}
    return hc.Scenario(
        joints=pose, duration=DURATION, payload=100.0, commands={"lift": (times, lift), "jib": (times, jib)}
    )


@pytest.fixture(scope="module")
def log() -> dict[str, np.ndarray]:
    """A crane on a supply that sags, as a logger has it."""
    rng = np.random.default_rng(3)
    times = np.arange(0.0, DURATION + 0.01, 0.05)
    sagging = 140e5 - 35e5 * np.sin(0.7 * times) ** 2 - 10e5 * (times > 5.0)
    run = hc.simulate(plan(), supply=(times, sagging), payload=MASS, overrides=TRUTH, rtol=1e-6)
    noise = {"joint.boom.q": 2e-4, "joint.jib.q": 2e-4, "joint.extension.q": 2e-4, "mains.p": 3e4}
    noise |= {f"cylinder.{c}.p{side}": 3e4 for c in ("lift", "jib") for side in (1, 2)}
    columns = {
        name: run.columns[name].values + rng.normal(0.0, by, len(run.columns.time)) for name, by in noise.items()
    }
    columns["supply.pressure"] = columns.pop("mains.p")
    columns["supply.pressure"][300:303] = np.nan
    return {"time": run.columns.time, **columns}


@pytest.fixture(scope="module")
def tied(log: dict[str, np.ndarray]) -> hc.Fit:
    return hc.fit(plan(), log, NAMES, ties=TIE, overrides=FILE, priors={"payload.mass": 50.0})


@pytest.mark.evidence
def test_the_logged_supply_pressure_is_replayed(log: dict[str, np.ndarray], tied: hc.Fit):
    low, high = tied.interval("payload.mass")
    assert low <= MASS <= high and high - low < 2.0
    assert all(q.share < 0.02 for q in tied.quality if "extension" not in q.signal)
    without = {name: column for name, column in log.items() if name != "supply.pressure"}
    constant = hc.fit(plan(), without, NAMES, overrides=FILE, priors={"payload.mass": 50.0})
    assert max(q.rms / q.noise for q in constant.quality) > 5.0 * max(q.rms / q.noise for q in tied.quality)
    assert any("something that is not fitted is wrong" in warning for warning in constant.warnings)


def test_what_is_tied_keeps_its_proportion(tied: hc.Fit, tmp_path):
    low, high = tied.interval(NAMES[1])
    assert low <= COULOMB <= high
    friction = [tied.machine.value(f"friction.lift.{key}").si for key in ("coulomb", "breakaway")]
    assert friction[1][0] == pytest.approx(2.0 * friction[0][0]) and friction[1][1] == 1470.0
    assert not any("is unchanged while" in warning for warning in tied.warnings)
    assert "friction.lift.breakaway[0] moves with it, 2 times" in tied.summary()
    tied.write(tmp_path / "fitted.toml")
    (tmp_path / "mine.toml").write_text(
        'extends = "rottne-f9-lab"\ninclude = ["fitted.toml"]\n[machine]\nname = "mine"\n'
    )
    mine = hc.load_machine(tmp_path / "mine.toml")
    assert mine.value("friction.lift.breakaway").si == pytest.approx(friction[1], rel=1e-5)


def test_break_away_that_stays_behind_is_said(log: dict[str, np.ndarray]):
    found = hc.fit(plan(), log, NAMES, overrides=FILE, priors={"payload.mass": 50.0})
    told = [warning for warning in found.warnings if "is unchanged while" in warning]
    assert len(told) == 1 and "ties={'friction.lift.breakaway[0]': 'friction.lift.coulomb[0]'}" in told[0]
    assert not list(left_behind(found.start, found.machine, [*NAMES, "friction.lift.breakaway[0]"], ()))


@pytest.mark.evidence
def test_what_is_wrong_with_the_supply_pressure_is_said(log: dict[str, np.ndarray]):
    bars = log | {"supply.pressure": 1e-5 * log["supply.pressure"]}
    found = hc.fit(plan(), bars, NAMES[:1], overrides=FILE)
    assert any("0.0014 bar at most" in note and "check its column and its unit" in note for note in found.notes)
    volts = log | {"cylinder.lift.command": np.zeros(log["time"].size)}
    for name, unit, words in [
        ("supply.pressure", "N", "is in N and is replayed in Pa"),
        ("cylinder.lift.command", "V", "is in V and is replayed in m; state what one of its numbers means"),
    ]:
        columns = {column: {"column": column} for column in volts if column != "time"}
        columns[name]["unit"] = unit
        with pytest.raises(hc.HydrocraneError, match=words):
            hc.fit(plan(), volts, NAMES, mapping={"signal": columns})


def test_a_column_that_fits_no_worse_as_it_is_is_not_called_swapped():
    time = np.linspace(0.0, 10.0, 500)
    wave, other = np.sin(time), np.cos(3.0 * time)
    names = [f"cylinder.{cylinder}.pressure_force" for cylinder in ("extension", "lift")]

    def told(small: np.ndarray, large: np.ndarray) -> list[str]:
        pairs = {names[0]: (other, small), names[1]: (wave, large)}
        known = {("log", n): Difference(n, "N", time, run, log) for n, (run, log) in pairs.items()}
        return [text for text in doubtful_columns(known) if "columns exchanged" in text]

    assert len(told(wave, other)) == 1
    assert not told(0.3 * wave + 0.1 * other, wave)


def test_ties_of_a_measured_motion(log: dict[str, np.ndarray]):
    given = {"motion": "measured", "overrides": FILE, "priors": {"payload.mass": 50.0}}
    found = hc.fit(plan(), log, [*NAMES, "joint.boom.q.zero"], ties=TIE, **given)
    friction = [found.machine.value(f"friction.lift.{key}").si[0] for key in ("coulomb", "breakaway")]
    assert friction[1] == pytest.approx(2.0 * friction[0])
    assert found.value("payload.mass") == pytest.approx(MASS, rel=0.05)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"ties": {"friction.lift.breakaway[0]": "friction.lift.colomb[0]"}}, r"coulomb\[0\]"),
        ({"ties": {"friction.lift.coulomb[0]": "payload.mass"}}, "moves it too"),
        ({"ties": {"friction.lift.breakaway": "friction.lift.coulomb[0]"}}, r"friction.lift.breakaway\[0\]"),
        ({"ties": {"friction.lift.breakway[0]": "friction.lift.coulomb[0]"}}, "breakaway"),
        ({"ties": ["friction.lift.breakaway[0]"]}, "pairs of keys"),
        ({"ties": {"friction.lift.breakaway[0]": "payload.mass"}, "payload": 0.0}, "is zero"),
        ({"parameters": [*NAMES, "supply.pressure"]}, "does not enter a run that follows a measured supply"),
        ({"machine": "rottne-f9-pump"}, "follows from its pump; map the column to `mains.p`"),
    ],
)
def test_bad_input_is_refused_with_its_cure(log: dict[str, np.ndarray], arguments: dict, message: str):
    given = {"scenario": plan(), "logs": log, "parameters": NAMES, "overrides": FILE, **arguments}
    with pytest.raises(hc.HydrocraneError, match=message):
        hc.fit(**given)


def test_the_command_line_ties_keys(log: dict[str, np.ndarray], tmp_path):
    rows = np.column_stack(list(log.values()))
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=",".join(log), comments="")
    (tmp_path / "plan.toml").write_text(plan().to_toml())
    text = [str(tmp_path / "plan.toml"), str(tmp_path / "log.csv"), "-p", NAMES[1], "--tie", "=".join(*TIE.items())]
    texts = {key: [f"{force} N" for force in pair] for key, pair in FILE.items()}
    sets = [part for key, pair in texts.items() for part in ("--set", f"{key}={json.dumps(pair)}")]
    done = CliRunner().invoke(app, ["fit", *text, *sets, "--payload", "130"])
    assert done.exit_code == 0, done.output
    assert "moves with it" in done.output
    wrong = CliRunner().invoke(app, ["fit", *text[:4], "--tie", "friction.lift.breakaway[0]"])
    assert "--tie takes KEY=PARAMETER" in str(wrong.exception)
