"""Content of a ``modelDescription.xml``, independent of the version of FMI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

from hydrocrane import _core

# Categories of the library's messages.
CATEGORIES = {
    "logStatusWarning": "what makes the simulation doubtful",
    "logStatusDiscard": "steps and states that are not possible for the machine",
    "logStatusError": "wrong calls and wrong values",
    "logStatusFatal": "defects",
}


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU; its value reference is its index in the list."""

    name: str
    kind: str
    # Number of the state, cylinder or joint.
    number: int
    # independent, input, fixed, tunable, output or local
    use: str
    unit: str
    description: str
    start: float | None
    range: tuple[float, float] | None
    nominal: float | None

    @property
    def causality(self) -> str:
        return "parameter" if self.use in ("fixed", "tunable") else self.use


@dataclass(frozen=True)
class Description:
    """Data that both versions of FMI state in different notation."""

    name: str
    title: str
    token: str
    version: str
    identifier: str
    variables: tuple[Variable, ...]
    # Whether a tool can integrate the model (model exchange).
    exchanges: bool
    # Time between the samples of a controller, s.
    period: float | None
    # Suggested size of a step, and the end of a first simulation, s.
    step: float
    stop: float

    def variability(self, variable: Variable) -> str:
        """The variability of FMI; outputs of a controller are discrete."""
        if variable.use in ("fixed", "tunable"):
            return variable.use
        sampled = self.period is not None and variable.use == "output"
        return "discrete" if sampled or variable.kind == "reading" and variable.use == "output" else "continuous"

    @property
    def outputs(self) -> list[int]:
        """Value references."""
        return [i for i, variable in enumerate(self.variables) if variable.use == "output"]

    def state(self, number: int) -> int:
        """Value reference of a state."""
        return next(i for i, v in enumerate(self.variables) if v.kind == "state" and v.number == number)

    @property
    def rates(self) -> dict[int, int]:
        """Value reference of the derivative of each state to that of the state; empty without model exchange."""
        found = enumerate(self.variables) if self.exchanges else ()
        return {i: self.state(v.number) for i, v in found if v.kind == "rate"}

    @property
    def initial_unknowns(self) -> list[int]:
        """Value references of the initial unknowns."""
        rates = self.rates
        return sorted({*self.outputs, *rates, *rates.values()})

    @property
    def units(self) -> list[str]:
        return sorted({variable.unit for variable in self.variables} - {""})


def number(value: float | None) -> str | None:
    """A number with all its digits; None if it is not finite."""
    return None if value is None or value in (float("inf"), float("-inf")) else repr(float(value))


def attributes(given: Mapping[str, str | None]) -> dict[str, str]:
    """The attributes with a value."""
    return {name: value for name, value in given.items() if value is not None}


def bounds(variable: Variable) -> dict[str, str | None]:
    """Lowest, highest and nominal value as attributes."""
    low, high = variable.range or (None, None)
    return {"min": number(low), "max": number(high), "nominal": number(variable.nominal)}


def unit_definitions(description: Description) -> ElementTree.Element:
    """All units with their exponents of the SI base units, if these are integers."""
    top = ElementTree.Element("UnitDefinitions")
    for unit in description.units:
        entry = ElementTree.SubElement(top, "Unit", name=unit)
        found = _core.exponents_of_unit(unit)
        if found is not None and all(power == int(power) for power in found):
            powers = zip(("m", "kg", "s", "K", "A", "rad"), found, strict=True)
            ElementTree.SubElement(entry, "BaseUnit", {base: str(int(power)) for base, power in powers if power})
    return top


def log_categories() -> ElementTree.Element:
    top = ElementTree.Element("LogCategories")
    for name, text in CATEGORIES.items():
        ElementTree.SubElement(top, "Category", name=name, description=text)
    return top


def experiment(description: Description) -> ElementTree.Element:
    given = {"startTime": 0.0, "stopTime": description.stop, "stepSize": description.step}
    return ElementTree.Element("DefaultExperiment", {name: repr(value) for name, value in given.items()})


def document(root: ElementTree.Element) -> bytes:
    """The text of a file."""
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"
