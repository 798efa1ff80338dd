"""The command from logs to a friction block: the whole way, what is wrong with logs, and what remains of bad ones."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import rig
from hydrocrane.app.cli import main
from hydrocrane.identification import FrictionPoints, fit_static
from hydrocrane.identification.sensors import linearity_error
from hydrocrane.signals import steady_windows

TRUTH = hc.load_machine("rig-rottne")
LEVELS = [0.05, 0.02, 0.01, 0.005, 0.002, 0.001]
# What spans of 0.3 % leave of the friction's error after a zero calibration, three standard deviations, N.
SPAN = 40.0


@pytest.fixture(scope="module")
def steady():
    """Six levels both ways with 20 kg, data-sheet sensors, one second of calibration."""
    return rig.run("constant-velocity", payload=20.0, seed=2, calibration=1.0, levels=LEVELS, interval=0.01)


@pytest.fixture(scope="module")
def log(steady):
    return hc.Log.of(steady)


@pytest.fixture(scope="module")
def found(steady):
    return hc.identify_friction(steady, "rig-rottne")


def command(*arguments) -> int:
    with pytest.raises(SystemExit) as ended:
        main(["identify", "friction", *map(str, arguments)])
    return int(ended.value.code or 0)


def changed(log, **signals):
    """The log with other values of signals, checked anew."""
    data = log.data.copy(deep=True)
    for name, values in signals.items():
        data[name] = ("time", np.asarray(values, dtype=float), data[name].attrs)
    return hc.Log.of(data, source=log.source)


def failed(found) -> dict[str, str]:
    return {stage.name: stage.message for stage in found.failures}


# --- the whole way --------------------------------------------------------------------------------------------------


@pytest.mark.evidence
def test_a_log_of_the_rig_needs_no_option(steady, tmp_path, monkeypatch, capsys):
    """File, command, block, machine file: the machine then has the numbers of the block."""
    monkeypatch.chdir(tmp_path)
    steady.save("levels.csv")
    assert command("levels.csv", "--rig", "rig-rottne", "--report", "page.html", "--write", "friction.toml") == 0
    told = capsys.readouterr()
    assert "coulomb.extending" in told.out and "friction.toml" in told.out and not told.err
    Path("mine.toml").write_text('extends = "rig-rottne"\ninclude = ["friction.toml"]\n', encoding="utf-8")
    mine = hc.load_machine("mine.toml")
    block = Path("friction.toml").read_text(encoding="utf-8")
    stated = re.search(r'coulomb = \["(\S+) N", "(\S+) N"\]', block)
    assert stated is not None
    assert list(mine.value("friction.test.coulomb").si) == [float(stated[1]), float(stated[2])]
    assert mine.value("friction.test.coulomb").provenance == "fitted"
    assert "levels.csv" in mine.value("friction.test.coulomb").source
    assert f"hydrocrane {hc.__version__}" in mine.value("friction.test.coulomb").source
    for key in ("coulomb", "breakaway"):
        assert mine.value(f"friction.test.{key}").si == pytest.approx(TRUTH.value(f"friction.test.{key}").si, abs=SPAN)
    assert mine.value("friction.test.viscous").si == pytest.approx(TRUTH.value("friction.test.viscous").si, rel=0.05)


@pytest.mark.evidence
def test_the_report_is_one_file_that_needs_no_other(found, tmp_path):
    page = found.report().write(tmp_path / "page.html").read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page)
    assert page.count("<img") == 3 and "Not finished" not in page
    assert all(f"{name}</h2>" in page for name in ("Result", "Logs", "Parameters", "Block for the machine file"))


def test_zero_load_and_role_come_from_the_file(found):
    (record,) = found.records
    assert (record.role, record.payload, record.supply) == ("steady", 20.0, 140e5)
    assert record.zero is not None and record.log.time[0] >= 1.0
    # Weight and zero are right: 20 kg are 196 N, and a zero may be 236 N off.
    assert found.static.fit.params["coulomb"] == pytest.approx(TRUTH.value("friction.test.coulomb").si, abs=SPAN)


def test_the_stages_do_what_the_functions_do(found):
    """The chain by hand gives the same map."""
    record = found.records[0]
    windows = steady_windows(record.log, found.windows[0].rig)
    points, bias = FrictionPoints.from_windows(windows), record.zero.force_error(windows.rig)
    by_hand = fit_static(points, bias=bias, span=0.003 / np.sqrt(3), linearity_error=linearity_error(TRUTH))
    assert by_hand.covariance.values == pytest.approx(found.static.fit.covariance.values, rel=1e-6)
    assert by_hand.law.values == pytest.approx(found.static.fit.law.values, rel=1e-7)


def test_a_stretch_at_zero_pressure_can_be_named(log, found):
    bare = log.data.assign_attrs(calibration=0.0)
    again = hc.identify_friction(hc.Log(bare, source="a"), "rig-rottne", zero=(0.0, 1.0))
    assert again.static.fit.params == found.static.fit.params
    without = hc.identify_friction(hc.Log(bare.sel(time=slice(1.0, None)), source="a"), "rig-rottne")
    assert any("zero calibration" in text for text in without.warnings)
    (low, high), (lowest, highest) = (f.static.fit.intervals()["coulomb.extending"] for f in (again, without))
    assert lowest < low < high < highest


def test_the_load_cell_stands_in_for_the_weight(steady):
    """A wrong load does not matter then; without the cell it shifts friction by its weight."""
    with_cell = hc.identify_friction(steady, "rig-rottne", load_cell=True, payload=0.0)
    assert with_cell.static.fit.params["coulomb"] == pytest.approx(TRUTH.value("friction.test.coulomb").si, abs=SPAN)
    without = hc.identify_friction(steady, "rig-rottne", payload=30.0)
    shift = np.subtract(without.static.fit.params["coulomb"], TRUTH.value("friction.test.coulomb").si)
    assert shift == pytest.approx([98.1, -98.1], abs=SPAN)
    assert any("30 kg is taken" in text for text in without.warnings)


@pytest.mark.evidence
def test_logs_of_several_loads_are_compared(steady):
    heavy = rig.run(
        "constant-velocity", payload=115.0, seed=2, calibration=1.0, levels=LEVELS, interval=0.01,
        overrides=rig.loaded_friction("rig-rottne"),
    )  # fmt: skip
    found = hc.identify_friction([steady, heavy], "rig-rottne")
    assert found.comparison.conclusion == "different" and set(found.comparison.fits) == {"20 kg", "115 kg"}
    assert any("one map was fitted to all logs" in text for text in found.warnings)


def test_the_block_can_be_named_for_another_machine(found, tmp_path):
    path = found.write(tmp_path / "arm.toml", cylinder="extension")
    (tmp_path / "crane.toml").write_text('extends = "rottne-f9-lab"\ninclude = ["arm.toml"]\n', encoding="utf-8")
    crane = hc.load_machine(tmp_path / "crane.toml")
    assert crane.value("friction.extension.viscous").provenance == "fitted"
    assert 'include = ["arm.toml"]' in path.read_text(encoding="utf-8")


# --- what is wrong with a log ---------------------------------------------------------------------------------------


def part(log, start, end):
    return hc.Log.of(log.data.sel(time=slice(start, end)), source="part")


SPOILT = {
    "no p1": (lambda log: changed(log, p1=np.full(log.time.size, np.nan)), "logs", ["p1", "finite"]),
    "clock goes back": (
        lambda log: hc.Log.of(log.data.assign_coords(time=np.minimum(log.time, 20.0)), source="clock"),
        "logs", ["time does not increase", "20 s"],
    ),
    "bar for Pa": (lambda log: changed(log, p1=log["p1"] / 1e5, p2=log["p2"] / 1e5), "logs", ["bar", "unit"]),
    "mm for m": (lambda log: changed(log, x=log["x"] * 1e3), "logs", ["travels", "mm"]),
    "ten samples": (lambda log: part(log, 0.0, 0.05), "logs", ["samples"]),
    "at rest": (
        lambda log: changed(log, x=1e-5 * np.random.default_rng(0).normal(size=log.time.size)),
        "steady windows", ["rests", "constant velocities"],
    ),
    "pressures exchanged": (lambda log: changed(log, p1=log["p2"], p2=log["p1"]), "steady windows", ["exchanged"]),
    "other sign of x": (lambda log: changed(log, x=-log["x"]), "steady windows", ["sign of x"]),
}  # fmt: skip


@pytest.mark.parametrize("case", SPOILT)
def test_a_spoilt_log_fails_its_stage_and_says_why(log, case):
    spoil, stage, words = SPOILT[case]
    found = hc.identify_friction(spoil(log), "rig-rottne")
    assert found.static is None and all(word in failed(found)[stage] for word in words)
    page = found.report().html()
    assert "Not finished" in page and words[0] in page
    with pytest.raises(hc.InputError, match="nothing was identified"):
        found.toml()


def test_a_spoilt_log_does_not_cost_the_others(log, found):
    spoilt = changed(log, p1=log["p2"], p2=log["p1"])
    both = hc.identify_friction([log, spoilt], "rig-rottne")
    assert both.static.fit.params == found.static.fit.params
    assert list(failed(both)) == ["steady windows"]
    assert "# Not finished: steady windows" in both.toml()


FLAGGED = {
    "values missing": (
        lambda log: changed(log, p1=np.where((log.time > 8.0) & (log.time < 9.0), np.nan, log["p1"])), "misses",
    ),
    "gap": (lambda log: hc.Log.of(log.data.isel(time=(log.time < 8.0) | (log.time > 12.0)), source="gap"), "no sample"),
    "frozen": (
        lambda log: changed(log, p2=np.where(log.time > 40.0, log["p2"][4000], log["p2"])), "is exactly",
    ),
    "saturated": (lambda log: changed(log, p1=np.minimum(log["p1"], np.quantile(log["p1"], 0.7))), "end of its range"),
    "cut off": (lambda log: part(log, 0.0, 0.6 * log.time[-1]), "was it cut"),
    "one level": (lambda log: part(log, 0.0, 3.4), "one velocity level"),
}  # fmt: skip


@pytest.mark.parametrize("case", FLAGGED)
def test_what_is_left_of_a_damaged_log_is_used_and_said(log, case):
    spoil, word = FLAGGED[case]
    found = hc.identify_friction(spoil(log), "rig-rottne")
    assert any(word in text for text in found.warnings), found.warnings
    assert found.static is not None and word in found.summary()


def test_one_level_of_one_direction_gives_no_block(log, tmp_path):
    found = hc.identify_friction(part(log, 0.0, 3.4), "rig-rottne")
    table, _, warnings = found.summary().partition("warning: ")
    assert table.count("not identifiable") == 4 and "not identifiable" in warnings
    with pytest.raises(hc.InputError, match="retracting"):
        found.write(tmp_path / "friction.toml")


# --- bristles -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ramp():
    return hc.Log.of(rig.run("ramp", payload=20.0, seed=2, calibration=1.0, interval=0.01))


@pytest.mark.evidence
def test_bristles_are_fitted_on_the_identified_map(steady, ramp, tmp_path):
    told = []
    found = hc.identify_friction([steady, ramp], "rig-rottne", progress=told.append)
    assert not found.failures and found.dynamic.static is found.static.fit
    low, high = found.dynamic.intervals(0.999)["bristle-stiffness"]
    assert low < TRUTH.value("friction.test.bristle-stiffness").si < high
    assert any("evaluation" in text for text in told)
    found.write(tmp_path / "friction.toml")
    (tmp_path / "mine.toml").write_text('extends = "rig-rottne"\ninclude = ["friction.toml"]\n', encoding="utf-8")
    mine = hc.load_machine(tmp_path / "mine.toml")
    for name, value in found.dynamic.params.items():
        assert mine.value(f"friction.test.{name}").si == pytest.approx(value, rel=1e-4)
    assert mine.value("friction.test.bristle-damping-velocity").provenance == "assumed"
    # A ramp alone says nothing of the damping: the search ends at its bound, and no number claims to know it.
    assert any(text.startswith("bristle-damping") and "not identifiable" in text for text in found.warnings)
    assert found.dynamic.intervals()["bristle-damping"] == (-np.inf, np.inf)
    assert re.search(r"bristle-damping .*not identifiable", found.dynamic.summary())
    assert re.search(r"bristle-damping .*not identifiable", found.toml())


@pytest.mark.evidence
def test_a_later_stage_that_fails_leaves_the_earlier_ones(steady, ramp, found):
    other = hc.Log(ramp.data.assign_attrs(payload=0.0, experiment="step"), source="step.csv")
    both = hc.identify_friction([steady, ramp, other], "rig-rottne")
    assert "different loads, 0, 20 kg" in failed(both)["bristles"]
    assert both.static.fit.params == found.static.fit.params
    assert "Not finished" in both.report().html() and 'model = "static"' in both.toml()


def test_a_ramp_without_its_command_is_named(ramp):
    with pytest.raises(hc.InputError, match="command"):
        hc.identify_friction((), "rig-rottne", ramps=hc.Log(ramp.data.drop_vars("command"), source="a"))


# --- what is wrong with the call ------------------------------------------------------------------------------------

WRONG_FILES = {
    "missing.csv": (None, "no such file"),
    "empty.csv": (b"", "is empty"),
    "letter.csv": (b"Dear sir,\nplease find enclosed.\n", "no row of numbers"),
    "picture.csv": (b"\x89PNG\x00\x01\x02", "binary"),
    "other.mat": (b"Dear sir,", "not a MATLAB file"),
    "other.nc": (b"Dear sir,", "not a NetCDF file"),
    "log.xls": (b"1", "unknown suffix"),
    "foreign.csv": (b"t,Length,Ptop\n" + b"0,1,2\n" * 20, "no signal `x`"),
}


@pytest.mark.parametrize("name", WRONG_FILES)
def test_a_file_that_is_no_log_is_one_error(name, tmp_path, monkeypatch, capsys):
    content, word = WRONG_FILES[name]
    monkeypatch.chdir(tmp_path)
    if content is not None:
        Path(name).write_bytes(content)
    assert command(name, "--rig", "rig-rottne", "--report", "page.html") == 2
    told = capsys.readouterr().err
    assert name.split(".")[0] in told and word in told and told.count("error:") == 1
    assert not Path("page.html").exists()


@pytest.mark.evidence
def test_a_window_cuts_every_log_and_the_zero_is_read_before_it(log, found):
    """Here the first level is left out; so is a start that spoils the whole log."""
    start, end = found.windows[0][0].end, float(log.time[-1])
    cut = hc.identify_friction(log, "rig-rottne", window=(start, end))
    assert cut.records[0].log.time[0] == pytest.approx(start, abs=0.02)
    assert cut.records[0].zero.errors == found.records[0].zero.errors
    assert len(cut.windows[0]) == len(found.windows[0]) - 1
    assert cut.windows[0][0].force == pytest.approx(found.windows[0][1].force, rel=1e-6)
    time = log.time.copy()
    time[:3] = time[2::-1]
    jumped = hc.Log.of(log.data.assign_coords(time=time), source="a")
    assert "time" in failed(hc.identify_friction(jumped, "rig-rottne"))["logs"]
    assert not hc.identify_friction(jumped, "rig-rottne", window=(start, end)).failures


def test_a_window_can_be_said_on_the_command_line(steady, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    steady.save("a.csv")
    assert command("a.csv", "--window", "1:1.9") == 1
    assert "rests" in capsys.readouterr().err


WRONG_OPTIONS = {
    "no log": ([], "no log was given"),
    "folder": (["."], "is a folder"),
    "crane for a rig": (["a.csv", "--rig", "rottne-f9-lab"], "one cylinder"),
    "no such rig": (["a.csv", "--rig", "rig-rotne"], "rig-rottne"),
    "negative load": (["a.csv", "--payload=-3"], "zero or greater"),
    "zero of one time": (["a.csv", "--zero", "1"], "FROM:TO"),
    "zero backwards": (["a.csv", "--zero", "2:1"], "FROM before TO"),
    "zero outside": (["a.csv", "--zero", "900:901"], "0 samples between 900 and 901 s"),
    "zero under pressure": (["a.csv", "--zero", "3:4"], "data sheet allows 1.2 bar"),
    "window backwards": (["a.csv", "--window", "9:2"], "FROM before TO"),
    "window outside": (["a.csv", "--window", "900:901"], "no sample between 900 and 901 s"),
    "role": (["--ramp", "a.csv"], "given as a ramp, but states that it is a `constant-velocity`"),
    "report": (["a.csv", "--report", "page.pdf"], ".html"),
    "block": (["a.csv", "--write", "friction.txt"], ".toml"),
    "mapping": (["a.csv", "--mapping", "map.toml"], "map.toml"),
}


@pytest.mark.parametrize("case", WRONG_OPTIONS)
def test_a_wrong_option_is_one_error(case, steady, tmp_path, monkeypatch, capsys):
    arguments, word = WRONG_OPTIONS[case]
    monkeypatch.chdir(tmp_path)
    if "a.csv" in arguments:
        hc.Log(steady.data.isel(time=slice(0, 3000))).save("a.csv")
    assert command(*arguments) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert word in told and told.count("error:") == 1


def test_a_load_that_is_no_number_is_named(log):
    with pytest.raises(hc.InputError, match="twenty"):
        hc.identify_friction(hc.Log(log.data.assign_attrs(payload="twenty"), source="a"), "rig-rottne")


def test_other_rigs_and_unused_experiments_are_said(log):
    foreign = hc.Log(log.data.assign_attrs(machine="rig-kalmar", experiment="break-away"), source="a")
    found = hc.identify_friction([log, foreign], "rig-rottne")
    assert any("recorded on rig-kalmar" in text for text in found.warnings)
    assert any("no stage uses" in text for text in found.warnings)
    assert [record.role for record in found.records] == ["steady", ""]


def test_a_failed_stage_is_exit_status_one(log, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    changed(log, p1=log["p2"], p2=log["p1"]).save("swapped.csv")
    assert command("swapped.csv", "--report", "page.html", "--write", "friction.toml") == 1
    told = capsys.readouterr()
    assert "steady windows failed" in told.err and "nothing was identified" in told.err
    assert Path("page.html").exists() and not Path("friction.toml").exists()


# --- the page ---------------------------------------------------------------------------------------------------------


@pytest.mark.evidence
def test_a_report_of_fifteen_logs_stays_small(steady, tmp_path):
    """Curves of whole logs are pixels. What was left out stands after the result."""
    found = hc.identify_friction([hc.Log.of(steady.reread(seed)) for seed in range(15)], "rig-rottne")
    page = found.report().write(tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count("<img") == 17 and page.count("data:image/png") >= 15
    assert len(page.encode()) < 3e6
    places = [page.index(f"{title}</h2>") for title in ("Result", "Parameters", "Points left out", "Windows left out")]
    assert places == sorted(places)


@pytest.mark.browser
def test_no_table_is_wider_than_a_page_of_1200_pixels(steady, tmp_path, browser):
    """27 parameters and errors of sensors: the widest table that a campaign of 15 logs has."""
    found = hc.identify_friction([hc.Log.of(steady.reread(seed)) for seed in range(15)], "rig-rottne")
    assert len(found.static.fit.spread.labels) > 20
    path = found.static.report("test").write(tmp_path / "page.html")
    wide = "[...document.querySelectorAll('.table')].filter(t => t.scrollWidth > t.clientWidth).length"
    page = browser.new_page(viewport={"width": 1200, "height": 900})
    page.goto(path.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= 1200
    assert page.evaluate("document.querySelectorAll('.table').length") > 5
    assert page.evaluate(wide) == 0
