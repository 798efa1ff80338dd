"""A main for the exported C that compares one state with the core."""

from __future__ import annotations

import numpy as np

from hydrocrane.export.tape import Tape, wrapped
from hydrocrane.machine.machine import Machine

# Joint rates of the state, rad/s or m/s, and its pressures as a share of the supply's.
_RATE = 0.1
_SHARE = 0.4
_MAIN = """
#if defined HYDROCRANE_TEST && !defined HYDROCRANE_DECLARATIONS
#include <stdio.h>

int main(void)
{{
    const double x[] = {{{x}}};
    const double u[] = {{{u}}};
    const double expected[] = {{{dx}}};
    double dx[HYDROCRANE_STATES], worst = 0.0;
    if (hydrocrane_derivative(x, u, 0, dx))
        return 1;
    for (int i = 0; i < HYDROCRANE_STATES; i++) {{
        const double off = fabs(dx[i] - expected[i]) / (1.0 + fabs(expected[i]));
        worst = off > worst ? off : worst;
    }}
    printf("largest relative difference from hydrocrane: %.1e\\n", worst);
    return worst > 1e-9;
}}
#endif
"""


def self_test(machine: Machine, tape: Tape) -> str:
    """Under ``HYDROCRANE_TEST``: exit status 0 if the derivative is the core's."""
    state = np.zeros(len(tape.states))
    q = iter(machine.home.tolist())
    for i, (name, unit, _) in enumerate(tape.states):
        if name.endswith(".q"):
            state[i] = next(q)
        elif name.endswith(".qd"):
            state[i] = _RATE
        elif unit == "Pa":
            state[i] = _SHARE * machine.supply_pressure
        elif unit == "1":
            state[i] = _SHARE
    command = _SHARE * machine.core.spool_strokes
    lists = {"x": state, "u": command, "dx": machine.state_derivative(state, command)}
    return _MAIN.format(**{name: wrapped([*map(repr, values.tolist())], " " * 8) for name, values in lists.items()})
