"""What a scenario states against time beside what drives the crane: for programs that step the crane by themselves."""

from __future__ import annotations

from collections.abc import Mapping
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
# What ends when an operator takes over, beside sticks and spool commands.
OPERATED = {field: FIELDS[field] for field in ("phases", "payload_changes")} | {"goals": "goals of the tip"}


def against_time(plan: Scenario, fields: Mapping[str, str] = FIELDS) -> tuple[str, str] | None:
    """The first of `fields` that the scenario has, and what it states; ``None`` if it has none of them."""
    return next(((field, what) for field, what in fields.items() if getattr(plan, field)), None)
