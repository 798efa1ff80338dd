"""Model, simulate and plot hydraulically driven cranes.

Three lines give a run, its charts and its animation::

    import hydrocrane as hc
    run = hc.simulate("vertical-lift-open-loop")
    run.plot(), run.animate("lift.gif")

Everything is SI and radians inside; pictures show degrees, millimetres and bar.
Modules are imported on first use of a name, so ``import hydrocrane`` itself is fast.
"""

from __future__ import annotations

import importlib

# Public name -> module that defines it; `__init__.pyi` says the same to type checkers.
_HOME = {
    "BatchObservation": "simulation.batch",
    "BatchSimulator": "simulation.batch",
    "Burst": "scenario.events",
    "Command": "scenario.series",
    "Comparison": "results.comparison",
    "Controller": "control.controllers",
    "Event": "results.record",
    "Fit": "identification",
    "Goal": "scenario.events",
    "HydrocraneError": "errors",
    "Identification": "identification",
    "InputError": "errors",
    "Joystick": "control.joystick",
    "LinearModel": "state_space.model",
    "LiveSimulator": "simulation.live",
    "LoadChart": "analysis.capacity",
    "Log": "logs",
    "Machine": "machine.machine",
    "MachineFileError": "errors",
    "Modes": "analysis.linear",
    "NamedController": "control.named",
    "Observation": "control.controllers",
    "OutOfReachError": "errors",
    "Outcome": "results.outcome",
    "PayloadChange": "scenario.payload",
    "Phase": "scenario.phases",
    "ResultFileError": "errors",
    "Run": "results.run",
    "Scenario": "scenario.scenario",
    "Sensitivities": "analysis.sensitivity",
    "SensorFault": "machine.sensors",
    "SimulationError": "errors",
    "Simulator": "simulation.simulator",
    "Solver": "scenario.solver",
    "Stick": "control.joystick",
    "Study": "studies",
    "SupplyPressure": "scenario.series",
    "Value": "machine.stated",
    "bode": "plots.bode",
    "bundled_machines": "machine.machine",
    "bundled_scenarios": "scenario.scenario_file",
    "cite": "results.citation",
    "export_controller": "export.controller",
    "export_fmu": "export.fmu",
    "export_mjcf": "export.mjcf",
    "export_model": "export.model",
    "export_urdf": "export.urdf",
    "fit": "identification",
    "identify_friction": "identification",
    "linearise": "linear.linearise",
    "load_chart": "analysis.capacity",
    "load_machine": "machine.machine",
    "load_run": "results.run",
    "load_scenario": "scenario.scenario_file",
    "load_study": "studies",
    "mode_map": "analysis.linear",
    "modes": "analysis.linear",
    "open_study": "studies",
    "read_commands": "scenario.series",
    "read_supply": "scenario.series",
    "read_log": "logs",
    "sensitivities": "analysis.sensitivity",
    "simulate": "simulation.running",
    "sweep": "studies",
}
_ROOMS = ("linear", "plots", "rig")

__all__ = sorted([*_HOME, *_ROOMS, "__version__"])


def __getattr__(name: str) -> object:
    """Import the module that holds a public name when the name is first used (PEP 562)."""
    if name == "__version__":
        from importlib.metadata import version

        value: object = version("hydrocrane")
    elif name in _ROOMS:
        value = importlib.import_module(f"hydrocrane.{name}")
    elif name in _HOME:
        value = getattr(importlib.import_module(f"hydrocrane.{_HOME[name]}"), name)
    else:
        raise AttributeError(f"module 'hydrocrane' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
