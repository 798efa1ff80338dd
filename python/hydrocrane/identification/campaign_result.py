"""What a campaign of measurement told about friction, and how each stage of the identification went."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from hydrocrane.errors import ResultFileError
from hydrocrane.identification.comparison import FrictionComparison
from hydrocrane.identification.dynamic_result import DynamicFit
from hydrocrane.identification.records import Record
from hydrocrane.identification.static_stage import StaticIdentification
from hydrocrane.machine import Machine
from hydrocrane.signals import SteadyWindows
from hydrocrane.whole_file import write_text

if TYPE_CHECKING:
    from hydrocrane.identification.report import Report


@dataclass(frozen=True)
class Stage:
    """How one stage went.

    Attributes
    ----------
    name : str
    outcome : {"done", "skipped", "failed"}
    message : str
        Why it was skipped or failed.
    """

    name: str
    outcome: str = "done"
    message: str = ""


@dataclass(frozen=True)
class LeftOut:
    """A stretch of a log that was not steady."""

    start: float
    end: float
    reason: str


@dataclass
class Identification:
    """What the logs of a rig tell about the friction of its cylinder; what a failed stage would have given is None.

    Attributes
    ----------
    rig : Machine
    records : list of Record
        The logs, with what each is for.
    stages : list of Stage
        In their order.
    windows : list of SteadyWindows
        Of each steady log that could be used.
    static : StaticIdentification or None
        The static map (119), (122).
    comparison : FrictionComparison or None
        Whether load or supply pressure matter, where logs of several were handed over.
    dynamic : DynamicFit or None
        Bristle stiffness and damping.
    warnings : list of str
        What a reader must know before trusting the numbers.
    """

    rig: Machine
    records: list[Record] = field(default_factory=list)
    stages: list[Stage] = field(default_factory=list)
    windows: list[SteadyWindows] = field(default_factory=list)
    static: StaticIdentification | None = None
    comparison: FrictionComparison | None = None
    dynamic: DynamicFit | None = None
    warnings: list[str] = field(default_factory=list)

    @property
    def cylinder(self) -> str:
        """Name of the rig's cylinder."""
        return self.rig.cylinder_names[0]

    @property
    def failures(self) -> tuple[Stage, ...]:
        """The stages that did not end."""
        return tuple(stage for stage in self.stages if stage.outcome == "failed")

    def toml(self, cylinder: str | None = None, *, date: str = "", file_name: str = "friction.toml") -> str:
        """The block ``[friction.<cylinder>]`` for a machine file, with comments on its origin."""
        from hydrocrane.identification.friction_file import friction_file

        return friction_file(self, cylinder or self.cylinder, date=date, file_name=file_name)

    def write(self, path: str | PathLike[str], cylinder: str | None = None) -> Path:
        """Write the block to a file that a machine file can include."""
        target = Path(path)
        if target.suffix != ".toml":
            raise ResultFileError(f"a part of a machine file ends in .toml, unlike `{target.name}`")
        return write_text(target, self.toml(cylinder, file_name=target.name))

    def report(self) -> Report:
        """Everything in one page."""
        from hydrocrane.identification.campaign_report import campaign_report

        return campaign_report(self)

    def summary(self) -> str:
        """Stages, parameters with their 95 % intervals, and warnings as plain text."""
        from hydrocrane.identification.campaign_report import summary

        return summary(self)
