"""Damaged files that are no text, stores of studies, command lines and calls of an FMU, made from a seed."""

from __future__ import annotations

import contextlib
import gzip
import io
import json
import os
import random
import shutil
import struct
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import h5py
import numpy as np
from mutate import damaged_table
from scipy.io import savemat

import hydrocrane as hc
from hydrocrane.app import cli
from hydrocrane.errors import HydrocraneError
from hydrocrane.studies import integrity

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/python/export"), str(ROOT / "tests/python")]
T = np.arange(50) / 100
# What lies in a file that a damaged one may name, and is never to be read from there.
SECRET = 12345.678
ODD = (
    "", "\0", "\ud800", "\x1b[31m", "[/bold]", "$\\frac{$", "../../../x", "/dev/zero", "x" * 5000, "=HYPERLINK(1)",
    "[" * 20_000, "x" + ".a" * 20_000, "nan", "inf", "1e400", "-1", "5 m", "9" * 5000, "\ufffe", "--help", "*/", "%s",
    "{}", "true", "é",
)  # fmt: skip


def flipped(draws: random.Random, raw: bytes, most: int = 8) -> bytes:
    """Some bytes changed, or the end cut off."""
    damaged = bytearray(raw)
    for _ in range(draws.randint(0, most)):
        damaged[draws.randrange(len(damaged))] = draws.choice((0, 255, draws.randrange(256)))
    return bytes(damaged[: draws.randrange(len(damaged))] if draws.random() < 0.05 else damaged)


# --- HDF5, runs, MATLAB, packed texts ---------------------------------------------------------------------------------


def _member(draws: random.Random, group: h5py.Group, name: str, groups: list[h5py.Group]) -> None:
    """Something in a group that a log may have, or that only somebody with a plan puts there."""
    kinds: list[Callable[[], object]] = [
        lambda: group.create_dataset(name, data=T * draws.choice((1.0, 1e300, np.nan))),
        lambda: group.create_dataset(
            name, data=np.arange(draws.randrange(60), dtype=draws.choice(("i1", "u2", ">f4")))
        ),
        lambda: group.create_dataset(name, (draws.choice((10, 10**7, 10**12)),), "f8", chunks=(10,)),
        lambda: group.create_dataset(name, (50,), "f8", external=[(draws.choice((_secret(), "/etc/passwd")), 0, 400)]),
        lambda: group.create_dataset(name, (5,), draws.choice((h5py.string_dtype(), h5py.vlen_dtype("f8"), "S90"))),
        lambda: group.create_dataset(name, (3,), h5py.ref_dtype, data=[draws.choice(groups).ref] * 3),
        lambda: group.create_dataset(name, data=np.zeros(5, [("a", "f8"), ("b", "i4")])),
        lambda: group.create_dataset(name, data=h5py.Empty("f8")),
        lambda: group.__setitem__(name, h5py.SoftLink(draws.choice(("/x", "/nowhere", f"/{name}")))),
        lambda: group.__setitem__(name, h5py.ExternalLink(_secret(), "/y")),
        lambda: group.__setitem__(name, draws.choice(groups)),
        lambda: groups.append(group.create_group(name)),
    ]
    weights = (9, 3, 1, 1, 2, 2, 2, 1, 1, 1, 2, 5)
    draws.choices(kinds, weights)[0]()


@cache
def _secret() -> str:
    path = Path(tempfile.gettempdir()) / "hydrocrane-fuzz-secret.h5"
    with h5py.File(path, "w") as stored:
        stored["y"] = np.full(50, SECRET)
    return str(path)


def hdf5(draws: random.Random) -> bytes:
    content = io.BytesIO()
    with h5py.File(content, "w", libver=draws.choice(("earliest", "latest"))) as stored:
        groups: list[h5py.Group] = [stored]
        stored["time"], stored["x"] = T, T
        stored["time"].make_scale("time")
        stored["x"].dims[0].attach_scale(stored["time"])
        for i in range(draws.randrange(12)):
            with contextlib.suppress(OSError, ValueError, TypeError):
                _member(draws, draws.choice(groups), f"m{i}", groups)
        for node in (stored, stored["x"], stored["time"]):
            if draws.random() < 0.3:
                value = draws.choice(("char", "double", "mm", b"\xff", np.arange(90), ["a"] * 99, 1e300))
                node.attrs[draws.choice(("MATLAB_class", "MATLAB_empty", "units", "scale_factor", "_FillValue"))] = (
                    value
                )
    return flipped(draws, content.getvalue(), draws.choice((0, 0, 4)))


@cache
def _run() -> bytes:
    made = hc.simulate("single-cylinder-step", duration=0.05)
    made.data.attrs["wall_time"] = 0.0
    with tempfile.TemporaryDirectory() as folder:
        return made.save(Path(folder) / "run.nc").read_bytes()


def run(draws: random.Random) -> bytes:
    if draws.random() < 0.3:
        return flipped(draws, _run())
    content = io.BytesIO(_run())
    with h5py.File(content, "r+") as stored:
        for _ in range(draws.randint(1, 3)):
            node = stored if draws.random() < 0.7 else draws.choice(list(stored.values()))
            name = draws.choice(list(node.attrs))
            if draws.random() < 0.3:
                del node.attrs[name]
            elif isinstance(node.attrs[name], str):
                text = node.attrs[name]
                at = draws.randrange(len(text) + 1)
                cut = text[:at] + draws.choice(("[", "]", "{}", "null", "1e999", '"', "\ufffe", "")) + text[at + 1 :]
                node.attrs[name] = cut.replace("\0", "")
            elif draws.random() < 0.5:
                del stored[draws.choice(list(stored))]
                break
            else:
                node.attrs[name] = draws.choice(("text", 1e300, np.arange(5)))
    return content.getvalue()


def matlab(draws: random.Random) -> bytes:
    content = io.BytesIO()
    data = {"time": T, "x": T, "s": {"a": T, "name": "text"}, "c": np.array([T, "two", {"d": 1}], object)}
    savemat(content, data, do_compression=draws.random() < 0.3)
    raw = content.getvalue()
    raw = b"MATLAB 5.0 MAT-file".ljust(116) + raw[116:]
    if draws.random() < 0.5:
        at = draws.randrange(128, len(raw) - 8) // 4 * 4
        number = draws.choice((0, 1, 5, 14, 15, 2**16 + 1, 2**31 - 1, 2**32 - 1))
        raw = raw[:at] + struct.pack("<I", number) + raw[at + 4 :]
    return flipped(draws, raw, 3)


def packed(draws: random.Random) -> bytes:
    row = draws.choice((b"1,2\n", b"\0" * 64, b"7" * 64, b'"a",1\n', b"# x = 1\n"))
    if draws.random() < 0.01:
        return gzip.compress(row, mtime=0) + gzip.compress(row * (2**24 // len(row)), mtime=0) * 20
    table = "time,x\n" + "".join(f"{i / 100},{i}\n" for i in range(60))
    raw = damaged_table(draws, table, [table]).encode(errors="surrogateescape")
    return flipped(draws, gzip.compress(raw, mtime=0), draws.choice((0, 0, 3)))


def read_hdf5(path: Path, folder: Path) -> None:
    for suffix in (".h5", ".nc", ".mat"):
        with contextlib.suppress(HydrocraneError):
            same_bytes(path, folder / f"log{suffix}")
    same_bytes(path, path.with_suffix(".h5"))


def same_bytes(path: Path, there: Path) -> None:
    if path != there:
        shutil.copy(path, there)
    log = hc.read_log(there)
    assert not any((np.asarray(values) == SECRET).any() for values in log.data.values()), "another file was read"
    log.save(there.with_name("again.csv"))


def same_bytes_of(path: Path, _: Path) -> None:
    same_bytes(path, path)


def read_run(path: Path, folder: Path) -> None:
    found = hc.load_run(path)
    assert found.summary() and repr(found) and found.machine.name
    found.save(folder / "again.nc")


# --- studies ----------------------------------------------------------------------------------------------------------


@cache
def _study() -> Path:
    folder = Path(tempfile.mkdtemp()) / "study"
    keys = {"payload.mass": [50.0, 60.0, 70.0]}
    settings = {"measures": ["end(tip.z)"], "signals": ["tip.z"], "duration": 0.05, "progress": False, "block": 2}
    hc.sweep("single-cylinder-step", keys, store=folder, **settings)
    return folder


def store(draws: random.Random) -> str:
    """File, what is done to it, and a number to draw from."""
    files = sorted(str(p.relative_to(_study())) for p in _study().rglob("*") if p.is_file())
    ways = ("field", "field", "field", "bytes", "remove", "pipe", "link")
    return json.dumps(
        [[draws.choice(files), draws.choice(ways), draws.randrange(2**32)] for _ in range(draws.randint(1, 3))]
    )


def read_store(path: Path, folder: Path) -> None:
    there = folder / "study"
    shutil.copytree(_study(), there)
    for name, way, number in json.loads(path.read_text(encoding="utf-8")):
        file, draws = there / name, random.Random(number)
        if not file.is_file():
            continue
        if way == "bytes" or (way == "field" and file.name != integrity.DESCRIPTION):
            file.write_bytes(flipped(draws, file.read_bytes()))
        elif way == "field":
            try:
                content = json.loads(file.read_text())
            except ValueError:
                continue
            inside = draws.choice([content, content["attributes"]])
            inside[draws.choice(list(inside) or ["shape"])] = draws.choice(
                [None, [], [10**12], "[[", "../x", {}, 7, "string"]
            )
            file.write_text(json.dumps(content))
            with contextlib.suppress(KeyError, TypeError, AttributeError):
                integrity.seal(file.parent)
        else:
            file.unlink()
            if way != "remove":
                (os.mkfifo if way == "pipe" else lambda p: p.symlink_to("/dev/zero"))(file)
    found = hc.open_study(there)
    with contextlib.suppress(ValueError, RuntimeError):  # Values are read when they are asked for, by Zarr.
        found.load()


# --- the command line -------------------------------------------------------------------------------------------------

LINES = [
    words.split()
    for words in (
        "check rottne-f9-lab",
        "machines",
        "simulate single-cylinder-step --set payload.mass=50kg -o out",
        "modes single-cylinder --at slide=0mm",
        "plot run.nc -o plot.png",
        "workspace rottne-f9-lab -o space.png",
        "loadchart single-cylinder -o chart.png",
        "identify log.csv --rig single-cylinder",
        "sweep study.toml",
        "export urdf rottne-f9-lab -o crane.urdf",
        "new own",
        "cite run.nc",
    )
]


def line(draws: random.Random) -> str:
    """A command line with one to three words replaced, left out, doubled or put in."""
    words = list(draws.choice(LINES))
    for _ in range(draws.randint(1, 3)):
        at = draws.randrange(len(words) + 1)
        odd = draws.choice((*ODD, *draws.choice(LINES)))
        words[at : at + draws.randint(0, 1)] = [
            odd if draws.random() < 0.7 else words[at - 1].partition("=")[0] + "=" + odd
        ]
    return json.dumps(words)


def read_line(path: Path, folder: Path) -> None:
    words = json.loads(path.read_text(encoding="utf-8"))
    (folder / "run.nc").write_bytes(_run())
    (folder / "log.csv").write_text("time,x\n0,1\n1,2\n", encoding="utf-8")
    before, told = Path.cwd(), io.StringIO()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
            cli.main(words)
    except SystemExit as end:
        if end.code:
            raise HydrocraneError(told.getvalue()[-3000:].strip()) from None
    finally:
        os.chdir(before)


# --- an FMU -----------------------------------------------------------------------------------------------------------


@cache
def _fmu(fmi: int) -> tuple[Path, Path]:
    folder = Path(tempfile.mkdtemp())
    return hc.export_fmu("single-cylinder", folder / "one.fmu", fmi=fmi), folder / "unzipped"


CALLS = ("step", "get", "set", "keep", "put_back", "let_go", "save", "load", "directional", "initialise", "reset")


def calls(draws: random.Random) -> str:
    names = [draws.choice(CALLS) for _ in range(draws.randint(1, 20))]
    return json.dumps([draws.choice((2, 3)), [[name, draws.randrange(2**32)] for name in names]])


def make_calls(path: Path, _: Path) -> None:
    from fmpy.fmi1 import FMICallException
    from fmu_in_fmpy import Unit

    fmi, program = json.loads(path.read_text(encoding="utf-8"))
    unit = Unit(*_fmu(fmi))
    unit.instantiate()
    names, states, kept = sorted(unit.variables), [], b""
    for name, number in program:
        draws = random.Random(number)
        numbers = [draws.choice((0.0, 1e-320, 1e-15, 1e-3, 0.1, -1.0, 1e300, np.nan, np.inf)) for _ in range(3)]
        some = [draws.choice(names) for _ in range(draws.randint(0, 3))]
        try:
            if name == "step":
                unit.step(numbers[0], numbers[1])
            elif name == "get":
                unit.get(some)
            elif name == "set":
                unit.set(dict(zip(some, numbers, strict=False)))
            elif name == "directional":
                unit.directional(some, some, numbers[: len(some)])
            elif name == "initialise":
                unit.initialise({})
            elif name == "reset":
                unit.fmu.reset()
            elif name == "keep":
                states.append(unit.keep())
            elif name == "put_back" and states:
                unit.put_back(draws.choice(states))
            elif name == "let_go" and states:
                unit.let_go(states.pop())
            elif name == "save":
                kept = unit.save()
            elif name == "load" and kept:
                unit.load(flipped(draws, kept))
        except FMICallException:
            assert all(text.strip() for text in unit.messages.texts), "an error without a message"
    for state in states:
        unit.let_go(state)
    unit.close()
    assert not any("defect of hydrocrane" in text for text in unit.messages.texts), unit.messages.texts[-1]
