"""Reproducible writer of .ssp files: system structure (SSD), parameters (SSV) and FMUs."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from pathlib import Path

from cardsflow_fmu.cosim.signals.units import BASES, Unit
from cardsflow_fmu.fmu.description import xml_bytes
from cardsflow_fmu.utils.archive import read_contents, write_archive
from cardsflow_fmu.version import __version__

from .system import Component, Connection, Parameter, System

FMU_TYPE = "application/x-fmu-sharedlibrary"
OSP_ANNOTATION = "com.opensimulationplatform"
_TOOL = f"CARDSFlow {__version__}"
_NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
}


def write_ssp(
    path: Path,
    system: System,
    fmus: Mapping[str, Path],
    variants: Mapping[str, System] | None = None,
) -> Path:
    """Pack a system of FMUs."""
    files = {source: read_contents(file) for source, file in fmus.items()}
    for structure, one in {"SystemStructure": system, **(variants or {})}.items():
        files[f"{structure}.ssd"] = _structure(one)
        for component in one.components:
            if component.parameters:
                files[_parameter_file(component)] = _parameter_set(component)
    write_archive(path, files)
    return path


def _parameter_file(component: Component) -> str:
    """Return the path of a parameter set, unique for each FMU of the variants."""
    return f"{component.source.removesuffix('.fmu')}.ssv"


def _root(prefix: str, tag: str, name: str, *others: str) -> ET.Element:
    spaces = {f"xmlns:{p}": _NAMESPACES[p] for p in (prefix, "ssc", *others)}
    return ET.Element(
        f"{prefix}:{tag}", {**spaces, "version": "1.0", "name": name, "generationTool": _TOOL}
    )


def _structure(system: System) -> bytes:
    root = _root("ssd", "SystemStructureDescription", system.name, "osp")
    top = ET.SubElement(root, "ssd:System", name=system.name)
    elements = ET.SubElement(top, "ssd:Elements")
    elements.extend(_component(component) for component in system.components)
    if system.connections:
        connections = ET.SubElement(top, "ssd:Connections")
        connections.extend(_connection(connection) for connection in system.connections)
    connectors = (connector for c in system.components for connector in c.connectors)
    _add_units(root, "ssd", (connector.unit for connector in connectors))
    _add_experiment(root, system)
    return xml_bytes(root)


def _component(component: Component) -> ET.Element:
    element = ET.Element(
        "ssd:Component", name=component.name, type=FMU_TYPE, source=component.source
    )
    if component.connectors:
        connectors = ET.SubElement(element, "ssd:Connectors")
        for connector in component.connectors:
            one = ET.SubElement(
                connectors, "ssd:Connector", name=connector.name, kind=connector.kind
            )
            kind = ET.SubElement(one, f"ssc:{connector.type}")
            if connector.unit is not None:
                kind.set("unit", connector.unit.name)
    if component.parameters:
        bindings = ET.SubElement(element, "ssd:ParameterBindings")
        ET.SubElement(bindings, "ssd:ParameterBinding", source=_parameter_file(component))
    return element


def _connection(connection: Connection) -> ET.Element:
    element = ET.Element(
        "ssd:Connection",
        startElement=connection.source[0],
        startConnector=connection.source[1],
        endElement=connection.target[0],
        endConnector=connection.target[1],
    )
    change = connection.change
    if not change.is_identity:
        # explicit, because few tools convert units
        element.set("suppressUnitConversion", "true")
        ET.SubElement(
            element,
            "ssc:LinearTransformation",
            factor=repr(change.factor),
            offset=repr(change.offset),
        )
    return element


def _add_units(root: ET.Element, prefix: str, units: Iterable[Unit | None]) -> None:
    used = {unit.name: unit for unit in units if unit is not None}
    if not used:
        return
    definitions = ET.SubElement(root, f"{prefix}:Units")
    for name, unit in sorted(used.items()):
        element = ET.SubElement(definitions, "ssc:Unit", name=name)
        exponents = zip(BASES, unit.exponents or (), strict=False)
        base = {letter: str(exponent) for letter, exponent in exponents if exponent}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        if unit.offset != 0.0:
            base["offset"] = repr(unit.offset)
        ET.SubElement(element, "ssc:BaseUnit", base)


def _add_experiment(root: ET.Element, system: System) -> None:
    """Add start time, stop time, and the step as an annotation for libcosim."""
    experiment = ET.SubElement(root, "ssd:DefaultExperiment", startTime="0.0")
    if system.stop_time is not None:
        experiment.set("stopTime", repr(system.stop_time))
    if system.step is not None:
        annotations = ET.SubElement(experiment, "ssd:Annotations")
        annotation = ET.SubElement(annotations, "ssc:Annotation", type=OSP_ANNOTATION)
        algorithm = ET.SubElement(annotation, "osp:Algorithm")
        ET.SubElement(algorithm, "osp:FixedStepAlgorithm", baseStepSize=repr(system.step))


def _parameter_set(component: Component) -> bytes:
    root = _root("ssv", "ParameterSet", component.name)
    parameters = ET.SubElement(root, "ssv:Parameters")
    parameters.extend(_parameter(parameter) for parameter in component.parameters)
    _add_units(root, "ssv", (parameter.unit for parameter in component.parameters))
    return xml_bytes(root)


def _parameter(parameter: Parameter) -> ET.Element:
    element = ET.Element("ssv:Parameter", name=parameter.name)
    value = ET.SubElement(element, "ssv:Real", value=repr(float(parameter.value)))
    if parameter.unit is not None:
        value.set("unit", parameter.unit.name)
    return element
