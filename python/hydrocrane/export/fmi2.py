"""``modelDescription.xml`` of FMI 2.0."""

from __future__ import annotations

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


def model_description(description: Description) -> bytes:
    """The file's text."""
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=description.name,
        guid=description.token,
        description=description.title,
        generationTool=f"hydrocrane {description.version}",
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    abilities = {"modelIdentifier": description.identifier}
    abilities |= dict.fromkeys(("canGetAndSetFMUstate", "canSerializeFMUstate"), "true")
    if description.exchanges:
        abilities["providesDirectionalDerivative"] = "true"
        SubElement(root, "ModelExchange", abilities, completedIntegratorStepNotNeeded="true")
    SubElement(root, "CoSimulation", abilities, canHandleVariableCommunicationStepSize="true")
    root.extend([unit_definitions(description), log_categories(), experiment(description)])
    rates = description.rates
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(description.variables):
        variables.append(_scalar(description, variable, reference, rates.get(reference)))
    _structure(root, description)
    return document(root)


def _scalar(description: Description, variable: Variable, reference: int, state: int | None) -> Element:
    scalar = Element(
        "ScalarVariable",
        name=variable.name,
        valueReference=str(reference),
        description=variable.description,
        causality=variable.causality,
        variability=description.variability(variable),
    )
    if variable.causality == "parameter":
        scalar.set("initial", "exact")
    # Indices of variables begin with one.
    derivative = None if state is None else str(state + 1)
    given = {"unit": variable.unit or None, "start": number(variable.start), "derivative": derivative}
    SubElement(scalar, "Real", attributes(given | bounds(variable)))
    return scalar


def _structure(root: Element, description: Description) -> None:
    structure = SubElement(root, "ModelStructure")
    parts = {
        "Outputs": description.outputs,
        "Derivatives": list(description.rates),
        "InitialUnknowns": description.initial_unknowns,
    }
    for name, references in parts.items():
        if references:
            part = SubElement(structure, name)
            for reference in references:
                SubElement(part, "Unknown", index=str(reference + 1))
