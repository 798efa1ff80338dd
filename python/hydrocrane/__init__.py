"""Model, simulate and look at hydraulically driven cranes.

Three lines give a run, its charts and its animation::

    import hydrocrane as hc
    run = hc.simulate("vertical-lift-open-loop")
    run.plot(), run.animate("lift.gif")

Everything is SI and radians inside; pictures show degrees, millimetres and bar.
Names are looked up on first use, so that ``import hydrocrane`` itself costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hydrocrane import plots, rig
    from hydrocrane.batch import BatchObservation, BatchSimulator
    from hydrocrane.capacity import LoadChart, load_chart
    from hydrocrane.citation import cite
    from hydrocrane.compare import Comparison
    from hydrocrane.controllers import Controller, Observation, SensorFault
    from hydrocrane.errors import (
        HydrocraneError,
        InputError,
        MachineFileError,
        OutOfReachError,
        ResultFileError,
        SimulationError,
    )
    from hydrocrane.identification import Identification, identify_friction
    from hydrocrane.joystick import Joystick, Stick
    from hydrocrane.linear import Modes, mode_map, modes
    from hydrocrane.logs import Log, read_log
    from hydrocrane.machine import Machine, Value, bundled_machines, load_machine
    from hydrocrane.payload import PayloadChange
    from hydrocrane.phases import Phase
    from hydrocrane.result import Event, Outcome, Run, load_run
    from hydrocrane.scenario import Command, Scenario, Solver, bundled_scenarios, load_scenario
    from hydrocrane.sensitivity import Sensitivities, sensitivities
    from hydrocrane.simulation import simulate
    from hydrocrane.simulator import Simulator
    from hydrocrane.studies import Study, load_study, open_study, sweep

# Public name -> module that defines it.
_HOME = {
    "BatchObservation": "batch",
    "BatchSimulator": "batch",
    "Command": "scenario",
    "Comparison": "compare",
    "Controller": "controllers",
    "Event": "result",
    "HydrocraneError": "errors",
    "Identification": "identification",
    "InputError": "errors",
    "Joystick": "joystick",
    "LoadChart": "capacity",
    "Log": "logs",
    "Machine": "machine",
    "MachineFileError": "errors",
    "Modes": "linear",
    "Observation": "controllers",
    "OutOfReachError": "errors",
    "Outcome": "result",
    "PayloadChange": "payload",
    "Phase": "phases",
    "ResultFileError": "errors",
    "Run": "result",
    "Scenario": "scenario",
    "Sensitivities": "sensitivity",
    "SensorFault": "controllers",
    "SimulationError": "errors",
    "Simulator": "simulator",
    "Solver": "scenario",
    "Stick": "joystick",
    "Study": "studies",
    "Value": "machine",
    "bundled_machines": "machine",
    "bundled_scenarios": "scenario",
    "cite": "citation",
    "identify_friction": "identification",
    "load_chart": "capacity",
    "load_machine": "machine",
    "load_run": "result",
    "load_scenario": "scenario",
    "load_study": "studies",
    "mode_map": "linear",
    "modes": "linear",
    "open_study": "studies",
    "read_log": "logs",
    "sensitivities": "sensitivity",
    "simulate": "simulation",
    "sweep": "studies",
}

__all__ = [
    "BatchObservation",
    "BatchSimulator",
    "Command",
    "Comparison",
    "Controller",
    "Event",
    "HydrocraneError",
    "Identification",
    "InputError",
    "Joystick",
    "LoadChart",
    "Log",
    "Machine",
    "MachineFileError",
    "Modes",
    "Observation",
    "OutOfReachError",
    "Outcome",
    "PayloadChange",
    "Phase",
    "ResultFileError",
    "Run",
    "Scenario",
    "Sensitivities",
    "SensorFault",
    "SimulationError",
    "Simulator",
    "Solver",
    "Stick",
    "Study",
    "Value",
    "__version__",
    "bundled_machines",
    "bundled_scenarios",
    "cite",
    "identify_friction",
    "load_chart",
    "load_machine",
    "load_run",
    "load_scenario",
    "load_study",
    "mode_map",
    "modes",
    "open_study",
    "plots",
    "read_log",
    "sensitivities",
    "rig",
    "simulate",
    "sweep",
]


def __getattr__(name: str) -> Any:
    """Import the module that holds a public name when the name is first used (PEP 562)."""
    if name == "__version__":
        from importlib.metadata import version

        value: Any = version("hydrocrane")
    elif name in ("plots", "rig"):
        value = importlib.import_module(f"hydrocrane.{name}")
    elif name in _HOME:
        value = getattr(importlib.import_module(f"hydrocrane.{_HOME[name]}"), name)
    else:
        raise AttributeError(f"module 'hydrocrane' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
