"""Models exported to Python's libraries, MATLAB and CUDA against the core."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import warnings

import models_on_a_gpu
import numpy as np
import pytest
from exported_model import COMPILER, STATES, agrees, exportable, module, needs_compiler, off

import hydrocrane as hc
from hydrocrane.errors import InputError

MACHINES = [
    name if name == "rottne-f9-mobile" else pytest.param(name, marks=pytest.mark.evidence)
    for name in hc.bundled_machines()
]
# The same where a large machine takes long.
QUICK = [
    name if name == "single-cylinder" else pytest.param(name, marks=pytest.mark.evidence)
    for name in hc.bundled_machines()
]


@pytest.mark.parametrize("name", MACHINES)
def test_numpy_over_any_axes(name, random_states, tmp_path):
    crane = exportable(name)
    model = module(hc.export_model(crane, tmp_path / "crane.py", to="numpy"))
    x, u = (rows.reshape(2, -1, rows.shape[-1]) for rows in random_states(crane, STATES, 3))
    expected = crane.state_derivative(x, u)
    dx, dfdx = model.linearise(x, u)
    assert np.array_equal(model.derivative(x, u), dx) and agrees(dx, expected)
    assert off(crane, dfdx, crane.jacobian(x, u)) < 1e-12
    assert np.array_equal(model.derivative(x[0, 0], u[0, 0], model.VALUES), dx[0, 0])
    assert crane.state_names == model.STATES
    outputs, y = crane.outputs(x, u), model.outputs(x, u)
    for k, output in enumerate(model.OUTPUTS):
        assert np.allclose(y[..., k], outputs[output], rtol=1e-11, atol=1e-12 * np.abs(outputs[output]).max()), output


@pytest.fixture(scope="module")
def casadi():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("casadi")


@pytest.mark.parametrize("name", MACHINES)
def test_casadi(name, casadi, random_states, tmp_path):
    crane = exportable(name)
    model = module(hc.export_model(crane, tmp_path / "crane.py", to="casadi"))
    x, u = random_states(crane, STATES, 3)
    dx, dfdx = model.linearise.map(STATES)(x.T, u.T, np.tile(model.VALUES, (STATES, 1)).T)
    n = x.shape[1]
    assert agrees(np.array(dx).T, crane.state_derivative(x, u))
    found = np.array(dfdx).reshape(n, STATES, n).transpose(1, 0, 2)
    assert off(crane, found, crane.jacobian(x, u)) < 1e-12
    y = np.array(model.outputs(x[0], u[0], model.VALUES)).ravel()
    assert np.allclose(y[model.OUTPUTS.index("tip.x")], crane.outputs(x, u)["tip.x"][0], rtol=1e-12)


def test_casadi_in_process_follows_a_parameter(casadi, random_states):
    crane = hc.load_machine("rottne-f9-lab")
    model = crane.casadi(parameters=["payload.mass"], outputs=["tip.z"])
    x, u = random_states(crane, STATES, 3)
    dx = np.array(model.derivative(x[0], u[0], [80.0])).ravel()
    assert model.OUTPUTS == ("tip.z",)
    assert agrees(dx[None], crane.state_derivative(x[:1], u[:1], payload=80.0))


def by_jax(folder, script, **arrays):
    """Arrays that a script makes of `arrays` in a process of its own: one that has imported JAX must not fork."""
    if importlib.util.find_spec("jax") is None:
        pytest.skip("no JAX here")
    np.savez(folder / "given.npz", **arrays)
    text = f"import jax, numpy as np\ngiven = np.load('given.npz')\n{script}\nnp.savez('found.npz', **found)\n"
    subprocess.run([sys.executable, "-c", text], check=True, cwd=folder)
    return np.load(folder / "found.npz")


@pytest.mark.parametrize("name", QUICK)
def test_jax_maps_compiles_and_derives(name, random_states, tmp_path):
    crane = exportable(name)
    file = hc.export_model(crane, tmp_path / "crane.py", to="jax", parameters=["payload.mass"])
    assert "import hydrocrane" not in file.read_text()
    x, u = random_states(crane, STATES, 3)
    # Compiled, a large machine takes a minute.
    both = "jax.jit(jax.vmap(crane.linearise))" if name == "single-cylinder" else "jax.vmap(crane.linearise)"
    script = f"import crane\ndx, dfdx = {both}(given['x'], given['u'])\nfound = dict(dx=dx, dfdx=dfdx)"
    found = by_jax(tmp_path, script, x=x, u=u)
    assert agrees(found["dx"], crane.state_derivative(x, u))
    assert off(crane, found["dfdx"], crane.jacobian(x, u)) < 1e-12


def test_jax_derives_by_a_parameter(random_states, tmp_path):
    crane = hc.load_machine("rottne-f9-lab")
    x, u = random_states(crane, STATES, 3)
    script = (
        "import hydrocrane as hc\n"
        "model = hc.load_machine('rottne-f9-lab').jax(parameters=['payload.mass'])\n"
        "rate = lambda p: model.derivative(given['x'], given['u'], p)[3]\n"
        "found = dict(slope=jax.grad(rate)(np.array([50.0])))"
    )
    slope = by_jax(tmp_path, script, x=x[0], u=u[0])["slope"]
    rates = [crane.state_derivative(x[0], u[0], payload=50.0 + h)[3] for h in (-1e-3, 1e-3)]
    assert np.isclose(float(slope[0]), (rates[1] - rates[0]) / 2e-3, rtol=1e-6)


def test_a_library_that_is_missing_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(InputError, match="pip install casadi"):
        hc.load_machine("single-cylinder").casadi()


@pytest.mark.parametrize("name", MACHINES)
def test_matlab(name, random_states, tmp_path):
    octave = shutil.which("octave-cli")
    if octave is None:
        pytest.skip("no Octave here")
    crane = exportable(name)
    hc.export_model(crane, tmp_path / "crane_model.m", to="matlab")
    x, u = random_states(crane, STATES, 3)
    for file, rows in (("x.txt", x), ("u.txt", u)):
        np.savetxt(tmp_path / file, rows, fmt="%.17g")
    script = (
        "x = load('x.txt'); u = load('u.txt'); f = [];"
        "for k = 1:rows(x) [dx, dfdx, y] = crane_model(x(k, :)', u(k, :)');"
        "f = [f; dx', reshape(dfdx', 1, []), y']; end;"
        "names = crane_model(); assert(numel(names.states) == columns(x));"
        "dlmwrite('found.txt', f, 'precision', '%.17g', 'delimiter', ' ');"
    )
    subprocess.run([octave, "--norc", "--quiet", "--eval", script], check=True, cwd=tmp_path)
    found, n = np.loadtxt(tmp_path / "found.txt"), x.shape[1]
    assert agrees(found[:, :n], crane.state_derivative(x, u))
    slopes = found[:, n : n + n * n].reshape(-1, n, n)
    assert off(crane, slopes, crane.jacobian(x, u)) < 1e-12
    assert np.isclose(found[0, n + n * n], crane.outputs(x, u)["tip.x"][0], rtol=1e-12)


# What a compiler of C++ needs to take CUDA's words.
SHIM = """\
#include <cstddef>
#include <cstdio>
#include <vector>
#define __device__
#define __global__
static struct { int x; } blockIdx, blockDim, threadIdx;
#include "crane.cu"
int main()
{
    const int cranes = %d, n = HYDROCRANE_STATES, m = HYDROCRANE_INPUTS;
    std::vector<double> x(cranes * n), u(cranes * m), dx(cranes * n), values(cranes * HYDROCRANE_NONZEROS);
    for (double &number : x) if (std::scanf("%%lf", &number) != 1) return 1;
    for (double &number : u) if (std::scanf("%%lf", &number) != 1) return 1;
    blockDim.x = 4;
    for (blockIdx.x = 0; blockIdx.x < cranes; blockIdx.x++)
        for (threadIdx.x = 0; threadIdx.x < 4; threadIdx.x++)
            hydrocrane_sparse_many(cranes, 1, x.data(), u.data(), nullptr, dx.data(), values.data());
    for (double number : dx) std::printf("%%.17g\\n", number);
    for (double number : values) std::printf("%%.17g\\n", number);
}
"""


@needs_compiler
@pytest.mark.parametrize("name", MACHINES)
def test_cuda_read_as_cpp(name, random_states, tmp_path):
    """No GPU here: the kernels are compiled as C++, and each thread runs in turn."""
    crane = exportable(name)
    text = hc.export_model(crane, tmp_path / "crane.cu", to="cuda").read_text()
    x, u = random_states(crane, STATES, 3)
    (tmp_path / "main.cpp").write_text(SHIM % STATES)
    command = [str(COMPILER), "-O1", str(tmp_path / "main.cpp"), "-o", str(tmp_path / "main"), "-lm", "-lstdc++"]
    subprocess.run(command, check=True)
    given = "\n".join(repr(float(v)) for v in [*x.T.ravel(), *u.T.ravel()])
    told = subprocess.run([str(tmp_path / "main")], input=given, capture_output=True, text=True, check=True).stdout
    numbers, n = np.array(told.split(), dtype=float), x.shape[1]
    assert agrees(numbers[: n * STATES].reshape(n, STATES).T, crane.state_derivative(x, u))
    dfdx = np.zeros((STATES, n, n))
    dfdx[:, *models_on_a_gpu.places(text)] = numbers[n * STATES :].reshape(-1, STATES).T
    assert off(crane, dfdx, crane.jacobian(x, u)) < 1e-12


@pytest.mark.skipif(models_on_a_gpu.gpu() is None, reason=models_on_a_gpu.MISSING)
@pytest.mark.parametrize("name", MACHINES)
def test_cuda_on_a_gpu(name, random_states):
    crane = exportable(name)
    x, u = random_states(crane, STATES, 3)
    cranes = models_on_a_gpu.OnGpu(crane)
    cranes.begin(x)
    cranes.evaluate(u)
    state, dx, values = cranes.read()
    assert np.array_equal(state, x) and agrees(dx, crane.state_derivative(x, u))
    dfdx = np.zeros((STATES, x.shape[1], x.shape[1]))
    dfdx[:, *cranes.places] = values
    assert off(crane, dfdx, crane.jacobian(x, u)) < 1e-12
