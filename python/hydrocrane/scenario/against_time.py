"""What a scenario states against time beside what drives the crane: for programs that step the crane by themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hydrocrane.scenario.scenario import Scenario

FIELDS = {
    "supply": "a measured supply pressure",
    "phases": "phases",
    "payload_changes": "loads that come and go",
    "bursts": "hoses that burst",
    "sensor_faults": "sensors that fail",
}


def against_time(plan: Scenario) -> tuple[str, str] | None:
    """The first such field, and what it states; ``None`` if machine and load stay as they are."""
    return next(((field, what) for field, what in FIELDS.items() if getattr(plan, field)), None)
