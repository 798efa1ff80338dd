"""Studies: every case is the run that `simulate` would give; what is wrong is said before anything runs."""

from __future__ import annotations

import dataclasses
import sys

import numpy as np
import pytest
from scipy import stats

import hydrocrane as hc
from hydrocrane.errors import InputError
from hydrocrane.result_warning import DoubtfulResult
from hydrocrane.studies import case, design
from hydrocrane.studies.processes import NotComputed

# That cases fail is what some of them are for.
pytestmark = pytest.mark.filterwarnings("ignore:.*cases have no results")

RIG = "single-cylinder-step"
SHORT = {"duration": 0.8}


def rig_study(keys, **options):
    return hc.sweep(RIG, keys, progress=False, **{**SHORT, **options})


def own_way(run):
    """Path length of the tip, by a second hand."""
    tip = np.column_stack([run.data["tip.x"], run.data["tip.z"]])
    return float(np.linalg.norm(np.diff(tip, axis=0), axis=1).sum())


def test_every_case_of_a_grid_is_the_run_of_simulate():
    keys = {"supply.pressure": ["80 bar", 140e5], "payload.mass": [50.0, "120 kg", 200]}
    measures = ["tip_way", "largest_pressure", "smallest_pressure", "pump_energy", "stroke_margin", "steps", "rejected"]
    measures += ["max(cylinder.test.p1)", "min(tip.z)", "mean(supply.flow)", "end(energy.oil)", "rms(joint.slide.qd)"]
    data = rig_study(keys, measures=measures, signals=["tip.z", "cylinder.test.p2"], resample="20 ms")
    assert dict(data.sizes) == {"supply.pressure": 2, "payload.mass": 3, "time": 41}
    for pressure in data["supply.pressure"].values:
        for mass in data["payload.mass"].values:
            one = data.sel({"supply.pressure": pressure, "payload.mass": mass})
            run = hc.simulate(RIG, overrides={"supply.pressure": pressure, "payload.mass": mass}, ledger=False, **SHORT)
            crane, signals = run.machine, run.data
            stroke = signals["cylinder.test.x"].values
            wanted = {
                "end_time": run.outcome.time,
                "tip_way": own_way(run),
                "largest_pressure": max(signals["cylinder.test.p1"].max(), signals["cylinder.test.p2"].max()),
                "smallest_pressure": min(signals["cylinder.test.p1"].min(), signals["cylinder.test.p2"].min()),
                "pump_energy": float(signals["supply.power"].integrate("time")),
                "stroke_margin": np.abs(stroke[:, np.newaxis] - crane.stroke_limits[0]).min(),
                "steps": signals.attrs["solver_steps"],
                "rejected": signals.attrs["solver_rejected"],
                "max(cylinder.test.p1)": signals["cylinder.test.p1"].max(),
                "min(tip.z)": signals["tip.z"].min(),
                "mean(supply.flow)": signals["supply.flow"].mean(),
                "end(energy.oil)": signals["energy.oil"][-1],
                "rms(joint.slide.qd)": np.sqrt((signals["joint.slide.qd"] ** 2).mean()),
            }  # fmt: skip
            for name, value in wanted.items():
                assert float(one[name]) == pytest.approx(float(value), rel=1e-12, abs=1e-12), name
            assert one["outcome"] == "completed" and one["message"] == ""
            picked = signals.sel(time=one.time.values, method="nearest")
            assert np.array_equal(one["tip.z"], picked["tip.z"])
            assert np.array_equal(one["cylinder.test.p2"], picked["cylinder.test.p2"])
    assert data["pump_energy"].attrs["units"] == "J" and data["supply.pressure"].attrs["units"] == "Pa"
    assert data["max(cylinder.test.p1)"].attrs["units"] == "Pa" and data["tip.z"].attrs["long_name"]


OPEN, CLOSED = "vertical-lift-open-loop", "tip-vertical-line"


def with_joystick(**fields):
    plan = hc.load_scenario(CLOSED)
    return plan.changed(joystick=dataclasses.replace(plan.joystick, **fields))


def with_command(spool):
    plan = hc.load_scenario(OPEN)
    return plan.changed(commands={**plan.commands, "lift": dataclasses.replace(plan.commands["lift"], spool=spool)})


def over(key, value):
    return {"overrides": {key: value}}


# Scenario, key, value in a study -> the same by other means.
SPOOLS = [0.0, 0.01, 0.02, 0.01, 0.0]
COULOMB = "friction.lift.coulomb"
LOWER = {"boom": np.deg2rad(95), "jib": np.deg2rad(100), "extension": 0.0}
KEYS = {
    "machine": (OPEN, "cylinder.lift.bore", "90 mm", over("cylinder.lift.bore", 0.09)),
    "choice of the machine": (OPEN, "errata.gravity-sign", "as-printed", over("errata.gravity-sign", "as-printed")),
    "one of a pair": (OPEN, f"{COULOMB}[0]", 500.0, over(COULOMB, [500.0, 490.0])),
    "whole pair": (OPEN, COULOMB, ["0.1 kN", 600.0], over(COULOMB, ["0.1 kN", 600.0])),
    "duration": (OPEN, "scenario.duration", "0.7 s", {"duration": 0.7}),
    "record interval": (OPEN, "record-interval", "20 ms", {"record_interval": 0.02}),
    "payload": (OPEN, "payload", 120, {"payload": 120}),
    "tolerance": (OPEN, "solver.rtol", 1e-3, {"rtol": 1e-3}),
    "method": (OPEN, "solver.method", "tsit5", {"method": "tsit5"}),
    "largest step": (OPEN, "solver.max-step", "5 ms", {"max_step": 0.005}),
    "start": (OPEN, "initial.joint.boom", "95 deg", {"joints": LOWER}),
    "command": (OPEN, "command.lift.spool", SPOOLS, lambda: with_command(SPOOLS)),
    "gain": (CLOSED, "control.tip.position-gain", "1 1/s", over("control.tip.position-gain", "1 1/s")),
    "period": (CLOSED, "controller.period", "20 ms", {"period": 0.02}),
    "period of the machine": (CLOSED, "control.period", "20 ms", {"period": 0.02}),
    "sensors": (CLOSED, "controller.sensors", "ideal", {"sensors": "ideal"}),
    "seed": (CLOSED, "seed", 7, {"seed": 7}),
    "stick": (CLOSED, "joystick.full-speed", 0.2, lambda: with_joystick(full_speed=0.2)),
    "full speed of the machine": (CLOSED, "control.tip.full-speed", 0.2, lambda: with_joystick(full_speed=0.2)),
    "model": (CLOSED, "controller.model.payload.mass", "300 kg", {"controller_model": {"payload.mass": 300.0}}),
}  # fmt: skip


@pytest.mark.parametrize(("scenario", "key", "value", "changes"), KEYS.values(), ids=KEYS)
def test_a_key_does_what_its_change_does(scenario, key, value, changes):
    fields = {} if key == "scenario.duration" else {"duration": 1.0}
    base = changes() if callable(changes) else hc.load_scenario(scenario).changed(**changes)
    run = hc.simulate(base, ledger=False, **fields)
    plain = hc.simulate(scenario, ledger=False, **fields)
    found = hc.sweep(
        scenario, {key: [value]}, measures=["tip_way", "steps", "rms(supply.flow)"], progress=False, **fields
    )
    assert found.outcome.item() == "completed", found.message.item()
    assert found["tip_way"].item() == pytest.approx(own_way(run), rel=1e-12)
    assert found["steps"].item() == run.data.attrs["solver_steps"]
    told = [own_way(run), run.data.attrs["solver_steps"], run.data.sizes["time"]]
    assert told != [own_way(plain), plain.data.attrs["solver_steps"], plain.data.sizes["time"]], "the key did nothing"


def test_start_pressures_are_keys_too():
    plan = hc.load_scenario(RIG).changed(pressures={"test": (40e5, 20e5)}, **SHORT)
    found = hc.sweep(
        plan, {"initial.pressure.test": [["30 bar", 20e5]]}, measures=["start(cylinder.test.p1)"], progress=False
    )
    assert found["start(cylinder.test.p1)"].item() == 30e5


def test_the_payload_of_the_machine_counts_where_the_scenario_states_one():
    plan = hc.load_scenario(RIG).changed(payload=20.0, **SHORT)
    found = hc.sweep(plan, {"payload.mass": [20.0, 150.0]}, measures=["mean(payload)"], progress=False)
    assert found["mean(payload)"].values.tolist() == [20.0, 150.0]


DRAW = {"method": "random", "n": 2}
WRONG = {
    "misspelt key": ({"supply.presure": [1e7]}, {}, ["supply.presure", "`pressure`"]),
    "misspelt name": ({"cylinder.tset.bore": [0.1]}, {}, ["tset", "test"]),
    "misspelt field": ({"duraton": [1.0]}, {}, ["duraton", "`duration`"]),
    "misspelt solver": ({"solver.rtoll": [1e-3]}, {}, ["solver.rtoll", "`solver.rtol`"]),
    "misspelt table": ({"solvr.rtol": [1e-3]}, {}, ["solvr.rtol", "`solver.rtol`"]),
    "unknown joint": ({"initial.joint.slid": [0.1]}, {}, ["initial.joint.slid", "initial.joint.slide"]),
    "beyond the pair": ({"friction.test.coulomb[2]": [0.1]}, {}, ["[0] to [1]"]),
    "gain of a lever": ({"joystick.ramp": [0.1]}, {}, ["no joystick"]),
    "period of nobody": ({"controller.period": ["10 ms"]}, {}, ["controller.period", "no controller"]),
    "model of no controller": ({"controller.model.payload.mass": [1.0]}, {}, ["no controller"]),
    "another quantity": ({"payload.mass": ["5 bar"]}, {}, ["payload.mass", "pressure"]),
    "another quantity later": ({"payload.mass": [5.0, "5 bar"]}, {}, ["payload.mass", "5 bar"]),
    "another quantity of the scenario": ({"duration": ["5 bar"]}, {}, ["duration", "5 bar"]),
    "misspelt word": ({"errata.end-stop": ["corrected", "as-prnted"]}, {}, ["as-prnted", "as-printed"]),
    "misspelt word of the scenario": ({"solver.method": ["tsit5", "rodas5"]}, {}, ["rodas5", "`rodas5p`"]),
    "misspelt controller": ({"controller.name": ["tipp"]}, {}, ["tipp", "`tip`"]),
    "unknown unit": ({"payload.mass": ["5 kgg"]}, {}, ["kgg", "kg"]),
    "no value": ({"payload.mass": []}, {}, ["payload.mass", "empty"]),
    "no key": ({}, {}, ["payload.mass"]),
    "a number for values": ({"payload.mass": 5.0}, {}, ["payload.mass", "list of values"]),
    "unknown method": ({"payload.mass": [1.0]}, {"method": "grit"}, ["grit", "`grid`"]),
    "draws without a number": ({"payload.mass": (1.0, 2.0)}, {"method": "random"}, ["random", "needs n"]),
    "grid with a number": ({"payload.mass": (1.0, 2.0)}, {"n": 3}, ["grid", "takes no n"]),
    "half a case": ({"payload.mass": (1.0, 2.0)}, {"method": "latin", "n": 2.5}, ["n must", "2.5"]),
    "three ends": ({"payload.mass": (1.0, 2.0, 3.0)}, {"method": "latin", "n": 2}, ["3 values", "low"]),
    "range backwards": ({"payload.mass": (2.0, 1.0)}, {"method": "latin", "n": 2}, ["low to high"]),
    "log of zero": ({"payload.mass": {"low": 0.0, "high": 1.0, "log": True}}, DRAW, ["above zero"]),
    "range without count": ({"payload.mass": {"low": 0.0, "high": 1.0}}, {}, ["count"]),
    "range misspelt": ({"payload.mass": {"low": 0.0, "hihg": 1.0}}, {}, ["hihg", "`high`"]),
    "unknown distribution": ({"payload.mass": {"distribution": "normm"}}, DRAW, ["normm", "norm"]),
    "distribution on a grid": ({"payload.mass": stats.norm(50, 5)}, {}, ["distribution", "grid"]),
    "unequal lists": ({"payload.mass": [1.0], "supply.pressure": [1e7, 2e7]}, {"method": "list"}, ["payload.mass 1"]),
    "unknown measure": ({"payload.mass": [1.0]}, {"measures": ["tip_wya"]}, ["tip_wya", "`tip_way`"]),
    "unknown statistic": ({"payload.mass": [1.0]}, {"measures": ["maxi(tip.z)"]}, ["maxi", "`max`"]),
    "statistic of nothing": ({"payload.mass": [1.0]}, {"measures": ["max(tip.zz)"]}, ["tip.zz", "`tip.z`"]),
    "measure twice": ({"payload.mass": [1.0]}, {"measures": ["tip_way", "tip_way"]}, ["tip_way", "twice"]),
    "unknown signal": ({"payload.mass": [1.0]}, {"signals": ["tip.y"]}, ["tip.y"]),
    "no interval": ({"payload.mass": [1.0]}, {"signals": ["tip.z"], "resample": 0.0}, ["resample", "0.0"]),
    "intervals differ": ({"record-interval": [0.01, 0.02]}, {"signals": ["tip.z"]}, ["resample"]),
    "name taken": ({"payload.mass": [1.0]}, {"measures": {"outcome": own_way}}, ["outcome", "two things"]),
    "no workers": ({"payload.mass": [1.0]}, {"workers": 0}, ["workers", "0"]),
    "no block": ({"payload.mass": [1.0]}, {"block": -1}, ["block", "-1"]),
    "seed with a fraction": ({"payload.mass": (1.0, 2.0)}, {"method": "random", "n": 2, "seed": 0.5}, ["seed", "0.5"]),
    "unknown scheduler": ({"payload.mass": [1.0]}, {"scheduler": "nowhere"}, ["nowhere"]),
}  # fmt: skip


@pytest.mark.parametrize(("keys", "options", "words"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_said_before_anything_runs(keys, options, words, monkeypatch):
    monkeypatch.setattr(case, "run_case", lambda *_: pytest.fail("a case was run"))
    with pytest.raises(hc.HydrocraneError) as caught:
        rig_study(keys, **options)
    for word in words:
        assert word in str(caught.value), str(caught.value)
    assert len(str(caught.value)) < 400


def cases(keys, **options):
    """The values of the keys alone."""
    return hc.Study(RIG, keys, **options).cases


def test_a_range_on_a_grid_has_even_steps_or_even_ratios():
    keys = {
        "supply.pressure": {"low": "100 bar", "high": "140 bar", "count": 5},
        "payload.mass": {"low": 10.0, "high": 1000.0, "count": 3, "log": True},
    }
    pressure, mass = cases(keys).axes
    assert np.allclose(pressure, [100e5, 110e5, 120e5, 130e5, 140e5], rtol=1e-14)
    assert np.allclose(mass, [10.0, 100.0, 1000.0], rtol=1e-12)


def test_a_latin_hypercube_has_one_case_in_every_stripe():
    keys = {"payload.mass": (100.0, 200.0), "supply.pressure": {"low": 1e6, "high": 1e8, "log": True}}
    mass, pressure = cases(keys, method="latin", n=40, seed=3).axes
    assert sorted(int((m - 100.0) / 100.0 * 40) for m in mass) == list(range(40))
    assert sorted(int(np.log10(p / 1e6) / 2 * 40) for p in pressure) == list(range(40))


def test_draws_follow_their_distribution_and_their_seed():
    keys = {
        "payload.mass": stats.uniform(50, 100),
        "supply.pressure": {"distribution": "norm", "loc": "140 bar", "scale": "5 bar"},
        "valve.test.damping-ratio": {"values": [0.3, 0.7]},
    }
    first = cases(keys, method="random", n=2000, seed=1)
    again, other = (cases(keys, method="random", n=2000, seed=seed) for seed in (1, 2))
    assert first.axes == again.axes and first.axes != other.axes
    mass, pressure, damping = (np.array(axis) for axis in first.axes)
    # Bounds of the Kolmogorov statistic that one draw in a million exceeds.
    limit = 2.7 / np.sqrt(2000)
    assert stats.kstest(mass, stats.uniform(50, 100).cdf).statistic < limit
    assert stats.kstest(pressure, stats.norm(140e5, 5e5).cdf).statistic < limit
    assert set(damping) == {0.3, 0.7} and abs((damping == 0.3).mean() - 0.5) < 5 * 0.5 / np.sqrt(2000)


def test_drawn_cases_stand_in_a_row_with_their_values():
    keys = {"payload.mass": (50.0, 150.0), "solver.method": {"values": ["rodas5p", "tsit5"]}}
    data = rig_study(keys, method="latin", n=6, seed=4)
    assert data["tip_way"].dims == ("case",) and set(data["solver.method"].values) == {"rodas5p", "tsit5"}
    drawn = hc.Study(RIG, keys, method="latin", n=6, seed=4).cases
    assert data["payload.mass"].values.tolist() == drawn.axes[0]
    last = data.isel(case=5)
    run = hc.simulate(
        RIG, overrides={"payload.mass": last["payload.mass"].item()}, method=last["solver.method"].item(), **SHORT
    )
    assert last["tip_way"].item() == pytest.approx(own_way(run), rel=1e-12)


def test_a_failed_case_is_kept_and_its_neighbours_do_not_notice():
    masses = [50.0, -1.0, 100.0]
    starts = [0.0, "400 mm"]
    keys = {"payload.mass": masses, "initial.joint.slide": starts}
    options = {"signals": ["tip.z"], "pressures": {"test": (10e5, 10e5)}}
    data = rig_study(keys, block=6, **options)
    assert data.outcome.values.tolist() == [
        ["completed", "bad-state"],
        ["invalid-input"] * 2,
        ["completed", "bad-state"],
    ]
    assert "payload.mass" in data.message.values[1, 0] and "test" in data.message.values[0, 1]
    sound = rig_study({"payload.mass": [50.0, 100.0], "initial.joint.slide": [0.0]}, **options)
    for name in ("tip_way", "tip.z", "pump_energy", "end_time"):
        assert np.array_equal(data[name].values[[0, 2], 0], sound[name].values[:, 0])
        if name != "end_time":
            assert np.isnan(data[name].values[1]).all() and np.isnan(data[name].values[:, 1]).all()


def quitting(obs, command):
    """A controller that gives up with heavy loads on the rod."""
    if obs.t > 0.3 and obs.p.max() > 40e5:
        raise RuntimeError("too heavy")
    return [0.0]


def test_a_run_that_ends_early_has_its_signals_up_to_there():
    plan = hc.Scenario(machine="single-cylinder", joints={"slide": 0.0}, controller=quitting)
    keys = {"payload.mass": [10.0, 900.0], "duration": [1.0, 1.5]}
    data = hc.sweep(plan, keys, signals=["tip.z"], resample=0.03, progress=False)
    assert data.outcome.values.tolist() == [["completed"] * 2, ["controller-failed"] * 2]
    assert "too heavy" in data.message.values[1, 0] and (data["end_time"].values[1] < 0.5).all()
    for one, end in zip(data["tip.z"].values.reshape(4, -1), data["end_time"].values.ravel(), strict=True):
        reached = data.time.values <= end + 1e-9
        assert np.isfinite(one[reached]).all() and np.isnan(one[~reached]).all()
    assert np.isnan(data["tip_way"].values[1]).all() and data.sizes["time"] == 51


def test_functions_of_a_run_are_measures():
    data = rig_study(
        {"payload.mass": [50.0, 100.0]},
        measures={
            "way": own_way,
            "both": lambda run: {"low": run.data["tip.z"].min(), "high": run.data["tip.z"].max()},
        },
    )
    again = rig_study({"payload.mass": [50.0, 100.0]}, measures=["tip_way", "min(tip.z)", "max(tip.z)"])
    assert np.allclose(data["way"], again["tip_way"], rtol=1e-12)
    assert np.array_equal(data["low"], again["min(tip.z)"]) and np.array_equal(data["high"], again["max(tip.z)"])


def test_functions_may_read_the_ledger_where_it_is_asked_for():
    closing = {"closing": lambda run: run.data["ledger.payload.load"].values[-1]}
    assert (rig_study({"payload.mass": [50.0]}, measures=closing).outcome == "measure-failed").all()
    assert (rig_study({"payload.mass": [50.0]}, measures=closing, ledger=True)["closing"] == 0.0).all()


def test_a_measure_that_fails_costs_its_case_only_its_figures():
    def moody(run):
        if run.data.attrs["payload"] > 70:
            raise ZeroDivisionError("too heavy")
        return 1.0

    data = rig_study({"payload.mass": [50.0, 100.0]}, measures=[moody])
    assert data.outcome.values.tolist() == ["completed", "measure-failed"]
    assert data["message"].values[1] == "ZeroDivisionError: too heavy"
    assert data["moody"].values[0] == 1.0 and np.isnan(data["moody"].values[1]) and data["end_time"].values[1] == 0.8


def test_whatever_breaks_in_a_case_is_its_outcome(monkeypatch):
    """A panic of the core is no `Exception` in Python."""

    class Panic(BaseException):
        pass

    def broken(crane, plan, **_):
        raise Panic("assertion failed")

    monkeypatch.setattr(case, "integrate", broken)
    data = rig_study({"payload.mass": [50.0]})
    assert data.outcome.item() == "crashed" and data.message.item() == "Panic: assertion failed"


class Ramp:
    """A controller that remembers how often it was asked."""

    def __init__(self):
        self.count = 0

    def reset(self, crane, obs):
        self.crane = crane

    def step(self, obs, command):
        self.count += 1
        return [1e-4 * self.count * self.crane.payload_mass / 100.0]


def test_every_case_has_a_controller_of_its_own():
    plan = hc.Scenario(machine="single-cylinder", joints={"slide": 0.0}, controller=Ramp(), duration=0.5)
    masses = [60.0, 80.0, 100.0, 120.0]
    data = hc.sweep(
        plan, {"payload.mass": masses}, measures=["end(cylinder.test.command)"], workers=3, block=1, progress=False
    )
    # 50 samples, the last of which may fall on the end.
    wanted = [1e-4 * 50 * mass / 100.0 for mass in masses]
    assert np.allclose(data["end(cylinder.test.command)"], wanted, rtol=0.03) and plan.controller.count == 0


def test_result_does_not_depend_on_threads_or_blocks():
    keys = {"payload.mass": (50.0, 150.0), "supply.pressure": ("100 bar", "140 bar")}
    options = {"method": "random", "n": 12, "signals": ["tip.z"]}
    one = rig_study(keys, workers=1, block=12, **options)
    many = rig_study(keys, workers=4, block=1, **options)
    assert one.equals(many)


def test_blocks_cover_every_case_once_and_stay_small():
    rng = np.random.default_rng(5)
    for _ in range(200):
        shape = tuple(int(n) for n in rng.integers(1, 9, rng.integers(1, 4)))
        size = int(rng.integers(1, 40))
        block = design.block_shape(shape, size, 0)
        assert np.prod(block) <= size or np.prod(block) == 1
        count = np.zeros(shape, dtype=int)
        for place in design.blocks(shape, block):
            count[place] += 1
        assert (count == 1).all()


def test_blocks_with_signals_stay_within_their_bytes():
    assert np.prod(design.block_shape((5000,), None, 8 * 40 * 2001)) * 8 * 40 * 2001 <= design.BLOCK_BYTES
    assert design.block_shape((5000,), None, 10**9) == (1,)


def test_no_figure_takes_the_name_of_another():
    def first(run):
        return {"peak": 1.0}

    def second(run):
        return {"peak": 2.0}

    for measures, name in (
        ([first, second], "peak"),
        ([lambda run: {"end_time": -3.0}], "end_time"),
        ([lambda run: {"payload.mass": 5.0}], "payload.mass"),
        (["tip_way", lambda run: {"tip_way": 5.0}], "tip_way"),
        ([lambda run: {"outcome": 5.0}], "outcome"),
    ):
        with pytest.raises(InputError, match=f"`{name}`"):
            hc.sweep("single-cylinder-step", {"payload.mass": [50]}, measures=measures, duration=0.1)


def test_two_workers_of_dask_give_the_bits_of_threads():
    """Small studies too: their arrays may come at odd addresses."""
    distributed = pytest.importorskip("distributed")

    def swept(count, scheduler, measure="tip_way"):
        masses = {"payload.mass": {"low": 50.0, "high": 150.0, "count": count}}
        return hc.sweep("single-cylinder-step", masses, measures=[measure], duration=0.3, scheduler=scheduler)

    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        far = {count: swept(count, client) for count in (7, 100)}
        kept = client.nthreads()
        with pytest.raises(SystemExit, match="3"):
            swept(7, client, lambda run: sys.exit(3))
        assert client.nthreads() == kept, "what ends a study ends no worker"
    with pytest.raises(NotComputed, match="client was closed; stopped after 0 of 7 cases"):
        swept(7, client)
    for count, data in far.items():
        assert set(data["outcome"].values) == {"completed"}
        assert data.identical(swept(count, "threads"))


def test_a_record_beyond_the_limit_is_refused_before_the_first_case():
    """Also if only one of the cases has it; a length that is none is the outcome of its case."""
    for keys in ({"duration": [0.1, 360_000.0]}, {"record-interval": [0.1, 1e-6]}):
        with pytest.raises(InputError, match="the record of this run would take .* record_limit"):
            hc.sweep("single-cylinder-step", keys, record_limit="100 MB", progress=False)
    with pytest.warns(DoubtfulResult, match="1 of 2 cases"):
        data = hc.sweep("single-cylinder-step", {"duration": [0.1, -1.0]}, progress=False)
    assert data.outcome.values.tolist() == ["completed", "invalid-input"]


def test_a_machine_whose_file_was_changed_is_no_other_machine(tmp_path):
    """The cases read the file; `simulate` takes the machine as it was loaded."""
    file = tmp_path / "mine.toml"
    text = hc.load_machine("single-cylinder").to_toml()
    file.write_text(text)
    rig = hc.load_machine(file, {"supply.pressure": "130 bar"})
    options = {"machine": rig, "duration": 0.1, "overrides": {"supply.tank-pressure": "2 bar"}, "progress": False}
    assert (hc.sweep(RIG, {"payload.mass": [50.0]}, **options).outcome == "completed").all()
    assert 'bore = "50 mm"' in text
    file.write_text(text.replace('bore = "50 mm"', 'bore = "60 mm"'))
    with pytest.raises(InputError, match="mine.toml was changed after this machine was loaded"):
        hc.sweep(RIG, {"payload.mass": [50.0]}, **options)
