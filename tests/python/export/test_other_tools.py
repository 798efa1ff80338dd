"""FMUs in tools other than FMPy, where these are installed, and the speed of a step."""

from __future__ import annotations

import statistics
import time

import numpy as np
import pytest
from fmu_in_fmpy import STEP, Unit, inputs

import hydrocrane as hc

pytestmark = pytest.mark.evidence


def test_the_open_simulation_platform_loads_and_steps_an_fmu(tmp_path):
    """libcosim, by its Python package; not a dependency of the tests."""
    package = pytest.importorskip("libcosimpy.CosimExecution", reason="libcosimpy is not installed")
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    crane = hc.load_machine("rottne-f9-lab")
    file = hc.export_fmu(crane, tmp_path / "crane.fmu")
    execution = package.CosimExecution.from_step_size(step_size=int(STEP * 1e9))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=str(file), instance_name="crane"))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer=observer)
    execution.add_manipulator(manipulator=manipulator)
    variables = {v.name.decode(): v.reference for v in execution.slave_variables(slave_index=index)}
    u = [0.02, -0.01, 0.01]
    commanded = [variables[name] for name in inputs(crane)]
    manipulator.slave_real_values(slave_index=index, variable_references=commanded, values=u)
    native = hc.Simulator(crane, STEP)
    obs = native.reset(q=crane.home)
    for _ in range(200):
        execution.step()
        obs = native.step(u)
    names = [f"joint.{joint}.q" for joint in crane.joint_names]
    read = observer.last_real_values(slave_index=index, variable_references=[variables[name] for name in names])
    assert np.abs(np.array(read) - obs.q).max() < 1e-12


def test_a_step_of_co_simulation_takes_no_more_than_twice_a_native_one(tmp_path):
    """Steps of 1 ms, in turn, by the same interpreter; the medians of ten rounds are compared."""
    crane = hc.load_machine("rottne-f9-lab")
    unit = Unit(hc.export_fmu(crane, tmp_path / "crane.fmu"), tmp_path / "unzipped").begin()
    native = hc.Simulator(crane, STEP)
    native.reset(q=crane.home)
    u = np.array([0.01, -0.005, 0.004])
    unit.set(dict(zip(inputs(crane), u, strict=True)))
    do, component = unit.fmu.fmi2DoStep, unit.fmu.component
    took: dict[str, list[float]] = {"native": [], "fmu": []}
    steps = 100
    for i in range(10):
        began = time.perf_counter()
        for _ in range(steps):
            native.step(u)
        between = time.perf_counter()
        for k in range(steps):
            do(component, (i * steps + k) * STEP, STEP, 1)
        took["native"].append(between - began)
        took["fmu"].append(time.perf_counter() - between)
    assert unit.get(["time"])[0] == pytest.approx(native.time)
    assert unit.get(crane.state_names).tobytes() == native.state.tobytes()
    ratio = statistics.median(took["fmu"]) / statistics.median(took["native"])
    print(f"co-simulation / native at 1 ms: {ratio:.2f}, native {1e6 * min(took['native']) / steps:.1f} us")
    assert ratio < 2.0
    unit.close()
