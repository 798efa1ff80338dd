"""What a file may ask for is bounded, and every refusal is one short message."""

from __future__ import annotations

import pickle

import pytest

import hydrocrane as hc
from hydrocrane.errors import LONGEST_MESSAGE, InputError, MachineFileError

STUDY = """
[study]
scenario = "single-cylinder-step"
{study}

[keys]
"payload.mass" = {masses}
"supply.pressure" = {pressures}
"""
RANGE = '{ low = "100 bar", high = "140 bar"'
DEEP = 20_000


@pytest.fixture
def study(tmp_path):
    def cases(about='method = "grid"', masses="[0.0, 1.0]", pressures=f"{RANGE}, count = 2 }}"):
        path = tmp_path / "study.toml"
        path.write_text(STUDY.format(study=about, masses=masses, pressures=pressures), encoding="utf-8")
        return hc.load_study(path).study.cases

    return cases


@pytest.mark.parametrize(
    "given",
    [
        {"pressures": f"{RANGE}, count = 18446744073709551616 }}"},
        {"pressures": f"{RANGE}, count = 6_000_000 }}"},
        {"about": 'method = "latin"\nn = 18446744073709551616', "masses": "{ low = 0.0, high = 1.0 }",
         "pressures": RANGE + " }"},
    ],
)  # fmt: skip
def test_a_study_of_too_many_cases_is_refused_before_any_is_made(study, given):
    with pytest.raises(InputError, match="at most 1e.07 are possible; (draw|give) fewer"):
        study(**given)
    assert study().count == 4


@pytest.mark.parametrize("value", ["[" * DEEP, "{" + "a." * DEEP + "a = 1}", "[" * 200 + "]" * 200, "9" * 5000])
def test_deep_nesting_and_endless_numbers_are_refused(study, tmp_path, value):
    with pytest.raises(InputError, match="study.toml is (nested deeper than|not valid TOML)"):
        study(masses=value)
    mapping = tmp_path / "mapping.toml"
    mapping.write_text(f"[signal.p1]\nunit = {value}\n", encoding="utf-8")
    log = tmp_path / "log.csv"
    log.write_text("time,p1\n" + "".join(f"{i},{i}\n" for i in range(20)), encoding="utf-8")
    with pytest.raises(InputError, match="mapping.toml is (nested deeper than|not valid TOML)"):
        hc.read_log(log, mapping)


@pytest.mark.parametrize("name", ["long " * 60_000, "a\\u0000b"])
def test_a_name_that_no_path_can_have_is_an_unknown_scenario(tmp_path, name):
    path = tmp_path / "study.toml"
    path.write_text(f'[study]\nscenario = "{name}"\n\n[keys]\n"payload.mass" = [0.0, 1.0]\n', encoding="utf-8")
    with pytest.raises(hc.errors.HydrocraneError, match="bundled: |scenario"):
        assert hc.load_study(path).study.cases


def test_messages_stay_short_and_keep_both_ends(study):
    with pytest.raises(InputError) as caught:
        study(masses='"' + "long " * 60_000 + '"')
    text = str(caught.value)
    assert len(text) < LONGEST_MESSAGE + 100
    assert text.startswith("`payload.mass` needs") and "letters left out" in text


def test_an_error_of_a_file_is_copied_whole():
    error = MachineFileError("no", slug="syntax", line=3)
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.slug, again.line) == ("no", "syntax", 3)


@pytest.mark.parametrize("unit", ["5e-324 bar", "0 bar", "1e300 bar"])
def test_a_unit_in_which_numbers_are_lost_is_refused(tmp_path, unit):
    log = tmp_path / "log.csv"
    log.write_text("time,p1\n" + "".join(f"{i},{i}\n" for i in range(20)), encoding="utf-8")
    with pytest.raises(InputError, match=r"unit: one `.* bar` is .* in SI; give a unit of 1e-30 to 1e\+30 in SI"):
        hc.read_log(log, {"signal": {"p1": {"column": "p1", "unit": unit}}})


def test_a_unit_of_a_header_that_is_nothing_in_si_is_no_crash(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time,a [um^53]\n" + "".join(f"{i},{i}\n" for i in range(20)), encoding="utf-8")
    with pytest.raises(InputError, match=r"column `a \[um\^53\]` unit: one `um\^53` is"):
        hc.read_log(log)


def test_a_log_of_very_many_columns_is_refused_and_of_many_is_read(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(",".join("1" * 50_000) + "\n", encoding="utf-8")
    with pytest.raises(hc.ResultFileError, match="has 50000 columns, more than 2000; keep"):
        hc.read_log(path)
    names = [f"s{i}" for i in range(600)]
    path.write_text("time," + ",".join(names) + "\n" + "".join(f"{i}" + ",1" * 600 + "\n" for i in range(9)))
    assert list(hc.read_log(path).data.data_vars) == names


@pytest.mark.parametrize("value", ["[" * DEEP, "9" * 5000])
def test_a_comment_that_cannot_be_read_is_passed_over(tmp_path, value):
    path = tmp_path / "log.csv"
    path.write_text(f"# a = {value}\n# payload = 20\ntime,p1\n" + "".join(f"{i},{i}\n" for i in range(20)))
    assert hc.read_log(path).data.attrs["payload"] == 20


def test_an_override_beyond_every_double_is_refused():
    with pytest.raises(InputError, match="override `payload.mass` is a whole number beyond 1.8e308; give a smaller"):
        hc.load_machine("single-cylinder", {"payload.mass": 10**400})
