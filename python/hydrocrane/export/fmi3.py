"""``modelDescription.xml`` of FMI 3.0."""

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
        fmiVersion="3.0",
        modelName=description.name,
        instantiationToken=description.token,
        description=description.title,
        generationTool=f"hydrocrane {description.version}",
        variableNamingConvention="structured",
    )
    abilities = {"modelIdentifier": description.identifier}
    abilities |= dict.fromkeys(("canGetAndSetFMUState", "canSerializeFMUState"), "true")
    if description.exchanges:
        abilities["providesDirectionalDerivatives"] = "true"
        SubElement(root, "ModelExchange", abilities)
    SubElement(root, "CoSimulation", abilities, canHandleVariableCommunicationStepSize="true")
    root.extend([unit_definitions(description), log_categories(), experiment(description)])
    rates = description.rates
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(description.variables):
        variables.append(_float(description, variable, reference, rates.get(reference)))
    structure = SubElement(root, "ModelStructure")
    parts = {
        "Output": description.outputs,
        "ContinuousStateDerivative": list(rates),
        "InitialUnknown": description.initial_unknowns,
    }
    for name, references in parts.items():
        for reference in references:
            SubElement(structure, name, valueReference=str(reference))
    return document(root)


def _float(description: Description, variable: Variable, reference: int, state: int | None) -> Element:
    given = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": description.variability(variable),
        "initial": "exact" if variable.causality == "parameter" else None,
        "unit": variable.unit or None,
        "start": number(variable.start),
        "derivative": None if state is None else str(state),
    }
    return Element("Float64", attributes(given | bounds(variable)))
