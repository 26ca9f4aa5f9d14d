"""modelDescription.xml of FMI 2.0, for co-simulation."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fmu_export.options import Experiment
from fmu_export.variables import Variable
from gearblocks.language.units import base_exponents, parse_unit

if TYPE_CHECKING:
    from lxml.etree import _Element

DISPLAY_UNITS = {"rad/s": "rpm", "rad": "deg"}
"""SI unit: display unit and its factor (shown value = factor * value)."""

LOG_CATEGORIES = {
    "logStatusError": "what was refused or failed, where and when",
    "logStatusWarning": "what was taken otherwise than asked",
    "logStatusDiscard": "steps that ended on their way",
    "logEvents": "how many events were located in a step",
    "logAll": "all messages",
}

_STRUCTURED = re.compile(
    r"""(?x) ^ (?: [_a-zA-Z][_a-zA-Z0-9]* | '(?: [^'\\] | \\. )+' ) (?: \[\d+(?:,\d+)*\] )?
        (?: \. (?: [_a-zA-Z][_a-zA-Z0-9]* | '(?: [^'\\] | \\. )+' ) (?: \[\d+(?:,\d+)*\] )? )* $"""
)


@dataclass(frozen=True, slots=True)
class Header:
    """What the description says of the FMU as a whole."""

    name: str
    identifier: str
    token: str
    words: str
    tool: str
    sources: Sequence[str]
    experiment: Experiment


def describe(header: Header, variables: Sequence[Variable]) -> bytes:
    """The XML file. The same arguments give the same bytes."""
    from lxml import etree

    structured = all(structured_name(v.name) for v in variables)
    root = etree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": header.name,
            "guid": header.token,
            "description": header.words,
            "generationTool": header.tool,
            "variableNamingConvention": "structured" if structured else "flat",
            "numberOfEventIndicators": "0",
        },
    )
    _co_simulation(root, header)
    _units(root, variables)
    log = etree.SubElement(root, "LogCategories")
    for name, words in LOG_CATEGORIES.items():
        etree.SubElement(log, "Category", {"name": name, "description": words})
    _experiment(root, header.experiment)
    listed = etree.SubElement(root, "ModelVariables")
    for variable in variables:
        _variable(listed, variable)
    _structure(root, variables)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def structured_name(name: str) -> bool:
    """Whether a variable's name is one of the naming convention "structured"."""
    return name.isascii() and _STRUCTURED.match(name) is not None


def _co_simulation(root: _Element, header: Header) -> None:
    from lxml import etree

    capabilities = {
        "modelIdentifier": header.identifier,
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false",
        "maxOutputDerivativeOrder": "0",
        "canRunAsynchronuously": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "false",
    }
    element = etree.SubElement(root, "CoSimulation", capabilities)
    files = etree.SubElement(element, "SourceFiles")
    for name in sorted(header.sources):
        if name.endswith(".c"):
            etree.SubElement(files, "File", {"name": name})


def _units(root: _Element, variables: Sequence[Variable]) -> None:
    from lxml import etree

    units = sorted({v.unit for v in variables if unit_name(v.unit)})
    if not units:
        return
    definitions = etree.SubElement(root, "UnitDefinitions")
    for unit in units:
        element = etree.SubElement(definitions, "Unit", {"name": unit_name(unit)})
        exponents = base_exponents(unit).items()
        etree.SubElement(element, "BaseUnit", {base: str(power) for base, power in exponents})
        shown = dict.fromkeys(name for v in variables if v.unit == unit and (name := display_unit(v)))
        for name in shown:
            factor = repr(1.0 / parse_unit(name).factor)
            etree.SubElement(element, "DisplayUnit", {"name": unit_name(name), "factor": factor})


def display_unit(variable: Variable) -> str:
    """The unit in which a variable is shown: that in which its values are given, else one for its unit; "" for none."""
    return variable.display or DISPLAY_UNITS.get(variable.unit, "")


def unit_name(unit: str) -> str:
    """The unit's name in the description, factors joined by dots ("N.m/rad"); "" for the number one."""
    text = ".".join(unit.split())
    return "" if text == "1" else text


def _experiment(root: _Element, experiment: Experiment) -> None:
    from lxml import etree

    attributes = {"startTime": "0.0", "stopTime": repr(experiment.stop), "tolerance": repr(experiment.tolerance)}
    if experiment.step is not None:
        attributes["stepSize"] = repr(experiment.step)
    etree.SubElement(root, "DefaultExperiment", attributes)


_ROLES = {
    "parameter": ("parameter", "tunable", "exact"),
    "start": ("parameter", "fixed", "exact"),
    "solver": ("parameter", "fixed", "exact"),
    "input": ("input", "continuous", None),
    "output": ("output", "continuous", "calculated"),
}


def _variable(parent: _Element, variable: Variable) -> None:
    from lxml import etree

    causality, variability, initial = _ROLES[variable.kind]
    if variable.kind == "solver" and variable.start is None:
        causality, variability, initial = "independent", "continuous", None
    if variable.kind == "parameter" and not variable.tunable:
        variability = "fixed"
    attributes = {"name": variable.name, "valueReference": str(variable.reference)}
    if variable.words:
        attributes["description"] = variable.words
    attributes |= {"causality": causality, "variability": variability}
    if initial is not None:
        attributes["initial"] = initial
    element = etree.SubElement(parent, "ScalarVariable", attributes)
    real = {}
    if unit_name(variable.unit):
        real["unit"] = unit_name(variable.unit)
    if display_unit(variable):
        real["displayUnit"] = unit_name(display_unit(variable))
    for name, value in (*closed_bounds(variable).items(), ("start", variable.start)):
        if value is not None and math.isfinite(value):
            real[name] = repr(float(value))
    etree.SubElement(element, "Real", real)


def closed_bounds(variable: Variable) -> dict[str, float | None]:
    """`min` and `max` of the description, which belong to the values: of an open bound the next number inside, above 0 the
    least that has all its digits."""
    low, high = variable.lower, variable.upper
    if low is not None and variable.open_lower:
        low = max(math.nextafter(low, math.inf), sys.float_info.min) if low >= 0 else math.nextafter(low, math.inf)
    if high is not None and variable.open_upper:
        high = (
            min(math.nextafter(high, -math.inf), -sys.float_info.min) if high <= 0 else math.nextafter(high, -math.inf)
        )
    return {"min": low, "max": high}


def _structure(root: _Element, variables: Sequence[Variable]) -> None:
    """Every output, without `dependencies`: it may depend on all inputs, parameters and states."""
    from lxml import etree

    structure = etree.SubElement(root, "ModelStructure")
    outputs = [index for index, v in enumerate(variables, start=1) if v.kind == "output"]
    for group in ("Outputs", "InitialUnknowns"):
        if outputs:
            listed = etree.SubElement(structure, group)
            for index in outputs:
                etree.SubElement(listed, "Unknown", {"index": str(index)})
