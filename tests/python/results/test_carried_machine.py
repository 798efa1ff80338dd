"""A saved run carries its machine: as it ran, whatever has become of its file, and without the place of that file."""

from __future__ import annotations

import hashlib
import json
import pickle
import re
import shutil
from pathlib import Path

import h5py
import pytest

import hydrocrane as hc
from hydrocrane.app.live import machine_request
from hydrocrane.results.carried import DIGEST, SOURCE, TEXT, made

MACHINE = """
extends = "base.toml"
include = ["part.toml"]
[machine]
name = "own"
"""


def described(tmp_path):
    folder = tmp_path / "home" / "somebody"
    folder.mkdir(parents=True)
    (folder / "base.toml").write_text('extends = "single-cylinder"\n[machine]\nname = "base"\n')
    (folder / "part.toml").write_text('[payload]\nclass = "assumed"\nmass = "68.2 kg"\n')
    (folder / "own.toml").write_text(MACHINE)
    return folder


@pytest.fixture
def own(tmp_path):
    return described(tmp_path)


def simulated(folder, **changes):
    return hc.simulate("single-cylinder-step", machine=folder / "own.toml", duration=0.1, **changes)


def told(machine):
    """What decides what the machine does, without the lines of its file."""
    return re.sub(r'place: "[^"]*"', "", machine.core.resolved)


def test_the_machine_of_a_loaded_run_is_the_one_that_ran(own, tmp_path):
    run = simulated(own, overrides={"supply.pressure": "100 bar", "cylinder.test.bore": 0.0651})
    path = run.save(tmp_path / "run.nc")
    (own / "part.toml").write_text('[payload]\nclass = "assumed"\nmass = "69 kg"\n')
    loaded = hc.load_run(path).machine
    assert loaded.value("payload.mass").si == 68.2 and told(loaded) == told(run.machine)
    assert loaded.overrides == run.machine.overrides and loaded.name == "own" and loaded.source == SOURCE
    for file in own.iterdir():
        file.unlink()
    again = hc.load_run(hc.load_run(path).save(tmp_path / "again.nc"))
    assert told(again.machine) == told(run.machine)
    assert stated(tmp_path / "again.nc") == stated(path)
    assert again.summary() == run.summary()
    again.plot()


def test_a_bundled_machine_keeps_its_name(tmp_path):
    run = hc.simulate("vertical-lift-open-loop", duration=0.1, overrides={"supply.pressure": 1e7 / 3})
    assert hc.load_run(run.save(tmp_path / "run.nc")).machine.source == "rottne-f9-lab"


def test_a_bundled_name_does_not_stand_for_another_machine(own, tmp_path):
    path = simulated(own).save(tmp_path / "run.nc")
    changed(path, machine_source="single-cylinder")
    assert hc.load_run(path).machine.value("payload.mass").si == 68.2


@pytest.mark.parametrize("suffix", [".nc", ".mat", ".csv"])
def test_no_file_says_where_the_machine_lay(own, suffix, tmp_path):
    model = hc.load_machine(own / "base.toml")
    stick = hc.Joystick([0.0], {"test": [0.5]}, mode="lever")
    fields = {"joystick": stick, "controller": "lever", "controller_model": model, "joints": {"slide": 0.0}}
    run = hc.simulate(hc.Scenario(machine=own / "own.toml", duration=0.1, **fields))
    assert "base" in run.data.attrs["controller_model_source"]
    raw = run.save(tmp_path / f"run{suffix}").read_bytes()
    assert b"somebody" not in raw and str(tmp_path).encode() not in raw


def stated(path):
    with h5py.File(path, "r") as file:
        return {name: file.attrs[name] for name in (TEXT, DIGEST)}


def changed(path, **attributes):
    with h5py.File(path, "a") as file:
        for name, value in attributes.items():
            file.attrs.pop(name, None)
            if value is not None:
                file.attrs[name] = value


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("once")
    return simulated(described(folder)).save(folder / "run.nc")


@pytest.fixture
def saved(once, tmp_path):
    return Path(shutil.copy(once, tmp_path))


def test_a_run_opens_no_file_that_it_names(saved, own, tmp_path, monkeypatch):
    other = tmp_path / "other.toml"
    other.write_text('extends = "single-cylinder"\n')
    changed(saved, **{TEXT: None, "machine_source": str(other)})
    with pytest.raises(hc.ResultFileError, match="carries no machine"):
        hc.load_run(saved).machine  # noqa: B018
    monkeypatch.chdir(own)
    for text in (
        f'extends = "{other}"',
        'extends = "./base.toml"',
        'extends = "single-cylinder"\ninclude = ["part.toml"]',
    ):
        changed(saved, **{TEXT: text, DIGEST: f"sha256 {hashlib.sha256(text.encode()).hexdigest()}"})
        with pytest.raises(hc.MachineFileError, match="not among the files at hand"):
            hc.load_run(saved).machine  # noqa: B018


def test_a_machine_that_was_changed_since(saved):
    text = stated(saved)[TEXT]
    changed(saved, **{TEXT: text.replace("68.2", "69")})
    with pytest.raises(hc.ResultFileError, match="does not match its hash"):
        hc.load_run(saved).machine  # noqa: B018


DEEP = "[" * 100_000
DAMAGED = {
    "outcome": ["melted", None],
    "outcome_time": ["soon", None],
    "events": ["[[0", "[1]", "5", '[["soon", 1]]', DEEP],
    "warnings": ["[[0", "[1]", '[{"kind": "a"}]', '[{"time": "b", "kind": "a", "text": "", "cure": ""}, 5]', DEEP],
    "payload_changes": ["[[0", "[1]", "[[1, [2], [3], 4]]", '[["a", ["b", 1], [[0, 0], [0, 0]], 1]]'],
    "learnt": ["[1]", '{"lift": [1]}', '{"lift": ["a", "b", "c", "d"]}', "5"],
    "verification": ["[1]", '{"tip": 1}', '{"solver": 1, "tip": "a", "pressure": 1, "time": 1}'],
    "joint_names": ["boom", "5", '{"a": 1}'],
    "cylinder_names": ["[", "5"],
    "solver_rtol": ["small", None],
    "scenario": [None],
    "machine": [None],
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_attribute_is_one_error(name, once):
    run = hc.load_run(once)
    for value in DAMAGED[name]:
        about = {**run.data.attrs, name: value}
        again = hc.Run(run.data.drop_attrs().assign_attrs({n: v for n, v in about.items() if v is not None}))
        with pytest.raises(hc.ResultFileError, match=f"^file: .*`({name}|outcome|events)` is missing or damaged"):
            again._check("file")


def test_a_damaged_file_is_one_error_when_it_is_loaded(saved):
    changed(saved, events="[[0")
    with pytest.raises(hc.ResultFileError, match=r"run.nc: .*`events` is missing or damaged \(JSONDecodeError"):
        hc.load_run(saved)
    changed(saved, outcome=None)
    with pytest.raises(hc.ResultFileError, match="no outcome"):
        hc.load_run(saved)


def test_overrides_that_are_none(once):
    carried = stated(once)
    for value in ["[1", DEEP, "[1]", '{"supply.pressure": {"a": 1}}', '{"supply.pressure": null}', "5"]:
        with pytest.raises(hc.HydrocraneError):
            made({"machine_overrides": value}, carried)


def test_a_machine_that_is_handed_to_another_process_is_the_same(own):
    machine = hc.load_machine(own / "own.toml", {"supply.pressure": "100 bar"})
    packed = pickle.dumps(machine)
    (own / "part.toml").write_text('[payload]\nclass = "assumed"\nmass = "69 kg"\n')
    again = pickle.loads(packed)
    assert told(again) == told(machine) and again.overrides == machine.overrides


def test_what_the_run_says_of_its_overrides_stays(saved):
    assert json.loads(hc.load_run(saved).data.attrs["machine_overrides"]) == {}


def test_the_page_and_an_fmu_take_the_machine_of_a_saved_run(once, tmp_path):
    machine = hc.load_run(once).machine
    request = machine_request(machine)
    assert request["machine"] == "machine.toml" and "68.2 kg" in request["text"] and "extends" not in request["text"]
    assert hc.simulate("single-cylinder-step", machine=machine, duration=0.05).machine.payload() == 68.2
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "again.toml").write_text(machine.to_toml(), encoding="utf-8")
    assert told(hc.load_machine(folder / "again.toml")) == told(machine)
    with pytest.raises(hc.HydrocraneError, match="no bundled machine `the machine of a saved run`"):
        hc.Scenario(machine=machine, joints={"slide": 0.0}).load_machine()
