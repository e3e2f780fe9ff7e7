"""Writer of terminalsAndIcons.xml, for FMI 3.0: signals of each joint, muscle and task frame."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence

from cardsflow_fmu.cosim.signals.variables import Variable

from .description import xml_bytes

_GROUPS = {
    "joints": ("Signals of joints", ("q", "qd", "q_d", "qd_d", "qdd_d", "tau", "torque")),
    "muscles": ("Signals of muscles", ("f", "u", "l", "tension")),
    "tasks": ("Signals of task frames", ("y", "y_d", "yd_d", "ydd_d", "w")),
}
_SIZE = "100"


def terminals_and_icons(variables: Sequence[Variable]) -> bytes:
    """Return the contents of terminalsAndIcons.xml.

    The matching rule `bus` connects members with equal names: the terminal `joint_1` of a plant has
    the members `q` and `qd`, and so does the terminal `joint_1` of a controller. With arrays, one
    terminal contains all joints or all muscles.
    """
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    graphics = ET.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": f"-{_SIZE}", "y1": f"-{_SIZE}", "x2": _SIZE, "y2": _SIZE}
    ET.SubElement(graphics, "CoordinateSystem", corners, suggestedScalingFactorTo_mm="0.1")
    ET.SubElement(graphics, "Icon", corners)
    terminals = ET.Element("Terminals")
    for name, (description, prefixes) in _GROUPS.items():
        terminal = _group(name, description, prefixes, variables)
        if len(terminal):
            terminals.append(terminal)
    if len(terminals):
        root.append(terminals)
    return xml_bytes(root)


def _group(
    name: str, description: str, prefixes: Sequence[str], variables: Sequence[Variable]
) -> ET.Element:
    """Return a terminal with a member per array and a terminal per joint, muscle or frame."""
    terminal = _terminal(name, description)
    inner: dict[str, ET.Element] = {}
    for variable in variables:
        prefix, _, item = variable.name.partition(".")
        if prefix not in prefixes or variable.port.causality == "parameter":
            continue
        if variable.is_array:
            _add_member(terminal, variable, prefix)
            continue
        item, _, axis = item.partition(".")
        if item not in inner:
            inner[item] = _terminal(item, f"Signals of {item}")
        _add_member(inner[item], variable, f"{prefix}.{axis}" if axis else prefix)
    terminal.extend(inner.values())
    return terminal


def _terminal(name: str, description: str) -> ET.Element:
    return ET.Element("Terminal", name=name, matchingRule="bus", description=description)


def _add_member(terminal: ET.Element, variable: Variable, member: str) -> None:
    ET.SubElement(
        terminal,
        "TerminalMemberVariable",
        variableName=variable.name,
        memberName=member,
        variableKind="signal",
    )
