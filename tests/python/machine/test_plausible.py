"""Values that are possible and unlikely: a warning; the command line asks for units."""

import pytest
from command_line import run as command

import hydrocrane as hc


def test_bundled_machines_are_plausible():
    assert not any(hc.load_machine(name).warnings for name in hc.bundled_machines())


def test_a_bore_in_metres_is_warned_of_with_its_place(tmp_path):
    path = tmp_path / "crane.toml"
    path.write_text('extends = "single-cylinder"\n[machine]\nclass = "assumed"\n[cylinder.test]\nbore = "63 m"\n')
    (warning,) = hc.load_machine(path).warnings
    assert (warning.kind, warning.time) == ("implausible-value", 0.0)
    assert "crane.toml:5:8: cylinder.test.bore is 63 m; usual is 10 mm to 600 mm" in warning.text
    assert warning.cure == 'did you mean "63 mm"?'
    shown = " ".join(command("check", str(path)).stdout.split())
    assert 'did you mean "63 mm"?' in shown and "no errors, 1 warning" in shown


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("supply.pressure=100", ["missing-unit", '"100 bar"']),
        ("friction.lift.coulomb=[100, 200]", ["missing-unit", '"100 N"']),
        ("link.extension.point.tip=[1, 2]", ["point"]),
        ("control.period=1e-9 s", ["control.period"]),
    ],
)
def test_a_bare_number_on_the_command_line_is_refused(setting, words):
    done = command("check", "rottne-f9-lab", "--set", setting)
    assert done.returncode == 2 and done.stderr.count("error:") == 1
    assert all(word in " ".join(done.stderr.split()) for word in words), done.stderr


@pytest.mark.evidence
def test_plain_numbers_and_units_are_taken():
    for setting in (
        "valve.lift.damping-ratio=0.5",
        "supply.pressure=100 bar",
        'friction.lift.coulomb=["100 N", "200 N"]',
    ):
        assert command("check", "rottne-f9-lab", "--set", setting).returncode == 0
    assert hc.load_machine("rottne-f9-lab", {"supply.pressure": 1e7}).supply_pressure == 1e7


@pytest.mark.evidence
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("simulate", "rottne-f9-lab"), ["is a machine", "hydrocrane machines"]),
        (("modes", "vertical-lift-open-loop"), ["is a scenario", "its machine is"]),
        (("simulate", "tests/data/two-telescopes.toml"), ["is a machine", "hydrocrane machines"]),
        (("modes", "scenarios/vertical-lift-open-loop.toml"), ["is a scenario", "its machine is"]),
        (("simulate", "vertical-lift-open-loop", "--duration", "9e4"), ["GB", "shorter duration"]),
    ],
)
def test_one_message_says_what_was_mistaken(arguments, words):
    done = command(*arguments)
    assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
    assert all(word in " ".join(done.stderr.split()) for word in words), done.stderr
