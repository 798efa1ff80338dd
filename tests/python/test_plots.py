"""Pictures hold what they should, in the units people read; films are films."""

import shutil

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

import hydrocrane as hc
from hydrocrane import plots

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


def test_six_charts_of_a_cylinder_in_degrees_bar_and_millimetres(run):
    figure = run.plot("lift")
    assert len(panels(figure)) == 6
    expected = {
        "[deg]": np.degrees(run.data["joint.boom.q"]),
        "[deg/s]": np.degrees(run.data["joint.boom.qd"]),
        "[mm]": 1e3 * run.data["cylinder.lift.x"],
        "[mm/s]": 1e3 * run.data["cylinder.lift.v"],
    }
    by_unit = {axes.get_ylabel(): axes for axes in panels(figure)}
    for unit, values in expected.items():
        np.testing.assert_allclose(by_unit[unit].lines[0].get_ydata(), values, rtol=1e-12, err_msg=unit)
    bars = [axes.lines[0].get_ydata() for axes in panels(figure) if axes.get_ylabel() == "[bar]"]
    np.testing.assert_allclose(bars, [1e-5 * run.data[f"cylinder.lift.p{s}"] for s in (1, 2)], rtol=1e-12)


def test_all_cylinders_side_by_side(run, tmp_path):
    figure = run.plot(path=tmp_path / "new" / "all.png")
    assert len(panels(figure)) == 18
    with Image.open(tmp_path / "new" / "all.png") as picture:
        assert picture.size[0] > 1000


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
    for make in (plots.workspace, plots.joint_stroke, plots.flow_law):
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
