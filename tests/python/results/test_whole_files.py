"""A file under its final name is whole, also where the disk is full; the process ends with one message."""

import errno
import os
import stat
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import hydrocrane as hc
from hydrocrane.files.whole_file import write_text, written_whole

pytestmark = pytest.mark.evidence

posix = pytest.mark.skipif(sys.platform == "win32", reason="a limit on the size of files needs POSIX")


def limited(code, most, folder):
    """Run Python in a process whose files cannot grow beyond `most` bytes: writing fails as on a full disk."""
    head = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({most}, {most}))\n"
    # Nothing but what is under test shall be written.
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, "-c", head + code], capture_output=True, text=True, cwd=folder, timeout=300, env=environment
    )


def command(*arguments):
    return f"from hydrocrane.app.cli import main\nmain({list(map(str, arguments))!r})"


def refused(done, name):
    """Exit status 2 (no signal), one message that names the file, no traceback."""
    assert done.returncode == 2, (done.returncode, done.stderr)
    assert "Traceback" not in done.stderr and done.stderr.count("error:") == 1, done.stderr
    assert f"cannot write `{name}`" in " ".join(done.stderr.split()), done.stderr


@pytest.fixture(scope="module")
def run():
    return hc.simulate("vertical-lift-open-loop", duration=0.5)


@posix
def test_simulate_on_a_full_disk_leaves_nothing_broken(tmp_path):
    done = limited(command("simulate", "vertical-lift-open-loop", "--duration", 0.5, "-o", "out"), 50_000, tmp_path)
    refused(done, "out/vertical-lift-open-loop.nc")
    assert not list((tmp_path / "out").iterdir())


RUNS = ["run.nc", "run.mat", "run.csv", "run.parquet", "run.xlsx", "run.mcap", "run.png", "run.gif"]
LOGS = ["log.csv", "log.mat", "log.nc", "log.h5"]
# Every writer in one process: to load the libraries takes longer than all of them.
WRITERS = """
import os
from pathlib import Path
import matplotlib; matplotlib.use("Agg")
import numpy as np
import hydrocrane as hc
run = hc.load_run("whole.nc")
log = hc.Log.of({"time": np.arange(5000) * 0.01, "x": np.random.default_rng(0).normal(size=5000)}, source="test")
def write(name):
    if name.endswith(".png"):
        run.plot(path=name)
    elif name.endswith(".gif"):
        run.animate(name, fps=5)
    else:
        (run if name.startswith("run") else log).save(name)
for folder in sorted(Path.cwd().glob("*/")):
    os.chdir(folder)
    try:
        write(folder.name)
        print(f"{folder.name}: written")
    except hc.ResultFileError as error:
        print(f"{folder.name}: refused: {error}")
    os.chdir("..")
"""
BEFORE = b"what was there"


@pytest.fixture(scope="module", params=[False, True], ids=["new", "over another"])
def full_disk(request, run, tmp_path_factory):
    """A folder with one folder per file that was to be written, what was said, and whether files were there before."""
    folder = tmp_path_factory.mktemp("full")
    for name in (*RUNS, *LOGS):
        (folder / name).mkdir()
        if request.param:
            (folder / name / name).write_bytes(BEFORE)
    run.save(folder / "whole.nc")
    done = limited(WRITERS, 5_000, folder)
    assert done.returncode == 0, done.stderr
    return folder, done.stdout.splitlines(), request.param


@posix
@pytest.mark.parametrize("name", [*RUNS, *LOGS])
def test_no_writer_leaves_half_a_file(full_disk, name):
    folder, said, before = full_disk
    assert any(line.startswith(f"{name}: refused: cannot write `{name}`") for line in said), said
    assert [path.name for path in (folder / name).iterdir()] == ([name] if before else [])
    assert not before or (folder / name / name).read_bytes() == BEFORE


@posix
def test_texts_and_starters_are_whole_too(tmp_path):
    refused(limited(command("new", "mine"), 2_000, tmp_path), "mine/machine.toml")
    assert not list((tmp_path / "mine").iterdir())


@pytest.mark.skipif(
    sys.platform != "linux" or os.geteuid() != 0, reason="a disk of its own that can be filled needs Linux and root"
)
def test_simulate_on_a_disk_that_is_really_full(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        code = command("simulate", "vertical-lift-open-loop", "--duration", 0.5, "-o", disk)
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
        refused(done, f"{disk}/vertical-lift-open-loop.nc")
        assert "free some space" in " ".join(done.stderr.split()) and not list(disk.iterdir())
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_a_film_that_cannot_be_written_is_told_before_the_run(tmp_path, monkeypatch, capsys):
    from hydrocrane.app.cli import main

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(hc.simulation, "simulate", None)
    monkeypatch.setattr(hc, "simulate", None)
    for options, words in (
        (["--film", "mp4"], "ffmpeg"),
        (["--also", "csvv"], ".csv"),
        (["--also", "nc,xls"], "unknown suffix `.xls`"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["simulate", "vertical-lift-open-loop", *options])
        assert ended.value.code == 2 and words in capsys.readouterr().err
    for arguments in (["animate", "vertical-lift-open-loop", "-o", "x.mp4"], ["plot", "tip-circle", "-o", "x.xlsx"]):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == 2 and "cannot write" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_what_was_there_stays_until_the_new_file_is_whole(tmp_path):
    target = tmp_path / "folder" / "a.txt"
    assert write_text(target, "first\n") == target and target.read_bytes() == b"first\n"
    with pytest.raises(RuntimeError), written_whole(target) as beside:
        beside.write_text("half")
        assert beside.suffix == ".txt" and beside.parent == target.parent and target.read_text() == "first\n"
        raise RuntimeError
    with pytest.raises(KeyboardInterrupt), written_whole(target) as beside:
        beside.write_text("half")
        raise KeyboardInterrupt
    assert target.read_text() == "first\n" and list(target.parent.iterdir()) == [target]


def test_links_devices_and_folders(tmp_path):
    (tmp_path / "real.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to("real.txt")
    write_text(tmp_path / "link.txt", "new")
    assert (tmp_path / "link.txt").is_symlink() and (tmp_path / "real.txt").read_text() == "new"
    write_text(os.devnull, "nothing")
    assert not stat.S_ISREG(os.stat(os.devnull).st_mode)
    with pytest.raises(hc.ResultFileError, match="folder"):
        write_text(tmp_path, "text")
    with pytest.raises(hc.ResultFileError, match="a part of this path is a file"):
        write_text(tmp_path / "real.txt" / "x.txt", "text")


def test_the_systems_reason_and_a_cure_are_told(tmp_path):
    words = f"{os.strerror(errno.ENOSPC)}; free some space"
    with pytest.raises(hc.ResultFileError, match=words), written_whole(tmp_path / "x.nc"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_run_reads_back_as_it_was_written(run, tmp_path):
    run.save(tmp_path / "run.nc")
    again = hc.load_run(tmp_path / "run.nc")
    xr.testing.assert_identical(again.data.drop_attrs(), run.data.drop_attrs())
    assert again.outcome == run.outcome and np.array_equal(again.data.time, run.data.time)


@pytest.mark.skipif(os.name != "posix", reason="modes of files are those of POSIX")
def test_a_file_that_is_overwritten_keeps_its_mode(tmp_path):
    secret = tmp_path / "drive.toml"
    secret.write_text("before")
    secret.chmod(0o640)
    write_text(secret, "after")
    assert secret.read_text() == "after" and secret.stat().st_mode & 0o777 == 0o640
