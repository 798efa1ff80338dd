"""The circuit diagram shows what the machine file says, and can be read: no text lies over another one or a line."""

from importlib import import_module

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from command_line import run
from matplotlib.backends.backend_agg import FigureCanvasAgg

import hydrocrane as hc
from hydrocrane import plots
from hydrocrane.machine import circuit as circuits
from hydrocrane.plots.circuit_parts import ON_LINE

mpl.use("Agg")
EXCAVATOR = "sany-sy19e"
diagram = import_module("hydrocrane.plots.circuit").diagram

HELD = {
    f"counterbalance.{name}.{key}": value
    for name, cylinder, side in (("up", "lift", "rod-side"), ("in", "jib", "rod-side"), ("out", "jib", "piston-side"))
    for key, value in {
        "cylinder": cylinder, "side": side, "setting": "180 bar", "pilot-ratio": 4.5, "nominal-flow": "40 l/min",
        "nominal-pressure-drop": "10 bar",
    }.items()
}  # fmt: skip


def part(kind, name, cylinder, side, **keys):
    keys = {"cylinder": cylinder, "side": side, "nominal-flow": "60 l/min"} | keys
    return {f"{kind}.{name}.{key.replace('_', '-')}": value for key, value in keys.items()}


def lines_with_everything():
    drop = {"nominal_pressure_drop": "5 bar"}
    return {
        **part("line", "boom", "lift", "piston-side", length="6 m", inner_diameter="12 mm", compliance="0.08 ml/bar"),
        **part("line", "tip", "extension", "piston-side", volume="0.3 l", nominal_pressure_drop="7 bar"),
        **part("port-relief", "boom", "lift", "piston-side", setting="220 bar", overpressure="15 bar"),
        **part("port-relief", "down", "lift", "rod-side", setting="230 bar"),
        **part("anti-cavitation", "boom", "lift", "piston-side", **drop),
        **part("anti-cavitation", "down", "lift", "rod-side", opening_pressure="0.3 bar", **drop),
        **part("crossover-relief", "tip", "extension", "piston-side", setting="160 bar"),
        **part("crossover-relief", "back", "extension", "rod-side", setting="170 bar", overpressure="12 bar"),
        **part("pilot-check", "jib", "jib", "rod-side", pilot_ratio=4.0, **drop),
        **part("hose-burst", "jib", "jib", "piston-side", closing_flow="66 l/min", bleed=0.01, **drop),
        "hose-leak.tip.cylinder": "extension", "hose-leak.tip.side": "rod-side", "hose-leak.tip.opening": "3 mm^2",
        "accumulator.main.volume": "0.5 l", "accumulator.main.precharge": "90 bar",
    }  # fmt: skip


TANK_LINE = {
    "tank-line.volume": "3 l", "tank-line.nominal-flow": "60 l/min", "tank-line.nominal-pressure-drop": "2 bar",
    "tank-line.filter.nominal-flow": "90 l/min", "tank-line.filter.nominal-pressure-drop": "0.6 bar",
    "tank-line.filter.bypass-pressure": "1.7 bar", "tank-line.filter.bypass-overpressure": "0.4 bar",
    **part("anti-cavitation", "boom", "lift", "piston-side", nominal_pressure_drop="5 bar"),
}  # fmt: skip
SHARING = {"pump.main.type": "load-sensing", "pump.main.ls-margin": "17 bar", "pump.main.torque-limit": "31 N m"} | {
    f"valve.{valve}.compensator": "behind-spool" for valve in ("lift", "jib")
}
SECOND = {
    f"pump.aside.{key}": value
    for key, value in {
        "type": "load-sensing", "displacement": "9 ml", "speed": "1450 rpm", "volumetric-efficiency": 0.9,
        "hydromechanical-efficiency": 0.9, "control-range": "6 bar", "ls-margin": "20 bar", "ls-time-constant": "20 ms",
    }.items()
}  # fmt: skip
MACHINES = {
    **{name: (name, {}) for name in hc.bundled_machines()},
    "every line held": ("rottne-f9-mobile", HELD),
    "flow sharing": ("rottne-f9-pump", SHARING),
    "all parts": ("rottne-f9-ls", lines_with_everything()),
    "tank line": ("rottne-f9-ls", TANK_LINE),
    "served first": ("rottne-f9-mobile", {"priority.cylinder": "jib", "priority.margin": "9 bar"}),
    "two pumps": ("rottne-f9-mobile", SECOND),
    "measured": ("hiab-xs031", {"supply.measured": "yes"}),
    "motor": (EXCAVATOR, {}),
}


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module", params=MACHINES)
def machine(request):
    name, overrides = MACHINES[request.param]
    return hc.load_machine(name, overrides)


@pytest.fixture(scope="module")
def drawn(machine):
    """The figure; closed after the first test, it has no canvas, but all that is on it."""
    return plots.circuit(machine)


@pytest.fixture(scope="module")
def sheet(machine):
    return diagram(machine)


def texts(crane):
    return [label.text for label in diagram(crane).labels]


def crosses(box, start, end):
    """Whether a straight line runs through a box (Liang and Barsky)."""
    first, last = 0.0, 1.0
    for axis in (0, 1):
        way = end[axis] - start[axis]
        bounds = [box[axis] - start[axis], box[axis + 2] - start[axis]]
        if way == 0.0:
            if bounds[0] > 0.0 or bounds[1] < 0.0:
                return False
            continue
        enter, leave = sorted(bound / way for bound in bounds)
        first, last = max(first, enter), min(last, leave)
    return first < last


def test_no_text_lies_over_another_or_outside(drawn):
    renderer = FigureCanvasAgg(drawn).get_renderer()
    boxes = {text: text.get_window_extent(renderer) for text in drawn.axes[0].texts}
    assert len(boxes) > 8
    for text, box in boxes.items():
        assert box.x0 > 0 and box.y0 > 0 and box.x1 < drawn.bbox.x1 and box.y1 < drawn.bbox.y1, text.get_text()
        over = [other.get_text() for other in boxes if other is not text and box.overlaps(boxes[other])]
        assert not over, (text.get_text(), over)


def test_no_line_runs_through_a_text(sheet):
    lines = []
    for stroke in sheet.strokes:
        ends = (*stroke.points[1:], stroke.points[0]) if stroke.fill else stroke.points[1:]
        lines += zip(stroke.points, ends)
    low, high = np.min(lines, axis=1), np.max(lines, axis=1)
    for label in sheet.labels:
        if label.text == "M":
            continue
        box = np.array(label.box)
        # What lies on one side of the box crosses it nowhere.
        near = (low <= box[2:]).all(axis=1) & (high >= box[:2]).all(axis=1)
        through = [lines[i] for i in np.flatnonzero(near) if crosses(label.box, *lines[i])]
        assert not through, (label.text, through)


def test_the_boxes_of_texts_are_those_that_are_drawn(drawn, sheet):
    """What is reckoned with the font's metrics, so that the layout is the same everywhere, is what appears."""
    renderer, millimetre = FigureCanvasAgg(drawn).get_renderer(), drawn.dpi / 25.4
    for label, text in zip(sheet.labels, drawn.axes[0].texts, strict=True):
        assert text.get_text() == label.text
        width = text.get_window_extent(renderer).width / millimetre
        # Pixels and hinting round the letters.
        assert width == pytest.approx(label.box[2] - label.box[0], rel=0.1, abs=0.3), label.text


@pytest.mark.parametrize("name", hc.bundled_machines())
def test_at_1400_pixels_a_line_of_text_has_ten(name):
    sheet = diagram(hc.load_machine(name))
    left, _, right, _ = sheet.extent
    assert min(label.size for label in sheet.labels if "bar" in label.text) * 1400 / (right - left + 12) > 10


def test_the_values_of_a_load_sensing_machine_stand_beside_its_symbols():
    shown = texts(hc.load_machine("rottne-f9-mobile"))
    for text in (
        "load-sensing", "18 cm³ per turn", "26.1 l/min without leakage", "1450 rpm", "load + 20 bar", "at most 180 bar",
        "210 bar", "counterbalance lift", "155 bar", "pilot ratio 3", "40 l/min at 10 bar", "12 l/min at 16 bar",
        "6 l/min at 16 bar", "mains, 400 cm³", "Ø 100/40 mm, stroke 301.5 mm", "0 bar",
    ):  # fmt: skip
        assert text in shown, text
    assert shown.count("compensator") == shown.count("8 bar") == 3


def test_a_mistake_in_the_file_is_seen():
    right = hc.load_machine("rottne-f9-mobile")
    wrong = right.changed({"counterbalance.lift.setting": "12 bar", "counterbalance.lift.side": "rod-side"})
    left = {label.text: label.x for label in diagram(right).labels}
    there = {label.text: label.x for label in diagram(wrong).labels}
    assert "12 bar" in there and "155 bar" not in there
    assert left["counterbalance lift"] < left["lift"] and there["counterbalance lift"] > there["lift"]


def test_each_kind_of_supply_and_compensator_is_named():
    kinds = {name: texts(hc.load_machine(*MACHINES[name])) for name in MACHINES}
    assert "constant pressure" in kinds["rottne-f9-lab"] and "control" not in kinds["rottne-f9-lab"]
    assert "measured pressure" in kinds["measured"]
    assert kinds["flow sharing"].count("flow sharing") == kinds["flow sharing"].count("metering edge") == 2
    assert {"at most 31 N m", "load + 17 bar"} <= set(kinds["flow sharing"])


def test_what_stands_on_lines_is_drawn_with_its_values():
    crane = hc.load_machine(*MACHINES["all parts"])
    assert circuits.read(crane).left_out == ()
    shown = texts(crane)
    for text in (
        "line boom", "6 m × Ø 12 mm", "0.08 cm³/bar", "walls at 60 l/min", "300 cm³", "60 l/min at 7 bar",
        "cross-over relief tip", "160 bar", "60 l/min at + 12 bar",
        "port relief boom", "220 bar", "60 l/min at + 15 bar", "anti-cavitation down", "60 l/min at 5 bar",
        "opens at 0.3 bar", "pilot check jib", "pilot ratio 4", "hose burst jib", "closes above 66 l/min",
        "bleed 1 %", "hose leak tip", "3 mm²", "accumulator main", "500 cm³", "precharge 90 bar",
    ):  # fmt: skip
        assert text in shown, text
    there = {label.text: label.x for label in diagram(crane).labels}
    assert there["port relief boom"] < there["lift"] < there["port relief down"]


def test_the_tank_line_is_drawn_with_its_filter_and_takes_the_oil_of_the_relief_valve():
    crane = hc.load_machine(*MACHINES["tank line"])
    assert circuits.read(crane).left_out == ()
    shown = texts(crane)
    for text in (
        "tank line, 3000 cm³", "60 l/min at 2 bar", "port valves join it", "return filter", "90 l/min at 0.6 bar",
        "bypass opens at 1.7 bar",
    ):  # fmt: skip
        assert text in shown, text
    bare = hc.load_machine("rottne-f9-ls")
    assert not {"return filter", "port valves join it"} & set(texts(bare))
    with_line, without = (sum(stroke.kind == "tank" for stroke in diagram(one).strokes) for one in (crane, bare))
    assert with_line == without + 1


def test_the_sections_that_give_way_are_told_from_the_one_served_first():
    crane = hc.load_machine(*MACHINES["served first"])
    assert circuits.read(crane).left_out == ()
    shown = texts(crane)
    assert shown.count("gives way") == shown.count("below load + 9 bar") == 2
    assert shown.count("served first") == 1 and "served first" not in texts(hc.load_machine("rottne-f9-mobile"))


def test_each_pump_is_drawn():
    crane = hc.load_machine(*MACHINES["two pumps"])
    assert circuits.read(crane).left_out == ()
    shown = texts(crane)
    assert {"pump main", "pump aside", "18 cm³ per turn", "9 cm³ per turn"} <= set(shown)
    assert shown.count("load-sensing") == shown.count("load + 20 bar") == 2 and shown.count("relief valve") == 1


def test_a_fixed_pump_is_unloaded_and_a_relief_pressure_by_default_is_shown(tmp_path):
    run("new", tmp_path / "crane", "--machine", "rottne-f9-lab", "--pump", "fixed")
    fixed = hc.load_machine(tmp_path / "crane" / "machine.toml")
    assert {"relief valve", "140 bar", "fixed"} <= set(texts(fixed)) and "control" not in texts(fixed)
    unloaded = texts(fixed.changed({"pump.main.ls-margin": "15 bar"}))
    assert {"unloading valve", "load + 15 bar", "at most 140 bar"} <= set(unloaded) and "relief valve" not in unloaded


def test_only_a_pump_that_senses_the_load_has_a_line_for_it():
    kinds = {name: {stroke.kind for stroke in diagram(hc.load_machine(*MACHINES[name])).strokes} for name in MACHINES}
    assert {name for name, found in kinds.items() if "load" in found} == {
        "rottne-f9-mobile", "rottne-f9-ls", "every line held", "flow sharing", "all parts", "tank line",
        "served first", "two pumps",
    }  # fmt: skip


def test_every_part_that_can_stand_on_a_line_has_a_symbol():
    assert set(circuits.ON_LINES) == set(ON_LINE)


def test_what_the_diagram_does_not_know_is_named(monkeypatch):
    """A part of the machine is never left out without a word."""
    for name in hc.bundled_machines():
        assert circuits.read(hc.load_machine(name)).left_out == ()
    monkeypatch.setattr(circuits, "READ", circuits.READ - {"counterbalance", "mains"})
    assert any("not drawn: counterbalance, mains" in text for text in texts(hc.load_machine("rottne-f9-mobile")))


def test_the_same_machine_makes_the_same_file(tmp_path):
    for suffix in ("svg", "pdf"):
        paths = [tmp_path / f"{i}.{suffix}" for i in range(2)]
        for path in paths:
            done = run("circuit", "rottne-f9-mobile", "-o", path)
            assert done.returncode == 0 and str(path) in done.stdout.replace("\n", "")
        assert paths[0].read_bytes() == paths[1].read_bytes()


def test_the_command_takes_overrides_and_refuses_what_is_no_machine(tmp_path):
    assert run("circuit", "single-cylinder", "--set", "supply.pressure='99 bar'", folder=tmp_path).returncode == 0
    assert (tmp_path / "single-cylinder-circuit.svg").read_text(encoding="utf-8").startswith("<?xml")
    for arguments in (["vertical-lift-open-loop"], ["single-cylinder", "-o", "circuit.doc"], ["no-such-machine"]):
        done = run("circuit", *arguments, folder=tmp_path)
        assert done.returncode == 2 and done.stderr.count("error:") == 1


def test_a_motor_stands_in_the_place_of_the_piston():
    shown = texts(hc.load_machine(EXCAVATOR))
    assert "motor 23.6 cm³ per turn, gear 134 : 1" in shown
    assert sum(text.startswith("Ø 5") for text in shown) == 2 and sum("mm, stroke" in text for text in shown) == 3
