"""A log means the same through `hc.Log` and as the log of a scenario file, or is refused alike: units and clocks."""

from __future__ import annotations

import re

import numpy as np
import pytest

import hydrocrane as hc

HEAD = (
    '[scenario]\nname = "s"\nmachine = "rottne-f9-lab"\nduration = "0.1 s"\n[initial.joint]\nboom = "1.7 rad"\n'
    'jib = "1.7 rad"\nextension = "0 m"\n[supply]\nlog = "log.csv"\ncolumn = "p1"\n'
)


def through_both(folder, content, keys="", mapping=None):
    """Times and pressures of a text, or the refusal, as a log and as the supply of a scenario."""
    (folder / "log.csv").write_text(content, encoding="utf-8")
    (folder / "s.toml").write_text(HEAD + keys, encoding="utf-8")

    def log():
        read = hc.read_log(folder / "log.csv", {"signal": {"p1": {}}, **(mapping or {})})
        if fatal := [flag.message for flag in read.fatal if flag.kind == "unknown-unit"]:
            raise hc.InputError(fatal[0])
        return read.time, read["p1"]

    def scenario():
        supply = hc.load_scenario(folder / "s.toml").supply
        return supply.time, supply.pressure

    found = []
    for door in (log, scenario):
        try:
            found.append(np.array(door()))
        except hc.HydrocraneError as error:
            found.append(str(error).split("\n")[0])
    return found


# One of each in Pa; None: refused.
PRESSURES = {
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "mbar": 1e2,
    "bar": 1e5,
    "Bar": 1e5,
    "BAR": 1e5,
    "bars": 1e5,
    "kilopascals": 1e3,
    "Pascal": 1.0,
    "barg": 1e5,
    "bar(g)": 1e5,
    "bar g": 1e5,
    "bara": 1e5,
    "bar(a)": 1e5,
    "bar_abs": 1e5,
    "kPa (absolute)": 1e3,
    "psi": 6894.757293168,
    "PSI": 6894.757293168,
    "psig": 6894.757293168,
    "PSIA": 6894.757293168,
    "lbf/in^2": 6894.757293168,
    "lbs/in²": 6894.757293168,
    "N/mm^2": 1e6,
    "kp/cm²": 98066.5,
    "0.1 bar": 1e4,
    "25 bar": 25e5,
    "-": 1.0,
    "": 1.0,
    "mm": None,
    "kg": None,
    "degC": None,
    "1": None,
    "%": None,
    "1/s": None,
    "mA": None,
    "V": None,
    "counts": None,
    "1e-40 bar": None,
    "barr": None,
    "furlong": None,
    "bar/mm s": None,
}


@pytest.mark.parametrize("stated", ["beside", "in the name", "behind in", "in the mapping"])
@pytest.mark.parametrize(("unit", "one"), PRESSURES.items(), ids=PRESSURES)
def test_a_unit_means_the_same_or_is_refused_alike(unit, one, stated, tmp_path):
    rows = "0.0;20\n0.5;30\n"
    heads = {
        "beside": f"time;p1\ns;{unit}\n",
        "in the name": f"time [s];p1 ({unit})\n",
        "behind in": f"time in s;p1 in {unit}\n",
        "in the mapping": "time;p1\n",
    }
    by_mapping = stated == "in the mapping"
    if stated == "behind in" and (one is None or unit in ("", "-", "0.1 bar", "25 bar")):
        pytest.skip("that is no name with a unit")
    keys = f'unit = "{unit}"\n' if by_mapping and unit not in ("", "-") else ""
    mapping = {"signal": {"p1": {"unit": unit}}} if keys else None
    log, scenario = through_both(tmp_path, heads[stated] + rows, keys, mapping)
    if one is not None:
        air = 101325.0 if re.search(r"(a|A|abs|absolute)\)?$", unit) and unit not in ("Pa", "kPa", "MPa") else 0.0
        np.testing.assert_allclose(log, [[0.0, 0.5], [20 * one - air, 30 * one - air]], rtol=1e-12)
        np.testing.assert_array_equal(scenario, log)
    elif "is not known" in scenario:
        # A log is read whole, so that it flags what a scenario refuses.
        assert [re.search("unit `[^`]*` of column `p1", text)[0] for text in (log, scenario)] == [
            f"unit `{unit}` of column `p1"
        ] * 2
    else:
        assert log.split(" unit: ")[1] == scenario.split(" unit: ")[1], (log, scenario)


TIMES = {
    "s": 1.0,
    "sec": 1.0,
    "seconds": 1.0,
    "ms": 1e-3,
    "milliseconds": 1e-3,
    "us": 1e-6,
    "µs": 1e-6,
    "μs": 1e-6,
    "nanoseconds": 1e-9,
    "ns": 1e-9,
    "min": 60.0,
    "minutes": 60.0,
    "h": 3600.0,
    "hours": 3600.0,
    "d": 86400.0,
    "days": 86400.0,
    "10 ms": 1e-2,
    "seconds since 2024-05-01": 1.0,
}


@pytest.mark.parametrize(("unit", "one"), TIMES.items(), ids=TIMES)
def test_times_have_the_same_units(unit, one, tmp_path):
    log, scenario = through_both(tmp_path, f"time [{unit}],p1 [bar]\n0,20\n1,30\n3,40\n")
    np.testing.assert_allclose(log[0], [0.0, one, 3 * one], rtol=1e-12)
    np.testing.assert_array_equal(scenario, log)


# Names and two rows of cells, and the times, or what both refusals say.
CLOCKS = {
    "by name": ("p1;Zeit", ["2;0", "3;1"], [0.0, 1.0]),
    "in any case": ("p1;TIME [ms]", ["2;0", "3;1"], [0.0, 1e-3]),
    "the likelier name": ("t;time;p1", ["5;0;2", "6;2;3"], [0.0, 2.0]),
    "T at last": ("T;p1", ["0;2", "1;3"], [0.0, 1.0]),
    "T beside another": ("T;timestamp;p1", ["20;0;2", "20;1;3"], [0.0, 1.0]),
    "a temperature": ("t [degC];when;p1", ["20;10:00:00;2", "20;10:00:01;3"], [0.0, 1.0]),
    "by dates": ("p1;when", ["2;2024-05-01T12:00:00Z", "3;2024-05-01T12:00:01Z"], [0.0, 1.0]),
    "dates have no unit": ("p1;time [ms]", ["2;2024-05-01T12:00:00Z", "3;2024-05-01T12:00:01Z"], [0.0, 1.0]),
    "times of days": ("Date;Time;p1", ["1.5.2024;10:00:00;2", "3.5.2024;11:00:00;3"], [0.0, 176400.0]),
    "seconds since 1970": ("time;p1", ["1.7e9;2", "1700000001;3"], [1.7e9, 1700000001.0]),
    "two of one name": ("TIME;Time;p1", ["0;0;2", "1;1;3"], "`TIME` and `Time`; say by its full name which is `time`"),
    "two units": ("time [s];time [ms];p1", ["0;0;2", "1;1;3"], "say by its full name which is `time`"),
    "two of dates": ("a;b;p1", ["10:00:00;10:00:00;2", "10:00:01;10:00:01;3"], "by its full name which is the time"),
    "ms since 1970": ("time;p1", ["1.7e12;2", "1700000000010;3"], "cannot be in seconds, it seems to count ms"),
    "microseconds": ("time;p1", ["1.7e15;2", "1.70000001e15;3"], "it seems to count 1e-6 s"),
    "days of Excel": ("time;p1", ["45000.25;2", "45000.2500001;3"], "it seems to count d"),
    "days from zero": ("time;p1", ["0;2", "0.0000001;3"], "it seems to count d"),
    "another unit": ("when [bar];p1", ["0;2", "1;3"], "time"),
    "undecided days": ("Date;t;p1", ["1/5/2024;1:00:00;2", "3/4/2024;1:00:00;3"], "of day beside the dates in `Date`"),
}  # fmt: skip


@pytest.mark.parametrize(("names", "rows", "wanted"), CLOCKS.values(), ids=CLOCKS)
def test_the_clock_is_the_same_or_asked_alike(names, rows, wanted, tmp_path):
    log, scenario = through_both(tmp_path, "\n".join([names, *rows]) + "\n")
    if isinstance(wanted, str):
        assert wanted in log and wanted in scenario, (log, scenario)
    else:
        np.testing.assert_allclose(log, [wanted, [2.0, 3.0]], rtol=1e-12)
        np.testing.assert_array_equal(scenario, log)


def test_a_named_clock_counts_for_a_comparison():
    run = hc.simulate("single-cylinder-step", duration=0.2)
    t, z = run.columns.time, run.columns["tip.z"].values
    log = {"a": 1e3 * t, "b": t, "height": 1e3 * z}
    with pytest.raises(hc.InputError, match=r"under \[time\] of a mapping: hc.Log.of\(log, mapping\)"):
        run.compare(log, {"height": "tip.z"})
    mapping = {"time": {"column": "a", "unit": "ms"}, "signal": {"tip.z": {"column": "height", "unit": "mm"}}}
    assert run.compare(hc.Log.of(log, mapping)).rms["tip.z"] < 1e-12
