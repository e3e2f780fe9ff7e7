"""Document of an .osim file: its version, its sets of objects, and references.

Only version 4 is supported; in older files bodies contain the joints. OpenSim writes the tag
`HuntCrossleyForce::ContactParametersSet`, which is not valid XML and is repaired before parsing.
"""

from __future__ import annotations

import re
from pathlib import Path

from lxml import etree

from ....errors import InputError
from ....finding import Subject
from ...reading.xml import TRUE, Node, Notes, parse

OLDEST = 40000
OFFSET_FRAME = "PhysicalOffsetFrame"
SETS = {
    "BodySet": "Body",
    "JointSet": r"\w+Joint",
    "ConstraintSet": r"\w+Constraint",
    "ForceSet": r"\w+(Force|Actuator|Muscle\w*|Ligament\w*|Spring)",
    "MarkerSet": "Marker",
    "ControllerSet": r"\w*Controller",
    "ContactGeometrySet": r"Contact\w+",
    "ProbeSet": r"\w+Probe",
    "ComponentSet": OFFSET_FRAME,
}
"""Sets of a model, and the tags of the objects that they contain."""
_COLONS = re.compile(rb"<(/?\w+)::(\w+)")


def read_document(file: Path, notes: Notes) -> Node:
    """Return the `<Model>` element of a file.

    Raises:
        InputError: The file is not readable XML, not from OpenSim, or too old.
    """
    root = parse(
        file, Subject("robot", file.stem), notes, mend=lambda data: _COLONS.sub(rb"<\1__\2", data)
    )
    if root.tag != "OpenSimDocument":
        raise InputError(f"<{root.tag}> is not <OpenSimDocument>", file=file, line=root.line)
    version = root.attribute("Version", "0")
    if not version.isascii() or not version.isdigit() or int(version[:9]) < OLDEST:
        problem = (
            f"has the OpenSim format {version[:20]!r}, which is not supported; open it in OpenSim "
            f"4 and save it there, which writes format {OLDEST} or newer"
        )
        raise InputError(problem, file=file, line=root.line)
    models = root.all("Model", "ModelComponentSet")
    if len(models) != 1 or models[0].tag != "Model":
        problem = f"contains {len(root.all('Model'))} models, not one"
        raise InputError(problem, file=file, line=root.line)
    model = models[0]
    _sort_components(model)
    return model.with_subject(Subject("robot", model.attribute("name", "") or file.stem))


def _sort_components(model: Node) -> None:
    """Move components of a model into the set of their kind, where OpenSim accepts them as well.

    Components of other kinds stay in place; the list of unread elements contains them.
    """
    nodes = [child for group in model.all("components") for child in group.all()]
    nodes += [child for child in objects(model, "ComponentSet") if child.tag != OFFSET_FRAME]
    for node in nodes:
        kind = next((name for name, tags in SETS.items() if re.fullmatch(tags, node.tag)), None)
        if kind is None and node.element.find(".//GeometryPath") is not None:
            kind = "ForceSet"
        if kind is not None:
            _objects_element(model, kind).append(node.element)


def _objects_element(model: Node, kind: str) -> etree._Element:
    """Return the `<objects>` of a set; it is created if missing."""
    element = model.element.find(f"{kind}/objects")
    if element is None:
        group = model.element.find(kind)
        group = etree.SubElement(model.element, kind) if group is None else group
        element = etree.SubElement(group, "objects")
    return element


def objects(parent: Node, tag: str) -> list[Node]:
    """Return the objects of a set, such as `<BodySet><objects>`."""
    return [
        child
        for group in parent.all(tag)
        for inner_element in group.all("objects")
        for child in inner_element.all()
    ]


def is_true(node: Node, tag: str, default: bool) -> bool:
    """Return the value of a boolean child element."""
    child = node.optional(tag)
    return default if child is None else child.text.lower() in TRUE


def text(node: Node, tag: str, default: str = "") -> str:
    """Return the text of a child element, or the default if it does not exist."""
    child = node.optional(tag)
    return default if child is None else child.text


def inner_element(node: Node, tag: str) -> Node | None:
    """Return the first element inside a child, such as the function in `<x_location>`."""
    child = node.optional(tag)
    children = [] if child is None else child.all()
    return children[0] if children else None


def last_part(path: str) -> str:
    """Return the last part of a path."""
    return path.rpartition("/")[2]
