"""What is wrong with an export, an FMU or a call is one clear message and an error of FMI, never a crash."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import command_line
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmu_in_fmpy import STEP, Unit, inputs

import hydrocrane as hc
from hydrocrane.errors import InputError, MachineFileError
from hydrocrane.export import platforms


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def fmi(request):
    return request.param


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """One export for each version of FMI."""
    folder = tmp_path_factory.mktemp("exports")
    return {fmi: hc.export_fmu("rottne-f9-lab", folder / f"{fmi}.fmu", fmi=fmi) for fmi in (2, 3)}


@pytest.fixture
def unit(fmi, files, tmp_path):
    made = Unit(files[fmi], tmp_path / "unzipped")
    yield made
    if made.fmu.component:
        made.close()


# --- exports --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"source": "rottne-f9-labb"}, "rottne-f9-lab"),
        ({"path": "crane.zip"}, "ends in .fmu"),
        ({"fmi": 1}, "2 or 3"),
        ({"controller": "tipp"}, "did you mean `tip`"),
        ({"controller": "tip", "sensors": "data-sheet"}, "sensors are those of a plant"),
        ({"sensors": "real"}, "kind of sensors"),
        ({"monitor": True}, "part of a controller"),
        ({"platforms": ["linux-x86"]}, "linux-x86_64"),
        ({"platforms": ["windows-x86_64"]}, "make fmu"),
        ({"parameters": ["supply.colour"]}, "no number at `supply.colour`"),
        ({"step": -1.0}, "greater than zero"),
    ],
)
def test_a_wrong_export_names_what_is_wrong(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(platforms, "installed", lambda: ("linux-x86_64",))
    given = {"source": "rottne-f9-lab", "path": "crane.fmu", **arguments}
    with pytest.raises(hc.HydrocraneError, match=words):
        hc.export_fmu(given.pop("source"), given.pop("path"), **given)
    assert not list(tmp_path.iterdir())


def test_an_invalid_machine_is_told_with_its_place(tmp_path):
    (tmp_path / "bad.toml").write_text(
        'extends = "rottne-f9-lab"\n[supply]\nclass = "assumed"\npressure = "140 baar"\n', encoding="utf-8"
    )
    with pytest.raises(MachineFileError, match="bad.toml:4.*supply.pressure"):
        hc.export_fmu(tmp_path / "bad.toml", tmp_path / "one.fmu")


def test_an_installation_without_libraries_says_what_builds_them(tmp_path, monkeypatch):
    monkeypatch.setattr(platforms, "LIBRARIES", tmp_path)
    with pytest.raises(InputError, match="does not have any FMU library.*make fmu"):
        hc.export_fmu("single-cylinder", tmp_path / "one.fmu")


def test_what_a_scenario_states_against_time_is_no_part_of_an_fmu(tmp_path):
    plan = hc.load_scenario("vertical-lift-open-loop").changed(payload_changes={1.0: 50.0})
    with pytest.raises(InputError, match="payload_changes"):
        hc.export_fmu(plan, tmp_path / "one.fmu")
    failing = hc.SensorFault("joint.boom.q", "freeze", 0.5)
    with pytest.raises(InputError, match="sensors that fail against time.*leave `sensor_faults` out"):
        hc.export_fmu(hc.load_scenario("tip-vertical-line").changed(sensor_faults=[failing]), tmp_path / "failing.fmu")


def test_a_start_that_the_machine_cannot_take_is_told_at_once(tmp_path):
    plan = hc.Scenario(joints={"boom": 3.3, "jib": 1.7, "extension": 0.0})
    with pytest.raises(hc.HydrocraneError, match="boom"):
        hc.export_fmu(plan, tmp_path / "one.fmu")


def test_the_command_line_exports_and_lists_platforms(tmp_path):
    done = command_line.run(
        "export", "fmu", "rottne-f9-lab", "--at", "boom=110 deg", "-o", "crane.fmu", folder=tmp_path
    )
    assert done.returncode == 0 and (tmp_path / "crane.fmu").is_file(), done.stderr
    listed = command_line.run("export", "--platforms").stdout
    assert all(name in listed for name in platforms.PLATFORMS) and "yes" in listed
    wrong = command_line.run("export", "fmu", "rottne-f9-lab", "--platform", "amiga", folder=tmp_path)
    assert wrong.returncode == 2 and "unknown platform `amiga`" in wrong.stderr
    assert not (tmp_path / "rottne-f9-lab.fmu").exists()


# --- files of an FMU ------------------------------------------------------------------------------------------------


def refused(unit: Unit) -> str:
    """The message with which an instance is not made."""
    with pytest.raises(Exception, match="(?i)failed to instantiate"):
        unit.instantiate()
    assert len(unit.messages.texts) == 1
    return unit.messages.texts[0]


def resources(unit: Unit) -> Path:
    return Path(unit.fmu.unzipDirectory) / "resources"


def test_missing_files_are_named(unit):
    (resources(unit) / "machine.toml").unlink()
    assert "machine.toml" in refused(unit) and "unzip the whole FMU" in unit.messages.texts[0]


def test_a_missing_folder_is_named(unit):
    shutil.rmtree(resources(unit))
    assert "fmu.json" in refused(unit)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("machine.toml", b"\xff\xfe\x00", "no text"),
        ("machine.toml", b"pressure = = 3", "not valid TOML"),
        ("machine.toml", b"[machine]\nname = 'x'\n", "machine.toml"),
        ("scenario.toml", b"[scenario]\n", "scenario.toml"),
        ("fmu.json", b"{", "fmu.json is damaged"),
        ("fmu.json", b'{"role": "plant", "parameters": [], "token": 3, "version": ""}', "fmu.json is damaged"),
    ],
)
def test_damaged_files_are_told(unit, name, content, words):
    (resources(unit) / name).write_bytes(content)
    assert words in refused(unit)


def test_files_of_two_exports_are_not_mixed(unit):
    file = resources(unit) / "fmu.json"
    settings = json.loads(file.read_text(encoding="utf-8"))
    file.write_text(json.dumps({**settings, "token": "{other}"}), encoding="utf-8")
    assert "two exports" in refused(unit)


def test_a_read_only_folder_is_enough(unit):
    folder = resources(unit)
    for path in (*folder.iterdir(), folder, folder.parent):
        path.chmod(0o555 if path.is_dir() else 0o444)
    try:
        unit.begin()
        unit.step(0.0)
    finally:
        for path in (folder.parent, folder):
            path.chmod(0o755)


# --- calls ----------------------------------------------------------------------------------------------------------


def told(unit: Unit, call, *arguments, **named) -> str:
    """The message of a call that fails."""
    unit.messages.texts.clear()
    with pytest.raises(FMICallException):
        call(*arguments, **named)
    assert len(unit.messages.texts) == 1
    return unit.messages.texts[0]


def test_wrong_values_are_refused_and_change_nothing(unit):
    unit.begin()
    last = len(unit.variables) - 1
    name = inputs(hc.load_machine("rottne-f9-lab"))[0]
    put, ask = (unit.fmu.setReal, unit.fmu.getReal) if unit.fmi == 2 else (unit.fmu.setFloat64, unit.fmu.getFloat64)
    assert f"from 0 to {last}" in told(unit, ask, [last + 1])
    assert f"from 0 to {last}" in told(unit, put, [4_000_000_000], [1.0])
    for value in (np.nan, np.inf):
        text = told(unit, unit.set, {name: value})
        assert name in text and "finite" in text
    assert unit.get([name]) == [0.0]
    assert "computed" in told(unit, unit.set, {"tip.x": 1.0})
    assert "fixed" in told(unit, unit.set, {"initial.joint.boom": 1.7})
    assert "negative" in told(unit, unit.set, {"payload.mass": -1.0})
    integers = unit.fmu.getInteger if unit.fmi == 2 else unit.fmu.getInt32
    assert "integer" in told(unit, integers, [1])
    unit.step(0.0)


def test_calls_out_of_turn_are_refused(unit):
    unit.instantiate()
    assert "step mode" in told(unit, unit.step, 0.0)
    assert "initialization mode" in told(unit, unit.fmu.exitInitializationMode)
    unit.initialise({})
    unit.step(0.0)
    assert "go on from there" in told(unit, unit.step, 0.5)
    for duration in (-STEP, np.nan, np.inf):
        assert "zero or more" in told(unit, unit.step, STEP, duration)
    unit.step(STEP)
    unit.fmu.terminate()
    assert "terminated" in told(unit, unit.step, 2 * STEP)
    unit.fmu.reset()
    unit.initialise({"initial.joint.boom": 1.8})
    unit.step(0.0)


def test_a_start_or_parameter_that_cannot_be_is_told_when_it_counts(unit):
    unit.instantiate()
    assert "boom" in told(unit, unit.initialise, {"initial.joint.boom": 3.3})
    unit.fmu.reset()
    assert "supply.pressure" in told(unit, unit.initialise, {"supply.pressure": -1.0})
    unit.fmu.reset()
    unit.initialise({})
    unit.step(0.0)
    unit.set({"friction.lift.coulomb[0]": 1e9})
    assert "friction.lift" in told(unit, unit.step, STEP)


@pytest.mark.evidence
def test_the_end_of_a_stroke_is_no_crash(unit):
    """The piston runs into its end stop and stays there."""
    unit.begin()
    unit.set({"cylinder.extension.command": 0.05})
    for i in range(1500):
        unit.step(i * 0.01, 0.01)
    # The zone of the end stop is 35.5 mm long.
    upper = hc.load_machine("rottne-f9-lab").joint_limits[2, 1]
    q, rate = unit.get(["joint.extension.q", "joint.extension.qd"])
    assert 0.0 < upper - q < 0.0355 and abs(rate) < 1e-4


def test_damaged_states_are_refused(unit):
    unit.begin()
    unit.step(0.0)
    kept = unit.save()
    for damaged in (b"", kept[:1], kept[:-3], kept + b"\0", b"\xff" * len(kept)):
        assert "state" in told(unit, unit.load, damaged)
    unit.load(kept)
    unit.step(STEP)


def test_damaged_states_of_a_controller_are_refused_and_its_own_is_taken_after_that(fmi, tmp_path):
    file = hc.export_fmu("single-cylinder", tmp_path / "one.fmu", fmi=fmi, controller="lever")
    unit = Unit(file, tmp_path / "u").begin()
    unit.set({"stick.test": 0.5})
    for i in range(5):
        unit.step(i * 0.01, 0.01)
    kept = unit.save()
    other = Unit(hc.export_fmu("single-cylinder", tmp_path / "two.fmu", controller="tip"), tmp_path / "v").begin()
    for damaged in (b"", kept[:9], kept[:-3], kept + bytes(8), b"\xff" * len(kept), other.save()):
        assert "no state of this FMU" in told(unit, unit.load, damaged)
    unit.load(kept)
    unit.step(0.05, 0.01)
    assert unit.get(["cylinder.test.command"])[0] > 0.0
    unit.close()
    other.close()


@pytest.mark.evidence
def test_a_controller_tells_why_the_spools_are_centred(fmi, tmp_path):
    unit = Unit(hc.export_fmu("rottne-f9-lab", tmp_path / "tip.fmu", fmi=fmi, controller="tip"), tmp_path / "u").begin()
    unit.set({"stick.z": 0.5})
    for i in range(10):
        unit.step(i * 0.01, 0.01)
    assert np.abs(unit.get(["cylinder.lift.command"])).max() > 0
    unit.set({"measured.joint.boom.q": np.nan})
    for i in range(10, 200):
        unit.step(i * 0.01, 0.01)
    assert unit.get(["cylinder.lift.command"]) == [0.0]
    assert any("spools are centred" in text or "boom" in text for text in unit.messages.texts)
    unit.close()


@pytest.mark.parametrize("imperfect", [{"valve.lift.delay": "10 ms"}, {"valve.lift.command.hysteresis": "3 %"}])
def test_delays_and_hysteresis_are_for_co_simulation_only(tmp_path, imperfect):
    crane = hc.load_machine("rottne-f9-lab", imperfect)
    unit = Unit(hc.export_fmu(crane, tmp_path / "one.fmu"), tmp_path / "unzipped", exchange=True)
    assert unit.description.modelExchange is None
    assert "co-simulation only" in refused(unit)


@pytest.mark.parametrize("least", [1e-320, 1e-15])
def test_a_step_of_no_length_does_not_bound_the_next_one(unit, least):
    unit.begin()
    unit.step(0.0, least)
    unit.step(least, least)
    unit.set({"cylinder.lift.command": 0.02})
    for i in range(10):
        unit.step(2 * least + i * STEP, STEP)
    assert unit.get(["joint.boom.qd"])[0] > 1e-3


@pytest.mark.parametrize("duration", [86_401.0, 1e300])
def test_a_step_that_nobody_waits_for_is_refused(unit, duration):
    unit.begin()
    assert "steps of at most 86400 s" in told(unit, unit.step, 0.0, duration)
    unit.step(0.0)
