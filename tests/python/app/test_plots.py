"""Pictures hold what they should, in the units people read; films are films."""

import shutil

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

import hydrocrane as hc
from hydrocrane import plots
from hydrocrane.plots.grid_layout import arrange
from hydrocrane.plots.style import RC, figure, title

mpl.use("Agg")


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def run():
    return hc.simulate("vertical-lift-open-loop", duration=0.6)


@pytest.fixture(scope="module")
def crane():
    return hc.load_machine("rottne-f9-lab")


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def test_eight_charts_of_a_cylinder_in_degrees_bar_and_millimetres(run):
    figure = run.plot("lift")
    assert len(panels(figure)) == 8
    expected = {
        ("joint boom", "angle [deg]"): [np.degrees(run.data["joint.boom.q"])],
        ("rate of joint boom", "angular velocity [deg/s]"): [np.degrees(run.data["joint.boom.qd"])],
        ("piston position", "position [mm]"): [1e3 * run.data["cylinder.lift.x"]],
        ("piston velocity", "velocity [mm/s]"): [1e3 * run.data["cylinder.lift.v"]],
        ("spool; command thin", "position [mm]"): [1e3 * run.data[f"cylinder.lift.{s}"] for s in ("xs", "command")],
        ("net force on the rod; friction thin", "force [kN]"): [
            1e-3 * run.data[f"cylinder.lift.{s}"] for s in ("force", "friction")
        ],
    }
    by_name = {(axes.get_title(loc="left"), axes.get_ylabel()): axes for axes in panels(figure)}
    for name, curves in expected.items():
        for line, values in zip(by_name[name].lines, curves, strict=False):
            np.testing.assert_allclose(line.get_ydata(), values, rtol=1e-12, err_msg=name)
    bars = [axes.lines[0].get_ydata() for axes in panels(figure) if axes.get_ylabel() == "pressure [bar]"]
    np.testing.assert_allclose(bars, [1e-5 * run.data[f"cylinder.lift.p{s}"] for s in (1, 2)], rtol=1e-12)


def test_all_cylinders_side_by_side(run, tmp_path):
    figure = run.plot(path=tmp_path / "new" / "all.png")
    assert len(panels(figure)) == 24
    with Image.open(tmp_path / "new" / "all.png") as picture:
        assert picture.size[0] > 1000


def boxes_apart(figure):
    """Each chart with its numbers and labels lies inside the picture, below its headline and over no other."""
    renderer = figure.canvas.get_renderer()
    boxes = [axes.get_tightbbox(renderer, for_layout_only=True) for axes in figure.axes]
    top = min([figure.bbox.y1, *(text.get_window_extent(renderer).y0 for text in figure.texts)])
    for i, box in enumerate(boxes):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= figure.bbox.x1 and box.y1 <= top, (i, box)
        assert not any(box.overlaps(other) for other in boxes[:i])


def test_a_plain_grid_is_laid_out_in_one_pass_as_constrained_layout_does(run):
    for made in (run.plot("lift"), run.plot(), hc.simulate("single-cylinder-step", duration=0.3).plot()):
        assert arrange(made)
        boxes_apart(made)
        placed = np.array([axes.get_position().bounds for axes in made.axes])
        made.get_layout_engine().execute(made)
        theirs = np.array([axes.get_position().bounds for axes in made.axes])
        np.testing.assert_allclose(placed * np.tile(made.bbox.size, 2), theirs * np.tile(made.bbox.size, 2), atol=5.0)


@mpl.rc_context(RC)
def test_wide_numbers_and_many_columns_stay_apart():
    made, axes = figure(21.0, 11.5, nrows=6, ncols=5, sharex=True)
    spans = ((-1000, 0), (0.0021, 0.0024), (-123456.5, -123456.0), (0, 1), (99990, 100010))
    for row in axes:
        for panel, span in zip(row, spans, strict=True):
            panel.plot([0, 100000], span)
            panel.set_title("a cylinder with a very long name: piston velocity", y=1.0)
            panel.set_ylabel("[l/min]")
            panel.margins(x=0)
    axes[-1, 0].set_xlabel("time [s]")
    title(made, "Cylinders", "five of them")
    assert arrange(made)
    boxes_apart(made)


def test_what_is_no_plain_grid_keeps_constrained_layout(run):
    for add in (
        lambda made: made.legend(made.axes[0].lines, ["line"], loc="outside lower center"),
        lambda made: made.axes[0].legend(made.axes[0].lines, ["line"]),
        lambda made: made.axes[0].annotate("note", (0.0, 1.3), xycoords="axes fraction"),
        lambda made: made.axes[2].plot(1e9 * made.axes[2].lines[0].get_ydata()),
        lambda made: made.axes[0].set_aspect("equal"),
        lambda made: made.supxlabel("below"),
        lambda made: made.set_layout_engine("tight"),
    ):
        made = run.plot("lift")
        add(made)
        assert not arrange(made)


def test_a_written_figure_is_laid_out_anew_when_it_changes(run, tmp_path):
    made = run.plot("lift", path=tmp_path / "lift.png")
    before = made.axes[0].get_position().y0
    made.legend(made.axes[0].lines, ["line"], loc="outside lower center")
    made.canvas.draw()
    assert made.axes[0].get_position().y0 > before + 0.005


def test_unknown_cylinder_and_suffix(run, tmp_path):
    with pytest.raises(hc.InputError, match="did you mean `lift`"):
        run.plot("lif")
    with pytest.raises(hc.ResultFileError, match=r"choose a suffix"):
        run.plot("lift", path=tmp_path / "a.docx")


def test_plotting_leaves_other_peoples_settings_alone(run):
    before = dict(mpl.rcParams)
    run.plot("lift")
    assert dict(mpl.rcParams) == before


def test_film_has_its_pictures_and_moves(run, tmp_path):
    path = run.animate(tmp_path / "film.gif", fps=10)
    with Image.open(path) as film:
        # 0.6 s at 10 per second is 7 pictures; the held last ones repeat and may be merged into one.
        assert film.n_frames >= 7
        assert film.info["duration"] == 100
        first = np.asarray(film.convert("L"), dtype=float)
        film.seek(6)
        assert np.abs(np.asarray(film.convert("L"), dtype=float) - first).max() > 100


def test_film_speed(run, tmp_path):
    path = run.animate(tmp_path / "fast.gif", fps=10, speed=3.0)
    with Image.open(path) as film:
        assert film.n_frames < 7


def test_film_suffixes(run, tmp_path, monkeypatch):
    with pytest.raises(hc.ResultFileError, match=r"\.gif, \.mp4"):
        run.animate(tmp_path / "film.avi")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(hc.ResultFileError, match="ffmpeg"):
        run.animate(tmp_path / "film.mp4")


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is an optional tool")
def test_film_as_mp4(run, tmp_path):
    assert run.animate(tmp_path / "film.mp4", fps=10).stat().st_size > 1000


@pytest.mark.parametrize("name", hc.bundled_machines())
def test_every_machine_can_be_drawn(name, tmp_path):
    crane = hc.load_machine(name)
    in_plane = () if "y" in crane.tip_axes else (plots.workspace,)
    for make in (*in_plane, plots.joint_stroke, plots.flow_law):
        figure = make(crane)
        figure.savefig(tmp_path / f"{make.__name__}.png")
        assert panels(figure)


def test_a_workspace_hatches_the_regions_and_keeps_its_limits(crane):
    bare = hc.load_machine("rottne-f9-lab", {f"keep-out.{name}.status": "inactive" for name in crane.keep_out})
    with_regions, without = (panels(plots.workspace(machine))[0] for machine in (crane, bare))
    drawn = [artist.get_xy()[:-1] for artist in with_regions.patches]
    for corners, outline in zip(drawn, crane.keep_out.values(), strict=True):
        np.testing.assert_allclose(corners, outline)
    assert with_regions.dataLim.bounds == without.dataLim.bounds and not without.patches


def test_joint_stroke_curve_is_the_linkage(crane):
    axes = panels(plots.joint_stroke(crane, "boom"))[0]
    angle, stroke = axes.lines[0].get_data()
    inside = (angle > 60) & (angle < 120)
    q = np.tile(crane.home, (inside.sum(), 1))
    q[:, 0] = np.radians(angle[inside])
    np.testing.assert_allclose(stroke[inside], 1e3 * crane.strokes(q)[:, 0], atol=1e-9)


def test_friction_maps_build_up(crane):
    first = [axes.lines[0].get_ydata() for axes in panels(plots.friction_maps(crane, "extension"))]
    coulomb, viscous, _, stribeck = first[:4]
    assert np.ptp(np.abs(coulomb[:500])) < 1e-6 * np.abs(coulomb[0])
    assert abs(viscous[0]) > abs(coulomb[0])
    assert np.abs(stribeck).max() > np.abs(coulomb).max()
    np.testing.assert_allclose(stribeck[[0, -1]], viscous[[0, -1]], rtol=1e-3)


def test_load_chart_and_mode_map(crane):
    assert len(panels(plots.load_chart(crane, hc.load_chart(crane, samples=8)))) == 2
    assert len(panels(plots.mode_map(crane, hc.mode_map(crane, samples=4)))) == 2


def test_runs_lie_over_each_other_in_the_units_of_pictures(run):
    other = hc.simulate("vertical-lift-open-loop", duration=0.6, record_interval=0.02, payload=50)
    figure = plots.overlay({"empty": run, "loaded": other}, ["tip.z", "cylinder.lift.p1"], span=(0.1, 0.5))
    heights, pressures = panels(figure)
    assert [line.get_label() for line in heights.lines] == ["empty", "loaded"]
    inside = other.data.sel(time=slice(0.1, 0.5))
    np.testing.assert_allclose(pressures.lines[1].get_ydata(), 1e-5 * inside["cylinder.lift.p1"], rtol=1e-12)
    np.testing.assert_allclose(pressures.lines[1].get_xdata(), inside.time, rtol=1e-12)


def test_a_run_less_another_at_equal_times(run):
    other = hc.simulate("vertical-lift-open-loop", duration=0.6, record_interval=0.02, payload=50)
    figure = plots.overlay({"empty": run, "loaded": other}, "tip.z", relative_to="empty", against="cylinder.lift.x")
    (line,) = panels(figure)[0].lines
    same = run.data["tip.z"].interp(time=other.data.time.values)
    np.testing.assert_allclose(line.get_ydata(), 1e3 * (other.data["tip.z"].values - same.values), atol=1e-9)
    np.testing.assert_allclose(line.get_xdata(), 1e3 * other.data["cylinder.lift.x"], rtol=1e-12)


def test_runs_that_cannot_be_laid_over_each_other(run):
    for call, message in (
        (lambda: plots.overlay({}, "tip.z"), "no run to draw"),
        (lambda: plots.overlay([run], "tip.z"), "mapping from label to run"),
        (lambda: plots.overlay({"a": run}, "tip.y"), "signal of run `a`"),
        (lambda: plots.overlay({"a": run}, "tip.z", relative_to="b"), "`b`"),
        (lambda: plots.overlay({"a": run}, "tip.z", relative_to="a"), "no run to draw"),
        (lambda: plots.overlay({"a": run}, []), "name a signal"),
        (lambda: plots.overlay({"a": run}, "tip.z", span=(2.0, 3.0)), "between 2 and 3 s"),
    ):
        with pytest.raises(hc.InputError, match=message):
            call()


def test_parameters_rank_by_their_effect():
    keys = ["supply.pressure", "friction.test.coulomb[0]", "friction.test.coulomb[1]"]
    slopes = hc.sensitivities("single-cylinder-step", keys, relative=True, duration=1.0)
    figure = plots.ranking(slopes, "joint.slide.q", most=2)
    (axes,) = panels(figure)
    sizes = np.sqrt((slopes.data["joint.slide.q"] ** 2).mean("time")).values
    best = np.argsort(-sizes)[:2]
    assert [label.get_text() for label in axes.get_yticklabels()] == [keys[i] for i in best]
    np.testing.assert_allclose([bar.get_width() for bar in axes.patches], 1e3 * sizes[best], rtol=1e-12)
    for signals, message in ((["joint.slide.q", "cylinder.test.p1"], "different units"), ("tip", "`tip`")):
        with pytest.raises(hc.InputError, match=message):
            plots.ranking(slopes, signals)
    with pytest.raises(hc.InputError, match="relative=True"):
        plots.ranking(hc.sensitivities("single-cylinder-step", keys[0], duration=0.1), "joint.slide.q")
