"""Scenarios: what is to be simulated, built in Python or read from a file."""

from hydrocrane.scenario.events import Burst
from hydrocrane.scenario.payload import PayloadChange
from hydrocrane.scenario.phases import Phase
from hydrocrane.scenario.scenario import Scenario
from hydrocrane.scenario.scenario_file import bundled_scenarios, load_scenario
from hydrocrane.scenario.series import INTERPOLATIONS, Command, SupplyPressure, read_commands, read_supply
from hydrocrane.scenario.solver import FIXED_STEPS, METHODS, Solver

__all__ = [
    "FIXED_STEPS",
    "INTERPOLATIONS",
    "METHODS",
    "Burst",
    "Command",
    "PayloadChange",
    "Phase",
    "Scenario",
    "Solver",
    "SupplyPressure",
    "bundled_scenarios",
    "load_scenario",
    "read_commands",
    "read_supply",
]
