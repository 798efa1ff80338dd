"""What holds of a scenario from a time on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hydrocrane._core_types import Override, StageTable
from hydrocrane.control.controllers import AnyController


@dataclass(frozen=True)
class ScenarioStage:
    """What holds from a time on: the start of a scenario, or one of its phases with all that stays.

    Attributes
    ----------
    driver : str, object or None
        The controller; ``None`` under spool commands.
    sensors : {"ideal", "data-sheet"}
    stick_mode : {"tip", "lever"}
    stick_times : int
        Times at which the sticks are stated.
    machine_overrides : mapping
        Of the scenario and all phases until here, with those that a named controller's period and full speed make.
    """

    driver: AnyController | None
    sensors: str
    stick_mode: str
    stick_times: int
    machine_overrides: Mapping[str, Override]

    @classmethod
    def of(cls, told: StageTable, own: Mapping[int, AnyController]) -> ScenarioStage:
        """From the core's data; `own` are your controllers by their numbers."""
        number = told["own"]
        driver = told["controller"] if number is None else own[number]
        return cls(driver, told["sensors"], told["mode"], told["stick_times"], dict(told["overrides"]))
