"""Exported right-hand sides in C beside CasADi's code of the same models, and the product's."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import hydrocrane as hc
from benches.competitors.casadi_cvodes import arrays
from benches.measures.laws import compiled
from benches.models import crane as independent
from benches.problem import NotAvailable, Problem

MACHINES = ("rottne-f9-lab", "hiab-xs031", "rottne-f9-mobile")
FLAGS = ("-O3", "-march=native", "-std=c99", "-D_POSIX_C_SOURCE=199309L")
ROUNDS = 9
CALLS = 100_000
# A state near rest, moving; every call changes one number, so that no call can be left out.
DRIVER = """
#include <stdio.h>
#include <time.h>

int main(void)
{{
    double x[] = {{{x}}}, u[] = {{{u}}}, out[{room}], more[{room}], sum = 0.0;
    const double first = x[0];
    struct timespec began, ended;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &began);
    for (int i = 0; i < {calls}; i++) {{
        x[0] = first + 1e-9 * i;
        {call}
        sum += out[1] + more[0];
    }}
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &ended);
    printf("%.6f %g\\n", ((ended.tv_sec - began.tv_sec) * 1e9 + (ended.tv_nsec - began.tv_nsec)) / {calls}, sum);
}}
"""
EXPORTED = {
    "rhs": "hydrocrane_derivative(x, u, 0, out); more[0] = 0.0;",
    "slopes": "hydrocrane_sparse(x, u, 0, out, more);",
}
CASADI = {
    "rhs": "const double *arg[] = {x, u, 0}; double *res[] = {out, 0}; more[0] = 0.0; derivative(arg, res, iw, w, 0);",
    "slopes": "const double *arg[] = {x, u, 0}; double *res[] = {out, more}; linearise(arg, res, iw, w, 0);",
}


def measure(problem: Problem) -> dict[str, Any]:
    """CPU time per call, ns, and the median ratios of pairs of runs, by machine and program."""
    compiler = c_compiler()
    if importlib.util.find_spec("casadi") is None:
        raise NotAvailable("casadi is not installed")
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in MACHINES:
            machine = hc.load_machine(name)
            programs = _programs(machine, Path(folder), compiler)
            rounds = [{program: run() for program, run in programs.items()} for _ in range(ROUNDS)]
            found[name] = {
                program: {
                    "ns": min(row[program] for row in rounds),
                    "ratio": median(row[program] / row[f"export, libm: {program.split(': ')[1]}"] for row in rounds),
                }
                for program in programs
            }
    states = np.ascontiguousarray(np.tile(problem.integrate("rodas5p", 1e-6)["states"], (10, 1)))
    return {"machines": found, "product": compiled(problem, states)}


def c_compiler() -> str:
    """A compiler that takes FLAGS."""
    compiler = next((name for name in ("gcc", "clang", "cc") if shutil.which(name)), None)
    if compiler is None:
        raise NotAvailable("there is no C compiler")
    return compiler


def exports(machine: hc.Machine, folder: Path, compiler: str, call: str) -> dict[str, Callable[[], float]]:
    """Programs that print the time of a call of the export, by whose elementary functions they take."""
    source = hc.export_model(machine, folder / f"{machine.name}.c", parameters=[], outputs=[])
    own = source.read_text(encoding="utf-8") + _driver(machine, call)
    functions = {"libm": ["-DHYDROCRANE_LIBM"], "own functions": ["-ffp-contract=off"]}
    return {who: _program(own, folder, [compiler, *FLAGS, *flags]) for who, flags in functions.items()}


def _programs(machine: hc.Machine, folder: Path, compiler: str) -> dict[str, Callable[[], float]]:
    """Programs that print the time of a call, by what they call: `who: what`."""
    codes = {"CasADi, same model": _casadi(machine.casadi(parameters=[], outputs=[]), folder)}
    if machine.name == "rottne-f9-lab":
        codes["CasADi, independent model"] = _casadi(_independent(machine), folder)
    programs = {}
    for what, call in EXPORTED.items():
        for who, program in exports(machine, folder, compiler, call).items():
            programs[f"export, {who}: {what}"] = program
        for who, code in codes.items():
            text = code + _driver(machine, f"static casadi_int iw[100000]; static double w[100000]; {CASADI[what]}")
            programs[f"{who}: {what}"] = _program(text, folder, [compiler, *FLAGS])
    return programs


def _driver(machine: hc.Machine, call: str) -> str:
    x = np.zeros(len(machine.state_names))
    x[: len(machine.joint_names)] = machine.home
    for i, (name, unit) in enumerate(zip(machine.state_names, machine.state_units, strict=True)):
        x[i] = {"Pa": 4e6, "1": 0.5}.get(unit, 0.02 if name.endswith(".qd") else x[i])
    u = 0.1 * machine.spool_strokes
    numbers = {name: ", ".join(map(repr, values.tolist())) for name, values in (("x", x), ("u", u))}
    return DRIVER.format(**numbers, room=x.size**2, calls=CALLS, call=call)


def _casadi(model: Any, folder: Path) -> str:
    """CasADi's C of the functions `derivative` and `linearise`."""
    import casadi as ca

    code = ca.CodeGenerator("casadi_model.c", {"with_header": False})
    code.add(model.derivative)
    code.add(model.linearise)
    return Path(code.generate(f"{folder}/")).read_text(encoding="utf-8")


def _independent(machine: hc.Machine) -> Any:
    """The model that a person wrote in CasADi's symbols, with the same two functions."""
    import casadi as ca

    class Model:
        x, u = ca.SX.sym("x", len(machine.state_names)), ca.SX.sym("u", independent.JOINTS)
        rate = independent.state_derivative(x, u, independent.parameters(machine), arrays())
        derivative = ca.Function("derivative", [x, u], [rate])
        linearise = ca.Function("linearise", [x, u], [rate, ca.jacobian(rate, x)])

    return Model


def _program(text: str, folder: Path, command: list[str]) -> Callable[[], float]:
    source = folder / f"program_{len(list(folder.iterdir()))}.c"
    source.write_text(text, encoding="utf-8")
    program = source.with_suffix(".bin")
    subprocess.run([*command, str(source), "-o", str(program), "-lm"], check=True, capture_output=True)

    def run() -> float:
        return float(subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout.split()[0])

    return run
