"""What the command line prints on narrow terminals and on full disks, and what it says after Ctrl-C."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import hydrocrane as hc
from hydrocrane.app import cli
from hydrocrane.app.console import say

COMMANDS = {
    "machines": ("machines",),
    "check": ("check", "rottne-f9-lab"),
    "modes": ("modes", "rottne-f9-lab", "--samples", "0"),
    "modes of a jib": ("modes", "hiab-xs031", "--samples", "0"),
    "linearise": ("linearise", "hiab-xs031", "-o", "linear.json"),
    "loops": ("bode", "rottne-f9-lab", "--loops", "-o", "bode.png"),
    "bode": ("bode", "rottne-f9-lab", "-o", "bode.png"),
    "simulate": ("simulate", "vertical-lift-open-loop", "--duration", "0.3", "--film", "none", "-o", "."),
    "rig list": ("rig", "list"),
    "loadchart": ("loadchart", "rottne-f9-lab", "--samples", "5"),
    "an error": ("check", "rottne-f9-lap"),
    "check of a scenario": ("check", "flow-valve-lift"),
}


def hydrocrane(*arguments, stdout=subprocess.PIPE, **settings):
    command = [sys.executable, "-m", "hydrocrane", *arguments]
    environment = os.environ | {"MPLBACKEND": "Agg", **settings}
    return subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, text=True, env=environment, check=False)


@pytest.mark.parametrize("columns", [80, 60])
@pytest.mark.parametrize("name", COMMANDS)
def test_tables_fit_narrow_terminals(name, columns, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", str(columns))
    with pytest.raises(SystemExit):
        cli.main(list(COMMANDS[name]))
    shown, told = capsys.readouterr()
    assert "…" not in shown
    assert not [line for line in (shown + told).splitlines() if len(line) > columns and " " in line.strip()]
    for machine in hc.bundled_machines() if name == "machines" else ("rottne-f9-lab",)[: name == "check"]:
        assert machine in shown
    words = ("modulus", "extension") if name == "loops" else ("frequency", "damping", "record", "every", "ms")
    for word in words if name in ("modes", "modes of a jib", "linearise", "loops") else ():
        assert word in shown.replace(",", "").split()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a device that is full")
@pytest.mark.parametrize("command", [("machines",), ("cite", "rottne-f9-lab"), ("--version",)])
def test_a_full_disk_is_one_clear_error(command):
    with open("/dev/full", "w") as full:
        done = hydrocrane(*command, stdout=full)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1 and "No space left on device" in done.stderr, done.stderr


def test_ctrl_c_says_what_was_written(tmp_path, monkeypatch, capsys):
    def interrupted(self, *_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("hydrocrane.results.run.Run.animate", interrupted)
    with pytest.raises(SystemExit):
        cli.main(["simulate", "vertical-lift-open-loop", "--duration", "0.2", "-o", str(tmp_path)])
    told = capsys.readouterr()
    assert "vertical-lift-open-loop.nc" in told.out and "not everything was written" in told.err
    assert (tmp_path / "vertical-lift-open-loop.nc").exists() and ".gif" not in told.out


def test_lines_of_files_are_not_wrapped(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "20")
    lines = ['12 | bore = "50 mm" # of the lift cylinder', 'source = "the longest of all data sheets"']
    say(*lines)
    assert capsys.readouterr().out.splitlines() == lines
