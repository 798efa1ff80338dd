"""What notebooks show: valid HTML of the text form, escaped, below 20 kB, each thing once."""

import base64
import html
import re
import sys
import types
from html.parser import HTMLParser

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane import notebook
from hydrocrane.studies.board import telling

mpl.use("Agg")
EMPTY = {"br", "img", "hr"}
WILD = "<script>alert('&')</script>"


class Page(HTMLParser):
    """The text of a page, cell by cell; tags that do not match are an error."""

    def __init__(self, source):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.cells = [], [], []
        self.feed(source)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        assert len(dict(attrs)) == len(attrs)
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.cells.append(data)


def page(thing):
    source = thing._repr_html_()
    assert len(source.encode()) <= 20_000
    found = Page(source)
    assert set(found.tags) <= {"div", "strong", "table", "tr", "th", "td"}
    return found


def words(text):
    return " ".join(text.split())


@pytest.fixture(scope="module")
def run():
    return hc.simulate("vertical-lift-open-loop", duration=0.4)


@pytest.mark.parametrize("name", hc.bundled_machines())
def test_a_machine_says_what_it_is(name):
    crane = hc.load_machine(name)
    text = words(" ".join(page(crane).cells))
    assert f"Machine {name}" in text and f"{len(crane.state_names)}" in text
    for part in (*crane.joint_names, *crane.cylinder_names, f"{1e-5 * crane.supply_pressure:.4g} bar"):
        assert part in text
    assert "overrides" not in text


def test_a_machine_with_overrides_says_them_and_its_warnings():
    text = words(" ".join(page(hc.load_machine("single-cylinder", {"payload.mass": 7e4})).cells))
    assert "payload.mass = 70000.0" in text and "warning" in text


def test_a_run_a_fit_and_an_identification_show_their_summary_once(run):
    """Every word of the text form, in its order, and no other."""
    summary = run.summary()
    assert words(" ".join(page(run).cells)) == words(summary)
    doubtful = summary + "\nwarning: p1 < 0 & p2 > 300 bar"
    for kind in (hc.Fit, hc.Identification):
        stand_in = types.SimpleNamespace(cylinder="lift", summary=lambda: doubtful)
        source = kind._repr_html_(stand_in)
        cells = words(" ".join(Page(source).cells))
        assert cells.endswith(words(doubtful)) and len(cells) - len(words(doubtful)) < 40
        assert "color:#c8553d" in source


def test_a_comparison_shows_each_quantity(run):
    log = {"time": run.columns.time, "tip.z": run.columns["tip.z"].values + 1e-3}
    found = run.compare(log)
    assert words(" ".join(page(found).cells)) == words("Run and log " + found.summary())


@pytest.mark.parametrize("name", hc.bundled_scenarios())
def test_a_scenario_says_what_it_does(name):
    plan = hc.load_scenario(name)
    text = words(" ".join(page(plan).cells))
    for part in (name, str(plan.machine), f"{plan.duration:g} s", plan.solver.method):
        assert part in text


def test_a_study_says_what_it_varies_and_a_wrong_one_why():
    study = hc.Study(
        "single-cylinder-step", {"payload.mass": [0.0, 10.0, 20.0], "supply.pressure": ["100 bar", "140 bar"]}
    )
    text = words(" ".join(page(study).cells))
    for part in ("single-cylinder-step", "cases 6, grid", "payload.mass 3 values: 0, 10, 20"):
        assert part in text, text
    wrong = words(" ".join(page(hc.Study("single-cylinder-step", {"payload.mas": [0.0, 1.0]})).cells))
    assert "payload.mas" in wrong and "warning" in wrong


def test_a_study_of_drawn_values_says_their_range():
    study = hc.Study("single-cylinder-step", {"payload.mass": (0.0, 20.0)}, method="random", n=200)
    (ends,) = re.findall(r"payload.mass 200 values: (\S+) \.\.\. (\S+)", words(" ".join(page(study).cells)))
    assert 0.0 <= float(ends[0]) < 1.0 and 19.0 < float(ends[1]) <= 20.0


def test_a_linear_model_says_what_oscillates():
    crane = hc.load_machine("rottne-f9-lab")
    model = crane.linearise(crane.home)
    text = words(" ".join(page(model).cells))
    assert text.startswith("Linear model of rottne-f9-lab") and "tip.z [m]" in text
    assert text.count("damping ratio") == len(model.oscillations.frequency)


def test_what_a_file_says_is_text_and_no_tag():
    plan = hc.load_scenario("single-cylinder-step").changed(title=WILD)
    assert html.escape(WILD) in plan._repr_html_() and WILD in page(plan).cells
    assert "script" not in page(plan).tags


def test_long_texts_are_cut_and_say_so():
    source = notebook.card("long", [f"key {i}  {WILD * 20}" for i in range(500)], "print(it)")
    assert 15_000 < len(source.encode()) <= 20_000
    last = Page(source).cells[-1]
    assert last.startswith("and ") and last.endswith("more lines: print(it)")
    rows = Page(source).tags.count("tr") - 1
    assert int(last.split()[1]) == 500 - rows
    short = notebook.card("many", [f"key {i}  {i}" for i in range(500)], "print(it)")
    assert Page(short).tags.count("tr") == notebook.TALLEST + 1
    assert Page(short).cells[-1] == f"and {500 - notebook.TALLEST} more lines: print(it)"


class Shell:
    pass


Shell.__name__ = "ZMQInteractiveShell"


@pytest.fixture
def jupyter(monkeypatch):
    """A notebook's kernel as this package sees it: a shell, and a display that notes what it shows."""
    shown = []

    class Handle:
        def update(self, thing):
            shown.append(thing)

    def display(thing, display_id=False):
        shown.append(thing)
        return Handle()

    whole, part = types.ModuleType("IPython"), types.ModuleType("IPython.display")
    whole.get_ipython, whole.version_info, part.HTML, part.display = Shell, (9, 0), str, display
    monkeypatch.setitem(sys.modules, "IPython", whole)
    monkeypatch.setitem(sys.modules, "IPython.display", part)
    return shown


def test_a_figure_is_shown_once(run, jupyter):
    """Pyplot holds none, so the notebook shows only what the cell gives back."""
    plt.close("all")
    for figure in (run.plot("lift"), hc.plots.circuit(run.machine), hc.plots.overlay({"a": run}, "tip.z")):
        assert not plt.get_fignums() and figure.axes


def test_elsewhere_pyplot_holds_the_figures(run):
    plt.close("all")
    run.plot("lift")
    assert len(plt.get_fignums()) == 1
    plt.close("all")


def test_a_study_has_a_bar_in_a_notebook(jupyter):
    with telling(None, "cases <1>") as tell:
        tell(0, 40)
        tell(40, 40)
    assert 'value="40" max="40"' in jupyter[-2] and "cases &lt;1&gt;: 40 of 40" in jupyter[-2]
    assert jupyter[-1] == ""
    del jupyter[:]
    with telling(False, "cases") as tell:
        tell(1, 2)
    assert not jupyter


def test_an_animation_plays_in_the_page(run, jupyter):
    film = run.animate(fps=5)
    source = film._repr_html_()
    assert Page(source).tags == ["img"] and not plt.get_fignums()
    data = base64.b64decode(source.split("base64,")[1].split('"')[0])
    assert data[:6] in (b"GIF87a", b"GIF89a")
    # Its making is watched.
    assert any("drawing film.gif" in str(thing) for thing in jupyter)
    assert np.isfinite(len(data))
