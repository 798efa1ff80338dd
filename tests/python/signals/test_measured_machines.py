"""The page of measured machines: its balances, on files made here in the format of the measured ones."""

from __future__ import annotations

import gzip
import runpy
from pathlib import Path

import numpy as np
import pytest

from hydrocrane.identification import fit_static

SCRIPT = Path(__file__).resolve().parents[3] / "docs/validation/measured.py"
INCH, POUND, PSI = 0.0254, 0.45359237 * 9.80665, 0.45359237 * 9.80665 / 0.0254**2


@pytest.fixture(scope="module")
def script():
    """What the script defines; it finds the other one of its folder where it is run as one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(SCRIPT.parent))
        return runpy.run_path(str(SCRIPT))


def test_a_folder_without_the_files_says_so(script, tmp_path, capsys):
    with pytest.raises(SystemExit):
        script["main"](["--data", str(tmp_path)])
    text = capsys.readouterr().err
    assert script["WEC"] in text and "says where each file can be had" in text


def written(path, names, columns, delimiter):
    rows = [delimiter.join(names)] + [delimiter.join(f"{v:.8g}" for v in row) for row in zip(*columns)]
    path.write_bytes(gzip.compress("\n".join(rows).encode()))


def test_friction_of_the_wave_energy_converter(script, tmp_path):
    """300 N + 2 kN s/m of known friction come out of position, pressures and pull, in their units and signs."""
    rng = np.random.default_rng(0)
    speeds = [*(0.05, -0.05, 0.1, -0.1) * 3, 0.3, -0.3]
    v = np.concatenate([part for s in speeds for part in (np.zeros(100), np.full(int(50 * 1.0 / abs(s)), s))])
    time = np.arange(v.size) / 50.0
    x = 0.1 + np.cumsum(v) / 50.0
    friction = np.sign(v) * 300.0 + 2000.0 * v
    lower, upper = 9.5e5 + 2e5 * x, 6e5 - 1.5e5 * x
    oil = 4e6 + 2e6 * v
    pull = lower * 0.0115 - upper * 0.0127 + oil * 1.375 * INCH**2 + friction
    columns = (
        time, x / INCH, oil / PSI, 0.0 * time, lower / PSI, upper / PSI,
        (pull + rng.normal(0, 5.0, v.size)) / POUND,
    )  # fmt: skip
    names = (
        "#time(s)", "Pos(in)", "LowerHydPress(psig)", "UpperHydPress(psig)", "LowerSpringPressure(psia)",
        "UpperSpringPressure(psia)", "TestMachineForce(lbs)",
    )  # fmt: skip
    written(tmp_path / script["WEC"], names, columns, " ")
    log, read = script["wec_log"](tmp_path)
    np.testing.assert_allclose(read, columns[-1] * POUND, rtol=1e-6)
    windows = script["wec_windows"](log)
    assert len(windows) == len(speeds)
    for window in windows:
        wanted = np.sign(window.velocity) * 300.0 + 2000.0 * window.velocity
        assert window.force == pytest.approx(wanted, abs=max(4 * window.force_error, 3.0))
    fit = fit_static(script["FrictionPoints"].from_windows(windows), exponents=script["LINEAR"])
    judged = script["wec_judged"](log, read, fit)
    within, beyond = (judged[f"held speeds, {which}"] for which in ("within those of the fit", "beyond them"))
    assert np.abs(within.speed).max() > 0.25 and within.rms < 20.0 and beyond.speed.size == 0
    first = fit_static(script["FrictionPoints"].from_windows(windows[:12]), exponents=script["LINEAR"])
    beyond = script["wec_judged"](log, read, first)["held speeds, beyond them"]
    assert beyond.speed.size > 100 and beyond.rms < 40.0


def test_friction_of_the_servo_cylinder(script, tmp_path):
    """Two runs with clocks of their own, put side by side by the opening of the valve."""
    rng = np.random.default_rng(1)
    piston, annulus = np.pi / 4 * 0.016**2, np.pi / 4 * (0.016**2 - 0.010**2)
    for volts in script["VOLTS"]:
        for side, delay in (("A", 0.2), ("B", 0.5)):
            time = np.arange(4000) / 1000.0
            opened = (time >= delay) & (time < delay + 3.0)
            v = 0.01 * volts * opened
            p_b = 10e5 + 0.0 * v
            p_a = (np.sign(v) * 50.0 + 60.0 * v + p_b * annulus) / piston
            pressure = (p_a if side == "A" else p_b) / 1e5 / 10.0 + rng.normal(0, 1e-3, v.size)
            position = np.cumsum(v) / 1000.0 / 0.02 + rng.normal(0, 1e-3, v.size)
            path = tmp_path / script["SERVO"].format(side=side, volts=volts, sample=1)
            written(
                path, ("t_s", "position_V", "pressure_V", "valve_V"), (time, position, pressure, volts * opened), ","
            )
    points = script["servo_points"](tmp_path, 1)
    assert len(points) == 4
    for velocity, force, error in zip(points.velocity, points.force, points.force_error):
        assert force == pytest.approx(50.0 + 60.0 * velocity, abs=max(4 * error, 0.3))


@pytest.fixture(scope="module")
def pvg32():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(SCRIPT.parent))
        return runpy.run_path(str(SCRIPT.with_name("measured_pvg32.py")))


def test_a_log_crane_moves_as_fast_as_its_compensated_section_lets_it(pvg32, tmp_path):
    """A made log in the format of the cycle: voltages each way give the flows of the data sheet, whatever the load."""
    time = np.arange(0.0, 9.0, 0.02)
    volts = np.interp(time, [0.5, 1.5, 4.0, 4.5, 5.0, 6.0, 9.0], [5.8, 5.0, 5.0, 5.8, 5.8, 6.4, 6.4])
    still = np.ones_like(time)
    columns = {
        "t_s": time, "s1_position_meas_mm": 1000.0 * still, "s2_position_meas_mm": 1281.0 * still,
        "U1_control_meas_V": volts, "U2_control_meas_V": 5.8 * still, "pP_pressure_meas_Pa": 92e5 * still,
    } | {f"{p}_pressure_meas_Pa": 1e6 * still for p in ("p1", "p2", "p3", "p4")}  # fmt: skip
    rows = "\n".join(",".join(f"{v:.9g}" for v in row) for row in zip(*columns.values()))
    (tmp_path / pvg32["patu"].CYCLE).write_text(",".join(columns) + "\n" + rows + "\n", encoding="utf-8")
    log = pvg32["cycle"](tmp_path)
    c = pvg32["compared"](log, pvg32["simulated"](log))
    full, overlap = 40e-3 / 60, 0.8

    def flow(volts_from_neutral):
        return full * (volts_from_neutral / 3 * 7 - overlap) / (7 - overlap)

    up, down = (pvg32["speed"](c.time, c.run["s1"], window) * 1e-3 for window in ((2.5, 4.0), (7.5, 9.0)))
    area, annulus = np.pi / 4 * 0.1**2, np.pi / 4 * (0.1**2 - 0.056**2)
    assert up == pytest.approx(flow(0.8) / area, rel=0.01)
    # The load pushes, and the wide edge to the tank lets it run ahead of its feed: no slower than that.
    assert down < -0.99 * flow(0.6) / annulus
    with pytest.raises(SystemExit):
        pvg32["main"](["--data", str(tmp_path / "nothing")])
