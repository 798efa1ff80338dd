"""What is done with a damaged file: read it, and use it for an instant. Run in a process of its own."""

from __future__ import annotations

import contextlib
import random
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

import elsewhere
import numpy as np
from mutate import damaged_table, damaged_toml

import hydrocrane as hc
from hydrocrane.errors import HydrocraneError

ROOT = Path(__file__).resolve().parents[2]
# A message longer than this is none for people.
LONGEST_MESSAGE = 4000
# Cases of a study that are run, and samples of a log that signals are computed from.
CASES = 2

MAPPING = """
[time]
sample-rate = "200 Hz"

[signal.x]
column = "Length_3"
unit = "mm"
sign = -1
offset = "625 mm"

[signal.p1]
column = "P_top"
unit = "bar"

[signal.p2]
column = 3
unit = "40 bar"
"""

STUDY = """
[study]
scenario = "single-cylinder-step"
measures = ["end(tip.z)", "tip_way"]
signals = ["tip.z"]
resample = "50 ms"

[keys]
payload.mass = ["50 kg", "80 kg"]
"supply.pressure" = { low = "100 bar", high = "140 bar", count = 2 }

[overrides]
"cylinder.test.bore" = "65 mm"
"""

DRAWN = """
[study]
scenario = "single-cylinder-step"
method = "latin"
n = 4
seed = 3
measures = ["largest_pressure", "pump_energy"]
ledger = true

[keys]
"payload.mass" = { low = "10 kg", high = "100 kg", log = true }
"friction.test.coulomb" = { distribution = "norm", loc = 170.0, scale = 5.0 }
"""


def table(samples: int = 60) -> str:
    """A log as a logger writes it."""
    rows = [f"{625 - 1e3 * np.sin(0.01 * i):.4f};{90 + i % 7:.3f};{12.5 + 0.1 * i:.3f}" for i in range(samples)]
    return "Length_3;P_top;P_bottom\nmm;bar;bar\n" + "\n".join(rows) + "\n"


def own_table(samples: int = 60) -> str:
    """A log as this package writes it."""
    rows = [f"{0.01 * i:.3f},{0.1 * np.sin(0.1 * i):.6f},{9e6 + i},{1.2e6 - i}" for i in range(samples)]
    return '# payload = 20\n# experiment = "ramp"\ntime,x,p1,p2\ns,m,Pa,Pa\n' + "\n".join(rows) + "\n"


def scenarios() -> list[str]:
    return [path.read_text(encoding="utf-8") for path in sorted((ROOT / "scenarios").glob("*.toml"))]


def studies() -> list[str]:
    kept = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "scenarios/studies").glob("*.toml"))]
    return [STUDY, DRAWN, *kept]


def content(kind: str, seed: int, number: int) -> str:
    """The damaged file `number` of a kind under `seed`."""
    draws = random.Random(f"{seed} {kind} {number}")
    if kind in MADE:
        made = MADE[kind](draws)
        return made if isinstance(made, str) else made.decode(errors="surrogateescape")
    if kind == "mapping":
        return damaged_toml(draws, MAPPING, [STUDY, DRAWN])
    if kind == "study":
        return damaged_toml(draws, draws.choice(studies()), [MAPPING, *studies()])
    if kind == "scenario":
        return damaged_toml(draws, draws.choice(scenarios()), scenarios())
    return damaged_table(draws, draws.choice([table(), own_table()]), [table(), own_table()])


def exercise(kind: str, text: str) -> str:
    """Try a text; "refused" or "ran". Any exception is a fault: an AssertionError, or one that is not the package's."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / NAMES.get(kind, f"{kind}.toml")
        path.write_bytes(text.encode(errors="surrogateescape"))
        try:
            KINDS[kind](path, Path(folder))
        except HydrocraneError as error:
            message = str(error).strip()
            assert message, "an error without a message"
            assert len(message) <= LONGEST_MESSAGE, f"a message of {len(message)} letters: {message[:80]}"
            return "refused"
    return "ran"


def _mapping(path: Path, folder: Path) -> None:
    log = folder / "log.csv"
    log.write_text(table(), encoding="utf-8")
    _used(hc.read_log(log, path))


def _log(path: Path, _: Path) -> None:
    mapping = {
        "time": {"sample-rate": "200 Hz"},
        "signal": {"x": {"column": "Length_3", "unit": "mm"}, "p1": {"column": 2}, "p2": {"column": 3}},
    }
    with contextlib.suppress(HydrocraneError):
        hc.read_log(path, mapping)
    _used(hc.read_log(path))


def _used(log: hc.Log) -> None:
    assert log.summary()
    time = log.data["time"].values
    assert log.fatal or np.isfinite(time).all(), "times are not finite in a log without a fatal flag"
    log.save(Path(log.source).with_name("again.csv"))


def _study(path: Path, folder: Path) -> None:
    file = hc.load_study(path)
    cases = file.study.cases
    total = int(np.prod(cases.shape))
    assert total <= 10_000_000, f"{total} cases without a word"
    assert file.study.job
    if total <= CASES * 8 and file.study.plan.duration <= 60:
        done = file.study.run(folder / "store.zarr", workers=1, progress=False)
        completed = (done["outcome"].values == 0) if done["outcome"].dtype.kind in "iu" else None
        assert completed is None or completed.size == total


def _scenario(path: Path, _: Path) -> None:
    run = hc.simulate(path)
    if run.outcome.kind == "completed":
        for name, values in run.data.items():
            numbers = values.values
            # Without a set-point there is no place for it; a limit that does not hold has no distance.
            if numbers.dtype.kind == "f" and str(name).split(".")[0] not in (
                "set_point",
                "wanted",
                "sensor",
                "clearance",
            ):
                assert np.isfinite(numbers).all(), f"{name} is not finite in a completed run"
    assert run.summary()


KINDS: dict[str, Callable[[Path, Path], None]] = {
    "study": _study, "mapping": _mapping, "log": _log, "scenario": _scenario,
    "hdf5": elsewhere.read_hdf5, "matlab": elsewhere.same_bytes_of, "packed": elsewhere.same_bytes_of,
    "run": elsewhere.read_run, "store": elsewhere.read_store, "line": elsewhere.read_line, "fmi": elsewhere.make_calls,
}  # fmt: skip
# What makes an input that is no damaged text, and the name that a file has for its reader.
MADE: dict[str, Callable[[random.Random], str | bytes]] = {
    "hdf5": elsewhere.hdf5, "matlab": elsewhere.matlab, "packed": elsewhere.packed, "run": elsewhere.run,
    "store": elsewhere.store, "line": elsewhere.line, "fmi": elsewhere.calls,
}  # fmt: skip
NAMES = {"log": "log.csv", "hdf5": "log.h5", "matlab": "log.mat", "packed": "log.csv.gz", "run": "run.nc"}
