"""Models exported to C against the core."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from exported_model import COMPILER, STATES, STRICT, CModel, exportable, needs_compiler, off

import hydrocrane as hc
from hydrocrane.errors import HydrocraneError, InputError

PAGE = Path(__file__).resolve().parents[3] / "docs/howto/model-in-c.md"
MACHINES = hc.bundled_machines()
SLOW = [
    name if name in ("rottne-f9-lab", "rottne-f9-mobile") else pytest.param(name, marks=pytest.mark.evidence)
    for name in MACHINES
]


def jacobian_places(model: CModel, n: int) -> tuple[np.ndarray, np.ndarray]:
    starts = model.integers("hydrocrane_columns", n + 1)
    rows = model.integers("hydrocrane_rows", starts[-1])
    return rows, np.repeat(np.arange(n), np.diff(starts))


@needs_compiler
@pytest.mark.parametrize("name", SLOW)
def test_c_has_the_bits_of_the_core(name, random_states, tmp_path):
    crane = exportable(name)
    model = CModel(hc.export_model(crane, tmp_path / "crane.c", parameters=[]))
    x, u = random_states(crane, STATES, 3)
    n = len(crane.state_names)
    expected = crane.state_derivative(x, u)
    (dx,) = model.call("hydrocrane_derivative", x, u, None, n)
    # Mains sum what cylinders draw in another order where these are in groups.
    same = np.array([state != "mains.p" for state in crane.state_names])
    assert np.array_equal(dx[:, same], expected[:, same])
    assert np.allclose(dx, expected, rtol=1e-12, atol=0.0)
    _, dense = model.call("hydrocrane_linearise", x, u, None, n, n * n)
    dense = dense.reshape(-1, n, n)
    assert off(crane, dense, crane.jacobian(x, u)) < 1e-12
    rows, columns = jacobian_places(model, n)
    rates, values = model.call("hydrocrane_sparse", x, u, None, n, len(rows))
    assert np.array_equal(rates, dx) and np.array_equal(dense[:, rows, columns], values)
    dense[:, rows, columns] = 0.0
    assert not dense.any()
    names = [o for o, _, _ in crane.core.output_info if not o.startswith("energy.")]
    (y,) = model.call("hydrocrane_outputs", x, u, None, len(names))
    outputs = crane.outputs(x, u)
    for k, output in enumerate(names):
        assert np.allclose(y[:, k], outputs[output], rtol=1e-11, atol=1e-12 * np.abs(outputs[output]).max()), output
    assert model.texts("hydrocrane_states", n) == list(crane.state_names)
    assert model.texts("hydrocrane_output_names", len(names)) == names


@needs_compiler
def test_parameters_are_those_of_a_machine_with_other_values(random_states, tmp_path):
    crane = hc.load_machine("rottne-f9-mobile")
    model = CModel(hc.export_model(crane, tmp_path / "crane.c"))
    count = int(re.search(r"PARAMETERS (\d+)", (tmp_path / "crane.c").read_text())[1])
    keys = model.texts("hydrocrane_parameters", count)
    assert keys[-1] == "payload.mass" and "supply.pressure" in keys and "pump.lift.speed" not in keys
    x, u = random_states(crane, STATES, 3)
    p = np.array([crane.payload() if key == "payload.mass" else np.nan for key in keys])
    for i, key in enumerate(keys[:-1]):
        own, _, side = key.partition("[")
        p[i] = np.atleast_1d(crane.value(own).si)[int(side[0]) if side else 0]
    n = len(crane.state_names)
    (given,) = model.call("hydrocrane_derivative", x, u, p, n)
    (of_file,) = model.call("hydrocrane_derivative", x, u, None, n)
    assert np.array_equal(given, of_file)
    other = crane.changed({**crane.overrides_at(keys[:-1], 1.02 * p[:-1]), "payload.mass": 70.0})
    (moved,) = model.call("hydrocrane_derivative", x, u, np.append(1.02 * p[:-1], 70.0), n)
    assert np.allclose(moved, other.state_derivative(x, u), rtol=1e-11, atol=1e-9)
    assert not np.allclose(moved, of_file, rtol=1e-4)


@needs_compiler
def test_the_platforms_functions_differ_by_rounding_and_the_file_tests_itself(random_states, tmp_path):
    crane = hc.load_machine("rottne-f9-lab")
    file = hc.export_model(crane, tmp_path / "crane.c")
    model = CModel(file, "-DHYDROCRANE_LIBM")
    x, u = random_states(crane, STATES, 3)
    n = len(crane.state_names)
    (dx,) = model.call("hydrocrane_derivative", x, u, None, n)
    expected = crane.state_derivative(x, u)
    assert np.allclose(dx, expected, rtol=1e-9, atol=0) and (np.abs(dx - expected) / np.abs(expected)).mean() < 1e-14
    program = tmp_path / "test"
    options = [*STRICT, "-DHYDROCRANE_TEST", str(file), "-o", str(program), "-lm"]
    subprocess.run([str(COMPILER), *options], check=True)
    told = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    assert float(told.rpartition(" ")[2]) == 0.0
    wrong = file.read_text().replace("const double expected[] = {0.1", "const double expected[] = {0.2")
    (tmp_path / "wrong.c").write_text(wrong)
    options[options.index(str(file))] = str(tmp_path / "wrong.c")
    subprocess.run([str(COMPILER), *options], check=True)
    assert subprocess.run([str(program)], capture_output=True).returncode == 1


@needs_compiler
def test_the_file_can_be_included_for_its_declarations_and_compiled_as_cpp(tmp_path):
    file = hc.export_model("single-cylinder", tmp_path / "crane.c", derivatives=False, outputs=["tip.x"])
    assert "hydrocrane_linearise(" not in file.read_text().split("#define")[1]
    user = (
        '#define HYDROCRANE_DECLARATIONS\n#include "crane.c"\n'
        "int (*f)(const double*, const double*, const double*, double*) = hydrocrane_derivative;\n"
    )
    for suffix in ("c", "cpp"):
        (tmp_path / f"user.{suffix}").write_text(user)
        command = [str(COMPILER), "-c", str(tmp_path / f"user.{suffix}"), "-o", str(tmp_path / "user.o")]
        subprocess.run(command, check=True)
    subprocess.run([str(COMPILER), "-x", "c++", "-c", str(file), "-o", str(tmp_path / "crane.o")], check=True)


@needs_compiler
def test_the_loop_of_the_page_moves_as_the_simulator_does(tmp_path):
    blocks = re.findall(r"```c\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (loop,) = [text for text in blocks if "int main" in text]
    (tmp_path / "loop.c").write_text(loop, encoding="utf-8")
    crane = hc.load_machine("rottne-f9-lab")
    hc.export_model(crane, tmp_path / "crane.c", outputs=["tip.x", "tip.z"])
    np.savetxt(tmp_path / "start.txt", crane.equilibrium(crane.home))
    subprocess.run([str(COMPILER), *STRICT, "-O2", "loop.c", "crane.c", "-o", "loop", "-lm"], check=True, cwd=tmp_path)
    told = subprocess.run([str(tmp_path / "loop")], capture_output=True, text=True, check=True, cwd=tmp_path).stdout
    t, x, z = np.array([line.split() for line in told.splitlines()], dtype=float).T
    home = dict(zip(crane.joint_names, crane.home, strict=True))
    plan = hc.Scenario(machine=crane, joints=home, commands={"lift": 0.01}, duration=1.0)
    columns = hc.simulate(plan, method="rodas5p", rtol=1e-9).columns
    assert np.allclose(columns["time"].values, t) and np.ptp(z) > 0.02
    assert max(np.abs(columns[f"tip.{axis}"].values - own).max() for axis, own in zip("xz", (x, z))) < 1e-10


@needs_compiler
def test_the_same_machine_gives_the_same_bytes(tmp_path):
    hc.export_model("rottne-f9-ls", tmp_path / "none.c", parameters=[], outputs=[])
    assert CModel(tmp_path / "none.c").texts("hydrocrane_output_names", 0) == []
    first, second = (hc.export_model("rottne-f9-ls", tmp_path / f"{k}.c").read_bytes() for k in "ab")
    assert first == second


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"path": "crane.c", "to": "julia"}, ["julia", "did you mean"]),
        ({"path": "crane.h"}, [".c", "crane.h"]),
        ({"path": "2d.m", "to": "matlab"}, ["2d", "MATLAB"]),
        ({"path": "crane.c", "parameters": ["friction.lift.colomb"]}, ["did you mean `friction.lift.coulomb`?"]),
        ({"path": "crane.c", "parameters": ["nonsense"]}, ["nonsense", "supply"]),
        ({"path": "crane.c", "parameters": [3]}, ["parameters", "3"]),
        ({"path": "crane.c", "parameters": 3}, ["list of names", "[3]"]),
        ({"path": "crane.c", "derivatives": "no"}, ["derivatives", "True or False", "'no'"]),
        ({"path": "crane.c", "outputs": "tip.x"}, ["outputs", "['tip.x']"]),
        ({"path": "crane.c", "parameters": "supply"}, ["['supply']"]),
        ({"path": "crane.c", "parameters": ["supply", "sensor"]}, ["`sensor`", "leave it out"]),
        ({"path": "crane.c", "outputs": ["tip.y"]}, ["tip.y", "tip.x"]),
        ({"path": "crane.c", "outputs": ["energy.oil"]}, ["energy.oil", "table"]),
        ({"path": "crane.c", "machine": "heinze-2007"}, ["friction", "jumps", "smoothing-velocity"]),
    ],
)
def test_bad_input_is_one_clear_error_and_writes_nothing(arguments, words, tmp_path):
    given = {"machine": "rottne-f9-lab", **arguments}
    with pytest.raises(InputError) as error:
        hc.export_model(given.pop("machine"), tmp_path / given.pop("path"), **given)
    assert all(word in str(error.value) for word in words), str(error.value)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(HydrocraneError, match="file"):
        hc.export_model("single-cylinder", tmp_path / "file" / "crane.c")
