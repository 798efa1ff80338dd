"""A study is resumed if it is the same, down to the code that it calls; what crashed is computed again."""

from __future__ import annotations

import functools
import importlib
import os
import pickle
import subprocess
import sys
import textwrap
import threading
import types

import numpy as np
import pytest

import hydrocrane as hc
from hydrocrane.result_warning import DoubtfulResult
from hydrocrane.studies import case
from hydrocrane.studies.identity import UNKNOWN, fingerprint, plain

PLAN = "single-cylinder-step"
LOADS = {"payload.mass": [50.0, 100.0, 150.0]}


def run(store, **given):
    return hc.sweep(PLAN, LOADS, store=store, **{"duration": 0.05, "measures": ["tip_way"], **given})


class Proportional:
    def __init__(self, gain):
        self.gain = gain

    def reset(self, machine, obs):
        self.start = obs.q[0]

    def step(self, obs, command):
        return [self.gain * (self.start + 0.1 - obs.q[0])]


OFFSET = 1.0
# A variable of the environment.
NAME = "GAIN"


def helper(run):
    return OFFSET * run.outcome.time


def measured(run, factor=1.0):
    return factor * helper(run)


def of(offset):
    return lambda run: offset


def changed_default():
    made = types.FunctionType(measured.__code__, globals(), "measured", (2.0,))
    made.__module__, made.__qualname__ = measured.__module__, measured.__qualname__
    return made


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (Proportional(1.0), Proportional(5.0)),
        (functools.partial(measured, factor=1.0), functools.partial(measured, factor=2.0)),
        (of(1.0), of(2.0)),
        (measured, changed_default()),
        (Proportional(np.zeros(3)).step, Proportional(np.ones(3)).step),
        (np.random.default_rng(1), np.random.default_rng(2)),
    ],
    ids=["state", "argument", "closure", "default", "method", "generator"],
)
def test_what_is_changed_has_another_digest(before, after):
    assert fingerprint(before) != fingerprint(after)
    assert fingerprint(before) == fingerprint(before)
    assert UNKNOWN not in fingerprint(before)


def test_globals_helpers_and_files_count(monkeypatch, tmp_path):
    before = fingerprint(measured)
    monkeypatch.setattr(sys.modules[__name__], "OFFSET", 2.0)
    assert fingerprint(measured) != before
    monkeypatch.undo()
    assert fingerprint(measured) == before
    monkeypatch.setattr(sys.modules[__name__], "helper", lambda run: run.outcome.time)
    assert fingerprint(measured) != before
    file = tmp_path / "table.csv"
    file.write_text("1\n")
    held = fingerprint(of(str(file)))
    file.write_text("2\n")
    assert fingerprint(of(str(file))) != held
    assert UNKNOWN not in fingerprint(of("a" * 500))


# Modules by their names, and what is put in place of 1.0 in the last of them: `measure` of the first gives it.
MODULES = {
    "a dataclass": {
        "mine": """
            import dataclasses
            @dataclasses.dataclass
            class Own:
                gain: float = 3.0
                def step(self, obs, command):
                    return [self.gain * 1.0]
            measure = Own()
            """
    },
    "a class of lists": {"mine": "class Own(list):\n    def __call__(self, run): return 1.0\nmeasure = Own()"},
    "a class of texts": {"mine": "class Own(str):\n    def step(self, obs, command): return 1.0\nmeasure = Own('a')"},
    "a number's class": {
        "mine": """
            class Own(float):
                pass
            own = Own(3.0)
            own.gain = 1.0
            def measure(run): return own.gain
            """
    },
    "a choice": {
        "mine": """
            import enum
            class Own(enum.IntEnum):
                A = 1
                def gain(self): return 1.0
            own = Own.A
            def measure(run): return own.gain()
            """
    },
    "a metaclass": {
        "mine": """
            class Made(type):
                gain = 1.0
            class Own(metaclass=Made):
                def __call__(self, run): return type(self).gain
            measure = Own()
            """
    },
    "a class with abstract methods": {
        "mine": """
            import hydrocrane as hc, typing
            class Own(hc.Controller, typing.Protocol):
                def step(self, obs, command): return [1.0]
            class More(Own):
                pass
            measure = More()
            """
    },
    "a function behind a cache": {
        "mine": """
            import functools
            @functools.lru_cache
            def helper(): return 1.0
            def measure(run): return helper()
            """
    },
    "an attribute of a function": {"mine": "def measure(run): return measure.gain\nmeasure.gain = 1.0"},
    "a wrapped function of a library": {
        "mine": """
            import functools
            import numpy as np
            def scaled(function):
                @functools.wraps(function)
                def inner(*given): return 1.0 * function(*given)
                return inner
            mean = scaled(np.mean)
            def measure(run): return mean([run.outcome.time])
            """
    },
    "order of arguments": {
        "mine": """
            def two(a=0.0, b=0.0): return a - 2 * b
            def measure(run): return two(a=3.0)
            """
    },
    "masked numbers": {
        "mine": """
            import numpy as np
            own = np.ma.array([3.0, 4.0], mask=[0, 1.0 > 1.5])
            def measure(run): return own.sum()
            """
    },
    "a module of a package": {
        "mine": "import parts.inner\ndef measure(run): return parts.inner.GAIN",
        "parts/__init__": "",
        "parts/inner": "GAIN = 1.0",
    },
    "a module with a name of Python's": {
        "mine": "import code\ndef measure(run): return code.GAIN",
        "code": "GAIN = 1.0",
    },
    "a module as an argument": {
        "mine": "import inner\ndef measure(run, settings=inner): return settings.GAIN",
        "inner": "GAIN = 1.0",
    },
    "a module in a table": {
        "mine": "import inner\ntable = {'inner': inner}\ndef measure(run): return table['inner'].GAIN",
        "inner": "GAIN = 1.0",
    },
    "an attribute by its name": {
        "mine": "import inner\ndef measure(run): return getattr(inner, 'GAIN')",
        "inner": "GAIN = 1.0",
    },
    "a late import": {
        "mine": "def measure(run):\n    import inner\n    return inner.GAIN",
        "inner": "GAIN = 1.0",
    },
    "a late import of a name": {
        "mine": "from parts.outer import measure",
        "parts/__init__": "",
        "parts/outer": "def measure(run):\n    from . import inner\n    return inner.gain()",
        "parts/inner": "def gain(): return 1.0",
    },
}


@pytest.mark.parametrize("modules", MODULES.values(), ids=MODULES)
def test_what_code_reaches_counts(modules, tmp_path, monkeypatch):
    def told(folder):
        folder.mkdir()
        for name, text in written.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / f"{name}.py").write_text(textwrap.dedent(text))
        for name in ("mine", "inner", "parts", "parts.inner", "parts.outer", "code"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        with monkeypatch.context() as patched:
            patched.syspath_prepend(folder)
            return plain(importlib.import_module("mine").measure)

    monkeypatch.delitem(sys.modules, "code", raising=False)
    written = dict(modules)
    before, again = told(tmp_path / "before"), told(tmp_path / "again")
    last = list(written)[-1]
    changes = {"order of arguments": ("a=0.0, b=0.0): return a - 2 * b", "b=0.0, a=0.0): return b - 2 * a")}
    old, new = changes["order of arguments"] if "two(" in written[last] else ("1.0", "2.0")
    assert old in written[last]
    written[last] = written[last].replace(old, new)
    assert before == again and UNKNOWN not in str(before)
    assert told(tmp_path / "after") != before


def test_a_class_that_was_copied_is_the_same():
    """Python notes in a class how to copy what is made of it."""

    class Own:
        pass

    def measure(run):
        return Own() is not None

    before = fingerprint(measure)
    Own().__reduce_ex__(4)
    assert fingerprint(measure) == before


def test_a_run_is_the_same_however_long_it_took():
    def held():
        reference = hc.simulate(PLAN, duration=0.05)
        return lambda run: run.outcome.time - reference.outcome.time

    assert fingerprint(held()) == fingerprint(held())


def test_what_leads_anywhere_is_not_known():
    function = np.frompyfunc(lambda x: x, 1, 1)
    for own, told in (
        (lambda run: float(os.environ[str(run)]), "os.environ"),
        (lambda run: os.environ, "os.environ"),
        (lambda run: os.getenv(str(run)), "os.getenv"),
        (lambda run: eval("OFFSET"), "eval"),
        (lambda run: function(1.0), "ufunc"),
        (lambda run: len({threading.Lock()} | held), "lock"),
    ):
        held = {threading.Lock()}
        assert UNKNOWN in fingerprint(own) and told in fingerprint(own), told
    assert UNKNOWN not in fingerprint(lambda run: os.path.join("a", "b") + str(np.sin(0.0)))


def test_the_environment_counts_where_its_names_stand(monkeypatch):
    for own in (
        lambda run: os.environ["GAIN"],
        lambda run: os.environ.get("GAIN", "1"),
        lambda run: os.getenv("GAIN"),
        lambda run: os.environ[NAME],
    ):
        seen = []
        for gain in ("1", "2", "1"):
            monkeypatch.setenv("GAIN", gain)
            seen.append(fingerprint(own))
        assert seen[0] == seen[2] != seen[1] and UNKNOWN not in seen[0]


SCRIPT = """
    import abc, dataclasses
    import hydrocrane as hc
    import inner
    class Base(abc.ABC):
        @abc.abstractmethod
        def step(self, obs, command): ...
    @dataclasses.dataclass
    class Own(Base):
        __slots__ = ("gain",)
        gain: float
        def step(self, obs, command): return [self.gain]
    plan = hc.Scenario(machine="single-cylinder", joints={"slide": 0.0}, controller=Own(0.0), duration=0.05)
    def gain(run): return inner.GAIN
    def swept():
        data = hc.sweep(
            plan, {"payload.mass": [50.0]}, measures=[gain], workers=1, scheduler="processes", progress=False
        )
        print(data["gain"].item())
    swept()
    inner.GAIN = 5.0
    swept()
"""


def test_a_module_that_was_changed_in_memory_is_not_taken_from_its_file(tmp_path):
    """Processes import modules anew, and would compute with what these say there."""
    (tmp_path / "inner.py").write_text("GAIN = 1.0")
    (tmp_path / "script.py").write_text(textwrap.dedent(SCRIPT))
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.stdout.split() == ["1.0"]
    assert "measure `gain` is" in done.stderr and "changed after it was imported" in done.stderr


def test_another_gain_is_another_study(tmp_path):
    def swept(gain):
        plan = hc.Scenario(
            machine="single-cylinder", joints={"slide": 0.0}, controller=Proportional(gain), duration=0.05
        )
        return hc.sweep(plan, LOADS, store=tmp_path / "s", measures=["tip_way"])

    swept(0.01)
    assert (swept(0.01)["outcome"] == "completed").all()
    with pytest.raises(hc.ResultFileError, match="controller was"):
        swept(0.05)


def test_what_cannot_be_told_is_refused_or_taken_on_trust(tmp_path):
    guard = threading.Lock()

    def slow(run):
        with guard:
            return run.outcome.time

    run(tmp_path / "s", measures=[slow])
    with pytest.raises(hc.ResultFileError, match="lock does not tell its state.*resume"):
        run(tmp_path / "s", measures=[slow])
    found = run(tmp_path / "s", measures=[slow], resume="trust")
    assert "lock" in found.attrs["resumed_on_trust"]
    with pytest.raises(hc.InputError, match="trust"):
        run(tmp_path / "s", measures=[slow], resume="blindly")


def test_the_content_of_a_log_counts(tmp_path):
    log = tmp_path / "commands.csv"
    text = "time,test\n0,0\n0.01,{}\n1,{}\n"
    log.write_text(text.format(0.002, 0.002))
    keys = {"command.log": [str(log)]}
    first = hc.sweep(PLAN, keys, store=tmp_path / "s", duration=0.1, measures=["tip_way"])
    log.write_text(text.format(0.009, 0.009))
    with pytest.raises(hc.ResultFileError, match="logs"):
        hc.sweep(PLAN, keys, store=tmp_path / "s", duration=0.1, measures=["tip_way"])
    assert (first["outcome"] == "completed").all()


def test_what_crashed_is_told_and_computed_again(tmp_path, monkeypatch):
    simulated, heavy = case._simulated, {150.0}

    def crashing(job, values, should_stop):
        if values[0] in heavy:
            raise TypeError("a mistake of the program")
        return simulated(job, values, should_stop)

    monkeypatch.setattr(case, "_simulated", crashing)
    with pytest.warns(DoubtfulResult, match=r"1 of 3 cases have no results \(crashed\).*a mistake of the program"):
        found = run(tmp_path / "s", block=1)
    assert list(found["outcome"].values) == ["completed", "completed", "crashed"]
    heavy.clear()
    assert list(run(tmp_path / "s", block=1)["outcome"].values) == ["completed"] * 3


@pytest.mark.parametrize("offset", range(1, 8))
def test_arrays_may_lie_at_any_byte(offset):
    """As buffers of pickle lie that another process sends."""

    def sent(array):
        kept = []
        data = pickle.dumps(np.asarray(array, dtype=float), protocol=5, buffer_callback=kept.append)
        buffers = []
        for buffer in kept:
            room = bytearray(len(buffer.raw()) + 8)
            room[offset : offset + len(buffer.raw())] = buffer.raw()
            buffers.append(memoryview(room)[offset : offset + len(buffer.raw())])
        return pickle.loads(data, buffers=buffers)

    times, spools = [0.0, 0.02, 0.05], [0.0, 2e-3, 1e-3]
    assert not sent(times).flags.aligned
    plain = hc.simulate(PLAN, commands={"test": hc.Command(times, spools)}, duration=0.1)
    command = hc.Command(times, spools)
    for name in ("time", "spool"):
        object.__setattr__(command, name, sent(getattr(command, name)))
    odd = hc.simulate(PLAN, commands={"test": command}, duration=0.1)
    assert odd.columns["tip.x"].values.tobytes() == plain.columns["tip.x"].values.tobytes()
    one, two = hc.BatchSimulator("single-cylinder", 3), hc.BatchSimulator("single-cylinder", 3)
    places, spools = np.array([[0.0], [0.01], [0.02]]), np.array([[1e-3], [2e-3], [0.0]])
    one.reset(q=places)
    two.reset(q=sent(places))
    assert one.step(spools).q.tobytes() == two.step(sent(spools)).q.tobytes()
