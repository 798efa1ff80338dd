"""Stores that are damaged, old, full, or written by two at once: one clear error, and nothing wrong is ever read."""

import errno
import json
import os
import shutil
import subprocess
import sys
import warnings
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import zarr

import hydrocrane as hc
from hydrocrane.studies import integrity
from hydrocrane.studies.integrity import written_by_one
from hydrocrane.studies.store import StudyRepaired

pytestmark = [pytest.mark.evidence, pytest.mark.filterwarnings("ignore:.*cases have no results")]

RIG = "single-cylinder-step"
KEYS = {"payload.mass": [50.0, 60.0, 70.0, -1.0], "supply.pressure": [100e5, 120e5, 140e5]}


def own(run):
    return {"own": float(run.data.time[-1])}


def rig_study(store=None, **options):
    how = {"duration": 0.2, "progress": False, "signals": ["tip.z"], "block": 3, "measures": ["tip_way", own]}
    return hc.sweep(RIG, KEYS, store=store, **{**how, **options})


@pytest.fixture(scope="module")
def whole():
    return rig_study()


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "study.zarr"
    rig_study(folder)
    return folder


@pytest.fixture
def store(made, tmp_path):
    return Path(shutil.copytree(made, tmp_path / "study.zarr"))


def delete(file):
    file.unlink()


def flip(file):
    raw = bytearray(file.read_bytes())
    raw[len(raw) // 2] ^= 4
    file.write_bytes(raw)


def cut(file):
    file.write_bytes(file.read_bytes()[:-7])


def empty(file):
    file.write_bytes(b"")


BLOCK_FILES = ["tip.z/c/1/0/0", "tip_way/c/1/0", "own/c/1/0", "message/c/1/0", "outcome/c/1/0"]
DAMAGES = [(file, do) for file in BLOCK_FILES for do in (delete, flip, cut, empty)]
# Without its outcomes a block is one that was not run yet.
DAMAGES.remove(("outcome/c/1/0", delete))


@pytest.mark.parametrize(("file", "damage"), DAMAGES, ids=lambda value: getattr(value, "__name__", value))
def test_a_damaged_block_is_named_and_computed_again(file, damage, store, whole, computed):
    damage(store / file)
    with pytest.raises(hc.ResultFileError, match=r"1 of 4 blocks damaged: .*Run the same study") as caught:
        hc.open_study(store)
    assert file in str(caught.value)
    with pytest.warns(StudyRepaired, match=file):
        again = rig_study(store)
    assert len(computed) == 3 and {values[0] for values in computed} == {60.0}
    assert again.load().identical(whole) and hc.open_study(store).load().identical(whole)


def test_a_deleted_block_of_outcomes_is_one_to_run(store, whole):
    (store / "outcome/c/1/0").unlink()
    assert (hc.open_study(store).outcome.values == "").sum() == 3
    assert rig_study(store).load().identical(whole)


def test_many_damaged_files_make_one_short_message(store):
    for name in ("tip.z", "tip_way"):
        shutil.rmtree(store / name / "c")
    with pytest.raises(hc.ResultFileError, match="4 of 4 blocks damaged: .*, and 3 more"):
        hc.open_study(store)


@pytest.mark.parametrize("name", ["payload.mass", "time", "tip.z", "own", "outcome", "message"])
@pytest.mark.parametrize("damage", [delete, flip, cut, empty])
def test_damaged_descriptions_are_made_again(name, damage, store, whole):
    damage(store / name / "zarr.json")
    with pytest.raises(hc.ResultFileError, match=f"{name}/zarr.json"):
        hc.open_study(store)
    with pytest.warns(StudyRepaired, match=f"{name}/zarr.json"):
        again = rig_study(store)
    assert again.load().identical(whole) and hc.open_study(store).load().identical(whole)


@pytest.mark.parametrize("damage", [delete, flip, cut])
def test_damaged_values_of_keys_are_found(damage, store, whole):
    damage(store / "payload.mass/c/0")
    with pytest.raises(hc.ResultFileError, match="payload.mass/c/0"):
        hc.open_study(store)
    with pytest.warns(StudyRepaired):
        assert rig_study(store).load().identical(whole)


@pytest.mark.parametrize("damage", [flip, cut, empty])
def test_a_damaged_description_of_the_study_is_one_error(damage, store):
    damage(store / "zarr.json")
    for attempt in (lambda: hc.open_study(store), lambda: rig_study(store)):
        with pytest.raises(hc.ResultFileError, match=r"zarr\.json was cut off or changed.*delete the folder"):
            attempt()


def test_a_description_that_is_still_readable_is_checked(store):
    """A changed shape, unit or fill value is still JSON that Zarr takes."""
    file = store / "tip.z/zarr.json"
    file.write_text(file.read_text().replace('"units": "m"', '"units": "k"'))
    with pytest.raises(hc.ResultFileError, match="tip.z/zarr.json"):
        hc.open_study(store)


def test_other_programs_find_changed_chunks_too(store):
    flip(store / "tip_way/c/1/0")
    with pytest.raises(ValueError, match="checksum"):
        zarr.open_array(store / "tip_way", mode="r")[...]


def test_a_figure_that_comes_late_is_whole_everywhere(tmp_path):
    """Blocks before it have no value, and that is not a loss."""

    def late(run):
        return {"late": 1.0} if run.data.attrs["payload"] > 55.0 else {}

    store = tmp_path / "study.zarr"
    data = rig_study(store, measures=[late], workers=1)
    assert np.isnan(data["late"].values[0]).all() and (data["late"].values[1:3] == 1.0).all()
    assert hc.open_study(store).load().identical(data.load())


def without_checksums(store):
    """The store as earlier versions left it."""
    plain = store.with_name("old.zarr")
    old = zarr.open_group(plain, mode="w")
    new = zarr.open_group(store, mode="r")
    for name, array in new.arrays():
        attributes = {key: value for key, value in array.attrs.items() if key != integrity.CHECKSUM}
        made = old.create_array(
            name, shape=array.shape, chunks=array.chunks, dtype=str if array.dtype.kind not in "if" else array.dtype,
            fill_value=array.fill_value, dimension_names=array.metadata.dimension_names, attributes=attributes,
        )  # fmt: skip
        made[...] = array[...]
    leave = (integrity.CHECKSUM, integrity.AXES, integrity.BLOCK_ARRAYS)
    old.attrs.update({key: value for key, value in new.attrs.items() if key not in leave})
    return plain


def test_old_stores_open_with_a_warning_and_do_not_go_on(store, whole):
    old = without_checksums(store)
    with pytest.warns(UserWarning, match="no checksums"):
        data = hc.open_study(old)
    assert np.array_equal(data["tip.z"].values, whole["tip.z"].values, equal_nan=True)
    with pytest.raises(hc.ResultFileError, match=r"without checksums.*overwrite"):
        rig_study(old)
    cut(old / "outcome/c/1/0")
    with pytest.warns(UserWarning), pytest.raises(hc.ResultFileError, match="is damaged, or not a study"):
        hc.open_study(old)
    assert rig_study(old, overwrite=True).load().identical(whole)


def test_two_at_once_are_one_error_and_leave_nothing(tmp_path, whole):
    store = tmp_path / "results" / "study.zarr"
    code = (
        "import sys, time, pathlib; from hydrocrane.studies.integrity import written_by_one\n"
        "with written_by_one(pathlib.Path(sys.argv[1])):\n    print('held', flush=True)\n    time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(store)], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "held\n"
        try:
            with pytest.raises(hc.ResultFileError, match=rf"study.zarr is being written by process {other.pid} on "):
                rig_study(store)
            assert [path.name for path in store.parent.iterdir()] == [".study.zarr.lock"]
        finally:
            other.kill()
    # The one that was killed has left its file, not its lock.
    assert rig_study(store).load().identical(whole)
    assert [path.name for path in store.parent.iterdir()] == ["study.zarr"]


def test_the_lock_is_for_threads_too_and_is_given_back(tmp_path):
    with written_by_one(tmp_path / "a"):
        with written_by_one(tmp_path / "b"), written_by_one(None):
            pass
        with pytest.raises(hc.ResultFileError, match=f"process {os.getpid()}"), written_by_one(tmp_path / "a"):
            pass
    with written_by_one(tmp_path / "a"):
        pass
    assert not list(tmp_path.iterdir())


def test_the_command_line_says_it_in_one_line(tmp_path):
    study = tmp_path / "masses.toml"
    study.write_text(f'[study]\nscenario = "{RIG}"\n[keys]\n"payload.mass" = [50, 60]\n')
    run = [sys.executable, "-m", "hydrocrane", "sweep", str(study), "--store", "s.zarr"]
    options = {"capture_output": True, "text": True, "cwd": tmp_path, "timeout": 300}
    with written_by_one(tmp_path / "s.zarr"):
        done = subprocess.run(run, **options)
    assert done.returncode == 2 and done.stderr.count("error:") == 1 and "is being written by" in done.stderr
    assert subprocess.run(run, **options).returncode == 0
    flip(tmp_path / "s.zarr/tip_way/c/0")
    done = subprocess.run(run, **options)
    assert done.returncode == 0 and done.stderr.startswith("warning: s.zarr: 1 of 2 blocks damaged"), done.stderr
    assert "Traceback" not in done.stderr and "UserWarning" not in done.stderr


def test_remains_of_a_killed_start_are_removed(tmp_path, whole):
    left = tmp_path / f".study.zarr.{'0' * 32}"
    left.mkdir()
    (left / "zarr.json").write_text("{")
    other = tmp_path / ".study.zarr.mine"
    other.write_text("keep")
    assert rig_study(tmp_path / "study.zarr").load().identical(whole)
    assert {path.name for path in tmp_path.iterdir()} == {"study.zarr", ".study.zarr.mine"}


def test_a_full_disk_stops_the_study_with_one_error(tmp_path, whole, monkeypatch):
    from zarr.storage import _local

    plain, written = _local._put, []

    def full(path, *rest, **options):
        written.append(path)
        if "tip.z" in path.parts and len([p for p in written if "tip.z" in p.parts and p.name != "zarr.json"]) > 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return plain(path, *rest, **options)

    monkeypatch.setattr(_local, "_put", full)
    store = tmp_path / "study.zarr"
    with pytest.raises(hc.ResultFileError, match=r"free some space.*after 6 of 12 cases; the same call resumes"):
        rig_study(store, workers=1)
    monkeypatch.undo()
    assert (hc.open_study(store).outcome.values == "").sum() == 6
    assert rig_study(store).load().identical(whole)


def test_a_store_that_cannot_be_made_leaves_nothing(tmp_path, monkeypatch):
    from hydrocrane.studies import store as store_module

    def full(node, **_):
        raise hc.ResultFileError("cannot write: disk full")

    monkeypatch.setattr(store_module, "seal", full)
    with pytest.raises(hc.ResultFileError):
        rig_study(tmp_path / "study.zarr")
    assert not list(tmp_path.iterdir())


def test_descriptions_carry_their_checksum(made):
    for file in made.rglob("zarr.json"):
        assert integrity.CHECKSUM in json.loads(file.read_text())["attributes"]
    assert integrity.CHECKSUM not in hc.open_study(made).attrs


def reseal(store, name="", **fields):
    """Change a description as somebody would who knows how its digest is made."""
    file = store / name / "zarr.json"
    content = json.loads(file.read_text())
    file.write_text(
        json.dumps({**content, **fields, "attributes": content["attributes"] | fields.get("attributes", {})})
    )
    integrity.seal(store / name)


def grid(step):
    return {"name": "regular", "configuration": {"chunk_shape": [step, step]}}


HOSTILE = {
    "too many blocks": lambda s: reseal(s, "outcome", shape=[10**9, 10**9], chunk_grid=grid(1)),
    "a huge block": lambda s: reseal(s, "tip_way", shape=[10**6, 10**6], chunk_grid=grid(10**6)),
    "huge texts": lambda s: reseal(s, "message", shape=[10**9, 10**9], chunk_grid=grid(10**9)),
    "no block": lambda s: reseal(s, "outcome", chunk_grid=grid(0)),
    "a codec": lambda s: reseal(s, "tip_way", codecs=[{"name": "numcodecs.pickle", "configuration": {}}]),
    "no array": lambda s: reseal(s, "tip_way", shape="five"),
    "names": lambda s: reseal(s, attributes={"block_arrays": json.dumps(["../../other", "outcome"])}),
    "axes": lambda s: reseal(s, attributes={"axes": json.dumps(["/etc"])}),
    "no list": lambda s: reseal(s, attributes={"block_arrays": "[" * 100_000}),
    "no texts": lambda s: reseal(s, attributes={"block_arrays": "[[1], 2]"}),
    "no dimensions": lambda s: reseal(s, attributes={"dimensions": "7"}),
    "deep": lambda s: (s / "zarr.json").write_text("[" * 100_000),
    "a pipe": lambda s: ((s / "own/c/1/0").unlink(), os.mkfifo(s / "own/c/1/0")),
    "a pipe for a description": lambda s: ((s / "own/zarr.json").unlink(), os.mkfifo(s / "own/zarr.json")),
    "a link": lambda s: ((s / "own").rename(s.parent / "own"), (s / "own").symlink_to(s.parent / "own")),
    "version 2": lambda s: ((s / "zarr.json").unlink(), (s / ".zgroup").write_text('{"zarr_format": 2}')),
}  # fmt: skip


@pytest.mark.skipif(sys.platform == "win32", reason="no pipes as files")
@pytest.mark.parametrize("harm", HOSTILE.values(), ids=HOSTILE)
def test_a_store_made_to_harm_is_one_error_and_nothing_outside_is_touched(harm, store):
    other = store.parent.parent / "other"
    other.mkdir(exist_ok=True)
    (other / "zarr.json").write_text("{}")
    harm(store)
    with pytest.raises(hc.ResultFileError):
        hc.open_study(store)
    with suppress(hc.ResultFileError), warnings.catch_warnings(action="ignore", category=StudyRepaired):
        rig_study(store)
    assert (other / "zarr.json").read_text() == "{}"


def test_a_chunk_that_states_a_huge_size(store):
    file = store / "own/c/1/0"
    raw = bytes([0x28, 0xB5, 0x2F, 0xFD, 0b11100000]) + (2**42).to_bytes(8, "little") + b"\1\0\0"
    file.write_bytes(raw + integrity._crc(raw))
    with pytest.raises(hc.ResultFileError, match="own/c/1/0 was cut off or changed"):
        hc.open_study(store)
