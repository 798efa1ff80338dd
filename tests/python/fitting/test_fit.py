"""Any values of a machine from logs: values come back, intervals hold, and what is wrong is said."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import hydrocrane as hc

CRANE = "rottne-f9-lab"
DURATION = 16.0
TRUTH = {"payload.mass": 130.0, "friction.lift.coulomb[0]": 400.0, "valve.lift.nominal-flow": 5.2e-3 / 60}
OVERRIDES = {"friction.lift.coulomb": [400, 700], "friction.lift.breakaway": [560, 980]}
# The file's Coulomb friction extending, all else as it is.
ELSE = {"friction.lift.coulomb": [280, 700], "friction.lift.breakaway": [560, 980]}


def moves(seed: int) -> dict[str, tuple[list[float], list[float]]]:
    """Openings of lift and jib, each for some seconds, to and fro."""
    rng = np.random.default_rng(seed)
    commands = {}
    for cylinder in ("lift", "jib"):
        times, spools, sign, t = [0.0], [0.0], 1.0, 0.5
        while t < DURATION - 2.0:
            times += [t, t + float(rng.uniform(2.0, 4.0))]
            spools += [sign * 0.045 * float(rng.uniform(0.3, 1.0)), 0.0]
            t, sign = times[-1] + float(rng.uniform(0.5, 1.0)), -sign
        commands[cylinder] = (times, spools)
    return commands


def plan(seed: int) -> hc.Scenario:
    return hc.Scenario(
        machine=CRANE,
        joints={"boom": 1.3, "jib": 1.8, "extension": 0.2},
        duration=DURATION,
        payload=100.0,
        commands=moves(seed),
    )


def drive(seed: int, noise: float = 1.0) -> dict[str, np.ndarray]:
    """What a logger has of a crane that is not the one of the file."""
    rng = np.random.default_rng(seed)
    flow = {"valve.lift.nominal-flow": "5.2 l/min"}
    run = hc.simulate(plan(seed), overrides={**OVERRIDES, **flow}, payload=TRUTH["payload.mass"], rtol=1e-6)
    assert run.outcome.kind == "completed"
    columns = {"time": run.columns.time}
    for joint in ("boom", "jib", "extension"):
        clean = run.columns[f"joint.{joint}.q"].values
        columns[f"joint.{joint}.q"] = clean + noise * rng.normal(0, 2e-4, clean.size)
    for cylinder in ("lift", "jib"):
        for side in ("p1", "p2"):
            clean = run.columns[f"cylinder.{cylinder}.{side}"].values
            wrong = clean * (1 + noise * rng.normal(0, 1e-3)) + noise * rng.normal(0, 1e4)
            columns[f"cylinder.{cylinder}.{side}"] = wrong + noise * rng.normal(0, 3e4, clean.size)
    return columns


@pytest.fixture(scope="module")
def log() -> dict[str, np.ndarray]:
    return drive(0)


def test_values_come_back_from_a_clean_log():
    truth = hc.simulate("single-cylinder-step", duration=1.0, overrides={"supply.pressure": "95 bar"}).data
    found = hc.fit("single-cylinder-step", truth.drop_vars("cylinder.test.command"), ["supply.pressure"])
    assert found.value("supply.pressure") == pytest.approx(95e5, rel=1e-4)


def held(seed: int, motion: str, names: list[str]) -> dict[str, bool]:
    """Whether the interval of each parameter holds the truth."""
    found = hc.fit(plan(seed), drive(seed), names, motion=motion, overrides=ELSE, priors={"payload.mass": 50.0})
    return {name: low <= TRUTH[name] <= high for name, (low, high) in found.intervals().items() if name in TRUTH}


def test_intervals_of_a_simulated_motion_hold_the_truth():
    assert all(held(1, "simulated", list(TRUTH)).values())


@pytest.mark.study
@pytest.mark.evidence
@pytest.mark.parametrize(("motion", "least"), [("simulated", 0.9), ("measured", 0.75)])
def test_intervals_hold_as_often_as_they_say(motion: str, least: float):
    """Of 20 drives; a measured motion has friction after its static map, where the truth has bristles."""
    names = list(TRUTH) if motion == "simulated" else ["payload.mass", "friction.lift.coulomb[0]"]
    drives = [held(seed, motion, names) for seed in range(20)]
    assert np.mean([hit for drive in drives for hit in drive.values()]) >= least


@pytest.mark.evidence
def test_a_crane_that_swings_out_of_step_is_found(log: dict[str, np.ndarray]):
    """With 100 kg in place of 130 kg the swings soon fall out of step, where plain least squares stays."""
    found = hc.fit(plan(0), log, ["payload.mass"], overrides={**OVERRIDES, "valve.lift.nominal-flow": "5.2 l/min"})
    assert found.value("payload.mass") == pytest.approx(130.0, rel=2e-3)


def test_a_measured_motion_weighs_the_load_whatever_the_valve(log: dict[str, np.ndarray]):
    found = hc.fit(
        plan(0), log, ["payload.mass"], motion="measured", priors={"payload.mass": 50.0}, overrides=OVERRIDES
    )
    assert found.value("payload.mass") == pytest.approx(130.0, rel=0.03)
    assert any("may be at rest" in note for note in found.notes)


@pytest.mark.evidence
def test_errors_of_sensors_are_found(log: dict[str, np.ndarray]):
    late = dict(log)
    late["cylinder.jib.p1"] = np.interp(log["time"] - 0.03, log["time"], 1.05 * log["cylinder.jib.p1"]) + 3e5
    over = {**OVERRIDES, "valve.lift.nominal-flow": "5.2 l/min"}
    errors = ["cylinder.jib.p1.zero", "cylinder.jib.p1.span", "cylinder.jib.p1.delay"]
    loose = {"cylinder.jib.p1.zero": 1e6, "cylinder.jib.p1.span": 0.2}
    found = hc.fit(plan(0), late, ["payload.mass", *errors], overrides=over, priors=loose)
    assert found.value("cylinder.jib.p1.delay") == pytest.approx(0.03, abs=3e-3)
    assert found.value("cylinder.jib.p1.span") == pytest.approx(0.05, abs=0.01)
    assert found.value("cylinder.jib.p1.zero") == pytest.approx(3e5, abs=8e4)
    assert found.unit("cylinder.jib.p1.zero") == "Pa"


def test_a_controller_in_the_loop():
    truth = hc.simulate("tip-vertical-line", duration=3.0, payload=60.0)
    names = ["cylinder.lift.p1", "cylinder.lift.p2", "tip.x", "tip.z"]
    columns = {"time": truth.columns.time, **{name: truth.columns[name].values for name in names}}
    found = hc.fit("tip-vertical-line", columns, ["payload.mass"], payload=50.0, duration=3.0)
    # What the controller decides at thresholds makes the residuals rough.
    assert found.value("payload.mass") == pytest.approx(60.0, rel=0.1)


@pytest.fixture(scope="module")
def complete(log: dict[str, np.ndarray]) -> hc.Fit:
    """A fit of all that is wrong with the file: the load, and the valve of the lift, 13 % smaller than it says."""
    return hc.fit(plan(0), log, ["payload.mass", "valve.lift.nominal-flow"], overrides=OVERRIDES)


@pytest.mark.evidence
def test_what_is_wrong_and_not_fitted_is_said(log: dict[str, np.ndarray], complete: hc.Fit):
    """The load takes up a part of what is wrong with the valve."""
    found = hc.fit(plan(0), log, ["payload.mass"], overrides=OVERRIDES)
    assert any("something that is not fitted" in text for text in found.warnings), found.warnings
    assert not any("something that is not fitted" in text for text in complete.warnings), complete.warnings


def test_what_the_log_cannot_tell_is_named(log: dict[str, np.ndarray]):
    found = hc.fit(plan(0), log, ["payload.mass", "friction.extension.coulomb[0]"], overrides=OVERRIDES)
    assert any("`friction.extension.coulomb[0]`" in text for text in found.cannot_tell)
    assert not any("payload" in text for text in found.cannot_tell)


def test_outliers_do_not_carry_the_fit_away(log: dict[str, np.ndarray]):
    spiky = dict(log)
    pressure = log["cylinder.lift.p1"].copy()
    pressure[::40] = 2.5e7
    spiky["cylinder.lift.p1"] = pressure
    over = {**OVERRIDES, "valve.lift.nominal-flow": "5.2 l/min"}
    robust = hc.fit(plan(0), spiky, ["payload.mass"], overrides=over)
    assert robust.value("payload.mass") == pytest.approx(130.0, rel=5e-3)
    quality = next(q for q in robust.quality if q.signal == "cylinder.lift.p1")
    assert quality.outliers > 0.02


@pytest.mark.evidence
def test_held_out_parts_are_judged_and_not_fitted(log: dict[str, np.ndarray]):
    spoilt = {name: values.copy() for name, values in log.items()}
    late = log["time"] > 12.0
    spoilt["cylinder.lift.p1"][late] += 2e6
    over = {**OVERRIDES, "valve.lift.nominal-flow": "5.2 l/min"}
    found = hc.fit(plan(0), spoilt, ["payload.mass"], overrides=over, hold_out=(12.0, 16.0))
    assert found.value("payload.mass") == pytest.approx(130.0, rel=5e-3)
    quality = next(q for q in found.quality if q.signal == "cylinder.lift.p1")
    assert quality.held_out == pytest.approx(2e6, rel=0.1)
    assert any("does not predict" in text for text in found.warnings)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda log: {"joint.boom.q": -log["joint.boom.q"]}, "wrong"),
        (
            lambda log: {"cylinder.lift.p1": log["cylinder.lift.p2"], "cylinder.lift.p2": log["cylinder.lift.p1"]},
            "swapped",
        ),
    ],
    ids=["sign", "swapped"],
)
def test_wrong_columns_are_named(log: dict[str, np.ndarray], change, said: str):
    wrong = {**log, **change(log)}
    # The pose at the start comes from the log too, and may be impossible.
    try:
        found = hc.fit(plan(0), wrong, ["payload.mass"], overrides=OVERRIDES, sensor_errors=False)
    except hc.HydrocraneError as error:
        assert "boom" in str(error)
        return
    assert any(said in text for text in (*found.warnings, *found.notes)), found.warnings


@pytest.mark.evidence
def test_several_logs_and_starts_elsewhere():
    logs = [drive(seed) for seed in (0, 0)]
    with ThreadPoolExecutor(2) as executor:
        found = hc.fit(
            plan(0), logs, ["payload.mass"], overrides={**OVERRIDES, "valve.lift.nominal-flow": "5.2 l/min"},
            starts=3, executor=executor,
        )  # fmt: skip
    assert found.value("payload.mass") == pytest.approx(130.0, rel=2e-3)
    assert len(found.found.costs) == 3
    assert pickle.loads(pickle.dumps(found.task)).unknowns == found.task.unknowns


def test_the_block_is_a_part_of_a_machine_file(complete: hc.Fit, tmp_path):
    complete.write(tmp_path / "fitted.toml")
    text = f'extends = "{CRANE}"\ninclude = ["fitted.toml"]\n[machine]\nname = "mine"\n'
    (tmp_path / "mine.toml").write_text(text)
    mine = hc.load_machine(tmp_path / "mine.toml")
    assert mine.payload_mass == pytest.approx(complete.value("payload.mass"), rel=1e-5)
    assert mine.value("payload.mass").provenance == "fitted"
    assert complete.report().html().count("<section") >= 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"parameters": ["payload.mas"]}, "payload.mass"),
        ({"parameters": ["friction.lift.coulomb"]}, r"friction.lift.coulomb\[0\]"),
        ({"parameters": ["payload.mass", "payload.mass"]}, "twice"),
        ({"parameters": []}, "list of keys"),
        ({"parameters": ["cylinder.lift.p1.zero"]}, "at least one key"),
        ({"signals": ["cylinder.lift.p3"]}, "cylinder.lift.p2"),
        ({"signals": ["tip.x"]}, "has no signal `tip.x`"),
        ({"motion": "measure"}, "measured"),
        ({"hold_out": 1.5}, "between 0 and 1"),
        ({"hold_out": (0.0, 100.0)}, "every sample"),
        ({"window": (3.0, 2.0)}, "the first before the second"),
        ({"priors": {"payload.mass": -1.0}}, "above zero"),
        ({"priors": {"payload": 1.0}}, "payload.mass"),
        ({"starts": 0}, "1 to 1000"),
        ({"bandwidth": 0.0}, "bandwidth"),
        ({"logs": []}, "no log"),
        ({"payload": 0.0}, "is zero"),
    ],
)
def test_bad_input_is_refused_with_its_cure(log: dict[str, np.ndarray], arguments: dict, message: str):
    given = {"scenario": plan(0), "logs": log, "parameters": ["payload.mass"], **arguments}
    with pytest.raises(hc.HydrocraneError, match=message):
        hc.fit(**given)
