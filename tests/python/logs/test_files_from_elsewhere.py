"""Files that others made, to harm or by accident: one error, soon and in little memory, and no other file's bytes."""

from __future__ import annotations

import gzip
import os
import struct
import sys
import time
import tracemalloc
import zlib

import h5py
import numpy as np
import pytest
import xarray as xr
from scipy.io import savemat

import hydrocrane as hc
from hydrocrane.files import hdf5
from hydrocrane.files import received as received_files
from hydrocrane.files.received import received
from hydrocrane.logs.formats import matlab, readers

SECRET = np.frombuffer(b"root:x:0:0:root:" * 30, dtype=np.float64)
T = np.arange(60) / 100


@pytest.fixture
def soon():
    began = time.process_time()
    yield
    assert time.process_time() - began < 5.0


def good(file):
    file["time"], file["x"] = T, 2 * T
    file["time"].make_scale("time")
    file["x"].dims[0].attach_scale(file["time"])
    return file


# --- what a path is ---------------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="no pipes and devices as files")
@pytest.mark.parametrize("name", ["log.csv", "log.csv.gz", "log.mat", "log.h5", "log.nc", "map.toml", "study.toml"])
@pytest.mark.parametrize("what", ["pipe", "device", "folder"])
def test_only_regular_files_are_read(what, name, tmp_path):
    path = tmp_path / name
    {"pipe": os.mkfifo, "device": lambda p: p.symlink_to("/dev/zero"), "folder": os.mkdir}[what](path)
    log = tmp_path / "good.csv"
    log.write_text("time,x\n0,1\n1,2\n")
    reads = {"map.toml": lambda: hc.read_log(log, path), "study.toml": lambda: hc.load_study(path)}
    with pytest.raises(
        hc.HydrocraneError, match="is a folder" if what == "folder" else "is a pipe, a socket or a device"
    ):
        reads.get(name, lambda: hc.read_log(path))()
    if name == "log.nc":
        with pytest.raises(hc.ResultFileError, match="is a folder|is a pipe"):
            hc.load_run(path)


@pytest.mark.parametrize("name", ["a\0b.csv", "\ud800.csv", "x" * 5000 + ".csv", "missing/log.csv"])
def test_paths_that_no_file_has(name, tmp_path):
    with pytest.raises(hc.ResultFileError):
        hc.read_log(f"{tmp_path}/{name}")


def test_a_size_beyond_the_limit_is_said(tmp_path):
    path = tmp_path / "log.csv"
    with path.open("wb") as stream:
        stream.truncate(2**33)
    with pytest.raises(hc.ResultFileError, match="8192 MiB, more than 4096"):
        received(path)


# --- texts ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", [b"\0" * 4096, b"1,2\n" * 1024, b"1" * 4096, b'"' * 4096, b"# a = 1\n" * 512])
def test_a_small_packed_file_that_unpacks_to_much(row, tmp_path, monkeypatch):
    """Nothing beyond the limit is unpacked, and no text is taken apart."""
    monkeypatch.setattr(readers, "LARGEST_TEXT", 2**20)
    monkeypatch.setattr(readers, "add_text", None)
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(row) * (2**22 // len(row)))
    tracemalloc.start()
    with pytest.raises(hc.ResultFileError, match="has more than 1 MiB"):
        hc.read_log(path)
    assert tracemalloc.get_traced_memory()[1] < 2**22
    tracemalloc.stop()


def test_very_many_short_lines(tmp_path, soon):
    path = tmp_path / "log.csv"
    path.write_text("x\n" + "1\n" * 5_000_001)
    with pytest.raises(hc.ResultFileError, match="more than 5000000 lines"):
        hc.read_log(path)


@pytest.mark.parametrize("late", [",1" * 3000, ";" * 100_000, '"' + "a" * 200_000 + '"'])
def test_a_late_line_of_very_many_cells_or_letters(late, tmp_path, soon):
    path = tmp_path / "log.csv"
    path.write_text("time,x\n" + "".join(f"{i},{i}\n" for i in range(2000)) + f"1{late}\n2,2\n")
    try:
        hc.read_log(path)
    except hc.ResultFileError as error:
        assert "columns, more than" in str(error)


def test_very_many_comments(tmp_path, soon):
    path = tmp_path / "log.csv"
    path.write_text("# payload = 20\n" + "# a = [1, 2\n" * 200_000 + "time,x\n0,1\n1,2\n")
    assert hc.read_log(path).data.attrs["payload"] == 20


DEEP = 200_000
TOML = {
    "dotted": "x" + ".a" * DEEP + " = 1",
    "quoted": "x" + '."a\\"b"' * DEEP + " = 1",
    "literal": "x" + " . 'a'" * DEEP + " = 1",
    "header": "[x" + ".a" * DEEP + "]",
    "array of tables": "[[x" + ".a" * DEEP + "]]",
    "inline": "x = {y" + ".a" * DEEP + " = 1}",
    "lists": "x = " + "[" * DEEP,
    "tables": "x = " + "{a = " * DEEP,
    "size": "x = '" + "a" * 2_000_000 + "'",
    "digits": "x = " + "9" * 10_000,
    "escapes": 'x = "' + '\\"' * 250_000,
}


@pytest.mark.parametrize("endless", TOML.values(), ids=TOML)
def test_toml_that_never_ends(endless, tmp_path, soon):
    path, log = tmp_path / "study.toml", tmp_path / "log.csv"
    path.write_text(f'[study]\nscenario = "vertical-lift-open-loop"\n{endless}\n')
    log.write_text(f"# {endless}\ntime,x\n0,1\n1,2\n")
    with pytest.raises(hc.InputError, match="nested deeper|not valid TOML|more than|MiB"):
        hc.load_study(path)
    with pytest.raises(hc.InputError):
        hc.read_log(log, path)
    assert "x" in hc.read_log(log)


# --- HDF5, NetCDF and MATLAB 7.3 --------------------------------------------------------------------------------------


def external_storage(file, folder):
    (folder / "secret").write_bytes(SECRET.tobytes())
    good(file).create_dataset("y", (60,), "f8", external=[(str(folder / "secret"), 0, 480)])


def external_link(file, folder):
    with h5py.File(folder / "secret.h5", "w") as other:
        other["y"] = SECRET
    good(file)["y"] = h5py.ExternalLink(str(folder / "secret.h5"), "/y")


def nested_link(file, folder):
    with h5py.File(folder / "secret.h5", "w") as other:
        other["y"] = SECRET
    good(file).create_group("a/b")["c"] = h5py.ExternalLink(str(folder / "secret.h5"), "/")
    file["y"] = h5py.SoftLink("/a/b/c/y")


def virtual(file, folder):
    with h5py.File(folder / "secret.h5", "w") as other:
        other["y"] = SECRET
    layout = h5py.VirtualLayout((60,), "f8")
    layout[:] = h5py.VirtualSource(str(folder / "secret.h5"), "y", (60,))
    good(file).create_virtual_dataset("y", layout)


def huge(file, _):
    good(file).create_dataset("y", (10**12,), "f8", chunks=(1000,))


def huge_chunk(file, _):
    good(file).create_dataset("y", (60,), "f8", chunks=(500_000_000,), maxshape=(None,), compression="gzip")


def huge_texts(file, _):
    good(file).create_dataset("y", (60,), "S1000000000", chunks=(1,))


def doubly_linked(file, _):
    group = good(file)
    for _ in range(40):
        below = group.create_group("a")
        group["b"] = below
        group = below
    group["y"] = T


def circle(file, _):
    group = good(file).create_group("a")
    group["b"] = group


def many_links(file, _):
    for i in range(301):
        file.id.links.create_soft(f"g{i}".encode(), b"/x")
    good(file)


def deep(file, _):
    good(file)["a" + "/a" * 100] = T


def wrong_class(file, _):
    good(file)["y"] = 1.5 * T
    file["y"].attrs["MATLAB_class"] = np.bytes_("char")


def references(file, _):
    references = file.create_dataset("y", (200,), h5py.ref_dtype)
    references[:] = [references.ref] * 200
    good(file)


OUTSIDE = [external_storage, external_link, nested_link, virtual]
TOO_MUCH = [huge, huge_chunk, huge_texts, many_links, deep]


@pytest.mark.parametrize("suffix", [".h5", ".mat", ".nc"])
@pytest.mark.parametrize("make", OUTSIDE + TOO_MUCH, ids=lambda make: make.__name__)
def test_what_hdf5_could_do(make, suffix, tmp_path, soon, monkeypatch):
    monkeypatch.setattr(hdf5, "MOST_OBJECTS", 300)
    path = tmp_path / f"log{suffix}"
    with h5py.File(path, "w", libver="latest") as file:
        make(file, tmp_path)
    words = "in another file" if make in OUTSIDE else "numbers, more than|members|levels of groups"
    with pytest.raises(hc.ResultFileError, match=words):
        hc.read_log(path)
    with pytest.raises(hc.ResultFileError, match=words):
        hc.load_run(path)


@pytest.mark.parametrize("make", [doubly_linked, circle])
@pytest.mark.parametrize("suffix", [".h5", ".mat", ".nc"])
def test_each_group_is_read_once(make, suffix, tmp_path, soon):
    path = tmp_path / f"log{suffix}"
    with h5py.File(path, "w", libver="latest") as file:
        make(file, tmp_path)
    log = hc.read_log(path)
    np.testing.assert_array_equal(log["x"], 2 * T)
    assert len(log.data.data_vars) <= 2


def test_a_text_that_is_no_text_and_references_in_a_circle(tmp_path):
    for make, words in [(wrong_class, "states that it is a text"), (references, "members|levels of groups")]:
        path = tmp_path / f"{make.__name__}.mat"
        with h5py.File(path, "w") as file:
            make(file, tmp_path)
        with pytest.raises(hc.ResultFileError, match=words):
            hc.read_log(path)


@pytest.mark.parametrize("suffix", [".h5", ".nc", ".mat"])
def test_values_of_no_fixed_length_links_and_odd_names_are_left_out_with_a_word(suffix, tmp_path):
    path = tmp_path / f"log{suffix}"
    with h5py.File(path, "w") as file:
        good(file)
        file.create_dataset("vlen", (60,), h5py.vlen_dtype(np.float64))[:] = [np.zeros(2)] * 60
        file.create_dataset("words", (60,), h5py.string_dtype())[:] = ["ok"] * 60
        file.create_dataset("none", data=h5py.Empty("f8"))
        file["alias"] = h5py.SoftLink("/x")
        file["x"].attrs.create("history", ["a"] * 3, dtype=h5py.string_dtype())
    if suffix == ".nc":
        with h5py.File(path, "a") as file:
            del file["none"]
    log = hc.read_log(path)
    np.testing.assert_array_equal(log["x"], 2 * T)
    assert "alias" not in log and "vlen" not in log
    log.save(tmp_path / "again.csv")


def test_many_texts_in_one_attribute(tmp_path):
    path = tmp_path / "log.nc"
    with h5py.File(path, "w") as file:
        good(file)["x"].attrs.create("history", ["a"] * 100, dtype=h5py.string_dtype())
    with pytest.raises(hc.ResultFileError, match="an attribute `history` of 100 values"):
        hc.read_log(path)


@pytest.mark.parametrize("suffix", [".h5", ".nc", ".mat"])
@pytest.mark.parametrize("seed", range(12))
def test_changed_bytes(suffix, seed, tmp_path):
    path = tmp_path / f"log{suffix}"
    if suffix == ".mat":
        savemat(path, {"time": T, "x": T, "s": {"a": T, "b": [1, "two", T]}}, do_compression=bool(seed % 2))
    else:
        xr.Dataset({"x": ("time", T, {"units": "m"})}, {"time": T}).to_netcdf(path, engine="h5netcdf")
    raw, draws = bytearray(path.read_bytes()), np.random.default_rng(seed)
    for place in draws.integers(0, len(raw), 1 + seed):
        raw[place] = draws.integers(256)
    path.write_bytes(raw)
    try:
        hc.read_log(path).save(tmp_path / "again.csv")
    except hc.HydrocraneError as error:
        assert str(error)


# --- MATLAB 5 ---------------------------------------------------------------------------------------------------------


def matlab5(path, content, packed=True):
    """A file with one variable of these elements."""
    matrix = struct.pack("<II", 14, len(content)) + content
    shrunk = zlib.compress(matrix, 1)
    element = struct.pack("<II", 15, len(shrunk)) + shrunk if packed else matrix
    path.write_bytes(b"MATLAB 5.0".ljust(124) + struct.pack("<H", 0x100) + b"IM" + element)


def head(kind, *dims):
    return (
        struct.pack("<IIII", 6, 8, kind, 0)
        + struct.pack("<IIii", 5, 8, *dims)
        + struct.pack("<II", 1 << 16 | 1, ord("x"))
    )


def test_a_small_matlab_file_that_unpacks_to_much(tmp_path, monkeypatch):
    many = 10_000_000
    monkeypatch.setattr(received_files, "MOST_VALUES", many - 1)
    matlab5(tmp_path / "log.mat", head(6, 1, many) + struct.pack("<II", 2, many) + bytes(many))
    with pytest.raises(hc.ResultFileError, match="numbers, more than"):
        hc.read_log(tmp_path / "log.mat")


def test_a_matlab_file_of_very_many_small_arrays(tmp_path, monkeypatch):
    monkeypatch.setattr(matlab, "MOST_ELEMENTS", 10_000)
    one = struct.pack("<II", 14, 48) + struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, 0, 0)
    cell = one + struct.pack("<II", 1, 0) + struct.pack("<II", 9, 0)
    matlab5(tmp_path / "log.mat", head(1, 1, 5000) + cell * 5000)
    with pytest.raises(hc.ResultFileError, match="more than 10000 arrays"):
        hc.read_log(tmp_path / "log.mat")


@pytest.mark.parametrize("dims", [(2**31 - 1, 2**31 - 1), (1, 2**31 - 1), (-1, 5)])
@pytest.mark.parametrize("kind", [1, 2, 4, 6])
def test_a_matlab_file_that_states_more_than_it_has(kind, dims, tmp_path, soon):
    matlab5(tmp_path / "log.mat", head(kind, *dims) + struct.pack("<II", 9, 16) + bytes(16), packed=False)
    with pytest.raises(hc.ResultFileError):
        hc.read_log(tmp_path / "log.mat")


@pytest.mark.parametrize(("kind", "code"), [(6, 65289), (6, 40), (6, 0), (21, 9), (255, 9), (0, 9)])
def test_a_matlab_file_of_kinds_that_there_are_not(kind, code, tmp_path):
    """SciPy would look them up beyond the end of its tables."""
    matlab5(tmp_path / "log.mat", head(kind, 1, 2) + struct.pack("<II", code, 16) + bytes(16))
    with pytest.raises(hc.ResultFileError, match="which there is not"):
        hc.read_log(tmp_path / "log.mat")


@pytest.mark.parametrize("value", [np.arange(5), "text", 1e300, ["a"] * 3])
@pytest.mark.parametrize("name", ["DIMENSION_LIST", "REFERENCE_LIST", "CLASS"])
def test_dimensions_that_are_none_of_hdf5(name, value, tmp_path):
    """HDF5 would write beyond its memory and end the process."""
    path = tmp_path / "log.nc"
    with h5py.File(path, "w") as file:
        good(file)["x" if name == "DIMENSION_LIST" else "time"].attrs[name] = value
    try:
        hc.read_log(path)
    except hc.ResultFileError as error:
        assert name == "CLASS" or f"the attribute `{name}`" in str(error)


def test_a_line_that_is_no_row(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,x\n0,1\n" + "7" * (2**20 + 1) + ",1\n")
    with pytest.raises(hc.ResultFileError, match="a line of 1048579 letters"):
        hc.read_log(path)


@pytest.mark.parametrize("suffix", [".csv", ".nc", ".h5"])
def test_facts_that_are_no_text_of_unicode_are_marked(tmp_path, suffix):
    """A byte 0xff in an attribute: HDF5 hands it out as a character that nothing can write."""
    import h5py

    file = tmp_path / "log.h5"
    with h5py.File(file, "w") as stored:
        stored["time"], stored["x"] = np.arange(5) / 100, np.arange(5) / 1000
        stored["x"].attrs["units"] = "m"
        stored.attrs.create("operator", b"J\xff", dtype=h5py.string_dtype())
    log = hc.read_log(file)
    assert log.data.attrs["operator"] == "J?"
    log.save(tmp_path / f"again{suffix}")
