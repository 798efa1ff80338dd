"""Names and texts of files that somebody sends: one rule where they are read, and no writer takes them for code."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
import warnings
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import scipy.io
import xarray as xr
from command_line import run

import hydrocrane as hc
from hydrocrane.app.console import complain, say
from hydrocrane.files.datasets import save
from hydrocrane.identification.values.result import block
from hydrocrane.logs.formats.writers import write_log
from hydrocrane.plots.style import one_chart, styled, title, write

WRONG = (
    "", "a b", "../../../x", "/abs/x", "C:\\x", ".x", "..", "NUL", "com1.toml", "x" * 65, "[/bold]", "$\\frac{$",
    "=1+1", "*/ int x; /*", "a\0b", "a\x1b[31mb", "a\x7fb", "a\x9bb", "a\u202eb", "a\ufffeb", "a\nb", "\ud800",
    "\udcff",
)  # fmt: skip
# Names that the rule allows and that some format could misread.
ODD = ("crane---v2", "--", "-", "-x-", "a--.--b", "Größe", "起重机", "क्रेन", "\u0301x")
# A title that means something to spreadsheets, terminals, formulas, TeX, XML and C.
TITLE = '=HYPERLINK("http://x") [/bold] :bomb: $\\frac{$ --> ]]> <b>&amp; */ \\input{x} %s'
STUDY = '[study]\nname = {}\nscenario = "single-cylinder-step"\n[keys]\n"payload.mass" = ["50 kg"]\n'


def named(name, **more):
    return hc.load_machine("rottne-f9-lab", {"machine.name": name, **more})


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_name_is_refused_everywhere(name, tmp_path):
    for call in (
        lambda: named(name),
        lambda: hc.load_scenario("vertical-lift-open-loop", {"scenario.name": name}),
        lambda: hc.Scenario(name=name),
        lambda: hc.simulate("vertical-lift-open-loop", name=name),
    ):
        with pytest.raises(hc.HydrocraneError) as caught:
            call()
        assert str(caught.value).isprintable() and isinstance(caught.value, hc.InputError | hc.MachineFileError)
    if name.isprintable() and name.isascii():
        (tmp_path / "x.toml").write_text(STUDY.format(f"'{name}'"))
        with pytest.raises(hc.InputError, match=r"study\.name"):
            hc.load_study(tmp_path / "x.toml")


def test_a_study_writes_below_the_present_folder(tmp_path):
    for store in ("/abs/x", "../x", "a/../../x", "C:\\x", "\\\\host\\x", "..\\x"):
        (tmp_path / "x.toml").write_text(STUDY.format(f"'x'\nstore = '{store}'"))
        with pytest.raises(hc.InputError, match="leads out of the present folder"):
            hc.load_study(tmp_path / "x.toml")
    (tmp_path / "x.toml").write_text(STUDY.format("'x'\nstore = 'results/x.zarr'"))
    assert hc.load_study(tmp_path / "x.toml").store == Path("results/x.zarr")


def test_a_study_names_no_path_into_a_network(tmp_path):
    for wrong in ("scenario = '//h/s/x.toml'", "scenario = 'x'\nmachine = '\\\\h\\x.toml'"):
        (tmp_path / "x.toml").write_text(f"[study]\n{wrong}\n[keys]\nx = [1]\n")
        with pytest.raises(hc.InputError, match="leads into a network"):
            hc.load_study(tmp_path / "x.toml")
    (tmp_path / "x.toml").write_text("[study]\nscenario = 'x'\n[keys]\ncommand.log = ['a.csv', '//h/a.csv']\n")
    with pytest.raises(hc.InputError, match=r"command\.log is `//h/a\.csv`"):
        hc.load_study(tmp_path / "x.toml")


@pytest.mark.parametrize("name", ODD)
def test_exports_with_an_odd_name_are_read(name, tmp_path):
    machine = named(name, **{"machine.title": TITLE})
    hc.export_urdf(machine, tmp_path / "x.urdf")
    hc.export_mjcf(machine, tmp_path / "x.xml")
    for file, key in (("x.urdf", "name"), ("x.xml", "model")):
        text = (tmp_path / file).read_text(encoding="utf-8")
        assert ElementTree.fromstring(text).get(key) == name
        # Python's parser is more patient than others with comments.
        assert "--" not in re.search("<!--(.*?)-->", text, re.S)[1]


def test_a_name_is_no_code_in_c(tmp_path, monkeypatch):
    """The reader lets no such name pass; the writer would not either."""
    machine = named("x")
    monkeypatch.setattr(type(machine), "name", property(lambda _: "x */ int injected; /*"))
    header = (hc.export_controller(machine, tmp_path) / "hydrocrane_parameters.h").read_text(encoding="utf-8")
    assert "injected" not in re.sub(r"/\*.*?\*/", "", header, flags=re.S) and "/*" not in header[2 : header.index("*/")]
    if compiler := shutil.which("cc"):
        subprocess.run(
            [compiler, "-Wall", "-Werror", "-fsyntax-only", "hydrocrane_parameters.c"], cwd=tmp_path, check=True
        )


@pytest.fixture(scope="module")
def titled_run():
    return hc.simulate("single-cylinder-step", title=TITLE, duration=0.05)


def test_texts_in_a_workbook_are_no_formulas(titled_run, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    data = titled_run.data.rename({"tip.z": "=1+1", "tip.x": "a\x0bb"}).assign_attrs({"=2+2": "#N/A"})
    save(data, tmp_path / "run.xlsx")
    book = openpyxl.load_workbook(tmp_path / "run.xlsx")
    cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row if cell.value is not None]
    assert {cell.data_type for cell in cells} == {"s", "n"}
    assert {TITLE, "=1+1 [m]", "=2+2", "#N/A", "a\ufffdb"} <= {cell.value for cell in cells}


def test_charts_show_dollars_as_they_are(titled_run, tmp_path):
    warnings.filterwarnings("ignore", "Glyph")

    @styled
    def chart():
        fig, axes = one_chart(4.0, 3.0)
        axes.plot([1.0, 1000.0], [1.0, 2.0], label=TITLE)
        axes.set(xscale="log", xlabel="$\\frac{$", ylabel="a\ufffeb\x01")
        axes.set_yticks([1.0, 2.0], ["$\\frac{$", "$b$"])
        axes.legend()
        title(fig, TITLE, "$x^2$")
        return fig

    for path in (write(chart(), tmp_path / "x.svg"), titled_run.plot("test", path=tmp_path / "run.svg")):
        assert ElementTree.parse(tmp_path / "x.svg") is not None and path is not None
    assert "<!-- 1000 -->" in (tmp_path / "x.svg").read_text(encoding="utf-8")
    write(chart(), tmp_path / "x.png")


def test_the_terminal_shows_texts_as_they_are(capsys):
    from rich.table import Table

    table = Table("[/bold]", title="[/title]")
    table.add_row("[red]x[/] :bomb:\x1b[2J")
    say("[/bold] \x1b[31m\0", table)
    complain("[/bold] \x9b \ud800")
    out, err = capsys.readouterr()
    assert "[/bold] \\x1b[31m\\x00" in out and "[red]x[/] :bomb:\\x1b[2J" in out and "[/title]" in out
    assert "[/bold] \\x9b \\ud800" in err and not {"\x1b", "\x9b"} & set(out + err)


def test_machines_with_markup_in_their_titles_are_listed(tmp_path):
    text = f'extends = "rottne-f9-lab"\n[machine]\ntitle = {TITLE!r}\n'.replace("\\\\", "\\")
    (tmp_path / "x.toml").write_text(text)
    # The terminal breaks lines.
    assert " ".join(TITLE.split()) in " ".join(run("check", tmp_path / "x.toml").stdout.split())


def test_blocks_and_logs_keep_file_names_in_their_place(tmp_path):
    machine = named("x")
    evil = 'a\n[machine]\nname = "b"\r\x1b.csv'
    found = block(machine, {"friction.lift.coulomb[0]": (1.0, 2.0)}, [evil], "x", [evil], "")
    assert set(tomllib.loads(found)) == {"friction"}
    data = xr.Dataset(
        {'a,"b\nc': ("time", np.arange(3.0), {"units": "m,\n"})}, {"time": np.arange(3.0)}, {"é🚜": "🚜\n"}
    )
    write_log(data, tmp_path / "log.csv")
    read = hc.read_log(tmp_path / "log.csv")
    assert len(read.data) == 1 and len(read.data.time) == 3


def test_names_that_matlab_would_take_for_one_stay_two(tmp_path):
    data = xr.Dataset({name: ("time", [value]) for name, value in (("тяга.x", 1.0), ("груз.x", 2.0))}, {"time": [0.0]})
    save(data, tmp_path / "run.mat")
    found = scipy.io.loadmat(tmp_path / "run.mat", simplify_cells=True)
    assert {name: float(found[short]) for short, name in found["names"].items()} == {
        "time": 0.0,
        "тяга.x": 1.0,
        "груз.x": 2.0,
    }


HALF = "\ud800"
START = {"boom": 1.745, "jib": 1.745, "extension": 0.0}
NO_TEXT = {
    "value of an override": lambda: hc.load_machine("rottne-f9-lab", {"supply.pressure": HALF}),
    "value in a list": lambda: hc.load_machine("rottne-f9-lab", {"friction.lift.coulomb": ["1 N", HALF]}),
    "key of an override": lambda: hc.load_machine("rottne-f9-lab", {HALF: 1.0}),
    "byte of a command line": lambda: hc.load_machine("rottne-f9-lab", {"supply.pressure": "\udcff"}),
    "lists in lists": lambda: hc.load_machine("rottne-f9-lab", {"supply.pressure": [[1.0]]}),
    "list of itself": lambda: hc.load_machine("rottne-f9-lab", {"supply.pressure": endless()}),
    "override of a scenario": lambda: hc.load_scenario("vertical-lift-open-loop", {"scenario.title": HALF}),
    "source": lambda: hc.load_machine(HALF),
    "path": lambda: hc.load_machine(f"{HALF}.toml"),
    "scenario": lambda: hc.load_scenario(f"{HALF}.toml"),
    "commands": lambda: hc.simulate("vertical-lift-open-loop", commands={HALF: 1e-3}),
    "joints": lambda: hc.simulate("vertical-lift-open-loop", joints={HALF: 1.0}),
    "number as a joint": lambda: hc.simulate("vertical-lift-open-loop", joints={**START, 1: 1.0}),
    "nothing as a cylinder": lambda: hc.simulate("vertical-lift-open-loop", commands={None: 1e-3}),
    "pressures": lambda: hc.simulate("vertical-lift-open-loop", pressures={HALF: (1e5, 1e5)}),
    "title": lambda: hc.Scenario(title=HALF),
    "overrides of a scenario": lambda: hc.simulate("vertical-lift-open-loop", overrides={"supply.pressure": HALF}),
    "payload beside an override": lambda: hc.simulate(
        "vertical-lift-open-loop", payload=1.0, overrides={"payload.mass": HALF}
    ),
    "controller model": lambda: hc.simulate("tip-vertical-line", controller_model={HALF: HALF}),
    "burst": lambda: hc.simulate("vertical-lift-open-loop", bursts=[hc.Burst(HALF, "rod-side", 1.0, 1e-6)]),
    "sensor fault": lambda: hc.simulate("tip-vertical-line", sensor_faults=[hc.SensorFault(HALF, "freeze", 1.0)]),
    "keys of a study": lambda: hc.sweep("vertical-lift-open-loop", {HALF: [1.0]}),
    "values of a study": lambda: hc.sweep("vertical-lift-open-loop", {"supply.pressure": [HALF]}),
    "study": lambda: hc.load_study(f"{HALF}.toml"),
    "study without an end": lambda: hc.load_study("a\0.toml"),
    "log": lambda: hc.read_commands(f"{HALF}.csv", "rottne-f9-lab"),
    "column of a log": lambda: hc.read_commands("x.csv", "rottne-f9-lab", columns={"lift": HALF}),
    "value of a machine": lambda: hc.load_machine("rottne-f9-lab").value(HALF),
    "changed": lambda: hc.load_machine("rottne-f9-lab").changed({HALF: HALF}),
    "quantity": lambda: hc.load_machine("rottne-f9-lab", {"supply.pressure": f"1 {HALF}"}),
    "FMU": lambda: hc.export_fmu("rottne-f9-lab", "x.fmu", parameters=[HALF]),
    "sensitivities": lambda: hc.sensitivities("vertical-lift-open-loop", [HALF]),
}


def endless():
    one = []
    one.append(one)
    return one


@pytest.mark.parametrize("call", NO_TEXT.values(), ids=NO_TEXT)
def test_what_is_no_text_is_an_input_error(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(hc.HydrocraneError) as caught:
        call()
    str(caught.value).encode("utf-8")


@pytest.mark.parametrize(
    "setting", ["supply.pressure=\udcff", "\udcff=1", "supply.pressure=" + "[" * 5000, "a=" + "9" * 5000]
)
def test_bytes_on_the_command_line_are_an_error(setting):
    done = run("check", "rottne-f9-lab", "--set", setting)
    assert done.returncode == 2 and done.stderr.startswith("error: ") and "Traceback" not in done.stderr
