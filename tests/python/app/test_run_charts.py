"""Charts of a run by name, and signals of runs over each other on the command line."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from command_line import run as command

import hydrocrane as hc
from hydrocrane.results.energy import energy_flow

mpl.use("Agg")


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def sensing():
    return hc.simulate("vertical-lift-open-loop", machine="rottne-f9-mobile", duration=1.2)


@pytest.fixture(scope="module")
def weak():
    """Two functions at once ask for more than half of the pump gives."""
    half = {"pump.main.displacement": "5 ml"}
    return hc.simulate("vertical-lift-open-loop", machine="rottne-f9-mobile", duration=1.2, overrides=half)


@pytest.fixture(scope="module")
def saved(sensing, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    sensing.save(folder / "before.nc")
    hc.simulate("vertical-lift-open-loop", duration=0.8).save(folder / "after.nc")
    return folder


def test_the_bars_of_the_energy_add_up_to_what_the_pump_gave(sensing):
    axes = sensing.plot("energy").axes[0]
    flow = energy_flow(sensing)
    names = [label.get_text() for label in axes.get_yticklabels()]
    bars = dict.fromkeys(names, 0.0)
    for place, name in zip(axes.get_yticks(), names, strict=True):
        bars[name] = sum(
            bar.get_width() for bar in axes.patches if bar.get_y() < place < bar.get_y() + bar.get_height()
        )
    given = {entry.name for entry in flow.given}
    assert names[0] == "shaft of the pump"
    assert sum(width for name, width in bars.items() if name in given) == pytest.approx(1e-3 * flow.total, rel=1e-3)
    assert sum(width for name, width in bars.items() if name not in given) == pytest.approx(1e-3 * flow.total, rel=1e-3)
    shares = [text.get_text().split()[-2] for text in axes.texts]
    assert sum(map(float, shares)) == pytest.approx(200.0, abs=1.0)
    assert {"pressure compensators of all valves", "leakage of the pump", "metering edge supply to A"} <= set(names)


def test_no_text_of_the_energy_lies_over_another(sensing):
    figure = sensing.plot("energy")
    figure.canvas.draw()
    axes = figure.axes[0]
    texts = [*axes.texts, *axes.get_yticklabels(), *axes.get_legend().get_texts(), axes.title, *figure.texts]
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts if text.get_text()]
    for i, (name, box) in enumerate(boxes):
        assert not [other for other, there in boxes[:i] if box.overlaps(there)], name


def test_a_machine_with_an_ideal_supply_has_fewer_charts_of_it(sensing):
    headings = [axes.get_title(loc="left") for axes in sensing.plot("supply").axes]
    assert headings[:4] == ["Pressures", "Flows", "Power", "Displacement of the pump in use"] and len(headings) == 6
    ideal = hc.simulate("single-cylinder-step", duration=0.1).plot("supply")
    assert [axes.get_title(loc="left") for axes in ideal.axes] == ["Flows", "Power"]
    assert [axes.get_ylabel() for axes in ideal.axes] == ["flow [l/min]", "power [kW]"]


def test_shortfall_says_when_the_pump_is_too_small(sensing, weak):
    """Steady, a pump that suffices lacks nothing and one that does not gives all of its displacement."""
    for run, lacks in ((sensing, False), (weak, True)):
        late = run.data.isel(time=run.data.time > 1.1)
        short = late["mains.shortfall"] / late["mains.setting"]
        assert bool((short > 0.02).all()) == lacks and bool((abs(short) < 0.02).all()) != lacks
        assert bool((late["pump.main.displacement"] > 0.98).all()) == lacks
        # What the pump keeps without flow, less its control range as far as it has swivelled out.
        control = late["mains.setting"] - 4e5 * late["pump.main.displacement"] - late["mains.p"]
        np.testing.assert_allclose(late["mains.shortfall"], control, atol=1e-6)
        np.testing.assert_allclose(late["mains.setting"], np.minimum(180e5, late["mains.load"] + 20e5), atol=1e-6)
        shaded = [patch for patch in run.plot("supply").axes[0].collections if patch.get_paths()]
        assert bool(shaded) == lacks


def test_what_a_compensator_takes_is_what_its_edge_leaves(sensing):
    """With 8 bar kept over the edge the compensator takes the rest of the drop from the mains to the fed port."""
    data = sensing.data
    fed = (data["cylinder.lift.xs"] > 6e-3).values & (data.time > 1.1).values
    assert fed.any()
    rest = data["mains.p"] - data["cylinder.lift.p1"] - 8e5
    np.testing.assert_allclose(data["cylinder.lift.compensator_drop"].values[fed], rest.values[fed], atol=0.5e5)
    centred = np.abs(data["cylinder.lift.xs"].values) < 1e-3
    assert centred.any() and not data["cylinder.lift.compensator_drop"].values[centred].any()


def test_charts_by_name_from_the_command_line(saved, sensing):
    for chart in ("energy", "supply", "tip"):
        done = command("plot", "before.nc", "--chart", chart, folder=saved)
        assert done.returncode == 0 and (saved / f"before-{chart}.png").stat().st_size > 10_000, done.stderr
    with pytest.raises(hc.InputError, match="did you mean `energy`"):
        sensing.plot("energi")


def test_signals_of_runs_over_each_other(saved, monkeypatch):
    drawn = []
    overlay = hc.plots.overlay
    monkeypatch.setattr(hc.plots, "overlay", lambda *arguments: drawn.append(overlay(*arguments)) or drawn[-1])
    signals = ["--signal", "tip.z", "--signal", "cylinder.lift.p1"]
    done = command("plot", "before.nc", "after.nc", *signals, "-o", "both.png", folder=saved)
    assert done.returncode == 0 and (saved / "both.png").is_file(), done.stderr
    upper, lower = drawn[0].axes
    assert [line.get_label() for line in upper.lines] == ["before", "after"]
    assert (upper.get_title(loc="left"), upper.get_ylabel()) == ("tip.z: crane tip, up", "[mm]")
    assert (lower.get_title(loc="left"), lower.get_ylabel()) == ("cylinder.lift.p1: lift piston-side pressure", "[bar]")
    assert lower.get_xlabel() == "time [s]"
    before = hc.load_run(saved / "before.nc").data["cylinder.lift.p1"]
    np.testing.assert_allclose(lower.lines[0].get_ydata(), 1e-5 * before)
    assert command("plot", "before.nc", "--signal", "tip.z", folder=saved).returncode == 0
    assert (saved / "before-signals.png").is_file()


def test_what_cannot_be_drawn_is_one_message(saved):
    for arguments, words in (
        (["before.nc", "after.nc"], "--signal tip.z"),
        (["before.nc", "before.nc", "--signal", "tip.z"], "named twice"),
        (["before.nc", "--signal", "tip.y"], "did you mean `tip.z`"),
        (["before.nc", "after.nc", "--signal", "mains.p"], "signal of run `after`"),
        (["before.nc", "--signal", "tip.z", "--chart", "energy"], "leave --chart and --cylinder out"),
        (["before.nc", "--chart", "supply", "--cylinder", "lift"], "of the whole machine"),
    ):
        done = command("plot", *arguments, folder=saved)
        assert done.returncode == 2 and done.stderr.count("error:") == 1, arguments
        assert words in " ".join(done.stderr.split()), done.stderr
