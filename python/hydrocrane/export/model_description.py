"""``modelDescription.xml`` of FMI 2.0 and 3.0: one content in two notations."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from hydrocrane.export.description import (
    Description,
    Variable,
    attributes,
    bounds,
    document,
    experiment,
    log_categories,
    number,
    unit_definitions,
)


@dataclass(frozen=True)
class Notation:
    """Names in one version of FMI, of its token, what it is able to, and its lists of outputs, rates and unknowns."""

    version: str
    token: str
    keeps_states: tuple[str, str]
    derivatives: str
    lists: tuple[str, str, str]


NOTATIONS = {
    2: Notation(
        "2.0",
        "guid",
        ("canGetAndSetFMUstate", "canSerializeFMUstate"),
        "providesDirectionalDerivative",
        ("Outputs", "Derivatives", "InitialUnknowns"),
    ),
    3: Notation(
        "3.0",
        "instantiationToken",
        ("canGetAndSetFMUState", "canSerializeFMUState"),
        "providesDirectionalDerivatives",
        ("Output", "ContinuousStateDerivative", "InitialUnknown"),
    ),
}


def model_description(description: Description, fmi: int) -> bytes:
    """The file's text for version 2 or 3 of FMI."""
    notation, second = NOTATIONS[fmi], fmi == 2
    head = {
        "fmiVersion": notation.version,
        "modelName": description.name,
        notation.token: description.token,
        "description": description.title,
        "generationTool": f"hydrocrane {description.version}",
        "variableNamingConvention": "structured",
    }
    root = Element("fmiModelDescription", head | ({"numberOfEventIndicators": "0"} if second else {}))
    abilities = {"modelIdentifier": description.identifier, **dict.fromkeys(notation.keeps_states, "true")}
    if description.exchanges:
        abilities[notation.derivatives] = "true"
        steps = {"completedIntegratorStepNotNeeded": "true"} if second else {}
        SubElement(root, "ModelExchange", abilities | steps)
    SubElement(root, "CoSimulation", abilities, canHandleVariableCommunicationStepSize="true")
    root.extend([unit_definitions(description), log_categories(), experiment(description)])
    rates = description.rates
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(description.variables):
        variables.append(_variable(description, variable, reference, rates.get(reference), second=second))
    structure = SubElement(root, "ModelStructure")
    listed = (description.outputs, list(rates), description.initial_unknowns)
    for name, references in zip(notation.lists, listed, strict=True):
        # The second version lists them by index, the third by reference.
        part = SubElement(structure, name) if second and references else structure
        for reference in references:
            if second:
                SubElement(part, "Unknown", index=str(reference + 1))
            else:
                SubElement(part, name, valueReference=str(reference))
    return document(root)


def _variable(
    description: Description, variable: Variable, reference: int, state: int | None, *, second: bool
) -> Element:
    """A variable with what its value may be, which the second version states in an element of its own."""
    about = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": description.variability(variable),
        "initial": "exact" if variable.causality == "parameter" else None,
    }
    # The second version counts variables from one.
    derivative = None if state is None else str(state + second)
    value = {"unit": variable.unit or None, "start": number(variable.start), "derivative": derivative}
    value |= bounds(variable)
    if not second:
        return Element("Float64", attributes(about | value))
    scalar = Element("ScalarVariable", attributes(about))
    SubElement(scalar, "Real", attributes(value))
    return scalar
